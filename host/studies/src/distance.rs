//! Flicker, error and cost of a scene by distance: a camera that creeps, from near to far away.

use crate::bench::Summary;
use crate::edges::{REFERENCE, with_coverage};
use crate::perceptual::difference;
use relievo::Error;
use relievo::picture::Picture;
use relievo::prepare::{PreparedScene, finer};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Camera, Scene};
use relievo_shared::layout::Frame;
use std::time::Instant;

/// Distances, multiples of that of the scene's camera.
pub const DISTANCES: [f64; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
/// How far the camera moves from frame to frame, pixels at its target.
pub const STEP: f64 = 0.01;
/// Least side of a picture, pixels.
const LEAST_SIDE: f64 = 16.0;

/// What is measured at one distance, without and with smooth edges.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Multiple of the distance of the scene's camera.
    pub distance: f64,
    /// Size of the picture, which shows as much of the scene as the scene's own, pixels.
    pub size: [u32; 2],
    /// Mean FLIP difference between frames, minus that of the reference.
    pub flicker: [f64; 2],
    /// The same, between the first two frames, if each class has its exact share of a pixel in the colour of the
    /// nearest sample: see [`Row::covered`](crate::edges::Row::covered).
    pub covered: f64,
    /// Mean FLIP difference from 256 samples a pixel.
    pub error: [f64; 2],
    /// Median time of a frame over the number of pixels that hit something, microseconds.
    pub time: [f64; 2],
}

/// Measures `scene`, prepared without and with smooth edges, on the CPU. The picture has `size` at the
/// distance 1, and less, with the same pixels, further away.
///
/// # Errors
/// [`Error`] if a renderer fails; the reference needs 12 KB a pixel.
pub fn measure(
    scene: &Scene,
    prepared: [&PreparedScene; 2],
    size: [u32; 2],
    frames: u32,
    progress: &dyn Fn(&str, f64),
) -> Result<Vec<Row>, Error> {
    let mut renderers = prepared.map(CpuRenderer::new);
    let mut rows = Vec::new();
    for (index, distance) in DISTANCES.into_iter().enumerate() {
        let share = |part: f64| (index as f64 + part) / DISTANCES.len() as f64;
        progress("frames", share(0.0));
        let view = View::new(scene, prepared[0], size, distance);
        let mut flicker = [0.0; 2];
        let mut error = [0.0; 2];
        let mut time = [0.0; 2];
        let mut first = Vec::new();
        let mut samples = Vec::new();
        for (which, renderer) in renderers.iter_mut().enumerate() {
            let mut before: Option<Picture> = None;
            let mut times = Vec::new();
            for step in 0..=frames {
                let frame = view.frame(step);
                let start = Instant::now();
                let words = renderer.color(&frame)?;
                times.push(start.elapsed().as_secs_f64());
                let picture = Picture::develop(&words, 1, &prepared[0].development)?;
                match &before {
                    None => first.push(picture.clone()),
                    Some(before) => flicker[which] += difference(before, &picture),
                }
                before = Some(picture);
                if which == 0 && step < 2 {
                    samples.push(words);
                }
            }
            flicker[which] /= f64::from(frames);
            let hits = renderer.statistics(&view.frame(0)).hits.max(1);
            // The first frame warms up.
            let median = Summary::of(&times[1..]).map_or(0.0, |summary| summary.median);
            time[which] = 1e6 * median / hits as f64;
        }
        progress("reference", share(0.5));
        let [start, end] = [0, 1].map(|step| {
            let frame = finer(&view.frame(step), REFERENCE);
            let words = renderers[0].color(&frame)?;
            let development = &prepared[0].development;
            let covered = with_coverage(&words, &samples[step as usize], development)?;
            Picture::develop(&words, REFERENCE, development).map(|picture| (picture, covered))
        });
        let ((start, covered_start), (end, covered_end)) = (start?, end?);
        let even = difference(&start, &end);
        let covered = difference(&covered_start, &covered_end);
        for which in 0..2 {
            flicker[which] = (flicker[which] - even).max(0.0);
            error[which] = difference(&start, &first[which]);
        }
        rows.push(Row {
            distance,
            size: view.size,
            flicker,
            covered: (covered - even).max(0.0),
            error,
            time,
        });
    }
    Ok(rows)
}

/// A camera at some distance.
struct View<'a> {
    prepared: &'a PreparedScene,
    /// The scene, with the field of view that the picture's size leaves of its own.
    scene: Scene,
    size: [u32; 2],
    camera: Camera,
    /// The camera's way from frame to frame, world units.
    step: [f64; 3],
}

impl<'a> View<'a> {
    fn new(scene: &Scene, prepared: &'a PreparedScene, size: [u32; 2], distance: f64) -> View<'a> {
        let longest = f64::from(size[0].max(size[1]));
        let part = (1.0 / distance).max(LEAST_SIDE / longest).min(1.0);
        let small = size.map(|side| (f64::from(side) * part).round().max(1.0) as u32);
        let camera = prepared.view_of(scene).camera;
        let [eye, target] = [camera.eye, camera.target].map(glam::DVec3::from);
        let away = (eye - target) * distance;
        let mut scene = scene.clone();
        let half = (scene.field_of_view.to_radians() / 2.0).tan();
        let share = f64::from(small[1]) / f64::from(size[1]);
        scene.field_of_view = 2.0 * (half * share).atan().to_degrees();
        let right = (-away).cross(camera.up.into()).normalize_or_zero();
        let camera = Camera {
            eye: (target + away).to_array(),
            ..camera
        };
        let frame = prepared.frame_from(&scene, &camera, small);
        let pixel = f64::from(glam::Vec3::from(frame.ray_right).length());
        View {
            prepared,
            scene,
            size: small,
            camera,
            step: (right * (away.length() * pixel * STEP)).to_array(),
        }
    }

    fn frame(&self, step: u32) -> Frame {
        let moved = |place: [f64; 3]| {
            let [x, y, z] = [0, 1, 2].map(|i| place[i] + self.step[i] * f64::from(step));
            [x, y, z]
        };
        let camera = Camera {
            eye: moved(self.camera.eye),
            target: moved(self.camera.target),
            ..self.camera
        };
        self.prepared.frame_from(&self.scene, &camera, self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo::prepare::prepare;
    use relievo::{Files, Limits};
    use std::path::Path;

    /// Returns the rows of a wall with so many repeats of two letters along each axis.
    fn rows(repeat: u32) -> Vec<Row> {
        let quad = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";
        let scene = |is_smooth| {
            let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
            let text = format!(
                "[image]\nsize = [48, 36]\nsmooth_edges = {is_smooth}\n\
                 [camera]\neye = [0.3, 0.2, 2]\ntarget = [0, 0, 0]\nfov = 40\n\
                 [environment]\n[[light]]\ndirection = [1, 2, 3]\n\
                 [[object]]\nmesh = \"quad.obj\"\nshape = {{ text = \"Ra\" }}\n\
                 projection = \"planar-z\"\nrepeat = [{repeat}, {repeat}]\ndepth = 0.01\n"
            );
            Scene::parse_with(&text, Path::new(""), &Limits::default(), files).unwrap()
        };
        let prepared = [false, true].map(|is_smooth| prepare(&scene(is_smooth), &|_| ()).unwrap());
        let [plain, smooth] = &prepared;
        measure(&scene(false), [plain, smooth], [48, 36], 4, &|_, _| ()).unwrap()
    }

    #[test]
    fn patterns_flicker_the_more_the_smaller_they_are() {
        // Two letters fill the picture; then a pixel holds one pair.
        let (large, small) = (rows(12), rows(400));
        assert!(
            small[0].flicker[0] > 2.0 * large[0].flicker[0],
            "{large:?} {small:?}"
        );
        assert!(
            small[0].error[0] > 2.0 * large[0].error[0],
            "{large:?} {small:?}"
        );
        // Large flat letters hardly flicker with exact coverage.
        assert!(large[0].covered < 0.1 * large[0].flicker[0], "{large:?}");
        // As many pixels as fit into 48 × 36 at this distance, and at least 16.
        let sizes: Vec<[u32; 2]> = large.iter().map(|row| row.size).collect();
        assert_eq!(sizes[..3], [[48, 36], [16, 12], [16, 12]]);
        assert!(
            large
                .iter()
                .all(|row| row.time.iter().all(|time| *time > 0.0))
        );
    }
}
