//! Reports the accuracy of a rendering, as text and as JSON.

use super::{Accuracy, CLASS_NAMES};
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;

/// Accuracy of a rendering of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneReport {
    /// The scene file.
    pub scene: PathBuf,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// The renderer's name.
    pub renderer: String,
    /// Tier and shape of each object.
    pub objects: Vec<String>,
    /// The measurements.
    pub accuracy: Accuracy,
}

impl fmt::Display for SceneReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let accuracy = &self.accuracy;
        writeln!(
            f,
            "{}: {} × {} pixels, {}, {}",
            self.scene.display(),
            self.size[0],
            self.size[1],
            self.objects.join(", "),
            self.renderer
        )?;
        writeln!(
            f,
            "  silhouette IoU {:.5}; holes {}, of which interior {}; extra pixels {}",
            accuracy.silhouette_iou, accuracy.holes, accuracy.interior_holes, accuracy.extra
        )?;
        writeln!(
            f,
            "  distance RMSE {:.3e}, 99th percentile {:.3e} world units; class differs in {:.3} % of the pixels hit in both",
            accuracy.distance_rmse,
            accuracy.distance_p99,
            100.0 * accuracy.class_errors
        )?;
        write!(f, "  {:>14}", "truth \\ found")?;
        for name in CLASS_NAMES {
            write!(f, "{name:>9}")?;
        }
        for (name, row) in CLASS_NAMES.iter().zip(accuracy.confusion) {
            write!(f, "\n  {name:>14}")?;
            for count in row {
                write!(f, "{count:>9}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_a_row_for_each_class_of_the_truth() {
        let report = SceneReport {
            scene: PathBuf::from("a.toml"),
            size: [4, 3],
            renderer: "CPU".to_string(),
            objects: vec!["fast torus".to_string()],
            accuracy: Accuracy {
                silhouette_iou: 0.98765,
                holes: 12,
                interior_holes: 3,
                extra: 45,
                distance_rmse: 0.001,
                distance_p99: 0.02,
                class_errors: 0.5,
                confusion: [
                    [1, 2, 3, 4],
                    [5, 6, 7, 8],
                    [9, 10, 11, 12],
                    [13, 14, 15, 16],
                ],
            },
        };
        let text = report.to_string();
        let last: Vec<&str> = text.lines().last().unwrap().split_whitespace().collect();
        assert_eq!(last, ["floor", "13", "14", "15", "16"]);
        for part in ["0.98765", "holes 12, of which interior 3", "50.000 %"] {
            assert!(text.contains(part), "{text}");
        }
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["accuracy"]["confusion"][1][0], 5);
    }
}
