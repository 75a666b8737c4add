//! Ends the program when it is told to, and leaves no half of a file.

/// From now on, ctrl-C (and SIGTERM) first removes what is being written. Does
/// nothing where there are no signals.
pub fn watch() {
    #[cfg(unix)]
    {
        use relievo::file::abandon;
        use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
        use signal_hook::flag;
        use signal_hook::iterator::Signals;
        use signal_hook::low_level::emulate_default_handler;
        use std::sync::Arc;
        use std::sync::atomic::AtomicBool;

        // A file that may not grow is then told by the write that fails.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
        // Where signals cannot be had, the program works without.
        let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else {
            return;
        };
        // Whoever says it twice does not wait for a file system that hangs.
        let is_told = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            let _ = flag::register_conditional_default(signal, is_told.clone());
            let _ = flag::register(signal, is_told.clone());
        }
        std::thread::spawn(move || {
            if let Some(signal) = signals.forever().next() {
                // The shell is to see that it was a signal.
                abandon(|| drop(emulate_default_handler(signal)));
            }
        });
    }
}
