//! Random draws that depend on (seed, name, purpose) alone, so that no clip's draws move another's (DESIGN 3).

/// A stream of draws: splitmix64 started from a digest of (seed, name, purpose).
#[derive(Clone, Debug)]
pub struct Draws {
    state: u64,
}

impl Draws {
    /// The stream of one purpose of one clip or subject.
    pub fn new(seed: u64, name: &str, purpose: &str) -> Draws {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&seed.to_le_bytes());
        hasher.update(&(name.len() as u64).to_le_bytes());
        hasher.update(name.as_bytes());
        hasher.update(purpose.as_bytes());
        let digest = hasher.finalize();
        let mut first = [0; 8];
        first.copy_from_slice(&digest.as_bytes()[..8]);
        Draws { state: u64::from_le_bytes(first) }
    }

    /// 64 fresh bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly from `[low, high)`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// From the normal distribution with mean 0 and standard deviation 1 (Box and Muller); the same bits everywhere.
    pub fn normal(&mut self) -> f64 {
        let (radius, turn) = (1.0 - self.uniform(0.0, 1.0), self.uniform(0.0, 1.0));
        libm::sqrt(-2.0 * libm::log(radius)) * libm::cos(core::f64::consts::TAU * turn)
    }

    /// Evenly from `0..n`; 0 for `n` = 0.
    pub fn pick(&mut self, n: usize) -> usize {
        ((self.uniform(0.0, 1.0) * n as f64) as usize).min(n.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_seed_name_and_purpose_and_repeat_otherwise() {
        let first = |seed, name, purpose| Draws::new(seed, name, purpose).bits();
        let base = first(1, "walk_01", "style");
        assert_eq!(base, first(1, "walk_01", "style"));
        for other in [first(2, "walk_01", "style"), first(1, "walk_02", "style"), first(1, "walk_01", "plan")] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn normal_draws_have_the_moments_of_the_normal_distribution() {
        let mut draws = Draws::new(7, "x", "normal");
        let values: Vec<f64> = (0..20_000).map(|_| draws.normal()).collect();
        let moment = |power: i32| values.iter().map(|v| v.powi(power)).sum::<f64>() / values.len() as f64;
        assert!(moment(1).abs() < 0.02 && (moment(2) - 1.0).abs() < 0.03 && (moment(4) - 3.0).abs() < 0.2);
    }

    #[test]
    fn draws_fill_their_range() {
        let mut draws = Draws::new(7, "x", "range");
        let values: Vec<f64> = (0..1000).map(|_| draws.uniform(2.0, 3.0)).collect();
        assert!(values.iter().all(|v| (2.0..3.0).contains(v)));
        assert!((values.iter().sum::<f64>() / 1000.0 - 2.5).abs() < 0.03);
        let mut seen = [false; 5];
        (0..100).for_each(|_| seen[draws.pick(5)] = true);
        assert_eq!(seen, [true; 5]);
    }
}
