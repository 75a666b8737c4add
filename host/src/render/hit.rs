//! What one pixel hits.

use super::cpu::{CpuRenderer, NO_OBJECT};
use super::words::GeometryWords;
use crate::prepare::{PreparedObject, PreparedScene};
use glam::{DVec3, Vec3};
use relievo_shared::camera::pixel_ray;
use relievo_shared::layout::Frame;
use relievo_shared::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR, CLASS_WALL};
use std::sync::OnceLock;

/// Part of the carved surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// The uncarved surface.
    Cap,
    /// A side with a constant outline.
    Wall,
    /// A side whose outline grows with the depth.
    Bevel,
    /// The bottom between columns.
    Floor,
}

impl Class {
    /// Returns the class of a `CLASS_` constant of [`relievo_shared::normals`];
    /// `None` for a miss.
    pub fn of(code: u32) -> Option<Class> {
        match code {
            CLASS_CAP => Some(Class::Cap),
            CLASS_WALL => Some(Class::Wall),
            CLASS_BEVEL => Some(Class::Bevel),
            CLASS_FLOOR => Some(Class::Floor),
            _ => None,
        }
    }

    /// Returns the `CLASS_` constant.
    pub fn code(self) -> u32 {
        match self {
            Class::Cap => CLASS_CAP,
            Class::Wall => CLASS_WALL,
            Class::Bevel => CLASS_BEVEL,
            Class::Floor => CLASS_FLOOR,
        }
    }
}

/// The hits of a picture, decoded from its words without a copy.
pub struct Hits<'a> {
    scene: &'a PreparedScene,
    frame: &'a Frame,
    words: &'a GeometryWords,
    /// The object of each pixel; found at the first use.
    objects: OnceLock<Vec<u32>>,
}

/// The hit of one pixel.
#[derive(Clone, Copy)]
pub struct Hit<'h, 'a> {
    hits: &'h Hits<'a>,
    x: u32,
    y: u32,
    class: Class,
}

impl<'a> Hits<'a> {
    /// Decodes `words`, the picture of `scene` in `frame`.
    ///
    /// # Panics
    /// If `words` and `frame` differ in size.
    pub fn new(scene: &'a PreparedScene, frame: &'a Frame, words: &'a GeometryWords) -> Hits<'a> {
        let size = frame.size.map(|side| side as u32);
        assert_eq!(size, [words.width, words.height]);
        Hits {
            scene,
            frame,
            words,
            objects: OnceLock::new(),
        }
    }

    /// Returns the hit of pixel (`x`, `y`), counted from the top left; `None` for
    /// a miss.
    ///
    /// # Panics
    /// If the pixel is outside the picture.
    pub fn at(&self, x: u32, y: u32) -> Option<Hit<'_, 'a>> {
        assert!(x < self.words.width && y < self.words.height);
        let class = Class::of(self.words.class(self.index(x, y)))?;
        Some(Hit {
            hits: self,
            x,
            y,
            class,
        })
    }

    /// Returns the hit of each pixel, rows from the top.
    pub fn pixels(&self) -> impl Iterator<Item = Option<Hit<'_, 'a>>> {
        let GeometryWords { width, height, .. } = *self.words;
        (0..height).flat_map(move |y| (0..width).map(move |x| self.at(x, y)))
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.words.width as usize + x as usize
    }
}

impl Hit<'_, '_> {
    /// Returns the column and the row of the pixel, from the top left.
    pub fn pixel(&self) -> [u32; 2] {
        [self.x, self.y]
    }

    /// Returns the distance of the hit from the eye, world units.
    pub fn t(&self) -> f32 {
        self.hits.words.t(self.index())
    }

    /// Returns the position, world units.
    pub fn position(&self) -> DVec3 {
        let Hits { scene, frame, .. } = self.hits;
        let direction = pixel_ray(frame, self.x, self.y).as_dvec3();
        scene.origin + Vec3::from(frame.eye).as_dvec3() + direction * f64::from(self.t())
    }

    /// Returns the texture coordinates within one repeat of the pattern, v
    /// down.
    pub fn uv(&self) -> [f32; 2] {
        self.hits.words.uv(self.index())
    }

    /// Returns the depth fraction δ: 0 at the surface, 1 at the floor.
    pub fn delta(&self) -> f32 {
        self.hits.words.delta(self.index())
    }

    /// Returns the part of the carved surface.
    pub fn class(&self) -> Class {
        self.class
    }

    /// Returns the unit normal of the carved surface, world axes.
    pub fn normal(&self) -> [f32; 3] {
        self.hits.words.normal(self.index())
    }

    /// Returns the number of steps of the linear search.
    pub fn steps(&self) -> u32 {
        self.hits.words.steps(self.index())
    }

    /// Returns the index of the object in [`PreparedScene::objects`].
    ///
    /// Words do not store it: the picture of a scene of several objects is traced again, on
    /// the CPU, once. `None` if that ray misses, which happens only with words of a device
    /// that rounds differently.
    pub fn object(&self) -> Option<usize> {
        let Hits { scene, frame, .. } = *self.hits;
        if scene.objects.len() == 1 {
            return Some(0);
        }
        let objects = self
            .hits
            .objects
            .get_or_init(|| CpuRenderer::new(scene).objects(frame));
        let object = objects[self.index()];
        (object != NO_OBJECT).then_some(object as usize)
    }

    /// Returns the object, as [`Hit::object`] does.
    pub fn prepared(&self) -> Option<&PreparedObject> {
        self.object().map(|index| &self.hits.scene.objects[index])
    }

    fn index(&self) -> usize {
        self.hits.index(self.x, self.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::prepare;
    use crate::render::Renderer;
    use crate::scene::Scene;
    use std::path::Path;

    /// Two spheres beside each other, the second one nearer to the eye.
    #[test]
    fn each_pixel_has_its_object_and_a_position_on_it() {
        let text = "[image]\nsize = [80, 40]\n[camera]\neye = [100.0, 0.0, 10.0]\ntarget = [100.0, 0.0, 0.0]\nfov = 25.0\n[[object]]\nmesh = '../meshes/sphere.obj'\nshape = '../patterns/discs.png'\nrepeat = [8, 4]\ndepth = 0.05\ntranslate = [98.5, 0.0, 0.0]\n[[object]]\nmesh = '../meshes/sphere.obj'\nshape = '../patterns/discs.png'\nrepeat = [8, 4]\ndepth = 0.05\ntier = 'accurate'\ntranslate = [101.5, 0.0, 1.0]\n";
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/a.toml");
        let scene = prepare(&Scene::parse(text, &path).unwrap(), &|_| ()).unwrap();
        let words = CpuRenderer::new(&scene).geometry(&scene.frame).unwrap();
        let hits = Hits::new(&scene, &scene.frame, &words);
        let mut seen = [0; 2];
        for hit in hits.pixels().flatten() {
            let object = hit.object().unwrap();
            seen[object] += 1;
            let centre = [DVec3::new(98.5, 0.0, 0.0), DVec3::new(101.5, 0.0, 1.0)][object];
            // The depth below the unit sphere, up to the facets' error.
            let depth = 1.0 - hit.position().distance(centre);
            let wanted = 0.05 * f64::from(hit.delta());
            assert!((depth - wanted).abs() < 0.01, "{depth} {wanted}");
            // In the accurate tier the floor is found up to the overlap of prisms.
            assert!(hit.class() != Class::Floor || hit.delta() > 0.999);
        }
        assert!(seen.iter().all(|pixels| *pixels > 200), "{seen:?}");
        assert!(hits.at(0, 0).is_none());
    }
}
