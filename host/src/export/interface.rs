//! How exported shaders fit into those of an engine: names and bindings.

use super::ExportError;
use super::layout::{Binding, bindings};
use super::map::{self, MapForm};
use crate::shaders::Facets;
use naga::{Module, ResourceBinding, Type, TypeInner};
use relievo_translate::GROUP;

/// Bindings of exported shaders, and names in what [`Output::Hit`](super::Output::Hit) exports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interface {
    /// Start of every global name of [`Output::Hit`](super::Output::Hit), in lower case: `relievo` gives `relievo_hit` and `RelievoHit`.
    pub prefix: String,
    /// Group (set, space) of the buffers.
    pub group: u32,
    /// Binding of the first of the four buffers; the others follow.
    pub first_binding: u32,
    /// How shaders read the shape map, at the last of these bindings.
    pub map: MapForm,
}

impl Default for Interface {
    /// The prefix `relievo`, bindings 0 to 3 of group 0, and the map in a buffer.
    fn default() -> Interface {
        Interface {
            prefix: "relievo".to_string(),
            group: 0,
            first_binding: 0,
            map: MapForm::Buffer,
        }
    }
}

/// Longest prefix, bytes.
const LONGEST: usize = 40;
/// Largest group and first binding: GLSL and Metal have 16 slots for each group, and Metal 31 in all, the
/// last of them for sizes.
const LARGEST: [u32; 2] = [1, 10];

fn refused(message: String) -> Result<(), ExportError> {
    Err(ExportError::Interface { message })
}

impl Interface {
    /// Checks that every language takes the names and the bindings.
    ///
    /// # Errors
    /// [`ExportError::Interface`] if one does not.
    pub(super) fn check(&self) -> Result<(), ExportError> {
        self.check_prefix()?;
        let [group, binding] = LARGEST;
        if self.group > group || self.first_binding > binding {
            return refused(format!(
                "group {} and first binding {} do not fit in every language; take a group up to {group} and a first binding up to {binding}",
                self.group, self.first_binding
            ));
        }
        Ok(())
    }

    /// Checks that every language takes the names.
    ///
    /// # Errors
    /// [`ExportError::Interface`] if one does not.
    pub(super) fn check_prefix(&self) -> Result<(), ExportError> {
        let is_plain = |letter: char| matches!(letter, 'a'..='z' | '0'..='9' | '_');
        let is_name = self
            .prefix
            .starts_with(|first: char| first.is_ascii_lowercase())
            && self.prefix.chars().all(is_plain)
            && !self.prefix.contains("__")
            && !self.prefix.ends_with('_')
            && self.prefix.len() <= LONGEST;
        if !is_name {
            return refused(format!(
                "the prefix {:?} is no name; take up to {LONGEST} letters from a to z, digits and single underscores, a letter first, such as relievo",
                self.prefix
            ));
        }
        Ok(())
    }

    /// Returns the name of a function or variable.
    pub(super) fn value(&self, name: &str) -> String {
        format!("{}_{name}", self.prefix)
    }

    /// Returns the name of a type.
    pub(super) fn type_name(&self, name: &str) -> String {
        let capital = |word: &str| {
            let (first, rest) = word.split_at(1.min(word.len()));
            first.to_uppercase() + rest
        };
        let words: String = self.prefix.split('_').map(capital).collect();
        words + name
    }

    /// Returns the names of the map.
    pub(super) fn map_names(&self) -> map::Names {
        map::Names {
            map: self.value("map"),
            data: self.type_name("WordData"),
            word: self.value("map_word"),
        }
    }

    /// Returns a text that is written for the prefix `relievo`, with these names and bindings.
    pub(super) fn adapt(&self, text: &str) -> String {
        text.replace("relievo_", &self.value(""))
            .replace("RELIEVO_", &self.value("").to_uppercase())
            .replace("Relievo", &self.type_name(""))
            .replace("FIRST_BINDING", &self.first_binding.to_string())
            .replace("GROUP", &self.group.to_string())
    }

    /// Returns what the shaders of an object with these facets read, with the bindings.
    pub(super) fn bindings(&self, facets: Facets) -> [Binding; 4] {
        bindings(facets, self.map).map(|binding| Binding {
            number: self.first_binding + binding.number,
            ..binding
        })
    }

    /// Returns the slot of the first buffer in a language without groups.
    pub(super) fn first_slot(&self) -> u32 {
        GROUP * self.group + self.first_binding
    }

    /// Moves the buffers of a module, which are in group 0, to their bindings.
    pub(super) fn place(&self, module: &mut Module) {
        for (_, variable) in module.global_variables.iter_mut() {
            if let Some(binding) = &mut variable.binding {
                *binding = ResourceBinding {
                    group: self.group,
                    binding: self.first_binding + binding.binding,
                };
            }
        }
    }

    /// Gives every global name of a module the prefix. What has no name gets a number.
    pub(super) fn rename(&self, module: &mut Module) {
        let types: Vec<_> = module.types.iter().map(|(handle, _)| handle).collect();
        for handle in types {
            let Type { name, inner } = module.types[handle].clone();
            let name = match (name, &inner) {
                (Some(name), _) => name,
                (None, TypeInner::Struct { .. }) => format!("Part{}_", handle.index()),
                _ => continue,
            };
            let name = Some(self.type_name(&name));
            module.types.replace(handle, Type { name, inner });
        }
        for (handle, function) in module.functions.iter_mut() {
            function.name = Some(self.value(&format!("part_{}_", handle.index())));
        }
        for (handle, variable) in module.global_variables.iter_mut() {
            let name = match (&variable.binding, &variable.name) {
                (Some(_), Some(name)) => name.clone(),
                _ => format!("value_{}_", handle.index()),
            };
            variable.name = Some(self.value(&name));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interface(prefix: &str, group: u32, first_binding: u32) -> Interface {
        Interface {
            prefix: prefix.to_string(),
            group,
            first_binding,
            map: MapForm::Buffer,
        }
    }

    #[test]
    fn names_have_the_prefix() {
        let wall = interface("my_wall2", 2, 4);
        assert_eq!(wall.value("hit"), "my_wall2_hit");
        assert_eq!(wall.type_name("Hit"), "MyWall2Hit");
        let text = wall.adapt("@group(GROUP) @binding(FIRST_BINDING) relievo_a RELIEVO_B RelievoC");
        assert_eq!(text, "@group(2) @binding(4) my_wall2_a MY_WALL2_B MyWall2C");
    }

    #[test]
    fn what_a_language_would_not_take_is_refused() {
        for (prefix, group, first, word) in [
            ("", 0, 0, "prefix"),
            ("2wall", 0, 0, "prefix"),
            ("Wall", 0, 0, "prefix"),
            ("wäll", 0, 0, "prefix"),
            ("wall_", 0, 0, "prefix"),
            ("a__b", 0, 0, "prefix"),
            ("wall", 2, 0, "group up to 1"),
            ("wall", 0, 11, "binding up to 10"),
            ("wall", u32::MAX, u32::MAX, "group up to 1"),
        ] {
            let error = interface(prefix, group, first).check().unwrap_err();
            assert!(error.to_string().contains(word), "{error}");
        }
        assert!(interface("relievo", 1, 10).check().is_ok());
    }
}
