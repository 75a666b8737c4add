//! Measures the error of a recipe on some of the picture's own rays.

use super::metrics::thinned;
use crate::mesh::Bounds;
use crate::oracle::{Displacements, MeshOracle, SHARE, Truth};
use crate::prepare::PreparedScene;
use crate::render::{CpuRenderer, GeometryWords, RenderError, Renderer};
use glam::DVec3;
use relievo_shared::layout::Frame;

/// Approximate number of rays that meet the object in a first trial.
pub(super) const FEW_RAYS: f64 = 1_000.0;
/// The same in a second trial, if the first is inconclusive.
pub(super) const MANY_RAYS: f64 = 10_000.0;

/// Largest ratio of a trial's rays to those that meet the object. More would take long for
/// objects that are hidden or outside the picture.
const SPARSEST: f64 = 32.0;

/// Confidence of a trial in standard deviations: the share on the trial's rays
/// and the share on all pixels differ by more in 1 of 200 cases.
const DOUBT: f64 = 2.6;

/// Result of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Rays on which the picture or the truth shows the object.
    pub rays: usize,
    /// Pixels of the picture per ray.
    pub pixels_per_ray: f64,
    /// Share of the rays whose error exceeds the budget.
    pub share_above: f64,
    /// Maximum number of steps of the linear search on any ray.
    pub steps: u32,
}

impl Trial {
    /// Returns whether smaller tolerances may help.
    pub(super) fn is_near(&self) -> bool {
        self.share_above <= 3.0 * (1.0 - SHARE)
    }

    /// Returns whether a trial with more rays may succeed.
    pub(super) fn is_doubtful(&self) -> bool {
        !self.keeps() && self.share_above <= 1.0 - SHARE && self.pixels_per_ray > 1.0
    }

    /// Returns whether the picture keeps the budget, with confidence `DOUBT`.
    pub fn keeps(&self) -> bool {
        let allowed = 1.0 - SHARE;
        let doubt = if self.pixels_per_ray > 1.0 {
            DOUBT * (allowed * SHARE / self.rays.max(1) as f64).sqrt()
        } else {
            0.0
        };
        self.share_above <= (allowed - doubt).max(0.0)
    }
}

/// Measures errors on a grid of rays whose truth is known.
pub(super) struct Evaluator<'a> {
    oracle: MeshOracle<'a>,
    truth: Truth,
    frame: Frame,
    /// Pixels between rays.
    stride: f64,
    eye: DVec3,
}

impl<'a> Evaluator<'a> {
    /// Traces the truth on a grid of rays of the picture of `reference`, which contains
    /// one object. About `rays` of them meet it, if it covers about `pixels` of the picture.
    pub(super) fn new(reference: &'a PreparedScene, pixels: f64, rays: f64) -> Evaluator<'a> {
        let (frame, stride) = grid(reference, pixels, rays);
        Evaluator::on(reference, frame, stride)
    }

    /// Traces the truth on every pixel of the picture of `reference`.
    pub(super) fn of_every_pixel(reference: &'a PreparedScene) -> Evaluator<'a> {
        Evaluator::on(reference, reference.frame, 1.0)
    }

    fn on(reference: &'a PreparedScene, frame: Frame, stride: f64) -> Evaluator<'a> {
        let oracle = MeshOracle::new(reference);
        let eye = DVec3::from(reference.camera.eye);
        let truth = Truth::of(&oracle, eye, &frame);
        Evaluator {
            oracle,
            truth,
            frame,
            stride,
            eye,
        }
    }

    /// Measures the errors of `scene`, which is the reference with another recipe.
    pub(super) fn evaluate(
        &self,
        scene: &mut PreparedScene,
        budget: f64,
    ) -> Result<Trial, RenderError> {
        let words = self.words(scene)?;
        let (rays, share_above) = self.truth.share_above(
            &self.oracle,
            self.eye,
            &self.frame,
            self.stride,
            &words,
            budget,
        );
        let pixels = 0..words.surface.len();
        Ok(Trial {
            rays,
            pixels_per_ray: self.stride * self.stride,
            share_above,
            steps: pixels.map(|i| words.steps(i)).max().unwrap_or_default(),
        })
    }

    /// Returns the errors of `scene` up to `largest` pixels; for evaluators of
    /// every pixel.
    pub(super) fn displacements(
        &self,
        scene: &mut PreparedScene,
        largest: f64,
    ) -> Result<Displacements, RenderError> {
        let words = self.words(scene)?;
        let (oracle, truth) = (&self.oracle, &self.truth);
        Ok(truth.displacements(oracle, self.eye, &self.frame, &words, largest))
    }

    /// Renders `scene` on the rays of the grid.
    fn words(&self, scene: &mut PreparedScene) -> Result<GeometryWords, RenderError> {
        // Tolerances are in pixels of the picture, not in those of the grid.
        let objects = scene.objects.iter();
        let own: Vec<f32> = objects.map(|object| object.parameters.tolerance).collect();
        for object in &mut scene.objects {
            object.parameters.tolerance /= self.stride as f32;
        }
        let words = CpuRenderer::new(scene).geometry(&self.frame);
        for (object, tolerance) in scene.objects.iter_mut().zip(own) {
            object.parameters.tolerance = tolerance;
        }
        words
    }
}

/// Returns a frame of rays over the rectangle of the picture that the only object of `scene`
/// may cover, and the pixels between two rays. About `rays` of them meet the object, if it
/// covers about `pixels`, but at most [`SPARSEST`] times as many are traced.
fn grid(scene: &PreparedScene, pixels: f64, rays: f64) -> (Frame, f64) {
    let frame = &scene.frame;
    let [left, top, right, bottom] = rectangle(scene);
    let area = (right - left) * (bottom - top);
    let covered = pixels.clamp(area / SPARSEST, area);
    let stride = (covered / rays).sqrt().floor().max(1.0);
    let first = [left, top].map(|side| (side + 0.5 * (stride - 1.0).floor()) as f32);
    let size = [right - left, bottom - top].map(|side| (side / stride).floor().max(1.0) as f32);
    let grid = thinned(frame, first, [stride as f32; 2], size);
    (grid, stride)
}

/// Returns left, top, right and bottom of the rectangle that the object may
/// cover, pixels.
fn rectangle(scene: &PreparedScene) -> [f64; 4] {
    let frame = &scene.frame;
    let [width, height] = frame.size.map(f64::from);
    let whole = [0.0, 0.0, width, height];
    let Some(object) = scene.objects.first() else {
        return whole;
    };
    let Bounds { min, max } = object.mesh.bounds;
    // The smooth surface may bulge out of its mesh.
    let margin = DVec3::splat(f64::from(object.parameters.depth) + 0.05 * min.distance(max));
    let (low, high) = (min - margin - scene.origin, max + margin - scene.origin);
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let mut found = [width, height, 0.0, 0.0];
    for corner in 0..8 {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                low[axis]
            } else {
                high[axis]
            }
        };
        let point = DVec3::new(pick(0), pick(1), pick(2)) - wide(frame.eye);
        let z = point.dot(wide(frame.forward));
        if z <= f64::from(frame.near) {
            return whole;
        }
        let x = 0.5 * width * (1.0 + point.dot(wide(frame.right)) / z);
        let y = 0.5 * height * (1.0 - point.dot(wide(frame.up)) / z);
        found = [
            found[0].min(x),
            found[1].min(y),
            found[2].max(x),
            found[3].max(y),
        ];
    }
    let [left, top, right, bottom] = found;
    let found = [
        (left.floor() - 1.0).max(0.0),
        (top.floor() - 1.0).max(0.0),
        (right.ceil() + 1.0).min(width),
        (bottom.ceil() + 1.0).min(height),
    ];
    if found[0] < found[2] && found[1] < found[3] {
        found
    } else {
        // Outside the picture: one ray is enough.
        [0.0, 0.0, 1.0, 1.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_rays_have_to_be_better() {
        let trial = |rays, pixels_per_ray, share_above| Trial {
            rays,
            pixels_per_ray,
            share_above,
            steps: 0,
        };
        assert!(trial(5000, 1.0, 0.01).keeps());
        assert!(!trial(5000, 1.0, 0.0101).keeps());
        assert!(trial(5000, 4.0, 0.006).keeps());
        assert!(!trial(5000, 4.0, 0.009).keeps());
        assert!(!trial(100, 4.0, 0.001).keeps());
        assert!(trial(100, 4.0, 0.0).keeps());
        assert!(trial(0, 4.0, 0.0).keeps());
    }
}
