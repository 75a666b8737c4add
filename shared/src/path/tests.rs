use super::*;
use crate::exit::Exit;
use crate::layout::{TIER_FAST, TIER_PLANAR};
use crate::model::quadric::{LEAST_ANGLE, LEAST_BEND};

use crate::shape_map::tests::Random;

/// A ray over a quadric patch: the inputs of section 4, in f64.
#[derive(Clone, Copy, Debug)]
struct Ray {
    quadric: [f64; 3],
    facet_depth: f64,
    direction: [f64; 3],
    facet_t: f64,
    depth: f64,
}

impl Ray {
    /// Any curvature, depth and direction; the unit of length spans six
    /// orders of magnitude, and zeros are frequent.
    fn random(random: &mut Random) -> Ray {
        let unit = random.magnitude(1e-3, 1e3);
        let curvature = random.choose(&[0.0, 1e-6, 1e-3, 0.3, 3.0]) / unit;
        let entry = |random: &mut Random| curvature * random.within(-1.0, 1.0);
        let z = random.choose(&[0.0, 1e-4, 0.1, 1.0]) * random.within(-1.0, 1.0);
        let angle = random.within(0.0, std::f64::consts::TAU);
        let tangential = (1.0 - z * z).sqrt();
        Ray {
            quadric: [entry(random), entry(random), entry(random)],
            facet_depth: random.choose(&[0.0, 1e-4, 0.1]) * random.within(-1.0, 1.0) * unit,
            direction: [tangential * angle.cos(), tangential * angle.sin(), -z],
            facet_t: random.within(-1.0, 10.0) * unit,
            depth: random.magnitude(1e-3, 1.0) * unit,
        }
        .narrowed()
    }

    /// Rounded to f32, so that both sides start from the same numbers.
    fn narrowed(self) -> Ray {
        let narrow = |x: f64| f64::from(x as f32);
        Ray {
            quadric: self.quadric.map(narrow),
            facet_depth: narrow(self.facet_depth),
            direction: self.direction.map(narrow),
            facet_t: narrow(self.facet_t),
            depth: narrow(self.depth),
        }
    }

    fn path(&self, tier: u32) -> QuadraticPath {
        QuadraticPath::new(
            &test_surface(self.quadric.map(|q| q as f32), self.facet_depth as f32),
            vec3(self.direction.map(|x| x as f32)),
            self.facet_t as f32,
            self.depth as f32,
            tier,
        )
    }

    fn v_z(&self) -> f64 {
        -self.direction[2]
    }

    /// Q V.
    fn turn(&self) -> [f64; 2] {
        let ([xx, xy, yy], [x, y, _]) = (self.quadric, self.direction);
        [xx * x + 0.5 * xy * y, 0.5 * xy * x + yy * y]
    }

    /// q of section 4.
    fn section_q(&self) -> f64 {
        self.turn()[0] * self.direction[0] + self.turn()[1] * self.direction[1]
    }

    /// |V|² along the surface.
    fn tangential(&self) -> f64 {
        self.direction[0].powi(2) + self.direction[1].powi(2)
    }

    /// ½ k S_z.
    fn half_bend(&self) -> f64 {
        let [x, y] = self.turn();
        let turn_squared = x * x + y * y;
        let least = (self.section_q().powi(2)).max(self.tangential() * turn_squared / 16.0);
        if least <= 1e-36 {
            return 0.0;
        }
        (turn_squared / least * self.section_q() * self.depth).clamp(-0.25, 0.25)
    }

    /// q + ½ k V_z².
    fn q(&self) -> f64 {
        self.section_q() + self.half_bend() / self.depth * self.v_z().powi(2)
    }

    /// By how much the texture coordinates bend: 2 Q V, where that is small.
    fn shift(&self) -> [f64; 2] {
        let [x, y] = self.turn();
        let reach = 16.0 * self.depth.powi(2) * (x * x + y * y);
        let share = if reach > self.tangential() {
            self.tangential() / reach
        } else {
            1.0
        };
        [2.0 * share * x, 2.0 * share * y]
    }

    /// δ where d − ½ k d² is `even`.
    fn fraction_of(&self, even: f64) -> f64 {
        let half_bend = self.half_bend();
        let even = even / (self.depth * (1.0 - half_bend));
        even * (1.0 - half_bend * (1.0 + half_bend) * (1.0 - even))
    }

    fn radicand(&self) -> f64 {
        self.v_z().powi(2) + 4.0 * self.q() * self.facet_depth
    }

    /// R.
    fn root(&self) -> f64 {
        if self.radicand() < 0.0 {
            self.v_z().abs()
        } else {
            self.radicand().sqrt()
        }
    }

    /// Not away from a flat or hollow cap, which never comes back.
    fn enters(&self) -> bool {
        self.q() > 0.0 || self.v_z() + self.root() > 0.0
    }

    /// δ0 as it counts: none where the quadric does not reach the facet.
    fn counted_facet_depth(&self) -> f64 {
        if self.radicand() < 0.0 {
            0.0
        } else {
            self.facet_depth
        }
    }

    /// d − ½ k d² at the distance `s` from the facet.
    fn depth_at(&self, s: f64) -> f64 {
        self.counted_facet_depth() + s * (self.v_z() - self.q() * s)
    }

    /// The size of the terms of [`Ray::depth_at`], which rounding is relative to.
    fn scale_at(&self, s: f64) -> f64 {
        self.facet_depth.abs() + (self.v_z() * s).abs() + (self.q() * s * s).abs()
    }

    /// Whether no small number counts as 0.
    fn counts(&self) -> bool {
        let counts = |x: f64, least: f32| x == 0.0 || x.abs() > 1.01 * f64::from(least);
        self.direction.into_iter().all(|x| counts(x, LEAST_ANGLE))
            && self
                .turn()
                .into_iter()
                .all(|x| counts(x * self.depth, LEAST_BEND))
            && counts(self.facet_depth / self.depth, LEAST_BEND)
    }

    /// Where one rounding decides between two answers, or where q or V_z + R
    /// is the difference of larger numbers, f32 cannot agree with f64.
    fn well_conditioned(&self) -> bool {
        let terms = self.v_z().powi(2) + (4.0 * self.q() * self.facet_depth).abs();
        let [x, y, _] = self.direction.map(f64::abs);
        let q_terms = self.quadric[0].abs() * x * x
            + self.quadric[1].abs() * x * y
            + self.quadric[2].abs() * y * y;
        self.counts()
            && (self.radicand().abs() > 1e-3 * terms || terms == 0.0)
            && self.section_q().abs() >= 0.1 * q_terms
            && (q_terms == 0.0 || self.section_q().abs() > 1e-15)
            && (self.q() == 0.0 || self.q().abs() > 1e-15)
            && (self.q() >= 0.0 || self.v_z() + self.root() > 0.1 * self.root() || !self.enters())
    }
}

fn well_conditioned(seed: u64) -> impl Iterator<Item = Ray> {
    let mut random = Random(seed);
    (0..100_000)
        .map(move |_| Ray::random(&mut random))
        .filter(Ray::well_conditioned)
}

#[test]
fn depth_and_texture_coordinates_follow_section_4() {
    let (mut entering, mut to_floor, mut to_cap) = (0, 0, 0);
    for ray in well_conditioned(1) {
        let path = ray.path(TIER_FAST);
        let v_z = ray.v_z();
        if path.slope > 0.0 {
            assert_eq!(path.enters, ray.enters(), "{ray:?}");
        }
        // Along a flat cap the depth stays δ0: `grazing_rays` looks at these.
        let along = v_z == 0.0 && ray.q() == 0.0;
        if !path.enters || along {
            continue;
        }
        entering += 1;
        let entry = f64::from(path.entry_from_facet);
        // The cap is where the ray enters.
        let scale = ray.scale_at(entry);
        assert!(
            ray.depth_at(entry).abs() <= 4e-6 * scale,
            "{ray:?} {path:?}"
        );
        let entry_t = f64::from(path.entry_t);
        assert!((entry_t - ray.facet_t - entry).abs() <= 1e-6 * (ray.facet_t.abs() + entry.abs()));
        // There it goes down, not up.
        assert!(path.slope >= 0.0);

        let end = f64::from(path.end());
        for fraction in [0.1, 0.5, 0.9, 1.0] {
            let s = end * fraction;
            let from_facet = entry + s;
            let expected = ray.fraction_of(ray.depth_at(from_facet));
            let scale = (ray.scale_at(from_facet) + ray.scale_at(entry)) / ray.depth;
            let found = f64::from(path.depth_fraction(s as f32));
            assert!(
                (found - expected).abs() <= 4e-6 * scale + 1e-6,
                "{found} {expected} {ray:?} {path:?}"
            );
            // The test surface's uv are x and y.
            let uv = path.uv(s as f32);
            let reach = entry.abs().max(end);
            let first = |i: usize| ray.direction[i] + ray.shift()[i] * ray.counted_facet_depth();
            let second = ray.shift().map(|shift| shift * v_z);
            let sum = |a: f64, b: f64| a.abs() + b.abs();
            let excess = sum(second[0], second[1]) * reach / sum(first(0), first(1));
            let share = if reach > 1e9 {
                0.0
            } else {
                1.0 / excess.max(1.0)
            };
            let scale = (1.0 + excess.min(1.0)) * (entry.abs() + s);
            for (i, found) in uv.to_array().into_iter().enumerate() {
                let expected = (first(i) + share * second[i] * from_facet) * from_facet;
                assert!(
                    (f64::from(found) - expected).abs() <= 4e-6 * scale,
                    "{found} {expected} {ray:?} {path:?}"
                );
            }
        }
        if path.ends_on_floor() {
            to_floor += 1;
            assert!(
                (path.depth_fraction(path.end()) - 1.0).abs() < 1e-5,
                "{path:?}"
            );
        } else {
            to_cap += 1;
            assert!(path.depth_fraction(path.end()).abs() < 1e-5, "{path:?}");
        }
        // Neither floor nor cap before the end.
        for i in 1..20 {
            let inside = path.depth_fraction((end * f64::from(i) / 20.0) as f32);
            assert!(inside > -1e-5 && inside < 1.0 + 1e-5, "{inside} {path:?}");
        }
    }
    println!("{entering} enter, {to_floor} to the floor, {to_cap} to the cap");
    assert!(entering > 10_000 && to_floor > 5_000 && to_cap > 1_000);
}

#[test]
fn the_steepest_descent_is_never_exceeded() {
    for ray in well_conditioned(2) {
        let path = ray.path(TIER_FAST);
        if !path.enters || path.end() == 0.0 {
            continue;
        }
        for i in 0..=10 {
            let s = f64::from(path.end()) * f64::from(i) / 10.0;
            let from_facet = f64::from(path.entry_from_facet) + s;
            let half_bend = ray.half_bend();
            let floor_depth = ray.depth * (1.0 - half_bend);
            let even = (ray.depth_at(from_facet) / floor_depth).clamp(0.0, 1.0);
            let warped = 1.0 + half_bend * (1.0 + half_bend) * (2.0 * even - 1.0);
            let descent = warped * (ray.v_z() - 2.0 * ray.q() * from_facet) / floor_depth;
            let scale = (ray.v_z().abs() + (ray.q() * from_facet).abs()) / floor_depth;
            assert!(
                descent <= f64::from(path.depth_rate()) + 4e-6 * scale,
                "{descent} {} {ray:?}",
                path.depth_rate()
            );
        }
    }
}

#[test]
fn a_sphere_is_met_to_third_order() {
    let mut random = Random(3);
    for _ in 0..2_000 {
        let radius = random.magnitude(1e-2, 1e2);
        let z = random.within(-0.3, 1.0);
        let angle = random.within(0.0, std::f64::consts::TAU);
        let tangential = (1.0f64 - z * z).sqrt();
        let ray = Ray {
            quadric: [0.5 / radius, 0.0, 0.5 / radius],
            facet_depth: 0.0,
            direction: [tangential * angle.cos(), tangential * angle.sin(), -z],
            facet_t: 3.0 * radius,
            depth: 0.3 * radius,
        };
        let path = ray.path(TIER_FAST);
        let entry = f64::from(path.entry_from_facet);
        let surface = test_surface(ray.quadric.map(|q| q as f32), 0.0);
        let direction = vec3(ray.direction.map(|x| x as f32));
        for fraction in [0.02, 0.1, 0.3] {
            // From the facet point (0, 0, R), where the quadric touches the sphere.
            let from_facet = fraction * radius;
            let [x, y, z] = ray.direction.map(|d| d * from_facet);
            let distance = (x * x + y * y + (radius + z).powi(2)).sqrt();
            let s = (from_facet - entry) as f32;
            let found = f64::from(path.depth_fraction(s)) * ray.depth;
            if s > path.end() {
                continue;
            }
            // What is left is that the warp is a parabola, too.
            let error = (found - (radius - distance)).abs() / ray.depth;
            assert!(error < 4e-3, "{error} {fraction} {ray:?}");

            // The texture coordinates are x and y of the plane that touches
            // the sphere where the ray does; they are to be those of the
            // place from which the normal leads to the ray.
            let uv = path.uv(s);
            let foot = |along: f64| f64::from(along as f32) * radius / distance;
            let apart = (f64::from(uv.x) - foot(x)).hypot(f64::from(uv.y) - foot(y)) / radius;
            assert!(
                apart < 1.5 * fraction.powi(3) + 3e-6,
                "{apart} {fraction} {ray:?}"
            );

            // The normal at the end of the way: that of the sphere below it.
            let exact = Vec3::new(x as f32, y as f32, (radius + z) as f32) / distance as f32;
            let normal = path.surface_normal(&surface, direction, s);
            let error = f64::from((normal - exact).length());
            assert!(error < 1.2 * fraction.powi(3) + 1e-5, "{error} {fraction}");
            assert_eq!(
                ray.path(TIER_PLANAR).surface_normal(&surface, direction, s),
                Vec3::Z
            );
        }
    }
}

#[test]
fn planar_is_a_surface_without_curvature() {
    let mut random = Random(4);
    let rays = (0..10_000).map(|_| Ray::random(&mut random));
    for ray in rays.filter(Ray::counts) {
        let flat = Ray {
            quadric: [0.0; 3],
            facet_depth: 0.0,
            ..ray
        };
        let (straight, bent) = (ray.path(TIER_PLANAR), flat.path(TIER_FAST));
        // Debug prints every field, the sign of zero aside.
        let text = |path: QuadraticPath| {
            let path = QuadraticPath {
                is_bent: false,
                ..path
            };
            format!("{path:?}").replace("-0.0", "0.0")
        };
        assert_eq!(text(straight), text(bent), "{ray:?}");
    }
}

/// The straight ray down the axis, bent by `q` (it leans so little that q = `q`/2 · 10⁻⁸ or so).
fn leaning(quadric: f32, v_z: f32, depth: f32, facet_depth: f32) -> QuadraticPath {
    let v_x = (1.0 - f64::from(v_z).powi(2)).sqrt() as f32;
    QuadraticPath::new(
        &test_surface([quadric, 0.0, 0.0], facet_depth),
        Vec3::new(v_x, 0.0, -v_z),
        1.0,
        depth,
        TIER_FAST,
    )
}

#[test]
fn the_stable_root_keeps_its_digits() {
    // Section 10: C = −0.3 with B = 1 and A from 10⁻⁶ to 0; here B = V_z =
    // 0.6, so q = 0.64 · quadric, and the floor 0.18 deep lies at s = 0.3.
    for quadric in [1e-6, 1e-8, 1e-12, 1e-20, 0.0, -1e-8, -1e-6] {
        let path = leaning(quadric, 0.6, 0.18, 0.0);
        assert!((path.end() - 0.3).abs() < 3e-7, "{quadric} {}", path.end());
        assert!(path.ends_on_floor());
    }
    // The textbook form in f32 loses a part in hundred.
    let (a, b) = (0.64e-6f32, 0.6f32);
    let textbook = (b - (b * b - 4.0 * a * 0.18).sqrt()) / (2.0 * a);
    assert!((textbook - 0.3).abs() > 1e-3, "{textbook}");
}

#[test]
fn the_exit_of_a_convex_surface() {
    // The exit of a chord of a circle: 2 V_z / k, here with k = 4.
    let path = leaning(2.0, 0.6, 0.06, 0.0);
    assert!(!path.ends_on_floor());
    assert!((path.end() - 0.3).abs() < 1e-6);
    // The floor at the very top of the arc is still the floor: (1 − 0.8) / k.
    let path = leaning(1.0, 0.6, 0.1 - 1e-6, 0.0);
    assert!(path.ends_on_floor());
    // A ray that climbs from a facet below the cap entered before the facet.
    let path = leaning(2.0, -0.6, 0.5, 0.01);
    assert!(path.enters && path.entry_from_facet < -0.4);
    assert!(path.entry_from_facet + path.end() > 0.0);
}

#[test]
fn grazing_rays() {
    // Section 10. q > 0: only the cap.
    let convex = leaning(0.5, 0.0, 0.1, 0.0);
    assert!(convex.enters && !convex.ends_on_floor());
    assert_eq!(convex.end(), 0.0);
    // q = 0: along the cap for ever.
    let flat = leaning(0.0, 0.0, 0.1, 0.0);
    assert!(flat.enters && !flat.ends_on_floor());
    assert_eq!(flat.end(), 0.0);
    // q < 0: the floor of a circle with radius 1 at √(1.1² − 1).
    let concave = leaning(-0.5, 0.0, 0.1, 0.0);
    assert!(concave.enters && concave.ends_on_floor());
    assert!((concave.end() - 0.21f32.sqrt()).abs() < 1e-6);
    // Away from a flat or a hollow cap: never.
    assert!(!leaning(0.0, -0.1, 0.1, 0.0).enters);
    assert!(!leaning(-0.5, -0.1, 0.1, 0.0).enters);
    assert!(!leaning(0.0, -0.1, 0.1, 0.01).enters);
    // A facet deeper than the quadric reaches: its depth is forgotten.
    let forgotten = leaning(-0.5, 0.6, 0.1, 1.0);
    assert!(forgotten.enters && forgotten.entry_from_facet == 0.0);
    assert_eq!(forgotten.slope, 0.6);
}

#[test]
fn the_march_starts_at_the_eye_inside_the_shell() {
    let direction = Vec3::new(0.8, 0.0, -0.6);
    let surface = test_surface([0.0; 3], 0.0);
    let path = QuadraticPath::new(&surface, direction, -0.25, 0.6, TIER_FAST);
    assert_eq!(path.entry_t, -0.25);
    assert_eq!(path.start(), 0.25);
    assert!((path.end() - 1.0).abs() < 1e-6);
    let outside = QuadraticPath::new(&surface, direction, 0.25, 0.6, TIER_FAST);
    assert_eq!(outside.start(), 0.0);
}

#[test]
fn every_number_stays_finite() {
    let mut random = Random(5);
    let extreme = |random: &mut Random| -> f32 {
        let special = [
            0.0, -0.0, 1e-45, -1e-45, 1e-39, 1e-30, 1e-20, 1e-18, 1e-10, 1.0, 1e9,
        ];
        let value = match random.whole(0, 2) {
            0 => random.choose(&special),
            _ => random.magnitude(1e-45, 1e9) as f32,
        };
        if random.whole(0, 1) == 0 {
            value
        } else {
            -value
        }
    };
    for _ in 0..200_000 {
        let z = match random.whole(0, 3) {
            0 => random.choose(&[0.0, 1.0, -1.0]),
            1 => extreme(&mut random).clamp(-1.0, 1.0),
            _ => random.within(-1.0, 1.0) as f32,
        };
        let tangential = (1.0 - f64::from(z).powi(2)).sqrt() as f32;
        let angle = random.choose(&[0.0, 1.0, random_angle(&mut Random(u64::from(z.to_bits())))]);
        let direction = Vec3::new(
            tangential * angle.cos() as f32,
            tangential * angle.sin() as f32,
            -z,
        );
        let mut value = || extreme(&mut random);
        let surface = Surface {
            uv: Vec2::new(value(), value()),
            gradient_u: Vec3::new(value(), value(), value()),
            gradient_v: Vec3::new(value(), value(), value()),
            ..test_surface([value(), value(), value()], value())
        };
        // 1 / depth must be a number, too.
        let depth = value().abs().max(1e-30);
        let facet_t = value();
        for tier in [TIER_PLANAR, TIER_FAST] {
            let path = QuadraticPath::new(&surface, direction, facet_t, depth, tier);
            // Debug prints every field.
            let text = format!("{path:?}");
            assert!(
                !text.contains("inf") && !text.contains("NaN"),
                "{text} from {surface:?} {direction} {depth}"
            );
            assert!(path.start() >= 0.0 && path.end() >= 0.0 && path.slope >= 0.0);
            let normal = path.surface_normal(&surface, direction, path.end());
            assert!(normal.is_finite(), "{normal} {text}");
            assert!(path.depth_rate() >= 0.0, "{text}");
        }
    }
}

fn random_angle(random: &mut Random) -> f64 {
    random.within(0.0, std::f64::consts::TAU)
}

/// A path through the shell of a unit sphere, of depth 0.4.
fn over_sphere(v_z: f32) -> QuadraticPath {
    let surface = test_surface([0.5, 0.0, 0.5], 0.0);
    let direction = Vec3::new((1.0 - v_z * v_z).sqrt(), 0.0, -v_z);
    QuadraticPath::new(&surface, direction, 3.0, 0.4, TIER_FAST)
}

/// One that leaves the sphere through the cap.
fn silhouette(v_z: f32) -> QuadraticPath {
    let path = over_sphere(v_z);
    assert!(!path.ends_on_floor);
    path
}

#[test]
fn a_floor_holds_unless_the_mesh_ends_before_it() {
    let path = over_sphere(0.9);
    assert!(path.ends_on_floor);
    let until = |length: f32| {
        let exit = Exit {
            t: 3.0 + length,
            slope: 0.9,
            facet_depth: 0.0,
            uv: Vec2::ZERO,
            depth: 1.0 / path.inverse_depth,
        };
        path.until(&exit, 3.0)
    };
    // The chord of the sphere, and nearly the depth below the plane at the exit.
    let least = path.end + 0.95 / (0.9 * path.inverse_depth);
    for length in [1.8, least + 0.01] {
        let until = until(length);
        assert_eq!((until.end, until.uv_bend), (path.end, path.uv_bend));
    }
    // A mesh that is thinner than the depth.
    for length in [least - 0.01, 0.3] {
        let until = until(length);
        assert!(!until.ends_on_floor && (until.end - length).abs() < 1e-5);
    }
}

#[test]
fn on_a_sphere_the_exit_changes_little() {
    for v_z in [0.01, 0.1, 0.3, 0.5] {
        let path = silhouette(v_z);
        // The chord of the sphere, and the texture coordinates of the path.
        let exit = Exit {
            t: 3.0 + 2.0 * v_z,
            slope: v_z,
            facet_depth: 0.0,
            uv: path.uv(2.0 * v_z),
            depth: 1.0 / path.inverse_depth,
        };
        let until = path.until(&exit, 3.0);
        assert!(!until.ends_on_floor);
        assert!((until.end - 2.0 * v_z).abs() < 1e-5);
        for i in 0..=10 {
            let s = 0.2 * v_z * i as f32;
            assert!((path.uv(s) - until.uv(s)).length() < 1e-5);
            let difference = path.depth_fraction(s) - until.depth_fraction(s);
            assert!(difference.abs() < 0.07, "{v_z} {s} {difference}");
        }
    }
}

#[test]
fn an_exit_that_is_not_behind_the_facet_is_ignored() {
    let path = silhouette(0.2);
    for (t, slope) in [(0.0, 0.0), (2.9, 0.5), (3.0, 0.5), (3.000_001, 0.0)] {
        let exit = Exit {
            t,
            slope,
            facet_depth: 0.0,
            uv: Vec2::ZERO,
            depth: 1.0 / path.inverse_depth,
        };
        let until = path.until(&exit, 3.0);
        assert_eq!(
            (until.end, until.bend, until.twist),
            (path.end, path.bend, 0.0)
        );
    }
}

#[test]
fn a_path_up_to_an_exit_starts_and_ends_on_the_cap_or_meets_the_floor() {
    let mut random = Random(11);
    let (mut floors, mut caps) = (0, 0);
    for _ in 0..20_000 {
        let path = silhouette(random.choose(&[1e-4, 0.01, 0.1, 0.5]));
        let exit = Exit {
            t: 3.0 + random.magnitude(1e-3, 10.0) as f32,
            slope: random.choose(&[0.0, 1e-4, 0.1, 1.0]) * random.within(0.0, 1.0) as f32,
            facet_depth: random.choose(&[0.0, 1e-3]) * random.within(-1.0, 1.0) as f32,
            uv: Vec2::new(
                random.within(0.0, 1.0) as f32,
                random.within(0.0, 1.0) as f32,
            ),
            depth: random.choose(&[0.1, 1.0]) as f32 / path.inverse_depth,
        };
        let until = path.until(&exit, 3.0);
        let at_end = until.depth_fraction(until.end);
        if until.ends_on_floor {
            floors += 1;
            assert!((at_end - 1.0).abs() < 2e-3, "{at_end} {exit:?}");
        } else {
            caps += 1;
            assert!(at_end.abs() < 1e-4, "{at_end} {exit:?}");
        }
        let rate = until.depth_rate() * 1.001 + 1e-5;
        for i in 0..100 {
            let [s, next] = [i, i + 1].map(|i| until.end * i as f32 * 0.01);
            let [from, to] = [s, next].map(|s| until.depth_fraction(s));
            assert!((-1e-5..1.0 + 2e-3).contains(&from), "{from} {exit:?}");
            assert!((to - from).abs() <= rate * (next - s) + 1e-5, "{exit:?}");
        }
        let to_facet = exit.t - until.entry_t;
        let is_known = (until.bend, until.twist) != (path.bend, 0.0);
        if is_known && 2.0 * to_facet > until.end && !until.ends_on_floor {
            let off = until.uv(to_facet) - exit.uv;
            let off = Vec2::new(off.x - off.x.round(), off.y - off.y.round());
            assert!(off.length() < 1e-4 * (1.0 + to_facet), "{off} {exit:?}");
        }
    }
    assert!(floors > 500 && caps > 500, "{floors} {caps}");
}
