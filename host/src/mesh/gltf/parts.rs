//! The scene tree: primitives with triangles and their transforms.

use glam::{DMat4, DQuat, DVec3};
use gltf::buffer::View;
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Accessor, Document, Mesh, Node, Primitive, Semantic};

use super::draco::Draco;
use super::problem::Problem;

/// Attributes that are read.
const READ: [Semantic; 3] = [
    Semantic::Positions,
    Semantic::Normals,
    Semantic::TexCoords(0),
];

/// Maximum depth of the node tree.
const DEEPEST: usize = 4096;

/// A primitive and its transform.
pub(super) struct Part<'a> {
    pub primitive: Primitive<'a>,
    /// Transform to the scene; `None` for the identity.
    pub transform: Option<DMat4>,
    /// Its geometry, if it is compressed.
    pub draco: Option<Draco<'a>>,
    /// Name in messages.
    pub name: String,
}

/// Returns the primitives with triangles of the default scene, in tree order.
pub(super) fn parts(document: &Document) -> Result<Vec<Part<'_>>, Problem> {
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
            let problem = "has a node with two parents; export it again";
            return Err(problem.into());
        }
        if depth > DEEPEST {
            return Err("has nodes nested too deep; export it again".into());
        }
        let own = transform(&node);
        let transform = match (around, own) {
            (Some(around), Some(own)) => Some(around * own),
            (around, own) => around.or(own),
        };
        if let Some(mesh) = node.mesh() {
            let is_skinned = node.skin().is_some();
            // Bones transform a skinned mesh, not its node.
            let transform = if is_skinned { None } else { transform };
            for primitive in mesh.primitives() {
                if !matches!(
                    primitive.mode(),
                    Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
                ) {
                    continue;
                }
                is_posed |= is_skinned || primitive.morph_targets().len() > 0;
                let name = part_name(&mesh, &primitive);
                let draco = Draco::of(document, mesh.index(), &primitive, &READ)?;
                parts.push(Part {
                    name,
                    primitive,
                    draco,
                    transform,
                });
            }
        }
        let first_child = left.len();
        left.extend(node.children().map(|child| (child, transform, depth + 1)));
        left[first_child..].reverse();
    }
    if is_posed {
        log::warn!("a mesh with bones or morph targets is loaded in its rest pose");
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

/// Returns the transform of a node, or `None` for the identity.
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
    /// Returns the number of corners of the triangles.
    fn corner_count(&self) -> Result<usize, Problem> {
        let positions = self.primitive.get(&Semantic::Positions);
        let positions = positions
            .ok_or_else(|| format!("{} has no positions; export it with them", self.name))?;
        Ok(self.primitive.indices().unwrap_or(positions).count())
    }

    pub fn triangle_count(&self) -> Result<usize, Problem> {
        let corners = self.corner_count()?;
        match self.primitive.mode() {
            Mode::Triangles if corners % 3 != 0 => Err(format!(
                "{}: {corners} corners are not a multiple of 3; export it again",
                self.name
            )
            .into()),
            Mode::Triangles => Ok(corners / 3),
            _ => Ok(corners.saturating_sub(2)),
        }
    }

    /// Returns the buffer views that are read.
    pub fn views(&self) -> impl Iterator<Item = View<'_>> {
        let views = self.accessors().flat_map(|accessor| {
            let sparse = accessor.sparse();
            let sparse = sparse.map(|sparse| [sparse.indices().view(), sparse.values().view()]);
            sparse.into_iter().flatten().chain(accessor.view())
        });
        views.chain(self.draco.as_ref().map(|draco| draco.view.clone()))
    }

    /// Returns the accessors that are read.
    fn accessors(&self) -> impl Iterator<Item = Accessor<'_>> {
        let draco = self.draco.as_ref();
        let is_read = move |semantic: &&Semantic| draco.is_none_or(|draco| !draco.has(semantic));
        let streams = READ.iter().filter(is_read);
        let streams = streams.filter_map(|semantic| self.primitive.get(semantic));
        let indices = self.primitive.indices();
        streams.chain(indices.filter(|_| draco.is_none()))
    }
}
