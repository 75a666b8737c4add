//! Bold capital letters drawn with a round pen.

use glam::DVec2;

use crate::sdf;

/// A path of the pen's centre, in pixels from the top left corner of the letter's
/// skeleton, y down.
enum Stroke {
    /// From one point to another.
    Line(DVec2, DVec2),
    /// The right half of a circle: centre and radius.
    RightHalfCircle(DVec2, f64),
    /// The outline of an upright stadium from the origin to this corner.
    Stadium(DVec2),
}

/// The letters of the patterns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Letter {
    E,
    I,
    L,
    O,
    R,
    V,
}

/// A letter: the strokes of its skeleton.
pub struct Glyph(Vec<Stroke>);

impl Glyph {
    /// Creates a letter whose skeleton is `size` pixels wide and high.
    pub fn new(letter: Letter, size: DVec2) -> Self {
        let DVec2 { x: w, y: h } = size;
        let line = |x0, y0, x1, y1| Stroke::Line(DVec2::new(x0, y0), DVec2::new(x1, y1));
        let stem = line(0.0, 0.0, 0.0, h);
        let strokes = match letter {
            Letter::E => vec![
                stem,
                line(0.0, 0.0, w, 0.0),
                line(0.0, h / 2.0, 0.9 * w, h / 2.0),
                line(0.0, h, w, h),
            ],
            Letter::I => vec![stem],
            Letter::L => vec![stem, line(0.0, h, w, h)],
            Letter::O => vec![Stroke::Stadium(size)],
            Letter::R => {
                let bowl = 0.27 * h;
                let turn = w - bowl;
                vec![
                    stem,
                    line(0.0, 0.0, turn, 0.0),
                    Stroke::RightHalfCircle(DVec2::new(turn, bowl), bowl),
                    line(0.0, 2.0 * bowl, turn, 2.0 * bowl),
                    line(0.5 * w, 2.0 * bowl, w, h),
                ]
            }
            Letter::V => vec![line(0.0, 0.0, w / 2.0, h), line(w / 2.0, h, w, 0.0)],
        };
        Self(strokes)
    }

    /// Returns the distance in pixels from `point` to the skeleton.
    pub fn distance(&self, point: DVec2) -> f64 {
        self.0
            .iter()
            .map(|stroke| match *stroke {
                Stroke::Line(a, b) => sdf::segment(point, a, b),
                Stroke::RightHalfCircle(centre, radius) => {
                    sdf::right_half_circle(point, centre, radius)
                }
                Stroke::Stadium(size) => {
                    let half = size / 2.0;
                    sdf::rounded_rectangle(point - half, half, half.min_element()).abs()
                }
            })
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_fill_their_box_and_nothing_more() {
        let size = DVec2::new(60.0, 100.0);
        for letter in [
            Letter::E,
            Letter::I,
            Letter::L,
            Letter::O,
            Letter::R,
            Letter::V,
        ] {
            let glyph = Glyph::new(letter, size);
            let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for y in -20..=120 {
                for x in -20..=80 {
                    let point = DVec2::new(f64::from(x), f64::from(y));
                    if glyph.distance(point) < 0.5 {
                        low = low.min(point);
                        high = high.max(point);
                    }
                }
            }
            let width = if letter == Letter::I { 0.0 } else { size.x };
            assert!(low.abs_diff_eq(DVec2::ZERO, 1.0), "{letter:?}: {low}");
            assert!(
                high.abs_diff_eq(DVec2::new(width, size.y), 1.0),
                "{letter:?}: {high}"
            );
        }
    }
}
