//! Describes the structs that shaders read. The JSON, the Rust and the names in the
//! shaders are generated from this one table. Offsets are the compiler's.

use super::map::MapForm;
use crate::shaders::Facets;
use relievo_shared::layout;
use std::mem::{offset_of, size_of};

/// Type of a field's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    F32,
    U32,
    Struct(&'static str),
}

impl Element {
    pub(super) fn name(self) -> &'static str {
        match self {
            Element::F32 => "f32",
            Element::U32 => "u32",
            Element::Struct(name) => name,
        }
    }
}

/// The type of a field: an element, or an array (of arrays) of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    pub(super) element: Element,
    /// Sides of the array, the outermost first; empty for one element.
    pub(super) shape: Vec<usize>,
}

impl Kind {
    /// Returns the type in Rust syntax.
    pub(super) fn rust(&self) -> String {
        let element = self.element.name().to_string();
        let wrap = |inner, side| format!("[{inner}; {side}]");
        self.shape.iter().rev().fold(element, wrap)
    }
}

/// A field of a [`Struct`].
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub(super) name: &'static str,
    /// Bytes from the struct's start.
    pub(super) offset: usize,
    pub(super) kind: Kind,
    /// Empty if dimensionless.
    pub(super) unit: &'static str,
    pub(super) meaning: &'static str,
}

/// A struct of `relievo_shared::layout`.
#[derive(Clone, Debug)]
pub(super) struct Struct {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    /// Bytes.
    pub(super) size: usize,
    pub(super) fields: Vec<Field>,
}

/// A type that a field may have.
trait Plain {
    fn kind() -> Kind;
}

impl<T: Plain, const N: usize> Plain for [T; N] {
    fn kind() -> Kind {
        let Kind { element, mut shape } = T::kind();
        shape.insert(0, N);
        Kind { element, shape }
    }
}

macro_rules! plain {
    ($($type:ty: $element:expr;)*) => {$(
        impl Plain for $type {
            fn kind() -> Kind {
                Kind {
                    element: $element,
                    shape: Vec::new(),
                }
            }
        }
    )*};
}

plain! {
    f32: Element::F32;
    u32: Element::U32;
    layout::Corner: Element::Struct("Corner");
    layout::PlanarCorner: Element::Struct("PlanarCorner");
    layout::Slab: Element::Struct("Slab");
    layout::Quotients: Element::Struct("Quotients");
}

/// Makes a function for each struct. A field with a wrong type does not compile.
macro_rules! structs {
    ($($function:ident $name:ident $about:literal {
        $($field:ident: $type:ty, $unit:literal, $meaning:literal;)*
    })*) => {$(
        fn $function() -> Struct {
            Struct {
                name: stringify!($name),
                about: $about,
                size: size_of::<layout::$name>(),
                fields: vec![$({
                    let _: fn(&layout::$name) -> &$type = |all| &all.$field;
                    Field {
                        name: stringify!($field),
                        offset: offset_of!(layout::$name, $field),
                        kind: <$type>::kind(),
                        unit: $unit,
                        meaning: $meaning,
                    }
                }),*],
            }
        }
    )*};
}

structs! {
    frame Frame "The camera, the picture and the light of one frame." {
        eye: [f32; 3], "object units", "Position of the eye, relative to the scene's origin.";
        near: f32, "object units", "Distance of the near plane along `forward`, > 0.";
        right: [f32; 3], "", "Unit vector to the right of the picture, divided by tan(half the horizontal field of view).";
        up: [f32; 3], "", "Unit vector to the top of the picture, divided by tan(half the vertical field of view).";
        forward: [f32; 3], "", "Unit vector along the view direction, through the picture's centre.";
        ray_first: [f32; 3], "", "Direction (not normalised) of the ray through the centre of the top left pixel (0, 0).";
        ray_right: [f32; 3], "", "Change of that direction per pixel to the right.";
        ray_down: [f32; 3], "", "Change of that direction per pixel down.";
        light_direction: [f32; 3], "", "Unit vector towards the light.";
        light_color: [f32; 3], "linear RGB", "Colour of the light times its intensity.";
        ambient: [f32; 3], "linear RGB", "Colour of the ambient light.";
        size: [f32; 2], "pixels", "Width and height of the picture, integers.";
        unit: f32, "world units", "World units per object unit; not read by these shaders.";
        axes: [[f32; 3]; 3], "", "Axes of object space; not read by these shaders.";
        number: u32, "", "Added to the object's number.";
    }
    quotients Quotients "What follows from an object's parameters: change it with them." {
        gradient_offset: [f32; 2], "repeats", "`map_reach` / `map_size`.";
        gradient_scale: f32, "1 / texels", "1 / (2 `map_reach`).";
        inverse_bevel: f32, "1 / texels", "1 / (`bevel` times the map's width); 0 without a bevel.";
        part_width: f32, "texels", "`bevel` times the map's width times `chamfer` / `parts`.";
        inverse_part_width: f32, "1 / texels", "1 / `part_width`; 0 without a bevel.";
    }
    object Object "Parameters of one object." {
        map_size: [f32; 2], "texels", "Width and height of the shape map, integers.";
        map_step: f32, "texels", "Change of distance per step of a stored code.";
        map_quantum: f32, "texels", "Largest amount by which a stored distance may be less than the true one.";
        map_reach: f32, "texels", "Half the span of the finite differences for the map's gradient, > 0.";
        depth: f32, "object units", "Distance from the surface to the floor, > 0.";
        extension: f32, "widths", "Outward offset of the pattern.";
        bevel: f32, "widths", "Growth of the pattern's offset per unit of depth fraction.";
        chamfer: f32, "", "Depth fraction at which the growth stops, 0 to 1.";
        specular: f32, "", "Strength of the specular reflection, 0 to 1.";
        tolerance: f32, "pixels", "Largest deviation from the ray at which the accurate tier may search.";
        slack: f32, "texels", "Distance before the solid at which a search may end, per unit of distance from the eye; depends on the pixel width of the exported picture.";
        cap_color: [f32; 3], "linear RGB", "Colour of the cap (the mesh's surface).";
        wall_color: [f32; 3], "linear RGB", "Colour of the walls.";
        bevel_color: [f32; 3], "linear RGB", "Colour of bevels and chamfers.";
        floor_color: [f32; 3], "linear RGB", "Colour of the floor.";
        shininess: u32, "", "Exponent of the specular reflection, 1 to 127.";
        tier: u32, "", "Tier: 0 planar, 1 fast, 2 paper, 3 accurate. The shader is compiled for it.";
        cut_out: u32, "", "Not 0 if there is no floor.";
        linear_steps: u32, "", "Maximum number of steps of the linear search.";
        binary_steps: u32, "", "Number of bisections after the linear search.";
        map_bias: u32, "", "Stored code of distance 0.";
        map_packing: u32, "", "log2 of the texels per 32-bit word: 0, 1 or 2.";
        map_format: u32, "", "Format of the texels: 0 codes of 8 or 16 bits, 1 floats, 2 the paper's RGBA8. The shader is compiled for it.";
        search: u32, "", "Search: 0 extrusion, 1 relief, 2 paper, 3 prisms. The shader is compiled for it.";
        self_shadow: u32, "", "Not 0 if the object casts shadows on itself. The shader is compiled for it.";
        profile: u32, "", "Profile of the extrusion: 0 straight. A shader for straight profiles does not read it.";
        parts: u32, "", "Number of parts of a profile that has parts, >= 1.";
        number: u32, "", "Not 0 where the fast tier knows the mesh behind a facet. Keep it.";
        quotients: layout::Quotients, "", "What follows from the other parameters.";
        finish: u32, "", "Number of the object in its scene, from 0, or any of yours: hits have it as `object`. Other shaders do not read it.";
        facets: u32, "", "Number of the object's facets.";
        mean_from: f32, "object units", "Width of a pixel from which on only the mean of the pattern is seen; exported shaders do not read it.";
    }
    corner Corner "One corner of a triangle." {
        position: [f32; 3], "object units", "Position, relative to the scene's origin.";
        normal: [f32; 3], "", "Outward unit normal of the smooth surface.";
        tangent: [f32; 3], "", "Unit tangent in the direction of increasing u, orthogonal to the normal.";
        uv: [f32; 2], "repeats", "Texture coordinates, minus an integer per triangle; v points down.";
        quadric: [f32; 3], "1 / object units", "Coefficients xx, xy, yy of the quadric in the corner's tangent frame, positive where convex.";
        gradient_u: [f32; 3], "repeats / object unit", "Gradient of u, orthogonal to the normal.";
        gradient_v: [f32; 3], "repeats / object unit", "Gradient of v, orthogonal to the normal.";
    }
    triangle Triangle "One triangle." {
        corners: [layout::Corner; 3], "", "Corners, counter-clockwise seen from outside.";
        handedness: f32, "", "+1 or -1: the bitangent is handedness * cross(normal, tangent).";
        depth_reductions: u32, "", "1 - local depth / depth at the corners, in steps of 1/1023; 10 bits each, the first corner's lowest.";
    }
    planar_corner PlanarCorner "One corner of a triangle of the planar tier." {
        position: [f32; 3], "object units", "Position, relative to the scene's origin.";
        normal: [f32; 3], "", "Outward unit normal of the smooth surface.";
        uv: [f32; 2], "repeats", "Texture coordinates, minus an integer per triangle; v points down.";
        gradient_u: [f32; 3], "repeats / object unit", "Gradient of u, orthogonal to the normal.";
        gradient_v: [f32; 3], "repeats / object unit", "Gradient of v, orthogonal to the normal.";
    }
    planar_triangle PlanarTriangle "One triangle of the planar tier." {
        corners: [layout::PlanarCorner; 3], "", "Corners, counter-clockwise seen from outside.";
        depth_reductions: u32, "", "1 - local depth / depth at the corners, in steps of 1/1023; 10 bits each, the first corner's lowest.";
    }
    slab Slab "The space between two parallel planes." {
        axis: [f32; 3], "", "Normal of the planes, of any length.";
        low: f32, "", "Minimum of dot(p, axis), p relative to the prism's anchor.";
        high: f32, "", "Maximum of dot(p, axis).";
    }
    prism PrismData "The curved prism over one triangle: F(w1, w2, d) = S(w) - depth d N(w)." {
        anchor: [f32; 3], "object units", "The first corner, relative to the scene's origin; the other positions are relative to it.";
        surface: [[f32; 3]; 5], "object units", "S: coefficients of w1, w2, w1 w1, w1 w2, w2 w2.";
        normal: [[f32; 3]; 6], "", "N: coefficients of 1, w1, w2, w1 w1, w1 w2, w2 w2.";
        corner_normals: [[f32; 3]; 3], "", "Unit normals of the corners, for shading the cap.";
        uv: [[f32; 2]; 3], "repeats", "Texture coordinates of the first corner, and the differences of the second and third from it.";
        facet: [f32; 3], "", "Unit normal of the facet.";
        least_determinant: f32, "object units cubed", "F is treated as folded where its determinant is less.";
        spread: f32, "", "Sine of the largest angle between a normal of S and `facet`; 1 if unknown.";
        slabs: [layout::Slab; 4], "", "Slabs whose intersection contains all points where a ray may enter from outside.";
        centre: [f32; 3], "object units", "Centre of a bounding sphere.";
        radius: f32, "object units", "Radius of the bounding sphere.";
        inverse_altitude: f32, "1 / object units", "1 / the facet's smallest altitude.";
        neighbours: [u32; 3], "", "For each corner, the neighbour across the opposite side: 4 * its index + its corner opposite to that side, or 0xffffffff if there is none.";
    }
}

/// A buffer or a texture that the shaders read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Binding {
    /// Binding number in group 0.
    pub(super) number: u32,
    /// Name of the variable in the shaders.
    pub(super) name: &'static str,
    /// Name of the file with its bytes.
    pub(super) file: &'static str,
    /// Type of its contents, or of the array's elements.
    pub(super) element: Element,
    /// Whether its contents are an array of any length.
    pub(super) is_array: bool,
    /// Whether the vertex shader reads it; the fragment shader reads every buffer.
    pub(super) in_vertex: bool,
    /// How shaders read it, if it is the shape map.
    pub(super) map: MapForm,
    pub(super) about: &'static str,
}

/// Returns what the shaders of an object with these facets read.
pub(super) fn bindings(facets: Facets, map: MapForm) -> [Binding; 4] {
    let (facet, about) = match facets {
        Facets::Triangles => ("Triangle", "the object's triangles"),
        Facets::PlanarTriangles => ("PlanarTriangle", "the object's triangles"),
        Facets::Prisms => ("PrismData", "the curved prisms over the object's triangles"),
    };
    [
        Binding {
            number: 0,
            name: "frames",
            file: "frame.bin",
            element: Element::Struct("Frame"),
            is_array: true,
            in_vertex: true,
            map: MapForm::Buffer,
            about: "camera, light and size of the picture: one",
        },
        Binding {
            number: 1,
            name: "object",
            file: "object.bin",
            element: Element::Struct("Object"),
            is_array: false,
            in_vertex: true,
            map: MapForm::Buffer,
            about: "the object's parameters",
        },
        Binding {
            number: 2,
            name: "facets",
            file: "facets.bin",
            element: Element::Struct(facet),
            is_array: true,
            in_vertex: true,
            map: MapForm::Buffer,
            about,
        },
        Binding {
            number: 3,
            name: "map",
            file: "map.bin",
            element: Element::U32,
            is_array: true,
            in_vertex: false,
            map,
            about: "the shape map, with texels packed into words",
        },
    ]
}

/// Returns the structs in those buffers, each after the structs it contains.
pub(super) fn structs(facets: Facets) -> Vec<Struct> {
    let mut all = vec![frame(), quotients(), object()];
    match facets {
        Facets::Triangles => all.extend([corner(), triangle()]),
        Facets::PlanarTriangles => all.extend([planar_corner(), planar_triangle()]),
        Facets::Prisms => all.extend([slab(), prism()]),
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Facets; 3] = [Facets::Triangles, Facets::PlanarTriangles, Facets::Prisms];

    /// Types and offsets come from the compiler; this checks that no field is missing.
    #[test]
    fn fields_fill_their_structs() {
        for facets in ALL {
            let all = structs(facets);
            for described in &all {
                let mut end = 0;
                for field in &described.fields {
                    assert_eq!(field.offset, end, "{}.{}", described.name, field.name);
                    let element = match field.kind.element {
                        Element::F32 | Element::U32 => 4,
                        Element::Struct(name) => {
                            let inner = all.iter().find(|other| other.name == name);
                            inner.expect("it comes before").size
                        }
                    };
                    end += element * field.kind.shape.iter().product::<usize>();
                }
                assert_eq!(end, described.size, "{}", described.name);
            }
            assert_eq!(all.last().unwrap().size, facets.bytes());
            let facet = bindings(facets, MapForm::Buffer)[2].element;
            assert_eq!(facet, Element::Struct(all.last().unwrap().name));
        }
    }

    #[test]
    fn types_are_written_in_rust_syntax() {
        assert_eq!(<[[f32; 3]; 5]>::kind().rust(), "[[f32; 3]; 5]");
        assert_eq!(<[layout::Slab; 4]>::kind().rust(), "[Slab; 4]");
        assert_eq!(u32::kind().rust(), "u32");
    }
}
