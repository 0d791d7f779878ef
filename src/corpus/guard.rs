//! Calls into the Parquet reader: a damaged file may make it panic, which is then an error like any other.

use super::error::CorpusError;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

thread_local! {
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

/// Whether this thread is inside a call whose panics become errors: a panic hook that ends the program must let
/// them pass, and stay silent.
pub fn in_guarded_call() -> bool {
    DEPTH.get() > 0
}

/// Runs a call into the Parquet reader; a panic in it becomes [`CorpusError::Damaged`].
pub(super) fn guarded<T>(path: &Path, call: impl FnOnce() -> Result<T, CorpusError>) -> Result<T, CorpusError> {
    struct Deeper;
    impl Drop for Deeper {
        fn drop(&mut self) {
            DEPTH.set(DEPTH.get() - 1);
        }
    }
    DEPTH.set(DEPTH.get() + 1);
    let deeper = Deeper;
    let result = catch_unwind(AssertUnwindSafe(call));
    drop(deeper);
    result.unwrap_or_else(|panic| {
        let message = panic.downcast_ref::<String>().map(String::as_str);
        let message = message.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Err(CorpusError::damaged(path, format!("the Parquet reader gave up: {message}")))
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_and_the_flag_goes_down() {
        let error = guarded::<()>(Path::new("x"), || {
            assert!(in_guarded_call());
            panic!("slice {}", 3)
        });
        assert!(error.unwrap_err().to_string().ends_with("slice 3"));
        assert!(!in_guarded_call());
    }
}
