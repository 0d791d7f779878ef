//! From the description of a clip to its channels and its ground truth.

use super::act::{Act, PlanError};
use super::arms::ArmAction;
use super::body::{Body, Posture};
use super::draws::Draws;
use super::mover::Mover;
use super::path::GRID_HZ;
use super::plan::{Footing, Plan, plan};
use super::skeleton::{ASF_UNIT_M, BVH_UNIT_M, Subject, acclaim_skeleton, asf_text, bvh_skeleton, joint};
use super::style::Style;
use crate::annotate::{Foot, Gait};
use crate::motion::kinematics::rest_rotation;
use crate::motion::rotation::euler_near;
use crate::motion::{Axis, ChannelKind, Clip, Format, Skeleton, UpAxis};
use glam::DQuat;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// All that making a clip needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClipSpec {
    /// Name of the clip, without folder and extension.
    pub name: String,
    /// Who moves.
    pub subject: Subject,
    /// What they do, one after the other.
    pub acts: Vec<Act>,
    /// What their arms do meanwhile.
    pub actions: Vec<ArmAction>,
    /// How they move.
    pub style: Style,
    /// Heading at the first frame, radians from +Z towards +X.
    pub yaw_rad: f64,
    /// A divisor of 240.
    pub rate_hz: u32,
    /// Of all that is still left to chance (first foot, phase of the stride, idle motion).
    pub seed: u64,
}

/// A foot on the ground, as planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueStance {
    /// Which foot.
    pub foot: Foot,
    /// Seconds from the first frame; may be negative.
    pub strike_s: f64,
    /// Seconds from the first frame; may be after the last, or infinite.
    pub lift_s: f64,
    /// Height of the ground below the ankle, metres: stairs and slopes.
    pub ground_m: f64,
    /// Of the ground along the foot, radians, rising towards the toes positive.
    pub slope_rad: f64,
}

/// What is true of a clip, read from its footstep plan, never from its poses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// `[frame]`: the left foot is on the ground.
    pub left_contact: Vec<bool>,
    /// `[frame]`: the right foot is on the ground.
    pub right_contact: Vec<bool>,
    /// `[frame]`: never [`Gait::Other`].
    pub gait: Vec<Gait>,
    /// Every stance that touches the clip, by strike time, left before right.
    pub stances: Vec<TrueStance>,
}

/// A clip that was made, with what is true of it.
#[derive(Clone, Debug)]
pub struct SyntheticClip {
    /// As in its spec.
    pub name: String,
    /// Channels in file units.
    pub clip: Clip,
    /// The text of the subject's ASF file; none for BVH, whose files carry their skeleton.
    pub asf: Option<String>,
    /// From the footstep plan.
    pub truth: Truth,
}

/// What can't be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MakeError {
    /// The acts can't be planned.
    #[error("clip {name}: {error}")]
    Plan {
        /// Name of the clip.
        name: String,
        /// Why.
        error: PlanError,
    },
    /// No such rate.
    #[error("clip {name}: {rate_hz} frames a second; a divisor of 240 is needed, such as 30, 60 or 120")]
    Rate {
        /// Name of the clip.
        name: String,
        /// As given.
        rate_hz: u32,
    },
    /// A field of the spec that has no meaning or lies outside what a body does.
    #[error("clip {name}: {what} is {found}, must lie in {low} to {high}")]
    Range {
        /// Name of the clip.
        name: String,
        /// Which field.
        what: &'static str,
        /// As given.
        found: f64,
        /// Least.
        low: f64,
        /// Most.
        high: f64,
    },
}

/// Makes a clip in the format asked for: the same motion in either.
///
/// A pure function of its arguments: the same bits on every machine.
///
/// # Errors
/// [`MakeError`] for acts, rates and bodies that have no meaning.
pub fn make(spec: &ClipSpec, format: Format) -> Result<SyntheticClip, MakeError> {
    let name = || spec.name.clone();
    if spec.rate_hz == 0 || !GRID_HZ.is_multiple_of(spec.rate_hz) {
        return Err(MakeError::Rate { name: name(), rate_hz: spec.rate_hz });
    }
    let subject = ("subject.height_m", spec.subject.height_m, [1.2, 2.1]);
    let heading = ("yaw_rad", spec.yaw_rad, [-1e3, 1e3]);
    let wrong = [subject, heading].into_iter().find(|(_, value, [low, high])| !(low..=high).contains(&value));
    if let Some((what, found, [low, high])) = wrong.or(spec.style.out_of_range()) {
        return Err(MakeError::Range { name: name(), what, found, low, high });
    }
    let body = Body::new(&spec.subject);
    let plan = footsteps(spec, &body).map_err(|error| MakeError::Plan { name: name(), error })?;
    let mut draws = Draws::new(spec.seed, &spec.name, "idle");
    let mover = Mover::new(&plan, &body, &spec.style, &spec.actions, &mut draws);
    let n_frames = frames(&plan, spec.rate_hz);
    let postures = (0..n_frames).map(|frame| mover.posture(sample(&plan, spec.rate_hz, frame)));
    let (skeleton, unit_m) = match format {
        Format::Amc => (acclaim_skeleton(&spec.subject), ASF_UNIT_M),
        Format::Bvh => (bvh_skeleton(&spec.subject), BVH_UNIT_M),
    };
    let channels = channels(&skeleton, unit_m, postures);
    Ok(SyntheticClip {
        name: name(),
        clip: Clip {
            skeleton: Arc::new(skeleton),
            rate_hz: f64::from(spec.rate_hz),
            unit_m,
            up: UpAxis::Y,
            n_frames,
            channels,
        },
        asf: (format == Format::Amc).then(|| asf_text(&spec.subject)),
        truth: truth(&plan, spec.rate_hz),
    })
}

/// The footstep plan of a clip.
fn footsteps(spec: &ClipSpec, body: &Body) -> Result<Plan, PlanError> {
    let footing = Footing {
        leg_m: body.leg_m(),
        cadence: spec.style.cadence,
        step_width: spec.style.step_width,
        toe_out_rad: spec.style.toe_out_rad,
        duty: spec.style.duty,
        limp: spec.style.limp,
        heel_strike: spec.style.heel_strike,
        clearance: spec.style.clearance,
    };
    plan(&spec.acts, &footing, spec.yaw_rad, &mut Draws::new(spec.seed, &spec.name, "footsteps"))
}

fn frames(plan: &Plan, rate_hz: u32) -> usize {
    (plan.duration_s * f64::from(rate_hz)).floor() as usize + 1
}

fn sample(plan: &Plan, rate_hz: u32, frame: usize) -> usize {
    plan.path.index(0.0) + frame * (GRID_HZ / rate_hz) as usize
}

fn truth(plan: &Plan, rate_hz: u32) -> Truth {
    let times: Vec<f64> = (0..frames(plan, rate_hz)).map(|frame| frame as f64 / f64::from(rate_hz)).collect();
    let last_s = times.last().copied().unwrap_or(0.0);
    let mut stances: Vec<TrueStance> = [Foot::Left, Foot::Right]
        .into_iter()
        .flat_map(|foot| plan.stances[foot as usize].iter().map(move |stance| (foot, stance)))
        .filter(|(_, stance)| stance.lift_s > 0.0 && stance.strike_s <= last_s)
        .map(|(foot, stance)| TrueStance {
            foot,
            strike_s: stance.strike_s,
            lift_s: stance.lift_s,
            ground_m: stance.ground_m,
            slope_rad: stance.slope_rad,
        })
        .collect();
    stances.sort_by(|a, b| a.strike_s.total_cmp(&b.strike_s).then(a.foot.cmp(&b.foot)));
    Truth {
        left_contact: times.iter().map(|&t| plan.contact(Foot::Left, t)).collect(),
        right_contact: times.iter().map(|&t| plan.contact(Foot::Right, t)).collect(),
        gait: times.iter().map(|&t| plan.gait(t)).collect(),
        stances,
    }
}

/// Postures as the channels of a skeleton with the joints of [`acclaim_skeleton`], angles without jumps.
fn channels(skeleton: &Skeleton, unit_m: f64, postures: impl Iterator<Item = Posture>) -> Vec<f32> {
    let rests: Vec<DQuat> =
        skeleton.joints.iter().map(|joint| joint.axis.map_or(DQuat::IDENTITY, rest_rotation)).collect();
    let orders: Vec<[Axis; 3]> = skeleton
        .joints
        .iter()
        .map(|joint| match skeleton.format {
            // The last of the axis letters is the outermost.
            Format::Amc => joint.axis.map_or([Axis::Z, Axis::Y, Axis::X], |axis| {
                let [a, b, c] = axis.order;
                [c, b, a]
            }),
            Format::Bvh if joint.parent.is_none() => [Axis::Y, Axis::X, Axis::Z],
            Format::Bvh => [Axis::Z, Axis::Y, Axis::X],
        })
        .collect();
    let mut previous = [[0.0; 3]; joint::COUNT];
    let mut channels = Vec::new();
    for posture in postures {
        for (index, joint) in skeleton.joints.iter().enumerate() {
            let rest = rests[index];
            let turn = rest.conjugate() * posture.local[index] * rest;
            previous[index] = euler_near(turn, orders[index], previous[index]);
            for channel in &joint.channels {
                channels.push(match channel.kind {
                    ChannelKind::Position => posture.root_m[channel.axis.index()] / unit_m,
                    _ => {
                        let at = orders[index].iter().position(|&axis| axis == channel.axis).unwrap_or(0);
                        previous[index][at].to_degrees()
                    }
                } as f32);
            }
        }
    }
    channels
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::motion::kinematics::poses;
    use crate::procedural::corpus;
    use crate::procedural::pace::GRAVITY_MPS2;
    use glam::DVec3;

    fn spec(name: &str) -> ClipSpec {
        corpus(20, 1).into_iter().find(|spec| spec.name == name).unwrap()
    }

    #[test]
    fn the_same_spec_gives_the_same_bits_and_the_seed_matters() {
        let bits = |spec: &ClipSpec| -> Vec<u32> {
            make(spec, Format::Amc).unwrap().clip.channels.iter().map(|value| value.to_bits()).collect()
        };
        let walk = spec("walk_01");
        assert_eq!(bits(&walk), bits(&walk));
        assert_ne!(bits(&walk), bits(&ClipSpec { seed: 2, ..walk.clone() }));
    }

    #[test]
    fn both_formats_put_every_joint_in_the_same_place() {
        for name in ["walk_turn_left_01", "jump_forward_01", "stand_wave_right_01"] {
            let (acclaim, bvh) = (make(&spec(name), Format::Amc).unwrap(), make(&spec(name), Format::Bvh).unwrap());
            assert_eq!(acclaim.truth, bvh.truth);
            let (a, b) = (poses(&acclaim.clip), poses(&bvh.clip));
            assert_eq!((a.n_frames, a.n_points), (b.n_frames, b.n_points));
            let worst = a.world.iter().zip(&b.world).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            assert!(worst < 2e-5, "{name}: {worst} m");
        }
    }

    #[test]
    fn channels_are_finite_and_angles_do_not_jump() {
        for spec in corpus(20, 5) {
            for format in [Format::Amc, Format::Bvh] {
                let clip = make(&spec, format).unwrap().clip;
                assert!(clip.channels.iter().all(|value| value.is_finite()), "{}", spec.name);
                let first = clip.skeleton.first_channels()[joint::FEMUR[0]];
                for frame in 1..clip.n_frames {
                    let (before, now) = (clip.frame(frame - 1), clip.frame(frame));
                    // Thighs stay far from the locks of Euler angles, so any jump would be a fault.
                    for channel in first..first + 3 {
                        let step = (now[channel] - before[channel]).abs() * spec.rate_hz as f32;
                        assert!(step < 2000.0, "{} frame {frame}: {step} degrees a second", spec.name);
                    }
                }
            }
        }
    }

    #[test]
    fn what_the_file_says_is_what_was_posed() {
        let spec = spec("run_turn_left_01");
        let body = Body::new(&spec.subject);
        let plan = footsteps(&spec, &body).unwrap();
        let mover =
            Mover::new(&plan, &body, &spec.style, &spec.actions, &mut Draws::new(spec.seed, &spec.name, "idle"));
        let poses = poses(&make(&spec, Format::Amc).unwrap().clip);
        for frame in (0..poses.n_frames).step_by(17) {
            let placed = body.place(&mover.posture(sample(&plan, spec.rate_hz, frame)));
            for joint in 0..joint::COUNT {
                assert!((poses.at(frame, joint) - placed.position_m[joint]).length() < 1e-5, "{frame} {joint}");
            }
        }
    }

    #[test]
    fn the_center_of_mass_falls_freely_in_every_flight() {
        let hop = Act::Hop { foot: Foot::Left, hops: 5, height_m: 0.08, forward_m: 0.2 };
        let others = [
            ("jog", vec![Act::Jog { seconds: 4.0, lift: 0.15 }]),
            ("hop", vec![Act::Stand { seconds: 1.0 }, hop, Act::Stand { seconds: 1.0 }]),
        ];
        let others = others.map(|(name, acts)| ClipSpec { name: name.to_owned(), acts, ..spec("run_01") });
        let specs = ["run_01", "run_fast_01", "jump_01", "jump_forward_01"].map(spec);
        for spec in specs.into_iter().chain(others) {
            let name = &spec.name;
            let body = Body::new(&spec.subject);
            let plan = footsteps(&spec, &body).unwrap();
            let mover =
                Mover::new(&plan, &body, &spec.style, &spec.actions, &mut Draws::new(spec.seed, &spec.name, "idle"));
            let height_m = |index: usize| body.mass_center_m(&body.place(&mover.posture(index))).y;
            let mut n_flights = 0;
            for flight in plan.flights() {
                if flight.takeoff_s < 0.0 || flight.landing_s > plan.duration_s {
                    continue;
                }
                n_flights += 1;
                let (from, to) = (plan.path.index(flight.takeoff_s) + 1, plan.path.index(flight.landing_s) - 1);
                // Speed lost between the two halves, over the time between their middles.
                let half_s = 0.5 * (to - from) as f64 / f64::from(GRID_HZ);
                let middle = (from + to) / 2;
                let speed = |a: usize, b: usize| (height_m(b) - height_m(a)) * f64::from(GRID_HZ) / (b - a) as f64;
                let fall = (speed(from, middle) - speed(middle, to)) / half_s;
                assert!((fall / GRAVITY_MPS2 - 1.0).abs() < 0.08, "{name} {}: {fall} m/s^2", flight.takeoff_s);
            }
            assert!(n_flights >= 4, "{name}: {n_flights} flights");
        }
    }

    #[test]
    fn gestures_happen_where_and_when_they_are_asked_for() {
        let raised = spec("stand_raise_left_01");
        let action = raised.actions[0];
        let made = make(&raised, Format::Amc).unwrap();
        let poses = poses(&made.clip);
        let above_head = |time_s: f64, side: usize| {
            let frame = (time_s * made.clip.rate_hz) as usize;
            poses.at(frame, joint::WRIST[side]).y - poses.at(frame, joint::HEAD).y
        };
        let middle_s = action.start_s + 0.5 * action.seconds;
        assert!(above_head(middle_s, 0) > 0.1, "{}", above_head(middle_s, 0));
        assert!(above_head(middle_s, 1) < -0.3, "the other arm hangs");
        assert!(above_head(0.0, 0) < -0.3);
        let waving = spec("stand_wave_right_01");
        let (made, action) = (make(&waving, Format::Amc).unwrap(), waving.actions[0]);
        let poses = crate::motion::kinematics::poses(&made.clip);
        let (from, to) = (action.start_s + 1.0, action.start_s + action.seconds - 1.0);
        let frames = (from * made.clip.rate_hz) as usize..(to * made.clip.rate_hz) as usize;
        let turns = frames
            .clone()
            .skip(2)
            .filter(|&frame| {
                let x =
                    |frame| (poses.at(frame, joint::WRIST[1]) - poses.at(frame, joint::RADIUS[1])).dot(across(&poses));
                (x(frame) - x(frame - 1)) * (x(frame - 1) - x(frame - 2)) < 0.0
            })
            .count() as f64;
        let wanted = 2.0 * action.rate_hz * (to - from);
        assert!((turns - wanted).abs() < 2.1, "the forearm turns {turns} times, {wanted} asked for");
    }

    fn across(poses: &crate::motion::Poses) -> DVec3 {
        (poses.at(0, joint::FEMUR[0]) - poses.at(0, joint::FEMUR[1])).normalize()
    }

    #[test]
    fn what_has_no_meaning_is_refused_by_name() {
        let good = spec("walk_01");
        let refused = |spec: ClipSpec| make(&spec, Format::Amc).unwrap_err().to_string();
        assert!(refused(ClipSpec { rate_hz: 50, ..good.clone() }).contains("50 frames"));
        assert!(refused(ClipSpec { rate_hz: 0, ..good.clone() }).contains("0 frames"));
        let tall = Subject { height_m: 2.5, ..good.subject.clone() };
        assert!(refused(ClipSpec { subject: tall, ..good.clone() }).contains("subject.height_m is 2.5"));
        let style = Style { cadence: f64::NAN, ..good.style };
        assert!(refused(ClipSpec { style, ..good.clone() }).contains("cadence is NaN"));
        assert!(refused(ClipSpec { yaw_rad: f64::INFINITY, ..good.clone() }).contains("yaw_rad"));
        assert!(refused(ClipSpec { acts: Vec::new(), ..good }).contains("at least one act"));
    }
}
