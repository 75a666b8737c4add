//! Pictures drawn by an oracle.

use glam::DVec3;
use rayon::prelude::*;
use relievo::oracle::{AnalyticOracle, Truth};
use relievo::picture::Picture;
use relievo::prepare::PreparedScene;
use relievo::render::{ColorWords, RenderError};
use relievo::scene::Development;
use relievo_shared::camera::pixel_ray;
use relievo_shared::light::shade;

/// Draws `scene` from the oracle's hits, lit as renderers light it.
pub fn truth_picture(
    oracle: &AnalyticOracle<'_>,
    scene: &PreparedScene,
) -> Result<Picture, RenderError> {
    let frame = scene.frame_with_samples(scene.supersampling);
    let eye = DVec3::from(scene.camera.eye);
    let truth = Truth::of(oracle, eye, &frame);
    let object = &scene.objects[0].parameters;
    let background = scene.background.map(f32::to_bits);
    let mut words = vec![[0; 4]; truth.samples.len()];
    words.par_iter_mut().enumerate().for_each(|(i, word)| {
        let sample = truth.samples[i];
        let [r, g, b] = if sample.is_hit() {
            let (x, y) = (i % truth.width, i / truth.width);
            let direction = pixel_ray(&frame, x as u32, y as u32);
            let normal = oracle.normal(eye, direction.as_dvec3().normalize(), sample);
            shade(
                &frame,
                object,
                sample.class,
                normal.as_vec3(),
                direction,
                true,
            )
            .to_array()
            .map(f32::to_bits)
        } else {
            background
        };
        *word = [r, g, b, sample.class];
    });
    let words = ColorWords {
        width: truth.width as u32,
        height: truth.height as u32,
        words,
    };
    Picture::develop(&words, scene.supersampling, &Development::default())
}
