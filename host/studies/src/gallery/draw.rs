//! Draws, measures and writes every panel.

use super::page::{Drawn, Numbers, markdown};
use super::scene::scene_text;
use super::truth::truth_picture;
use super::{Figure, Model, Panel, Show};
use glam::DVec3;
use relievo::Error;
use relievo::file::write_bytes;
use relievo::files::relative;
use relievo::oracle::{AnalyticOracle, Torus, Truth};
use relievo::overlay::draw_mesh;
use relievo::picture::Picture;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::{RenderError, Renderer};
use relievo::scene::{Color, Development, Scene};
use std::path::PathBuf;
use std::time::Instant;

/// Line colour of the polygon mesh.
const MESH_COLOR: Color = Color::from_hex(0x10_1418);

/// Closed form of [`Model::Torus`].
const TORUS: Torus = Torus {
    major: 1.0,
    minor: 0.4,
};

/// Gallery options.
#[derive(Clone, Debug)]
pub struct Gallery {
    /// Folder with `meshes` and `patterns`.
    pub assets: PathBuf,
    /// Output folder, created if missing.
    pub output: PathBuf,
    /// Width and height of every picture, pixels.
    pub size: [u32; 2],
}

/// Creates the renderer of a scene.
pub type ChooseRenderer<'f> =
    dyn for<'a> Fn(&'a PreparedScene) -> Result<Box<dyn Renderer + 'a>, RenderError> + 'f;

/// Draws `figures` and writes their pictures, scenes and the page `index.md`,
/// whose path it returns, to the output folder. `progress` receives a message
/// and the fraction done.
///
/// The page is written last. After an interruption, run it again: all files are
/// rewritten.
///
/// # Errors
/// [`Error`] of the first panel whose assets cannot be used, that cannot be
/// drawn, or whose files cannot be written.
///
/// # Panics
/// A panel with [`Show::Truth`] or [`Show::Errors`] does not show a
/// torus.
pub fn write(
    gallery: &Gallery,
    figures: &[Figure],
    choose: &ChooseRenderer<'_>,
    progress: &dyn Fn(&str, f64),
) -> Result<PathBuf, Error> {
    let scenes = gallery.output.join("scenes");
    let failed = |source| Error::Write {
        path: scenes.clone(),
        source,
    };
    std::fs::create_dir_all(&scenes).map_err(failed)?;
    let from = scenes.canonicalize().map_err(failed)?;
    // If the assets are missing, loading the first mesh reports it.
    let to = gallery
        .assets
        .canonicalize()
        .unwrap_or_else(|_| gallery.assets.clone());
    let assets = relative(&from, &to);

    let total: usize = figures
        .iter()
        .flat_map(Figure::rows)
        .map(|row| row.len())
        .sum();
    let mut done = 0;
    let mut drawn = Vec::with_capacity(figures.len());
    for figure in figures {
        let mut rows = Vec::new();
        for row in figure.rows() {
            let mut panels = Vec::with_capacity(row.len());
            for panel in row {
                let what = format!("figure {}: {}", figure.number, panel.label());
                progress(&what, done as f64 / total as f64);
                let numbers = draw(gallery, &panel, &assets, choose)?;
                panels.push(Drawn { panel, numbers });
                done += 1;
            }
            rows.push(panels);
        }
        drawn.push((figure, rows));
    }
    let page = gallery.output.join("index.md");
    write_bytes(&page, markdown(&drawn, gallery.size).as_bytes())?;
    Ok(page)
}

/// Writes scene and picture of one panel.
fn draw(
    gallery: &Gallery,
    panel: &Panel,
    assets: &str,
    choose: &ChooseRenderer<'_>,
) -> Result<Numbers, Error> {
    let path = gallery.output.join(panel.scene_file());
    let text = scene_text(panel, assets, gallery.size);
    write_bytes(&path, text.as_bytes())?;
    let scene = Scene::parse(&text, &path)?;
    let prepared = prepare(&scene, &|_| ())?;
    let mut renderer = choose(&prepared)?;

    let factor = prepared.supersampling;
    let start = Instant::now();
    let colors = renderer.color(&prepared.frame_with_samples(factor))?;
    let time = start.elapsed();
    let words = renderer.geometry(&prepared.frame)?;

    let oracle = (panel.subject.model == Model::Torus)
        .then(|| AnalyticOracle::new(&TORUS, &scene.objects[0], &prepared.objects[0]));
    let truth = oracle
        .as_ref()
        .map(|oracle| Truth::of(oracle, DVec3::from(prepared.camera.eye), &prepared.frame));

    let picture = match panel.way.show {
        Show::Picture => Picture::develop(&colors, factor, &Development::default())?,
        Show::Mesh => {
            let mut picture = Picture::develop(&colors, factor, &Development::default())?;
            draw_mesh(&mut picture, &prepared, MESH_COLOR)?;
            picture
        }
        Show::Truth => {
            let oracle = oracle.as_ref().expect("an oracle knows the torus only");
            truth_picture(oracle, &prepared)?
        }
        Show::Errors => {
            let truth = truth.as_ref().expect("an oracle knows the torus only");
            truth.picture(&words)
        }
    };
    let software = concat!("relievo ", env!("CARGO_PKG_VERSION"));
    picture.save_png(
        &gallery.output.join(panel.picture_file()),
        &[("Software", software), ("relievo-scene", &text)],
    )?;

    let (covered, steps) = words.coverage();
    Ok(Numbers {
        covered,
        steps,
        time,
        renderer: renderer.name(),
        accuracy: truth.map(|truth| truth.compare(&words)),
    })
}

#[cfg(test)]
mod tests {
    use super::super::FIGURES;
    use super::*;
    use relievo::render::CpuRenderer;
    use std::path::Path;
    use std::sync::Mutex;

    /// Figure 16 on a few pixels, twice into the same folder.
    #[test]
    fn a_gallery_is_complete_and_can_be_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let gallery = Gallery {
            assets: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets"),
            output: folder.path().join("new/gallery"),
            size: [40, 30],
        };
        let figures = &FIGURES[FIGURES.len() - 1..];
        let heard = Mutex::new(Vec::new());
        for _ in 0..2 {
            let page = write(
                &gallery,
                figures,
                &|scene| Ok(Box::new(CpuRenderer::new(scene))),
                &|_, fraction| heard.lock().unwrap().push(fraction),
            )
            .unwrap();
            assert_eq!(page, gallery.output.join("index.md"));
        }
        let markdown = std::fs::read_to_string(gallery.output.join("index.md")).unwrap();
        let panels: Vec<Panel> = figures[0].rows().concat();
        assert_eq!(heard.lock().unwrap().len(), 2 * panels.len());
        for panel in panels {
            for file in [panel.picture_file(), panel.scene_file()] {
                assert!(markdown.contains(&file), "{file}");
                assert!(gallery.output.join(&file).is_file(), "{file}");
            }
            // The scene can be rendered where it was written.
            let scene = Scene::load(&gallery.output.join(panel.scene_file())).unwrap();
            assert_eq!(scene.size, gallery.size);
            assert!(scene.objects[0].mesh.file().unwrap().is_file());
            assert!(scene.objects[0].files().all(Path::is_file));
            let picture = image::open(gallery.output.join(panel.picture_file())).unwrap();
            assert_eq!((picture.width(), picture.height()), (40, 30));
        }
    }

    #[test]
    fn missing_assets_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let gallery = Gallery {
            assets: folder.path().join("nowhere"),
            output: folder.path().join("gallery"),
            size: [4, 3],
        };
        let message = write(
            &gallery,
            FIGURES,
            &|scene| Ok(Box::new(CpuRenderer::new(scene))),
            &|_, _| (),
        )
        .unwrap_err()
        .to_string();
        assert!(message.contains("nowhere"), "{message}");
    }
}
