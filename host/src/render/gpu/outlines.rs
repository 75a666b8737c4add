//! The outlines around the facets' pixels: a compute pass finds them, and a render pass
//! draws them, both for all copies of an object that follow each other. Where outlines do not fit one
//! buffer, they are found and drawn in batches.

use super::pipelines::Pipelines;
use super::shared::STRIDE;
use crate::prepare::PreparedObject;
use relievo_shared::layout::Frame;
use std::mem::size_of;
use std::num::NonZero;
use std::ops::Range;

/// Bytes of an outline: x and y of three corners.
const OUTLINE: u64 = size_of::<[f32; 6]>() as u64;

/// Bytes of the frame of a copy.
const FRAME: u64 = size_of::<Frame>() as u64;

/// Bytes that a scene's outlines take at most, unless one object needs more.
const MOST: u64 = 64 << 20;

/// Bytes that the outlines of a run take at most, unless one object needs more.
const MOST_OF_RUN: u64 = 4 << 20;

/// Largest number of copies of a run.
const MOST_COPIES: u64 = 4096;

/// Facets that are drawn at once: those of an object, or of copies of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    /// Index of the facets.
    pub facets: u32,
    /// Number of copies.
    pub copies: u32,
    /// Where the frame of the first copy is, bytes; those of the others follow.
    pub frames: u32,
    /// Where the outlines are, bytes.
    pub outlines: u32,
}

/// What is drawn, in order.
#[derive(Default)]
pub(super) struct Runs {
    all: Vec<Run>,
    /// Those of `all` whose outlines the buffer holds at once; never empty.
    batches: Vec<Range<usize>>,
    /// End of the frames, bytes.
    frames: u64,
    /// End of the outlines of the last batch, bytes.
    outlines: u64,
}

impl Runs {
    /// Removes all.
    pub fn clear(&mut self) {
        self.all.clear();
        self.batches.clear();
        self.batches.push(0..0);
        // The frame of objects without a placement is the first one.
        self.frames = STRIDE as u64;
        self.outlines = 0;
    }

    /// Adds an object with `count` facets of this index, and returns where its frame is, bytes:
    /// at 0 unless it is `placed`. `sizes` are the sizes of the outlines' buffer.
    pub fn add(&mut self, facets: u32, count: u64, placed: bool, sizes: Sizes) -> u32 {
        if let Some(last) = self.all.last_mut().filter(|last| last.facets == facets)
            && placed
            && u64::from(last.copies) < MOST_COPIES
        {
            let longer = bytes((u64::from(last.copies) + 1) * count);
            if longer <= sizes.bound && u64::from(last.outlines) + longer <= sizes.capacity {
                let frame = u64::from(last.frames) + u64::from(last.copies) * FRAME;
                last.copies += 1;
                self.outlines = u64::from(last.outlines) + longer;
                self.frames = frame + FRAME;
                return frame as u32;
            }
        }
        let first = self.all.len();
        if self.outlines + bytes(count) > sizes.capacity {
            self.batches.push(first..first);
            self.outlines = 0;
        }
        let frames = if placed {
            let start = self.frames.next_multiple_of(STRIDE as u64);
            self.frames = start + FRAME;
            start as u32
        } else {
            0
        };
        self.all.push(Run {
            facets,
            copies: 1,
            frames,
            outlines: self.outlines as u32,
        });
        self.outlines += bytes(count);
        if let Some(batch) = self.batches.last_mut() {
            batch.end = first + 1;
        }
        frames
    }

    /// Returns the end of the frames, bytes.
    pub fn frame_bytes(&self) -> u64 {
        self.frames
    }

    /// Returns the number of batches.
    pub fn batches(&self) -> usize {
        self.batches.len()
    }

    /// Returns the runs of a batch.
    pub fn batch(&self, index: usize) -> &[Run] {
        let range = self.batches.get(index).cloned().unwrap_or(0..0);
        &self.all[range]
    }
}

/// The buffer of outlines.
pub(super) struct Outlines {
    buffer: wgpu::Buffer,
    /// For the compute pass, and for the render pass.
    written: wgpu::BindGroup,
    read: wgpu::BindGroup,
    sizes: Sizes,
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

/// Returns the bytes of the frames that are bound for runs of up to `copies` of an object with
/// `facets`: those of invocations that have no facet, too.
pub(super) fn bound_frame_bytes(copies: u64, facets: u64) -> u64 {
    let beyond = if copies > 1 {
        ROW / facets.max(1) + 1
    } else {
        0
    };
    (copies.min(MOST_COPIES) + beyond) * FRAME
}

/// Returns the bytes of the buffer of frames for `objects`, which share facets as `shared` says.
pub(super) fn frame_buffer_bytes(objects: &[PreparedObject], shared: &[Vec<usize>]) -> u64 {
    let placed = objects.iter().filter(|object| object.placement.is_some());
    let bound = shared.iter().map(|shared| {
        let facets = objects[shared[0]].triangles.len() as u64;
        bound_frame_bytes(shared.len() as u64, facets)
    });
    // The frames of a run are bound with as many as the longest one has.
    (STRIDE * (1 + placed.count())) as u64 + bound.max().unwrap_or(0)
}

/// Sizes of the buffer of outlines, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sizes {
    /// Of the runs of a batch.
    pub capacity: u64,
    /// Of those that are bound: as many as the largest run needs.
    pub bound: u64,
}

impl Sizes {
    /// Returns the sizes for objects of so many `facets` each.
    pub fn of(facets: impl Iterator<Item = u64>) -> Sizes {
        let (mut all, mut largest) = (0, STRIDE as u64);
        for facets in facets {
            all += bytes(facets);
            largest = largest.max(bytes(facets));
        }
        Sizes {
            capacity: all.min(MOST).max(largest),
            bound: all.min(MOST_OF_RUN).max(largest),
        }
    }

    /// Returns the bytes of the buffer: a run is bound with as many as the largest one.
    pub fn total(self) -> u64 {
        self.capacity + self.bound
    }
}

impl Outlines {
    /// Makes the buffer for objects of so many `facets` each.
    pub fn new(pipelines: &Pipelines, facets: impl Iterator<Item = u64>) -> Outlines {
        let device = pipelines.device().wgpu();
        let sizes = Sizes::of(facets);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("outlines"),
            size: sizes.total(),
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
                        size: NonZero::new(sizes.bound),
                    }),
                }],
            })
        };
        Outlines {
            written: bindings(pipelines.outline_bindings(true)),
            read: bindings(pipelines.outline_bindings(false)),
            buffer,
            sizes,
        }
    }

    /// Returns the bytes of the buffer.
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }

    /// Returns its sizes.
    pub fn sizes(&self) -> Sizes {
        self.sizes
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

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(sizes: Sizes, objects: &[(u32, u64, bool)]) -> (Runs, Vec<u32>) {
        let mut runs = Runs::default();
        runs.clear();
        let frames = objects.iter();
        let frames = frames.map(|&(facets, count, placed)| runs.add(facets, count, placed, sizes));
        let frames = frames.collect();
        (runs, frames)
    }

    const LARGE: Sizes = Sizes {
        capacity: 1 << 20,
        bound: 1 << 20,
    };

    #[test]
    fn copies_that_follow_each_other_are_one_run() {
        let objects = [
            (0, 9, false),
            (1, 5, true),
            (1, 5, true),
            (2, 9, true),
            (1, 5, true),
        ];
        let (runs, frames) = runs(LARGE, &objects);
        let copies: Vec<_> = runs
            .batch(0)
            .iter()
            .map(|run| (run.facets, run.copies))
            .collect();
        assert_eq!(copies, [(0, 1), (1, 2), (2, 1), (1, 1)]);
        assert_eq!(frames, [0, 256, 256 + FRAME as u32, 768, 1024]);
        assert_eq!(runs.frame_bytes(), 1024 + FRAME);
        // 64 outlines are room for the 10 of both copies.
        let outlines: Vec<_> = runs.batch(0).iter().map(|run| run.outlines).collect();
        assert_eq!(outlines, [0, 1536, 3072, 4608]);
    }

    #[test]
    fn batches_and_runs_end_where_the_buffer_does() {
        let small = Sizes {
            capacity: 2 * 1536,
            bound: 1536,
        };
        let (runs, _) = runs(small, &[(0, 40, true); 5]);
        let copies = |batch| {
            runs.batch(batch)
                .iter()
                .map(|run| run.copies)
                .collect::<Vec<_>>()
        };
        // 80 outlines do not fit 1536 bytes.
        assert_eq!(runs.batches(), 3);
        assert_eq!(
            [copies(0), copies(1), copies(2)],
            [vec![1, 1], vec![1, 1], vec![1]]
        );
        let (nothing, _) = self::runs(small, &[]);
        assert_eq!((nothing.batches(), nothing.batch(0).len()), (1, 0));
    }
}
