//! New clips from the ones that are there: chains, correlation, grafts, recipes, and the judge.

pub mod tables;

pub use tables::{Figure, Made, ProvenanceRow, Recipe};
