//! The surface class of a hit and the normal that lights it (section 9).

use crate::arithmetic::{div, kept3, normalize_or};
use crate::layout::Object;
use crate::march::{END_CAP, END_FLOOR, END_MISS, March};
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
use crate::surface::Surface;
use crate::{Real, Vec2, Vec3};

/// Nothing was hit.
pub const CLASS_MISS: u32 = 0;
/// The mesh surface, on the pattern.
pub const CLASS_CAP: u32 = 1;
/// The upright side of the extrusion.
pub const CLASS_WALL: u32 = 2;
/// The sloped side of a bevel or a chamfer.
pub const CLASS_BEVEL: u32 = 3;
/// The floor between the columns.
pub const CLASS_FLOOR: u32 = 4;
/// Nothing was hit, and the environment is seen; in pictures of colours only.
pub const CLASS_SKY: u32 = 5;

/// Returns the class of the point where the march ended. `distance` computes its
/// distance to the pattern, texels.
#[inline]
pub fn class_of(march: &March, object: &Object, distance: impl FnOnce() -> Real) -> u32 {
    if march.end == END_MISS {
        CLASS_MISS
    } else if march.end == END_CAP {
        CLASS_CAP
    } else if march.end == END_FLOOR {
        if object.cut_out != 0 {
            CLASS_MISS
        } else {
            CLASS_FLOOR
        }
    } else if Profile::new(object).is_growing(march.depth_fraction, distance) {
        CLASS_BEVEL
    } else {
        CLASS_WALL
    }
}

/// The smooth surface at a hit, with the gradients of u, v and δ in space.
pub trait HitSurface: Copy {
    /// Unit normal of the smooth surface, pointing out.
    fn normal(&self) -> Vec3;

    /// The normal of a side, of any length: the gradient of g = D − r(δ), where
    /// `slope` is the gradient of D by u and v, texels per repeat, and `growth`
    /// is dr/dδ, texels; r does not change with δ unless `is_sloped`.
    fn side(&self, slope: Vec2, is_sloped: bool, growth: Real) -> Vec3;

    /// ∇u and ∇v, repeats per object unit.
    fn gradients(&self) -> (Vec3, Vec3);
}

/// The smooth surface at a hit of a model over triangles.
#[derive(Clone, Copy, Debug)]
pub struct SmoothSurface {
    /// The surface where the ray entered the shell.
    pub surface: Surface,
    /// Unit normal at the hit.
    pub normal: Vec3,
    /// The local depth h, object units.
    pub depth: Real,
}

impl HitSurface for SmoothSurface {
    #[inline]
    fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Normals are covectors: ∇u and ∇v carry the map's gradient, and
    /// ∇δ = −N / S_z tilts a bevel.
    #[inline]
    fn side(&self, slope: Vec2, is_sloped: bool, growth: Real) -> Vec3 {
        let raw = self.surface.gradient_u * slope.x + self.surface.gradient_v * slope.y;
        // Upright with respect to the surface at the hit.
        let upright = raw - self.normal * self.normal.dot(raw);
        let tilt = if is_sloped {
            div(growth, self.depth)
        } else {
            0.0
        };
        upright + self.normal * tilt
    }

    #[inline]
    fn gradients(&self) -> (Vec3, Vec3) {
        (self.surface.gradient_u, self.surface.gradient_v)
    }
}

/// Returns the unit normal of the carved surface at a hit of `class` at `uv` and
/// `depth_fraction`, where `surface` is the smooth surface.
#[inline]
pub fn normal_at<S: HitSurface, T: Texels + ?Sized>(
    class: u32,
    object: &Object,
    map: &ShapeMap,
    texels: &T,
    surface: &S,
    uv: Vec2,
    depth_fraction: Real,
) -> Vec3 {
    let smooth = surface.normal();
    if class != CLASS_WALL && class != CLASS_BEVEL {
        return smooth;
    }
    let slope = map.gradient(texels, uv) * map.size;
    let profile = Profile::new(object);
    let is_sloped = class == CLASS_BEVEL && profile.grows;
    let side = surface.side(slope, is_sloped, profile.slope(depth_fraction));
    normalize_or(kept3(side), smooth)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::march::END_SIDE;
    use crate::path::test_surface;
    use crate::shape_map::tests::{FORMS, Random, Sample};

    #[test]
    fn the_class_follows_the_end_of_the_march() {
        let class = |end, depth_fraction, bevel, chamfer, cut_out| {
            let march = March {
                end,
                s: 1.0,
                uv: Vec2::ZERO,
                depth_fraction,
                steps: 3,
            };
            let object = Object {
                bevel,
                chamfer,
                cut_out,
                ..Object::default()
            };
            class_of(&march, &object, || 0.0)
        };
        for cut_out in [0, 1] {
            assert_eq!(class(END_MISS, 0.0, 0.1, 1.0, cut_out), CLASS_MISS);
            assert_eq!(class(END_CAP, 0.0, 0.1, 1.0, cut_out), CLASS_CAP);
            // A side without a bevel, with one, and above and below a chamfer.
            assert_eq!(class(END_SIDE, 0.5, 0.0, 1.0, cut_out), CLASS_WALL);
            assert_eq!(class(END_SIDE, 0.5, 0.1, 1.0, cut_out), CLASS_BEVEL);
            assert_eq!(class(END_SIDE, 0.29, 0.1, 0.3, cut_out), CLASS_BEVEL);
            assert_eq!(class(END_SIDE, 0.3, 0.1, 0.3, cut_out), CLASS_WALL);
            assert_eq!(class(END_SIDE, 0.9, 0.1, 0.3, cut_out), CLASS_WALL);
        }
        assert_eq!(class(END_FLOOR, 1.0, 0.1, 1.0, 0), CLASS_FLOOR);
        assert_eq!(class(END_FLOOR, 1.0, 0.1, 1.0, 1), CLASS_MISS);
    }

    /// A map of 64 × 32 texels whose pattern is its left or its upper half, on
    /// a surface where a repeat is 2 by 0.5 object units.
    fn half(left: bool) -> (Sample, Surface) {
        let pattern: Vec<bool> = (0..64 * 32)
            .map(|i| if left { i % 64 < 32 } else { i / 64 < 16 })
            .collect();
        let surface = Surface {
            gradient_u: Vec3::X * 0.5,
            gradient_v: Vec3::Y * -2.0,
            ..test_surface([0.0; 3], 0.0)
        };
        (Sample::of_pattern(64, &pattern, FORMS[0]), surface)
    }

    fn normal(class: u32, sample: &Sample, surface: &Surface, at: Vec3, uv: [f32; 2]) -> Vec3 {
        let map = sample.map();
        let uv = Vec2::new(uv[0], uv[1]);
        let surface = SmoothSurface {
            surface: *surface,
            normal: at,
            depth: sample.object.depth,
        };
        normal_at(
            class,
            &sample.object,
            &map,
            &sample.words[..],
            &surface,
            uv,
            0.0,
        )
    }

    #[test]
    fn a_wall_faces_away_from_the_pattern() {
        let (sample, surface) = half(true);
        let wall = |uv| normal(CLASS_WALL, &sample, &surface, Vec3::Z, uv);
        assert!((wall([0.5, 0.3]) - Vec3::X).length() < 1e-3);
        assert!((wall([0.0, 0.7]) + Vec3::X).length() < 1e-3);
        // v grows against y.
        let (sample, surface) = half(false);
        let wall = |uv| normal(CLASS_WALL, &sample, &surface, Vec3::Z, uv);
        assert!((wall([0.3, 0.5]) + Vec3::Y).length() < 1e-3);
        assert!((wall([0.3, 0.0]) - Vec3::Y).length() < 1e-3);
    }

    /// Over a straight edge across u the bevel is a plane: one width W·∇u⁻¹ of
    /// run per b⁻¹ S_z of descent, so its normal is (|∇u|, b / S_z) in the plane
    /// of T and N (section 9); across v distances are counted in widths, too,
    /// so |∇v| H / W takes the place of |∇u|.
    #[test]
    fn a_bevel_is_tilted_by_its_slope() {
        for (bevel, depth) in [(0.01, 0.2), (0.1, 0.2), (0.3, 0.05), (2.0, 0.1)] {
            for left in [true, false] {
                let (mut sample, surface) = half(left);
                sample.object.bevel = bevel;
                sample.object.depth = depth;
                let (uv, expected) = if left {
                    ([0.5, 0.3], Vec3::new(0.5, 0.0, bevel / depth))
                } else {
                    ([0.3, 0.5], Vec3::new(0.0, -2.0 * 0.5, bevel / depth))
                };
                let found = normal(CLASS_BEVEL, &sample, &surface, Vec3::Z, uv);
                let expected = expected.normalize();
                assert!((found - expected).length() < 1e-3, "{found} {expected}");
            }
        }
    }

    /// The part along the normal is subtracted: products of two small numbers remain.
    #[test]
    fn tiny_components_of_normals_are_zero() {
        let (sample, mut surface) = half(true);
        surface.gradient_u = Vec3::new(0.0, 4.0, 9e-19);
        let at = Vec3::new(9e-19, 0.0, 1.0);
        let found = normal(CLASS_WALL, &sample, &surface, at, [0.5, 0.3]);
        assert_eq!(found.x, 0.0);
        assert!((found.y - 1.0).abs() < 1e-6);
    }

    #[test]
    fn cap_and_floor_have_the_surface_normal() {
        let (sample, surface) = half(true);
        let at = Vec3::new(0.6, 0.0, 0.8);
        for class in [CLASS_CAP, CLASS_FLOOR] {
            assert_eq!(normal(class, &sample, &surface, at, [0.5, 0.3]), at);
        }
    }

    #[test]
    fn sides_stand_upright_on_the_surface_at_the_hit_and_have_length_one() {
        let mut random = Random(1);
        let mut flat = 0;
        for _ in 0..300 {
            let mut sample = Sample::random(&mut random);
            sample.object.bevel = random.magnitude(1e-3, 1.0) as f32;
            let (_, surface) = half(true);
            for _ in 0..20 {
                let mut number = || random.within(-0.4, 0.4) as f32;
                let at = Vec3::new(number(), number(), 1.0).normalize();
                let uv = [number(), number()];
                let wall = normal(CLASS_WALL, &sample, &surface, at, uv);
                let bevel = normal(CLASS_BEVEL, &sample, &surface, at, uv);
                assert!((wall.length() - 1.0).abs() < 1e-5);
                assert!((bevel.length() - 1.0).abs() < 1e-5);
                // Where the gradient vanishes, on a ridge, the surface's normal replaces it.
                if wall == at {
                    flat += 1;
                } else {
                    assert!(wall.dot(at).abs() < 1e-3, "{wall} {at}");
                }
                assert!(bevel.dot(at) > 0.0);
            }
        }
        assert!(flat < 3_000, "{flat} of 6000 without a gradient");
    }
}
