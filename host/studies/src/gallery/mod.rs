//! The paper's figures, drawn by its algorithms and by ours, as one page.
//!
//! A figure is data: subjects ([`Subject`]) and ways to draw them ([`Way`]). A
//! [`Panel`] is one picture. [`write`](fn@write) turns each panel into a scene
//! file, a picture and measurements, and all panels into a Markdown page.

mod draw;
mod figures;
mod page;
mod scene;
mod truth;

pub use draw::{ChooseRenderer, Gallery, write};
pub use figures::FIGURES;

use relievo::scene::Extrusion;

/// One figure of the paper: every subject of a group in every way.
#[derive(Debug)]
pub struct Figure {
    /// Number in the paper.
    pub number: u32,
    /// Short title.
    pub title: &'static str,
    /// Caption.
    pub caption: &'static str,
    /// Ways to draw each subject.
    pub ways: &'static [Way],
    /// Subjects, in groups to compare.
    pub groups: &'static [&'static [Subject]],
}

/// A carved object and a camera.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// Name within the figure.
    pub label: &'static str,
    /// Mesh.
    pub model: Model,
    /// Pattern: a file in `patterns/`, without its extension.
    pub pattern: &'static str,
    /// Repeats of the pattern along u and v.
    pub repeat: [f64; 2],
    /// Depth S_z, world units.
    pub depth: f64,
    /// Extension, bevel and chamfer.
    pub extrusion: Extrusion,
    /// Eye, world units.
    pub eye: [f64; 3],
    /// Point at the picture's centre, world units.
    pub target: [f64; 3],
    /// Vertical field of view, degrees.
    pub field_of_view: f64,
}

/// A file in `meshes/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// 2,028 triangles; its closed form is known.
    Torus,
    /// 1,216 triangles.
    Sphere,
    /// 384 triangles, open above and below.
    Cylinder,
    /// 8 triangles.
    Plane,
}

/// How a panel is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Way {
    /// Name.
    pub label: &'static str,
    /// Algorithm.
    pub method: Method,
    /// Presentation of the result.
    pub show: Show,
}

/// Algorithm that finds the hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Extrusion mapping along straight rays: `tier = "planar"`.
    Planar,
    /// The paper's algorithms as printed: `tier = "paper"`.
    Paper,
    /// Bent rays: `tier = "fast"`.
    Fast,
    /// Relief mapping along the same bent rays: `technique = "relief"`.
    Relief,
}

/// Contents of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// Rendered scene.
    Picture,
    /// Rendered scene with the polygon mesh drawn over it.
    Mesh,
    /// The oracle's picture; torus only.
    Truth,
    /// Differences from the oracle; torus only.
    Errors,
}

/// One picture of a figure.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    /// Figure number.
    pub figure: u32,
    /// Subject.
    pub subject: &'static Subject,
    /// Way.
    pub way: &'static Way,
}

impl Figure {
    /// Returns the panels row by row: a row for each way and a column for each
    /// subject, or a single row for a group of one subject.
    pub fn rows(&self) -> Vec<Vec<Panel>> {
        let panel = |subject, way| Panel {
            figure: self.number,
            subject,
            way,
        };
        let rows = self.groups.iter().flat_map(|&group| match group {
            [subject] => vec![self.ways.iter().map(|way| panel(subject, way)).collect()],
            subjects => self
                .ways
                .iter()
                .map(|way| subjects.iter().map(|subject| panel(subject, way)).collect())
                .collect(),
        });
        rows.collect()
    }
}

impl Model {
    /// Returns the file in `meshes/`, without its extension.
    pub fn name(self) -> &'static str {
        match self {
            Model::Torus => "torus",
            Model::Sphere => "sphere",
            Model::Cylinder => "cylinder",
            Model::Plane => "plane",
        }
    }
}

impl Panel {
    /// Returns a label: subject and way.
    pub fn label(&self) -> String {
        format!("{}, {}", self.subject.label, self.way.label)
    }

    /// Returns the path of the picture, relative to the page.
    pub fn picture_file(&self) -> String {
        format!("pictures/{}.png", self.file_stem(self.way.label))
    }

    /// Returns the path of the scene, relative to the page. Panels that differ
    /// only in [`Show`] share it.
    pub fn scene_file(&self) -> String {
        let method = match self.way.method {
            Method::Planar => "planar",
            Method::Paper => "paper",
            Method::Fast => "fast",
            Method::Relief => "relief",
        };
        format!("scenes/{}.toml", self.file_stem(method))
    }

    fn file_stem(&self, way: &str) -> String {
        let text = format!("figure {:02} {} {way}", self.figure, self.subject.label);
        let words: Vec<&str> = text
            .split(|c: char| !c.is_ascii_alphanumeric())
            .filter(|word| !word.is_empty())
            .collect();
        words.join("-")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn panels() -> Vec<Panel> {
        FIGURES.iter().flat_map(Figure::rows).flatten().collect()
    }

    #[test]
    fn every_figure_asked_for_is_there_in_full() {
        let numbers: Vec<u32> = FIGURES.iter().map(|figure| figure.number).collect();
        assert_eq!(numbers, [2, 6, 11, 12, 13, 14, 15, 16]);
        for figure in FIGURES {
            let subjects: usize = figure.groups.iter().map(|group| group.len()).sum();
            let panels: usize = figure.rows().iter().map(Vec::len).sum();
            assert!(subjects > 0 && panels == subjects * figure.ways.len());
        }
    }

    #[test]
    fn no_two_pictures_share_a_file() {
        let panels = panels();
        let files: BTreeSet<String> = panels.iter().map(Panel::picture_file).collect();
        assert_eq!(files.len(), panels.len());
        assert!(files.contains("pictures/figure-16-torus-from-near-paper-errors.png"));
    }

    #[test]
    fn only_the_torus_is_compared_with_the_oracle() {
        for panel in panels() {
            let needs_oracle = matches!(panel.way.show, Show::Truth | Show::Errors);
            assert!(!needs_oracle || panel.subject.model == Model::Torus);
        }
    }
}
