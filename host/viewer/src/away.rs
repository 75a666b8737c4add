//! The workshop in a worker without shared memory: orders and deliveries as bytes.
//!
//! A message is a head and what belongs to it as it is, so that large contents are copied once: the
//! new files of an order, the picture of an analysis, prepared scenes. Files that the worker has are
//! not sent again.

use super::analysis::{Analysed, Analysis};
use super::bench::{Bench, Delivery, Order, Ready};
use super::platform::{News, StartWorker, Worker};
use super::watch::Wake;
use relievo::picture::Picture;
use relievo::prepare::transfer::{Receiver, Sender};
use relievo::scene::{Camera, Scene};
use relievo::{Files, Limits};
use relievo_shared::layout::Frame;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files by their paths.
type Known = BTreeMap<PathBuf, Arc<[u8]>>;

/// Head of an order.
#[derive(Serialize, Deserialize)]
enum Request {
    Prepare {
        number: u64,
        scenes: Vec<Text>,
        anew: bool,
        /// Names of files, and the number of their bytes; `None` for those that are no more.
        files: Vec<(String, Option<usize>)>,
    },
    Analyse {
        analysis: Analysis,
        number: u64,
        camera: Camera,
    },
}

/// A scene as a file.
#[derive(Serialize, Deserialize)]
struct Text {
    path: String,
    text: String,
    limits: Limits,
}

/// Head of a delivery.
#[derive(Serialize, Deserialize)]
enum Reply {
    /// The plans of each scene.
    Prepared(u64, Result<Vec<Vec<String>>, String>),
    /// Width and height of the picture, and the text.
    Analysed(u64, Result<([u32; 2], String), String>),
}

/// Returns a message.
fn message(head: &impl Serialize, rest: &[u8]) -> Vec<u8> {
    let mut bytes = postcard::to_allocvec(head).expect("memory takes any value");
    bytes.extend(rest);
    bytes
}

/// The end of the worker.
#[derive(Default)]
pub struct Station {
    bench: Bench,
    files: Known,
    sender: Sender,
}

impl Station {
    /// Executes an order, and returns the delivery.
    ///
    /// # Errors
    /// A message, if `bytes` are no order.
    pub fn work(&mut self, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let (request, rest) =
            postcard::take_from_bytes(bytes).map_err(|error| format!("no order: {error}"))?;
        let order = match request {
            Request::Prepare {
                number,
                scenes,
                anew,
                files,
            } => {
                self.receive_files(files, rest)?;
                let files = Files::Memory(Arc::new(self.files.clone()));
                let read = |scene: &Text| {
                    let path = Path::new(&scene.path);
                    Scene::parse_with(&scene.text, path, &scene.limits, files.clone())
                };
                match scenes.iter().map(read).collect() {
                    Ok(scenes) => Order::Prepare {
                        number,
                        scenes,
                        anew,
                    },
                    Err(error) => {
                        let reply = Reply::Prepared(number, Err(error.to_string()));
                        return Ok(message(&reply, &[]));
                    }
                }
            }
            Request::Analyse {
                analysis,
                number,
                camera,
            } => Order::Analyse {
                analysis,
                number,
                camera,
                frame: Box::new(
                    bytemuck::try_pod_read_unaligned(rest)
                        .map_err(|error| format!("no frame: {error}"))?,
                ),
            },
        };
        Ok(match self.bench.work(order) {
            Delivery::Prepared(number, Ok(scenes)) => {
                let sent = self.sender.send(scenes.iter().map(|ready| &*ready.scene));
                let plans = scenes.into_iter().map(|ready| ready.plans);
                message(&Reply::Prepared(number, Ok(plans.collect())), &sent)
            }
            Delivery::Prepared(number, Err(problem)) => {
                message(&Reply::Prepared(number, Err(problem)), &[])
            }
            Delivery::Analysed(number, Ok(analysed)) => {
                let Analysed { picture, text } = analysed;
                let head = ([picture.width, picture.height], text);
                message(&Reply::Analysed(number, Ok(head)), &picture.bytes)
            }
            Delivery::Analysed(number, Err(problem)) => {
                message(&Reply::Analysed(number, Err(problem)), &[])
            }
        })
    }

    fn receive_files(
        &mut self,
        files: Vec<(String, Option<usize>)>,
        mut rest: &[u8],
    ) -> Result<(), String> {
        for (name, length) in files {
            match length {
                Some(length) => {
                    let (bytes, after) = rest
                        .split_at_checked(length)
                        .ok_or_else(|| format!("no order: {name} is cut off"))?;
                    self.files.insert(name.into(), bytes.into());
                    rest = after;
                }
                None => drop(self.files.remove(Path::new(&name))),
            }
        }
        Ok(())
    }
}

/// The end of the page.
pub struct Away {
    start: StartWorker,
    wake: Wake,
    line: Option<Line>,
    /// What the worker is at.
    under_way: Option<Order>,
    /// What comes next.
    waiting: Option<Order>,
    /// What is delivered without the worker.
    delivery: Option<Delivery>,
    /// Why there is no worker at all.
    cannot_start: Option<String>,
}

/// A running worker, and what it has.
struct Line {
    worker: Box<dyn Worker>,
    is_ready: bool,
    files: Arc<Known>,
    receiver: Receiver,
}

impl Away {
    /// Creates an end whose worker is started by the first order.
    pub fn new(start: StartWorker, wake: Wake) -> Away {
        Away {
            start,
            wake,
            line: None,
            under_way: None,
            waiting: None,
            delivery: None,
            cannot_start: None,
        }
    }

    /// Sends an order, once the worker is free.
    pub fn order(&mut self, order: Order) {
        self.waiting = Some(match self.waiting.take() {
            Some(before) => before.then(order),
            None => order,
        });
        self.go_on();
    }

    /// Returns the next finished delivery, if any.
    pub fn delivery(&mut self) -> Option<Delivery> {
        if let Some(delivery) = self.delivery.take() {
            return Some(delivery);
        }
        let line = self.line.as_mut()?;
        match line.worker.news()? {
            News::Ready => {
                line.is_ready = true;
                self.delivery()
            }
            News::Reply(bytes) => match line.read(&bytes) {
                Ok(delivery) => {
                    self.under_way = None;
                    self.go_on();
                    Some(delivery)
                }
                Err(problem) => self.stopped(problem),
            },
            News::Stopped(problem) => self.stopped(problem),
        }
    }

    /// Returns why no worker can be started, if so.
    pub fn cannot_start(&self) -> Option<&str> {
        self.cannot_start.as_deref()
    }

    /// Takes the orders that have not been executed.
    pub fn left(&mut self) -> Option<Order> {
        let orders = [self.under_way.take(), self.waiting.take()];
        orders.into_iter().flatten().reduce(Order::then)
    }

    /// Returns what it calls after a delivery.
    pub fn wake(&self) -> Wake {
        self.wake.clone()
    }

    /// Sends the next order, if the worker is free.
    fn go_on(&mut self) {
        if self.under_way.is_some() {
            return;
        }
        let Some(order) = self.waiting.take() else {
            return;
        };
        if self.line.is_none() {
            match (self.start)(self.wake.clone()) {
                Ok(worker) => {
                    self.line = Some(Line {
                        worker,
                        is_ready: false,
                        files: Arc::default(),
                        receiver: Receiver::default(),
                    });
                }
                Err(problem) => self.cannot_start = Some(problem),
            }
        }
        let sent = self.line.as_mut().map(|line| line.send(&order));
        match sent {
            // Its message is clearer than that about a text that nobody has written.
            Some(Err(problem)) => {
                self.delivery = Some(order.failed(problem));
                (self.wake)();
            }
            Some(Ok(())) => self.under_way = Some(order),
            None => {
                self.under_way = Some(order);
                (self.wake)();
            }
        }
    }

    /// Gives up the worker. The next order starts another one.
    fn stopped(&mut self, problem: String) -> Option<Delivery> {
        let line = self.line.take()?;
        if !line.is_ready {
            self.cannot_start = Some(problem);
            return None;
        }
        let order = self.under_way.take();
        self.go_on();
        let message = format!(
            "The worker has stopped: {problem}. If its memory was full, use fewer triangles or a smaller pattern; the next change starts another worker"
        );
        order.map(|order| order.failed(message))
    }
}

impl Line {
    /// Sends an order.
    ///
    /// # Errors
    /// A message for the user, if the scene is not valid.
    fn send(&mut self, order: &Order) -> Result<(), String> {
        let bytes = match order {
            Order::Prepare {
                number,
                scenes,
                anew,
            } => {
                for scene in scenes {
                    scene.check().map_err(|error| error.to_string())?;
                }
                let (files, contents) = self.new_files(scenes);
                let text = |scene: &Scene| Text {
                    path: scene.path.to_string_lossy().into_owned(),
                    text: scene.to_toml(scene.path.parent().unwrap_or(Path::new(""))),
                    limits: scene.limits.clone(),
                };
                let request = Request::Prepare {
                    number: *number,
                    scenes: scenes.iter().map(text).collect(),
                    anew: *anew,
                    files,
                };
                message(&request, &contents)
            }
            Order::Analyse {
                analysis,
                number,
                camera,
                frame,
            } => {
                let request = Request::Analyse {
                    analysis: *analysis,
                    number: *number,
                    camera: *camera,
                };
                message(&request, bytemuck::bytes_of::<Frame>(frame))
            }
        };
        self.worker.send(bytes);
        Ok(())
    }

    /// Returns the names and lengths of the files that have changed, and their contents.
    fn new_files(&mut self, scenes: &[Scene]) -> (Vec<(String, Option<usize>)>, Vec<u8>) {
        let now = match scenes.first().map(|scene| &scene.files) {
            Some(Files::Memory(files)) => files.clone(),
            _ => Arc::default(),
        };
        let name = |path: &Path| path.to_string_lossy().into_owned();
        let gone = self.files.keys().filter(|path| !now.contains_key(*path));
        let mut files: Vec<_> = gone.map(|path| (name(path), None)).collect();
        let mut contents = Vec::new();
        for (path, bytes) in now.iter() {
            let is_it = |known: &Arc<[u8]>| Arc::ptr_eq(known, bytes);
            if !self.files.get(path).is_some_and(is_it) {
                files.push((name(path), Some(bytes.len())));
                contents.extend_from_slice(bytes);
            }
        }
        self.files = now;
        (files, contents)
    }

    /// Reads a delivery.
    fn read(&mut self, bytes: &[u8]) -> Result<Delivery, String> {
        let (reply, rest) =
            postcard::take_from_bytes(bytes).map_err(|error| format!("no delivery: {error}"))?;
        Ok(match reply {
            Reply::Prepared(number, Ok(plans)) => {
                let scenes = self.receiver.receive(rest);
                let scenes = scenes.map_err(|error| error.to_string())?;
                let ready = scenes.into_iter().zip(plans).map(|(scene, plans)| Ready {
                    scene: Arc::new(scene),
                    plans,
                });
                Delivery::Prepared(number, Ok(ready.collect()))
            }
            Reply::Prepared(number, Err(problem)) => Delivery::Prepared(number, Err(problem)),
            Reply::Analysed(number, Ok(([width, height], text))) => {
                let pixels = (width as usize).checked_mul(height as usize);
                if pixels.and_then(|pixels| pixels.checked_mul(3)) != Some(rest.len()) {
                    return Err("no delivery: the picture has another size".to_string());
                }
                let picture = Picture {
                    width,
                    height,
                    bytes: rest.to_vec(),
                };
                Delivery::Analysed(number, Ok(Analysed { picture, text }))
            }
            Reply::Analysed(number, Err(problem)) => Delivery::Analysed(number, Err(problem)),
        })
    }
}

#[cfg(test)]
mod tests;
