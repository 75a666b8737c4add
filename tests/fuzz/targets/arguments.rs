//! Command lines: any words, one per line, are a command or a usage error.
//! Nothing is run.

#![no_main]

use clap::Parser;
use libfuzzer_sys::fuzz_target;

// The program's own parsers. Commands are not run.
#[allow(dead_code)]
#[path = "../../../host/program/src/cli/mod.rs"]
mod cli;

fuzz_target!(|text: &str| {
    let words = std::iter::once("relievo").chain(text.lines());
    if let Err(error) = cli::Arguments::try_parse_from(words) {
        assert!(!error.to_string().is_empty());
        assert!([0, 2].contains(&error.exit_code()));
    }
});
