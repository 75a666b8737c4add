//! Refusals: what is not exact, where, and what to write instead.

use crate::advice::Advice;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Names of entry points that are listed before the rest are counted.
const LISTED: usize = 3;

/// A place in the sources, as shown.
#[derive(Clone, Default, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Site {
    /// The user's file, line and column, if debug information has them. Two lines if only
    /// those before and after are known.
    pub at: Option<String>,
    /// The function that contains it.
    pub function: Option<String>,
    /// The source lines.
    pub code: Vec<String>,
    /// The place in a library that the user's line leads to.
    pub through: Option<String>,
}

/// What is refused in all modules of a crate, grouped by advice and place.
#[derive(Default, Debug)]
pub struct Refusals(BTreeMap<Advice, BTreeMap<Site, BTreeSet<String>>>);

impl Refusals {
    /// Adds what is refused at a place of an entry point.
    pub fn add(&mut self, entry_point: &str, advice: Advice, site: Site) {
        let sites = self.0.entry(advice).or_default();
        let entry_points = sites.entry(site).or_default();
        entry_points.insert(entry_point.to_string());
    }

    /// Returns whether nothing is refused.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns an error if something is refused.
    pub fn into_result(self) -> Result<(), Refusals> {
        if self.is_empty() { Ok(()) } else { Err(self) }
    }
}

impl fmt::Display for Refusals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not exact: devices may give other bits than the CPU")?;
        for (advice, sites) in &self.0 {
            write!(f, "\n\n{}: {}", advice.what, advice.why)?;
            for (site, entry_points) in sites {
                write!(f, "\n  {site}")?;
                write!(f, "\n    {}", list(entry_points))?;
            }
            write!(f, "\n  instead: {}", advice.instead)?;
        }
        Ok(())
    }
}

impl std::error::Error for Refusals {}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.at {
            Some(at) => write!(f, "at {at}")?,
            None => write!(f, "at a place that is not known")?,
        }
        if let Some(function) = &self.function {
            write!(f, ", in {function}")?;
        }
        for line in &self.code {
            write!(f, "\n    | {line}")?;
        }
        if let Some(through) = &self.through {
            write!(f, "\n    through {through}")?;
        }
        Ok(())
    }
}

/// Returns the names of entry points as a phrase.
fn list(entry_points: &BTreeSet<String>) -> String {
    let names: Vec<String> = entry_points
        .iter()
        .take(LISTED)
        .map(|name| format!("`{name}`"))
        .collect();
    let names = names.join(", ");
    match entry_points.len() {
        1 => format!("entry point {names}"),
        n if n <= LISTED => format!("entry points {names}"),
        n => format!("entry points {names} and {} more", n - LISTED),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::advice;

    #[test]
    fn places_are_grouped_by_advice_and_listed_once() {
        let mut refusals = Refusals::default();
        let site = |line| Site {
            at: Some(format!("src/lib.rs:{line}:1")),
            ..Site::default()
        };
        for name in ["e", "d", "c", "b", "a"] {
            refusals.add(name, advice::of_driver(13), site(7));
            refusals.add(name, advice::of_driver(13), site(7));
        }
        refusals.add("a", advice::of_driver(13), site(8));
        refusals.add("a", advice::of_instruction(140), Site::default());
        let text = refusals.into_result().unwrap_err().to_string();
        assert_eq!(
            text,
            "\
not exact: devices may give other bits than the CPU

`%` of floats (OpFRem): devices round it differently
  at a place that is not known
    entry point `a`
  instead: x - y * relievo_exact::trunc(relievo_exact::div(x, y))

`sin` of the driver (GLSL.std.450 Sin): devices round it differently
  at src/lib.rs:7:1
    entry points `a`, `b`, `c` and 2 more
  at src/lib.rs:8:1
    entry point `a`
  instead: relievo_exact::sin(x)"
        );
    }

    #[test]
    fn nothing_is_no_error() {
        Refusals::default().into_result().unwrap();
    }
}
