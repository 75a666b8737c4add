//! The tangent frame at a hit, in which normal maps and coordinates down a wall are given.

use crate::arithmetic::{abs, kept, kept3, normalize_or};
use crate::contract::check3;
use crate::model::Normals;
use crate::normals::{CLASS_BEVEL, CLASS_WALL};
use crate::{Real, Vec3};

/// Largest square of the sine between a side and the mesh where the side has no outline: it faces as
/// the cap does.
pub const FLAT: Real = 1e-6;

/// The tangent at a hit, and how the texture lies along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentFrame {
    /// Unit tangent: the direction of growing u on caps and floors; along the outline on walls and
    /// bevels.
    pub tangent: Vec3,
    /// Whether the tangent runs along the outline.
    pub is_side: bool,
    /// Whether that outline runs along v rather than along u.
    pub is_along_v: bool,
    /// Whether normal × tangent points against growing v, or out of the depth.
    pub is_mirrored: bool,
}

impl TangentFrame {
    /// Returns the frame at a hit of `class` with `normals`, where ∇u and ∇v are `gradients`.
    #[inline]
    pub fn new(class: u32, normals: &Normals, gradients: (Vec3, Vec3)) -> TangentFrame {
        let (gradient_u, gradient_v) = gradients;
        let smooth = normals.smooth;
        let along_u = kept3(gradient_u - smooth * smooth.dot(gradient_u));
        let outline = kept3(smooth.cross(normals.carved));
        let is_side = (class == CLASS_WALL || class == CLASS_BEVEL) && outline.dot(outline) > FLAT;
        let rate_u: Real = kept(gradient_u.dot(outline));
        let rate_v: Real = kept(gradient_v.dot(outline));
        let is_along_v = is_side && abs(rate_v) > abs(rate_u);
        let tangent = if !is_side {
            along_u
        } else if (if is_along_v { rate_v } else { rate_u }) < 0.0 {
            -outline
        } else {
            outline
        };
        let tangent = normalize_or(tangent, Vec3::X);
        let bitangent = normals.carved.cross(tangent);
        let towards = if is_side {
            -bitangent.dot(smooth)
        } else {
            kept(bitangent.dot(kept3(gradient_v)))
        };
        check3(tangent);
        TangentFrame {
            tangent,
            is_side,
            is_along_v,
            is_mirrored: towards < 0.0,
        }
    }
}
