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

use super::edges::pixel::growth_across;
use super::edges::{Shares, from_code};
use super::image::{Footprint, sample_over};
use super::layout::{Finish, Light, Lighting};
use super::lights::{self, Incoming};
use super::material::finish_of;
use super::{Tables, shade_under};
use crate::arithmetic::{abs, clamp, div, kept, kept3, max, min, normalize_or, sqrt};
use crate::camera::{on_plane, pixel_ray};
use crate::contract::check3;
use crate::gbuffer::{Hits, MeshFrame, Sample};
use crate::layout::{Frame, vec2, vec3};
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR, CLASS_MISS};
use crate::trace::word;
use crate::{Real, Vec2, Vec3};
use glam::{UVec4, Vec4};

/// Largest xx or yy of a texel of the chart, and twice the largest xy: what is larger is cut off.
pub const MOST: Real = 1.5;
/// Least cosine between the mesh and the direction to the eye or to a light.
const LEAST_COSINE: Real = 0.02;
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
/// Least outline per area, and least share of an area.
const LEAST: Real = 1e-4;
/// How much of what both families hide is hidden twice: all in square holes, nothing around
/// square parts.
const BOTH: Real = 0.75;
/// Mean of |cos| over all directions.
const EVEN: Real = core::f32::consts::FRAC_2_PI;
/// Cosine and sine of how far two directions are from that to the eye, which have the mean square of the
/// cosine of all sides of a round groove that are seen: 2 / 3.
const EVEN_SIDE: (Real, Real) = (0.816_496_6, 0.577_350_3);

/// The pattern around a pixel as two families of straight grooves. Lengths are world units.
#[derive(Clone, Copy, Debug)]
struct Pattern {
    /// Unit normal of the outlines of the first family, along growing u and v on the mesh; that of
    /// the second one is across.
    first: Vec2,
    /// How much the families differ: 0 where the outline runs in all directions alike, 1 where
    /// all of it is of the first family.
    order: Real,
    /// Width of the grooves of each family, if those of the other one take no place.
    width: Vec2,
}

/// Which shares of an area are seen; the rest is floor.
#[derive(Clone, Copy, Debug)]
struct Seen {
    cap: Real,
    /// Of the grooves of each family.
    sides: Vec2,
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

/// The grooves at a pixel. Two-dimensional vectors lie on the mesh, across those of each family.
#[derive(Clone, Copy, Debug)]
struct Grooves {
    /// Unit normal of the mesh, world axes.
    normal: Vec3,
    /// Unit direction across the grooves of the first family.
    first: Vec3,
    /// See [`Pattern`].
    order: Real,
    width: Vec2,
    depth: Real,
    /// How far sides of each family grow towards the middle of a groove.
    growth: Vec2,
    /// Width of a groove from side to side.
    gap: Real,
}

/// Number of steps. The first one finds the pattern; each of the others shades a part of it.
const STEPS: u32 = 7;
const FIND: u32 = 0;
const CAP: u32 = 1;
/// The sides of the first family that face the eye, and those that face away; then those of the
/// second one.
const SIDES: u32 = 2;
const FLOOR: u32 = 6;

/// Returns the words of pixel (`x`, `y`) of a picture with smooth edges, where the mean of a pattern
/// is seen instead of what the pixel hits: not at all where the grooves of the pattern are wider than
/// the pixel, nothing else where the pixel is twice as wide as they are. Hits know the mesh, and
/// `color` returns the words of the pixel by [`words_with_edges`](super::words_with_edges).
#[inline]
pub fn words<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    at: (u32, u32),
    hits: &H,
    color: impl FnOnce() -> UVec4,
) -> UVec4 {
    let (mean, weight) = mean(tables, frame, lighting, hits, at);
    let found = color();
    if weight > 0.0 {
        let mean = kept3(mean);
        check3(mean);
        let own = |word: u32| f32::from_bits(word) * (1.0 - weight);
        let own = Vec3::new(own(found.x), own(found.y), own(found.z));
        let rgb = kept3(own + mean * weight);
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
    if finish.chart.levels == 0 {
        return false;
    }
    let facing = -kept(hits.mesh(x, y).normal.dot(pixel_ray(frame, x, y)));
    // No side of the footprint is longer than a side of a pixel that is tilted along it.
    let (right, down) = (vec3(frame.ray_right), vec3(frame.ray_down));
    let side = sqrt(max(right.dot(right), down.dot(down)));
    let pixel = div(side * hit.t, max(facing, LEAST_COSINE));
    pixel * MOST_UNEVEN > gap(finish, density(tables, finish, &hit))
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

/// Returns texels of the chart of `finish` per world unit along u and v, where `rate` repeats of the
/// pattern are.
#[inline]
fn texels(finish: &Finish, rate: Vec2) -> Vec2 {
    let chart = &finish.chart;
    rate * Vec2::new(chart.width as i32 as Real, chart.height as i32 as Real)
}

/// Returns the mean width of the pattern's gaps, world units, where `rate` repeats of it are a world unit
/// along u and v.
#[inline]
fn gap(finish: &Finish, rate: Vec2) -> Real {
    let texels = texels(finish, rate);
    div(finish.gap, max(sqrt(texels.x * texels.y), 1e-12))
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

/// Returns repeats of the pattern per world unit along u and v at `hit`.
#[inline]
fn density<T: Tables + ?Sized>(tables: &T, finish: &Finish, hit: &Sample) -> Vec2 {
    let facet = tables.facet(finish.first_facet + hit.facet);
    vec2(facet.density) * div(1.0, max(hit.unit, 1e-12))
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
    let mut end = if pixel * MOST_UNEVEN < gap { 0 } else { 1 };
    while which < end {
        // Sides and floor are seen on the way down. The cap is that of the pixel.
        let is_cap = which == 1;
        let at = if is_cap {
            cap.uv
        } else {
            cap.uv + way * rate * 0.5
        };
        let scale = if is_cap { rate } else { rate * longer };
        let found = sample_over(tables, &finish.chart, at, &footprint.scaled(scale));
        if is_cap {
            cap_share = clamp(found.x, 0.0, 1.0);
        } else {
            pattern = Pattern::new(found, texels(finish, rate));
            // The cap is known to the pixel; what lies in the grooves is not.
            let width = pattern.width.x;
            let of = |pixel: Real| clamp(div(pixel, width) - 1.0, 0.0, 1.0);
            let begins = clamp(div(pixel * MOST_UNEVEN, max(gap, 1e-12)) - 1.0, 0.0, 1.0);
            weight = of(pixel) * begins;
            if weight > 0.0 {
                let even = evenness(frame, hits, at_pixel);
                weight = max(of(footprint.narrowest()) * begins, weight * even);
                end = 2;
            }
        }
        which += 1;
    }
    let grooves = Grooves::new(tables, view, &pattern);
    let sides = grooves.sides(view.direction);
    let first = div(sides.x, pattern.width.x);
    let second = div(sides.y, pattern.width.y);
    let side = (1.0 - cap_share) * (1.0 - left(first, second));
    let first = div(first, max(first + second, 1e-12)) * side;
    let seen = Seen {
        cap: cap_share,
        sides: Vec2::new(first, max(side - first, 0.0)),
    };
    (pattern, seen, weight)
}

impl Pattern {
    /// What takes the place of a pattern that is not seen.
    const NONE: Pattern = Pattern {
        first: Vec2::X,
        order: 0.0,
        width: Vec2::ONE,
    };

    /// Returns that of a texel of the chart, of which `texels` are a world unit along u and v.
    #[inline]
    fn new(texel: Vec4, texels: Vec2) -> Pattern {
        let xx = texel.y * MOST * texels.x;
        let yy = texel.z * MOST * texels.y;
        let xy = (texel.w - 0.5) * MOST * sqrt(texels.x * texels.y);
        // The eigenvectors, of the matrix over its trace.
        let outline = xx + yy;
        let inverse = div(1.0, max(outline, 1e-12));
        let difference = 0.5 * (xx - yy) * inverse;
        let mixed = xy * inverse;
        let half_order = min(sqrt(difference * difference + mixed * mixed), 0.5);
        let cosine = clamp(div(difference, max(half_order, 1e-6)), -1.0, 1.0);
        let second = sqrt(max(0.5 - 0.5 * cosine, 0.0));
        let groove = max(1.0 - texel.x, LEAST);
        // Each family has some outline, so that its grooves have a width.
        let width = |share: Real| div(2.0 * groove, max(share, LEAST) * outline + 1e-12);
        Pattern {
            first: Vec2::new(
                sqrt(max(0.5 + 0.5 * cosine, 0.0)),
                if mixed < 0.0 { -second } else { second },
            ),
            order: 2.0 * half_order,
            width: Vec2::new(width(0.5 + half_order), width(0.5 - half_order)),
        }
    }
}

/// Returns the share of a floor that is left where the grooves of either family hide these shares of
/// it: between that of holes, where some is hidden twice, and that around parts that stand apart.
#[inline]
fn left(first: Real, second: Real) -> Real {
    let [first, second] = [min(first, 1.0), min(second, 1.0)];
    max(1.0 - first - second + BOTH * first * second, 0.0)
}

impl Grooves {
    /// Returns those of `pattern` in `view`.
    #[inline]
    fn new<T: Tables + ?Sized>(tables: &T, view: &View, pattern: &Pattern) -> Grooves {
        let View {
            mesh, cap, rate, ..
        } = view;
        let finish = tables.finish(finish_of(cap));
        let Pattern {
            first,
            order,
            width,
        } = *pattern;
        Grooves {
            normal: mesh.normal,
            first: mesh.along_u * first.x + mesh.along_v() * first.y,
            order,
            width,
            depth: finish.depth * cap.unit,
            growth: Vec2::new(
                growth_across(finish, *rate, first.x),
                growth_across(finish, *rate, first.y),
            ),
            gap: max(gap(finish, *rate), 1e-12),
        }
    }

    /// Returns how far the ray along `direction` goes along the mesh per unit of depth.
    #[inline]
    fn along(&self, direction: Vec3) -> Vec2 {
        let inverse = div(1.0, max(-kept(self.normal.dot(direction)), LEAST_COSINE));
        let second = self.normal.cross(self.first);
        let along = Vec2::new(kept(self.first.dot(direction)), kept(second.dot(direction)));
        along * inverse
    }

    /// Returns how far a ray that goes `along` the mesh per unit of depth is shifted by the depth,
    /// across the grooves of each family.
    #[inline]
    fn shift(&self, along: Vec2) -> Vec2 {
        let even = EVEN * (1.0 - self.order) * sqrt(kept(along.dot(along)));
        let across = |along: Real| (even + self.order * abs(along)) * self.depth;
        Vec2::new(across(along.x), across(along.y))
    }

    /// Returns down to which part of the depth sides of one family reach: they meet there if they lean
    /// enough.
    #[inline]
    fn deepest(&self, is_second: bool) -> Real {
        let growth = of_family(self.growth, is_second);
        min(div(self.gap, max(2.0 * growth, 1e-12)), 1.0)
    }

    /// Returns how wide both sides of a groove of each family are, as seen along `direction`.
    #[inline]
    fn sides(&self, direction: Vec3) -> Vec2 {
        let shift = self.shift(self.along(direction));
        let width = |shift: Real, growth: Real| growth + max(growth, shift);
        Vec2::new(width(shift.x, self.growth.x), width(shift.y, self.growth.y))
    }

    /// Returns the share of what is seen of the sides of one family along `direction` that faces away
    /// from the eye: something, if they lean back by more than it looks from the side.
    #[inline]
    fn away(&self, direction: Vec3, is_second: bool) -> Real {
        let shift = of_family(self.shift(self.along(direction)), is_second);
        let growth = of_family(self.growth, is_second);
        div(max(growth - shift, 0.0), max(2.0 * growth, 1e-12))
    }

    /// Returns the sides of one family that face the eye, which looks along `direction`, or away from
    /// it, at the place `half_way` down.
    #[inline]
    fn side(
        &self,
        direction: Vec3,
        is_second: bool,
        is_away: bool,
        mesh: &MeshFrame,
        half_way: &Sample,
        class: u32,
    ) -> Sample {
        let (gap, depth) = (self.gap, self.depth);
        let along = self.along(direction);
        let length = sqrt(kept(along.dot(along)));
        let towards = -along * div(1.0, max(length, 1e-12));
        let faces = if is_second { towards.y } else { towards.x };
        let sign = if faces < 0.0 { -1.0 } else { 1.0 };
        // What runs in all directions faces the eye from both sides.
        let beside = Vec2::new(-towards.y, towards.x);
        let beside = if of_family(beside, is_second) * sign < 0.0 {
            -beside
        } else {
            beside
        };
        let own = sign * self.order;
        let even = (towards * EVEN_SIDE.0 + beside * EVEN_SIDE.1) * (1.0 - self.order);
        let facing = if is_second {
            Vec2::new(even.x, even.y + own)
        } else {
            Vec2::new(even.x + own, even.y)
        };
        let facing = if is_away { -facing } else { facing };
        let second = self.normal.cross(self.first);
        let upright = normalize_or(self.first * facing.x + second * facing.y, self.first);
        let lean = div(of_family(self.growth, is_second), max(depth, 1e-12));
        let normal = normalize_or(upright + self.normal * lean, upright);
        let is_along_v = abs(upright.dot(mesh.along_u)) > abs(upright.dot(mesh.along_v()));
        let deep = depth * self.deepest(is_second);
        let sky = 0.5 - 0.5 * div(deep, sqrt(gap * gap + deep * deep) + gap);
        let side = Sample {
            class,
            normal,
            openness: if class == CLASS_BEVEL {
                0.5 + 0.5 * sky
            } else {
                0.25 + 0.5 * sky
            },
            ..*half_way
        };
        side.along_outline(mesh, self.normal.cross(upright), is_along_v)
    }

    /// Returns the share of the sky that the floor sees, 0…1.
    #[inline]
    fn floor_openness(&self) -> Real {
        let depth = self.depth;
        let open = |width: Real| div(width, sqrt(width * width + depth * depth) + depth);
        open(self.width.x) * open(self.width.y)
    }

    /// Returns the share of what is seen of the floor or of the sides of one family along `direction`
    /// that `incoming` light reaches, where shadows are looked up at this distance above surfaces.
    #[inline]
    fn lit(
        &self,
        direction: Vec3,
        is_floor: bool,
        is_second: bool,
        incoming: &Incoming,
        lift: Real,
    ) -> Real {
        let eye = self.along(direction);
        let light = self.along(-incoming.direction);
        let (seen, lit) = (self.shift(eye), self.shift(light));
        if is_floor {
            // How much of the shadow lies where the eye does not see: all of it if both look from
            // the same side.
            let lengths = sqrt(kept(eye.dot(eye)) * kept(light.dot(light)));
            let even = clamp(div(kept(eye.dot(light)), max(lengths, 1e-12)), 0.0, 1.0);
            let shallower = max(1.0 - div(lift, max(self.depth, 1e-12)), 0.0);
            let hidden = |eye: Real, light: Real, seen: Real, lit: Real, is_second: bool| {
                let growth = of_family(self.growth, is_second);
                let width = of_family(self.width, is_second);
                let is_same = (eye < 0.0) == (light < 0.0);
                let same = even + self.order * (if is_same { 1.0 } else { 0.0 } - even);
                let foot = div(1.0, max(width - 2.0 * growth, 1e-12));
                let seen = max(seen - growth, 0.0);
                let lit = max(lit * shallower - growth, 0.0);
                let apart = seen + lit;
                let both = apart + (max(seen, lit) - apart) * same;
                Vec2::new(seen * foot, both * foot)
            };
            let first = hidden(eye.x, light.x, seen.x, lit.x, false);
            let second = hidden(eye.y, light.y, seen.y, lit.y, true);
            let seen = max(left(first.x, second.x), 1e-6);
            min(div(left(first.y, second.y), seen), 1.0)
        } else {
            let gap = max(self.gap - lift, 0.0);
            let (seen, lit) = (of_family(seen, is_second), of_family(lit, is_second));
            // Down to which part of the depth, in straight grooves and in round ones.
            let growth = of_family(self.growth, is_second);
            let deepest = self.deepest(is_second);
            let deep = |gap: Real, shift: Real| min(div(gap, max(shift + growth, 1e-12)), deepest);
            let straight = min(div(deep(gap, lit), deep(self.gap, seen)), 1.0);
            let round = div(2.0 * self.gap + seen, 2.0 * self.gap + seen + lit);
            round + (straight - round) * self.order
        }
    }
}

/// Returns what `of_both` says of one family.
#[inline]
fn of_family(of_both: Vec2, is_second: bool) -> Real {
    if is_second { of_both.y } else { of_both.x }
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
    let (mut rgb, mut weight) = (Vec3::ZERO, 0.0);
    let mut pattern = Pattern::NONE;
    let mut seen = Seen {
        cap: 1.0,
        sides: Vec2::ZERO,
    };
    let (mut step, mut end) = (FIND, 1);
    while step < end {
        if step > FIND || may_be_seen(tables, frame, hits, at) {
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
                let grooves = Grooves::new(tables, &view, &pattern);
                rgb += part(tables, frame, lighting, &view, &grooves, &seen, step);
            }
        }
        step += 1;
    }
    (rgb, weight)
}

/// Returns what the part of `grooves` that `step` shades adds to the mean.
#[inline]
fn part<T: Tables + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    view: &View,
    grooves: &Grooves,
    seen: &Seen,
    step: u32,
) -> Vec3 {
    let View {
        direction,
        mesh,
        cap,
        ..
    } = *view;
    let (is_cap, is_floor) = (step == CAP, step == FLOOR);
    let (is_second, is_away) = (step > SIDES + 1, (step - CAP) & 1 == 0);
    let share = if is_cap {
        seen.cap
    } else if is_floor {
        1.0 - seen.cap - seen.sides.x - seen.sides.y
    } else {
        let away = grooves.away(direction, is_second);
        of_family(seen.sides, is_second) * if is_away { away } else { 1.0 - away }
    };
    if share <= 0.0 {
        return Vec3::ZERO;
    }
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
    let arriving = |light: &Light, incoming: &Incoming, _| {
        let own = if is_cap || light.shadows == 0 {
            1.0
        } else {
            let lift = lights::lift(tables, light, on_cap);
            grooves.lit(direction, is_floor, is_second, incoming, lift)
        };
        own * lights::arriving(tables, light, on_cap, grooves.normal)
    };
    shade_under(tables, frame, lighting, direction, &hit, arriving) * share
}
