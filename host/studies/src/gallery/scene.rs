//! Scene file of a panel.

use super::{Method, Panel};

/// Returns the text of the panel's scene. `assets` is the path from the scene
/// to the folder of meshes and patterns. The material is matte, because
/// highlights hide the carving.
pub fn scene_text(panel: &Panel, assets: &str, size: [u32; 2]) -> String {
    let subject = panel.subject;
    let object = [
        (
            "mesh",
            quoted(&format!("{assets}/meshes/{}.obj", subject.model.name())),
        ),
        (
            "shape",
            quoted(&format!("{assets}/patterns/{}.png", subject.pattern)),
        ),
        ("repeat", format!("{:?}", subject.repeat)),
        ("depth", format!("{:?}", subject.depth)),
    ];
    let method = match panel.way.method {
        Method::Planar => ("tier", quoted("planar")),
        Method::Paper => ("tier", quoted("paper")),
        Method::Fast => ("tier", quoted("fast")),
        Method::Relief => ("technique", quoted("relief")),
    };
    let extrusion = subject.extrusion;
    let beveled = extrusion.bevel > 0.0;
    let parameters = [
        ("extension", extrusion.extension, extrusion.extension != 0.0),
        ("bevel", extrusion.bevel, beveled),
        (
            "chamfer",
            extrusion.chamfer,
            beveled && extrusion.chamfer < 1.0,
        ),
    ];
    let parameters = parameters
        .into_iter()
        .filter(|&(_, _, wanted)| wanted)
        .map(|(key, value, _)| (key, format!("{value:?}")));
    let lines: String = object
        .into_iter()
        .chain([method])
        .chain(parameters)
        .map(|(key, value)| format!("{key} = {value}\n"))
        .collect();
    format!(
        "# Figure {} of the paper: {}. Written by `relievo gallery`.\n\
         [image]\nsize = {size:?}\nsupersample = true\n\n\
         [camera]\neye = {:?}\ntarget = {:?}\nfov = {:?}\n\n\
         [[object]]\n{lines}material = {{ specular = 0.0 }}\n",
        panel.figure, subject.label, subject.eye, subject.target, subject.field_of_view,
    )
}

/// Quotes `text` as a TOML string; JSON escapes are valid in TOML.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::super::{FIGURES, Figure};
    use super::*;
    use relievo::scene::{Scene, Search, Tier};
    use std::path::Path;

    #[test]
    fn every_panel_is_a_scene_of_what_it_shows() {
        for panel in FIGURES.iter().flat_map(Figure::rows).flatten() {
            let text = scene_text(&panel, "../a \"b\"", [40, 30]);
            let scene = Scene::parse(&text, Path::new("scenes/x.toml")).unwrap();
            let object = &scene.objects[0];
            assert_eq!(object.extrusion, panel.subject.extrusion);
            assert_eq!(object.depth, Some(panel.subject.depth));
            assert!(
                object
                    .mesh
                    .file()
                    .unwrap()
                    .starts_with("scenes/../a \"b\"/meshes")
            );
            assert_eq!(
                object.search == Search::Relief,
                panel.way.method == Method::Relief
            );
            assert_eq!(
                object.tier == Tier::Paper,
                panel.way.method == Method::Paper
            );
            assert_eq!((scene.size, scene.supersampling), ([40, 30], 2));
        }
    }
}
