//! What holds for every profile of the list.

use super::*;
use crate::shape_map::tests::Random;
use crate::techniques::{PROFILES, TECHNIQUES};

/// A profile of any kind, in a map of 64 texels.
fn random_profile(random: &mut Random, kind: u32) -> Profile {
    Profile::new(
        &Object {
            map_size: [64.0, 64.0],
            extension: random.within(-0.1, 0.1) as f32,
            bevel: random.magnitude(1e-3, 1.0) as f32,
            chamfer: random.choose(&[0.0, 0.05, 0.5, 1.0]) as f32,
            profile: kind,
            parts: random.whole(1, 6),
            ..Object::default()
        }
        .complete(),
    )
}

/// Calls `check` for many random profiles of every kind.
fn for_many(mut check: impl FnMut(&mut Random, &Profile)) {
    for kind in 0..PROFILES {
        let mut random = Random(1 + u64::from(kind));
        for _ in 0..500 {
            let profile = random_profile(&mut random, kind);
            check(&mut random, &profile);
        }
    }
}

#[test]
fn every_profile_grows_inside_its_box() {
    for_many(|_, profile| {
        let step = 1e-4 * (1.0 + profile.largest_radius().abs());
        // With c = 0 nothing of the cap is left at the first depth.
        if profile.chamfer > 0.0 {
            assert!((profile.radius(0.0) - profile.extension).abs() <= step);
        }
        let mut before = profile.radius(0.0);
        for i in 0..=200 {
            let depth_fraction = i as f32 / 200.0;
            let radius = profile.radius(depth_fraction);
            assert!(radius >= before - step, "{profile:?} {depth_fraction}");
            if depth_fraction >= profile.chamfer {
                assert!((radius - profile.largest_radius()).abs() <= step);
            }
            before = radius;
        }
    });
}

#[test]
fn the_gap_is_positive_outside_only() {
    for_many(|random, profile| {
        for _ in 0..100 {
            let depth_fraction = random.within(0.0, 1.0) as f32;
            let distance = random.within(-20.0, 90.0) as f32;
            let outside = distance - profile.radius(depth_fraction);
            let gap = profile.gap(distance, depth_fraction);
            if outside.abs() > 1e-3 {
                assert_eq!(
                    gap > 0.0,
                    outside > 0.0,
                    "{profile:?} {distance} {depth_fraction}"
                );
            }
        }
    });
}

/// The steps of the march rely on it.
#[test]
fn the_gap_changes_no_faster_than_it_says() {
    for_many(|random, profile| {
        let mut place = || {
            let depth_fraction = random.within(0.0, 1.0) as f32;
            (random.within(-20.0, 90.0) as f32, depth_fraction)
        };
        for _ in 0..100 {
            let ((d0, x0), (d1, x1)) = (place(), place());
            let change = profile.gap(d1, x1) - profile.gap(d0, x0);
            let most = (d1 - d0).abs() + profile.largest_slope() * (x1 - x0).abs();
            assert!(change.abs() <= most + 1e-3, "{profile:?} {change} {most}");
            let deeper = profile.gap(d0, x0.max(x1)) - profile.gap(d0, x0.min(x1));
            assert!(deeper <= 1e-3, "{profile:?} {deeper}");
        }
    });
}

#[test]
fn depths_are_the_profile_the_other_way_round() {
    for_many(|random, profile| {
        for _ in 0..100 {
            let distance = random.within(-20.0, 90.0) as f32;
            let depth_fraction = profile.depth_of(distance);
            let [above, below] = [depth_fraction - 2e-3, depth_fraction + 2e-3];
            let slack = 1e-3 * (1.0 + distance.abs());
            if above > 0.0 {
                assert!(
                    profile.radius(above) <= distance + slack,
                    "{profile:?} {distance}"
                );
            }
            if below < 1.0 {
                assert!(
                    profile.radius(below) >= distance - slack,
                    "{profile:?} {distance}"
                );
            }
        }
    });
}

#[test]
fn slopes_are_those_of_the_radius() {
    for_many(|random, profile| {
        for _ in 0..100 {
            let (depth_fraction, h) = (random.within(0.01, 0.99) as f32, 1e-3);
            if depth_fraction + h >= profile.chamfer {
                continue;
            }
            let rise = profile.radius(depth_fraction + h) - profile.radius(depth_fraction - h);
            let slopes = [depth_fraction - h, depth_fraction + h].map(|x| profile.slope(x));
            let [low, high] = [
                slopes[0].min(slopes[1]) * 2.0 * h,
                slopes[0].max(slopes[1]) * 2.0 * h,
            ];
            // Where r jumps, a slope says nothing of the places between the jumps.
            let low = if low >= STEEP * 2.0 * h { 0.0 } else { low };
            let error = 1e-3 + 0.02 * rise.abs();
            assert!(
                low <= rise + error && rise <= high + error,
                "{profile:?} {depth_fraction} {low} {rise} {high}"
            );
        }
    });
}

#[test]
fn sides_below_the_chamfer_are_walls() {
    for_many(|_, profile| {
        let distance = profile.largest_radius();
        // With c = 1 this is the edge between growing part and floor.
        assert!(profile.chamfer == 1.0 || !profile.is_growing(1.0, || distance));
        let upright = Profile {
            grows: false,
            ..*profile
        };
        assert!(!upright.is_growing(0.0, || distance));
        assert_eq!(upright.upright_gap(distance), distance - profile.extension);
    });
}

#[test]
fn techniques_have_profiles_of_the_list() {
    for technique in TECHNIQUES {
        assert!(technique.profile < PROFILES, "{}", technique.name);
        let [_, bevel, chamfer] = technique.growth;
        assert!(bevel >= 0.0 && (0.0..=1.0).contains(&chamfer) && technique.parts > 0);
    }
}

#[test]
fn growth_and_rim_are_those_of_the_radius() {
    let object = |profile, bevel, chamfer| Object {
        map_size: [40.0, 10.0],
        profile,
        bevel,
        chamfer,
        ..Object::default()
    };
    // 2 texels, of 40 and of 10.
    let [u, v] = growth(&object(STRAIGHT, 0.1, 0.5));
    assert!((u - 0.05).abs() < 1e-6 && (v - 0.2).abs() < 1e-6, "{u} {v}");
    assert_eq!(rim(&object(STRAIGHT, 0.1, 0.5)), 0.5);
    assert_eq!(rim(&object(STRAIGHT, 0.0, 0.5)), 0.0);
    // So do fillets and terraces; each layer has its own.
    assert_eq!(rim(&object(rounded::Rounded::NUMBER, 0.1, 0.5)), 0.5);
    assert_eq!(rim(&object(stepped::Stepped::NUMBER, 0.1, 0.5)), 0.5);
    assert_eq!(rim(&object(LAYERED, 0.1, 0.5)), 0.0);
}
