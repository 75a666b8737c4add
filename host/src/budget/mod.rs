//! Error budgets: plans the cheapest way to draw an object within an error in
//! pixels (`error_px`).
//!
//! The error in pixels is that of [`crate::oracle::Displacements`]: in 99 % of
//! the pixels, the truth (the mesh as curved prisms in double precision) has the
//! picture's class and distance somewhere within that many pixels.
//!
//! Planning loads a scene, then
//!
//! 1. `metrics` measures each object in the picture,
//! 2. `model` predicts which tiers are worth a trial,
//! 3. `recipe` lists parameters for them, from cheap to expensive,
//! 4. `trial` measures the error of a recipe on some of the picture's rays,
//! 5. `plan` picks the first recipe whose trial keeps the budget.
//!
//! `random` and `study` fit the model to random scenes and test the plans.
//!
//! ```
//! use relievo::budget::{Promise, plan};
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! image.size = [40, 30]
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! error_px = 2
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let planned = plan(&scene, &|_| ())?;
//! let plan = planned.plans[0].as_ref().unwrap();
//! if let Promise::Doubtful(reason) = &plan.promise {
//!     println!("not promised: {reason}");
//! }
//! println!("{plan}");
//! # Ok::<(), relievo::Error>(())
//! ```

mod metrics;
mod model;
mod plan;
mod random;
mod recipe;
mod study;
mod trial;

pub use metrics::{ScreenMetrics, measure};
pub use model::{FAST, Model, PLANAR};
pub use plan::{Plan, PlannedScene, Promise, plan, plan_view, plan_with};
pub use random::random_scene;
pub use recipe::Recipe;
pub use study::{Held, Study};
pub use trial::Trial;
