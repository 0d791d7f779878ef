//! What choosing recipes needs to know of a clip: its gait, its ankle passes, its action, and two descriptors.

use super::action::{Action, ActionSettings};
use super::correlation::{AnklePass, CorrelationSettings, Footwork};
use super::heading::forward;
use super::judge::GateSettings;
use super::judge::arm_leg::arm_leg;
use super::parts::Part;
use super::subject::Movement;
use crate::annotate::Gait;
use glam::DVec3;

/// Numbers of the descriptor of the arms: mean (3), spread (3) and speed of both elbows and wrists.
pub const ARM_NUMBERS: usize = 28;
/// Numbers of the descriptor of the legs: mean (3) and spread (3) of both ankles, speed and turn rate of the hips.
pub const LEG_NUMBERS: usize = 14;
/// What a speed of 1 m/s, or a turn of 1 rad/s, weighs beside a metre.
const SPEED_WEIGHT_S: f64 = 0.25;

/// A clip as the choice of recipes sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Portrait {
    /// `source/name`: recipes and ties go by it.
    pub name: String,
    /// Layout of its skeleton: rotations can be copied within one.
    pub layout: String,
    /// Class of the clip.
    pub gait: Gait,
    /// Frames a second.
    pub rate_hz: f64,
    /// Number of frames.
    pub n_frames: usize,
    /// When the ankles pass each other.
    pub passes: Vec<AnklePass>,
    /// Whether its arms keep time with its legs, by the judge's gates; true where that can't be told. Arms of another beat
    /// would be refused on any base.
    pub in_step: bool,
    /// Arms that do something: left, right.
    pub active: [bool; 2],
    /// How long the action lasts with its seams, seconds; 0 where no arm is active.
    pub action_s: f64,
    /// How the arms move, in heading space about the hips.
    pub arms: [f64; ARM_NUMBERS],
    /// How the legs move.
    pub legs: [f64; LEG_NUMBERS],
}

impl Portrait {
    /// Draws the portrait of a clip's movement.
    pub fn of(
        name: String,
        layout: String,
        gait: Gait,
        movement: &Movement,
        seam_s: f64,
        settings: (&ActionSettings, &CorrelationSettings, &GateSettings),
    ) -> Portrait {
        let action = Action::of(movement, settings.0);
        let [first, end] = action.frames_with_seams(seam_s, movement.rate_hz, movement.n_frames());
        let action_s = if action.active == [false; 2] { 0.0 } else { (end - first) as f64 / movement.rate_hz };
        let forward = forward(movement);
        Portrait {
            name,
            layout,
            gait,
            rate_hz: movement.rate_hz,
            n_frames: movement.n_frames(),
            passes: Footwork::of(movement, settings.1).passes,
            in_step: arm_leg(movement).is_none_or(|found| settings.2.is_in_step(&found)),
            active: action.active,
            action_s,
            arms: arms(movement, &forward),
            legs: legs(movement, &forward),
        }
    }

    /// The active arms as parts.
    pub fn active_arms(&self) -> Vec<Part> {
        (0..2).filter(|&side| self.active[side]).map(|side| Part::ARMS[side]).collect()
    }

    /// Frames over rate.
    pub fn duration_s(&self) -> f64 {
        self.n_frames as f64 / self.rate_hz
    }
}

fn arms(movement: &Movement, forward: &[DVec3]) -> [f64; ARM_NUMBERS] {
    let mut numbers = [0.0; ARM_NUMBERS];
    let marks = &movement.landmarks;
    let points = marks.arms.iter().flat_map(|arm| [arm.elbow, arm.wrist]);
    for (point, block) in points.zip(numbers.chunks_exact_mut(7)) {
        let path = in_heading(&movement.path_from(point, marks.hips), forward);
        block.copy_from_slice(&moments(&path, movement.rate_hz));
    }
    numbers
}

fn legs(movement: &Movement, forward: &[DVec3]) -> [f64; LEG_NUMBERS] {
    let mut numbers = [0.0; LEG_NUMBERS];
    let marks = &movement.landmarks;
    for (leg, block) in marks.legs.iter().zip(numbers.chunks_exact_mut(6)) {
        let path = in_heading(&movement.path_from(leg.ankle, marks.hips), forward);
        block.copy_from_slice(&moments(&path, movement.rate_hz)[..6]);
    }
    let hips: Vec<DVec3> = (0..movement.n_frames()).map(|frame| movement.poses.at(frame, marks.hips)).collect();
    let steps = hips.windows(2).map(|two| (two[1] - two[0]).with_y(0.0).length());
    let seconds = ((hips.len() - 1) as f64 / movement.rate_hz).max(1e-9);
    numbers[12] = SPEED_WEIGHT_S * steps.sum::<f64>() / seconds;
    let turns =
        forward.windows(2).map(|two| libm::atan2(two[0].z * two[1].x - two[0].x * two[1].z, two[0].dot(two[1])));
    numbers[13] = SPEED_WEIGHT_S * turns.sum::<f64>() / seconds;
    numbers
}

/// Left, up, forward.
fn in_heading(path: &[DVec3], forward: &[DVec3]) -> Vec<DVec3> {
    let turned = |(offset, forward): (&DVec3, &DVec3)| {
        DVec3::new(offset.dot(DVec3::Y.cross(*forward)), offset.y, offset.dot(*forward))
    };
    path.iter().zip(forward).map(turned).collect()
}

/// Mean (3), standard deviation (3), weighted mean speed.
fn moments(path: &[DVec3], rate_hz: f64) -> [f64; 7] {
    let n = path.len().max(1) as f64;
    let mean = path.iter().sum::<DVec3>() / n;
    let variance = path.iter().map(|point| (*point - mean) * (*point - mean)).sum::<DVec3>() / n;
    let spread = DVec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt());
    let steps = path.windows(2).map(|two| two[1].distance(two[0])).sum::<f64>();
    let speed = SPEED_WEIGHT_S * steps * rate_hz / (path.len().max(2) - 1) as f64;
    [mean.x, mean.y, mean.z, spread.x, spread.y, spread.z, speed]
}

#[cfg(test)]
mod tests {
    use super::super::walker::mover;
    use super::*;
    use crate::motion::Role;
    use core::f64::consts::TAU;

    fn limbs(leg: f64, arm: f64) -> Vec<(Role, [f64; 3])> {
        let [leg, arm] = [leg, arm].map(|phase| 25.0 * libm::sin(TAU * phase));
        vec![
            (Role::ThighLeft, [0.0, -leg, 0.0]),
            (Role::ThighRight, [0.0, leg, 0.0]),
            (Role::ShoulderLeft, [0.0, arm, 0.0]),
            (Role::ShoulderRight, [0.0, -arm, 0.0]),
        ]
    }

    #[test]
    fn arms_of_another_beat_are_noticed() {
        let on_time = mover(30.0, 200, 1.0, 1.2, &|_, phase| limbs(phase, phase + 0.06));
        let late = mover(30.0, 200, 1.0, 1.2, &|_, phase| limbs(phase, phase + 0.3));
        let in_step = [on_time, late].map(|walker| {
            let told = (&ActionSettings::default(), &CorrelationSettings::default(), &GateSettings::default());
            Portrait::of("s/walk".to_owned(), "L".to_owned(), Gait::Walk, &walker.movement, 0.5, told).in_step
        });
        assert_eq!(in_step, [true, false]);
    }
}
