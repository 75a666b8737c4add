//! Colours as users write them and as light is computed.

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;

/// A colour: sRGB as written (`"#rrggbb"` or `[r, g, b]` with 0…1), kept as such.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color(pub [f64; 3]);

impl Color {
    /// From 0xRRGGBB.
    pub const fn from_hex(hex: u32) -> Color {
        Color([
            (hex >> 16 & 255) as f64 / 255.0,
            (hex >> 8 & 255) as f64 / 255.0,
            (hex & 255) as f64 / 255.0,
        ])
    }

    /// Linear RGB, 0…1.
    pub fn linear(self) -> [f32; 3] {
        self.0.map(|s| {
            let linear = if s <= 0.04045 {
                s / 12.92
            } else {
                ((s + 0.055) / 1.055).powf(2.4)
            };
            linear as f32
        })
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ColorVisitor;

        impl<'de> Visitor<'de> for ColorVisitor {
            type Value = Color;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a colour: \"#rrggbb\", or three numbers from 0 to 1")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Color, E> {
                let digits = text.strip_prefix('#').unwrap_or_default();
                if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
                    return Err(E::custom(format!(
                        "{text:?} is not a colour; write \"#rrggbb\", such as \"#c0a060\""
                    )));
                }
                let hex = u32::from_str_radix(digits, 16).map_err(E::custom)?;
                Ok(Color::from_hex(hex))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Color, A::Error> {
                let mut channels = [0.0; 3];
                for (i, channel) in channels.iter_mut().enumerate() {
                    *channel = sequence
                        .next_element()?
                        .ok_or_else(|| A::Error::invalid_length(i, &self))?;
                    if !(0.0..=1.0).contains(channel) {
                        return Err(A::Error::custom(format!(
                            "{channel} is not a colour channel; channels go from 0 to 1"
                        )));
                    }
                }
                if sequence.next_element::<f64>()?.is_some() {
                    return Err(A::Error::invalid_length(4, &self));
                }
                Ok(Color(channels))
            }
        }

        deserializer.deserialize_any(ColorVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize)]
    struct Holder {
        c: Color,
    }

    fn parse(value: &str) -> Result<Color, String> {
        toml::from_str::<Holder>(&format!("c = {value}"))
            .map(|holder| holder.c)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn both_notations() {
        assert_eq!(parse("\"#ff8000\""), Ok(Color::from_hex(0xff8000)));
        assert_eq!(parse("[1.0, 0.5, 0]"), Ok(Color([1.0, 0.5, 0.0])));
        assert_eq!(Color([1.0, 0.0, 1.0]).linear(), [1.0, 0.0, 1.0]);
    }

    #[test]
    fn mistakes_are_told() {
        for bad in [
            "\"red\"",
            "\"#12345\"",
            "\"#12345g\"",
            "[1, 2, 3]",
            "[nan, 0, 0]",
            "[0, 0]",
            "[0,0,0,0]",
            "7",
            "\"#äöü\"",
        ] {
            let message = parse(bad).unwrap_err();
            assert!(message.contains("line 1"), "{bad}: {message}");
        }
    }
}
