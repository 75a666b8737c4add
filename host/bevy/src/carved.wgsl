// Draws a carved object in every pass of Bevy. `relievo_hit` and its buffers stand before this.

// The parameters of the object that are Bevy's.
struct Carving {
    // The object's origin in the space of the mesh, and the radius of a ball around the object.
    ball: vec4<f32>,
    // Repeats of the pattern along u and v.
    repeat: vec2<f32>,
    // Base colours of cap, wall, bevel and floor, and of cap, wall and bevel of further layers; an alpha
    // of 0 keeps the material's.
    colors: array<vec4<f32>, FINISHES>,
    // Their roughness and metallic; a negative number keeps the material's.
    finishes: array<vec4<f32>, FINISHES>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> carving: Carving;

struct Vertex {
    @builtin(instance_index) instance: u32,
    @location(0) position: vec3<f32>,
    @location(1) outward: vec3<f32>,
    @location(2) facing: vec3<f32>,
    @location(3) ball: vec4<f32>,
    @location(4) whole: vec2<f32>,
    @location(5) facet: u32,
}

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) facet: u32,
    @location(1) @interpolate(flat) instance: u32,
    @location(2) @interpolate(flat) whole: vec2<f32>,
}

fn is_orthographic() -> bool {
    return view.clip_from_view[3].w == 1.0;
}

// Distance of the near plane from the eye, world units.
fn near_plane() -> f32 {
    let near = view.view_from_clip * vec4<f32>(0.0, 0.0, 1.0, 1.0);
    return -near.z / near.w;
}

@vertex
fn vertex(in: Vertex) -> Varyings {
    let world_from_local = mesh_functions::get_world_from_local(in.instance);
    let scale = length(world_from_local[0].xyz);
    var out: Varyings;
    out.facet = in.facet >> 2u;
    out.instance = in.instance;
    out.whole = in.whole;

    // The facet grows by this on each side, so that no pixel is left out between two of them.
#ifdef RELIEVO_MULTISAMPLED
    // All samples of a pixel have what the ray through its centre hits: none lies as far from it.
    let pixels = 0.75;
#else
    let pixels = 0.25;
#endif
    let place = world_from_local * vec4<f32>(in.position, 1.0);
    let corner = view.clip_from_world * place;
    let pixel = 2.0 * abs(corner.w) / (view.viewport.w * abs(view.clip_from_view[1].y));
    // What is seen from the side grows by less in the picture.
    let forward = -view.world_from_view[2].xyz;
    let towards = normalize(select(place.xyz - view.world_position, forward, is_orthographic()));
    let normal = (world_from_local * vec4<f32>(in.facing, 0.0)).xyz / scale;
    let foreshortening = select(1.0, max(abs(dot(normal, towards)), 0.05), any(in.facing != vec3<f32>()));
    let position = in.position + in.outward * (pixels * pixel / (scale * foreshortening));
    out.position = view.clip_from_world * (world_from_local * vec4<f32>(position, 1.0));
    // What is in front of the near plane still has rays that go on behind it.
    out.position.z = min(out.position.z, out.position.w);

    let centre = (world_from_local * vec4<f32>(in.ball.xyz, 1.0)).xyz;
    let reach = in.ball.w * scale + 1.5 * near_plane();
    if !is_orthographic() && distance(centre, view.world_position) <= reach {
        // The shell may hold the eye: any ray may start in it.
        let index = in.facet & 3u;
        let x = select(-1.0, 3.0, index == 1u);
        let y = select(-1.0, 3.0, index == 2u);
        out.position = select(vec4<f32>(x, y, 1.0, 1.0), vec4<f32>(2.0, 2.0, 1.0, 1.0), index == 3u);
    }
    return out;
}

// What a pixel hits.
struct Found {
    surface_class: u32,
    // Index of its finish.
    finish: u32,
    world_position: vec4<f32>,
    world_normal: vec3<f32>,
    world_tangent: vec4<f32>,
    // Texture coordinates of the mesh.
    uv: vec2<f32>,
    // Position in the space of the mesh.
    position: vec3<f32>,
    depth: f32,
}

fn find(in: Varyings) -> Found {
    let world_from_local = mesh_functions::get_world_from_local(in.instance);
    let local_from_world = mesh_functions::get_local_from_world(in.instance);
    let scale = length(world_from_local[0].xyz);
    // Turns vectors from world space to that of the mesh; their length stays.
    let turn = mat3x3<f32>(local_from_world[0].xyz, local_from_world[1].xyz, local_from_world[2].xyz) * scale;
    let world_from_view = mat3x3<f32>(view.world_from_view[0].xyz, view.world_from_view[1].xyz, view.world_from_view[2].xyz);

    let place = (in.position.xy - view.viewport.xy) / view.viewport.zw;
    let ndc = place * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
    let pixel = vec2<f32>(2.0, -2.0) / view.viewport.zw;
    // Points of the near plane, in view space.
    let at = near_point(ndc);
    let right = near_point(ndc + vec2<f32>(pixel.x, 0.0)) - at;
    let down = near_point(ndc + vec2<f32>(0.0, pixel.y)) - at;
    let forward = turn * (world_from_view * vec3<f32>(0.0, 0.0, -1.0));
    var origin: vec3<f32>;
    var through: vec3<f32>;
    var near: f32;
    var per_pixel: f32;
    if is_orthographic() {
        // The ray starts before the whole object.
        let on_plane = (local_from_world * (view.world_from_view * vec4<f32>(at, 1.0))).xyz - carving.ball.xyz;
        let back = dot(on_plane, forward) + carving.ball.w;
        origin = on_plane - forward * back;
        through = forward;
        near = 1e-6 * carving.ball.w;
#ifndef RELIEVO_SHADOW
        // A shadow map has what is before its near plane, too.
        near = max(back, near);
#endif
        per_pixel = 1.0 / (2.0 * carving.ball.w * scale);
    } else {
        origin = (local_from_world * vec4<f32>(view.world_position, 1.0)).xyz - carving.ball.xyz;
        through = turn * (world_from_view * (at / -at.z));
        near = -at.z / scale;
        per_pixel = 1.0 / -at.z;
    }
    let direction = normalize(through);
    let hit = relievo_hit(
        origin,
        direction,
        forward,
        turn * (world_from_view * right) * per_pixel,
        turn * (world_from_view * down) * per_pixel,
        near,
        in.facet,
    );
    var found: Found;
    found.surface_class = hit.surface_class;
    let is_own = hit.layer == 0u || hit.surface_class == 4u;
    found.finish = select(3u * hit.layer + hit.surface_class, hit.surface_class - 1u, is_own);
    found.position = origin + direction * hit.t + carving.ball.xyz;
    found.world_position = world_from_local * vec4<f32>(found.position, 1.0);
    let back = mat3x3<f32>(world_from_local[0].xyz, world_from_local[1].xyz, world_from_local[2].xyz);
    found.world_normal = normalize(back * hit.normal);
    found.world_tangent = vec4<f32>(normalize(back * hit.tangent.xyz), hit.tangent.w);
    found.uv = (hit.uv + in.whole) / carving.repeat + vec2<f32>(0.0, 1.0);
    let clip = view.clip_from_world * found.world_position;
    found.depth = clip.z / clip.w;
    return found;
}

// The point of the near plane at a place of the picture, in view space.
fn near_point(ndc: vec2<f32>) -> vec3<f32> {
    let point = view.view_from_clip * vec4<f32>(ndc, 1.0, 1.0);
    return point.xyz / point.w;
}

#ifdef PREPASS_PIPELINE

struct Output {
#ifdef NORMAL_PREPASS
    @location(0) normal: vec4<f32>,
#endif
#ifdef MOTION_VECTOR_PREPASS
    @location(1) motion_vector: vec2<f32>,
#endif
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fragment(in: Varyings) -> Output {
    let found = find(in);
    if found.surface_class == 0u {
        discard;
    }
    var out: Output;
    out.depth = min(found.depth, 1.0);
#ifdef NORMAL_PREPASS
    out.normal = vec4<f32>(found.world_normal * 0.5 + 0.5, 1.0);
#endif
#ifdef MOTION_VECTOR_PREPASS
    let before = mesh_functions::get_previous_world_from_local(in.instance) * vec4<f32>(found.position, 1.0);
    let clip = view.unjittered_clip_from_world * found.world_position;
    let clip_before = prepass_bindings::previous_view_uniforms.clip_from_world * before;
    out.motion_vector = (clip.xy / clip.w - clip_before.xy / clip_before.w) * vec2<f32>(0.5, -0.5);
#endif
    return out;
}

#else // PREPASS_PIPELINE

struct Output {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fragment(in: Varyings) -> Output {
    let found = find(in);
    if found.surface_class == 0u {
        discard;
    }
    var surface: VertexOutput;
    surface.position = vec4<f32>(in.position.xy, found.depth, in.position.w);
    surface.world_position = found.world_position;
    surface.world_normal = found.world_normal;
    surface.world_tangent = found.world_tangent;
    surface.uv = found.uv;
    surface.instance_index = in.instance;
    var pbr_input = pbr_input_from_standard_material(surface, true);

    let color = carving.colors[found.finish];
    let finish = carving.finishes[found.finish];
    pbr_input.material.base_color = select(pbr_input.material.base_color, vec4<f32>(color.rgb, 1.0), color.a > 0.0);
    pbr_input.material.perceptual_roughness = select(pbr_input.material.perceptual_roughness, finish.x, finish.x >= 0.0);
    pbr_input.material.metallic = select(pbr_input.material.metallic, finish.y, finish.y >= 0.0);
    pbr_input.material.base_color = alpha_discard(pbr_input.material, pbr_input.material.base_color);
    apply_decals(&pbr_input);

    var out: Output;
    if (pbr_input.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        out.color = apply_pbr_lighting(pbr_input);
    } else {
        out.color = pbr_input.material.base_color;
    }
    out.color = main_pass_post_lighting_processing(pbr_input, out.color);
    out.depth = found.depth;
#ifdef DEPTH_PREPASS
    // The prepass has the same depth, but another shader may have rounded otherwise.
    out.depth *= 1.00001;
#endif
    return out;
}

#endif // PREPASS_PIPELINE
