//! The accurate tier: from prism to prism through the curved shell (section 6).

use super::{Found, Model, Normals, Place, Ray, Traced};
use crate::arithmetic::{div, kept, kept3, max, sqrt};
use crate::exit::Exits;
use crate::layout::{Frame, Object, vec3};
use crate::normals::{CLASS_WALL, HitSurface, normal_at};
use crate::prism::{Prism, PrismFrame};
use crate::profile::Profile;
use crate::shadow::{CLEARANCE, away, is_above};
use crate::shape_map::{ShapeMap, Texels};
use crate::walk::{self, Field, PrismList};
use crate::{Real, Vec2, Vec3};

/// The accurate tier.
#[derive(Clone, Copy, Debug)]
pub struct Prisms;

/// The prism that a pixel is drawn for, among its neighbours.
#[derive(Clone, Copy)]
pub struct Home<S> {
    /// All prisms of the object.
    pub prisms: S,
    /// Its number.
    pub index: u32,
}

/// A place in the shell.
#[derive(Clone, Copy, Debug)]
pub struct PrismPlace {
    /// Number of the prism.
    pub prism: u32,
    /// (w1, w2, δ) there.
    pub x: Vec3,
    /// Number of prisms that the ray went through.
    pub prisms: u32,
}

impl HitSurface for PrismFrame {
    #[inline]
    fn normal(&self) -> Vec3 {
        self.normal
    }

    /// The gradient in space of g, with the gradients of u, v and δ in the prism
    /// (section 9).
    #[inline]
    fn side(&self, slope: Vec2, is_sloped: bool, growth: Real) -> Vec3 {
        let mut gradient = self.gradient_u * slope.x + self.gradient_v * slope.y;
        if is_sloped {
            gradient -= self.jacobian.gradient_depth * growth;
        }
        gradient
    }

    #[inline]
    fn gradients(&self) -> (Vec3, Vec3) {
        (self.gradient_u, self.gradient_v)
    }
}

impl Place for PrismPlace {
    #[inline]
    fn facet(&self, _: u32) -> u32 {
        self.prism
    }

    #[inline]
    fn prisms(&self) -> u32 {
        self.prisms
    }
}

/// The tolerance of `object` at distance 1, object units.
#[inline]
fn tolerance(frame: &Frame, object: &Object) -> Real {
    let pixel = vec3(frame.ray_right);
    object.tolerance * sqrt(pixel.dot(pixel))
}

impl<S: PrismList> Model<Home<S>> for Prisms {
    type Meeting = ();
    type Entry = ();
    type Place = PrismPlace;
    type Surface = PrismFrame;
    const FINDS_ENTRY: bool = false;

    #[inline]
    fn meet(_: &Ray<'_>, _: &Home<S>) -> (bool, ()) {
        (true, ())
    }

    /// The search finds out where the ray enters.
    #[inline]
    fn enter<X: Exits>(_: &Ray<'_>, _: &Home<S>, _: &(), _: &X) -> (bool, ()) {
        (true, ())
    }

    #[inline]
    fn entry_t(_: &()) -> Real {
        0.0
    }

    #[inline]
    fn search<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        home: &Home<S>,
        texels: &T,
        _: &(),
    ) -> Found<PrismPlace> {
        let object = ray.object;
        let field = Field {
            prisms: &home.prisms,
            object,
            tolerance: tolerance(ray.frame, object),
            slack: object.slack,
            texels,
            binary_steps: object.binary_steps,
        };
        let found = walk::search(&field, home.index, vec3(ray.frame.eye), ray.direction);
        Found {
            march: found.march,
            t: found.march.s,
            place: PrismPlace {
                prism: found.prism,
                x: found.x,
                prisms: found.prisms,
            },
        }
    }

    #[inline]
    fn surface(ray: &Ray<'_>, home: &Home<S>, _: &(), place: &PrismPlace) -> PrismFrame {
        Prism::new(home.prisms.prism(place.prism), ray.object.depth).frame(place.x)
    }

    #[inline]
    fn lit<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        home: &Home<S>,
        texels: &T,
        traced: &Traced<PrismPlace>,
        surface: &PrismFrame,
        normals: &Normals,
    ) -> bool {
        let object = ray.object;
        let to_light = vec3(ray.frame.light_direction);
        if is_above::<T>(traced.hit.class, traced.hit.depth_fraction) {
            return true;
        }
        if to_light.dot(normals.smooth) <= 0.0 {
            return false;
        }
        let map = ShapeMap::new(object);
        let profile = Profile::new(object);
        // A side may lie as flat as the surface: start above it, and beside the wall of
        // the same place, which does not.
        let mut x = traced.place.x;
        let side = if profile.is_straight() {
            normals.carved
        } else {
            x.z = max(x.z - profile.depth_of_growth(CLEARANCE), 0.0);
            let (uv, depth_fraction) = (traced.hit.uv, traced.hit.depth_fraction);
            if T::IS_STACK {
                normals.carved
            } else {
                normal_at(
                    CLASS_WALL,
                    object,
                    &map,
                    texels,
                    surface,
                    uv,
                    depth_fraction,
                )
            }
        };
        // Start beside it.
        let sideways = away(side, normals.smooth);
        let rate = Vec2::new(
            kept(sideways.dot(kept3(surface.gradient_u))),
            kept(sideways.dot(kept3(surface.gradient_v))),
        ) * map.size;
        let speed = sqrt(rate.dot(rate));
        let offset = if speed > 1e-12 {
            sideways * div(CLEARANCE, speed)
        } else {
            Vec3::ZERO
        };
        let field = Field {
            prisms: &home.prisms,
            object,
            tolerance: tolerance(ray.frame, object),
            slack: 0.0,
            texels,
            binary_steps: 0,
        };
        walk::leaves(&field, traced.place.prism, x, offset, to_light)
    }
}
