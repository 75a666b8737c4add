//! Exported WGSL, SPIR-V and HLSL, drawn with wgpu.

use super::cases::{Difference, cases, exported, file};
use relievo::export::{ExportedFile, Output, Target};
use relievo::prepare::PreparedScene;
use relievo_bitwise::{Device, Module, wgpu};
use relievo_tests::{every_adapter, lacking};
use serde_json::Value;
use std::process::Command;

/// The vertex and the fragment shader of an object's files.
pub type Load<'a> = &'a dyn Fn(&Device, &[ExportedFile]) -> [wgpu::ShaderModule; 2];

/// WGSL, unchanged.
pub fn wgsl(device: &Device, files: &[ExportedFile]) -> [wgpu::ShaderModule; 2] {
    ["vertex.wgsl", "fragment.wgsl"].map(|name| {
        let text = String::from_utf8(file(files, name).to_vec()).unwrap();
        parsed(device, text)
    })
}

/// A shader in WGSL.
pub fn parsed(device: &Device, text: String) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(text.into());
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: None,
        source,
    };
    device.wgpu().create_shader_module(descriptor)
}

/// SPIR-V, unchanged.
fn spirv(device: &Device, files: &[ExportedFile]) -> [wgpu::ShaderModule; 2] {
    let all = ["vertex.spv", "fragment.spv"].map(|name| file(files, name));
    // SAFETY: spirv-val accepts them (tools.rs), and they are our renderer's
    // except for their outputs.
    let module = unsafe { Module::untouched(&all) }.unwrap();
    ["vs_main", "fs_main"].map(|name| module.load(device, name).unwrap())
}

/// HLSL, through another compiler, as SPIR-V.
fn hlsl(device: &Device, files: &[ExportedFile]) -> [wgpu::ShaderModule; 2] {
    let folder = tempfile::tempdir().unwrap();
    [
        ("vert", "vertex.hlsl", "vs_main"),
        ("frag", "fragment.hlsl", "fs_main"),
    ]
    .map(|(stage, name, entry_point)| {
        let source = folder.path().join(name);
        std::fs::write(&source, file(files, name)).unwrap();
        let compiled = folder.path().join(stage);
        let run = Command::new("glslangValidator")
            .args(["-D", "-V", "-S", stage, "-e", entry_point, "-o"])
            .args([&compiled, &source])
            .output()
            .unwrap();
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stdout)
        );
        let bytes = std::fs::read(&compiled).unwrap();
        // Through naga again: unchanged, lavapipe draws this compiler's SPIR-V
        // of the accurate tier in other colours, but not naga's.
        let module = Module::portable(&[&bytes]).unwrap();
        module.load(device, entry_point).unwrap()
    })
}

/// Returns the size of the texture of the shape map, if `layout.json` says that it is one.
pub fn map_size(files: &[ExportedFile]) -> Option<[u32; 2]> {
    let layout: Value = serde_json::from_slice(file(files, "layout.json")).unwrap();
    let entry = &layout["bind_groups"][0]["entries"][3];
    let is_texture = entry["type"] == "texture";
    let side = |name: &str| entry["texture"][name].as_u64().unwrap() as u32;
    is_texture.then(|| {
        assert_eq!(entry["texture"]["format"], "r32uint");
        [side("width"), side("height")]
    })
}

/// Draws `objects` and reads the target: four words per pixel, rows from the
/// top. If a prepass is given, this entry point writes depths first, and only fragments with the same
/// ones are drawn.
pub fn draw(
    device: &Device,
    scene: &PreparedScene,
    objects: &[Vec<ExportedFile>],
    output: Output,
    load: Load<'_>,
    prepass: Option<&str>,
) -> Vec<[u32; 4]> {
    let (gpu, queue) = (device.wgpu(), device.queue());
    let [width, height] = scene.size;
    let (format, clear) = match output {
        Output::Color | Output::Hit => {
            let [r, g, b] = scene.background.map(f64::from);
            (
                wgpu::TextureFormat::Rgba32Float,
                wgpu::Color { r, g, b, a: 1.0 },
            )
        }
        Output::Words => (wgpu::TextureFormat::Rgba32Uint, wgpu::Color::TRANSPARENT),
    };
    let texture_of_map = objects.iter().find_map(|files| map_size(files));
    let entries: Vec<_> = (0..4)
        .map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: if binding == 3 {
                wgpu::ShaderStages::FRAGMENT
            } else {
                wgpu::ShaderStages::VERTEX_FRAGMENT
            },
            ty: match texture_of_map {
                Some(_) if binding == 3 => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                _ => wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            },
            count: None,
        })
        .collect();
    let layout = gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    });
    let pipeline_layout = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let texture_of = |[width, height]: [u32; 2], format, usage| {
        gpu.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let texture = |format, usage| {
        let usage = usage | wgpu::TextureUsages::RENDER_ATTACHMENT;
        texture_of([width, height], format, usage)
    };
    let texture_with = |bytes: &[u8], [width, height]: [u32; 2]| {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = texture_of([width, height], wgpu::TextureFormat::R32Uint, usage);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * width),
            rows_per_image: None,
        };
        queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    };
    let buffer = |bytes: &[u8], usage| {
        let buffer = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, bytes);
        buffer
    };
    let drawn: Vec<_> = objects
        .iter()
        .map(|files| {
            let [vertex, fragment] = load(device, files);
            let pipeline = |entry_point, compare, write_mask| {
                gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: None,
                    layout: Some(&pipeline_layout),
                    vertex: wgpu::VertexState {
                        module: &vertex,
                        entry_point: Some("vs_main"),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        buffers: &[],
                    },
                    primitive: wgpu::PrimitiveState::default(),
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: wgpu::TextureFormat::Depth32Float,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(compare),
                        stencil: wgpu::StencilState::default(),
                        bias: wgpu::DepthBiasState::default(),
                    }),
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &fragment,
                        entry_point: Some(entry_point),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        targets: &[Some(wgpu::ColorTargetState {
                            format,
                            blend: None,
                            write_mask,
                        })],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            };
            let (greater, equal) = (wgpu::CompareFunction::Greater, wgpu::CompareFunction::Equal);
            let all = wgpu::ColorWrites::ALL;
            let pipelines = match prepass {
                Some(name) => vec![
                    pipeline(name, greater, wgpu::ColorWrites::empty()),
                    pipeline("fs_main", equal, all),
                ],
                None => vec![pipeline("fs_main", greater, all)],
            };
            let buffers = ["frame.bin", "object.bin", "facets.bin", "map.bin"]
                .map(|name| buffer(file(files, name), wgpu::BufferUsages::STORAGE));
            let map = map_size(files).map(|size| texture_with(file(files, "map.bin"), size));
            let entries: Vec<_> = (0..)
                .zip(&buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: match &map {
                        Some(view) if binding == 3 => wgpu::BindingResource::TextureView(view),
                        _ => buffer.as_entire_binding(),
                    },
                })
                .collect();
            let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &layout,
                entries: &entries,
            });
            let count = buffer(file(files, "draw.bin"), wgpu::BufferUsages::INDIRECT);
            (pipelines, group, count)
        })
        .collect();

    let color = texture(format, wgpu::TextureUsages::COPY_SRC);
    let depth = texture(
        wgpu::TextureFormat::Depth32Float,
        wgpu::TextureUsages::empty(),
    );
    let stride = (16 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let rows = gpu.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(stride * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color.create_view(&wgpu::TextureViewDescriptor::default()),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(clear),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth.create_view(&wgpu::TextureViewDescriptor::default()),
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        for index in 0..=usize::from(prepass.is_some()) {
            for (pipelines, group, count) in &drawn {
                pass.set_pipeline(&pipelines[index]);
                pass.set_bind_group(0, group, &[]);
                pass.draw_indirect(count, 0);
            }
        }
    }
    encoder.copy_texture_to_buffer(
        color.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &rows,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(stride),
                rows_per_image: None,
            },
        },
        color.size(),
    );
    queue.submit([encoder.finish()]);
    let row =
        |row: &[u8]| bytemuck::pod_collect_to_vec::<u8, [u32; 4]>(&row[..16 * width as usize]);
    device
        .read(&rows, rows.size(), |bytes| {
            bytes.chunks(stride as usize).flat_map(row).collect()
        })
        .unwrap()
}

/// Every shader, and several objects with one depth buffer, match the CPU's
/// picture.
#[test]
fn gpu_exports_draw_our_picture() {
    let adapter = every_adapter().swap_remove(0);
    let device = adapter.open().unwrap();
    let has_glslang = Command::new("glslangValidator").arg("-v").output().is_ok();
    if !has_glslang {
        lacking("glslangValidator");
    }
    for case in cases() {
        let picture = |target, output, load| {
            let objects = exported(&case.scene, target, output);
            draw(&device, &case.scene, &objects, output, load, None)
        };
        let words = picture(Target::Wgsl, Output::Words, &wgsl);
        let mut forms: Vec<(Target, Load<'_>)> = vec![(Target::Wgsl, &wgsl)];
        if device.takes_spirv() {
            forms.push((Target::Spirv, &spirv));
            if has_glslang {
                forms.push((Target::Hlsl, &hlsl));
            }
        }
        for (target, load) in forms {
            let colors = picture(target, Output::Color, load);
            let difference = Difference::of(&case.scene, &colors, &words);
            eprint!("{target} on {}, ", device.describe());
            difference.check(&case, adapter.is_software());
        }
    }
}
