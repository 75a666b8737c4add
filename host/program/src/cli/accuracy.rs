//! `relievo accuracy`.

use super::Backend;
use super::limits::LimitArguments;
use super::parse_size;
use super::say;
use super::session::{Loaded, choose_renderer, load};
use anyhow::Context;
use clap::{Args, ValueEnum};
use glam::DVec3;
use relievo::Error;
use relievo::file::write_bytes;
use relievo::oracle::{
    AnalyticOracle, MeshOracle, Nearest, Oracle, SceneReport, Truth, UnknownShape,
};
use std::path::{Path, PathBuf};

/// The reference to compare with.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Against {
    /// The closed form of the surface that the mesh approximates
    Analytic,
    /// The mesh itself as curved prisms, in double precision
    Mesh,
}

#[derive(Args)]
pub struct AccuracyArguments {
    /// Scene files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Reference to compare with
    #[arg(long, value_enum, default_value_t = Against::Analytic)]
    against: Against,
    /// Write accuracy.json, and a picture of the errors of each scene, into this folder: holes red,
    /// inside the outline purple, extra pixels blue, another class yellow
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Size of the pictures instead of the scenes'
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Renderer
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    #[command(flatten)]
    limits: LimitArguments,
}

pub fn run(arguments: &AccuracyArguments) -> anyhow::Result<()> {
    if let Some(folder) = &arguments.output {
        std::fs::create_dir_all(folder).map_err(|source| Error::Write {
            path: folder.clone(),
            source,
        })?;
    }
    let mut reports = Vec::new();
    for (number, path) in arguments.scenes.iter().enumerate() {
        let report = judge(number, path, arguments)?;
        say(format_args!("{report}"))?;
        reports.push(report);
    }
    let Some(folder) = &arguments.output else {
        return Ok(());
    };
    let path = folder.join("accuracy.json");
    let json = serde_json::to_string_pretty(&reports).context("cannot write the report as JSON")?;
    write_bytes(&path, json.as_bytes()).map_err(relievo::Error::from)?;
    say(format_args!("{}", path.display()))
}

/// Renders and judges a scene, and draws its errors if an output was asked for.
fn judge(number: usize, path: &Path, arguments: &AccuracyArguments) -> anyhow::Result<SceneReport> {
    let loaded = load(path, arguments.size, &arguments.limits.limits())?;
    let scene = &loaded.prepared;
    let (oracle, objects) = match arguments.against {
        Against::Analytic => analytic(&loaded).with_context(|| path.display().to_string())?,
        Against::Mesh => {
            let objects = loaded.scene.objects.iter();
            let names = objects.map(|object| format!("{} {}", object.tier.name(), object.name));
            let oracle: Box<dyn Oracle> = Box::new(MeshOracle::new(scene));
            (oracle, names.collect())
        }
    };

    let (mut renderer, _) =
        choose_renderer(arguments.backend, None, scene, &loaded.plans).map_err(Error::from)?;
    let words = renderer.geometry(&scene.frame).map_err(Error::from)?;
    let truth = Truth::of(oracle.as_ref(), DVec3::from(scene.camera.eye), &scene.frame);
    if let Some(folder) = &arguments.output {
        // The number distinguishes scenes of the same name in several folders.
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let file = folder.join(format!("{:02}-{stem}.png", number + 1));
        let software = concat!("relievo ", env!("CARGO_PKG_VERSION"));
        let comments = [
            ("Software", software),
            ("relievo-scene", loaded.scene.text.as_str()),
        ];
        truth.picture(&words).save_png(&file, &comments)?;
        log::info!("{}", file.display());
    }
    Ok(SceneReport {
        scene: path.to_path_buf(),
        size: scene.size,
        renderer: renderer.name(),
        objects,
        accuracy: truth.compare(&words),
    })
}

/// Returns the closed forms of a scene's objects, and their names.
fn analytic(loaded: &Loaded) -> Result<(Box<dyn Oracle + '_>, Vec<String>), UnknownShape> {
    let (mut oracles, mut names) = (Vec::new(), Vec::new());
    for prepared in &loaded.prepared.objects {
        let object = &loaded.scene.objects[prepared.number];
        let oracle = AnalyticOracle::find(object, prepared)?;
        names.push(format!("{} {}", object.tier.name(), oracle.shape.name()));
        oracles.push(Box::new(oracle) as Box<dyn Oracle>);
    }
    Ok((Box::new(Nearest(oracles)), names))
}
