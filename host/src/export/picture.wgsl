// Calls relievo_hit for each pixel of a picture: entry points to build those of an engine from.

// Camera, picture and light; see README.md.
struct RelievoFrame {
    eye: array<f32, 3>,
    near: f32,
    right: array<f32, 3>,
    up: array<f32, 3>,
    forward: array<f32, 3>,
    ray_first: array<f32, 3>,
    ray_right: array<f32, 3>,
    ray_down: array<f32, 3>,
    light_direction: array<f32, 3>,
    light_color: array<f32, 3>,
    ambient: array<f32, 3>,
    size: array<f32, 2>,
    unit: f32,
    axes: array<array<f32, 3>, 3>,
    number: u32,
}

struct RelievoFrameData {
    at: array<RelievoFrame>,
}

@group(GROUP) @binding(FIRST_BINDING)
var<storage> relievo_frames: RelievoFrameData;

// Whether the first row of pixels is the lowest.
const RELIEVO_ROWS_UPWARDS = false;

fn relievo_vector(a: array<f32, 3>) -> vec3<f32> {
    return vec3<f32>(a[0], a[1], a[2]);
}

struct RelievoPixel {
    hit: RelievoHit,
    // Unit vector from the eye.
    direction: vec3<f32>,
    // near / distance along the view axis.
    depth: f32,
}

// The vector from the eye to the centre of a pixel.
fn relievo_through(position: vec4<f32>) -> vec3<f32> {
    let frame = relievo_frames.at[0];
    let x = floor(position.x);
    let y = floor(select(position.y, frame.size[1] - position.y, RELIEVO_ROWS_UPWARDS));
    return relievo_vector(frame.ray_first) + relievo_vector(frame.ray_right) * x + relievo_vector(frame.ray_down) * y;
}

// What a pixel hits over a facet.
fn relievo_pixel(position: vec4<f32>, facet: u32) -> RelievoPixel {
    let frame = relievo_frames.at[0];
    let forward = relievo_vector(frame.forward);
    let right = relievo_vector(frame.ray_right);
    let down = relievo_vector(frame.ray_down);
    let through = relievo_through(position);
    let direction = through * (1.0 / sqrt(dot(through, through)));
    let hit = relievo_hit(relievo_vector(frame.eye), direction, forward, right, down, frame.near, facet);
    return RelievoPixel(hit, direction, frame.near / (hit.t * dot(direction, forward)));
}

struct RelievoForward {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

// Linear RGB: the colour of the class, lit by one directional light.
@fragment
fn fs_main(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) facet: u32) -> RelievoForward {
    let pixel = relievo_pixel(position, facet);
    let hit = pixel.hit;
    if hit.surface_class == 0u {
        discard;
    }
    var base_color = relievo_vector(relievo_object.at.cap_color);
    if hit.surface_class == 2u {
        base_color = relievo_vector(relievo_object.at.wall_color);
    } else if hit.surface_class == 3u {
        base_color = relievo_vector(relievo_object.at.bevel_color);
    } else if hit.surface_class == 4u {
        base_color = relievo_vector(relievo_object.at.floor_color);
    }
    let frame = relievo_frames.at[0];
    let cosine = max(dot(hit.normal, relievo_vector(frame.light_direction)), 0.0);
    let color = base_color * (relievo_vector(frame.ambient) + relievo_vector(frame.light_color) * cosine);
    return RelievoForward(vec4<f32>(color, 1.0), pixel.depth);
}

// The depth alone, for a depth prepass or a shadow map.
@fragment
fn fs_depth(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) facet: u32) -> @builtin(frag_depth) f32 {
    let pixel = relievo_pixel(position, facet);
    if pixel.hit.surface_class == 0u {
        discard;
    }
    return pixel.depth;
}

// The same of an orthographic camera, whose frame is in README.md: 1 - distance from the eye's plane / near.
@fragment
fn fs_depth_orthographic(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) facet: u32) -> @builtin(frag_depth) f32 {
    let frame = relievo_frames.at[0];
    let forward = relievo_vector(frame.forward);
    let origin = relievo_vector(frame.eye) + relievo_through(position);
    // Parallel rays are as wide everywhere as those of a perspective camera on the far plane.
    let right = relievo_vector(frame.ray_right) / frame.near;
    let down = relievo_vector(frame.ray_down) / frame.near;
    let hit = relievo_hit(origin, forward, forward, right, down, 1e-6 * frame.near, facet);
    if hit.surface_class == 0u || hit.t > frame.near {
        discard;
    }
    return 1.0 - hit.t / frame.near;
}

struct RelievoGeometry {
    // Distance from the eye (world units), texture coordinates, depth fraction.
    @location(0) place: vec4<f32>,
    // Unit normal of the carved surface, and the class.
    @location(1) surface: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

// A geometry buffer.
@fragment
fn fs_geometry(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) facet: u32) -> RelievoGeometry {
    let pixel = relievo_pixel(position, facet);
    let hit = pixel.hit;
    if hit.surface_class == 0u {
        discard;
    }
    let place = vec4<f32>(hit.t * relievo_frames.at[0].unit, hit.uv, hit.depth_fraction);
    return RelievoGeometry(place, vec4<f32>(hit.normal, f32(hit.surface_class)), pixel.depth);
}
