//! The list of files from which one is opened, within the window.

use super::dropped::{Arrived, MESHES, SCENES};
use super::patterns::{ENDINGS, has_ending};
use super::probe::Collector;
use eframe::egui::{self, Key};
use std::path::{Path, PathBuf};

/// The list while it is shown.
pub struct Browse {
    /// Folder, as the user wrote it.
    folder: String,
    /// Listed folder and its entries: folders, then files.
    listed: Option<(PathBuf, Result<Vec<Entry>, String>)>,
}

/// A folder or a file.
struct Entry {
    name: String,
    path: PathBuf,
    is_folder: bool,
}

impl Browse {
    /// Creates the list of a folder.
    pub fn new(folder: &Path) -> Browse {
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
        Browse {
            folder: folder.to_string_lossy().into_owned(),
            listed: None,
        }
    }

    /// Shows the list; `arrived` receives the file that is chosen. Returns whether the
    /// list is still shown.
    pub fn show(
        &mut self,
        context: &egui::Context,
        collector: &Collector,
        arrived: &Arrived,
    ) -> bool {
        let mut is_open = !context.input(|input| input.key_pressed(Key::Escape));
        let mut chosen = None;
        egui::Window::new("Open")
            .open(&mut is_open)
            .default_size([420.0, 360.0])
            .collapsible(false)
            .show(context, |ui| {
                let field = egui::TextEdit::singleline(&mut self.folder)
                    .desired_width(f32::INFINITY)
                    .hint_text("Folder");
                let field = ui.add(field);
                field.widget_info(|| {
                    egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Folder")
                });
                collector.add("Folder", field.rect, &self.folder);
                let folder = PathBuf::from(&self.folder);
                if self
                    .listed
                    .as_ref()
                    .is_none_or(|(listed, _)| *listed != folder)
                {
                    let entries = entries(&folder);
                    self.listed = Some((folder, entries));
                }
                ui.separator();
                egui::ScrollArea::vertical()
                    .auto_shrink(false)
                    .show(ui, |ui| match &self.listed {
                        Some((_, Ok(entries))) => {
                            for entry in entries {
                                let response = ui.selectable_label(false, &entry.name);
                                let label = format!("Open: {}", entry.name);
                                collector.add(&label, response.rect, "");
                                if response.clicked() {
                                    chosen = Some((entry.path.clone(), entry.is_folder));
                                }
                            }
                        }
                        Some((_, Err(problem))) => {
                            ui.colored_label(ui.visuals().error_fg_color, problem);
                        }
                        None => {}
                    });
            });
        match chosen {
            Some((path, true)) => self.folder = path.to_string_lossy().into_owned(),
            Some((path, false)) => {
                arrived.add(path, Ok(Vec::new()));
                context.request_repaint();
                return false;
            }
            None => {}
        }
        is_open
    }
}

/// Returns the folders and the files that can be opened, and the folder around.
fn entries(folder: &Path) -> Result<Vec<Entry>, String> {
    let problem = |error| format!("{}: {error}; write another folder", folder.display());
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(problem)? {
        let path = entry.map_err(problem)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_folder = path.is_dir();
        let kinds: [&[&str]; 3] = [&MESHES, &SCENES, &ENDINGS];
        let is_known = kinds.into_iter().any(|kind| has_ending(&path, kind));
        if name.starts_with('.') || !(is_folder || is_known) {
            continue;
        }
        let name = if is_folder {
            format!("{name}/")
        } else {
            name.into_owned()
        };
        all.push(Entry {
            name,
            path,
            is_folder,
        });
    }
    all.sort_by_key(|entry| (!entry.is_folder, entry.name.to_lowercase()));
    if let Some(around) = folder.parent() {
        all.insert(
            0,
            Entry {
                name: "..".to_string(),
                path: around.to_path_buf(),
                is_folder: true,
            },
        );
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_come_before_the_files_that_can_be_opened() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("meshes")).unwrap();
        for name in ["b.toml", "A.OBJ", "c.svg", "notes.txt", ".hidden.png"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let all = entries(folder.path()).unwrap();
        let names: Vec<&str> = all.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(names, ["..", "meshes/", "A.OBJ", "b.toml", "c.svg"]);
        let Err(problem) = entries(&folder.path().join("none")) else {
            panic!("there is no such folder");
        };
        assert!(problem.contains("write another folder"), "{problem}");
    }
}
