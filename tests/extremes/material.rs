//! Unusual meshes, patterns and scenes.

use glam::DVec3;
use image::{GrayImage, Luma};
use relievo::scene::{Camera, Scene, SceneObject};
use relievo_tests::asset;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A temporary folder of generated files.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a pattern of this size, black where `is_pattern`.
    pub fn pattern(&self, [width, height]: [u32; 2], is_pattern: fn(u32, u32) -> bool) -> PathBuf {
        let image = GrayImage::from_fn(width, height, |x, y| {
            Luma([if is_pattern(x, y) { 0 } else { 255 }])
        });
        let name = format!("{}.png", std::fs::read_dir(self.path()).unwrap().count());
        let path = self.path().join(name);
        image.save(&path).unwrap();
        path
    }

    /// Writes a mesh of positions, texture coordinates and triangles (indices
    /// from 0; a corner's texture coordinates have the same index).
    pub fn mesh(&self, corners: &[(DVec3, [f64; 2])], triangles: &[[usize; 3]]) -> PathBuf {
        let mut text = String::new();
        for (position, [u, v]) in corners {
            let DVec3 { x, y, z } = position;
            writeln!(text, "v {x} {y} {z}\nvt {u} {v}").unwrap();
        }
        for [a, b, c] in triangles.iter().map(|t| t.map(|corner| corner + 1)) {
            writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}").unwrap();
        }
        let name = format!("{}.obj", std::fs::read_dir(self.path()).unwrap().count());
        let path = self.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Writes a patch of `cells` × `cells` squares over (−1…1)², with height y
    /// = `height`(x, z) and texture coordinates `uv`(x, z).
    pub fn patch(
        &self,
        cells: usize,
        height: fn(f64, f64) -> f64,
        uv: fn(f64, f64) -> [f64; 2],
    ) -> PathBuf {
        let at = |i: usize| 2.0 * i as f64 / cells as f64 - 1.0;
        let row = cells + 1;
        let corners: Vec<_> = (0..row * row)
            .map(|i| {
                let (x, z) = (at(i % row), -at(i / row));
                (DVec3::new(x, height(x, z), z), uv(x, z))
            })
            .collect();
        let triangles: Vec<_> = (0..cells * cells)
            .flat_map(|i| {
                let first = i / cells * row + i % cells;
                [
                    [first, first + 1, first + row + 1],
                    [first, first + row + 1, first + row],
                ]
            })
            .collect();
        self.mesh(&corners, &triangles)
    }
}

/// A beveled and chamfered ball of radius 1, seen from outside.
pub fn ball() -> Scene {
    let text = "[image]\nsize = [48, 36]\n[camera]\neye = [0.4, 0.6, 2.6]\nfov = 50.0\n\
        [[object]]\nmesh = \"../meshes/sphere.obj\"\nshape = \"../patterns/discs.png\"\n\
        repeat = [12, 6]\ndepth = 0.08\ntechnique = \"chamfered\"\nextension = 0.02\n\
        bevel = 0.06\nchamfer = 0.5\n";
    Scene::parse(text, &asset("scenes/extreme.toml")).unwrap()
}

/// The same with another mesh.
pub fn over(mesh: &str) -> Scene {
    let mut scene = ball();
    scene.objects[0].mesh = asset("meshes").join(mesh).into();
    scene
}

/// Places the camera.
pub fn look(scene: &mut Scene, eye: [f64; 3], target: [f64; 3]) {
    let up = [0.0, 1.0, 0.01];
    scene.camera = Some(Camera { eye, target, up });
}

/// Scales a scene by `factor`.
pub fn scale(scene: &mut Scene, factor: f64) {
    let longer = |v: [f64; 3]| v.map(|x| x * factor);
    if let Some(camera) = &mut scene.camera {
        camera.eye = longer(camera.eye);
        camera.target = longer(camera.target);
    }
    for SceneObject {
        scale,
        translate,
        depth,
        ..
    } in &mut scene.objects
    {
        *scale *= factor;
        *translate = longer(*translate);
        *depth = depth.map(|depth| depth * factor);
    }
}
