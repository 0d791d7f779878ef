//! Which foot is on the ground, frame by frame.
//!
//! [`adaptive`] is the default: one setting for every body, rate and gait. [`thesis`] (T 3.1) and [`extrema`]
//! (T 5.5.1) compare heights and speeds with fixed thresholds; they are here as references. What the adaptive detector
//! does, in order (CONTACTS 2):
//!
//! ```text
//! foot_paths    ankles and toes, scaled to a leg of 0.9 m      resting_height   where each joint rests
//! repair        samples that break a bone's length             force            weight on the feet
//! noise         its estimate, and smoothing                    uneven           levels, where it is no plane
//! foot_speeds   speeds, and what counts as still               decode           evidence -> tokens
//! tilt          the ground's slope                              treadmill        a belt's velocity, taken off first
//! ```

pub mod adaptive;
pub mod decode;
pub mod extrema;
pub mod foot_paths;
pub mod foot_speeds;
pub mod force;
pub mod noise;
pub mod repair;
pub mod resting_height;
pub mod thesis;
pub mod tilt;
pub mod treadmill;
pub mod uneven;

use self::foot_paths::FootPaths;
use super::gait_steps::Evidence;
use super::gait_tokens::Token;
use super::labels::Foot;
use crate::motion::{Poses, RoleMap};
use serde::{Deserialize, Serialize};

/// Height above its rest at which a joint's evidence turns from planted to not (CONTACTS 2.10: epsilon), scaled metres;
/// of feet without toes [`adaptive::evidence_height_m`].
pub const EVIDENCE_HEIGHT_M: f64 = 0.06;

/// A foot may be locked where one of its joints moves at less than this share of the speed below which it is planted.
pub const PINNED_SHARE: f64 = 0.5;

/// How feet on the ground are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Detector {
    /// Thresholds from the clip itself, evidence weighed over time (CONTACTS 2).
    #[default]
    Adaptive,
    /// Height and speed below fixed thresholds, gaps closed (T 3.1).
    Thesis,
    /// Low turning points of the height, grown while slow (T 5.5.1).
    Extrema,
}

impl Detector {
    /// The word in configs.
    pub fn name(self) -> &'static str {
        match self {
            Detector::Adaptive => "adaptive",
            Detector::Thesis => "thesis",
            Detector::Extrema => "extrema",
        }
    }
}

/// Foot contacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactSettings {
    /// Which detector.
    pub detector: Detector,
    /// Thresholds of the thesis' detector.
    pub thesis: ThesisSettings,
    /// Thresholds of the detector of turning points.
    pub extrema: ExtremaSettings,
}

/// Thresholds of the thesis' detector (T 3.1), for a body with a leg (hip to ankle) of 0.9 m (CONTACTS 2.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThesisSettings {
    /// A planted joint is within this distance of its resting height (T 3.1: epsilon).
    pub max_height_m: f64,
    /// A planted joint is slower than this (T 3.1: eta).
    pub max_speed_mps: f64,
    /// A joint that is off the ground is planted all the same if it is planted at most this long before and after
    /// (T 3.1: the debounce's window w).
    pub close_gap_s: f64,
}

/// Thresholds of the detector of turning points (T 5.5.1), for a body with a leg of 0.9 m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExtremaSettings {
    /// A turning point of the height plants the joint within this distance of its resting height.
    pub max_height_m: f64,
    /// From there on the joint stays planted while it is slower than this.
    pub max_speed_mps: f64,
}

impl Default for ThesisSettings {
    /// 5 cm, 1.0 m/s, 0.05 s: the best fixed pair under the step classifier (CONTACTS 1, 4).
    fn default() -> Self {
        ThesisSettings { max_height_m: 0.05, max_speed_mps: 1.0, close_gap_s: 0.05 }
    }
}

impl Default for ExtremaSettings {
    /// 5 cm, 0.6 m/s (CONTACTS 7).
    fn default() -> Self {
        ExtremaSettings { max_height_m: 0.05, max_speed_mps: 0.6 }
    }
}

/// Contacts of a clip's feet.
#[derive(Clone, Debug, PartialEq)]
pub struct Contacts {
    /// `[foot][frame]`: in stance: from the strike to the lift-off. What phase and gait are read from; the foot may still
    /// roll or slide.
    pub stance: [Vec<bool>; 2],
    /// `[foot][frame]`: may be locked to its place: in stance, and one of its joints as good as at rest. Locking it moves
    /// nothing that an eye would see.
    pub pinned: [Vec<bool>; 2],
    /// `[foot joint][frame]`: above (below: negative) the resting ground, metres, in the body's own size.
    pub heights_m: [Option<Vec<f64>>; 4],
    /// `[foot joint][frame]`: m/s, in the body's own size: the mean over 1/30 s before and after (fixed thresholds: from
    /// the frame before; frame 0 takes frame 1's).
    pub speeds_mps: [Option<Vec<f64>>; 4],
    /// What the feet rest on.
    pub ground: Ground,
    /// What the adaptive detector knows beyond contacts. None: another detector.
    pub diagnosis: Option<Diagnosis>,
}

/// The ground that the feet rest on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// World height at which the feet rest, metres: mean over feet of the toe's (the ankle's where there is no toe), in
    /// the middle of the way on sloping ground.
    pub height_m: Option<f64>,
    /// Robust standard deviation of slow toes about it, metres: how far it can be believed. None: fixed thresholds.
    pub spread_m: Option<f64>,
    /// Slope, rise over run. None: no plane was looked for or found; the ground counts as level.
    pub tilt: Option<tilt::Tilt>,
    /// Each plant has its own level (stairs, boxes). None: not looked for.
    pub uneven: Option<bool>,
    /// Speed of the belt that the feet stand on, m/s, 0 where the ground is at rest. None: not looked for.
    pub belt_mps: Option<f64>,
    /// A joint's own resting height was replaced by the other foot's, which lies far lower.
    pub feet_rest_apart: bool,
}

/// What the adaptive detector knows beyond contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// `[frame][foot]`: log-odds of the foot being planted, -3 to 3; raw contacts are where they are positive.
    pub log_odds: Vec<[f64; 2]>,
    /// `[frame]`: vertical force in body weights; None where it can't be known.
    pub force_bw: Vec<Option<f64>>,
    /// `[foot][frame]`: world height at which the foot's toe (ankle) would rest there, metres.
    pub ground_m: [Vec<f64>; 2],
    /// Estimated standard deviation of white noise in each coordinate of the feet, metres, and that estimate's spread.
    pub noise_m: f64,
    /// Robust standard deviation of the noise estimate among the coordinates, metres.
    pub noise_spread_m: f64,
}

impl Contacts {
    /// Which feet are planted, frame by frame.
    pub fn tokens(&self) -> Vec<Token> {
        self.stance[0].iter().zip(&self.stance[1]).map(|(&left, &right)| Token::of_feet(left, right)).collect()
    }

    /// Whether a foot is in stance, `[frame]`.
    pub fn stance_of(&self, foot: Foot) -> &[bool] {
        &self.stance[foot as usize]
    }

    /// What the classifier of gaits takes besides tokens.
    pub fn evidence(&self) -> Evidence<'_> {
        self.diagnosis.as_ref().map_or(Evidence::default(), |diagnosis| Evidence {
            log_odds: Some(&diagnosis.log_odds),
            force_bw: Some(&diagnosis.force_bw),
            wider_gaps_s: adaptive::WIDER_GAPS_S,
        })
    }
}

/// Contacts by the detector that the settings name. `feet` are those of the poses, in scaled metres.
pub fn contacts(poses: &Poses, roles: &RoleMap, feet: &FootPaths, settings: &ContactSettings) -> Contacts {
    match settings.detector {
        Detector::Adaptive => adaptive::adaptive_contacts(poses, roles, feet),
        Detector::Thesis => thesis::thesis_contacts(feet, &resting_height::resting_heights(feet), &settings.thesis),
        Detector::Extrema => extrema::extrema_contacts(feet, &resting_height::resting_heights(feet), &settings.extrema),
    }
}
