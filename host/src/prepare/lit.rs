//! Materials and lights of a prepared scene: plain data that renderers read.

use relievo_shared::layout::Frame;
use relievo_shared::shading::{FacetMaterial, Finish, Light, Lighting, ShadowMap};

/// Materials and lights of a scene, ready for a renderer.
#[derive(Clone, Debug, Default)]
pub struct PreparedLighting {
    /// What is the same for all pixels.
    pub lighting: Lighting,
    /// Whether edges are smoothed.
    pub has_smooth_edges: bool,
    /// The materials of all objects.
    pub finishes: Vec<Finish>,
    /// How the pattern lies on the facets of all objects, and their materials.
    pub facets: Vec<FacetMaterial>,
    /// The lights.
    pub lights: Vec<Light>,
    /// The shadow maps of all lights.
    pub shadow_maps: Vec<ShadowMap>,
    /// From where each shadow map is seen.
    pub shadow_frames: Vec<Frame>,
    /// Pictures and environment; the words of shadow maps follow.
    pub words: Vec<u32>,
}

impl PreparedLighting {
    /// Returns whether patterns that are smaller than a pixel are averaged.
    pub fn has_charts(&self) -> bool {
        self.finishes
            .iter()
            .any(|finish| finish.chart.image.levels != 0)
    }

    /// Returns the words of all shadow maps.
    pub fn shadow_words(&self) -> usize {
        let sizes = self.shadow_maps.iter();
        sizes.map(|map| map.size as usize * map.size as usize).sum()
    }

    /// Returns the bytes of the buffers that a device needs: of the fields in their order, with
    /// the words of shadow maps.
    pub fn buffer_bytes(&self) -> [u64; 6] {
        let words = self.words.len() + self.shadow_words();
        [
            size_of_val(&self.lighting),
            // No buffer is empty.
            size_of_val(&self.finishes[..]).max(size_of::<Finish>()),
            size_of_val(&self.facets[..]).max(size_of::<FacetMaterial>()),
            size_of_val(&self.lights[..]).max(size_of::<Light>()),
            size_of_val(&self.shadow_maps[..]).max(size_of::<ShadowMap>()),
            words * size_of::<u32>(),
        ]
        .map(|bytes| bytes as u64)
    }
}
