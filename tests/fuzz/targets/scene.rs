//! Scene files: any text gives a valid scene or an error with a message.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo::scene::Scene;
use std::path::Path;

fuzz_target!(|text: &str| {
    match Scene::parse(text, Path::new("scene.toml")) {
        Ok(mut scene) => {
            assert!(!scene.objects.is_empty());
            scene.set_budget(Some(0.5));
        }
        Err(error) => assert!(error.to_string().contains("scene.toml")),
    }
});
