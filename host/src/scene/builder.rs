//! Scenes in code: constructors and setters that can be chained.

use super::{
    Camera, Color, Development, Environment, Finish, Instances, Layer, Light, LightSource,
    MapOptions, Material, PhysicalMaterial, Scene, SceneObject, Shape, Technique, Tier, Track,
};
use crate::mesh::{MeshSource, Projection};
use crate::{Files, Limits};

impl Scene {
    /// Adds an object.
    #[must_use]
    pub fn object(mut self, object: SceneObject) -> Scene {
        self.objects.push(object);
        self
    }

    /// Sets width and height of the picture, pixels.
    #[must_use]
    pub fn size(mut self, width: u32, height: u32) -> Scene {
        self.size = [width, height];
        self
    }

    /// Sets whether four samples a pixel are drawn.
    #[must_use]
    pub fn supersample(mut self, is_on: bool) -> Scene {
        self.supersampling = if is_on { 2 } else { 1 };
        self
    }

    /// Sets whether pixels at edges are blended with their neighbours, in a scene that is lit
    /// physically.
    #[must_use]
    pub fn smooth_edges(mut self, is_on: bool) -> Scene {
        self.smooth_edges = is_on;
        self
    }

    /// Sets the colour where no object is.
    #[must_use]
    pub fn background(mut self, color: Color) -> Scene {
        self.background = color;
        self
    }

    /// Sets exposure, tone curve and transparency of the picture.
    #[must_use]
    pub fn development(mut self, development: Development) -> Scene {
        self.development = development;
        self
    }

    /// Sets the camera.
    #[must_use]
    pub fn camera(mut self, camera: Camera) -> Scene {
        self.camera = Some(camera);
        self
    }

    /// Sets the vertical field of view, degrees.
    #[must_use]
    pub fn field_of_view(mut self, degrees: f64) -> Scene {
        self.field_of_view = degrees;
        self
    }

    /// Sets the angle by which the eye is turned around the target about the up direction,
    /// degrees.
    #[must_use]
    pub fn orbit(mut self, degrees: f64) -> Scene {
        self.orbit = degrees;
        self
    }

    /// Adds values that change with time.
    #[must_use]
    pub fn track(mut self, track: Track) -> Scene {
        self.tracks.push(track);
        self
    }

    /// Sets the frames per second of a sequence.
    #[must_use]
    pub fn frame_rate(mut self, frames_per_second: f64) -> Scene {
        self.frame_rate = frames_per_second;
        self
    }

    /// Sets the light.
    #[must_use]
    pub fn light(mut self, light: Light) -> Scene {
        self.light = light;
        self
    }

    /// Adds a light, in place of [`Scene::light`].
    #[must_use]
    pub fn with_light(mut self, light: LightSource) -> Scene {
        self.lights.push(light);
        self
    }

    /// Sets the light from all directions.
    #[must_use]
    pub fn environment(mut self, environment: Environment) -> Scene {
        self.environment = Some(environment);
        self
    }

    /// Adds a material that objects may name.
    #[must_use]
    pub fn with_material(mut self, material: PhysicalMaterial) -> Scene {
        self.materials.push(material);
        self
    }

    /// Sets the limits of what the scene may load.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Scene {
        self.limits = limits;
        self
    }

    /// Sets the files that the scene may read.
    #[must_use]
    pub fn files(mut self, files: Files) -> Scene {
        self.files = files;
        self
    }
}

impl SceneObject {
    /// Creates an object of `mesh` with the pattern `shape`. Texts are paths,
    /// relative to the folder where the program runs.
    pub fn new(mesh: impl Into<MeshSource>, shape: impl Into<Shape>) -> SceneObject {
        let mut object = SceneObject {
            mesh: mesh.into(),
            shape: shape.into(),
            ..SceneObject::default()
        };
        object.name = object.default_name();
        object
    }

    /// Sets the technique, and parameters and effort to its defaults: call it
    /// before their setters.
    #[must_use]
    pub fn with_technique(mut self, technique: Technique) -> SceneObject {
        self.set_technique(technique);
        self
    }

    /// Sets the tier, and the effort to its default: call it before
    /// [`SceneObject::steps`] and [`SceneObject::bisections`].
    #[must_use]
    pub fn tier(mut self, tier: Tier) -> SceneObject {
        self.tier = tier;
        self.set_default_effort();
        self
    }

    /// Sets the repeats of the pattern along u and v.
    #[must_use]
    pub fn repeat(mut self, u: impl Into<f64>, v: impl Into<f64>) -> SceneObject {
        self.repeat = [u.into(), v.into()];
        self
    }
}

/// Defines setters of fields that need no conversion but `Some`.
macro_rules! setters {
    ($owner:ident; $($(#[$doc:meta])* $name:ident: $type:ty $(, $wrap:ident)?;)*) => {
        impl $owner {
            $(
                $(#[$doc])*
                #[must_use]
                pub fn $name(mut self, $name: $type) -> $owner {
                    self.$name = setters!(@ $name $($wrap)?);
                    self
                }
            )*
        }
    };
    (@ $value:ident) => { $value };
    (@ $value:ident $wrap:ident) => { $wrap($value) };
}

/// Defines the setters that objects and layers have.
macro_rules! carving_setters {
    ($owner:ident) => {
        impl $owner {
            /// Sets the extension e, pattern widths.
            #[must_use]
            pub fn extension(mut self, widths: f64) -> $owner {
                self.extrusion.extension = widths;
                self
            }

            /// Sets the bevel b, pattern widths per unit of depth.
            #[must_use]
            pub fn bevel(mut self, widths: f64) -> $owner {
                self.extrusion.bevel = widths;
                self
            }

            /// Sets the chamfer c, 0…1.
            #[must_use]
            pub fn chamfer(mut self, part: f64) -> $owner {
                self.extrusion.chamfer = part;
                self
            }

            /// Sets the number of parts of a profile that has parts.
            #[must_use]
            pub fn parts(mut self, parts: u32) -> $owner {
                self.extrusion.parts = parts;
                self
            }
        }

        setters! { $owner;
            /// Sets the luma below which a pixel is pattern, 1…255.
            threshold: u8;
            /// Sets whether the light pixels are the pattern.
            invert: bool;
            /// Sets which part of the pattern's pieces is kept, of how many, 1…64.
            pieces: [u32; 2], Some;
            /// Sets colours and gloss.
            material: Material;
            /// Sets materials of the scene in place of colours.
            finish: Finish;
        }
    };
}

setters! { SceneObject;
    /// Sets the pixels of the longer side of a drawing or text, 8…32768.
    raster: u32, Some;
    /// Sets how the pattern is stored.
    map: MapOptions;
    /// Sets the depth of the floor, world units, > 0.
    depth: f64, Some;
    /// Sets the error budget, pixels, 0.01…100.
    budget: f64, Some;
    /// Sets the tolerance of the accurate tier, pixels, 0.0001…16.
    tolerance: f64;
    /// Sets the distance before the hit at which a search may end, pixels, 0…16.
    slack: f64;
    /// Sets the largest number of steps, 1…65536.
    steps: u32;
    /// Sets the largest number of bisections, 0…64.
    bisections: u32;
    /// Sets whether columns rise from the mesh in place of being cut into it.
    raised: bool;
    /// Sets whether there is no floor.
    cut_out: bool;
    /// Sets whether columns cast shadows on the object.
    self_shadow: bool;
    /// Sets texture coordinates in place of the mesh's own.
    projection: Projection, Some;
    /// Sets the largest angle between two triangles whose edge is smooth where the
    /// mesh has no normals, degrees, 0…180.
    crease_angle: f64;
    /// Sets the uniform scale, > 0.
    scale: f64;
    /// Sets the rotation about x, then y, then z, degrees.
    rotate: [f64; 3];
    /// Sets the translation, world units.
    translate: [f64; 3];
    /// Sets copies of the object, placed after its own transform.
    instances: Instances, Some;
}

setters! { Layer;
    /// Sets the δ of its caps, 0…1.
    top: f64;
    /// Sets the δ where it ends, above `top`, at most 1.
    bottom: f64;
}

carving_setters!(SceneObject);
carving_setters!(Layer);

impl Layer {
    /// Creates a layer of the whole depth. Texts are paths, as for [`SceneObject::new`].
    pub fn new(shape: impl Into<Shape>) -> Layer {
        Layer {
            shape: shape.into(),
            ..Layer::default()
        }
    }

    /// Sets the technique, and parameters to its defaults: call it before their setters.
    #[must_use]
    pub fn with_technique(mut self, technique: Technique) -> Layer {
        self.set_technique(technique);
        self
    }
}

impl SceneObject {
    /// Adds a layer.
    #[must_use]
    pub fn with_layer(mut self, layer: Layer) -> SceneObject {
        self.layers.push(layer);
        self
    }

    /// Sets the name in messages.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> SceneObject {
        self.name = name.into();
        self
    }
}
