//! Turns panics of a library, above all wgpu, into errors.
//!
//! If a driver fails, wgpu panics in some places: in `Device::poll` once the
//! device is lost, in `wgpu-hal` if a render pass or framebuffer cannot be made.
//! A program that can continue without the device should not end there.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

const UNKNOWN: &str = "no reason is known";

thread_local! {
    /// Number of nested attempts on this thread.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// Message of the last panic in one of them.
    static SAID: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs `work` and returns a panic in it as an error that names `who`.
///
/// State that `work` leaves half changed must not be used after an error.
///
/// The first call installs a panic hook that keeps these panics off the terminal
/// and passes every other panic to the previous hook.
///
/// # Errors
/// The message and location of the panic.
///
/// ```
/// use relievo_bitwise::attempt;
///
/// assert_eq!(attempt("the parser", || 7), Ok(7));
/// let error = attempt("the parser", || -> u32 { panic!("no input") }).unwrap_err();
/// assert!(error.starts_with("the parser gave up: no input"));
/// ```
pub fn attempt<T>(who: &str, work: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if DEPTH.get() == 0 {
                return before(info);
            }
            let payload = info.payload();
            let said = match (payload.downcast_ref::<&str>(), payload.downcast_ref()) {
                (Some(said), _) => said,
                (None, Some(said)) => String::as_str(said),
                (None, None) => UNKNOWN,
            };
            let said = said.trim();
            let place = info.location().map_or(String::new(), |location| {
                let file = location.file().rsplit(['/', '\\']).next();
                format!(" ({}, line {})", file.unwrap_or_default(), location.line())
            });
            SAID.set(Some(format!("{said}{place}")));
        }));
    });
    DEPTH.set(DEPTH.get() + 1);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    DEPTH.set(DEPTH.get() - 1);
    result.map_err(|_| {
        let said = SAID.take();
        format!("{who} gave up: {}", said.as_deref().unwrap_or(UNKNOWN))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_returned_once_and_others_are_left_alone() {
        let said = |result: Result<(), String>| result.unwrap_err();
        assert_eq!(attempt("wgpu", || 7), Ok(7));
        let inner = attempt("all", || attempt("wgpu", || panic!("inner {}", 1)))
            .expect("it was caught inside");
        assert!(said(inner).starts_with("wgpu gave up: inner 1 (attempt.rs, line "));
        let outer = attempt("wgpu", || {
            let _ = attempt("nobody", || ());
            panic!("outer");
        });
        assert!(said(outer).starts_with("wgpu gave up: outer (attempt.rs"));
        assert_eq!(DEPTH.get(), 0);
        assert!(SAID.take().is_none());
    }
}
