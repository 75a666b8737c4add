//! The connected pieces of a pattern, dealt to parts at random: bricks that differ in height, bevel or
//! material are layers of such parts.

use super::Pattern;
use relievo_shared::shading::cells::hash;

/// No piece yet.
const NONE: u32 = u32::MAX;

impl Pattern {
    /// Returns the pattern with one part of its connected pieces: part `number` (1, 2, …) of `parts`, to which
    /// pieces are dealt at random. Parts have the same number of pieces, or one more. Pixels are connected by
    /// sides and corners, also across the borders, since the pattern repeats.
    ///
    /// # Panics
    /// Unless 1 ≤ `number` ≤ `parts`.
    ///
    /// # Examples
    /// ```
    /// use relievo::shape_map::Pattern;
    ///
    /// let bars = Pattern::from_fn(8, 2, |x, _| x % 4 == 1)?;
    /// let [first, second] = [1, 2].map(|number| bars.pieces([number, 2]));
    /// assert!(first.is_solid(1, 0) != first.is_solid(5, 0));
    /// assert!(first.is_solid(1, 0) != second.is_solid(1, 0));
    /// # Ok::<(), relievo::shape_map::ShapeMapError>(())
    /// ```
    #[must_use]
    pub fn pieces(&self, [number, parts]: [u32; 2]) -> Pattern {
        assert!((1..=parts).contains(&number), "part {number} of {parts}");
        let (labels, count) = labels(self);
        let mut dealt: Vec<u32> = (0..count).collect();
        dealt.sort_by_key(|piece| (hash(*piece), *piece));
        let mut is_kept = vec![false; count as usize];
        for piece in dealt
            .iter()
            .skip(number as usize - 1)
            .step_by(parts as usize)
        {
            is_kept[*piece as usize] = true;
        }
        let kept = labels
            .iter()
            .map(|piece| *piece != NONE && is_kept[*piece as usize]);
        self.with_solid(kept.collect())
    }
}

/// Returns the number of the piece of each pixel, or [`NONE`], and how many there are.
fn labels(pattern: &Pattern) -> (Vec<u32>, u32) {
    let size = [pattern.width() as usize, pattern.height() as usize];
    let solid = pattern.solid();
    let mut labels = vec![NONE; solid.len()];
    let (mut count, mut stack) = (0, Vec::new());
    for start in 0..solid.len() {
        if !solid[start] || labels[start] != NONE {
            continue;
        }
        labels[start] = count;
        stack.push(start);
        while let Some(index) = stack.pop() {
            for (next, _) in neighbours(index, size) {
                if solid[next] && labels[next] == NONE {
                    labels[next] = count;
                    stack.push(next);
                }
            }
        }
        count += 1;
    }
    (labels, count)
}

/// Returns the eight texels around `index` in a picture of `width` × `height` texels that repeats, and how
/// many repeats lie between.
pub(crate) fn neighbours(index: usize, [width, height]: [usize; 2]) -> [(usize, [i32; 2]); 8] {
    let [x, y] = [index % width, index / width];
    let step = |at: usize, by: i32, size: usize| {
        let to = at as i32 + by;
        let wrapped = to.rem_euclid(size as i32);
        (wrapped as usize, to.div_euclid(size as i32))
    };
    [
        [1, 0],
        [-1, 0],
        [0, 1],
        [0, -1],
        [1, 1],
        [1, -1],
        [-1, 1],
        [-1, -1],
    ]
    .map(|[across, down]| {
        let (x, u) = step(x, across, width);
        let (y, v) = step(y, down, height);
        (y * width + x, [u, v])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Of any pattern, every pixel is in one part, and no piece is in two.
        #[test]
        fn parts_are_whole_pieces_and_together_the_pattern(
            width in 1u32..12, pixels in prop::collection::vec(any::<bool>(), 1..120), parts in 1u32..5,
        ) {
            let height = (pixels.len() as u32).div_ceil(width);
            let solid = (0..width * height).map(|i| *pixels.get(i as usize).unwrap_or(&false));
            let pattern = Pattern::from_pixels(width, height, solid.collect::<Vec<_>>()).unwrap();
            let made: Vec<Pattern> = (1..=parts).map(|number| pattern.pieces([number, parts])).collect();
            for (i, is_solid) in pattern.solid().iter().enumerate() {
                let among = made.iter().filter(|part| part.solid()[i]).count();
                prop_assert_eq!(among, usize::from(*is_solid));
                for part in made.iter().filter(|part| part.solid()[i]) {
                    for (next, _) in neighbours(i, [width as usize, height as usize]) {
                        prop_assert_eq!(part.solid()[next], pattern.solid()[next]);
                    }
                }
            }
            let counts: Vec<u32> = made.iter().map(|part| labels(part).1).collect();
            prop_assert_eq!(counts.iter().sum::<u32>(), labels(&pattern).1);
            let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
            prop_assert!(most - least <= 1, "{:?}", counts);
        }
    }

    #[test]
    fn pieces_go_on_across_the_borders() {
        // Two pixels at the corners are one piece, and a dot in the middle is another.
        let pattern =
            Pattern::from_fn(5, 5, |x, y| (x, y) == (2, 2) || (x % 4, y % 4) == (0, 0)).unwrap();
        assert_eq!(labels(&pattern).1, 2);
        assert_eq!(labels(&Pattern::from_fn(3, 1, |_, _| false).unwrap()).1, 0);
        assert_eq!(labels(&Pattern::from_fn(1, 1, |_, _| true).unwrap()).1, 1);
    }
}
