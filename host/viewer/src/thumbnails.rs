//! Small pictures of patterns: made by the code that carves them, on a thread of their
//! own, or one a frame in a browser.

use super::patterns::{Choice, choices};
use super::probe::Collector;
use super::watch::Wake;
use eframe::egui::{
    self, Color32, ColorImage, CursorIcon, Rect, Role, Sense, Stroke, StrokeKind, TextureHandle,
    TextureOptions, Ui, Vec2, WidgetInfo, vec2,
};
use relievo::Files;
use relievo::scene::{Scene, Shape};
use relievo::shape_map::{Pattern, PatternOptions, ShapeMap};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Longer side of a picture, pixels.
const PIXELS: u32 = 96;
/// Side of its button, points.
const POINTS: f32 = 48.0;
/// Distance of a picture from the button's edge, points.
const MARGIN: f32 = 3.0;
/// Height of the list, points.
const HEIGHT: f32 = 220.0;
/// Largest number of pixels of a pattern that is read.
const MOST_PIXELS: u64 = 1 << 24;
/// Grey of the background and of the pattern.
const GREYS: [f32; 2] = [240.0, 40.0];

/// What determines the pictures.
#[derive(Clone, PartialEq)]
struct Request {
    choices: Vec<Choice>,
    files: Files,
    options: PatternOptions,
}

/// State of a picture.
#[derive(Clone, Default)]
enum Picture {
    #[default]
    Wanted,
    Made(TextureHandle),
    /// The file is no pattern.
    Missing,
}

/// Number of the request and of the choice, and the picture of a pattern.
type Made = (u64, usize, Option<ColorImage>);

/// A list of patterns to choose from.
pub struct Thumbnails {
    /// Folder of the last pattern that is a file.
    folder: Option<PathBuf>,
    /// Source of the list: where files are read, and the folder.
    source: Option<(Files, Option<PathBuf>)>,
    request: Option<Request>,
    /// Number of the request.
    number: u64,
    /// Pictures of the request's choices.
    pictures: Vec<Picture>,
    orders: Sender<(u64, Request)>,
    made: Receiver<Made>,
    #[cfg(target_arch = "wasm32")]
    here: Painter,
}

impl Thumbnails {
    /// Creates a list without pictures; `wake` is called when one has been made.
    pub fn new(wake: Wake) -> Thumbnails {
        let (orders, to_do) = channel();
        let (done, made) = channel();
        let painter = Painter {
            orders: to_do,
            made: done,
            order: None,
            next: 0,
            wake,
        };
        #[cfg(not(target_arch = "wasm32"))]
        {
            let mut painter = painter;
            // Ends when the window is closed.
            std::thread::spawn(move || while painter.receive() && painter.paint() {});
        }
        Thumbnails {
            folder: None,
            source: None,
            request: None,
            number: 0,
            pictures: Vec::new(),
            orders,
            made,
            #[cfg(target_arch = "wasm32")]
            here: painter,
        }
    }

    /// Lists the files beside `shape`, if it is a file; otherwise those listed before.
    pub fn visit(&mut self, shape: &Shape) {
        if let Shape::File(path) = shape
            && self.folder.as_deref() != path.parent()
        {
            self.folder = path.parent().map(Path::to_path_buf);
        }
    }

    /// Lists and draws all patterns anew.
    pub fn forget(&mut self) {
        (self.source, self.request) = (None, None);
    }

    /// Shows the patterns; returns the one that was clicked.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        collector: &Collector,
        scene: &Scene,
        selected: usize,
    ) -> Option<Shape> {
        let object = scene.objects.get(selected)?;
        self.update(scene, object.threshold, object.invert);
        self.receive(ui);
        let choices = self.request.iter().flat_map(|request| &request.choices);
        let all = choices.zip(&self.pictures);
        let mut clicked = None;
        egui::ScrollArea::vertical()
            .max_height(HEIGHT)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                ui.spacing_mut().item_spacing = Vec2::splat(4.0);
                ui.horizontal_wrapped(|ui| {
                    for (choice, picture) in all {
                        let texture = match picture {
                            Picture::Missing => continue,
                            Picture::Wanted => None,
                            Picture::Made(texture) => Some(texture),
                        };
                        let is_chosen = choice.shape == object.shape;
                        if button(ui, collector, &choice.name, texture, is_chosen) {
                            clicked = Some(choice.shape.clone());
                        }
                    }
                });
            });
        clicked
    }

    /// Orders pictures, unless they have been ordered.
    fn update(&mut self, scene: &Scene, threshold: u8, invert: bool) {
        let source = Some((scene.files.clone(), self.folder.clone()));
        let options = PatternOptions {
            threshold,
            invert,
            max_pixels: scene.limits.pixels.min(MOST_PIXELS),
            // Averaged below.
            raster: 2 * PIXELS,
        };
        let request = self.request.as_ref();
        if self.source == source && request.is_some_and(|request| request.options == options) {
            return;
        }
        let list = match (&self.source, request) {
            (same, Some(request)) if *same == source => request.choices.clone(),
            _ => choices(
                &scene.files,
                source.as_ref().and_then(|(_, folder)| folder.as_deref()),
            ),
        };
        let request = Request {
            choices: list,
            files: scene.files.clone(),
            options,
        };
        // Earlier pictures are shown until there are others.
        if self.request.as_ref().map(|request| &request.choices) != Some(&request.choices) {
            self.pictures = vec![Picture::Wanted; request.choices.len()];
        }
        self.number += 1;
        // The receiver lives as long as the program.
        let _ = self.orders.send((self.number, request.clone()));
        (self.source, self.request) = (source, Some(request));
    }

    /// Receives pictures.
    fn receive(&mut self, ui: &Ui) {
        #[cfg(target_arch = "wasm32")]
        if self.here.receive() {
            self.here.paint();
        }
        for (number, index, image) in self.made.try_iter() {
            let Some(picture) = self.pictures.get_mut(index) else {
                continue;
            };
            if number != self.number {
                continue;
            }
            *picture = image.map_or(Picture::Missing, |image| {
                let context = ui.ctx();
                Picture::Made(context.load_texture("pattern", image, TextureOptions::LINEAR))
            });
        }
    }
}

/// Shows the button of a pattern; returns whether it was clicked.
fn button(
    ui: &mut Ui,
    collector: &Collector,
    name: &str,
    texture: Option<&TextureHandle>,
    is_chosen: bool,
) -> bool {
    let (rectangle, response) = ui.allocate_exact_size(Vec2::splat(POINTS), Sense::click());
    let label = format!("Pattern: {name}");
    let state = match (is_chosen, texture) {
        (true, _) => "chosen",
        (_, Some(_)) => "",
        (_, None) => "not drawn yet",
    };
    collector.add(&label, rectangle, state);
    let visuals = ui.style().interact_selectable(&response, is_chosen);
    let painter = ui.painter();
    painter.rect_filled(rectangle, 3.0, Color32::from_gray(GREYS[0] as u8));
    if let Some(texture) = texture {
        let [width, height] = texture.size().map(|side| side as f32);
        let size = vec2(width, height) * ((POINTS - 2.0 * MARGIN) / width.max(height));
        let whole = Rect::from_min_size(egui::Pos2::ZERO, Vec2::splat(1.0));
        let place = Rect::from_center_size(rectangle.center(), size);
        painter.image(texture.id(), place, whole, Color32::WHITE);
    }
    let stroke = if is_chosen || response.hovered() || response.has_focus() {
        Stroke::new(2.0, ui.visuals().selection.bg_fill)
    } else {
        visuals.bg_stroke
    };
    painter.rect_stroke(rectangle, 3.0, stroke, StrokeKind::Inside);
    response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_chosen, &label));
    response
        .on_hover_cursor(CursorIcon::PointingHand)
        .on_hover_text(name)
        .clicked()
}

/// Makes the pictures of the latest order.
struct Painter {
    orders: Receiver<(u64, Request)>,
    made: Sender<Made>,
    order: Option<(u64, Request)>,
    /// Index of the next choice of the order.
    next: usize,
    wake: Wake,
}

impl Painter {
    /// Takes the latest order, and waits for one where waiting is possible and there is
    /// nothing to do. Returns whether there is something to do.
    fn receive(&mut self) -> bool {
        let mut latest = self.orders.try_iter().last();
        if cfg!(not(target_arch = "wasm32")) && latest.is_none() && self.order.is_none() {
            latest = self.orders.recv().ok();
        }
        if latest.is_some() {
            (self.order, self.next) = (latest, 0);
        }
        self.order.is_some()
    }

    /// Makes one picture; returns whether someone receives it.
    fn paint(&mut self) -> bool {
        let Some((number, request)) = &self.order else {
            return true;
        };
        let Some(choice) = request.choices.get(self.next) else {
            self.order = None;
            return true;
        };
        let image = image(&choice.shape, &request.files, &request.options);
        let is_received = self.made.send((*number, self.next, image)).is_ok();
        self.next += 1;
        (self.wake)();
        is_received
    }
}

/// Draws a pattern; `None` if it is none, or a baked map.
fn image(shape: &Shape, files: &Files, options: &PatternOptions) -> Option<ColorImage> {
    let pattern = match shape {
        Shape::File(path) if ShapeMap::is_shape_map_of(files, path).ok()? => return None,
        Shape::File(path) => Pattern::load_from(files, path, options).ok()?,
        Shape::Drawing(document) => Pattern::from_svg(document, options).ok()?,
        Shape::Text(_) | Shape::Pattern(_) => return None,
    };
    Some(reduced(&pattern))
}

/// Returns a pattern in [`PIXELS`] pixels or less, dark on light.
fn reduced(pattern: &Pattern) -> ColorImage {
    let sides = [pattern.width(), pattern.height()];
    let longer = sides[0].max(sides[1]);
    let size = sides.map(|side| (side * PIXELS.min(longer) / longer).max(1));
    // The pixels of the pattern under a pixel of the picture.
    let range = |axis: usize, at: u32| {
        let edge =
            |at: u32| (u64::from(at) * u64::from(sides[axis]) / u64::from(size[axis])) as u32;
        edge(at)..edge(at + 1)
    };
    let mut pixels = Vec::with_capacity((size[0] * size[1]) as usize);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let (columns, rows) = (range(0, x), range(1, y));
            let count = columns.len() * rows.len();
            let solid = rows
                .flat_map(|row| columns.clone().map(move |column| (column, row)))
                .filter(|&(column, row)| pattern.is_solid(column, row));
            let share = solid.count() as f32 / count as f32;
            let grey = GREYS[0] + (GREYS[1] - GREYS[0]) * share;
            pixels.push(Color32::from_gray(grey.round() as u8));
        }
    }
    ColorImage::new(size.map(|side| side as usize), pixels)
}

#[cfg(test)]
mod tests {
    use super::super::patterns::DRAWINGS;
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_picture_shows_the_shares_of_the_pattern() {
        let pattern = Pattern::from_fn(400, 200, |x, _| x < 100).unwrap();
        let image = reduced(&pattern);
        assert_eq!(image.size, [96, 48]);
        let row: Vec<u8> = image.pixels[..96].iter().map(|pixel| pixel.r()).collect();
        assert_eq!((row[0], row[23], row[24], row[95]), (40, 40, 240, 240));
        // Not enlarged.
        let small = reduced(&Pattern::from_fn(2, 3, |x, y| x == y).unwrap());
        assert_eq!(small.size, [2, 3]);
    }

    #[test]
    fn the_latest_request_is_painted_and_what_is_no_pattern_is_missing() {
        let woken = Arc::new(AtomicUsize::new(0));
        let wakes = woken.clone();
        let wake: Wake = Arc::new(move || {
            wakes.fetch_add(1, Ordering::Relaxed);
        });
        let files = Files::memory([
            ("no.png".into(), b"no picture".as_slice().into()),
            ("yes.pbm".into(), b"P1 2 1\n1 0\n".as_slice().into()),
        ]);
        let mut thumbnails = Thumbnails::new(wake);
        let scene = Scene::default().files(files);
        thumbnails.update(&scene, 128, true);
        thumbnails.update(&scene, 128, false);
        let count = DRAWINGS.len() + 2;
        let mut made = vec![None; count];
        let mut left = count;
        while left > 0 {
            let (number, index, image) = thumbnails.made.recv().unwrap();
            if number == thumbnails.number {
                made[index] = image;
                left -= 1;
            }
        }
        assert!(woken.load(Ordering::Relaxed) + 1 >= count);
        assert_eq!(made.iter().filter(|image| image.is_none()).count(), 1);
        assert!(made[count - 2].is_none(), "no.png");
        let yes = made[count - 1].as_ref().unwrap();
        assert_eq!((yes.pixels[0].r(), yes.pixels[1].r()), (40, 240));
    }
}
