//! Motionmill turns a folder of motion captures into a corpus: Parquet tables of every frame, a cluster
//! graph of where each clip can turn into another, and new clips grafted from the ones that are there.
//!
//! The rooms, in reading order. An arrow means "knows of": the pure rooms hold types and algorithms (values
//! in, values out; no files, clocks or printing), `corpus`, `plan` and `inputs` touch the world, `flow` wires
//! everything as timely dataflows, `cli` talks to people. `tests/house.rs` enforces the directions.
//!
//! ```text
//! motion <- formats procedural annotate <- cluster <- synthesis      (evaluate, picture beside them)
//!                                                    corpus plan inputs <- flow <- cli
//! ```
//!
//! Invariants: SI units (metres, seconds, radians), Y up and right-handed everywhere past kinematics; `f32` in
//! tables, `f64` where a decision is made; nothing written depends on a worker, a clock, a hash seed or a path.

pub mod motion;

pub mod annotate;
pub mod formats;
pub mod procedural;

pub mod cluster;
pub mod synthesis;

pub mod evaluate;
pub mod picture;

pub mod corpus;
pub mod inputs;
pub mod plan;

pub mod flow;

pub mod cli;
