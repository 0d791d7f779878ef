//! Medians and percentiles, in linear time.

use glam::DVec3;

/// The middle value; of an even number the mean of the two in the middle. None of nothing. Reorders `values`.
pub fn median(values: &mut [f64]) -> Option<f64> {
    percentile(values, 50.0)
}

/// The value below which `percent` of the values lie, linear between neighbors (the first value is 0 %, the last
/// 100 %). None of nothing. Reorders `values`.
pub fn percentile(values: &mut [f64], percent: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let place = (percent / 100.0).clamp(0.0, 1.0) * last as f64;
    let (_, &mut low, above) = values.select_nth_unstable_by(place.floor() as usize, f64::total_cmp);
    let part = place - place.floor();
    match above.iter().copied().min_by(f64::total_cmp) {
        Some(high) if part > 0.0 => Some(low * (1.0 - part) + high * part),
        _ => Some(low),
    }
}

/// A robust standard deviation is this many median absolute deviations.
const DEVIATION_IN_MAD: f64 = 1.4826;

/// The standard deviation that normal values have whose absolute distances from their middle these are, whatever the
/// outliers. None of nothing. Reorders `away`.
pub fn robust_deviation(away: &mut [f64]) -> Option<f64> {
    Some(DEVIATION_IN_MAD * median(away)?)
}

/// The median of each coordinate; the origin of nothing.
pub fn coordinate_medians(points: &[DVec3]) -> DVec3 {
    let mut coordinate = vec![0.0; points.len()];
    DVec3::from_array([0, 1, 2].map(|axis| {
        for (value, point) in coordinate.iter_mut().zip(points) {
            *value = point[axis];
        }
        median(&mut coordinate).unwrap_or(0.0)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_percentiles_of_small_sets() {
        assert_eq!(median(&mut []), None);
        assert_eq!(median(&mut [4.0]), Some(4.0));
        assert_eq!(median(&mut [9.0, 1.0, 4.0]), Some(4.0));
        assert_eq!(median(&mut [9.0, 1.0, 4.0, 2.0]), Some(3.0));
        let mut hundred: Vec<f64> = (0..101).rev().map(f64::from).collect();
        assert_eq!(percentile(&mut hundred, 2.0), Some(2.0));
        assert_eq!(percentile(&mut [10.0, 20.0], 25.0), Some(12.5));
        assert_eq!(percentile(&mut [10.0, 20.0], 100.0), Some(20.0));
    }
}
