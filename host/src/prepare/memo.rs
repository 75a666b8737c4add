//! What was made for a scene, kept for the next one.

use std::sync::Arc;

/// Values by what they were made from: those that this scene uses, and those that the scene before
/// used.
pub(super) struct Memo<K, V> {
    used: Vec<(K, Arc<V>)>,
    before: Vec<(K, Arc<V>)>,
}

impl<K, V> Default for Memo<K, V> {
    fn default() -> Memo<K, V> {
        Memo {
            used: Vec::new(),
            before: Vec::new(),
        }
    }
}

impl<K: PartialEq, V> Memo<K, V> {
    /// Returns it for the next scene, without what this one did not use.
    pub(super) fn for_next(self) -> Memo<K, V> {
        Memo {
            used: Vec::new(),
            before: self.used,
        }
    }

    /// Returns the value that was made from `key`.
    pub(super) fn get(&mut self, key: &K) -> Option<Arc<V>> {
        let is_it = |(known, _): &(K, Arc<V>)| known == key;
        if let Some((_, value)) = self.used.iter().find(|known| is_it(known)) {
            return Some(value.clone());
        }
        let place = self.before.iter().position(is_it)?;
        let known = self.before.swap_remove(place);
        let value = known.1.clone();
        self.used.push(known);
        Some(value)
    }

    /// Keeps `value`, which was made from `key`.
    pub(super) fn insert(&mut self, key: K, value: V) -> Arc<V> {
        let value = Arc::new(value);
        self.used.push((key, value.clone()));
        value
    }
}

/// A thing that is equal to itself only.
pub(super) struct Same<T>(pub(super) Arc<T>);

impl<T> PartialEq for Same<T> {
    fn eq(&self, other: &Same<T>) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_kept_while_scenes_use_them() {
        let mut memo = Memo::default();
        let first = memo.insert("first", 1);
        memo.insert("second", 2);
        assert!(memo.get(&"third").is_none());
        let mut memo = memo.for_next();
        // Asked for twice.
        for _ in 0..2 {
            assert!(Arc::ptr_eq(&memo.get(&"first").unwrap(), &first));
        }
        let mut memo = memo.for_next();
        assert!(memo.get(&"second").is_none());
        assert!(memo.get(&"first").is_some());
    }
}
