//! So many pixels wrong, and no more: the cheapest way to draw an object that
//! keeps a budget.
//!
//! ```text
//! view      what a picture shows of an object → numbers that errors follow from
//! model     those → which tiers are worth a trial
//! recipe    a budget → ways to draw, from cheap to dear
//! trial     a way to draw → how wrong it is, on some of the picture's own rays
//! plan      the cheapest whose trial keeps the budget
//! random    scenes to fit the model to, and to hold the planner to
//! study     such scenes, measured
//! ```
//!
//! An error in pixels is that of [`crate::oracle::Displacements`]: in 99 of 100
//! pixels the picture shows what the truth, the mesh as curved prisms in double
//! precision, shows within so many pixels of there.

mod model;
mod plan;
mod random;
mod recipe;
mod study;
mod trial;
mod view;

pub use model::{FAST, Model, PLANAR};
pub(crate) use plan::plan;
pub use plan::{Plan, Promise};
pub use random::random_scene;
pub use recipe::Recipe;
pub use study::{Held, Study};
pub use trial::Trial;
pub(crate) use view::smaller_stretch;
pub use view::{View, look};
