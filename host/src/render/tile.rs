//! Tiles of pixels: their rays, and which of these may meet a facet.

use glam::{Vec2, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use relievo_shared::camera::pixel_ray;
use relievo_shared::layout::Frame;
use relievo_shared::outline::{Outline, Rectangle};
use std::array;

/// Width and height of a tile, pixels.
pub(super) const SIDE: usize = 8;
/// Number of its pixels.
pub(super) const PIXELS: usize = SIDE * SIDE;

/// The rays of a square of pixels, rows from the top. A set of its pixels has one bit for
/// each.
pub(super) struct Tile {
    /// The x, y and z of the rays' unit directions.
    directions: [[f32; PIXELS]; 3],
    /// The pixels inside the picture.
    inside: u64,
    /// The first pixel's centre and the step from pixel to pixel to the right and down,
    /// normalised device coordinates.
    first: Vec2,
    step: Vec2,
    eye: Vec3,
    /// The first pixel.
    origin: [usize; 2],
    /// Normals of the four planes around the rays, which point inwards: their x, y and z.
    planes: [[f32; 4]; 3],
    /// What places points in pixels.
    raster: Raster,
}

/// Places points in pixels. A point p from the eye has the column −(N · p) / (B · p): the
/// planes through the eye and a column have the normals N + column · B. Rows likewise.
struct Raster {
    /// N of columns and rows.
    normals: [Vec3; 2],
    /// B of columns and rows.
    steps: [Vec3; 2],
    /// Bounds of the lengths of N + column · B, of columns and rows of the tile.
    longest: [f32; 2],
}

impl Tile {
    /// Returns the tile of `frame` whose first pixel is (`x`, `y`).
    pub(super) fn new(frame: &Frame, x: usize, y: usize) -> Tile {
        let mut directions = [[0.0; PIXELS]; 3];
        for i in 0..PIXELS {
            let ray = pixel_ray(frame, (x + i % SIDE) as u32, (y + i / SIDE) as u32);
            for (all, one) in directions.iter_mut().zip(ray.to_array()) {
                all[i] = one;
            }
        }
        let [width, height] = frame.size.map(|side| side as usize);
        let row = u64::from(u8::MAX >> SIDE.saturating_sub(width - x));
        let rows = (0..SIDE.min(height - y)).fold(0, |rows, i| rows | row << (SIDE * i));
        // From the rays: those of a frame may be a part of its picture, and further apart.
        let [right, up, forward] = [frame.right, frame.up, frame.forward].map(Vec3::from);
        let [first, to_right, down] =
            [frame.ray_first, frame.ray_right, frame.ray_down].map(Vec3::from);
        let scale = 1.0 / first.dot(forward);
        let corner = Vec2::new(first.dot(right), first.dot(up)) * scale;
        let step = Vec2::new(to_right.dot(right), down.dot(up)) * scale;
        Tile {
            directions,
            inside: rows,
            first: corner + Vec2::new(x as f32, y as f32) * step,
            step,
            eye: Vec3::from(frame.eye),
            origin: [x, y],
            planes: planes(frame, x as f32, y as f32),
            raster: Raster::new(frame, x as f32, y as f32),
        }
    }

    /// Returns the same tile of `frame`, which is the same picture in another space.
    pub(super) fn seen_from(&self, frame: &Frame) -> Tile {
        let [x, y] = self.origin;
        Tile::new(frame, x, y)
    }

    /// Returns column and row of pixel `index` in the picture.
    pub(super) fn pixel(&self, index: usize) -> [u32; 2] {
        let [x, y] = self.origin;
        [(x + index % SIDE) as u32, (y + index / SIDE) as u32]
    }

    /// The direction of pixel `index`.
    pub(super) fn direction(&self, index: usize) -> Vec3 {
        Vec3::from(self.directions.map(|all| all[index]))
    }

    /// Returns the pixels in the rows of `rectangle` for whose direction `meets` is true.
    // Inlined, so that the loop over a row is one of vectors.
    #[inline(always)]
    pub(super) fn which(&self, rectangle: &Rectangle, meets: impl Fn(Vec3) -> bool) -> u64 {
        let [x, y, z] = &self.directions;
        self.set(rectangle, |i| meets(Vec3::new(x[i], y[i], z[i])))
    }

    /// Returns the pixels in `outline`.
    pub(super) fn within(&self, outline: &Outline) -> u64 {
        let at =
            |i: usize| self.first + Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) * self.step;
        let Rectangle { low, high } = outline.rectangle;
        if outline.grown {
            let [a, b, c] = outline.corners;
            let inner = |from: Vec2, to: Vec2, point| (to - from).perp_dot(point - from) >= 0.0;
            self.set(&outline.rectangle, |i| {
                inner(a, b, at(i)) & inner(b, c, at(i)) & inner(c, a, at(i))
            })
        } else {
            self.set(&outline.rectangle, |i| {
                (low.x <= at(i).x) & (at(i).x <= high.x)
            })
        }
    }

    /// Returns the pixels in the rows of `rectangle` whose index `is_in`.
    #[inline(always)]
    fn set(&self, rectangle: &Rectangle, is_in: impl Fn(usize) -> bool) -> u64 {
        let last = self.first.x + self.step.x * (SIDE - 1) as f32;
        let Rectangle { low, high } = rectangle;
        if low.x >= high.x || high.x < self.first.x || last < low.x {
            return 0;
        }
        let rows = |y: f32| (y - self.first.y) / self.step.y;
        let limited = |row: f32| row.clamp(0.0, SIDE as f32) as usize;
        // Rounded: the rectangle has a margin of a pixel.
        let (start, end) = (limited(rows(high.y)), limited(rows(low.y) + 1.0));
        let mut found = 0;
        for row in start..end {
            let mut all = [0; SIDE];
            for (i, one) in all.iter_mut().enumerate() {
                *one = u8::from(is_in(row * SIDE + i));
            }
            // Moves bit 0 of byte i to bit 56 + i.
            let bits = u64::from_le_bytes(all).wrapping_mul(0x0102_0408_1020_4080) >> 56;
            found |= bits << (row * SIDE);
        }
        found & self.inside
    }

    /// Returns the least distance of `bounds` from the eye; `None` if no ray comes near.
    #[inline]
    pub(super) fn nearest(&self, bounds: &Aabb) -> Option<f32> {
        let low = Vec3::from(bounds.min) - self.eye;
        let high = Vec3::from(bounds.max) - self.eye;
        let [x, y, z] = &self.planes;
        let mut beyond = false;
        for i in 0..4 {
            // The largest distance of a corner.
            let furthest = (x[i] * low.x).max(x[i] * high.x)
                + (y[i] * low.y).max(y[i] * high.y)
                + (z[i] * low.z).max(z[i] * high.z);
            beyond |= furthest < 0.0;
        }
        if beyond
            || self
                .raster
                .misses(0.5 * (low + high), 0.5 * (high - low).length())
        {
            return None;
        }
        Some(low.max(-high).max(Vec3::ZERO).length())
    }
}

/// Margin of [`Raster::misses`], pixels.
const MARGIN: f32 = 0.01;

impl Raster {
    /// Returns that of the tile of `frame` at (`x`, `y`).
    fn new(frame: &Frame, x: f32, y: f32) -> Raster {
        let [first, right, down] =
            [frame.ray_first, frame.ray_right, frame.ray_down].map(Vec3::from);
        let normals = [down.cross(first), right.cross(first)];
        let steps = [down.cross(right), right.cross(down)];
        let side = SIDE as f32;
        let longest = [(0, x), (1, y)].map(|(axis, start)| {
            let length = |place: f32| (normals[axis] + steps[axis] * place).length();
            length(start - 1.0).max(length(start + side))
        });
        Raster {
            normals,
            steps,
            longest,
        }
    }

    /// Returns whether the ball around `centre` (from the eye) lies between the rays of all
    /// pixels: smaller than they are apart, and beside all.
    #[inline]
    fn misses(&self, centre: Vec3, radius: f32) -> bool {
        (0..2).any(|axis| {
            let step = self.steps[axis];
            let away = step.dot(centre);
            // |N + column · B| r / (|B · p| − |B| r) bounds the change of the column.
            let reach = self.longest[axis] * radius;
            let least = away.abs() - step.length() * radius;
            if reach > 0.5 * least {
                return false;
            }
            let place = -self.normals[axis].dot(centre) / away;
            (place - place.round()).abs() * least > reach + MARGIN * least
        })
    }
}

/// Returns the normals of the planes through the eye one pixel beside the centres of the
/// outer pixels of the tile at (`x`, `y`). The pixel is a margin.
fn planes(frame: &Frame, x: f32, y: f32) -> [[f32; 4]; 3] {
    let first = Vec3::from(frame.ray_first);
    let right = Vec3::from(frame.ray_right);
    let down = Vec3::from(frame.ray_down);
    let side = SIDE as f32;
    let middle = first + right * (x + 0.5 * side) + down * (y + 0.5 * side);
    let normals = [
        down.cross(first + right * (x - 1.0)),
        down.cross(first + right * (x + side)),
        right.cross(first + down * (y - 1.0)),
        right.cross(first + down * (y + side)),
    ];
    let inwards = normals.map(|normal| normal * normal.dot(middle).signum());
    array::from_fn(|axis| inwards.map(|normal| normal[axis]))
}

/// Calls `visit` with the leaves of `bvh` that the rays of `tile` may meet, and their least
/// distance from the eye; roughly from near to far.
#[inline]
pub(super) fn visit_tile(
    bvh: &Bvh2,
    tile: &Tile,
    stack: &mut Vec<(f32, u32)>,
    mut visit: impl FnMut(u32, f32),
) {
    let nodes = &bvh.nodes;
    let entry = |index: u32| Some((tile.nearest(nodes[index as usize].aabb())?, index));
    stack.clear();
    stack.extend((!nodes.is_empty()).then(|| entry(0)).flatten());
    while let Some((distance, index)) = stack.pop() {
        let node = &nodes[index as usize];
        let first = node.first_index;
        if node.is_leaf() {
            for leaf in first..first + node.prim_count {
                visit(leaf, distance);
            }
            continue;
        }
        let (left, right) = (entry(first), entry(first + 1));
        // The last one is visited first.
        if left < right {
            stack.extend(right.into_iter().chain(left));
        } else {
            stack.extend(left.into_iter().chain(right));
        }
    }
}

/// Calls `visit` with the index of each pixel in `set`.
#[inline]
pub(super) fn for_each(mut set: u64, mut visit: impl FnMut(usize)) {
    while set != 0 {
        visit(set.trailing_zeros() as usize);
        set &= set - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Frame {
        Frame {
            near: 0.01,
            right: [0.5, 0.0, 0.0],
            up: [0.0, 0.5, 0.0],
            forward: [0.0, 0.0, -1.0],
            ray_first: [-1.9, 1.9, -1.0],
            ray_right: [0.2, 0.0, 0.0],
            ray_down: [0.0, -0.2, 0.0],
            size: [20.0, 20.0],
            ..Frame::default()
        }
    }

    /// Columns 1 to 3 and rows 2 to 4, counted from the tile's.
    fn rectangle(x: f32, y: f32) -> Rectangle {
        let at = |column: f32, row: f32| Vec2::new((x + column) * 0.1 - 1.0, 1.0 - (y + row) * 0.1);
        Rectangle {
            low: at(1.25, 4.75),
            high: at(3.75, 2.25),
        }
    }

    #[test]
    fn a_rectangle_holds_its_pixels() {
        let tile = Tile::new(&frame(), 8, 8);
        let outline = Outline {
            grown: false,
            corners: [Vec2::ZERO; 3],
            rectangle: rectangle(8.0, 8.0),
        };
        let mut found = 0_u64;
        for_each(tile.within(&outline), |i| found |= 1 << i);
        // And those of row 1: rows are rounded.
        assert_eq!(found, 0x0e_0e0e_0e00);
        for (x, y) in [(0.0, 8.0), (16.0, 8.0), (8.0, 0.0), (8.0, 16.0)] {
            assert_eq!(tile.which(&rectangle(x, y), |_| true), 0);
        }
    }

    #[test]
    fn rays_of_a_part_of_the_picture_are_found_where_they_are() {
        // Every second ray of the right lower quarter.
        let part = Frame {
            ray_first: [0.1, -0.1, -1.0],
            ray_right: [0.4, 0.0, 0.0],
            ray_down: [0.0, -0.4, 0.0],
            size: [5.0, 5.0],
            ..frame()
        };
        let tile = Tile::new(&part, 0, 0);
        let meets = |rectangle: &Rectangle| tile.which(rectangle, |_| true);
        // Row 0 is the only one near the middle; column 4 near the right side.
        let low = Vec2::new(0.0, -0.1);
        let right = Vec2::new(1.0, 0.15);
        assert_eq!(meets(&Rectangle { low, high: right }), 0x1f);
        let nothing = Rectangle {
            low: Vec2::NEG_ONE,
            high: Vec2::new(-0.1, 1.0),
        };
        assert_eq!(meets(&nothing), 0);
    }

    #[test]
    fn pixels_outside_the_picture_are_left_out() {
        let everything = Rectangle {
            low: Vec2::NEG_ONE,
            high: Vec2::ONE,
        };
        let all = |x, y| Tile::new(&frame(), x, y).which(&everything, |_| true);
        assert_eq!(all(8, 8), u64::MAX);
        assert_eq!(all(16, 8), 0x0f0f_0f0f_0f0f_0f0f);
        assert_eq!(all(8, 16), 0xffff_ffff);
        assert_eq!(all(16, 16), 0x0f0f_0f0f);
    }

    #[test]
    fn boxes_between_the_rays_are_left_out() {
        let tile = Tile::new(&frame(), 8, 8);
        // Column i at distance 1 has x = −0.3 + 0.2 i, row i the negative y.
        for distance in [1.0, 2.0] {
            let at = |column: f32, row: f32, radius: f32| {
                let [x, y] = [column, row].map(|place| 0.2 * place - 0.3);
                let centre = glam::Vec3A::new(x, -y, -1.0) * distance;
                let half = glam::Vec3A::new(radius, radius, 0.0) * 0.2 * distance;
                let bounds = Aabb::new(centre - half, centre + half);
                tile.nearest(&bounds).is_some()
            };
            let near: Vec<usize> = (0..20)
                .filter(|&i| at(1.0 + 0.1 * i as f32, 1.0, 0.06))
                .collect();
            assert_eq!(near, [0, 1, 9, 10, 11, 19]);
            assert!(!at(1.5, 1.0, 0.06) && !at(1.0, 1.5, 0.06) && !at(1.5, 1.5, 0.06));
            // A box that is wider than the rays are apart may hold one.
            assert!((0..20).all(|i| at(1.0 + 0.1 * i as f32, 1.5, 0.51)));
        }
    }

    #[test]
    fn boxes_beside_the_rays_are_left_out() {
        let tile = Tile::new(&frame(), 8, 8);
        let at = |x: f32, y: f32, z: f32| {
            let centre = glam::Vec3A::new(x, y, z);
            tile.nearest(&Aabb::new(centre - 0.11, centre + 0.11))
        };
        // The rays of the tile lie at x and -y from -0.3 to 1.1 at distance 1.
        assert!((at(0.0, 0.0, -1.0).unwrap() - 0.89).abs() < 1e-3);
        assert!(at(-0.25, 0.25, -1.0).is_some() && at(1.05, -1.05, -1.0).is_some());
        for (x, y) in [(-0.7, 0.0), (1.7, 0.0), (0.0, 0.7), (0.0, -1.7)] {
            assert_eq!(at(x, y, -1.0), None);
        }
        assert_eq!(at(0.2, 0.2, 1.0), None);
    }
}
