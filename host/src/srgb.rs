//! The transfer function of sRGB (IEC 61966-2-1).

/// Returns linear light for an sRGB value; both 0…1.
pub(crate) fn linear(value: f64) -> f64 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}
