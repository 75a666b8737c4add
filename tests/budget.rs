//! Error budgets are kept, or reported in advance as not promised.
//!
//! `RELIEVO_SCENES=500 cargo test --profile checked -p relievo-tests --test
//! thorough budget::` is the long form.

use relievo::budget::{Held, Promise, Recipe, Study, plan};
use relievo::scene::{MapOptions, Scene, Tier};
use relievo_tests::asset;
use std::path::Path;

const BUDGETS: [f64; 3] = [0.1, 0.5, 2.0];
const SIZE: [u32; 2] = [112, 84];
/// A series other than the one the model is fitted to.
const SERIES: u64 = 3;

/// Number of scenes to test.
fn scenes() -> u64 {
    std::env::var("RELIEVO_SCENES").map_or(4, |text| text.parse().unwrap())
}

#[test]
fn budgets_are_kept_or_not_promised() {
    let (mut held, mut kept, mut drawn) = (0, 0, [0; 3]);
    let mut dearer = 0;
    for number in 0..scenes() {
        let study = Study::new(SERIES, number, SIZE, &asset(".")).unwrap();
        let plans = study.hold(&BUDGETS).unwrap();
        assert_eq!(plans.len(), BUDGETS.len());
        let tiers = [Tier::Planar, Tier::Fast, Tier::Accurate];
        let careful = tiers.map(|tier| Recipe::plain(tier, MapOptions::default()));
        let least = study.kept(&careful[..2], &BUDGETS).unwrap();
        for (budget, plan) in BUDGETS.iter().zip(&plans) {
            held += 1;
            kept += usize::from(plan.is_kept());
            assert!(plan.is_honest(), "scene {number}, {budget} px: {plan:?}");
            let tier = tiers
                .iter()
                .position(|tier| *tier == plan.plan.recipe.tier)
                .unwrap();
            drawn[tier] += 1;
            let cheapest = least.iter().position(|least| least <= budget);
            dearer += usize::from(cheapest.is_some_and(|cheapest| cheapest < tier));
        }
    }
    println!(
        "{kept} of {held} kept; planar, fast, accurate: {drawn:?}; dearer than need be: {dearer}"
    );
    assert!(kept as f64 >= 0.99 * held as f64, "{kept} of {held}");
    // Plans do not buy unneeded accuracy, and they vary.
    assert!(drawn.iter().all(|count| 20 * count >= held), "{drawn:?}");
    assert!(4 * dearer <= held, "{dearer} of {held}");
}

/// A promise without a trial is detected.
#[test]
fn a_broken_promise_is_seen() {
    let study = Study::new(SERIES, 0, SIZE, &asset(".")).unwrap();
    let planned = study.hold(&[2.0]).unwrap().remove(0);
    let broken = Held {
        share_above: Some(0.5),
        ..planned.clone()
    };
    assert!(planned.is_honest() && !broken.is_kept());
    assert_eq!(broken.is_honest(), planned.plan.promise != Promise::Kept);
}

fn with_budget(object: &str) -> Scene {
    let text = format!("[image]\nsize = [80, 60]\n[[object]]\n{object}\n");
    Scene::parse(&text, &asset("scenes/budget.toml")).unwrap()
}

/// Where the depth is too little for prisms there is no oracle.
#[test]
fn what_cannot_be_judged_is_not_promised() {
    let scene = with_budget(
        "mesh = '../meshes/torus.obj'\nshape = '../patterns/discs.png'\nrepeat = [24, 10]\ndepth = 1e-5\nerror_px = 0.5",
    );
    let planned = plan(&scene, &|_| ()).unwrap();
    let plan = planned.plans[0].as_ref().unwrap();
    match &plan.promise {
        Promise::Doubtful(reason) => assert!(reason.contains("too little"), "{reason}"),
        Promise::Kept => panic!("{plan:?}"),
    }
    assert!(plan.to_string().contains("not promised"), "{plan}");
}

/// Each object has its own plan, and a baked map stays as it is.
#[test]
fn objects_are_planned_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let baked = folder.path().join("discs.png");
    let pattern = relievo::shape_map::Pattern::load(
        asset("patterns/discs.png"),
        &relievo::shape_map::PatternOptions::default(),
    )
    .unwrap();
    relievo::shape_map::bake(&pattern, relievo::shape_map::Storage::R16, &|_| ())
        .save(&baked)
        .unwrap();
    let object = |shape: &Path, more: &str| {
        format!(
            "mesh = '../meshes/sphere.obj'\nshape = '{}'\nrepeat = [8, 4]\ndepth = 0.05\n{more}",
            shape.display()
        )
    };
    let scene = with_budget(&format!(
        "{}\n[[object]]\n{}\n[[object]]\n{}",
        object(&baked, "error_px = 4"),
        object(
            &asset("patterns/discs.png"),
            "error_px = 4\ntranslate = [3, 0, 0]"
        ),
        object(
            &asset("patterns/discs.png"),
            "tier = 'fast'\ntranslate = [6, 0, 0]"
        ),
    ));
    let planned = plan(&scene, &|_| ()).unwrap();
    let [baked, plain, None] = &planned.plans[..] else {
        panic!()
    };
    let [baked, plain] = [baked, plain].map(|plan| plan.as_ref().unwrap());
    assert_eq!(baked.recipe.map, MapOptions::default());
    let objects = &planned.scene.objects;
    assert_eq!(objects[2].parameters.slack, 0.0);
    for (plan, object) in [baked, plain].into_iter().zip(objects) {
        let (recipe, parameters) = (plan.recipe, &object.parameters);
        assert_eq!(recipe.tier.code(), parameters.tier);
        assert_eq!(recipe.steps, parameters.linear_steps);
        assert_eq!(recipe.slack > 0.0, parameters.slack > 0.0);
        assert!(plan.promise == Promise::Kept);
    }
}
