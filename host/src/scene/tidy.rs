//! Resetting of values that have no meaning after a change of tier, technique or
//! error budget.

use super::keys::{OBJECT, find};
use super::track::object_key;
use super::{Scene, SceneObject, Search, Tier};
use relievo_shared::profile;

impl SceneObject {
    /// Resets what another tier or search was set for: parameters that have no
    /// meaning for the new one, and the effort, get their defaults; layers that it does not
    /// draw are removed.
    pub fn tidy(&mut self) {
        if self.search == Search::Relief {
            self.tier = Tier::Fast;
        }
        if self.search == Search::Relief || self.tier == Tier::Paper {
            self.extrusion.profile = profile::STRAIGHT;
            self.layers.clear();
        }
        if self.tier == Tier::Paper {
            self.extrusion.extension = self.extrusion.extension.max(0.0);
        }
        let default = SceneObject::default();
        for key in OBJECT {
            if key.applies(self).is_err() {
                key.copy(self, &default);
            }
        }
        self.set_default_effort();
    }

    /// Resets what an error budget chooses: tier, tolerance, slack, steps and map.
    pub fn reset_planned(&mut self) {
        let default = SceneObject::default();
        for key in OBJECT.iter().filter(|key| key.is_planned) {
            key.copy(self, &default);
        }
    }
}

impl Scene {
    /// Gives all objects but those drawn by relief mapping this error budget,
    /// pixels, in place of tier, tolerance, slack, steps and map, and of their tracks. `None`
    /// changes nothing.
    pub fn set_budget(&mut self, budget: Option<f64>) {
        if budget.is_none() {
            return;
        }
        let objects = self.objects.iter_mut();
        for object in objects.filter(|object| object.search == Search::Extrusion) {
            object.reset_planned();
            object.budget = budget;
        }
        self.tracks.retain(|track| {
            let key = object_key(&track.key).and_then(|(_, name)| find(OBJECT, name));
            !key.is_some_and(|key| key.is_planned)
        });
    }
}
