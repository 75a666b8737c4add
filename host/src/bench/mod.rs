//! How long frames take: measurements, their statistics, and their tables and
//! plots. Nothing here judges a time; machines differ.

mod plan;
mod plot;
mod report;
mod statistics;
mod table1;
mod timed;

pub use plan::{Method, PatternRow, ROWS, Surface, Technique};
pub(crate) use report::{quoted, significant, write_aligned};
pub use statistics::Summary;
pub use table1::{Cell, Run, Table1, measure};
pub use timed::{Backend, Clock, Timed};
