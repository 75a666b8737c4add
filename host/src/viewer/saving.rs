//! What the viewer saves: pictures, the scene, its shaders.

use super::{PATIENCE, Viewer};
use crate::Files;
use crate::export::{ExportedFile, Options, export};
use crate::picture::Picture;
use crate::prepare::finer;
use crate::scene::Scene;
use eframe::egui::{self, ColorImage, Rect};
use std::sync::{Arc, OnceLock};

/// A picture of the screen, for a file.
#[derive(Default)]
pub(super) enum Shot {
    /// Nobody wants one.
    #[default]
    None,
    /// As soon as the screen shows all that was asked for.
    Wanted,
    /// Of this part of the window, pixels from its left and top; there when it is.
    Taken([usize; 4], Arc<OnceLock<Arc<ColorImage>>>),
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
            Ok(()) => self.is_saving = true,
            Err(error) => self.complain(error.to_string()),
        }
        // The scene on the device has another camera now.
        self.drawn = None;
    }

    /// Saves the picture that [`Viewer::save_picture`] began, once it is there.
    pub(super) fn finish_picture(&mut self) {
        if !self.is_saving {
            return;
        }
        let Some(picture) = self.stage.saved() else {
            return;
        };
        self.is_saving = false;
        match picture {
            Ok(picture) => self.save_as(&format!("{}.png", self.name), &picture),
            Err(error) => self.complain(error.to_string()),
        }
    }

    fn save_as(&mut self, name: &str, picture: &Picture) {
        let text = self.saved_scene().to_toml(self.platform.folder());
        let software = concat!("relievo ", env!("CARGO_PKG_VERSION"));
        let comments = [("Software", software), ("relievo-scene", text.as_str())];
        let saved = picture
            .png(&comments)
            .map_err(|error| error.to_string())
            .and_then(|png| self.platform.save_file(name, &png));
        self.report(saved);
    }

    /// Saves what the screen shows where the picture is, once it stands still:
    /// another view of the words, two tiers, the wireframe, errors.
    pub(super) fn save_shown(&mut self) {
        self.shot = Shot::Wanted;
    }

    /// Takes the picture of the screen that is wanted, if it is complete:
    /// `rectangle` of the window.
    pub(super) fn take_shot(&mut self, context: &egui::Context, rectangle: Rect) {
        let is_complete = self.probe.settled && self.is_judged == self.judgement.is_some();
        if !matches!(self.shot, Shot::Wanted) || !is_complete {
            return;
        }
        let pixels = rectangle * context.pixels_per_point();
        let part = [pixels.left(), pixels.top(), pixels.width(), pixels.height()];
        let image = Arc::new(OnceLock::new());
        self.shot = Shot::Taken(part.map(|side| side.round() as usize), image.clone());
        let waker = context.clone();
        context.request_screenshot(move |whole| {
            // It is told once.
            let _ = image.set(whole);
            waker.request_repaint();
        });
        context.request_repaint();
    }

    /// Saves the picture of the screen, once it is there.
    pub(super) fn finish_shot(&mut self, context: &egui::Context) {
        let Shot::Taken(part, image) = &self.shot else {
            return;
        };
        let Some(whole) = image.get() else {
            // Devices tell of it while they are given work.
            context.request_repaint_after(PATIENCE);
            return;
        };
        let picture = cut(whole, *part);
        self.shot = Shot::None;
        self.save_as(&format!("{}-shown.png", self.name), &picture);
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
