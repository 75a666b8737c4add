//! Panics of others as errors: of wgpu above all.
//!
//! Where a driver fails, wgpu panics in places: in `Device::poll` once the
//! device is lost, in `wgpu-hal` where a render pass or a framebuffer cannot be
//! made. A lost device is no reason to end a program that can go on without.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

const UNKNOWN: &str = "no reason is known";

thread_local! {
    /// How many attempts this thread is in.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// What the last panic in one of them said.
    static SAID: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs `work` of `who`; where it panics, gives what the panic said.
///
/// What `work` leaves half done must not be used after that.
///
/// The first call puts a hook before the process's panic hook that keeps such
/// a panic off the terminal; every other panic goes to the hook that was there.
///
/// # Errors
/// What the panic said, where it was, and who gave up.
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
    fn a_panic_is_told_once_and_others_are_left_alone() {
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
