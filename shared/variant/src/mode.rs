//! What the float operations do, on the calling thread.

use std::cell::Cell;

/// What the float operations do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// What the sources say.
    Exact,
    /// A product and the sum around it are rounded once, as a compiler may do
    /// that contracts.
    Fused,
    /// Denormal operands and results become zeros of the same sign.
    FlushToZero,
    /// Quotients and roots are off by up to this many ULP, pseudo-randomly but
    /// equally for equal operands.
    DivisionOff(u8),
    /// Results are rounded towards zero, as where RoundingModeRTE is not offered.
    TowardZero,
}

/// What the operations of a thread do. Each operation reads it once.
#[derive(Clone, Copy)]
pub(crate) struct Setting {
    pub mode: Mode,
    /// Whether operations are audited.
    pub is_audited: bool,
}

thread_local! {
    static SETTING: Cell<Setting> = const {
        Cell::new(Setting {
            mode: Mode::Exact,
            is_audited: false,
        })
    };
}

/// The setting of this thread.
#[inline]
pub(crate) fn setting() -> Setting {
    SETTING.get()
}

/// Turns the audit of this thread's operations on or off.
pub(crate) fn set_audited(is_audited: bool) {
    SETTING.set(Setting {
        is_audited,
        ..setting()
    });
}

/// Changes the mode of this thread; returns the mode before.
fn replace_mode(mode: Mode) -> Mode {
    let before = setting();
    SETTING.set(Setting { mode, ..before });
    before.mode
}

/// Calls `work` in `mode`. Threads that it starts are in [`Mode::Exact`].
pub fn with_mode<T>(mode: Mode, work: impl FnOnce() -> T) -> T {
    /// Puts the mode back, also when `work` panics.
    struct Restore(Mode);
    impl Drop for Restore {
        fn drop(&mut self) {
            replace_mode(self.0);
        }
    }
    let _restore = Restore(replace_mode(mode));
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode() -> Mode {
        setting().mode
    }

    #[test]
    fn modes_nest_and_end() {
        let modes = with_mode(Mode::Fused, || {
            let inner = with_mode(Mode::FlushToZero, mode);
            let caught = std::panic::catch_unwind(|| with_mode(Mode::TowardZero, || panic!()));
            assert!(caught.is_err());
            (inner, mode(), std::thread::spawn(mode).join().unwrap())
        });
        assert_eq!(modes, (Mode::FlushToZero, Mode::Fused, Mode::Exact));
        assert_eq!(mode(), Mode::Exact);
    }
}
