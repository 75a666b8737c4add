//! Names of kernels: of two with one name, the shaders have only one.

use std::collections::BTreeMap;
use std::panic::Location;
use std::sync::{Mutex, PoisonError};

/// Panics if a kernel of this name was compared from elsewhere.
#[track_caller]
pub(crate) fn check(name: &'static str, place: &'static Location<'static>) {
    static PLACES: Mutex<BTreeMap<&str, &Location>> = Mutex::new(BTreeMap::new());
    let mut places = PLACES.lock().unwrap_or_else(PoisonError::into_inner);
    let first = *places.entry(name).or_insert(place);
    drop(places);
    assert!(
        first == place,
        "two kernels are named {name}, at {first} and {place}; rename one"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_belongs_to_one_place() {
        let (here, there) = (Location::caller(), line!());
        check("tested", here);
        check("tested", here);
        let again = std::panic::catch_unwind(|| {
            #[track_caller]
            fn place() -> &'static Location<'static> {
                Location::caller()
            }
            check("tested", place());
        });
        let message = again.unwrap_err();
        let message = message.downcast_ref::<String>().unwrap();
        assert!(
            message.contains("two kernels are named tested"),
            "{message}, {there}"
        );
    }
}
