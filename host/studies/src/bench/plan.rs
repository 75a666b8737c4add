//! Methods, scenes and published results of the paper's Table 1.

use relievo::scene::{Scene, SceneError, Technique};
use std::fmt;
use std::path::Path;

/// Surface model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// Straight rays: no silhouettes.
    Planar,
    /// Rays bent along the local quadric.
    Curved,
    /// The paper's algorithms as printed.
    Paper,
}

/// A column of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// Surface model.
    pub surface: Surface,
    /// Technique, with its default parameters: b = 0.08, c = 0.6.
    pub technique: Technique,
}

impl Method {
    /// Every method: the paper's columns in its order, then our additions.
    pub const ALL: [Method; 11] = {
        use Surface::{Curved, Paper, Planar};
        use Technique::{Basic, Beveled, Chamfered, Relief};
        [
            Method::new(Planar, Basic),
            Method::new(Planar, Beveled),
            Method::new(Planar, Chamfered),
            Method::new(Curved, Basic),
            Method::new(Curved, Beveled),
            Method::new(Curved, Chamfered),
            Method::new(Curved, Relief),
            Method::new(Planar, Relief),
            Method::new(Paper, Basic),
            Method::new(Paper, Beveled),
            Method::new(Paper, Chamfered),
        ]
    };
    /// Number of the paper's columns, the first of [`Method::ALL`].
    pub const IN_PAPER: usize = 7;
    /// The method that the paper compares extrusion with.
    pub const CURVED_RELIEF: Method = Method::new(Surface::Curved, Technique::Relief);

    const fn new(surface: Surface, technique: Technique) -> Method {
        Method { surface, technique }
    }

    /// Returns the index in [`Method::ALL`].
    pub fn index(self) -> usize {
        let mut all = Method::ALL.iter();
        all.position(|method| *method == self)
            .expect("ALL holds every method")
    }

    /// Returns whether the paper measures this method.
    pub fn is_in_paper(self) -> bool {
        self.index() < Method::IN_PAPER
    }

    /// Returns the same technique without curvature, to compare the cost of
    /// silhouettes.
    pub fn planar(self) -> Option<Method> {
        (self.surface == Surface::Curved).then_some(Method::new(Surface::Planar, self.technique))
    }

    /// Returns the paper's method of comparison: curved relief mapping, for
    /// extrusions.
    pub fn relief(self) -> Option<Method> {
        (self.technique != Technique::Relief).then_some(Method::CURVED_RELIEF)
    }

    /// Returns the keys that select this method in a scene's object.
    fn keys(self) -> String {
        let tier = match self.surface {
            Surface::Planar => "planar",
            Surface::Curved => "fast",
            Surface::Paper => "paper",
        };
        format!("technique = '{}'\ntier = '{tier}'", self.technique.name())
    }
}

impl fmt::Display for Method {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let surface = match self.surface {
            Surface::Planar => "planar",
            Surface::Curved => "curved",
            Surface::Paper => "paper tier",
        };
        write!(formatter, "{surface} {}", self.technique.name())
    }
}

/// A row of the table: a shape map of 1024² texels and its repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatternRow {
    /// Name of the pattern in `patterns/`; the paper's own are not published.
    pub pattern: &'static str,
    /// Repeats along u and v.
    pub repeat: [u32; 2],
    /// The paper's frames per second for the first [`Method::IN_PAPER`]
    /// methods.
    pub paper_fps: [f64; Method::IN_PAPER],
}

/// The rows, with the figures of Table 1 of A. Ouazzani Chahdi et al.,
/// "Per-pixel extrusion mapping with correct silhouette", 2021, section 6.
pub const ROWS: [PatternRow; 3] = [
    PatternRow {
        pattern: "letters",
        repeat: [6, 6],
        paper_fps: [200.0, 184.0, 176.0, 192.0, 176.0, 168.0, 136.0],
    },
    PatternRow {
        pattern: "bricks",
        repeat: [10, 10],
        paper_fps: [160.0, 144.0, 136.0, 152.0, 136.0, 128.0, 128.0],
    },
    PatternRow {
        pattern: "lattice",
        repeat: [12, 10],
        paper_fps: [152.0, 136.0, 128.0, 144.0, 128.0, 120.0, 96.0],
    },
];

impl PatternRow {
    /// Returns the paper's frames per second with `method`.
    pub fn paper_fps_of(&self, method: Method) -> Option<f64> {
        self.paper_fps.get(method.index()).copied()
    }

    /// Returns the paper's speed of `method` as a multiple of that of
    /// `reference`.
    pub fn paper_speed(&self, method: Method, reference: Method) -> Option<f64> {
        Some(self.paper_fps_of(method)? / self.paper_fps_of(reference)?)
    }

    /// Returns the scene of `method`: the torus of 2,028 triangles, which fills
    /// the view, with 25 linear and 5 binary steps. `assets` holds the folders
    /// `meshes` and `patterns`; `size` is in pixels.
    ///
    /// # Errors
    /// [`SceneError`] if a side of `size` is out of range.
    pub fn scene(
        &self,
        method: Method,
        size: [u32; 2],
        assets: &Path,
    ) -> Result<Scene, SceneError> {
        let PatternRow {
            pattern,
            repeat: [u, v],
            ..
        } = self;
        let [width, height] = size;
        let keys = method.keys();
        let text = format!(
            "[image]
size = [{width}, {height}]
[camera]
eye = [0.0, 0.82, 1.9]
target = [0.0, 0.0, 0.8]
fov = 38.0
[[object]]
mesh = 'meshes/torus.obj'
shape = 'patterns/{pattern}.png'
repeat = [{u}, {v}]
depth = 0.1
steps = 25
bisections = 5
{keys}
"
        );
        Scene::parse(&text, &assets.join("table1.toml"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo::scene::{Search, Tier};

    #[test]
    fn the_methods_are_what_they_say() {
        for (i, method) in Method::ALL.into_iter().enumerate() {
            assert_eq!(method.index(), i);
            let scene = ROWS[0].scene(method, [80, 60], Path::new("a")).unwrap();
            let object = &scene.objects[0];
            assert_eq!((object.steps, object.bisections), (25, 5));
            let tier = match method.surface {
                Surface::Planar => Tier::Planar,
                Surface::Curved => Tier::Fast,
                Surface::Paper => Tier::Paper,
            };
            assert_eq!(object.tier, tier);
            let relief = method.technique == Technique::Relief;
            assert_eq!(object.search == Search::Relief, relief);
            let (bevel, chamfer) = match method.technique {
                Technique::Beveled => (0.08, 1.0),
                Technique::Chamfered => (0.08, 0.6),
                _ => (0.0, 1.0),
            };
            let found = object.extrusion;
            assert_eq!((found.bevel, found.chamfer), (bevel, chamfer), "{method}");
        }
    }

    #[test]
    fn the_papers_own_conclusions_follow_from_its_figures() {
        // "means differences of 42, 26, and 18 FPS" over curved relief mapping,
        // and a loss "of 8 FPS" by curvature.
        for (column, difference) in [(3, 42.0), (4, 26.0), (5, 18.0)] {
            let sum: f64 = ROWS
                .iter()
                .map(|row| row.paper_fps[column] - row.paper_fps[6])
                .sum();
            assert_eq!((sum / 3.0).floor(), difference);
            for row in ROWS {
                assert_eq!(row.paper_fps[column - 3] - row.paper_fps[column], 8.0);
            }
        }
        let basic = Method::ALL[3];
        let [to_planar, to_relief] = [basic.planar(), basic.relief()]
            .map(|reference| ROWS[0].paper_speed(basic, reference.unwrap()).unwrap());
        assert_eq!(to_planar, 0.96);
        assert!((to_relief - 1.41).abs() < 0.005);
        assert_eq!(ROWS[0].paper_speed(Method::ALL[8], basic), None);
    }
}
