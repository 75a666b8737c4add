//! Checks of scenes, whether they were read from a file or made in code.

use super::keys::{CAMERA, ENVIRONMENT, IMAGE, Key, LIGHT, LIGHTS, MATERIALS, TEXT};
use super::object::layer_prefix;
use super::object_keys::Carving;
use super::{
    Extrusion, Finish, Instances, LightKind, LightSource, MOST_LAYERS, Scene, SceneError,
    SceneObject, Search, Shape, Tier, animation,
};
use glam::DVec3;
use relievo_shared::profile;
use relievo_shared::techniques::PROFILES;

/// Longest path that operating systems open, bytes.
const LONGEST_PATH: usize = 4096;
/// Largest number of lights.
const MOST_LIGHTS: usize = 64;
/// Longest text of a pattern, characters.
const LONGEST_TEXT: usize = 4096;
/// Smallest sine of the angle between the view and the up direction.
const LEAST_UP: f64 = 1e-6;

/// A key with its tables, and what is wrong with its value.
pub(super) type Problem = (String, String);

impl Scene {
    /// Checks that every value is in its range and that values fit each other.
    /// Readers of scene files and [`prepare`](crate::prepare::prepare) call it.
    ///
    /// ```
    /// use relievo::scene::{Scene, SceneObject};
    ///
    /// let object = SceneObject::new("torus.obj", "discs.png").depth(-1.0);
    /// let error = Scene::default().object(object).check().unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "scene: object 1: depth is -1.0; it goes from 1e-9 to 1e9 world units"
    /// );
    /// ```
    ///
    /// # Errors
    /// [`SceneError::Invalid`] for the first value that is not allowed.
    pub fn check(&self) -> Result<(), SceneError> {
        check_values(self)
            .and_then(|()| animation::check(self))
            .map_err(|(key, problem)| self.invalid(key, problem))
    }

    /// Returns the error for a key.
    pub(super) fn invalid(&self, key: String, problem: String) -> SceneError {
        SceneError::Invalid {
            path: self.path.clone(),
            key,
            problem,
        }
    }
}

/// Checks everything but what changes with time.
pub(super) fn check_values(scene: &Scene) -> Result<(), Problem> {
    ranges(scene, IMAGE, "image.")?;
    ranges(scene, CAMERA, "camera.")?;
    ranges(scene, LIGHT, "light.")?;
    if !(1..=2).contains(&scene.supersampling) {
        let problem = format!(
            "is {} samples per pixel side; it is 1 or 2",
            scene.supersampling
        );
        return Err(("image.supersample".to_string(), problem));
    }
    if scene.smooth_edges && !scene.is_physical() {
        let problem = "is for scenes that are lit physically: add the table `[environment]`, a `[[light]]` or a `[[material]]`, or use `supersample`";
        return wrong("image.smooth_edges", problem);
    }
    camera(scene)?;
    if DVec3::from(scene.light.direction).normalize_or_zero() == DVec3::ZERO {
        let problem = "has no length; it points towards the light";
        return wrong("light.direction", problem);
    }
    lighting(scene)?;
    if scene.objects.is_empty() {
        return wrong("object", "is missing; add one with a mesh and a shape");
    }
    let limit = scene.limits.objects;
    if scene.objects.len() > limit {
        let problem = format!(
            "is beyond the limit of {limit} objects; leave some out, or raise the limit (--max-objects)"
        );
        return wrong(&format!("object {}", limit + 1), &problem);
    }
    for (index, checked) in scene.objects.iter().enumerate() {
        let prefix = format!("object {}: ", index + 1);
        object(checked, &prefix)?;
        finish(scene, &checked.finish, &prefix)?;
        for (number, layer) in (1..).zip(&checked.layers) {
            let prefix = format!("{prefix}{}", layer_prefix(number));
            finish(scene, &layer.finish, &prefix)?;
        }
    }
    Ok(())
}

/// Checks that the scene has the materials of `finish`.
fn finish(scene: &Scene, finish: &Finish, prefix: &str) -> Result<(), Problem> {
    for (part, name) in finish.names() {
        if name == Finish::OF_MESH {
            continue;
        }
        let mut materials = scene.materials.iter();
        if !materials.any(|material| material.name == name) {
            let names = scene.materials.iter();
            let names: Vec<&str> = names.map(|material| material.name.as_str()).collect();
            let known = if name.starts_with('@') {
                format!("the materials of the mesh file are {:?}", Finish::OF_MESH)
            } else if names.is_empty() {
                "add a table [[material]] with that name".to_string()
            } else {
                format!("the materials are {}", names.join(", "))
            };
            let problem = format!("is {name:?}, which is neither a colour nor a material; {known}");
            return wrong(&format!("{prefix}material.{part}"), &problem);
        }
    }
    Ok(())
}

/// Checks lights, environment and materials.
fn lighting(scene: &Scene) -> Result<(), Problem> {
    if scene.lights.len() > MOST_LIGHTS {
        let problem = format!("is one too many; a scene has at most {MOST_LIGHTS} lights");
        return wrong(&format!("light {}", MOST_LIGHTS + 1), &problem);
    }
    for (index, light) in scene.lights.iter().enumerate() {
        let prefix = format!("light {}: ", index + 1);
        ranges(light, LIGHTS, &prefix)?;
        light_source(light).map_err(|(key, problem)| (format!("{prefix}{key}"), problem))?;
    }
    if let Some(environment) = &scene.environment {
        ranges(environment, ENVIRONMENT, "environment.")?;
    }
    for (index, material) in scene.materials.iter().enumerate() {
        let prefix = format!("material {}: ", index + 1);
        ranges(material, MATERIALS, &prefix)?;
        let key = format!("{prefix}name");
        if material.name.is_empty() || material.name.starts_with(['#', '@']) {
            let problem = "is empty, or begins with # as colours do, or with @; choose another one";
            return wrong(&key, problem);
        }
        let mut before = scene.materials[..index].iter();
        if before.any(|other| other.name == material.name) {
            return wrong(&key, "is that of another material; choose another one");
        }
    }
    Ok(())
}

fn light_source(light: &LightSource) -> Result<(), Problem> {
    let has_length = |v: DVec3| v.normalize_or_zero() != DVec3::ZERO;
    let [direction, position, target] =
        [light.direction, light.position, light.target].map(DVec3::from);
    if light.kind == LightKind::Directional && !has_length(direction) {
        return wrong("direction", "has no length; it points towards the light");
    }
    if light.kind == LightKind::Spot && !has_length(position - target) {
        return wrong("target", "is the light's position; move one of them");
    }
    if light.kind == LightKind::Spot && light.inner_angle >= light.outer_angle {
        return wrong("inner_angle", "is not less than outer_angle; make it less");
    }
    if !light.shadow_size.is_multiple_of(64) {
        return wrong("shadow_size", "is not a multiple of 64; round it");
    }
    Ok(())
}

fn wrong(key: &str, problem: &str) -> Result<(), Problem> {
    Err((key.to_string(), problem.to_string()))
}

/// Checks the ranges of the fields that `keys` set.
fn ranges<T>(owner: &T, keys: &[Key<T>], prefix: &str) -> Result<(), Problem> {
    keys.iter().try_for_each(|key| match key.get(owner) {
        Some(value) => key
            .check(&value)
            .map_err(|problem| (format!("{prefix}{}", key.name), problem)),
        None => Ok(()),
    })
}

fn camera(scene: &Scene) -> Result<(), Problem> {
    let Some(camera) = scene.camera else {
        return Ok(());
    };
    let [eye, target, up] = [camera.eye, camera.target, camera.up].map(DVec3::from);
    let forward = (target - eye).normalize_or_zero();
    if forward == DVec3::ZERO {
        let problem = "is the same point as camera.target; move one of them";
        return wrong("camera.eye", problem);
    }
    if forward.cross(up.normalize_or_zero()).length() < LEAST_UP {
        let problem = "points along the view; choose another direction, such as [0, 0, 1]";
        return wrong("camera.up", problem);
    }
    Ok(())
}

fn object(object: &SceneObject, prefix: &str) -> Result<(), Problem> {
    let wrong = |name: &str, problem: &str| wrong(&format!("{prefix}{name}"), problem);
    for (name, path) in object.named_files() {
        let length = path.as_os_str().len();
        if length == 0 {
            return wrong(&name, "is empty; name a file");
        }
        if length > LONGEST_PATH {
            return wrong(
                &name,
                &format!("is longer than {LONGEST_PATH} bytes; name a file"),
            );
        }
    }
    carving(object, &object.extrusion, prefix)?;
    if let Some(Err(problem)) = object.instances.as_ref().map(Instances::check) {
        return wrong("instances", &problem);
    }
    if object.raised && object.depth.is_none() {
        let problem = "needs to know how far: write depth, world units";
        return wrong("raised", problem);
    }
    let reduction = object.map.reduction;
    if !reduction.is_power_of_two() {
        let problem = format!("is {reduction}; it is a power of two");
        return wrong("map_reduction", &problem);
    }
    match (object.search, object.tier) {
        (Search::Relief, Tier::Accurate) => {
            let problem = "has no relief mapping; use tier = \"fast\", or another technique";
            return wrong("tier", problem);
        }
        (Search::Relief, _) | (_, Tier::Paper) if object.extrusion.profile != profile::STRAIGHT => {
            let problem = "has a profile that the paper's tier and relief mapping do not draw; use tier = \"fast\", or technique = \"chamfered\"";
            return wrong("technique", problem);
        }
        // The paper's D is never negative, and neither is D − e.
        (_, Tier::Paper) if object.extrusion.extension < 0.0 => {
            let problem =
                "is negative, which the paper's algorithms do not know; use tier = \"fast\"";
            return wrong("extension", problem);
        }
        _ => {}
    }
    if let (Search::Relief, Some(_)) = (object.search, object.budget) {
        let problem = "cannot be kept by relief mapping; use another technique";
        return wrong("error_px", problem);
    }
    layers(object, prefix)
}

/// Checks the layers of an object.
fn layers(object: &SceneObject, prefix: &str) -> Result<(), Problem> {
    let wrong = |name: &str, problem: &str| wrong(&format!("{prefix}{name}"), problem);
    if object.layers.is_empty() {
        return Ok(());
    }
    if object.layers.len() > MOST_LAYERS {
        let problem = format!("is one too many; an object has at most {MOST_LAYERS} layers");
        return wrong(&format!("layer {}", MOST_LAYERS + 1), &problem);
    }
    if object.search == Search::Relief {
        let problem = "draws no layers; use another technique, or leave the layers out";
        return wrong("technique", problem);
    }
    if object.tier == Tier::Paper {
        let problem = "draws no layers; layers need the tiers planar, fast or accurate";
        return wrong("tier", problem);
    }
    for (number, layer) in (1..).zip(&object.layers) {
        let name = layer_prefix(number);
        carving(layer, &layer.extrusion, &format!("{prefix}{name}"))?;
        if layer.top >= layer.bottom {
            let (top, bottom) = (layer.top, layer.bottom);
            let problem =
                format!("is {top}, which is not less than bottom, {bottom}; make it less");
            return wrong(&format!("{name}top"), &problem);
        }
    }
    Ok(())
}

/// Checks what an object and a layer have in common.
fn carving<T: Carving>(owner: &T, extrusion: &Extrusion, prefix: &str) -> Result<(), Problem> {
    let wrong = |name: &str, problem: &str| wrong(&format!("{prefix}{name}"), problem);
    ranges(owner, T::keys(), prefix)?;
    ranges(owner, T::material_keys(), &format!("{prefix}material."))?;
    if let Shape::Text(lettering) = owner.shape() {
        if lettering.text.chars().all(char::is_whitespace) {
            return wrong("shape.text", "has no letters; write some");
        }
        if lettering.text.chars().count() > LONGEST_TEXT {
            let problem = format!("is longer than {LONGEST_TEXT} characters; shorten it");
            return wrong("shape.text", &problem);
        }
        ranges(lettering, TEXT, &format!("{prefix}shape."))?;
    }
    if let Some([number, parts]) = owner.pieces()
        && number > parts
    {
        let problem = format!(
            "is [{number}, {parts}], but there is no part {number} of {parts}: the first number is at most the second"
        );
        return wrong("pieces", &problem);
    }
    if extrusion.profile >= PROFILES {
        let problem = "has a profile that does not exist; set a technique";
        return wrong("technique", problem);
    }
    Ok(())
}
