//! What an object needs of the shaders.
//!
//! [`known`] is an object of which is known what it does not need: code that
//! is given that holds nothing for it, since the compiler knows too. The values
//! are those that the object has anyhow, so that the results are the same.

use crate::layout::{FORMAT_CODES, Object, TIER_FAST, TIER_PLANAR};

/// The surface bends the rays: the tier is not the planar one.
pub const CURVED: u32 = 1;
/// The pattern grows with the depth: there is a bevel or a chamfer.
pub const GROWING: u32 = 2;
/// Nothing is known: any tier, any profile, any format of the map.
pub const ANYTHING: u32 = 0xffff_ffff;

/// What `object` needs: [`CURVED`] and [`GROWING`], each or none, or [`ANYTHING`]
/// where none of them would do.
pub fn needs(object: &Object) -> u32 {
    let curved = match object.tier {
        TIER_PLANAR => 0,
        TIER_FAST => CURVED,
        _ => return ANYTHING,
    };
    if object.map_format != FORMAT_CODES {
        return ANYTHING;
    }
    curved | if object.bevel == 0.0 { 0 } else { GROWING }
}

/// `object`, which needs `NEEDS` by [`needs`].
#[inline]
pub fn known<const NEEDS: u32>(object: &Object) -> Object {
    let mut known = *object;
    if NEEDS != ANYTHING {
        known.map_format = FORMAT_CODES;
        known.tier = if NEEDS & CURVED == 0 {
            TIER_PLANAR
        } else {
            TIER_FAST
        };
        if NEEDS & GROWING == 0 {
            known.bevel = 0.0;
        }
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{FORMAT_FLOAT, TIER_ACCURATE};

    #[test]
    fn what_is_known_is_what_the_object_is() {
        let mut seen = std::collections::BTreeSet::new();
        for tier in [TIER_PLANAR, TIER_FAST, TIER_ACCURATE] {
            for (bevel, format) in [
                (0.0, FORMAT_CODES),
                (0.1, FORMAT_CODES),
                (0.1, FORMAT_FLOAT),
            ] {
                let object = Object {
                    tier,
                    bevel,
                    map_format: format,
                    ..Object::default()
                };
                let needed = needs(&object);
                seen.insert(needed);
                let known = match needed {
                    0 => known::<0>(&object),
                    CURVED => known::<CURVED>(&object),
                    GROWING => known::<GROWING>(&object),
                    3 => known::<3>(&object),
                    _ => known::<ANYTHING>(&object),
                };
                assert_eq!(known, object);
            }
        }
        assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3, ANYTHING]);
    }
}
