//! Drawings as SVG text: strips of stick figures.

pub mod strip;

pub use strip::{Layout, Strip, View, spread, strips};
