//! Prepares a carved object: meshes and patterns become what the shader reads.

use crate::Carved;
use crate::hull::{Hull, MOST_FACETS, hull};
use crate::material::{CarvingKey, shader};
use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::render::storage::ShaderBuffer;
use bevy::shader::Shader;
use relievo::export::EngineHit;
use relievo::mesh::MeshData;
use relievo::prepare::PreparedObject;
use relievo::scene::{Scene, SceneObject, Shape};
use relievo::shape_map;
use std::sync::Arc;

/// A prepared object.
pub(crate) struct Prepared {
    pub key: CarvingKey,
    pub shader: Shader,
    /// Contents of the object's, the facets' and the map's buffer.
    pub buffers: [ShaderBuffer; 3],
    pub hull: Hull,
    /// The object's origin in the space of the mesh.
    pub origin: Vec3,
}

/// Returns the triangles of `mesh`.
///
/// # Errors
/// What the mesh lacks, and the remedy.
pub(crate) fn mesh_data(mesh: &Mesh) -> Result<MeshData, String> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return Err("its mesh is no list of triangles; make it one".to_string());
    }
    let attribute = |attribute| {
        mesh.try_attribute_option(attribute).map_err(|_| {
            "its mesh is not kept in memory; load it with RenderAssetUsages::MAIN_WORLD".to_string()
        })
    };
    let vectors = |values: Option<&VertexAttributeValues>| match values {
        Some(VertexAttributeValues::Float32x3(values)) => {
            values.iter().map(|v| v.map(f64::from)).collect()
        }
        _ => Vec::new(),
    };
    let positions: Vec<[f64; 3]> = vectors(attribute(Mesh::ATTRIBUTE_POSITION)?);
    let normals = vectors(attribute(Mesh::ATTRIBUTE_NORMAL)?);
    let Some(VertexAttributeValues::Float32x2(uvs)) = attribute(Mesh::ATTRIBUTE_UV_0)? else {
        return Err("its mesh has no texture coordinates (Mesh::ATTRIBUTE_UV_0), along which the pattern repeats; add them".to_string());
    };
    // Relievo's v grows up.
    let uvs: Vec<[f64; 2]> = uvs
        .iter()
        .map(|[u, v]| [f64::from(*u), 1.0 - f64::from(*v)])
        .collect();
    let indices: Vec<u32> = match mesh.indices() {
        Some(Indices::U16(indices)) => indices.iter().copied().map(u32::from).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..positions.len() as u32).collect(),
    };
    let (triangles, rest) = indices.as_chunks::<3>();
    if !rest.is_empty() {
        return Err("the number of its mesh's indices is no multiple of 3".to_string());
    }
    if triangles.len() > MOST_FACETS {
        return Err(format!(
            "its mesh has more than {MOST_FACETS} triangles; split it"
        ));
    }
    Ok(MeshData::new("mesh", positions, triangles)
        .with_normals(normals)
        .with_uvs(uvs))
}

/// Returns the object that `carved` describes.
fn object(carved: &Carved, mesh: MeshData, pattern: Arc<shape_map::Pattern>) -> SceneObject {
    let mut object = SceneObject::new(mesh, Shape::Pattern(pattern))
        .named("carved")
        .with_technique(carved.technique)
        .tier(carved.tier)
        .repeat(carved.repeat.x, carved.repeat.y)
        .raised(carved.raised)
        .cut_out(carved.cut_out);
    object.depth = carved.depth.map(f64::from);
    let given = [
        (carved.extension, &mut object.extrusion.extension),
        (carved.bevel, &mut object.extrusion.bevel),
        (carved.chamfer, &mut object.extrusion.chamfer),
    ];
    for (value, parameter) in given {
        if let Some(value) = value {
            *parameter = f64::from(value);
        }
    }
    object
}

/// Prepares an object.
///
/// # Errors
/// What is wrong with it, and the remedy.
pub(crate) fn prepare(
    carved: &Carved,
    mesh: MeshData,
    pattern: Arc<shape_map::Pattern>,
) -> Result<Prepared, String> {
    let scene = Scene::default().object(object(carved, mesh, pattern));
    let scene = relievo::prepare::prepare(&scene, &|_| ()).map_err(|error| error.to_string())?;
    prepared(
        &scene.objects[0],
        narrow(scene.origin.to_array()),
        carved.repeat,
    )
}

fn narrow(vector: [f64; 3]) -> Vec3 {
    Vec3::from(vector.map(|part| part as f32))
}

/// Returns what an object is drawn with, whose positions are relative to `origin` in the space of
/// the mesh.
fn prepared(object: &PreparedObject, origin: Vec3, repeat: Vec2) -> Result<Prepared, String> {
    let hit = EngineHit::of(object);
    let shader = shader(&hit).map_err(|error| error.to_string())?;
    let buffer = |bytes: &[u8]| ShaderBuffer::new(bytes, RenderAssetUsages::RENDER_WORLD);
    Ok(Prepared {
        key: CarvingKey::of(hit.shader()),
        shader,
        buffers: hit.buffers().map(|bytes| buffer(&bytes)),
        hull: hull(object, origin, repeat),
        origin,
    })
}

/// A prepared object of a scene.
pub(crate) struct Placed {
    pub object: Prepared,
    pub name: String,
    /// Number of the object in the scene.
    pub number: usize,
    pub repeat: Vec2,
    pub transform: Transform,
}

/// Prepares the objects of a scene.
///
/// # Errors
/// What is wrong with it, and the remedy.
pub(crate) fn prepare_scene(scene: &Scene) -> Result<Vec<Placed>, String> {
    let all = relievo::prepare::prepare(scene, &|_| ()).map_err(|error| error.to_string())?;
    let origin = narrow(all.origin.to_array());
    let place = |object: &PreparedObject| {
        let transform = object.placement.map_or(Transform::IDENTITY, |placement| {
            let turn = placement.rotation.to_array().map(|part| part as f32);
            Transform {
                translation: narrow(placement.translation.to_array()),
                rotation: Quat::from_array(turn).normalize(),
                scale: Vec3::splat(placement.scale as f32),
            }
        });
        let repeat = scene.objects[object.number].repeat.map(|part| part as f32);
        Ok(Placed {
            object: prepared(object, Vec3::ZERO, repeat.into())?,
            name: object.name.clone(),
            number: object.number,
            repeat: repeat.into(),
            transform: Transform::from_translation(origin) * transform,
        })
    };
    all.objects.iter().map(place).collect()
}
