//! Outlines of a pattern that repeats, as closed lines.

use glam::DVec2;
use std::collections::HashSet;

/// The outlines of one repeat of a pattern, in texels. The pattern lies to the left of
/// each line, with x to the right and y up.
#[derive(Clone, Debug)]
pub struct Contours {
    /// Width and height of a repeat, texels.
    pub size: DVec2,
    /// The lines. Each ends where it begins, or whole repeats further.
    pub lines: Vec<Vec<DVec2>>,
    /// Whether a pattern without lines is solid.
    is_solid: bool,
}

/// A cell between four texel centres, counted beyond one repeat, and one of its sides:
/// 0 to 3, from corner k to corner k + 1.
type Side = (i64, i64, usize);

/// The corners of a cell, counter-clockwise.
const CORNERS: [(i64, i64); 4] = [(0, 0), (1, 0), (1, 1), (0, 1)];
/// The cell at the other side of each side.
const ACROSS: [(i64, i64); 4] = [(0, -1), (1, 0), (0, 1), (-1, 0)];

impl Contours {
    /// Traces the zero set of the bilinear interpolation of `value`, which is given at the
    /// centres of `size` texels and repeats. The pattern is where it is not positive. In a
    /// cell the line is straight.
    pub fn trace(size: [usize; 2], value: impl Fn(usize, usize) -> f64) -> Contours {
        let [width, height] = size.map(|side| side as i64);
        let at =
            |x: i64, y: i64| value(x.rem_euclid(width) as usize, y.rem_euclid(height) as usize);
        let corners = |x: i64, y: i64| CORNERS.map(|(dx, dy)| at(x + dx, y + dy));
        let canonical = |(x, y, k): Side| (x.rem_euclid(width), y.rem_euclid(height), k);
        let point = |(x, y, k): Side| {
            let values = corners(x, y);
            let [from, to] = [k, (k + 1) % 4].map(|corner| {
                let (dx, dy) = CORNERS[corner];
                DVec2::new((x + dx) as f64 + 0.5, (y + dy) as f64 + 0.5)
            });
            let (a, b) = (values[k], values[(k + 1) % 4]);
            from.lerp(to, a / (a - b))
        };
        let mut lines = Vec::new();
        let mut seen = HashSet::new();
        for y in 0..height {
            for x in 0..width {
                for start in exits(&corners(x, y)).map(|k| (x, y, k)) {
                    if !seen.insert(start) {
                        continue;
                    }
                    let mut line = vec![point(start)];
                    let mut side = start;
                    loop {
                        let entry = entry(&corners(side.0, side.1), side.2);
                        let (dx, dy) = ACROSS[entry];
                        // The same side, seen from the next cell.
                        side = (side.0 + dx, side.1 + dy, (entry + 2) % 4);
                        line.push(point(side));
                        if !seen.insert(canonical(side)) {
                            break;
                        }
                    }
                    lines.push(line);
                }
            }
        }
        Contours {
            size: DVec2::new(width as f64, height as f64),
            lines,
            is_solid: at(0, 0) <= 0.0,
        }
    }

    /// Returns lines of fewer points, at most `tolerance` texels from these (Douglas and
    /// Peucker). Lines without area are left out.
    pub fn simplified(&self, tolerance: f64) -> Contours {
        let lines = self.lines.iter().filter_map(|line| {
            let (first, last) = (0, line.len() - 1);
            let mut kept = vec![false; line.len()];
            (kept[first], kept[last]) = (true, true);
            let mut pending = vec![(first, last)];
            let is_closed = line[first].distance(line[last]) < 1e-9;
            if is_closed {
                let furthest = (first..last).max_by(|&a, &b| {
                    let [a, b] = [a, b].map(|i| line[i].distance_squared(line[first]));
                    a.total_cmp(&b)
                })?;
                kept[furthest] = true;
                pending = vec![(first, furthest), (furthest, last)];
            }
            while let Some((from, to)) = pending.pop() {
                let far = |i: usize| distance(line[i], line[from], line[to]);
                let between = (from + 1..to).max_by(|&a, &b| far(a).total_cmp(&far(b)));
                if let Some(middle) = between.filter(|&middle| far(middle) > tolerance) {
                    kept[middle] = true;
                    pending.extend([(from, middle), (middle, to)]);
                }
            }
            let points = line.iter().zip(&kept);
            let points: Vec<DVec2> = points.filter(|(_, kept)| **kept).map(|(p, _)| *p).collect();
            (!is_closed || points.len() > 3).then_some(points)
        });
        let lines: Vec<_> = lines.collect();
        Contours {
            size: self.size,
            is_solid: if lines.is_empty() && !self.lines.is_empty() {
                // Nothing is left of the lines: what covers more of a repeat wins.
                self.covered() > 0.5
            } else {
                self.is_solid
            },
            lines,
        }
    }

    /// Returns the share of a repeat that the pattern covers, on a grid.
    fn covered(&self) -> f64 {
        const SIDE: usize = 16;
        let inside = (0..SIDE * SIDE).filter(|i| {
            let place = DVec2::new((i % SIDE) as f64 + 0.41, (i / SIDE) as f64 + 0.37);
            self.is_inside(self.size * place / SIDE as f64)
        });
        inside.count() as f64 / (SIDE * SIDE) as f64
    }

    /// Returns whether the pattern covers `point`, texels.
    pub fn is_inside(&self, point: DVec2) -> bool {
        let Some(line) = self.lines.first() else {
            return self.is_solid;
        };
        let along_x = |point| self.left_of(point, |p: DVec2| p, 1.0);
        along_x(point)
            .or_else(|| self.left_of(point, |p: DVec2| DVec2::new(p.y, p.x), -1.0))
            // Neither its row nor its column meets a line: then no line lies between it
            // and the row of a line.
            .or_else(|| along_x(DVec2::new(point.x, 0.5 * (line[0].y + line[1].y))))
            .unwrap_or(self.is_solid)
    }

    /// Follows the row of `point` to the first line, after `turn`, and returns whether the
    /// point lies to its left. `hand` is −1 where `turn` mirrors.
    fn left_of(&self, point: DVec2, turn: impl Fn(DVec2) -> DVec2, hand: f64) -> Option<bool> {
        let (point, size) = (turn(point), turn(self.size));
        let mut nearest = None;
        for line in &self.lines {
            for pair in line.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(&turn);
                // The repeats whose copy of the piece crosses the row.
                let first = ((point.y - a.y.max(b.y)) / size.y).ceil() as i64;
                let last = ((point.y - a.y.min(b.y)) / size.y).floor() as i64;
                for repeat in first..=last {
                    let y = point.y - repeat as f64 * size.y;
                    if (a.y > y) == (b.y > y) {
                        continue;
                    }
                    let x = a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y);
                    let ahead = (x - point.x).rem_euclid(size.x);
                    if nearest.is_none_or(|(least, _)| ahead < least) {
                        nearest = Some((ahead, hand * (b.y - a.y) > 0.0));
                    }
                }
            }
        }
        nearest.map(|(_, is_left)| is_left)
    }
}

/// Returns the sides where the pattern ends, counter-clockwise.
fn exits(values: &[f64; 4]) -> impl Iterator<Item = usize> {
    let values = *values;
    (0..4).filter(move |&k| values[k] <= 0.0 && values[(k + 1) % 4] > 0.0)
}

/// Returns the side where the line from `exit` through the cell comes out.
fn entry(values: &[f64; 4], exit: usize) -> usize {
    let begins = |k: usize| values[k % 4] > 0.0 && values[(k + 1) % 4] <= 0.0;
    let mut ahead = (1..4).map(|step| exit + step);
    let mut behind = (1..4).map(|step| exit + 4 - step);
    let [a, b, c, d] = *values;
    let is_saddle = exits(values).count() == 2;
    // The value at the saddle point says whether the two corners are joined.
    let is_joined = (a * c - b * d) * (a + c - b - d) <= 0.0;
    let found = if is_saddle && !is_joined {
        behind.find(|&k| begins(k))
    } else {
        ahead.find(|&k| begins(k))
    };
    found.expect("what ends in a cell begins in it") % 4
}

/// Returns the distance of `p` from the piece from `a` to `b`.
fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let length = along.length_squared();
    let place = if length > 0.0 {
        ((p - a).dot(along) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(a + along * place)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(contours: &Contours) -> f64 {
        let pieces = contours.lines.iter().flat_map(|line| line.windows(2));
        pieces.map(|pair| 0.5 * pair[0].perp_dot(pair[1])).sum()
    }

    #[test]
    fn a_disc_is_one_line_around_its_area() {
        let center = DVec2::new(30.2, 5.1);
        let size = [40, 48];
        let disc = Contours::trace(size, |x, y| {
            let from = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - center;
            let period = DVec2::new(40.0, 48.0);
            (from - (from / period).round() * period).length() - 12.0
        });
        assert_eq!(disc.lines.len(), 1);
        let exact = std::f64::consts::PI * 144.0;
        assert!(
            (area(&disc) - exact).abs() < 0.01 * exact,
            "{}",
            area(&disc)
        );
        let coarse = disc.simplified(0.5);
        assert!(coarse.lines[0].len() < 20, "{:?}", coarse.lines[0].len());
        assert!((area(&coarse) - exact).abs() < 0.06 * exact);
        for contours in [&disc, &coarse] {
            assert!(contours.is_inside(center));
            assert!(contours.is_inside(center + DVec2::new(40.0, -96.0)));
            // Over the border of the repeat, and beside the disc.
            assert!(contours.is_inside(DVec2::new(30.0, 46.0)));
            assert!(!contours.is_inside(DVec2::new(10.0, 5.0)));
            assert!(!contours.is_inside(DVec2::new(10.0, 25.0)));
        }
        let gone = disc.simplified(50.0);
        assert!(gone.lines.is_empty() && !gone.is_inside(center));
    }

    #[test]
    fn stripes_and_their_negative_go_round() {
        for sign in [1.0, -1.0] {
            let stripe = Contours::trace([8, 8], |_, y| sign * ((y as f64 - 3.0).abs() - 1.5));
            assert_eq!(stripe.lines.len(), 2);
            for line in &stripe.lines {
                let moved = line[line.len() - 1] - line[0];
                assert_eq!(moved.abs(), DVec2::new(8.0, 0.0));
            }
            let simple = stripe.simplified(0.1);
            assert!(simple.lines.iter().all(|line| line.len() == 2));
            for (y, is_in) in [(3.5, true), (7.0, false), (11.5, true)] {
                let inside = simple.is_inside(DVec2::new(-3.0, y));
                assert_eq!(inside, is_in == (sign > 0.0), "{sign} {y}");
            }
        }
    }

    #[test]
    fn corners_that_touch_are_joined_or_not_and_all_lines_are_closed() {
        for middle in [-1.0, 1.0] {
            let checks = Contours::trace([2, 2], |x, y| match (x, y) {
                (0, 0) | (1, 1) => -1.0 + 0.1 * middle,
                _ => 1.0 + 0.1 * middle,
            });
            let pieces: usize = checks.lines.iter().map(|line| line.len() - 1).sum();
            assert_eq!(pieces, 8);
        }
        let nothing = Contours::trace([1, 1], |_, _| 1.0);
        assert!(nothing.lines.is_empty() && !nothing.is_inside(DVec2::ZERO));
        assert!(Contours::trace([3, 1], |_, _| -1.0).is_inside(DVec2::ZERO));
    }
}
