//! The scene file: its keys, its defaults and its checks.

use super::{
    Camera, Color, DEFAULT_BACKGROUND, DEFAULT_FIELD_OF_VIEW, DEFAULT_SIZE, DEFAULT_THRESHOLD,
    DEFAULT_TOLERANCE, DEFAULT_UP, Extrusion, LARGEST_BUDGET, LARGEST_PICTURE_SIDE, LARGEST_STEPS,
    LEAST_BUDGET, Lettering, Light, MapOptions, Material, Scene, SceneError, SceneObject, Search,
    Shape, Tier,
};
use crate::mesh::Projection;
use crate::shape_map::{LARGEST_RASTER, SMALLEST_RASTER, Storage};
use crate::{Files, Limits};
use serde::Deserialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    #[serde(default)]
    image: ImageTable,
    #[serde(default)]
    camera: CameraTable,
    #[serde(default)]
    light: LightTable,
    #[serde(default)]
    object: Vec<ObjectTable>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct ImageTable {
    size: Option<Spanned<[i64; 2]>>,
    #[serde(default)]
    supersample: bool,
    background: Option<Color>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    eye: Option<Spanned<[f64; 3]>>,
    target: Option<Spanned<[f64; 3]>>,
    up: Option<Spanned<[f64; 3]>>,
    fov: Option<Spanned<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct LightTable {
    direction: Option<Spanned<[f64; 3]>>,
    color: Option<Color>,
    intensity: Option<Spanned<f64>>,
    ambient: Option<Color>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "kebab-case")]
enum Technique {
    Basic,
    Outward,
    Beveled,
    Chamfered,
    Relief,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectTable {
    name: Option<String>,
    mesh: Spanned<PathBuf>,
    shape: Spanned<Shape>,
    raster: Option<Spanned<i64>>,
    repeat: Option<Spanned<[f64; 2]>>,
    depth: Option<Spanned<f64>>,
    clamp_depth: Option<Spanned<bool>>,
    technique: Option<Technique>,
    extension: Option<Spanned<f64>>,
    bevel: Option<Spanned<f64>>,
    chamfer: Option<Spanned<f64>>,
    tier: Option<Spanned<Tier>>,
    tolerance: Option<Spanned<f64>>,
    slack: Option<Spanned<f64>>,
    error_px: Option<Spanned<f64>>,
    map_bits: Option<Spanned<i64>>,
    map_reduction: Option<Spanned<i64>>,
    steps: Option<Spanned<i64>>,
    bisections: Option<Spanned<i64>>,
    #[serde(default)]
    cut_out: bool,
    #[serde(default)]
    self_shadow: bool,
    projection: Option<Projection>,
    threshold: Option<Spanned<i64>>,
    #[serde(default)]
    invert: bool,
    #[serde(default)]
    material: MaterialTable,
    scale: Option<Spanned<f64>>,
    rotate: Option<Spanned<[f64; 3]>>,
    translate: Option<Spanned<[f64; 3]>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct MaterialTable {
    cap: Option<Color>,
    wall: Option<Color>,
    bevel: Option<Color>,
    floor: Option<Color>,
    specular: Option<Spanned<f64>>,
    shininess: Option<Spanned<i64>>,
}

/// A scene file of more bytes is no scene.
const LARGEST_FILE: u64 = 16 << 20;

/// No system opens longer paths.
const LONGEST_PATH: usize = 4096;

/// A pattern of more letters is none.
const LONGEST_TEXT: usize = 4096;

pub(super) fn load(path: &Path, limits: &Limits) -> Result<Scene, SceneError> {
    let read = |source| SceneError::Read {
        path: path.to_path_buf(),
        source,
    };
    let metadata = std::fs::metadata(path).map_err(read)?;
    let no_scene = |problem| SceneError::NotAScene {
        path: path.to_path_buf(),
        problem,
    };
    if !metadata.is_file() {
        let problem = "it is a folder, a pipe or a device; name a TOML file".to_string();
        return Err(no_scene(problem));
    }
    if metadata.len() > LARGEST_FILE {
        return Err(no_scene(format!(
            "it has {} bytes; a scene file has at most {LARGEST_FILE}",
            metadata.len()
        )));
    }
    let bytes = std::fs::read(path).map_err(read)?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let valid = &bytes[..error.valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        no_scene(format!("line {line} is not UTF-8 text; save it as UTF-8"))
    })?;
    parse(text, path, limits, Files::Disk)
}

pub(super) fn parse(
    text: &str,
    path: &Path,
    limits: &Limits,
    files: Files,
) -> Result<Scene, SceneError> {
    let file: SceneFile = toml::from_str(text).map_err(|error| SceneError::Syntax {
        path: path.to_path_buf(),
        message: error.to_string().trim_end().to_string(),
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let files = match files {
        Files::Disk if !limits.outside => {
            Files::of_scene(folder).map_err(|source| SceneError::Read {
                path: path.to_path_buf(),
                source,
            })?
        }
        files => files,
    };
    let check = Checker {
        text,
        path,
        files: &files,
    };

    let size = match &file.image.size {
        None => DEFAULT_SIZE,
        Some(size) => {
            let limit = i64::from(LARGEST_PICTURE_SIDE);
            if size.get_ref().iter().any(|&side| side < 1 || side > limit) {
                return Err(check.wrong(
                    size,
                    "image.size",
                    format!(
                        "is {:?}; both sides go from 1 to {limit} pixels",
                        size.get_ref()
                    ),
                ));
            }
            size.get_ref().map(|side| side as u32)
        }
    };

    let field_of_view = check.within(
        &file.camera.fov,
        "camera.fov",
        DEFAULT_FIELD_OF_VIEW,
        0.01,
        179.0,
    )?;
    let camera = camera(&check, &file.camera)?;

    let default = Light::default();
    let direction = match &file.light.direction {
        None => default.direction,
        Some(direction) => {
            check.finite(direction, "light.direction")?;
            if direction.get_ref().iter().all(|&x| x == 0.0) {
                return Err(check.wrong(
                    direction,
                    "light.direction",
                    "has no length; it points towards the light".to_string(),
                ));
            }
            *direction.get_ref()
        }
    };
    let light = Light {
        direction,
        color: file.light.color.unwrap_or(default.color),
        intensity: check.within(
            &file.light.intensity,
            "light.intensity",
            default.intensity,
            0.0,
            1000.0,
        )?,
        ambient: file.light.ambient.unwrap_or(default.ambient),
    };

    if file.object.is_empty() {
        return Err(SceneError::Syntax {
            path: path.to_path_buf(),
            message: "there is no object; add a table [[object]] with the keys mesh and shape"
                .to_string(),
        });
    }
    if let Some(table) = file.object.get(limits.objects) {
        return Err(check.wrong(
            &table.mesh,
            &format!("object {}", limits.objects + 1),
            format!(
                "is beyond the limit of {} objects; leave some out, or raise the limit (--max-objects)",
                limits.objects
            ),
        ));
    }
    let objects = file
        .object
        .iter()
        .enumerate()
        .map(|(i, table)| object(&check, table, i, folder))
        .collect::<Result<Vec<_>, _>>()?;

    Ok(Scene {
        path: path.to_path_buf(),
        text: text.to_string(),
        size,
        supersampling: if file.image.supersample { 2 } else { 1 },
        background: file.image.background.unwrap_or(DEFAULT_BACKGROUND),
        camera,
        field_of_view,
        light,
        objects,
        limits: limits.clone(),
        files,
    })
}

fn camera(check: &Checker<'_>, table: &CameraTable) -> Result<Option<Camera>, SceneError> {
    for (key, value) in [
        ("camera.eye", &table.eye),
        ("camera.target", &table.target),
        ("camera.up", &table.up),
    ] {
        if let Some(value) = value {
            check.finite(value, key)?;
        }
    }
    let Some(eye) = &table.eye else {
        if let Some(target) = table.target.as_ref().or(table.up.as_ref()) {
            return Err(check.wrong(
                target,
                "camera.target or camera.up",
                "needs camera.eye beside it".to_string(),
            ));
        }
        return Ok(None);
    };
    let camera = Camera {
        eye: *eye.get_ref(),
        target: table.target.as_ref().map_or([0.0; 3], |v| *v.get_ref()),
        up: table.up.as_ref().map_or(DEFAULT_UP, |v| *v.get_ref()),
    };
    let [eye_point, target, up] = [camera.eye, camera.target, camera.up].map(glam::DVec3::from);
    let forward = (target - eye_point).normalize_or_zero();
    if forward == glam::DVec3::ZERO {
        return Err(check.wrong(
            eye,
            "camera.eye",
            "is the same point as camera.target; move one of them".to_string(),
        ));
    }
    if forward.cross(up.normalize_or_zero()).length() < 1e-6 {
        return Err(check.wrong(
            table.up.as_ref().unwrap_or(eye),
            "camera.up",
            "points along the view; choose another direction, such as [0, 0, 1]".to_string(),
        ));
    }
    Ok(Some(camera))
}

fn object(
    check: &Checker<'_>,
    table: &ObjectTable,
    index: usize,
    folder: &Path,
) -> Result<SceneObject, SceneError> {
    let key = |name: &str| format!("object {}: {name}", index + 1);
    let mesh = check.file(&table.mesh, table.mesh.get_ref(), &key("mesh"), folder)?;
    let shape = shape(check, &table.shape, &key, folder)?;
    let repeat = match &table.repeat {
        None => [1.0, 1.0],
        Some(repeat) => {
            let in_range = |r: &f64| (1e-3..=1e5).contains(r);
            if !repeat.get_ref().iter().all(in_range) {
                return Err(check.wrong(
                    repeat,
                    &key("repeat"),
                    format!("is {:?}; repeats go from 0.001 to 100000", repeat.get_ref()),
                ));
            }
            *repeat.get_ref()
        }
    };
    let depth = match &table.depth {
        None => None,
        some => Some(check.within(some, &key("depth"), 0.0, 1e-9, 1e9)?),
    };
    let default = Material::default();
    let given = &table.material;
    let material = Material {
        cap: given.cap.unwrap_or(default.cap),
        wall: given.wall.unwrap_or(default.wall),
        bevel: given.bevel.unwrap_or(default.bevel),
        floor: given.floor.unwrap_or(default.floor),
        specular: check.within(
            &given.specular,
            &key("material.specular"),
            default.specular,
            0.0,
            1.0,
        )?,
        shininess: check.whole(
            &given.shininess,
            &key("material.shininess"),
            default.shininess,
            1,
            127,
        )?,
    };
    let technique = technique(table);
    let tier = tier_of(table).unwrap_or(Tier::Fast);
    if let (Tier::Accurate, Technique::Relief, Some(given)) = (tier, technique, &table.tier) {
        return Err(check.wrong(
            given,
            &key("tier"),
            "has no relief mapping; use tier = \"fast\", or another technique".to_string(),
        ));
    }
    if tier != Tier::Accurate {
        let elsewhere = "has no meaning in this tier; write tier = \"accurate\"";
        if let Some(given) = &table.tolerance {
            return Err(check.wrong(given, &key("tolerance"), elsewhere.to_string()));
        }
        if let Some(given) = &table.clamp_depth {
            return Err(check.wrong(given, &key("clamp_depth"), elsewhere.to_string()));
        }
    }
    if let Some(given) = table.slack.as_ref()
        && (tier == Tier::Paper || technique == Technique::Relief)
    {
        let elsewhere =
            "has no meaning for the paper's search and for relief mapping; leave it out";
        return Err(check.wrong(given, &key("slack"), elsewhere.to_string()));
    }
    let budget = budget(check, table, technique, &key)?;
    let (steps, bisections) = if technique == Technique::Relief {
        Tier::Paper.default_effort()
    } else {
        tier.default_effort()
    };
    Ok(SceneObject {
        name: table.name.clone().unwrap_or_else(|| default_name(&mesh)),
        mesh,
        shape,
        raster: match &table.raster {
            None => None,
            some => Some(check.whole(some, &key("raster"), 0, SMALLEST_RASTER, LARGEST_RASTER)?),
        },
        map: map_options(check, table, &key)?,
        budget,
        repeat,
        depth,
        clamp_depth: table
            .clamp_depth
            .as_ref()
            .is_some_and(|clamp| *clamp.get_ref()),
        extrusion: extrusion(check, table, technique, &key)?,
        search: if technique == Technique::Relief {
            Search::Relief
        } else {
            Search::Extrusion
        },
        tier,
        tolerance: check.within(
            &table.tolerance,
            &key("tolerance"),
            DEFAULT_TOLERANCE,
            1e-4,
            16.0,
        )?,
        slack: check.within(&table.slack, &key("slack"), 0.0, 0.0, 16.0)?,
        steps: check.whole(&table.steps, &key("steps"), steps, 1, LARGEST_STEPS)?,
        bisections: check.whole(&table.bisections, &key("bisections"), bisections, 0, 64)?,
        cut_out: table.cut_out,
        self_shadow: table.self_shadow,
        projection: table.projection,
        threshold: check.whole(
            &table.threshold,
            &key("threshold"),
            u32::from(DEFAULT_THRESHOLD),
            1,
            255,
        )? as u8,
        invert: table.invert,
        material,
        scale: check.within(&table.scale, &key("scale"), 1.0, 1e-9, 1e9)?,
        rotate: check.vector(&table.rotate, &key("rotate"), 1e9)?,
        translate: check.vector(&table.translate, &key("translate"), 1e9)?,
    })
}

/// The name of an object that is given none.
pub(super) fn default_name(mesh: &Path) -> String {
    mesh.file_stem().map_or_else(
        || "object".to_string(),
        |stem| stem.to_string_lossy().into(),
    )
}

/// The pattern, with its paths from where the program runs.
fn shape(
    check: &Checker<'_>,
    given: &Spanned<Shape>,
    key: &dyn Fn(&str) -> String,
    folder: &Path,
) -> Result<Shape, SceneError> {
    let Lettering { text, font, margin } = match given.get_ref() {
        Shape::File(path) => {
            return Ok(Shape::File(check.file(
                given,
                path,
                &key("shape"),
                folder,
            )?));
        }
        Shape::Text(lettering) => lettering,
    };
    let wrong = |name: &str, problem: String| Err(check.wrong(given, &key(name), problem));
    if text.chars().all(char::is_whitespace) {
        return wrong("shape.text", "has no letters; write some".to_string());
    }
    if text.chars().count() > LONGEST_TEXT {
        let problem = format!("is longer than {LONGEST_TEXT} characters; shorten it");
        return wrong("shape.text", problem);
    }
    if !(0.0..=10.0).contains(margin) {
        let problem = format!("is {margin}; it goes from 0 to 10 line heights");
        return wrong("shape.margin", problem);
    }
    let font = font.as_ref();
    let font = font.map(|path| check.file(given, path, &key("shape.font"), folder));
    Ok(Shape::Text(Lettering {
        text: text.clone(),
        font: font.transpose()?,
        margin: *margin,
    }))
}

/// The tier, if one is given.
fn tier_of(table: &ObjectTable) -> Option<Tier> {
    table.tier.as_ref().map(|tier| *tier.get_ref())
}

/// The error that may be made, if one is given in place of what it decides.
fn budget(
    check: &Checker<'_>,
    table: &ObjectTable,
    technique: Technique,
    key: &dyn Fn(&str) -> String,
) -> Result<Option<f64>, SceneError> {
    let Some(given) = &table.error_px else {
        return Ok(None);
    };
    let name = key("error_px");
    if technique == Technique::Relief {
        let problem = "cannot be kept by relief mapping; use another technique";
        return Err(check.wrong(given, &name, problem.to_string()));
    }
    let decided = [
        ("tier", table.tier.is_some()),
        ("tolerance", table.tolerance.is_some()),
        ("slack", table.slack.is_some()),
        ("clamp_depth", table.clamp_depth.is_some()),
        ("steps", table.steps.is_some()),
        ("bisections", table.bisections.is_some()),
        ("map_bits", table.map_bits.is_some()),
        ("map_reduction", table.map_reduction.is_some()),
    ];
    if let Some((other, _)) = decided.iter().find(|(_, is_given)| *is_given) {
        return Err(check.wrong(
            given,
            &name,
            format!("decides {other}, which is given too; leave one of them out"),
        ));
    }
    let pixels = check.within(&table.error_px, &name, 0.0, LEAST_BUDGET, LARGEST_BUDGET)?;
    Ok(Some(pixels))
}

/// How the pattern is stored.
fn map_options(
    check: &Checker<'_>,
    table: &ObjectTable,
    key: &dyn Fn(&str) -> String,
) -> Result<MapOptions, SceneError> {
    let mut options = MapOptions::default();
    if let Some(bits) = &table.map_bits {
        options.storage = match bits.get_ref() {
            8 => Storage::R8,
            16 => Storage::R16,
            32 => Storage::R32F,
            other => {
                let problem = format!("is {other}; it is 8, 16 or 32");
                return Err(check.wrong(bits, &key("map_bits"), problem));
            }
        };
    }
    if let Some(reduction) = &table.map_reduction {
        options.reduction = check.whole(&table.map_reduction, &key("map_reduction"), 1, 1, 4096)?;
        if !options.reduction.is_power_of_two() {
            let problem = format!("is {}; it is a power of two", options.reduction);
            return Err(check.wrong(reduction, &key("map_reduction"), problem));
        }
    }
    Ok(options)
}

/// The technique as given, or as the parameters say.
fn technique(table: &ObjectTable) -> Technique {
    table
        .technique
        .unwrap_or(match (&table.chamfer, &table.bevel, &table.extension) {
            (Some(_), _, _) => Technique::Chamfered,
            (None, Some(_), _) => Technique::Beveled,
            (None, None, Some(_)) => Technique::Outward,
            (None, None, None) => Technique::Basic,
        })
}

/// The technique's parameters; a parameter that the technique does not have is a mistake.
fn extrusion(
    check: &Checker<'_>,
    table: &ObjectTable,
    technique: Technique,
    key: &dyn Fn(&str) -> String,
) -> Result<Extrusion, SceneError> {
    let (has_bevel, has_chamfer) = match technique {
        Technique::Basic | Technique::Outward => (false, false),
        Technique::Beveled => (true, false),
        // A depth map can hold any profile.
        Technique::Chamfered | Technique::Relief => (true, true),
    };
    let forbid = |value: &Option<Spanned<f64>>, name: &str, instead: &str| match value {
        Some(value) => Err(check.wrong(
            value,
            &key(name),
            format!("has no meaning for this technique; {instead}"),
        )),
        None => Ok(()),
    };
    if technique == Technique::Basic {
        forbid(
            &table.extension,
            "extension",
            "write technique = \"outward\"",
        )?;
    }
    if !has_bevel {
        forbid(
            &table.bevel,
            "bevel",
            "write technique = \"beveled\" or \"chamfered\"",
        )?;
    }
    if !has_chamfer {
        forbid(&table.chamfer, "chamfer", "write technique = \"chamfered\"")?;
    }
    // The paper's D is never negative, and D − e with it.
    if let (Some(Tier::Paper), Some(extension)) = (tier_of(table), &table.extension)
        && *extension.get_ref() < 0.0
    {
        return Err(check.wrong(
            extension,
            &key("extension"),
            "is negative, which the paper's algorithms do not know; use tier = \"fast\""
                .to_string(),
        ));
    }
    let extension_default = if technique == Technique::Outward {
        0.02
    } else {
        0.0
    };
    // Relief mapping has no bevel but the one that is asked for.
    let (bevel_default, chamfer_default) = if technique == Technique::Relief {
        (0.0, 1.0)
    } else {
        (0.08, 0.6)
    };
    Ok(Extrusion {
        extension: check.within(
            &table.extension,
            &key("extension"),
            extension_default,
            -1.0,
            2.0,
        )?,
        bevel: if has_bevel {
            check.within(&table.bevel, &key("bevel"), bevel_default, 0.0, 10.0)?
        } else {
            0.0
        },
        chamfer: if has_chamfer {
            check.within(&table.chamfer, &key("chamfer"), chamfer_default, 0.0, 1.0)?
        } else {
            1.0
        },
    })
}

/// Checks values and says where they stand.
struct Checker<'a> {
    text: &'a str,
    path: &'a Path,
    files: &'a Files,
}

impl Checker<'_> {
    fn wrong<T>(&self, value: &Spanned<T>, key: &str, problem: String) -> SceneError {
        let (line, column) = self.place(value.span());
        SceneError::Value {
            path: self.path.to_path_buf(),
            line,
            column,
            key: key.to_string(),
            problem,
        }
    }

    /// The path of a file that `value` names, from where the program runs.
    fn file<T>(
        &self,
        value: &Spanned<T>,
        path: &Path,
        key: &str,
        folder: &Path,
    ) -> Result<PathBuf, SceneError> {
        if path.as_os_str().is_empty() {
            return Err(self.wrong(value, key, "is empty; name a file".to_string()));
        }
        if path.as_os_str().len() > LONGEST_PATH {
            let problem = format!("is longer than {LONGEST_PATH} bytes; name a file");
            return Err(self.wrong(value, key, problem));
        }
        let path = folder.join(path);
        match self.files.check(&path) {
            Ok(()) => Ok(path),
            Err(problem) => Err(self.wrong(value, key, problem)),
        }
    }

    fn place(&self, span: Range<usize>) -> (usize, usize) {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        (line, column)
    }

    fn within(
        &self,
        value: &Option<Spanned<f64>>,
        key: &str,
        default: f64,
        low: f64,
        high: f64,
    ) -> Result<f64, SceneError> {
        let Some(value) = value else {
            return Ok(default);
        };
        // False for NaN too.
        if (low..=high).contains(value.get_ref()) {
            Ok(*value.get_ref())
        } else {
            Err(self.wrong(
                value,
                key,
                format!("is {}; it goes from {low} to {high}", value.get_ref()),
            ))
        }
    }

    fn whole(
        &self,
        value: &Option<Spanned<i64>>,
        key: &str,
        default: u32,
        low: u32,
        high: u32,
    ) -> Result<u32, SceneError> {
        let Some(value) = value else {
            return Ok(default);
        };
        match u32::try_from(*value.get_ref()) {
            Ok(number) if (low..=high).contains(&number) => Ok(number),
            _ => Err(self.wrong(
                value,
                key,
                format!("is {}; it goes from {low} to {high}", value.get_ref()),
            )),
        }
    }

    fn finite(&self, value: &Spanned<[f64; 3]>, key: &str) -> Result<(), SceneError> {
        if value.get_ref().iter().all(|x| x.abs() <= 1e9) {
            Ok(())
        } else {
            Err(self.wrong(
                value,
                key,
                format!(
                    "is {:?}; its numbers are finite and at most 1e9",
                    value.get_ref()
                ),
            ))
        }
    }

    fn vector(
        &self,
        value: &Option<Spanned<[f64; 3]>>,
        key: &str,
        limit: f64,
    ) -> Result<[f64; 3], SceneError> {
        match value {
            None => Ok([0.0; 3]),
            Some(value) if value.get_ref().iter().all(|x| x.abs() <= limit) => Ok(*value.get_ref()),
            Some(value) => Err(self.wrong(
                value,
                key,
                format!(
                    "is {:?}; its numbers are finite and at most {limit}",
                    value.get_ref()
                ),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: &str = "[[object]]\nmesh = \"torus.obj\"\nshape = \"letters.png\"\n";

    fn parse_scene(text: &str) -> Result<Scene, String> {
        Scene::parse(text, Path::new("some/scene.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn three_lines_are_a_scene() {
        let scene = parse_scene(SHORT).unwrap();
        assert_eq!(scene.size, [800, 600]);
        assert_eq!(scene.objects[0].mesh, Path::new("some/torus.obj"));
        assert_eq!(scene.objects[0].name, "torus");
        assert_eq!(scene.objects[0].extrusion.bevel, 0.0);
        assert!(scene.camera.is_none());
    }

    #[test]
    fn parameters_choose_the_technique() {
        let with =
            |line: &str| parse_scene(&format!("{SHORT}{line}\n")).unwrap().objects[0].extrusion;
        assert_eq!(
            with("bevel = 0.1"),
            Extrusion {
                extension: 0.0,
                bevel: 0.1,
                chamfer: 1.0
            }
        );
        assert_eq!(
            with("technique = \"chamfered\""),
            Extrusion {
                extension: 0.0,
                bevel: 0.08,
                chamfer: 0.6
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
            ("{ text = 'A', size = 3 }", "unknown field `size`"),
            ("{ font = 'A' }", "missing field `text`"),
            ("7", "a pattern: the path of a file"),
            ("''", "shape is empty"),
        ] {
            let error = with(shape).unwrap_err();
            assert!(error.contains(part) && error.contains("line 3"), "{error}");
        }
        let long = format!("{{ text = '{}' }}", "x".repeat(4097));
        assert!(with(&long).unwrap_err().contains("4096"));
    }

    /// Every mistake is told with its line, its key and what would be right.
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
            (
                object("tier = \"fast\"\nclamp_depth = true"),
                "line 5",
                "accurate",
            ),
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
}
