//! Finds the known surface that a mesh approximates.

use super::analytic::AnalyticOracle;
use super::flat::{Cylinder, Plane};
use super::shape::Shape;
use super::{Ellipsoid, Saddle, Sphere, Torus};
use crate::mesh::Mesh;
use crate::prepare::{Placement, PreparedObject};
use crate::scene::SceneObject;
use glam::{DVec2, DVec3};

/// The surfaces of the meshes in `assets/meshes`.
pub const KNOWN: [&dyn Shape; 6] = [
    &Torus {
        major: 1.0,
        minor: 0.4,
    },
    &Sphere { radius: 1.0 },
    &Cylinder {
        radius: 1.0,
        height: 3.0,
    },
    &Plane { side: 2.0 },
    &Ellipsoid {
        axes: DVec3::new(1.2, 0.8, 1.0),
    },
    &Saddle {
        side: 2.0,
        rise: 0.3,
    },
];

/// Maximum distance of a vertex from its surface, as a share of the shape's
/// radius, and of its texture coordinates from the closed form.
const TOLERANCE: f64 = 1e-4;

/// Reason why an object has no analytic oracle.
#[derive(Debug, thiserror::Error)]
pub enum UnknownShape {
    /// The mesh approximates no known surface.
    #[error(
        "the mesh of object {object:?} lies on no surface of a known closed form with its texture coordinates; the known ones are those of assets/meshes: {}",
        names()
    )]
    Mesh {
        /// The object.
        object: String,
    },
    /// The pattern does not repeat a whole number of times around a closed surface.
    #[error(
        "object {object:?} repeats its pattern {repeat} times around a closed {shape}; only whole numbers join up, so make repeat one"
    )]
    Repeat {
        /// The object.
        object: String,
        /// The shape.
        shape: &'static str,
        /// Number of repeats.
        repeat: f64,
    },
    /// The depth reaches the point where normals meet.
    #[error(
        "object {object:?} is carved {depth} deep, but a {shape} of this size has room for less than {largest}, and parts of this mesh for less; make depth smaller"
    )]
    Depth {
        /// The object.
        object: String,
        /// The shape.
        shape: &'static str,
        /// Depth S_z, world units.
        depth: f64,
        /// Depth at which normals meet, world units.
        largest: f64,
    },
}

fn names() -> String {
    KNOWN
        .map(|shape| format!("{}.obj", shape.name()))
        .join(", ")
}

impl AnalyticOracle<'_> {
    /// Makes the oracle of a scene's object if its mesh approximates one of
    /// [`KNOWN`]: every vertex lies on the surface with the texture coordinates of
    /// the closed form, and the triangles cover it.
    ///
    /// # Errors
    /// [`UnknownShape`], also for a pattern or a depth that does not fit the surface.
    pub fn find<'a>(
        object: &SceneObject,
        prepared: &'a PreparedObject,
    ) -> Result<AnalyticOracle<'a>, UnknownShape> {
        // A mesh that is placed is scaled only.
        let of_mesh = match prepared.placement {
            None => prepared.transform,
            Some(_) => Placement {
                scale: object.scale,
                ..Placement::default()
            },
        };
        let name = || object.name.clone();
        let shape = KNOWN
            .into_iter()
            .find(|shape| fits(*shape, &prepared.mesh, &of_mesh))
            .ok_or_else(|| UnknownShape::Mesh { object: name() })?;
        for (closed, repeat) in shape.closed().into_iter().zip(object.repeat) {
            if closed && repeat.fract() != 0.0 {
                return Err(UnknownShape::Repeat {
                    object: name(),
                    shape: shape.name(),
                    repeat,
                });
            }
        }
        let oracle = AnalyticOracle::new(shape, object, prepared);
        let largest = shape.largest_depth() * of_mesh.scale;
        // The closed forms have one depth.
        if prepared.depth >= largest || prepared.reduces_depth() {
            return Err(UnknownShape::Depth {
                object: name(),
                shape: shape.name(),
                depth: prepared.depth,
                largest,
            });
        }
        Ok(oracle)
    }
}

/// Returns whether `mesh` approximates the whole of `shape`, seen from the same
/// side.
pub(super) fn fits(shape: &dyn Shape, mesh: &Mesh, placement: &Placement) -> bool {
    let corners = mesh.triangles.iter().flat_map(|triangle| &triangle.corners);
    let on_surface = corners.into_iter().all(|corner| {
        let p = placement.to_object(corner.position);
        let tolerance = TOLERANCE * shape.radius();
        let foot = shape.foot(p);
        let below = p - placement.direction_to_object(corner.normal) * tolerance;
        foot.depth.abs() <= tolerance
            && foot.beyond <= tolerance
            && shape.foot(below).depth > foot.depth
            && same_texture(shape, p, foot.uv, corner.uv)
    });
    // Triangles at the poles of a sphere cover half of their texture.
    let covered: f64 = mesh
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.corners.map(|corner| corner.uv);
            0.5 * (b - a).perp_dot(c - a).abs()
        })
        .sum();
    on_surface && (0.85..1.001).contains(&covered)
}

/// Returns whether `uv` are the texture coordinates at `p`, up to whole turns of
/// closed ones; at a pole any u is accepted.
pub(super) fn same_texture(shape: &dyn Shape, p: DVec3, expected: DVec2, uv: DVec2) -> bool {
    let lengths = shape.metric(p, 0.0).lengths;
    let apart = uv - expected;
    (0..2).all(|axis| {
        let off = if shape.closed()[axis] {
            apart[axis] - apart[axis].round()
        } else {
            apart[axis]
        };
        off.abs() <= TOLERANCE || lengths[axis] <= TOLERANCE
    })
}
