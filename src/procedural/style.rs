//! How somebody moves: small differences between clips, drawn once a clip.

use super::draws::Draws;
use serde::{Deserialize, Serialize};

/// Multipliers are 1 for an ordinary mover, angles are added to one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Style {
    /// Multiplies the usual step rate.
    pub cadence: f64,
    /// Multiplies the usual step width.
    pub step_width: f64,
    /// Feet turned outwards, radians.
    pub toe_out_rad: f64,
    /// Multiplies the swing of the arms.
    pub arm_swing: f64,
    /// Added to the bend of the elbows, radians.
    pub elbow_rad: f64,
    /// Added to the forward lean of the trunk, radians.
    pub lean_rad: f64,
    /// Multiplies the bob of a walk.
    pub bounce: f64,
    /// Hips lower by this share of the straight leg.
    pub crouch: f64,
    /// Multiplies the turning of pelvis and chest.
    pub twist: f64,
    /// Added to the tilt of the head, radians, down positive.
    pub head_rad: f64,
    /// Added to the usual duty factor.
    pub duty: f64,
    /// Steps of unequal length and time: strikes of the left foot come early by this share of half a stride, and the
    /// right foot stands for as much less; negative the other way round.
    pub limp: f64,
    /// Multiplies the pitch of the foot at its strike; negative: the ball strikes first.
    pub heel_strike: f64,
    /// Multiplies the height of a swing over its arc.
    pub clearance: f64,
}

impl Style {
    /// Nobody in particular.
    pub const ORDINARY: Style = Style {
        cadence: 1.0,
        step_width: 1.0,
        toe_out_rad: 0.10,
        arm_swing: 1.0,
        elbow_rad: 0.0,
        lean_rad: 0.0,
        bounce: 1.0,
        crouch: 0.0,
        twist: 1.0,
        head_rad: 0.0,
        duty: 0.0,
        limp: 0.0,
        heel_strike: 1.0,
        clearance: 1.0,
    };

    /// The first field that lies outside what a body does, with its value and range.
    pub(super) fn out_of_range(&self) -> Option<(&'static str, f64, [f64; 2])> {
        [
            ("cadence", self.cadence, [0.6, 1.6]),
            ("step_width", self.step_width, [0.0, 3.0]),
            ("toe_out_rad", self.toe_out_rad, [-0.5, 0.8]),
            ("arm_swing", self.arm_swing, [0.0, 3.0]),
            ("elbow_rad", self.elbow_rad, [-0.2, 1.0]),
            ("lean_rad", self.lean_rad, [-0.4, 0.8]),
            ("bounce", self.bounce, [0.0, 2.0]),
            ("crouch", self.crouch, [0.0, 0.2]),
            ("twist", self.twist, [0.0, 3.0]),
            ("head_rad", self.head_rad, [-0.6, 0.9]),
            ("duty", self.duty, [-0.1, 0.15]),
            ("limp", self.limp, [-0.3, 0.3]),
            ("heel_strike", self.heel_strike, [-1.0, 1.3]),
            ("clearance", self.clearance, [0.0, 6.0]),
        ]
        .into_iter()
        .find(|(_, value, [low, high])| !(low..=high).contains(&value))
    }

    /// Somebody near the ordinary.
    pub fn draw(draws: &mut Draws) -> Style {
        Style {
            cadence: draws.uniform(0.93, 1.07),
            step_width: draws.uniform(0.8, 1.3),
            toe_out_rad: draws.uniform(0.04, 0.16),
            arm_swing: draws.uniform(0.75, 1.35),
            elbow_rad: draws.uniform(-0.08, 0.2),
            lean_rad: draws.uniform(-0.02, 0.06),
            bounce: draws.uniform(0.8, 1.15),
            crouch: draws.uniform(0.0, 0.005),
            twist: draws.uniform(0.7, 1.3),
            head_rad: draws.uniform(-0.03, 0.12),
            ..Style::ORDINARY
        }
    }
}

impl Default for Style {
    fn default() -> Style {
        Style::ORDINARY
    }
}
