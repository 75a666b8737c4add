//! Builds bounding volume hierarchies for renderers and oracles.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;

/// Builds a hierarchy over `boxes`, equal to that of
/// `obvhs::bvh2::builder::build_bvh2` with medium parameters, but without reading
/// the clock, which browsers do not have.
pub(crate) fn build(boxes: &[Aabb]) -> Bvh2 {
    let parameters = BvhBuildParams::medium_build();
    let mut hierarchy = PlocBuilder::with_capacity(boxes.len()).build(
        parameters.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        parameters.sort_precision,
        parameters.search_depth_threshold,
    );
    let ratio = parameters.reinsertion_batch_ratio;
    let after = ratio * parameters.post_collapse_reinsertion_batch_ratio_multiplier;
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut hierarchy, ratio, None);
    let leaf = parameters.max_prims_per_leaf.clamp(1, 255);
    collapse(&mut hierarchy, leaf, parameters.collapse_traversal_cost);
    optimizer.run(&mut hierarchy, after, None);
    hierarchy
}

/// Builds a hierarchy over `boxes` in less time, for few rays.
pub(crate) fn build_fast(boxes: &[Aabb]) -> Bvh2 {
    let parameters = BvhBuildParams::fast_build();
    PlocBuilder::with_capacity(boxes.len()).build(
        parameters.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        parameters.sort_precision,
        parameters.search_depth_threshold,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn it_is_what_the_library_builds() {
        let mut random = fastrand::Rng::with_seed(7);
        let boxes: Vec<Aabb> = (0..500)
            .map(|_| {
                let low = glam::Vec3A::from_array(std::array::from_fn(|_| random.f32()));
                Aabb::new(low, low + 0.1 * random.f32())
            })
            .collect();
        let parameters = BvhBuildParams::medium_build();
        let theirs = obvhs::bvh2::builder::build_bvh2(&boxes, parameters, &mut Duration::default());
        let ours = build(&boxes);
        assert_eq!(ours.primitive_indices, theirs.primitive_indices);
        assert_eq!(ours.nodes.len(), theirs.nodes.len());
        for (a, b) in ours.nodes.iter().zip(&theirs.nodes) {
            assert_eq!(a.aabb(), b.aabb());
            assert_eq!((a.prim_count, a.first_index), (b.prim_count, b.first_index));
        }
    }
}
