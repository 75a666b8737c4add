//! The list of techniques: how scene files name profiles and their parameters.

use crate::profile::*;

/// Calls the macro `$with`, after the tokens `$before`, with every technique, a line
/// each:
///
/// ```text
/// Name "name" module::Profile, is relief mapping, [keys of its parameters]
///     (extension bevel chamfer parts by default) "doc";
/// ```
///
/// A scene that names no technique gets the first one with all parameters that it
/// gives.
#[macro_export]
macro_rules! for_each_technique {
    ($with:ident $($before:tt)*) => {
        $with! { $($before)*
            Basic "basic" straight::Straight false [] (0.0 0.0 1.0 1) "Upright walls on the pattern's outline.";
            Outward "outward" straight::Straight false ["extension"] (0.02 0.0 1.0 1) "Upright walls, the pattern grown by the extension.";
            Beveled "beveled" straight::Straight false ["extension", "bevel"] (0.0 0.08 1.0 1) "Walls that slant outwards down to the floor.";
            Chamfered "chamfered" straight::Straight false ["extension", "bevel", "chamfer"] (0.0 0.08 0.6 1) "Walls that slant outwards down to a part of the depth.";
            Rounded "rounded" rounded::Rounded false ["extension", "bevel", "chamfer"] (0.0 0.16 0.25 1) "Upright walls below a fillet at the cap's edge, of radius `bevel` × `chamfer`.";
            Stepped "stepped" stepped::Stepped false ["extension", "bevel", "chamfer", "terraces"] (0.0 0.12 0.75 3) "Terraces from the cap down to a part of the depth.";
            Relief "relief" straight::Straight true ["extension", "bevel", "chamfer"] (0.0 0.0 1.0 1) "Relief mapping, the baseline of comparisons.";
        }
    };
}

/// A technique: a row of [`TECHNIQUES`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TechniqueRow {
    /// Its name in scene files.
    pub name: &'static str,
    /// [`Growth::NUMBER`] of its profile.
    pub profile: u32,
    /// Whether it is relief mapping.
    pub is_relief: bool,
    /// Keys of its parameters.
    pub parameters: &'static [&'static str],
    /// Extension, bevel and chamfer by default.
    pub growth: [f64; 3],
    /// Number of parts by default.
    pub parts: u32,
    /// Description.
    pub doc: &'static str,
}

macro_rules! technique_rows {
    ($($technique:ident $name:literal $module:ident::$profile:ident $is_relief:literal [$($parameter:literal),*]
        ($extension:literal $bevel:literal $chamfer:literal $parts:literal) $doc:literal;)*) => {
        /// Every technique, in the order of the list.
        pub const TECHNIQUES: &[TechniqueRow] = &[$(TechniqueRow {
            name: $name,
            profile: $module::$profile::NUMBER,
            is_relief: $is_relief,
            parameters: &[$($parameter),*],
            growth: [$extension, $bevel, $chamfer],
            parts: $parts,
            doc: $doc,
        },)*];
    };
}
for_each_technique!(technique_rows);

/// Number of profiles in the list.
pub const PROFILES: u32 = {
    let mut count = 0;
    let mut i = 0;
    while i < TECHNIQUES.len() {
        if TECHNIQUES[i].profile >= count {
            count = TECHNIQUES[i].profile + 1;
        }
        i += 1;
    }
    count
};
