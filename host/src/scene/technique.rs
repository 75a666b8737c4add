//! The techniques of the paper, as scene files name them. This is the only list
//! of them on the host.

use super::{Extrusion, SceneObject, Search};

/// A way to make geometry of a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Technique {
    /// Upright walls on the pattern's outline.
    Basic,
    /// Upright walls, the pattern grown by the extension.
    Outward,
    /// Walls that slant outwards down to the floor.
    Beveled,
    /// Walls that slant outwards down to a part of the depth.
    Chamfered,
    /// Relief mapping, the baseline of comparisons.
    Relief,
}

impl Technique {
    /// All techniques. Each one follows those with fewer parameters, but for
    /// relief mapping.
    pub const ALL: [Technique; 5] = [
        Technique::Basic,
        Technique::Outward,
        Technique::Beveled,
        Technique::Chamfered,
        Technique::Relief,
    ];

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Technique::Basic => "basic",
            Technique::Outward => "outward",
            Technique::Beveled => "beveled",
            Technique::Chamfered => "chamfered",
            Technique::Relief => "relief",
        }
    }

    /// Returns the keys of its parameters.
    pub fn parameters(self) -> &'static [&'static str] {
        match self {
            Technique::Basic => &[],
            Technique::Outward => &["extension"],
            Technique::Beveled => &["extension", "bevel"],
            // A depth map can hold any profile.
            Technique::Chamfered | Technique::Relief => &["extension", "bevel", "chamfer"],
        }
    }

    /// Returns the default values of its parameters.
    pub fn default_extrusion(self) -> Extrusion {
        let [extension, bevel, chamfer] = match self {
            Technique::Basic | Technique::Relief => [0.0, 0.0, 1.0],
            Technique::Outward => [0.02, 0.0, 1.0],
            Technique::Beveled => [0.0, 0.08, 1.0],
            Technique::Chamfered => [0.0, 0.08, 0.6],
        };
        Extrusion {
            extension,
            bevel,
            chamfer,
        }
    }

    /// Returns whether the key `name` is a parameter of any technique.
    pub fn is_parameter(name: &str) -> bool {
        Technique::ALL.iter().any(|technique| technique.has(name))
    }

    /// Returns whether the key `name` is one of its parameters.
    pub fn has(self, name: &str) -> bool {
        self.parameters().contains(&name)
    }

    /// Returns the technique with the fewest parameters that has all of `given`.
    pub fn with_parameters(given: &[&str]) -> Technique {
        let mut all = Technique::ALL.into_iter();
        all.find(|technique| given.iter().all(|name| technique.has(name)))
            .expect("one technique has every parameter")
    }
}

impl SceneObject {
    /// Returns the technique with the fewest parameters that draws the object.
    pub fn technique(&self) -> Technique {
        let extrusion = self.extrusion;
        match self.search {
            Search::Relief => Technique::Relief,
            Search::Extrusion if extrusion.chamfer != 1.0 => Technique::Chamfered,
            Search::Extrusion if extrusion.bevel != 0.0 => Technique::Beveled,
            Search::Extrusion if extrusion.extension != 0.0 => Technique::Outward,
            Search::Extrusion => Technique::Basic,
        }
    }

    /// Sets the search, and parameters and effort to the technique's defaults.
    pub fn set_technique(&mut self, technique: Technique) {
        self.extrusion = technique.default_extrusion();
        self.search = match technique {
            Technique::Relief => Search::Relief,
            _ => Search::Extrusion,
        };
        self.set_default_effort();
    }
}
