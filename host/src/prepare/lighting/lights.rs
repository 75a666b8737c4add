//! Lights, and the frames that their shadow maps are drawn with.

use super::super::camera::{narrow, unlit_frame};
use super::super::lit::PreparedLighting;
use crate::Error;
use crate::limits::Account;
use crate::mesh::Bounds;
use crate::scene::{LightKind, LightSource};
use glam::DVec3;
use relievo_shared::layout::Frame;
use relievo_shared::shading::layout::{LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT};
use relievo_shared::shading::{Light, ShadowMap};

/// Distance of the eye of a directional light's shadow map, radii of the scene. Its rays differ
/// from the light's direction by at most half a degree, as those of the sun do.
const FAR: f64 = 128.0;
/// Nearest distance at which a shadow map sees, in diagonals of the scene. Shells within it
/// count as around the eye, which is slow.
const NEAR: f64 = 1e-3;
/// Margin around the scene.
const MARGIN: f64 = 1.02;
/// Texels around the faces of a point light, which lookups beside an edge reach.
const BORDER: f64 = 4.0;

/// Returns the lights, their shadow maps, whose words follow the first `words`, and the frames of
/// these; nothing else of the lighting.
pub(super) fn lights(
    sources: &[LightSource],
    bounds: &Bounds,
    words: usize,
    account: &mut Account<'_>,
) -> Result<PreparedLighting, Error> {
    let mut made = PreparedLighting::default();
    let mut first = words as u64;
    for source in sources {
        let views = if source.casts_shadows {
            views(source, bounds)
        } else {
            Vec::new()
        };
        made.lights.push(Light {
            first_shadow: made.shadow_maps.len() as u32,
            shadows: views.len() as u32,
            ..light(source, bounds)
        });
        let texels = u64::from(source.shadow_size).pow(2);
        for frame in views {
            account.take("a shadow map", texels, 8)?;
            if first + texels > u64::from(u32::MAX) {
                return Err(account.refused("a shadow map", texels).into());
            }
            let across = DVec3::from(frame.ray_right.map(f64::from));
            made.shadow_maps.push(ShadowMap {
                eye: frame.eye,
                near: frame.near,
                right: frame.right,
                size: source.shadow_size,
                up: frame.up,
                first: first as u32,
                forward: frame.forward,
                texel: across.length() as f32,
            });
            made.shadow_frames.push(frame);
            first += texels;
        }
    }
    Ok(made)
}

fn light(source: &LightSource, bounds: &Bounds) -> Light {
    let position = DVec3::from(source.position);
    let direction = match source.kind {
        LightKind::Directional => DVec3::from(source.direction),
        LightKind::Spot => position - DVec3::from(source.target),
        LightKind::Point => DVec3::Y,
    };
    // As the extension KHR_lights_punctual computes them.
    let [inner, outer] = [source.inner_angle, source.outer_angle].map(|x| x.to_radians().cos());
    let scale = 1.0 / (inner - outer).max(1e-6);
    Light {
        color: source
            .color
            .linear()
            .map(|channel| channel * source.intensity as f32),
        kind: match source.kind {
            LightKind::Directional => LIGHT_DIRECTIONAL,
            LightKind::Point => LIGHT_POINT,
            LightKind::Spot => LIGHT_SPOT,
        },
        position: narrow(position - bounds.centre()),
        inverse_range: source.range.map_or(0.0, |range| (1.0 / range) as f32),
        direction: narrow(direction.normalize()),
        spot_scale: scale as f32,
        spot_offset: (-outer * scale) as f32,
        ..Light::default()
    }
}

/// Returns the frames of a light's shadow maps.
fn views(source: &LightSource, bounds: &Bounds) -> Vec<Frame> {
    let radius = (0.5 * bounds.diagonal()).max(1e-12) * MARGIN;
    let size = [source.shadow_size; 2];
    let view = |eye: DVec3, forward: DVec3, angle: f64, near: f64| {
        let up = if forward.normalize().y.abs() < 0.9 {
            DVec3::Y
        } else {
            DVec3::X
        };
        Frame {
            near: near as f32,
            ..unlit_frame(eye, forward, up, angle, size)
        }
    };
    let position = DVec3::from(source.position) - bounds.centre();
    let near = NEAR * bounds.diagonal();
    match source.kind {
        LightKind::Directional => {
            let direction = DVec3::from(source.direction).normalize();
            let distance = FAR * radius;
            let angle = 2.0 * (1.0 / FAR).asin().to_degrees();
            vec![view(direction * distance, -direction, angle, near)]
        }
        LightKind::Spot => {
            let forward = DVec3::from(source.target) - DVec3::from(source.position);
            let angle = (2.0 * source.outer_angle + 1.0).min(179.0);
            vec![view(position, forward, angle, near)]
        }
        LightKind::Point => {
            let margin = 1.0 / (1.0 - 2.0 * BORDER / f64::from(source.shadow_size));
            let angle = 2.0 * margin.atan().to_degrees();
            // The order of `relievo_shared::shading::shadow_map::face`.
            [DVec3::X, DVec3::Y, DVec3::Z]
                .into_iter()
                .flat_map(|axis| [axis, -axis])
                .map(|forward| view(position, forward, angle, near))
                .collect()
        }
    }
}
