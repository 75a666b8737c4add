//! Limits on the number of pixels.

/// Default limit on the number of pixels of an image: 2²⁸, a square of 16,384.
pub const DEFAULT_MAX_PIXELS: u64 = 1 << 28;

/// Upper bound of every limit on pixels: 2³⁰. To this number squared distances
/// fit the integers used, and byte offsets fit 32 bits.
pub const MAX_PIXELS: u64 = 1 << 30;
