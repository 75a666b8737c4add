//! From a scene to plain data that a renderer reads.
//!
//! Positions are moved so that the middle of all objects is the origin, in
//! f64, before they become f32: a scene far from the origin keeps its digits.

use crate::Error;
use crate::mesh::{Bounds, Mesh, MeshOptions, MeshShell, MeshTriangle};
use crate::scene::{Camera, Extrusion, Material, Scene, SceneObject};
use crate::shape_map::{Pattern, PatternOptions, ShapeMap, Storage, bake};
use crate::shell::{folded, narrow_shell};
use glam::{DQuat, DVec3, EulerRot};
use rayon::prelude::*;
use relievo_shared::layout::{
    Corner, FORMAT_CODES, FORMAT_FLOAT, FORMAT_PAPER, Frame, Object, SEARCH_PRISMS, Shell, Triangle,
};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A scene, ready for a renderer.
pub struct PreparedScene {
    /// Camera, light and picture size, one sample per pixel.
    pub frame: Frame,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Samples per pixel side.
    pub supersampling: u32,
    /// Linear RGB where nothing is.
    pub background: [f32; 3],
    /// What is drawn, in order.
    pub objects: Vec<PreparedObject>,
    /// The middle of all objects, world units: positions are relative to it.
    pub origin: DVec3,
    /// The camera in world units, also where the scene file has none.
    pub camera: Camera,
    /// Time spent on loading and baking.
    pub preparation: Duration,
}

/// An object, ready for a renderer.
pub struct PreparedObject {
    /// The object's name.
    pub name: String,
    /// Its parameters.
    pub parameters: Object,
    /// Its triangles, relative to the scene's origin.
    pub triangles: Vec<Triangle>,
    /// The prisms over them; empty unless the tier is the accurate one.
    pub shells: Vec<Shell>,
    /// Its shape map; objects with the same pattern share it.
    pub map: Arc<ShapeMap>,
    /// The mesh it came from; objects with the same mesh and transform share it.
    pub mesh: Arc<Mesh>,
}

/// A step of the work, for a progress bar.
#[derive(Clone, Debug)]
pub enum Step {
    /// A mesh is loaded and its curvature fitted.
    Mesh(PathBuf),
    /// A pattern is loaded and its distance field computed; the fraction done.
    ShapeMap(PathBuf, f64),
}

/// What identifies a shape map among the objects of a scene.
type ShapeKey = (PathBuf, u8, bool);

/// Loads and prepares everything that `scene` names; `progress` may be called
/// from any thread.
///
/// # Errors
/// [`Error`] for the first object whose assets cannot be used.
pub fn prepare(scene: &Scene, progress: &(dyn Fn(Step) + Sync)) -> Result<PreparedScene, Error> {
    let start = Instant::now();
    let shapes = load_shapes(scene, progress)?;
    let meshes = load_meshes(scene, progress)?;

    let bounds = meshes
        .iter()
        .map(|mesh| mesh.bounds)
        .reduce(|a, b| Bounds {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        })
        .expect("a scene has at least one object");
    let origin = bounds.centre();
    let camera = scene
        .camera
        .unwrap_or_else(|| default_camera(&bounds, scene));

    let objects = scene
        .objects
        .iter()
        .zip(meshes)
        .map(|(object, mesh)| {
            let map = shapes[&shape_key(object)].clone();
            prepare_object(scene, object, mesh, map, origin)
        })
        .collect::<Result<Vec<_>, _>>()?;

    Ok(PreparedScene {
        frame: frame(scene, &camera, origin, &bounds, scene.size),
        size: scene.size,
        supersampling: scene.supersampling,
        background: scene.background.linear(),
        objects,
        origin,
        camera,
        preparation: start.elapsed(),
    })
}

impl PreparedScene {
    /// The frame of a picture with `factor` samples per pixel side: the same
    /// view on a finer grid.
    pub fn frame_with_samples(&self, factor: u32) -> Frame {
        let inverse = 1.0 / f64::from(factor);
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let (right, down) = (wide(self.frame.ray_right), wide(self.frame.ray_down));
        // The first sample's centre is nearer to the pixel's corner.
        let first = wide(self.frame.ray_first) + (right + down) * (0.5 * inverse - 0.5);
        Frame {
            ray_first: narrow(first),
            ray_right: narrow(right * inverse),
            ray_down: narrow(down * inverse),
            size: self.frame.size.map(|side| side * factor as f32),
            ..self.frame
        }
    }

    /// Makes the prisms of every object, also of those that do not need them.
    pub fn make_all_shells(&mut self) {
        for object in &mut self.objects {
            let shells = object.all_shells(self.origin).into_owned();
            object.shells = shells;
        }
    }

    /// Number of triangles of all objects.
    pub fn triangle_count(&self) -> usize {
        self.objects
            .iter()
            .map(|object| object.triangles.len())
            .sum()
    }
}

impl PreparedObject {
    /// Rounds `shells` to what renderers read, for the object's depth.
    fn narrow_shells(&self, shells: &[MeshShell], origin: DVec3) -> Vec<Shell> {
        let depth = f64::from(self.parameters.depth);
        shells
            .par_iter()
            .zip(&self.triangles)
            .map(|(shell, triangle)| {
                let uv = triangle.corners.map(|corner| corner.uv);
                narrow_shell(shell, uv, depth, origin)
            })
            .collect()
    }

    /// The prisms over all triangles, made for this call where the tier needs
    /// none; `origin` is the scene's.
    pub fn all_shells(&self, origin: DVec3) -> Cow<'_, [Shell]> {
        if self.shells.is_empty() {
            Cow::Owned(self.narrow_shells(&self.mesh.shells(), origin))
        } else {
            Cow::Borrowed(&self.shells)
        }
    }

    /// Whether rays are followed through prisms.
    pub fn has_prisms(&self) -> bool {
        self.parameters.search == SEARCH_PRISMS
    }
}

/// Triangles that are named in an error.
const NAMED: usize = 3;

/// A depth is clamped to this share of the largest that works.
const CLAMPED: f64 = 0.95;

/// Makes the prisms of `prepared`, which needs them; an error where the surface
/// bends too much for the depth, unless that may be clamped.
fn make_shells(
    scene: &Scene,
    object: &SceneObject,
    prepared: &mut PreparedObject,
    origin: DVec3,
) -> Result<(), Error> {
    let shells = prepared.mesh.shells();
    let depth = f64::from(prepared.parameters.depth);
    if let Some(folded) = folded(&shells, depth) {
        let clamped = CLAMPED * folded.largest_depth;
        if !object.clamp_depth || clamped <= 0.0 {
            let triangles = &prepared.mesh.triangles;
            let named = folded.triangles.iter().take(NAMED).map(|&index| {
                let [a, b, c] = triangles[index].corners.map(|corner| corner.position);
                let [x, y, z] = ((a + b + c) / 3.0).to_array();
                format!("number {} at ({x:.4}, {y:.4}, {z:.4})", index + 1)
            });
            let named: Vec<String> = named.collect();
            let more = if folded.triangles.len() > NAMED {
                ", …"
            } else {
                ""
            };
            let way_out = if clamped > 0.0 {
                format!(
                    "the largest depth that works is {:.6}: write a smaller depth, or clamp_depth = true, or tier = \"fast\"",
                    folded.largest_depth
                )
            } else {
                "no depth works there: repair the mesh, or write tier = \"fast\"".to_string()
            };
            return Err(Error::Object {
                scene: scene.path.clone(),
                name: object.name.clone(),
                problem: format!(
                    "the surface bends too much for the depth {depth:.6} of the accurate tier in {} of {} triangles ({}{more}); {way_out}",
                    folded.triangles.len(),
                    shells.len(),
                    named.join(", "),
                ),
            });
        }
        tracing::warn!(
            "object {:?}: depth {depth:.6} is clamped to {clamped:.6}, since the surface bends too much in {} of {} triangles",
            object.name,
            folded.triangles.len(),
            shells.len(),
        );
        prepared.parameters.depth = clamped as f32;
    }
    prepared.shells = prepared.narrow_shells(&shells, origin);
    Ok(())
}

fn shape_key(object: &SceneObject) -> ShapeKey {
    (object.shape.clone(), object.threshold, object.invert)
}

fn load_shapes(
    scene: &Scene,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<BTreeMap<ShapeKey, Arc<ShapeMap>>, Error> {
    let mut shapes = BTreeMap::new();
    // One after the other: each is spread over the cores by itself.
    for object in &scene.objects {
        let key = shape_key(object);
        if shapes.contains_key(&key) {
            continue;
        }
        let map = load_shape(object, progress)?;
        shapes.insert(key, Arc::new(map));
    }
    Ok(shapes)
}

fn load_shape(object: &SceneObject, progress: &(dyn Fn(Step) + Sync)) -> Result<ShapeMap, Error> {
    let path = &object.shape;
    progress(Step::ShapeMap(path.clone(), 0.0));
    if ShapeMap::is_shape_map(path)? {
        return Ok(ShapeMap::load(path)?);
    }
    let options = PatternOptions {
        threshold: object.threshold,
        invert: object.invert,
        ..PatternOptions::default()
    };
    let pattern = Pattern::load(path, &options)?;
    Ok(bake(&pattern, Storage::R16, &|fraction| {
        progress(Step::ShapeMap(path.clone(), fraction));
    }))
}

/// The mesh of each object, loaded once for objects that share it.
fn load_meshes(scene: &Scene, progress: &(dyn Fn(Step) + Sync)) -> Result<Vec<Arc<Mesh>>, Error> {
    let mut loaded: Vec<(PathBuf, MeshOptions, Arc<Mesh>)> = Vec::new();
    let mut meshes = Vec::with_capacity(scene.objects.len());
    for object in &scene.objects {
        let [x, y, z] = object.rotate.map(f64::to_radians);
        let options = MeshOptions {
            projection: object.projection,
            scale: object.scale,
            rotation: DQuat::from_euler(EulerRot::ZYX, z, y, x),
            translation: DVec3::from(object.translate),
            ..MeshOptions::default()
        };
        let known = loaded
            .iter()
            .find(|(path, known, _)| *path == object.mesh && *known == options);
        let mesh = match known {
            Some((_, _, mesh)) => mesh.clone(),
            None => {
                progress(Step::Mesh(object.mesh.clone()));
                let mesh = Arc::new(Mesh::load(&object.mesh, &options)?);
                loaded.push((object.mesh.clone(), options, mesh.clone()));
                mesh
            }
        };
        meshes.push(mesh);
    }
    Ok(meshes)
}

fn prepare_object(
    scene: &Scene,
    object: &SceneObject,
    mesh: Arc<Mesh>,
    map: Arc<ShapeMap>,
    origin: DVec3,
) -> Result<PreparedObject, Error> {
    let depth = object.depth.unwrap_or(0.04 * mesh.bounds.diagonal());
    let extrusion =
        growth(object.extrusion, &object.shape, &map).map_err(|problem| Error::Object {
            scene: scene.path.clone(),
            name: object.name.clone(),
            problem,
        })?;
    let Material {
        cap,
        wall,
        bevel,
        floor,
        specular,
        shininess,
    } = object.material;
    let parameters = Object {
        map_size: [map.width() as f32, map.height() as f32],
        map_step: map.step(),
        depth: depth as f32,
        extension: extrusion.extension as f32,
        bevel: extrusion.bevel as f32,
        chamfer: extrusion.chamfer as f32,
        specular: specular as f32,
        tolerance: object.tolerance as f32,
        cap_color: cap.linear(),
        wall_color: wall.linear(),
        bevel_color: bevel.linear(),
        floor_color: floor.linear(),
        shininess,
        tier: object.tier.code(),
        cut_out: u32::from(object.cut_out),
        linear_steps: object.steps,
        binary_steps: object.bisections,
        map_bias: map.bias(),
        map_packing: match map.storage() {
            Storage::R8 => 2,
            Storage::R16 => 1,
            Storage::R32F | Storage::Rgba8 => 0,
        },
        map_quantum: map.quantum(),
        map_reach: gradient_reach(map.width(), map.height()),
        map_format: match map.storage() {
            Storage::R8 | Storage::R16 => FORMAT_CODES,
            Storage::R32F => FORMAT_FLOAT,
            Storage::Rgba8 => FORMAT_PAPER,
        },
        search: object.search_code(),
        self_shadow: u32::from(object.self_shadow),
    };
    let triangles = mesh
        .triangles
        .par_iter()
        .map(|triangle| narrow_triangle(triangle, origin, object.repeat))
        .collect();
    let mut prepared = PreparedObject {
        name: object.name.clone(),
        parameters,
        triangles,
        shells: Vec::new(),
        map,
        mesh,
    };
    if prepared.has_prisms() {
        make_shells(scene, object, &mut prepared, origin)?;
    }
    Ok(prepared)
}

/// Half the span of the differences that make the map's gradient, texels: a
/// power of two, about a 128th of the map, since the outline of a binary
/// pattern is a staircase, but less than would reach round a tiny map.
fn gradient_reach(width: u32, height: u32) -> f32 {
    let (shorter, longer) = (width.min(height), width.max(height));
    let reach = (shorter / 128).clamp(1, 32);
    let reach = (1u32 << reach.ilog2()) as f32;
    // A side of one texel has no slope, whatever the reach.
    let narrowest = if shorter > 1 { shorter } else { longer };
    reach.min(0.25 * narrowest as f32)
}

/// The extrusion as `map` can carry it out, or what stands against it.
fn growth(extrusion: Extrusion, shape: &Path, map: &ShapeMap) -> Result<Extrusion, String> {
    let width = f64::from(map.width());
    let largest = extrusion.extension + extrusion.bevel * extrusion.chamfer;
    // No point of a map that repeats is further from its pattern.
    let furthest = 0.5 * width.hypot(f64::from(map.height()));
    if largest * width >= furthest {
        // Everything is covered, unless there is nothing that could grow.
        let is_empty = (0..map.height())
            .into_par_iter()
            .all(|y| (0..map.width()).all(|x| map.decode(x, y) > 0.0));
        return Ok(if is_empty {
            Extrusion {
                extension: 0.0,
                bevel: 0.0,
                ..extrusion
            }
        } else {
            extrusion
        });
    }
    let better = match map.storage() {
        Storage::R8 | Storage::Rgba8 => "bake the map with --format r16",
        Storage::R16 | Storage::R32F => "bake the map with --format r32f",
    };
    if map.saturated() && largest * width >= f64::from(map.max_distance()) {
        return Err(format!(
            "the pattern grows by e + b·c = {largest:.4} widths, but {} holds distances up to {:.4} widths only; make extension or bevel smaller, or {better}",
            shape.display(),
            f64::from(map.max_distance()) / width,
        ));
    }
    let has_bottom = map.saturated() || map.storage() == Storage::Rgba8;
    if has_bottom && extrusion.extension * width <= f64::from(map.min_distance()) {
        return Err(format!(
            "the pattern shrinks by {:.4} widths, but {} holds distances down to {:.4} widths inside it only; make extension larger, or {better}",
            -extrusion.extension,
            shape.display(),
            f64::from(map.min_distance()) / width,
        ));
    }
    Ok(extrusion)
}

/// A triangle in the renderers' units: f32, positions relative to `origin`,
/// texture coordinates in repeats of the pattern, v down as rows of an image
/// run (OBJ's v goes up), less a whole number of repeats.
fn narrow_triangle(triangle: &MeshTriangle, origin: DVec3, repeat: [f64; 2]) -> Triangle {
    let uv = triangle
        .corners
        .map(|corner| [corner.uv.x * repeat[0], -corner.uv.y * repeat[1]]);
    let whole = [0, 1].map(|i| uv[0][i].min(uv[1][i]).min(uv[2][i]).floor());
    let mut corners = [Corner::default(); 3];
    for (i, (narrowed, corner)) in corners.iter_mut().zip(&triangle.corners).enumerate() {
        *narrowed = Corner {
            position: narrow(corner.position - origin),
            normal: narrow(corner.normal),
            tangent: narrow(corner.tangent),
            uv: [0, 1].map(|axis| (uv[i][axis] - whole[axis]) as f32),
            quadric: [corner.quadric.xx, corner.quadric.xy, corner.quadric.yy].map(|q| q as f32),
            gradient_u: narrow(corner.gradient_u * repeat[0]),
            gradient_v: narrow(corner.gradient_v * -repeat[1]),
        };
    }
    Triangle {
        corners,
        handedness: triangle.corners[0].handedness as f32,
    }
}

/// A view of everything from its front, right and above.
fn default_camera(bounds: &Bounds, scene: &Scene) -> Camera {
    let centre = bounds.centre();
    let radius = (0.5 * bounds.diagonal()).max(1e-12);
    let half = 0.5 * scene.field_of_view.to_radians();
    let aspect = f64::from(scene.size[0]) / f64::from(scene.size[1]);
    let narrower = half.tan().min(half.tan() * aspect).atan();
    let eye = centre + DVec3::new(0.55, 0.75, 1.0).normalize() * (radius / narrower.sin());
    Camera {
        eye: eye.to_array(),
        target: centre.to_array(),
        up: [0.0, 1.0, 0.0],
    }
}

fn frame(scene: &Scene, camera: &Camera, origin: DVec3, bounds: &Bounds, size: [u32; 2]) -> Frame {
    let eye = DVec3::from(camera.eye);
    let reach = eye.distance(bounds.centre()) + bounds.diagonal();
    let light = &scene.light;
    Frame {
        near: (1e-5 * reach).max(1e-12) as f32,
        light_direction: narrow(DVec3::from(light.direction).normalize()),
        light_color: light.color.linear().map(|c| c * light.intensity as f32),
        ambient: light.ambient.linear(),
        ..unlit_frame(
            eye - origin,
            DVec3::from(camera.target) - eye,
            DVec3::from(camera.up),
            scene.field_of_view,
            size,
        )
    }
}

/// A frame seen from `eye`, relative to the scene's origin, along `forward` of
/// any length; `up` is not along it. `field_of_view` is the vertical one in
/// degrees, `size` in pixels. It has no light yet, and no near plane.
pub fn unlit_frame(
    eye: DVec3,
    forward: DVec3,
    up: DVec3,
    field_of_view: f64,
    size: [u32; 2],
) -> Frame {
    let forward = forward.normalize();
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let [width, height] = size.map(f64::from);
    let tan_y = (0.5 * field_of_view.to_radians()).tan();
    let tan_x = tan_y * width / height;
    let ray_right = right * (2.0 * tan_x / width);
    let ray_down = up * (-2.0 * tan_y / height);
    let corner = forward - right * tan_x + up * tan_y;
    Frame {
        eye: narrow(eye),
        right: narrow(right / tan_x),
        up: narrow(up / tan_y),
        forward: narrow(forward),
        ray_first: narrow(corner + 0.5 * (ray_right + ray_down)),
        ray_right: narrow(ray_right),
        ray_down: narrow(ray_down),
        size: [width as f32, height as f32],
        ..Frame::default()
    }
}

fn narrow(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}
