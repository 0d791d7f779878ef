//! Drawings as SVG text: strips of stick figures, and a clip's feet and gait plotted over time.

mod canvas;
mod columns;
mod panels;
pub mod plot;
pub mod strip;

pub use plot::{Plot, plot};
pub use strip::{Layout, Strip, View, spread, strips};
