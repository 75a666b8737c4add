//! The local depths of the meshes of a scene: each is found once.

use super::memo::{Memo, Same};
use crate::mesh::{LocalDepth, Mesh, MeshPrism, Shell};
use relievo_shared::layout::{REDUCTION_STEPS, pack_depth_reductions};
use std::sync::Arc;

/// Smaller reductions are rounding errors.
const SMALLEST: f64 = 1e-6;

/// The local depth of a mesh.
pub(super) struct MeshShell {
    /// Largest local depth, object units.
    pub depth: f64,
    /// Reductions at the corners of each triangle, as in
    /// [`Triangle::depth_reductions`](relievo_shared::layout::Triangle::depth_reductions);
    /// empty if there are none.
    pub reductions: Vec<u32>,
    /// Whether the surface over each triangle is straight; empty if there are no reductions.
    pub straight: Vec<bool>,
    /// Where it is less than asked for.
    pub local_depth: Option<LocalDepth>,
}

/// Local depths by mesh and depth asked for.
pub(super) type Shells = Memo<(Same<Mesh>, f64), MeshShell>;

impl Shells {
    /// Returns the local depth of `mesh` for `depth`, object units.
    pub fn of(&mut self, mesh: &Arc<Mesh>, depth: f64) -> Arc<MeshShell> {
        let key = (Same(mesh.clone()), depth);
        self.get(&key).unwrap_or_else(|| {
            let shell = MeshShell::new(&mesh.shell(depth));
            self.insert(key, shell)
        })
    }
}

impl MeshShell {
    /// Keeps what all tiers read of a shell.
    pub fn new(shell: &Shell) -> MeshShell {
        // Rounded up, since less depth is safe, but some depth is left.
        let steps = |share: f64| {
            let reduction = 1.0 - share;
            if reduction < SMALLEST {
                0
            } else {
                ((reduction * f64::from(REDUCTION_STEPS)).ceil() as u32).min(REDUCTION_STEPS - 1)
            }
        };
        let is_reduced = shell.prisms.iter().any(|prism| prism.shares != [1.0; 3]);
        let reduced = || shell.prisms.iter().filter(|_| is_reduced);
        MeshShell {
            depth: shell.depth,
            reductions: reduced()
                .map(|prism| pack_depth_reductions(prism.shares.map(steps)))
                .collect(),
            straight: reduced().map(MeshPrism::is_straight).collect(),
            local_depth: shell.local_depth,
        }
    }
}
