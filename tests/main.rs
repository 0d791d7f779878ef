//! One binary for all integration tests: one module per promise.
#![expect(clippy::unwrap_used, reason = "tests")]
#![expect(dead_code, reason = "until the first tests use the references")]

mod shared_data;
