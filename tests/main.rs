//! One binary for all integration tests: one module per promise.
#![expect(clippy::unwrap_used, reason = "tests")]

mod bandai;
mod contacts;
mod gaits;
mod golden;
mod captures;
mod hostile;
mod grafts;
mod positions;
mod quirks;
mod round_trip;
mod procedural;
mod motion;
mod plain_reader;
mod inputs;
mod plan_hostile;
mod plan_mistakes;
mod plans;
mod procedural;
mod shared_data;
mod tree;
