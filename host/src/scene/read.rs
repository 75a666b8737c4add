//! Reading of scene files.

use super::keys::{
    CAMERA, DRAWING, ENVIRONMENT, IMAGE, Key, LIGHT, LIGHTS, MATERIALS, TEXT, TRACK,
};
use super::object::layer_prefix;
use super::object_keys::Carving;
use super::value::one_of;
use super::{Environment, MOST_LAYERS, Scene, SceneError, SceneObject, Shape, Technique};
use crate::shape_map::Lettering;
use crate::{Files, Limits};
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Value};

/// Largest scene file, bytes.
const LARGEST_FILE: u64 = 16 << 20;
/// Longest unknown key for which a similar one is searched, bytes.
const LONGEST_NAME: usize = 64;
/// Tables of a scene file.
const TABLES: [&str; 7] = [
    "image",
    "camera",
    "light",
    "environment",
    "material",
    "object",
    "animate",
];

impl Scene {
    /// Reads and checks a scene file, which may read any other file. Use
    /// [`Scene::load_within`] with [`Limits::default`] for files from elsewhere.
    ///
    /// # Errors
    /// [`SceneError`] with the file, the line and the remedy.
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        Scene::load_within(path, &Limits::trusting())
    }

    /// Reads and checks a scene file within `limits`, which also hold when the
    /// scene is prepared.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_within(path: &Path, limits: &Limits) -> Result<Scene, SceneError> {
        Scene::parse_with(&read_text(path)?, path, limits, Files::Disk)
    }

    /// Reads a scene from `text`. `path` is used for messages, and relative
    /// paths start at its folder.
    ///
    /// ```
    /// use relievo::scene::Scene;
    /// use std::path::Path;
    ///
    /// let text = "[[object]]\nmesh = 'torus.obj'\nshape = 'discs.png'\ndepht = 0.1\n";
    /// let error = Scene::parse(text, Path::new("a.toml")).unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "a.toml, line 4, column 1: object 1: depht is not a key; did you mean depth?"
    /// );
    /// ```
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Scene, SceneError> {
        Scene::parse_with(text, path, &Limits::trusting(), Files::Disk)
    }

    /// Reads a scene from `text` within `limits`; it reads its files from
    /// `files`. The names of [`Files::Memory`] are relative to the root of
    /// `path`. [`Files::Disk`] is narrowed to the scene's folder unless the
    /// limits allow more.
    ///
    /// # Errors
    /// As [`Scene::load`]; for files in memory, also where one is missing.
    pub fn parse_with(
        text: &str,
        path: &Path,
        limits: &Limits,
        files: Files,
    ) -> Result<Scene, SceneError> {
        let tables = DeTable::parse(text).map_err(|error| SceneError::Syntax {
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
        let mut scene = Scene {
            path: path.to_path_buf(),
            text: text.to_string(),
            limits: limits.clone(),
            files,
            ..Scene::default()
        };
        let mut reader = Reader {
            text,
            path,
            places: Vec::new(),
        };
        reader.scene(tables.get_ref(), &mut scene)?;
        match scene.check() {
            Err(SceneError::Invalid { key, problem, .. }) => Err(reader.wrong(&key, problem)),
            checked => checked,
        }?;
        let files = scene.files.clone();
        for (name, file) in scene.files_mut() {
            *file = folder.join(&*file);
            let checked = files.check(file);
            checked.map_err(|problem| reader.wrong(&name, problem))?;
        }
        Ok(scene)
    }
}

/// Reads the text of a scene file.
fn read_text(path: &Path) -> Result<String, SceneError> {
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
    String::from_utf8(std::fs::read(path).map_err(read)?).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        no_scene(format!("line {line} is not UTF-8 text; save it as UTF-8"))
    })
}

/// Sets fields from tables, and remembers where each key is.
struct Reader<'a> {
    text: &'a str,
    path: &'a Path,
    /// Keys with their tables, and where in the text their values are.
    places: Vec<(String, Range<usize>)>,
}

impl Reader<'_> {
    fn scene(&mut self, tables: &DeTable<'_>, scene: &mut Scene) -> Result<(), SceneError> {
        self.only(tables, "", &TABLES)?;
        let lights = tables
            .get("light")
            .and_then(|value| value.get_ref().as_array());
        for (name, keys) in [("image", IMAGE), ("camera", CAMERA), ("light", LIGHT)] {
            if let Some(value) = tables
                .get(name)
                .filter(|_| name != "light" || lights.is_none())
            {
                let table = self.table(name, value)?;
                self.keys(table, &format!("{name}."), keys, &[], scene)?;
            }
        }
        for name in ["target", "up"] {
            let key = format!("camera.{name}");
            if self.has(&key) && !self.has("camera.eye") {
                return Err(self.wrong(&key, "needs camera.eye beside it".to_string()));
            }
        }
        if lights.is_some() {
            scene.lights = self.all(tables, "light", LIGHTS)?;
        }
        if let Some(value) = tables.get("environment") {
            let table = self.table("environment", value)?;
            let environment = scene.environment.insert(Environment::default());
            self.keys(table, "environment.", ENVIRONMENT, &[], environment)?;
        }
        scene.materials = self.all(tables, "material", MATERIALS)?;
        let objects = self.array(tables, "", "object")?;
        if objects.is_empty() {
            return Err(SceneError::Syntax {
                path: self.path.to_path_buf(),
                message: "there is no object; add a table [[object]] with the keys mesh and shape"
                    .to_string(),
            });
        }
        // One more than allowed is enough for the check to find it.
        for (index, value) in objects.iter().enumerate().take(scene.limits.objects + 1) {
            let name = format!("object {}", index + 1);
            let table = self.table(&name, value)?;
            scene.objects.push(self.object(table, &name)?);
        }
        scene.tracks = self.all(tables, "animate", TRACK)?;
        Ok(())
    }

    /// Reads all tables of the array `name`.
    fn all<T: Default>(
        &mut self,
        tables: &DeTable<'_>,
        name: &str,
        keys: &'static [Key<T>],
    ) -> Result<Vec<T>, SceneError> {
        let mut all = Vec::new();
        for (index, value) in self.array(tables, "", name)?.iter().enumerate() {
            let name = format!("{name} {}", index + 1);
            let table = self.table(&name, value)?;
            let prefix = format!("{name}: ");
            self.require(table, &prefix, keys, "…")?;
            let mut owner = T::default();
            self.keys(table, &prefix, keys, &[], &mut owner)?;
            all.push(owner);
        }
        Ok(all)
    }

    /// Refuses a table without a key that it has to have; `example` is a value of such keys.
    fn require<T>(
        &self,
        table: &DeTable<'_>,
        prefix: &str,
        keys: &[Key<T>],
        example: &str,
    ) -> Result<(), SceneError> {
        let mut required = keys.iter().filter(|key| key.is_required);
        match required.find(|key| table.get(key.name).is_none()) {
            None => Ok(()),
            Some(Key { name, .. }) => {
                let problem = format!("is missing; add a line {name} = {example}");
                Err(self.wrong(&format!("{prefix}{name}"), problem))
            }
        }
    }

    /// Returns the tables of the array `header`, of which `tables` has the last part; none if it
    /// is missing.
    fn array<'t, 'i>(
        &mut self,
        tables: &'t DeTable<'i>,
        prefix: &str,
        header: &str,
    ) -> Result<&'t [Spanned<DeValue<'i>>], SceneError> {
        let name = header.rsplit('.').next().unwrap_or(header);
        match tables.get(name).map(|value| (value, value.get_ref())) {
            None => Ok(&[]),
            Some((_, DeValue::Array(elements))) => Ok(elements),
            Some((value, _)) => {
                let key = format!("{prefix}{name}");
                self.places.push((key.clone(), value.span()));
                let problem = format!("is not an array of tables; write [[{header}]]");
                Err(self.wrong(&key, problem))
            }
        }
    }

    fn object(&mut self, table: &DeTable<'_>, name: &str) -> Result<SceneObject, SceneError> {
        let prefix = format!("{name}: ");
        let mut object = SceneObject::default();
        self.carving(table, &prefix, &["material", "layer"], &mut object)?;
        if table.get("name").is_none() {
            object.name = object.default_name();
        }
        let layers = self.array(table, &prefix, "object.layer")?;
        // One more than allowed is enough for the check to find it.
        for (number, value) in (1..).zip(layers.iter().take(MOST_LAYERS + 1)) {
            let table = self.table(&format!("{prefix}layer {number}"), value)?;
            let prefix = format!("{prefix}{}", layer_prefix(number));
            let mut layer = object.default_layer();
            self.carving(table, &prefix, &["material"], &mut layer)?;
            object.layers.push(layer);
        }
        Ok(object)
    }

    /// Sets the fields of an object or a layer; `tables` are the names of its tables.
    fn carving<T: Carving>(
        &mut self,
        table: &DeTable<'_>,
        prefix: &str,
        tables: &[&'static str],
        owner: &mut T,
    ) -> Result<(), SceneError> {
        let keys = T::keys();
        let names = keys.iter().map(|key| key.name);
        let names: Vec<&str> = names.chain(tables.iter().copied()).collect();
        self.only(table, prefix, &names)?;
        self.require(table, prefix, keys, "\"…\"")?;
        let given = |name: &str| table.get(name).is_some();
        let parameters = keys.iter().map(|key| key.name);
        let parameters = parameters.filter(|name| Technique::is_parameter(name));
        let parameters: Vec<&str> = parameters.filter(|name| given(name)).collect();
        let Some(technique) = Technique::with_parameters(&parameters) else {
            let problem = format!(
                "has no technique with all of {}; leave one of them out",
                parameters.join(", ")
            );
            return Err(self.wrong(&format!("{prefix}{}", parameters[0]), problem));
        };
        owner.carve_by(technique);

        // A nested table has keys of its own.
        let shape = table
            .get("shape")
            .and_then(|value| Some((value.span(), value.get_ref().as_table()?)));
        let mut nested = tables.to_vec();
        nested.extend(shape.is_some().then_some("shape"));
        self.keys(table, prefix, keys, &nested, owner)?;
        if let Some((span, table)) = shape {
            self.places.push((format!("{prefix}shape"), span));
            owner.set_shape(self.shape(table, &format!("{prefix}shape."))?);
        }
        if let Some(value) = table.get("material") {
            let table = self.table(&format!("{prefix}material"), value)?;
            let prefix = format!("{prefix}material.");
            self.keys(table, &prefix, T::material_keys(), &[], owner)?;
        }

        if given("error_px")
            && let Some(key) = keys.iter().find(|key| key.is_planned && given(key.name))
        {
            let problem = format!(
                "decides {}, which is given too; leave one of them out",
                key.name
            );
            return Err(self.wrong(&format!("{prefix}error_px"), problem));
        }
        // The technique as it was given, which may have more parameters than it needs.
        let technique = match table
            .get("technique")
            .and_then(|value| value.get_ref().as_str())
        {
            Some(given) => Technique::ALL
                .into_iter()
                .find(|technique| technique.name() == given),
            None => None,
        };
        for name in parameters {
            if technique.is_some_and(|technique| !technique.has(name)) {
                let with = Technique::ALL
                    .into_iter()
                    .filter(|technique| technique.has(name) && T::allows(*technique));
                let problem = format!(
                    "has no meaning for this technique; write technique = {}",
                    one_of(with.map(|technique| format!("{:?}", technique.name())))
                );
                return Err(self.wrong(&format!("{prefix}{name}"), problem));
            }
        }
        for key in keys.iter().filter(|key| given(key.name)) {
            if let Err(problem) = key.applies(owner) {
                let key = format!("{prefix}{}", key.name);
                return Err(self.wrong(&key, problem.to_string()));
            }
        }
        Ok(())
    }

    /// Reads the table of a text or a drawing.
    fn shape(&mut self, table: &DeTable<'_>, prefix: &str) -> Result<Shape, SceneError> {
        if table.get("svg").is_some() {
            let mut drawing = Shape::svg("");
            self.keys(table, prefix, DRAWING, &[], &mut drawing)?;
            return Ok(drawing);
        }
        if table.get("text").is_none() {
            let problem = "is missing; add text = \"…\", or svg = \"…\"".to_string();
            return Err(self.wrong(&format!("{prefix}text"), problem));
        }
        let mut lettering = Lettering::new("");
        self.keys(table, prefix, TEXT, &[], &mut lettering)?;
        Ok(Shape::Text(lettering))
    }

    /// Sets the fields of `owner` from `table`, in the order of `keys`; `nested`
    /// are names of tables in it that are left alone.
    fn keys<T>(
        &mut self,
        table: &DeTable<'_>,
        prefix: &str,
        keys: &'static [Key<T>],
        nested: &[&'static str],
        owner: &mut T,
    ) -> Result<(), SceneError> {
        let names: Vec<&str> = keys
            .iter()
            .map(|key| key.name)
            .chain(nested.iter().copied())
            .collect();
        self.only(table, prefix, &names)?;
        for key in keys.iter().filter(|key| !nested.contains(&key.name)) {
            let Some(value) = table.get(key.name) else {
                continue;
            };
            let name = format!("{prefix}{}", key.name);
            self.places.push((name.clone(), value.span()));
            let set = plain(value.get_ref()).and_then(|value| {
                key.check(&value)?;
                match key.set(owner, &value) {
                    true => Ok(()),
                    false => Err(key.expected(&value)),
                }
            });
            set.map_err(|problem| self.wrong(&name, problem))?;
        }
        Ok(())
    }

    /// Refuses names that `table` should not have.
    fn only(
        &mut self,
        table: &DeTable<'_>,
        prefix: &str,
        names: &[&str],
    ) -> Result<(), SceneError> {
        let Some((given, _)) = table
            .iter()
            .find(|(given, _)| !names.contains(&given.get_ref().as_ref()))
        else {
            return Ok(());
        };
        let name = given.get_ref();
        let nearest = match name.len() {
            0..=LONGEST_NAME => names
                .iter()
                .map(|known| (distance(name, known), known))
                .min(),
            _ => None,
        };
        let problem = match nearest {
            Some((edits, known)) if edits <= 2.max(name.len() / 3) => {
                format!("is not a key; did you mean {known}?")
            }
            _ => format!("is not a key; the keys here are {}", names.join(", ")),
        };
        let name = format!("{prefix}{name}");
        self.places.push((name.clone(), given.span()));
        Err(self.wrong(&name, problem))
    }

    /// Returns a value that has to be a table.
    fn table<'t, 'i>(
        &mut self,
        name: &str,
        value: &'t Spanned<DeValue<'i>>,
    ) -> Result<&'t DeTable<'i>, SceneError> {
        self.places.push((name.to_string(), value.span()));
        match value.get_ref().as_table() {
            Some(table) => Ok(table),
            None => Err(self.wrong(
                name,
                "is not a table; write its keys below its name in brackets".to_string(),
            )),
        }
    }

    /// Returns whether a key was read.
    fn has(&self, key: &str) -> bool {
        self.places.iter().any(|(known, _)| known == key)
    }

    /// Returns the error for a key: where its value is, else where the first key
    /// of its table is.
    fn wrong(&self, key: &str, problem: String) -> SceneError {
        let is_key = |key: &str| key.contains(['.', ':']);
        let table = |key: &str| key.split(['.', ':']).next().map(str::to_string);
        let find = |is_it: &dyn Fn(&str) -> bool| {
            let mut places = self.places.iter();
            places
                .find(|(known, _)| is_it(known))
                .map(|(_, place)| place)
        };
        let around = key
            .rsplit_once(['.', ':'])
            .map_or(key, |(around, _)| around);
        let place = find(&|known| known == key && is_key(known))
            .or_else(|| find(&|known| known == around && is_key(known)))
            .or_else(|| find(&|known| table(known) == table(key) && is_key(known)))
            .or_else(|| find(&|known| table(known) == table(key)));
        let start = place.map_or(0, |place| place.start);
        let before = self.text.get(..start).unwrap_or(self.text);
        SceneError::Value {
            path: self.path.to_path_buf(),
            line: before.matches('\n').count() + 1,
            column: before.rsplit('\n').next().unwrap_or("").chars().count() + 1,
            key: key.to_string(),
            problem,
        }
    }
}

/// Converts a value, which has to fit 64 bits.
fn plain(value: &DeValue<'_>) -> Result<Value, String> {
    Ok(match value {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(whole) => {
            let parsed = i64::from_str_radix(whole.as_str(), whole.radix());
            Value::Integer(parsed.map_err(|_| format!("is {whole}; that is too large"))?)
        }
        DeValue::Float(number) => {
            let parsed = number.as_str().parse::<f64>();
            Value::Float(parsed.map_err(|_| format!("is {number}; expected a number"))?)
        }
        DeValue::Boolean(flag) => Value::Boolean(*flag),
        DeValue::Datetime(date) => Value::Datetime(*date),
        DeValue::Array(parts) => {
            let parts = parts.iter().map(|part| plain(part.get_ref()));
            Value::Array(parts.collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => {
            let parts = table
                .iter()
                .map(|(name, value)| Ok((name.get_ref().to_string(), plain(value.get_ref())?)));
            Value::Table(parts.collect::<Result<_, String>>()?)
        }
    })
}

/// Returns the number of characters to insert, delete or replace between `a` and `b`.
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, to) in b.chars().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.chars().count()]
}

#[cfg(test)]
mod tests;
