//! Drawings: strips of stick figures, plots.
