//! Random scenes, measured: what the model is fitted to, and whether plans
//! hold what they promise.

use super::{Plan, Promise, Recipe, View, look, random_scene};
use crate::Error;
use crate::oracle::{MeshOracle, SHARE, Truth};
use crate::prepare::{PreparedScene, prepare};
use crate::render::{CpuRenderer, Renderer};
use crate::scene::{MapOptions, Scene, Tier};
use crate::shape_map::Storage;
use glam::DVec3;
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

/// A picture of a [`Study`].
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// How it is drawn.
    pub recipe: Recipe,
    /// The error in pixels; see [`crate::oracle::Displacements::error_px`].
    pub error_px: f64,
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
        let finest = Recipe::plain(
            Tier::Accurate,
            MapOptions {
                storage: Storage::R32F,
                reduction: 1,
            },
        );
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

    /// How wrong the pictures of `recipes` are; infinity for those that cannot
    /// be drawn. Nothing where the truth is not known.
    ///
    /// # Errors
    /// As [`prepare`] and [`Renderer::geometry`].
    pub fn outcomes(&self, recipes: &[Recipe]) -> Result<Vec<Outcome>, Error> {
        let Some(judge) = self.reference.as_ref().map(Judge::new) else {
            return Ok(Vec::new());
        };
        let outcome = |recipe: &Recipe| {
            let error_px = match self.drawn(recipe) {
                Ok(prepared) => judge.errors(&prepared, LARGEST)?.error_px(),
                Err(Error::Object { .. }) => f64::INFINITY,
                Err(error) => return Err(error),
            };
            Ok(Outcome {
                recipe: *recipe,
                error_px,
            })
        };
        recipes.iter().map(outcome).collect()
    }

    /// The least of `budgets` (pixels, in growing order) that the picture of each
    /// of `recipes` keeps; infinity where it keeps none or cannot be drawn.
    /// Nothing where the truth is not known.
    ///
    /// # Errors
    /// As [`Study::outcomes`].
    pub fn kept(&self, recipes: &[Recipe], budgets: &[f64]) -> Result<Vec<f64>, Error> {
        let Some(judge) = self.reference.as_ref().map(Judge::new) else {
            return Ok(Vec::new());
        };
        let least = |recipe: &Recipe| {
            let prepared = match self.drawn(recipe) {
                Ok(prepared) => prepared,
                Err(Error::Object { .. }) => return Ok(f64::INFINITY),
                Err(error) => return Err(error),
            };
            let mut least = f64::INFINITY;
            // The largest first: what does not keep that is soon known.
            for &budget in budgets.iter().rev() {
                if judge.share_above(&prepared, budget)? > 1.0 - SHARE {
                    break;
                }
                least = budget;
            }
            Ok(least)
        };
        recipes.iter().map(least).collect()
    }

    /// Plans for each of `budgets` (pixels), and judges every pixel of what
    /// comes of it.
    ///
    /// # Errors
    /// As [`Study::outcomes`].
    pub fn hold(&self, budgets: &[f64]) -> Result<Vec<Held>, Error> {
        let judge = self.reference.as_ref().map(Judge::new);
        let held = |budget: &f64| {
            let mut scene = self.scene.clone();
            for object in &mut scene.objects {
                object.budget = Some(*budget);
            }
            let prepared = prepare(&scene, &|_| ())?;
            let share_above = match &judge {
                Some(judge) => Some(judge.share_above(&prepared, *budget)?),
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

/// The truth of every pixel.
struct Judge<'a> {
    reference: &'a PreparedScene,
    oracle: MeshOracle<'a>,
    truth: Truth,
}

impl<'a> Judge<'a> {
    fn new(reference: &'a PreparedScene) -> Judge<'a> {
        let oracle = MeshOracle::new(reference);
        let eye = DVec3::from(reference.camera.eye);
        let truth = Truth::of(&oracle, eye, &reference.frame);
        Judge {
            reference,
            oracle,
            truth,
        }
    }

    fn errors(
        &self,
        prepared: &PreparedScene,
        largest: f64,
    ) -> Result<crate::oracle::Displacements, Error> {
        let frame = &self.reference.frame;
        let words = CpuRenderer::new(prepared).geometry(frame)?;
        let eye = DVec3::from(self.reference.camera.eye);
        Ok(self
            .truth
            .displacements(&self.oracle, eye, frame, &words, largest))
    }

    /// The share of all pixels that is wrong by more than `budget`.
    fn share_above(&self, prepared: &PreparedScene, budget: f64) -> Result<f64, Error> {
        let frame = &self.reference.frame;
        let words = CpuRenderer::new(prepared).geometry(frame)?;
        let eye = DVec3::from(self.reference.camera.eye);
        let oracle = &self.oracle;
        let (_, share) = self
            .truth
            .share_above(oracle, eye, frame, 1.0, &words, budget);
        Ok(share)
    }
}

fn drawn(scene: &Scene, recipe: &Recipe) -> Result<PreparedScene, Error> {
    let mut scene = scene.clone();
    for object in &mut scene.objects {
        *object = recipe.of(object);
    }
    prepare(&scene, &|_| ())
}
