//! Structs that the host writes and both renderers read: plain scalars, with the
//! same layout in a storage buffer and in a slice.
//!
//! ```
//! use relievo_shared::layout::{Triangle, vec3};
//! use relievo_shared::Vec3;
//!
//! assert_eq!(size_of::<Triangle>(), 248);
//! assert_eq!(vec3([1.0, 2.0, 3.0]), Vec3::new(1.0, 2.0, 3.0));
//! ```

use crate::{Real, Vec2, Vec3};

/// One corner of a [`Triangle`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Corner {
    /// Position, object units, relative to the scene's origin.
    pub position: [Real; 3],
    /// Unit normal of the smooth surface, pointing out.
    pub normal: [Real; 3],
    /// Unit tangent, along growing u, orthogonal to the normal.
    pub tangent: [Real; 3],
    /// Texture coordinates in repeats, less a whole number per triangle.
    pub uv: [Real; 2],
    /// The quadric's coefficients xx, xy, yy in the corner's frame (section
    /// 4): z = xx x² + xy xy + yy y², 1 / object units, positive where convex.
    pub quadric: [Real; 3],
    /// ∇u, orthogonal to the normal, repeats per object unit.
    pub gradient_u: [Real; 3],
    /// ∇v, orthogonal to the normal, repeats per object unit.
    pub gradient_v: [Real; 3],
}

/// One triangle, as the models over triangles read it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Triangle {
    /// The corners, counter-clockwise when seen from outside.
    pub corners: [Corner; 3],
    /// +1 or −1: the bitangent is handedness · (normal × tangent).
    pub handedness: Real,
    /// 1 − h / S_z at each corner: how much less than the object's the depth is there.
    /// [`pack_depth_reductions`] says how.
    pub depth_reductions: u32,
}

/// Number of steps of a corner's depth reduction from 0 to 1: all that 10 bits hold.
pub const REDUCTION_STEPS: u32 = 1023;

/// One step.
const REDUCTION_STEP: Real = 1.0 / 1023.0;

/// Packs depth reductions at three corners, in steps (0 to [`REDUCTION_STEPS`]), for
/// [`Triangle::depth_reductions`]: 10 bits a corner, the first corner's lowest.
///
/// ```
/// use relievo_shared::layout::{depth_reductions, pack_depth_reductions};
///
/// assert_eq!(depth_reductions(pack_depth_reductions([0, 1023, 0])), [0.0, 1.0, 0.0]);
/// ```
pub fn pack_depth_reductions(steps: [u32; 3]) -> u32 {
    let [a, b, c] = steps;
    a | (b << 10) | (c << 20)
}

/// Unpacks [`Triangle::depth_reductions`]: 1 − h / S_z at the corners, 0…1.
#[inline]
pub fn depth_reductions(packed: u32) -> [Real; 3] {
    let reduction = |steps: u32| (steps & REDUCTION_STEPS) as Real * REDUCTION_STEP;
    [
        reduction(packed),
        reduction(packed >> 10),
        reduction(packed >> 20),
    ]
}

/// One corner of a [`PlanarTriangle`]; the fields are those of [`Corner`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct PlanarCorner {
    /// Position, object units, relative to the scene's origin.
    pub position: [Real; 3],
    /// Unit normal of the smooth surface, pointing out.
    pub normal: [Real; 3],
    /// Texture coordinates in repeats, less a whole number per triangle.
    pub uv: [Real; 2],
    /// ∇u, orthogonal to the normal, repeats per object unit.
    pub gradient_u: [Real; 3],
    /// ∇v, orthogonal to the normal, repeats per object unit.
    pub gradient_v: [Real; 3],
}

/// The part of a [`Triangle`] that the planar tier reads: no quadrics and no
/// tangents.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct PlanarTriangle {
    /// The corners, counter-clockwise when seen from outside.
    pub corners: [PlanarCorner; 3],
    /// As in [`Triangle`].
    pub depth_reductions: u32,
}

impl From<&Triangle> for PlanarTriangle {
    #[inline]
    fn from(triangle: &Triangle) -> PlanarTriangle {
        let corner = |corner: &Corner| PlanarCorner {
            position: corner.position,
            normal: corner.normal,
            uv: corner.uv,
            gradient_u: corner.gradient_u,
            gradient_v: corner.gradient_v,
        };
        let [a, b, c] = &triangle.corners;
        PlanarTriangle {
            corners: [corner(a), corner(b), corner(c)],
            depth_reductions: triangle.depth_reductions,
        }
    }
}

impl From<&PlanarTriangle> for Triangle {
    /// Sets the fields that are left out to 0.
    #[inline]
    fn from(triangle: &PlanarTriangle) -> Triangle {
        let corner = |corner: &PlanarCorner| Corner {
            position: corner.position,
            normal: corner.normal,
            tangent: [0.0; 3],
            uv: corner.uv,
            quadric: [0.0; 3],
            gradient_u: corner.gradient_u,
            gradient_v: corner.gradient_v,
        };
        let [a, b, c] = &triangle.corners;
        Triangle {
            corners: [corner(a), corner(b), corner(c)],
            handedness: 0.0,
            depth_reductions: triangle.depth_reductions,
        }
    }
}

/// A pair of parallel planes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Slab {
    /// Vector across it, of any length > 0.
    pub axis: [Real; 3],
    /// The least p · `axis` in the slab, p relative to the prism's anchor.
    pub low: Real,
    /// The largest one.
    pub high: Real,
}

/// The curved prism over one triangle (section 6), as [`Prism`](crate::prism::Prism)
/// reads it: the points F(w1, w2, δ) = S(w) − S_z δ N(w), with S and N of degree two
/// in the barycentrics w1 and w2 of the second and third corner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct PrismData {
    /// Position of the first corner, object units, relative to the scene's
    /// origin. The other fields are relative to it.
    pub anchor: [Real; 3],
    /// S without its constant, which is 0: the coefficients of w1, w2, w1²,
    /// w1 w2, w2², object units.
    pub surface: [[Real; 3]; 5],
    /// N: the coefficients of 1, w1, w2, w1², w1 w2, w2².
    pub normal: [[Real; 3]; 6],
    /// Unit normals of the corners, which light the cap: those of the mesh. N
    /// differs where an edge is hard.
    pub corner_normals: [[Real; 3]; 3],
    /// Texture coordinates of the first corner, and the changes from there to
    /// the second and to the third, repeats.
    pub uv: [[Real; 2]; 3],
    /// Unit normal of the facet.
    pub facet: [Real; 3],
    /// F counts as folded where its determinant is less than this, object units
    /// cubed.
    pub least_determinant: Real,
    /// Sine of an angle that no normal of S exceeds with `facet`; 1 if no such bound
    /// is known.
    pub spread: Real,
    /// Slabs around all faces through which a ray may enter this prism from outside:
    /// around the cap, or around the whole prism if a side is open. They lie along the
    /// facet and along its sides. The last two have the width 1 in p · `axis`, so that
    /// p · `axis` − `low` is about w1 and w2.
    pub slabs: [Slab; 4],
    /// Centre of a ball around the whole prism.
    pub centre: [Real; 3],
    /// Its radius, object units.
    pub radius: Real,
    /// 1 / the facet's least altitude, 1 / object units.
    pub inverse_altitude: Real,
    /// For each corner the neighbour across the side opposite to it: 4 × the index
    /// of the neighbour + the neighbour's corner opposite to the same side; or
    /// [`NO_NEIGHBOUR`].
    pub neighbours: [u32; 3],
}

/// The surface ends at this side of a prism.
pub const NO_NEIGHBOUR: u32 = 0xffff_ffff;

/// The camera, the picture and the light of one frame, in the space of the objects that
/// are drawn with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Frame {
    /// The eye, object units, relative to the scene's origin.
    pub eye: [Real; 3],
    /// Distance of the near plane along `forward`, object units, > 0.
    pub near: Real,
    /// Unit vector to the right of the picture, divided by tan(half the horizontal field of view).
    pub right: [Real; 3],
    /// Unit vector to the top of the picture, divided by tan(half the vertical field of view).
    pub up: [Real; 3],
    /// Unit vector from the eye into the picture's centre.
    pub forward: [Real; 3],
    /// Direction (not normalised) through the centre of pixel (0, 0), the top left one.
    pub ray_first: [Real; 3],
    /// Change of that direction from one pixel to the next on its right.
    pub ray_right: [Real; 3],
    /// Change of that direction from one pixel to the next below.
    pub ray_down: [Real; 3],
    /// Unit vector towards the light.
    pub light_direction: [Real; 3],
    /// Linear RGB of the light.
    pub light_color: [Real; 3],
    /// Linear RGB of the ambient light.
    pub ambient: [Real; 3],
    /// Width and height of the picture, pixels (whole numbers).
    pub size: [Real; 2],
    /// World units per object unit; pictures of the geometry are in world units.
    pub unit: Real,
    /// The axes of object space, world axes: the columns of a rotation.
    pub axes: [[Real; 3]; 3],
    /// Added to the [`number`](Object::number) of the object; 0 for its first copy.
    pub number: u32,
}

/// The axes of a space that is not turned.
pub const UPRIGHT_AXES: [[Real; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The parameters of one object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Object {
    /// Width and height of the shape map, texels (whole numbers).
    pub map_size: [Real; 2],
    /// Texels per step of a stored code; a power of two in accurate maps.
    pub map_step: Real,
    /// The largest amount by which a stored distance may lie under the true one, texels.
    pub map_quantum: Real,
    /// Half the span of the differences that make the map's gradient, texels, > 0.
    pub map_reach: Real,
    /// S_z: the largest distance from the cap to the floor, object units, > 0.
    pub depth: Real,
    /// e: outward extension of the pattern, width units (section 2).
    pub extension: Real,
    /// b: growth of the pattern's radius, width units per unit of δ.
    pub bevel: Real,
    /// c: depth fraction at which the growth stops, 0…1.
    pub chamfer: Real,
    /// Strength of the specular reflection, 0…1.
    pub specular: Real,
    /// Largest distance between the searched and the true ray in the accurate tier,
    /// pixels.
    pub tolerance: Real,
    /// Largest distance before the solid at which a search may end, texels at
    /// distance 1 from the eye, ≥ 0; proportional to the distance.
    pub slack: Real,
    /// Linear RGB of the cap (the mesh surface).
    pub cap_color: [Real; 3],
    /// Linear RGB of the walls.
    pub wall_color: [Real; 3],
    /// Linear RGB of bevels and chamfers.
    pub bevel_color: [Real; 3],
    /// Linear RGB of the floor.
    pub floor_color: [Real; 3],
    /// Exponent of the specular reflection, 1…127.
    pub shininess: u32,
    /// One of the `TIER_` constants.
    pub tier: u32,
    /// Not 0: there is no floor; rays that reach δ = 1 are discarded.
    pub cut_out: u32,
    /// Largest number of steps of the linear search.
    pub linear_steps: u32,
    /// Number of bisections after it.
    pub binary_steps: u32,
    /// The stored code of distance 0.
    pub map_bias: u32,
    /// log₂ of the texels in one 32-bit word: 0, 1 or 2 (for 32, 16 and 8 bits).
    pub map_packing: u32,
    /// One of the `FORMAT_` constants.
    pub map_format: u32,
    /// One of the `SEARCH_` constants.
    pub search: u32,
    /// Not 0: columns cast shadows on their own object.
    pub self_shadow: u32,
    /// [`NUMBER`](crate::profile::Growth::NUMBER) of the profile.
    pub profile: u32,
    /// Number of parts of a profile that has parts, ≥ 1.
    pub parts: u32,
    /// Number of the object in its scene, from 1, whose exits
    /// ([`Exit`](crate::exit::Exit)) are asked for; 0 to do without.
    pub number: u32,
    /// What follows from the other fields and is the same for all pixels:
    /// [`Object::complete`] computes it.
    pub quotients: Quotients,
    /// Number of its materials in the scene: its first [`Finish`](crate::shading::Finish) is
    /// [`FINISHES`](crate::shading::layout::FINISHES) times this. The flags
    /// [`KNOWS_EDGES`](crate::gbuffer::KNOWS_EDGES) and [`KNOWS_MESH`](crate::gbuffer::KNOWS_MESH) may be
    /// set.
    pub finish: u32,
    /// Number of its facets. Facet i of copy c has the number c · `facets` + i where copies are
    /// drawn at once.
    pub facets: u32,
    /// Width of a pixel, object units, from which on the mean of the pattern is all that it shows
    /// ([`far`](crate::far)); 0 where no mean is asked for.
    pub mean_from: Real,
}

/// Quotients of an [`Object`]'s parameters, so that pixels do not divide by them: the exact
/// shaders correct each division.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "double"), derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Quotients {
    /// Offsets of the differences that make the map's gradient, repeats:
    /// `map_reach` / `map_size`.
    pub gradient_offset: [Real; 2],
    /// 1 / (2 `map_reach`), 1 / texels.
    pub gradient_scale: Real,
    /// 1 / b with b in texels; 0 without a bevel.
    pub inverse_bevel: Real,
    /// b c / `parts`, texels.
    pub part_width: Real,
    /// 1 / `part_width`; 0 without a bevel.
    pub inverse_part_width: Real,
}

/// The curvature of the surface is ignored: extrusion mapping without silhouette.
pub const TIER_PLANAR: u32 = 0;
/// The ray bends along the local quadric, with facet depth (section 4).
pub const TIER_FAST: u32 = 1;

/// The paper's algorithms as printed, mistakes included (section 8).
pub const TIER_PAPER: u32 = 2;
/// The ray is followed through curved prisms (section 6).
pub const TIER_ACCURATE: u32 = 3;

/// Texels are signed fixed-point codes of 8 or 16 bits: (code − bias) · step.
pub const FORMAT_CODES: u32 = 0;
/// Texels are the bits of f32 distances.
pub const FORMAT_FLOAT: u32 = 1;
/// Texels are the paper's RGBA8: normal in R and G, distance in B, shape in A.
pub const FORMAT_PAPER: u32 = 2;

/// Steps through the distance map that cannot skip the pattern.
pub const SEARCH_EXTRUSION: u32 = 0;
/// Equal steps through a depth map of the same pattern: relief mapping.
pub const SEARCH_RELIEF: u32 = 1;
/// The search of the paper's tier, with its own path.
pub const SEARCH_PAPER: u32 = 2;
/// The search of the accurate tier, from prism to prism.
pub const SEARCH_PRISMS: u32 = 3;

#[cfg(not(feature = "double"))]
const _: () = {
    use core::mem::{align_of, offset_of, size_of};
    assert!(size_of::<Corner>() == 80 && align_of::<Corner>() == 4);
    assert!(offset_of!(Corner, uv) == 36 && offset_of!(Corner, quadric) == 44);
    assert!(size_of::<Triangle>() == 248 && align_of::<Triangle>() == 4);
    assert!(offset_of!(Corner, gradient_u) == 56 && offset_of!(Triangle, handedness) == 240);
    assert!(size_of::<PlanarCorner>() == 56 && size_of::<PlanarTriangle>() == 172);
    assert!(offset_of!(PlanarCorner, uv) == 24 && align_of::<PlanarTriangle>() == 4);
    assert!(
        size_of::<Slab>() == 20 && size_of::<PrismData>() == 336 && align_of::<PrismData>() == 4
    );
    assert!(offset_of!(PrismData, facet) == 204 && offset_of!(PrismData, neighbours) == 324);
    assert!(size_of::<Frame>() == 176 && align_of::<Frame>() == 4);
    assert!(
        offset_of!(Frame, right) == 16
            && offset_of!(Frame, size) == 124
            && offset_of!(Frame, unit) == 132
    );
    assert!(size_of::<Object>() == 184 && align_of::<Object>() == 4);
    assert!(offset_of!(Object, cap_color) == 48 && offset_of!(Object, shininess) == 96);
    assert!(offset_of!(Object, quotients) == 148);
};

/// A vector from three scalars of a layout.
#[inline]
pub fn vec3(a: [Real; 3]) -> Vec3 {
    Vec3::new(a[0], a[1], a[2])
}

/// A vector from two scalars of a layout.
#[inline]
pub fn vec2(a: [Real; 2]) -> Vec2 {
    Vec2::new(a[0], a[1])
}
