//! Converts the layouts of the f32 mathematics to those of its f64 twin.
//!
//! ```
//! use relievo::oracle::wide::wide_object;
//! use relievo_shared::layout::Object;
//!
//! let object = Object { depth: 0.5, ..Object::default() };
//! assert_eq!(wide_object(&object).depth, 0.5);
//! ```

use relievo_shared::layout::{Frame, Object, PrismData, Triangle};
use relievo_shared::surface::Surface;
use relievo_shared_f64::layout as double;
use relievo_shared_f64::surface::Surface as WideSurface;

fn wide<const N: usize>(a: [f32; N]) -> [f64; N] {
    a.map(f64::from)
}

/// Widens a prism.
pub fn wide_prism(prism: &PrismData) -> double::PrismData {
    double::PrismData {
        anchor: wide(prism.anchor),
        surface: prism.surface.map(wide),
        normal: prism.normal.map(wide),
        corner_normals: prism.corner_normals.map(wide),
        uv: prism.uv.map(wide),
        facet: wide(prism.facet),
        least_determinant: f64::from(prism.least_determinant),
        spread: f64::from(prism.spread),
        slabs: prism.slabs.map(|slab| double::Slab {
            axis: wide(slab.axis),
            low: f64::from(slab.low),
            high: f64::from(slab.high),
        }),
        centre: wide(prism.centre),
        radius: f64::from(prism.radius),
        inverse_altitude: f64::from(prism.inverse_altitude),
        neighbours: prism.neighbours,
    }
}

/// Widens a triangle.
pub fn wide_triangle(triangle: &Triangle) -> double::Triangle {
    double::Triangle {
        corners: triangle.corners.map(|corner| double::Corner {
            position: wide(corner.position),
            normal: wide(corner.normal),
            tangent: wide(corner.tangent),
            uv: wide(corner.uv),
            quadric: wide(corner.quadric),
            gradient_u: wide(corner.gradient_u),
            gradient_v: wide(corner.gradient_v),
        }),
        handedness: f64::from(triangle.handedness),
        depth_reductions: triangle.depth_reductions,
    }
}

/// Widens the parameters of an object.
pub fn wide_object(object: &Object) -> double::Object {
    double::Object {
        map_size: wide(object.map_size),
        map_step: f64::from(object.map_step),
        map_quantum: f64::from(object.map_quantum),
        map_reach: f64::from(object.map_reach),
        depth: f64::from(object.depth),
        extension: f64::from(object.extension),
        bevel: f64::from(object.bevel),
        chamfer: f64::from(object.chamfer),
        specular: f64::from(object.specular),
        tolerance: f64::from(object.tolerance),
        slack: f64::from(object.slack),
        cap_color: wide(object.cap_color),
        wall_color: wide(object.wall_color),
        bevel_color: wide(object.bevel_color),
        floor_color: wide(object.floor_color),
        shininess: object.shininess,
        tier: object.tier,
        cut_out: object.cut_out,
        linear_steps: object.linear_steps,
        binary_steps: object.binary_steps,
        map_bias: object.map_bias,
        map_packing: object.map_packing,
        map_format: object.map_format,
        search: object.search,
        self_shadow: object.self_shadow,
        profile: object.profile,
        parts: object.parts,
        number: object.number,
        finish: object.finish,
        facets: object.facets,
        mean_from: f64::from(object.mean_from),
        quotients: double::Quotients::default(),
    }
    .complete()
}

/// Widens a frame.
pub fn wide_frame(frame: &Frame) -> double::Frame {
    double::Frame {
        eye: wide(frame.eye),
        near: f64::from(frame.near),
        right: wide(frame.right),
        up: wide(frame.up),
        forward: wide(frame.forward),
        ray_first: wide(frame.ray_first),
        ray_right: wide(frame.ray_right),
        ray_down: wide(frame.ray_down),
        light_direction: wide(frame.light_direction),
        light_color: wide(frame.light_color),
        ambient: wide(frame.ambient),
        size: wide(frame.size),
        unit: f64::from(frame.unit),
        axes: frame.axes.map(wide),
        number: frame.number,
    }
}

/// Widens a surface.
pub fn wide_surface(surface: &Surface) -> WideSurface {
    WideSurface {
        normal: surface.normal.as_dvec3(),
        tangent: surface.tangent.as_dvec3(),
        bitangent: surface.bitangent.as_dvec3(),
        quadric: surface.quadric.as_dvec3(),
        uv: surface.uv.as_dvec2(),
        gradient_u: surface.gradient_u.as_dvec3(),
        gradient_v: surface.gradient_v.as_dvec3(),
        uv_bend: surface.uv_bend.as_dvec2(),
        facet_depth: f64::from(surface.facet_depth),
    }
}
