//! One object: its parameters, its triangles and its prisms.

use super::camera::narrow;
use super::exits::{exit_number, is_fast};
use super::growth::{check_growth, grow};
use super::layers::stack;
use super::placement::Placement;
use super::prepared::PreparedObject;
use super::shells::{MeshShell, Shells};
use super::sources::has_shadows;
use crate::Error;
use crate::mesh::{Mesh, MeshCorner, MeshTriangle, SHALLOWEST, smaller_stretch};
use crate::scene::{Material, Scene, SceneObject};
use crate::shape_map::ShapeMap;
use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::{Corner, Object, SEARCH_EXTRUSION, SEARCH_PRISMS, Triangle};
use std::sync::Arc;

/// Factor on the tolerance of an object whose local depth is reduced. δ varies more in its
/// prisms, and the third order underestimates a ray's error.
const REDUCED_TOLERANCE: f32 = 0.5;

/// What objects of a scene have in common.
pub(super) struct Common<'a> {
    pub scene: &'a Scene,
    /// Point that positions are relative to, in the space of the mesh.
    pub origin: DVec3,
    /// A pixel's width at distance 1, world units.
    pub pixel: f64,
    pub shells: &'a mut Shells,
}

/// Prepares `object`, number `number` of the scene, with the `maps` of its pattern and of its layers.
pub(super) fn prepare_object(
    common: Common<'_>,
    number: usize,
    object: &SceneObject,
    mesh: Arc<Mesh>,
    maps: Vec<Arc<ShapeMap>>,
) -> Result<PreparedObject, Error> {
    let Common {
        scene,
        origin,
        pixel,
        shells,
    } = common;
    let depth = object.depth.unwrap_or(0.04 * mesh.bounds.diagonal());
    // As renderers read it.
    let depth = f64::from(depth as f32);
    let map = &maps[0];
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
        specular: specular as f32,
        tolerance: object.tolerance as f32,
        // Shadow maps are seen from far away, where a slack for the camera is too much.
        slack: if object.slack > 0.0 && !has_shadows(scene) {
            (object.slack * pixel * coarsest_texels(&mesh, object.repeat, map)) as f32
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
        facets: mesh.triangles.len() as u32,
        // The rest is set below.
        ..Object::default()
    };
    grow(&mut parameters, &object.extrusion);
    let patterns = match &maps[..] {
        [map] => {
            check_growth(&mut parameters, &object.shape, map).map(|()| (map.clone(), Vec::new()))
        }
        _ => {
            let texels = depth * coarsest_texels(&mesh, object.repeat, map);
            stack(object, &mesh, &maps, texels, &mut parameters)
        }
    };
    let (map, layers) = patterns.map_err(|problem| Error::Object {
        scene: scene.path.clone(),
        name: object.name.clone(),
        problem,
    })?;
    let is_accurate = parameters.search == SEARCH_PRISMS;
    if is_accurate {
        check_depth(scene, object, &mesh, depth)?;
    }
    let (shell, prisms) = if is_accurate {
        let shell = mesh.shell(depth);
        (Arc::new(MeshShell::new(&shell)), shell.prisms)
    } else {
        (shells.of(&mesh, depth), Vec::new())
    };
    parameters.depth = shell.depth as f32;
    if shell.local_depth.is_some() {
        parameters.tolerance *= REDUCED_TOLERANCE;
    }
    // The paper's tier and relief mapping draw what was published: one depth.
    let has_local_depth = is_accurate || parameters.search == SEARCH_EXTRUSION;
    let flat = FLAT / mesh.bounds.diagonal();
    let is_fast = is_fast(&parameters);
    let triangles = mesh
        .triangles
        .par_iter()
        .enumerate()
        .map(|(index, triangle)| {
            let reductions = shell.reductions.get(index).filter(|_| has_local_depth);
            let reductions = reductions.copied().unwrap_or_default();
            // The fast tier draws the facet where the surface is straight.
            let is_straight = is_fast && shell.straight.get(index).is_some_and(|is| *is);
            let flat = if is_straight { f64::INFINITY } else { flat };
            narrow_triangle(triangle, reductions, origin, object.repeat, flat)
        })
        .collect::<Vec<_>>();
    parameters.number = exit_number(&parameters, &triangles, number);
    let mut prepared = PreparedObject {
        name: object.name.clone(),
        number,
        instance: 0,
        placement: None,
        transform: Placement::default(),
        parameters,
        triangles: Arc::new(triangles),
        depth,
        local_depth: shell.local_depth,
        prisms: Arc::default(),
        map,
        layers: Arc::new(layers),
        map_options: object.map,
        mesh,
    };
    if is_accurate {
        prepared.prisms = Arc::new(prepared.narrow_prisms(&prisms, origin));
    }
    Ok(prepared)
}

/// Returns the texture coordinates of the corners in repeats of the pattern, with v down (OBJ's v
/// goes up), and the whole repeats that renderers leave out.
pub(super) fn repeats(triangle: &MeshTriangle, repeat: [f64; 2]) -> ([[f64; 2]; 3], [f64; 2]) {
    let uv = triangle
        .corners
        .map(|corner| [corner.uv.x * repeat[0], -corner.uv.y * repeat[1]]);
    let whole = [0, 1].map(|i| uv[0][i].min(uv[1][i]).min(uv[2][i]).floor());
    (uv, whole)
}

/// Converts a triangle to the renderers' units: f32, with the `reductions` of the
/// depth at its corners, positions relative to `origin`, texture coordinates as [`repeats`] has them,
/// less the whole ones. Curvatures below `flat` are
/// treated as zero.
fn narrow_triangle(
    triangle: &MeshTriangle,
    depth_reductions: u32,
    origin: DVec3,
    repeat: [f64; 2],
    flat: f64,
) -> Triangle {
    let (uv, whole) = repeats(triangle, repeat);
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
        depth_reductions,
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

/// Checks that `depth` is enough for the accurate tier.
///
/// # Errors
/// [`Error::Object`] if the depth is below [`SHALLOWEST`].
fn check_depth(scene: &Scene, object: &SceneObject, mesh: &Mesh, depth: f64) -> Result<(), Error> {
    let least = SHALLOWEST * mesh.bounds.diagonal();
    if depth >= least {
        return Ok(());
    }
    Err(Error::Object {
        scene: scene.path.clone(),
        name: object.name.clone(),
        problem: format!(
            "the depth {depth:e} is too little for the accurate tier, which follows rays through depths from {least:.2e} on in a mesh of this size: write tier = \"fast\", which is as good there, or more depth"
        ),
    })
}
