//! Measures scenes, mostly random ones: to fit the model, and to check that plans keep their
//! promises.

use super::metrics::{ScreenMetrics, measure};
use super::plan::{Plan, Promise, plan_with};
use super::random::random_scene;
use super::recipe::Recipe;
use super::trial::Evaluator;
use crate::Error;
use crate::oracle::SHARE;
use crate::prepare::{Assets, PreparedScene, prepare};
use crate::scene::{MapOptions, Scene, Tier};
use std::path::Path;

/// Largest error that is measured, pixels.
const LARGEST: f64 = 2.0;

/// A scene, and its most accurate form.
pub struct Study {
    /// The scene.
    pub scene: Scene,
    /// `None` where prisms of that depth cannot be made.
    reference: Option<PreparedScene>,
}

/// A plan of a [`Study`], and its actual error.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// The plan.
    pub plan: Plan,
    /// Share of all pixels whose error exceeds the budget; `None` without a
    /// reference.
    pub share_above: Option<f64>,
}

impl Held {
    /// Returns whether the budget is kept.
    pub fn is_kept(&self) -> bool {
        self.share_above.is_some_and(|share| share <= 1.0 - SHARE)
    }

    /// Returns whether the budget is kept or was not promised.
    pub fn is_honest(&self) -> bool {
        self.is_kept() || self.plan.promise != Promise::Kept
    }
}

impl Study {
    /// Loads random scene `number` of `series` with this project's `assets`, for
    /// pictures of `size` pixels.
    ///
    /// # Errors
    /// [`Error`] where the assets cannot be loaded.
    pub fn new(series: u64, number: u64, size: [u32; 2], assets: &Path) -> Result<Study, Error> {
        let text = random_scene(series, number, size);
        Study::of(Scene::parse(&text, &assets.join("scenes/random.toml"))?)
    }

    /// Studies `scene`, which has one object.
    ///
    /// # Errors
    /// [`Error`] where its files cannot be loaded.
    pub fn of(scene: Scene) -> Result<Study, Error> {
        let finest = Recipe::plain(Tier::Accurate, MapOptions::FINEST);
        let reference = match drawn(&scene, &finest) {
            Ok(prepared) => Some(prepared),
            Err(Error::Object { .. }) => None,
            Err(error) => return Err(error),
        };
        Ok(Study { scene, reference })
    }

    /// Returns whether there is a reference.
    pub fn has_truth(&self) -> bool {
        self.reference.is_some()
    }

    /// Measures the object in the picture.
    ///
    /// # Errors
    /// As [`prepare`].
    pub fn metrics(&self) -> Result<ScreenMetrics, Error> {
        let plain = Recipe::plain(Tier::Fast, MapOptions::default());
        let metrics = measure(&drawn(&self.scene, &plain)?);
        Ok(metrics.first().copied().unwrap_or_default())
    }

    /// Prepares the scene with `recipe`.
    ///
    /// # Errors
    /// As [`prepare`].
    pub fn drawn(&self, recipe: &Recipe) -> Result<PreparedScene, Error> {
        drawn(&self.scene, recipe)
    }

    /// Measures the errors of the pictures of `recipes`, pixels (see
    /// [`crate::oracle::Displacements::error_px`]); infinity for those that
    /// cannot be drawn. Empty without a reference.
    ///
    /// # Errors
    /// As [`prepare`] and [`crate::render::Renderer::geometry`].
    pub fn errors_px(&self, recipes: &[Recipe]) -> Result<Vec<f64>, Error> {
        self.each(recipes, |evaluator, prepared| {
            Ok(evaluator.displacements(prepared, LARGEST)?.error_px())
        })
    }

    /// Returns the smallest of `budgets` (pixels, ascending) that the picture of
    /// each of `recipes` keeps; infinity where it keeps none or cannot be drawn.
    /// Empty without a reference.
    ///
    /// # Errors
    /// As [`Study::errors_px`].
    pub fn kept(&self, recipes: &[Recipe], budgets: &[f64]) -> Result<Vec<f64>, Error> {
        self.each(recipes, |evaluator, prepared| {
            let mut least = f64::INFINITY;
            // The largest first: a failure there is found fastest.
            for &budget in budgets.iter().rev() {
                if evaluator.evaluate(prepared, budget)?.share_above > 1.0 - SHARE {
                    break;
                }
                least = budget;
            }
            Ok(least)
        })
    }

    /// Calls `value` for each of `recipes`; infinity for those that cannot be
    /// drawn. Empty without a reference.
    fn each(
        &self,
        recipes: &[Recipe],
        value: impl Fn(&Evaluator<'_>, &mut PreparedScene) -> Result<f64, Error>,
    ) -> Result<Vec<f64>, Error> {
        let Some(evaluator) = self.reference.as_ref().map(Evaluator::of_every_pixel) else {
            return Ok(Vec::new());
        };
        let value = |recipe: &Recipe| match self.drawn(recipe) {
            Ok(mut prepared) => value(&evaluator, &mut prepared),
            Err(Error::Object { .. }) => Ok(f64::INFINITY),
            Err(error) => Err(error),
        };
        recipes.iter().map(value).collect()
    }

    /// Plans for each of `budgets` (pixels), and measures every pixel of the
    /// result.
    ///
    /// # Errors
    /// As [`Study::errors_px`].
    pub fn hold(&self, budgets: &[f64]) -> Result<Vec<Held>, Error> {
        let evaluator = self.reference.as_ref().map(Evaluator::of_every_pixel);
        let mut assets = Assets::default();
        let mut held = |budget: &f64| {
            let mut scene = self.scene.clone();
            for object in &mut scene.objects {
                object.budget = Some(*budget);
            }
            let mut planned = plan_with(&scene, &mut assets, &|_| ())?;
            let share_above = match &evaluator {
                Some(evaluator) => {
                    let trial = evaluator.evaluate(&mut planned.scene, *budget)?;
                    Some(trial.share_above)
                }
                None => None,
            };
            let plan = planned.plans.into_iter().flatten().next();
            Ok(plan.map(|plan| Held { plan, share_above }))
        };
        budgets
            .iter()
            .filter_map(|budget| held(budget).transpose())
            .collect()
    }
}

fn drawn(scene: &Scene, recipe: &Recipe) -> Result<PreparedScene, Error> {
    let mut scene = scene.clone();
    for object in &mut scene.objects {
        *object = recipe.of(object);
    }
    prepare(&scene, &|_| ())
}
