//! The corners of triangles by position.

/// The corners at each position: 3 × the triangle's index + the corner's, ascending.
pub(super) struct CornersAt {
    /// Where those of a position start.
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl CornersAt {
    /// Sorts corners by position; `positions` are the indices of the corners' positions, in
    /// the order of the corners, and below `count`.
    pub fn new(count: usize, positions: impl Iterator<Item = u32> + Clone) -> CornersAt {
        let mut starts = vec![0; count + 1];
        for position in positions.clone() {
            starts[position as usize + 1] += 1;
        }
        for position in 0..count {
            starts[position + 1] += starts[position];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; starts[count] as usize];
        for (corner, position) in positions.enumerate() {
            let slot = &mut next[position as usize];
            corners[*slot as usize] = corner as u32;
            *slot += 1;
        }
        CornersAt { starts, corners }
    }

    /// Returns the corners at a position.
    pub fn of(&self, position: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|i| self.starts[position as usize + i] as usize);
        &self.corners[start..end]
    }

    /// Returns the number of positions.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the corners at every position.
    pub fn all(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.count() as u32).map(|position| self.of(position))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_sorted_by_position() {
        let at = CornersAt::new(5, [1, 0, 3, 3, 1, 0].into_iter());
        let all: Vec<&[u32]> = at.all().collect();
        assert_eq!(all, [&[1, 5][..], &[0, 4], &[], &[2, 3], &[]]);
        assert_eq!(CornersAt::new(0, [].into_iter()).all().count(), 0);
    }
}
