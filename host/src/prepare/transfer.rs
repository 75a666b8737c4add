//! Prepared scenes as bytes, for a thread without shared memory, as a worker of a browser is.
//!
//! What objects share is sent once. What the receiver holds since the delivery before is not sent
//! again, and stays the same [`Arc`] there. Deliveries are received in the order in which they were
//! sent; after an error both ends start anew.
//!
//! ```
//! use relievo::prepare::prepare;
//! use relievo::prepare::transfer::{Receiver, Sender};
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = "[[object]]\nmesh = 'quad.obj'\nshape = { text = 'A' }\nprojection = 'planar-z'\n";
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let prepared = prepare(&scene, &|_| ())?;
//!
//! let (mut sender, mut receiver) = (Sender::default(), Receiver::default());
//! let bytes = sender.send([&prepared]);
//! assert_eq!(receiver.receive(&bytes)?[0].triangle_count(), 2);
//! // All of it is there already.
//! assert!(sender.send([&prepared]).len() < bytes.len() / 10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::{PreparedLayer, PreparedLighting, PreparedObject, PreparedScene};
use crate::mesh::Mesh;
use crate::shape_map::ShapeMap;
use bytemuck::Pod;
use relievo_shared::layout::{PrismData, Triangle};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[cfg(test)]
mod tests;

/// Bytes of the checksum at the end of a delivery.
const CHECKSUM: usize = size_of::<u32>();

/// Error of a delivery that is not as it was sent.
#[derive(Debug, thiserror::Error)]
#[error("a prepared scene did not arrive as it was sent: {problem}; prepare it again")]
pub struct TransferError {
    problem: String,
}

impl TransferError {
    fn new(problem: impl Into<String>) -> TransferError {
        let problem = problem.into();
        TransferError { problem }
    }
}

/// The end that prepares scenes.
#[derive(Default)]
pub struct Sender {
    sent: Parts,
}

/// The end that uses them.
#[derive(Default)]
pub struct Receiver {
    held: Parts,
}

impl Sender {
    /// Returns the bytes of a delivery of `scenes`.
    pub fn send<'a>(&mut self, scenes: impl IntoIterator<Item = &'a PreparedScene>) -> Vec<u8> {
        let mut writer = Writer {
            before: std::mem::take(&mut self.sent),
            parts: Parts::default(),
            bytes: Vec::new(),
        };
        for scene in scenes {
            writer.value(&true);
            writer.scene(scene);
        }
        writer.value(&false);
        let Writer {
            parts, mut bytes, ..
        } = writer;
        self.sent = parts;
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }
}

impl Receiver {
    /// Returns the scenes of a delivery.
    ///
    /// # Errors
    /// [`TransferError`] if the bytes are cut off or changed, or a delivery before them is missing.
    pub fn receive(&mut self, bytes: &[u8]) -> Result<Vec<PreparedScene>, TransferError> {
        let (bytes, checksum) = bytes
            .split_last_chunk::<CHECKSUM>()
            .ok_or_else(|| TransferError::new("it is cut off"))?;
        if crc32fast::hash(bytes) != u32::from_le_bytes(*checksum) {
            return Err(TransferError::new("its checksum is another"));
        }
        let mut reader = Reader {
            before: std::mem::take(&mut self.held),
            parts: Parts::default(),
            rest: bytes,
        };
        let mut scenes = Vec::new();
        while reader.value()? {
            scenes.push(reader.scene()?);
        }
        if !reader.rest.is_empty() {
            let problem = format!("{} bytes are left", reader.rest.len());
            return Err(TransferError::new(problem));
        }
        self.held = reader.parts;
        Ok(scenes)
    }
}

/// What several objects or deliveries may share, in the order in which a delivery names it. Both
/// ends have the same lists. `None` stands for what has been used again.
#[derive(Default)]
struct Parts {
    triangles: List<Vec<Triangle>>,
    prisms: List<Vec<PrismData>>,
    maps: List<ShapeMap>,
    layers: List<Vec<PreparedLayer>>,
    meshes: List<Mesh>,
    lightings: List<PreparedLighting>,
}

type List<T> = Vec<Option<Arc<T>>>;

/// How a delivery names a part: by its number in this delivery or in the one before, or by its
/// content, which follows.
#[derive(Serialize, Deserialize)]
enum Name {
    Again(usize),
    Held(usize),
    New,
}

/// What several objects may share.
trait Part: Sized {
    /// Returns the list of its kind.
    fn list(parts: &mut Parts) -> &mut List<Self>;

    /// Returns whether `other` is the same, if that takes much less time than sending it.
    fn is(&self, other: &Self) -> bool;

    fn write(&self, writer: &mut Writer);

    fn read(reader: &mut Reader<'_>) -> Result<Self, TransferError>;
}

struct Writer {
    before: Parts,
    parts: Parts,
    bytes: Vec<u8>,
}

struct Reader<'a> {
    before: Parts,
    parts: Parts,
    rest: &'a [u8],
}

impl Writer {
    fn value(&mut self, value: &impl Serialize) {
        let bytes = std::mem::take(&mut self.bytes);
        self.bytes = postcard::to_extend(value, bytes).expect("memory takes any value");
    }

    fn pod(&mut self, value: &impl Pod) {
        self.bytes.extend(bytemuck::bytes_of(value));
    }

    fn pods(&mut self, values: &[impl Pod]) {
        self.value(&values.len());
        self.bytes.extend(bytemuck::cast_slice::<_, u8>(values));
    }

    fn part<T: Part>(&mut self, part: &Arc<T>) {
        let is_it = |known: &Option<Arc<T>>| known.as_ref().is_some_and(|it| Arc::ptr_eq(it, part));
        let now = T::list(&mut self.parts);
        if let Some(number) = now.iter().position(is_it) {
            return self.value(&Name::Again(number));
        }
        now.push(Some(part.clone()));
        let before = T::list(&mut self.before);
        let is_equal = |known: &Option<Arc<T>>| known.as_ref().is_some_and(|it| it.is(part));
        let mut held = before.iter();
        let held = held.position(is_it);
        match held.or_else(|| before.iter().position(is_equal)) {
            Some(number) => {
                // Two parts that are equal stay two: copies are told by what they share.
                before[number] = None;
                self.value(&Name::Held(number));
            }
            None => {
                self.value(&Name::New);
                part.write(self);
            }
        }
    }

    fn scene(&mut self, scene: &PreparedScene) {
        let PreparedScene {
            frame,
            size,
            supersampling,
            background,
            development,
            lighting,
            objects,
            outside,
            origin,
            bounds,
            camera,
            preparation,
        } = scene;
        self.pod(frame);
        self.value(&(size, supersampling, background, development, outside));
        self.value(&(origin, bounds, camera, preparation));
        self.value(&lighting.is_some());
        if let Some(lighting) = lighting {
            self.part(lighting);
        }
        self.value(&objects.len());
        for object in objects {
            self.object(object);
        }
    }

    fn object(&mut self, object: &PreparedObject) {
        let PreparedObject {
            name,
            number,
            instance,
            placement,
            transform,
            parameters,
            triangles,
            depth,
            local_depth,
            prisms,
            map,
            layers,
            map_options,
            mesh,
        } = object;
        self.pod(parameters);
        self.value(&(name, number, instance, placement, transform));
        self.value(&(depth, local_depth, map_options));
        self.part(triangles);
        self.part(prisms);
        self.part(map);
        self.part(layers);
        self.part(mesh);
    }
}

impl Reader<'_> {
    fn value<T: DeserializeOwned>(&mut self) -> Result<T, TransferError> {
        let (value, rest) = postcard::take_from_bytes(self.rest)
            .map_err(|error| TransferError::new(error.to_string()))?;
        self.rest = rest;
        Ok(value)
    }

    fn pod<T: Pod>(&mut self) -> Result<T, TransferError> {
        Ok(bytemuck::pod_read_unaligned(self.bytes(size_of::<T>())?))
    }

    fn pods<T: Pod>(&mut self) -> Result<Vec<T>, TransferError> {
        let count: usize = self.value()?;
        let bytes = self.bytes(count.saturating_mul(size_of::<T>()))?;
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }

    fn bytes(&mut self, count: usize) -> Result<&[u8], TransferError> {
        let (bytes, rest) = self
            .rest
            .split_at_checked(count)
            .ok_or_else(|| TransferError::new("it is cut off"))?;
        self.rest = rest;
        Ok(bytes)
    }

    fn part<T: Part>(&mut self) -> Result<Arc<T>, TransferError> {
        let known = match self.value()? {
            Name::Again(number) => {
                let now = T::list(&mut self.parts).get(number).cloned().flatten();
                return now.ok_or_else(|| TransferError::new(format!("it has no part {number}")));
            }
            Name::Held(number) => {
                let held = T::list(&mut self.before).get_mut(number);
                let held = held.and_then(Option::take);
                held.ok_or_else(|| {
                    TransferError::new(format!("the delivery before it has no part {number}"))
                })?
            }
            Name::New => Arc::new(T::read(self)?),
        };
        T::list(&mut self.parts).push(Some(known.clone()));
        Ok(known)
    }

    fn scene(&mut self) -> Result<PreparedScene, TransferError> {
        let frame = self.pod()?;
        let (size, supersampling, background, development, outside) = self.value()?;
        let (origin, bounds, camera, preparation) = self.value()?;
        let lighting = match self.value()? {
            true => Some(self.part()?),
            false => None,
        };
        let count: usize = self.value()?;
        Ok(PreparedScene {
            frame,
            size,
            supersampling,
            background,
            development,
            lighting,
            objects: (0..count)
                .map(|_| self.object())
                .collect::<Result<_, _>>()?,
            outside,
            origin,
            bounds,
            camera,
            preparation,
        })
    }

    fn object(&mut self) -> Result<PreparedObject, TransferError> {
        let parameters = self.pod()?;
        let (name, number, instance, placement, transform) = self.value()?;
        let (depth, local_depth, map_options) = self.value()?;
        Ok(PreparedObject {
            name,
            number,
            instance,
            placement,
            transform,
            parameters,
            depth,
            local_depth,
            map_options,
            triangles: self.part()?,
            prisms: self.part()?,
            map: self.part()?,
            layers: self.part()?,
            mesh: self.part()?,
        })
    }
}

/// Plain data that a list of [`Parts`] holds.
trait Plain: Pod {
    fn list(parts: &mut Parts) -> &mut List<Vec<Self>>;
}

impl Plain for Triangle {
    fn list(parts: &mut Parts) -> &mut List<Vec<Triangle>> {
        &mut parts.triangles
    }
}

impl Plain for PrismData {
    fn list(parts: &mut Parts) -> &mut List<Vec<PrismData>> {
        &mut parts.prisms
    }
}

impl<T: Plain> Part for Vec<T> {
    fn list(parts: &mut Parts) -> &mut List<Vec<T>> {
        T::list(parts)
    }

    fn is(&self, other: &Vec<T>) -> bool {
        bytemuck::cast_slice::<T, u8>(self) == bytemuck::cast_slice::<T, u8>(other)
    }

    fn write(&self, writer: &mut Writer) {
        writer.pods(self);
    }

    fn read(reader: &mut Reader<'_>) -> Result<Vec<T>, TransferError> {
        reader.pods()
    }
}

impl Part for ShapeMap {
    fn list(parts: &mut Parts) -> &mut List<ShapeMap> {
        &mut parts.maps
    }

    fn is(&self, other: &ShapeMap) -> bool {
        self == other
    }

    fn write(&self, writer: &mut Writer) {
        writer.value(&self.header());
        writer.pods(self.words());
    }

    fn read(reader: &mut Reader<'_>) -> Result<ShapeMap, TransferError> {
        let header = reader.value()?;
        ShapeMap::from_header(header, reader.pods()?)
            .ok_or_else(|| TransferError::new("a shape map has too few texels"))
    }
}

impl Part for Vec<PreparedLayer> {
    fn list(parts: &mut Parts) -> &mut List<Vec<PreparedLayer>> {
        &mut parts.layers
    }

    fn is(&self, _: &Vec<PreparedLayer>) -> bool {
        // Little but its maps, which are parts themselves.
        false
    }

    fn write(&self, writer: &mut Writer) {
        writer.value(&self.len());
        for layer in self {
            let PreparedLayer {
                map,
                range,
                parameters,
            } = layer;
            writer.pod(range);
            writer.pod(parameters);
            writer.part(map);
        }
    }

    fn read(reader: &mut Reader<'_>) -> Result<Vec<PreparedLayer>, TransferError> {
        let count: usize = reader.value()?;
        let layer = |_| {
            Ok(PreparedLayer {
                range: reader.pod()?,
                parameters: reader.pod()?,
                map: reader.part()?,
            })
        };
        (0..count).map(layer).collect()
    }
}

impl Part for Mesh {
    fn list(parts: &mut Parts) -> &mut List<Mesh> {
        &mut parts.meshes
    }

    fn is(&self, _: &Mesh) -> bool {
        // The assets keep a mesh that stays the same.
        false
    }

    fn write(&self, writer: &mut Writer) {
        writer.value(self);
    }

    fn read(reader: &mut Reader<'_>) -> Result<Mesh, TransferError> {
        reader.value()
    }
}

impl Part for PreparedLighting {
    fn list(parts: &mut Parts) -> &mut List<PreparedLighting> {
        &mut parts.lightings
    }

    fn is(&self, _: &PreparedLighting) -> bool {
        // Little but its words, which are looked for by themselves.
        false
    }

    fn write(&self, writer: &mut Writer) {
        let PreparedLighting {
            lighting,
            has_smooth_edges,
            finishes,
            facets,
            lights,
            shadow_maps,
            shadow_frames,
            words,
        } = self;
        writer.pod(lighting);
        writer.value(has_smooth_edges);
        writer.pods(finishes);
        writer.pods(facets);
        writer.pods(lights);
        writer.pods(shadow_maps);
        writer.pods(shadow_frames);
        let mut before = writer.before.lightings.iter().flatten();
        let held = before.position(|held| held.words == *words);
        writer.value(&held);
        if held.is_none() {
            writer.pods(words);
        }
    }

    fn read(reader: &mut Reader<'_>) -> Result<PreparedLighting, TransferError> {
        Ok(PreparedLighting {
            lighting: reader.pod()?,
            has_smooth_edges: reader.value()?,
            finishes: reader.pods()?,
            facets: reader.pods()?,
            lights: reader.pods()?,
            shadow_maps: reader.pods()?,
            shadow_frames: reader.pods()?,
            words: match reader.value()? {
                Some::<usize>(number) => {
                    let mut before = reader.before.lightings.iter().flatten();
                    let held = before.nth(number).ok_or_else(|| {
                        TransferError::new("the delivery before it has no such words")
                    })?;
                    held.words.clone()
                }
                None => reader.pods()?,
            },
        })
    }
}
