//! Pictures that an oracle draws.

use crate::oracle::{Sample, TorusOracle, Truth, Verdict};
use crate::picture::Picture;
use crate::prepare::PreparedScene;
use crate::render::{ColorWords, GeometryWords, RenderError, allocate};
use crate::scene::Color;
use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::camera::pixel_ray;
use relievo_shared::light::shade;
use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_MISS};

/// What the oracle sees of `scene`, lit as a renderer lights it.
pub fn truth_picture(
    oracle: &TorusOracle<'_>,
    scene: &PreparedScene,
) -> Result<Picture, RenderError> {
    let frame = scene.frame_with_samples(scene.supersampling);
    let eye = DVec3::from(scene.camera.eye);
    let truth = oracle.truth(eye, &frame);
    let object = &scene.objects[0].parameters;
    let background = scene.background.map(f32::to_bits);
    let mut words = allocate("the picture", truth.samples.len(), [0; 4])?;
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
    Picture::develop(&words, scene.supersampling)
}

/// Where `words` differ from the truth: holes red, what is too much blue,
/// another class yellow, and what is right in greys by class.
pub fn error_picture(truth: &Truth, words: &GeometryWords) -> Picture {
    let bytes = truth
        .verdicts(words)
        .into_iter()
        .zip(&truth.samples)
        .flat_map(|(verdict, sample)| color_of(verdict, *sample).0)
        .map(|channel| (255.0 * channel).round() as u8)
        .collect();
    Picture {
        width: words.width,
        height: words.height,
        bytes,
    }
}

fn color_of(verdict: Verdict, sample: Sample) -> Color {
    Color::from_hex(match verdict {
        Verdict::Hole => 0xd4_1f26,
        Verdict::Extra => 0x1f_5fd4,
        Verdict::OtherClass => 0xf0_b400,
        Verdict::Nothing | Verdict::Same => match sample.class {
            CLASS_MISS => 0xff_ffff,
            CLASS_CAP => 0xd6_d9dd,
            CLASS_FLOOR => 0x9a_a1a9,
            _ => 0xb8_bdc4,
        },
    })
}
