use super::*;
use std::f64::consts::TAU;

/// A small generator (splitmix64), so that many thousand cases are the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in `low..high`.
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A whole number in `low..=high`.
    pub(crate) fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + (self.next() % u64::from(high - low + 1)) as u32
    }

    /// A number whose magnitude is anything in `low..high`.
    pub(crate) fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    /// One of `choices`.
    pub(crate) fn choose<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.whole(0, choices.len() as u32 - 1) as usize]
    }
}

/// An encoded map, and what it holds, in f64.
#[derive(Clone)]
pub(crate) struct Sample {
    pub(crate) object: Object,
    pub(crate) words: Vec<u32>,
    pub(crate) width: usize,
    pub(crate) height: usize,
    values: Vec<f64>,
}

/// A form of storage: format, log₂ of the texels in a word, and step in texels.
pub(crate) type Form = (u32, u32, f64);

/// All forms, from the finest to the coarsest. Some saturate.
pub(crate) const FORMS: [Form; 9] = [
    (FORMAT_FLOAT, 0, 0.0),
    (FORMAT_CODES, 1, 1.0 / 256.0),
    (FORMAT_CODES, 1, 1.0 / 16.0),
    (FORMAT_CODES, 1, 0.5),
    (FORMAT_CODES, 2, 1.0 / 256.0),
    (FORMAT_CODES, 2, 1.0 / 16.0),
    (FORMAT_CODES, 2, 0.5),
    (FORMAT_PAPER, 0, 1.0 / 16.0),
    (FORMAT_PAPER, 0, 0.5),
];

/// Fixed-point codes of `values`, rounded down, their bias, and what they stand for.
fn codes(values: &[f64], packing: u32, step: f64) -> (Vec<u32>, u32, Vec<f64>) {
    let largest = (1i64 << (32 >> packing)) - 1;
    let counts: Vec<i64> = values.iter().map(|v| (v / step).floor() as i64).collect();
    let lowest = counts.iter().copied().min().unwrap();
    let bias = (-lowest).clamp(0, (largest + 1) / 2);
    let codes: Vec<i64> = counts
        .iter()
        .map(|count| (count + bias).clamp(0, largest))
        .collect();
    let stored = codes.iter().map(|c| (c - bias) as f64 * step).collect();
    let codes = codes.iter().map(|&code| code as u32).collect();
    (codes, bias as u32, stored)
}

/// The paper's RGBA8 words of `values`, without normals, and what they stand for.
fn paper_words(values: &[f64], step: f64) -> (Vec<u32>, Vec<f64>) {
    values
        .iter()
        .map(|&value| {
            if value < 0.0 {
                return (0, -0.5);
            }
            // Counted from pixel centre to pixel centre.
            let count = ((value + 0.5) / step).floor().min(255.0);
            let word = 255 << 24 | (count as u32) << 16;
            (word, (count * step - 0.5).max(0.5))
        })
        .unzip()
}

impl Sample {
    /// Rounds `values` (texels, rows from the top) down to steps; what does
    /// not fit the form saturates.
    pub(crate) fn new(width: usize, values: &[f64], form: Form) -> Sample {
        let (format, packing, step) = form;
        let (words, bias, stored) = if format == FORMAT_FLOAT {
            let stored: Vec<f32> = values.iter().map(|&value| value as f32).collect();
            let words = stored.iter().map(|value| value.to_bits()).collect();
            (words, 0, stored.into_iter().map(f64::from).collect())
        } else if format == FORMAT_PAPER {
            let (words, stored) = paper_words(values, step);
            (words, 0, stored)
        } else {
            let (codes, bias, stored) = codes(values, packing, step);
            let mut words = vec![0u32; values.len().div_ceil(1 << packing)];
            for (i, code) in codes.into_iter().enumerate() {
                let lane = i & ((1 << packing) - 1);
                words[i >> packing] |= code << (lane as u32 * (32 >> packing));
            }
            (words, bias, stored)
        };
        let height = values.len() / width;
        Sample {
            object: Object {
                map_size: [width as f32, height as f32],
                map_step: step as f32,
                map_quantum: step as f32,
                map_reach: 2.0,
                map_bias: bias,
                map_packing: packing,
                map_format: format,
                depth: 1.0,
                chamfer: 1.0,
                ..Object::default()
            }
            .complete(),
            words,
            width,
            height,
            values: stored,
        }
    }

    /// The signed distances of a pattern.
    pub(crate) fn of_pattern(width: usize, pattern: &[bool], form: Form) -> Sample {
        Sample::new(width, &signed_distances(width, pattern), form)
    }

    /// Patterns of the same size whose words are one after the other, in each sample.
    pub(crate) fn stacked(width: usize, patterns: &[Vec<bool>], form: Form) -> Vec<Sample> {
        let distances = patterns
            .iter()
            .map(|pattern| signed_distances(width, pattern));
        let all = Sample::new(width, &distances.collect::<Vec<_>>().concat(), form);
        let texels = all.values.len() / patterns.len();
        let height = all.height / patterns.len();
        let object = Object {
            map_size: [width as f32, height as f32],
            ..all.object
        };
        all.values
            .chunks(texels)
            .map(|values| Sample {
                object: object.complete(),
                words: all.words.clone(),
                width,
                height,
                values: values.to_vec(),
            })
            .collect()
    }

    /// A random pattern of 1…40 × 1…40 texels in a random form.
    pub(crate) fn random(random: &mut Random) -> Sample {
        let (width, pattern) = random_pattern(random);
        let form = random.choose(&FORMS);
        Sample::of_pattern(width, &pattern, form)
    }

    /// Makes a map of codes no distance field any more: all values times `factor`.
    pub(crate) fn steepen(&mut self, factor: f32) {
        self.object.map_step *= factor;
        self.values
            .iter_mut()
            .for_each(|value| *value *= f64::from(factor));
    }

    pub(crate) fn map(&self) -> ShapeMap {
        ShapeMap::new(&self.object)
    }

    /// The value between the texels around (`x`, `y`), where texel centres are whole numbers.
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        let texel = |column: f64, row: f64| {
            let column = (column as i64).rem_euclid(self.width as i64);
            let row = (row as i64).rem_euclid(self.height as i64);
            self.values[row as usize * self.width + column as usize]
        };
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        (1.0 - fy) * ((1.0 - fx) * texel(left, top) + fx * texel(left + 1.0, top))
            + fy * ((1.0 - fx) * texel(left, top + 1.0) + fx * texel(left + 1.0, top + 1.0))
    }

    /// Texture coordinates in the units of [`Sample::at`].
    pub(crate) fn texel_of(&self, uv: [f64; 2]) -> [f64; 2] {
        [
            uv[0] * self.width as f64 - 0.5,
            uv[1] * self.height as f64 - 0.5,
        ]
    }
}

/// Width and pixels of a pattern: noise of any density, or a few rectangles.
fn random_pattern(random: &mut Random) -> (usize, Vec<bool>) {
    let (width, height) = (random.whole(1, 40) as usize, random.whole(1, 40) as usize);
    let mut pattern = vec![false; width * height];
    if random.whole(0, 1) == 0 {
        let density = random.magnitude(1e-3, 1.0);
        for pixel in &mut pattern {
            *pixel = random.within(0.0, 1.0) < density;
        }
    } else {
        for _ in 0..random.whole(1, 4) {
            let (x, y) = (random.whole(0, 39) as usize, random.whole(0, 39) as usize);
            let (w, h) = (random.whole(1, 20) as usize, random.whole(1, 20) as usize);
            for (row, column) in (y..y + h).flat_map(|row| (x..x + w).map(move |c| (row, c))) {
                pattern[row % height * width + column % width] = true;
            }
        }
    }
    if random.whole(0, 1) == 0 {
        pattern.iter_mut().for_each(|pixel| *pixel = !*pixel);
    }
    (width, pattern)
}

/// Signed distances on the torus, texels, by trying all pairs (section 3).
fn signed_distances(width: usize, pattern: &[bool]) -> Vec<f64> {
    let height = pattern.len() / width;
    let positions = |wanted: bool| -> Vec<(i64, i64)> {
        (0..pattern.len())
            .filter(|&i| pattern[i] == wanted)
            .map(|i| ((i % width) as i64, (i / width) as i64))
            .collect()
    };
    let (inside, outside) = (positions(true), positions(false));
    (0..pattern.len())
        .map(|i| {
            let others = if pattern[i] { &outside } else { &inside };
            let nearest = others
                .iter()
                .map(|&(x, y)| {
                    let dx = (x - (i % width) as i64).rem_euclid(width as i64);
                    let dy = (y - (i / width) as i64).rem_euclid(height as i64);
                    let (dx, dy) = (dx.min(width as i64 - dx), dy.min(height as i64 - dy));
                    dx * dx + dy * dy
                })
                .min()
                // Neither an empty nor a full pattern has an edge.
                .unwrap_or((width * width + height * height) as i64);
            let distance = (nearest as f64).sqrt() - 0.5;
            if pattern[i] { -distance } else { distance }
        })
        .collect()
}

/// Where the straight line from `from` by `displacement` (texels) leaves one
/// cell of the interpolation for the next, as fractions 0…1, sorted, with 0
/// and 1: between two of them the field is a quadratic.
pub(crate) fn cell_borders(from: [f64; 2], displacement: [f64; 2]) -> Vec<f64> {
    let mut borders = vec![0.0, 1.0];
    for axis in 0..2 {
        let (start, end) = (from[axis], from[axis] + displacement[axis]);
        let (low, high) = (start.min(end).ceil() as i64, start.max(end).floor() as i64);
        for line in low..=high {
            let fraction = (line as f64 - start) / displacement[axis];
            if fraction > 0.0 && fraction < 1.0 {
                borders.push(fraction);
            }
        }
    }
    borders.sort_by(f64::total_cmp);
    borders
}

/// The least value of a function that is a quadratic between neighbours of
/// `borders`: exact, where sampling could miss a dip.
pub(crate) fn least_value(borders: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let mut least = f64::INFINITY;
    for pair in borders.windows(2) {
        let start = f(pair[0]);
        let middle = f(0.5 * (pair[0] + pair[1]));
        let end = f(pair[1]);
        least = least.min(start).min(end);
        let square = 2.0 * (start - 2.0 * middle + end);
        let linear = end - start - square;
        if square > 0.0 && linear < 0.0 && -linear < 2.0 * square {
            least = least.min(start - linear * linear / (4.0 * square));
        }
    }
    least
}

#[test]
fn distances_agree_with_a_plain_reference() {
    let mut random = Random(1);
    for case in 0..400 {
        let mut sample = Sample::random(&mut random);
        // Rows and columns of a single texel, too.
        if case % 4 == 0 {
            let (width, mut pattern) = random_pattern(&mut random);
            let form = random.choose(&FORMS);
            sample = match case % 3 {
                0 => Sample::of_pattern(1, &pattern, form),
                1 => Sample::of_pattern(pattern.len(), &pattern, form),
                _ => {
                    pattern.truncate(1);
                    Sample::of_pattern(width.min(1), &pattern, form)
                }
            };
        }
        let map = sample.map();
        let step = 1.0 / sample.width as f64;
        for _ in 0..100 {
            let uv = Vec2::new(
                random.choose(&[0.0, step, 0.5 * step, random_uv(&mut Random(case)), -0.25]) as f32,
                random.within(-4.0, 4.0) as f32,
            );
            let [x, y] = sample.texel_of([f64::from(uv.x), f64::from(uv.y)]);
            let expected = sample.at(x, y);
            let found = f64::from(map.distance(&sample.words[..], uv));
            // A coordinate in f32 is wrong by up to 2⁻²³ of the map's size,
            // and the field rises by at most √2 (1 + step) a texel.
            let size = sample.width.max(sample.height) as f64;
            let tolerance = 1e-6 * (size + expected.abs());
            assert!(
                (found - expected).abs() <= tolerance,
                "{found} {expected} at {uv} of {} × {}",
                sample.width,
                sample.height
            );
        }
    }
}

fn random_uv(random: &mut Random) -> f64 {
    random.within(-4.0, 4.0)
}

#[test]
fn every_texel_is_found_at_its_centre_in_every_repeat() {
    for form in FORMS {
        let values: Vec<f64> = (0..15).map(|i| f64::from(i * i % 17) * 0.5 - 0.5).collect();
        let sample = Sample::new(5, &values, form);
        let map = sample.map();
        for (i, &stored) in sample.values.iter().enumerate() {
            for repeat in [-1.0, 0.0, 3.0] {
                let uv = Vec2::new(
                    (i % 5) as f32 * 0.2 + 0.1 + repeat,
                    ((i / 5) as f32 + 0.5) / 3.0 - repeat,
                );
                let found = f64::from(map.distance(&sample.words[..], uv));
                assert!((found - stored).abs() < 2e-5, "{found} {stored} {form:?}");
            }
        }
    }
}

#[test]
fn a_map_of_one_texel_is_constant() {
    let sample = Sample::new(1, &[2.5], FORMS[2]);
    for uv in [0.0, 0.25, 0.5, 0.99, -3.7] {
        let found = sample.map().distance(&sample.words[..], Vec2::splat(uv));
        assert_eq!(found, 2.5);
    }
}

/// Texels that must not be asked for what they do not have.
struct Bounded(u32);

impl Texels for Bounded {
    fn word(&self, index: u32) -> u32 {
        assert!(index < self.0, "word {index} of {}", self.0);
        0
    }
}

#[test]
fn no_texture_coordinate_leads_outside_the_map() {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.999_999_94,
        -1e-9,
        -1e-45,
        1e9,
        -1e9,
        8_388_607.5,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    let mut random = Random(2);
    for case in 0..300 {
        let (width, height) = (random.whole(1, 9), random.whole(1, 9));
        let (format, packing, _) = FORMS[case % FORMS.len()];
        let map = ShapeMap::new(
            &Object {
                map_reach: 2.0,
                map_size: [width as f32, height as f32],
                map_step: 0.5,
                map_packing: packing,
                map_format: format,
                ..Object::default()
            }
            .complete(),
        );
        let texels = Bounded((width * height).div_ceil(1 << packing));
        for u in special {
            for v in special {
                map.distance(&texels, Vec2::new(u, v));
                map.gradient(&texels, Vec2::new(v, u));
            }
        }
        for _ in 0..100 {
            let bits = Vec2::new(
                f32::from_bits(random.next() as u32),
                f32::from_bits(random.next() as u32),
            );
            map.distance(&texels, bits);
        }
    }
}

#[test]
fn the_gradient_of_a_straight_edge_is_one_across_it() {
    let pattern: Vec<bool> = (0..32 * 16).map(|i| i % 32 < 16).collect();
    let sample = Sample::of_pattern(32, &pattern, FORMS[0]);
    let map = sample.map();
    // The edges lie at u = ½ (rising) and u = 0 (falling).
    let rising = map.gradient(&sample.words[..], Vec2::new(0.5, 0.3));
    let falling = map.gradient(&sample.words[..], Vec2::new(0.0, 0.3));
    assert!((rising - Vec2::X).length() < 1e-4, "{rising}");
    assert!((falling + Vec2::X).length() < 1e-4, "{falling}");
    let pattern: Vec<bool> = (0..32 * 16).map(|i| i / 32 < 8).collect();
    let sample = Sample::of_pattern(32, &pattern, FORMS[0]);
    let down = sample
        .map()
        .gradient(&sample.words[..], Vec2::new(0.3, 0.5));
    assert!((down - Vec2::Y).length() < 1e-4, "{down}");
}

#[test]
fn the_paper_form_stores_its_normals() {
    let map = ShapeMap::new(
        &Object {
            map_reach: 2.0,
            map_size: [2.0, 1.0],
            map_step: 1.0,
            map_format: FORMAT_PAPER,
            ..Object::default()
        }
        .complete(),
    );
    // R and G are 255 and 0 at the left, 0 and 255 at the right.
    let words = [0xff07_00ff_u32, 0xff07_ff00];
    let gradient = |u| map.gradient(&words[..], Vec2::new(u, 0.5));
    assert!((gradient(0.25) - Vec2::new(1.0, -1.0)).length() < 1e-6);
    assert!((gradient(0.75) - Vec2::new(-1.0, 1.0)).length() < 1e-6);
    assert!(gradient(0.5).length() < 1e-6);
}

/// Rounding aside: f and r are f32s of up to 64, wrong by a few 2⁻¹⁸.
const ROUNDING: f64 = 5e-5;

/// Steps `bound(f, r)` texels from random points in random directions, and
/// returns how many steps could be tried and by how much the worst one sank
/// below r, with its description.
fn worst_step(
    seed: u64,
    maps: u32,
    rays: u32,
    bound: impl Fn(&SafeStep, f32, f32) -> f32,
) -> (u32, f64, String) {
    let mut random = Random(seed);
    let (mut tried, mut worst, mut description) = (0, 0.0, String::new());
    for _ in 0..maps {
        let sample = Sample::random(&mut random);
        let map = sample.map();
        let safe = map.safe;
        for _ in 0..rays {
            let uv = Vec2::new(
                random.within(0.0, 1.0) as f32,
                random.within(0.0, 1.0) as f32,
            );
            let angle = random.within(0.0, TAU);
            let f = map.distance(&sample.words[..], uv);
            let radius = match random.whole(0, 3) {
                0 => 0.0,
                1 => random.within(-4.0, 0.0),
                2 => random.within(0.0, 4.0),
                _ => f64::from(f) - random.magnitude(0.01, 20.0),
            } as f32;
            let length = f64::from(bound(&safe, f, radius));
            if f <= radius || length <= 0.0 {
                continue;
            }
            tried += 1;
            let from = sample.texel_of([f64::from(uv.x), f64::from(uv.y)]);
            let displacement = [length * angle.cos(), length * angle.sin()];
            let borders = cell_borders(from, displacement);
            let least = least_value(&borders, |fraction| {
                sample.at(
                    from[0] + fraction * displacement[0],
                    from[1] + fraction * displacement[1],
                )
            });
            let sunk = f64::from(radius) - least;
            if sunk > worst {
                worst = sunk;
                description = format!(
                    "{} × {} texels in format {} with steps of {}, from {from:?} by {displacement:?}: f = {f}, r = {radius}, sinks to {least}",
                    sample.width, sample.height, sample.object.map_format, sample.object.map_step
                );
            }
        }
    }
    (tried, worst, description)
}

/// The safe displacement for a fixed radius, texels, ≥ 0.
fn at_fixed_radius(safe: &SafeStep, distance: Real, radius: Real) -> Real {
    let gap = distance - radius;
    let near = gap / safe.steepest;
    let far = if distance >= 1.5 {
        gap - safe.margin
    } else {
        0.0
    };
    max(max(near, far), 0.0)
}

#[test]
fn a_safe_step_never_sinks_to_the_radius() {
    let (tried, worst, description) = worst_step(3, 1000, 300, at_fixed_radius);
    println!("{tried} steps, worst {worst:e}: {description}");
    assert!(tried > 100_000, "{tried}");
    assert!(worst <= ROUNDING, "{description}");
}

/// What the bound guards against: sphere tracing as if the field were exact.
#[test]
fn longer_steps_sink_below_the_radius() {
    let too_long: [fn(&SafeStep, f32, f32) -> f32; 3] = [
        |_, f, r| f - r,
        // A little more than the slope allows.
        |safe, f, r| 1.2 * (f - r) / safe.steepest,
        // A tenth of the margin that Jensen's inequality asks for.
        |safe, f, r| {
            if f >= 1.5 {
                f - r - 0.1 * safe.margin
            } else {
                0.0
            }
        },
    ];
    for (number, bound) in too_long.into_iter().enumerate() {
        let (_, worst, description) = worst_step(4, 300, 200, bound);
        println!("bound {number}: worst {worst:e}: {description}");
        assert!(worst > 10.0 * ROUNDING, "bound {number} was never too long");
    }
}
