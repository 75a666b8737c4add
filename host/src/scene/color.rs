//! Colours of scenes.

use crate::srgb;

/// A colour in sRGB, channels 0…1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color(pub [f64; 3]);

impl Color {
    /// Creates a colour from 0xRRGGBB.
    pub const fn from_hex(hex: u32) -> Color {
        Color([
            (hex >> 16 & 255) as f64 / 255.0,
            (hex >> 8 & 255) as f64 / 255.0,
            (hex & 255) as f64 / 255.0,
        ])
    }

    /// Reads `#rrggbb`; `None` for any other text.
    pub fn parse(text: &str) -> Option<Color> {
        let digits = text.strip_prefix('#')?;
        let is_hex = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
        is_hex.then(|| u32::from_str_radix(digits, 16).ok().map(Color::from_hex))?
    }

    /// Returns `#rrggbb`; `None` where that would round a channel.
    pub fn hex(self) -> Option<String> {
        let [red, green, blue] = self.0.map(|channel| (channel * 255.0).round() as u32);
        let hex = red << 16 | green << 8 | blue;
        (Color::from_hex(hex) == self).then(|| format!("#{hex:06x}"))
    }

    /// Returns linear RGB, 0…1.
    pub fn linear(self) -> [f32; 3] {
        self.0.map(|channel| srgb::linear(channel) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexadecimal_colours() {
        assert_eq!(Color::parse("#ff8000"), Some(Color::from_hex(0xff8000)));
        assert_eq!(Color::from_hex(0xff8000).hex().unwrap(), "#ff8000");
        assert_eq!(Color([0.3, 0.0, 1.0]).hex(), None);
        assert_eq!(Color([f64::NAN; 3]).hex(), None);
        assert_eq!(Color([1.0, 0.0, 1.0]).linear(), [1.0, 0.0, 1.0]);
        for bad in ["red", "#12345", "#12345g", "#äöü", "", "#"] {
            assert_eq!(Color::parse(bad), None, "{bad}");
        }
    }
}
