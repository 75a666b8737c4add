//! Decides whether the rays of an object ask the mesh where they leave it.

use rayon::prelude::*;
use relievo_shared::layout::{Corner, Object, SEARCH_EXTRUSION, TIER_FAST, Triangle};

/// Half the curvature times the depth from which on a quadric says too little about the
/// way of a ray: the depth is half of the radius of curvature.
const TOO_CURVED: f32 = 0.25;

/// Returns the number with which object `number` of a scene asks for its exits, 1 to
/// 255. Returns 0 if it does not ask: in other tiers, and where the depth is reduced nowhere
/// and less than half of the radius of curvature everywhere.
pub(super) fn exit_number(parameters: &Object, triangles: &[Triangle], number: usize) -> u32 {
    let is_too_curved = |corner: &Corner| warp(corner, parameters.depth) > TOO_CURVED;
    let asks = is_fast(parameters)
        && triangles.par_iter().any(|triangle| {
            triangle.depth_reductions != 0 || triangle.corners.iter().any(is_too_curved)
        });
    if asks { number_of_exits(number) } else { 0 }
}

/// Returns the number, 1 to 255, by which object `number` knows its exits.
pub(super) fn number_of_exits(number: usize) -> u32 {
    (number % 255 + 1) as u32
}

/// Returns whether the fast tier draws the object, with a profile and not as relief.
pub(super) fn is_fast(parameters: &Object) -> bool {
    parameters.search == SEARCH_EXTRUSION && parameters.tier == TIER_FAST
}

/// Half the largest normal curvature at a corner times the depth; negative where the
/// surface is hollow in every direction.
fn warp(corner: &Corner, depth: f32) -> f32 {
    let [xx, xy, yy] = corner.quadric;
    let half_curvature = 0.5 * (xx + yy) + 0.5 * (xx - yy).hypot(xy);
    half_curvature * depth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduced_depth_and_one_near_the_radius_of_curvature_ask() {
        let sphere = |radius: f32, depth_reductions: u32| {
            let corner = Corner {
                quadric: [0.5 / radius, 0.0, 0.5 / radius],
                ..Corner::default()
            };
            [Triangle {
                corners: [corner; 3],
                handedness: 1.0,
                depth_reductions,
            }]
        };
        let object = |depth: f32, tier: u32| Object {
            depth,
            tier,
            search: SEARCH_EXTRUSION,
            ..Object::default()
        };
        let fast = |depth: f32| object(depth, TIER_FAST);
        assert_eq!(exit_number(&fast(0.4), &sphere(1.0, 0), 0), 0);
        assert_eq!(exit_number(&fast(0.6), &sphere(1.0, 0), 0), 1);
        assert_eq!(exit_number(&fast(0.6), &sphere(-1.0, 0), 0), 0);
        assert_eq!(exit_number(&fast(0.1), &sphere(1.0, 1 << 20), 0), 1);
        assert_eq!(exit_number(&fast(0.6), &sphere(1.0, 0), 255), 1);
        assert_eq!(exit_number(&fast(0.6), &sphere(1.0, 0), 254), 255);
        assert_eq!(exit_number(&object(0.6, 0), &sphere(1.0, 0), 0), 0);
        // A cylinder at 45 degrees: xx = yy = xy / 2.
        let mut cylinder = sphere(1.0, 0);
        for corner in &mut cylinder[0].corners {
            corner.quadric = [0.25, 0.5, 0.25];
        }
        assert_eq!(exit_number(&fast(0.4), &cylinder, 0), 0);
        assert_eq!(exit_number(&fast(0.6), &cylinder, 0), 1);
    }
}
