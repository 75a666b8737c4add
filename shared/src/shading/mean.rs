//! The mean of what a pixel sees of a pattern whose parts are smaller than the pixel.
//!
//! A chart of the pattern says which share of an area is cap, and how its outline runs: the sum of
//! m mᵀ over the outline, where m is its unit normal, per area. Its eigenvectors are the normals of two
//! families of straight grooves that have the same outline. How far the floor is shifted against the
//! cap, seen from the eye, says which shares of a groove are floor and sides; how far it is
//! shifted as seen from a light, which share of them is lit.
//!
//! A texel of the chart is four numbers: the share of the cap, and xx / [`MOST`], yy / [`MOST`] and
//! ½ + xy / [`MOST`] of the sum, 1 / texels.

mod grooves;

pub use grooves::MOST;

use super::edges::{Shares, from_code, lights_of};
use super::image::{Footprint, sample_over};
use super::layout::{Light, Lighting};
use super::lights::{self, Incoming};
use super::material::finish_of;
use super::pattern::{density, gap, texels};
use super::{Tables, mixed, shade_under};
use crate::arithmetic::{abs, clamp, div, kept, kept3, max, sqrt};
use crate::camera::{on_plane, pixel_ray};
use crate::contract::check3;
use crate::gbuffer::{self, Hits, MeshFrame, Sample};
use crate::layout::{Frame, vec3};
use crate::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_MISS};
use crate::trace::word;
use crate::{Real, Vec2, Vec3};
use glam::UVec4;
use grooves::{Grooves, LEAST_COSINE, Pattern, of_family};

/// Where the mesh faces the ray by this share of what it does beside a pixel, it turns away too fast
/// for a plane. The mean is full from this share + 1 / scale on.
const TURNS: Real = 0.85;
const TURNS_SCALE: Real = 10.0;
/// Least cosine between normals of the mesh that face alike, and how far two places of an even mesh
/// may be above each other, as a share of their distance.
const ALIKE: Real = 0.9;
const ALIKE_SLOPE: Real = 0.25;
/// How many times a groove may be narrower than the mean of the gaps of its pattern.
pub const MOST_UNEVEN: Real = 2.0;
/// 1 / the share of a pixel up to which a part is not shaded; it counts fully from twice that share on.
const INVERSE_LEAST_SHARE: Real = 256.0;

/// Which shares of an area are seen; the rest is floor.
#[derive(Clone, Copy, Debug)]
struct Seen {
    cap: Real,
    /// Of the sides of each family.
    sides: Vec2,
    /// Share of those that face away from the eye.
    away: Vec2,
}

impl Seen {
    /// Returns the share of the part that `step` shades; 0 of one that is too small to matter.
    #[inline]
    fn share(&self, step: u32) -> Real {
        let share = if step == CAP {
            self.cap
        } else if step == FLOOR {
            1.0 - self.cap - self.sides.x - self.sides.y
        } else {
            let away = of_family(self.away, is_second(step));
            let share = if is_away(step) { away } else { 1.0 - away };
            of_family(self.sides, is_second(step)) * share
        };
        share * clamp(share * INVERSE_LEAST_SHARE - 1.0, 0.0, 1.0)
    }
}

/// How a pixel sees the mesh.
#[derive(Clone, Copy, Debug)]
struct View {
    /// Unit direction of the ray.
    direction: Vec3,
    mesh: MeshFrame,
    /// The place on the cap where the ray goes through.
    cap: Sample,
    /// Repeats of the pattern per world unit along u and v.
    rate: Vec2,
}

/// Number of steps. The first one finds the pattern; each of the others shades a part of it.
const STEPS: u32 = 7;
const FIND: u32 = 0;
const CAP: u32 = 1;
/// The sides of the first family that face the eye, and those that face away; then those of the
/// second one.
const SIDES: u32 = 2;
const FLOOR: u32 = 6;

/// Returns whether the sides that `step` shades are those of the second family.
#[inline]
fn is_second(step: u32) -> bool {
    step > SIDES + 1
}

/// Returns whether the sides that `step` shades face away from the eye.
#[inline]
fn is_away(step: u32) -> bool {
    (step - CAP) & 1 == 0
}

/// Returns the words of pixel (`x`, `y`) of a picture with smooth edges, where the mean of a pattern
/// is seen instead of what the pixel hits: not at all where the grooves of the pattern are wider than
/// the pixel, nothing else where the pixel is twice as wide as they are. Hits know the mesh, and
/// `color` returns the words of the pixel by [`words_with_edges`](super::words_with_edges), given whether nothing
/// but the mean is seen.
#[inline]
pub fn words<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    at: (u32, u32),
    hits: &H,
    color: impl FnOnce(bool) -> UVec4,
) -> UVec4 {
    let (mean, weight) = mean(tables, frame, lighting, hits, at);
    let found = color(weight == 1.0);
    if weight > 0.0 {
        let mean = kept3(mean);
        check3(mean);
        let (own, between) = lights_of(found);
        let (_, shares) = from_code(found.w);
        let left = 1.0 - weight;
        let own_weight = left * (1.0 - shares.between) * mixed(lighting, own);
        let between_weight = left * shares.between * mixed(lighting, between);
        let mean_weight = weight * mixed(lighting, mean);
        let total = div(1.0, own_weight + between_weight + mean_weight);
        let rgb = kept3((own * own_weight + between * between_weight + mean * mean_weight) * total);
        let code = faded(tables, frame, hits, at, found.w, 1.0 - weight);
        UVec4::new(word(rgb.x), word(rgb.y), word(rgb.z), code)
    } else {
        found
    }
}

/// Returns whether the grooves at pixel (`x`, `y`) may be so narrow that their mean is seen. Costs little,
/// and most pixels of most pictures end here.
#[inline]
fn may_be_seen<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    (x, y): (u32, u32),
) -> bool {
    let hit = hits.sample(x, y);
    if hit.class == CLASS_MISS {
        return false;
    }
    let finish = tables.finish(finish_of(&hit));
    if finish.chart.image.levels == 0 {
        return false;
    }
    let facing = -kept(hits.mesh(x, y).normal.dot(pixel_ray(frame, x, y)));
    // No side of the footprint is longer than a side of a pixel that is tilted along it.
    let (right, down) = (vec3(frame.ray_right), vec3(frame.ray_down));
    let side = sqrt(max(right.dot(right), down.dot(down)));
    let pixel = div(side * hit.t, max(facing, LEAST_COSINE));
    let is_wider = pixel * MOST_UNEVEN > gap(finish, density(tables, finish, &hit));
    is_wider | gbuffer::is_mean_only(hits.words(x, y).1)
}

/// Returns the class word `code` of pixel (`x`, `y`), in which the shares of neighbours are scaled by
/// `scale`, where they hit the same pattern on a part of the mesh that goes on alike.
#[inline]
fn faded<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    (x, y): (u32, u32),
    code: u32,
    scale: Real,
) -> u32 {
    let (own, mesh) = (hits.sample(x, y), hits.mesh(x, y));
    let place = pixel_ray(frame, x, y) * own.t;
    let depth = tables.finish(finish_of(&own)).depth * own.unit;
    let (class, shares) = from_code(code);
    let share = |share: Real, is_after: bool| {
        if share > 0.0 {
            // Only neighbours in the picture have a share.
            let step = |x: u32| if is_after { x + 1 } else { x - 1 };
            let (x, y) = if shares.is_down {
                (x, step(y))
            } else {
                (step(x), y)
            };
            let other = hits.sample(x, y);
            let cosine = kept(mesh.normal.dot(hits.mesh(x, y).normal));
            // Not so where it hides itself, or a copy.
            let way = kept3(pixel_ray(frame, x, y) * other.t - place);
            let above = abs(kept(mesh.normal.dot(way)));
            let goes_on = above < depth + ALIKE_SLOPE * sqrt(way.dot(way));
            let is_hit = other.class != CLASS_MISS && other.finish == own.finish;
            let is_alike = is_hit && cosine > ALIKE && goes_on;
            share * if is_alike { scale } else { 1.0 }
        } else {
            0.0
        }
    };
    let shares = Shares {
        before: share(shares.before, false),
        after: share(shares.after, true),
        between: 0.0,
        ..shares
    };
    shares.code(class)
}

impl View {
    /// Returns that of a pixel that hits `hit` on `mesh` along `direction`.
    #[inline]
    fn new<T: Tables + ?Sized>(tables: &T, direction: Vec3, mesh: MeshFrame, hit: &Sample) -> View {
        let rate = density(tables, tables.finish(finish_of(hit)), hit);
        let view = View {
            direction,
            mesh,
            cap: *hit,
            rate,
        };
        View {
            cap: view.at_depth(tables, 0.0),
            ..view
        }
    }

    /// Returns the grooves of `pattern`.
    #[inline]
    fn grooves<T: Tables + ?Sized>(&self, tables: &T, pattern: &Pattern) -> Grooves {
        let View {
            mesh, cap, rate, ..
        } = self;
        let finish = tables.finish(finish_of(cap));
        Grooves::new(finish, mesh, cap.unit, *rate, pattern)
    }

    /// Returns the place on the ray at the depth fraction `depth_fraction` above or below `cap`, on a
    /// surface that faces as the mesh does.
    #[inline]
    fn at_depth<T: Tables + ?Sized>(&self, tables: &T, depth_fraction: Real) -> Sample {
        let View {
            mesh, cap, rate, ..
        } = self;
        let finish = tables.finish(finish_of(cap));
        let (along, across) = per_depth(mesh, self.direction);
        let down = (depth_fraction - cap.depth_fraction) * finish.depth * cap.unit;
        Sample {
            class: if depth_fraction > 0.0 {
                CLASS_FLOOR
            } else {
                CLASS_CAP
            },
            t: max(cap.t + down * along, 0.0),
            uv: cap.uv + across * *rate * down,
            depth_fraction,
            normal: mesh.normal,
            tangent: mesh.along_u,
            is_mirrored: mesh.is_mirrored,
            is_along_v: false,
            openness: 1.0,
            ..*cap
        }
    }
}

/// Returns how far the ray along `direction` goes per unit of depth below `mesh`: along itself, and
/// along the mesh.
#[inline]
fn per_depth(mesh: &MeshFrame, direction: Vec3) -> (Real, Vec2) {
    let inverse = div(1.0, max(-kept(mesh.normal.dot(direction)), LEAST_COSINE));
    let along = Vec2::new(
        kept(mesh.along_u.dot(direction)),
        kept(mesh.along_v().dot(direction)),
    );
    (inverse, along * inverse)
}

/// Returns how even the mesh is around pixel (`x`, `y`), which hits something: 1 where it faces the
/// ray as the pixels beside do, 0 where it turns away within a pixel.
#[inline]
fn evenness<H: Hits + ?Sized>(frame: &Frame, hits: &H, (x, y): (u32, u32)) -> Real {
    // All for the same ray: then a plane is even in perspective, too.
    let ray = pixel_ray(frame, x, y);
    let facing = |x: u32, y: u32| -kept(hits.mesh(x, y).normal.dot(ray));
    let (finish, own) = (hits.sample(x, y).finish, facing(x, y));
    let mut most = max(own, 1e-6);
    let mut side = 0;
    while side < 4 {
        let step = if side & 1 == 0 { 1 } else { -1 };
        let x = x as i32 + if side < 2 { step } else { 0 };
        let y = y as i32 + if side < 2 { 0 } else { step };
        let [width, height] = frame.size;
        if x >= 0 && y >= 0 && x < width as i32 && y < height as i32 {
            let (x, y) = (x as u32, y as u32);
            let beside = hits.sample(x, y);
            if beside.class != CLASS_MISS && beside.finish == finish {
                most = max(most, facing(x, y));
            }
        }
        side += 1;
    }
    clamp((div(own, most) - TURNS) * TURNS_SCALE, 0.0, 1.0)
}

/// Returns the pattern around pixel (`x`, `y`), which shares of it are seen, and how much of the
/// mean is.
#[inline]
fn pattern<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    hits: &H,
    at_pixel: (u32, u32),
    view: &View,
) -> (Pattern, Seen, Real) {
    let View {
        mesh, cap, rate, ..
    } = view;
    let rate = *rate;
    let finish = tables.finish(finish_of(cap));
    let [right, down] = on_plane(frame, view.direction, cap.t, mesh.normal, LEAST_COSINE);
    let along_v = mesh.along_v();
    let on_mesh = |side: Vec3| Vec2::new(kept(mesh.along_u.dot(side)), kept(along_v.dot(side)));
    let footprint = Footprint {
        right: on_mesh(right),
        down: on_mesh(down),
    };
    let pixel = footprint.longest();
    let (_, along) = per_depth(mesh, view.direction);
    let way = along * finish.depth * cap.unit;
    let longer = 1.0 + div(sqrt(kept(way.dot(way))), max(pixel, 1e-12));
    let mut pattern = Pattern::NONE;
    let mut weight = 0.0;
    let mut cap_share = 1.0;
    let mut which = 0;
    let gap = gap(finish, rate);
    let is_only = gbuffer::is_mean_only(hits.words(at_pixel.0, at_pixel.1).1);
    let mut end = if !is_only && pixel * MOST_UNEVEN < gap {
        0
    } else {
        1
    };
    while which < end {
        // Sides and floor are seen on the way down. The cap is that of the pixel.
        let is_cap = which == 1;
        let at = if is_cap {
            cap.uv
        } else {
            cap.uv + way * rate * 0.5
        };
        let scale = if is_cap { rate } else { rate * longer };
        let found = sample_over(tables, &finish.chart.image, at, &footprint.scaled(scale));
        if is_cap {
            cap_share = clamp(found.x, 0.0, 1.0);
        } else {
            pattern = Pattern::new(found, texels(finish, rate), finish.chart.order);
            // The cap is known to the pixel; what lies in the grooves is not.
            let width = pattern.width.x;
            let of = |pixel: Real| clamp(div(pixel, width) - 1.0, 0.0, 1.0);
            let begins = clamp(div(pixel * MOST_UNEVEN, max(gap, 1e-12)) - 1.0, 0.0, 1.0);
            weight = if is_only { 1.0 } else { of(pixel) * begins };
            if weight > 0.0 {
                end = 2;
            }
            let least = of(footprint.narrowest()) * begins;
            if !is_only && least < weight {
                weight = max(least, weight * evenness(frame, hits, at_pixel));
            }
        }
        which += 1;
    }
    let grooves = view.grooves(tables, &pattern);
    let sides = grooves.sides(view.direction);
    let first = div(sides.x, pattern.width.x);
    let second = div(sides.y, pattern.width.y);
    let side = (1.0 - cap_share) * (1.0 - grooves.left(first, second));
    let first = div(first, max(first + second, 1e-12)) * side;
    let seen = Seen {
        cap: cap_share,
        sides: Vec2::new(first, max(side - first, 0.0)),
        away: grooves.away(view.direction),
    };
    (pattern, seen, weight)
}

/// Returns the linear RGB of the mean that pixel (`x`, `y`) shows, and how much of it is seen, 0…1.
#[inline]
fn mean<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    hits: &H,
    at: (u32, u32),
) -> (Vec3, Real) {
    let (mut rgb, mut total, mut weight) = (Vec3::ZERO, 0.0, 0.0);
    // Of no light yet.
    let mut visible = (u32::MAX, 0.0);
    let mut pattern = Pattern::NONE;
    let mut seen = Seen {
        cap: 1.0,
        sides: Vec2::ZERO,
        away: Vec2::ZERO,
    };
    let (mut step, mut end) = (FIND, 1);
    while step < end {
        let share = if step > FIND {
            seen.share(step)
        } else if may_be_seen(tables, frame, hits, at) {
            1.0
        } else {
            0.0
        };
        if share > 0.0 {
            // Read again for each part, so that it takes no registers meanwhile.
            let hit = hits.sample_on_mesh(at.0, at.1);
            let direction = pixel_ray(frame, at.0, at.1);
            let view = View::new(tables, direction, hits.mesh(at.0, at.1), &hit);
            if step == FIND {
                let found = self::pattern(tables, frame, hits, at, &view);
                (pattern, seen, weight) = found;
                if weight > 0.0 {
                    end = STEPS;
                }
            } else {
                let grooves = view.grooves(tables, &pattern);
                let light = part(tables, frame, lighting, &view, &grooves, step, &mut visible);
                let share = share * mixed(lighting, light);
                rgb += light * share;
                total += share;
            }
        }
        step += 1;
    }
    (rgb * div(1.0, max(total, 1e-12)), weight)
}

/// Returns the light of the part of `grooves` that `step` shades. `visible` keeps the index of the last light
/// and the share of it that arrives at the cap, which is the same for all parts.
#[inline]
fn part<T: Tables + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    view: &View,
    grooves: &Grooves,
    step: u32,
    visible: &mut (u32, Real),
) -> Vec3 {
    let View {
        direction,
        mesh,
        cap,
        ..
    } = *view;
    let (is_cap, is_floor) = (step == CAP, step == FLOOR);
    let (is_second, is_away) = (is_second(step), is_away(step));
    let finish = tables.finish(finish_of(&cap));
    let down = if is_cap {
        0.0
    } else if is_floor {
        1.0
    } else {
        0.5 * grooves.deepest(is_second)
    };
    let hit = view.at_depth(tables, down);
    let hit = if is_cap {
        hit
    } else if is_floor {
        Sample {
            openness: grooves.floor_openness(),
            ..hit
        }
    } else {
        grooves.side(direction, is_second, is_away, &mesh, &hit, finish.side)
    };
    let on_cap = vec3(frame.eye) + direction * cap.t;
    let arriving = |light: &Light, index: u32, incoming: &Incoming, _| {
        let own = if is_cap || light.shadows == 0 {
            1.0
        } else {
            let lift = lights::lift(tables, light, on_cap);
            grooves.lit(direction, is_floor, is_second, incoming, lift)
        };
        if visible.0 != index {
            *visible = (
                index,
                lights::arriving(tables, light, on_cap, grooves.normal),
            );
        }
        own * visible.1
    };
    shade_under(tables, frame, lighting, direction, &hit, !is_cap, arriving)
}
