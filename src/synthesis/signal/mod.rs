//! Signals over time: the low-pass, the interpolant and the transforms that correlation and judge are defined with.
//!
//! Definitions are those of the field's common tools, so that a figure can be checked with them: what `scipy.signal.butter`
//! with `sosfiltfilt`, `scipy.interpolate.PchipInterpolator`, `scipy.signal.hilbert` and numpy's `unwrap`, `gradient` and
//! `percentile` give. Every transcendental comes from `libm`: the same bits on every machine.

pub mod butterworth;
pub mod fourier;
pub mod pchip;
pub mod sequence;

pub use butterworth::{lowpass, lowpass_points};
pub use fourier::{analytic, spectrum};
pub use pchip::Pchip;
pub use sequence::{gradient, mean, median, percentile, standard_deviation, unwrap_phase};

/// A signal for tests, also made in the Python that gave the golden numbers:
/// `((7 k k + 3 k) % 31) / 31 - 0.4 + 0.01 k`.
#[cfg(test)]
pub(crate) fn saw(length: usize) -> Vec<f64> {
    (0..length).map(|k| ((7 * k * k + 3 * k) % 31) as f64 / 31.0 - 0.4 + 0.01 * k as f64).collect()
}
