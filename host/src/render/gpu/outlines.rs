//! The outlines around the facets' pixels: a compute pass finds them, and a render pass
//! draws them. Where they do not fit one buffer, they are found and drawn in batches.

use super::pipelines::Pipelines;
use super::shared::STRIDE;
use std::mem::size_of;
use std::num::NonZero;
use std::ops::Range;

/// Bytes of an outline: x and y of three corners.
const OUTLINE: u64 = size_of::<[f32; 6]>() as u64;

/// Bytes that a scene's outlines take at most, unless one object needs more.
const MOST: u64 = 64 << 20;

/// The buffer of outlines, and what is drawn by it.
pub(super) struct Outlines {
    buffer: wgpu::Buffer,
    /// For the compute pass, and for the render pass.
    written: wgpu::BindGroup,
    read: wgpu::BindGroup,
    /// Bytes for objects of a batch.
    capacity: u64,
    /// Index of an object, and where its outlines are, bytes.
    drawn: Vec<(u32, u32)>,
    /// Those of `drawn` that the buffer holds at once; never empty.
    batches: Vec<Range<usize>>,
}

/// Invocations of a workgroup of the compute shaders, and of a row of workgroups.
const THREADS: u64 = 64;
const ROW: u64 = 1 << 13;

/// Returns the number of facets that buffers have room for: one for each invocation of the
/// compute shaders, which have no bound.
pub(super) fn padded(facets: u64) -> u64 {
    let step = if facets <= ROW { THREADS } else { ROW };
    facets.next_multiple_of(step)
}

/// Returns the numbers of workgroups for this many facets.
pub(super) fn workgroups(facets: u64) -> [u32; 2] {
    let facets = padded(facets);
    [
        (facets.min(ROW) / THREADS) as u32,
        facets.div_ceil(ROW) as u32,
    ]
}

/// Returns the bytes of the outlines of this many facets.
fn bytes(facets: u64) -> u64 {
    (padded(facets) * OUTLINE).next_multiple_of(STRIDE as u64)
}

/// Returns the bytes of the buffer for objects of so many `facets` each: those of a batch,
/// and those that are bound, which are as many as the largest object needs.
pub(super) fn buffer_bytes(facets: impl Iterator<Item = u64>) -> [u64; 2] {
    let (mut all, mut largest) = (0, STRIDE as u64);
    for facets in facets {
        all += bytes(facets);
        largest = largest.max(bytes(facets));
    }
    [all.min(MOST).max(largest), largest]
}

impl Outlines {
    /// Makes the buffer for objects of so many `facets` each.
    pub fn new(pipelines: &Pipelines, facets: impl Iterator<Item = u64>) -> Outlines {
        let device = pipelines.device().wgpu();
        let [capacity, bound] = buffer_bytes(facets);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("outlines"),
            // An object is bound with as many as the largest one.
            size: capacity + bound,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let bindings = |layout: &wgpu::BindGroupLayout| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("outlines"),
                layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &buffer,
                        offset: 0,
                        size: NonZero::new(bound),
                    }),
                }],
            })
        };
        Outlines {
            written: bindings(pipelines.outline_bindings(true)),
            read: bindings(pipelines.outline_bindings(false)),
            buffer,
            capacity,
            drawn: Vec::new(),
            batches: Vec::new(),
        }
    }

    /// Returns the bytes of the buffer.
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }

    /// Sets the objects that are drawn: their indices, and how many facets each has.
    pub fn set(&mut self, objects: impl Iterator<Item = (u32, u64)>) {
        self.drawn.clear();
        self.batches.clear();
        let (mut first, mut offset) = (0, 0);
        for (object, facets) in objects {
            let bytes = bytes(facets);
            if offset + bytes > self.capacity {
                self.batches.push(first..self.drawn.len());
                first = self.drawn.len();
                offset = 0;
            }
            self.drawn.push((object, offset as u32));
            offset += bytes;
        }
        self.batches.push(first..self.drawn.len());
    }

    /// Returns the number of batches.
    pub fn batches(&self) -> usize {
        self.batches.len()
    }

    /// Returns the objects of a batch, and where their outlines are.
    pub fn batch(&self, index: usize) -> impl Iterator<Item = (u32, u32)> + '_ {
        let range = self.batches.get(index).cloned().unwrap_or(0..0);
        self.drawn[range].iter().copied()
    }

    /// Returns the bindings for a compute pass (group 1).
    pub fn written(&self) -> &wgpu::BindGroup {
        &self.written
    }

    /// Returns the bindings for a render pass (group 2).
    pub fn read(&self) -> &wgpu::BindGroup {
        &self.read
    }
}
