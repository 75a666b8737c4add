//! Writes an object's triangles as a binary glTF file, with the shaders' data of each
//! corner as custom attributes.

use super::error::ExportError;
use crate::prepare::PreparedObject;
use glam::{DQuat, DVec3};
use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::{Stride, Target, View};
use gltf::json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::scene::UnitQuaternion;
use gltf::json::validation::Checked::Valid;
use gltf::json::validation::USize64;
use gltf::json::{self, Accessor, Asset, Buffer, Index, Material, Mesh, Node, Root, Scene, Value};
use relievo_shared::layout::{Corner, depth_reductions};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Returns the attributes in the order of their bytes in a vertex. Texture
/// coordinates and gradients are those of the shaders: in repeats of the pattern,
/// with v pointing down as in glTF.
fn attributes() -> [(Semantic, Type); 8] {
    let own = |name: &str| Semantic::Extras(name.to_string());
    [
        (Semantic::Positions, Type::Vec3),
        (Semantic::Normals, Type::Vec3),
        (Semantic::Tangents, Type::Vec4),
        (Semantic::TexCoords(0), Type::Vec2),
        (own("QUADRIC"), Type::Vec3),
        (own("GRADIENT_U"), Type::Vec3),
        (own("GRADIENT_V"), Type::Vec3),
        (own("DEPTH_REDUCTION"), Type::Scalar),
    ]
}

/// Number of f32 per vertex.
const NUMBERS: usize = 22;

/// Returns the numbers of a vertex in the order of [`attributes`].
fn numbers(corner: &Corner, handedness: f32, depth_reduction: f32) -> impl Iterator<Item = f32> {
    let Corner {
        position,
        normal,
        tangent,
        uv,
        quadric,
        gradient_u,
        gradient_v,
    } = *corner;
    position
        .into_iter()
        .chain(normal)
        .chain(tangent)
        .chain([handedness])
        .chain(uv)
        .chain(quadric)
        .chain(gradient_u)
        .chain(gradient_v)
        .chain([depth_reduction])
}

/// Writes the object as a .glb file. `origin` is the scene's origin, world units.
pub(super) fn glb(object: &PreparedObject, origin: DVec3) -> Result<Vec<u8>, ExportError> {
    let failed = |message: String| ExportError::Mesh {
        object: object.name.clone(),
        message,
    };
    let stride = size_of::<f32>() * NUMBERS;
    let count = 3 * object.triangles.len();
    // Lengths in the format have 32 bits; the JSON is far smaller than 1 MiB.
    const MOST: usize = u32::MAX as usize - (1 << 20);
    let length = count.saturating_mul(stride);
    if length > MOST {
        return Err(failed(format!(
            "{} triangles take {length} bytes, and a .glb file holds 4 GiB; simplify the mesh",
            object.triangles.len()
        )));
    }
    let mut bytes = Vec::with_capacity(length);
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for triangle in object.triangles.iter() {
        let reductions = depth_reductions(triangle.depth_reductions);
        for (corner, reduction) in triangle.corners.iter().zip(reductions) {
            let (lower, higher) = (low.iter_mut(), high.iter_mut());
            for ((low, high), &at) in lower.zip(higher).zip(&corner.position) {
                (*low, *high) = (low.min(at), high.max(at));
            }
            let numbers = numbers(corner, triangle.handedness, reduction);
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
        }
    }
    let root = root(object, origin, count, [low, high]);
    let text = root.to_vec().map_err(|error| failed(error.to_string()))?;
    let file = Glb {
        header: Header {
            magic: *b"glTF",
            version: 2,
            // Computed by the writer.
            length: 0,
        },
        json: Cow::Owned(text),
        bin: Some(Cow::Owned(bytes)),
    };
    file.to_vec().map_err(|error| failed(error.to_string()))
}

/// Builds the JSON of the file.
fn root(object: &PreparedObject, origin: DVec3, count: usize, bounds: [[f32; 3]; 2]) -> Root {
    let mut root = Root {
        asset: Asset {
            generator: Some(concat!("relievo ", env!("CARGO_PKG_VERSION")).to_string()),
            ..Asset::default()
        },
        ..Root::default()
    };
    let stride = size_of::<f32>() * NUMBERS;
    let buffer = root.push(Buffer {
        byte_length: USize64::from(count * stride),
        name: None,
        uri: None,
        extensions: None,
        extras: None,
    });
    let view = root.push(View {
        buffer,
        byte_length: USize64::from(count * stride),
        byte_offset: None,
        byte_stride: Some(Stride(stride)),
        name: None,
        target: Some(Valid(Target::ArrayBuffer)),
        extensions: None,
        extras: None,
    });
    let mut offset = 0;
    let mut accessors = BTreeMap::new();
    for (semantic, kind) in attributes() {
        let is_position = semantic == Semantic::Positions;
        let bound = |at: usize| is_position.then(|| Value::from(bounds[at].to_vec()));
        let accessor = root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: Some(USize64::from(offset)),
            count: USize64::from(count),
            component_type: Valid(GenericComponentType(ComponentType::F32)),
            type_: Valid(kind),
            min: bound(0),
            max: bound(1),
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: None,
        });
        offset += kind.multiplicity() * size_of::<f32>();
        accessors.insert(Valid(semantic), accessor);
    }
    let [red, green, blue] = object.parameters.cap_color;
    let material = root.push(Material {
        name: Some("cap".to_string()),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([red, green, blue, 1.0]),
            metallic_factor: StrengthFactor(0.0),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    });
    let mesh = root.push(Mesh {
        name: Some(object.name.clone()),
        primitives: vec![Primitive {
            attributes: accessors,
            indices: None,
            material: Some(material),
            mode: Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        }],
        weights: None,
        extensions: None,
        extras: None,
    });
    let placement = object.placement.unwrap_or_default();
    let turned = placement.rotation != DQuat::IDENTITY;
    let scaled = placement.scale != 1.0;
    let node = root.push(Node {
        name: Some(object.name.clone()),
        mesh: Some(mesh),
        translation: Some((origin + placement.translation).as_vec3().to_array()),
        rotation: turned.then(|| UnitQuaternion(placement.rotation.as_quat().to_array())),
        scale: scaled.then_some([placement.scale as f32; 3]),
        ..Node::default()
    });
    let scene: Index<Scene> = root.push(json::Scene {
        name: None,
        nodes: vec![node],
        extensions: None,
        extras: None,
    });
    root.scene = Some(scene);
    root
}
