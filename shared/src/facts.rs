//! Facts about an object that are known before anything is drawn.
//!
//! The compiler removes the code for features that an object does not use from
//! shaders that are given [`known`]. The values are those of the object, so that
//! the results are the same.

use crate::layout::{FORMAT_CODES, Object, TIER_FAST, TIER_PLANAR};
use crate::profile::{self, grows, know_layered, know_straight, know_upright};

/// The tier is the planar one.
pub const PLANAR: u32 = 1;
/// The tier is the fast one.
pub const CURVED: u32 = 2;
/// The pattern does not grow with the depth: walls stand upright.
pub const UPRIGHT: u32 = 4;
/// The map holds codes, not floats and not the paper's form.
pub const CODES: u32 = 8;
/// The profile is straight: nothing but a bevel or a chamfer.
pub const STRAIGHT: u32 = 16;

/// The object is a stack of layers ([`stack`](crate::stack)). Only shaders for which it holds draw stacks.
pub const LAYERED: u32 = 32;

/// Returns all facts that are true of `object`.
pub fn facts(object: &Object) -> u32 {
    let when = |is_so, fact| if is_so { fact } else { 0 };
    when(object.tier == TIER_PLANAR, PLANAR)
        | when(object.tier == TIER_FAST, CURVED)
        | when(!grows(object), UPRIGHT)
        | when(object.map_format == FORMAT_CODES, CODES)
        | when(object.profile == profile::STRAIGHT, STRAIGHT)
        | when(object.profile == profile::LAYERED, LAYERED)
}

/// Returns `object`, for which `FACTS` hold, with the fields they determine as constants.
#[inline]
pub fn known<const FACTS: u32>(object: &Object) -> Object {
    let mut known = *object;
    if FACTS & PLANAR != 0 {
        known.tier = TIER_PLANAR;
    }
    if FACTS & CURVED != 0 {
        known.tier = TIER_FAST;
    }
    if FACTS & UPRIGHT != 0 {
        know_upright(&mut known);
    }
    if FACTS & CODES != 0 {
        known.map_format = FORMAT_CODES;
    }
    if FACTS & STRAIGHT != 0 {
        know_straight(&mut known);
    }
    if FACTS & LAYERED != 0 {
        know_layered(&mut known);
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{FORMAT_FLOAT, TIER_ACCURATE};

    #[test]
    fn each_fact_is_true_of_the_objects_that_it_is_said_of_only() {
        let mut seen = 0;
        for tier in [TIER_PLANAR, TIER_FAST, TIER_ACCURATE] {
            for bevel in [0.0, 0.1] {
                for (map_format, profile) in [
                    (FORMAT_CODES, profile::STRAIGHT),
                    (FORMAT_FLOAT, profile::STRAIGHT),
                    (FORMAT_CODES, profile::LAYERED),
                ] {
                    let object = Object {
                        tier,
                        bevel,
                        map_format,
                        profile,
                        ..Object::default()
                    };
                    let all = facts(&object);
                    seen |= all;
                    let changes = |fact, known: Object| {
                        assert_eq!(all & fact != 0, known == object, "{fact} {object:?}");
                    };
                    changes(PLANAR, known::<PLANAR>(&object));
                    changes(CURVED, known::<CURVED>(&object));
                    changes(UPRIGHT, known::<UPRIGHT>(&object));
                    changes(CODES, known::<CODES>(&object));
                    changes(STRAIGHT, known::<STRAIGHT>(&object));
                    changes(LAYERED, known::<LAYERED>(&object));
                    assert_eq!(known::<0>(&object), object);
                }
            }
        }
        assert_eq!(seen, PLANAR | CURVED | UPRIGHT | CODES | STRAIGHT | LAYERED);
    }
}
