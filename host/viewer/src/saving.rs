//! Saving of pictures, scenes and shaders.

use super::{Drawn, PATIENCE, Viewer};
use eframe::egui::{self, ColorImage, Rect};
use relievo::Files;
use relievo::export::{ExportedFile, Options, export};
use relievo::picture::Picture;
use relievo::prepare::finer;
use relievo::scene::Scene;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// File name and contents of a picture.
pub(super) struct Caption {
    file: String,
    /// Scene file of the picture.
    scene: String,
}

/// Progress of a screenshot.
#[derive(Default)]
pub(super) enum Shot {
    /// None requested.
    #[default]
    None,
    /// Waits until the screen is up to date.
    Wanted,
    /// Requested from the window.
    Taken(Box<Taken>),
}

/// A screenshot in progress.
pub(super) struct Taken {
    caption: Caption,
    /// Rectangle and contents at the request. The screenshot is taken in the
    /// next pass, which must match.
    rectangle: Rect,
    drawn: Option<Drawn>,
    is_certain: bool,
    /// Pixels per point.
    scale: f32,
    /// The whole window, once received.
    image: Arc<OnceLock<Arc<ColorImage>>>,
}

impl Viewer {
    /// Returns the scene with the current camera.
    pub(super) fn saved_scene(&self) -> Scene {
        self.scene.seen_from(self.camera)
    }

    /// Shows where files were saved, or the error.
    fn report(&mut self, saved: Result<String, String>) {
        match saved {
            Ok(place) => self.say(format!("Saved {place}")),
            Err(problem) => self.complain(problem),
        }
    }

    /// Saves the scene, with the files that are not on disk.
    pub(super) fn save_scene(&mut self) {
        let scene = self.saved_scene();
        let name = format!("{}.toml", self.name);
        let text = scene.to_toml(self.platform.folder()).into_bytes();
        let Files::Memory(all) = &scene.files else {
            let saved = self.platform.save_file(&name, &text);
            return self.report(saved);
        };
        let mut files = vec![ExportedFile { name, bytes: text }];
        for path in scene.named_files() {
            let path = relievo::files::normal(&path);
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

    /// Copies the address that shows the scene.
    pub(super) fn copy_link(&mut self, context: &egui::Context) {
        match self.platform.link(&self.saved_scene()) {
            Ok(link) => {
                let length = link.len();
                context.copy_text(link);
                self.say(format!("Copied a link of {length} characters"));
            }
            Err(problem) => self.complain(problem),
        }
    }

    /// Exports the scene's shaders with their input data.
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

    /// Starts rendering the picture as `relievo render` would.
    pub(super) fn save_picture(&mut self) {
        let Some(camera) = self.camera.filter(|_| self.ordered == self.shown) else {
            return;
        };
        let factor = self.scene.supersampling;
        let frames = self.frames(&camera, self.scene.size);
        let Some(frame) = frames.first() else { return };
        match self
            .stage
            .save(&finer(frame, factor), factor, self.scene.development)
        {
            Ok(()) => self.saving = Some(self.caption("")),
            Err(error) => self.complain(error.to_string()),
        }
        // The device now holds another camera.
        self.drawn = None;
    }

    /// Saves the picture started by [`Viewer::save_picture`] once it is
    /// finished.
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

    /// Describes a picture of the current scene; `what` is appended to its
    /// name.
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

    /// Requests a screenshot of the picture area, taken once the view is up to
    /// date: any quantity, two tiers, wireframe or analysis.
    pub(super) fn save_shown(&mut self) {
        self.shot = Shot::Wanted;
    }

    /// Takes the requested screenshot of `rectangle`, points, if `is_complete`:
    /// the screen is up to date.
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
                self.shot = Shot::Taken(Box::new(Taken {
                    caption: self.caption("-shown"),
                    rectangle,
                    drawn: self.drawn.clone(),
                    is_certain: false,
                    scale: context.pixels_per_point(),
                    image: image.clone(),
                }));
                let waker = context.clone();
                context.request_screenshot(move |whole| {
                    // Reported once only.
                    let _ = image.set(whole);
                    waker.request_repaint();
                });
                context.request_repaint();
            }
            _ => {}
        }
    }

    /// Saves the screenshot once received.
    pub(super) fn finish_shot(&mut self, context: &egui::Context) {
        let Shot::Taken(taken) = &self.shot else {
            return;
        };
        // Checked first: a failed device has reported already.
        let is_over = Arc::strong_count(&taken.image) == 1;
        match taken.image.get() {
            // Arrived before the pass that decides whether it is usable.
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
            // Devices report it only while they are given work.
            None => context.request_repaint_after(PATIENCE),
        }
    }
}

/// Returns the name of files saved of the scene in `path`, without an ending.
pub(super) fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    format!("{}-view", stem.trim_end_matches("-view"))
}

/// Crops an image to left, top, width and height, clipped to its size.
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
