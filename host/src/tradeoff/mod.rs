//! What every choice costs and what it buys: a scene is drawn in many variants,
//! each is timed and compared with the truth, and those that nothing beats are
//! told from the rest.
//!
//! ```text
//! subject   a scene, and what of it can be varied
//! variant   one value for each axis, and its name
//! grid      which variants there are, split into shards
//! judge     the truth, and how far words are from it
//! measure   one variant: cost and error
//! record    a file of measurements that survives an interruption
//! sweep     what is missing of a shard, measured
//! report    all measurements together, and which variants nothing beats
//! effects   what changing one axis alone does
//! chart     the report as SVG and PNG       page  the report for a person
//! ```

mod chart;
mod effects;
mod grid;
mod judge;
mod measure;
mod page;
mod pareto;
mod perceptual;
mod raster;
mod record;
mod remembered;
mod report;
mod subject;
mod sweep;
mod variant;

pub use grid::{Grid, Shard, part, reference, variants};
pub use measure::{Errors, Measurement};
pub use page::Asked;
pub use pareto::front;
pub use perceptual::difference;
pub use raster::png;
pub use record::{FORMAT, Header, Machine, Outcome, Record, Store};
pub use report::{Metric, Report, Row};
pub use subject::Subject;
pub use sweep::{Devices, Progress, sweep};
pub use variant::{Axis, Class, Model, Rendering, SelfShadow, Settings, Steps, Variant};

#[cfg(test)]
mod tests {
    use super::Subject;
    use crate::scene::Scene;
    use std::path::Path;

    /// A torus with discs and `keys`, 32 × 24 pixels.
    pub fn subject(keys: &str) -> Subject {
        let text = format!(
            "[image]\nsize = [32, 24]\n[camera]\neye = [0.0, 2.3, 3.4]\nfov = 38.0\n[[object]]\nmesh = \"../meshes/torus.obj\"\nshape = \"../patterns/discs.png\"\nrepeat = [24, 10]\ndepth = 0.08\n{keys}\n"
        );
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/test.toml");
        Subject::new(Scene::parse(&text, &path).unwrap()).unwrap()
    }
}
