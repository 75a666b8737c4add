//! The structs that the exported shaders read, and constants for a pipeline.
//! Written by `relievo export`; needs the crates `bytemuck` (with `derive`) and `wgpu`.
#![allow(dead_code)]

/// Entry point of the vertex shader (in GLSL: main).
pub const VERTEX: &str = "vs_main";
/// Entry point of the fragment shader (in GLSL: main).
pub const FRAGMENT: &str = "fs_main";
/// Number of vertices to draw per facet, without vertex or index buffers.
pub const VERTICES_PER_FACET: u32 = 3;
/// Format of the depth buffer: compare `Greater`, clear to 0, written by the fragment shader.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Format of a target that keeps the fragment shader's output exactly.
pub const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Files with the contents of group 0, in the order of the bindings.
pub const BUFFERS: [&str; 4] = ["frame.bin", "object.bin", "facets.bin", "map.bin"];

/// The camera, the picture and the light of one frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frame {
    /// Position of the eye, relative to the scene's origin. In object units.
    pub eye: [f32; 3],
    /// Distance of the near plane along `forward`, > 0. In object units.
    pub near: f32,
    /// Unit vector to the right of the picture, divided by tan(half the horizontal field of view).
    pub right: [f32; 3],
    /// Unit vector to the top of the picture, divided by tan(half the vertical field of view).
    pub up: [f32; 3],
    /// Unit vector along the view direction, through the picture's centre.
    pub forward: [f32; 3],
    /// Direction (not normalised) of the ray through the centre of the top left pixel (0, 0).
    pub ray_first: [f32; 3],
    /// Change of that direction per pixel to the right.
    pub ray_right: [f32; 3],
    /// Change of that direction per pixel down.
    pub ray_down: [f32; 3],
    /// Unit vector towards the light.
    pub light_direction: [f32; 3],
    /// Colour of the light times its intensity. In linear RGB.
    pub light_color: [f32; 3],
    /// Colour of the ambient light. In linear RGB.
    pub ambient: [f32; 3],
    /// Width and height of the picture, integers. In pixels.
    pub size: [f32; 2],
    /// World units per object unit; not read by these shaders. In world units.
    pub unit: f32,
    /// Axes of object space; not read by these shaders.
    pub axes: [[f32; 3]; 3],
    /// Added to the object's number.
    pub number: u32,
}

/// What follows from an object's parameters: change it with them.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Quotients {
    /// `map_reach` / `map_size`. In repeats.
    pub gradient_offset: [f32; 2],
    /// 1 / (2 `map_reach`). In 1 / texels.
    pub gradient_scale: f32,
    /// 1 / (`bevel` times the map's width); 0 without a bevel. In 1 / texels.
    pub inverse_bevel: f32,
    /// `bevel` times the map's width times `chamfer` / `parts`. In texels.
    pub part_width: f32,
    /// 1 / `part_width`; 0 without a bevel. In 1 / texels.
    pub inverse_part_width: f32,
}

/// Parameters of one object.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Object {
    /// Width and height of the shape map, integers. In texels.
    pub map_size: [f32; 2],
    /// Change of distance per step of a stored code. In texels.
    pub map_step: f32,
    /// Largest amount by which a stored distance may be less than the true one. In texels.
    pub map_quantum: f32,
    /// Half the span of the finite differences for the map's gradient, > 0. In texels.
    pub map_reach: f32,
    /// Distance from the surface to the floor, > 0. In object units.
    pub depth: f32,
    /// Outward offset of the pattern. In widths.
    pub extension: f32,
    /// Growth of the pattern's offset per unit of depth fraction. In widths.
    pub bevel: f32,
    /// Depth fraction at which the growth stops, 0 to 1.
    pub chamfer: f32,
    /// Strength of the specular reflection, 0 to 1.
    pub specular: f32,
    /// Largest deviation from the ray at which the accurate tier may search. In pixels.
    pub tolerance: f32,
    /// Distance before the solid at which a search may end, per unit of distance from the eye; depends on the pixel width of the exported picture. In texels.
    pub slack: f32,
    /// Colour of the cap (the mesh's surface). In linear RGB.
    pub cap_color: [f32; 3],
    /// Colour of the walls. In linear RGB.
    pub wall_color: [f32; 3],
    /// Colour of bevels and chamfers. In linear RGB.
    pub bevel_color: [f32; 3],
    /// Colour of the floor. In linear RGB.
    pub floor_color: [f32; 3],
    /// Exponent of the specular reflection, 1 to 127.
    pub shininess: u32,
    /// Tier: 0 planar, 1 fast, 2 paper, 3 accurate. The shader is compiled for it.
    pub tier: u32,
    /// Not 0 if there is no floor.
    pub cut_out: u32,
    /// Maximum number of steps of the linear search.
    pub linear_steps: u32,
    /// Number of bisections after the linear search.
    pub binary_steps: u32,
    /// Stored code of distance 0.
    pub map_bias: u32,
    /// log2 of the texels per 32-bit word: 0, 1 or 2.
    pub map_packing: u32,
    /// Format of the texels: 0 codes of 8 or 16 bits, 1 floats, 2 the paper's RGBA8. The shader is compiled for it.
    pub map_format: u32,
    /// Search: 0 extrusion, 1 relief, 2 paper, 3 prisms. The shader is compiled for it.
    pub search: u32,
    /// Not 0 if the object casts shadows on itself. The shader is compiled for it.
    pub self_shadow: u32,
    /// Profile of the extrusion: 0 straight. A shader for straight profiles does not read it.
    pub profile: u32,
    /// Number of parts of a profile that has parts, >= 1.
    pub parts: u32,
    /// Not 0 where the fast tier knows the mesh behind a facet. Keep it.
    pub number: u32,
    /// What follows from the other parameters.
    pub quotients: Quotients,
    /// Number of the object in its scene, from 0, or any of yours: hits have it as `object`. Other shaders do not read it.
    pub finish: u32,
    /// Number of the object's facets.
    pub facets: u32,
    /// Width of a pixel from which on only the mean of the pattern is seen; exported shaders do not read it. In object units.
    pub mean_from: f32,
}

/// One corner of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Corner {
    /// Position, relative to the scene's origin. In object units.
    pub position: [f32; 3],
    /// Outward unit normal of the smooth surface.
    pub normal: [f32; 3],
    /// Unit tangent in the direction of increasing u, orthogonal to the normal.
    pub tangent: [f32; 3],
    /// Texture coordinates, minus an integer per triangle; v points down. In repeats.
    pub uv: [f32; 2],
    /// Coefficients xx, xy, yy of the quadric in the corner's tangent frame, positive where convex. In 1 / object units.
    pub quadric: [f32; 3],
    /// Gradient of u, orthogonal to the normal. In repeats / object unit.
    pub gradient_u: [f32; 3],
    /// Gradient of v, orthogonal to the normal. In repeats / object unit.
    pub gradient_v: [f32; 3],
}

/// One triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Triangle {
    /// Corners, counter-clockwise seen from outside.
    pub corners: [Corner; 3],
    /// +1 or -1: the bitangent is handedness * cross(normal, tangent).
    pub handedness: f32,
    /// 1 - local depth / depth at the corners, in steps of 1/1023; 10 bits each, the first corner's lowest.
    pub depth_reductions: u32,
}

/// Makes the layout of group 0: four read-only storage buffers.
pub fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
    let stages = [both, both, both, wgpu::ShaderStages::FRAGMENT];
    let buffer = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let entries = [0, 1, 2, 3].map(|index| wgpu::BindGroupLayoutEntry {
        binding: index,
        visibility: stages[index as usize],
        ty: buffer,
        count: None,
    });
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("relievo"),
        entries: &entries,
    })
}
