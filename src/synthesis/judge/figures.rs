//! The figures of a clip: each sees one kind of fault (GRAFTS 5).

use super::super::signal::{mean, percentile};
use super::super::subject::Movement;
use super::arm_leg::arm_leg;
use super::collision::self_collision;
use super::contacts::{contacts, runs};
use super::reference::Reference;
use crate::motion::rotation::rotation_vector;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What is measured, in the order of GRAFTS 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Largest third difference of either wrist about the chest, in its axes, m/s^3.
    WristJerk,
    /// Largest of trunk, head and arms, local rotations, rad/s^2.
    UpperAngularAcceleration,
    /// Largest of hips, knees and ankles, rad/s^2.
    LegAngularAcceleration,
    /// Mean horizontal speed of planted feet, the slower of ankle and toe, m/s.
    Skate,
    /// How far a planted toe drifts, 90th percentile over plants, m.
    PlantDrift,
    /// Depth of a toe joint below 2 cm (scaled with the leg), m.
    Penetration,
    /// Worst angle outside the joint ranges of the captures, rad.
    LimitExcess,
    /// Deepest overlap of the body's capsules, m.
    SelfCollision,
    /// Distance of the zero moment point to the support, m. Not computed: it needs a mass model.
    ZmpDistance,
    /// Distance of either arm to its nearest captured pose. Not computed: it needs a frozen reference.
    ArmNovelty,
    /// Phase of the arms after the opposite legs, cycles.
    ArmLegRelation,
    /// How firmly arms and legs are locked, 0..1.
    ArmLegLock,
    /// Distance of arms and legs to the nearest captured pose: a score. Not computed: it needs a frozen reference.
    PoseNovelty,
}

/// The figures of one clip. None: not computed, or the clip has no such thing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    values: [Option<f64>; Measure::ALL.len()],
}

/// Hip to knee to ankle of the body that the study's radii and heights belong to, metres.
const STUDY_LEG_M: f64 = 0.800665;
const TOE_HEIGHT_M: f64 = 0.02;

impl Measure {
    /// All of them, in order.
    pub const ALL: [Measure; 13] = [
        Measure::WristJerk,
        Measure::UpperAngularAcceleration,
        Measure::LegAngularAcceleration,
        Measure::Skate,
        Measure::PlantDrift,
        Measure::Penetration,
        Measure::LimitExcess,
        Measure::SelfCollision,
        Measure::ZmpDistance,
        Measure::ArmNovelty,
        Measure::ArmLegRelation,
        Measure::ArmLegLock,
        Measure::PoseNovelty,
    ];

    /// The column's name.
    pub fn name(self) -> &'static str {
        [
            "wrist_jerk",
            "upper_angular_acceleration",
            "leg_angular_acceleration",
            "skate",
            "plant_drift",
            "penetration",
            "limit_excess",
            "self_collision",
            "zmp_distance",
            "arm_novelty",
            "arm_leg_relation",
            "arm_leg_lock",
            "pose_novelty",
        ][self as usize]
    }

    /// The measure of that name.
    pub fn from_name(name: &str) -> Option<Measure> {
        Measure::ALL.into_iter().find(|measure| measure.name() == name)
    }
}

impl Figures {
    /// Measures a clip at its rate; joint ranges are those of the reference.
    pub fn of(movement: &Movement, reference: &Reference) -> Figures {
        let planted = contacts(movement);
        let arm_leg = arm_leg(movement);
        let mut figures = Figures::default();
        for measure in Measure::ALL {
            figures.values[measure as usize] = match measure {
                Measure::WristJerk => wrist_jerk(movement),
                Measure::UpperAngularAcceleration => angular_acceleration(movement, &movement.upper_joints()),
                Measure::LegAngularAcceleration => angular_acceleration(movement, &movement.leg_joints()),
                Measure::Skate => Some(skate(movement, &planted)),
                Measure::PlantDrift => Some(plant_drift(movement, &planted)),
                Measure::Penetration => Some(penetration(movement)),
                Measure::LimitExcess => reference.limit_excess(movement),
                Measure::SelfCollision => Some(self_collision(movement)),
                Measure::ArmLegRelation => arm_leg.map(|found| found.relation),
                Measure::ArmLegLock => arm_leg.map(|found| found.lock),
                Measure::ZmpDistance | Measure::ArmNovelty | Measure::PoseNovelty => None,
            };
        }
        figures
    }

    /// Measures a parent at its child's rate. Nothing is measured where the rates lie too far apart to resample; such a
    /// pair is never grafted ([`Refusal::RatesTooFarApart`](super::super::Refusal::RatesTooFarApart)).
    pub fn of_parent(parent: &Movement, rate_hz: f64, reference: &Reference) -> Figures {
        if parent.rate_hz == rate_hz {
            return Figures::of(parent, reference);
        }
        let resampled = parent.resampled(rate_hz);
        resampled.map_or_else(Figures::default, |resampled| Figures::of(&resampled, reference))
    }

    /// One figure.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        self.values[measure as usize]
    }

    /// The same figures with one replaced, such as one that was measured elsewhere.
    pub fn with(mut self, measure: Measure, value: Option<f64>) -> Figures {
        self.values[measure as usize] = value;
        self
    }
}

/// How large a body is beside the study's.
pub(super) fn body_scale(movement: &Movement) -> f64 {
    movement.leg_length_m() / STUDY_LEG_M
}

fn wrist_jerk(movement: &Movement) -> Option<f64> {
    let chest = movement.landmarks.chest;
    let cube = movement.rate_hz * movement.rate_hz * movement.rate_hz;
    let largest = |wrist: usize| {
        let path = movement.path_in_chest(wrist, chest);
        let third = |four: &[DVec3]| (four[3] - four[2]) - 2.0 * (four[2] - four[1]) + (four[1] - four[0]);
        path.windows(4).map(|four| third(four).length() * cube).reduce(f64::max)
    };
    movement.landmarks.arms.iter().filter_map(|arm| largest(arm.wrist)).reduce(f64::max)
}

/// None: fewer than three frames, or no joints.
fn angular_acceleration(movement: &Movement, joints: &[usize]) -> Option<f64> {
    let turns = &movement.rotations;
    let largest = |&joint: &usize| {
        let velocity = |frame: usize| {
            rotation_vector(turns.local_at(frame, joint).conjugate() * turns.local_at(frame + 1, joint))
                * movement.rate_hz
        };
        let velocities: Vec<DVec3> = (0..movement.n_frames() - 1).map(velocity).collect();
        velocities.windows(2).map(|pair| (pair[1] - pair[0]).length() * movement.rate_hz).reduce(f64::max)
    };
    joints.iter().filter_map(largest).reduce(f64::max)
}

fn skate(movement: &Movement, planted: &[Vec<bool>; 2]) -> f64 {
    let mut speeds = Vec::new();
    for (leg, planted) in movement.landmarks.legs.iter().zip(planted) {
        for frame in 0..movement.n_frames() - 1 {
            if planted[frame] && planted[frame + 1] {
                let step = |point: usize| {
                    let moved = movement.poses.at(frame + 1, point) - movement.poses.at(frame, point);
                    DVec3::new(moved.x, 0.0, moved.z).length()
                };
                speeds.push(step(leg.ankle).min(step(leg.toe)) * movement.rate_hz);
            }
        }
    }
    mean(&speeds)
}

fn plant_drift(movement: &Movement, planted: &[Vec<bool>; 2]) -> f64 {
    // Five frames at 30 Hz; the hair of slack takes a file's 30.00003 for 30.
    let shortest = 5.0 * movement.rate_hz / 30.0 - 0.01;
    let mut drifts = Vec::new();
    for (leg, planted) in movement.landmarks.legs.iter().zip(planted) {
        for (first, end) in runs(planted, true) {
            if (end - first) as f64 >= shortest {
                let cut = (0.2 * (end - first) as f64) as usize;
                let toe = (first + cut..end - cut).map(|frame| movement.poses.at(frame, leg.toe));
                let (low, high) =
                    toe.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), toe| (low.min(toe), high.max(toe)));
                drifts.push(DVec3::new(high.x - low.x, 0.0, high.z - low.z).length());
            }
        }
    }
    percentile(&drifts, 90.0).unwrap_or(0.0)
}

fn penetration(movement: &Movement) -> f64 {
    let toes = movement.landmarks.legs.iter().flat_map(|leg| movement.poses.path(leg.toe));
    let lowest = toes.map(|toe| toe.y).fold(f64::INFINITY, f64::min);
    (TOE_HEIGHT_M * body_scale(movement) - lowest).max(0.0)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::super::subject::Subject;
    use super::super::super::walker::{mover, walker, waver};
    use super::*;
    use crate::motion::Role;
    use core::f64::consts::TAU;

    fn of(subject: &Subject) -> Figures {
        Figures::of(&subject.movement, &Reference::default())
    }

    #[test]
    fn names_and_order_are_those_of_the_table() {
        assert!(Measure::ALL.into_iter().enumerate().all(|(n, measure)| measure as usize == n));
        assert!(Measure::ALL.into_iter().all(|measure| Measure::from_name(measure.name()) == Some(measure)));
    }

    #[test]
    fn a_swing_has_the_acceleration_of_its_sine() {
        // 25 degrees at 1 Hz: amplitude times (2 pi)^2, less what a difference over frames loses.
        let figures = of(&walker(120.0, 480, 1.0));
        let expected = 25.0_f64.to_radians() * TAU * TAU;
        let legs = figures.get(Measure::LegAngularAcceleration).unwrap();
        assert!((legs / expected - 1.0).abs() < 0.01, "{legs} {expected}");
        let arms = figures.get(Measure::UpperAngularAcceleration).unwrap();
        assert!((arms / (0.8 * expected) - 1.0).abs() < 0.02, "{arms}");
    }

    #[test]
    fn a_slide_is_skate_and_drift_and_a_sunken_foot_penetrates() {
        let slider = mover(30.0, 61, 1.0, 0.25, &|_, _| Vec::new());
        let figures = of(&slider);
        assert!((figures.get(Measure::Skate).unwrap() - 0.25).abs() < 1e-6);
        // The middle 60% of 61 frames is 37 frames, 36 steps.
        assert!((figures.get(Measure::PlantDrift).unwrap() - 0.25 * 36.0 / 30.0).abs() < 1e-6);
        // Legs of 0.88 m below hips at 0.90 m: toes 2 cm up; the rule asks for 2 cm times 0.82 / 0.800665.
        let sunk = figures.get(Measure::Penetration).unwrap();
        assert!((sunk - 0.02 * (slider.movement.leg_length_m() / STUDY_LEG_M - 1.0)).abs() < 1e-6, "{sunk}");
        let stander = of(&waver(30.0, 60));
        assert!(stander.get(Measure::Skate).unwrap() < 1e-9);
    }

    #[test]
    fn a_jolt_is_jerk() {
        let jolt = mover(30.0, 60, 1.0, 0.0, &|time_s, _| {
            vec![(Role::ShoulderLeft, [if time_s > 1.0 { 20.0 } else { 0.0 }, 0.0, 0.0])]
        });
        let jolted = of(&jolt).get(Measure::WristJerk).unwrap();
        let smooth = of(&waver(30.0, 60)).get(Measure::WristJerk).unwrap();
        assert!(jolted > 50.0 * smooth, "{jolted} {smooth}");
    }

    #[test]
    fn a_parent_at_another_rate_is_brought_to_its_childs() {
        let (fast, slow) = (walker(120.0, 481, 1.0), walker(30.0, 121, 1.0));
        let (fast, slow) = (Figures::of_parent(&fast.movement, 30.0, &Reference::default()), of(&slow));
        for measure in Measure::ALL {
            let (a, b) = (fast.get(measure), slow.get(measure));
            // Channels are rounded to f32: a third difference at 30 Hz multiplies that by 1e5.
            assert!(a.is_none() == b.is_none(), "{measure:?}");
            let (a, b) = (a.unwrap_or(0.0), b.unwrap_or(0.0));
            assert!((a - b).abs() < 1e-3 * (1.0 + b.abs()), "{measure:?} {a} {b}");
        }
    }
}
