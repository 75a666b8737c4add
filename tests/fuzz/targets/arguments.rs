//! The command line: any words, one a line, are a command or an error that says
//! how it should be. Nothing is run.

#![no_main]

use clap::Parser;
use libfuzzer_sys::fuzz_target;

// The program's own parsers: what it does with them is not called here.
#[allow(dead_code)]
#[path = "../../../host/src/cli/mod.rs"]
mod cli;

fuzz_target!(|text: &str| {
    let words = std::iter::once("relievo").chain(text.lines());
    if let Err(error) = cli::Arguments::try_parse_from(words) {
        assert!(!error.to_string().is_empty());
        assert!([0, 2].contains(&error.exit_code()));
    }
});
