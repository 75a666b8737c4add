//! A pixel with what it hits, and how far the surface there reaches on the picture.

use super::super::Tables;
use super::super::material::finish_of;
use super::super::pattern::{density, gap, growth};
use crate::arithmetic::{abs, div, kept, kept3, max, min, normalize_or, sqrt};
use crate::camera::through;
use crate::gbuffer::{Hits, MeshFrame, Sample, is_side};
use crate::layout::{Frame, vec3};
use crate::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_MISS, CLASS_WALL};
use crate::{Real, Vec2, Vec3};
use glam::IVec2;

/// Place of an edge that is beyond the other centre.
const BEYOND: Real = 2.0;
/// Step in depth that makes an edge, widths of a pixel.
pub(super) const STEP: Real = 0.3;
/// Least turn of a surface before a pixel, of that after it, which tells a curve from an edge.
const BEGUN: Real = 0.06;
/// Least δ of a hit that tells how far it is to other depths.
const LEAST_DEPTH: Real = 0.03;

/// A pixel with what it hits.
#[derive(Clone, Copy)]
pub(super) struct Pixel {
    /// Direction of its ray, whose part along the view axis is 1.
    pub(super) ray: Vec3,
    pub(super) hit: Sample,
    /// Distance along the view axis.
    pub(super) depth: Real,
    /// See [`Pixel::width_of_side`]; 0 where it is not asked for.
    pub(super) side_width: Real,
}

impl Pixel {
    // As the functions of `Hits`.
    #[inline(always)]
    pub(super) fn new<H: Hits + ?Sized>(frame: &Frame, hits: &H, at: IVec2) -> Pixel {
        let within = |x: i32, size: Real| {
            let last = size as i32 - 1;
            let x = if x < last { x } else { last };
            if x > 0 { x } else { 0 }
        };
        let (x, y) = (within(at.x, frame.size[0]), within(at.y, frame.size[1]));
        let (place, surface) = hits.words(x as u32, y as u32);
        let hit = Sample::at_depth_on_mesh(place, surface);
        let ray = through(frame, x as Real, y as Real);
        Pixel {
            ray,
            hit,
            depth: max(div(hit.t, sqrt(ray.dot(ray))), 1e-18),
            side_width: 0.0,
        }
    }

    #[inline]
    pub(super) fn is_hit(&self) -> bool {
        self.hit.class != CLASS_MISS
    }

    /// Returns whether it hits a side whose cap is along `step`.
    #[inline]
    pub(super) fn leads_to_cap(&self, step: Vec2) -> bool {
        is_side(self.hit.class) && kept(self.hit.edge.direction.dot(step)) > 0.0
    }

    /// Returns the normal's part along the ray, which points against it.
    #[inline]
    fn facing(&self) -> Real {
        min(kept(self.hit.normal.dot(self.ray)), -1e-3)
    }

    /// Returns 1 / distance along the view axis, and its change on the tangent plane where the
    /// ray changes by `along`: both are even on planes.
    #[inline]
    pub(super) fn inverse(&self, along: Vec3) -> (Real, Real) {
        let inverse = div(1.0, self.depth);
        let rate = div(kept(self.hit.normal.dot(along)), self.facing());
        (inverse, kept(rate * inverse))
    }

    /// Returns how far above the tangent plane that is which `other` hits.
    #[inline]
    pub(super) fn height_of(&self, other: &Pixel) -> Real {
        let way = kept3(other.ray * other.depth - self.ray * self.depth);
        kept(self.hit.normal.dot(way))
    }

    /// Returns whether the tangent plane leads to what `other` hits, where a pixel is `pixel`
    /// wide at distance 1.
    #[inline]
    pub(super) fn leads_to(&self, other: &Pixel, pixel: Real) -> bool {
        abs(self.height_of(other)) < STEP * pixel * self.depth * -self.facing()
    }

    /// Returns how far the edge is that the hit knows, pixels along `step`.
    #[inline]
    pub(super) fn known_end<T: Tables + ?Sized>(&self, tables: &T, step: Vec2) -> Real {
        let Sample {
            class,
            edge,
            depth_fraction: depth,
            ..
        } = self.hit;
        if !self.is_hit() || !edge.is_near {
            return BEYOND;
        }
        let mut rate = kept(edge.direction.dot(step));
        let mut distance = edge.distance;
        if is_side(class) {
            // A side knows the edge of the cap: its bevel or its wall ends on the way there, or on the
            // opposite way.
            let rim = tables.finish(finish_of(&self.hit)).rim;
            let is_up = rate > 0.0;
            let is_wall = class == CLASS_WALL;
            let end = if is_wall == is_up {
                rim
            } else if is_wall {
                1.0
            } else {
                0.0
            };
            let to_end = if is_up { depth - end } else { end - depth };
            distance *= div(to_end, max(depth, 1e-6));
            rate = if is_up {
                rate
            } else if depth < LEAST_DEPTH {
                0.0
            } else {
                -rate
            };
        }
        if distance >= 0.0 && distance < rate {
            div(distance, rate)
        } else {
            BEYOND
        }
    }

    /// Returns the cap above what it hits, or the floor below it, on a part of the mesh that is as `mesh`.
    #[inline]
    pub(super) fn level<T: Tables + ?Sized>(
        &self,
        tables: &T,
        mesh: &MeshFrame,
        is_cap: bool,
    ) -> Pixel {
        let depth = tables.finish(finish_of(&self.hit)).depth * self.hit.unit;
        let below = if is_cap { 0.0 } else { 1.0 } - self.hit.depth_fraction;
        let mut level = *self;
        level.hit.class = if is_cap { CLASS_CAP } else { CLASS_FLOOR };
        level.hit.normal = mesh.normal;
        level.hit.tangent = mesh.along_u;
        level.hit.is_mirrored = mesh.is_mirrored;
        level.hit.is_along_v = false;
        level.depth = max(self.depth + div(below * depth, -level.facing()), 1e-18);
        level
    }

    /// Returns the width of the side below the near edge of a cap, pixels across the edge: as far as
    /// the rim of the bevel hides the rest of it, or down to its foot; or of the wall above the near edge of
    /// a floor, up to the rim, negative where that hides the wall: at the opposite edge it is seen. It is 0 of anything
    /// else.
    #[inline]
    pub(super) fn width_of_side<T: Tables + ?Sized>(&self, tables: &T, frame: &Frame) -> Real {
        let is_cap = self.hit.class == CLASS_CAP;
        if !(is_cap || self.hit.class == CLASS_FLOOR) || !self.hit.edge.is_near {
            return 0.0;
        }
        let (aside, down) = self.side(tables, frame);
        let rim = tables.finish(finish_of(&self.hit)).rim;
        if is_cap {
            width_below(aside, down, rim)
        } else if rim > 0.0 {
            down * (rim - 1.0)
        } else {
            0.0
        }
    }

    /// Returns how far a side at the edge of a cap or a floor reaches on the picture, pixels across the edge:
    /// by what it grows, and by its depth, which is negative where the eye looks along it.
    #[inline]
    pub(super) fn side<T: Tables + ?Sized>(&self, tables: &T, frame: &Frame) -> (Real, Real) {
        let hit = self.hit;
        let finish = tables.finish(finish_of(&hit));
        let outward = self.outward(frame);
        let at_edge = self.ray + self.way_to_edge(frame) * hit.edge.distance;
        let across = self.across_edge(frame, at_edge);
        let growth = growth(tables, finish, &hit, outward) * hit.unit;
        let aside = abs(kept(across.dot(outward))) * growth;
        (
            aside,
            -kept(across.dot(hit.normal)) * finish.depth * hit.unit,
        )
    }

    /// Returns the vector whose product with another one says how far that reaches across the edge on the
    /// picture, pixels, as `ray` sees it: they are as wide as high.
    #[inline]
    fn across_edge(&self, frame: &Frame, ray: Vec3) -> Vec3 {
        let right = vec3(frame.ray_right);
        let scale = div(1.0, kept(right.dot(right)) * self.depth);
        kept3(self.along_edge(frame).cross(ray)) * scale
    }

    /// Returns the mean width of the gaps of the pattern at a cap, pixels across an edge that is in the
    /// direction `to_edge` on the picture; 0 if it is not known.
    #[inline]
    pub(super) fn gap<T: Tables + ?Sized>(&self, tables: &T, frame: &Frame, to_edge: Vec2) -> Real {
        let mut cap = *self;
        cap.hit.edge.direction = to_edge;
        let across = cap.across_edge(frame, cap.ray);
        abs(kept(across.dot(cap.outward(frame)))) * self.gap_width(tables)
    }

    /// Returns the mean width of the gaps of the pattern at a cap, world units; 0 if it is not known.
    #[inline]
    pub(super) fn gap_width<T: Tables + ?Sized>(&self, tables: &T) -> Real {
        let finish = tables.finish(finish_of(&self.hit));
        if finish.chart.image.levels == 0 {
            return 0.0;
        }
        gap(finish, density(tables, finish, &self.hit))
    }

    /// Returns how long `width` across the edge is along `step`, which leads to it.
    #[inline]
    pub(super) fn along(&self, step: Vec2, width: Real) -> Real {
        let rate = kept(self.hit.edge.direction.dot(step));
        div(width, max(rate, 1e-3))
    }

    /// Returns the way to the edge on the picture, as the change of the ray over a pixel.
    #[inline]
    fn way_to_edge(&self, frame: &Frame) -> Vec3 {
        let to_edge = self.hit.edge.direction;
        vec3(frame.ray_right) * to_edge.x + vec3(frame.ray_down) * to_edge.y
    }

    /// Returns the same across that way, along the edge.
    #[inline]
    fn along_edge(&self, frame: &Frame) -> Vec3 {
        let to_edge = self.hit.edge.direction;
        vec3(frame.ray_down) * to_edge.x - vec3(frame.ray_right) * to_edge.y
    }

    /// Returns the unit vector on the tangent plane across the edge, towards it.
    #[inline]
    pub(super) fn outward(&self, frame: &Frame) -> Vec3 {
        let normal = self.hit.normal;
        let on_plane = |v: Vec3| kept3(v - self.ray * div(kept(normal.dot(v)), self.facing()));
        // It is a quarter turn from the edge, as on the picture: the normal faces the eye.
        let edge = on_plane(self.along_edge(frame));
        normalize_or(kept3(normal.cross(edge)), self.hit.tangent)
    }

    /// Returns whether it hits the same part of an object as `other` does.
    #[inline]
    fn is_like(&self, other: &Pixel) -> bool {
        self.hit.class == other.hit.class && self.hit.finish == other.hit.finish
    }

    /// Returns whether the surface goes on to `next` in a curve that has begun before it, on the
    /// opposite side, where `inner` is.
    #[inline]
    pub(super) fn curves(&self, inner: &Pixel, next: &Pixel) -> bool {
        let begun = kept3(self.hit.normal - inner.hit.normal);
        let turn = kept3(next.hit.normal - self.hit.normal);
        let is_one = self.is_like(inner) && self.is_like(next);
        is_one && kept(begun.dot(turn)) > BEGUN * kept(turn.dot(turn))
    }

    /// Returns how far it is to where the surface turns away from the eye, pixels away from
    /// `inner`: the square of the cosine between normal and ray falls evenly.
    #[inline]
    pub(super) fn horizon(&self, inner: &Pixel) -> Real {
        let square = |pixel: &Pixel| {
            let facing = pixel.facing();
            kept(div(facing * facing, pixel.ray.dot(pixel.ray)))
        };
        let (own, before) = (square(self), square(inner));
        if self.is_like(inner) && before > 2.0 * own {
            div(own, before - own)
        } else {
            BEYOND
        }
    }
}

/// Returns how wide what is seen of a side looks below the edge of a cap, of what [`Pixel::side`] returns: down to
/// its foot, or to the `rim` of a bevel that hides the rest.
#[inline]
pub(super) fn width_below(aside: Real, down: Real, rim: Real) -> Real {
    max(aside + max(down, down * rim), 0.0)
}
