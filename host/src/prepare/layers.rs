//! The layers of an object: several patterns in one map, with a record for each.

use super::growth::{check_growth, grow};
use super::shapes::reduced;
use crate::mesh::Mesh;
use crate::scene::{Extrusion, Finish, Layer, Material, SceneObject, Shape};
use crate::shape_map::{DistanceField, ShapeMap};
use relievo_shared::layout::Object;
use relievo_shared::profile::{Profile, know_layered};
use relievo_shared::stack;
use std::sync::Arc;

/// One layer of an object.
pub struct PreparedLayer {
    /// Its map.
    pub map: Arc<ShapeMap>,
    /// δ where it begins and ends.
    pub range: [f64; 2],
    /// The object's parameters with the growth of the layer.
    pub parameters: Object,
}

/// Least number of texels that the depth counts for.
const LEAST_SLOPE: f32 = 8.0;

/// Least part of the depth over which a layer grows.
const THINNEST: f32 = 1e-4;

/// What an object says about one of its layers.
pub(super) struct Described<'a> {
    pub shape: &'a Shape,
    pub range: [f64; 2],
    pub extrusion: &'a Extrusion,
    pub material: &'a Material,
    pub finish: &'a Finish,
    pub pieces: Option<[u32; 2]>,
}

/// Returns what `object` says about its layers: about its own pattern first.
pub(super) fn described(object: &SceneObject) -> impl Iterator<Item = Described<'_>> {
    let own = Described {
        shape: &object.shape,
        range: [0.0, 1.0],
        extrusion: &object.extrusion,
        material: &object.material,
        finish: &object.finish,
        pieces: object.pieces,
    };
    let further = object.layers.iter().map(|layer: &Layer| Described {
        shape: &layer.shape,
        range: [layer.top, layer.bottom],
        extrusion: &layer.extrusion,
        material: &layer.material,
        finish: &layer.finish,
        pieces: layer.pieces,
    });
    std::iter::once(own).chain(further)
}

/// Returns the number of materials that each layer of `object` takes.
pub(super) fn material_slots(object: &SceneObject, mesh: &Mesh) -> usize {
    match object.is_of_mesh() {
        true => mesh.materials.len().max(1),
        false => 1,
    }
}

/// Makes `parameters` those of a stack of the layers of `object`, whose maps are `maps`, and returns
/// its map. `texels` is the depth in texels.
///
/// # Errors
/// A text that says what is wrong with a layer and the way out.
pub(super) fn stack(
    object: &SceneObject,
    mesh: &Mesh,
    maps: &[Arc<ShapeMap>],
    texels: f64,
    parameters: &mut Object,
) -> Result<(Arc<ShapeMap>, Vec<PreparedLayer>), String> {
    let mut slope = LEAST_SLOPE.max(texels as f32);
    let mut prepared = Vec::new();
    let mut parts = Vec::new();
    for (number, (layer, map)) in described(object).zip(maps).enumerate() {
        let mut own = *parameters;
        grow(&mut own, layer.extrusion);
        check_growth(&mut own, layer.shape, map).map_err(|problem| match number {
            0 => problem,
            _ => format!("layer {number}: {problem}"),
        })?;
        let [top, bottom] = layer.range.map(|fraction| fraction as f32);
        let part = stack::Layer {
            top,
            bottom,
            inverse_extent: 1.0 / (bottom - top).max(THINNEST),
            profile: Profile::new(&own),
        };
        slope = slope.max(part.profile.largest_slope() * part.inverse_extent);
        parts.push((part, layer.material));
        prepared.push(PreparedLayer {
            map: map.clone(),
            range: layer.range,
            parameters: own,
        });
    }
    let slots = material_slots(object, mesh) as u32;
    let records = (0..).zip(&parts).flat_map(|(number, (part, material))| {
        let parts = [material.cap, material.wall, material.bevel];
        let [[a, b, c], [d, e, f], [g, h, i]] = parts.map(|color| color.linear());
        part.record(number * slots, [a, b, c, d, e, f, g, h, i])
    });
    let map = ShapeMap::joined(maps, records.collect());
    parameters.bevel = slope / parameters.map_size[0];
    parameters.parts = parts.len() as u32;
    know_layered(parameters);
    *parameters = parameters.complete();
    Ok((Arc::new(map), prepared))
}

/// Returns the maps of `fields`, of the layers of `object`, in the form that it asks for.
///
/// # Errors
/// A text that names a layer whose pattern has another size, and the way out.
pub(super) fn encode(
    object: &SceneObject,
    fields: &[&DistanceField],
) -> Result<Vec<Arc<ShapeMap>>, String> {
    let [width, height] = [fields[0].width(), fields[0].height()];
    let mut all = Vec::new();
    for (number, (field, layer)) in fields.iter().zip(described(object)).enumerate() {
        if [field.width(), field.height()] != [width, height] {
            return Err(format!(
                "layer {number}: {} has {} × {} pixels, but the patterns of an object have one size, here {width} × {height}: draw it on the same canvas",
                layer.shape,
                field.width(),
                field.height(),
            ));
        }
        all.push(reduced(field, object.map.reduction, layer.shape)?);
    }
    let maps = ShapeMap::encode_all(&all, object.map.storage);
    Ok(maps.into_iter().map(Arc::new).collect())
}
