//! One binary for all integration tests: one module per promise.
#![expect(clippy::unwrap_used, reason = "tests")]

mod adaptive;
mod bandai;
mod captures;
mod cli;
mod contacts;
mod corpus;
mod corpus_samples;
mod corpus_tables;
mod dataflow;
mod evaluate;
mod front_page;
mod frozen_reference;
mod gaits;
mod golden;
mod grafts;
mod growth;
mod hostile;
mod house;
mod inputs;
mod invariances;
mod joint_limits;
mod motion;
mod pass_shares;
mod plain_reader;
mod plan_hostile;
mod plan_mistakes;
mod plans;
mod positions;
mod procedural;
mod quirks;
mod round_trip;
mod running;
mod shared_data;
mod tree;
mod truth;
