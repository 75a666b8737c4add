//! Random scenes, measured: what the model is fitted to, and whether plans
//! hold what they promise.

use super::trial::Judge;
use super::{Plan, Promise, Recipe, View, look, random_scene};
use crate::Error;
use crate::oracle::SHARE;
use crate::prepare::{PreparedScene, prepare};
use crate::scene::{MapOptions, Scene, Tier};
use std::path::Path;

/// Errors are looked for up to this, pixels.
const LARGEST: f64 = 2.0;

/// A random scene, and what it should look like.
pub struct Study {
    /// The scene.
    pub scene: Scene,
    /// As accurate as can be; none where prisms of that depth cannot be made.
    reference: Option<PreparedScene>,
}

/// A planned picture of a [`Study`], held to its promise.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// The plan.
    pub plan: Plan,
    /// The share of all pixels that is wrong by more than the budget; none where
    /// nothing knows the truth.
    pub share_above: Option<f64>,
}

impl Held {
    /// Whether the budget is kept.
    pub fn is_kept(&self) -> bool {
        self.share_above.is_some_and(|share| share <= 1.0 - SHARE)
    }

    /// Whether the plan said what has come true: it promised only what is kept.
    pub fn is_honest(&self) -> bool {
        self.is_kept() || self.plan.promise != Promise::Kept
    }
}

impl Study {
    /// Random scene `number` of `series`, with this project's `assets`; pictures
    /// of `size` pixels.
    ///
    /// # Errors
    /// [`Error`] where the assets are not there.
    pub fn new(series: u64, number: u64, size: [u32; 2], assets: &Path) -> Result<Study, Error> {
        let text = random_scene(series, number, size);
        let scene = Scene::parse(&text, &assets.join("scenes/random.toml"))?;
        let finest = Recipe::plain(Tier::Accurate, MapOptions::FINEST);
        let reference = match drawn(&scene, &finest) {
            Ok(prepared) => Some(prepared),
            Err(Error::Object { .. }) => None,
            Err(error) => return Err(error),
        };
        Ok(Study { scene, reference })
    }

    /// Whether the truth is known.
    pub fn has_truth(&self) -> bool {
        self.reference.is_some()
    }

    /// What the picture shows.
    ///
    /// # Errors
    /// As [`prepare`].
    pub fn view(&self) -> Result<View, Error> {
        let plain = Recipe::plain(Tier::Fast, MapOptions::default());
        let views = look(&drawn(&self.scene, &plain)?);
        Ok(views.first().copied().unwrap_or_default())
    }

    /// The scene, drawn by `recipe`.
    ///
    /// # Errors
    /// As [`prepare`].
    pub fn drawn(&self, recipe: &Recipe) -> Result<PreparedScene, Error> {
        drawn(&self.scene, recipe)
    }

    /// How wrong the pictures of `recipes` are, pixels (see
    /// [`crate::oracle::Displacements::error_px`]); infinity for those that
    /// cannot be drawn. Nothing where the truth is not known.
    ///
    /// # Errors
    /// As [`prepare`] and [`crate::render::Renderer::geometry`].
    pub fn errors_px(&self, recipes: &[Recipe]) -> Result<Vec<f64>, Error> {
        self.each(recipes, |judge, prepared| {
            Ok(judge.displacements(prepared, LARGEST)?.error_px())
        })
    }

    /// The least of `budgets` (pixels, in growing order) that the picture of each
    /// of `recipes` keeps; infinity where it keeps none or cannot be drawn.
    /// Nothing where the truth is not known.
    ///
    /// # Errors
    /// As [`Study::errors_px`].
    pub fn kept(&self, recipes: &[Recipe], budgets: &[f64]) -> Result<Vec<f64>, Error> {
        self.each(recipes, |judge, prepared| {
            let mut least = f64::INFINITY;
            // The largest first: what does not keep that is soon known.
            for &budget in budgets.iter().rev() {
                if judge.judge(prepared, budget)?.share_above > 1.0 - SHARE {
                    break;
                }
                least = budget;
            }
            Ok(least)
        })
    }

    /// What `value` says of the picture of each of `recipes`; infinity for those
    /// that cannot be drawn. Nothing where the truth is not known.
    fn each(
        &self,
        recipes: &[Recipe],
        value: impl Fn(&Judge<'_>, &mut PreparedScene) -> Result<f64, Error>,
    ) -> Result<Vec<f64>, Error> {
        let Some(judge) = self.reference.as_ref().map(Judge::of_every_pixel) else {
            return Ok(Vec::new());
        };
        let value = |recipe: &Recipe| match self.drawn(recipe) {
            Ok(mut prepared) => value(&judge, &mut prepared),
            Err(Error::Object { .. }) => Ok(f64::INFINITY),
            Err(error) => Err(error),
        };
        recipes.iter().map(value).collect()
    }

    /// Plans for each of `budgets` (pixels), and judges every pixel of what
    /// comes of it.
    ///
    /// # Errors
    /// As [`Study::errors_px`].
    pub fn hold(&self, budgets: &[f64]) -> Result<Vec<Held>, Error> {
        let judge = self.reference.as_ref().map(Judge::of_every_pixel);
        let held = |budget: &f64| {
            let mut scene = self.scene.clone();
            for object in &mut scene.objects {
                object.budget = Some(*budget);
            }
            let mut prepared = prepare(&scene, &|_| ())?;
            let share_above = match &judge {
                Some(judge) => Some(judge.judge(&mut prepared, *budget)?.share_above),
                None => None,
            };
            let planned = prepared.objects.into_iter().find_map(|object| object.plan);
            Ok(planned.map(|plan| Held { plan, share_above }))
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
