//! Draws over a picture of a scene: the polygon mesh, or the local depth.
//!
//! ```
//! use relievo::overlay::draw_mesh;
//! use relievo::picture::Picture;
//! use relievo::prepare::prepare;
//! use relievo::scene::{Color, Scene};
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! image.size = [40, 30]
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let mut picture = Picture { width: 40, height: 30, bytes: vec![255; 3 * 40 * 30] };
//! draw_mesh(&mut picture, &prepared, Color::from_hex(0))?;
//! assert!(picture.bytes.iter().any(|byte| *byte < 255));
//! # Ok::<(), relievo::Error>(())
//! ```

use crate::picture::Picture;
use crate::prepare::{PreparedObject, PreparedScene};
use crate::render::{CpuRenderer, RenderError, Renderer, allocate};
use crate::scene::{Color, Development};
use rayon::prelude::*;
use relievo_shared::camera::pixel_ray;
use relievo_shared::facet::intersect;
use relievo_shared::layout::{Frame, Triangle, vec3};
use relievo_shared::outline::bounding_rectangle;
use relievo_shared::surface::local_depth;
use std::borrow::Cow;

/// Samples per pixel side: edges are two samples wide, so one pixel.
const SAMPLES: u32 = 2;
/// Opacity of edges and colours, 0…1.
const OPACITY: f32 = 0.7;
/// Local depths are coloured from S_z down to S_z / 2^6.
const OCTAVES: f32 = 6.0;
/// Larger shares of S_z are not reduced.
const FULL: f32 = 1.0 - 1e-5;
/// Marks a sample without a facet.
const NO_FACET: u32 = u32::MAX;

/// Draws the visible edges of the scene's flat facets in `color`, one pixel wide:
/// where the nearest front-facing facet differs between neighbouring samples.
///
/// # Errors
/// [`RenderError::Memory`].
///
/// # Panics
/// If `picture` and the scene differ in size.
pub fn draw_mesh(
    picture: &mut Picture,
    scene: &PreparedScene,
    color: Color,
) -> Result<(), RenderError> {
    assert_eq!([picture.width, picture.height], scene.size);
    let frame = scene.frame_with_samples(SAMPLES);
    let width = frame.size[0] as usize;
    let height = frame.size[1] as usize;
    let frames = frames(scene, &frame);
    let facets = nearest_facets(&frame, &facets(scene, &frames))?;
    let is_edge = |x: usize, y: usize| {
        let facet = |x: usize, y: usize| facets[y * width + x];
        let own = facet(x, y);
        (x > 0 && facet(x - 1, y) != own)
            || (x + 1 < width && facet(x + 1, y) != own)
            || (y > 0 && facet(x, y - 1) != own)
            || (y + 1 < height && facet(x, y + 1) != own)
    };

    let samples = SAMPLES as usize;
    let weight = OPACITY / (SAMPLES * SAMPLES) as f32;
    let ink = color.0.map(|channel| 255.0 * channel as f32);
    picture
        .bytes
        .par_chunks_mut(3 * picture.width as usize)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let edges = (0..samples * samples)
                    .filter(|i| is_edge(x * samples + i % samples, y * samples + i / samples))
                    .count();
                let opacity = edges as f32 * weight;
                for (byte, ink) in pixel.iter_mut().zip(ink) {
                    *byte = (f32::from(*byte) * (1.0 - opacity) + ink * opacity).round() as u8;
                }
            }
        });
    Ok(())
}

/// Returns the picture of `scene` in `frame`, drawn by the CPU and coloured where the local
/// depth h is less than the object's depth S_z (docs/object.md): yellow near h = S_z, green
/// at S_z / 8, dark blue at S_z / 64 and below. h is that of the mesh, where the pixel's ray
/// meets it first.
///
/// # Errors
/// [`RenderError::Memory`].
pub fn local_depth_picture(scene: &PreparedScene, frame: &Frame) -> Result<Picture, RenderError> {
    let words = CpuRenderer::new(scene).color(frame)?;
    let mut picture = Picture::develop(&words, 1, &Development::default())?;
    let frames = frames(scene, frame);
    let all = facets(scene, &frames);
    let nearest = nearest_facets(frame, &all)?;
    let width = picture.width as usize;
    let pixels = picture.bytes.par_chunks_exact_mut(3).zip(&nearest);
    pixels.enumerate().for_each(|(i, (pixel, facet))| {
        if *facet == NO_FACET {
            return;
        }
        let Facet {
            triangle,
            frame,
            object,
        } = all[*facet as usize];
        let direction = pixel_ray(frame, (i % width) as u32, (i / width) as u32);
        let hit = intersect(vec3(frame.eye), direction, triangle);
        // h / S_z where the depth of the triangle is not reduced.
        let whole = (f64::from(object.parameters.depth) / object.depth) as f32;
        let share = local_depth(triangle, &hit, whole);
        if share < FULL {
            let ink = heat(1.0 + share.max(f32::MIN_POSITIVE).log2() / OCTAVES);
            for (byte, ink) in pixel.iter_mut().zip(ink) {
                let mixed = f32::from(*byte) * (1.0 - OPACITY) + 255.0 * ink * OPACITY;
                *byte = mixed.round() as u8;
            }
        }
    });
    Ok(picture)
}

/// Returns a colour, 0…1 each, for `x`: dark blue at 0, green at 0.5, yellow at 1.
pub fn heat(x: f32) -> [f32; 3] {
    let stops = [[0.15, 0.05, 0.40], [0.10, 0.60, 0.45], [1.0, 0.90, 0.20]];
    let x = 2.0 * x.clamp(0.0, 1.0);
    let (from, to, part) = if x < 1.0 {
        (stops[0], stops[1], x)
    } else {
        (stops[1], stops[2], x - 1.0)
    };
    std::array::from_fn(|i| from[i] + (to[i] - from[i]) * part)
}

/// A triangle, and the frame in the space of its object.
#[derive(Clone, Copy)]
struct Facet<'a> {
    triangle: &'a Triangle,
    frame: &'a Frame,
    object: &'a PreparedObject,
}

/// Returns `frame` in the space of each object.
fn frames<'a>(scene: &PreparedScene, frame: &'a Frame) -> Vec<Cow<'a, Frame>> {
    let objects = scene.objects.iter();
    objects.map(|object| object.frame(frame)).collect()
}

fn facets<'a>(scene: &'a PreparedScene, frames: &'a [Cow<'_, Frame>]) -> Vec<Facet<'a>> {
    let objects = scene.objects.iter().zip(frames);
    let facets = objects.flat_map(|(object, frame)| {
        object.triangles.iter().map(move |triangle| Facet {
            triangle,
            frame,
            object,
        })
    });
    facets.collect()
}

/// Finds the index of the nearest of `facets` in each pixel of `frame`.
fn nearest_facets(frame: &Frame, facets: &[Facet<'_>]) -> Result<Vec<u32>, RenderError> {
    let [width, height] = frame.size.map(|side| side as usize);
    // First and last column and row of each triangle, from the top left.
    let pixels = |low: f32, high: f32, side: usize| {
        let first = (0.5 * (low + 1.0) * side as f32).floor() as usize;
        let last = (0.5 * (high + 1.0) * side as f32).ceil() as usize;
        first..last.min(side)
    };
    let boxes: Vec<_> = facets
        .iter()
        .map(|facet| {
            let rectangle = bounding_rectangle(facet.frame, facet.triangle);
            (
                pixels(rectangle.low.x, rectangle.high.x, width),
                pixels(-rectangle.high.y, -rectangle.low.y, height),
            )
        })
        .collect();
    let mut found = allocate("the mesh's facets", width * height, NO_FACET)?;
    found
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            let mut nearest = vec![f32::INFINITY; width];
            for (i, (facet, (columns, rows))) in facets.iter().zip(&boxes).enumerate() {
                if !rows.contains(&y) {
                    continue;
                }
                let Facet {
                    triangle, frame, ..
                } = facet;
                for x in columns.clone() {
                    let direction = pixel_ray(frame, x as u32, y as u32);
                    let hit = intersect(vec3(frame.eye), direction, triangle);
                    let t = hit.t * frame.unit;
                    if hit.hit && t > 0.0 && t < nearest[x] {
                        nearest[x] = t;
                        row[x] = i as u32;
                    }
                }
            }
        });
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::prepare;
    use crate::scene::Scene;
    use std::path::Path;

    const SIZE: [u32; 2] = [80, 60];

    /// A scene of one triangle in the plane z = 0, seen from (0, 0, 3) with a
    /// vertical field of view of 90°.
    fn scene(corners: [[f64; 2]; 3]) -> PreparedScene {
        let folder = tempfile::tempdir().unwrap();
        let vertices: String = corners
            .iter()
            .map(|[x, y]| format!("v {x} {y} 0\n"))
            .collect();
        std::fs::write(folder.path().join("triangle.obj"), vertices + "f 1 2 3\n").unwrap();
        let pattern = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/patterns/discs.png");
        std::fs::copy(pattern, folder.path().join("discs.png")).unwrap();
        let text = "image = { size = [80, 60] }\ncamera = { eye = [0.0, 0.0, 3.0], fov = 90.0 }\n[[object]]\nmesh = \"triangle.obj\"\nshape = \"discs.png\"\nprojection = \"planar-z\"\ndepth = 0.1\n";
        let scene = Scene::parse(text, &folder.path().join("scene.toml")).unwrap();
        prepare(&scene, &|_| ()).unwrap()
    }

    fn white() -> Picture {
        Picture {
            width: SIZE[0],
            height: SIZE[1],
            bytes: vec![255; 3 * 80 * 60],
        }
    }

    /// Where a point of the plane z = 0 is in the picture, pixels.
    fn project([x, y]: [f64; 2]) -> [f64; 2] {
        let scale = 30.0 / 3.0;
        [40.0 + scale * x, 30.0 - scale * y]
    }

    fn distance_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
        let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let along = (ap[0] * ab[0] + ap[1] * ab[1]) / (ab[0] * ab[0] + ab[1] * ab[1]);
        let along = along.clamp(0.0, 1.0);
        (ap[0] - along * ab[0]).hypot(ap[1] - along * ab[1])
    }

    #[test]
    fn a_triangle_shows_its_three_edges_and_nothing_else() {
        let corners = [[-2.1, -1.3], [2.3, -1.9], [0.4, 2.2]];
        let mut picture = white();
        draw_mesh(&mut picture, &scene(corners), Color::from_hex(0)).unwrap();
        let [a, b, c] = corners.map(project);
        for (i, pixel) in picture.bytes.chunks_exact(3).enumerate() {
            let centre = [(i % 80) as f64 + 0.5, (i / 80) as f64 + 0.5];
            let distance = [(a, b), (b, c), (c, a)]
                .map(|(from, to)| distance_to_segment(centre, from, to))
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            if distance < 0.3 {
                assert!(pixel[0] < 255, "{centre:?} is on an edge");
            }
            if distance > 1.5 {
                assert_eq!(pixel, [255; 3], "{centre:?} is on no edge");
            }
        }
    }

    #[test]
    fn a_triangle_seen_from_behind_shows_nothing() {
        let mut picture = white();
        let behind = scene([[-2.1, -1.3], [0.4, 2.2], [2.3, -1.9]]);
        draw_mesh(&mut picture, &behind, Color::from_hex(0)).unwrap();
        assert_eq!(picture, white());
    }
}
