//! The patterns of a scene: each is read once, and each map of it is made once.

use super::step::Step;
use crate::Error;
use crate::limits::Account;
use crate::scene::{MapOptions, Scene, SceneObject, Shape};
use crate::shape_map::{
    DEFAULT_RASTER, DistanceField, Pattern, PatternOptions, ShapeMap, signed_distance_field,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Estimated bytes per texel of a baked map: in the file, and packed.
const TEXEL: u64 = 8;
/// Estimated bytes per pixel of a plain pattern while it is read and its
/// distances are computed.
const PIXEL_READ: u64 = 24;
/// Estimated bytes per pixel after that: the distance, and its texel.
const PIXEL: u64 = 8;

/// A pattern as an object or a layer describes it.
#[derive(Clone, PartialEq)]
struct Key {
    shape: Shape,
    raster: Option<u32>,
    threshold: u8,
    invert: bool,
    pieces: Option<[u32; 2]>,
}

impl Key {
    /// Returns that of `object` itself.
    fn of(object: &SceneObject) -> Key {
        Key {
            shape: object.shape.clone(),
            raster: object.raster,
            threshold: object.threshold,
            invert: object.invert,
            pieces: object.pieces,
        }
    }

    /// Returns those of `object` and its layers.
    fn all(object: &SceneObject) -> impl Iterator<Item = Key> {
        let layers = object.layers.iter().map(|layer| Key {
            shape: layer.shape.clone(),
            raster: object.raster,
            threshold: layer.threshold,
            invert: layer.invert,
            pieces: layer.pieces,
        });
        std::iter::once(Key::of(object)).chain(layers)
    }
}

/// What a shape holds.
enum Distances {
    /// A map that was baked before, taken as it is.
    Baked(Arc<ShapeMap>),
    /// A plain pattern, with its distances.
    Plain(DistanceField),
}

/// A pattern, and its maps.
struct Loaded {
    key: Key,
    distances: Distances,
    maps: BTreeMap<MapOptions, Arc<ShapeMap>>,
}

/// Returns the distances `field` of `shape` on a coarser grid.
///
/// # Errors
/// A text that says that `reduction` does not divide the sides.
pub(super) fn reduced(
    field: &DistanceField,
    reduction: u32,
    shape: &Shape,
) -> Result<DistanceField, String> {
    field.reduced(reduction).ok_or_else(|| {
        format!(
            "map_reduction {reduction} does not divide both sides of {shape}, {} × {} pixels",
            field.width(),
            field.height()
        )
    })
}

/// All patterns of a scene.
#[derive(Default)]
pub(super) struct Shapes(Vec<Loaded>);

impl Shapes {
    /// Reads the patterns of `objects` of `scene`, reusing those of `before`.
    pub(super) fn load<'a>(
        objects: impl Iterator<Item = &'a SceneObject>,
        scene: &Scene,
        mut before: Shapes,
        account: &mut Account<'_>,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<Shapes, Error> {
        let mut loaded: Vec<Loaded> = Vec::new();
        // One after the other: each uses all cores.
        for (object, key) in
            objects.flat_map(|object| Key::all(object).map(move |key| (object, key)))
        {
            if loaded.iter().any(|known| known.key == key) {
                continue;
            }
            let kept = before.0.iter().position(|known| known.key == key);
            loaded.push(match kept.map(|place| before.0.swap_remove(place)) {
                Some(kept) => {
                    kept.distances.take(&kept.key.shape, account)?;
                    kept
                }
                None => Loaded {
                    distances: Distances::load(object, &key, scene, account, progress)?,
                    key,
                    maps: BTreeMap::new(),
                },
            });
        }
        Ok(Shapes(loaded))
    }

    /// Returns the index of the pattern of `key`, which has been read.
    fn place(&self, key: &Key) -> usize {
        let known = self.0.iter().position(|known| known.key == *key);
        known.expect("the pattern of every object is read")
    }

    /// Returns width and height of the plain pattern of `object`, pixels; `None`
    /// if its map is baked.
    pub(super) fn plain_size(&self, object: &SceneObject) -> Option<[u32; 2]> {
        match &self.0[self.place(&Key::of(object))].distances {
            Distances::Baked(_) => None,
            Distances::Plain(field) => Some([field.width(), field.height()]),
        }
    }

    /// Returns the map of `object`, shared by all objects with the same pattern
    /// and options.
    ///
    /// # Errors
    /// A text that says which option does not fit the pattern.
    pub(super) fn map(&mut self, object: &SceneObject) -> Result<Arc<ShapeMap>, String> {
        let place = self.place(&Key::of(object));
        let loaded = &mut self.0[place];
        if let Some(map) = loaded.maps.get(&object.map) {
            return Ok(map.clone());
        }
        let map = match &loaded.distances {
            Distances::Baked(map) if object.map == MapOptions::default() => map.clone(),
            Distances::Baked(_) => {
                return Err(format!(
                    "{} is a baked shape map, which is taken as it is; leave out map_bits and map_reduction, or name the pattern",
                    object.shape
                ));
            }
            Distances::Plain(field) => {
                let MapOptions { storage, reduction } = object.map;
                if reduction == 1 {
                    Arc::new(ShapeMap::encode(field, storage))
                } else {
                    let reduced = reduced(field, reduction, &object.shape)?;
                    Arc::new(ShapeMap::encode(&reduced, storage))
                }
            }
        };
        loaded.maps.insert(object.map, map.clone());
        Ok(map)
    }
}

impl Shapes {
    /// Returns the distances of the patterns of `object` and its layers.
    ///
    /// # Errors
    /// A text that names a baked map, and the way out.
    pub(super) fn fields(&self, object: &SceneObject) -> Result<Vec<&DistanceField>, String> {
        let field = |key: Key| match &self.0[self.place(&key)].distances {
            Distances::Plain(field) => Ok(field),
            Distances::Baked(_) => Err(format!(
                "{} is a baked shape map, but an object with layers needs plain patterns; name the pattern",
                key.shape
            )),
        };
        Key::all(object).map(field).collect()
    }
}

impl Distances {
    /// Takes the memory that they need after loading.
    fn take(&self, shape: &Shape, account: &mut Account<'_>) -> Result<(), Error> {
        let (size, bytes) = match self {
            Distances::Baked(map) => ([map.width(), map.height()], TEXEL),
            Distances::Plain(field) => ([field.width(), field.height()], PIXEL),
        };
        let texels = size.map(u64::from).iter().product();
        Ok(account.take(shape, texels, bytes)?)
    }

    fn load(
        object: &SceneObject,
        key: &Key,
        scene: &Scene,
        account: &mut Account<'_>,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<Distances, Error> {
        let shape = &key.shape;
        progress(Step::ShapeMap(shape.clone(), 0.0));
        let has_pixels = match shape {
            Shape::File(path) => key.raster.is_some() && !Pattern::is_drawing(&scene.files, path)?,
            Shape::Pattern(_) => true,
            Shape::Text(_) | Shape::Drawing(_) => false,
        };
        // Of several patterns some may be drawings.
        if has_pixels && key.raster.is_some() && object.layers.is_empty() {
            return Err(Error::Object {
                scene: scene.path.clone(),
                name: object.name.clone(),
                problem: format!(
                    "{shape} has its own pixels, and raster is for SVG files and text; leave it out, or use map_reduction"
                ),
            });
        }
        if let Shape::File(path) = shape
            && ShapeMap::is_shape_map_of(&scene.files, path)?
        {
            if key.pieces.is_some() {
                return Err(Error::Object {
                    scene: scene.path.clone(),
                    name: object.name.clone(),
                    problem: format!(
                        "{shape} is a baked shape map, whose pieces are not known; leave pieces out, or name the pattern"
                    ),
                });
            }
            let max_pixels = scene.limits.pixels.min(account.left(TEXEL));
            let map = ShapeMap::load_from(&scene.files, path, max_pixels)?;
            let baked = Distances::Baked(Arc::new(map));
            baked.take(shape, account)?;
            return Ok(baked);
        }
        let options = PatternOptions {
            threshold: key.threshold,
            invert: key.invert,
            max_pixels: scene.limits.pixels.min(account.left(PIXEL_READ)),
            raster: key.raster.unwrap_or(DEFAULT_RASTER),
        };
        let pattern: Arc<Pattern> = match shape {
            Shape::File(path) => Pattern::load_from(&scene.files, path, &options)?.into(),
            Shape::Text(text) => Pattern::from_text(text, &scene.files, &options)?.into(),
            Shape::Drawing(document) => Pattern::from_svg(document, &options)?.into(),
            Shape::Pattern(pattern) => pattern.clone(),
        };
        let pixels = u64::from(pattern.width()) * u64::from(pattern.height());
        account.take(shape, pixels, PIXEL)?;
        let pattern = match key.pieces {
            Some(pieces) => pattern.pieces(pieces).into(),
            None => pattern,
        };
        Ok(Distances::Plain(signed_distance_field(
            &pattern,
            &|fraction| progress(Step::ShapeMap(shape.clone(), fraction)),
        )))
    }
}
