//! The figures of the paper, drawn by its algorithms and by ours, as one page.
//!
//! A figure is data: what is shown ([`Subject`]) and how ([`Way`]); a [`Panel`]
//! is one picture of it. [`write`](fn@write) makes of every panel a scene file, a picture
//! and numbers, and of all panels a page in HTML and one in Markdown.

mod draw;
mod figures;
mod page;
mod scene;
mod truth;

pub use draw::{ChooseRenderer, Gallery, Numbers, write};
pub use figures::FIGURES;

use crate::scene::Extrusion;

/// One figure of the paper: every subject of a group in every way.
#[derive(Debug)]
pub struct Figure {
    /// Its number in the paper.
    pub number: u32,
    /// What it shows, a few words.
    pub title: &'static str,
    /// What to look at.
    pub caption: &'static str,
    /// The ways to draw each subject.
    pub ways: &'static [Way],
    /// What is drawn, in groups that are compared with each other.
    pub groups: &'static [&'static [Subject]],
}

/// What a panel shows: a carved object and the eye that sees it.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// Its name within the figure.
    pub label: &'static str,
    /// The mesh.
    pub model: Model,
    /// The pattern, a file of `patterns/` without its extension.
    pub pattern: &'static str,
    /// Repeats of the pattern along u and v.
    pub repeat: [f64; 2],
    /// S_z, world units.
    pub depth: f64,
    /// How the pattern grows.
    pub extrusion: Extrusion,
    /// The eye, world units.
    pub eye: [f64; 3],
    /// The point in the picture's centre.
    pub target: [f64; 3],
    /// Vertical field of view, degrees.
    pub field_of_view: f64,
}

/// The meshes of `meshes/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// 2,028 triangles; the oracle knows its closed form.
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
    /// Its name.
    pub label: &'static str,
    /// The algorithm.
    pub method: Method,
    /// What is made of its result.
    pub show: Show,
}

/// What finds the hits.
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

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// The scene.
    Picture,
    /// The scene with the polygon mesh over it.
    Mesh,
    /// What the oracle sees in its place; torus only.
    Truth,
    /// Where the scene differs from what the oracle sees; torus only.
    Errors,
}

/// One picture of a figure.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    /// The figure's number.
    pub figure: u32,
    /// What it shows.
    pub subject: &'static Subject,
    /// How.
    pub way: &'static Way,
}

impl Figure {
    /// The panels as they lie on the page, row by row: a row for each way and a
    /// column for each subject, or one row where a group has one subject.
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
    /// The file of `meshes/` without its extension.
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
    /// Subject and way, for a person.
    pub fn label(&self) -> String {
        format!("{}, {}", self.subject.label, self.way.label)
    }

    /// The picture's file, relative to the page.
    pub fn picture_file(&self) -> String {
        format!("pictures/{}.png", self.file_stem(self.way.label))
    }

    /// The scene's file, relative to the page; panels that differ only in what
    /// they show of the same scene share it.
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
