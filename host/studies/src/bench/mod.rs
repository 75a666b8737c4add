//! Frame times: measurement, statistics, tables and plots. Times are never
//! tested against a limit; machines differ.

mod plan;
mod plot;
mod report;
mod scaling;
mod statistics;
mod table1;
mod timed;

pub use plan::{Method, PatternRow, ROWS, Surface};
pub(crate) use report::{quoted, significant, write_aligned};
pub use scaling::{Number, Row, Scaling, scaling};
pub use statistics::Summary;
pub use table1::{Cell, Run, Table1, measure};
pub(crate) use timed::fitting;
pub use timed::{Backend, Clock, Timed};
