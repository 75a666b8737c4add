//! Primitives with KHR_draco_mesh_compression, which `draco-gltf` decodes.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use draco_gltf::{
    ComponentType, DecodeLimits, DracoPrimitiveContract, DracoPrimitiveExtension, JsonValue,
    PackedAttribute, PackedGeometry,
};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;
use gltf::json::Value;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Primitive, Semantic};

use super::buffers::Buffers;
use super::numbers::Numbers;
use super::problem::{BufferError, Problem, whole_number};

/// Name of the extension.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// The compressed geometry of a primitive.
pub(super) struct Draco<'a> {
    /// Where it lies.
    pub view: View<'a>,
    /// Indices of the mesh and of the primitive.
    key: (usize, usize),
    /// Number of triangles.
    triangles: u64,
    extension: DracoPrimitiveExtension,
    contract: DracoPrimitiveContract,
}

impl<'a> Draco<'a> {
    /// Returns that of a primitive of mesh `mesh`, with those of its attributes that `wanted` names;
    /// `None` if it is not compressed.
    pub fn of(
        document: &'a Document,
        mesh: usize,
        primitive: &Primitive<'a>,
        wanted: &[Semantic],
    ) -> Result<Option<Draco<'a>>, Problem> {
        let Some(object) = primitive.extension_value(NAME) else {
            return Ok(None);
        };
        let key = (mesh, primitive.index());
        let problem = |what: &str| located(key, what);
        let told = |Problem(what): Problem| located(key, &what);
        let view = whole_number(object, "bufferView").map_err(told)?;
        let view = view.and_then(|index| document.views().nth(index));
        let view = view.ok_or_else(|| problem("there is no such buffer view"))?;
        if primitive.mode() != Mode::Triangles {
            return Err(problem("it is a strip or a fan, no list of triangles"));
        }
        let indices = primitive.indices();
        let indices = indices.ok_or_else(|| problem("it has no indices"))?.count() as u64;
        let mut contract = DracoPrimitiveContract::new().with_indices(indices);
        let none = Value::Null;
        let ids = object.get("attributes").unwrap_or(&none);
        let mut attributes = Vec::new();
        for semantic in wanted {
            let name = semantic.to_string();
            let Some(accessor) = primitive.get(semantic) else {
                continue;
            };
            let count = accessor.count() as u64;
            contract = contract.with_attribute(&name, count, accessor.normalized());
            if let Some(id) = whole_number(ids, &name).map_err(told)? {
                attributes.push((name, JsonValue::from(id as u64)));
            }
        }
        let json = JsonValue::object([
            ("bufferView", JsonValue::from(view.index() as u64)),
            ("attributes", JsonValue::Object(attributes)),
        ]);
        let extension = DracoPrimitiveExtension::from_json(&json);
        Ok(Some(Draco {
            view,
            key,
            triangles: indices / 3,
            extension: extension.map_err(|error| problem(&error.to_string()))?,
            contract,
        }))
    }

    /// Returns whether the attribute `semantic` is compressed.
    pub fn has(&self, semantic: &Semantic) -> bool {
        self.extension.unique_id(&semantic.to_string()).is_some()
    }

    /// Returns the geometry, whose compressed bytes are `payload`, if it has at most `limit` bytes.
    fn decode(&self, payload: &[u8], limit: u64) -> Result<Geometry, BufferError> {
        // A triangle has three indices. Twice as many as declared are an error of the file; what has
        // more is not decoded.
        let limits = DecodeLimits::default()
            .with_max_faces(self.triangles.saturating_mul(2).min(limit / 12))
            .with_max_decoded_bytes(limit);
        let contract = self.contract.clone().with_limits(limits);
        match self.extension.decode(payload, &contract) {
            Ok(geometry) => Ok(Geometry(geometry)),
            Err(error) if error.is_decode_limit_exceeded() => Err(BufferError::TooLarge),
            Err(error) => {
                Err(located(self.key, &format!("it cannot be decompressed ({error})")).into())
            }
        }
    }
}

/// Returns the problem of the primitive `key`.
fn located((mesh, primitive): (usize, usize), problem: &str) -> Problem {
    format!("mesh {mesh}, primitive {primitive}, {NAME}: {problem}; export it again").into()
}

/// What the compressed primitives decode to, by the indices of their meshes and their own.
pub(super) struct Geometries(BTreeMap<(usize, usize), Geometry>);

impl Geometries {
    /// Decodes each primitive of `all`, once where several nodes show it: at most the bytes that
    /// `buffers` has left, in total.
    pub fn decode<'d>(
        all: impl Iterator<Item = &'d Draco<'d>>,
        buffers: &Buffers<'_>,
    ) -> Result<Geometries, BufferError> {
        let mut limit = buffers.left;
        let mut found = BTreeMap::new();
        for draco in all {
            if let Entry::Vacant(place) = found.entry(draco.key) {
                let geometry = draco.decode(buffers.view(&draco.view)?, limit)?;
                limit = limit.saturating_sub(geometry.size());
                place.insert(geometry);
            }
        }
        Ok(Geometries(found))
    }

    /// Returns that of `draco`, which has been decoded.
    pub fn of(&self, draco: &Draco<'_>) -> &Geometry {
        &self.0[&draco.key]
    }
}

/// What a primitive's compressed geometry decodes to: a list of triangles.
pub(super) struct Geometry(PackedGeometry);

impl Geometry {
    /// Returns the number of its bytes.
    fn size(&self) -> u64 {
        let attributes = self.0.attributes().iter().map(|all| all.bytes().len());
        let indices = self.0.indices().map_or(0, |all| all.bytes().len());
        (attributes.sum::<usize>() + indices) as u64
    }

    /// Returns the attribute `semantic`, if it was compressed.
    pub fn attribute(
        &self,
        semantic: &Semantic,
        accessor: &Accessor<'_>,
        dimensions: Dimensions,
    ) -> Result<Option<Numbers<'_>>, Problem> {
        let name = semantic.to_string();
        let is_it = |attribute: &&PackedAttribute| attribute.semantic() == name;
        let Some(found) = self.0.attributes().iter().find(is_it) else {
            return Ok(None);
        };
        let kind = data_type(found.component_type())
            .filter(|_| usize::from(found.components()) == dimensions.multiplicity())
            .ok_or_else(|| format!("its compressed {name} has another type; export it again"))?;
        let is_normalized = accessor.normalized();
        Ok(Some(Numbers::packed(
            found.bytes(),
            found.count(),
            kind,
            dimensions.multiplicity(),
            is_normalized,
        )))
    }

    /// Returns the corners of its triangles.
    pub fn indices(&self) -> Option<Numbers<'_>> {
        let indices = self.0.indices()?;
        let (bytes, count) = (indices.bytes(), indices.count());
        Some(Numbers::packed(bytes, count, DataType::U32, 1, false))
    }
}

/// Returns the type of the components of an attribute; `None` if no accessor has it.
fn data_type(component: ComponentType) -> Option<DataType> {
    Some(match component {
        ComponentType::I8 => DataType::I8,
        ComponentType::U8 => DataType::U8,
        ComponentType::I16 => DataType::I16,
        ComponentType::U16 => DataType::U16,
        ComponentType::U32 => DataType::U32,
        ComponentType::F32 => DataType::F32,
        _ => return None,
    })
}
