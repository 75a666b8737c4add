//! The shader entry points: bind resources, call [`relievo_shared`], write
//! outputs. No arithmetic of their own.
//!
//! The entry points are generated from the list in `relievo_shared::shaders`.
//!
//! Bindings of group 0, all read-only storage buffers of plain scalars:
//! 0 a [`Frame`] for each copy of the object, 1 [`Object`], 2 the object's facets ([`Triangle`],
//! [`PlanarTriangle`] or [`PrismData`], as the list says), 3 the words of its shape
//! map. Binding 0 of group 1 is the picture that `exits` has written, for models that
//! ask for exits. Binding 0 of group 2 are outlines around the facets' pixels: compute entry
//! points find them, with the outlines in binding 0 of group 1. Draws are not indexed: three
//! vertices a facet; the fragment shader decides by an exact test.
//!
//! The specialization constant 0, `has_copies`, is 0 in the files. If the host sets it to 1, it draws
//! all copies of an object at once, and numbers facets through all copies.
//!
//! `shade` is drawn over the whole picture, after the G-buffer, with bindings of its own.
#![cfg_attr(target_arch = "spirv", no_std)]
// A binding is an argument.
#![allow(clippy::too_many_arguments)]

use relievo_shared::exit::{self, Exit, KnownExit};

use relievo_shared::facts::{CODES, CURVED, LAYERED, PLANAR, STRAIGHT, UPRIGHT, known};
use relievo_shared::gbuffer::Hits;
#[cfg(not(feature = "corrected"))]
use relievo_shared::intersection::{Camera, intersect};
use relievo_shared::layout::{Frame, Object, PlanarTriangle, PrismData, Triangle};
use relievo_shared::model::prisms::Home;
use relievo_shared::model::{Flat, Model, Paper, Prisms, Quadric, Ray, Relief, Traced};
use relievo_shared::normals::CLASS_MISS;
use relievo_shared::outline::{Outline, outline, outline_corner, prism_outline};
use relievo_shared::shading::{self, FacetMaterial, Finish, Light, Lighting, ShadowMap, Tables};
use relievo_shared::shape_map::Texels;
use relievo_shared::stack::Stacked;
use relievo_shared::walk::PrismList;
use relievo_shared::{camera, far, for_each_facet, for_each_search, gbuffer, trace};
use spirv_std::arch::{IndexUnchecked, kill};
use spirv_std::glam::{UVec2, UVec3, UVec4, Vec4, vec4};
#[cfg(not(feature = "corrected"))]
use spirv_std::glam::{Vec2, Vec3};
use spirv_std::{Image, spirv};

/// Texels in a storage buffer.
struct TexelBuffer<'a>(&'a [u32]);

impl Texels for TexelBuffer<'_> {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        // SAFETY: `shared` keeps texel coordinates inside the map, and the host
        // binds a buffer that holds the whole map. A checked index would turn
        // into a branch that silently drops the pixel.
        unsafe { *self.0.index_unchecked(index as usize) }
    }
}

/// Prisms in a storage buffer.
#[derive(Clone, Copy)]
struct PrismBuffer<'a>(&'a [PrismData]);

impl PrismList for PrismBuffer<'_> {
    #[inline]
    fn prism(&self, index: u32) -> &PrismData {
        // SAFETY: the host draws the prisms of the buffer, and gives them
        // neighbours that are in it.
        unsafe { self.0.index_unchecked(index as usize) }
    }
}

/// A type of facets in a storage buffer.
trait Facet: Sized {
    /// What the models are drawn over.
    type Over<'a>
    where
        Self: 'a;
    /// Facet `index`.
    fn over(facets: &[Self], index: u32) -> Self::Over<'_>;
    /// The outline around the pixels of facet `index`.
    fn outline(facets: &[Self], frame: &Frame, object: &Object, index: u32) -> Outline;
}

impl Facet for Triangle {
    type Over<'a> = Triangle;

    #[inline]
    fn over(facets: &[Triangle], index: u32) -> Triangle {
        // SAFETY: the host draws the triangles of the buffer.
        unsafe { *facets.index_unchecked(index as usize) }
    }

    #[inline]
    fn outline(facets: &[Triangle], frame: &Frame, object: &Object, index: u32) -> Outline {
        outline(frame, object, &Triangle::over(facets, index))
    }
}

impl Facet for PlanarTriangle {
    type Over<'a> = Triangle;

    #[inline]
    fn over(facets: &[PlanarTriangle], index: u32) -> Triangle {
        // SAFETY: as above.
        Triangle::from(unsafe { facets.index_unchecked(index as usize) })
    }

    #[inline]
    fn outline(facets: &[PlanarTriangle], frame: &Frame, object: &Object, index: u32) -> Outline {
        outline(frame, object, &PlanarTriangle::over(facets, index))
    }
}

impl Facet for PrismData {
    type Over<'a> = Home<PrismBuffer<'a>>;

    #[inline]
    fn over(facets: &[PrismData], index: u32) -> Home<PrismBuffer<'_>> {
        Home {
            prisms: PrismBuffer(facets),
            index,
        }
    }

    #[inline]
    fn outline(facets: &[PrismData], frame: &Frame, object: &Object, index: u32) -> Outline {
        prism_outline(frame, object, PrismBuffer(facets).prism(index))
    }
}

/// The words of a picture's pixels.
type WordPicture = Image!(2D, type=u32, sampled);
/// The exits of a picture's pixels.
type ExitPicture = WordPicture;

/// The corners of the triangle that is drawn around a facet's pixels: x and y of each,
/// normalised device coordinates.
type Corners = [f32; 6];

/// Returns the corners for `outline`.
#[inline]
fn corners(outline: &Outline) -> Corners {
    let a = outline_corner(outline, 0);
    let b = outline_corner(outline, 1);
    let c = outline_corner(outline, 2);
    [a.x, a.y, b.x, b.y, c.x, c.y]
}

/// Returns the frame of the copy that facet `index` belongs to, and the facet's index in the object.
///
/// Where `has_copies` is 0, compilers see that the frame is the same for all pixels.
#[inline]
fn locate<'a>(
    frames: &'a [Frame],
    object: &Object,
    index: u32,
    has_copies: u32,
) -> (&'a Frame, u32) {
    let copy = index.checked_div(object.facets).unwrap_or(0) * has_copies;
    // SAFETY: the host binds a frame for each copy that it draws.
    let frame = unsafe { frames.index_unchecked(copy as usize) };
    (frame, index - copy * object.facets)
}

/// Facets of a row of invocations; a grid has more than one row where there are more. The host
/// binds room for all invocations.
const ROW: u32 = 1 << 13;

/// Defines an entry point that finds the outlines of facets: from `$outline` of one.
macro_rules! outline_entry_point {
    ($name:ident, $facet:ident, $outline:expr) => {
        #[doc = "Finds the corners of the outline around each facet's pixels."]
        #[spirv(compute(threads(64)))]
        pub fn $name(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0))] has_copies: u32,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frames: &[Frame],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] facets: &[$facet],
            #[spirv(storage_buffer, descriptor_set = 1, binding = 0)] outlines: &mut [Corners],
        ) {
            let index = id.x + ROW * id.y;
            let (frame, facet) = locate(frames, object, index, has_copies);
            let outline = $outline(facets, frame, object, facet);
            // SAFETY: the host binds room for all invocations.
            unsafe { *outlines.index_unchecked_mut(index as usize) = corners(&outline) };
        }
    };
}

/// The outline around the pixels of triangle `index`, seen from behind.
#[inline]
fn outline_behind(facets: &[Triangle], frame: &Frame, object: &Object, index: u32) -> Outline {
    outline(
        frame,
        object,
        &exit::reversed(&Triangle::over(facets, index)),
    )
}

outline_entry_point!(outlines_exits, Triangle, outline_behind);

/// Places the corners of the outlines that a compute entry point has found.
#[spirv(vertex)]
pub fn place(
    #[spirv(vertex_index)] vertex_index: u32,
    #[spirv(storage_buffer, descriptor_set = 2, binding = 0)] outlines: &[f32],
    #[spirv(position)] position: &mut Vec4,
    #[spirv(flat)] facet_index: &mut u32,
) {
    let first = 2 * vertex_index as usize;
    // SAFETY: the host draws three vertices for each outline of the buffer.
    let (x, y) = unsafe {
        (
            *outlines.index_unchecked(first),
            *outlines.index_unchecked(first + 1),
        )
    };
    *position = vec4(x, y, 0.5, 1.0);
    *facet_index = vertex_index / 3;
}

/// The compute entry points of the list, and its vertex entry points, which are exported.
macro_rules! facet_entry_points {
    ($($facet:ident $outlines:ident $vertex:ident;)*) => {$(
        outline_entry_point!($outlines, $facet, $facet::outline);

        #[cfg(not(feature = "corrected"))]
        #[doc = "Places the corners of the outline around a facet's pixels."]
        #[spirv(vertex)]
        pub fn $vertex(
            #[spirv(vertex_index)] vertex_index: u32,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frames: &[Frame],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] facets: &[$facet],
            #[spirv(position)] position: &mut Vec4,
            #[spirv(flat)] facet_index: &mut u32,
        ) {
            let index = vertex_index / 3;
            let (frame, _) = locate(frames, object, index, 0);
            let outline = $facet::outline(facets, frame, object, index);
            let corner = outline_corner(&outline, vertex_index - 3 * index);
            *position = vec4(corner.x, corner.y, 0.5, 1.0);
            *facet_index = index;
        }
    )*};
}

for_each_facet!(facet_entry_points);

/// Writes the words of the pixel's exit through this facet.
#[spirv(fragment(depth_replacing))]
pub fn exits(
    #[spirv(frag_coord)] coordinate: Vec4,
    #[spirv(spec_constant(id = 0))] has_copies: u32,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frames: &[Frame],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] facets: &[Triangle],
    #[spirv(flat)] index: u32,
    #[spirv(frag_depth)] depth: &mut f32,
    words: &mut UVec4,
) {
    let (frame, facet) = locate(frames, object, index, has_copies);
    let triangle = Triangle::over(facets, facet);
    let direction = camera::pixel_ray(frame, coordinate.x as u32, coordinate.y as u32);
    let (found, reversed_depth) = exit::meet(frame, direction, &triangle);
    if !found.hit {
        kill();
    }
    let number = exit::number(frame, object);
    *words = Exit::new(object, direction, &triangle, &found).words(number);
    *depth = reversed_depth;
}

/// Returns how this pixel's ray enters the shell over one facet, or discards the pixel.
#[inline]
fn enter<M: Model<Over>, Over>(
    ray: &Ray,
    over: &Over,
    exits: &ExitPicture,
    pixel: UVec2,
) -> M::Entry {
    let (meets, meeting) = M::meet(ray, over);
    if !meets {
        kill();
    }
    // Read before it is known to be needed: a struct cannot hold a picture. Without
    // exits the picture has one pixel.
    let pixel = if ray.object.number == 0 {
        UVec2::ZERO
    } else {
        pixel
    };
    let exit = KnownExit(exits.fetch(pixel));
    let (enters, entry) = M::enter(ray, over, &meeting, &exit);
    if !enters {
        kill();
    }
    entry
}

/// Traces this pixel's ray from its `entry`, or discards the pixel.
#[inline]
fn hit<M: Model<Over>, Over, T: Texels>(
    ray: &Ray,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
) -> Traced<M::Place> {
    let traced = trace::trace::<M, _, _>(ray, over, texels, entry);
    if traced.hit.class == CLASS_MISS {
        kill();
    }
    traced
}

/// Returns what [`hit`] does, where the mean of the pattern may be seen instead: without a march.
#[inline]
fn hit_or_mean<M: Model<Over>, Over, T: Texels>(
    ray: &Ray,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
) -> Traced<M::Place> {
    if M::FINDS_ENTRY {
        let object = &far::seen::<M, _>(ray, over, entry);
        hit::<M, Over, T>(&Ray { object, ..*ray }, over, texels, entry)
    } else {
        // A copy would take the registers of what is still to be read of the object.
        hit::<M, Over, T>(ray, over, texels, entry)
    }
}

/// Returns how this pixel's ray enters the shell over one facet, and what it hits, or discards the pixel.
#[inline]
fn find<M: Model<Over>, Over, T: Texels>(
    ray: &Ray,
    over: &Over,
    texels: &T,
    exits: &ExitPicture,
    pixel: UVec2,
) -> (M::Entry, Traced<M::Place>) {
    let entry = enter::<M, Over>(ray, over, exits, pixel);
    let traced = hit::<M, Over, T>(ray, over, texels, &entry);
    (entry, traced)
}

/// Defines an entry point that writes [`trace::color_words`], with self-shadows if `$shadow`.
/// If `$facts` are given, it draws only objects for which they hold.
macro_rules! color_entry_point {
    ($name:ident, $model:ident, $facet:ident, $shadow:literal $(, $facts:expr $(, $words:ident)?)?) => {
        #[doc = "Writes linear RGB as the bits of three f32, and the class."]
        #[spirv(fragment(depth_replacing))]
        pub fn $name(
            #[spirv(frag_coord)] coordinate: Vec4,
            #[spirv(spec_constant(id = 0))] has_copies: u32,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frames: &[Frame],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] facets: &[$facet],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
            #[spirv(descriptor_set = 1, binding = 0)] exits: &ExitPicture,
            #[spirv(flat)] index: u32,
            #[spirv(frag_depth)] depth: &mut f32,
            color: &mut UVec4,
        ) {
            let texels = TexelBuffer(words);
            $($(let texels = $words(texels);)?)?
            let given = object;
            $(let object = &known::<{ $facts }>(given);)?
            let (frame, facet) = locate(frames, object, index, has_copies);
            let over = $facet::over(facets, facet);
            let pixel = UVec2::new(coordinate.x as u32, coordinate.y as u32);
            let direction = camera::pixel_ray(frame, pixel.x, pixel.y);
            let ray = Ray { frame, object, direction };
            let (entry, traced) = find::<$model, _, _>(&ray, &over, &texels, exits, pixel);
            // Read again: what only shading needs takes no register during the search.
            let object = given;
            $(let object = &known::<{ $facts }>(object);)?
            let ray = Ray { frame, object, direction };
            let rgb = trace::color::<$shadow, $model, _, _>(&ray, &over, &texels, &entry, &traced);
            *color = trace::color_words(rgb, &traced.hit);
            *depth = traced.hit.depth;
        }
    };
}

/// Defines an entry point that writes [`trace::geometry_words`]. If `$facts` are given, it
/// draws only objects for which they hold.
macro_rules! geometry_entry_point {
    ($name:ident, $model:ident, $facet:ident $(, $facts:expr $(, $words:ident)?)?) => {
        #[doc = "Writes (t, u, v, δ) and (class and steps, N), as bits."]
        #[spirv(fragment(depth_replacing))]
        pub fn $name(
            #[spirv(frag_coord)] coordinate: Vec4,
            #[spirv(spec_constant(id = 0))] has_copies: u32,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frames: &[Frame],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] facets: &[$facet],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
            #[spirv(descriptor_set = 1, binding = 0)] exits: &ExitPicture,
            #[spirv(flat)] index: u32,
            #[spirv(frag_depth)] depth: &mut f32,
            place: &mut UVec4,
            surface: &mut UVec4,
        ) {
            let texels = TexelBuffer(words);
            $($(let texels = $words(texels);)?)?
            $(let object = &known::<{ $facts }>(object);)?
            let (frame, facet) = locate(frames, object, index, has_copies);
            let over = $facet::over(facets, facet);
            let pixel = UVec2::new(coordinate.x as u32, coordinate.y as u32);
            let direction = camera::pixel_ray(frame, pixel.x, pixel.y);
            let ray = Ray { frame, object, direction };
            let (entry, traced) = find::<$model, _, _>(&ray, &over, &texels, exits, pixel);
            let normals = trace::normals::<$model, _, _>(&ray, &over, &texels, &entry, &traced);
            (*place, *surface) = trace::geometry_words(frame, &traced.hit, normals.carved);
            *depth = traced.hit.depth;
        }
    };
}

/// Defines an entry point that writes [`gbuffer::words`]. If `$facts` are given, it draws only
/// objects for which they hold.
macro_rules! surface_entry_point {
    ($name:ident, $model:ident, $facet:ident $(, $facts:expr $(, $words:ident)?)?) => {
        #[doc = "Writes the G-buffer."]
        #[spirv(fragment(depth_replacing))]
        pub fn $name(
            #[spirv(frag_coord)] coordinate: Vec4,
            #[spirv(spec_constant(id = 0))] has_copies: u32,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frames: &[Frame],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] facets: &[$facet],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
            #[spirv(descriptor_set = 1, binding = 0)] exits: &ExitPicture,
            #[spirv(flat)] index: u32,
            #[spirv(frag_depth)] depth: &mut f32,
            place: &mut UVec4,
            surface: &mut UVec4,
        ) {
            let texels = TexelBuffer(words);
            $($(let texels = $words(texels);)?)?
            let given = object;
            $(let object = &known::<{ $facts }>(given);)?
            let (frame, facet) = locate(frames, object, index, has_copies);
            let over = $facet::over(facets, facet);
            let pixel = UVec2::new(coordinate.x as u32, coordinate.y as u32);
            let direction = camera::pixel_ray(frame, pixel.x, pixel.y);
            let ray = Ray { frame, object, direction };
            let entry = enter::<$model, _>(&ray, &over, exits, pixel);
            let traced = hit_or_mean::<$model, _, _>(&ray, &over, &texels, &entry);
            // Read again, as for colours.
            let object = given;
            $(let object = &known::<{ $facts }>(object);)?
            let ray = Ray { frame, object, direction };
            (*place, *surface) =
                gbuffer::words::<$model, _, _>(&ray, &over, &texels, &entry, &traced, facet);
            *depth = traced.hit.depth;
        }
    };
}

/// Defines an entry point that exports turn into a function: locations are its arguments, and the
/// fields of its result. If `$facts` are given, it knows only objects for which they hold.
macro_rules! hit_entry_point {
    ($name:ident, $model:ident, $facet:ident $(, $facts:expr $(, $words:ident)?)?) => {
        #[cfg(not(feature = "corrected"))]
        #[doc = "Finds what a ray hits over a facet."]
        #[spirv(fragment)]
        pub fn $name(
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] object: &Object,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] facets: &[$facet],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] words: &[u32],
            origin: Vec3,
            direction: Vec3,
            forward: Vec3,
            right: Vec3,
            down: Vec3,
            near: f32,
            #[spirv(flat)] facet: u32,
            class: &mut u32,
            t: &mut f32,
            normal: &mut Vec3,
            mesh_normal: &mut Vec3,
            tangent: &mut Vec4,
            uv: &mut Vec2,
            uv_right: &mut Vec2,
            uv_down: &mut Vec2,
            depth_fraction: &mut f32,
            object_number: &mut u32,
            layer: &mut u32,
        ) {
            let texels = TexelBuffer(words);
            $($(let texels = $words(texels);)?)?
            $(let object = &known::<{ $facts }>(object);)?
            let over = $facet::over(facets, facet);
            let frame = &Camera { forward, right, down, near }.frame(origin);
            let ray = Ray { frame, object, direction };
            let found = intersect::<$model, _, _>(&ray, &over, &texels);
            *class = found.class;
            *t = found.t;
            *normal = found.normal;
            *mesh_normal = found.mesh_normal;
            *tangent = found.tangent.extend(found.handedness);
            *uv = found.uv;
            *uv_right = found.uv_right;
            *uv_down = found.uv_down;
            *depth_fraction = found.depth_fraction;
            *object_number = found.object;
            *layer = found.layer;
        }
    };
}

/// The entry points of a search, for any object and for special ones.
macro_rules! fragment_entry_points {
    ($($search:ident: $model:ident over $facet:ident $(given $given:ident)?
        draws $color:ident $shadow:ident $geometry:ident $surface:ident $hit:ident
        tiers { $($tiers:tt)* }
        special { $($facts:expr => $special:ident over $special_facet:ident $(through $words:ident)?
            draws $special_color:ident $special_shadow:ident $special_geometry:ident $special_surface:ident $special_hit:ident;)* })*) => {$(
        color_entry_point!($color, $model, $facet, false $(, $given)?);
        color_entry_point!($shadow, $model, $facet, true $(, $given)?);
        geometry_entry_point!($geometry, $model, $facet $(, $given)?);
        surface_entry_point!($surface, $model, $facet $(, $given)?);
        hit_entry_point!($hit, $model, $facet $(, $given)?);
        $(
            // The object is copied to registers; the compiler removes unused fields.
            color_entry_point!($special_color, $special, $special_facet, false, $facts $(, $words)?);
            color_entry_point!($special_shadow, $special, $special_facet, true, $facts $(, $words)?);
            geometry_entry_point!($special_geometry, $special, $special_facet, $facts $(, $words)?);
            surface_entry_point!($special_surface, $special, $special_facet, $facts $(, $words)?);
            hit_entry_point!($special_hit, $special, $special_facet, $facts $(, $words)?);
        )*
    )*};
}

for_each_search!(fragment_entry_points);

/// What shading reads, in storage buffers.
struct Buffers<'a> {
    finishes: &'a [Finish],
    facets: &'a [FacetMaterial],
    lights: &'a [Light],
    shadow_maps: &'a [ShadowMap],
    words: &'a [u32],
}

impl Texels for Buffers<'_> {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        // SAFETY: the host writes the indices, and binds what they lead to.
        unsafe { *self.words.index_unchecked(index as usize) }
    }
}

impl Tables for Buffers<'_> {
    #[inline]
    fn finish(&self, index: u32) -> &Finish {
        // SAFETY: as above.
        unsafe { self.finishes.index_unchecked(index as usize) }
    }

    #[inline]
    fn facet(&self, index: u32) -> &FacetMaterial {
        // SAFETY: as above.
        unsafe { self.facets.index_unchecked(index as usize) }
    }

    #[inline]
    fn light(&self, index: u32) -> &Light {
        // SAFETY: as above.
        unsafe { self.lights.index_unchecked(index as usize) }
    }

    #[inline]
    fn shadow_map(&self, index: u32) -> &ShadowMap {
        // SAFETY: as above.
        unsafe { self.shadow_maps.index_unchecked(index as usize) }
    }
}

/// Places the corners of a triangle around the whole picture.
#[spirv(vertex)]
pub fn screen(#[spirv(vertex_index)] vertex_index: u32, #[spirv(position)] position: &mut Vec4) {
    let side = |is_far: bool| if is_far { 3.0 } else { -1.0 };
    *position = vec4(side(vertex_index == 1), side(vertex_index == 2), 0.0, 1.0);
}

/// The G-buffer.
struct HitPictures<'a> {
    place: &'a WordPicture,
    surface: &'a WordPicture,
}

impl Hits for HitPictures<'_> {
    #[inline]
    fn words(&self, x: u32, y: u32) -> (UVec4, UVec4) {
        let at = UVec2::new(x, y);
        (self.place.fetch(at), self.surface.fetch(at))
    }
}

/// Defines an entry point that writes what `$words` makes of a pixel whose hits, and words that
/// another one has written, are in pictures.
macro_rules! shade_entry_point {
    ($name:ident, $doc:literal, $words:expr $(, $written:ident = $binding:literal)? $(; $last:expr)?) => {
        #[doc = $doc]
        #[spirv(fragment)]
        pub fn $name(
            #[spirv(frag_coord)] coordinate: Vec4,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] frame: &Frame,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] lighting: &Lighting,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] finishes: &[Finish],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] facets: &[FacetMaterial],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] lights: &[Light],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] shadow_maps: &[ShadowMap],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] words: &[u32],
            #[spirv(descriptor_set = 1, binding = 0)] place: &WordPicture,
            #[spirv(descriptor_set = 1, binding = 1)] surface: &WordPicture,
            $(#[spirv(descriptor_set = 1, binding = $binding)] $written: &WordPicture,)?
            color: &mut UVec4,
        ) {
            let tables = Buffers {
                finishes,
                facets,
                lights,
                shadow_maps,
                words,
            };
            let pixel = (coordinate.x as u32, coordinate.y as u32);
            let hits = HitPictures { place, surface };
            *color = $words(
                &tables, frame, lighting, pixel, &hits
                $(, |_| $written.fetch(UVec2::new(pixel.0, pixel.1)))?
                $(, $last)?
            );
        }
    };
}

shade_entry_point!(
    shade,
    "Writes linear RGB as the bits of three f32, and the class.",
    shading::words
);
shade_entry_point!(
    shade_edges,
    "Writes linear RGB as the bits of three f32, and the class with shares of neighbours.",
    shading::words_with_edges;
    // Means are not known yet, but for those that hits tell of.
    false
);
shade_entry_point!(
    mean,
    "Writes them anew where the mean of a pattern is seen.",
    shading::mean::words,
    colors = 2
);
