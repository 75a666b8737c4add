//! Sums of two numbers, the second one less than half a unit of the first: 48 bits.

/// Returns the sum of `a` and `b`, rounded, and its error, exactly.
#[inline]
pub(crate) fn two_sum(a: f32, b: f32) -> (f32, f32) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Returns the result of [`two_sum`] for |a| ≥ |b|, or a = 0.
#[inline]
pub(crate) fn fast_two_sum(a: f32, b: f32) -> (f32, f32) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Returns halves of 12 bits each of `a`.
#[inline]
fn split(a: f32) -> (f32, f32) {
    let shifted = a * 4097.0;
    let high = shifted - (shifted - a);
    (high, a - high)
}

/// Returns the product of `a` and `b`, rounded, and its error, exactly, if it is 0 or of a
/// magnitude in 2⁻⁷⁰…2¹⁰⁰.
#[inline]
pub(crate) fn two_product(a: f32, b: f32) -> (f32, f32) {
    let product = a * b;
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, error)
}

/// Returns the product of two pairs.
#[inline]
pub(crate) fn product((a, a_low): (f32, f32), (b, b_low): (f32, f32)) -> (f32, f32) {
    let (high, low) = two_product(a, b);
    fast_two_sum(high, low + (a * b_low + a_low * b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_are_exact() {
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..100_000 {
            let [a, b] = [(); 2]
                .map(|_| (random.f32() - 0.5) * f32::from_bits((100 + random.u32(..54)) << 23));
            let (high, low) = two_product(a, b);
            assert_eq!(
                f64::from(a) * f64::from(b),
                f64::from(high) + f64::from(low)
            );
            let (high, low) = two_sum(a, b);
            assert_eq!(
                f64::from(a) + f64::from(b),
                f64::from(high) + f64::from(low)
            );
            assert_eq!(high, a + b);
        }
    }
}
