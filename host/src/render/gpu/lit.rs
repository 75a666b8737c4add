//! Shading on a GPU: the buffers of materials and lights, the shadow maps, and the passes
//! over the G-buffer.

use super::content::Pass;
use super::pipelines::Pipelines;
use super::targets::Targets;
use super::timestamps::Timestamps;
use crate::prepare::PreparedLighting;
use crate::render::RenderError;
use relievo_shared::layout::Frame;
use std::mem::size_of;
use std::num::NonZero;
use std::sync::Arc;

/// Materials and lights of a scene.
pub(super) struct GpuLighting {
    lighting: Arc<PreparedLighting>,
    tables: wgpu::BindGroup,
    /// Pictures, environment and shadow maps.
    words: wgpu::Buffer,
}

impl GpuLighting {
    /// Uploads `lighting` to the device of `pipelines`, and makes its pipeline; `frames` begins
    /// with the frame in world space, and `description` names the device in errors.
    pub(super) fn new(
        lighting: &Arc<PreparedLighting>,
        pipelines: &mut Pipelines,
        frames: &wgpu::Buffer,
        description: &str,
    ) -> Result<GpuLighting, RenderError> {
        let opened = pipelines.device().clone();
        let contents: [&[u8]; 6] = [
            bytemuck::bytes_of(&lighting.lighting),
            bytemuck::cast_slice(&lighting.finishes),
            bytemuck::cast_slice(&lighting.facets),
            bytemuck::cast_slice(&lighting.lights),
            bytemuck::cast_slice(&lighting.shadow_maps),
            bytemuck::cast_slice(&lighting.words),
        ];
        let sizes = lighting.buffer_bytes();
        let largest = opened.largest_storage();
        if let Some(needed) = sizes.into_iter().find(|bytes| *bytes > largest) {
            return Err(RenderError::Limit {
                adapter: description.to_string(),
                what: "a buffer of pictures and shadow maps (bytes)".to_string(),
                needed,
                limit: largest,
            });
        }
        let layout = pipelines.make_shade(Pass::of(lighting))?;
        let buffers: Vec<wgpu::Buffer> = contents
            .into_iter()
            .zip(sizes)
            .map(|(bytes, size)| {
                let buffer = opened.wgpu().create_buffer(&wgpu::BufferDescriptor {
                    label: Some("materials and lights"),
                    size,
                    usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                opened.queue().write_buffer(&buffer, 0, bytes);
                buffer
            })
            .collect();
        let frame = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: frames,
            offset: 0,
            size: NonZero::new(size_of::<Frame>() as u64),
        });
        let rest = buffers.iter().map(wgpu::Buffer::as_entire_binding);
        let entries: Vec<_> = (0..)
            .zip([frame].into_iter().chain(rest))
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let tables = opened.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("materials and lights"),
            layout,
            entries: &entries,
        });
        let [.., words] = &buffers[..] else {
            unreachable!("there are six buffers");
        };
        Ok(GpuLighting {
            lighting: lighting.clone(),
            tables,
            words: words.clone(),
        })
    }

    /// Returns the frames of the shadow maps.
    pub(super) fn frames(&self) -> &[Frame] {
        &self.lighting.shadow_frames
    }

    /// Records the copy of the depths in `targets` to shadow map `index`.
    pub(super) fn record_shadow(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        index: usize,
    ) {
        let depth = targets.kept_depth().expect("shadow maps are read");
        let map = &self.lighting.shadow_maps[index];
        let bytes = size_of::<f32>() as u32;
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                aspect: wgpu::TextureAspect::DepthOnly,
                ..depth.as_image_copy()
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &self.words,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: u64::from(map.first) * u64::from(bytes),
                    // A multiple of 256: sizes are multiples of 64.
                    bytes_per_row: Some(map.size * bytes),
                    rows_per_image: Some(map.size),
                },
            },
            depth.size(),
        );
    }

    /// Returns the passes that shade the G-buffer.
    pub(super) fn passes(&self) -> &'static [Pass] {
        Pass::of(&self.lighting)
    }

    /// Records the shading of the G-buffer in `targets`, whose end `clock` takes.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &Pipelines,
        targets: &Targets,
        clock: Option<&Timestamps>,
    ) {
        let passes = self.passes();
        for (index, pass) in passes.iter().enumerate() {
            let is_last = index + 1 == passes.len();
            let Some(color) = targets.view(Pass::writes(is_last)) else {
                return;
            };
            let mut recorded = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(pass.fragment()),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: color,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: None,
                timestamp_writes: clock.filter(|_| is_last).map(Timestamps::end),
                occlusion_query_set: None,
                multiview_mask: None,
            });
            recorded.set_pipeline(pipelines.shade().pipeline(*pass));
            recorded.set_bind_group(0, &self.tables, &[]);
            recorded.set_bind_group(1, targets.readable(*pass), &[]);
            recorded.draw(0..3, 0..1);
        }
    }
}
