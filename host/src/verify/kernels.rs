//! Lists the functions of the shared mathematics that are compared one by one, and
//! records their arguments in scenes.
//!
//! ```
//! use relievo::verify::kernels::KERNELS;
//! use relievo_bitwise::evaluate;
//!
//! let root = KERNELS.iter().find(|kernel| kernel.name == "root").unwrap();
//! let mut words = [0];
//! evaluate(root, &[4_f32.to_bits()], &mut words);
//! assert_eq!(words, [2_f32.to_bits()]);
//! ```

use crate::prepare::PreparedScene;
use crate::render::{CpuRenderer, RenderError, Renderer};
use glam::Vec3;
use relievo_bitwise::Recorded;
use relievo_kernel::{Kernel, table};
use relievo_shared::camera::pixel_ray;
use relievo_shared::kernels::*;
use relievo_shared::normals::CLASS_MISS;
use relievo_shared::{arithmetic, for_each_kernel, kernels};

/// Every kernel, with its CPU function.
pub const KERNELS: &[Kernel] = for_each_kernel!(table);

/// Width and height of the picture that values are recorded from, pixels.
const SIZE: [u32; 2] = [160, 120];

/// Records the values of a small picture of `scene`: rays, hits, corners of
/// triangles, parameters.
///
/// # Errors
/// [`RenderError`] if the picture does not fit into memory.
pub fn record(scene: &PreparedScene, recorded: &mut Recorded) -> Result<(), RenderError> {
    let mut frame = scene.frame;
    // The same view on a coarser grid.
    for axis in 0..3 {
        frame.ray_right[axis] *= frame.size[0] / SIZE[0] as f32;
        frame.ray_down[axis] *= frame.size[1] / SIZE[1] as f32;
    }
    frame.size = SIZE.map(|side| side as f32);
    let mut put = |domain: relievo_kernel::Domain, values: &[f32]| {
        let words = values.iter().map(|value| value.to_bits());
        recorded
            .entry(domain.name.to_string())
            .or_default()
            .extend(words.clone());
        recorded
            .entry(NUMBER.name.to_string())
            .or_default()
            .extend(words);
    };

    let geometry = CpuRenderer::new(scene).geometry(&frame)?;
    let eye = Vec3::from(frame.eye);
    put(POSITION, &frame.eye);
    for (index, (place, surface)) in geometry.place.iter().zip(&geometry.surface).enumerate() {
        if geometry.class(index) == CLASS_MISS {
            continue;
        }
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let direction = pixel_ray(&frame, x, y);
        let [t, u, v, depth_fraction] = place.map(f32::from_bits);
        put(DIRECTION, &direction.to_array());
        put(
            DIRECTION,
            &[1, 2, 3].map(|word| f32::from_bits(surface[word])),
        );
        put(DISTANCE, &[t]);
        put(POSITION, &(eye + direction * t).to_array());
        put(UV, &[u, v]);
        put(FRACTION, &[depth_fraction]);
    }
    for object in &scene.objects {
        let parameters = &object.parameters;
        put(DEPTH, &[parameters.depth]);
        put(WIDTH, &[parameters.extension, parameters.bevel]);
        put(FRACTION, &[parameters.chamfer, parameters.specular]);
        put(FRACTION, &parameters.wall_color);
        // A few thousand corners are enough.
        let step = object.triangles.len().div_ceil(2000);
        for triangle in object.triangles.iter().step_by(step.max(1)) {
            for corner in &triangle.corners {
                put(POSITION, &corner.position);
                put(DIRECTION, &corner.normal);
                put(DIRECTION, &corner.tangent);
                put(UV, &corner.uv);
                put(CURVATURE, &corner.quadric);
                put(GRADIENT, &corner.gradient_u);
                put(GRADIENT, &corner.gradient_v);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn kernels_have_unique_names() {
        let names: BTreeSet<&str> = KERNELS.iter().map(|kernel| kernel.name).collect();
        assert_eq!(names.len(), KERNELS.len());
        assert!(names.len() > 15);
    }
}
