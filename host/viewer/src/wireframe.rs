//! Wireframe of the mesh over the picture.

use glam::Vec3;
use relievo::prepare::PreparedScene;
use relievo_shared::layout::Frame;
use std::collections::BTreeMap;

/// Maximum number of edges; more would cover the picture.
pub const MOST_EDGES: usize = 100_000;

/// Edges of all objects, each once, with the normals of its one or two
/// triangles.
pub struct Wireframe {
    edges: Vec<Edge>,
}

struct Edge {
    ends: [Vec3; 2],
    /// Normals of the triangles at the edge, not normalized.
    sides: [Vec3; 2],
}

impl Wireframe {
    /// Collects the edges of `scene`; `None` if there are more than
    /// [`MOST_EDGES`].
    pub fn of(scene: &PreparedScene) -> Option<Wireframe> {
        let mut edges: BTreeMap<[[u32; 3]; 2], Edge> = BTreeMap::new();
        let objects = scene.objects.iter();
        let triangles = objects.flat_map(|object| {
            let triangles = object.triangles.iter();
            triangles.map(move |triangle| (object, triangle))
        });
        for (object, triangle) in triangles {
            let corners = triangle.corners.map(|corner| {
                let own = Vec3::from(corner.position);
                match &object.placement {
                    Some(placement) => placement.point(own.as_dvec3()).as_vec3(),
                    None => own,
                }
            });
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let mut key = [from, to].map(|end| end.to_array().map(f32::to_bits));
                key.sort_unstable();
                edges
                    .entry(key)
                    .and_modify(|edge| edge.sides[1] = normal)
                    .or_insert(Edge {
                        ends: [from, to],
                        sides: [normal; 2],
                    });
            }
            if edges.len() > MOST_EDGES {
                return None;
            }
        }
        Some(Wireframe {
            edges: edges.into_values().collect(),
        })
    }

    /// Returns the edges of front faces: x and y of both ends, 0…1 from the
    /// picture's upper left corner.
    pub fn seen<'a>(&'a self, frame: &'a Frame) -> impl Iterator<Item = [[f32; 2]; 2]> + 'a {
        let eye = Vec3::from(frame.eye);
        let [right, up, forward] = [frame.right, frame.up, frame.forward].map(Vec3::from);
        self.edges.iter().filter_map(move |edge| {
            let to_eye = eye - edge.ends[0];
            if edge.sides.iter().all(|normal| normal.dot(to_eye) <= 0.0) {
                return None;
            }
            let place = |end: Vec3| {
                let ray = end - eye;
                let distance = ray.dot(forward);
                let x = 0.5 + 0.5 * ray.dot(right) / distance;
                let y = 0.5 - 0.5 * ray.dot(up) / distance;
                (distance > frame.near).then_some([x, y])
            };
            Some([place(edge.ends[0])?, place(edge.ends[1])?])
        })
    }
}
