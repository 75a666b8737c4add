//! The page `docs/registers.md`: its end is made from the table.

use relievo_shaders::Compiled;
use relievo_tests::root;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

/// The line of the page after which it is made.
const MARK: &str =
    "<!-- From assets/shaders/registers.csv: RELIEVO_UPDATE_GOLDEN=1 writes it. -->\n";

/// Columns of the page: their names, and what they show.
type Column = (&'static str, fn(&Compiled) -> String);
const COLUMNS: [Column; 6] = [
    ("VGPRs", |row| row.vgprs.to_string()),
    ("SGPRs", |row| row.sgprs.to_string()),
    ("spilled", |row| match row.spills() {
        true => format!("{} + {}", row.spilled_vgprs, row.spilled_sgprs),
        false => "–".to_string(),
    }),
    ("waves", |row| row.waves.to_string()),
    ("instructions", |row| row.instructions.to_string()),
    ("latency", |row| row.latency.to_string()),
];

/// The end of the page.
fn end(table: &str) -> String {
    let mut generations: BTreeMap<&str, BTreeMap<&str, Vec<Compiled>>> = BTreeMap::new();
    for row in Compiled::rows(table) {
        let shaders = generations.entry(row.generation).or_default();
        shaders.entry(row.entry_point).or_default().push(row);
    }
    let mut text = String::new();
    for (generation, shaders) in generations {
        write!(text, "\n### {generation}\n\n| shader |").unwrap();
        for (name, _) in COLUMNS {
            write!(text, " {name} |").unwrap();
        }
        writeln!(text, "\n|---|{}", "---|".repeat(COLUMNS.len())).unwrap();
        for (name, rows) in shaders {
            write!(text, "| {name} |").unwrap();
            for (_, show) in COLUMNS {
                let values: Vec<String> = rows.iter().map(show).collect();
                write!(text, " {} |", values.join(" · ")).unwrap();
            }
            text.push('\n');
        }
    }
    text
}

/// The page, what it should be and what it is.
pub fn pages(table: &str) -> (String, String) {
    let page = fs::read_to_string(path()).unwrap().replace("\r\n", "\n");
    let (begin, _) = page.split_once(MARK).expect("the page has the mark");
    (format!("{begin}{MARK}{}", end(table)), page)
}

/// Its file.
pub fn path() -> PathBuf {
    root().join("docs/registers.md")
}
