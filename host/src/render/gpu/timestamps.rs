//! Times the passes of a frame by the device's clock.

use relievo_bitwise::Device;
use std::time::Duration;

/// Bytes of the two timestamps.
const SIZE: u64 = 2 * size_of::<u64>() as u64;

/// Timestamps of the beginning of the first and the end of the last pass.
pub struct Timestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read_back: wgpu::Buffer,
    /// Nanoseconds of a tick.
    period: f32,
}

impl Timestamps {
    /// Makes timestamps if `device` supports them.
    pub fn of(device: &Device) -> Option<Timestamps> {
        let (wgpu, queue) = (device.wgpu(), device.queue());
        let has_clock = wgpu.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        has_clock.then(|| Timestamps::new(wgpu, queue.get_timestamp_period()))
    }

    /// For a device whose clock ticks every `period` nanoseconds.
    fn new(device: &wgpu::Device, period: f32) -> Timestamps {
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: SIZE,
                usage,
                mapped_at_creation: false,
            })
        };
        Timestamps {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            read_back: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
            period,
        }
    }

    /// Returns the writes for the first compute pass of a frame.
    pub(super) fn begin(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: None,
        }
    }

    /// Returns the writes for the last render pass of a frame.
    pub(super) fn end(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: None,
            end_of_pass_write_index: Some(1),
        }
    }

    /// Records the copy of the timestamps to [`Self::buffer`].
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read_back, 0, SIZE);
    }

    /// Returns the buffer of the two ticks.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.read_back
    }

    /// Returns the time between the two ticks in `bytes`, the content of
    /// [`Self::buffer`].
    pub fn duration(&self, bytes: &[u8]) -> Duration {
        let [begin, end] = [0, 8].map(|at| {
            let mut word = [0; 8];
            word.copy_from_slice(&bytes[at..at + 8]);
            u64::from_le_bytes(word)
        });
        let ticks = end.saturating_sub(begin);
        Duration::from_nanos((ticks as f64 * f64::from(self.period)) as u64)
    }
}
