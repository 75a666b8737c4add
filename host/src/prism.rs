//! The curved prisms of the accurate tier as renderers read them: in f32, with
//! bounds that hold for the rounded numbers.

use glam::DVec3;
use relievo_shared::contract::LARGEST;
use relievo_shared::layout::{NO_NEIGHBOUR, PrismData, Slab};

use crate::mesh::{FOLDED, MeshPrism, Quadratic};

/// Margin of bounds, as a share of their extent.
const SHARE_MARGIN: f64 = 1e-3;
/// Margin of bounds, as a share of the triangle's longest edge.
const EDGE_MARGIN: f64 = 1e-4;
/// Margin of bounds, as a share of the anchor's coordinates, since neighbours round
/// theirs differently.
const ANCHOR_MARGIN: f64 = 4e-7;

/// Margin of the sine of the normals' spread, for the rounding errors of the
/// renderers.
const SPREAD_MARGIN: f64 = 1e-5;

/// Smaller coefficients are rounding errors and are set to 0 (2⁻⁶⁰): their products
/// would not be normal numbers in f32.
const SMALLEST: f64 = 8.673_617_379_884_035e-19;

/// So are those that are less than this share of what they are parts of (2⁻⁴⁰): the curvature of
/// a plane that is turned.
const ROUNDING_ERROR: f64 = 9.094_947_017_729_282e-13;

/// `prism` as renderers read it, `depth` object units deep, relative to
/// `origin`, with the texture coordinates `uv` of its corners in repeats.
///
/// Bounds hold the prism of the rounded coefficients, with margins for the
/// arithmetic of renderers. Everything is finite, also for a sliver.
pub fn narrow_prism(prism: &MeshPrism, uv: [[f32; 2]; 3], depth: f64, origin: DVec3) -> PrismData {
    let edges = edges(prism);
    let longest = edges.map(DVec3::length).into_iter().fold(0.0, f64::max);
    let unit = |v: DVec3| narrow(v, 1.0);
    let anchor = alone(prism.anchor - origin);
    let surface = prism.surface.map(|v| narrow(v, longest));
    let normal = prism.normal.map(unit);
    let rounded = MeshPrism {
        surface: surface.map(widen),
        normal: normal.map(widen),
        ..*prism
    };

    let area_normal = prism.area_normal();
    let facet_normal = area_normal.normalize_or(DVec3::Z);
    let facet = unit(facet_normal);
    let fixed_margin = EDGE_MARGIN * longest + ANCHOR_MARGIN * widen(anchor).abs().max_element();

    let [cap_hull, floor_hull] = hull(&rounded, depth);
    let is_open = prism.neighbours.contains(&NO_NEIGHBOUR);
    let all = || cap_hull.into_iter().chain(floor_hull);
    let slab = |axis: DVec3, has_width_one: bool| {
        let points = all().take(if is_open { 12 } else { 6 });
        let (low, high) = extent(points, axis);
        // More than the errors of the rounded axis.
        let margin = SHARE_MARGIN * (high - low) + fixed_margin;
        let (low, high) = (low - margin, high + margin);
        let scale = if has_width_one {
            1.0 / (high - low)
        } else {
            1.0
        };
        Slab {
            axis: alone(axis * scale),
            low: round_down(low * scale),
            high: round_up(high * scale),
        }
    };
    let sides = edges.map(|edge| facet_normal.cross(edge).normalize_or(DVec3::X));

    let low = all().fold(DVec3::INFINITY, DVec3::min);
    let high = all().fold(DVec3::NEG_INFINITY, DVec3::max);
    let centre = alone(low.midpoint(high));
    let reach = all().map(|point| point.distance(widen(centre)));
    let radius = reach.fold(0.0, f64::max);

    let uv_change = |i: usize| [0, 1].map(|axis| uv[i][axis] - uv[0][axis]);
    PrismData {
        anchor,
        surface,
        normal,
        corner_normals: prism.corner_normals.map(unit),
        uv: [uv[0], uv_change(1), uv_change(2)],
        facet,
        least_determinant: (FOLDED * depth * prism.least_share() * area_normal.length()) as f32,
        spread: round_up(spread(&rounded.surface(), widen(facet))),
        slabs: [
            slab(facet_normal, false),
            slab(sides[0], false),
            slab(sides[1], true),
            slab(sides[2], true),
        ],
        centre,
        radius: round_up(radius + SHARE_MARGIN * radius + fixed_margin),
        // Twice the area by the longest edge.
        inverse_altitude: (longest / area_normal.length()).min(f64::from(LARGEST)) as f32,
        neighbours: prism.neighbours,
    }
}

/// Returns points whose convex hull contains the cap, and points such that the hull of
/// both contains the whole prism.
fn hull(prism: &MeshPrism, depth: f64) -> [[DVec3; 6]; 2] {
    let cap = prism.surface().bezier();
    let out = prism.normal().bezier();
    let floor = std::array::from_fn(|i| cap[i] - depth * out[i]);
    [cap, floor]
}

/// The edges opposite to the corners, as the triangle runs through them.
fn edges(prism: &MeshPrism) -> [DVec3; 3] {
    let [a, b, c] = prism.corners();
    [c - b, a - c, b - a]
}

/// The least and the largest p · `axis`.
fn extent(points: impl Iterator<Item = DVec3>, axis: DVec3) -> (f64, f64) {
    points
        .map(|point| point.dot(axis))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        })
}

/// A bound of the sine of the angle between `facet` and the normals of
/// `surface`; 1 if one may be 90° away or more, or has no direction.
///
/// The normals lie in the convex cone of their Bézier points, so none is further from
/// an axis than the furthest of these points, up to 90°.
fn spread(surface: &Quadratic, facet: DVec3) -> f64 {
    let sines = surface.normal_bezier().map(|point| {
        let cosine = point.dot(facet);
        if cosine > 0.0 {
            point.cross(facet).length() / (point.length() * facet.length())
        } else {
            1.0
        }
    });
    (sines.into_iter().fold(0.0, f64::max) + SPREAD_MARGIN).min(1.0)
}

/// Rounds to f32 a part of something of this `size`.
fn narrow(v: DVec3, size: f64) -> [f32; 3] {
    let least = SMALLEST.max(ROUNDING_ERROR * size);
    v.to_array()
        .map(|x| if x.abs() < least { 0.0 } else { x as f32 })
}

/// Rounds to f32 what is no part of anything else.
fn alone(v: DVec3) -> [f32; 3] {
    narrow(v, v.abs().max_element())
}

fn widen(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// The largest f32 that is not larger.
fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x {
        rounded.next_down()
    } else {
        rounded
    }
}

/// The smallest f32 that is not smaller.
fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, MeshOptions};
    use glam::DVec2;
    use std::path::Path;

    fn asset(name: &str) -> Mesh {
        let path = format!("{}/../assets/meshes/{name}.obj", env!("CARGO_MANIFEST_DIR"));
        Mesh::load(Path::new(&path), &MeshOptions::default()).unwrap()
    }

    const UV: [[f32; 2]; 3] = [[0.25, 0.5], [1.0, 0.0], [2.0, 3.0]];
    const DEPTH: f64 = 0.1;

    /// Evenly distributed weights and fractions of a depth.
    fn samples() -> impl Iterator<Item = (DVec2, f64)> {
        (1..=40).map(|i| {
            let [a, b, c] = [0.8191725, 0.6710436, 0.5497005].map(|x| (f64::from(i) * x).fract());
            let w = DVec2::new(a, b);
            (if a + b > 1.0 { DVec2::ONE - w } else { w }, c)
        })
    }

    /// A prism as renderers see it, in f64.
    struct Wide {
        surface: Quadratic,
        normal: Quadratic,
        depth: f64,
    }

    impl Wide {
        fn new(prism: &PrismData, depth: f64) -> Self {
            let s = prism.surface.map(widen);
            Self {
                surface: Quadratic([DVec3::ZERO, s[0], s[1], s[2], s[3], s[4]]),
                normal: Quadratic(prism.normal.map(widen)),
                depth,
            }
        }

        fn point(&self, w: DVec2, fraction: f64) -> DVec3 {
            self.surface.at(w) - self.depth * fraction * self.normal.at(w)
        }
    }

    fn is_in(slab: &Slab, point: DVec3) -> bool {
        let at = point.dot(widen(slab.axis));
        at >= f64::from(slab.low) && at <= f64::from(slab.high)
    }

    /// Counts samples outside their slabs, samples outside their ball, and all samples.
    fn outside(
        prisms: &[MeshPrism],
        depth: f64,
        edit: impl Fn(&mut PrismData, &MeshPrism),
    ) -> [usize; 3] {
        let mut counts = [0; 3];
        for prism in prisms {
            let mut narrowed = narrow_prism(prism, UV, depth, DVec3::new(0.1, 0.2, -0.3));
            edit(&mut narrowed, prism);
            let wide = Wide::new(&narrowed, depth);
            let open = narrowed.neighbours.contains(&NO_NEIGHBOUR);
            for (w, fraction) in samples() {
                let held = wide.point(w, if open { fraction } else { 0.0 });
                let out = narrowed.slabs.iter().any(|slab| !is_in(slab, held));
                counts[0] += usize::from(out);
                let far = wide.point(w, fraction).distance(widen(narrowed.centre));
                counts[1] += usize::from(far > f64::from(narrowed.radius));
                counts[2] += 1;
            }
        }
        counts
    }

    #[test]
    fn slabs_and_ball_hold_the_prism() {
        for name in ["torus", "blob", "cylinder", "saddle", "plane"] {
            let prisms = asset(name).prisms();
            let [slabs, ball, count] = outside(&prisms, DEPTH, |_, _| ());
            assert_eq!([slabs, ball], [0, 0], "{name}: of {count}");
        }
        // Twins: the corners alone do not hold a curved cap, nor does the cap
        // hold an open prism, nor a smaller ball anything.
        let torus = asset("torus").prisms();
        let [slabs, ball, _] = outside(&torus, DEPTH, |narrowed, prism| {
            narrowed.radius *= 0.7;
            for slab in &mut narrowed.slabs {
                let (low, high) = extent(prism.corners().into_iter(), widen(slab.axis));
                (slab.low, slab.high) = (low as f32, high as f32);
            }
        });
        assert!(slabs > 1000 && ball > 1000, "{slabs} {ball}");
        let [slabs, ..] = outside(&asset("plane").prisms(), DEPTH, |narrowed, prism| {
            let closed = MeshPrism {
                neighbours: [0; 3],
                ..*prism
            };
            narrowed.slabs = narrow_prism(&closed, UV, DEPTH, DVec3::ZERO).slabs;
        });
        assert!(slabs > 100, "{slabs}");
    }

    #[test]
    fn no_normal_is_outside_the_spread() {
        for name in ["torus", "blob", "saddle"] {
            let (mut tightest, mut coarsest): (f64, f64) = (f64::INFINITY, 0.0);
            for prism in asset(name).prisms() {
                let narrowed = narrow_prism(&prism, UV, DEPTH, DVec3::ZERO);
                let wide = Wide::new(&narrowed, DEPTH);
                let facet = widen(narrowed.facet);
                let mut largest: f64 = 0.0;
                for (w, _) in samples() {
                    let h = 1e-4;
                    let slope = |step: DVec2| wide.surface.at(w + step) - wide.surface.at(w - step);
                    let normal = slope(h * DVec2::X).cross(slope(h * DVec2::Y)).normalize();
                    assert!(normal.dot(facet) > 0.0);
                    largest = largest.max(normal.cross(facet).length());
                }
                let spread = f64::from(narrowed.spread);
                assert!(spread < 1.0);
                tightest = tightest.min(spread - largest);
                coarsest = coarsest.max(spread);
            }
            assert!(tightest > 0.0, "{name}: {tightest:e}");
            // Twin: the bound is of use, and so is the test.
            assert!(tightest < 0.1 * coarsest, "{name}: {tightest} {coarsest}");
        }
        let [a, b, c] = [DVec3::X, DVec3::Y, DVec3::ZERO];
        // The derivative by w1 turns round on the way.
        let turning = Quadratic([c, a, b, -a, c, c]);
        assert_eq!(spread(&turning, DVec3::Z), 1.0);
        assert_eq!(
            spread(&Quadratic([c, a, b, c, c, c]), DVec3::Z),
            SPREAD_MARGIN
        );
        assert_eq!(spread(&Quadratic([c, a, a, c, c, c]), DVec3::Z), 1.0);
    }

    #[test]
    fn a_flat_prism_is_what_one_expects() {
        let prism = asset("plane").prisms()[0];
        let narrowed = narrow_prism(&prism, UV, 0.5, DVec3::X);
        assert_eq!(widen(narrowed.anchor), prism.anchor - DVec3::X);
        assert_eq!(narrowed.facet, [0.0, 1.0, 0.0]);
        assert_eq!(narrowed.uv, [[0.25, 0.5], [0.75, -0.5], [1.75, 2.5]]);
        assert_eq!(narrowed.corner_normals, [[0.0, 1.0, 0.0]; 3]);
        assert_eq!(narrowed.least_determinant, 0.5e-3);
        assert_eq!(narrowed.neighbours, prism.neighbours);
        // Half a square of side 1.
        assert!((narrowed.inverse_altitude - 2_f32.sqrt()).abs() < 1e-6);
        assert!((narrowed.slabs[0].low + 0.5).abs() < 2e-3);
    }

    #[test]
    fn slivers_stay_finite() {
        let base = asset("plane").prisms()[0];
        for (height, size) in [(1e-11, 1.0), (1e-11, 1e-12), (1e-5, 1e12), (0.0, 1.0)] {
            let [a, b] = [DVec3::X, DVec3::new(0.5, 0.0, -height)].map(|p| size * p);
            let mut prism = base;
            prism.anchor = DVec3::splat(size);
            prism.surface = [a, b, DVec3::ZERO, 1e-9 * a, DVec3::ZERO];
            let narrowed = narrow_prism(&prism, UV, 0.1 * size, DVec3::ZERO);
            let words: &[f32] = bytemuck::cast_slice(std::slice::from_ref(&narrowed));
            let (numbers, _neighbours) = words.split_at(words.len() - 3);
            let largest = numbers.iter().map(|x| x.abs()).fold(0.0, f32::max);
            assert!(
                numbers.iter().all(|x| x.is_finite()),
                "{height} {size} {narrowed:?}"
            );
            assert!(size > 1.0 || largest <= LARGEST);
            assert!(narrowed.inverse_altitude > 0.0 && narrowed.radius > 0.0);
        }
    }

    #[test]
    fn bounds_are_rounded_outwards() {
        for x in [0.1, -0.1, 1.0, 0.0, 1e-30, 1.0 / 3.0, -1e20 / 3.0] {
            let (down, up) = (f64::from(round_down(x)), f64::from(round_up(x)));
            assert!(down <= x && x <= up && up - down <= 1.2e-7 * x.abs());
        }
        assert!(f64::from(0.1_f32) > 0.1 && f64::from(round_down(0.1)) < 0.1);
    }
}
