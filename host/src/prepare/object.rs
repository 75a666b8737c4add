//! One object: its parameters, its triangles and its prisms.

use super::camera::narrow;
use super::prepared::PreparedObject;
use crate::Error;
use crate::mesh::{Mesh, MeshCorner, MeshTriangle, smaller_stretch};
use crate::prism::folded;
use crate::scene::{Material, Scene, SceneObject, Shape};
use crate::shape_map::{ShapeMap, Storage};
use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::{Corner, Object, Triangle};
use relievo_shared::profile::{Profile, know_upright};
use std::sync::Arc;

/// Prepares `object`, number `number` of `scene`; `origin` is the scene's, and
/// `pixel` is a pixel's width at distance 1, both in world units.
pub(super) fn prepare_object(
    scene: &Scene,
    number: usize,
    object: &SceneObject,
    mesh: Arc<Mesh>,
    map: Arc<ShapeMap>,
    origin: DVec3,
    pixel: f64,
) -> Result<PreparedObject, Error> {
    let depth = object.depth.unwrap_or(0.04 * mesh.bounds.diagonal());
    let extrusion = object.extrusion;
    let Material {
        cap,
        wall,
        bevel,
        floor,
        specular,
        shininess,
    } = object.material;
    let mut parameters = Object {
        map_size: [map.width() as f32, map.height() as f32],
        map_step: map.step(),
        depth: depth as f32,
        extension: extrusion.extension as f32,
        bevel: extrusion.bevel as f32,
        chamfer: extrusion.chamfer as f32,
        specular: specular as f32,
        tolerance: object.tolerance as f32,
        slack: if object.slack > 0.0 {
            (object.slack * pixel * coarsest_texels(&mesh, object.repeat, &map)) as f32
        } else {
            0.0
        },
        cap_color: cap.linear(),
        wall_color: wall.linear(),
        bevel_color: bevel.linear(),
        floor_color: floor.linear(),
        shininess,
        tier: object.tier.code(),
        cut_out: u32::from(object.cut_out),
        linear_steps: object.steps,
        binary_steps: object.bisections,
        map_bias: map.bias(),
        map_packing: map.storage().texels_per_word().trailing_zeros(),
        map_quantum: map.quantum(),
        map_reach: gradient_reach(map.width(), map.height()),
        map_format: map.storage().shader_format(),
        search: object.search_code(),
        self_shadow: u32::from(object.self_shadow),
        profile: extrusion.profile,
        parts: extrusion.parts,
    };
    check_growth(&mut parameters, &object.shape, &map).map_err(|problem| Error::Object {
        scene: scene.path.clone(),
        name: object.name.clone(),
        problem,
    })?;
    let flat = FLAT / mesh.bounds.diagonal();
    let triangles = mesh
        .triangles
        .par_iter()
        .map(|triangle| narrow_triangle(triangle, origin, object.repeat, flat))
        .collect();
    let mut prepared = PreparedObject {
        name: object.name.clone(),
        number,
        parameters,
        triangles,
        prisms: Vec::new(),
        map,
        map_options: object.map,
        mesh,
    };
    if prepared.has_prisms() {
        make_prisms(scene, object, &mut prepared, origin)?;
    }
    Ok(prepared)
}

/// Converts a triangle to the renderers' units: f32, positions relative to
/// `origin`, texture coordinates in repeats of the pattern with v down (OBJ's v
/// goes up), less a whole number of repeats. Curvatures below `flat` are
/// treated as zero.
fn narrow_triangle(
    triangle: &MeshTriangle,
    origin: DVec3,
    repeat: [f64; 2],
    flat: f64,
) -> Triangle {
    let uv = triangle
        .corners
        .map(|corner| [corner.uv.x * repeat[0], -corner.uv.y * repeat[1]]);
    let whole = [0, 1].map(|i| uv[0][i].min(uv[1][i]).min(uv[2][i]).floor());
    let mut corners = [Corner::default(); 3];
    for (i, (narrowed, corner)) in corners.iter_mut().zip(&triangle.corners).enumerate() {
        *narrowed = Corner {
            position: narrow(corner.position - origin),
            normal: narrow(corner.normal),
            tangent: narrow(corner.tangent),
            uv: [0, 1].map(|axis| (uv[i][axis] - whole[axis]) as f32),
            quadric: [corner.quadric.xx, corner.quadric.xy, corner.quadric.yy]
                .map(|q| if q.abs() < flat { 0.0 } else { q as f32 }),
            gradient_u: narrow(corner.gradient_u * repeat[0]),
            gradient_v: narrow(corner.gradient_v * -repeat[1]),
        };
    }
    Triangle {
        corners,
        handedness: triangle.corners[0].handedness as f32,
    }
}

/// Curvatures below this, times the mesh's size, are rounding errors of a
/// rotated flat mesh; their squares would be denormal.
const FLAT: f64 = 1e-14;

/// Share of the surface that [`coarsest_texels`] leaves out.
const COARSER: f64 = 0.02;

/// Returns the lowest texel density (texels per object unit, along the direction
/// of the lowest density) of the surface, leaving out [`COARSER`] of it.
fn coarsest_texels(mesh: &Mesh, repeat: [f64; 2], map: &ShapeMap) -> f64 {
    let size = [map.width(), map.height()].map(f64::from);
    let mut densities: Vec<(f64, f64)> = mesh
        .triangles
        .par_iter()
        .map(|triangle| {
            let [a, b, c] = triangle.corners.map(|corner| corner.position);
            let area = (b - a).cross(c - a).length();
            let mean = |gradient: fn(&MeshCorner) -> DVec3| {
                triangle.corners.iter().map(gradient).sum::<DVec3>() / 3.0
            };
            let u = mean(|corner| corner.gradient_u) * (repeat[0] * size[0]);
            let v = mean(|corner| corner.gradient_v) * (repeat[1] * size[1]);
            (smaller_stretch(u, v), area)
        })
        .collect();
    densities.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = COARSER * densities.iter().map(|(_, area)| area).sum::<f64>();
    let reached = densities.iter().find(|(_, area)| {
        left -= area;
        left < 0.0
    });
    reached.map_or(0.0, |(density, _)| *density)
}

/// Returns half the span of the differences of the map's gradient, texels: a
/// power of two, about 1/128 of the map, which smooths the staircase outline of
/// a binary pattern, and at most a quarter of the narrowest side.
fn gradient_reach(width: u32, height: u32) -> f32 {
    let (shorter, longer) = (width.min(height), width.max(height));
    let reach = (shorter / 128).clamp(1, 32);
    let reach = (1u32 << reach.ilog2()) as f32;
    // A side of one texel has no slope, whatever the reach.
    let narrowest = if shorter > 1 { shorter } else { longer };
    reach.min(0.25 * narrowest as f32)
}

/// Checks that the distances that `map` stores suffice for the profile of `object`, and
/// removes the growth of an empty pattern.
///
/// # Errors
/// A text that says what is too large and how to change it.
fn check_growth(object: &mut Object, shape: &Shape, map: &ShapeMap) -> Result<(), String> {
    let width = f64::from(map.width());
    let profile = Profile::new(object);
    let [smallest, largest] = [profile.radius(0.0), profile.largest_radius()].map(f64::from);
    // Upper bound of the distance to the pattern in a map that repeats.
    let furthest = 0.5 * width.hypot(f64::from(map.height()));
    if largest >= furthest {
        // The pattern covers everything, unless it is empty.
        let is_empty = (0..map.height())
            .into_par_iter()
            .all(|y| (0..map.width()).all(|x| map.decode(x, y) > 0.0));
        if is_empty {
            object.extension = 0.0;
            know_upright(object);
        }
        return Ok(());
    }
    let better = format!("bake the map with --format {}", map.storage().larger());
    if map.saturated() && largest >= f64::from(map.max_distance()) {
        return Err(format!(
            "the pattern grows by e + b·c = {:.4} widths, but {} holds distances up to {:.4} widths only; make extension or bevel smaller, or {better}",
            largest / width,
            shape,
            f64::from(map.max_distance()) / width,
        ));
    }
    let has_bottom = map.saturated() || map.storage() == Storage::Rgba8;
    if has_bottom && smallest <= f64::from(map.min_distance()) {
        return Err(format!(
            "the pattern shrinks by {:.4} widths, but {} holds distances down to {:.4} widths inside it only; make extension larger, or {better}",
            -smallest / width,
            shape,
            f64::from(map.min_distance()) / width,
        ));
    }
    Ok(())
}

/// Maximum number of triangles named in an error.
const NAMED: usize = 3;

/// A clamped depth is this share of the largest valid depth.
const CLAMPED: f64 = 0.95;

/// Minimum depth of a shell as a share of the mesh's diagonal. Below it the
/// rounding of δ shows, and rays get lost.
const SHALLOWEST: f64 = 3e-5;

/// Makes the prisms of `prepared`, clamping its depth if the scene allows it.
///
/// # Errors
/// [`Error::Object`] if the surface bends too much for the depth, or if the depth
/// is below [`SHALLOWEST`].
fn make_prisms(
    scene: &Scene,
    object: &SceneObject,
    prepared: &mut PreparedObject,
    origin: DVec3,
) -> Result<(), Error> {
    let prisms = prepared.mesh.prisms();
    let depth = f64::from(prepared.parameters.depth);
    if let Some(folded) = folded(&prisms, depth) {
        let clamped = CLAMPED * folded.largest_depth;
        if !object.clamp_depth || clamped <= 0.0 {
            let triangles = &prepared.mesh.triangles;
            let named = folded.triangles.iter().take(NAMED).map(|&index| {
                let [a, b, c] = triangles[index].corners.map(|corner| corner.position);
                let [x, y, z] = ((a + b + c) / 3.0).to_array();
                format!("number {} at ({x:.4}, {y:.4}, {z:.4})", index + 1)
            });
            let named: Vec<String> = named.collect();
            let more = if folded.triangles.len() > NAMED {
                ", …"
            } else {
                ""
            };
            let way_out = if clamped > 0.0 {
                format!(
                    "the largest depth that works is {:.6}: write a smaller depth, or clamp_depth = true, or tier = \"fast\"",
                    folded.largest_depth
                )
            } else {
                "no depth works there: repair the mesh, or write tier = \"fast\"".to_string()
            };
            return Err(Error::Object {
                scene: scene.path.clone(),
                name: object.name.clone(),
                problem: format!(
                    "the surface bends too much for the depth {depth:.6} of the accurate tier in {} of {} triangles ({}{more}); {way_out}",
                    folded.triangles.len(),
                    prisms.len(),
                    named.join(", "),
                ),
            });
        }
        tracing::warn!(
            "object {:?}: depth {depth:.6} is clamped to {clamped:.6}, since the surface bends too much in {} of {} triangles",
            object.name,
            folded.triangles.len(),
            prisms.len(),
        );
        prepared.parameters.depth = clamped as f32;
    }
    let (depth, least) = (
        f64::from(prepared.parameters.depth),
        SHALLOWEST * prepared.mesh.bounds.diagonal(),
    );
    if depth < least {
        return Err(Error::Object {
            scene: scene.path.clone(),
            name: object.name.clone(),
            problem: format!(
                "the depth {depth:e} is too little for the accurate tier, which follows rays through depths from {least:.2e} on in a mesh of this size: write tier = \"fast\", which is as good there, or more depth"
            ),
        });
    }
    prepared.prisms = prepared.narrow_prisms(&prisms, origin);
    Ok(())
}
