// Plain triangles with the light of the extrusions (shared/src/light.rs).

struct Uniforms {
    // From positions to clip coordinates; the depth is reversed, without a far plane.
    clip: mat4x4f,
    eye: vec4f,
    to_light: vec4f,
    light: vec4f,
    ambient: vec4f,
    // Specular share and exponent.
    gloss: vec4f,
    // By surface class.
    colors: array<vec4f, 8>,
}

@group(0) @binding(0) var<uniform> uniforms: Uniforms;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) @interpolate(flat, first) surface: u32,
}

@vertex
fn vertex(@location(0) position: vec3f, @location(1) packed: u32) -> Varying {
    let normal = unpack4x8snorm(packed).xyz;
    return Varying(uniforms.clip * vec4f(position, 1.0), position, normal, packed >> 24u);
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    let normal = normalize(in.normal);
    let direction = normalize(in.position - uniforms.eye.xyz);
    let cosine = max(dot(normal, uniforms.to_light.xyz), 0.0);
    let half_way = normalize(uniforms.to_light.xyz - direction);
    var highlight = 0.0;
    if cosine > 0.0 {
        highlight = uniforms.gloss.x * pow(max(dot(normal, half_way), 0.0), uniforms.gloss.y);
    }
    let color = uniforms.colors[in.surface].xyz * (uniforms.ambient.xyz + uniforms.light.xyz * cosine)
        + uniforms.light.xyz * highlight;
    return vec4f(color, f32(in.surface));
}
