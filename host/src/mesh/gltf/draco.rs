//! Primitives with KHR_draco_mesh_compression, which `draco-gltf` decodes.

use draco_gltf::{
    ComponentType, DecodeLimits, DracoPrimitiveContract, DracoPrimitiveExtension, JsonValue,
    PackedAttribute, PackedGeometry,
};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;
use gltf::{Accessor, Document, Primitive, Semantic};

use super::numbers::Numbers;
use super::problem::{BufferError, Problem, whole_number};

/// Name of the extension.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// The compressed geometry of a primitive.
pub(super) struct Draco<'a> {
    /// Where it lies.
    pub view: View<'a>,
    extension: DracoPrimitiveExtension,
    contract: DracoPrimitiveContract,
}

impl<'a> Draco<'a> {
    /// Returns that of `primitive`, with those of its attributes that `wanted` names; `None` if it is
    /// not compressed.
    pub fn of(
        document: &'a Document,
        primitive: &Primitive<'a>,
        wanted: &[Semantic],
    ) -> Result<Option<Draco<'a>>, Problem> {
        let Some(object) = primitive.extension_value(NAME) else {
            return Ok(None);
        };
        let problem = |what: &str| Problem(format!("{NAME}: {what}; export it again"));
        let view = whole_number(object, "bufferView").and_then(|index| document.views().nth(index));
        let view = view.ok_or_else(|| problem("there is no such buffer view"))?;
        let mut contract = DracoPrimitiveContract::new();
        if let Some(indices) = primitive.indices() {
            contract = contract.with_indices(indices.count() as u64);
        }
        let mut attributes = Vec::new();
        for semantic in wanted {
            let name = semantic.to_string();
            let Some(accessor) = primitive.get(semantic) else {
                continue;
            };
            contract =
                contract.with_attribute(&name, accessor.count() as u64, accessor.normalized());
            if let Some(id) = object
                .get("attributes")
                .and_then(|ids| whole_number(ids, &name))
            {
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
            extension: extension.map_err(|error| problem(&error.to_string()))?,
            contract,
        }))
    }

    /// Returns whether the attribute `semantic` is compressed.
    pub fn has(&self, semantic: &Semantic) -> bool {
        self.extension.unique_id(&semantic.to_string()).is_some()
    }

    /// Returns the geometry, whose compressed bytes are `payload`, if it has at most `limit` bytes.
    pub fn decode(&self, payload: &[u8], limit: u64) -> Result<Geometry, BufferError> {
        // A triangle is three indices, and a point at least a position.
        let limits = DecodeLimits::default()
            .with_max_faces(limit / 12)
            .with_max_points(limit / 12)
            .with_max_decoded_bytes(limit);
        let contract = self.contract.clone().with_limits(limits);
        match self.extension.decode(payload, &contract) {
            Ok(geometry) => Ok(Geometry(geometry)),
            Err(error) if error.is_decode_limit_exceeded() => Err(BufferError::TooLarge),
            Err(error) => {
                Err(format!("it cannot be decompressed ({error}); export it again").into())
            }
        }
    }
}

/// What a primitive's compressed geometry decodes to: a list of triangles.
pub(super) struct Geometry(PackedGeometry);

impl Geometry {
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
