//! Oracle with a cache, because every variant repeats the same queries.

use glam::DVec3;
use relievo::oracle::{Oracle, Sample};
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Maximum number of cached answers, about 80 bytes each.
const KEPT: usize = 4 << 20;
/// Number of cache shards, each with a lock to reduce contention.
const PARTS: usize = 64;

/// Oracle for one eye with cached answers.
pub struct Remembered<O> {
    oracle: O,
    parts: Vec<Mutex<HashMap<[u64; 3], Sample>>>,
}

impl<O: Oracle> Remembered<O> {
    /// Caches the answers of `oracle`.
    pub fn new(oracle: O) -> Remembered<O> {
        Remembered {
            oracle,
            parts: (0..PARTS).map(|_| Mutex::default()).collect(),
        }
    }
}

impl<O: Oracle> Oracle for Remembered<O> {
    /// Traces like the oracle; `eye` must be the same in every call.
    fn trace(&self, eye: DVec3, direction: DVec3) -> Sample {
        let key = direction.to_array().map(f64::to_bits);
        // Neighbours differ most in the low bits.
        let mixed = key.iter().fold(0u64, |mixed, bits| {
            (mixed ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        });
        let part = &self.parts[(mixed >> 58) as usize % PARTS];
        // Entries are complete even if a thread panicked.
        let lock = || part.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return *known;
        }
        let sample = self.oracle.trace(eye, direction);
        let mut known = lock();
        if known.len() < KEPT / PARTS {
            known.insert(key, sample);
        }
        sample
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Counts its calls.
    #[derive(Default)]
    struct Counting(AtomicU32);

    impl Oracle for Counting {
        fn trace(&self, _: DVec3, direction: DVec3) -> Sample {
            self.0.fetch_add(1, Ordering::Relaxed);
            Sample {
                class: 1,
                t: direction.x,
            }
        }
    }

    #[test]
    fn the_same_is_asked_once() {
        let oracle = Remembered::new(Counting::default());
        for _ in 0..3 {
            for i in 0..100 {
                let direction = DVec3::new(f64::from(i), 1.0, 0.0);
                assert_eq!(oracle.trace(DVec3::ZERO, direction).t, f64::from(i));
            }
        }
        assert_eq!(oracle.oracle.0.load(Ordering::Relaxed), 100);
    }
}
