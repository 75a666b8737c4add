//! Unit vectors.

use super::Distribution;
use super::number::SMALLEST;
use super::random::Random;

/// Largest deviation of a unit vector's squared length from 1.
const ROUNDING: f64 = 1e-5;

/// Draws a unit vector, as words.
pub(super) fn draw(distribution: Distribution, random: &mut Random) -> [u32; 3] {
    let vector = match distribution {
        Distribution::Value | Distribution::Recorded => on_the_sphere(random),
        Distribution::Bits => uneven(random),
        Distribution::Edges if random.coin() => special(random),
        Distribution::Edges => uneven(random),
    };
    normalize(vector)
}

/// Returns whether three words are a unit vector.
pub(super) fn contains(words: [u32; 3]) -> bool {
    let vector = words.map(f32::from_bits);
    let smallest = f32::from_bits(SMALLEST);
    let length_squared: f64 = vector.map(|x| f64::from(x) * f64::from(x)).iter().sum();
    vector.iter().all(|x| *x == 0.0 || x.abs() >= smallest)
        && (length_squared - 1.0).abs() <= ROUNDING
}

/// Draws a direction uniformly on the sphere, by rejection from a cube.
fn on_the_sphere(random: &mut Random) -> [f64; 3] {
    loop {
        let vector: [f64; 3] = std::array::from_fn(|_| 2.0 * random.unit() - 1.0);
        if (1e-6..=1.0).contains(&dot(vector)) {
            return vector;
        }
    }
}

/// Draws components of magnitudes from 2⁻²⁰ to 2, every exponent equally likely.
fn uneven(random: &mut Random) -> [f64; 3] {
    std::array::from_fn(|_| {
        let magnitude = power(random.up_to(20)) * (1.0 + random.unit());
        signed(magnitude, random)
    })
}

/// Draws an axis, a diagonal of a face or of the cube, or a vector close to an axis.
fn special(random: &mut Random) -> [f64; 3] {
    let mut vector = [1.0, 0.0, 0.0];
    match random.up_to(3) {
        0 => {}
        1 => vector[1] = 1.0,
        2 => vector = [1.0; 3],
        _ => {
            for side in &mut vector[1..] {
                *side = power(random.up_to(20));
            }
            if random.coin() {
                vector[2] = 0.0;
            }
        }
    }
    vector.rotate_left(random.up_to(2) as usize);
    vector.map(|x| signed(x, random))
}

fn signed(x: f64, random: &mut Random) -> f64 {
    if random.coin() { x } else { -x }
}

/// Returns 2 to the power of minus `exponent`, which is at most 20.
fn power(exponent: u32) -> f64 {
    1.0 / (1_u64 << exponent) as f64
}

fn dot(vector: [f64; 3]) -> f64 {
    vector.map(|x| x * x).iter().sum()
}

/// Normalises in f64 and rounds to f32. Components too small for the domain
/// become +0.
fn normalize(vector: [f64; 3]) -> [u32; 3] {
    let length = dot(vector).sqrt();
    vector.map(|x| {
        let component = (x / length) as f32;
        if component.abs() < f32::from_bits(SMALLEST) {
            0
        } else {
            component.to_bits()
        }
    })
}
