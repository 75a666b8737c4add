//! Techniques: the ways to make geometry of a pattern. Their list is in
//! `relievo_shared::techniques`.

use super::{Extrusion, Layer, SceneObject, Search};
use relievo_shared::for_each_technique;
use relievo_shared::techniques::{TECHNIQUES, TechniqueRow};

macro_rules! technique {
    ($($name:ident $text:literal $module:ident::$profile:ident $is_relief:literal [$($parameter:literal),*]
        ($($default:literal)*) $doc:literal;)*) => {
        /// A way to make geometry of a pattern, as scene files name it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Technique {
            $(#[doc = $doc] $name,)*
        }

        impl Technique {
            /// All techniques. Those with fewer parameters come first.
            pub const ALL: [Technique; TECHNIQUES.len()] = [$(Technique::$name),*];
        }
    };
}
for_each_technique!(technique);

impl Technique {
    fn row(self) -> &'static TechniqueRow {
        &TECHNIQUES[self as usize]
    }

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns the description.
    pub fn describe(self) -> &'static str {
        self.row().doc
    }

    /// Returns the keys of its parameters.
    pub fn parameters(self) -> &'static [&'static str] {
        self.row().parameters
    }

    /// Returns how it searches for hits.
    pub fn search(self) -> Search {
        if self.row().is_relief {
            Search::Relief
        } else {
            Search::Extrusion
        }
    }

    /// Returns the default values of its parameters.
    pub fn default_extrusion(self) -> Extrusion {
        let row = self.row();
        let [extension, bevel, chamfer] = row.growth;
        Extrusion {
            profile: row.profile,
            extension,
            bevel,
            chamfer,
            parts: row.parts,
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
    pub fn with_parameters(given: &[&str]) -> Option<Technique> {
        let mut all = Technique::ALL.into_iter();
        all.find(|technique| given.iter().all(|name| technique.has(name)))
    }

    /// Returns the technique with the fewest parameters that draws `extrusion`.
    fn of(search: Search, extrusion: &Extrusion) -> Technique {
        let mut all = Technique::ALL.into_iter();
        all.find(|technique| technique.draws(search, extrusion))
            .unwrap_or(Technique::Relief)
    }

    /// Returns whether it draws objects with `search` and `extrusion`.
    fn draws(self, search: Search, extrusion: &Extrusion) -> bool {
        let Extrusion {
            profile,
            extension,
            bevel,
            chamfer,
            parts: _,
        } = *extrusion;
        search == self.search()
            && profile == self.row().profile
            && (extension == 0.0 || self.has("extension"))
            && (bevel == 0.0 || self.has("bevel"))
            && (chamfer == 1.0 || self.has("chamfer"))
    }
}

impl SceneObject {
    /// Returns the technique with the fewest parameters that draws the object.
    pub fn technique(&self) -> Technique {
        Technique::of(self.search, &self.extrusion)
    }

    /// Sets the search, and parameters and effort to the technique's defaults.
    pub fn set_technique(&mut self, technique: Technique) {
        self.extrusion = technique.default_extrusion();
        self.search = technique.search();
        self.set_default_effort();
    }
}

impl Layer {
    /// Returns the technique with the fewest parameters that draws the layer.
    pub fn technique(&self) -> Technique {
        Technique::of(Search::Extrusion, &self.extrusion)
    }

    /// Sets the parameters to the technique's defaults. Relief mapping, which has no layers,
    /// gives upright walls.
    pub fn set_technique(&mut self, technique: Technique) {
        self.extrusion = technique.default_extrusion();
    }
}
