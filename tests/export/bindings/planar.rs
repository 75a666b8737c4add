//! What the exported shaders read, and what a pipeline for them is made of.
//! Made by `relievo export`; needs the crates `bytemuck` (with `derive`) and `wgpu`.
#![allow(dead_code)]

/// The vertex shader's entry point (in GLSL: main).
pub const VERTEX: &str = "vs_main";
/// The fragment shader's entry point (in GLSL: main).
pub const FRAGMENT: &str = "fs_main";
/// Vertices that are drawn for each facet, without vertex or index buffers.
pub const VERTICES_PER_FACET: u32 = 6;
/// The depth: `Greater`, cleared to 0, written by the fragment shader.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// A target that holds all that the fragment shader writes.
pub const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Files with the buffers of group 0, in the order of their bindings.
pub const BUFFERS: [&str; 4] = ["frame.bin", "object.bin", "facets.bin", "map.bin"];

/// The camera, the picture and the light of one frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frame {
    /// The eye, relative to the scene's origin. In object units.
    pub eye: [f32; 3],
    /// Distance of the near plane along `forward`, > 0. In object units.
    pub near: f32,
    /// Unit vector to the right of the picture, divided by tan(half the horizontal field of view).
    pub right: [f32; 3],
    /// Unit vector to the top of the picture, divided by tan(half the vertical field of view).
    pub up: [f32; 3],
    /// Unit vector from the eye into the picture's centre.
    pub forward: [f32; 3],
    /// Direction (not normalised) through the centre of pixel (0, 0), the top left one.
    pub ray_first: [f32; 3],
    /// Change of that direction from one pixel to the next on its right.
    pub ray_right: [f32; 3],
    /// Change of that direction from one pixel to the next below.
    pub ray_down: [f32; 3],
    /// Unit vector towards the light.
    pub light_direction: [f32; 3],
    /// The light. In linear RGB.
    pub light_color: [f32; 3],
    /// The ambient light. In linear RGB.
    pub ambient: [f32; 3],
    /// Width and height of the picture, whole numbers. In pixels.
    pub size: [f32; 2],
}

/// Everything about one object that is not its surface or its texels.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Object {
    /// Width and height of the shape map, whole numbers. In texels.
    pub map_size: [f32; 2],
    /// Distance of one step of a stored code. In texels.
    pub map_step: f32,
    /// The largest amount by which a stored distance may lie under the true one. In texels.
    pub map_quantum: f32,
    /// Half the span of the differences that make the map's gradient, > 0. In texels.
    pub map_reach: f32,
    /// From the surface to the floor, > 0. In object units.
    pub depth: f32,
    /// By how much the pattern grows outward. In widths.
    pub extension: f32,
    /// Growth of the pattern per unit of depth fraction. In widths.
    pub bevel: f32,
    /// Depth fraction at which the growth stops, 0 to 1.
    pub chamfer: f32,
    /// Strength of the specular reflection, 0 to 1.
    pub specular: f32,
    /// How far beside its place a ray may be searched in the accurate tier. In pixels.
    pub tolerance: f32,
    /// How far before the solid a search may end, at distance 1 from the eye; made for the width of a pixel of the exported picture. In texels.
    pub slack: f32,
    /// The cap (the mesh's surface). In linear RGB.
    pub cap_color: [f32; 3],
    /// The walls. In linear RGB.
    pub wall_color: [f32; 3],
    /// Bevels and chamfers. In linear RGB.
    pub bevel_color: [f32; 3],
    /// The floor. In linear RGB.
    pub floor_color: [f32; 3],
    /// Exponent of the specular reflection, 1 to 127.
    pub shininess: u32,
    /// 0 planar, 1 fast, 2 paper, 3 accurate; the shader is made for it.
    pub tier: u32,
    /// Not 0: there is no floor.
    pub cut_out: u32,
    /// Largest number of steps of the linear search.
    pub linear_steps: u32,
    /// Number of bisections after it.
    pub binary_steps: u32,
    /// The stored code of distance 0.
    pub map_bias: u32,
    /// log2 of the texels in one 32-bit word: 0, 1 or 2.
    pub map_packing: u32,
    /// 0 codes of 8 or 16 bits, 1 floats, 2 the paper's RGBA8; the shader is made for it.
    pub map_format: u32,
    /// 0 extrusion, 1 relief, 2 paper, 3 prisms; the shader is made for it.
    pub search: u32,
    /// Not 0: columns throw shadows; the shader is made for it.
    pub self_shadow: u32,
}

/// One corner of a triangle of the planar tier.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PlanarCorner {
    /// Position, relative to the scene's origin. In object units.
    pub position: [f32; 3],
    /// Unit normal of the smooth surface, pointing out.
    pub normal: [f32; 3],
    /// Texture coordinates, less a whole number per triangle; v grows downwards. In repeats.
    pub uv: [f32; 2],
    /// Gradient of u, orthogonal to the normal. In repeats / object unit.
    pub gradient_u: [f32; 3],
    /// Gradient of v, orthogonal to the normal. In repeats / object unit.
    pub gradient_v: [f32; 3],
}

/// One triangle of the planar tier.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PlanarTriangle {
    /// The corners, counter-clockwise when seen from outside.
    pub corners: [PlanarCorner; 3],
}

/// The layout of group 0: four read-only storage buffers.
pub fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
    let stages = [both, both, both, wgpu::ShaderStages::FRAGMENT];
    let entries = [0, 1, 2, 3].map(|binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: stages[binding as usize],
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    });
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("relievo"),
        entries: &entries,
    })
}
