//! Mistakes in scene files are reported with line and key.

use crate::scene::{Extrusion, Lettering, Scene, Shape};
use std::path::Path;

const SHORT: &str = "[[object]]\nmesh = \"torus.obj\"\nshape = \"letters.png\"\n";

fn parse_scene(text: &str) -> Result<Scene, String> {
    Scene::parse(text, Path::new("some/scene.toml")).map_err(|error| error.to_string())
}

#[test]
fn three_lines_are_a_scene() {
    let scene = parse_scene(SHORT).unwrap();
    assert_eq!(scene.size, [800, 600]);
    assert_eq!(
        scene.objects[0].mesh.file(),
        Some(Path::new("some/torus.obj"))
    );
    assert_eq!(scene.objects[0].name, "torus");
    assert_eq!(scene.objects[0].extrusion.bevel, 0.0);
    assert!(scene.camera.is_none());
}

#[test]
fn parameters_choose_the_technique() {
    let with = |line: &str| parse_scene(&format!("{SHORT}{line}\n")).unwrap().objects[0].extrusion;
    assert_eq!(
        with("bevel = 0.1"),
        Extrusion {
            extension: 0.0,
            bevel: 0.1,
            ..Extrusion::UPRIGHT
        }
    );
    assert_eq!(
        with("technique = \"chamfered\""),
        Extrusion {
            extension: 0.0,
            bevel: 0.08,
            chamfer: 0.6,
            ..Extrusion::UPRIGHT
        }
    );
    assert_eq!(with("extension = 0.1").extension, 0.1);
}

#[test]
fn text_is_a_pattern() {
    let with = |shape: &str| {
        parse_scene(&format!(
            "[[object]]\nmesh = 'a.obj'\nshape = {shape}\nraster = 64\n"
        ))
    };
    let scene = with("{ text = 'A\\nB', font = '../f.ttf', margin = 1 }").unwrap();
    let lettering = Lettering {
        text: "A\\nB".to_string(),
        font: Some("some/../f.ttf".into()),
        margin: 1.0,
    };
    assert_eq!(scene.objects[0].shape, Shape::Text(lettering));
    assert_eq!(scene.objects[0].raster, Some(64));
    assert_eq!(scene.objects[0].files().count(), 2);
    let scene = with("{ text = \"A\\nB\" }").unwrap();
    let Shape::Text(lettering) = &scene.objects[0].shape else {
        panic!("a text");
    };
    assert_eq!((lettering.text.as_str(), lettering.margin), ("A\nB", 0.2));
    for (shape, part) in [
        ("{ text = ' ' }", "has no letters"),
        ("{ text = 'A', margin = 11 }", "shape.margin is 11"),
        ("{ text = 'A', font = '' }", "shape.font is empty"),
        ("{ text = 'A', size = 3 }", "shape.size is not a key"),
        ("{ font = 'A' }", "shape.text is missing"),
        ("7", "a pattern: the path of a file"),
        ("''", "shape is empty"),
    ] {
        let error = with(shape).unwrap_err();
        assert!(error.contains(part) && error.contains("line 3"), "{error}");
    }
    let long = format!("{{ text = '{}' }}", "x".repeat(4097));
    assert!(with(&long).unwrap_err().contains("4096"));
}

/// Every mistake is reported with its line, its key and what would be right.
#[test]
fn mistakes_name_line_and_key() {
    let object = |line: &str| format!("{SHORT}{line}\n");
    let cases = [
        (object("depht = 0.1"), "line 4", "depht"),
        (object("depth = nan"), "line 4", "depth"),
        (object("depth = -1"), "line 4", "depth"),
        (object("repeat = [0, 6]"), "line 4", "repeat"),
        (object("repeat = [inf, 6]"), "line 4", "repeat"),
        (
            object("tier = \"paper\"\nextension = -0.1"),
            "line 5",
            "fast",
        ),
        (
            object("technique = \"relief\"\ntier = \"accurate\""),
            "line 5",
            "no relief mapping",
        ),
        (object("tolerance = 0.1"), "line 4", "accurate"),
        (object("crease_angle = 181"), "line 4", "crease_angle"),
        (object("raised = true"), "line 4", "write depth"),
        (
            object("tier = \"accurate\"\ntolerance = 0"),
            "line 5",
            "tolerance",
        ),
        (object("steps = 0"), "line 4", "steps"),
        (object("raster = 7"), "line 4", "raster"),
        (
            object("technique = \"relief\"\nslack = 1"),
            "line 5",
            "relief",
        ),
        (object("slack = -1"), "line 4", "slack"),
        (object("error_px = 0"), "line 4", "error_px"),
        (object("tier = \"fast\"\nerror_px = 1"), "line 5", "tier"),
        (
            object("technique = \"relief\"\nerror_px = 1"),
            "line 5",
            "relief",
        ),
        (object("map_bits = 12"), "line 4", "8, 16 or 32"),
        (object("map_reduction = 3"), "line 4", "power of two"),
        (object("steps = -99999999999"), "line 4", "steps"),
        (object("tier = \"best\""), "line 4", "fast"),
        (
            object("technique = \"basic\"\nbevel = 0.1"),
            "line 5",
            "beveled",
        ),
        (
            object("technique = \"beveled\"\nchamfer = 0.1"),
            "line 5",
            "chamfered",
        ),
        (object("translate = [nan, 0, 0]"), "line 4", "translate"),
        (
            object("[object.material]\nshininess = 1000"),
            "line 5",
            "shininess",
        ),
        (
            format!("[image]\nsize = [0, 600]\n{SHORT}"),
            "line 2",
            "image.size",
        ),
        (
            format!("[image]\nsize = [800, 99999999]\n{SHORT}"),
            "line 2",
            "image.size",
        ),
        (
            format!("[camera]\nfov = nan\n{SHORT}"),
            "line 2",
            "camera.fov",
        ),
        (
            format!("[camera]\nfov = 180\n{SHORT}"),
            "line 2",
            "camera.fov",
        ),
        (
            format!("[camera]\neye = [0, 0, nan]\n{SHORT}"),
            "line 2",
            "camera.eye",
        ),
        (
            format!("[camera]\neye = [0, 0, 0]\n{SHORT}"),
            "line 2",
            "camera.target",
        ),
        (
            format!("[camera]\neye = [0, 5, 0]\n{SHORT}"),
            "line 2",
            "camera.up",
        ),
        (
            format!("[camera]\ntarget = [0, 5, 0]\n{SHORT}"),
            "line 2",
            "camera.eye",
        ),
        (
            format!("[light]\ndirection = [0, 0, 0]\n{SHORT}"),
            "line 2",
            "light.direction",
        ),
        (
            format!("[light]\nintensity = -1\n{SHORT}"),
            "line 2",
            "light.intensity",
        ),
        (
            "[[object]]\nmesh = \"\"\nshape = \"a\"\n".to_string(),
            "line 2",
            "mesh",
        ),
        ("[[object]]\nmesh = \"a\"\n".to_string(), "line 1", "shape"),
        (
            "[[object]]\noutput = \"a\"\n".to_string(),
            "line 2",
            "output",
        ),
        ("output = \"a\"\n".to_string(), "line 1", "output"),
        (
            "[[object]]\n[object.material]\ncaps = 1\n".to_string(),
            "line 1",
            "mesh",
        ),
        (
            object("[object.material]\ncaps = 1"),
            "line 5",
            "did you mean cap?",
        ),
        ("image = 3\n".to_string(), "line 1", "image is not a table"),
        (
            "[object]\nmesh = \"a\"\n".to_string(),
            "line 1",
            "[[object]]",
        ),
        ("this is not toml".to_string(), "line 1", ""),
    ];
    for (text, line, key) in cases {
        let message = parse_scene(&text).unwrap_err();
        assert!(message.contains("some/scene.toml"), "{message}");
        assert!(message.contains(line), "{text}\n{message}");
        assert!(message.contains(key), "{text}\n{message}");
    }
    assert!(parse_scene("").unwrap_err().contains("[[object]]"));
}
