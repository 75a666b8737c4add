//! The work of the workshop: what is ordered, what is delivered, and what is kept in between.

use super::analysis::{Analysed, Analysis};
use relievo::budget::{PlannedScene, plan_with};
use relievo::prepare::{Assets, PreparedScene};
use relievo::scene::{Camera, Scene};
use relievo_shared::layout::Frame;
use std::sync::Arc;

/// A request.
pub enum Order {
    /// Prepares scenes and drops earlier orders.
    Prepare {
        /// Identifies the result.
        number: u64,
        /// One scene, or two to compare, with the same files.
        scenes: Vec<Scene>,
        /// Reads all files again.
        anew: bool,
    },
    /// Analyses a picture of the first scene that was delivered last.
    Analyse {
        /// What is computed.
        analysis: Analysis,
        /// Identifies the result.
        number: u64,
        /// The camera.
        camera: Camera,
        /// The frame, which holds the size.
        frame: Box<Frame>,
    },
}

/// Result of an [`Order`] with its number, or a message for the user.
pub enum Delivery {
    /// Prepared scenes.
    Prepared(u64, Result<Vec<Ready>, String>),
    /// The analysis of a picture.
    Analysed(u64, Result<Analysed, String>),
}

/// A prepared scene.
pub struct Ready {
    /// The scene.
    pub scene: Arc<PreparedScene>,
    /// The plans of the objects that have an error budget, as text.
    pub plans: Vec<String>,
}

/// Executes orders.
#[derive(Default)]
pub struct Bench {
    assets: Vec<Assets>,
    /// The first scene of the last delivery.
    first: Option<Arc<PreparedScene>>,
}

impl Order {
    /// Returns what is left to do of an order and of the one after it.
    pub fn then(self, mut after: Order) -> Order {
        match (&self, &mut after) {
            // The picture's scene is about to change.
            (Order::Prepare { .. }, Order::Analyse { .. }) => self,
            (Order::Prepare { anew: true, .. }, Order::Prepare { anew, .. }) => {
                *anew = true;
                after
            }
            _ => after,
        }
    }

    /// Returns the delivery of a message in place of the result.
    #[cfg(feature = "worker")]
    pub fn failed(&self, problem: String) -> Delivery {
        match self {
            Order::Prepare { number, .. } => Delivery::Prepared(*number, Err(problem)),
            Order::Analyse { number, .. } => Delivery::Analysed(*number, Err(problem)),
        }
    }
}

impl Bench {
    /// Executes an order.
    pub fn work(&mut self, order: Order) -> Delivery {
        match order {
            Order::Prepare {
                number,
                scenes,
                anew,
            } => {
                if anew {
                    self.assets.clear();
                }
                Delivery::Prepared(number, self.prepare(&scenes))
            }
            Order::Analyse {
                analysis,
                number,
                camera,
                frame,
            } => Delivery::Analysed(number, self.analyse(analysis, &camera, &frame)),
        }
    }

    fn prepare(&mut self, scenes: &[Scene]) -> Result<Vec<Ready>, String> {
        if self.assets.len() < scenes.len() {
            self.assets.resize_with(scenes.len(), Assets::default);
        }
        let planned = scenes
            .iter()
            .zip(&mut self.assets)
            .map(|(scene, assets)| {
                let PlannedScene { scene, plans } =
                    plan_with(scene, assets, &|_| ()).map_err(|error| error.to_string())?;
                Ok(Ready {
                    scene: Arc::new(scene),
                    plans: plans.iter().flatten().map(ToString::to_string).collect(),
                })
            })
            .collect::<Result<Vec<Ready>, String>>()?;
        self.first = planned.first().map(|first| first.scene.clone());
        Ok(planned)
    }

    fn analyse(
        &self,
        analysis: Analysis,
        camera: &Camera,
        frame: &Frame,
    ) -> Result<Analysed, String> {
        let scene = self
            .first
            .as_ref()
            .ok_or("the scene has to be prepared again: press F5")?;
        Analysed::new(analysis, scene, camera, frame).map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prepare(number: u64, anew: bool) -> Order {
        Order::Prepare {
            number,
            scenes: Vec::new(),
            anew,
        }
    }

    fn analyse(number: u64) -> Order {
        Order::Analyse {
            analysis: Analysis::Errors,
            number,
            camera: Camera::new([1.0; 3], [0.0; 3]),
            frame: Box::default(),
        }
    }

    #[test]
    fn the_latest_order_is_left_to_do() {
        let left = |orders: Vec<Order>| match orders.into_iter().reduce(Order::then) {
            Some(Order::Prepare { number, anew, .. }) => (number, anew),
            _ => panic!("a scene is prepared"),
        };
        assert_eq!(left(vec![prepare(1, false), prepare(2, false)]), (2, false));
        assert_eq!(left(vec![prepare(1, true), prepare(2, false)]), (2, true));
        assert_eq!(left(vec![prepare(1, false), analyse(1)]), (1, false));
        assert_eq!(left(vec![analyse(1), prepare(1, true)]), (1, true));
        assert!(matches!(
            analyse(1).then(analyse(2)),
            Order::Analyse { number: 2, .. }
        ));
    }
}
