//! Predicts the device memory of a scene, without a device.

use super::content::Pass;
use super::outlines::{Sizes, frame_buffer_bytes, padded};
use super::shared::sharing;
use crate::prepare::{PreparedObject, PreparedScene};
use crate::shaders::{EntryPoints, Extent, Facets};
use relievo_shared::layout::Object;
use std::collections::BTreeSet;
use std::mem::{size_of, size_of_val};

/// Bytes per pixel of a picture of words.
pub(super) const WORDS: u64 = size_of::<[u32; 4]>() as u64;
/// Bytes per pixel of the depth buffer.
pub(super) const DEPTH: u64 = size_of::<f32>() as u64;

/// Pictures that are rendered and read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pictures {
    /// Colours.
    Color,
    /// Colours and geometry.
    ColorAndGeometry,
}

/// Bytes on a device, excluding the overhead of the driver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Triangles; shared ones count once.
    pub triangles: u64,
    /// Prisms.
    pub prisms: u64,
    /// Shape maps; a shared map counts once.
    pub maps: u64,
    /// The frame and the objects' parameters.
    pub parameters: u64,
    /// Outlines of the facets.
    pub outlines: u64,
    /// Materials, lights, pictures and shadow maps.
    pub lighting: u64,
    /// Pictures, their read-back buffers, depth and exits.
    pub pictures: u64,
}

impl Memory {
    /// Predicts the memory of `scene` with shaders of this `extent`, rendering
    /// `pictures` of the scene's size.
    pub fn of(scene: &PreparedScene, extent: Extent, pictures: Pictures) -> Memory {
        let shared = sharing(&scene.objects);
        let facets = |object: &PreparedObject| object.triangles.len() as u64;
        let mut memory = Memory {
            parameters: frame_buffer_bytes(&scene.objects, &shared),
            outlines: Sizes::of(scene.objects.iter().map(facets)).total(),
            lighting: scene
                .lighting
                .as_ref()
                .map_or(0, |lighting| lighting.buffer_bytes().iter().sum()),
            pictures: picture_bytes(scene, extent, pictures),
            ..Memory::default()
        };
        let mut maps = BTreeSet::new();
        for shared in shared {
            let object = &scene.objects[shared[0]];
            let has_everything = extent == Extent::Everything;
            let entry_points = EntryPoints::of(&object.parameters, extent);
            let facets = entry_points.facets;
            let count = padded(object.triangles.len() as u64);
            let bytes = |facets: Facets| count * facets.bytes() as u64;
            match facets {
                _ if has_everything => {
                    memory.triangles += bytes(Facets::Triangles);
                    memory.prisms += bytes(Facets::Prisms);
                }
                Facets::Prisms => memory.prisms += bytes(facets),
                _ => memory.triangles += bytes(facets),
            }
            let words = object.map.words();
            if maps.insert(words.as_ptr()) {
                let bytes = size_of_val(words) as u64;
                memory.maps += if has_everything {
                    bytes.max(object.plain_map_bytes())
                } else {
                    bytes
                };
            }
            memory.parameters += size_of::<Object>() as u64;
        }
        memory
    }

    /// Returns the bytes of the scene without its pictures.
    pub fn scene(&self) -> u64 {
        self.total() - self.pictures
    }

    /// Returns the sum.
    pub fn total(&self) -> u64 {
        self.triangles
            + self.prisms
            + self.maps
            + self.parameters
            + self.outlines
            + self.lighting
            + self.pictures
    }
}

/// Returns the bytes of the pictures of `scene`.
fn picture_bytes(scene: &PreparedScene, extent: Extent, pictures: Pictures) -> u64 {
    let [width, height] = scene.size.map(|side| u64::from(side * scene.supersampling));
    let read_back = match pictures {
        Pictures::Color => 1,
        Pictures::ColorAndGeometry => 2,
    };
    let targets = match &scene.lighting {
        Some(lighting) => Pass::targets(lighting) as u64,
        None => read_back,
    };
    let asking = scene
        .objects
        .iter()
        .map(|object| &object.parameters)
        .filter(|object| EntryPoints::of(object, extent).asks_for_exits);
    let pixels_of_exits = asking.map(|object| {
        if object.number == 0 {
            1
        } else {
            width * height
        }
    });
    height * (width * DEPTH + targets * width * WORDS + read_back * row_stride(width))
        + pixels_of_exits.max().unwrap_or(0) * WORDS
}

/// Returns the bytes of a row of `width` pixels in a read-back buffer, with the
/// alignment of the API.
pub(super) fn row_stride(width: u64) -> u64 {
    (width * WORDS).next_multiple_of(u64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT))
}
