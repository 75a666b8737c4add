//! The scene: picture, camera, light and objects.

use super::{Color, Development, Environment, LightSource, PhysicalMaterial, SceneObject, Track};
use crate::{Files, Limits};
use std::path::PathBuf;

/// A scene. The ranges of the fields are those of the keys in [`super::keys`];
/// [`Scene::check`] checks them.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The file it was read from; for messages.
    pub path: PathBuf,
    /// The text of the file, for the metadata of pictures.
    pub text: String,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Samples per pixel side: 1, or 2 for 4× supersampling.
    pub supersampling: u32,
    /// Whether pixels at edges are blended with their neighbours; in scenes that are lit
    /// physically.
    pub smooth_edges: bool,
    /// Colour where no object is.
    pub background: Color,
    /// Exposure, tone curve and transparency of the picture.
    pub development: Development,
    /// The camera; `None` shows the whole scene from its front, right and above.
    pub camera: Option<Camera>,
    /// Angle by which the eye is turned around the target about the up direction, degrees.
    pub orbit: f64,
    /// Vertical field of view, degrees.
    pub field_of_view: f64,
    /// The light, unless there are `lights`.
    pub light: Light,
    /// Lights in place of `light`.
    pub lights: Vec<LightSource>,
    /// Light from all directions in place of `light.ambient`.
    pub environment: Option<Environment>,
    /// Materials that objects name.
    pub materials: Vec<PhysicalMaterial>,
    /// The objects.
    pub objects: Vec<SceneObject>,
    /// Values that change with time, for [`Scene::at_time`].
    pub tracks: Vec<Track>,
    /// Frames per second of a sequence.
    pub frame_rate: f64,
    /// Limits of what the scene may load.
    pub limits: Limits,
    /// Files that the scene may read.
    pub files: Files,
}

impl Default for Scene {
    /// A scene without objects, which may read any file within the default limits.
    fn default() -> Scene {
        Scene {
            path: PathBuf::from("scene"),
            text: String::new(),
            size: [800, 600],
            supersampling: 1,
            smooth_edges: false,
            background: Color::from_hex(0xe9edf2),
            development: Development::default(),
            camera: None,
            orbit: 0.0,
            field_of_view: 45.0,
            light: Light::default(),
            lights: Vec::new(),
            environment: None,
            materials: Vec::new(),
            objects: Vec::new(),
            tracks: Vec::new(),
            frame_rate: 24.0,
            limits: Limits::trusting(),
            files: Files::Disk,
        }
    }
}

impl Scene {
    /// Returns whether the scene has lights, an environment or materials, of its own or of mesh
    /// files: then its objects are drawn first, and lit physically where they are seen.
    pub fn is_physical(&self) -> bool {
        let mut objects = self.objects.iter();
        !self.lights.is_empty()
            || self.environment.is_some()
            || !self.materials.is_empty()
            || objects.any(SceneObject::is_of_mesh)
    }

    /// Returns the paths of all files that the scene names.
    pub fn named_files(&self) -> Vec<PathBuf> {
        let mut scene = self.clone();
        scene.files_mut().map(|(_, path)| path.clone()).collect()
    }

    /// Returns the key, with its tables, and the path of all files that the scene names, for
    /// other paths to be set.
    pub(super) fn files_mut(&mut self) -> impl Iterator<Item = (String, &mut PathBuf)> {
        let environment = self.environment.iter_mut();
        let environment = environment.filter_map(|environment| environment.image.as_mut());
        let environment = environment.map(|path| ("environment.image".to_string(), path));
        let materials = (1..)
            .zip(&mut self.materials)
            .flat_map(|(number, material)| {
                let files = material.files_mut();
                files.map(move |(key, path)| (format!("material {number}: {key}"), path))
            });
        let objects = (1..).zip(&mut self.objects).flat_map(|(number, object)| {
            let files = object.files_mut().into_iter();
            files.map(move |(key, path)| (format!("object {number}: {key}"), path))
        });
        environment.chain(materials).chain(objects)
    }
}

/// Position and orientation of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Camera {
    /// Position of the eye, world units.
    pub eye: [f64; 3],
    /// Point in the centre of the picture, world units.
    pub target: [f64; 3],
    /// Up direction; need not be perpendicular to the view.
    pub up: [f64; 3],
}

impl Camera {
    /// Creates an upright camera.
    pub fn new(eye: [f64; 3], target: [f64; 3]) -> Camera {
        Camera {
            eye,
            target,
            up: [0.0, 1.0, 0.0],
        }
    }
}

/// A directional light and an ambient one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Direction towards the light; of any length but zero.
    pub direction: [f64; 3],
    /// Colour of the directional light.
    pub color: Color,
    /// Factor of the directional light.
    pub intensity: f64,
    /// Colour of the ambient light.
    pub ambient: Color,
}

impl Default for Light {
    /// Light from the upper right.
    fn default() -> Light {
        Light {
            direction: [0.5, 0.8, 0.6],
            color: Color::from_hex(0xfff6e8),
            intensity: 1.0,
            ambient: Color::from_hex(0x5a6470),
        }
    }
}
