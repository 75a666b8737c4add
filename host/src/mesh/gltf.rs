//! glTF 2.0 files, as text (`.gltf`) or binary (`.glb`).
//!
//! The `gltf` crate reads the description; the numbers are read here, each
//! where it is used, so that what a file costs goes by its triangles and not by
//! the counts that it claims.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::ErrorKind;
use std::path::Path;

use data_url::DataUrl;
use glam::{DMat3, DMat4, DQuat, DVec2, DVec3};
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::{Source, View};
use gltf::json::Root;
use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Accessor, Document, Mesh, Node, Primitive, Semantic};

use super::error::MeshError;
use super::obj::{Corner, SourceMesh};
use super::scan::LARGEST_NUMBER;
use crate::Files;

/// A binary file begins so.
pub(super) const MAGIC: &[u8] = b"glTF";

/// Bytes that an object of the description may take in memory. A file of so
/// many times fewer bytes as it holds objects is refused unread.
const OBJECT_BYTES: u64 = 512;

/// Bytes that nobody asks about.
const FREE: u64 = 1 << 20;

/// Bytes in memory that the caller counts for a byte of a file.
const COUNTED: u64 = 4;

/// Beginnings of the names of extensions that do not change where triangles
/// are, or whose numbers are read here as any others.
const HARMLESS: [&str; 8] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_animation_",
    "KHR_xmp",
    "KHR_mesh_quantization",
    "EXT_texture_",
    "MSFT_texture_",
];

/// Most children below children: more are a mistake.
const DEEPEST: usize = 4096;

/// What is wrong with a file, and what to do.
struct Problem(String);

impl<T: Into<String>> From<T> for Problem {
    fn from(text: T) -> Problem {
        Problem(text.into())
    }
}

/// Reads a glTF file of which `bytes` are the content; its other files are
/// named as seen from the folder of `path`.
///
/// # Errors
///
/// [`MeshError::Gltf`], [`MeshError::NoFaces`], [`MeshError::TooManyTriangles`],
/// [`MeshError::TooLarge`].
pub(super) fn parse(
    files: &Files,
    bytes: &[u8],
    path: &Path,
    triangle_limit: usize,
    byte_limit: u64,
) -> Result<SourceMesh, MeshError> {
    let failure = |Problem(problem)| MeshError::Gltf {
        path: path.to_owned(),
        problem,
    };
    let too_large = || MeshError::TooLarge {
        path: path.to_owned(),
        limit: byte_limit,
    };
    let (json, blob) = split(bytes).map_err(failure)?;
    let objects = json.iter().filter(|byte| **byte == b'{').count() as u64;
    if objects.saturating_mul(OBJECT_BYTES) / COUNTED > byte_limit.max(FREE) {
        return Err(too_large());
    }
    let document = document(json).map_err(failure)?;
    let parts = parts(&document).map_err(failure)?;

    let mut count = 0_usize;
    for part in &parts {
        count = count.saturating_add(part.triangle_count().map_err(failure)?);
        if count > triangle_limit {
            return Err(MeshError::TooManyTriangles {
                path: path.to_owned(),
                count,
                limit: triangle_limit,
            });
        }
    }
    if count == 0 {
        return Err(MeshError::NoFaces {
            path: path.to_owned(),
        });
    }

    let buffers = Buffers::load(&document, &parts, files, path, blob, {
        byte_limit.saturating_sub(bytes.len() as u64)
    })
    .map_err(|error| match error {
        BufferError::Problem(problem) => failure(problem),
        BufferError::TooLarge => too_large(),
    })?;
    let lacking = |semantic: Semantic| {
        parts
            .iter()
            .find(|part| part.primitive.get(&semantic).is_none())
    };
    let without_uvs = lacking(Semantic::TexCoords(0)).map(|part| format!("in {}", part.name));
    let mut mesh = SourceMesh {
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        triangles: Vec::with_capacity(count),
        face_without_uvs: without_uvs,
    };
    let has_normals = lacking(Semantic::Normals).is_none();
    for part in &parts {
        part.append(&buffers, has_normals, &mut mesh)
            .map_err(|Problem(problem)| failure(format!("{}: {problem}", part.name).into()))?;
    }
    Ok(mesh)
}

/// The description and the binary part of a file.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Problem> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Ok((bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None));
    };
    let cut = || Problem::from("is cut off or damaged; export it again as glTF 2.0");
    let word = |at: usize| -> Result<u32, Problem> {
        let word = rest.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map(u32::from_le_bytes).ok_or_else(cut)
    };
    let version = word(0)?;
    if version != 2 {
        return Err(format!("is binary glTF {version}; export it again as glTF 2.0").into());
    }
    let mut chunks = rest.get(8..).ok_or_else(cut)?;
    let mut chunk = |wanted: &[u8]| -> Result<Option<&[u8]>, Problem> {
        if chunks.len() < 8 {
            return Ok(None);
        }
        let (header, body) = chunks.split_at(8);
        let length = u32::from_le_bytes([header[0], header[1], header[2], header[3]]);
        let content = body.get(..length as usize).ok_or_else(cut)?;
        if header[4..] != *wanted {
            return Ok(None);
        }
        chunks = &body[content.len()..];
        Ok(Some(content))
    };
    let json = chunk(b"JSON")?.ok_or_else(cut)?;
    Ok((json, chunk(b"BIN\0")?))
}

/// The description, checked as far as the crate's functions rely on it.
fn document(json: &[u8]) -> Result<Document, Problem> {
    let mut root: Root = gltf::json::deserialize::from_slice(json)
        .map_err(|error| format!("is not a glTF 2.0 file ({error}); export it again"))?;
    if let Some(name) = root
        .extensions_required
        .iter()
        .find(|name| !HARMLESS.iter().any(|harmless| name.starts_with(harmless)))
    {
        let way_out = match name.as_str() {
            "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => {
                "is compressed; export it without compression"
            }
            _ => "cannot be read; export it without",
        };
        return Err(format!("needs the extension {name:?}, with which it {way_out}").into());
    }
    // What is left of them changes nothing that is read.
    root.extensions_required.clear();
    // The crate's check takes these for granted.
    let positions = Checked::Valid(Semantic::Positions);
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for index in primitives.filter_map(|primitive| primitive.attributes.get(&positions)) {
        if index.value() >= root.accessors.len() {
            let problem = format!(
                "names accessor {}, and has {}; export it again",
                index.value(),
                root.accessors.len()
            );
            return Err(problem.into());
        }
    }
    let mut first = None;
    root.validate(&root, gltf::json::Path::new, &mut |place, fault| {
        let place = place().to_string();
        // The bounds of positions are found here, and what no view holds is zeros.
        let may_miss = [".min", ".max", ".bufferView"];
        let may_miss = may_miss.iter().any(|end| place.ends_with(end));
        if !(may_miss && fault == Fault::Missing) {
            first.get_or_insert((place, fault));
        }
    });
    match first {
        None => Ok(Document::from_json_without_validation(root)),
        Some((place, fault)) => Err(format!(
            "is not valid glTF: {place}: {fault}; repair it, or export it again"
        )
        .into()),
    }
}

/// Triangles at a place.
struct Part<'a> {
    primitive: Primitive<'a>,
    /// The node's place; none if it moves nothing.
    transform: Option<DMat4>,
    /// For messages.
    name: String,
}

/// The primitives with triangles of the default scene, in the order of its tree.
fn parts(document: &Document) -> Result<Vec<Part<'_>>, Problem> {
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    let roots: Vec<Node<'_>> = match scene {
        Some(scene) => scene.nodes().collect(),
        None => {
            let mut is_child = vec![false; document.nodes().len()];
            for child in document.nodes().flat_map(|node| node.children()) {
                is_child[child.index()] = true;
            }
            document
                .nodes()
                .filter(|node| !is_child[node.index()])
                .collect()
        }
    };
    let mut parts = Vec::new();
    let mut seen = vec![false; document.nodes().len()];
    let mut is_posed = false;
    let mut left: Vec<(Node<'_>, Option<DMat4>, usize)> = Vec::new();
    left.extend(roots.into_iter().rev().map(|node| (node, None, 0)));
    while let Some((node, around, depth)) = left.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            let problem = "has a node that hangs in two places; export it again";
            return Err(problem.into());
        }
        if depth > DEEPEST {
            return Err("has nodes within nodes without end; export it again".into());
        }
        let own = transform(&node);
        let transform = match (around, own) {
            (Some(around), Some(own)) => Some(around * own),
            (around, own) => around.or(own),
        };
        if let Some(mesh) = node.mesh() {
            let is_skinned = node.skin().is_some();
            // Bones place a skinned mesh, and not its node.
            let transform = if is_skinned { None } else { transform };
            for primitive in mesh.primitives() {
                if !matches!(
                    primitive.mode(),
                    Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
                ) {
                    continue;
                }
                is_posed |= is_skinned || primitive.morph_targets().len() > 0;
                parts.push(Part {
                    name: part_name(&mesh, &primitive),
                    primitive,
                    transform,
                });
            }
        }
        let first_child = left.len();
        left.extend(node.children().map(|child| (child, transform, depth + 1)));
        left[first_child..].reverse();
    }
    if is_posed {
        tracing::warn!("a mesh with bones or morph targets is taken as it was modelled, unposed");
    }
    Ok(parts)
}

fn part_name(mesh: &Mesh<'_>, primitive: &Primitive<'_>) -> String {
    let name = mesh.name().map(|name| format!(" {name:?}"));
    format!(
        "mesh {}{}, primitive {}",
        mesh.index(),
        name.unwrap_or_default(),
        primitive.index()
    )
}

/// What a node does to what is in it, if anything.
fn transform(node: &Node<'_>) -> Option<DMat4> {
    let matrix = match node.transform() {
        Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            let rotation = DQuat::from_array(rotation.map(f64::from)).normalize();
            let [scale, translation] = [scale, translation].map(|v| DVec3::from(v.map(f64::from)));
            DMat4::from_scale_rotation_translation(scale, rotation, translation)
        }
    };
    (matrix != DMat4::IDENTITY).then_some(matrix)
}

impl Part<'_> {
    /// Corners that the triangles are made of.
    fn corner_count(&self) -> Result<usize, Problem> {
        let positions = self.primitive.get(&Semantic::Positions);
        let positions = positions
            .ok_or_else(|| format!("{} has no positions; export it with them", self.name))?;
        Ok(self.primitive.indices().unwrap_or(positions).count())
    }

    fn triangle_count(&self) -> Result<usize, Problem> {
        let corners = self.corner_count()?;
        match self.primitive.mode() {
            Mode::Triangles if corners % 3 != 0 => Err(format!(
                "{}: {corners} corners are no whole number of triangles; export it again",
                self.name
            )
            .into()),
            Mode::Triangles => Ok(corners / 3),
            _ => Ok(corners.saturating_sub(2)),
        }
    }

    /// The accessors that are read.
    fn accessors(&self) -> impl Iterator<Item = Accessor<'_>> {
        let streams = [
            Semantic::Positions,
            Semantic::Normals,
            Semantic::TexCoords(0),
        ];
        let streams = streams.map(|semantic| self.primitive.get(&semantic));
        streams
            .into_iter()
            .chain([self.primitive.indices()])
            .flatten()
    }

    /// Adds the triangles to `mesh`.
    fn append(
        &self,
        buffers: &Buffers<'_>,
        has_normals: bool,
        mesh: &mut SourceMesh,
    ) -> Result<(), Problem> {
        let stream = |semantic: &Semantic, dimensions, what| {
            let accessor = self.primitive.get(semantic);
            accessor
                .map(|accessor| Numbers::new(&accessor, dimensions, buffers, what))
                .transpose()
        };
        let positions = stream(&Semantic::Positions, Dimensions::Vec3, "positions")?
            .ok_or("has no positions; export it with them")?;
        let normals = match has_normals {
            true => stream(&Semantic::Normals, Dimensions::Vec3, "normals")?,
            false => None,
        };
        let uvs = match mesh.face_without_uvs {
            None => stream(
                &Semantic::TexCoords(0),
                Dimensions::Vec2,
                "texture coordinates",
            )?,
            Some(_) => None,
        };
        let indices = self.primitive.indices();
        let indices = indices
            .map(|accessor| Numbers::new(&accessor, Dimensions::Scalar, buffers, "indices"))
            .transpose()?;
        if let Some(indices) = &indices
            && !matches!(indices.kind, DataType::U8 | DataType::U16 | DataType::U32)
        {
            return Err("its indices are no whole numbers; export it again".into());
        }
        for (what, stream) in [("normals", &normals), ("texture coordinates", &uvs)] {
            if let Some(stream) = stream
                && stream.count != positions.count
            {
                return Err(format!(
                    "it has {} {what} for {} positions; export it again",
                    stream.count, positions.count
                )
                .into());
            }
        }

        let matrix = self.transform.map(DMat3::from_mat4);
        let is_mirrored = matrix.is_some_and(|matrix| matrix.determinant() < 0.0);
        let for_normals = matrix.map(|matrix| {
            // The inverse's transpose but for a factor, also where there is no inverse.
            let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
            let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
            if is_mirrored { -cofactors } else { cofactors }
        });
        let mut known: HashMap<usize, u32> = HashMap::new();
        let mut corner = |number: usize| -> Result<Corner, Problem> {
            let vertex = match &indices {
                None => number,
                Some(indices) => indices.get::<1>(number)?[0] as usize,
            };
            if vertex >= positions.count {
                return Err(format!(
                    "it names position {vertex}, and has {}; export it again",
                    positions.count
                )
                .into());
            }
            let index = match known.get(&vertex) {
                Some(index) => *index,
                None => {
                    let index = mesh.positions.len() as u32;
                    let position = DVec3::from(positions.get(vertex)?);
                    let placed = match &self.transform {
                        None => position,
                        Some(transform) => transform.transform_point3(position),
                    };
                    // False for NaN too.
                    if !(placed.abs().max_element() <= LARGEST_NUMBER && placed.is_finite()) {
                        return Err(format!(
                            "position {vertex} is {placed}; coordinates are finite and at most {LARGEST_NUMBER:e}"
                        )
                        .into());
                    }
                    mesh.positions.push(placed);
                    if let Some(normals) = &normals {
                        let normal = DVec3::from(normals.get(vertex)?);
                        let turned = for_normals
                            .map_or(normal, |matrix| (matrix * normal).normalize_or_zero());
                        // What has no direction is computed.
                        mesh.normals.push(if turned.is_finite() {
                            turned
                        } else {
                            DVec3::ZERO
                        });
                    }
                    if let Some(uvs) = &uvs {
                        let [u, v] = uvs.get(vertex)?;
                        // Upwards, as in OBJ files.
                        let uv = DVec2::new(u, 1.0 - v);
                        if !(uv.abs().max_element() <= LARGEST_NUMBER && uv.is_finite()) {
                            return Err(format!(
                                "texture coordinate {vertex} is {uv}; its numbers are finite and at most {LARGEST_NUMBER:e}"
                            )
                            .into());
                        }
                        mesh.uvs.push(uv);
                    }
                    known.insert(vertex, index);
                    index
                }
            };
            Ok(Corner {
                position: index,
                normal: normals.is_some().then_some(index),
                uv: uvs.is_some().then_some(index),
            })
        };
        for triangle in 0..self.triangle_count()? {
            let numbers = match self.primitive.mode() {
                Mode::TriangleStrip if triangle % 2 == 1 => [triangle, triangle + 2, triangle + 1],
                Mode::TriangleStrip => [triangle, triangle + 1, triangle + 2],
                Mode::TriangleFan => [0, triangle + 1, triangle + 2],
                _ => [3 * triangle, 3 * triangle + 1, 3 * triangle + 2],
            };
            let [a, b, c] = numbers.map(&mut corner);
            let (a, b, c) = (a?, b?, c?);
            mesh.triangles
                .push(if is_mirrored { [a, c, b] } else { [a, b, c] });
        }
        Ok(())
    }
}

/// The contents of the buffers that are read.
struct Buffers<'a>(Vec<Option<Cow<'a, [u8]>>>);

enum BufferError {
    Problem(Problem),
    TooLarge,
}

impl<T: Into<Problem>> From<T> for BufferError {
    fn from(problem: T) -> BufferError {
        BufferError::Problem(problem.into())
    }
}

impl<'a> Buffers<'a> {
    /// Reads the buffers of `parts`, of at most `limit` bytes together.
    fn load(
        document: &Document,
        parts: &[Part<'_>],
        files: &'a Files,
        path: &Path,
        blob: Option<&'a [u8]>,
        mut limit: u64,
    ) -> Result<Buffers<'a>, BufferError> {
        let mut is_read = vec![false; document.buffers().len()];
        for accessor in parts.iter().flat_map(Part::accessors) {
            let sparse = accessor.sparse();
            let sparse = sparse.map(|sparse| [sparse.indices().view(), sparse.values().view()]);
            for view in sparse.into_iter().flatten().chain(accessor.view()) {
                is_read[view.buffer().index()] = true;
            }
        }
        let mut contents = Vec::with_capacity(is_read.len());
        for (buffer, is_read) in document.buffers().zip(is_read) {
            if !is_read {
                contents.push(None);
                continue;
            }
            let index = buffer.index();
            let mut content = match buffer.source() {
                Source::Bin => Cow::Borrowed(blob.filter(|_| index == 0).ok_or_else(|| {
                    format!("buffer {index} has no content; export it with its buffers")
                })?),
                Source::Uri(uri) if is_data(uri) => Cow::Owned(inline(uri, index, limit)?),
                Source::Uri(uri) => external(files, path, uri, limit)?,
            };
            let length = buffer.length();
            if content.len() < length {
                return Err(format!(
                    "buffer {index} has {} bytes and should have {length}; export it again",
                    content.len()
                )
                .into());
            }
            match &mut content {
                Cow::Borrowed(bytes) => *bytes = &bytes[..length],
                Cow::Owned(bytes) => bytes.truncate(length),
            }
            // A binary file's own was counted with the file.
            if !matches!(buffer.source(), Source::Bin) {
                limit = limit.saturating_sub(content.len() as u64);
            }
            contents.push(Some(content));
        }
        Ok(Buffers(contents))
    }

    /// The bytes of a view.
    fn view(&self, view: &View<'_>) -> Result<&[u8], Problem> {
        let content = self.0.get(view.buffer().index());
        let content = content.and_then(|content| content.as_deref());
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| content?.get(view.offset()..end))
            .ok_or_else(|| {
                format!(
                    "buffer view {} reaches beyond its buffer; export it again",
                    view.index()
                )
                .into()
            })
    }
}

fn is_data(uri: &str) -> bool {
    uri.get(..5)
        .is_some_and(|start| start.eq_ignore_ascii_case("data:"))
}

/// The content of a buffer that stands in the file.
fn inline(uri: &str, index: usize, limit: u64) -> Result<Vec<u8>, BufferError> {
    let damaged = || Problem(format!("buffer {index} is damaged base64; export it again"));
    let url = DataUrl::process(uri).map_err(|_| damaged())?;
    let mut bytes = Vec::new();
    let mut is_too_large = false;
    let result = url.decode(|piece| {
        is_too_large = (bytes.len() + piece.len()) as u64 > limit;
        if is_too_large {
            return Err(());
        }
        bytes.extend_from_slice(piece);
        Ok(())
    });
    match result {
        _ if is_too_large => Err(BufferError::TooLarge),
        Ok(_) => Ok(bytes),
        Err(_) => Err(damaged().into()),
    }
}

/// The content of a buffer in a file of its own.
fn external<'a>(
    files: &'a Files,
    path: &Path,
    uri: &str,
    limit: u64,
) -> Result<Cow<'a, [u8]>, BufferError> {
    let has_scheme = uri
        .split_once(':')
        .is_some_and(|(scheme, _)| !scheme.contains('/'));
    let name = decoded(uri).filter(|name| !has_scheme && !name.is_empty());
    let name = name.ok_or_else(|| {
        let shown: String = uri.chars().take(80).collect();
        format!("its buffer {shown:?} is no file; export it with its buffers beside it or in it")
    })?;
    let buffer = path.parent().unwrap_or(Path::new("")).join(name);
    files
        .check(&buffer)
        .map_err(|problem| format!("its buffer {problem}"))?;
    files.read(&buffer, limit).map_err(|source| {
        if source.kind() == ErrorKind::FileTooLarge {
            return BufferError::TooLarge;
        }
        let buffer = buffer.display();
        format!("cannot read its buffer `{buffer}`: {source}; put it there, or export the mesh as .glb, which is one file")
            .into()
    })
}

/// `uri` without the `%20` in it, if that is text.
fn decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = tail.get(..2).filter(|_| *first == b'%');
        let hex = hex.and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

/// The numbers of an accessor; each is read when it is asked for.
struct Numbers<'a> {
    count: usize,
    kind: DataType,
    is_normalized: bool,
    /// None are zeros.
    base: Option<Run<'a>>,
    sparse: Option<Sparse<'a>>,
}

/// Elements in a row.
#[derive(Clone, Copy)]
struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that stand for others.
struct Sparse<'a> {
    count: usize,
    kind: DataType,
    indices: Run<'a>,
    values: Run<'a>,
}

impl<'a> Numbers<'a> {
    fn new(
        accessor: &Accessor<'_>,
        dimensions: Dimensions,
        buffers: &'a Buffers<'_>,
        what: &str,
    ) -> Result<Numbers<'a>, Problem> {
        if accessor.dimensions() != dimensions {
            return Err(format!(
                "its {what} are of the type {:?}, and should be {dimensions:?}; export it again",
                accessor.dimensions()
            )
            .into());
        }
        let (count, size) = (accessor.count(), accessor.size());
        let base = accessor.view();
        let base = base.map(|view| Run::new(&view, accessor.offset(), count, size, buffers));
        let sparse = accessor.sparse().filter(|sparse| sparse.count() > 0);
        let sparse = sparse.map(|sparse| {
            let (indices, values) = (sparse.indices(), sparse.values());
            let kind = match indices.index_type() {
                IndexType::U8 => DataType::U8,
                IndexType::U16 => DataType::U16,
                IndexType::U32 => DataType::U32,
            };
            let places = Run::new(
                &indices.view(),
                indices.offset(),
                sparse.count(),
                indices.index_type().size(),
                buffers,
            );
            let values = Run::new(
                &values.view(),
                values.offset(),
                sparse.count(),
                size,
                buffers,
            );
            Ok::<_, Problem>(Sparse {
                count: sparse.count(),
                kind,
                indices: places?,
                values: values?,
            })
        });
        let sparse = sparse.transpose()?;
        if let Some(sparse) = &sparse {
            let place = |index| sparse.place(index);
            if (1..sparse.count).any(|index| place(index - 1) >= place(index)) {
                return Err(format!(
                    "the sparse indices of its {what} do not grow; export it again"
                )
                .into());
            }
        }
        Ok(Numbers {
            count,
            kind: accessor.data_type(),
            is_normalized: accessor.normalized(),
            base: base.transpose()?,
            sparse,
        })
    }

    /// Element `index`.
    fn get<const N: usize>(&self, index: usize) -> Result<[f64; N], Problem> {
        if index >= self.count {
            return Err(format!("it has no element {index}; export it again").into());
        }
        let sparse = self.sparse.as_ref();
        let element = match sparse.and_then(|sparse| sparse.element(index)) {
            Some(element) => element,
            None => match self.base {
                Some(run) => run.element(index),
                None => return Ok([0.0; N]),
            },
        };
        let size = self.kind.size();
        Ok(std::array::from_fn(|i| {
            number(&element[i * size..], self.kind, self.is_normalized)
        }))
    }
}

impl<'a> Run<'a> {
    /// `count` elements of `size` bytes, from `offset` on.
    fn new(
        view: &View<'_>,
        offset: usize,
        count: usize,
        size: usize,
        buffers: &'a Buffers<'_>,
    ) -> Result<Run<'a>, Problem> {
        let bytes = buffers.view(view)?;
        let stride = view.stride().unwrap_or(size);
        let end = count.checked_sub(1).and_then(|last| {
            last.checked_mul(stride)?
                .checked_add(size)?
                .checked_add(offset)
        });
        let bytes = end.and_then(|end| bytes.get(offset..end));
        match bytes {
            Some(bytes) if stride >= size => Ok(Run { bytes, stride }),
            _ => Err(format!(
                "{count} elements of {size} bytes do not fit buffer view {}; export it again",
                view.index()
            )
            .into()),
        }
    }

    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}

impl<'a> Sparse<'a> {
    /// For which element the one at `index` stands.
    fn place(&self, index: usize) -> usize {
        number(self.indices.element(index), self.kind, false) as usize
    }

    /// What stands for element `wanted`, if anything does.
    fn element(&self, wanted: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match self.place(middle).cmp(&wanted) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Equal => return Some(self.values.element(middle)),
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

/// The number that `bytes` begin with.
fn number(bytes: &[u8], kind: DataType, is_normalized: bool) -> f64 {
    let (value, largest) = match kind {
        DataType::I8 => (f64::from(bytes[0] as i8), 127.0),
        DataType::U8 => (f64::from(bytes[0]), 255.0),
        DataType::I16 => (
            f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            32_767.0,
        ),
        DataType::U16 => (
            f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            65_535.0,
        ),
        DataType::U32 => {
            let word = [bytes[0], bytes[1], bytes[2], bytes[3]];
            (f64::from(u32::from_le_bytes(word)), f64::from(u32::MAX))
        }
        DataType::F32 => {
            let word = [bytes[0], bytes[1], bytes[2], bytes[3]];
            return f64::from(f32::from_le_bytes(word));
        }
    };
    if is_normalized {
        // Two's complement has one number more below zero.
        (value / largest).max(-1.0)
    } else {
        value
    }
}

#[cfg(test)]
mod tests;
