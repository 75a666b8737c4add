//! The cheapest way to draw an object whose trial keeps the budget.

use super::recipe::recipes;
use super::trial::{FEW_RAYS, Judge, MANY_RAYS};
use super::{Recipe, Trial, View};
use crate::Error;
use crate::prepare::{PreparedObject, PreparedScene};
use crate::scene::{MapOptions, SceneObject, Tier};
use std::fmt;

/// Steps beside twice those that a trial's rays took.
const SPARE_STEPS: u32 = 16;

/// How an object with a budget is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// How wrong it may be, pixels.
    pub budget: f64,
    /// How it is drawn.
    pub recipe: Recipe,
    /// What the picture shows of it.
    pub view: View,
    /// What was tried, in turn; the last is what is drawn. Empty where there is
    /// nothing to judge by.
    pub trials: Vec<(Recipe, Option<Trial>)>,
    /// Whether the budget will be kept.
    pub promise: Promise,
}

/// What a [`Plan`] says of its budget before anything is drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Promise {
    /// It is kept.
    Kept,
    /// It may not be kept, and why.
    Doubtful(String),
}

/// Plans for `object` with a `budget`, of which the picture shows `view`;
/// `map` as for [`recipes`], `make` prepares it as drawn in a certain way, and
/// `scene` is what it lies in. The second answer is the object as planned.
pub(crate) fn plan(
    object: &SceneObject,
    budget: f64,
    view: View,
    map: Option<[u32; 2]>,
    scene: &PreparedScene,
    make: &mut dyn FnMut(&SceneObject) -> Result<PreparedObject, Error>,
) -> Result<(Plan, PreparedObject), Error> {
    let finest = map.map_or_else(MapOptions::default, |_| MapOptions::FINEST);
    let reference = match make(&Recipe::plain(Tier::Accurate, finest).of(object)) {
        Ok(reference) => scene.alone(reference),
        Err(Error::Object { problem, .. }) => {
            return untried(object, budget, view, Vec::new(), problem, make);
        }
        Err(error) => return Err(error),
    };
    let judge = Judge::new(&reference, FEW_RAYS);
    let mut careful_judge = None;
    let mut trials = Vec::new();
    let mut last: Option<(Recipe, Trial, PreparedObject)> = None;
    for recipe in recipes(&view, budget, map) {
        // What is far too wrong in one tier is so with more care, too.
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
        let mut trial = judge.judge(&mut drawn, budget)?;
        if trial.is_doubtful() {
            let judge = careful_judge.get_or_insert_with(|| Judge::new(&reference, MANY_RAYS));
            trial = judge.judge(&mut drawn, budget)?;
        }
        trials.push((recipe, Some(trial)));
        last = Some((recipe, trial, drawn.objects.remove(0)));
        if trial.keeps() {
            break;
        }
    }
    let Some((mut recipe, trial, mut drawn)) = last else {
        let reason = "nothing could be tried".to_string();
        return untried(object, budget, view, trials, reason, make);
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
        view,
        trials,
        promise,
    };
    Ok((plan, drawn))
}

/// The plan where no trial says anything, for that `reason`: the fast tier, and
/// no promise.
fn untried(
    object: &SceneObject,
    budget: f64,
    view: View,
    trials: Vec<(Recipe, Option<Trial>)>,
    reason: String,
    make: &mut dyn FnMut(&SceneObject) -> Result<PreparedObject, Error>,
) -> Result<(Plan, PreparedObject), Error> {
    let recipe = Recipe::plain(Tier::Fast, MapOptions::default());
    let drawn = make(&recipe.of(object))?;
    let plan = Plan {
        budget,
        recipe,
        view,
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
