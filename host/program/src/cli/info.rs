//! `relievo info`.

use super::bake::describe;
use super::limits::LimitArguments;
use super::say;
use super::session::{Loaded, load, refuse_input};
use clap::Args;
use relievo::Error;
use relievo::overlay::local_depth_picture;
use relievo::render::gpu::adapters;
use std::mem::size_of_val;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct InfoArguments {
    /// Scene file; without it only the adapters are shown
    scene: Option<PathBuf>,
    /// Also draw where the depth is reduced: yellow for a little, green for 1/8 of the depth,
    /// dark blue for 1/64 or less
    #[arg(long, value_name = "OUT.png", requires = "scene")]
    local_depth: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArguments,
}

pub fn run(arguments: &InfoArguments) -> anyhow::Result<()> {
    if let Some(path) = &arguments.scene {
        let loaded = load(path, None, &arguments.limits.limits())?;
        show(&loaded)?;
        if let Some(output) = &arguments.local_depth {
            draw(&loaded, output)?;
        }
    }
    let all = adapters();
    if all.is_empty() {
        say(format_args!("adapters: none"))?;
    }
    for found in all {
        say(format_args!(
            "adapter: {}{}, shaders {}",
            found.describe(),
            if found.is_software() {
                ", a software driver"
            } else {
                ""
            },
            if found.takes_spirv() {
                "untouched"
            } else {
                "through naga"
            },
        ))?;
    }
    Ok(())
}

fn show(
    Loaded {
        scene, prepared, ..
    }: &Loaded,
) -> anyhow::Result<()> {
    say(format_args!("scene: {}", scene.path.display()))?;
    say(format_args!(
        "picture: {} × {} pixels, {} sample(s) a pixel",
        scene.size[0],
        scene.size[1],
        scene.supersampling.pow(2)
    ))?;
    let camera = &prepared.camera;
    say(format_args!(
        "camera: eye {:.4?}, target {:.4?}, up {:?}, {}° field of view{}",
        camera.eye,
        camera.target,
        camera.up,
        scene.field_of_view,
        if scene.camera.is_none() {
            " (chosen)"
        } else {
            ""
        }
    ))?;
    if !scene.tracks.is_empty() {
        let times = scene.tracks.iter().filter_map(|track| track.times.last());
        let end = times.copied().fold(0.0, f64::max);
        say(format_args!(
            "animation: {} key(s) change until {end} s, {} frames per second",
            scene.tracks.len(),
            scene.frame_rate
        ))?;
    }
    let copies = |number: usize| {
        let objects = prepared.objects.iter();
        objects.filter(|object| object.number == number).count()
    };
    for prepared in prepared
        .objects
        .iter()
        .filter(|object| object.instance == 0)
    {
        let object = &scene.objects[prepared.number];
        let (mesh, map) = (&prepared.mesh, &prepared.map);
        let report = &mesh.report;
        match copies(prepared.number) {
            1 => say(format_args!("object {:?}:", object.name))?,
            copies => say(format_args!("object {:?}, {copies} times:", object.name))?,
        }
        say(format_args!(
            "  mesh {}: {} triangles, {} positions, {} bytes for the renderer",
            object.mesh,
            mesh.triangles.len(),
            mesh.position_count,
            size_of_val(prepared.triangles.as_slice())
        ))?;
        say(format_args!(
            "    from {:.4?} to {:.4?}",
            mesh.bounds.min.to_array(),
            mesh.bounds.max.to_array()
        ))?;
        say(format_args!(
            "    principal curvatures from {:.4} to {:.4} per unit",
            report.smallest_curvature, report.largest_curvature
        ))?;
        if !mesh.materials.is_empty() {
            let mut counts = vec![0; mesh.materials.len()];
            for triangle in &mesh.triangles {
                counts[triangle.material as usize] += 1;
            }
            let named = mesh.materials.iter().zip(counts);
            let named = named.map(|(name, count)| format!("{name:?} ({count})"));
            let named: Vec<String> = named.collect();
            say(format_args!(
                "    materials and their triangles: {}",
                named.join(", ")
            ))?;
        }
        let remarks = [
            (
                report.skipped_degenerate > 0,
                format!(
                    "{} triangles without area left out",
                    report.skipped_degenerate
                ),
            ),
            (
                report.reversed_triangles > 0,
                format!("{} triangles turned round", report.reversed_triangles),
            ),
            (report.computed_normals, "normals computed".to_string()),
            (
                report.projected_uvs,
                "texture coordinates projected".to_string(),
            ),
        ];
        for (_, remark) in remarks.iter().filter(|(applies, _)| *applies) {
            say(format_args!("    {remark}"))?;
        }
        say(format_args!("  shape {}: {}", object.shape, describe(map)))?;
        let parameters = &prepared.parameters;
        if let Some(local_depth) = prepared.local_depth {
            say(format_args!(
                "  local depth: {:.6}, {local_depth}",
                prepared.depth
            ))?;
        }
        let own = match prepared.layers.first() {
            Some(layer) => &layer.parameters,
            None => parameters,
        };
        say(format_args!(
            "  extrusion: repeat {:?}, depth {}, e {}, b {}, c {}, {:?}, {} steps and {} bisections{}{}",
            object.repeat,
            parameters.depth,
            own.extension,
            own.bevel,
            own.chamfer,
            object.tier,
            parameters.linear_steps,
            parameters.binary_steps,
            if object.cut_out { ", cut out" } else { "" },
            if object.raised { ", raised" } else { "" }
        ))?;
        for (layer, prepared) in object.layers.iter().zip(prepared.layers.iter().skip(1)) {
            let own = &prepared.parameters;
            say(format_args!(
                "  layer {}: δ {} to {}, e {}, b {}, c {}",
                layer.shape, layer.top, layer.bottom, own.extension, own.bevel, own.chamfer
            ))?;
        }
    }
    say(format_args!(
        "prepared in {:.3} s",
        prepared.preparation.as_secs_f64()
    ))
}

/// Writes the picture of the local depth.
fn draw(loaded: &Loaded, output: &Path) -> anyhow::Result<()> {
    refuse_input(&loaded.scene, output)?;
    let prepared = &loaded.prepared;
    let picture = local_depth_picture(prepared, &prepared.frame).map_err(Error::from)?;
    picture.save_png(output, &[])?;
    say(format_args!("{}", output.display()))
}
