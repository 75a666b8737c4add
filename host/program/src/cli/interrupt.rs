//! Removes incomplete files when the program is interrupted.

/// Installs handlers for ctrl-C and SIGTERM that remove incomplete files before exiting. Does
/// nothing on systems without signals.
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

        // Caught, so that a write beyond the file size limit fails with an error instead.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
        // The program works without signals.
        let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else {
            return;
        };
        // A second signal exits at once, even if a file system hangs.
        let is_told = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            let _ = flag::register_conditional_default(signal, is_told.clone());
            let _ = flag::register(signal, is_told.clone());
        }
        std::thread::spawn(move || {
            if let Some(signal) = signals.forever().next() {
                // The shell must see that a signal ended the program.
                abandon(|| drop(emulate_default_handler(signal)));
            }
        });
    }
}
