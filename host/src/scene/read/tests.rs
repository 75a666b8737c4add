//! Mistakes in scene files are reported with line and key.

use crate::scene::{
    Color, Extrusion, Layer, Lettering, Scene, SceneObject, Search, Shape, Technique, Tier,
};
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
        ("{ svg = 7 }", "shape.svg is 7; expected a text"),
        (
            "{ svg = '<svg/>', margin = 1 }",
            "shape.margin is not a key",
        ),
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

const PHYSICAL: &str = "[[light]]\nname = 'sun'\ndirection = [1, 2, 1]\nintensity = 2.5\n[[light]]\ntype = 'spot'\nposition = [0, 3, 0]\nouter_angle = 30\nrange = 9\n[environment]\ncolor = '#808080'\nocclusion = 0.5\n[[material]]\nname = 'gold'\nmetallic = 1\nbase_color = '#ffd070'\nnormal_image = 'n.png'\nturn_pictures = true\n[[object]]\nname = 'a'\nmesh = 'a.obj'\nshape = 'b.png'\nmaterial = { cap = 'gold', wall = '#102030' }\n";

#[test]
fn lights_environment_and_materials_are_read_as_they_are_written() {
    let path = Path::new("folder/a.toml");
    let scene = Scene::parse(PHYSICAL, path).unwrap();
    assert!(scene.is_physical());
    assert_eq!((scene.lights.len(), scene.materials.len()), (2, 1));
    assert_eq!(scene.lights[1].range, Some(9.0));
    let finish = &scene.objects[0].finish;
    assert_eq!(finish.names().collect::<Vec<_>>(), [("cap", "gold")]);
    let normal = scene.materials[0].normal_image.as_deref();
    assert_eq!(normal, Some(Path::new("folder/n.png")));
    let files = ["folder/n.png", "folder/a.obj", "folder/b.png"];
    assert_eq!(scene.named_files(), files.map(std::path::PathBuf::from));
    let again = Scene::parse(&scene.to_toml(Path::new("folder")), path).unwrap();
    assert_eq!(again.lights, scene.lights);
    assert_eq!(again.environment, scene.environment);
    assert_eq!(again.materials, scene.materials);
    assert_eq!(again.objects, scene.objects);
    // A light or an environment without keys is one, too.
    let bare = Scene::parse(
        "environment = {}\n[[light]]\n[[object]]\nmesh = 'a'\nshape = 'b'\n",
        path,
    )
    .unwrap();
    let again = Scene::parse(&bare.to_toml(Path::new("folder")), path).unwrap();
    assert_eq!(again.lights.len(), 1);
    assert!(again.environment.is_some());
}

#[test]
fn smooth_edges_are_for_scenes_that_are_lit_physically() {
    let path = Path::new("a.toml");
    let text = |more: &str| {
        format!("image.smooth_edges = true\n{more}[[object]]\nmesh = 'a'\nshape = 'b'\n")
    };
    let error = Scene::parse(&text(""), path).unwrap_err().to_string();
    assert!(error.contains("line 1, column 22"), "{error}");
    assert!(error.contains("add the table `[environment]`"), "{error}");
    let scene = Scene::parse(&text("[environment]\n"), path).unwrap();
    assert!(scene.smooth_edges);
    let again = Scene::parse(&scene.to_toml(Path::new("")), path).unwrap();
    assert!(again.smooth_edges);
}

#[test]
fn mistakes_in_lights_and_materials_are_told_with_line_and_key() {
    let error = |from: &str, to: &str| {
        let text = PHYSICAL.replacen(from, to, 1);
        assert_ne!(text, PHYSICAL);
        let error = Scene::parse(&text, Path::new("a.toml")).unwrap_err();
        error.to_string()
    };
    for (from, to, expected) in [
        (
            "type = 'spot'",
            "type = 'lamp'",
            "a.toml, line 6, column 8: light 2: type is \"lamp\"; expected \"directional\", \"point\" or \"spot\"",
        ),
        ("[1, 2, 1]", "[0, 0, 0]", "light 1: direction has no length"),
        (
            "outer_angle = 30",
            "inner_angle = 60",
            "light 2: inner_angle is not less than outer_angle",
        ),
        (
            "position = [0, 3, 0]",
            "shadow_size = 100",
            "light 2: target is the light's position",
        ),
        (
            "intensity = 2.5",
            "shadow_size = 100",
            "line 4, column 15: light 1: shadow_size is not a multiple of 64",
        ),
        (
            "cap = 'gold'",
            "cap = 'silver'",
            "object 1: material.cap is \"silver\", which is neither a colour nor a material; the materials are gold",
        ),
        (
            "cap = 'gold'",
            "cap = '#12'",
            "object 1: material.cap is \"#12\"; expected a colour",
        ),
        (
            "name = 'gold'",
            "name = '#gold'",
            "material 1: name is empty, or begins with #",
        ),
        (
            "name = 'gold'\n",
            "",
            "material 1: name is missing; add a line name = …",
        ),
        (
            "metallic = 1",
            "metallic = 2",
            "material 1: metallic is 2; it goes from 0 to 1",
        ),
        (
            "occlusion",
            "oclusion",
            "environment.oclusion is not a key; did you mean occlusion?",
        ),
        (
            "[[object]]",
            "[[material]]\nname = 'gold'\n[[object]]",
            "material 2: name is that of another material",
        ),
    ] {
        let found = error(from, to);
        assert!(found.contains(expected), "{found}");
    }
}

#[test]
fn lights_and_materials_change_with_time() {
    let track = |key: &str| {
        let text =
            format!("{PHYSICAL}[[animate]]\nkey = '{key}'\ntimes = [0, 2]\nvalues = [0, 1]\n");
        Scene::parse(&text, Path::new("a.toml")).map_err(|error| error.to_string())
    };
    let scene = track("light.sun.intensity").unwrap();
    assert_eq!(scene.at_time(1.0).unwrap().lights[0].intensity, 0.5);
    assert!(!scene.is_still());
    let scene = track("material.gold.metallic").unwrap();
    assert_eq!(scene.at_time(1.0).unwrap().materials[0].metallic, 0.5);
    let scene = track("environment.occlusion").unwrap();
    assert_eq!(
        scene.at_time(1.0).unwrap().environment.unwrap().occlusion,
        0.5
    );
    assert!(track("camera.orbit").unwrap().is_still());
    for (key, expected) in [
        (
            "light.moon.intensity",
            "names the light \"moon\"; the lights are sun, ",
        ),
        (
            "light.intensity",
            "is light.intensity; name the light: light.NAME.intensity",
        ),
    ] {
        let error = track(key).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

const LAYERED: &str = "[[material]]
name = 'oak'
[[object]]
mesh = 'a.obj'
shape = 'b.svg'
material = { cap = 'oak', wall = '#102030' }
[[object.layer]]
shape = 'c.svg'
[[object.layer]]
shape = { text = 'A', font = 'd.ttf' }
top = 0.25
bottom = 0.75
bevel = 0.125
threshold = 64
invert = true
pieces = [2, 3]
material = { cap = '#ffffff', wall = 'oak' }
";

#[test]
fn layers_have_the_materials_of_their_object_where_they_name_none() {
    let path = Path::new("folder/a.toml");
    let scene = Scene::parse(LAYERED, path).unwrap();
    let object = &scene.objects[0];
    let [first, second] = &object.layers[..] else {
        panic!("two layers");
    };
    let plain = Layer {
        material: object.material,
        finish: object.finish.clone(),
        ..Layer::new("folder/c.svg")
    };
    assert_eq!(*first, plain);
    assert_eq!((first.top, first.bottom), (0.0, 1.0));
    assert_eq!(first.technique(), Technique::Basic);

    assert_eq!((second.top, second.bottom), (0.25, 0.75));
    assert_eq!((second.threshold, second.invert), (64, true));
    assert_eq!((first.pieces, second.pieces), (None, Some([2, 3])));
    assert_eq!(second.technique(), Technique::Beveled);
    assert_eq!(second.extrusion.bevel, 0.125);
    assert_eq!(second.material.cap, Color([1.0; 3]));
    assert_eq!(second.material.wall, Color::from_hex(0x102030));
    assert_eq!(second.finish.names().collect::<Vec<_>>(), [("wall", "oak")]);

    let files = ["a.obj", "b.svg", "c.svg", "d.ttf"].map(|name| Path::new("folder").join(name));
    assert_eq!(scene.named_files(), files);
    assert!(object.files().eq(&files));
    let again = Scene::parse(&scene.to_toml(Path::new("folder")), path).unwrap();
    assert_eq!(again.objects, scene.objects);
}

#[test]
fn layers_of_the_mesh_files_materials_are_lit_physically() {
    let layer = |cap: &str| {
        let text = format!("{SHORT}[[object.layer]]\nshape = 'c'\nmaterial.cap = '{cap}'\n");
        parse_scene(&text).unwrap()
    };
    assert!(layer("@mesh").is_physical());
    assert!(!layer("#ffffff").is_physical());
}

#[test]
fn mistakes_in_layers_are_told_with_line_and_key() {
    for (from, to, expected) in [
        (
            "top = 0.25",
            "top = 0.75",
            "a.toml, line 11, column 7: object 1: layer 2: top is 0.75, which is not less than bottom, 0.75; make it less",
        ),
        (
            "top = 0.25\nbottom = 0.75",
            "bottom = 0",
            "line 9, column 1: object 1: layer 2: top is 0, which is not less than bottom, 0",
        ),
        (
            "top = 0.25",
            "top = nan",
            "object 1: layer 2: top is nan; it goes from 0 to 1 of the depth",
        ),
        (
            "bevel = 0.125",
            "technique = 'relief'",
            "line 13, column 13: object 1: layer 2: technique is \"relief\"; expected \"basic\", \"outward\", \"beveled\", \"chamfered\", \"rounded\" or \"stepped\"",
        ),
        (
            "bevel = 0.125",
            "technique = 'basic'\nextension = 0.1",
            "object 1: layer 2: extension has no meaning for this technique; write technique = \"outward\", \"beveled\", \"chamfered\", \"rounded\" or \"stepped\"",
        ),
        (
            "mesh = 'a.obj'",
            "mesh = 'a.obj'\ntechnique = 'relief'",
            "line 5, column 13: object 1: technique draws no layers; use another technique",
        ),
        (
            "mesh = 'a.obj'",
            "mesh = 'a.obj'\ntier = 'paper'",
            "line 5, column 8: object 1: tier draws no layers; layers need the tiers planar, fast or accurate",
        ),
        (
            "wall = 'oak'",
            "wall = 'elm'",
            "object 1: layer 2: material.wall is \"elm\", which is neither a colour nor a material; the materials are oak",
        ),
        (
            "wall = 'oak'",
            "shininess = 3",
            "object 1: layer 2: material.shininess is not a key; the keys here are cap, wall, bevel",
        ),
        (
            "'c.svg'",
            "''",
            "line 8, column 9: object 1: layer 1: shape is empty; name a file",
        ),
        (
            "text = 'A'",
            "text = ' '",
            "object 1: layer 2: shape.text has no letters",
        ),
        (
            "shape = 'c.svg'",
            "",
            "object 1: layer 1: shape is missing; add a line shape = ",
        ),
        (
            "top = 0.25",
            "repeat = [2, 2]",
            "object 1: layer 2: repeat is not a key",
        ),
        (
            "pieces = [2, 3]",
            "pieces = [4, 3]",
            "line 16, column 10: object 1: layer 2: pieces is [4, 3], but there is no part 4 of 3: the first number is at most the second",
        ),
        (
            "pieces = [2, 3]",
            "pieces = [0, 3]",
            "object 1: layer 2: pieces is [0, 3]; its numbers go from 1 to 64",
        ),
        (
            "[[object.layer]]\nshape = 'c.svg'\n[[object.layer]]",
            "[object.layer]",
            "object 1: layer is not an array of tables; write [[object.layer]]",
        ),
    ] {
        let text = LAYERED.replacen(from, to, 1);
        assert_ne!(text, LAYERED);
        let error = Scene::parse(&text, Path::new("a.toml")).unwrap_err();
        let found = error.to_string();
        assert!(found.contains(expected), "{found}");
    }
    let many = format!("{SHORT}{}", "[[object.layer]]\nshape = 'c'\n".repeat(9));
    let error = parse_scene(&many).unwrap_err();
    let expected =
        "line 18, column 1: object 1: layer 8 is one too many; an object has at most 7 layers";
    assert!(error.contains(expected), "{error}");
}

#[test]
fn layers_made_in_code_are_checked() {
    let check = |object: SceneObject| {
        let error = Scene::default().object(object).check().unwrap_err();
        error.to_string()
    };
    let object = || SceneObject::new("a", "b").with_layer(Layer::new("c"));
    for (object, expected) in [
        (
            object().with_layer(Layer::new("d").top(0.5).bottom(0.25)),
            "scene: object 1: layer 2: top is 0.5, which is not less than bottom, 0.25",
        ),
        (object().tier(Tier::Paper), "object 1: tier draws no layers"),
        (
            object().with_technique(Technique::Relief),
            "object 1: technique draws no layers",
        ),
        (
            (0..7).fold(object(), |object, _| object.with_layer(Layer::new("c"))),
            "object 1: layer 8 is one too many",
        ),
    ] {
        let found = check(object);
        assert!(found.contains(expected), "{found}");
    }
    let mut relief = object().with_technique(Technique::Relief);
    relief.tidy();
    assert_eq!((relief.search, relief.layers.len()), (Search::Relief, 0));
    let mut planar = object().tier(Tier::Planar);
    planar.tidy();
    assert_eq!(planar.layers.len(), 1);
}
