//! Exact, toroidal, signed Euclidean distance transform in linear time.
//!
//! Meijster's algorithm on integers: first the distance along each column to the
//! nearest pixel of the other class (pattern or not), then the lower envelope of
//! the parabolas of these distances along each row. Squared distances are
//! integers, so the result is exact up to one square root and one rounding to
//! f32.
//!
//! ```
//! use relievo::shape_map::{Pattern, signed_distance_field};
//!
//! let pattern = Pattern::from_pixels(4, 1, [true, false, false, false])?;
//! let field = signed_distance_field(&pattern, &|_| ());
//! // The field wraps around: texel 3 is next to texel 0.
//! assert_eq!(field.values(), [-0.5, 0.5, 1.5, 0.5]);
//! # Ok::<(), relievo::shape_map::ShapeMapError>(())
//! ```
//!
//! Source: section 3 of docs/algorithm.md; A. Meijster, J. Roerdink, W. Hesselink, "A
//! general algorithm for computing distance transforms in linear time", 2000.

use super::Pattern;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Called from time to time, from any thread, with the fraction of the work that
/// is done, 0…1.
pub type Progress<'a> = dyn Fn(f64) + Sync + 'a;

/// Signed distances of a map that repeats in both directions, in texels.
///
/// Outside the pattern: the distance to the nearest centre of a pattern pixel − ½.
/// Inside: ½ − the distance to the nearest centre that is not pattern. So no value
/// is between −½ and ½, and values of neighbours (on the torus) differ by at most
/// 1.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    width: u32,
    height: u32,
    values: Vec<f32>,
}

impl DistanceField {
    /// Returns the width in texels, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in texels, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns all values, row by row, in texels.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns the lowest and the highest value, in texels.
    pub fn range(&self) -> (f32, f32) {
        self.values.par_iter().map(|&value| (value, value)).reduce(
            || (f32::INFINITY, f32::NEG_INFINITY),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        )
    }

    /// Returns the field on a coarser grid, in units of its texels: each square of
    /// `factor` × `factor` texels becomes one with their mean. `None` unless
    /// `factor` divides both sides.
    ///
    /// The mean preserves the Lipschitz constant of 1, so steps remain safe. The
    /// pattern's edge moves by a fraction of a texel; features thinner than a
    /// texel are lost.
    pub fn reduced(&self, factor: u32) -> Option<DistanceField> {
        if factor == 0 || !self.width.is_multiple_of(factor) || !self.height.is_multiple_of(factor)
        {
            return None;
        }
        let (width, height) = (self.width / factor, self.height / factor);
        let scale = 1.0 / f64::from(factor).powi(3);
        let values = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                (0..width).map(move |x| {
                    let block = (0..factor * factor).map(|i| {
                        let (x, y) = (x * factor + i % factor, y * factor + i / factor);
                        f64::from(self.get(x, y))
                    });
                    (block.sum::<f64>() * scale) as f32
                })
            })
            .collect();
        Some(DistanceField {
            width,
            height,
            values,
        })
    }

    /// Returns the rows of all `fields`, which have one width, one field below the other.
    pub(super) fn joined(fields: &[DistanceField]) -> DistanceField {
        DistanceField {
            width: fields[0].width,
            height: fields.iter().map(|field| field.height).sum(),
            values: fields
                .iter()
                .flat_map(|field| &field.values)
                .copied()
                .collect(),
        }
    }

    /// Returns one value, in texels; coordinates wrap around.
    pub fn get(&self, x: u32, y: u32) -> f32 {
        let (x, y) = ((x % self.width) as usize, (y % self.height) as usize);
        self.values[y * self.width as usize + x]
    }
}

/// Columns of a block: 64 bytes of the pattern, one cache line.
const BLOCK: usize = 64;
/// Minimum number of pixels of a task of the row pass.
const ROWS_PIXELS: usize = 1 << 16;
/// No pixel of the other class in this column. Distances are below 2³⁰.
const NONE: u32 = u32::MAX;

/// Computes the signed distance field of `pattern`, in parallel over columns and
/// then over rows. Needs 8 bytes per texel, including the result.
///
/// For an empty pattern every value is √(width² + height²), larger than any
/// distance on the torus; for a full one it is the negative of that.
pub fn signed_distance_field(pattern: &Pattern, progress: &Progress<'_>) -> DistanceField {
    let (width, height) = (pattern.width(), pattern.height());
    let solid = pattern.solid();
    let values = if solid.iter().all(|&pixel| pixel == solid[0]) {
        let far = f64::from(width).hypot(f64::from(height)) as f32;
        vec![if solid[0] { -far } else { far }; solid.len()]
    } else {
        let meter = Meter {
            progress,
            total: 2 * solid.len(),
            done: AtomicUsize::new(0),
        };
        let columns = ColumnDistances::new(pattern, &meter);
        row_pass(pattern, &columns, &meter)
    };
    progress(1.0);
    DistanceField {
        width,
        height,
        values,
    }
}

/// Counts finished pixels over all threads.
struct Meter<'a> {
    progress: &'a Progress<'a>,
    total: usize,
    done: AtomicUsize,
}

impl Meter<'_> {
    fn advance(&self, pixels: usize) {
        let done = self.done.fetch_add(pixels, Ordering::Relaxed) + pixels;
        (self.progress)(done as f64 / self.total as f64);
    }
}

/// The distance of each pixel along its column to the nearest pixel of the other
/// class, or [`NONE`]. Stored in blocks of [`BLOCK`] columns (the last may have
/// fewer), row by row in a block, so that each thread owns a slice.
struct ColumnDistances {
    width: usize,
    height: usize,
    distances: Vec<u32>,
}

impl ColumnDistances {
    fn new(pattern: &Pattern, meter: &Meter<'_>) -> Self {
        let (width, height) = (pattern.width() as usize, pattern.height() as usize);
        let mut distances = vec![0; width * height];
        distances
            .par_chunks_mut(BLOCK * height)
            .enumerate()
            .for_each(|(index, block)| {
                scan_block(pattern.solid(), width, index * BLOCK, height, block);
                meter.advance(block.len());
            });
        Self {
            width,
            height,
            distances,
        }
    }

    /// Copies row `y` of the map.
    fn copy_row(&self, y: usize, row: &mut [u32]) {
        for (index, part) in row.chunks_mut(BLOCK).enumerate() {
            let columns = BLOCK.min(self.width - index * BLOCK);
            let start = index * BLOCK * self.height + y * columns;
            part.copy_from_slice(&self.distances[start..start + columns]);
        }
    }
}

/// Scans a block of columns down and up.
fn scan_block(solid: &[bool], width: usize, first: usize, height: usize, block: &mut [u32]) {
    let columns = block.len() / height;
    let pixels = |y: usize| &solid[y * width + first..][..columns];
    let below = |y: usize| if y + 1 == height { 0 } else { y + 1 };
    let above = |y: usize| y.checked_sub(1).unwrap_or(height - 1);
    // Advances the distances to row `y` from its neighbour `from`.
    let advance = |distances: &mut [u32], y: usize, from: usize| {
        for ((distance, pixel), neighbour) in distances.iter_mut().zip(pixels(y)).zip(pixels(from))
        {
            *distance = if pixel == neighbour {
                distance.saturating_add(1)
            } else {
                1
            };
        }
    };

    // Each direction takes two laps: the first computes the distances with which
    // the second starts at the edge.
    let mut distances = [NONE; BLOCK];
    let distances = &mut distances[..columns];
    for y in 0..height {
        advance(distances, y, above(y));
    }
    for (y, row) in block.chunks_exact_mut(columns).enumerate() {
        advance(distances, y, above(y));
        row.copy_from_slice(distances);
    }
    distances.fill(NONE);
    for y in (0..height).rev() {
        advance(distances, y, below(y));
    }
    for (y, row) in block.chunks_exact_mut(columns).enumerate().rev() {
        advance(distances, y, below(y));
        for (nearest, &distance) in row.iter_mut().zip(distances.iter()) {
            *nearest = distance.min(*nearest);
        }
    }
}

/// Computes the signed distances of all rows.
fn row_pass(pattern: &Pattern, columns: &ColumnDistances, meter: &Meter<'_>) -> Vec<f32> {
    let width = columns.width;
    let solid = pattern.solid();
    let mut values = vec![0.0; solid.len()];
    let rows = ROWS_PIXELS.div_ceil(width);
    values
        .par_chunks_mut(rows * width)
        .enumerate()
        .for_each_init(
            || RowScan::new(width),
            |scan, (index, part)| {
                for (row, values) in part.chunks_exact_mut(width).enumerate() {
                    let y = index * rows + row;
                    columns.copy_row(y, &mut scan.vertical);
                    scan.run(&solid[y * width..][..width], values);
                }
                meter.advance(part.len());
            },
        );
    values
}

/// A parabola (x − apex)² + offset that is the lowest from `start` on.
struct Arc {
    apex: i64,
    offset: i64,
    start: i64,
}

impl Arc {
    fn at(&self, x: i64) -> i64 {
        (x - self.apex) * (x - self.apex) + self.offset
    }
}

/// Buffers for scanning a row.
struct RowScan {
    /// Distance along the column to the other class.
    vertical: Vec<u32>,
    envelope: Vec<Arc>,
}

impl RowScan {
    fn new(width: usize) -> Self {
        Self {
            vertical: vec![0; width],
            envelope: Vec::new(),
        }
    }

    /// Computes the signed distances of a row from `vertical`.
    ///
    /// The row is cut at *fences*: pixels of the other class, which are sources
    /// of distance 0, or in a row of one class the pixel with the least vertical
    /// distance. No source beyond a fence is nearer than the fence, so the
    /// algorithm for a segment is enough, and the torus costs nothing.
    fn run(&mut self, solid: &[bool], values: &mut [f32]) {
        let width = solid.len();
        let previous = |x: usize| x.checked_sub(1).unwrap_or(width - 1);
        let Some(first) = (0..width).find(|&x| solid[x] != solid[previous(x)]) else {
            let fence = (0..width)
                .min_by_key(|&x| self.vertical[x])
                .unwrap_or_default();
            let vertical = self.vertical[fence];
            let squared = i64::from(vertical) * i64::from(vertical);
            values[fence] = signed_distance(squared, solid[fence]);
            self.segment(solid, fence + 1, width - 1, vertical, values);
            return;
        };
        // Runs of one class.
        let mut start = first;
        while start < first + width {
            let class = solid[start % width];
            let length = (start + 1..first + width)
                .find(|&x| solid[x % width] != class)
                .unwrap_or(first + width)
                - start;
            self.segment(solid, start, length, 0, values);
            start += length;
        }
    }

    /// Computes the distances of `length` pixels of one class from `start` on
    /// (modulo the width). The fences, one pixel before and one after, have the
    /// vertical distance `fence`.
    fn segment(
        &mut self,
        solid: &[bool],
        start: usize,
        length: usize,
        fence: u32,
        values: &mut [f32],
    ) {
        // Segment coordinate 0 is the fence before the first pixel. Segments end
        // within the second repeat.
        let wrap = |x: i64| {
            let x = start + x as usize - 1;
            x.checked_sub(solid.len()).unwrap_or(x)
        };
        let last = length as i64 + 1;
        self.envelope.clear();
        self.add_source(0, fence, last);
        for x in 1..last {
            self.add_source(x, self.vertical[wrap(x)], last);
        }
        self.add_source(last, fence, last);

        for (index, arc) in self.envelope.iter().enumerate() {
            let end = self.envelope.get(index + 1).map_or(last, |arc| arc.start);
            for x in arc.start.max(1)..end {
                values[wrap(x)] = signed_distance(arc.at(x), solid[wrap(x)]);
            }
        }
    }

    /// Adds a source to the right of all others to the envelope over 0…`last`.
    fn add_source(&mut self, apex: i64, vertical: u32, last: i64) {
        if vertical == NONE {
            return;
        }
        let mut new = Arc {
            apex,
            offset: i64::from(vertical) * i64::from(vertical),
            start: 0,
        };
        let hidden = |arc: &mut Arc| arc.at(arc.start) > new.at(arc.start);
        while self.envelope.pop_if(hidden).is_some() {}
        if let Some(arc) = self.envelope.last() {
            // The last x where `arc` is not above `new`, ≥ 0 as it is not above
            // at its own start. All terms are at most 2⁶⁰.
            let numerator = (new.apex * new.apex - arc.apex * arc.apex) + (new.offset - arc.offset);
            new.start = numerator / (2 * (new.apex - arc.apex)) + 1;
        }
        if new.start <= last {
            self.envelope.push(new);
        }
    }
}

/// Returns the signed distance from the squared distance to the nearest centre of
/// the other class.
fn signed_distance(squared: i64, solid: bool) -> f32 {
    let outside = ((squared as f64).sqrt() - 0.5) as f32;
    if solid { -outside } else { outside }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::Mutex;

    fn field(pattern: &Pattern) -> DistanceField {
        signed_distance_field(pattern, &|_| ())
    }

    /// Computes one value by the definition, over all pixels.
    fn brute_force(pattern: &Pattern, x: u32, y: u32) -> f32 {
        let (width, height) = (pattern.width(), pattern.height());
        let solid = pattern.is_solid(x, y);
        let around = |a: u32, b: u32, size: u32| u64::from(a.abs_diff(b).min(size - a.abs_diff(b)));
        let nearest = (0..height)
            .flat_map(|v| (0..width).map(move |u| (u, v)))
            .filter(|&(u, v)| pattern.is_solid(u, v) != solid)
            .map(|(u, v)| around(x, u, width).pow(2) + around(y, v, height).pow(2))
            .min();
        let outside = match nearest {
            Some(squared) => (squared as f64).sqrt() - 0.5,
            None => f64::from(width).hypot(f64::from(height)),
        };
        (if solid { -outside } else { outside }) as f32
    }

    /// Random patterns of all densities, with and without any pixel.
    pub(in super::super) fn patterns(
        max_width: u32,
        max_height: u32,
    ) -> impl Strategy<Value = Pattern> + use<> {
        let density = prop_oneof![
            1 => Just(0.0),
            1 => Just(1.0),
            2 => 0.0..0.05,
            2 => 0.95..1.0,
            6 => 0.0..1.0,
        ];
        (1..=max_width, 1..=max_height, density).prop_flat_map(|(width, height, density)| {
            let pixels = (width * height) as usize;
            prop::collection::vec(prop::bool::weighted(density), pixels).prop_map(move |solid| {
                Pattern::from_fn(width, height, |x, y| solid[(y * width + x) as usize]).unwrap()
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Checks the Lipschitz constant at every distance on the torus, and the
        /// mean of the field.
        #[test]
        fn reduced_fields_change_no_faster(pattern in patterns(6, 5), factor in 1u32..4) {
            let tiled = Pattern::from_fn(
                pattern.width() * factor,
                pattern.height() * factor,
                |x, y| pattern.is_solid(x % pattern.width(), y % pattern.height()),
            ).unwrap();
            let fine = field(&tiled);
            let coarse = fine.reduced(factor).unwrap();
            let (width, height) = (coarse.width(), coarse.height());
            prop_assert_eq!((width, height), (pattern.width(), pattern.height()));
            let around = |a: u32, b: u32, size: u32| {
                f64::from(a.abs_diff(b).min(size - a.abs_diff(b)))
            };
            let places = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            for (x, y) in places() {
                for (u, v) in places() {
                    let change = f64::from((coarse.get(x, y) - coarse.get(u, v)).abs());
                    let distance = around(x, u, width).hypot(around(y, v, height));
                    prop_assert!(change <= distance + 1e-5, "{change} {distance}");
                }
            }
            let mean = |field: &DistanceField| {
                let values = field.values();
                values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64
            };
            let expected = mean(&fine) / f64::from(factor);
            prop_assert!((mean(&coarse) - expected).abs() < 1e-5 * (1.0 + expected.abs()));
            prop_assert_eq!(fine.reduced(0), None);
            prop_assert_eq!(fine.reduced(fine.width() + fine.height()), None);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(600))]

        #[test]
        fn equals_brute_force(pattern in patterns(24, 17)) {
            let field = field(&pattern);
            for y in 0..pattern.height() {
                for x in 0..pattern.width() {
                    prop_assert_eq!(field.get(x, y), brute_force(&pattern, x, y), "at {}, {}", x, y);
                }
            }
        }

        #[test]
        fn equals_brute_force_across_blocks(pattern in patterns(150, 3)) {
            let field = field(&pattern);
            for x in 0..pattern.width() {
                prop_assert_eq!(field.get(x, 0), brute_force(&pattern, x, 0), "at {}", x);
            }
        }
    }

    #[test]
    fn one_pixel_in_a_very_long_row_or_column() {
        // Squared distances up to 10¹⁰ overflow 32 bits.
        const LENGTH: u32 = 200_000;
        let row = field(&Pattern::from_fn(LENGTH, 1, |x, _| x == 7).unwrap());
        let column = field(&Pattern::from_fn(1, LENGTH, |_, y| y == 7).unwrap());
        let inverse = field(&Pattern::from_fn(LENGTH, 1, |x, _| x != 7).unwrap());
        for i in 0..LENGTH {
            let away = i.abs_diff(7).min(LENGTH - i.abs_diff(7));
            let wanted = if away == 0 { -0.5 } else { away as f32 - 0.5 };
            assert_eq!(row.get(i, 0), wanted);
            assert_eq!(column.get(0, i), wanted);
            assert_eq!(inverse.get(i, 0), -wanted);
        }
    }

    #[test]
    fn empty_and_full_patterns_are_farther_than_any_distance() {
        let empty = field(&Pattern::from_fn(3, 4, |_, _| false).unwrap());
        assert_eq!(empty.values(), [5.0; 12]);
        let full = field(&Pattern::from_fn(3, 4, |_, _| true).unwrap());
        assert_eq!(full.values(), [-5.0; 12]);
    }

    #[test]
    fn progress_grows_to_one() {
        let pattern = Pattern::from_fn(300, 300, |x, y| x == y).unwrap();
        let calls = Mutex::new(Vec::new());
        signed_distance_field(&pattern, &|fraction| calls.lock().unwrap().push(fraction));
        let calls = calls.into_inner().unwrap();
        assert!(calls.len() >= 7, "{calls:?}");
        assert!(calls.iter().all(|&f| f > 0.0 && f <= 1.0), "{calls:?}");
        assert_eq!(calls.last(), Some(&1.0));
    }

    #[test]
    #[ignore = "large, and prints the time it takes: run by hand in release"]
    fn discs_of_4096_squared() {
        const SIZE: u32 = 4096;
        let pattern = Pattern::from_fn(SIZE, SIZE, |x, y| {
            let (x, y) = ((x % 256).abs_diff(128), (y % 256).abs_diff(128));
            x * x + y * y < 80 * 80
        })
        .unwrap();
        let started = std::time::Instant::now();
        let field = field(&pattern);
        let transformed = started.elapsed();
        super::super::ShapeMap::encode(&field, super::super::Storage::R16);
        println!(
            "transform {transformed:?}, with encoding {:?}",
            started.elapsed()
        );
        for i in 0..20 {
            let (x, y) = (i * 997 % SIZE, i * 3001 % SIZE);
            assert_eq!(field.get(x, y), brute_force(&pattern, x, y), "at {x}, {y}");
        }
    }
}
