//! The words of a pixel with smooth edges: its light and that of what lies between it and its neighbours, its class,
//! and the shares of all of them.
//!
//! Neighbours mix with the light of the pixel's own surface only: what lies between is on another side of it.

use crate::arithmetic::{clamp, kept3, max};
use crate::contract::check3;
use crate::trace::word;
use crate::{Real, Vec3};
use glam::{UVec3, UVec4};

/// Steps of a neighbour's share in its code, and of the share of what lies between.
const SHARES: Real = 510.0;
const BETWEEN_SHARES: Real = 127.0;
/// Places of the codes of `before` and `after` above the class, the flag `is_down`, and the place of the share of
/// what lies between.
const BEFORE: u32 = 8;
const AFTER: u32 = 16;
const IS_DOWN: u32 = 1 << 24;
const BETWEEN: u32 = 25;

/// Bits of a f32's mantissa that a channel of half a word leaves out: 10 are left.
const LEFT_OUT: u32 = 13;
/// The least channel, 2⁻³², which stands for 0, and its code before that. The largest channel is nearly 2³².
const LEAST_CHANNEL: Real = 1.0 / 4_294_967_296.0;
const LEAST: u32 = (127 - 32) << 10;

/// The shares in the class word of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Whether they are those of the neighbours above and below, rather than to the left and right.
    pub is_down: bool,
    /// Share of the neighbour to the left or above, 0…½.
    pub before: Real,
    /// Share of the one to the right or below, 0…½.
    pub after: Real,
    /// Share of what lies between, of what the neighbours leave, 0…1.
    pub between: Real,
}

impl Shares {
    /// Returns the class word of a pixel with these shares.
    #[inline]
    pub fn code(&self, class: u32) -> u32 {
        let share = |x: Real| (clamp(x, 0.0, 0.5) * SHARES + 0.5) as u32;
        let between = (clamp(self.between, 0.0, 1.0) * BETWEEN_SHARES + 0.5) as u32;
        let axis = if self.is_down { IS_DOWN } else { 0 };
        class
            | share(self.before) << BEFORE
            | share(self.after) << AFTER
            | axis
            | between << BETWEEN
    }
}

/// Returns the class in a class word, and the shares.
#[inline]
pub fn from_code(word: u32) -> (u32, Shares) {
    const SHARE: Real = 1.0 / 510.0;
    const BETWEEN_SHARE: Real = 1.0 / 127.0;
    let share = |place: u32| ((word >> place) & 0xff) as i32 as Real * SHARE;
    let shares = Shares {
        is_down: word & IS_DOWN != 0,
        before: share(BEFORE),
        after: share(AFTER),
        between: (word >> BETWEEN) as i32 as Real * BETWEEN_SHARE,
    };
    (word & 0xff, shares)
}

/// Returns the words of a pixel's light, `own` and that `between`, beside its class word: three f32 if nothing lies
/// between, else a channel of both a word. These have the precision of a half float (2⁻¹¹), and range to 2³².
#[inline]
pub fn light_words(own: Vec3, between: Vec3, class_word: u32) -> UVec3 {
    let (own, between) = (kept3(own), kept3(between));
    check3(own);
    check3(between);
    if class_word >> BETWEEN == 0 {
        UVec3::new(word(own.x), word(own.y), word(own.z))
    } else {
        let channel = |own: Real, between: Real| half(own) | half(between) << 16;
        UVec3::new(
            channel(own.x, between.x),
            channel(own.y, between.y),
            channel(own.z, between.z),
        )
    }
}

/// Returns the light in the words of a pixel: of its own surface, and of what lies between it and its
/// neighbours, 0 if nothing does.
#[inline]
pub fn lights_of(words: UVec4) -> (Vec3, Vec3) {
    if words.w >> BETWEEN == 0 {
        (light_in(words.truncate()), Vec3::ZERO)
    } else {
        let upper = |word: u32| from_half(word >> 16);
        (
            Vec3::new(from_half(words.x), from_half(words.y), from_half(words.z)),
            Vec3::new(upper(words.x), upper(words.y), upper(words.z)),
        )
    }
}

/// Returns the light whose three f32 have the bits `words`.
#[inline]
pub fn light_in(words: UVec3) -> Vec3 {
    Vec3::new(
        f32::from_bits(words.x),
        f32::from_bits(words.y),
        f32::from_bits(words.z),
    )
}

/// Returns the code of a channel, 16 bits.
#[inline]
fn half(x: Real) -> u32 {
    let rounded = word(max(x, LEAST_CHANNEL)) + (1 << (LEFT_OUT - 1));
    let code = (rounded >> LEFT_OUT) - LEAST;
    if code < 0xffff { code } else { 0xffff }
}

/// Returns the channel whose code is in the lower half of `word`.
#[inline]
fn from_half(word: u32) -> Real {
    let code = word & 0xffff;
    if code == 0 {
        0.0
    } else {
        f32::from_bits((code + LEAST) << LEFT_OUT)
    }
}
