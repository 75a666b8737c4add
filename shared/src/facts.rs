//! Facts about an object that are known before anything is drawn.
//!
//! The compiler removes the code for features that an object does not use from
//! shaders that are given [`known`]. The values are those of the object, so that
//! the results are the same.

use crate::layout::{FORMAT_CODES, Object, TIER_FAST, TIER_PLANAR};

/// The tier is the planar one.
pub const PLANAR: u32 = 1;
/// The tier is the fast one.
pub const CURVED: u32 = 2;
/// The pattern does not grow with the depth: walls stand upright.
pub const UPRIGHT: u32 = 4;
/// The map holds codes, not floats and not the paper's form.
pub const CODES: u32 = 8;

/// Returns all facts that are true of `object`.
pub fn facts(object: &Object) -> u32 {
    let when = |is_so, fact| if is_so { fact } else { 0 };
    when(object.tier == TIER_PLANAR, PLANAR)
        | when(object.tier == TIER_FAST, CURVED)
        | when(object.bevel == 0.0, UPRIGHT)
        | when(object.map_format == FORMAT_CODES, CODES)
}

/// Returns `object`, which `FACTS` are true of, as the compiler may know it.
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
        known.bevel = 0.0;
    }
    if FACTS & CODES != 0 {
        known.map_format = FORMAT_CODES;
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
                for map_format in [FORMAT_CODES, FORMAT_FLOAT] {
                    let object = Object {
                        tier,
                        bevel,
                        map_format,
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
                    assert_eq!(known::<0>(&object), object);
                }
            }
        }
        assert_eq!(seen, PLANAR | CURVED | UPRIGHT | CODES);
    }
}
