//! Where the surfaces that two neighbouring pixels hit end on the way from one centre to the other.

use super::super::Tables;
use super::super::material::finish_of;
use super::pixel::{Pixel, STEP};
use super::{as_vec, ray_step};
use crate::Real;
use crate::arithmetic::{abs, div, kept, max, min, sqrt};
use crate::gbuffer::{Hits, is_side};
use crate::layout::Frame;
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR, CLASS_WALL};
use glam::IVec2;

/// Where two surfaces end, pixels from the centre of one towards that of the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    /// End of the one.
    pub(super) own: Real,
    /// Begin of the other, no less than that.
    pub(super) other: Real,
}

impl Ends {
    /// Returns the ends of surfaces that meet.
    #[inline]
    pub(super) fn meeting(at: Real) -> Ends {
        Ends { own: at, other: at }
    }

    /// Returns ends with which a line across the pixel has the shares that the pixel has of an edge which moves by
    /// `slant` across it, 0…1.
    #[inline]
    pub(super) fn slanted(&self, slant: Real) -> Ends {
        let half = 0.5 * slant;
        let end = |place: Real| {
            let left = 0.5 - place;
            if abs(left) < half {
                let from_corner = left + half;
                0.5 - div(from_corner * from_corner, 4.0 * half)
            } else {
                place
            }
        };
        Ends {
            own: end(self.own),
            other: end(self.other),
        }
    }

    /// Returns the share of the other in the pixel of the one.
    #[inline]
    pub(super) fn beyond(&self) -> Real {
        max(0.5 - self.other, 0.0)
    }

    /// Returns the share of what lies between in the pixel of the one.
    #[inline]
    pub(super) fn between(&self) -> Real {
        max(0.5 - self.own, 0.0) - self.beyond()
    }
}

/// Where there is no edge before the other centre.
pub(super) const NONE: Ends = Ends {
    own: 1.0,
    other: 1.0,
};
/// Place of an edge that no hit knows, between the pixels.
pub(super) const UNKNOWN: Real = 0.5;

/// Returns whether `own` and `other`, one of which is a cap or a floor, may be parts of one carving: the other
/// one is below a cap or above a floor, and by no more than its depth.
#[inline]
fn goes_on<T: Tables + ?Sized>(tables: &T, own: &Pixel, other: &Pixel, pixel: Real) -> bool {
    let (even, beyond) = if has_side(own.hit.class, other.hit.class) {
        (*own, *other)
    } else {
        (*other, *own)
    };
    let depth = tables.finish(finish_of(&even.hit)).depth * even.hit.unit;
    let height = even.height_of(&beyond);
    let beyond = if even.hit.class == CLASS_CAP {
        -height
    } else {
        height
    };
    let slack = STEP * depth + pixel * even.depth;
    beyond > -slack && beyond < depth + slack
}

/// Returns whether the side between surfaces of these classes, if there is one, is at the first one: below a
/// cap, or above a floor.
#[inline]
pub(super) fn has_side(class: u32, other: u32) -> bool {
    class == CLASS_CAP || class == CLASS_FLOOR && other != CLASS_CAP
}

/// Returns where two parts of one carving end, at least one of which is a cap or a floor, of pixels along
/// `step` that know their edges at `known`. The ends are beyond the centres, or each other, where that is
/// not known.
#[inline]
fn in_carving<T: Tables + ?Sized>(
    tables: &T,
    frame: &Frame,
    own: &Pixel,
    other: &Pixel,
    step: IVec2,
    known: &Ends,
) -> Ends {
    let (class, other_class) = (own.hit.class, other.hit.class);
    let are_caps = class == CLASS_CAP && other_class == CLASS_CAP;
    let is_own = if are_caps {
        known.own <= 1.0
    } else {
        has_side(class, other_class)
    };
    // From the one with the side. By value: a GPU does not choose between references.
    let (even, beyond, towards) = if is_own {
        (*own, *other, as_vec(step))
    } else {
        (*other, *own, as_vec(-step))
    };
    let (mut end, mut begin) = (known.own, known.other);
    if !is_own {
        (end, begin) = (1.0 - begin, 1.0 - end);
    }
    let is_beyond_even = !is_side(beyond.hit.class);
    let edge = if are_caps {
        even.hit.edge
    } else {
        beyond.hit.edge
    };
    let away = kept(edge.direction.dot(towards));
    let is_opposite = even.hit.class == CLASS_CAP && !is_beyond_even && away >= 0.0;
    // A cap may know another edge only. It begins a gap away from the opposite one.
    let lacks_edge = if are_caps {
        end <= 1.0 && begin < 0.0
    } else {
        is_opposite && edge.is_near && end > 1.0
    };
    if lacks_edge {
        let gap = even.gap(tables, frame, edge.direction);
        let inverse = div(1.0, max(away, 1e-3));
        let back = (gap - edge.distance) * inverse;
        if gap > 0.0 && are_caps {
            begin = end + gap * inverse;
        } else if gap > 0.0 && abs(back - 0.5) <= 0.5 {
            end = 1.0 - back;
        }
    }
    let is_known = end <= 1.0;
    // At the opposite edge, where `rate` is negative, the side is seen whose width is.
    let rate = kept(even.hit.edge.direction.dot(towards));
    let rate_or_least = if abs(rate) > 1e-3 { rate } else { 1e-3 };
    let side = max(div(even.side_width, rate_or_least), 0.0);
    // Between a floor and a bevel is the wall below it.
    let is_walled = even.hit.class == CLASS_FLOOR && beyond.hit.class == CLASS_BEVEL;
    if are_caps || is_opposite && is_known && begin > end {
        // Between a cap and the side below the opposite one is floor, unless the cap hides it.
    } else if is_beyond_even {
        // A cap and the side below its edge hide what is behind them. Where they would hide the
        // floor that is seen, the outline is not straight.
        if is_known {
            let side = if end + side <= 1.0 { side } else { 0.0 };
            begin = max(end + side, begin);
        }
        end = min(end, begin);
    } else if is_known {
        // Between a cap and a wall is the bevel above it.
        let is_beveled = even.hit.class == CLASS_CAP
            && beyond.hit.class == CLASS_WALL
            && tables.finish(finish_of(&even.hit)).rim > 0.0;
        begin = if is_walled {
            min(end + side, 1.0)
        } else if is_beveled {
            max(begin, end)
        } else {
            end
        };
    } else if is_walled && rate < 0.0 && begin >= side {
        // The floor knows the opposite edge only.
        end = begin - side;
    } else {
        end = begin;
    }
    if is_own {
        Ends {
            own: end,
            other: begin,
        }
    } else {
        Ends {
            own: 1.0 - begin,
            other: 1.0 - end,
        }
    }
}

/// Returns where the surfaces of `own`, pixel `at`, and of `other`, its neighbour along `step`,
/// end.
#[inline]
pub(super) fn ends<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    at: IVec2,
    own: &Pixel,
    other: &Pixel,
    step: IVec2,
) -> Ends {
    if !own.is_hit() && !other.is_hit() {
        return NONE;
    }
    let known = Ends {
        own: own.known_end(tables, as_vec(step)),
        other: 1.0 - other.known_end(tables, as_vec(-step)),
    };
    let found = on_line(tables, frame, hits, (at, step), own, other, &known);
    let is_own = known.own <= 1.0;
    let is_found = found.own != UNKNOWN || found.other != UNKNOWN;
    if is_found && (is_own || known.other >= 0.0) {
        let edge = if is_own { own.hit.edge } else { other.hit.edge };
        let along = abs(kept(edge.direction.dot(as_vec(step))));
        let across = abs(kept(edge.direction.perp_dot(as_vec(step))));
        found.slanted(div(min(across, along), max(along, 1e-3)))
    } else {
        found
    }
}

/// Returns the same on the line between the centres, given where edges are `known`.
#[inline]
fn on_line<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    (at, step): (IVec2, IVec2),
    own: &Pixel,
    other: &Pixel,
    known: &Ends,
) -> Ends {
    let along = ray_step(frame, step);
    let mut is_own_nearer = own.is_hit();
    if own.is_hit() && other.is_hit() {
        let (class, other_class) = (own.hit.class, other.hit.class);
        let pixel = sqrt(along.dot(along));
        let leads = own.leads_to(other, pixel) && other.leads_to(own, pixel);
        let is_one = own.hit.finish == other.hit.finish;
        if is_one && !(is_side(class) && is_side(other_class)) {
            // A floor beyond the cap of a side is not the one at its foot.
            let is_behind = other_class == CLASS_FLOOR && own.leads_to_cap(as_vec(step))
                || class == CLASS_FLOOR && other.leads_to_cap(as_vec(-step));
            let goes_on = if class != other_class {
                !is_behind && goes_on(tables, own, other, pixel)
            } else {
                // Outlines in all directions are not straight for long enough.
                let is_known = known.own <= 1.0 || known.other >= 0.0;
                let is_cap = leads && is_known && class == CLASS_CAP;
                is_cap && tables.finish(finish_of(&own.hit)).chart.order > 0.0
            };
            if goes_on {
                let found = in_carving(tables, frame, own, other, step, known);
                let is_found = found.own <= 1.0 && found.other >= 0.0;
                let is_gap = found.own >= 0.0 && found.own < found.other && found.other <= 1.0;
                if is_gap || is_found && class != other_class {
                    return found;
                }
            }
        }
        if leads {
            return NONE;
        }
        let are_sides = is_one && is_side(class) && is_side(other_class);
        if are_sides && known.own <= 1.0 && known.own < known.other {
            return *known;
        }
        // Where their tangent planes meet, if they do up to half a pixel beyond the centres.
        let (inverse, slope) = own.inverse(along);
        let (other_inverse, other_slope) = other.inverse(along);
        let first = inverse - (other_inverse - other_slope);
        let last = inverse + slope - other_inverse;
        if abs(first + last) < 2.0 * abs(first - last) {
            let (nearer, farther, before) = if own.depth < other.depth {
                (*own, *other, at - step)
            } else {
                (*other, *own, at + step + step)
            };
            let before = Pixel::new(frame, hits, before);
            return if nearer.curves(&before, &farther) {
                NONE
            } else {
                let at = div(first, first - last);
                // Beyond a centre it counts less and less, so that nothing changes at once.
                Ends::meeting(if at > 1.0 { 2.0 - at } else { abs(at) })
            };
        }
        is_own_nearer = first > 0.0;
        // The cap beyond a side that hides the rest, up to the other centre.
        let is_capped = if is_own_nearer {
            known.own <= 1.0 && other_class != CLASS_CAP && own.leads_to_cap(as_vec(step))
        } else {
            known.other >= 0.0 && class != CLASS_CAP && other.leads_to_cap(as_vec(-step))
        };
        if is_one && is_capped {
            return Ends {
                own: if is_own_nearer { known.own } else { 0.0 },
                other: if is_own_nearer { 1.0 } else { known.other },
            };
        }
    }
    // One hides the other.
    let end = if is_own_nearer {
        known.own
    } else {
        known.other
    };
    Ends::meeting(if abs(end - 0.5) <= 0.5 { end } else { UNKNOWN })
}
