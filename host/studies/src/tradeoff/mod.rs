//! Cost and error of rendering choices: draws a scene in many variants, times
//! each, compares it with the truth, and finds the Pareto front.
//!
//! ```text
//! variant       settings and renderer, and their name
//! subject       a scene to vary
//! grid          the variants of a sweep, split into shards
//! ground_truth  the truth, and errors against it
//! measure       cost and error of one variant
//! record        measurement files that survive interruptions
//! sweep         measures the missing variants of a shard
//! report        all measurements, and their Pareto fronts
//! effects       effect of changing one axis alone
//! chart, page   the report as SVG and PNG, and as Markdown
//! ```

mod chart;
mod effects;
mod grid;
mod ground_truth;
mod measure;
mod page;
mod pareto;
mod raster;
mod record;
mod remembered;
mod report;
mod subject;
mod sweep;
mod variant;

pub use grid::{Grid, Shard, part, reference, variants};
pub use ground_truth::Errors;
pub use measure::Measurement;
pub use page::Asked;
pub use pareto::front;
pub use raster::png;
pub use record::{FORMAT, Header, Machine, Outcome, Record, Store};
pub use report::{Metric, Report, Row};
pub use subject::Subject;
pub use sweep::{Devices, Progress, sweep};
pub use variant::{Axis, Class, Model, Rendering, SelfShadow, Settings, Steps, Variant};

#[cfg(test)]
mod tests {
    use super::Subject;
    use relievo::scene::Scene;
    use std::path::Path;

    /// Returns a torus with discs and `keys`, 32 × 24 pixels.
    pub fn subject(keys: &str) -> Subject {
        let text = format!(
            "[image]\nsize = [32, 24]\n[camera]\neye = [0.0, 2.3, 3.4]\nfov = 38.0\n[[object]]\nmesh = \"../meshes/torus.obj\"\nshape = \"../patterns/discs.png\"\nrepeat = [24, 10]\ndepth = 0.08\n{keys}\n"
        );
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/test.toml");
        Subject::new(Scene::parse(&text, &path).unwrap()).unwrap()
    }
}
