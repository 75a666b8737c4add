// Maps the words of one picture, or of two side by side, to screen colours, like
// display.rs on the CPU.

struct Present {
    // Code of the quantity shown (display::Show).
    show: u32,
    // Width of the left picture, pixels.
    split: u32,
    near: f32,
    far: f32,
    steps: f32,
    unused_0: u32,
    unused_1: u32,
    unused_2: u32,
}

@group(0) @binding(0) var<uniform> present: Present;
@group(0) @binding(1) var left_0: texture_2d<u32>;
@group(0) @binding(2) var left_1: texture_2d<u32>;
@group(0) @binding(3) var right_0: texture_2d<u32>;
@group(0) @binding(4) var right_1: texture_2d<u32>;

@vertex
fn whole(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(index & 1u) * 4 - 1);
    let y = f32(i32(index >> 1u) * 4 - 1);
    return vec4(x, y, 0.0, 1.0);
}

fn encode(linear: f32) -> f32 {
    let x = clamp(linear, 0.0, 1.0);
    if x <= 0.0031308 {
        return 12.92 * x;
    }
    return 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

fn heat(share: f32) -> vec3<f32> {
    let x = 2.0 * clamp(share, 0.0, 1.0);
    let low = vec3(0.15, 0.05, 0.40);
    let middle = vec3(0.10, 0.60, 0.45);
    let high = vec3(1.0, 0.90, 0.20);
    if x < 1.0 {
        return mix(low, middle, x);
    }
    return mix(middle, high, x - 1.0);
}

@fragment
fn shown(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<u32>(position.xy);
    var first: vec4<u32>;
    var second: vec4<u32>;
    if at.x < present.split {
        first = textureLoad(left_0, at, 0);
        second = textureLoad(left_1, at, 0);
    } else {
        first = textureLoad(right_0, at, 0);
        second = textureLoad(right_1, at, 0);
    }
    let place = bitcast<vec4<f32>>(first);
    if present.show == 0u {
        return vec4(encode(place.x), encode(place.y), encode(place.z), 1.0);
    }
    let kind = second.x & 255u;
    var color = vec3(0.5);
    if kind == 0u {
        return vec4(color, 1.0);
    }
    switch present.show {
        case 1u: {
            switch kind {
                case 1u: { color = vec3(0.95, 0.78, 0.25); }
                case 2u: { color = vec3(0.80, 0.35, 0.20); }
                case 3u: { color = vec3(0.55, 0.75, 0.40); }
                case 4u: { color = vec3(0.20, 0.40, 0.65); }
                default: { color = vec3(1.0, 0.0, 1.0); }
            }
        }
        case 2u: { color = 0.5 * bitcast<vec3<f32>>(second.yzw) + 0.5; }
        case 3u: {
            color = vec3(1.0 - clamp((place.x - present.near) / (present.far - present.near), 0.0, 1.0));
        }
        case 4u: { color = vec3(place.yz - floor(place.yz), 0.0); }
        case 5u: { color = vec3(clamp(place.w, 0.0, 1.0)); }
        case 6u: { color = heat(f32(second.x >> 8u) / present.steps); }
        default: {}
    }
    return vec4(color, 1.0);
}
