//! The naive form of each formula, which fails, beside ours, which does not.
//! Section numbers refer to docs/algorithm.md.

use glam::{DVec3, Vec3};
use relievo::mesh::{Mesh, MeshOptions};
use relievo_shared::camera::reversed_depth;
use relievo_shared::facet::{self, FacetHit};
use relievo_shared::layout::{Corner, Frame, Object, TIER_FAST, Triangle};
use relievo_shared::path::{Path, QuadraticPath, test_surface};
use relievo_shared::shape_map::ShapeMap;
use relievo_shared::surface::interpolate;
use relievo_shared::{Vec2, arithmetic};

/// A ray straight down (tilted just enough to meet a curvature) over a quadric.
fn path(quadric: [f32; 3], direction: Vec3, depth: f32) -> QuadraticPath {
    let surface = test_surface(quadric, 0.0);
    QuadraticPath::new(&surface, direction, 1.0, depth, TIER_FAST)
}

/// Section 10: (B − √D) / −2A with B = 1 and C = −0.3.
#[test]
fn the_root_of_a_nearly_linear_equation() {
    let naive = |a: f32| {
        let (b, c) = (1.0_f32, -0.3_f32);
        (b - (b * b - 4.0 * a * c).sqrt()) / (-2.0 * a)
    };
    // 0.7 % off, then zero, then NaN.
    assert!((naive(1e-6) - 0.298).abs() < 5e-4, "{}", naive(1e-6));
    assert_eq!(naive(1e-8), 0.0);
    assert!(naive(0.0).is_nan());

    // The same equation: V_z s − q s² = S_z.
    for a in [1e-6_f32, 1e-8, 1e-12, 1e-30, 0.0, -1e-30, -1e-8, -1e-6] {
        // Down with V_z = 0.8, so that q = 0.36 xx.
        let direction = Vec3::new(0.6, 0.0, -0.8);
        let path = path([a / 0.36, 0.0, 0.0], direction, 0.24);
        assert!((path.end() - 0.3).abs() < 1e-6, "{a:e}: {}", path.end());
    }
}

/// Section 10: depth-normalising, v / v_z.
#[test]
fn grazing_rays() {
    let (q, depth) = (0.5_f32, 0.05_f32);
    let normalised = |v_z: f32| q / (depth * (v_z * v_z));
    assert!(normalised(1e-6) > 9e12);
    assert!(normalised(1e-20).is_infinite());
    for v_z in [1e-6_f32, 1e-20, 1e-30, 0.0] {
        let direction = Vec3::new(1.0, 0.0, -v_z);
        // Over a hill the ray leaves through the cap; into a hollow it reaches
        // the floor at √(S_z / |q|), apart from the shell's curvature.
        let over = path([q, 0.0, 0.0], direction, depth);
        assert!(over.enters && !over.ends_on_floor());
        let expected = f64::from(v_z) / f64::from(q);
        // V_z² underflows from 1e-20 on.
        assert!((f64::from(over.end()) - expected).abs() <= 1e-6 * expected + 1e-18);
        let into = path([-q, 0.0, 0.0], direction, depth);
        let expected = (depth / q).sqrt();
        assert!(into.ends_on_floor());
        assert!((into.end() - expected).abs() < 0.05 * expected, "{into:?}");
        // Along a plane only the cap can be met.
        let along = path([0.0; 3], direction, depth);
        assert_eq!(along.ends_on_floor(), v_z > 1e-18);
        assert!(along.end().is_finite() && along.uv(along.end()).is_finite());
    }
}

/// Section 10: δ near the end of the path, where V_z s and q s² are nearly equal.
#[test]
fn depth_near_the_exit() {
    let (q, v_z) = (0.31_f32, 0.1_f32);
    let path = path(
        [q, 0.0, 0.0],
        Vec3::new((1.0 - v_z * v_z).sqrt(), 0.0, -v_z),
        1.0,
    );
    let (bend, slope, inverse) = (path.bend, path.slope, path.inverse_depth);
    let (mut naive_worst, mut worst) = (0.0_f64, 0.0_f64);
    for i in 1..1000 {
        let s = path.end() * (1.0 - 1e-6 * i as f32);
        let wide = |x: f32| f64::from(x);
        let exact = wide(s) * (wide(slope) - wide(bend) * wide(s)) * wide(inverse);
        let naive = (slope * s - bend * (s * s)) * inverse;
        let ours = s * (slope - bend * s) * inverse;
        naive_worst = naive_worst.max((wide(naive) - exact).abs());
        worst = worst.max((wide(ours) - exact).abs());
    }
    println!("δ near the exit: naive {naive_worst:.1e}, ours {worst:.1e}");
    assert!(naive_worst > 1.5 * worst, "{naive_worst:e} {worst:e}");
    assert!(worst < 2e-9, "{worst:e}");
}

/// Section 10: at u = 1000.3 an f32 step is 6e-5 of a repeat.
#[test]
fn texture_coordinates_far_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("far.obj");
    let (u, width) = (1000.3, 0.01);
    let text = format!(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt {u} {u}\nvt {} {u}\nvt {u} {}\nf 1/1 2/2 3/3\n",
        u + width,
        u + width
    );
    std::fs::write(&path, text).unwrap();
    let mesh = Mesh::load(&path, &MeshOptions::default()).unwrap();
    assert_eq!(mesh.triangles.len(), 1);
    let at = |share: f64, whole: f64| {
        // As in the renderer: corners in f32, minus whole repeats, interpolated
        // in f32.
        let corners = [u, u + width].map(|x| (x - whole) as f32);
        let (a, b) = (1.0 - share as f32, share as f32);
        let expected = u + width * f64::from(share as f32) - whole;
        (f64::from(corners[0] * a + corners[1] * b) - expected).abs()
    };
    let worst = |whole: f64| {
        (0..1000)
            .map(|i| at(f64::from(i) / 1000.0, whole))
            .fold(0.0, f64::max)
    };
    let (naive, ours) = (worst(0.0), worst(u.floor()));
    println!("u near 1000: naive {naive:.1e}, ours {ours:.1e} repeats");
    assert!(naive > 5e-5 && ours < 1e-7, "{naive:e} {ours:e}");

    // Preparation does this: at u = 1000.3 no corner is above 1.
    let scene = format!(
        "[[object]]\nmesh = {:?}\nshape = {:?}\n",
        path,
        relievo_tests::asset("patterns/discs.png")
    );
    let mut scene = relievo::scene::Scene::parse(&scene, &path).unwrap();
    scene.objects[0].mesh = path.into();
    let prepared = relievo::prepare::prepare(&scene, &|_| ()).unwrap();
    for corner in prepared.objects[0].triangles[0].corners {
        assert!((0.0..1.0).contains(&corner.uv[0].abs()), "{corner:?}");
    }
}

/// Lookup in the shape map: whole repeats are subtracted before scaling to
/// texels.
#[test]
fn texels_far_out() {
    let texels: Vec<u32> = (0..60).map(|i| (i as f32).to_bits()).collect();
    let object = Object {
        map_size: [60.0, 1.0],
        map_reach: 1.0,
        map_format: relievo_shared::layout::FORMAT_FLOAT,
        ..Object::default()
    }
    .complete();
    let map = ShapeMap::new(&object);
    // A quarter of the map, after 131,071 repeats.
    let u = 131_071.0_f32 + 0.273_437_5;
    let ours = map.distance(&texels[..], Vec2::new(u, 0.0));
    let exact = map.distance(&texels[..], Vec2::new(0.273_437_5, 0.0));
    assert_eq!(ours, exact);
    // Scaled first, the fraction is quantized to half texels.
    let naive = (u * 60.0 - 0.5) % 60.0;
    assert!((naive - exact).abs() > 0.05, "{naive} {exact}");
}

/// The textbook triangle test (Möller and Trumbore), without a margin.
fn naive_hit(eye: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant <= 0.0 {
        return false;
    }
    let inverse = 1.0 / determinant;
    let from = eye - a;
    let u = from.dot(p) * inverse;
    let v = direction.dot(from.cross(ab)) * inverse;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0
}

/// Section 11: rays through a shared edge meet one of the two triangles.
#[test]
fn rays_through_shared_edges() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut point = |size: f32| {
        let mut number = || size * (2.0 * random.f32() - 1.0);
        Vec3::new(number(), number(), number())
    };
    let (mut naive, mut ours, mut rays) = (0, 0, 0);
    for i in 0..300_000 {
        let [a, b] = [point(1.0), point(1.0)];
        let (left, right) = (point(1.0), point(1.0));
        let eye = point(1.0) + Vec3::new(0.0, 0.0, 3.0);
        let share = (i % 97) as f32 / 97.0;
        let direction = (a + (b - a) * (0.1 + 0.8 * share) - eye).normalize();
        // Both seen from the front, one on each side of the edge.
        let side = |p: Vec3| (b - a).cross(p - a).dot(eye - a);
        if side(left) <= 0.05 || side(right) >= -0.05 {
            continue;
        }
        let pair = [[a, b, left], [b, a, right]];
        let clear = |p: Vec3| (p - eye).normalize().cross(direction).length() > 0.05;
        if !clear(a) || !clear(b) {
            continue;
        }
        rays += 1;
        naive += u32::from(
            !pair
                .iter()
                .any(|corners| naive_hit(eye, direction, *corners)),
        );
        let hit = |corners: &[Vec3; 3]| {
            let triangle = Triangle {
                corners: corners.map(|position| Corner {
                    position: position.to_array(),
                    ..Corner::default()
                }),
                handedness: 1.0,
                depth_reductions: 0,
            };
            facet::intersect(eye, direction, &triangle).hit
        };
        ours += u32::from(!pair.iter().any(hit));
    }
    println!("of {rays} rays through an edge, naive lets {naive} through, ours {ours}");
    assert!(rays > 1000 && naive > 10, "{rays} {naive}");
    assert_eq!(ours, 0);
}

/// Section 4: the facet's depth, from positions relative to a corner.
#[test]
fn facet_depth_far_from_the_origin() {
    let far = DVec3::new(1000.0, -2000.0, 500.0);
    let normals = [[0.0, 0.0], [0.02, 0.0], [0.0, 0.02]]
        .map(|[x, y]: [f64; 2]| DVec3::new(x, y, (1.0 - x * x - y * y).sqrt()));
    let triangle = Triangle {
        corners: normals.map(|normal| Corner {
            position: (normal + far).as_vec3().to_array(),
            normal: normal.as_vec3().to_array(),
            tangent: [1.0, 0.0, 0.0],
            ..Corner::default()
        }),
        handedness: 1.0,
        depth_reductions: 0,
    };
    let third: f32 = 1.0 / 3.0;
    let hit = FacetHit {
        hit: true,
        t: 1.0,
        weights: Vec3::splat(third),
        normal: Vec3::Z,
    };
    // The exact depth of the rounded corners.
    let wide = |i: usize| {
        (
            DVec3::from(triangle.corners[i].position.map(f64::from)) - far,
            DVec3::from(triangle.corners[i].normal.map(f64::from)),
        )
    };
    let corners = [wide(0), wide(1), wide(2)];
    let sum = |f: &dyn Fn(usize) -> f64| (0..3).map(f).sum::<f64>() / 3.0;
    let mean = |f: &dyn Fn(usize) -> DVec3| (0..3).map(f).sum::<DVec3>() / 3.0;
    let dots = sum(&|i| corners[i].0.dot(corners[i].1));
    let exact = 0.5 * (dots - mean(&|i| corners[i].0).dot(mean(&|i| corners[i].1)));
    let ours = f64::from(interpolate(&triangle, &hit).facet_depth);
    let naive = {
        let position = |i: usize| Vec3::from(triangle.corners[i].position);
        let normal = |i: usize| Vec3::from(triangle.corners[i].normal);
        let dots: f32 = (0..3).map(|i| third * position(i).dot(normal(i))).sum();
        let p: Vec3 = (0..3).map(|i| position(i) * third).sum();
        let n: Vec3 = (0..3).map(|i| normal(i) * third).sum();
        f64::from(0.5 * (dots - p.dot(n)))
    };
    println!("facet depth: exact {exact:.3e}, ours {ours:.3e}, naive {naive:.3e}");
    assert!((ours - exact).abs() < 1e-3 * exact.abs());
    assert!((naive - exact).abs() > 0.1 * exact.abs());
}

/// Reversed depth distinguishes far distances that z / far does not.
#[test]
fn depth_far_away() {
    let frame = Frame {
        near: 1e-3,
        forward: [0.0, 0.0, -1.0],
        ..Frame::default()
    };
    let depth = |t: f32| reversed_depth(&frame, Vec3::NEG_Z, t);
    let conventional = |t: f32| {
        let (near, far) = (1e-3_f32, 1e6_f32);
        far / (far - near) - far * near / (far - near) / t
    };
    let (t, further) = (50_000.0_f32, 50_001.0_f32);
    assert_eq!(conventional(t), conventional(further));
    assert!(depth(t) > depth(further));
}

/// A vector of length zero.
#[test]
fn normalising_nothing() {
    assert!(Vec3::ZERO.normalize().is_nan());
    // Its square is subnormal, and the quotient arbitrary.
    let small = Vec3::splat(1e-23);
    assert!(!(small.normalize().length() - 1.0).abs().le(&1e-3));
    for v in [Vec3::ZERO, small] {
        assert_eq!(arithmetic::normalize_or(v, Vec3::Z), Vec3::Z);
    }
}

/// A scene 100,000 from the world's origin: in f32 alone a texel's step is lost.
#[test]
fn scenes_far_from_the_origin() {
    let (far, step) = (1e5_f64, 1e-3);
    let narrow = ((far + step) as f32 - far as f32) as f64;
    assert!((narrow - step).abs() > 0.9 * step, "{narrow}");
    // As in preparation: relative to the scene's centre, in f64, first.
    let ours = f64::from(((far + step) - far) as f32);
    assert!((ours - step).abs() < 1e-8 * far * step);
}
