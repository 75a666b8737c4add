//! The values of a key at some times, and between them.

/// Largest number of key frames of all tracks of a scene.
pub(super) const MOST_KEY_FRAMES: usize = 10_000;

/// The values of one key of a scene at some times.
///
/// ```
/// use relievo::scene::{Scene, SceneObject, Track};
///
/// let object = SceneObject::new("torus.obj", "discs.png").named("ring");
/// let scene = Scene::default()
///     .object(object)
///     .track(Track::new("object.ring.depth", [(0.0, 0.25), (2.0, 0.75)]));
/// assert_eq!(scene.at_time(1.0)?.objects[0].depth, Some(0.5));
/// # Ok::<(), relievo::scene::SceneError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// The key with its tables: `camera.eye`, `light.intensity`, `object.NAME.depth`,
    /// `object.NAME.material.cap`. All objects of that name change.
    pub key: String,
    /// Times of the key frames, seconds, each later than the one before.
    pub times: Vec<f64>,
    /// The values at these times: one number for each component.
    pub values: Vec<Vec<f64>>,
    /// How the values between two key frames follow from them.
    pub interpolation: Interpolation,
}

/// How the values between two key frames follow from them. Before the first key frame and
/// after the last one a track has their values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// On a line.
    #[default]
    Linear,
    /// On a cubic curve through the key frames without corners (Catmull and Rom).
    Smooth,
    /// The value of the key frame before.
    Step,
}

impl Interpolation {
    /// All of them.
    pub const ALL: [Interpolation; 3] = [
        Interpolation::Linear,
        Interpolation::Smooth,
        Interpolation::Step,
    ];

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Interpolation::Linear => "linear",
            Interpolation::Smooth => "smooth",
            Interpolation::Step => "step",
        }
    }
}

impl Track {
    /// Creates a linear track of a key with one number.
    pub fn new(key: &str, frames: impl IntoIterator<Item = (f64, f64)>) -> Track {
        let (times, values) = frames.into_iter().map(|(t, x)| (t, vec![x])).unzip();
        Track {
            key: key.to_string(),
            times,
            values,
            interpolation: Interpolation::Linear,
        }
    }

    /// Returns the value at `time`, seconds; all values have as many components.
    pub(super) fn at(&self, time: f64) -> Vec<f64> {
        let (times, values) = (&self.times, &self.values);
        let next = times.partition_point(|key_frame| *key_frame <= time);
        if next == 0 || next == times.len() {
            return values[next.saturating_sub(1)].clone();
        }
        let first = next - 1;
        if self.interpolation == Interpolation::Step {
            return values[first].clone();
        }
        let length = times[next] - times[first];
        let x = (time - times[first]) / length;
        let component = |i: usize| {
            let (a, b) = (values[first][i], values[next][i]);
            if self.interpolation == Interpolation::Linear {
                return a + (b - a) * x;
            }
            // The slope at a key frame is that between its neighbours.
            let slope = |at: usize| {
                let (before, after) = (at.saturating_sub(1), (at + 1).min(times.len() - 1));
                (values[after][i] - values[before][i]) / (times[after] - times[before])
            };
            let (from, to) = (length * slope(first), length * slope(next));
            let (square, cube) = (x * x, x * x * x);
            (2.0 * cube - 3.0 * square + 1.0) * a
                + (cube - 2.0 * square + x) * from
                + (3.0 * square - 2.0 * cube) * b
                + (cube - square) * to
        };
        (0..values[first].len()).map(component).collect()
    }

    /// Checks the track by itself: the key and the problem.
    pub(super) fn check(&self) -> Result<(), Wrong> {
        let count = self.times.len();
        if count == 0 {
            return Err(("times", "is empty; write one time or more".to_string()));
        }
        if self.values.len() != count {
            let problem = format!(
                "has {} values for {count} times; write one for each",
                self.values.len()
            );
            return Err(("values", problem));
        }
        let components = self.values[0].len();
        if self.values.iter().any(|value| value.len() != components) {
            let problem = "are not all of one kind; write as many numbers in each".to_string();
            return Err(("values", problem));
        }
        let is_finite = self.times.iter().all(|time| time.is_finite());
        if !is_finite || !self.times.is_sorted_by(|a, b| a < b) {
            let problem = "is not in order; each time is later than the one before".to_string();
            return Err(("times", problem));
        }
        Ok(())
    }
}

/// Splits `object.NAME.KEY` into the object's name, with `.material` where the key is of that
/// table, and the key.
pub(super) fn object_key(key: &str) -> Option<(&str, &str)> {
    key.strip_prefix("object.")?.rsplit_once('.')
}

/// A key of a table `[[animate]]`, and what is wrong with its value.
pub(super) type Wrong = (&'static str, String);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_key_frames_follow_the_interpolation() {
        let curve = |interpolation| Track {
            interpolation,
            ..Track::new("camera.orbit", [(0.0, 0.0), (1.0, 1.0), (3.0, 9.0)])
        };
        let linear = curve(Interpolation::Linear);
        assert_eq!(
            [-1.0, 0.0, 0.5, 2.0, 9.0].map(|t| linear.at(t)[0]),
            [0.0, 0.0, 0.5, 5.0, 9.0]
        );
        let step = curve(Interpolation::Step);
        assert_eq!(
            [0.5, 1.0, 2.9, 3.0].map(|t| step.at(t)[0]),
            [0.0, 1.0, 1.0, 9.0]
        );
        // Through the key frames, with the same slope on both sides of one.
        let smooth = curve(Interpolation::Smooth);
        assert_eq!([0.0, 1.0, 3.0].map(|t| smooth.at(t)[0]), [0.0, 1.0, 9.0]);
        let slope = |t: f64| (smooth.at(t + 1e-6)[0] - smooth.at(t - 1e-6)[0]) / 2e-6;
        assert!((slope(1.0 - 1e-5) - 3.0).abs() < 1e-3 && (slope(1.0 + 1e-5) - 3.0).abs() < 1e-3);
        // A line stays one, and one key frame is a constant.
        let line = Track {
            interpolation: Interpolation::Smooth,
            ..Track::new("camera.orbit", [(0.0, 0.0), (1.0, 2.0), (4.0, 8.0)])
        };
        assert!((line.at(2.3)[0] - 4.6).abs() < 1e-12);
        assert_eq!(Track::new("camera.orbit", [(1.0, 7.0)]).at(0.0), [7.0]);
    }
}
