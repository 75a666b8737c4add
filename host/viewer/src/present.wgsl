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
    // Factor of the exposure.
    gain: f32,
    // Whether the tone curve is AgX.
    is_agx: u32,
    unused: u32,
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

// AgX, as relievo::tone has it.
fn agx(light: vec3<f32>) -> vec3<f32> {
    let to_wide = mat3x3(0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0113, 0.8956);
    let from_wide = mat3x3(1.6605, -0.1246, -0.0182, -0.5876, 1.1329, -0.1006, -0.0728, -0.0083, 1.1187);
    let inset = mat3x3(
        0.85662715, 0.13731897, 0.11189821,
        0.09512124, 0.761242, 0.07679942,
        0.048251606, 0.10143904, 0.81130237,
    );
    let outset = mat3x3(
        1.1271006, -0.14132976, -0.14132976,
        -0.11060664, 1.1578237, -0.11060664,
        -0.016493939, -0.016493939, 1.2519364,
    );
    let stops = (log2(max(inset * (to_wide * light), vec3(1e-10))) + 12.47393) / (4.026069 + 12.47393);
    let x = clamp(stops, vec3(0.0), vec3(1.0));
    let x2 = x * x;
    let x4 = x2 * x2;
    let curve = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    return from_wide * pow(max(outset * curve, vec3(0.0)), vec3(2.2));
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

fn first_words(at: vec2<i32>, is_left: bool) -> vec4<u32> {
    if is_left {
        return textureLoad(left_0, at, 0);
    }
    return textureLoad(right_0, at, 0);
}

// Returns the light in half words, as relievo_shared::shading::edges has them.
fn from_halves(words: vec3<u32>) -> vec3<f32> {
    let codes = words & vec3(0xffffu);
    return select(bitcast<vec3<f32>>((codes + vec3(95u << 10u)) << vec3(13u)), vec3(0.0), codes == vec3(0u));
}

// Returns the colour of what a pixel hits.
fn developed(words: vec4<u32>) -> vec3<f32> {
    if (words.w >> 25u) != 0u {
        return tone(from_halves(words.xyz));
    }
    let light = bitcast<vec3<f32>>(words.xyz);
    // The background keeps its colour.
    if (words.w & 255u) == 0u {
        return light;
    }
    return tone(light);
}

// Returns the colour of a pixel without its neighbours', but with what lies between it and them.
fn developed_with_between(words: vec4<u32>) -> vec3<f32> {
    let between = words.w >> 25u;
    let own = developed(words);
    if between == 0u {
        return own;
    }
    return mix(own, tone(from_halves(words.xyz >> vec3(16u))), f32(between) / 127.0);
}

fn tone(light: vec3<f32>) -> vec3<f32> {
    if present.is_agx != 0u {
        return agx(light * present.gain);
    }
    return light * present.gain;
}

@fragment
fn shown(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    let is_left = u32(at.x) < present.split;
    let first = first_words(at, is_left);
    if present.show == 0u {
        // The shares of neighbours, as relievo_shared::shading::edges has them.
        let shares = vec2<f32>(vec2(first.w >> 8u, first.w >> 16u) & vec2(255u)) / 510.0;
        let along = select(vec2(1, 0), vec2(0, 1), (first.w & (1u << 24u)) != 0u);
        var light = developed_with_between(first) * (1.0 - shares.x - shares.y);
        if shares.x > 0.0 {
            light += developed(first_words(at - along, is_left)) * shares.x;
        }
        if shares.y > 0.0 {
            light += developed(first_words(at + along, is_left)) * shares.y;
        }
        return vec4(encode(light.x), encode(light.y), encode(light.z), 1.0);
    }
    var second: vec4<u32>;
    if is_left {
        second = textureLoad(left_1, at, 0);
    } else {
        second = textureLoad(right_1, at, 0);
    }
    let place = bitcast<vec4<f32>>(first);
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
