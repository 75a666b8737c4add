//! Shading on the CPU: what [`relievo_shared::shading`] reads, in slices.

use super::error::{RenderError, allocate};
use super::words::ColorWords;
use crate::prepare::PreparedLighting;
use glam::UVec4;
use rayon::prelude::*;
use relievo_shared::gbuffer::Hits;
use relievo_shared::layout::Frame;
use relievo_shared::shading::{self, FacetMaterial, Finish, Light, ShadowMap, Tables};
use relievo_shared::shape_map::Texels;

/// What shading reads.
struct Slices<'a> {
    lighting: &'a PreparedLighting,
    /// The words of all shadow maps.
    shadows: &'a [u32],
}

/// Returns the colours of a picture from what its pixels hit.
pub(super) fn shade(
    frame: &Frame,
    lighting: &PreparedLighting,
    shadows: &[u32],
    hits: &[[UVec4; 2]],
) -> Result<ColorWords, RenderError> {
    let [width, height] = frame.size.map(|side| side as u32);
    let tables = Slices { lighting, shadows };
    let common = &lighting.lighting;
    let picture = Picture { width, hits };
    let mut words = allocate("the picture", hits.len(), [0; 4])?;
    let mut draw = |of: &(dyn Fn((u32, u32)) -> UVec4 + Sync)| {
        let rows = words.par_chunks_mut(width as usize).enumerate();
        rows.for_each(|(y, row)| {
            for (x, pixel) in (0..).zip(row) {
                *pixel = of((x, y as u32)).to_array();
            }
        });
    };
    if !lighting.has_smooth_edges {
        draw(&|at| shading::words(&tables, frame, common, at, &picture));
    } else {
        let edges = |at, is_mean_only| {
            shading::words_with_edges(&tables, frame, common, at, &picture, is_mean_only)
        };
        if lighting.has_charts() {
            draw(&|at| {
                shading::mean::words(&tables, frame, common, at, &picture, |is_mean_only| {
                    edges(at, is_mean_only)
                })
            });
        } else {
            draw(&|at| edges(at, false));
        }
    }
    Ok(ColorWords {
        width,
        height,
        words,
    })
}

/// The G-buffer.
struct Picture<'a> {
    width: u32,
    hits: &'a [[UVec4; 2]],
}

impl Hits for Picture<'_> {
    #[inline]
    fn words(&self, x: u32, y: u32) -> (UVec4, UVec4) {
        self.hits[y as usize * self.width as usize + x as usize].into()
    }
}

impl Texels for Slices<'_> {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        let words = &self.lighting.words;
        match (index as usize).checked_sub(words.len()) {
            None => words[index as usize],
            Some(index) => self.shadows[index],
        }
    }
}

impl Tables for Slices<'_> {
    #[inline]
    fn finish(&self, index: u32) -> &Finish {
        &self.lighting.finishes[index as usize]
    }

    #[inline]
    fn facet(&self, index: u32) -> &FacetMaterial {
        &self.lighting.facets[index as usize]
    }

    #[inline]
    fn light(&self, index: u32) -> &Light {
        &self.lighting.lights[index as usize]
    }

    #[inline]
    fn shadow_map(&self, index: u32) -> &ShadowMap {
        &self.lighting.shadow_maps[index as usize]
    }
}

#[cfg(test)]
mod tests;
