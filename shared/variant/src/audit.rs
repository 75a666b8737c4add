//! Which operations leave the range of values that every device keeps.

use crate::Site;
use crate::mode::{set_audited, setting};
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

/// Smallest magnitude, except 0, of quotients, roots and their operands: 2⁻⁶⁰.
const LOW: f32 = f32::from_bits((127 - 60) << 23);
/// Largest magnitude of quotients, roots and their operands: 2⁶⁰.
const HIGH: f32 = f32::from_bits((127 + 60) << 23);

/// How an operation leaves the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Problem {
    /// The result is no number.
    NotANumber,
    /// The result is infinite.
    Infinite,
    /// The result is denormal.
    Denormal,
    /// An operand or the result of a quotient or root has a magnitude outside
    /// 2⁻⁶⁰…2⁶⁰ and is not 0.
    OutOfRange,
}

/// An operation that has left the range.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Where it stands.
    pub site: Site,
    /// Who called the function of `arithmetic.rs` that it stands in.
    pub caller: Option<Site>,
    /// What is wrong.
    pub problem: Problem,
    /// How often.
    pub count: u64,
    /// The operation, its operands and its result, the first time.
    pub example: String,
}

type Table = BTreeMap<(Site, Option<Site>, Problem), (u64, String)>;

thread_local! {
    static CALLER: Cell<Option<Site>> = const { Cell::new(None) };
    static TABLE: RefCell<Table> = const { RefCell::new(BTreeMap::new()) };
}

/// Calls `work` and returns what it returns, and the operations on this thread
/// that have left the range, in the order of their sites. In
/// [`crate::Mode::Exact`] it changes no result.
pub fn audited<T>(work: impl FnOnce() -> T) -> (T, Vec<Finding>) {
    TABLE.take();
    set_audited(true);
    let result = work();
    set_audited(false);
    let findings = TABLE
        .take()
        .into_iter()
        .map(|((site, caller, problem), (count, example))| Finding {
            site,
            caller,
            problem,
            count,
            example,
        })
        .collect();
    (result, findings)
}

/// Calls `work` on behalf of `site`.
#[inline]
pub(crate) fn called_at<T>(site: Site, work: impl FnOnce() -> T) -> T {
    if !setting().is_audited {
        return work();
    }
    let before = CALLER.replace(Some(site));
    let result = work();
    CALLER.set(before);
    result
}

/// Looks at an operation's result; at its operands too where `is_narrow`.
#[cold]
pub(crate) fn look(name: &str, operands: &[f32], result: f32, is_narrow: bool, site: Site) {
    let is_outside = |x: f32| x != 0.0 && !(LOW..=HIGH).contains(&x.abs());
    let problem = if result.is_nan() {
        Problem::NotANumber
    } else if result.is_infinite() {
        Problem::Infinite
    } else if result.is_subnormal() {
        Problem::Denormal
    } else if is_narrow && (is_outside(result) || operands.iter().any(|&x| is_outside(x))) {
        Problem::OutOfRange
    } else {
        return;
    };
    TABLE.with_borrow_mut(|table| {
        let (count, _) = table
            .entry((site, CALLER.get(), problem))
            .or_insert_with(|| (0, format!("{name} {operands:?} = {result:e}")));
        *count += 1;
    });
}
