//! Where the objects of a scene stand. Objects that differ by their place only share one
//! mesh and its preparation.

use super::placement::Placement;
use crate::Error;
use crate::limits::Account;
use crate::scene::{Instance, Instances, Scene, SceneObject, rotation};
use glam::DVec3;
use std::borrow::Cow;
use std::path::Path;

/// Whether objects may share meshes that are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sharing {
    /// Copies share one mesh, in a space of its own.
    Shared,
    /// Each object has a mesh in world space.
    Apart,
}

/// Where an object, or one of its instances, stands.
pub(super) struct Place {
    /// Number of the object in the scene, from 0.
    pub number: usize,
    /// Number of the instance of the object, from 0.
    pub instance: usize,
    /// Index of its source.
    pub source: usize,
    /// From the space of the source to world space; `None` if they are the same.
    pub placement: Option<Placement>,
}

/// A mesh that is loaded for one or more places.
pub(super) struct Source<'a> {
    /// The object, with the depth of this source.
    pub object: Cow<'a, SceneObject>,
    /// From the space of the mesh file to that of the source.
    pub transform: Placement,
    /// Number of its places.
    pub places: usize,
}

/// Estimated bytes of a placed object.
const PLACE: u64 = 1024;

/// Finds the places of all objects of `scene`, and the sources of their meshes.
pub(super) fn places<'a>(
    scene: &'a Scene,
    sharing: Sharing,
    account: &mut Account<'_>,
) -> Result<(Vec<Source<'a>>, Vec<Place>), Error> {
    let mut sources: Vec<Source<'_>> = Vec::new();
    let mut places = Vec::new();
    let shared = match sharing {
        Sharing::Shared => groups(scene),
        Sharing::Apart => vec![None; scene.objects.len()],
    };
    // The source of each group.
    let mut known: Vec<Option<usize>> = vec![None; scene.objects.len()];
    for (number, object) in scene.objects.iter().enumerate() {
        let copies = copies(scene, object, account)?;
        let own = Placement {
            scale: object.scale,
            rotation: rotation(object.rotate),
            translation: DVec3::from(object.translate),
        };
        for (instance, copy) in copies.iter().enumerate() {
            let (source, placement) = match shared[number] {
                Some(group) => {
                    let source = *known[group].get_or_insert_with(|| {
                        sources.push(Source {
                            object: Cow::Borrowed(object),
                            transform: Placement {
                                scale: object.scale,
                                ..Placement::default()
                            },
                            places: 0,
                        });
                        sources.len() - 1
                    });
                    let place = Placement { scale: 1.0, ..own };
                    (source, Some(place.then(&placement_of(copy))))
                }
                None => {
                    sources.push(Source {
                        object: deeper(object, copy.scale),
                        transform: match object.instances {
                            None => own,
                            Some(_) => own.then(&placement_of(copy)),
                        },
                        places: 0,
                    });
                    (sources.len() - 1, None)
                }
            };
            sources[source].places += 1;
            places.push(Place {
                number,
                instance,
                source,
                placement,
            });
        }
    }
    Ok((sources, places))
}

/// Returns the number of the first object that each object shares its mesh with; `None`
/// where there is no other one.
fn groups(scene: &Scene) -> Vec<Option<usize>> {
    let plain = |object: &SceneObject| SceneObject {
        name: String::new(),
        rotate: [0.0; 3],
        translate: [0.0; 3],
        instances: None,
        ..object.clone()
    };
    // Each kind of object, the first one, and whether there are others.
    let mut kinds: Vec<(SceneObject, usize, bool)> = Vec::new();
    let kind_of: Vec<usize> = scene
        .objects
        .iter()
        .enumerate()
        .map(|(number, object)| {
            let plain = plain(object);
            let has_copies = object.instances.is_some();
            match kinds.iter().position(|(known, ..)| *known == plain) {
                Some(kind) => {
                    kinds[kind].2 = true;
                    kind
                }
                None => {
                    kinds.push((plain, number, has_copies));
                    kinds.len() - 1
                }
            }
        })
        .collect();
    let group = |kind: usize| {
        let (_, first, is_shared) = kinds[kind];
        is_shared.then_some(first)
    };
    kind_of.into_iter().map(group).collect()
}

fn placement_of(copy: &Instance) -> Placement {
    Placement {
        scale: copy.scale,
        rotation: rotation(copy.rotate),
        translation: DVec3::from(copy.translate),
    }
}

/// Returns `object` with `factor` times its depth.
fn deeper(object: &SceneObject, factor: f64) -> Cow<'_, SceneObject> {
    if factor == 1.0 {
        return Cow::Borrowed(object);
    }
    Cow::Owned(SceneObject {
        depth: object.depth.map(|depth| depth * factor),
        ..object.clone()
    })
}

/// Returns the copies of `object`, and takes their memory; one without instances is its only
/// copy.
fn copies(
    scene: &Scene,
    object: &SceneObject,
    account: &mut Account<'_>,
) -> Result<Vec<Instance>, Error> {
    let left = account.left(1);
    let mut take = |count: u64| {
        let what = format_args!("object {:?}: its instances", object.name);
        account.take(what, count, PLACE)
    };
    match &object.instances {
        None => {
            take(1)?;
            Ok(vec![Instance::default()])
        }
        Some(Instances::File(path)) => {
            let read = read(scene, path, left);
            let copies = read.map_err(|problem| Error::Object {
                scene: scene.path.clone(),
                name: object.name.clone(),
                problem: format!("instances {}: {problem}", path.display()),
            })?;
            take(copies.len() as u64)?;
            Ok(copies)
        }
        Some(Instances::List(list)) => {
            take(list.len() as u64)?;
            Ok(list.clone())
        }
        Some(Instances::Grid(grid)) => {
            // Before they are listed.
            take(grid.size())?;
            Ok(grid.instances().collect())
        }
    }
}

/// Names of the columns of a file of instances.
const COLUMNS: [&str; 7] = ["x", "y", "z", "rx", "ry", "rz", "scale"];

/// Reads a file of instances of at most `limit` bytes.
fn read(scene: &Scene, path: &Path, limit: u64) -> Result<Vec<Instance>, String> {
    let bytes = scene.files.read(path, limit);
    let bytes = bytes.map_err(|error| error.to_string())?;
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(&*bytes);
    let at = |error: csv::Error| {
        let line = error.position().map(csv::Position::line);
        match (error.kind(), line) {
            (
                csv::ErrorKind::UnequalLengths {
                    expected_len, len, ..
                },
                Some(line),
            ) => {
                format!("line {line} has {len} numbers, and the first line names {expected_len}")
            }
            (csv::ErrorKind::Utf8 { .. }, Some(line)) => format!("line {line} is not UTF-8 text"),
            _ => error.to_string(),
        }
    };
    let mut columns = Vec::new();
    for name in reader.headers().map_err(at)? {
        let column = COLUMNS.iter().position(|known| *known == name);
        let column = column.ok_or_else(|| {
            let name: String = name.chars().take(40).collect();
            format!(
                "the first line names {name:?}; the columns are {}",
                COLUMNS.join(", ")
            )
        })?;
        if columns.contains(&column) {
            return Err(format!("the first line names {name} twice"));
        }
        columns.push(column);
    }
    let mut copies = Vec::new();
    for record in reader.records() {
        let record = record.map_err(at)?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        for (column, text) in columns.iter().zip(&record) {
            numbers[*column] = text.parse().map_err(|_| {
                let text: String = text.chars().take(40).collect();
                format!(
                    "line {line}: {} is {text:?}; expected a number",
                    COLUMNS[*column]
                )
            })?;
        }
        let [x, y, z, rx, ry, rz, scale] = numbers;
        let copy = Instance {
            scale,
            rotate: [rx, ry, rz],
            translate: [x, y, z],
        };
        copy.check()
            .map_err(|problem| format!("line {line}: {problem}"))?;
        copies.push(copy);
    }
    if copies.is_empty() {
        return Err("it has no copies; add a line below the names of the columns".to_string());
    }
    Ok(copies)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Files, Limits};

    fn scene(instances: &str, csv: &str) -> Scene {
        let nothing = || [].as_slice().into();
        let files = Files::memory([
            ("a.obj".into(), nothing()),
            ("a.png".into(), nothing()),
            ("places.csv".into(), csv.as_bytes().into()),
        ]);
        let text = format!(
            "[[object]]\nmesh = 'a.obj'\nshape = 'a.png'\ndepth = 0.1\ntranslate = [1, 0, 0]\n{instances}\n"
        );
        Scene::parse_with(&text, Path::new(""), &Limits::default(), files).unwrap()
    }

    fn found(scene: &Scene, sharing: Sharing) -> Result<(usize, Vec<Place>), Error> {
        let mut account = Account::new(&scene.path, &scene.limits);
        let (sources, places) = places(scene, sharing, &mut account)?;
        Ok((sources.len(), places))
    }

    #[test]
    fn a_file_places_copies() {
        let csv = "x, y,ry,scale\n# in the garden\n1,2,90,1\n-3,0.5,0,2\n";
        let scene = scene("instances = 'places.csv'", csv);
        let (sources, places) = found(&scene, Sharing::Shared).unwrap();
        assert_eq!((sources, places.len()), (1, 2));
        let at = |index: usize| places[index].placement.unwrap().point(DVec3::X);
        // The object's own translation first.
        assert!(at(0).distance(DVec3::new(1.0, 2.0, -2.0)) < 1e-12);
        assert!(at(1).distance(DVec3::new(1.0, 0.5, 0.0)) < 1e-12);
        let (sources, places) = found(&scene, Sharing::Apart).unwrap();
        assert_eq!((sources, places.len()), (2, 2));
    }

    #[test]
    fn apart_copies_are_as_deep_as_they_are_large() {
        let scene = scene("instances = [{ scale = 2 }]", "");
        let mut account = Account::new(&scene.path, &scene.limits);
        let (sources, _) = places(&scene, Sharing::Apart, &mut account).unwrap();
        assert_eq!(sources[0].object.depth, Some(0.2));
        assert_eq!(sources[0].transform.translation, DVec3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn equal_objects_share_and_others_do_not() {
        let object = |rest: &str| format!("[[object]]\nmesh = 'a.obj'\nshape = 'a.png'\n{rest}\n");
        let text = [
            object("translate = [1, 0, 0]"),
            object("repeat = [2, 2]"),
            object("rotate = [0, 45, 0]\nname = 'turned'"),
            object("scale = 2"),
        ];
        let scene = Scene::parse(&text.concat(), Path::new("a.toml")).unwrap();
        assert_eq!(groups(&scene), [Some(0), None, Some(0), None]);
        let (sources, places) = found(&scene, Sharing::Shared).unwrap();
        assert_eq!(sources, 3);
        let shared: Vec<_> = places
            .iter()
            .map(|place| place.placement.is_some())
            .collect();
        assert_eq!(shared, [true, false, true, false]);
    }

    #[test]
    fn wrong_files_are_refused_with_line_and_remedy() {
        for (csv, part) in [
            ("", "it has no copies"),
            ("x,y\n", "it has no copies"),
            ("x,w\n1,2\n", "names \"w\"; the columns are x, y, z, rx"),
            ("x,x\n1,2\n", "names x twice"),
            ("x,y\n1,2\n3\n", "line 3 has 1 numbers"),
            ("x\n1\nfar\n", "line 3: x is \"far\"; expected a number"),
            ("scale\n1\n0\n", "line 3: scale is 0; it goes from"),
            ("x\nnan\n", "line 2: translate is [NaN"),
        ] {
            let error = found(&scene("instances = 'places.csv'", csv), Sharing::Shared);
            let error = error.err().unwrap().to_string();
            assert!(
                error.contains(part) && error.contains("places.csv"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_grid_beyond_the_memory_is_refused_before_it_is_listed() {
        let grid = "instances = { count = [1000000, 1000000, 1000000], spacing = [1, 1, 1] }";
        let error = found(&scene(grid, ""), Sharing::Shared).err().unwrap();
        assert!(error.to_string().contains("--max-memory"), "{error}");
    }
}
