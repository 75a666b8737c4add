//! Pictures as words: the bits of f32, which are compared exactly.

use relievo_shared::Vec3;
use relievo_shared::normals::CLASS_MISS;
use relievo_shared::shading::edges::{from_code, lights_of};

/// Linear colours, as the bits of f32.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColorWords {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// (red, green, blue, class) of each pixel, rows from the top. With smooth edges the class word also has the
    /// shares of neighbours and of what lies between
    /// ([`from_code`](relievo_shared::shading::edges::from_code)), whose light the other words have beside the
    /// pixel's own ([`lights_of`](relievo_shared::shading::edges::lights_of)).
    pub words: Vec<[u32; 4]>,
}

impl ColorWords {
    /// Returns the linear RGB of the surface that a pixel hits.
    pub fn rgb(&self, x: u32, y: u32) -> [f32; 3] {
        let (own, _) = lights_of(self.pixel(x, y).into());
        own.to_array()
    }

    /// Returns the words of a pixel.
    pub fn pixel(&self, x: u32, y: u32) -> [u32; 4] {
        self.words[y as usize * self.width as usize + x as usize]
    }

    /// Calls `visit` with each part of a pixel: its linear RGB, its class, and its share.
    ///
    /// Without smooth edges a pixel has one part; with them, parts are what lies between it and its neighbours, which
    /// counts as its class, and those of the neighbours.
    pub fn parts(&self, x: u32, y: u32, mut visit: impl FnMut([f32; 3], u32, f32)) {
        let mut part = |light: Vec3, word: u32, share: f32| {
            if share > 0.0 {
                visit(light.to_array(), from_code(word).0, share);
            }
        };
        let own = self.pixel(x, y);
        let (_, shares) = from_code(own[3]);
        let (light, between) = lights_of(own.into());
        let share = 1.0 - shares.before - shares.after;
        part(light, own[3], share * (1.0 - shares.between));
        part(between, own[3], share * shares.between);
        let (dx, dy) = if shares.is_down { (0, 1) } else { (1, 0) };
        let mut neighbor = |x: u32, y: u32, share: f32| {
            let words = self.pixel(x, y);
            part(lights_of(words.into()).0, words[3], share);
        };
        if shares.before > 0.0 {
            neighbor(x - dx, y - dy, shares.before);
        }
        if shares.after > 0.0 {
            neighbor(x + dx, y + dy, shares.after);
        }
    }
}

/// What each pixel hits, as words; all 0 for a miss.
///
/// Pixels are numbered in rows from the top; [`crate::render::Hits`] gives the
/// same per pixel, with position and object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GeometryWords {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// (t, u, v, δ) of each pixel, rows from the top.
    pub place: Vec<[u32; 4]>,
    /// (class + 256 · steps, N.x, N.y, N.z) of each pixel.
    pub surface: Vec<[u32; 4]>,
}

impl GeometryWords {
    /// Returns the distance along the ray in pixel `index`, world units.
    pub fn t(&self, index: usize) -> f32 {
        f32::from_bits(self.place[index][0])
    }

    /// Returns the texture coordinates in pixel `index`, within one
    /// repeat of the pattern, v down.
    pub fn uv(&self, index: usize) -> [f32; 2] {
        let [_, u, v, _] = self.place[index];
        [u, v].map(f32::from_bits)
    }

    /// Returns the depth fraction δ in pixel `index`: 0 at the surface, 1 at the
    /// floor.
    pub fn delta(&self, index: usize) -> f32 {
        f32::from_bits(self.place[index][3])
    }

    /// Returns the surface class of pixel `index`, one of the `CLASS_` constants
    /// of [`relievo_shared::normals`].
    pub fn class(&self, index: usize) -> u32 {
        self.surface[index][0] & 255
    }

    /// Returns the steps of the linear search in pixel `index`; 0 for a miss.
    pub fn steps(&self, index: usize) -> u32 {
        self.surface[index][0] >> 8
    }

    /// Returns the unit normal of the carved surface in pixel `index`, world axes.
    pub fn normal(&self, index: usize) -> [f32; 3] {
        let [_, x, y, z] = self.surface[index];
        [x, y, z].map(f32::from_bits)
    }

    /// Returns the number of pixels with a hit, and their mean number of linear
    /// steps.
    pub fn coverage(&self) -> (usize, f64) {
        let (mut covered, mut steps) = (0, 0_u64);
        for index in (0..self.surface.len()).filter(|&index| self.class(index) != CLASS_MISS) {
            covered += 1;
            steps += u64::from(self.steps(index));
        }
        (covered, steps as f64 / covered.max(1) as f64)
    }
}
