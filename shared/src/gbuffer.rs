//! The G-buffer: what a pixel hits, as eight words, from which [`shading`](crate::shading)
//! computes its colour when all objects are drawn.
//!
//! ```text
//! place    t  u  v  δ (16 bits), world units per object unit (15 bits), flag of the edge
//! surface  class, flags, finish, edge, openness  normal  tangent  facet, edge
//! ```
//!
//! Normal and tangent are unit vectors in world axes, in octahedral form. The tangent is the
//! direction of growing u on caps and floors, and runs along the outline on walls and bevels.
//!
//! Only objects with the flag [`KNOWS_EDGES`] have [edges](edge). Hits with the flag [`KNOWS_MESH`]
//! know the frame of the mesh's surface, too: walls and bevels then have the mesh's normal in
//! place of the tangent, from which the tangent follows; and 6 of the bits of δ are the direction of
//! growing u.

use crate::arithmetic::{abs, clamp, div, kept, kept3, max, normalize_or, sqrt};
use crate::edge::{self, Edge, from_turn, turn_of};
use crate::far::is_far;
use crate::intersection::{SurfaceAt, surface_at};
use crate::layers;
use crate::layout::vec3;
use crate::model::{Model, Normals, Place, Ray, Traced};
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_MISS, CLASS_WALL};
use crate::openness::openness;
use crate::shape_map::{ShapeMap, Texels};
use crate::tangent::FLAT;
use crate::trace::word;
use crate::{Real, Vec2, Vec3};
use glam::UVec4;

/// Steps of a coordinate in octahedral form, and of δ.
const STEPS: Real = 65_535.0;
/// Steps of δ where hits know the mesh, and the place of the direction beside it.
const DEPTH_STEPS: Real = 1_023.0;
const TURN: u32 = 10;
/// Bits of the class.
const CLASS: u32 = 7;
/// The bitangent runs against growing v, or against the depth. On walls and bevels that know the
/// mesh: the normal of the mesh × the direction of growing u runs against growing v.
const MIRRORED: u32 = 1 << 3;
/// The outline of a side runs along v rather than along u.
const ALONG_V: u32 = 1 << 4;
/// The hit on a cap is [far](crate::far).
const IS_FAR: u32 = ALONG_V;
/// Place and number of the bits of the finish.
const FINISH: (u32, u32) = (5, 0xfff);
/// Place of the distance of the edge.
const EDGE: u32 = 17;
/// Place of its direction, beside the facet.
const EDGE_DIRECTION: u32 = 26;
/// The distance is that to the foot of a side. In the place of the sign of world units per object unit.
const TO_FOOT: u32 = 1 << 31;
/// Place and steps of the openness.
const OPENNESS: (u32, Real) = (24, 255.0);
/// One step of it.
const OPENNESS_STEP: Real = 1.0 / 255.0;
/// The upper bits of an f32.
const UPPER: u32 = 0xffff_0000;

/// Largest number of finishes in a scene.
pub const MOST_FINISHES: u32 = FINISH.1 + 1;
/// Flag of [`Object::finish`](crate::layout::Object::finish): hits know their edges.
pub const KNOWS_EDGES: u32 = 1 << 31;
/// Flag of it: hits know the mesh's surface. All objects of a scene with smooth edges have it.
pub const KNOWS_MESH: u32 = 1 << 30;
/// Largest number of facets of an object.
pub const MOST_FACETS: u32 = 1 << EDGE_DIRECTION;

/// What a pixel hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Surface class, one of the `CLASS_` constants; the rest is meaningless for a miss.
    pub class: u32,
    /// Distance from the eye, world units.
    pub t: Real,
    /// Texture coordinates, repeats of the pattern, without the whole ones of the facet.
    pub uv: Vec2,
    /// δ, 0…1.
    pub depth_fraction: Real,
    /// World units per object unit, rounded down to 8 bits.
    pub unit: Real,
    /// Unit normal of the carved surface, world axes.
    pub normal: Vec3,
    /// Unit tangent, world axes.
    pub tangent: Vec3,
    /// Whether normal × tangent points against growing v, or out of the depth.
    pub is_mirrored: bool,
    /// Whether the outline at a wall or a bevel runs along v rather than along u; meaningless elsewhere.
    pub is_along_v: bool,
    /// Index of the finish.
    pub finish: u32,
    /// Index of the facet among those of its object.
    pub facet: u32,
    /// Where the surface ends on the picture.
    pub edge: Edge,
    /// Share of the light from all directions that arrives, 0…1.
    pub openness: Real,
}

/// The frame of the mesh's surface at a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshFrame {
    /// Unit normal, world axes.
    pub normal: Vec3,
    /// Unit direction of growing u.
    pub along_u: Vec3,
    /// Whether normal × `along_u` points against growing v.
    pub is_mirrored: bool,
}

impl MeshFrame {
    /// Returns that of the words of [`words`] of a hit that knows the mesh.
    #[inline(always)]
    pub fn from_words(place: UVec4, surface: UVec4) -> MeshFrame {
        let is_side = is_side(surface.x & CLASS);
        let normal = from_octahedral(if is_side { surface.z } else { surface.y });
        MeshFrame {
            normal,
            along_u: if is_side {
                along_turn(normal, (place.w & !UPPER) >> TURN)
            } else {
                from_octahedral(surface.z)
            },
            is_mirrored: surface.x & MIRRORED != 0,
        }
    }

    /// Returns the unit direction across `along_u`, towards growing v.
    #[inline]
    pub fn along_v(&self) -> Vec3 {
        let across = self.normal.cross(self.along_u);
        if self.is_mirrored { -across } else { across }
    }
}

/// Returns two unit vectors across the unit vector `n` and across each other.
#[inline]
fn across(n: Vec3) -> [Vec3; 2] {
    let axis = if abs(n.x) < 0.5 { Vec3::X } else { Vec3::Y };
    let first = normalize_or(kept3(n.cross(axis)), Vec3::Z);
    [first, n.cross(first)]
}

/// Returns the code of the direction `along` across the unit vector of octahedral form `normal`.
#[inline]
fn turn_on(normal: u32, along: Vec3) -> u32 {
    // Relative to vectors that are found again.
    let [first, second] = across(from_octahedral(normal));
    turn_of(Vec2::new(kept(along.dot(first)), kept(along.dot(second))))
}

/// Returns the unit vector of a code of [`turn_on`], across the unit vector `normal`.
#[inline]
fn along_turn(normal: Vec3, code: u32) -> Vec3 {
    let [first, second] = across(normal);
    let turn = from_turn(code);
    first * turn.x + second * turn.y
}

/// Returns whether `class` is that of a wall or a bevel.
#[inline]
pub fn is_side(class: u32) -> bool {
    class == CLASS_WALL || class == CLASS_BEVEL
}

/// Returns the unit vector `n` in octahedral form: 16 bits for each of two coordinates.
#[inline]
pub fn octahedral(n: Vec3) -> u32 {
    let n = kept3(n);
    let scale = div(1.0, max(abs(n.x) + abs(n.y) + abs(n.z), 1e-6));
    let at = octahedral_fold(n.x * scale, n.y * scale, n.z);
    let code = |x: Real| (clamp(x * 0.5 + 0.5, 0.0, 1.0) * STEPS + 0.5) as u32;
    code(at.x) | code(at.y) << 16
}

/// Returns the place in the square −1…1 of a point of the octahedron |x| + |y| + |z| = 1.
#[inline]
pub fn octahedral_fold(x: Real, y: Real, z: Real) -> Vec2 {
    if z < 0.0 {
        let sign = |x: Real| if x < 0.0 { -1.0 } else { 1.0 };
        Vec2::new((1.0 - abs(y)) * sign(x), (1.0 - abs(x)) * sign(y))
    } else {
        Vec2::new(x, y)
    }
}

/// Returns the unit vector of [`octahedral`] form.
#[inline]
pub fn from_octahedral(code: u32) -> Vec3 {
    const STEP: Real = 2.0 / 65_535.0;
    let x = (code & 0xffff) as i32 as Real * STEP - 1.0;
    let y = (code >> 16) as i32 as Real * STEP - 1.0;
    let z = 1.0 - abs(x) - abs(y);
    let folded = octahedral_fold(x, y, z);
    normalize_or(Vec3::new(folded.x, folded.y, z), Vec3::Z)
}

/// Returns whether the surface words are those of a miss.
#[inline]
pub fn is_miss(surface: UVec4) -> bool {
    surface.x & CLASS == CLASS_MISS
}

/// Returns whether the hit of the surface words is so [far](crate::far) that only the mean of its pattern is seen.
#[inline]
pub fn is_mean_only(surface: UVec4) -> bool {
    surface.x & (CLASS | IS_FAR) == CLASS_CAP | IS_FAR
}

/// Returns whether the hit of the surface words has no edge near it.
#[inline]
pub fn is_far_from_edge(surface: UVec4) -> bool {
    surface.x >> EDGE & edge::FAR_AWAY == edge::FAR_AWAY
}

/// Returns whether the hits of the surface words are as far from their edges, and have the same class and finish.
#[inline]
pub fn is_same_part(surface: UVec4, other: UVec4) -> bool {
    const PART: u32 = CLASS | FINISH.1 << FINISH.0 | edge::FAR_AWAY << EDGE;
    (surface.x ^ other.x) & PART == 0
}

/// Returns no less than the length of the difference between two unit vectors in octahedral form.
#[inline]
pub fn largest_turn(code: u32, other: u32) -> Real {
    // Of 3 per unit of the square: √3 on the octahedron, whose points are 1/√3 or more from its middle.
    const STEP: Real = 6.0 / 65_535.0;
    let step = |a: u32, b: u32| abs((a & 0xffff) as i32 as Real - (b & 0xffff) as i32 as Real);
    (step(code, other) + step(code >> 16, other >> 16)) * STEP
}

/// A picture of hits. Its functions are always inlined: what a caller does not use is not decoded.
pub trait Hits {
    /// Returns the words of pixel (`x`, `y`), which is in the picture: place and surface.
    fn words(&self, x: u32, y: u32) -> (UVec4, UVec4);

    /// Returns what pixel (`x`, `y`) hits; where hits know the mesh, without δ, and on sides without the
    /// tangent.
    #[inline(always)]
    fn sample(&self, x: u32, y: u32) -> Sample {
        let (place, surface) = self.words(x, y);
        Sample::from_words(place, surface)
    }

    /// Returns the mesh where pixel (`x`, `y`) hits something, if hits know it ([`KNOWS_MESH`]).
    #[inline(always)]
    fn mesh(&self, x: u32, y: u32) -> MeshFrame {
        let (place, surface) = self.words(x, y);
        MeshFrame::from_words(place, surface)
    }

    /// Returns what pixel (`x`, `y`) hits, where hits know the mesh.
    #[inline(always)]
    fn sample_on_mesh(&self, x: u32, y: u32) -> Sample {
        let (place, surface) = self.words(x, y);
        Sample::on_mesh(place, surface)
    }
}

/// Returns the words of a hit: place and surface; `drawn` is the facet that was drawn.
#[inline]
pub fn words<M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
    traced: &Traced<M::Place>,
    drawn: u32,
) -> (UVec4, UVec4) {
    let Ray { frame, object, .. } = *ray;
    let hit = &traced.hit;
    let SurfaceAt {
        normals,
        gradients,
        frame: tangent_frame,
    } = surface_at::<M, _, _>(ray, over, texels, entry, traced);
    let [x, y, z] = frame.axes;
    let in_world = |v: Vec3| vec3(x) * v.x + vec3(y) * v.y + vec3(z) * v.z;
    let flag = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
    let along_u = kept3(gradients.0);
    let is_far = hit.class == CLASS_CAP && is_far::<M, Over>(ray, hit.t);
    let knows_edges = object.finish & KNOWS_EDGES != 0 && !is_far;
    let density = sqrt(along_u.dot(along_u));
    let (mut distance, mut gradient) = (0.0, Vec2::ZERO);
    let open;
    let mut seen = *hit;
    let mut up = normals.smooth;
    if T::IS_STACK {
        let around = layers::around(object, texels, hit, density);
        distance = around.distance;
        gradient = around.gradient;
        open = around.openness;
        seen = around.hit;
        up = normals.smooth * around.up;
    } else {
        if knows_edges || hit.class != CLASS_CAP {
            let map = ShapeMap::new(object);
            distance = map.distance(texels, hit.uv);
            gradient = map.gradient(texels, hit.uv);
        }
        let map = ShapeMap::new(object);
        open = openness(object, &map, texels, hit, distance, gradient, density);
    }
    let (edge_distance, edge_direction, is_to_foot) = if knows_edges {
        let slopes = [gradients.0, gradients.1];
        let normals = Normals {
            smooth: up,
            ..normals
        };
        edge::codes(ray, &seen, &normals, distance, gradient, slopes)
    } else {
        (edge::FAR_AWAY, 0, false)
    };
    let knows_mesh = object.finish & KNOWS_MESH != 0;
    let depth_steps = if knows_mesh { DEPTH_STEPS } else { STEPS };
    let mut depth = (clamp(hit.depth_fraction, 0.0, 1.0) * depth_steps + 0.5) as u32;
    let mut is_mirrored = tangent_frame.is_mirrored;
    let mut tangent = octahedral(in_world(tangent_frame.tangent));
    if knows_mesh && is_side(hit.class) {
        let smooth = normals.smooth;
        tangent = octahedral(in_world(smooth));
        depth |= turn_on(tangent, in_world(along_u)) << TURN;
        let along_v = kept3(gradients.1);
        is_mirrored = kept(smooth.cross(kept3(gradients.0)).dot(along_v)) < 0.0;
    }
    let uv = hit.uv + hit.repeat;
    let place = UVec4::new(
        word(hit.t * frame.unit),
        word(uv.x),
        word(uv.y),
        depth | (word(frame.unit) & UPPER) | flag(is_to_foot, TO_FOOT),
    );
    let finish = if T::IS_STACK {
        object.finish + layers::finish(object, texels, hit)
    } else {
        object.finish
    };
    let surface = UVec4::new(
        hit.class
            | flag(is_mirrored, MIRRORED)
            | flag(tangent_frame.is_along_v, ALONG_V)
            | flag(is_far, IS_FAR)
            | (finish & FINISH.1) << FINISH.0
            | edge_distance << EDGE
            | ((clamp(open, 0.0, 1.0) * OPENNESS.1 + 0.5) as u32) << OPENNESS.0,
        octahedral(in_world(normals.carved)),
        tangent,
        traced.place.facet(drawn) | edge_direction << EDGE_DIRECTION,
    );
    (place, surface)
}

impl Sample {
    /// Returns the hit of the words of [`words`]; zeros are a miss.
    #[inline(always)]
    pub fn from_words(place: UVec4, surface: UVec4) -> Sample {
        const DEPTH_STEP: Real = 1.0 / 65_535.0;
        let bits = surface.x;
        let normal = from_octahedral(surface.y);
        let tangent = from_octahedral(surface.z);
        let is_mirrored = bits & MIRRORED != 0;
        Sample {
            class: bits & CLASS,
            t: f32::from_bits(place.x),
            uv: Vec2::new(f32::from_bits(place.y), f32::from_bits(place.z)),
            depth_fraction: (place.w & !UPPER) as i32 as Real * DEPTH_STEP,
            unit: f32::from_bits(place.w & UPPER & !TO_FOOT),
            normal,
            tangent,
            is_mirrored,
            is_along_v: bits & ALONG_V != 0,
            finish: (bits >> FINISH.0) & FINISH.1,
            facet: surface.w & (MOST_FACETS - 1),
            edge: Edge::from_codes((bits >> EDGE) & edge::FAR_AWAY, surface.w >> EDGE_DIRECTION),
            openness: (bits >> OPENNESS.0) as i32 as Real * OPENNESS_STEP,
        }
    }

    /// Returns the hit of the words of [`words`], which knows the mesh, but for the tangent and what
    /// is mirrored of a side.
    #[inline(always)]
    pub fn at_depth_on_mesh(place: UVec4, surface: UVec4) -> Sample {
        const DEPTH_STEP: Real = 1.0 / 1_023.0;
        let depth = place.w & ((1 << TURN) - 1);
        let depth_fraction = depth as i32 as Real * DEPTH_STEP;
        let mut sample = Sample {
            depth_fraction,
            ..Sample::from_words(place, surface)
        };
        if place.w & TO_FOOT != 0 {
            sample.edge = sample.edge.from_foot(depth_fraction, 0.5 * DEPTH_STEP);
        }
        sample
    }

    /// Returns the hit of the words of [`words`], which knows the mesh; zeros are a miss.
    #[inline(always)]
    pub fn on_mesh(place: UVec4, surface: UVec4) -> Sample {
        let found = Sample::at_depth_on_mesh(place, surface);
        if is_side(found.class) {
            // The normal of the mesh is in place of the tangent.
            let mesh = MeshFrame::from_words(place, surface);
            let outline = kept3(mesh.normal.cross(found.normal));
            if outline.dot(outline) > FLAT {
                let outline = normalize_or(outline, mesh.along_u);
                found.along_outline(&mesh, outline, found.is_along_v)
            } else {
                Sample {
                    tangent: mesh.along_u,
                    is_mirrored: mesh.is_mirrored,
                    ..found
                }
            }
        } else {
            found
        }
    }

    /// Returns it as a side of a carving of `mesh`, along whose outline the unit vector `outline`
    /// runs: along v rather than along u if `is_along_v`.
    #[inline]
    pub fn along_outline(&self, mesh: &MeshFrame, outline: Vec3, is_along_v: bool) -> Sample {
        let growing = if is_along_v {
            mesh.along_v()
        } else {
            mesh.along_u
        };
        let tangent = if kept(outline.dot(growing)) < 0.0 {
            -outline
        } else {
            outline
        };
        Sample {
            tangent,
            is_mirrored: kept(self.normal.cross(tangent).dot(mesh.normal)) > 0.0,
            is_along_v,
            ..*self
        }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn octahedral_form_keeps_directions(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0) {
            prop_assume!(x * x + y * y + z * z > 1e-6);
            let n = Vec3::new(x, y, z).normalize();
            let found = from_octahedral(octahedral(n));
            prop_assert!((found - n).length() < 7e-5, "{n} {found}");
        }
    }

    proptest! {
        #[test]
        fn sides_know_the_mesh(
            x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0,
            turn in 0.0f32..6.25, facing in 0.0f32..6.25, lean in 0.0f32..1.0,
            is_mirrored: bool,
        ) {
            prop_assume!(x * x + y * y + z * z > 1e-6);
            let normal = Vec3::new(x, y, z).normalize();
            let (first, second) = normal.any_orthonormal_pair();
            let along = |turn: f32| first * turn.cos() + second * turn.sin();
            let mesh = MeshFrame { normal, along_u: along(turn), is_mirrored };
            let carved = (along(facing) + normal * lean).normalize();
            let code = octahedral(normal);
            let outline = normal.cross(carved).normalize();
            let along_v = outline.dot(mesh.along_v()).abs() > outline.dot(mesh.along_u).abs();
            let place = UVec4::new(0, 0, 0, 512 | turn_on(code, mesh.along_u) << TURN);
            let flags = if is_mirrored { MIRRORED } else { 0 } | if along_v { ALONG_V } else { 0 };
            let surface = UVec4::new(CLASS_WALL | flags, octahedral(carved), code, 0);
            let found = MeshFrame::from_words(place, surface);
            prop_assert!((found.normal - normal).length() < 7e-5);
            prop_assert!(found.along_u.dot(mesh.along_u) > 0.998);
            prop_assert_eq!(found.is_mirrored, is_mirrored);
            let found = Sample::on_mesh(place, surface);
            prop_assert!((found.depth_fraction - 0.5).abs() < 1e-3);
            // Along the outline, growing with u or v.
            prop_assert!(found.tangent.dot(outline).abs() > 0.9999, "{:?}", found);
            let growing = if along_v { mesh.along_v() } else { mesh.along_u };
            prop_assert!(found.tangent.dot(growing) > 0.0);
            let down = found.normal.cross(found.tangent);
            prop_assert_eq!(found.is_mirrored, down.dot(normal) > 0.0);
        }
    }

    #[test]
    fn axes_are_kept() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for n in [axis, -axis] {
                assert!((from_octahedral(octahedral(n)) - n).length() < 5e-5, "{n}");
            }
        }
        // No direction at all is one.
        assert!((from_octahedral(octahedral(Vec3::ZERO)).length() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_miss_is_zeros() {
        assert_eq!(Sample::from_words(UVec4::ZERO, UVec4::ZERO).class, 0);
    }
}
