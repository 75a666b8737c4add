//! Timing a render pass by the device's own clock.

use relievo_bitwise::Device;
use std::time::Duration;

/// Bytes of the two timestamps.
const SIZE: u64 = 2 * size_of::<u64>() as u64;

/// The device's clock at the beginning and the end of a render pass.
pub(crate) struct Timestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read_back: wgpu::Buffer,
    /// Nanoseconds of a tick.
    period: f32,
}

impl Timestamps {
    /// Those of a device that has a clock.
    pub(crate) fn of(device: &Device) -> Option<Timestamps> {
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

    /// What a render pass writes.
    pub(crate) fn writes(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Makes what the pass wrote readable.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read_back, 0, SIZE);
    }

    /// Where the two resolved ticks can be read.
    pub(crate) fn buffer(&self) -> &wgpu::Buffer {
        &self.read_back
    }

    /// The time between the two ticks in `bytes`, the contents of [`Self::buffer`].
    pub(crate) fn duration(&self, bytes: &[u8]) -> Duration {
        let [begin, end] = [0, 8].map(|at| {
            let mut word = [0; 8];
            word.copy_from_slice(&bytes[at..at + 8]);
            u64::from_le_bytes(word)
        });
        let ticks = end.saturating_sub(begin);
        Duration::from_nanos((ticks as f64 * f64::from(self.period)) as u64)
    }
}
