//! The winding of triangles without normals: neighbours agree, and closed islands
//! are seen from outside.

use std::collections::VecDeque;

use glam::DVec3;

use super::bounds::Bounds;
use super::surface::{Face, Surface, area_normal, pairs};

/// Triangles that are connected by edges with exactly two sides.
struct Island {
    /// Indices of the triangles, and whether each has to be reversed to agree
    /// with the first.
    triangles: Vec<(u32, bool)>,
    /// Whether it has neither a border nor a triangle with normals, and all its
    /// triangles agree.
    is_closed: bool,
    /// Whether it has a triangle with normals, which keeps its winding.
    is_anchored: bool,
    bounds: Bounds,
    /// Six times the volume within, object units cubed, once its triangles agree.
    volume: f64,
    /// Twice the area of the triangles to reverse, and of the others.
    areas: [f64; 2],
}

/// Reverses triangles without normals so that they agree with their neighbours,
/// and with those that have normals. Closed islands are turned outward, but for
/// those in the bounding box of another one, which may be cavities; these and open
/// ones keep the winding of the larger part of their area. Returns the number of
/// triangles reversed.
pub(super) fn orient(surface: &mut Surface) -> usize {
    if surface.faces.iter().all(has_normals) {
        return 0;
    }
    let islands = islands(surface);
    let boxes: Vec<(usize, Bounds)> = islands
        .iter()
        .enumerate()
        .filter(|(_, island)| island.is_closed)
        .map(|(index, island)| (index, island.bounds))
        .collect();
    let mut count = 0;
    for (index, island) in islands.iter().enumerate() {
        let is_within = || {
            let Bounds { min, max } = island.bounds;
            boxes.iter().any(|(other, bounds)| {
                *other != index && bounds.min.cmple(min).all() && bounds.max.cmpge(max).all()
            })
        };
        let [reversed, kept] = island.areas;
        let turn = if island.is_anchored {
            false
        } else if island.is_closed && !is_within() {
            island.volume < 0.0
        } else {
            reversed > kept
        };
        for &(triangle, reverse) in &island.triangles {
            let face = &mut surface.faces[triangle as usize];
            if reverse != turn && !has_normals(face) {
                face.reverse();
                count += 1;
            }
        }
    }
    count
}

fn has_normals(face: &Face) -> bool {
    face.normals.iter().any(|normal| *normal != DVec3::ZERO)
}

/// Finds the islands, each from its first triangle with normals, else its first.
fn islands(surface: &Surface) -> Vec<Island> {
    const NONE: u32 = u32::MAX;
    let faces = &surface.faces;
    let mut other_side = vec![NONE; 3 * faces.len()];
    for [one, other] in pairs(surface) {
        (other_side[one], other_side[other]) = (other as u32, one as u32);
    }
    // The direction in which the triangle of a side runs through it.
    let runs_up = |side: usize| {
        let vertices = faces[side / 3].vertices;
        vertices[(side + 1) % 3] < vertices[(side + 2) % 3]
    };
    // Some(whether to reverse it) of the triangles that an island has.
    let mut known: Vec<Option<bool>> = vec![None; faces.len()];
    let mut islands = Vec::new();
    let anchors = (0..faces.len()).filter(|index| has_normals(&faces[*index]));
    for first in anchors.chain(0..faces.len()) {
        if known[first].is_some() {
            continue;
        }
        let origin = surface.positions[faces[first].vertices[0] as usize];
        let mut island = Island {
            triangles: Vec::new(),
            is_closed: true,
            is_anchored: false,
            bounds: Bounds {
                min: origin,
                max: origin,
            },
            volume: 0.0,
            areas: [0.0; 2],
        };
        known[first] = Some(false);
        let mut queue = VecDeque::from([first]);
        while let Some(index) = queue.pop_front() {
            let reverse = known[index] == Some(true);
            let corners = surface.corners(&faces[index]);
            let area = area_normal(corners);
            let sign = if reverse { -1.0 } else { 1.0 };
            island.triangles.push((index as u32, reverse));
            island.is_anchored |= has_normals(&faces[index]);
            island.volume += sign * area.dot(corners[0] - origin);
            island.areas[usize::from(!reverse)] += area.length();
            for corner in corners {
                island.bounds.min = island.bounds.min.min(corner);
                island.bounds.max = island.bounds.max.max(corner);
            }
            for side in [0, 1, 2].map(|i| 3 * index + i) {
                let other = other_side[side];
                if other == NONE {
                    island.is_closed = false;
                    continue;
                }
                let other = other as usize;
                let neighbour = other / 3;
                let agrees = runs_up(side) != runs_up(other);
                let wanted = !has_normals(&faces[neighbour]) && reverse == agrees;
                match known[neighbour] {
                    // A band with one side, or normals that contradict the winding.
                    Some(found) => island.is_closed &= found == wanted,
                    None => {
                        known[neighbour] = Some(wanted);
                        queue.push_back(neighbour);
                    }
                }
            }
        }
        island.is_closed &= !island.is_anchored;
        islands.push(island);
    }
    islands
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::DVec2;

    /// Returns the positions and triangles of the cube with the corners `centre` ± `size`.
    /// Each two triangles are a face: −x, +x, −y, +y, −z, +z.
    pub(in crate::mesh) fn cube(size: f64, centre: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let positions = (0..8)
            .map(|i| {
                centre
                    + size * DVec3::from([4, 2, 1].map(|bit| if i & bit > 0 { 1.0 } else { -1.0 }))
            })
            .collect();
        let quads: [[u32; 4]; 6] = [
            [0, 1, 3, 2],
            [4, 6, 7, 5],
            [0, 4, 5, 1],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 5, 7, 3],
        ];
        let triangles = quads.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).concat();
        (positions, triangles)
    }

    fn surface((positions, triangles): (Vec<DVec3>, Vec<[u32; 3]>)) -> Surface {
        Surface {
            positions,
            faces: triangles
                .into_iter()
                .map(|vertices| Face {
                    vertices,
                    material: 0,
                    normals: [DVec3::ZERO; 3],
                    uvs: [DVec2::ZERO; 3],
                })
                .collect(),
        }
    }

    fn volume(surface: &Surface) -> f64 {
        let faces = surface.faces.iter();
        let volumes = faces.map(|face| {
            let [a, b, c] = surface.corners(face);
            a.dot(b.cross(c)) / 6.0
        });
        volumes.sum()
    }

    #[test]
    fn closed_islands_are_seen_from_outside() {
        let mut outward = surface(cube(1.0, DVec3::X));
        assert_eq!(orient(&mut outward), 0);
        assert!((volume(&outward) - 8.0).abs() < 1e-9);
        let mut inward = outward;
        for face in &mut inward.faces {
            face.reverse();
        }
        assert_eq!(orient(&mut inward), 12);
        assert!((volume(&inward) - 8.0).abs() < 1e-9);
        // Every third triangle is turned, the first among them.
        for face in inward.faces.iter_mut().step_by(3) {
            face.reverse();
        }
        assert_eq!(orient(&mut inward), 4);
        assert!((volume(&inward) - 8.0).abs() < 1e-9);
    }

    #[test]
    fn a_cavity_keeps_its_winding() {
        let (mut positions, mut triangles) = cube(2.0, DVec3::ZERO);
        let (inner, cavity) = cube(1.0, DVec3::ZERO);
        positions.extend(inner);
        triangles.extend(cavity.iter().map(|[a, b, c]| [8 + a, 8 + c, 8 + b]));
        let mut hollow = surface((positions, triangles));
        assert_eq!(orient(&mut hollow), 0);
        assert!((volume(&hollow) - 56.0).abs() < 1e-9);
    }

    #[test]
    fn open_islands_and_normals_decide_by_area_and_by_normals() {
        let (positions, mut triangles) = cube(1.0, DVec3::ZERO);
        triangles.truncate(10);
        let mut open = surface((positions, triangles));
        open.faces[0].reverse();
        assert_eq!(orient(&mut open), 1);
        // A triangle with normals is not reversed, all others are.
        open.faces[3].reverse();
        open.faces[3].normals = [DVec3::X; 3];
        assert_eq!(orient(&mut open), 9);
        assert_eq!(orient(&mut open), 0);
    }

    #[test]
    fn a_band_with_one_side_ends() {
        let count = 7;
        let at = |i: usize, side: f64| {
            let angle = std::f64::consts::TAU * i as f64 / count as f64;
            let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let half = 0.5 * angle;
            out + side * 0.3 * (half.cos() * DVec3::Z + half.sin() * out)
        };
        let positions = (0..count).flat_map(|i| [at(i, -1.0), at(i, 1.0)]).collect();
        let mut triangles = Vec::new();
        for i in 0..count as u32 {
            let [a, b] = [2 * i, 2 * i + 1];
            let last = i + 1 == count as u32;
            let [c, d] = if last { [1, 0] } else { [a + 2, b + 2] };
            triangles.extend([[a, c, b], [b, c, d]]);
        }
        let mut band = surface((positions, triangles));
        orient(&mut band);
        let island = &islands(&band)[0];
        assert!(!island.is_closed && island.triangles.len() == 2 * count);
    }
}
