//! Small statistics of a series, as numpy defines them.

use core::f64::consts::{PI, TAU};

/// Central differences, one-sided at the ends, per step. Fewer than two values: zeros.
pub fn gradient(values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|n| match n {
            _ if last == 0 => 0.0,
            0 => values[1] - values[0],
            _ if n == last => values[last] - values[last - 1],
            _ => (values[n + 1] - values[n - 1]) / 2.0,
        })
        .collect()
}

/// The value below which `percent` of the values lie, linear between neighbors. None: no values.
pub fn percentile(values: &[f64], percent: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (percent / 100.0 * last as f64).clamp(0.0, last as f64);
    let below = at as usize;
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    let share = at - below as f64;
    Some(if share >= 0.5 { high - (high - low) * (1.0 - share) } else { low + (high - low) * share })
}

/// The middle value, or the mean of the two middle ones. None: no values.
pub fn median(values: &[f64]) -> Option<f64> {
    percentile(values, 50.0)
}

/// The mean; 0 of nothing.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// Root of the mean squared distance from the mean (of all values, not of a sample).
pub fn standard_deviation(values: &[f64]) -> f64 {
    let middle = mean(values);
    mean(&values.iter().map(|value| (value - middle) * (value - middle)).collect::<Vec<_>>()).sqrt()
}

/// Angles without jumps of a whole turn, radians: steps of more than half a turn are taken the other way round.
pub fn unwrap_phase(angles_rad: &[f64]) -> Vec<f64> {
    let mut correction = 0.0;
    let mut previous = angles_rad.first().copied().unwrap_or(0.0);
    angles_rad
        .iter()
        .map(|&angle| {
            let step = angle - previous;
            previous = angle;
            if step.abs() >= PI {
                let mut short = (step + PI).rem_euclid(TAU) - PI;
                if short == -PI && step > 0.0 {
                    short = PI;
                }
                correction += short - step;
            }
            angle + correction
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_equal_numpy() {
        assert_eq!(gradient(&[1.0, 4.0, 9.0, 7.0, 2.0]), [3.0, 4.0, 1.5, -3.5, -5.0]);
        let values = [3.0, 1.0, 2.0, 10.0];
        for (percent, expected) in [(0.0, 1.0), (10.0, 1.3), (50.0, 2.5), (90.0, 7.9), (100.0, 10.0)] {
            assert!((percentile(&values, percent).unwrap_or(f64::NAN) - expected).abs() < 1e-14, "{percent}");
        }
        assert_eq!(percentile(&[], 10.0), None);
        assert_eq!(median(&[4.0, 1.0, 3.0]), Some(3.0));
        assert!((standard_deviation(&[1.0, 2.0, 3.0, 4.0]) - 1.25_f64.sqrt()).abs() < 1e-15);
        let unwrapped = unwrap_phase(&[0.0, 2.9, -2.9, -0.1, 3.1, -3.1, 3.0, TAU]);
        let expected = [0.0, 2.9, 3.3831853071795863, 6.183185307179587, 3.1, 3.183185307179586, 3.0, 0.0];
        assert!(unwrapped.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{unwrapped:?}");
    }
}
