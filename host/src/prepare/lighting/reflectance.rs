//! What microfacets reflect of even light.

use rayon::prelude::*;
use relievo_shared::shading::brdf::visibility;
use relievo_shared::shading::layout::REFLECTANCE_SIZE;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Directions of light on the hemisphere, each way.
const STEPS: u32 = 64;

/// Returns the table of what a surface that reflects F_0 of facing light reflects of even
/// light, for rows of growing roughness and columns of growing cosine: the factor of F_0 and the
/// rest (Karis, "Real shading in Unreal Engine 4", 2013), 16 bits each.
pub(super) fn reflectance() -> Vec<u32> {
    static TABLE: LazyLock<Vec<u32>> = LazyLock::new(|| {
        let last = f64::from(REFLECTANCE_SIZE - 1);
        (0..REFLECTANCE_SIZE * REFLECTANCE_SIZE)
            .into_par_iter()
            .map(|index| {
                let cosine = f64::from(index % REFLECTANCE_SIZE) / last;
                let roughness = f64::from(index / REFLECTANCE_SIZE) / last;
                let [factor, rest] = shares(cosine.max(1e-3), roughness.max(0.045))
                    .map(|share| (share.clamp(0.0, 1.0) * 65_535.0).round() as u32);
                factor | rest << 16
            })
            .collect()
    });
    TABLE.clone()
}

/// Integrates over half-way vectors, as their density has them.
fn shares(cosine: f64, roughness: f64) -> [f64; 2] {
    let square = roughness.powi(4);
    let sine = (1.0 - cosine * cosine).sqrt();
    let mut sums = [0.0; 2];
    for i in 0..STEPS {
        for j in 0..STEPS {
            let [x, y] = [i, j].map(|step| (f64::from(step) + 0.5) / f64::from(STEPS));
            // tan² θ = α² x / (1 − x).
            let half_z = ((1.0 - x) / (1.0 + (square - 1.0) * x)).sqrt();
            let half_x = (1.0 - half_z * half_z).max(0.0).sqrt() * (2.0 * PI * y).cos();
            let eye_half = sine * half_x + cosine * half_z;
            let light_z = 2.0 * eye_half * half_z - cosine;
            if light_z <= 0.0 || eye_half <= 0.0 {
                continue;
            }
            let shadowing = visibility(square as f32, light_z as f32, cosine as f32);
            let weight = 4.0 * f64::from(shadowing) * light_z * eye_half / half_z;
            let fresnel = (1.0 - eye_half).powi(5);
            sums[0] += weight * (1.0 - fresnel);
            sums[1] += weight * fresnel;
        }
    }
    sums.map(|sum| sum / f64::from(STEPS * STEPS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_shared::shading::brdf::distribution;

    /// Against the sum over directions of light, evenly spread.
    #[test]
    fn the_table_is_the_integral_over_the_hemisphere() {
        for (cosine, roughness) in [(0.2, 0.5), (0.7, 0.3), (0.9, 1.0), (0.05, 0.8)] {
            let square = f64::powi(roughness, 4);
            let sine = f64::sqrt(1.0 - cosine * cosine);
            let (mut sums, steps) = ([0.0; 2], 1000);
            for i in 0..steps {
                for j in 0..steps {
                    let z = (f64::from(i) + 0.5) / f64::from(steps);
                    let turn = PI * (f64::from(j) + 0.5) / f64::from(steps);
                    let x = f64::sqrt(1.0 - z * z) * turn.cos();
                    let y = f64::sqrt(1.0 - z * z) * turn.sin();
                    let half = glam::DVec3::new(x + sine, y, z + cosine).normalize();
                    let eye_half = half.x * sine + half.z * cosine;
                    let specular =
                        f64::from(distribution(square as f32, (1.0 - half.z * half.z) as f32))
                            * f64::from(visibility(square as f32, z as f32, cosine as f32));
                    let fresnel = (1.0 - eye_half).powi(5);
                    // 2 dz dφ over half a turn; the factor π is in the density.
                    let weight = 2.0 * specular * z / f64::from(steps * steps);
                    sums[0] += weight * (1.0 - fresnel);
                    sums[1] += weight * fresnel;
                }
            }
            let found = shares(cosine, roughness);
            for (found, sum) in found.into_iter().zip(sums) {
                assert!(
                    (found - sum).abs() < 0.005,
                    "{cosine} {roughness}: {found} {sum}"
                );
            }
        }
    }
}
