//! Arms: swinging against the legs, hanging, helping a jump, and doing things of their own.

use super::body::{Body, rotation_between};
use super::path::smoothstep;
use super::plan::{Flight, Leap};
use super::skeleton::joint;
use super::style::Style;
use crate::motion::Axis;
use crate::motion::rotation::about;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// What an arm does beside swinging.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Gesture {
    /// Upper arm out to the side, forearm up, waved from side to side.
    Wave,
    /// Straight up, and held.
    Raise,
    /// Straight forward at shoulder height, and held.
    Point,
    /// Fist before the chest, then forward and back, again and again.
    Punch,
    /// To something in front at the height of the shoulder (higher and lower with the size), held, and back.
    Reach,
    /// Forearm held forward, as below a box; for both arms.
    Carry,
}

/// A gesture of one arm at some time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmAction {
    /// What.
    pub gesture: Gesture,
    /// Which arm.
    pub side: crate::annotate::Foot,
    /// When it begins, seconds from the clip's first frame.
    pub start_s: f64,
    /// How long it takes with its way in and out, seconds.
    pub seconds: f64,
    /// Repetitions a second, of waves and punches.
    pub rate_hz: f64,
    /// Multiplies its angles, 1 = ordinary.
    pub size: f64,
}

/// Angles of one arm, radians; all 0: hanging straight down, elbow hinge facing forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArmPose {
    /// Forward and up.
    pub(crate) flex: f64,
    /// Out to the side and up.
    pub(crate) abduct: f64,
    /// Of the upper arm about itself, outwards.
    pub(crate) twist: f64,
    pub(crate) elbow: f64,
}

/// What the legs are doing, for arms that follow them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beat {
    pub(crate) time_s: f64,
    pub(crate) walk: f64,
    pub(crate) run: f64,
    /// Cycles, whole where the left foot strikes.
    pub(crate) stride: f64,
    pub(crate) speed_mps: f64,
    /// 1: the left arm is ahead where the right foot strikes; -1: behind, in a walk backwards.
    pub(crate) ahead: f64,
}

/// How far the arms run ahead of the legs that they swing against, cycles, in a walk and in a run: gives the measured
/// arm-leg relation of +0.058 and +0.071 (GRAFTS 2).
const LEAD: [f64; 2] = [0.006, 0.185];

impl ArmPose {
    fn mix(self, other: ArmPose, share: f64) -> ArmPose {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        ArmPose {
            flex: mix(self.flex, other.flex),
            abduct: mix(self.abduct, other.abduct),
            twist: mix(self.twist, other.twist),
            elbow: mix(self.elbow, other.elbow),
        }
    }
}

/// The pose of one arm (0 left, 1 right).
pub(crate) fn arm_pose(flights: &[Flight], style: &Style, actions: &[ArmAction], side: usize, beat: &Beat) -> ArmPose {
    let mut pose = swinging(style, side, beat);
    for flight in flights.iter().filter(|flight| flight.leap == Leap::Jump) {
        pose = jumping(pose, flight, beat.time_s);
    }
    for action in actions.iter().filter(|action| action.side as usize == side) {
        let since_s = beat.time_s - action.start_s;
        let ease_s = (0.3 * action.seconds).min(0.7);
        let share = smoothstep(since_s / ease_s) * smoothstep((action.seconds - since_s) / ease_s);
        if share > 0.0 {
            pose = pose.mix(gesturing(action, since_s), share);
        }
    }
    pose
}

/// Local rotations of clavicle, humerus, radius, wrist and hand for a pose.
pub(crate) fn arm_turns(body: &Body, side: usize, pose: &ArmPose) -> [(usize, DQuat); 7] {
    let out = [1.0, -1.0][side];
    let humerus = &body.joints[joint::HUMERUS[side]];
    let along = humerus.bone_m.normalize();
    let bends_toward = (humerus.rest * DVec3::X).cross(along);
    let hanging = rotation_between([along, bends_toward], [DVec3::NEG_Y, DVec3::Z]);
    let turn = about(Axis::X, -pose.flex) * about(Axis::Z, out * pose.abduct) * about(Axis::Y, out * pose.twist);
    // The collar bone goes up with an arm that is raised beyond the horizontal.
    let raised = smoothstep((pose.flex.max(pose.abduct) - 0.9) / 1.6);
    let collar = about(Axis::Z, out * 0.32 * raised);
    let conjugated = |joint: usize, turn: DQuat| {
        let rest = body.joints[joint].rest;
        (joint, rest * turn * rest.conjugate())
    };
    [
        (joint::CLAVICLE[side], collar),
        (joint::HUMERUS[side], collar.conjugate() * turn * hanging),
        conjugated(joint::RADIUS[side], about(Axis::X, pose.elbow)),
        conjugated(joint::WRIST[side], about(Axis::Y, -0.35)),
        conjugated(joint::HAND[side], about(Axis::X, -0.12)),
        conjugated(joint::FINGERS[side], about(Axis::X, 0.25)),
        conjugated(joint::THUMB[side], about(Axis::X, 0.2)),
    ]
}

fn swinging(style: &Style, side: usize, beat: &Beat) -> ArmPose {
    let hang = ArmPose { flex: -0.02, abduct: 0.10, twist: -0.25, elbow: 0.22 + style.elbow_rad };
    // The left arm is ahead where the right foot strikes.
    let forward = |lead: f64| {
        let cycles = beat.stride + lead + if side == 0 { 0.5 } else { 0.0 };
        libm::cos(core::f64::consts::TAU * cycles)
    };
    let walk_forward = forward(LEAD[0]) * beat.ahead;
    let walk_rad = style.arm_swing * (0.12 + 0.16 * beat.speed_mps).min(0.5);
    let walk = ArmPose {
        flex: -0.05 + walk_rad * walk_forward,
        abduct: 0.09,
        twist: -0.25,
        elbow: 0.26 + style.elbow_rad + 0.55 * walk_rad * (0.6 + walk_forward),
    };
    let run_forward = forward(LEAD[1]);
    let run_rad = style.arm_swing * (0.42 + 0.06 * beat.speed_mps).min(0.8);
    let run = ArmPose {
        flex: -0.22 + run_rad * run_forward,
        abduct: 0.16,
        twist: -0.45,
        elbow: 1.5 + 0.5 * style.elbow_rad + 0.25 * run_forward,
    };
    hang.mix(walk, beat.walk).mix(run, beat.run)
}

/// Back in the crouch, forward and up at the take-off, down again after the landing.
fn jumping(pose: ArmPose, flight: &Flight, time_s: f64) -> ArmPose {
    let strength = ((flight.landing_s - flight.takeoff_s) / 0.5).min(1.2);
    let keys = [
        (flight.takeoff_s - 0.6, 0.0, 0.0, 0.0),
        (flight.takeoff_s - 0.27, -0.75, 0.1, 0.1),
        (flight.takeoff_s + 0.04, 1.9, 0.25, 0.35),
        (flight.landing_s - 0.02, 1.0, 0.45, 0.5),
        (flight.landing_s + 0.22, 0.35, 0.3, 0.35),
        (flight.landing_s + 0.7, 0.0, 0.0, 0.0),
    ];
    let after = keys.partition_point(|key| key.0 <= time_s);
    let (Some(before), Some(next)) = (after.checked_sub(1).map(|index| keys[index]), keys.get(after)) else {
        return pose;
    };
    let u = smoothstep((time_s - before.0) / (next.0 - before.0));
    let mix = |a: f64, b: f64| strength * (a + (b - a) * u);
    ArmPose {
        flex: pose.flex + mix(before.1, next.1),
        abduct: pose.abduct + mix(before.2, next.2),
        twist: pose.twist,
        elbow: pose.elbow + mix(before.3, next.3),
    }
}

fn gesturing(action: &ArmAction, since_s: f64) -> ArmPose {
    let size = action.size;
    let cycle = action.rate_hz * since_s;
    let swing = libm::sin(core::f64::consts::TAU * cycle);
    match action.gesture {
        Gesture::Wave => {
            ArmPose { flex: 0.25, abduct: 1.45 * size.min(1.2), twist: 1.35, elbow: 1.25 + 0.38 * size * swing }
        }
        Gesture::Raise => ArmPose { flex: 2.75 * size.min(1.08), abduct: 0.18, twist: -0.1, elbow: 0.2 },
        Gesture::Point => ArmPose { flex: 1.5 * size, abduct: 0.12, twist: -0.3, elbow: 0.12 },
        Gesture::Reach => ArmPose { flex: 1.25 * size, abduct: 0.10, twist: -0.1, elbow: 0.35 },
        Gesture::Carry => ArmPose { flex: 0.25 * size, abduct: 0.06, twist: -0.15, elbow: 1.35 },
        Gesture::Punch => {
            let guard = ArmPose { flex: 0.55, abduct: 0.15, twist: -0.35, elbow: 2.15 };
            let out = ArmPose { flex: 1.5 * size.min(1.1), abduct: 0.05, twist: -0.6, elbow: 0.15 };
            // Out in a quarter of the cycle, back in another, a rest between.
            let u = cycle - cycle.floor();
            guard.mix(out, smoothstep(u / 0.28) * (1.0 - smoothstep((u - 0.34) / 0.34)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotate::Foot;
    use crate::procedural::skeleton::Subject;

    /// Shoulder to elbow and elbow to wrist, unit vectors in chest axes (left, up, forward).
    fn directions(side: usize, pose: ArmPose) -> (DVec3, DVec3) {
        let body = Body::new(&Subject { name: "s".to_owned(), height_m: 1.75 });
        let turns = arm_turns(&body, side, &pose);
        let humerus = turns[0].1 * turns[1].1;
        let upper = humerus * body.joints[joint::HUMERUS[side]].bone_m.normalize();
        let lower = humerus * turns[2].1 * body.joints[joint::RADIUS[side]].bone_m.normalize();
        (upper, lower)
    }

    #[test]
    fn angles_mean_what_they_say_on_both_sides() {
        let pose = |flex, abduct, twist, elbow| ArmPose { flex, abduct, twist, elbow };
        for side in 0..2 {
            let out = [1.0, -1.0][side];
            let (upper, lower) = directions(side, pose(0.0, 0.0, 0.0, 0.5));
            assert!((upper - DVec3::NEG_Y).length() < 1e-5, "hanging: {upper}");
            assert!(lower.z > 0.4 && lower.x.abs() < 1e-5, "the elbow bends forward: {lower}");
            let (upper, _) = directions(side, pose(1.57, 0.0, 0.0, 0.1));
            assert!(upper.z > 0.99, "forward: {upper}");
            let (upper, lower) = directions(side, pose(0.0, 1.57, 1.57, 1.57));
            assert!(upper.x * out > 0.99, "out to the side: {upper}");
            assert!(lower.y > 0.99, "forearm up: {lower}");
        }
    }

    #[test]
    fn a_gesture_is_eased_in_and_out_of_the_swinging_arm() {
        let action = ArmAction {
            gesture: Gesture::Wave,
            side: Foot::Right,
            start_s: 1.0,
            seconds: 2.0,
            rate_hz: 2.0,
            size: 1.0,
        };
        let pose = |time_s, side| {
            let beat = Beat { time_s, walk: 0.0, run: 0.0, stride: 0.0, speed_mps: 0.0, ahead: 1.0 };
            arm_pose(&[], &Style::ORDINARY, &[action], side, &beat)
        };
        assert_eq!(pose(1.0, 1), pose(0.0, 1));
        assert_eq!(pose(3.0, 1), pose(9.0, 1));
        assert!(pose(2.0, 1).abduct > 1.0);
        assert_eq!(pose(2.0, 0), pose(0.0, 0), "the other arm does nothing");
        assert!((pose(1.01, 1).abduct - pose(1.0, 1).abduct).abs() < 0.01, "no jump at the start");
    }

    #[test]
    fn the_arm_is_ahead_when_the_other_foot_strikes() {
        for (walk, run) in [(1.0, 0.0), (0.0, 1.0)] {
            let flex = |stride, side| {
                let beat = Beat { time_s: 0.0, walk, run, stride, speed_mps: 2.0, ahead: 1.0 };
                arm_pose(&[], &Style::ORDINARY, &[], side, &beat).flex
            };
            assert!(flex(0.0, 1) > flex(0.0, 0) && flex(0.5, 0) > flex(0.5, 1));
            assert!((flex(0.3, 0) - flex(0.8, 1)).abs() < 1e-12, "half a stride apart");
        }
    }
}
