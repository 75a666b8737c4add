//! Markdown page of the tables.

use super::{Function, Row};
use std::fmt::Write;

/// Writes a Markdown table for each function and whether it keeps its bound.
/// `command` is the command line, `count` the inputs per row.
pub fn page(measured: &[(&Function, Vec<Row>)], command: &str, count: usize) -> String {
    let mut text = format!(
        "# Error bounds\n\nWritten by `{command}`. Do not edit.\n\n\
         Each function of `relievo-shared` in f32, compared with the same source in f64, which \
         starts from the same f32 numbers: {count} inputs per row, the same in every run. A row \
         holds inputs for which the quantity in its header lies between the power of two at its \
         left and that of the next row. *Others* is the fraction of inputs with another discrete \
         result, such as another column, because both are within a rounding error; errors are \
         those of the rest. 2⁻²⁴ = 6.0e-8 is the error of rounding to nearest.\n"
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
        // Writing to a String cannot fail.
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
