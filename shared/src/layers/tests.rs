use super::*;
use crate::layout::FORMAT_FLOAT;
use crate::march::{END_SIDE, Limits, TOLERANCE, march};
use crate::normals::SmoothSurface;
use crate::path::{Path, test_surface};
use crate::profile::rounded::Rounded;
use crate::profile::{Growth, LAYERED, STRAIGHT, stepped::Stepped};
use crate::shape_map::tests::{FORMS, Random, Sample};
use crate::stack::{Layer, Stacked};

/// A layer, and its pattern.
struct Part {
    sample: Sample,
    object: Object,
    layer: Layer,
}

impl Part {
    fn new(sample: Sample, range: [Real; 2], growth: [Real; 3], profile: u32) -> Part {
        let object = Object {
            extension: growth[0],
            bevel: growth[1],
            chamfer: growth[2],
            profile,
            parts: 3,
            ..sample.object
        }
        .complete();
        let [top, bottom] = range;
        let layer = Layer {
            top,
            bottom,
            inverse_extent: 1.0 / (bottom - top),
            profile: Profile::new(&object),
        };
        Part {
            sample,
            object,
            layer,
        }
    }

    /// Distance to the pattern less the radius, or how far the point is above or below the layer,
    /// `slope` texels per unit of δ, as equations.
    fn gap(&self, slope: f64, uv: Vec2, depth_fraction: f64) -> f64 {
        let [x, y] = self.sample.texel_of([f64::from(uv.x), f64::from(uv.y)]);
        let [top, bottom] = [self.layer.top, self.layer.bottom].map(f64::from);
        let own = ((depth_fraction - top) / (bottom - top)).clamp(0.0, 1.0);
        let radius = f64::from(self.layer.profile.radius(own as Real));
        let beside = self.sample.at(x, y) - radius;
        let above = if top > 0.0 {
            top - depth_fraction
        } else {
            -1.0
        };
        let below = if bottom < 1.0 {
            depth_fraction - bottom
        } else {
            -1.0
        };
        beside.max(slope * above).max(slope * below)
    }
}

/// The object and the words of `parts`, with `slope` texels per unit of δ.
fn stack(parts: &[Part], slope: Real) -> (Object, Vec<u32>) {
    let first = &parts[0].object;
    let mut words = parts[0].sample.words.clone();
    for (number, part) in parts.iter().enumerate() {
        let color = |i: usize| [(9 * number + i) as f32, 0.5, 1.0];
        let colors = [color(0), color(3), color(6)].concat();
        words.extend(part.layer.record(number as u32, colors.try_into().unwrap()));
    }
    let object = Object {
        extension: 0.0,
        bevel: slope / first.map_size[0],
        chamfer: 0.0,
        profile: LAYERED,
        parts: parts.len() as u32,
        ..*first
    };
    (object.complete(), words)
}

/// A straight line through the shell, up or down.
struct Line {
    uv: Vec2,
    velocity: Vec2,
    first: Real,
    rate: Real,
}

impl Path for Line {
    fn uv(&self, s: Real) -> Vec2 {
        self.uv + self.velocity * s
    }
    fn depth_fraction(&self, s: Real) -> Real {
        self.first + self.rate * s
    }
    fn uv_rates(&self) -> (Vec2, Vec2) {
        (self.velocity, self.velocity)
    }
    fn is_even(&self) -> bool {
        true
    }
    fn depth_rate(&self) -> Real {
        self.rate.abs()
    }
    fn start(&self) -> Real {
        0.0
    }
    fn end(&self) -> Real {
        let way = if self.rate > 0.0 {
            1.0 - self.first
        } else {
            self.first
        };
        way / self.rate.abs()
    }
    fn ends_on_floor(&self) -> bool {
        self.rate > 0.0
    }
}

const LIMITS: Limits = Limits {
    linear_steps: 4_000,
    binary_steps: 0,
    slack: 0.0,
};

/// A pattern of `width` × 12 texels: a few rectangles.
fn pattern(random: &mut Random, width: usize) -> Vec<bool> {
    let mut pattern = vec![false; width * 12];
    for _ in 0..random.whole(1, 3) {
        let [left, top] = [random.whole(0, width as u32 - 1), random.whole(0, 11)];
        let [right, bottom] = [left + random.whole(1, 9), top + random.whole(1, 6)];
        for (i, is_pattern) in pattern.iter_mut().enumerate() {
            let [x, y] = [(i % width) as u32, (i / width) as u32];
            *is_pattern |= (left..right).contains(&x) && (top..bottom).contains(&y);
        }
    }
    pattern
}

#[test]
fn the_march_ends_at_the_first_layer_on_the_way() {
    let mut random = Random(7);
    let mut faces = [0; 5];
    for _ in 0..4_000 {
        let width = random.choose(&[4usize, 12, 40]);
        let form = random.choose(&FORMS[..4]);
        let patterns = (0..random.whole(1, 4)).map(|_| pattern(&mut random, width));
        let patterns: Vec<Vec<bool>> = patterns.collect();
        let parts: Vec<Part> = Sample::stacked(width, &patterns, form)
            .into_iter()
            .map(|sample| {
                let top = random.choose(&[0.0, 0.3, 0.6]);
                let bottom = random.choose(&[1.0, 1.0, 0.8]);
                let spread = 1.0 / width as f64;
                let growth = [
                    (random.within(-0.5, 1.0) * spread) as Real,
                    (random.choose(&[0.0, 1.0]) * random.within(0.2, 6.0) * spread) as Real,
                    random.choose(&[1.0, 0.5]),
                ];
                let profile = random.choose(&[STRAIGHT, Rounded::NUMBER, Stepped::NUMBER]);
                Part::new(sample, [top, bottom], growth, profile)
            })
            .collect();
        let steepest = parts
            .iter()
            .map(|part| part.layer.profile.largest_slope() * part.layer.inverse_extent)
            .fold(random.within(2.0, 20.0) as Real, Real::max);
        let (object, words) = stack(&parts, steepest);
        let down = random.choose(&[true, true, false]);
        let rate = random.magnitude(0.05, 1.0) as Real;
        let line = Line {
            uv: Vec2::new(
                random.within(0.0, 1.0) as Real,
                random.within(0.0, 1.0) as Real,
            ),
            velocity: Vec2::new(
                random.within(-1.0, 1.0) as Real,
                random.within(-1.0, 1.0) as Real,
            ),
            first: if down { 0.0 } else { 0.95 },
            rate: if down { rate } else { -rate },
        };
        let map = ShapeMap::new(&object);
        let texels = Stacked(&words[..]);
        let profile = Profile::new(&object);
        let found = march(&line, &profile, &map, &texels, &LIMITS);
        let gap = |s: f64| {
            let s = s as Real;
            let depth_fraction = f64::from(line.depth_fraction(s).clamp(0.0, 1.0));
            let gaps = parts
                .iter()
                .map(|part| part.gap(f64::from(steepest), line.uv(s), depth_fraction));
            gaps.fold(f64::INFINITY, f64::min)
        };
        let end = f64::from(found.s);
        // A path may start inside.
        for i in 1..400 {
            let s = end * f64::from(i) / 400.0;
            assert!(
                end == 0.0 || gap(s) > -2e-3,
                "inside at {s} of {end}: {} {found:?}",
                gap(s)
            );
        }
        let (class, layer) = class_of(&found, &object, &texels);
        faces[class as usize] += 1;
        assert!(found.steps < LIMITS.linear_steps, "{found:?}");
        if found.end == END_SIDE || found.end == END_CAP {
            // A profile's own gap may be less than the distance beside it.
            let own = parts[layer as usize].layer;
            let (beside, above) = own.faces(
                steepest,
                map.of_layer(layer).distance(&texels, found.uv),
                found.depth_fraction,
            );
            assert!(max(beside, above) <= TOLERANCE + 1e-4);
        }
    }
    // Every face was met.
    assert!(faces[1..].iter().all(|&count| count > 50), "{faces:?}");
}

#[test]
fn one_layer_over_the_whole_depth_is_the_object_without_layers() {
    let mut random = Random(3);
    for profile in [STRAIGHT, Rounded::NUMBER, Stepped::NUMBER] {
        let sample = Sample::of_pattern(40, &pattern(&mut random, 40), FORMS[1]);
        let part = Part::new(sample, [0.0, 1.0], [0.02, 0.1, 0.5], profile);
        let slope = part.layer.profile.largest_slope();
        let plain = part.object;
        let plain_words = part.sample.words.clone();
        let (object, words) = stack(&[part], slope);
        let [map, same] = [&object, &plain].map(ShapeMap::new);
        let one = Profile::new(&object);
        let stack = Stack::new(&one, &map);
        for _ in 0..200 {
            let uv = Vec2::new(
                random.within(0.0, 1.0) as Real,
                random.within(0.0, 1.0) as Real,
            );
            let depth_fraction = random.within(0.0, 1.0) as Real;
            let (_, gap) = stack.gaps(&Stacked(&words[..]), uv, depth_fraction);
            let distance = same.distance(&plain_words[..], uv);
            assert_eq!(gap, Profile::new(&plain).gap(distance, depth_fraction));
        }
    }
}

/// A bar of 8 of 16 columns at δ from 0.5 to `bottom`, over a whole layer from 0.9 on.
fn bar(bottom: Real) -> (Object, Vec<u32>) {
    let columns: Vec<bool> = (0..16 * 4).map(|i| i % 16 < 8).collect();
    let mut ranges = [[0.5, bottom], [0.9, 1.0]].into_iter();
    let parts: Vec<Part> = Sample::stacked(16, &[columns, vec![true; 64]], FORMS[0])
        .into_iter()
        .map(|sample| Part::new(sample, ranges.next().unwrap(), [0.0, 0.0, 1.0], STRAIGHT))
        .collect();
    stack(&parts, 8.0)
}

#[test]
fn each_face_has_its_class_its_normal_and_its_layer() {
    let (object, words) = bar(0.75);
    assert_eq!(object.map_format, FORMAT_FLOAT);
    let texels = Stacked(&words[..]);
    let surface = SmoothSurface {
        surface: crate::surface::Surface {
            gradient_u: Vec3::X,
            gradient_v: Vec3::Y,
            ..test_surface([0.0; 3], 0.0)
        },
        normal: Vec3::Z,
        depth: 0.1,
    };
    for (u, depth_fraction, class, layer, normal) in [
        (0.25, 0.499, CLASS_CAP, 0, Vec3::Z),
        (0.25, 0.751, CLASS_CAP, 0, Vec3::NEG_Z),
        (0.502, 0.6, CLASS_WALL, 0, Vec3::X),
        (0.75, 0.899, CLASS_CAP, 1, Vec3::Z),
    ] {
        let march = March {
            end: END_SIDE,
            s: 1.0,
            uv: Vec2::new(u, 0.5),
            depth_fraction,
            steps: 1,
        };
        assert_eq!(
            class_of(&march, &object, &texels),
            (class, layer),
            "{u} {depth_fraction}"
        );
        let hit = Hit {
            class,
            depth: 0.0,
            t: 1.0,
            uv: march.uv,
            repeat: Vec2::ZERO,
            depth_fraction,
            steps: 1,
            layer,
        };
        let found = normal_at(class, &object, &texels, &surface, &hit);
        assert!((found - normal).length() < 1e-3, "{found} {normal}");
        assert_eq!(finish(&object, &texels, &hit), layer);
        let colored = colored(&object, &texels, &hit);
        assert_eq!(colored.cap_color, [9.0 * layer as f32, 0.5, 1.0]);
    }
}

#[test]
fn a_cap_ends_at_its_outline_or_at_the_foot_of_a_higher_layer() {
    let around_cap = |bottom: Real, u: Real, layer: u32| {
        let (object, words) = bar(bottom);
        let hit = Hit {
            class: CLASS_CAP,
            depth: 0.0,
            t: 1.0,
            uv: Vec2::new(u, 0.5),
            repeat: Vec2::ZERO,
            depth_fraction: if layer == 0 { 0.5 } else { 0.9 },
            steps: 1,
            layer,
        };
        around(&object, &Stacked(&words[..]), &hit, 1.0)
    };
    // Two texels inside the bar.
    let cap = around_cap(0.75, 0.375, 0);
    assert!((cap.distance + 2.0).abs() < 1e-3, "{}", cap.distance);
    assert_eq!((cap.hit.class, cap.openness), (CLASS_CAP, 1.0));
    // The bar ends above the layer below, which has no outline.
    let below = around_cap(0.75, 0.625, 1);
    assert_eq!((below.hit.class, below.openness), (CLASS_CAP, 1.0));
    // Two texels beside the bar, which is 6.4 texels high there.
    let foot = around_cap(1.0, 0.625, 1);
    assert!((foot.distance - 2.0).abs() < 1e-3, "{}", foot.distance);
    assert_eq!(foot.hit.class, CLASS_FLOOR);
    let open = 0.5 + 0.5 * 2.0 / (2.0 * 2.0 + 6.4 * 6.4f32).sqrt();
    assert!((foot.openness - open).abs() < 1e-3, "{}", foot.openness);
}

#[test]
fn the_side_of_a_layer_ends_at_its_cap_or_where_it_hangs() {
    let ends = |bottom: Real, depth_fraction: Real| {
        let (object, words) = bar(bottom);
        let hit = Hit {
            class: CLASS_WALL,
            depth: 0.0,
            t: 1.0,
            uv: Vec2::new(0.502, 0.5),
            repeat: Vec2::ZERO,
            depth_fraction,
            steps: 1,
            layer: 0,
        };
        let around = around(&object, &Stacked(&words[..]), &hit, 1.0);
        (around.up, around.hit.depth_fraction)
    };
    for (bottom, depth_fraction, up, away) in [
        (0.75, 0.53, -1.0, 0.22),
        (0.75, 0.74, -1.0, 0.01),
        (1.0, 0.99, 1.0, 0.49),
    ] {
        let found = ends(bottom, depth_fraction);
        assert_eq!(found.0, up);
        assert!((found.1 - away).abs() < 1e-6, "{found:?}");
    }
}
