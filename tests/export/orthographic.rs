//! The exported shadow map of a distant light: hulls, seen by an orthographic camera.

use super::cases::{file, prepared};
use super::hull::hit_facets;
use super::opengl::text;
use super::webgpu::parsed;
use glam::{Mat3, Vec2, Vec3};
use relievo::export::{ExportedFile, Options, Output, Target, export};
use relievo_bitwise::{Device, wgpu};
use relievo_shared::intersection::Camera;
use relievo_shared::layout::Frame;
use relievo_tests::every_adapter;

/// Pixels.
const SIZE: [u32; 2] = [64, 48];
/// Half the extent of the picture, and distance of the far plane, object units.
const HALF: Vec2 = Vec2::new(1.6, 1.2);
const FAR: f32 = 6.0;

/// The frame of the camera as README.md of an export says.
fn frame(forward: Vec3) -> Frame {
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let pixel = 2.0 * HALF / Vec2::from(SIZE.map(|side| side as f32));
    let (ray_right, ray_down) = (right * pixel.x, -up * pixel.y);
    let corner = up * HALF.y - right * HALF.x;
    Frame {
        eye: (-0.5 * FAR * forward).to_array(),
        near: FAR,
        forward: forward.to_array(),
        ray_first: (corner + 0.5 * (ray_right + ray_down)).to_array(),
        ray_right: ray_right.to_array(),
        ray_down: ray_down.to_array(),
        size: SIZE.map(|side| side as f32),
        ..Frame::default()
    }
}

/// The vertex shader of an engine, which draws the hulls.
fn vertex_shader(frame: &Frame) -> String {
    let forward = Vec3::from(frame.forward);
    let [right, down] = [frame.ray_right, frame.ray_down].map(Vec3::from);
    let pixel = right.length();
    let rows = [
        right.normalize() / HALF.x,
        -down.normalize() / HALF.y,
        -forward / FAR,
    ];
    let turn = Mat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    let vector = |v: Vec3| format!("vec3<f32>({:?}, {:?}, {:?})", v.x, v.y, v.z);
    format!(
        "struct Out {{ @builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) facet: u32 }}
@vertex fn vs_main(@location(0) position: vec3<f32>, @location(1) outward: vec3<f32>, @location(2) facet: u32) -> Out {{
    let turn = mat3x3<f32>({}, {}, {});
    let at = turn * (position + outward * {pixel:?} - {});
    return Out(vec4<f32>(at.xy, 1.0 + at.z, 1.0), facet);
}}",
        vector(turn.x_axis),
        vector(turn.y_axis),
        vector(turn.z_axis),
        vector(frame.eye.into()),
    )
}

/// Draws the depths of an exported object, rows from the top.
fn draw(device: &Device, files: &[ExportedFile], frame: &Frame) -> Vec<f32> {
    use wgpu::util::DeviceExt;
    let gpu = device.wgpu();
    let buffer = |contents: &[u8], usage| {
        gpu.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents,
            usage,
        })
    };
    let vertex = parsed(device, vertex_shader(frame));
    let fragment = parsed(device, text(files, "depth_orthographic.wgsl"));
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Uint32];
    let pipeline = gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &vertex,
            entry_point: Some("vs_main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 28,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: Some(wgpu::Face::Front),
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &fragment,
            entry_point: Some("fs_depth_orthographic"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    });
    let buffers = [
        buffer(bytemuck::bytes_of(frame), wgpu::BufferUsages::STORAGE),
        buffer(file(files, "object.bin"), wgpu::BufferUsages::STORAGE),
        buffer(file(files, "facets.bin"), wgpu::BufferUsages::STORAGE),
        buffer(file(files, "map.bin"), wgpu::BufferUsages::STORAGE),
    ];
    let entries: Vec<_> = (0..)
        .zip(&buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let vertices = buffer(file(files, "hull.bin"), wgpu::BufferUsages::VERTEX);
    let indices = file(files, "hull_indices.bin");
    let count = indices.len() as u32 / 4;
    let indices = buffer(indices, wgpu::BufferUsages::INDEX);
    let [width, height] = SIZE;
    let depth = gpu.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let rows = gpu.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(4 * width * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth.create_view(&wgpu::TextureViewDescriptor::default()),
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..count, 0, 0..1);
    }
    encoder.copy_texture_to_buffer(
        depth.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &rows,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: None,
            },
        },
        depth.size(),
    );
    device.queue().submit([encoder.finish()]);
    device
        .read(&rows, rows.size(), |bytes| {
            bytemuck::pod_collect_to_vec(bytes)
        })
        .unwrap()
}

#[test]
fn gpu_a_shadow_map_has_the_depths_of_parallel_rays() {
    let adapter = every_adapter().swap_remove(0);
    let device = adapter.open().unwrap();
    // GPUs have not been measured yet.
    let (pixels, bound) = if adapter.is_software() {
        (0, 1e-6)
    } else {
        (20, 1e-3)
    };
    for name in ["torus_planar.toml", "torus.toml", "torus_accurate.toml"] {
        let scene = prepared(name, |_| ());
        let options = Options {
            targets: vec![Target::Wgsl],
            output: Output::Hit,
            ..Options::default()
        };
        let files = export(&scene, &options).unwrap();
        let forward = Vec3::new(-0.5, -0.7, -0.4).normalize();
        let frame = frame(forward);
        let depths = draw(&device, &files, &frame);
        let camera = Camera {
            forward,
            right: Vec3::from(frame.ray_right) / FAR,
            down: Vec3::from(frame.ray_down) / FAR,
            near: 1e-6 * FAR,
        };
        let (mut covered, mut uncovered, mut largest) = (0, 0, 0.0f32);
        for (y, row) in depths.chunks(SIZE[0] as usize).enumerate() {
            for (x, depth) in row.iter().enumerate() {
                // In the order of the shader.
                let through = Vec3::from(frame.ray_first)
                    + Vec3::from(frame.ray_right) * x as f32
                    + Vec3::from(frame.ray_down) * y as f32;
                let origin = Vec3::from(frame.eye) + through;
                let hits = hit_facets(&scene, &camera, origin, forward);
                let nearest = hits.iter().map(|(_, t)| *t).reduce(f32::min);
                let wanted = nearest.map_or(0.0, |t| 1.0 - t / FAR);
                if (wanted > 0.0) != (*depth > 0.0) {
                    uncovered += 1;
                } else {
                    covered += usize::from(wanted > 0.0);
                    largest = largest.max((wanted - depth).abs());
                }
            }
        }
        eprintln!("{name}: {covered} covered, {uncovered} otherwise, {largest}");
        assert!(covered > 500, "{name}: there is something to see");
        assert!(
            uncovered <= pixels && largest < bound,
            "{name}: {uncovered}, {largest}"
        );
    }
}
