//! How far found times are from true ones: mean, standard deviation, count.

/// Errors in time, summed. Positive: found after it was true.
///
/// Each is kept in whole microseconds, so that the sums, and all that is computed from them, are the same in whatever
/// order errors are added and sums are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimeErrors {
    n: u64,
    sum_us: i128,
    /// Of squares, square microseconds.
    sum_us2: i128,
}

/// Beyond this, about 11 days, an error is cut off: squares of as many as fit a corpus can be summed.
const MOST_US: f64 = 1e12;

impl TimeErrors {
    /// Adds found time minus true time, seconds, to the nearest microsecond. What is no number is left out.
    pub fn add(&mut self, error_s: f64) {
        if error_s.is_nan() {
            return;
        }
        let error_us = (error_s * 1e6).round().clamp(-MOST_US, MOST_US) as i128;
        self.n += 1;
        self.sum_us = self.sum_us.saturating_add(error_us);
        self.sum_us2 = self.sum_us2.saturating_add(error_us * error_us);
    }

    /// Adds the errors of another sum.
    pub fn merge(&mut self, other: &TimeErrors) {
        self.n += other.n;
        self.sum_us = self.sum_us.saturating_add(other.sum_us);
        self.sum_us2 = self.sum_us2.saturating_add(other.sum_us2);
    }

    /// How many errors there are.
    pub fn count(&self) -> u64 {
        self.n
    }

    /// Mean, ms. None: there is no error.
    pub fn mean_ms(&self) -> Option<f64> {
        (self.n > 0).then(|| self.sum_us as f64 / self.n as f64 / 1e3)
    }

    /// Standard deviation of a sample (over n - 1), ms. None below two errors.
    pub fn sd_ms(&self) -> Option<f64> {
        if self.n < 2 {
            return None;
        }
        let n = i128::from(self.n);
        let exact = || n.checked_mul(self.sum_us2)?.checked_sub(self.sum_us.checked_mul(self.sum_us)?);
        let spread = match exact() {
            Some(spread) => spread as f64,
            None => self.n as f64 * self.sum_us2 as f64 - self.sum_us as f64 * self.sum_us as f64,
        };
        let variance_us2 = spread.max(0.0) / (self.n as f64 * (self.n - 1) as f64);
        Some(variance_us2.sqrt() / 1e3)
    }
}

#[cfg(test)]
impl TimeErrors {
    /// The same errors with true and found time swapped.
    pub(super) fn negated(self) -> TimeErrors {
        TimeErrors { sum_us: -self.sum_us, ..self }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn mean_and_deviation_are_those_of_a_sample() {
        let mut errors = TimeErrors::default();
        assert_eq!((errors.count(), errors.mean_ms(), errors.sd_ms()), (0, None, None));
        errors.add(0.010);
        assert_eq!((errors.mean_ms(), errors.sd_ms()), (Some(10.0), None));
        errors.add(-0.020);
        errors.add(0.040);
        errors.add(f64::NAN);
        assert_eq!((errors.count(), errors.mean_ms()), (3, Some(10.0)));
        // (0 + 900 + 900) / 2
        assert!((errors.sd_ms().unwrap() - 30.0).abs() < 1e-12);
    }

    #[test]
    fn equal_errors_have_no_spread_and_huge_ones_do_not_overflow() {
        let mut errors = TimeErrors::default();
        (0..1000).for_each(|_| errors.add(1.0 / 30.0));
        assert_eq!((errors.mean_ms(), errors.sd_ms()), (Some(33.333), Some(0.0)));
        (0..1000).for_each(|_| errors.add(f64::INFINITY));
        errors.add(f64::NEG_INFINITY);
        assert!(errors.sd_ms().unwrap().is_finite());
    }

    proptest! {
        #[test]
        fn any_order_gives_the_same(values in prop::collection::vec(-3.0..3.0_f64, 0..40), cut in 0_usize..40) {
            let sum = |values: &[f64]| {
                let mut errors = TimeErrors::default();
                values.iter().for_each(|&value| errors.add(value));
                errors
            };
            let (a, b) = values.split_at(cut.min(values.len()));
            let mut parts = sum(b);
            parts.merge(&sum(a));
            prop_assert_eq!(parts, sum(&values));
            prop_assert_eq!(parts.sd_ms(), sum(&values).sd_ms());
        }
    }
}
