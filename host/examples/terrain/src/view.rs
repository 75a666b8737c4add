//! A picture of the landscape: the colour of each pixel, by a ray.
//!
//! The ray steps over the height field with growing steps, and is bisected where it first
//! goes below; the soft shadow and the outline are those of Quilez ("Terrain
//! raymarching", 2002; "Soft shadows in raymarched SDFs", 2010).

use crate::noise::fbm;
use crate::terrain::{
    FULL_DETAIL, HIGHEST, LOWEST, WATER_LEVEL, coarse_height, cover, normal, smooth,
};
use glam::{UVec2, Vec2, Vec3, Vec4};
use relievo_exact::{abs, clamp, cos, div, exp, log2, max, min, normalize_or, pow, sin};
use relievo_kernel::{FromWords, ToWords};

/// How far one sees, metres.
pub const FAR: f32 = 40_000.0;

/// A camera, and the light.
#[derive(Clone, Copy, Debug, PartialEq, FromWords, ToWords)]
pub struct View {
    /// Where the camera is, metres.
    pub eye: Vec3,
    /// The distance of the picture in halves of its height: 1 sees 90° from top to bottom.
    pub focal: f32,
    /// The unit vector to the right of the picture.
    pub right: Vec3,
    /// The time, seconds: waves and clouds move.
    pub time: f32,
    /// The unit vector into the picture.
    pub forward: Vec3,
    /// How bright the picture is; 1 is usual.
    pub exposure: f32,
    /// The unit vector to the sun.
    pub sun: Vec3,
    /// How much haze is in the air; 1 is usual, 0 is none.
    pub haze: f32,
}

impl View {
    /// Returns the view from `eye` toward `target`, with light from the direction `sun`.
    pub fn new(eye: Vec3, target: Vec3, sun: Vec3, time: f32) -> View {
        let forward = normalize_or(target - eye, Vec3::Z);
        View {
            eye,
            focal: 1.7,
            right: normalize_or(forward.cross(Vec3::Y), Vec3::X),
            time,
            forward,
            exposure: 1.0,
            sun: normalize_or(sun, Vec3::Y),
            haze: 1.0,
        }
    }

    /// Returns a view over a lake to mountains, in the morning.
    pub fn overlook(time: f32) -> View {
        View::new(
            Vec3::new(4600.0, 610.0, 4200.0),
            Vec3::new(-1150.0, 150.0, -1400.0),
            Vec3::new(-0.75, 0.34, 0.8),
            time,
        )
    }

    /// Returns the unit vector from the eye through the middle of a pixel.
    fn ray(&self, pixel: UVec2, size: UVec2) -> Vec3 {
        let (width, height) = (size.x as f32, max(size.y as f32, 1.0));
        let x = div(2.0 * pixel.x as f32 + 1.0 - width, height);
        let y = div(height - 1.0 - 2.0 * pixel.y as f32, height);
        let up = self.right.cross(self.forward);
        normalize_or(self.forward * self.focal + self.right * x + up * y, Vec3::Z)
    }
}

/// A ray that starts within 1,000 km.
#[derive(Clone, Copy)]
struct Ray {
    origin: Vec3,
    direction: Vec3,
}

impl Ray {
    fn at(self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }

    /// Returns how far the point at `t` is above the ground.
    fn clearance(self, t: f32, detail: f32) -> f32 {
        let p = self.at(t);
        p.y - coarse_height(Vec2::new(p.x, p.z), detail)
    }

    /// Returns the distance at which the ray is at height `y`; `FAR` if it never is.
    fn distance_to_level(self, y: f32) -> f32 {
        let t = div(y - self.origin.y, self.direction.y);
        if abs(self.direction.y) > 1e-4 && t > 0.0 {
            min(t, FAR)
        } else {
            FAR
        }
    }
}

/// Returns the mix of two colours: `a` for 0, `b` for 1.
fn mix(a: Vec3, b: Vec3, weight: f32) -> Vec3 {
    a + (b - a) * weight
}

/// Returns the distance at which a ray meets the ground, `end` or more if it does not.
/// Steps are at least 0.5 + `growth` times the distance, and at most `steps`.
fn march(ray: Ray, end: f32, detail: f32, growth: f32, steps: u32) -> f32 {
    let mut before = 0.0;
    if ray.origin.y > HIGHEST {
        before = if ray.direction.y < 0.0 {
            ray.distance_to_level(HIGHEST)
        } else {
            FAR
        };
    }
    let mut t = before + 1.0;
    let mut above = 1.0;
    let mut step = 0;
    let mut searching = true;
    while searching {
        above = ray.clearance(t, detail);
        searching = above > 0.0 && t < end && step < steps;
        if searching {
            before = t;
            t += max(0.45 * above, 0.5 + growth * t);
            // Nothing is higher.
            if ray.direction.y > 0.0 && ray.at(t).y > HIGHEST {
                t = FAR;
            }
            step += 1;
        }
    }
    if above > 0.0 {
        return FAR;
    }
    let mut halving = 0;
    while halving < 9 {
        let middle = 0.5 * (before + t);
        if ray.clearance(middle, detail) > 0.0 {
            before = middle;
        } else {
            t = middle;
        }
        halving += 1;
    }
    t
}

/// Returns how much of the sun is seen from a point, 0 to 1.
fn sunlight(point: Vec3, sun: Vec3) -> f32 {
    let ray = Ray {
        origin: point,
        direction: sun,
    };
    let mut light = 1.0;
    let mut t = 15.0;
    let mut step = 0;
    while light > 0.0 && step < 22 && t < 9000.0 {
        let above = ray.clearance(t, 6.0);
        light = min(light, div(14.0 * above, t));
        t += max(0.5 * above, 8.0 + 0.09 * t);
        step += 1;
    }
    let light = clamp(light, 0.0, 1.0);
    light * light * (3.0 - 2.0 * light)
}

/// Returns the colour of sunlight: red when the sun is low.
fn sun_color(sun: Vec3) -> Vec3 {
    mix(
        Vec3::new(1.9, 0.85, 0.38),
        Vec3::new(1.75, 1.55, 1.3),
        smooth(sun.y, 0.0, 2.2),
    )
}

/// Returns the colour of the sky in a direction, with the sun and its glow, without clouds.
fn clear_sky(direction: Vec3, sun: Vec3) -> Vec3 {
    let up = clamp(direction.y, 0.0, 1.0);
    let toward = clamp(direction.dot(sun), 0.0, 1.0);
    let zenith = Vec3::new(0.10, 0.24, 0.58);
    let horizon = Vec3::new(0.52, 0.62, 0.74);
    let haze = exp(-6.0 * up);
    let blue = mix(zenith, horizon, haze);
    let glow = pow(toward, 6.0) * 0.25 * (0.3 + haze) + pow(toward, 60.0) * 0.35;
    blue + sun_color(sun) * glow
}

/// Returns the colour of the sky with sun and clouds.
fn sky(direction: Vec3, view: &View) -> Vec3 {
    const CLOUD_HEIGHT: f32 = 3500.0;
    const PER_CLOUD: f32 = 1.0 / 3800.0;
    let mut color = clear_sky(direction, view.sun);
    let toward = direction.dot(view.sun);
    color += sun_color(view.sun) * (12.0 * smooth(toward, 0.9997, 5000.0));
    if direction.y > 0.02 {
        let t = div(CLOUD_HEIGHT, direction.y);
        let p = Vec2::new(
            view.eye.x + direction.x * t + 12.0 * view.time,
            view.eye.z + direction.z * t,
        );
        let density = fbm(p * PER_CLOUD, 77, 6).value;
        let lit = fbm(
            (p + Vec2::new(view.sun.x, view.sun.z) * 500.0) * PER_CLOUD,
            77,
            4,
        )
        .value;
        let thick = smooth(density, -0.02, 2.2) * smooth(direction.y, 0.03, 4.5);
        let light = clamp(0.75 - 0.9 * lit, 0.35, 1.0);
        let cloud = mix(
            Vec3::new(0.42, 0.48, 0.58),
            sun_color(view.sun) * 0.75,
            light,
        );
        color = mix(color, cloud, 0.85 * thick);
    }
    color
}

/// Returns `color` seen through `distance` metres of air.
fn fog(color: Vec3, distance: f32, direction: Vec3, view: &View) -> Vec3 {
    const THICKNESS: f32 = 1.0 / 21_000.0;
    let level = normalize_or(Vec3::new(direction.x, 0.04, direction.z), Vec3::Z);
    let air = clear_sky(level, view.sun) * 0.92;
    let depth = clamp(distance * view.haze * THICKNESS, 0.0, 5.0);
    let clear = exp(-depth * (depth + 0.5));
    // Blue is scattered first.
    mix(air, color, clear) + Vec3::new(0.0, 0.004, 0.018) * (clear * (1.0 - clear))
}

/// Returns the colour of the ground where a ray meets it at `t`.
fn ground(ray: Ray, t: f32, view: &View) -> Vec3 {
    let point = ray.at(t);
    let p = Vec2::new(point.x, point.z);
    // What is smaller than a pixel is left out.
    let detail = clamp(20.5 - log2(max(t, 1.0)), 5.0, FULL_DETAIL);
    let normal = normal(p, 0.4 + 0.0012 * t, detail);
    let cover = cover(p, point.y, normal);
    // Stones and trees, as far as they are seen.
    let near = exp(-t * 0.0003);
    let bumps = fbm(p * 0.027, 5, 4);
    let mottle = 1.0 + 0.9 * near * bumps.value;
    let rough = bumps.slope * ((0.22 - 0.15 * cover.snow) * near);
    let normal = normalize_or(normal - Vec3::new(rough.x, 0.0, rough.y), Vec3::Y);
    let strata = 1.0 + 0.18 * sin(0.055 * point.y + 2.0 * mottle) * exp(-t * 0.0004);
    let albedo = Vec3::new(0.86, 0.90, 0.96) * cover.snow
        + Vec3::new(0.145, 0.115, 0.095) * (cover.rock * mottle * strata)
        + Vec3::new(0.022, 0.052, 0.016) * (cover.forest * mottle)
        + Vec3::new(0.085, 0.125, 0.03) * (cover.grass * mottle)
        + Vec3::new(0.34, 0.27, 0.17) * cover.sand;

    let direct = max(normal.dot(view.sun), 0.0);
    let shade = if direct > 0.0 {
        sunlight(point + normal * (1.0 + 0.002 * t), view.sun)
    } else {
        0.0
    };
    let dome = 0.5 + 0.5 * normal.y;
    let back = Vec3::new(-view.sun.x, 0.0, -view.sun.z);
    let bounce = clamp(0.5 + 0.5 * normal.dot(back), 0.0, 1.0);
    let light = sun_color(view.sun) * (2.6 * direct * shade)
        + Vec3::new(0.20, 0.32, 0.52) * (dome * 0.7)
        + sun_color(view.sun) * (0.10 * bounce);
    albedo * light
}

/// Water where a ray meets it.
struct Water {
    /// The colour of the water itself.
    body: Vec3,
    /// How much it reflects, 0 to 1.
    fresnel: f32,
    /// The reflected ray.
    reflected: Ray,
}

/// Returns the water where a ray meets it at `t`.
fn water(ray: Ray, t: f32, view: &View) -> Water {
    let point = ray.at(t);
    let p = Vec2::new(point.x, point.z);
    // The slope of waves of the sines in five directions, lower the farther they are.
    let mut slope = Vec2::ZERO;
    let mut angle = 0.6;
    let mut frequency = 0.09;
    let mut wave = 0;
    while wave < 5 {
        let along = Vec2::new(cos(angle), sin(angle));
        let seen = exp(-min(t * frequency * 0.012, 30.0));
        let phase = p.dot(along) * frequency + view.time * (0.6 + 3.0 * frequency);
        slope += along * (0.016 * seen * cos(phase));
        angle += 2.1;
        frequency *= 1.9;
        wave += 1;
    }
    let rough = fbm(p * 0.02 + Vec2::new(0.3 * view.time, 0.0), 9, 3).slope
        * (0.006 * exp(-min(t * 0.0012, 30.0)));
    let normal = normalize_or(
        Vec3::new(-slope.x - rough.x, 1.0, -slope.y - rough.y),
        Vec3::Y,
    );

    let facing = max(-ray.direction.dot(normal), 0.0);
    let mut mirrored = ray.direction + normal * (2.0 * facing);
    mirrored.y = abs(mirrored.y) + 0.002;
    let mirrored = normalize_or(mirrored, Vec3::Y);
    let away = Ray {
        origin: Vec3::new(p.x, WATER_LEVEL + 0.5, p.y),
        direction: mirrored,
    };

    let depth = WATER_LEVEL - coarse_height(p, 8.0);
    let light = sunlight(away.origin, view.sun);
    let shallow = exp(-max(depth, 0.0) * 0.12);
    let body = mix(
        Vec3::new(0.006, 0.035, 0.05),
        Vec3::new(0.09, 0.20, 0.17),
        shallow,
    );
    // Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994.
    let grazing = 1.0 - clamp(facing, 0.0, 1.0);
    let squared = grazing * grazing;
    let fresnel = 0.02 + 0.98 * squared * squared * grazing;
    Water {
        body: body * (0.45 + light),
        fresnel,
        reflected: away,
    }
}

/// Returns the response of film to light (Narkowicz, "ACES Filmic Tone Mapping Curve",
/// 2016), 0 to 1.
fn film(x: f32) -> f32 {
    let x = clamp(x * 0.8, 0.0, 1000.0);
    clamp(
        div(x * (2.51 * x + 0.03), x * (2.43 * x + 0.59) + 0.14),
        0.0,
        1.0,
    )
}

/// Returns the linear red, green and blue of a pixel, 0 to 1, and 1. The pixel 0, 0 is at
/// the upper left.
pub fn color(pixel: UVec2, size: UVec2, view: &View) -> Vec4 {
    let mut ray = Ray {
        origin: view.eye,
        direction: view.ray(pixel, size),
    };
    let mut level = if view.eye.y > WATER_LEVEL {
        ray.distance_to_level(WATER_LEVEL)
    } else {
        FAR
    };
    let mut end = min(level, ray.distance_to_level(LOWEST));
    let (mut detail, mut growth, mut steps) = (7.0, 0.003, 220);
    // The ray, and the one that water reflects.
    let mut first = Water {
        body: Vec3::ZERO,
        fresnel: 1.0,
        reflected: ray,
    };
    let mut water_at = FAR;
    let mut seen = Vec3::ZERO;
    let mut rays = 1;
    while rays > 0 {
        rays -= 1;
        let t = march(ray, end, detail, growth, steps);
        if t < min(end, FAR) {
            seen = fog(ground(ray, t, view), t, ray.direction, view);
        } else if level < FAR {
            first = water(ray, level, view);
            water_at = level;
            ray = first.reflected;
            level = FAR;
            end = FAR * 0.4;
            (detail, growth, steps) = (6.0, 0.04, 90);
            rays = 1;
        } else {
            seen = sky(ray.direction, view);
        }
    }
    if water_at < FAR {
        let direction = view.ray(pixel, size);
        seen = fog(
            mix(first.body, seen, first.fresnel),
            water_at,
            direction,
            view,
        );
    }
    let exposed = seen * view.exposure;
    Vec4::new(film(exposed.x), film(exposed.y), film(exposed.z), 1.0)
}
