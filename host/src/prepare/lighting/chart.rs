//! The chart of a pattern: how much of it is cap, and how its outline runs, for
//! [`relievo_shared::shading::mean`].

use super::far;
use super::pictures::{Levels, levels};
use crate::shape_map::ShapeMap;
use glam::Vec2;
use image::{Rgba, Rgba32FImage};
use rayon::prelude::*;
use relievo_shared::shading::Chart;
use relievo_shared::shading::image::halved;
use relievo_shared::shading::mean::{MOST, MOST_UNEVEN};

/// Least share of an outline along u and v, of one that does not run in all directions. That of a circle
/// is 0.36.
const LEAST_ORDER: f32 = 0.8;

/// The chart of a pattern.
pub(super) struct Charted {
    /// Without its image.
    pub(super) chart: Chart,
    pub(super) image: Levels,
    /// Width of a pixel from which on the mean is all that it shows, texels ([`far::from`]).
    pub(super) far_from: f32,
}

impl Charted {
    /// Adds the image of `size` to `chart`, that of `map`, whose pattern reaches to the distance `radius`, texels.
    pub(super) fn new(map: &ShapeMap, radius: f32, chart: Chart, size: [u32; 2]) -> Charted {
        let image = image(map, radius, size);
        Charted {
            chart,
            far_from: far::from(&image, chart.gap),
            image: levels(image),
        }
    }
}

/// Returns the chart of `map`, whose pattern reaches to the distance `radius`, texels, without its image,
/// and the size of that.
pub(super) fn chart(map: &ShapeMap, radius: f32) -> (Chart, [u32; 2]) {
    let (size, gap) = size(map, gap(map, radius));
    let chart = Chart {
        gap,
        order: order(map, radius),
        way: way(map, radius),
        ..Chart::default()
    };
    (chart, size)
}

/// Returns the size of the chart of `map`, whose gaps have the mean width `gap`, texels of the map, and
/// that width in texels of the chart. No pixel that reads the chart is narrower than its texels, unless
/// it is slanted.
fn size(map: &ShapeMap, gap: f32) -> ([u32; 2], f32) {
    let full = [map.width(), map.height()];
    let (mut size, mut rest) = (full, gap);
    while rest >= 2.0 * MOST_UNEVEN && size[0].min(size[1]) > 1 {
        (size, rest) = (size.map(halved), 0.5 * rest);
    }
    let smaller = area(size) as f64 / area(full) as f64;
    (size, gap * smaller.sqrt() as f32)
}

/// Returns the number of texels of a picture of this size.
pub(super) fn area([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Returns the first level of the chart of `map`, whose pattern reaches to the distance `radius`,
/// texels. The outline between the centres of four texels of the map belongs to the first of them.
fn image(map: &ShapeMap, radius: f32, size: [u32; 2]) -> Rgba32FImage {
    let map_size = [map.width(), map.height()];
    // Texels of the map that a texel of the chart takes the place of.
    let covered = |index: u32, axis: usize| {
        let edge =
            |index: u32| u64::from(index) * u64::from(map_size[axis]) / u64::from(size[axis]);
        edge(index) as u32..edge(index + 1) as u32
    };
    let scale = [0, 1].map(|axis| map_size[axis] as f32 / size[axis] as f32);
    let numbers = [
        1.0,
        scale[0] / MOST,
        scale[1] / MOST,
        (scale[0] * scale[1]).sqrt() / MOST,
    ];
    let texels: Vec<[f32; 4]> = (0..size[0] * size[1])
        .into_par_iter()
        .map(|index| {
            let (mut sums, mut count) = ([0.0; 4], 0.0);
            for y in covered(index / size[0], 1) {
                for x in covered(index % size[0], 0) {
                    let corners = corners(map, radius, x, y);
                    let [xx, yy, xy] = outline(corners);
                    let cap = (0.5 - corners[0]).clamp(0.0, 1.0);
                    for (sum, part) in sums.iter_mut().zip([cap, xx, yy, xy]) {
                        *sum += part;
                    }
                    count += 1.0;
                }
            }
            let [cap, xx, yy, xy] = [0, 1, 2, 3].map(|i| numbers[i] * sums[i] / count);
            [cap, xx, yy, 0.5 + xy]
        })
        .collect();
    Rgba32FImage::from_fn(size[0], size[1], |x, y| {
        Rgba(texels[(y * size[0] + x) as usize])
    })
}

/// Returns the mean width of the gaps of the pattern of `map`, which reaches to the distance `radius`,
/// texels: four times the mean distance from their sides, as between straight ones.
fn gap(map: &ShapeMap, radius: f32) -> f32 {
    let rows: Vec<(f64, u64)> = (0..map.height())
        .into_par_iter()
        .map(|y| {
            let distances = (0..map.width()).map(|x| f64::from(map.decode(x, y) - radius));
            distances
                .filter(|distance| *distance > 0.0)
                .fold((0.0, 0), |(sum, count), distance| {
                    (sum + distance, count + 1)
                })
        })
        .collect();
    let (sum, count) = rows
        .into_iter()
        .fold((0.0, 0), |(sum, count), row| (sum + row.0, count + row.1));
    (4.0 * sum / count.max(1) as f64) as f32
}

/// Returns how much of the outline of the pattern of `map`, which reaches to the distance `radius`,
/// texels, runs along u and v; 0 if less than [`LEAST_ORDER`] does.
fn order(map: &ShapeMap, radius: f32) -> f32 {
    let rows: Vec<[f64; 2]> = (0..map.height())
        .into_par_iter()
        .map(|y| {
            (0..map.width()).fold([0.0; 2], |[slanted, length], x| {
                let [xx, yy, xy] = outline(corners(map, radius, x, y)).map(f64::from);
                [slanted + 2.0 * xy.abs(), length + xx + yy]
            })
        })
        .collect();
    let sum = |part: usize| rows.iter().map(|row| row[part]).sum::<f64>();
    let order = 1.0 - sum(0) / sum(1).max(1e-9);
    match order as f32 {
        order if order < LEAST_ORDER => 0.0,
        order => order,
    }
}

/// Returns the mean way from part to part of the pattern of `map`, which reaches to the distance `radius`,
/// texels, along u and along v: repeats. It is 1 where there are no parts.
fn way(map: &ShapeMap, radius: f32) -> [f32; 2] {
    let size = [map.width(), map.height()];
    [0, 1].map(|axis| {
        let is_gap = |line: u32, at: u32| {
            let [x, y] = [[at, line], [line, at]][axis];
            map.decode(x, y) > radius
        };
        let lines = (0..size[1 - axis]).into_par_iter().map(|line| {
            let gaps = (0..size[axis]).filter(|at| is_gap(line, *at));
            let (begins, texels) = gaps.fold((0, 0), |(begins, texels), at| {
                let before = (at + size[axis] - 1) % size[axis];
                (begins + u64::from(!is_gap(line, before)), texels + 1)
            });
            // A line that meets no part has no way from one to another.
            match begins {
                0 => (0, 0),
                begins => (begins, texels),
            }
        });
        let sum = |a: (u64, u64), b: (u64, u64)| (a.0 + b.0, a.1 + b.1);
        match lines.reduce(|| (0, 0), sum) {
            (0, _) => 1.0,
            (begins, texels) => texels as f32 / (begins as f32 * size[axis] as f32),
        }
    })
}

/// Returns how far the centres of four texels of `map` are from the outline of the pattern, which reaches
/// to the distance `radius`: of texel (`x`, `y`) and of the next ones, in turn.
fn corners(map: &ShapeMap, radius: f32, x: u32, y: u32) -> [f32; 4] {
    let gap = |x: u32, y: u32| map.decode(x % map.width(), y % map.height()) - radius;
    [gap(x, y), gap(x + 1, y), gap(x + 1, y + 1), gap(x, y + 1)]
}

/// Returns xx, yy and xy of the sum of m mᵀ over the outline in a square whose corners have these
/// distances from it, in turn from the upper left one; m is the outline's unit normal.
fn outline(corners: [f32; 4]) -> [f32; 3] {
    let places = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    let crossings: Vec<Vec2> = (0..4)
        .filter_map(|side| {
            let next = (side + 1) % 4;
            let [from, to] = [corners[side], corners[next]];
            let crosses = (from <= 0.0) != (to <= 0.0);
            crosses.then(|| places[side].lerp(places[next], from / (from - to)))
        })
        .collect();
    // Where two pieces of the pattern touch at their corners, either pair of lines is as good.
    let mut sum = [0.0; 3];
    for line in crossings.chunks_exact(2) {
        let normal = (line[1] - line[0]).perp();
        let length = normal.length();
        if length > 0.0 {
            sum[0] += normal.x * normal.x / length;
            sum[1] += normal.y * normal.y / length;
            sum[2] += normal.x * normal.y / length;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape_map::{Pattern, Storage, bake};

    /// Returns the mean of the chart of the pattern of `size`² pixels that `is_solid`.
    fn mean(size: u32, is_solid: impl Fn(f64, f64) -> bool) -> [f64; 4] {
        let centre = |i: u32| f64::from(i) + 0.5;
        let solid = (0..size * size).map(|i| is_solid(centre(i % size), centre(i / size)));
        let pattern = Pattern::from_pixels(size, size, solid.collect::<Vec<_>>()).unwrap();
        let map = bake(&pattern, Storage::R32F, &|_| ());
        let chart = image(&map, 0.0, [size; 2]);
        let sums = chart.pixels().fold([0.0; 4], |sums, pixel| {
            [0, 1, 2, 3].map(|i| sums[i] + f64::from(pixel.0[i]))
        });
        let [cap, xx, yy, xy] = sums.map(|sum| sum / f64::from(size * size));
        let most = f64::from(MOST);
        [cap, xx * most, yy * most, (xy - 0.5) * most]
    }

    #[test]
    fn stripes_have_two_edges_a_period() {
        let [cap, xx, yy, xy] = mean(24, |x, _| x % 8.0 < 3.0);
        assert!((cap - 0.375).abs() < 1e-6, "{cap}");
        assert!((xx - 0.25).abs() < 1e-6 && yy.abs() < 1e-6 && xy.abs() < 1e-6);
        // Grooves of one pixel, too.
        let [cap, xx, ..] = mean(24, |x, _| x % 6.0 >= 1.0);
        assert!((cap - 5.0 / 6.0).abs() < 1e-6 && (xx - 1.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn gaps_are_as_wide_as_the_way_across() {
        let solid = (0..64 * 64).map(|i| i % 64 < 24).collect::<Vec<_>>();
        let pattern = Pattern::from_pixels(64, 64, solid).unwrap();
        let found = gap(&bake(&pattern, Storage::R32F, &|_| ()), 0.0);
        assert!((found - 40.0).abs() < 0.1, "{found}");
        let full = Pattern::from_pixels(2, 2, [true; 4]).unwrap();
        assert_eq!(gap(&bake(&full, Storage::R32F, &|_| ()), 0.0), 0.0);
    }

    #[test]
    fn bricks_run_along_u_and_v_and_discs_do_not() {
        let found = |is_solid: fn(f64, f64) -> bool| {
            let centre = |i: u32| f64::from(i) + 0.5;
            let solid = (0..64 * 64).map(|i| is_solid(centre(i % 64), centre(i / 64)));
            let pattern = Pattern::from_pixels(64, 64, solid.collect::<Vec<_>>()).unwrap();
            chart(&bake(&pattern, Storage::R32F, &|_| ()), 0.0).0
        };
        // Joints of 4 texels between courses of 28, and of 8 between bricks.
        let bricks = found(|x, y| y % 32.0 >= 4.0 && (x + 32.0 * (y / 32.0).floor()) % 64.0 >= 8.0);
        // Corners are cut off.
        assert!(bricks.order > 0.97, "{bricks:?}");
        // Columns in a joint between bricks go on through it.
        let v = (48.0 * 2.0 * 4.0 + 16.0 * 36.0) / (48.0 * 2.0 + 16.0) / 64.0;
        let [along_u, along_v] = bricks.way;
        assert!((along_u - 8.0 / 64.0).abs() < 1e-6, "{along_u}");
        assert!((along_v - v).abs() < 1e-6, "{along_v} {v}");
        let holes = found(|x, y| (x - 32.0).abs().max((y - 32.0).abs()) > 10.0);
        assert!(
            holes.order > 0.95 && holes.way == [20.0 / 64.0; 2],
            "{holes:?}"
        );
        let discs = found(|x, y| (x - 32.0).hypot(y - 32.0) < 20.0);
        assert_eq!(discs.order, 0.0);
        // No part, and nothing else.
        for solid in [true, false] {
            let pattern = Pattern::from_pixels(2, 2, [solid; 4]).unwrap();
            let (chart, _) = chart(&bake(&pattern, Storage::R32F, &|_| ()), 0.0);
            assert_eq!(chart.way, [1.0; 2]);
        }
    }

    #[test]
    fn a_chart_is_as_fine_as_gaps_ask_for() {
        let solid = (0..64 * 64).map(|i| i % 64 < 24).collect::<Vec<_>>();
        let pattern = Pattern::from_pixels(64, 64, solid).unwrap();
        let map = bake(&pattern, Storage::R32F, &|_| ());
        // 40 of 64 texels become 2.5 of 4.
        let (size, gap) = size(&map, gap(&map, 0.0));
        assert!(size == [4, 4] && (gap - 2.5).abs() < 0.01, "{size:?} {gap}");
        let chart = image(&map, 0.0, size);
        let sums = chart.pixels().fold([0.0; 2], |[cap, xx], pixel| {
            [cap + pixel.0[0], xx + pixel.0[1]]
        });
        // Two edges in 4 texels.
        let [cap, xx] = sums.map(|sum| sum / 16.0);
        assert!((cap - 0.375).abs() < 1e-6 && (xx * MOST - 0.5).abs() < 1e-6);
    }

    #[test]
    fn slanted_stripes_have_slanted_normals() {
        let [cap, xx, yy, xy] = mean(64, |x, y| (x + y) % 16.0 < 8.0);
        // Normals (1, 1) / sqrt 2; the period is 16 / sqrt 2.
        let half = std::f64::consts::SQRT_2 / 16.0;
        assert!((cap - 0.5).abs() < 0.04, "{cap}");
        for found in [xx, yy, xy] {
            assert!((found / half - 1.0).abs() < 0.05, "{xx} {yy} {xy}");
        }
    }

    #[test]
    fn a_disc_has_an_outline_in_all_directions() {
        let [cap, xx, yy, xy] = mean(64, |x, y| (x - 32.0).hypot(y - 32.0) < 20.0);
        let area = std::f64::consts::PI * 400.0 / 4096.0;
        // Half of the circumference along each axis; steps of pixels make it a bit longer.
        let half = std::f64::consts::PI * 20.0 / 4096.0;
        assert!((cap - area).abs() < 0.01, "{cap} {area}");
        assert!(xx / half > 0.99 && xx / half < 1.07, "{xx} {half}");
        assert!((xx - yy).abs() < 1e-6 && xy.abs() < 1e-6);
    }
}
