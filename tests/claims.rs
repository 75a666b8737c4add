//! Proves what README claims: GPU words equal CPU words, pictures equal the golden
//! ones and agree with the oracle, the program works as documented, and malformed
//! input ends in an error.
//!
//! `tests/run` runs this and the unit tests of the shared mathematics. It is a
//! test of the program's package, so that cargo builds the program beside it.

mod agreement;
mod desk;
mod golden;
mod hostile;
mod jobs;
mod layers;
mod oracle;
mod program;

use std::path::Path;

/// Returns the path of the program.
fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_relievo"))
}

/// Returns the feature that `arguments` need and this build of the program leaves
/// out.
fn left_out(arguments: &str) -> Option<&'static str> {
    match arguments.split_whitespace().next() {
        Some("view") if cfg!(not(feature = "viewer")) => Some("viewer"),
        Some("bench" | "bounds" | "gallery" | "report" | "tradeoff")
            if cfg!(not(feature = "studies")) =>
        {
            Some("studies")
        }
        _ => None,
    }
}
