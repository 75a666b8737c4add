//! Everything beyond the claims that needs no window and no browser: extremes,
//! precision, devices that fail, exports, and the sources themselves.

mod accurate;
mod api;
mod budget;
#[allow(dead_code)] // The claims use all of it.
mod desk;
mod device;
mod docs;
#[path = "export/main.rs"]
mod export;
#[path = "extremes/main.rs"]
mod extremes;
mod instances;
mod naive;
mod precision;
mod real;
#[path = "registers/main.rs"]
mod registers;
mod sources;
mod specialization;
mod structure;
mod techniques;
mod torture;
mod twins;
mod validation;
mod variants;

use relievo_tests::program;

/// The program of these tests has every command.
fn left_out(_: &str) -> Option<&'static str> {
    None
}
