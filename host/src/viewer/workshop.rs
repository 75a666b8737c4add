//! Work beside the window: on a thread of its own, or at once where there are no
//! threads.

use super::judge::Judgement;
use super::watch::Wake;
use crate::prepare::{Assets, PreparedScene, prepare_with};
use crate::scene::{Camera, Scene};
use relievo_shared::layout::Frame;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Something to do.
pub enum Order {
    /// Prepare scenes; orders before this one are forgotten.
    Prepare {
        /// The number by which the result is known.
        number: u64,
        /// One scene, or two to be compared.
        scenes: Vec<Scene>,
        /// Files may have changed: everything is read anew.
        anew: bool,
    },
    /// Judge a picture.
    Judge {
        /// The number by which the result is known.
        number: u64,
        /// Of this scene,
        scene: Arc<PreparedScene>,
        /// from here,
        camera: Camera,
        /// in this size.
        frame: Box<Frame>,
    },
}

/// What became of an [`Order`], by its number; or what stands against it, for a
/// person.
pub enum Delivery {
    /// Scenes.
    Prepared(u64, Result<Vec<Arc<PreparedScene>>, String>),
    /// A judgement.
    Judged(u64, Result<Judgement, String>),
}

/// Takes orders and gives deliveries.
pub struct Workshop {
    orders: Sender<Order>,
    deliveries: Receiver<Delivery>,
    #[cfg(target_arch = "wasm32")]
    here: Bench,
    #[cfg(target_arch = "wasm32")]
    wake: Wake,
}

/// Where the work is done.
struct Bench {
    orders: Receiver<Order>,
    deliveries: Sender<Delivery>,
    assets: Vec<Assets>,
}

impl Workshop {
    /// `wake` is called after each delivery, from any thread.
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
                // Until the window is closed.
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

    /// Gives an order.
    pub fn order(&mut self, order: Order) {
        // The other end ends with the program.
        let _ = self.orders.send(order);
        #[cfg(target_arch = "wasm32")]
        while let Ok(order) = self.here.orders.try_recv() {
            self.here.work(order);
            (self.wake)();
        }
    }

    /// What was finished, one by one.
    pub fn delivery(&self) -> Option<Delivery> {
        self.deliveries.try_recv().ok()
    }
}

impl Bench {
    /// Does the latest order.
    fn work(&mut self, first: Order) {
        let waiting = self.orders.try_iter();
        let mut is_anew = false;
        let latest = std::iter::once(first)
            .chain(waiting)
            .inspect(|order| is_anew |= matches!(order, Order::Prepare { anew: true, .. }))
            .reduce(|before, order| match (&before, &order) {
                // A picture of a scene that is about to change.
                (Order::Prepare { .. }, Order::Judge { .. }) => before,
                _ => order,
            });
        if is_anew {
            self.assets.clear();
        }
        let delivery = match latest {
            Some(Order::Prepare { number, scenes, .. }) => {
                Delivery::Prepared(number, self.prepare(&scenes))
            }
            Some(Order::Judge {
                number,
                scene,
                camera,
                frame,
            }) => Delivery::Judged(
                number,
                Judgement::of(&scene, &camera, &frame).map_err(|error| error.to_string()),
            ),
            None => return,
        };
        // Nobody waits for it once the window is closed.
        let _ = self.deliveries.send(delivery);
    }

    fn prepare(&mut self, scenes: &[Scene]) -> Result<Vec<Arc<PreparedScene>>, String> {
        if self.assets.len() < scenes.len() {
            self.assets.resize_with(scenes.len(), Assets::default);
        }
        scenes
            .iter()
            .zip(&mut self.assets)
            .map(|(scene, assets)| {
                let prepared = prepare_with(scene, assets, &|_| ());
                prepared.map(Arc::new).map_err(|error| error.to_string())
            })
            .collect()
    }
}
