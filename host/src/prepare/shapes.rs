//! The patterns of a scene: each is read once, and each form of it that is
//! drawn is made once.

use super::Step;
use crate::Error;
use crate::limits::Account;
use crate::scene::{MapOptions, Scene, SceneObject};
use crate::shape_map::{DistanceField, Pattern, PatternOptions, ShapeMap, signed_distance_field};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes that a texel of a baked map is estimated to take: in the file and packed.
const TEXEL: u64 = 8;
/// Bytes that a pixel of a plain pattern takes while it is read and its distance
/// is found.
const PIXEL_READ: u64 = 24;
/// Bytes that it takes after that: the distance and its stored form.
const PIXEL: u64 = 8;

/// What identifies a pattern among the objects of a scene.
type Key = (PathBuf, u8, bool);

fn key(object: &SceneObject) -> Key {
    (object.shape.clone(), object.threshold, object.invert)
}

/// What a shape file holds.
pub(super) enum Shape {
    /// A map that was baked before, taken as it is.
    Baked(Arc<ShapeMap>),
    /// A plain pattern, with its distances.
    Plain(DistanceField),
}

/// All patterns of a scene.
#[derive(Default)]
pub(super) struct Shapes {
    shapes: BTreeMap<Key, Shape>,
    maps: BTreeMap<(Key, MapOptions), Arc<ShapeMap>>,
}

impl Shapes {
    /// Reads the pattern of each of `objects` of `scene` that was not there
    /// `before`.
    pub(super) fn load<'a>(
        objects: impl Iterator<Item = &'a SceneObject>,
        scene: &Scene,
        mut before: Shapes,
        account: &mut Account<'_>,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<Shapes, Error> {
        let mut shapes = BTreeMap::new();
        // One after the other: each is spread over the cores by itself.
        for object in objects {
            let key = key(object);
            if let std::collections::btree_map::Entry::Vacant(place) = shapes.entry(key) {
                let shape = match before.shapes.remove(place.key()) {
                    Some(shape) => {
                        shape.take(&object.shape, account)?;
                        shape
                    }
                    None => Shape::load(object, scene, account, progress)?,
                };
                place.insert(shape);
            }
        }
        let mut maps = before.maps;
        maps.retain(|(key, _), _| shapes.contains_key(key));
        Ok(Shapes { shapes, maps })
    }

    /// Width and height of the plain pattern of `object`; none if its map is baked.
    pub(super) fn plain_size(&self, object: &SceneObject) -> Option<[u32; 2]> {
        match &self.shapes[&key(object)] {
            Shape::Baked(_) => None,
            Shape::Plain(field) => Some([field.width(), field.height()]),
        }
    }

    /// The map of `object`, shared with the objects before that have the same;
    /// or what stands against it.
    pub(super) fn map(&mut self, object: &SceneObject) -> Result<Arc<ShapeMap>, String> {
        let key = (key(object), object.map);
        if let Some(map) = self.maps.get(&key) {
            return Ok(map.clone());
        }
        let map = match &self.shapes[&key.0] {
            Shape::Baked(map) if object.map == MapOptions::default() => map.clone(),
            Shape::Baked(_) => {
                return Err(format!(
                    "{} is a baked shape map, which is taken as it is; leave out map_bits and map_reduction, or name the pattern",
                    object.shape.display()
                ));
            }
            Shape::Plain(field) => {
                let MapOptions { storage, reduction } = object.map;
                if reduction == 1 {
                    Arc::new(ShapeMap::encode(field, storage))
                } else {
                    let reduced = field.reduced(reduction).ok_or_else(|| {
                        format!(
                            "map_reduction {reduction} does not divide both sides of {}, {} × {} pixels",
                            object.shape.display(),
                            field.width(),
                            field.height()
                        )
                    })?;
                    Arc::new(ShapeMap::encode(&reduced, storage))
                }
            }
        };
        self.maps.insert(key, map.clone());
        Ok(map)
    }
}

impl Shape {
    /// Takes the memory that it needs once it is there.
    fn take(&self, path: &Path, account: &mut Account<'_>) -> Result<(), Error> {
        let (size, bytes) = match self {
            Shape::Baked(map) => ([map.width(), map.height()], TEXEL),
            Shape::Plain(field) => ([field.width(), field.height()], PIXEL),
        };
        let pixels = size.map(u64::from).iter().product();
        account.take(path.display(), pixels, bytes)
    }

    fn load(
        object: &SceneObject,
        scene: &Scene,
        account: &mut Account<'_>,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<Shape, Error> {
        let path = &object.shape;
        progress(Step::ShapeMap(path.clone(), 0.0));
        if ShapeMap::is_shape_map_of(&scene.files, path)? {
            let max_pixels = scene.limits.pixels.min(account.left(TEXEL));
            let map = ShapeMap::load_from(&scene.files, path, max_pixels)?;
            let shape = Shape::Baked(Arc::new(map));
            shape.take(path, account)?;
            return Ok(shape);
        }
        let options = PatternOptions {
            threshold: object.threshold,
            invert: object.invert,
            max_pixels: scene.limits.pixels.min(account.left(PIXEL_READ)),
        };
        let pattern = Pattern::load_from(&scene.files, path, &options)?;
        let pixels = u64::from(pattern.width()) * u64::from(pattern.height());
        account.take(path.display(), pixels, PIXEL)?;
        Ok(Shape::Plain(signed_distance_field(&pattern, &|fraction| {
            progress(Step::ShapeMap(path.clone(), fraction))
        })))
    }
}
