//! What the viewer saves: pictures, the scene, its shaders.

use super::{Drawn, PATIENCE, Viewer};
use crate::Files;
use crate::export::{ExportedFile, Options, export};
use crate::picture::Picture;
use crate::prepare::finer;
use crate::scene::Scene;
use eframe::egui::{self, ColorImage, Rect};
use std::sync::{Arc, OnceLock};

/// What a picture is called, and what it is of.
pub(super) struct Caption {
    file: String,
    /// The scene, as a scene file.
    scene: String,
}

/// A picture of the screen, for a file.
#[derive(Default)]
pub(super) enum Shot {
    /// Nobody wants one.
    #[default]
    None,
    /// As soon as the screen shows all that was asked for.
    Wanted,
    /// The window was asked for it.
    Taken(Taken),
}

/// A picture of the window that is under way.
pub(super) struct Taken {
    caption: Caption,
    /// Where the picture was in the window, and what it showed. The next pass is
    /// the one that is taken, and must have the same.
    rectangle: Rect,
    drawn: Option<Drawn>,
    is_certain: bool,
    /// Pixels for a point.
    scale: f32,
    /// The whole window, once it is there.
    image: Arc<OnceLock<Arc<ColorImage>>>,
}

impl Viewer {
    /// The scene as it would be saved, with the camera of the screen.
    pub(super) fn saved_scene(&self) -> Scene {
        Scene {
            camera: self.camera,
            ..self.scene.clone()
        }
    }

    /// Says where files are, or what stands against it.
    fn report(&mut self, saved: Result<String, String>) {
        match saved {
            Ok(place) => self.say(format!("Saved {place}")),
            Err(problem) => self.complain(problem),
        }
    }

    /// Saves the scene, with the files that it names where they are on no disk.
    pub(super) fn save_scene(&mut self) {
        let scene = self.saved_scene();
        let name = format!("{}.toml", self.name);
        let text = scene.to_toml(self.platform.folder()).into_bytes();
        let Files::Memory(all) = &scene.files else {
            let saved = self.platform.save_file(&name, &text);
            return self.report(saved);
        };
        let mut files = vec![ExportedFile { name, bytes: text }];
        for path in scene.objects.iter().flat_map(|object| object.files()) {
            let path = crate::files::normal(path);
            let name = path.to_string_lossy().into_owned();
            if let Some(bytes) = all.get(&path)
                && files.iter().all(|file| file.name != name)
            {
                let bytes = bytes.to_vec();
                files.push(ExportedFile { name, bytes });
            }
        }
        let saved = self.platform.save_folder(&self.name, &files);
        self.report(saved);
    }

    /// Saves the shaders of the scene, and all that they read.
    pub(super) fn export(&mut self) {
        let Some(first) = self.prepared.first() else {
            return;
        };
        let folder = format!("{}-shaders", self.name);
        let saved = export(first, &Options::default())
            .map_err(|error| error.to_string())
            .and_then(|files| self.platform.save_folder(&folder, &files));
        self.report(saved);
    }

    /// Begins to draw the picture as `render` would.
    pub(super) fn save_picture(&mut self) {
        let Some(camera) = self.camera.filter(|_| self.ordered == self.shown) else {
            return;
        };
        let factor = self.scene.supersampling;
        let frames = self.frames(&camera, self.scene.size);
        let Some(frame) = frames.first() else { return };
        match self.stage.save(&finer(frame, factor), factor) {
            Ok(()) => self.saving = Some(self.caption("")),
            Err(error) => self.complain(error.to_string()),
        }
        // The scene on the device has another camera now.
        self.drawn = None;
    }

    /// Saves the picture that [`Viewer::save_picture`] began, once it is there.
    pub(super) fn finish_picture(&mut self) {
        if self.saving.is_none() {
            return;
        }
        let Some(picture) = self.stage.saved() else {
            return;
        };
        let Some(caption) = self.saving.take() else {
            return;
        };
        match picture {
            Ok(picture) => self.save_as(&caption, &picture),
            Err(error) => self.complain(error.to_string()),
        }
    }

    /// Of a picture of the scene as it is now; `what` is added to its name.
    fn caption(&self, what: &str) -> Caption {
        Caption {
            file: format!("{}{what}.png", self.name),
            scene: self.saved_scene().to_toml(self.platform.folder()),
        }
    }

    fn save_as(&mut self, caption: &Caption, picture: &Picture) {
        let software = concat!("relievo ", env!("CARGO_PKG_VERSION"));
        let comments = [
            ("Software", software),
            ("relievo-scene", caption.scene.as_str()),
        ];
        let saved = picture
            .png(&comments)
            .map_err(|error| error.to_string())
            .and_then(|png| self.platform.save_file(&caption.file, &png));
        self.report(saved);
    }

    /// Saves what the screen shows where the picture is, once it stands still:
    /// another view of the words, two tiers, the wireframe, errors.
    pub(super) fn save_shown(&mut self) {
        self.shot = Shot::Wanted;
    }

    /// Takes the picture of the screen that is wanted: `rectangle` of the window,
    /// which `is_complete` if it shows all that was asked for.
    pub(super) fn take_shot(
        &mut self,
        context: &egui::Context,
        rectangle: Rect,
        is_complete: bool,
    ) {
        match &mut self.shot {
            Shot::Taken(taken) if !taken.is_certain => {
                if is_complete && taken.rectangle == rectangle && taken.drawn == self.drawn {
                    taken.is_certain = true;
                } else {
                    self.shot = Shot::Wanted;
                }
            }
            Shot::Wanted if is_complete => {
                let image = Arc::new(OnceLock::new());
                self.shot = Shot::Taken(Taken {
                    caption: self.caption("-shown"),
                    rectangle,
                    drawn: self.drawn.clone(),
                    is_certain: false,
                    scale: context.pixels_per_point(),
                    image: image.clone(),
                });
                let waker = context.clone();
                context.request_screenshot(move |whole| {
                    // It is told once.
                    let _ = image.set(whole);
                    waker.request_repaint();
                });
                context.request_repaint();
            }
            _ => {}
        }
    }

    /// Saves the picture of the screen, once it is there.
    pub(super) fn finish_shot(&mut self, context: &egui::Context) {
        let Shot::Taken(taken) = &self.shot else {
            return;
        };
        // Asked first: who held it has told before.
        let is_over = Arc::strong_count(&taken.image) == 1;
        match taken.image.get() {
            // Before the pass that says whether it can be used.
            Some(_) if !taken.is_certain => {}
            Some(whole) => {
                let pixels = taken.rectangle * taken.scale;
                let part = [pixels.left(), pixels.top(), pixels.width(), pixels.height()];
                let picture = cut(whole, part.map(|side| side.round() as usize));
                if let Shot::Taken(taken) = std::mem::take(&mut self.shot) {
                    self.save_as(&taken.caption, &picture);
                }
            }
            None if is_over => {
                self.shot = Shot::None;
                self.complain("the pixels of this window cannot be read".to_string());
            }
            // Devices tell of it while they are given work.
            None => context.request_repaint_after(PATIENCE),
        }
    }
}

/// A part of an image: left, top, width and height, as far as it lies in it.
fn cut(image: &ColorImage, [left, top, width, height]: [usize; 4]) -> Picture {
    let [right, bottom] = [left + width, top + height];
    let [right, bottom] = [right.min(image.width()), bottom.min(image.height())];
    let [left, top] = [left.min(right), top.min(bottom)];
    let rows = (top..bottom).flat_map(|row| {
        let start = row * image.width();
        &image.pixels[start + left..start + right]
    });
    Picture {
        width: (right - left) as u32,
        height: (bottom - top) as u32,
        bytes: rows
            .flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()])
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::Color32;

    #[test]
    fn a_part_is_cut_out_as_far_as_it_is_there() {
        let pixels = (0..12).map(|number| Color32::from_rgb(number, 0, 0));
        let image = ColorImage::new([4, 3], pixels.collect());
        let reds = |part| {
            let picture = cut(&image, part);
            let reds = picture.bytes.chunks(3).map(|pixel| pixel[0]);
            (picture.width, picture.height, reds.collect::<Vec<_>>())
        };
        assert_eq!(reds([1, 1, 2, 2]), (2, 2, vec![5, 6, 9, 10]));
        assert_eq!(reds([3, 2, 9, 9]), (1, 1, vec![11]));
        assert_eq!(reds([9, 9, 1, 1]), (0, 0, vec![]));
    }
}
