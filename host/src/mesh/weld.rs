//! Welds vertices at the same position. Exporters split vertices at UV seams,
//! where the surface must stay closed.

use std::collections::HashMap;

use glam::DVec3;

/// Welding distance, as a fraction of the mesh's diagonal.
const TOLERANCE: f64 = 1e-9;

/// Width of a cell of the search grid, in tolerances. Most neighbourhoods then
/// lie in one cell.
const CELL_TOLERANCES: f64 = 8.0;

/// End of a linked list.
const END: u32 = u32::MAX;

/// Welded positions, no two of which are within the tolerance.
#[derive(Debug)]
pub(super) struct Welded {
    /// The welded positions; each is the first of the positions that it replaces.
    pub positions: Vec<DVec3>,
    /// Welded index of each source position.
    pub indices: Vec<u32>,
}

/// Welds positions that are equal or at most 1e-9 · `diagonal` apart.
///
/// In input order, each position joins the first welded position within the
/// tolerance, or becomes a welded position itself. So the result is
/// deterministic, and chains of close positions do not merge over more than the
/// tolerance. The search uses a hash of grid cells and looks into *every* cell
/// that the tolerance reaches.
///
/// There must be fewer than 2³² − 1 positions, all finite. `diagonal` must be
/// positive and at least the largest distance between two positions, so that
/// cell numbers stay far below 2⁵³.
pub(super) fn weld(positions: &[DVec3], diagonal: f64) -> Welded {
    let origin = positions
        .iter()
        .copied()
        .reduce(DVec3::min)
        .unwrap_or_default();
    let tolerance = TOLERANCE * diagonal;
    let cell_of = |position: DVec3| {
        ((position - origin) / (CELL_TOLERANCES * tolerance))
            .floor()
            .to_array()
    };

    let mut welded = Welded {
        positions: Vec::new(),
        indices: Vec::with_capacity(positions.len()),
    };
    // Each cell has a linked list of welded positions: `heads` and `next`.
    let mut heads: HashMap<[i64; 3], u32> = HashMap::with_capacity(positions.len());
    let mut next: Vec<u32> = Vec::new();
    for &position in positions {
        let low = cell_of(position - tolerance).map(|cell| cell as i64);
        let high = cell_of(position + tolerance).map(|cell| cell as i64);
        let mut found: Option<u32> = None;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let mut candidate = heads.get(&[x, y, z]).copied().unwrap_or(END);
                    while candidate != END {
                        let close =
                            welded.positions[candidate as usize].distance(position) <= tolerance;
                        if close && found.is_none_or(|first| candidate < first) {
                            found = Some(candidate);
                        }
                        candidate = next[candidate as usize];
                    }
                }
            }
        }
        welded.indices.push(found.unwrap_or_else(|| {
            let index = welded.positions.len() as u32;
            welded.positions.push(position);
            let head = heads
                .entry(cell_of(position).map(|cell| cell as i64))
                .or_insert(END);
            next.push(std::mem::replace(head, index));
            index
        }));
    }
    welded
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn signed_zeros_and_close_positions_are_one() {
        let positions = [
            DVec3::ZERO,
            DVec3::new(-0.0, 0.0, -0.0),
            DVec3::splat(5e-10),
            DVec3::X,
            DVec3::new(1.0 + 2e-9, 0.0, 0.0),
        ];
        assert_eq!(weld(&positions, 1.0).indices, [0, 0, 0, 1, 2]);
    }

    #[test]
    fn chains_do_not_grow_together() {
        let positions: Vec<DVec3> = (0..10)
            .map(|step| DVec3::X * (0.6e-9 * f64::from(step)))
            .collect();
        assert_eq!(
            weld(&positions, 1.0).indices,
            [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]
        );
    }

    proptest! {
        /// Compares with the definition on all pairs, in a swarm dense enough
        /// for many cell borders and many entries per cell.
        #[test]
        fn agrees_with_an_exhaustive_search(swarm in prop::collection::vec(prop::array::uniform3(-2e-8..2e-8_f64), 1..60)) {
            let positions: Vec<DVec3> = swarm.into_iter().map(DVec3::from_array).collect();
            let mut expected: Vec<DVec3> = Vec::new();
            let mut indices = Vec::new();
            for position in &positions {
                let first = expected.iter().position(|other| other.distance(*position) <= TOLERANCE);
                indices.push(first.unwrap_or_else(|| {
                    expected.push(*position);
                    expected.len() - 1
                }) as u32);
            }
            let welded = weld(&positions, 1.0);
            prop_assert_eq!(welded.indices, indices);
            prop_assert_eq!(welded.positions, expected);
        }
    }
}
