//! Plans the cheapest way to draw each object whose trial keeps its budget.

use super::metrics::{ScreenMetrics, measure};
use super::recipe::{Recipe, recipes};
use super::trial::{Evaluator, FEW_RAYS, MANY_RAYS, Trial};
use crate::Error;
use crate::prepare::{Assets, LoadedScene, PreparedObject, PreparedScene, Step};
use crate::scene::{MapOptions, Scene, SceneObject, Tier};
use std::fmt;

/// Steps added to twice the steps of a trial's rays.
const SPARE_STEPS: u32 = 16;

/// A prepared scene, and the plans of its objects.
pub struct PlannedScene {
    /// The scene, ready for a renderer.
    pub scene: PreparedScene,
    /// One for each of the scene's objects; `None` for objects without a budget.
    pub plans: Vec<Option<Plan>>,
}

/// How an object with a budget is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Largest allowed error, pixels.
    pub budget: f64,
    /// How it is drawn.
    pub recipe: Recipe,
    /// Measurements of the object in the picture.
    pub metrics: ScreenMetrics,
    /// What was tried, in order; the last one is drawn. `None` where the map
    /// cannot hold the extrusion. Empty if there is no reference.
    pub trials: Vec<(Recipe, Option<Trial>)>,
    /// Whether the budget will be kept.
    pub promise: Promise,
}

/// Prediction of a [`Plan`] about its budget.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Promise {
    /// The budget is kept.
    Kept,
    /// The budget may be exceeded, and why.
    Doubtful(String),
}

/// Loads `scene`, plans its objects that have a budget, and prepares all.
/// `progress` may be called from any thread.
///
/// Scenes without budgets are prepared as by [`crate::prepare::prepare`].
///
/// # Errors
/// [`Error`] for the first object whose files or parameters cannot be used.
pub fn plan(scene: &Scene, progress: &(dyn Fn(Step) + Sync)) -> Result<PlannedScene, Error> {
    plan_with(scene, &mut Assets::default(), progress)
}

/// Like [`plan`], reusing unchanged `assets` as
/// [`crate::prepare::prepare_with`] does.
///
/// # Errors
/// As [`plan`].
pub fn plan_with(
    scene: &Scene,
    assets: &mut Assets,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<PlannedScene, Error> {
    let mut loaded = LoadedScene::load(scene, assets, progress)?;
    let planned = plan_loaded(scene, &mut loaded, progress)?;
    *assets = loaded.into_assets();
    Ok(planned)
}

/// Like [`plan`], without the objects outside the picture, as
/// [`crate::prepare::prepare_view`] does.
///
/// # Errors
/// As [`plan`], except for errors in preparing what is outside the picture.
pub fn plan_view(scene: &Scene, progress: &(dyn Fn(Step) + Sync)) -> Result<PlannedScene, Error> {
    plan_loaded(
        scene,
        &mut LoadedScene::load_view(scene, progress)?,
        progress,
    )
}

fn plan_loaded(
    scene: &Scene,
    loaded: &mut LoadedScene<'_>,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<PlannedScene, Error> {
    let prepared = loaded.prepare()?;
    let mut planned = PlannedScene {
        plans: vec![None; prepared.objects.len()],
        scene: prepared,
    };
    if scene.objects.iter().all(|object| object.budget.is_none()) {
        return Ok(planned);
    }
    let metrics = measure(&planned.scene);
    for (index, metrics) in metrics.into_iter().enumerate() {
        let prepared = &planned.scene.objects[index];
        let object = &scene.objects[prepared.number];
        let Some(budget) = object.budget else {
            continue;
        };
        progress(Step::Plan(object.name.clone()));
        let map = loaded.pattern_size(object);
        let mut make = |object: &SceneObject| loaded.again(prepared, object);
        let (plan, drawn) = plan_object(object, budget, metrics, map, &planned.scene, &mut make)?;
        log::info!("{:?}: {plan}", object.name);
        planned.plans[index] = Some(plan);
        planned.scene.objects[index] = drawn;
    }
    planned.scene.preparation = loaded.elapsed();
    Ok(planned)
}

/// Plans `object` with a `budget` in pixels, and prepares it as planned.
///
/// `map` is as for [`recipes`], `make` prepares a variation of the object, and
/// `scene` is the scene that contains it.
fn plan_object(
    object: &SceneObject,
    budget: f64,
    metrics: ScreenMetrics,
    map: Option<[u32; 2]>,
    scene: &PreparedScene,
    make: &mut dyn FnMut(&SceneObject) -> Result<PreparedObject, Error>,
) -> Result<(Plan, PreparedObject), Error> {
    let finest = map.map_or_else(MapOptions::default, |_| MapOptions::FINEST);
    let reference = match make(&Recipe::plain(Tier::Accurate, finest).of(object)) {
        Ok(reference) => scene.alone(reference),
        Err(Error::Object { problem, .. }) => {
            return untried(object, budget, metrics, Vec::new(), problem, make);
        }
        Err(error) => return Err(error),
    };
    let evaluator = Evaluator::new(&reference, metrics.pixels, FEW_RAYS);
    let mut finer_evaluator = None;
    let mut trials = Vec::new();
    let mut last: Option<(Recipe, Trial, PreparedObject)> = None;
    for recipe in recipes(&metrics, budget, map) {
        // A tier whose error is far too large stays so with a smaller tolerance.
        if let Some((other, trial, _)) = &last
            && other.tier == recipe.tier
            && !trial.is_near()
        {
            continue;
        }
        let drawn = match make(&recipe.of(object)) {
            Ok(drawn) => drawn,
            // A map that small does not hold what the extrusion needs.
            Err(Error::Object { .. }) => {
                trials.push((recipe, None));
                continue;
            }
            Err(error) => return Err(error),
        };
        let mut drawn = scene.alone(drawn);
        let mut trial = evaluator.evaluate(&mut drawn, budget)?;
        if trial.is_doubtful() {
            let finer = finer_evaluator
                .get_or_insert_with(|| Evaluator::new(&reference, metrics.pixels, MANY_RAYS));
            trial = finer.evaluate(&mut drawn, budget)?;
        }
        trials.push((recipe, Some(trial)));
        last = Some((recipe, trial, drawn.objects.remove(0)));
        if trial.keeps() {
            break;
        }
    }
    let Some((mut recipe, trial, mut drawn)) = last else {
        let reason = "nothing could be tried".to_string();
        return untried(object, budget, metrics, trials, reason, make);
    };
    let promise = if trial.keeps() {
        recipe.steps = recipe.steps.min(2 * trial.steps + SPARE_STEPS);
        Promise::Kept
    } else {
        Promise::Doubtful(format!(
            "on {:.2} % of the rays tried even the most careful way is wrong by more",
            100.0 * trial.share_above
        ))
    };
    drawn.parameters.linear_steps = recipe.steps;
    let plan = Plan {
        budget,
        recipe,
        metrics,
        trials,
        promise,
    };
    Ok((plan, drawn))
}

/// Plans the fast tier without a promise, where no trial is possible for
/// `reason`.
fn untried(
    object: &SceneObject,
    budget: f64,
    metrics: ScreenMetrics,
    trials: Vec<(Recipe, Option<Trial>)>,
    reason: String,
    make: &mut dyn FnMut(&SceneObject) -> Result<PreparedObject, Error>,
) -> Result<(Plan, PreparedObject), Error> {
    let recipe = Recipe::plain(Tier::Fast, MapOptions::default());
    let drawn = make(&recipe.of(object))?;
    let plan = Plan {
        budget,
        recipe,
        metrics,
        trials,
        promise: Promise::Doubtful(reason),
    };
    Ok((plan, drawn))
}

impl fmt::Display for Plan {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} px: {}", self.budget, self.recipe)?;
        match &self.promise {
            Promise::Kept => Ok(()),
            Promise::Doubtful(reason) => write!(formatter, "; not promised: {reason}"),
        }
    }
}
