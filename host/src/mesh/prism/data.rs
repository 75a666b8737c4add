//! Prisms and shells as data.

use std::fmt;

use glam::DVec3;

/// The curved prism over one triangle: the points S(w) − d N(w) at the depths d
/// ≥ 0 in object units, with S and N of degree two in the barycentric weights w1
/// and w2 of the second and the third corner (section 6 of docs/algorithm.md).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct MeshPrism {
    /// Position of the first corner, in object units. `surface` is relative to it.
    pub anchor: DVec3,
    /// S without its constant, which is 0: the coefficients of w1, w2, w1²,
    /// w1 w2, w2², in object units.
    pub surface: [DVec3; 5],
    /// N: the coefficients of 1, w1, w2, w1², w1 w2, w2². Of length 1 at corners
    /// and edge midpoints of a smooth surface; at hard edges longer, so that the
    /// floor is about parallel to the faces around. Where the local depth is less
    /// than the object's, it is shorter in proportion.
    pub normal: [DVec3; 6],
    /// The local depth at each corner as a share of the shell's, at most 1.
    pub shares: [f64; 3],
    /// Unit normals of the corners: those of the mesh.
    pub corner_normals: [DVec3; 3],
    /// For each corner, the neighbour at the opposite side: 4 × its index + the
    /// index of its corner opposite to the same side; or [`NO_NEIGHBOUR`](relievo_shared::layout::NO_NEIGHBOUR).
    pub neighbours: [u32; 3],
}

/// The curved prisms of a mesh for a depth S_z, with a *local depth* h ≤ S_z at
/// every position (section 6 of docs/algorithm.md).
///
/// h is at most half the way to the opposite wall, so that opposite floors do not
/// meet, 45 % of the radius of curvature, and 90 % of the depth at which a prism folds, 46 %
/// where it is curved. Along an edge it changes by at most 15 % of the edge's length, and to at
/// most four times as much. It is S_z where nothing limits it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Shell {
    /// The largest local depth, in object units: the depth asked for, or less where it
    /// is reduced everywhere. The prisms are that deep.
    pub depth: f64,
    /// The prisms, one for each triangle. None folds at depths up to `depth`.
    pub prisms: Vec<MeshPrism>,
    /// Where the local depth is less than S_z; `None` if it is so nowhere.
    pub local_depth: Option<LocalDepth>,
}

/// How far the local depth of a [`Shell`] is less than the object's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct LocalDepth {
    /// Share of the area of triangles with a reduced depth at a corner, 0 to 1.
    pub share: f64,
    /// The least local depth, in object units.
    pub least: f64,
    /// The median of the local depth over the reduced area, in object units.
    pub median: f64,
}

impl fmt::Display for LocalDepth {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "reduced over {:.2} % of the surface, to {:.6} in half of it and to {:.6} at least",
            100.0 * self.share,
            self.median,
            self.least,
        )
    }
}
