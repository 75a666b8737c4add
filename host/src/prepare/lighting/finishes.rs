//! The materials of objects, and how patterns lie on their facets.

use super::super::layers::{Described, described, material_slots};
use super::super::memo::{Memo, Same};
use super::super::object::repeats;
use super::super::prepared::PreparedObject;
use super::bakes::Bakes;
use super::cells::{Cells, cells};
use super::chart::{self, Charted};
use super::far::mean_from;
use super::of_meshes::OfMeshes;
use super::pictures::{Encoding, Pictures, TEXEL};
use crate::Error;
use crate::limits::Account;
use crate::mesh::MeshTriangle;
use crate::scene::{self, Color, PhysicalMaterial, Scene, SceneObject};
use crate::shape_map::ShapeMap;
use rayon::prelude::*;
use relievo_shared::gbuffer::{KNOWS_EDGES, KNOWS_MESH, MOST_FACETS, MOST_FINISHES};
use relievo_shared::layout::{FORMAT_PAPER, Object};
use relievo_shared::normals::{CLASS_BEVEL, CLASS_WALL};
use relievo_shared::profile::{Profile, grows_mostly, growth, rim};
use relievo_shared::shading::layout::FINISHES;
use relievo_shared::shading::{Chart, FacetMaterial, Finish, Image, Material};
use std::path::PathBuf;
use std::sync::Arc;

/// Returns the finishes and the facets of all `objects`, and numbers the materials in
/// their parameters.
pub(super) fn finishes(
    scene: &Scene,
    objects: &mut [PreparedObject],
    bakes: &mut Bakes,
    words: &mut Vec<u32>,
    account: &mut Account<'_>,
) -> Result<(Vec<Finish>, Vec<FacetMaterial>), Error> {
    let pictures = &mut Pictures::new(scene, &mut bakes.pictures);
    let mut finishes: Vec<Finish> = Vec::new();
    let mut facets = Vec::new();
    let mut of_meshes = OfMeshes::new(scene);
    let (knows_edges, knows_mesh) = match scene.smooth_edges {
        true => (KNOWS_EDGES, KNOWS_MESH),
        false => (0, 0),
    };
    for index in 0..objects.len() {
        let (before, rest) = objects.split_at_mut(index);
        let prepared = &mut rest[0];
        // Copies share facets and materials, and so do objects that differ by their place only:
        // a GPU has one set of parameters for them.
        let same = |other: &&PreparedObject| other.shares_facets(prepared);
        if let Some(first) = before.iter().rev().find(same) {
            prepared.parameters.finish = first.parameters.finish;
            prepared.parameters.mean_from = first.parameters.mean_from;
            continue;
        }
        let object = &scene.objects[prepared.number];
        let number = finishes.len() as u32 / FINISHES;
        let has_mesh_materials = object.is_of_mesh();
        let slots = material_slots(object, &prepared.mesh);
        let layers = 1 + object.layers.len();
        if number as usize + slots * layers > MOST_FINISHES as usize {
            return Err(Error::Object {
                scene: scene.path.clone(),
                name: object.name.clone(),
                problem: format!(
                    "is too much: a scene with materials, lights or an environment has at most {MOST_FINISHES} different objects, where each material of a mesh counts as one; copies count as one if they are instances without error_px"
                ),
            });
        }
        // The paper's maps have no distances inside the pattern.
        prepared.parameters.finish = match prepared.parameters.map_format {
            FORMAT_PAPER => number | knows_mesh,
            _ => number | knows_mesh | knows_edges,
        };
        let triangles = &prepared.mesh.triangles;
        if triangles.len() > MOST_FACETS as usize {
            return Err(Error::Object {
                scene: scene.path.clone(),
                name: object.name.clone(),
                problem: format!(
                    "has {} triangles; in a scene with materials, lights or an environment an object has at most {MOST_FACETS}",
                    triangles.len()
                ),
            });
        }
        account.take(
            &object.name,
            triangles.len() as u64,
            size_of::<FacetMaterial>() as u64,
        )?;
        let made = (slots * layers) as u64 * u64::from(FINISHES);
        account.take(&object.name, made, size_of::<Finish>() as u64)?;
        let first_facet = facets.len() as u32;
        facets.par_extend(triangles.par_iter().map(|triangle| {
            let slot = if has_mesh_materials {
                triangle.material
            } else {
                0
            };
            on_facet(triangle, object.repeat, slot)
        }));
        let mesh_materials = match has_mesh_materials {
            true => of_meshes.materials(object, &prepared.mesh, pictures, words, account)?,
            false => vec![Material::default()],
        };
        let (chart, far_from) =
            chart_of(scene, object, prepared, &mut bakes.charts, words, account)?;
        prepared.parameters.mean_from = mean_from(
            far_from,
            [chart.image.width, chart.image.height],
            prepared.parameters.depth,
            &facets[first_facet as usize..],
        );
        for (index, layer) in described(object).enumerate() {
            let (map, parameters) = match prepared.layers.get(index) {
                Some(layer) => (&layer.map, &layer.parameters),
                None => (&prepared.map, &prepared.parameters),
            };
            let (cells, cell_width) =
                cells_of(scene, &layer, map, &mut bakes.cells, words, account)?;
            let part = layer.pieces.map_or(0, |[number, _]| number);
            // In the order of the classes; `None` is that of the mesh.
            let mut classes: Vec<(Option<Material>, Image)> = Vec::new();
            for (name, color) in [
                (&layer.finish.cap, layer.material.cap),
                (&layer.finish.wall, layer.material.wall),
                (&layer.finish.bevel, layer.material.bevel),
                (&layer.finish.floor, layer.material.floor),
            ] {
                let mut materials = scene.materials.iter();
                let named = materials
                    .find(|material| name.as_ref().is_some_and(|name| *name == material.name));
                let material = match (named, name.as_deref()) {
                    (Some(material), _) => {
                        Some(named_material(material, pictures, words, account)?)
                    }
                    (None, Some(scene::Finish::OF_MESH)) => None,
                    (None, _) => Some(plain_material(color, &object.material)),
                };
                let cells = match named.is_some_and(PhysicalMaterial::varies) {
                    true => cells,
                    false => Image::default(),
                };
                classes.push((material, cells));
            }
            for mesh_material in &mesh_materials {
                finishes.extend(classes.iter().map(|(material, cells)| Finish {
                    material: material.unwrap_or(*mesh_material),
                    first_facet,
                    depth: prepared.parameters.depth,
                    inverse_repeat: object.repeat.map(|repeat| (1.0 / repeat) as f32),
                    period: object.repeat.map(|repeat| match repeat.fract() == 0.0 {
                        true => repeat as f32,
                        false => 0.0,
                    }),
                    cells: *cells,
                    // Pieces are numbered anew in each part.
                    seed: prepared.number as u32 ^ part << 16,
                    growth: growth(parameters),
                    rim: rim(parameters),
                    side: match grows_mostly(parameters) {
                        true => CLASS_BEVEL,
                        false => CLASS_WALL,
                    },
                    cell_width,
                    chart,
                }));
            }
        }
    }
    Ok((finishes, facets))
}

/// Returns the cells of the pattern of `layer`, whose map is `map`, if one of its materials varies
/// from cell to cell, and the width of a cell, texels.
fn cells_of(
    scene: &Scene,
    layer: &Described<'_>,
    map: &Arc<ShapeMap>,
    known: &mut Memo<Same<ShapeMap>, Cells>,
    words: &mut Vec<u32>,
    account: &mut Account<'_>,
) -> Result<(Image, f32), Error> {
    let varies = |(_, name): (_, &str)| {
        let mut materials = scene.materials.iter();
        materials.any(|material| material.name == name && material.varies())
    };
    if !layer.finish.names().any(varies) {
        return Ok((Image::default(), 0.0));
    }
    let [width, height] = [map.width(), map.height()];
    account.take(layer.shape, u64::from(width) * u64::from(height), 32)?;
    let first = words.len() as u32;
    let key = Same(map.clone());
    let cells = known
        .get(&key)
        .unwrap_or_else(|| known.insert(key, cells(map)));
    words.extend(&cells.words);
    let image = Image {
        first,
        width,
        height,
        levels: 1,
    };
    let area = f64::from(width) * f64::from(height) / f64::from(cells.count.max(1));
    Ok((image, area.sqrt() as f32))
}

/// Returns the chart of an object's pattern, if smooth edges are asked for, and the width of a pixel from which on
/// the mean is all that it shows, texels of the chart.
fn chart_of(
    scene: &Scene,
    object: &SceneObject,
    prepared: &PreparedObject,
    known: &mut Memo<(Same<ShapeMap>, f32), Charted>,
    words: &mut Vec<u32>,
    account: &mut Account<'_>,
) -> Result<(Chart, f32), Error> {
    let Object {
        map_format,
        cut_out,
        ..
    } = prepared.parameters;
    // The paper's maps have no distances inside the pattern, and what is seen through holes is
    // no surface of the object. Layers have no mean.
    let has_none = map_format == FORMAT_PAPER || cut_out != 0 || !prepared.layers.is_empty();
    if !scene.smooth_edges || has_none {
        return Ok((Chart::default(), f32::INFINITY));
    }
    let map = &prepared.map;
    let radius = Profile::new(&prepared.parameters).radius(0.0);
    let key = (Same(map.clone()), radius);
    let found = match known.get(&key) {
        Some(found) => {
            account.take(&object.shape, found.image.texels(), TEXEL)?;
            found
        }
        None => {
            let (chart, size) = chart::chart(map, radius);
            account.take(&object.shape, chart::area(size), TEXEL)?;
            known.insert(key, Charted::new(map, radius, chart, size))
        }
    };
    let chart = Chart {
        image: found.image.append(words),
        ..found.chart
    };
    Ok((chart, found.far_from))
}

/// Returns how the pattern lies on a triangle with the materials of `slot`.
fn on_facet(triangle: &MeshTriangle, repeat: [f64; 2], slot: u32) -> FacetMaterial {
    let (_, whole) = repeats(triangle, repeat);
    let mean = |axis: usize| {
        let lengths = triangle.corners.iter().map(|corner| match axis {
            0 => corner.gradient_u.length(),
            _ => corner.gradient_v.length(),
        });
        (lengths.sum::<f64>() / 3.0 * repeat[axis]) as f32
    };
    FacetMaterial {
        whole: whole.map(|repeats| repeats as f32),
        density: [mean(0), mean(1)],
        slot,
    }
}

/// Returns the material of a colour: a dielectric with a highlight like that of Blinn and Phong.
fn plain_material(color: Color, gloss: &scene::Material) -> Material {
    // The exponent of microfacets of this α.
    let alpha = (2.0 / (f64::from(gloss.shininess) + 2.0)).sqrt();
    Material {
        base_color: color.linear(),
        roughness: alpha.sqrt() as f32,
        tiles: [1.0; 2],
        ..Material::default()
    }
}

fn named_material(
    material: &PhysicalMaterial,
    pictures: &mut Pictures<'_>,
    words: &mut Vec<u32>,
    account: &mut Account<'_>,
) -> Result<Material, Error> {
    let mut picture = |path: &Option<PathBuf>, encoding| match path {
        Some(path) => pictures.load(path, encoding, words, account),
        None => Ok(Image::default()),
    };
    Ok(Material {
        base_color: material.base_color.linear(),
        metallic: material.metallic as f32,
        emission: material
            .emission
            .linear()
            .map(|light| light * material.emission_strength as f32),
        roughness: material.roughness as f32,
        normal_scale: material.normal_scale as f32,
        tiles: material.tiles.map(|tiles| tiles as f32),
        offset: [0.0; 2],
        shade_variation: material.shade_variation as f32,
        shifts: u32::from(material.shifts),
        turns: u32::from(material.turns),
        follows: material.coordinates.code(),
        base_color_image: picture(&material.base_color_image, Encoding::Color)?,
        metallic_roughness_image: picture(&material.metallic_roughness_image, Encoding::Linear)?,
        normal_image: picture(&material.normal_image, Encoding::Linear)?,
        emission_image: picture(&material.emission_image, Encoding::Color)?,
    })
}
