//! Undo and redo of changes of the scene.

use super::Viewer;
use eframe::egui::InputState;
use eframe::egui::util::undoer::Undoer;
use relievo::scene::Scene;

/// Versions of the scene.
///
/// A step is what changes while a button of the pointer is down, or what changes
/// without it and less than a second apart, as typed letters do.
#[derive(Default)]
pub struct History(Undoer<Scene>);

impl History {
    /// Records `scene`; called before each frame.
    pub fn record(&mut self, scene: &Scene, input: &InputState) {
        let pointer = &input.pointer;
        let is_edge = pointer.any_pressed() || pointer.any_released();
        self.note(scene, input.time, pointer.any_down(), is_edge);
    }

    /// Records `scene` at `time`, seconds. `is_edge` tells that the pointer was pressed
    /// or released, which ends a step.
    fn note(&mut self, scene: &Scene, time: f64, is_down: bool, is_edge: bool) {
        if is_edge || !is_down {
            self.0.feed_state(time, scene);
        }
        if is_edge {
            self.0.add_undo(scene);
        }
    }
}

impl Viewer {
    pub(super) fn can_undo(&self) -> bool {
        self.history.0.has_undo(&self.scene)
    }

    pub(super) fn can_redo(&self) -> bool {
        self.history.0.has_redo(&self.scene)
    }

    pub(super) fn undo(&mut self) {
        if let Some(scene) = self.history.0.undo(&self.scene).cloned() {
            self.replace(scene);
        }
    }

    pub(super) fn redo(&mut self) {
        if let Some(scene) = self.history.0.redo(&self.scene).cloned() {
            self.replace(scene);
        }
    }

    /// Shows another scene. The camera stays where it is, unless the meshes change.
    pub(super) fn replace(&mut self, scene: Scene) {
        let old = self.scene.objects.iter().map(|object| &object.mesh);
        let new = scene.objects.iter().map(|object| &object.mesh);
        if old.ne(new) {
            self.camera = scene.own_camera();
        }
        self.selected = self.selected.min(scene.objects.len().saturating_sub(1));
        self.scene = scene;
        self.order(false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene whose field of view is `degrees`.
    fn scene(degrees: f64) -> Scene {
        Scene::default().field_of_view(degrees)
    }

    fn undone(history: &mut History, degrees: f64) -> Option<f64> {
        let scene = history.0.undo(&scene(degrees));
        scene.map(|scene| scene.field_of_view)
    }

    fn redone(history: &mut History, degrees: f64) -> Option<f64> {
        let scene = history.0.redo(&scene(degrees));
        scene.map(|scene| scene.field_of_view)
    }

    #[test]
    fn a_drag_is_one_step_however_long_it_takes() {
        let mut history = History::default();
        history.note(&scene(10.0), 0.0, false, false);
        history.note(&scene(10.0), 1.0, true, true);
        for (time, degrees) in [(1.1, 11.0), (9.0, 12.0), (60.0, 13.0)] {
            history.note(&scene(degrees), time, true, false);
        }
        history.note(&scene(13.0), 60.1, false, true);
        // The next one at once.
        history.note(&scene(13.0), 60.2, true, true);
        history.note(&scene(20.0), 60.3, false, true);
        assert_eq!(undone(&mut history, 20.0), Some(13.0));
        assert_eq!(undone(&mut history, 13.0), Some(10.0));
        assert_eq!(undone(&mut history, 10.0), None);
        assert_eq!(redone(&mut history, 10.0), Some(13.0));
        assert_eq!(redone(&mut history, 13.0), Some(20.0));
        assert_eq!(redone(&mut history, 20.0), None);
    }

    #[test]
    fn keys_in_quick_succession_are_one_step_and_a_change_ends_redo() {
        let mut history = History::default();
        let mut at = |time: f64, degrees: f64| {
            history.note(&scene(degrees), time, false, false);
        };
        at(0.0, 10.0);
        at(5.0, 11.0);
        at(5.5, 12.0);
        // Drawn again much later, with the next change.
        at(30.0, 12.0);
        at(30.1, 13.0);
        assert_eq!(undone(&mut history, 13.0), Some(12.0));
        assert_eq!(undone(&mut history, 12.0), Some(10.0));
        history.note(&scene(50.0), 31.0, false, false);
        assert_eq!(redone(&mut history, 50.0), None);
        assert_eq!(undone(&mut history, 50.0), Some(10.0));
    }
}
