//! Cells of a pattern: its connected pieces, and for each texel the nearest one.

use crate::shape_map::{ShapeMap, neighbours};
use relievo_shared::shading::cells::NUMBER_BITS;
use std::collections::VecDeque;

/// No cell yet.
const NONE: u32 = u32::MAX;

/// A texel of a cell: its number, and how many repeats before the texel its own one lies.
#[derive(Clone, Copy)]
struct Member {
    cell: u32,
    before: [i32; 2],
}

/// The cells of a pattern.
pub(super) struct Cells {
    /// One word a texel, as [`relievo_shared::shading::cells`] reads them.
    pub(super) words: Vec<u32>,
    /// How many there are, ≥ 1.
    pub(super) count: u32,
}

/// Returns the cells of `map`. A pattern without solid texels is one cell.
pub(super) fn cells(map: &ShapeMap) -> Cells {
    let size = [map.width() as usize, map.height() as usize];
    let distances: Vec<f32> = (0..map.height())
        .flat_map(|y| (0..map.width()).map(move |x| (x, y)))
        .map(|(x, y)| map.decode(x, y))
        .collect();
    let mut members = vec![
        Member {
            cell: NONE,
            before: [0; 2],
        };
        distances.len()
    ];
    let mut count = 0;
    let mut queue = VecDeque::new();
    for start in 0..distances.len() {
        if distances[start] > 0.0 || members[start].cell != NONE {
            continue;
        }
        members[start].cell = count;
        count += 1;
        queue.push_back(start);
        while let Some(index) = queue.pop_front() {
            let member = members[index];
            for (next, crossed) in neighbours(index, size) {
                if distances[next] <= 0.0 && members[next].cell == NONE {
                    members[next] = moved(member, crossed);
                    queue.push_back(next);
                }
            }
        }
    }
    // What is not solid belongs to the cell that the distances lead to.
    let mut outside: Vec<usize> = (0..distances.len())
        .filter(|index| members[*index].cell == NONE)
        .collect();
    outside.sort_by(|a, b| distances[*a].total_cmp(&distances[*b]));
    for index in outside {
        let nearest = neighbours(index, size)
            .into_iter()
            .filter(|(next, _)| members[*next].cell != NONE)
            .min_by(|(a, _), (b, _)| distances[*a].total_cmp(&distances[*b]));
        members[index] = match nearest {
            Some((next, crossed)) => {
                // From there to here.
                moved(members[next], crossed.map(|repeat| -repeat))
            }
            None => Member {
                cell: 0,
                before: [0; 2],
            },
        };
    }
    Cells {
        words: members.into_iter().map(word).collect(),
        count: count.max(1),
    }
}

/// Returns `member` as seen from a texel `crossed` repeats further on.
fn moved(member: Member, crossed: [i32; 2]) -> Member {
    let before = [0, 1].map(|i| (member.before[i] + crossed[i]).clamp(-1, 1));
    Member { before, ..member }
}

fn word(Member { cell, before }: Member) -> u32 {
    let [u, v] = before.map(|repeat| (repeat + 1) as u32);
    cell & ((1 << NUMBER_BITS) - 1) | u << NUMBER_BITS | v << (NUMBER_BITS + 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape_map::{Pattern, Storage, bake};

    fn of(rows: &[&str]) -> Vec<(u32, [i32; 2])> {
        let width = rows[0].len() as u32;
        let solid: Vec<bool> = rows
            .iter()
            .flat_map(|row| row.bytes().map(|byte| byte == b'#'))
            .collect();
        let pattern = Pattern::from_pixels(width, rows.len() as u32, solid).unwrap();
        let map = bake(&pattern, Storage::R32F, &|_| ());
        let part = |word: u32, shift: u32| ((word >> (NUMBER_BITS + shift)) & 3) as i32 - 1;
        cells(&map)
            .words
            .into_iter()
            .map(|word| {
                (
                    word & ((1 << NUMBER_BITS) - 1),
                    [part(word, 0), part(word, 2)],
                )
            })
            .collect()
    }

    #[test]
    fn pieces_are_numbered_across_the_edges_of_a_repeat() {
        let found = of(&["#..##..#", "........", "........", "........"]);
        // The piece at the edge begins at the left and goes on in the repeat before.
        assert_eq!(found[0], (0, [0, 0]));
        assert_eq!(found[7], (0, [-1, 0]));
        assert_eq!(found[3], (1, [0, 0]));
        assert_eq!(found[4], (1, [0, 0]));
        // Texels between belong to the nearest piece.
        assert_eq!((found[1].0, found[2].0), (0, 1));
        assert_eq!(found[6], (0, [-1, 0]));
        assert_eq!(found[8], (0, [0, 0]));
        // The lowest row is next to the piece of the repeat below.
        assert_eq!(found[24], (0, [0, -1]));
    }

    #[test]
    fn a_pattern_without_pieces_or_with_one_is_one_cell() {
        assert!(of(&["....", "...."]).iter().all(|(cell, _)| *cell == 0));
        assert!(of(&["####", "####"]).iter().all(|(cell, _)| *cell == 0));
    }
}
