use super::*;
use crate::mesh::{Mesh, MeshOptions};
use crate::oracle::known::{KNOWN, same_texture};
use crate::shape_map::{Pattern, Storage, bake};
use glam::DQuat;
use proptest::prelude::*;
use relievo_shared_f64::layout::Object;
use std::path::Path;

/// One column a repeat, a quarter of it wide.
fn map() -> ShapeMap {
    let pattern = Pattern::from_fn(8, 8, |x, _| (3..5).contains(&x)).unwrap();
    bake(&pattern, Storage::R16, &|_| ())
}

/// Extension, bevel and chamfer.
const BASIC: [f64; 3] = [0.0, 0.0, 1.0];
const BEVELED: [f64; 3] = [0.05, 0.2, 0.6];

fn profile(map: &ShapeMap, [extension, bevel, chamfer]: [f64; 3]) -> Profile {
    Profile::new(
        &Object {
            map_size: [f64::from(map.width()), f64::from(map.height())],
            extension,
            bevel,
            chamfer,
            ..Object::default()
        }
        .complete(),
    )
}

fn oracle<'a>(map: &'a ShapeMap, shape: &'a dyn Shape) -> AnalyticOracle<'a> {
    AnalyticOracle {
        shape,
        placement: Placement::default(),
        map,
        repeat: [12.0, 5.0],
        depth: 0.1,
        profile: profile(map, BEVELED),
        layers: Vec::new(),
        slope: 0.0,
        cut_out: false,
    }
}

fn shape_depth(oracle: &AnalyticOracle<'_>, ray: &Ray, t: f64) -> f64 {
    oracle.shape.foot(ray.at(t)).depth
}

fn mesh(shape: &dyn Shape) -> Mesh {
    let file = format!("../assets/meshes/{}.obj", shape.name());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    Mesh::load(&path, &MeshOptions::default()).unwrap()
}

/// Every vertex of the mesh lies on the surface with its texture coordinates,
/// and points along its normal have the depth at which they lie, the same
/// texture coordinates, and a depth that grows along the normal.
#[test]
fn shapes_are_what_their_meshes_approximate() {
    for shape in KNOWN {
        let mesh = mesh(shape);
        for corner in mesh.triangles.iter().flat_map(|t| &t.corners) {
            for depth in [-0.2, 0.0, 0.1, 0.3] {
                let p = corner.position - corner.normal * depth;
                let foot = shape.foot(p);
                let name = shape.name();
                assert!((foot.depth - depth).abs() < 1e-7, "{name}: {p} {foot:?}");
                assert!(foot.beyond < 1e-7, "{name}: {p} {foot:?}");
                assert!(same_texture(shape, p, foot.uv, corner.uv), "{name}: {p}");
            }
            let ball = shape.radius() + 1e-7;
            assert!(corner.position.length() <= ball, "{}", shape.name());
        }
    }
}

/// A mesh fits its own shape only.
#[test]
fn no_shape_passes_for_another() {
    for shape in KNOWN {
        let mesh = mesh(shape);
        for other in KNOWN {
            let fits = crate::oracle::known::fits(other, &mesh, &Placement::default());
            assert_eq!(fits, shape.name() == other.name(), "{}", other.name());
        }
    }
}

proptest! {
    /// Depth and distance beyond the borders change no faster than the point
    /// moves, and texture coordinates no faster than the metric says.
    #[test]
    fn bounds_hold(
        which in 0..KNOWN.len(),
        from in proptest::array::uniform3(-1.3f64..1.3),
        towards in proptest::array::uniform3(-1.0f64..1.0),
        part in 0.0f64..1.0,
        limit in 0.001f64..0.3,
    ) {
        let shape = KNOWN[which];
        let (from, towards) = (DVec3::from(from), DVec3::from(towards).normalize_or(DVec3::X));
        let here = shape.foot(from);
        let there = shape.foot(from + towards * 0.1);
        prop_assert!((here.depth - there.depth).abs() <= 0.1 + 1e-9);
        if here.beyond > 0.0 && there.beyond <= 0.0 && there.depth.abs() < 0.3 {
            prop_assert!(here.beyond <= 0.1 + 1e-9, "{} {here:?} {there:?}", shape.name());
        }
        if here.depth < 0.0 || here.depth + limit >= 0.3f64.min(shape.largest_depth()) {
            return Ok(());
        }
        let metric = shape.metric(from, limit);
        let way = metric.reach * part;
        let there = shape.foot(from + towards * way);
        for axis in 0..2 {
            let mut apart = there.uv[axis] - here.uv[axis];
            if shape.closed()[axis] {
                apart -= apart.round();
            }
            let bound = way / metric.lengths[axis];
            prop_assert!(
                apart.abs() <= bound * (1.0 + 1e-6) + 1e-9,
                "{}: {apart} > {bound} on axis {axis}", shape.name()
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    /// Small equal steps find no hit before the oracle's.
    #[test]
    fn nothing_is_skipped(
        which in 0..KNOWN.len(),
        aim in proptest::array::uniform3(-1.0f64..1.0),
        from in 0.2f64..3.0,
        extrusion in prop_oneof![Just(BASIC), Just(BEVELED)],
        cut_out in proptest::bool::ANY,
    ) {
        let map = map();
        let oracle = AnalyticOracle { profile: profile(&map, extrusion), cut_out, ..oracle(&map, KNOWN[which]) };
        let eye = DVec3::new(0.0, from, 3.0);
        let direction = (DVec3::from(aim) * DVec3::new(1.4, 0.4, 1.4) - eye).normalize();
        let sample = oracle.trace(eye, direction);
        let end = if sample.is_hit() { sample.t - 1e-4 } else { 6.0 };
        let ray = Ray { eye, direction };
        let mut t = 0.5;
        let mut seen_from_outside = shape_depth(&oracle, &ray, t) < oracle.depth;
        while t < end {
            let foot = oracle.shape.foot(ray.at(t));
            let off = foot.beyond > 0.0 || foot.depth < 0.0;
            prop_assert!(
                off || !seen_from_outside || !oracle.is_solid(&foot),
                "{}: {t} before {sample:?}", oracle.shape.name()
            );
            seen_from_outside = foot.depth < oracle.depth && (off || seen_from_outside);
            t += 5e-4;
        }
        if sample.is_hit() {
            prop_assert!(oracle.is_solid(&oracle.shape.foot(ray.at(sample.t))));
            let normal = oracle.normal(eye, direction, sample);
            prop_assert!((normal.length() - 1.0).abs() < 1e-9);
        }
    }
}

/// From above each surface, along its normal: cap on a column, floor beside it.
#[test]
fn straight_down_the_cap_and_the_floor_are_met() {
    let map = map();
    for shape in KNOWN {
        let oracle = AnalyticOracle {
            profile: profile(&map, BASIC),
            ..oracle(&map, shape)
        };
        let (mut caps, mut floors) = (0, 0);
        for corner in mesh(shape).triangles.iter().map(|t| t.corners[0]) {
            let repeats = (corner.uv.x * 12.0).rem_euclid(1.0);
            let inner = shape.foot(corner.position).beyond < -1e-3;
            let (class, t) = if (0.4..0.6).contains(&repeats) {
                caps += 1;
                (CLASS_CAP, 0.2)
            } else if !(0.3..0.7).contains(&repeats) {
                floors += 1;
                (CLASS_FLOOR, 0.3)
            } else {
                continue;
            };
            let pole = corner.position.x.hypot(corner.position.z) < 1e-3;
            if inner && !pole {
                let eye = corner.position + corner.normal * 0.2;
                let sample = oracle.trace(eye, -corner.normal);
                assert_eq!(sample.class, class, "{}: {}", shape.name(), corner.uv);
                assert!((sample.t - t).abs() < 1e-5, "{}: {sample:?}", shape.name());
            }
        }
        assert!(caps + floors > 0, "{}", shape.name());
    }
}

/// A scaled, turned and moved object is met where the plain one is.
#[test]
fn placement_moves_what_is_met() {
    let map = map();
    let plain = oracle(&map, KNOWN[0]);
    let placement = Placement {
        scale: 2.5,
        rotation: DQuat::from_rotation_z(0.7) * DQuat::from_rotation_x(-0.4),
        translation: DVec3::new(3.0, -1.0, 0.5),
    };
    let placed = AnalyticOracle {
        placement,
        depth: 2.5 * plain.depth,
        ..oracle(&map, KNOWN[0])
    };
    let world = |p: DVec3| placement.point(p);
    let mut hits = 0;
    for i in 0..60 {
        let eye = DVec3::new(0.0, 2.3, 3.4);
        let aim = DVec3::new(0.04 * f64::from(i) - 1.2, 0.1, 0.3);
        let a = plain.trace(eye, (aim - eye).normalize());
        let b = placed.trace(world(eye), placement.rotation * (aim - eye).normalize());
        assert_eq!(a.class, b.class);
        assert!((2.5 * a.t - b.t).abs() < 1e-4, "{a:?} {b:?}");
        hits += usize::from(a.is_hit());
    }
    assert!(hits > 20);
}

/// Through the open end of a cut-out cylinder its inner side is not seen, and
/// past the border of a plane its floor is not seen from below.
#[test]
fn surfaces_are_seen_from_outside_only() {
    let map = map();
    let cylinder = AnalyticOracle {
        cut_out: true,
        ..oracle(&map, KNOWN[2])
    };
    let eye = DVec3::new(0.0, 4.0, 0.0);
    let into = (DVec3::new(0.3, 0.0, 1.0) - eye).normalize();
    assert_eq!(cylinder.trace(eye, into), Sample::MISS);
    let plane = oracle(&map, KNOWN[3]);
    let below = DVec3::new(0.1, -2.0, 0.2);
    assert_eq!(plane.trace(below, DVec3::Y), Sample::MISS);
    assert!(plane.trace(-below, DVec3::NEG_Y).is_hit());
}
