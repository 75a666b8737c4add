//! Background work: on a thread, in a worker of the browser, or at once where there is neither.

#[cfg(feature = "worker")]
use super::away::Away;
use super::bench::{Bench, Delivery, Order};
use super::platform::StartWorker;
use super::watch::Wake;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Executes orders in the background.
pub struct Workshop {
    place: Place,
    /// Why the window stands still meanwhile.
    note: Option<String>,
}

/// Where orders are executed.
enum Place {
    Thread {
        orders: Sender<Order>,
        deliveries: Receiver<Delivery>,
    },
    #[cfg(feature = "worker")]
    Worker(Box<Away>),
    Here(Box<Here>),
}

/// Executes orders at once.
struct Here {
    bench: Bench,
    deliveries: VecDeque<Delivery>,
    wake: Wake,
}

impl Workshop {
    /// Opens the workshop, in a worker if `start` starts one; it calls `wake` after each delivery,
    /// from any thread.
    pub fn new(start: Option<StartWorker>, wake: Wake) -> Workshop {
        let place = match start {
            #[cfg(feature = "worker")]
            Some(start) => Place::Worker(Box::new(Away::new(start, wake))),
            // A browser has no threads.
            _ if cfg!(target_arch = "wasm32") => Place::here(wake),
            _ => Place::thread(wake),
        };
        Workshop { place, note: None }
    }

    /// Sends an order. The latest one counts: those before it that have not been begun are dropped.
    pub fn order(&mut self, order: Order) {
        match &mut self.place {
            // The receiver lives as long as the program.
            Place::Thread { orders, .. } => drop(orders.send(order)),
            #[cfg(feature = "worker")]
            Place::Worker(away) => away.order(order),
            Place::Here(here) => here.work(order),
        }
    }

    /// Returns the next finished delivery, if any.
    pub fn delivery(&mut self) -> Option<Delivery> {
        match &mut self.place {
            Place::Thread { deliveries, .. } => deliveries.try_recv().ok(),
            #[cfg(feature = "worker")]
            Place::Worker(away) => {
                let delivery = away.delivery();
                if let Some(problem) = away.cannot_start() {
                    self.note = Some(format!(
                        "the page stands still meanwhile, since the browser starts no worker: {problem}"
                    ));
                    let left = away.left();
                    self.place = Place::here(away.wake());
                    left.into_iter().for_each(|order| self.order(order));
                }
                delivery
            }
            Place::Here(here) => here.deliveries.pop_front(),
        }
    }

    /// Returns why the window stands still during work, where it should not.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }
}

impl Place {
    fn thread(wake: Wake) -> Place {
        let (orders, to_do) = channel();
        let (done, deliveries) = channel();
        std::thread::spawn(move || {
            let mut bench = Bench::default();
            // Ends when the window is closed.
            while let Ok(first) = to_do.recv() {
                let order = to_do.try_iter().fold(first, Order::then);
                // There is no receiver once the window is closed.
                let _ = done.send(bench.work(order));
                wake();
            }
        });
        Place::Thread { orders, deliveries }
    }

    fn here(wake: Wake) -> Place {
        Place::Here(Box::new(Here {
            bench: Bench::default(),
            deliveries: VecDeque::new(),
            wake,
        }))
    }
}

impl Here {
    fn work(&mut self, order: Order) {
        self.deliveries.push_back(self.bench.work(order));
        (self.wake)();
    }
}

#[cfg(all(test, feature = "worker"))]
mod tests {
    use super::super::platform::{News, Worker};
    use super::*;
    use std::sync::Arc;

    /// A worker whose program is missing.
    struct Missing;

    impl Worker for Missing {
        fn send(&mut self, _: Vec<u8>) {}

        fn news(&mut self) -> Option<News> {
            Some(News::Stopped("its program is missing".to_string()))
        }
    }

    #[test]
    fn without_a_worker_the_window_works_itself() {
        let starts: [StartWorker; 2] = [
            Box::new(|_| Ok(Box::new(Missing))),
            Box::new(|_| Err("there are none".to_string())),
        ];
        for (start, part) in starts.into_iter().zip(["is missing", "there are none"]) {
            let mut workshop = Workshop::new(Some(start), Arc::new(|| ()));
            assert!(workshop.note().is_none());
            for number in [1, 2] {
                workshop.order(Order::Prepare {
                    number,
                    scenes: Vec::new(),
                    anew: false,
                });
            }
            assert!(workshop.delivery().is_none());
            // The first one is left out.
            assert!(matches!(
                workshop.delivery(),
                Some(Delivery::Prepared(2, Ok(_)))
            ));
            assert!(workshop.delivery().is_none());
            assert!(workshop.note().unwrap().contains(part));
        }
    }
}
