//! The exported hulls: every ray that hits something over a facet leaves the facet's hull through a
//! face that is drawn.

use super::cases::{file, prepared};
use glam::{DVec3, Vec3};
use relievo::export::{Options, Output, Target, export};
use relievo::prepare::PreparedScene;
use relievo_shared::intersection::{Camera, intersect};
use relievo_shared::model::prisms::Home;
use relievo_shared::model::{Flat, Prisms, Quadric, Ray};
use relievo_tests::Random;
use serde_json::Value;

/// The hulls of an export: positions moved out by `width`, facets, and triangles.
struct Hulls {
    positions: Vec<DVec3>,
    facets: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Hulls {
    /// Reads them as `layout.json` says.
    fn of(scene: &PreparedScene, width: f64) -> Hulls {
        let options = Options {
            targets: vec![Target::Wgsl],
            output: Output::Hit,
            ..Options::default()
        };
        let files = export(scene, &options).unwrap();
        let layout: Value = serde_json::from_slice(file(&files, "layout.json")).unwrap();
        let hull = &layout["hull"];
        let buffer = |name: &str| {
            let buffer = &hull[name];
            let bytes = file(&files, buffer["file"].as_str().unwrap());
            (bytes, buffer["count"].as_u64().unwrap() as usize)
        };
        let (bytes, count) = buffer("vertices");
        let stride = hull["stride"].as_u64().unwrap() as usize;
        assert_eq!(bytes.len(), count * stride);
        let attribute = |index: usize, name: &str, vertex: usize| {
            let attribute = &hull["attributes"][index];
            assert_eq!(attribute["name"], name);
            vertex * stride + attribute["offset"].as_u64().unwrap() as usize
        };
        let vector = |index: usize, name: &str, vertex: usize| {
            let start = attribute(index, name, vertex);
            let floats: [f32; 3] = bytemuck::pod_read_unaligned(&bytes[start..start + 12]);
            DVec3::from(floats.map(f64::from))
        };
        let position = |i| vector(0, "position", i) + width * vector(1, "outward", i);
        let facet = |i| {
            let start = attribute(2, "facet", i);
            bytemuck::pod_read_unaligned(&bytes[start..start + 4])
        };
        let (indices, number) = buffer("indices");
        let triangles: Vec<[u32; 3]> = bytemuck::pod_collect_to_vec(indices);
        assert_eq!(3 * triangles.len(), number);
        Hulls {
            positions: (0..count).map(position).collect(),
            facets: (0..count).map(facet).collect(),
            triangles,
        }
    }

    /// Returns the triangles of each facet.
    fn by_facet(&self) -> Vec<Vec<[DVec3; 3]>> {
        let mut all = vec![Vec::new(); 1 + *self.facets.iter().max().unwrap() as usize];
        for triangle in &self.triangles {
            let facets = triangle.map(|vertex| self.facets[vertex as usize]);
            assert_eq!(facets, [facets[0]; 3]);
            all[facets[0] as usize].push(triangle.map(|vertex| self.positions[vertex as usize]));
        }
        all
    }
}

/// Returns whether a ray leaves through one of these triangles.
fn leaves(triangles: &[[DVec3; 3]], origin: DVec3, direction: DVec3) -> bool {
    triangles.iter().any(|triangle| {
        let [a, b, c] = triangle.map(|corner| corner - origin);
        // All three have the sign of the side that the ray comes from.
        let sides = [b.cross(a), c.cross(b), a.cross(c)].map(|side| side.dot(direction));
        let normal = (b - a).cross(c - a);
        sides.iter().all(|side| *side <= 0.0) && normal.dot(direction) > 0.0 && a.dot(normal) > 0.0
    })
}

/// Returns the facets over which a ray hits something, with the distances.
pub fn hit_facets(
    scene: &PreparedScene,
    camera: &Camera,
    origin: Vec3,
    direction: Vec3,
) -> Vec<(usize, f32)> {
    let object = &scene.objects[0];
    let frame = camera.frame(origin);
    let ray = Ray {
        frame: &frame,
        object: &object.parameters,
        direction,
    };
    let map = object.map.words();
    let hit = |facet: usize| {
        let found = match (scene.objects[0].prisms.is_empty(), object.parameters.tier) {
            (false, _) => {
                let home = Home {
                    prisms: &object.prisms[..],
                    index: facet as u32,
                };
                intersect::<Prisms, _, _>(&ray, &home, map)
            }
            (_, relievo_shared::layout::TIER_PLANAR) => {
                intersect::<Flat, _, _>(&ray, &object.triangles[facet], map)
            }
            _ => intersect::<Quadric, _, _>(&ray, &object.triangles[facet], map),
        };
        (found.class != 0).then_some((facet, found.t))
    };
    (0..object.triangles.len()).filter_map(hit).collect()
}

#[test]
fn no_hit_is_outside_its_hull() {
    for name in ["torus_planar.toml", "torus.toml", "torus_accurate.toml"] {
        let scene = prepared(name, |_| ());
        let hulls = Hulls::of(&scene, 1e-5).by_facet();
        // Twin: hulls that are smaller lose hits.
        let small = Hulls::of(&scene, -0.02).by_facet();
        let mut random = Random(7);
        let (mut hits, mut lost) = (0, 0);
        for _ in 0..1000 {
            let origin = random.vector(3.0).as_vec3();
            // In the shell over triangles a ray may also enter where it comes from.
            if scene.objects[0].prisms.is_empty() && origin.length() < 2.0 {
                continue;
            }
            let target = (random.vector(1.3) * DVec3::new(1.0, 0.3, 1.0)).as_vec3();
            let direction = (target - origin).normalize();
            let camera = Camera {
                forward: direction,
                right: Vec3::splat(1e-3),
                down: Vec3::splat(1e-3),
                near: 1e-3,
            };
            for (facet, _) in hit_facets(&scene, &camera, origin, direction) {
                let found = |hulls: &[Vec<[DVec3; 3]>]| {
                    leaves(&hulls[facet], origin.as_dvec3(), direction.as_dvec3())
                };
                assert!(found(&hulls), "{name}, facet {facet}: {origin} {direction}");
                hits += 1;
                lost += usize::from(!found(&small));
            }
        }
        println!("{name}: {hits} hits, {lost} lost by the twin");
        assert!(hits > 100 && lost > 5, "{name}: {hits} {lost}");
    }
}
