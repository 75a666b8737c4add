//! Render targets and their read-back buffers.

use super::content::{Content, DEPTH_FORMAT, Drawing, Pass, TARGET_FORMAT};
use super::memory;
use super::pipelines::Pipelines;
use crate::render::{RenderError, allocate};
use relievo_bitwise::Device;
use std::collections::BTreeMap;
use std::mem::size_of;

/// The targets of pictures of one size.
pub struct Targets {
    width: u32,
    height: u32,
    /// Bytes per row of the read-back buffers, with the alignment of the API.
    stride: u32,
    /// Those that [`Drawing::targets`] numbers; made when first needed.
    colors: Vec<Target>,
    depth: wgpu::TextureView,
    /// The depth buffer, where it is read afterwards.
    kept_depth: Option<wgpu::Texture>,
    /// Made when first needed.
    exits: Option<Exits>,
    /// Pictures that passes read; made when first needed.
    readable: BTreeMap<Pass, wgpu::BindGroup>,
}

/// The picture of exits.
pub(super) struct Exits {
    /// Width and height, pixels.
    size: [u32; 2],
    pub view: wgpu::TextureView,
    pub bindings: wgpu::BindGroup,
}

/// A render target.
struct Target {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// Made when first read.
    read_back: Option<wgpu::Buffer>,
}

impl Targets {
    /// Makes the depth buffer for pictures of `width` × `height` samples; colours
    /// are made by [`GpuScene::make_targets`](super::GpuScene::make_targets).
    ///
    /// # Errors
    /// [`RenderError::Limit`] if the device does not support that size.
    pub fn new(device: &Device, size: [u32; 2]) -> Result<Targets, RenderError> {
        Targets::with_depth(device, size, false)
    }

    /// As [`Targets::new`], with a depth buffer that can be read if it `is_kept`.
    pub(super) fn with_depth(
        device: &Device,
        [width, height]: [u32; 2],
        is_kept: bool,
    ) -> Result<Targets, RenderError> {
        let limits = device.wgpu().limits();
        let too_large = |what: &str, needed: u64, limit: u64| RenderError::Limit {
            adapter: device.describe().to_string(),
            what: format!("a picture of {width} × {height} samples: {what}"),
            needed,
            limit,
        };
        let side = u64::from(width.max(height));
        let largest_side = u64::from(limits.max_texture_dimension_2d);
        if side > largest_side {
            return Err(too_large("its longer side (pixels)", side, largest_side));
        }
        let stride = memory::row_stride(u64::from(width));
        let bytes = stride * u64::from(height);
        if bytes > limits.max_buffer_size {
            return Err(too_large(
                "its buffer (bytes)",
                bytes,
                limits.max_buffer_size,
            ));
        }
        let depth = texture(
            device.wgpu(),
            [width, height],
            DEPTH_FORMAT,
            if is_kept {
                wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC
            } else {
                wgpu::TextureUsages::RENDER_ATTACHMENT
            },
        );
        Ok(Targets {
            width,
            height,
            stride: stride as u32,
            colors: Vec::new(),
            exits: None,
            readable: BTreeMap::new(),
            depth: depth.create_view(&wgpu::TextureViewDescriptor::default()),
            kept_depth: is_kept.then_some(depth),
        })
    }

    /// Returns width and height, samples.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Makes the picture of exits, if it is missing: of one pixel if none is written.
    pub(super) fn make_exits(&mut self, pipelines: &Pipelines, is_written: bool) {
        let size = if is_written { self.size() } else { [1, 1] };
        if self.exits.as_ref().is_some_and(|kept| kept.size == size) {
            return;
        }
        let device = pipelines.device().wgpu();
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let picture = texture(device, size, TARGET_FORMAT, usage);
        let view = picture.create_view(&wgpu::TextureViewDescriptor::default());
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("exits"),
            layout: pipelines.exit_bindings(),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        });
        self.exits = Some(Exits {
            size,
            view,
            bindings,
        });
    }

    /// Makes what `pass` reads, if it is missing.
    pub(super) fn make_pass(&mut self, pipelines: &Pipelines, pass: Pass) {
        let device = pipelines.device();
        self.make_colors(device, pass.reads().end);
        self.readable.entry(pass).or_insert_with(|| {
            let views = &self.colors[pass.reads()];
            let entries: Vec<_> = (0..)
                .zip(views)
                .map(|(binding, target)| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(&target.view),
                })
                .collect();
            device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("G-buffer"),
                layout: pipelines.shade().pictures(pass),
                entries: &entries,
            })
        });
    }

    /// Returns what `pass` reads, which [`Self::make_pass`] has made.
    pub(super) fn readable(&self, pass: Pass) -> &wgpu::BindGroup {
        &self.readable[&pass]
    }

    /// Returns the picture of exits, if it was made.
    pub(super) fn exits(&self) -> Option<&Exits> {
        self.exits.as_ref()
    }

    /// Makes the missing targets for `drawing`, and their read-back buffers if
    /// `read_back`.
    pub(super) fn make(&mut self, device: &Device, drawing: Drawing, read_back: bool) {
        let range = drawing.targets();
        self.make_colors(device, range.end);
        if !read_back {
            return;
        }
        for target in &mut self.colors[range] {
            if target.read_back.is_none() {
                target.read_back = Some(device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                    label: Some("read back"),
                    size: u64::from(self.stride) * u64::from(self.height),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                }));
            }
        }
    }

    /// Makes the targets that lack to `count`.
    fn make_colors(&mut self, device: &Device, count: usize) {
        let device = device.wgpu();
        while self.colors.len() < count {
            let texture = texture(
                device,
                [self.width, self.height],
                TARGET_FORMAT,
                wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::COPY_SRC
                    | wgpu::TextureUsages::TEXTURE_BINDING,
            );
            self.colors.push(Target {
                view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
                texture,
                read_back: None,
            });
        }
    }

    /// Returns target `index`, if it was made.
    pub fn view(&self, index: usize) -> Option<&wgpu::TextureView> {
        Some(&self.colors.get(index)?.view)
    }

    /// Returns the depth buffer.
    pub(super) fn depth(&self) -> &wgpu::TextureView {
        &self.depth
    }

    /// Returns the depth buffer, if it can be read.
    pub(super) fn kept_depth(&self) -> Option<&wgpu::Texture> {
        self.kept_depth.as_ref()
    }

    /// Records the copy of the targets of `content` to their read-back buffers.
    pub fn record_read_back(&self, encoder: &mut wgpu::CommandEncoder, content: Content) {
        for target in &self.colors[content.targets()] {
            let Some(buffer) = &target.read_back else {
                continue;
            };
            encoder.copy_texture_to_buffer(
                target.texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(self.stride),
                        rows_per_image: Some(self.height),
                    },
                },
                target.texture.size(),
            );
        }
    }

    /// Returns the read-back buffer of target `index`, if it was made.
    pub fn read_back(&self, index: usize) -> Option<&wgpu::Buffer> {
        self.colors.get(index)?.read_back.as_ref()
    }

    /// Returns the words in `bytes`, the content of a read-back buffer, without
    /// the padding of rows.
    pub fn words(&self, bytes: &[u8]) -> Result<Vec<[u32; 4]>, RenderError> {
        let count = self.width as usize * self.height as usize;
        let mut words = allocate("the picture", count, [0; 4])?;
        let row_bytes = self.width as usize * size_of::<[u32; 4]>();
        let rows = bytes.chunks(self.stride as usize);
        for (pixels, row) in words.chunks_mut(self.width as usize).zip(rows) {
            bytemuck::cast_slice_mut(pixels).copy_from_slice(&row[..row_bytes]);
        }
        Ok(words)
    }

    /// Returns their bytes on the device.
    pub fn bytes(&self) -> u64 {
        let pixels = u64::from(self.width) * u64::from(self.height);
        let read: u64 = self
            .colors
            .iter()
            .filter_map(|target| target.read_back.as_ref())
            .map(wgpu::Buffer::size)
            .sum();
        let exits = self.exits.as_ref().map_or(0, |exits| {
            exits.size.map(u64::from).iter().product::<u64>() * memory::WORDS
        });
        pixels * (self.colors.len() as u64 * memory::WORDS + memory::DEPTH) + exits + read
    }
}

/// Makes a texture to render to.
fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
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
}
