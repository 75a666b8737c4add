//! Draws an object written by `relievo export --target wgsl`, with wgpu and without
//! Relievo: `plain-wgpu FOLDER OUT.png`.

mod bindings;

use bindings::{BUFFERS, DEPTH_FORMAT, FRAGMENT, Frame, VERTEX, bind_group_layout};
use std::path::{Path, PathBuf};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The shader writes linear colours, which the target converts to sRGB.
const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

fn main() -> Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(folder), Some(output)) = (arguments.next(), arguments.next()) else {
        return Err("usage: plain-wgpu FOLDER OUT.png".into());
    };
    let (device, queue) = pollster::block_on(open())?;
    let (size, pixels) = draw(&device, &queue, &folder)?;
    image::save_buffer(&output, &pixels, size[0], size[1], image::ColorType::Rgba8)?;
    Ok(())
}

async fn open() -> Result<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::default();
    let adapter = instance.request_adapter(&Default::default()).await?;
    let descriptor = wgpu::DeviceDescriptor {
        // Shape maps may exceed the default limits.
        required_limits: wgpu::Limits {
            max_buffer_size: adapter.limits().max_buffer_size,
            max_storage_buffer_binding_size: adapter.limits().max_storage_buffer_binding_size,
            ..Default::default()
        },
        ..Default::default()
    };
    Ok(adapter.request_device(&descriptor).await?)
}

fn read(folder: &Path, name: &str) -> Result<Vec<u8>> {
    let path = folder.join(name);
    std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// Makes the pipeline that the folder's README describes.
fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    folder: &Path,
) -> Result<wgpu::RenderPipeline> {
    let shader = |name: &str| -> Result<wgpu::ShaderModule> {
        let text = String::from_utf8(read(folder, name)?)?;
        Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        }))
    };
    let (vertex, fragment) = (shader("vertex.wgsl")?, shader("fragment.wgsl")?);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    Ok(
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &vertex,
                entry_point: Some(VERTEX),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &fragment,
                entry_point: Some(FRAGMENT),
                compilation_options: Default::default(),
                targets: &[Some(TARGET_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        }),
    )
}

/// Draws the folder's object on white; returns width and height, and the pixels as
/// RGBA.
fn draw(device: &wgpu::Device, queue: &wgpu::Queue, folder: &Path) -> Result<([u32; 2], Vec<u8>)> {
    let frame: Frame = bytemuck::pod_read_unaligned(&read(folder, "frame.bin")?);
    let [width, height] = frame.size.map(|side| side as u32);
    let layout = bind_group_layout(device);
    let pipeline = pipeline(device, &layout, folder)?;
    let buffer = |name: &str, usage| -> Result<wgpu::Buffer> {
        Ok(device.create_buffer_init(&BufferInitDescriptor {
            label: Some(name),
            contents: &read(folder, name)?,
            usage,
        }))
    };
    let mut buffers = Vec::new();
    for name in BUFFERS {
        buffers.push(buffer(name, wgpu::BufferUsages::STORAGE)?);
    }
    let entries: Vec<_> = (0..)
        .zip(&buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &entries,
    });
    let count = buffer("draw.bin", wgpu::BufferUsages::INDIRECT)?;

    let texture = |format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
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
            usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    };
    let color = texture(TARGET_FORMAT, wgpu::TextureUsages::COPY_SRC);
    let depth = texture(DEPTH_FORMAT, wgpu::TextureUsages::empty());
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &color.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth.create_view(&Default::default()),
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw_indirect(&count, 0);
    drop(pass);

    let stride = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let rows = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(stride * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(stride),
        rows_per_image: None,
    };
    let target = wgpu::TexelCopyBufferInfo {
        buffer: &rows,
        layout,
    };
    encoder.copy_texture_to_buffer(color.as_image_copy(), target, color.size());
    queue.submit([encoder.finish()]);
    rows.map_async(wgpu::MapMode::Read, .., |result| {
        result.expect("the picture")
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = rows.get_mapped_range(..)?;
    let row = |row: &[u8]| row[..4 * width as usize].to_vec();
    let pixels = bytes.chunks(stride as usize).flat_map(row).collect();
    Ok(([width, height], pixels))
}
