//! Picture resolution while something moves.

use std::time::Duration;

/// Time budget of a frame in motion, seconds: 10 frames per second, with room
/// for the window itself.
const WANTED: Duration = Duration::from_millis(45);
/// Largest reduction: each rendered pixel covers 6 × 6 screen pixels.
const COARSEST: f64 = 1.0 / 6.0;

/// Chooses the resolution in motion from the times of recent frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Governor {
    /// Seconds per pixel, smoothed.
    cost: Option<f64>,
}

impl Governor {
    /// Records that a picture of this size took `time`.
    pub fn learn(&mut self, [width, height]: [u32; 2], took: Duration) {
        let pixels = (f64::from(width) * f64::from(height)).max(1.0);
        let cost = took.as_secs_f64() / pixels;
        // Rising costs apply at once, falling costs gradually.
        self.cost = Some(match self.cost {
            Some(before) if cost < before => 0.7 * before + 0.3 * cost,
            _ => cost,
        });
    }

    /// Returns the resolution in motion for a picture of `size` at rest.
    pub fn size(&self, size: [u32; 2]) -> [u32; 2] {
        let Some(cost) = self.cost else {
            // No measurement yet: a quarter of the pixels.
            return scaled(size, 0.5);
        };
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        let share = WANTED.as_secs_f64() / (cost * pixels).max(1e-9);
        scaled(size, share.sqrt().clamp(COARSEST, 1.0))
    }
}

fn scaled(size: [u32; 2], factor: f64) -> [u32; 2] {
    size.map(|side| ((f64::from(side) * factor).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_pictures_become_smaller_until_they_are_fast_enough() {
        let mut governor = Governor::default();
        let full = [640, 480];
        // A device that takes 1 µs per pixel: 0.3 s for all.
        for _ in 0..3 {
            let size = governor.size(full);
            let pixels = f64::from(size[0]) * f64::from(size[1]);
            governor.learn(size, Duration::from_secs_f64(1e-6 * pixels));
        }
        let size = governor.size(full);
        let took = 1e-6 * f64::from(size[0]) * f64::from(size[1]);
        assert!(took < 0.047 && took > 0.043, "{size:?}");
    }

    #[test]
    fn fast_devices_draw_everything_and_slow_ones_something() {
        let mut governor = Governor::default();
        governor.learn([640, 480], Duration::from_micros(300));
        assert_eq!(governor.size([640, 480]), [640, 480]);
        governor.learn([640, 480], Duration::from_secs(100));
        assert_eq!(governor.size([640, 480]), [107, 80]);
        assert_eq!(governor.size([1, 1]), [1, 1]);
    }
}
