//! The shader entry points: bind resources, call [`relievo_shared`], write
//! outputs. No arithmetic of their own.
//!
//! Bindings of group 0, all read-only storage buffers of plain scalars:
//! 0 [`Frame`], 1 [`Object`], 2 the object's [`Triangle`]s, or its
//! [`PlanarTriangle`]s for entry points of the planar tier alone, or its
//! [`Shell`]s in the accurate tier, 3 the words of its shape map. Draws are not
//! indexed: six vertices a triangle, an outline around its pixels; the fragment
//! decides by an exact test.
#![cfg_attr(target_arch = "spirv", no_std)]
// A binding is an argument.
#![allow(clippy::too_many_arguments)]

use relievo_shared::facts::{CODES, CURVED, PLANAR, UPRIGHT, known};
use relievo_shared::fragment::{Entry, Hit};
use relievo_shared::layout::{
    Frame, Object, PlanarTriangle, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_RELIEF, Shell, Triangle,
};
use relievo_shared::normals::CLASS_MISS;
use relievo_shared::shape_map::Texels;
use relievo_shared::shell::{self, ShellHit};
use relievo_shared::walk::Shells;
use relievo_shared::{camera, fragment, outline};
use spirv_std::arch::{IndexUnchecked, kill};
use spirv_std::glam::{UVec4, Vec3, Vec4, vec4};
use spirv_std::spirv;

/// Texels in a storage buffer.
struct Buffer<'a>(&'a [u32]);

impl Texels for Buffer<'_> {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        // SAFETY: `shared` keeps texel coordinates inside the map, and the host
        // binds a buffer that holds the whole map. A checked index would turn
        // into a branch that silently drops the pixel.
        unsafe { *self.0.index_unchecked(index as usize) }
    }
}

/// Prisms in a storage buffer.
struct Prisms<'a>(&'a [Shell]);

impl Shells for Prisms<'_> {
    #[inline]
    fn shell(&self, index: u32) -> &Shell {
        // SAFETY: the host draws the prisms of the buffer, and gives them
        // neighbours that are in it.
        unsafe { self.0.index_unchecked(index as usize) }
    }
}

/// Triangles in a storage buffer.
trait Triangles {
    /// Triangle `index`.
    fn triangle(&self, index: u32) -> Triangle;
}

impl Triangles for [Triangle] {
    #[inline]
    fn triangle(&self, index: u32) -> Triangle {
        // SAFETY: the host draws six vertices for each triangle of the buffer.
        unsafe { *self.index_unchecked(index as usize) }
    }
}

impl Triangles for [PlanarTriangle] {
    #[inline]
    fn triangle(&self, index: u32) -> Triangle {
        // SAFETY: as above.
        Triangle::from(unsafe { self.index_unchecked(index as usize) })
    }
}

/// A vertex shader that places the corners of the outline around a triangle's pixels.
macro_rules! vertex_entry_point {
    ($name:ident, $triangle:ident) => {
        #[doc = "Places the corners of the outline around a triangle's pixels."]
        #[spirv(vertex)]
        pub fn $name(
            #[spirv(vertex_index)] vertex_index: u32,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frame: &Frame,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] triangles: &[$triangle],
            #[spirv(position)] position: &mut Vec4,
            #[spirv(flat)] triangle_index: &mut u32,
        ) {
            let index = vertex_index / 6;
            let outline = outline::outline(frame, object, &triangles.triangle(index));
            let corner = outline::outline_vertex(&outline, vertex_index - 6 * index);
            *position = vec4(corner.x, corner.y, 0.5, 1.0);
            *triangle_index = index;
        }
    };
}

vertex_entry_point!(vertex, Triangle);
vertex_entry_point!(vertex_planar, PlanarTriangle);

/// Places the corners of the outline around a prism's pixels.
#[spirv(vertex)]
pub fn vertex_prisms(
    #[spirv(vertex_index)] vertex_index: u32,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] shells: &[Shell],
    #[spirv(position)] position: &mut Vec4,
    #[spirv(flat)] shell_index: &mut u32,
) {
    let index = vertex_index / 6;
    let outline = outline::shell_outline(frame, object, Prisms(shells).shell(index));
    let corner = outline::outline_vertex(&outline, vertex_index - 6 * index);
    *position = vec4(corner.x, corner.y, 0.5, 1.0);
    *shell_index = index;
}

/// Finds the hit of this pixel's ray on this triangle, or discards the pixel.
#[inline]
fn find<const SEARCH: u32>(
    coordinate: Vec4,
    frame: &Frame,
    object: &Object,
    triangle: &Triangle,
    texels: &Buffer,
) -> (Vec3, Entry, Hit) {
    let direction = camera::pixel_ray(frame, coordinate.x as u32, coordinate.y as u32);
    let facet = fragment::meet(frame, object, triangle, direction);
    if !facet.hit {
        kill();
    }
    let entry = fragment::enter(object, triangle, direction, &facet);
    if !entry.path.enters {
        kill();
    }
    let hit = fragment::trace::<SEARCH, _>(frame, object, texels, direction, &entry);
    if hit.class == CLASS_MISS {
        kill();
    }
    (direction, entry, hit)
}

/// Finds the hit of this pixel's ray where it comes in through this prism, or
/// discards the pixel.
#[inline]
fn find_prism(
    coordinate: Vec4,
    frame: &Frame,
    object: &Object,
    shells: &Prisms,
    texels: &Buffer,
    index: u32,
) -> (Vec3, ShellHit) {
    let direction = camera::pixel_ray(frame, coordinate.x as u32, coordinate.y as u32);
    let found = shell::trace(frame, object, shells, texels, direction, index);
    if found.hit.class == CLASS_MISS {
        kill();
    }
    (direction, found)
}

/// What pictures of colours hold of a pixel.
#[inline]
fn color_words(rgb: Vec3, hit: &Hit) -> UVec4 {
    UVec4::new(
        fragment::word(rgb.x),
        fragment::word(rgb.y),
        fragment::word(rgb.z),
        hit.class,
    )
}

/// What pictures of geometry hold of a pixel.
#[inline]
fn geometry_words(hit: &Hit, normal: Vec3) -> (UVec4, UVec4) {
    (
        UVec4::new(
            fragment::word(hit.t),
            fragment::word(hit.uv.x),
            fragment::word(hit.uv.y),
            fragment::word(hit.depth_fraction),
        ),
        UVec4::new(
            fragment::class_and_steps(hit),
            fragment::word(normal.x),
            fragment::word(normal.y),
            fragment::word(normal.z),
        ),
    )
}

/// An entry point that writes linear RGB as the bits of three f32, and the
/// class in the fourth word.
macro_rules! color_entry_point {
    ($name:ident, $triangle:ident, $search:expr, $shadow:expr $(, $facts:expr)?) => {
        #[doc = "Writes linear RGB as the bits of three f32, and the class."]
        #[spirv(fragment(depth_replacing))]
        pub fn $name(
            #[spirv(frag_coord)] coordinate: Vec4,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frame: &Frame,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] triangles: &[$triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
            #[spirv(flat)] index: u32,
            #[spirv(frag_depth)] depth: &mut f32,
            color: &mut UVec4,
        ) {
            let texels = Buffer(words);
            $(let object = &known::<{ $facts }>(object);)?
            let triangle = triangles.triangle(index);
            let (direction, entry, hit) =
                find::<{ $search }>(coordinate, frame, object, &triangle, &texels);
            let rgb =
                fragment::color::<{ $shadow }, _>(frame, object, &texels, direction, &entry, &hit);
            *color = color_words(rgb, &hit);
            *depth = hit.depth;
        }
    };
}

/// An entry point that writes what the hit is: (t, u, v, δ) and (class and
/// steps, N), as bits.
macro_rules! geometry_entry_point {
    ($name:ident, $triangle:ident, $search:expr $(, $facts:expr)?) => {
        #[doc = "Writes (t, u, v, δ) and (class and steps, N), as bits."]
        #[spirv(fragment(depth_replacing))]
        pub fn $name(
            #[spirv(frag_coord)] coordinate: Vec4,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frame: &Frame,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] triangles: &[$triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
            #[spirv(flat)] index: u32,
            #[spirv(frag_depth)] depth: &mut f32,
            place: &mut UVec4,
            surface: &mut UVec4,
        ) {
            let texels = Buffer(words);
            $(let object = &known::<{ $facts }>(object);)?
            let triangle = triangles.triangle(index);
            let (direction, entry, hit) =
                find::<{ $search }>(coordinate, frame, object, &triangle, &texels);
            let normal = fragment::normals(object, &texels, direction, &entry, &hit).carved;
            (*place, *surface) = geometry_words(&hit, normal);
            *depth = hit.depth;
        }
    };
}

/// [`color_entry_point`] of the accurate tier.
macro_rules! color_prisms_entry_point {
    ($name:ident, $shadow:expr) => {
        #[doc = "Writes linear RGB as the bits of three f32, and the class."]
        #[spirv(fragment(depth_replacing))]
        pub fn $name(
            #[spirv(frag_coord)] coordinate: Vec4,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frame: &Frame,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] shells: &[Shell],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
            #[spirv(flat)] index: u32,
            #[spirv(frag_depth)] depth: &mut f32,
            color: &mut UVec4,
        ) {
            let (shells, texels) = (Prisms(shells), Buffer(words));
            let (direction, found) = find_prism(coordinate, frame, object, &shells, &texels, index);
            let rgb = shell::color::<{ $shadow }, _, _>(
                frame, object, &shells, &texels, direction, &found,
            );
            *color = color_words(rgb, &found.hit);
            *depth = found.hit.depth;
        }
    };
}

/// Writes (t, u, v, δ) and (class and steps, N), as bits.
#[spirv(fragment(depth_replacing))]
pub fn geometry_prisms(
    #[spirv(frag_coord)] coordinate: Vec4,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] shells: &[Shell],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
    #[spirv(flat)] index: u32,
    #[spirv(frag_depth)] depth: &mut f32,
    place: &mut UVec4,
    surface: &mut UVec4,
) {
    let (shells, texels) = (Prisms(shells), Buffer(words));
    let (_, found) = find_prism(coordinate, frame, object, &shells, &texels, index);
    let normal = shell::normals(object, &shells, &texels, &found).carved;
    (*place, *surface) = geometry_words(&found.hit, normal);
    *depth = found.hit.depth;
}

/// The entry points of a search for objects of which these facts are true, if
/// any are wanted: an object that is known is held whole, in registers.
macro_rules! entry_points {
    ($color:ident $shadow:ident $geometry:ident, $triangle:ident, $search:expr $(, $facts:expr)?) => {
        color_entry_point!($color, $triangle, $search, false $(, $facts)?);
        color_entry_point!($shadow, $triangle, $search, true $(, $facts)?);
        geometry_entry_point!($geometry, $triangle, $search $(, $facts)?);
    };
}

// The host knows the facts of each by its name.
entry_points!(color_extrusion color_extrusion_shadow geometry_extrusion,
    Triangle, SEARCH_EXTRUSION);
entry_points!(color_planar color_planar_shadow geometry_planar,
    PlanarTriangle, SEARCH_EXTRUSION, PLANAR | UPRIGHT | CODES);
entry_points!(color_planar_growing color_planar_growing_shadow geometry_planar_growing,
    PlanarTriangle, SEARCH_EXTRUSION, PLANAR | CODES);
entry_points!(color_curved color_curved_shadow geometry_curved,
    Triangle, SEARCH_EXTRUSION, CURVED | UPRIGHT | CODES);
entry_points!(color_curved_growing color_curved_growing_shadow geometry_curved_growing,
    Triangle, SEARCH_EXTRUSION, CURVED | CODES);
entry_points!(color_relief color_relief_shadow geometry_relief, Triangle, SEARCH_RELIEF);
entry_points!(color_paper color_paper_shadow geometry_paper, Triangle, SEARCH_PAPER);
color_prisms_entry_point!(color_prisms, false);
color_prisms_entry_point!(color_prisms_shadow, true);
