//! Writing of scene files.

use super::keys::{
    CAMERA, DRAWING, ENVIRONMENT, IMAGE, Key, LIGHT, LIGHTS, MATERIALS, TEXT, TRACK,
};
use super::object_keys::Carving;
use super::{Scene, SceneObject, Shape, Technique};
use crate::files::{normal, relative};
use crate::shape_map::Lettering;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

impl Scene {
    /// Returns the text of a scene file that, read in `folder`, gives this scene,
    /// except for its path, its text and its limits. Paths are relative to
    /// `folder` where possible. Keys with default values are left out.
    ///
    /// Meshes in memory and patterns of pixels are written by name only, and paths that
    /// are not Unicode are changed. The values that an error budget chooses are
    /// left out.
    ///
    /// ```
    /// use relievo::scene::{Scene, SceneObject};
    /// use std::path::Path;
    ///
    /// let scene = Scene::default().object(SceneObject::new("torus.obj", "discs.png").depth(0.08));
    /// let text = scene.to_toml(Path::new(""));
    /// assert!(text.ends_with("[[object]]\nmesh = \"torus.obj\"\nshape = \"discs.png\"\ndepth = 0.08\n"));
    /// assert_eq!(Scene::parse(&text, Path::new("a.toml"))?.objects, scene.objects);
    /// # Ok::<(), relievo::scene::SceneError>(())
    /// ```
    pub fn to_toml(&self, folder: &Path) -> String {
        let default = Scene::default();
        let mut text = String::new();
        let mut named = self.clone();
        for (_, path) in named.files_mut() {
            *path = name(path, folder).into();
        }
        for (name, keys) in [("image", IMAGE), ("camera", CAMERA), ("light", LIGHT)] {
            // A scene has the one or the others.
            if name == "light" && !self.lights.is_empty() {
                continue;
            }
            let values = keys
                .iter()
                .map(|key| (key.name, changed(key, self, &default)));
            table(&mut text, &format!("[{name}]"), values);
        }
        all(&mut text, "[[light]]", LIGHTS, &named.lights);
        if let Some(environment) = &named.environment {
            let one = std::slice::from_ref(environment);
            all(&mut text, "[environment]", ENVIRONMENT, one);
        }
        all(&mut text, "[[material]]", MATERIALS, &named.materials);
        for object in &named.objects {
            write_object(&mut text, object);
        }
        all(&mut text, "[[animate]]", TRACK, &self.tracks);
        text
    }
}

/// Appends a table for each of `owners`, also where all of its values are left out.
fn all<T: Default>(text: &mut String, header: &str, keys: &'static [Key<T>], owners: &[T]) {
    let default = T::default();
    for owner in owners {
        let values = keys
            .iter()
            .map(|key| (key.name, changed(key, owner, &default)));
        let length = text.len();
        table(text, header, values);
        if text.len() == length {
            let gap = if text.is_empty() { "" } else { "\n" };
            writeln!(text, "{gap}{header}").expect("strings take any text");
        }
    }
}

/// Appends a table, unless it has no values.
fn table<'a>(
    text: &mut String,
    header: &str,
    values: impl Iterator<Item = (&'a str, Option<Value>)>,
) {
    let mut lines = values
        .filter_map(|(name, value)| Some((name, value?)))
        .peekable();
    if lines.peek().is_none() {
        return;
    }
    if !text.is_empty() {
        text.push('\n');
    }
    text.push_str(header);
    text.push('\n');
    for (name, value) in lines {
        writeln!(text, "{name} = {value}").expect("strings take any text");
    }
}

/// Returns the value of a key, unless it may be left out.
fn changed<T>(key: &Key<T>, owner: &T, default: &T) -> Option<Value> {
    let value = key.get(owner);
    let is_default = !key.is_always_written && value == key.get(default);
    value.filter(|_| !is_default)
}

fn write_object(text: &mut String, object: &SceneObject) {
    // What a file without further keys gives.
    let (steps, bisections) = object.default_effort();
    let default = SceneObject {
        name: object.default_name(),
        steps,
        bisections,
        ..SceneObject::default()
    };
    let headers = ["[[object]]", "[object.material]"];
    carving(text, headers, object, &default, object.budget.is_some());
    let default = object.default_layer();
    let headers = ["[[object.layer]]", "[object.layer.material]"];
    for layer in &object.layers {
        carving(text, headers, layer, &default, false);
    }
}

/// Appends the tables of an object or a layer. What a plan chooses is left out.
fn carving<T: Carving>(
    text: &mut String,
    [header, material_header]: [&str; 2],
    owner: &T,
    default: &T,
    has_plan: bool,
) {
    let technique = owner.carved_by();
    let values = T::keys().iter().map(|key| {
        let value = match (key.name, owner.shape()) {
            _ if key.applies(owner).is_err() || (key.is_planned && has_plan) => None,
            ("shape", Shape::Text(lettering)) => {
                Some(written(TEXT, lettering, &Lettering::new("")))
            }
            ("shape", drawing @ Shape::Drawing(_)) => {
                Some(written(DRAWING, drawing, &Shape::svg("")))
            }
            // Their defaults depend on the technique.
            (parameter, _) if Technique::is_parameter(parameter) => {
                key.get(owner).filter(|_| technique.has(parameter))
            }
            _ => changed(key, owner, default),
        };
        (key.name, value)
    });
    table(text, header, values);
    let values = T::material_keys().iter();
    let values = values.map(|key| (key.name, changed(key, owner, default)));
    table(text, material_header, values);
}

/// Returns the table of the values of `keys`.
fn written<T>(keys: &'static [Key<T>], owner: &T, default: &T) -> Value {
    let values = keys
        .iter()
        .filter_map(|key| Some((key.name.to_string(), changed(key, owner, default)?)));
    Value::Table(values.collect::<Table>())
}

/// Returns the name of `path` in a scene file in `folder`, with `/` between folders.
fn name(path: &Path, folder: &Path) -> String {
    if let Ok(below) = path.strip_prefix(folder)
        && below.is_relative()
    {
        // As it is: a folder may be a link, and `..` lead elsewhere then.
        let parts = below.components().map(|part| part.as_os_str());
        let parts: Vec<_> = parts.map(|part| part.to_string_lossy()).collect();
        return parts.join("/");
    }
    let whole = |path: &Path| -> Option<PathBuf> {
        // From where the program runs there may be no way down to a folder.
        let path = std::path::absolute(path).ok()?;
        let root = path.components().next()?;
        Some(Path::new(root.as_os_str()).join(normal(&path)))
    };
    match (whole(folder), whole(path)) {
        (Some(folder), Some(path)) => relative(&folder, &path),
        // Without a disk every name starts at one root.
        _ => relative(
            &Path::new("/").join(normal(folder)),
            &Path::new("/").join(normal(path)),
        ),
    }
}

#[cfg(test)]
mod tests;
