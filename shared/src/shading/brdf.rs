//! The metallic-roughness model of glTF 2.0: Lambert's diffuse part under a layer of GGX
//! microfacets with Smith's height-correlated shadowing and Schlick's Fresnel term
//! (appendix B of the specification), and the light that microfacets reflect more than once
//! (Turquin, "Practical multiple scattering compensation", 2019; for environments
//! Fdez-Agüera, "A multiple-scattering microfacet model", 2019).
//!
//! Reflected shares are multiplied by π: a white matte surface that faces a light of
//! colour 1 has colour 1.

use super::layout::REFLECTANCE_SIZE;
use crate::arithmetic::{clamp, div, kept3, max, sqrt};
use crate::shape_map::Texels;
use crate::{Real, Vec2, Vec3};

/// Least roughness: highlights of lights without a size stay finite.
pub const LEAST_ROUGHNESS: Real = 0.045;

/// Mean of Schlick's (1 − cosine)⁵ over a hemisphere of even light.
const MEAN_REST: Real = 1.0 / 21.0;

/// A surface, as light sees it.
#[derive(Clone, Copy, Debug)]
pub struct Reflector {
    /// Share that is reflected diffusely, of what the microfacets let through.
    pub diffuse: Vec3,
    /// F_0: share that is reflected by microfacets that face the light.
    pub facing: Vec3,
    /// Perceptual roughness.
    pub roughness: Real,
    /// Cosine between normal and the direction to the eye, > 0.
    pub eye_cosine: Real,
    /// What a white mirror of this roughness reflects of even light: E, as the factor of
    /// F_0 and the rest.
    pub reflectance: Vec2,
}

impl Reflector {
    /// Returns the surface of a material.
    #[inline]
    pub fn new(base_color: Vec3, metallic: Real, roughness: Real, eye_cosine: Real) -> Reflector {
        Reflector {
            diffuse: base_color * (1.0 - metallic),
            facing: Vec3::splat(0.04 * (1.0 - metallic)) + base_color * metallic,
            roughness: clamp(roughness, LEAST_ROUGHNESS, 1.0),
            eye_cosine: max(eye_cosine, 1e-3),
            reflectance: Vec2::new(1.0, 0.0),
        }
    }

    /// Reads the table of reflected shares, whose first word is `first`.
    #[inline]
    pub fn with_reflectance<T: Texels + ?Sized>(self, words: &T, first: u32) -> Reflector {
        Reflector {
            reflectance: reflectance(words, first, self.eye_cosine, self.roughness),
            ..self
        }
    }

    /// Returns the share of light from `to_light` that is reflected to the eye, along
    /// `to_eye`, times π and without the cosine of the light, which is `light_cosine` > 0.
    #[inline]
    pub fn reflected(
        &self,
        normal: Vec3,
        half_way: Vec3,
        half_cosine: Real,
        light_cosine: Real,
    ) -> Vec3 {
        let alpha = self.roughness * self.roughness;
        let square = alpha * alpha;
        let sine = kept3(normal.cross(half_way));
        let fresnel = schlick(self.facing, half_cosine);
        let specular = distribution(square, sine.dot(sine))
            * visibility(square, light_cosine, max(self.eye_cosine, 1e-3));
        let [share, rest] = [self.reflectance.x, self.reflectance.y];
        let lost = div(1.0, max(share + rest, 1e-3)) - 1.0;
        let compensation = Vec3::ONE + self.facing * lost;
        self.diffuse * (Vec3::ONE - fresnel) + fresnel * compensation * specular
    }

    /// Returns the share of diffuse light that arrives where the share `open` arrives directly, and
    /// the rest from surfaces of the same colour (Jiménez et al., "Practical realtime strategies for
    /// accurate indirect occlusion", 2016).
    #[inline]
    pub fn interreflected(&self, open: Real) -> Vec3 {
        let share = |albedo: Real| {
            let a = 2.0404 * albedo - 0.3324;
            let b = 0.6417 - 4.7951 * albedo;
            let c = 2.7552 * albedo + 0.6903;
            max(((a * open + b) * open + c) * open, open)
        };
        let albedo = self.diffuse;
        Vec3::new(share(albedo.x), share(albedo.y), share(albedo.z))
    }

    /// Returns the colour in the light of an environment: `irradiance` over π at the normal,
    /// and `radiance` in the direction of the reflection, blurred for the roughness.
    #[inline]
    pub fn surrounded(&self, irradiance: Vec3, radiance: Vec3) -> Vec3 {
        let [share, rest] = [self.reflectance.x, self.reflectance.y];
        let once = self.facing * share + Vec3::splat(rest);
        let lost = max(1.0 - share - rest, 0.0);
        let mean = self.facing + (Vec3::ONE - self.facing) * MEAN_REST;
        let again = |once: Real, mean: Real| lost * once * div(mean, 1.0 - mean * lost);
        let again = Vec3::new(
            again(once.x, mean.x),
            again(once.y, mean.y),
            again(once.z, mean.z),
        );
        let through = Vec3::ONE - once - again;
        once * radiance + (again + self.diffuse * through) * irradiance
    }
}

/// Returns Schlick's Fresnel term: the reflected share at `cosine` between light and
/// half-way vector.
#[inline]
pub fn schlick(facing: Vec3, cosine: Real) -> Vec3 {
    let rest = clamp(1.0 - cosine, 0.0, 1.0);
    let square = rest * rest;
    facing + (Vec3::ONE - facing) * (square * square * rest)
}

/// Returns π D: the density of GGX microfacets with α² = `square`, where `slant` is the square of
/// the sine between normal and half-way vector.
#[inline]
pub fn distribution(square: Real, slant: Real) -> Real {
    // cos² (α² − 1) + 1; for mirrors the sine has the digits that the cosine lacks.
    let base = square + slant * (1.0 - square);
    div(square, base * base)
}

/// Returns V: Smith's height-correlated shadowing over 4 cos cos.
#[inline]
pub fn visibility(square: Real, light_cosine: Real, eye_cosine: Real) -> Real {
    let part = |cosine: Real| sqrt(cosine * cosine * (1.0 - square) + square);
    let sum = light_cosine * part(eye_cosine) + eye_cosine * part(light_cosine);
    div(0.5, max(sum, 1e-9))
}

/// Returns what microfacets reflect of even light, as the factor of F_0 and the rest, from
/// the table at word `first`: rows of growing roughness, columns of growing cosine.
#[inline]
pub fn reflectance<T: Texels + ?Sized>(
    words: &T,
    first: u32,
    eye_cosine: Real,
    roughness: Real,
) -> Vec2 {
    const LAST: Real = (REFLECTANCE_SIZE - 1) as Real;
    const STEP: Real = 1.0 / 65_535.0;
    let part = |x: Real| {
        let at = clamp(x, 0.0, 1.0) * LAST;
        let low = clamp(at, 0.0, LAST - 1.0) as u32;
        (low, at - low as i32 as Real)
    };
    let (x, across) = part(eye_cosine);
    let (y, down) = part(roughness);
    let texel = |x: u32, y: u32| {
        let word = words.word(first + y * REFLECTANCE_SIZE + x);
        Vec2::new((word & 0xffff) as i32 as Real, (word >> 16) as i32 as Real) * STEP
    };
    let row = |y: u32| texel(x, y) * (1.0 - across) + texel(x + 1, y) * across;
    row(y) * (1.0 - down) + row(y + 1) * down
}
