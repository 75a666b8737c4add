//! The tables, as a page.

use super::{Function, Row};
use std::fmt::Write;

/// The page, in Markdown: a table for each function, and whether it keeps its
/// bound. `command` made it, from `count` inputs a row.
pub fn page(measured: &[(&Function, Vec<Row>)], command: &str, count: usize) -> String {
    let mut text = format!(
        "# Error bounds\n\nWritten by `{command}`. Do not edit.\n\n\
         Each function of `relievo-shared` in f32 beside the same source in f64, which starts \
         from the same f32 numbers: {count} inputs a row, the same in every run. A row holds \
         the inputs for which the quantity named in its head is from the power of two at its \
         left up to the one of the next row. *Others* is the share of inputs with another \
         answer, such as another column met, because both are within a rounding error; errors \
         are those of the rest. 2⁻²⁴ = 6.0e-8 is what rounding to nearest allows.\n"
    );
    for (function, rows) in measured {
        let Function {
            name,
            over,
            relative_to,
            bound,
            others,
            ..
        } = function;
        // A bar would end the cell.
        let over = over.replace('|', "\\|");
        let kept = rows.iter().all(|row| function.holds(row));
        // Writing into a text cannot fail.
        let _ = write!(
            text,
            "\n## {name}\n\nRelative to {relative_to}. Bound: {bound:.1e}, others {others}: {}.\n\n\
             | {over}, from | inputs | others | median | worst |\n|---|---|---|---|---|\n",
            if kept { "kept" } else { "**NOT KEPT**" },
        );
        for row in rows {
            let _ = writeln!(
                text,
                "| 2^{} | {} | {} | {:.1e} | {:.1e} |",
                row.exponent,
                row.count,
                share(row.others),
                row.median,
                row.worst
            );
        }
    }
    text
}

fn share(part: f64) -> String {
    if part == 0.0 {
        "0".to_string()
    } else {
        format!("{part:.1e}")
    }
}
