//! Background work: on a thread, or at once in a browser.

use super::analysis::{Analysed, Analysis};
use super::watch::Wake;
use relievo::budget::{PlannedScene, plan_with};
use relievo::prepare::{Assets, PreparedScene};
use relievo::scene::{Camera, Scene};
use relievo_shared::layout::Frame;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// A request.
pub enum Order {
    /// Prepares scenes and drops earlier orders.
    Prepare {
        /// Identifies the result.
        number: u64,
        /// One scene, or two to compare.
        scenes: Vec<Scene>,
        /// Reads all files again.
        anew: bool,
    },
    /// Analyses a picture.
    Analyse {
        /// What is computed.
        analysis: Analysis,
        /// Identifies the result.
        number: u64,
        /// The scene.
        scene: Arc<PreparedScene>,
        /// The camera.
        camera: Camera,
        /// The frame, which holds the size.
        frame: Box<Frame>,
    },
}

/// Result of an [`Order`] with its number, or a message for the user.
pub enum Delivery {
    /// Prepared scenes.
    Prepared(u64, Result<Vec<PlannedScene>, String>),
    /// The analysis of a picture.
    Analysed(u64, Result<Analysed, String>),
}

/// Executes orders in the background.
pub struct Workshop {
    orders: Sender<Order>,
    deliveries: Receiver<Delivery>,
    #[cfg(target_arch = "wasm32")]
    here: Bench,
    #[cfg(target_arch = "wasm32")]
    wake: Wake,
}

/// State of the worker.
struct Bench {
    orders: Receiver<Order>,
    deliveries: Sender<Delivery>,
    assets: Vec<Assets>,
}

impl Workshop {
    /// Starts the worker; it calls `wake` after each delivery, from any thread.
    pub fn new(wake: Wake) -> Workshop {
        let (orders, to_do) = channel();
        let (done, deliveries) = channel();
        let bench = Bench {
            orders: to_do,
            deliveries: done,
            assets: Vec::new(),
        };
        #[cfg(not(target_arch = "wasm32"))]
        {
            let mut bench = bench;
            std::thread::spawn(move || {
                // Ends when the window is closed.
                while let Ok(order) = bench.orders.recv() {
                    bench.work(order);
                    wake();
                }
            });
            Workshop { orders, deliveries }
        }
        #[cfg(target_arch = "wasm32")]
        {
            Workshop {
                orders,
                deliveries,
                here: bench,
                wake,
            }
        }
    }

    /// Sends an order.
    pub fn order(&mut self, order: Order) {
        // The receiver lives as long as the program.
        let _ = self.orders.send(order);
        #[cfg(target_arch = "wasm32")]
        while let Ok(order) = self.here.orders.try_recv() {
            self.here.work(order);
            (self.wake)();
        }
    }

    /// Returns the next finished delivery, if any.
    pub fn delivery(&self) -> Option<Delivery> {
        self.deliveries.try_recv().ok()
    }
}

impl Bench {
    /// Executes the latest order.
    fn work(&mut self, first: Order) {
        let waiting = self.orders.try_iter();
        let mut is_anew = false;
        let latest = std::iter::once(first)
            .chain(waiting)
            .inspect(|order| is_anew |= matches!(order, Order::Prepare { anew: true, .. }))
            .reduce(|before, order| match (&before, &order) {
                // The picture's scene is about to change.
                (Order::Prepare { .. }, Order::Analyse { .. }) => before,
                _ => order,
            });
        if is_anew {
            self.assets.clear();
        }
        let delivery = match latest {
            Some(Order::Prepare { number, scenes, .. }) => {
                Delivery::Prepared(number, self.prepare(&scenes))
            }
            Some(Order::Analyse {
                analysis,
                number,
                scene,
                camera,
                frame,
            }) => Delivery::Analysed(
                number,
                Analysed::new(analysis, &scene, &camera, &frame).map_err(|error| error.to_string()),
            ),
            None => return,
        };
        // There is no receiver once the window is closed.
        let _ = self.deliveries.send(delivery);
    }

    fn prepare(&mut self, scenes: &[Scene]) -> Result<Vec<PlannedScene>, String> {
        if self.assets.len() < scenes.len() {
            self.assets.resize_with(scenes.len(), Assets::default);
        }
        scenes
            .iter()
            .zip(&mut self.assets)
            .map(|(scene, assets)| {
                let planned = plan_with(scene, assets, &|_| ());
                planned.map_err(|error| error.to_string())
            })
            .collect()
    }
}
