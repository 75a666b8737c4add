//! How long frames take: measurements, their statistics, and their tables and
//! plots. Nothing here judges a time; machines differ.

mod plan;
mod plot;
mod report;
mod statistics;
mod table1;

pub use plan::{Method, PatternRow, ROWS, Surface, Technique};
pub use statistics::Summary;
pub use table1::{Backend, Cell, Clock, Run, Table1, measure};
