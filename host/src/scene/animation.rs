//! Scenes at some time, with the values of their tracks then.

use super::keys::{
    CAMERA, ENVIRONMENT, IMAGE, Key, LIGHT, LIGHTS, MATERIAL, MATERIALS, OBJECT, find,
};
use super::track::{MOST_KEY_FRAMES, Wrong, object_key};
use super::{Camera, Environment, Scene, SceneError, SceneObject, Track};
use glam::{DQuat, DVec3};
use toml::Value;

/// What to do with numbers out of the range of their key.
#[derive(Clone, Copy, PartialEq)]
enum Beyond {
    /// A smooth curve may lead there.
    Limit,
    /// In a key frame.
    Refuse,
}

/// Sets the key `name` of `owner`.
fn set<T>(
    keys: &'static [Key<T>],
    name: &str,
    owner: &mut T,
    numbers: &[f64],
    beyond: Beyond,
) -> Result<(), Wrong> {
    let Some(key) = find(keys, name) else {
        let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
        let names = names.join(", ");
        let problem = format!("ends with {name}, which is not a key; the keys there are {names}");
        return Err(("key", problem));
    };
    let limited = |x: &f64| match (beyond, key.range) {
        (Beyond::Limit, Some((low, high))) => x.clamp(low, high),
        _ => *x,
    };
    let value = match numbers {
        [x] => Value::Float(limited(x)),
        all => Value::Array(all.iter().map(limited).map(Value::Float).collect()),
    };
    key.check(&value)
        .map_err(|problem| ("values", format!("give a {name} that {problem}")))?;
    let is_set = key.set(owner, &value)
        || match (value, beyond) {
            (Value::Float(x), Beyond::Limit) => key.set(owner, &Value::Integer(x.round() as i64)),
            (Value::Float(x), Beyond::Refuse) => {
                x.fract() == 0.0 && key.set(owner, &Value::Integer(x as i64))
            }
            _ => false,
        };
    if !is_set {
        let problem = format!("do not fit {name}, which is {}", key.kind());
        return Err(("values", problem));
    }
    key.applies(owner)
        .map_err(|problem| ("key", format!("ends with {name}, which {problem}")))
}

/// Keys that stay as they are during a sequence.
const CONSTANT: [&str; 2] = ["image.size", "image.frame_rate"];

/// Sets `key` of `scene`, which is named with its tables.
fn set_in(scene: &mut Scene, key: &str, numbers: &[f64], beyond: Beyond) -> Result<(), Wrong> {
    let no_table = || {
        let problem =
            format!("is {key:?}; write it with its table, such as camera.eye or object.NAME.depth");
        ("key", problem)
    };
    let (table, rest) = key.split_once('.').ok_or_else(no_table)?;
    if CONSTANT.contains(&key) {
        return Err(("key", format!("is {key}, which cannot change with time")));
    }
    match table {
        "image" => set(IMAGE, rest, scene, numbers, beyond),
        "camera" => set(CAMERA, rest, scene, numbers, beyond),
        "light" if scene.lights.is_empty() => set(LIGHT, rest, scene, numbers, beyond),
        "light" => {
            let lights = scene.lights.iter_mut();
            let lights = lights.map(|light| (light.name.clone(), light));
            set_named(LIGHTS, "light", rest, lights.collect(), numbers, beyond)
        }
        "material" => {
            let materials = scene.materials.iter_mut();
            let materials = materials.map(|material| (material.name.clone(), material));
            let materials = materials.collect();
            set_named(MATERIALS, "material", rest, materials, numbers, beyond)
        }
        "environment" => {
            let environment = scene.environment.get_or_insert(Environment::default());
            set(ENVIRONMENT, rest, environment, numbers, beyond)
        }
        "object" => {
            let (object, name) = object_key(key).ok_or_else(no_table)?;
            let (object, keys) = match object.strip_suffix(".material") {
                Some(object) => (object, MATERIAL),
                None => (object, OBJECT),
            };
            let has_plan = |other: &SceneObject| other.name == object && other.budget.is_some();
            let is_planned = find(keys, name).is_some_and(|key| key.is_planned);
            if is_planned && scene.objects.iter().any(has_plan) {
                let problem = format!("ends with {name}, which error_px decides; leave one out");
                return Err(("key", problem));
            }
            let all = scene.objects.iter_mut();
            let all = all.map(|object| (object.name.clone(), object)).collect();
            set_all(keys, "object", (object, name), all, numbers, beyond)
        }
        _ => Err(no_table()),
    }
}

/// Sets the key of `rest`, NAME.KEY, of all `owners` of that name.
fn set_named<T>(
    keys: &'static [Key<T>],
    table: &'static str,
    rest: &str,
    owners: Vec<(String, &mut T)>,
    numbers: &[f64],
    beyond: Beyond,
) -> Result<(), Wrong> {
    match rest.rsplit_once('.') {
        Some(key) => set_all(keys, table, key, owners, numbers, beyond),
        None => {
            let problem = format!("is {table}.{rest}; name the {table}: {table}.NAME.{rest}");
            Err(("key", problem))
        }
    }
}

/// Sets the key `name` of all `owners` that are called `called`.
fn set_all<T>(
    keys: &'static [Key<T>],
    table: &'static str,
    (called, name): (&str, &str),
    owners: Vec<(String, &mut T)>,
    numbers: &[f64],
    beyond: Beyond,
) -> Result<(), Wrong> {
    let names: Vec<&str> = owners.iter().map(|(name, _)| &**name).collect();
    if !names.contains(&called) {
        let names = names.join(", ");
        let problem = format!("names the {table} {called:?}; the {table}s are {names}");
        return Err(("key", problem));
    }
    let mut named = owners.into_iter().filter(|(name, _)| name == called);
    named.try_for_each(|(_, owner)| set(keys, name, owner, numbers, beyond))
}

/// Returns whether the prepared scene stays as it is and only the frame changes.
fn changes_the_frame_only(scene: &Scene, track: &Track) -> bool {
    let camera = ["eye", "target", "up", "orbit"];
    match track.key.split_once('.') {
        Some(("camera", key)) => camera.contains(&key),
        // Lights of physically lit scenes are prepared.
        Some((table, _)) => table == "light" && !scene.is_physical(),
        None => false,
    }
}

impl Scene {
    /// Returns the scene at `time`, seconds, with the values of its tracks then, and without tracks.
    ///
    /// # Errors
    /// As [`Scene::check`].
    pub fn at_time(&self, time: f64) -> Result<Scene, SceneError> {
        let mut scene = self.without_tracks();
        for (index, track) in self.tracks.iter().enumerate() {
            let set = |()| {
                let value = track.at(time);
                set_in(&mut scene, &track.key, &value, Beyond::Limit)
            };
            track.check().and_then(set).map_err(|(key, problem)| {
                self.invalid(name(index, key), format!("{problem}, at {time} s"))
            })?;
        }
        match scene.check() {
            Err(SceneError::Invalid { key, problem, .. }) => {
                Err(self.invalid(key, format!("{problem}, at {time} s")))
            }
            checked => checked.map(|()| scene),
        }
    }

    /// Returns the scene as its keys have it, without tracks.
    #[must_use]
    pub fn without_tracks(&self) -> Scene {
        Scene {
            tracks: Vec::new(),
            ..self.clone()
        }
    }

    /// Returns whether [`Scene::at_time`] changes nothing but camera and light: then one
    /// preparation serves all times ([`view_of`](crate::prepare::PreparedScene::view_of)).
    pub fn is_still(&self) -> bool {
        let has_plan = self.objects.iter().any(|object| object.budget.is_some());
        let mut tracks = self.tracks.iter();
        !has_plan && tracks.all(|track| changes_the_frame_only(self, track))
    }
}

/// Returns the name of `key` of the track `index` in messages.
fn name(index: usize, key: &str) -> String {
    format!("animate {}: {key}", index + 1)
}

/// Checks the tracks of `scene`, and that its keys take each of their values. Values that
/// depend on each other are checked at each time.
pub(super) fn check(scene: &Scene) -> Result<(), (String, String)> {
    let animates = |key: &str| scene.tracks.iter().any(|track| track.key == key);
    let mut changed = scene.without_tracks();
    let mut key_frames = 0;
    for (index, track) in scene.tracks.iter().enumerate() {
        let name = |(key, problem)| (name(index, key), problem);
        track.check().map_err(name)?;
        key_frames += track.times.len();
        if key_frames > MOST_KEY_FRAMES {
            let problem = format!(
                "has key frame {key_frames}; all tracks together have at most {MOST_KEY_FRAMES}"
            );
            return Err(name(("times", problem)));
        }
        let needs_eye = ["camera.target", "camera.up"].contains(&track.key.as_str());
        if needs_eye && scene.camera.is_none() && !animates("camera.eye") {
            let problem = "needs camera.eye, in the scene or in another track".to_string();
            return Err(name(("key", problem)));
        }
        for (time, value) in track.times.iter().zip(&track.values) {
            set_in(&mut changed, &track.key, value, Beyond::Refuse)
                .map_err(|(key, problem)| name((key, format!("{problem}, at {time} s"))))?;
        }
    }
    Ok(())
}

impl Scene {
    /// Returns the camera of the scene with its orbit, if the scene has one.
    pub fn own_camera(&self) -> Option<Camera> {
        self.camera.map(|camera| camera.orbited(self.orbit))
    }

    /// Returns the scene with this camera in place of its own; `None` keeps that.
    #[must_use]
    pub fn seen_from(&self, camera: Option<Camera>) -> Scene {
        match camera {
            None => self.clone(),
            Some(_) => Scene {
                camera,
                orbit: 0.0,
                ..self.clone()
            },
        }
    }
}

impl Camera {
    /// Returns the camera with its eye turned around the target by `degrees` about `up`,
    /// counter-clockwise seen from above.
    #[must_use]
    pub fn orbited(self, degrees: f64) -> Camera {
        let axis = DVec3::from(self.up).normalize_or_zero();
        if degrees == 0.0 || axis == DVec3::ZERO {
            return self;
        }
        let target = DVec3::from(self.target);
        let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
        let eye = target + turn * (DVec3::from(self.eye) - target);
        Camera {
            eye: eye.to_array(),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const SCENE: &str = "[camera]\neye = [0, 0, 5]\n[[object]]\nname = \"a.b\"\nmesh = 'a.obj'\nshape = 'b.png'\ndepth = 0.1\n";

    fn parse(text: &str) -> Result<Scene, String> {
        Scene::parse(&format!("{SCENE}{text}"), Path::new("a.toml")).map_err(|e| e.to_string())
    }

    fn track(lines: &str) -> Result<Scene, String> {
        parse(&format!("[[animate]]\n{lines}\n"))
    }

    #[test]
    fn keys_of_every_table_change() {
        let scene = track(
            "key = 'camera.eye'\ntimes = [0, 2]\nvalues = [[0, 0, 5], [4, 0, 5]]\n[[animate]]\nkey = 'object.a.b.depth'\ntimes = [0, 2]\nvalues = [0.1, 0.3]\n[[animate]]\nkey = 'object.a.b.material.cap'\ntimes = [0, 2]\nvalues = ['#000000', '#ffffff']\n[[animate]]\nkey = 'object.a.b.steps'\ntimes = [0, 2]\nvalues = [10, 21]\ninterpolation = 'smooth'\n[[animate]]\nkey = 'light.intensity'\ntimes = [0, 2]\nvalues = [0, 1]",
        )
        .unwrap();
        let then = scene.at_time(1.0).unwrap();
        assert_eq!(then.camera.unwrap().eye, [2.0, 0.0, 5.0]);
        let object = &then.objects[0];
        assert!((object.depth.unwrap() - 0.2).abs() < 1e-12);
        assert_eq!(object.material.cap.0, [0.5; 3]);
        assert_eq!((object.steps, then.light.intensity), (16, 0.5));
        assert!(!scene.is_still());
        // It is written as it was read.
        let again = Scene::parse(&scene.to_toml(Path::new("")), Path::new("a.toml")).unwrap();
        assert_eq!(again.tracks, scene.tracks);
    }

    #[test]
    fn mistakes_are_told_with_line_and_key() {
        for (lines, expected) in [
            ("times = [0]\nvalues = [0]", "animate 1: key"),
            (
                "key = 'orbit'\ntimes = [0]\nvalues = [0]",
                "line 9, column 7: animate 1: key is \"orbit\"; write it with its table",
            ),
            (
                "key = 'camera.eyes'\ntimes = [0]\nvalues = [0]",
                "ends with eyes, which is not a key; the keys there are eye, target",
            ),
            (
                "key = 'object.c.depth'\ntimes = [0]\nvalues = [0]",
                "names the object \"c\"; the objects are a.b",
            ),
            (
                "key = 'object.a.b.tier'\ntimes = [0]\nvalues = [0]",
                "animate 1: values do not fit tier, which is \"planar\"",
            ),
            (
                "key = 'camera.eye'\ntimes = [0]\nvalues = [1]",
                "animate 1: values do not fit eye, which is 3 numbers, at 0 s",
            ),
            (
                "key = 'camera.orbit'\ntimes = [0, 0]\nvalues = [1, 2]",
                "line 10, column 9: animate 1: times is not in order",
            ),
            (
                "key = 'camera.orbit'\ntimes = [0, 1]\nvalues = [1]",
                "has 1 values for 2 times",
            ),
            (
                "key = 'camera.orbit'\ntimes = []\nvalues = []",
                "animate 1: times is empty",
            ),
            (
                "key = 'object.a.b.depth'\ntimes = [0, 1]\nvalues = [1, -1]",
                "line 11, column 10: animate 1: values give a depth that is -1.0; it goes from 1e-9 to 1e9 world units, at 1 s",
            ),
            (
                "key = 'camera.orbit'\ntimes = [0, nan]\nvalues = [1, 2]",
                "animate 1: times",
            ),
            (
                "key = 'object.a.b.tolerance'\ntimes = [0]\nvalues = [3]",
                "animate 1: key ends with tolerance, which has no meaning in this tier",
            ),
            (
                "key = 'object.a.b.steps'\ntimes = [0]\nvalues = [3.5]",
                "animate 1: values do not fit steps, which is a whole number, at 0 s",
            ),
            (
                "key = 'object.a.b.bisections'\ntimes = [0]\nvalues = [nan]",
                "animate 1: values give a bisections that is nan",
            ),
            (
                "key = 'image.frame_rate'\ntimes = [0]\nvalues = [3]",
                "animate 1: key is image.frame_rate, which cannot change with time",
            ),
        ] {
            let error = track(lines).unwrap_err();
            assert!(error.contains(expected), "{lines}: {error}");
        }
        let planned = "[[animate]]\nkey = 'object.a.b.steps'\ntimes = [0]\nvalues = [3]\n";
        let error = parse(&format!("error_px = 0.5\n{planned}")).unwrap_err();
        assert!(error.contains("which error_px decides"), "{error}");
        let reduced = track("key = 'object.a.b.map_reduction'\ntimes = [0]\nvalues = [3]");
        let error = reduced.unwrap().at_time(0.0).unwrap_err().to_string();
        assert!(error.contains("it is a power of two, at 0 s"), "{error}");
        // What lies between two key frames is checked where it is drawn.
        let through =
            track("key = 'camera.eye'\ntimes = [0, 2]\nvalues = [[0, 0, 5], [0, 0, -5]]").unwrap();
        let error = through.at_time(1.0).unwrap_err().to_string();
        assert!(
            error.contains("camera.eye is the same point as camera.target"),
            "{error}"
        );
    }

    #[test]
    fn the_eye_orbits_its_target_about_the_up_direction() {
        let camera = Camera::new([1.0, 3.0, 5.0], [1.0, 2.0, 3.0]);
        let turned = camera.orbited(90.0);
        let error = DVec3::from(turned.eye) - DVec3::new(3.0, 3.0, 3.0);
        assert!(error.length() < 1e-12, "{turned:?}");
        assert_eq!((turned.target, turned.up), (camera.target, camera.up));
        assert_eq!(camera.orbited(0.0), camera);
    }

    #[test]
    fn camera_and_light_alone_need_one_preparation() {
        let is_still = |key: &str| {
            let lines = format!("key = '{key}'\ntimes = [0]\nvalues = [50]");
            track(&lines).unwrap().is_still()
        };
        assert!(is_still("camera.orbit") && is_still("light.intensity"));
        // The slack of a search depends on the size of a pixel.
        assert!(!is_still("camera.fov") && !is_still("object.a.b.depth"));
        assert!(parse("").unwrap().is_still());
        assert!(!parse("error_px = 0.5").unwrap().is_still());
    }
}
