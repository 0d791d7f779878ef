//! The similarity metric between frames: canonical vectors, and E between two of them (T 4.2.1, eq. 4.1).
//!
//! E is a squared distance, so each weight is folded into the vector as its square root and rounded to f32
//! once. From then on the rounded vectors are the data: whoever computes E from them, on whatever machine,
//! gets the same bits. DESIGN 6 allows for a constant rotation R in front. It is the identity, because the
//! only gain of another R is shorter searches, and `search_basis` has that without
//! touching E.

use super::ClusterError;
use crate::annotate::Features;
use serde::{Deserialize, Serialize};

/// Feature values a frame: five effectors, three kinds (position, velocity, acceleration), three axes.
pub const FEATURES: usize = 45;

/// Coordinates of a canonical vector: the features, padded with zeros to whole cache lines.
pub const LANES: usize = 48;

/// How frames are compared and how far they are merged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The tree stops at the first merge that costs this much, m^2. At 0.5 a walk cycle falls into 5 to 10 nodes.
    pub t_max_m2: f64,
    /// Time by which velocities are multiplied to become lengths, seconds: the root of their weight.
    pub velocity_scale_s: f64,
    /// Square of a time by which accelerations are multiplied to become lengths, s^2: the root of their weight.
    pub acceleration_scale_s2: f64,
    /// Accelerations longer than this are shortened to it, in E only, m/s^2: marker spikes reach 500.
    pub max_acceleration_mps2: f64,
    /// Weight of each effector, a plain factor on its squared differences.
    pub weights: EffectorWeights,
}

/// Weight of each effector in E, without unit. An ankle that stands in for a missing toe takes the toe's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EffectorWeights {
    /// Base of the skull.
    pub head: f64,
    /// Far end of the left forearm.
    pub wrist_left: f64,
    /// Far end of the right forearm.
    pub wrist_right: f64,
    /// Ball of the left foot.
    pub toe_left: f64,
    /// Ball of the right foot.
    pub toe_right: f64,
}

/// The canonical vector of a frame: f32(sqrt(weight) x feature) and three zeros; metres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Vector(pub [f32; LANES]);

/// The metric of given settings: makes canonical vectors.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Root of the weight of each feature value.
    scale: [f64; FEATURES],
    max_acceleration_mps2: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            t_max_m2: 0.5,
            velocity_scale_s: 0.1,
            acceleration_scale_s2: 0.01,
            max_acceleration_mps2: 50.0,
            weights: EffectorWeights::default(),
        }
    }
}

impl Default for EffectorWeights {
    fn default() -> Self {
        EffectorWeights { head: 1.0, wrist_left: 1.0, wrist_right: 1.0, toe_left: 1.0, toe_right: 1.0 }
    }
}

impl Default for Vector {
    fn default() -> Self {
        Vector([0.0; LANES])
    }
}

impl Metric {
    /// The metric of these settings.
    ///
    /// # Errors
    /// [`ClusterError::Weight`] where a weight, scale or limit is negative, not finite or above 1e6;
    /// [`ClusterError::Threshold`] where `t_max_m2` is not positive and finite.
    pub fn new(settings: &Settings) -> Result<Metric, ClusterError> {
        let Settings { t_max_m2, velocity_scale_s, acceleration_scale_s2, max_acceleration_mps2, weights } = settings;
        let named = [
            ("velocity_scale_s", *velocity_scale_s),
            ("acceleration_scale_s2", *acceleration_scale_s2),
            ("max_acceleration_mps2", *max_acceleration_mps2),
            ("weights.head", weights.head),
            ("weights.wrist_left", weights.wrist_left),
            ("weights.wrist_right", weights.wrist_right),
            ("weights.toe_left", weights.toe_left),
            ("weights.toe_right", weights.toe_right),
        ];
        if let Some(&(name, found)) = named.iter().find(|(_, value)| !(0.0..=1e6).contains(value)) {
            return Err(ClusterError::Weight { name, found });
        }
        check_threshold(*t_max_m2)?;
        let of_kind = [1.0, *velocity_scale_s, *acceleration_scale_s2];
        let of_effector = [weights.head, weights.wrist_left, weights.wrist_right, weights.toe_left, weights.toe_right];
        let scale = std::array::from_fn(|lane| of_effector[lane / 9].sqrt() * of_kind[lane / 3 % 3]);
        Ok(Metric { scale, max_acceleration_mps2: *max_acceleration_mps2 })
    }

    /// The canonical vector of one frame.
    ///
    /// # Shapes and units
    /// `frame`: `[effector][p v a][x y z]` in the neutral frame, m, m/s, m/s^2, as [`Features::values`] has it.
    /// A NaN stays a NaN, for [`tree`](super::tree) to refuse.
    pub fn vector(&self, frame: &[f32; FEATURES]) -> Vector {
        let mut vector = Vector::default();
        for effector in 0..5 {
            let first = effector * 9;
            let acceleration = &frame[first + 6..first + 9];
            let length = acceleration.iter().map(|&a| f64::from(a) * f64::from(a)).sum::<f64>().sqrt();
            let shorten = if length > self.max_acceleration_mps2 { self.max_acceleration_mps2 / length } else { 1.0 };
            for (kind, values) in frame[first..first + 9].chunks(3).enumerate() {
                let shorten = if kind == 2 { shorten } else { 1.0 };
                for (axis, &value) in values.iter().enumerate() {
                    let lane = first + 3 * kind + axis;
                    // Adding zero turns -0 into 0, so that equal vectors are equal bits.
                    vector.0[lane] = (self.scale[lane] * (f64::from(value) * shorten)) as f32 + 0.0;
                }
            }
        }
        vector
    }

    /// The canonical vectors of some frames of a clip, in the order of `frames`.
    ///
    /// # Errors
    /// [`ClusterError::FeatureCount`] where the values are not whole frames of 45 or a frame lies beyond them.
    pub fn vectors(&self, features: &Features, frames: &[u32]) -> Result<Vec<Vector>, ClusterError> {
        let (rows, rest) = features.values.as_chunks::<FEATURES>();
        let wrong = ClusterError::FeatureCount { found: features.values.len() };
        if !rest.is_empty() {
            return Err(wrong);
        }
        frames.iter().map(|&frame| rows.get(frame as usize).map(|row| self.vector(row)).ok_or(wrong.clone())).collect()
    }

    /// Digest of all that decides E: lanes, rotation, scales, acceleration limit. Hexadecimal blake3.
    pub fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"motionmill similarity 1; 48 lanes f32; rotation identity; lanes 8 f64");
        for value in self.scale.iter().chain([&self.max_acceleration_mps2]) {
            hasher.update(&value.to_le_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// E between two canonical vectors, m^2 (eq. 4.1): the same bits on every machine, whichever comes first.
///
/// Differences and squares in f64; eight running sums (coordinate 8c + l goes to sum l), added up pairwise at
/// the end. Plain multiply and add instead of the fused operation, which processors without it would have to
/// imitate in software.
#[inline(always)] // Into loops that are compiled for wider registers than the rest.
pub fn error_m2(a: &Vector, b: &Vector) -> f64 {
    let mut sums = [0.0_f64; 8];
    for (a, b) in a.0.as_chunks::<8>().0.iter().zip(b.0.as_chunks::<8>().0) {
        for lane in 0..8 {
            let difference = f64::from(a[lane]) - f64::from(b[lane]);
            sums[lane] += difference * difference;
        }
    }
    add_up(sums)
}

/// The count-weighted mean of two vectors, in f64, rounded to f32 once. Of equal vectors: that vector.
pub fn centroid(a: &Vector, members_a: u32, b: &Vector, members_b: u32) -> Vector {
    let (weight_a, weight_b) = (f64::from(members_a), f64::from(members_b));
    let members = weight_a + weight_b;
    Vector(std::array::from_fn(|lane| {
        ((weight_a * f64::from(a.0[lane]) + weight_b * f64::from(b.0[lane])) / members) as f32 + 0.0
    }))
}

/// Refuses a threshold that is not above zero and finite.
pub(super) fn check_threshold(threshold_m2: f64) -> Result<(), ClusterError> {
    if threshold_m2 > 0.0 && threshold_m2.is_finite() {
        Ok(())
    } else {
        Err(ClusterError::Threshold { found_m2: threshold_m2 })
    }
}

/// The fixed final tree of the eight sums.
pub(super) fn add_up(sums: [f64; 8]) -> f64 {
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    fn frame() -> [f32; FEATURES] {
        std::array::from_fn(|lane| (lane as f32 * 0.37).fract() - 0.4)
    }

    fn metric() -> Metric {
        Metric::new(&Settings::default()).unwrap()
    }

    #[test]
    fn equation_4_1_by_hand() {
        let (mut a, mut b) = ([0.0; FEATURES], [0.0; FEATURES]);
        a[9] = 3.0; // position of the left wrist: 3 m apart
        a[9 + 4] = 20.0; // its velocity: 20 m/s x 0.1 s = 2 m
        b[8] = 30.0; // acceleration of the head: 30 m/s^2 x 0.01 s^2 = 0.3 m
        let e = error_m2(&metric().vector(&a), &metric().vector(&b));
        assert!((e - (9.0 + 4.0 + 0.09)).abs() < 1e-6, "{e}");
    }

    #[test]
    fn accelerations_are_shortened_to_their_limit_and_nothing_else_is() {
        let mut spike = frame();
        spike[6..9].copy_from_slice(&[300.0, 0.0, 400.0]); // 500 m/s^2
        spike[3..6].copy_from_slice(&[300.0, 0.0, 400.0]);
        let vector = metric().vector(&spike);
        assert!((vector.0[6] - 0.3).abs() < 1e-6 && vector.0[7] == 0.0 && (vector.0[8] - 0.4).abs() < 1e-6);
        assert_eq!(vector.0[3], 30.0);
        let mut still = frame();
        still[6..9].copy_from_slice(&[30.0, 0.0, 40.0]); // just 50
        assert_eq!(metric().vector(&still).0[6], 0.3);
    }

    #[test]
    fn weights_are_factors_on_squared_differences() {
        let weights = EffectorWeights { wrist_left: 0.25, ..Default::default() };
        let light = Metric::new(&Settings { weights, ..Default::default() }).unwrap();
        let mut moved = [0.0; FEATURES];
        moved[9] = 2.0;
        let zero = light.vector(&[0.0; FEATURES]);
        assert_eq!(error_m2(&light.vector(&moved), &zero), 1.0);
        assert_ne!(light.digest(), metric().digest());
        assert_eq!(metric().digest(), metric().digest());
    }

    #[test]
    fn bits_are_pinned() {
        // Any change of lane order, rounding or constants shows here; then DESIGN 6's digest must change too.
        let (a, b) = (metric().vector(&frame()), metric().vector(&frame().map(|x| x * x - 0.1)));
        assert_eq!(error_m2(&a, &b).to_bits(), error_m2(&b, &a).to_bits());
        assert_eq!(format!("{:016x}", error_m2(&a, &b).to_bits()), "3ff3f745a5b8b20e");
        assert_eq!(&metric().digest()[..16], "3863bb531d445756");
    }

    #[test]
    fn centroids_are_symmetric_and_keep_duplicates() {
        let (a, b) = (metric().vector(&frame()), metric().vector(&frame().map(|x| x * 1.1)));
        assert_eq!(centroid(&a, 3, &b, 7), centroid(&b, 7, &a, 3));
        assert_eq!(centroid(&a, 123_457, &a, 7_654_321), a);
    }

    #[test]
    fn senseless_settings_are_refused() {
        let refused = |settings: Settings| Metric::new(&settings).unwrap_err();
        let weights = EffectorWeights { head: -1.0, ..Default::default() };
        assert!(matches!(
            refused(Settings { weights, ..Default::default() }),
            ClusterError::Weight { name: "weights.head", .. }
        ));
        let scale = Settings { velocity_scale_s: f64::NAN, ..Default::default() };
        assert!(matches!(refused(scale), ClusterError::Weight { name: "velocity_scale_s", .. }));
        for t_max_m2 in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            let settings = Settings { t_max_m2, ..Default::default() };
            assert!(matches!(refused(settings), ClusterError::Threshold { .. }));
        }
    }

    #[test]
    fn frames_beyond_the_features_are_refused() {
        let features = Features { effectors: vec![], values: vec![0.5; 2 * FEATURES] };
        assert_eq!(metric().vectors(&features, &[1, 0]).unwrap().len(), 2);
        assert!(metric().vectors(&features, &[2]).is_err());
        assert!(metric().vectors(&Features { values: vec![0.5; 46], ..features }, &[0]).is_err());
    }
}
