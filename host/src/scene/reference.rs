//! The reference page of scene files, docs/scene.md.

use super::key::bound;
use super::keys::{
    CAMERA, DRAWING, ENVIRONMENT, IMAGE, Key, LAYER, LIGHT, LIGHTS, MATERIAL, MATERIALS, OBJECT,
    TEXT, TRACK,
};
use super::{
    Environment, Layer, LightSource, PhysicalMaterial, Scene, SceneObject, Shape, Technique, Track,
};
use crate::shape_map::Lettering;
use std::fmt::Write;

const INTRODUCTION: &str = "# Scenes

A scene is a TOML file. Five lines are enough: every key but an object's `mesh`
and `shape` has a default. Paths are relative to the scene file and stay near it
([Limits](limits.md#which-files-a-scene-reads)). Colours are `\"#rrggbb\"` or three numbers from 0 to 1, in
sRGB. Unknown keys, and values out of range, are errors with line and column.

```toml
[[object]]
mesh = \"../meshes/torus.obj\"
shape = \"../patterns/letters.png\"   # dark pixels are extruded
repeat = [12, 6]
depth = 0.08
```

This page is generated from the tables of keys in `host/src/scene/keys.rs` and `object_keys.rs`.
";

/// Returns the text of the reference page, Markdown.
///
/// ```
/// let page = relievo::scene::reference::page();
/// assert!(page.contains("| `depth` | a number | 4 % of the mesh's diagonal |"));
/// ```
pub fn page() -> String {
    let mut page = INTRODUCTION.to_string();
    let scene = Scene::default();
    table(&mut page, "[image]", "The picture.", IMAGE, &scene);
    table(&mut page, "[camera]", "The camera.", CAMERA, &scene);
    table(
        &mut page,
        "[light]",
        "A directional light and an ambient one.",
        LIGHT,
        &scene,
    );
    page.push_str(PHYSICAL);
    table(
        &mut page,
        "[[light]]",
        "A light, in place of `[light]`.",
        LIGHTS,
        &LightSource::default(),
    );
    table(
        &mut page,
        "[environment]",
        "Light from all directions, in place of `light.ambient`.",
        ENVIRONMENT,
        &Environment::default(),
    );
    table(
        &mut page,
        "[[material]]",
        "A material that objects name in `[object.material]`.",
        MATERIALS,
        &PhysicalMaterial::default(),
    );
    let object = SceneObject::default();
    table(
        &mut page,
        "[[object]]",
        "An object; a scene has one or more.",
        OBJECT,
        &object,
    );
    techniques(&mut page);
    page.push_str(PARTS);
    page.push_str(INSTANCES);
    table(
        &mut page,
        "[object.material]",
        "Colours and gloss of the object above.",
        MATERIAL,
        &object,
    );
    page.push_str(LAYERS);
    table(
        &mut page,
        "[[object.layer]]",
        "A further pattern of the object above.",
        LAYER,
        &Layer::default(),
    );
    let text = "A text as pattern, such as `shape = { text = \"ABC\", margin = 0.1 }`.";
    table(&mut page, "shape", text, TEXT, &Lettering::new(""));
    let drawing = "A drawing as pattern, in the scene file itself.";
    table(
        &mut page,
        "shape = { svg }",
        drawing,
        DRAWING,
        &Shape::svg(""),
    );
    page.push_str(ANIMATION);
    let about = "A key that changes with time.";
    table(&mut page, "[[animate]]", about, TRACK, &Track::default());
    page
}

const PHYSICAL: &str = "
## Materials and lights

A scene with a table `[[light]]`, `[environment]` or `[[material]]` is lit physically: by the
metallic-roughness model of glTF 2.0, with shadows of all objects on all objects
([Materials and lights](lighting.md)). What it lacks is taken from `[light]`: its directional light
where there is no `[[light]]`, and its ambient light where there is neither `[[light]]` nor
`[environment]`.

```toml
[[light]]
direction = [1, 2, 1.5]
intensity = 2.5

[environment]
image = \"studio.exr\"

[[material]]
name = \"brick\"
base_color_image = \"brick.png\"
roughness = 0.9

[[object]]
mesh = \"wall.obj\"
shape = \"bricks.png\"
material = { cap = \"brick\", wall = \"brick\", floor = \"#b0a898\" }
```

A colour is a dielectric whose roughness follows from `shininess`.
";

const PARTS: &str = "
## Parts

A mesh file may bring materials: those of an OBJ's `.mtl` files, and those of glTF. `@mesh` in
`[object.material]` draws each triangle with its own, with their pictures ([Materials and
lights](lighting.md#materials-of-mesh-files)):

```toml
[[object]]
mesh = \"chair.glb\"
shape = \"weave.png\"
material = { cap = \"@mesh\", wall = \"@mesh\", floor = \"#2b2018\" }
```

`parts` draws the triangles of some materials alone, so that other objects of the scene may give the
rest another pattern. `relievo info SCENE` lists the names. Triangles without a material are `\"\"`; a glTF
material without a name is `\"material N\"`, counted from 0; materials with the same name are drawn together.

```toml
[[object]]
mesh = \"chair.glb\"
parts = [\"seat\", \"back\"]
shape = \"weave.png\"

[[object]]
mesh = \"chair.glb\"
parts = [\"legs\"]
shape = \"rings.svg\"
```

A part is carved as if the rest of the mesh were not there: where it ends, so does its carving.
";

const LAYERS: &str = "
## Layers

![Arched windows in a round wall: sills, plaster, frames and glazing bars before glass](images/windows.png)

`relievo render assets/scenes/windows.toml --size 560x420 -o docs/images/windows.png`

An object may carry further patterns, at most 7. Each has its own part of the depth, its own technique
and its own material, and all are searched at once ([section 2](algorithm.md#2-profiles-one-formula-for-all-extrusions)).
Here the caps of frames are at 40 % of the depth, behind the wall, and bars hang before the floor:

```toml
[[object]]
mesh = \"facade.obj\"
shape = \"wall.svg\"
depth = 0.1

[[object.layer]]
shape = \"frames.svg\"
top = 0.4
bevel = 0.01
material = { cap = \"#ffffff\", wall = \"#c0c0c0\" }

[[object.layer]]
shape = \"bars.svg\"
top = 0.6
bottom = 0.8
```

All patterns of an object have one size in pixels: draw them on one canvas. `raster`, `repeat`, the keys of the
map and the gloss are the object's, and so is the floor. `[object.layer.material]` has the keys `cap`, `wall` and `bevel`
of `[object.material]`; those that a layer leaves out are as in the object's table. `bevel` and `chamfer`
are measured in the layer's part of the depth. Layers need the tiers `planar`, `fast` or `accurate`, no
`relief`, and no baked shape map. Tracks do not change them. Where [engines](export.md) call the hit function, a hit does
not tell its layer: all layers have the object's materials there.

### Pieces

![A wall of bricks that stand out by three heights, a third of them darker](images/pieces.png)

`relievo render assets/scenes/pieces.toml --size 560x420 -o docs/images/pieces.png`

`pieces = [1, 3]` keeps a third of the pattern's connected pieces, such as the bricks of a wall, chosen at random. With a
layer of the same pattern for each of the other parts, pieces differ in height, technique and material:

```toml
[[object]]
mesh = \"wall.obj\"
shape = \"bricks.png\"
pieces = [1, 3]
depth = 0.05

[[object.layer]]
shape = \"bricks.png\"
pieces = [2, 3]
top = 0.2

[[object.layer]]
shape = \"bricks.png\"
pieces = [3, 3]
top = 0.4
material = { cap = \"#7c3b28\", wall = \"#7c3b28\" }
```

Each part costs what a layer does ([Layers](measurements.md#layers)). `shade_variation`, `shift_pictures` and `turn_pictures`
of a [material](#material) need no parts.
";

const ANIMATION: &str = "
## Animation

`relievo render SCENE --frames 0..96 -o out/%04d.png` draws frames 0 to 95; frame n shows the
scene at n / `frame_rate` seconds. Keys with numbers or a colour can change, but for `image.size` and `image.frame_rate`.
Without `--frames` the values in the tables are used, and the tracks are not.

```toml
[[animate]]                      # a turntable: once around in four seconds
key = \"camera.orbit\"
times = [0, 4]
values = [0, 360]

[[animate]]                      # the carving of the object \"vase\" gets deeper meanwhile
key = \"object.vase.depth\"
times = [0, 1, 4]
values = [0.01, 0.05, 0.05]
interpolation = \"smooth\"
```

A key has its first value before the first key frame, and its last value after the last one. All tracks together have
at most 10,000 key frames. Smooth curves stay in the range of their key. Colours are interpolated in sRGB. Where only the camera changes, or
the light of `[light]` in a scene without materials and lights, the scene is prepared once.
";

const INSTANCES: &str = "
## Instances

Copies of an object share its mesh, its map and its preparation: a thousand copies take
little more memory than one. Each copy is the object, with its own transform, scaled,
rotated and translated again; the depth is scaled, too. `instances` is one of

```toml
instances = [{ translate = [0, 0, 0] }, { translate = [3, 0, 0], rotate = [0, 45, 0], scale = 0.5 }]
instances = { count = [20, 1, 20], spacing = [2.5, 0, 2.5] }   # a grid, centred on the object
instances = \"trees.csv\"
```

A CSV file has a line with the names of its columns, and a line for each copy. The columns
are `x`, `y`, `z` (translation), `rx`, `ry`, `rz` (rotation about x, then y, then z,
degrees) and `scale`, in any order; those left out have their default.

Objects of a scene that are equal but for `name`, `rotate` and `translate` share in the
same way. In a scene with `error_px` nothing is shared: the plan of an object depends on where
the object is.
";

/// Appends the table of techniques, and the default values of their parameters.
fn techniques(page: &mut String) {
    let header = "| technique | meaning | parameters |\n|---|---|---|";
    writeln!(page, "\n## Techniques\n\n{header}").expect("strings take any text");
    for technique in Technique::ALL {
        let mut object = SceneObject::default();
        object.set_technique(technique);
        let parameters = OBJECT.iter().filter(|key| technique.has(key.name));
        let parameters: Vec<String> = parameters
            .filter_map(|key| Some(format!("`{} = {}`", key.name, key.get(&object)?)))
            .collect();
        let (name, doc) = (technique.name(), technique.describe());
        writeln!(page, "| `{name}` | {doc} | {} |", parameters.join(", "))
            .expect("strings take any text");
    }
}

/// Appends the table of some keys.
fn table<T>(page: &mut String, title: &str, doc: &str, keys: &[Key<T>], default: &T) {
    let header = "| key | type | default | range | meaning |\n|---|---|---|---|---|";
    writeln!(page, "\n## `{title}`\n\n{doc}\n\n{header}").expect("strings take any text");
    for key in keys {
        let range = match key.range {
            // Part of the type of colours.
            Some((low, high)) if !key.kind().contains("colour") => {
                if low == -high {
                    format!("±{} {}", bound(high), key.unit)
                } else {
                    format!("{}…{} {}", bound(low), bound(high), key.unit)
                }
            }
            _ => key.unit.to_string(),
        };
        let kind = key.kind();
        let kind = kind.split_once(':').map_or(kind.as_str(), |(kind, _)| kind);
        let default = match key.is_required {
            true => "required".to_string(),
            false => key.default_text(default),
        };
        let line = format!(
            "| `{}` | {kind} | {default} | {} | {} |",
            key.name,
            range.trim(),
            key.doc
        );
        writeln!(page, "{line}").expect("strings take any text");
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn the_committed_page_is_up_to_date() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/scene.md");
        let page = super::page();
        if std::env::var_os("RELIEVO_UPDATE_GOLDEN").is_some() {
            std::fs::write(&path, page).unwrap();
            return;
        }
        assert!(
            std::fs::read_to_string(&path).is_ok_and(|committed| committed == page),
            "docs/scene.md is stale; run RELIEVO_UPDATE_GOLDEN=1 cargo test -p relievo --lib reference"
        );
    }
}
