//! Made people move like people: feet that stay where they stand, bones that keep their length, bodies that fall freely.

use glam::DVec3;
use motionmill::annotate::{Foot, Gait};
use motionmill::motion::kinematics::poses;
use motionmill::motion::{Format, Poses, Role, RoleMap};
use motionmill::picture::{Layout, Strip, View, spread, strips};
use motionmill::procedural::{Act, ClipSpec, SyntheticClip, TrueStance, bench, corpus, make};

const KNEE: [usize; 2] = [3, 8];
const HIP: [usize; 2] = [2, 7];
const ANKLE: [usize; 2] = [4, 9];
const BALL: [usize; 2] = [5, 10];

fn roles() -> RoleMap {
    let mut roles = RoleMap::default();
    for (role, point) in [
        (Role::Hips, 0),
        (Role::ThighLeft, 2),
        (Role::ToeLeft, 5),
        (Role::ThighRight, 7),
        (Role::ToeRight, 10),
        (Role::Head, 16),
        (Role::ClavicleLeft, 17),
        (Role::ClavicleRight, 24),
    ] {
        roles.set(role, point);
    }
    roles
}

fn made(spec: &ClipSpec) -> (SyntheticClip, Poses) {
    let made = make(spec, Format::Amc).unwrap();
    let poses = poses(&made.clip);
    (made, poses)
}

const TOE_TIP: [usize; 2] = [31, 32];

/// Height of the ground below a point: a plane on slopes, treads on stairs, else the floor.
fn ground<'a>(spec: &ClipSpec, made: &SyntheticClip, poses: &'a Poses) -> Box<dyn Fn(DVec3) -> f64 + 'a> {
    let (sin, cos) = libm::sincos(spec.yaw_rad);
    let along = move |at: DVec3| at.x * sin + at.z * cos;
    for act in &spec.acts {
        match *act {
            Act::Slope { incline_rad, .. } => return Box::new(move |at| libm::tan(incline_rad) * along(at)),
            Act::Stairs { riser_m, .. } => {
                let heel_m = 0.05 * spec.subject.height_m / 1.75;
                let mut feet: Vec<(f64, f64, f64)> = (made.truth.stances.iter())
                    .map(|stance| {
                        let (start_s, end_s) =
                            (stance.strike_s.max(0.0), stance.lift_s.min(made.truth.gait.len() as f64));
                        let middle = (0.5 * (start_s + end_s) * made.clip.rate_hz) as usize;
                        let frame = if stance.lift_s.is_finite() { middle } else { poses.n_frames - 1 };
                        let [ankle, tip] =
                            [ANKLE, TOE_TIP].map(|point| along(poses.at(frame, point[stance.foot as usize])));
                        (ankle - heel_m, tip, stance.ground_m)
                    })
                    .collect();
                feet.sort_by(|a, b| a.0.total_cmp(&b.0));
                // A tread begins ahead of the toes on the lower one, 3 cm from them or from the heel on the lower one.
                let edges: Vec<(f64, f64)> = (feet.windows(2).filter(|pair| pair[0].2 != pair[1].2))
                    .map(|pair| (if riser_m > 0.0 { pair[0].1 + 0.03 } else { pair[1].0 - 0.03 }, pair[1].2))
                    .collect();
                let first_m = feet[0].2;
                return Box::new(move |at| {
                    edges.iter().rev().find(|edge| edge.0 < along(at)).map_or(first_m, |edge| edge.1)
                });
            }
            _ => {}
        }
    }
    Box::new(|_| 0.0)
}

/// Set `MOTIONMILL_STRIPS` to a folder to look at the clips.
#[test]
fn strips_can_be_drawn_of_every_clip() {
    let folder = std::env::var_os("MOTIONMILL_STRIPS").map(std::path::PathBuf::from);
    let benched = bench(40, 1).into_iter().map(|spec| ClipSpec { name: format!("bench_{}", spec.name), ..spec });
    for spec in corpus(20, 1).into_iter().chain(benched) {
        let (made, poses) = made(&spec);
        // A second and a quarter from the middle.
        let middle = made.clip.n_frames / 2;
        let frames = spread(middle, made.clip.n_frames.min(middle + (1.25 * made.clip.rate_hz) as usize), 14);
        let all = spread(0, made.clip.n_frames, 24);
        let contacts = Some([made.truth.left_contact.as_slice(), made.truth.right_contact.as_slice()]);
        let roles = roles();
        let strip = |frames, view, layout| Strip {
            title: &spec.name,
            poses: &poses,
            skeleton: &made.clip.skeleton,
            roles: &roles,
            rate_hz: made.clip.rate_hz,
            frames,
            contacts,
            ground_m: 0.0,
            view,
            layout,
        };
        let svg = strips(&[
            strip(&frames, View::Side, Layout::Row),
            strip(&frames, View::Front, Layout::Row),
            strip(&all, View::Side, Layout::Path),
        ]);
        assert!(svg.len() > 10_000, "{}", spec.name);
        if let Some(folder) = &folder {
            std::fs::write(folder.join(format!("{}.svg", spec.name)), svg).unwrap();
        }
    }
}

/// Frames of one foot's stances that lie wholly inside the clip, or touch its ends: half-open.
fn stances(contact: &[bool]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for frame in 0..=contact.len() {
        match (start, contact.get(frame).copied().unwrap_or(false)) {
            (None, true) => start = Some(frame),
            (Some(first), false) => {
                found.push((first, frame));
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn contacts(made: &SyntheticClip) -> [&[bool]; 2] {
    [&made.truth.left_contact, &made.truth.right_contact]
}

/// A corpus with bodies of many sizes.
fn of_the_corpus() -> Vec<ClipSpec> {
    corpus(300, 11).into_iter().enumerate().filter(|(index, _)| index % 60 < 20).map(|(_, spec)| spec).collect()
}

/// The same, and two rounds of the bench.
fn many() -> Vec<ClipSpec> {
    of_the_corpus().into_iter().chain(bench(80, 11)).collect()
}

#[test]
fn planted_feet_stay_where_they_are_and_nothing_goes_through_the_floor() {
    for spec in many() {
        let (made, poses) = made(&spec);
        for stance in &made.truth.stances {
            // The middle: without the roll over the heel and off the toes.
            let side = stance.foot as usize;
            let margin_s = (0.2 * (stance.lift_s - stance.strike_s)).min(0.3);
            let planted = |&frame: &usize| {
                let time_s = frame as f64 / made.clip.rate_hz;
                stance.strike_s + margin_s <= time_s && time_s < stance.lift_s - margin_s
            };
            let frames: Vec<usize> = (0..poses.n_frames).filter(planted).collect();
            let Some(&middle) = frames.get(frames.len() / 2) else { continue };
            for frame in frames {
                let moved: DVec3 = poses.at(frame, BALL[side]) - poses.at(middle, BALL[side]);
                let drift_m = DVec3::new(moved.x, 0.0, moved.z).length();
                assert!(drift_m < 0.01, "{} frame {frame}: the foot slides {drift_m} m", spec.name);
                assert!(moved.y.abs() < 0.01, "{} frame {frame}: the foot rises {} m", spec.name, moved.y);
            }
        }
        let ground = ground(&spec, &made, &poses);
        for frame in 0..poses.n_frames {
            for point in 0..poses.n_points {
                let at = poses.at(frame, point);
                let y = at.y - ground(at);
                assert!(y > -0.01, "{} frame {frame}: point {point} is at {y} m", spec.name);
            }
        }
    }
}

#[test]
fn feet_in_the_air_are_off_the_ground() {
    for spec in many() {
        let (made, poses) = made(&spec);
        let ground = ground(&spec, &made, &poses);
        let height_m = |frame: usize, point: usize| poses.at(frame, point).y - ground(poses.at(frame, point));
        for side in 0..2 {
            let contact = contacts(&made)[side];
            let resting_m = 0.05 * spec.subject.height_m / 1.75;
            for (first, end) in stances(&contact.iter().map(|on| !on).collect::<Vec<bool>>()) {
                let whole = first > 0 && end < contact.len() && end - first >= 5;
                let ankle_m = (first..end).map(|frame| height_m(frame, ANKLE[side])).fold(0.0, f64::max);
                assert!(!whole || ankle_m > 2.2 * resting_m, "{} swing {first}..{end}: {ankle_m} m", spec.name);
                for frame in first..end {
                    let ball_m = height_m(frame, BALL[side]);
                    assert!(ball_m > resting_m - 0.01, "{} frame {frame}: {ball_m} m", spec.name);
                }
            }
        }
    }
}

#[test]
fn knees_bend_forward_only_and_without_jumps() {
    for spec in many() {
        let (made, poses) = made(&spec);
        for side in 0..2 {
            let mut before = None;
            for frame in 0..poses.n_frames {
                let [hip, knee, ankle] = [HIP[side], KNEE[side], ANKLE[side]].map(|joint| poses.at(frame, joint));
                let (thigh, shank) = ((knee - hip).normalize(), (ankle - knee).normalize());
                let flexion = libm::atan2(thigh.cross(shank).length(), thigh.dot(shank));
                let left = (poses.at(frame, HIP[0]) - poses.at(frame, HIP[1])).normalize();
                assert!(thigh.cross(shank).dot(left) > 0.0, "{} frame {frame}: the knee bends backward", spec.name);
                assert!(flexion < 2.6, "{} frame {frame}: {flexion} rad", spec.name);
                if let Some(before) = before {
                    let rate: f64 = (flexion - before) * made.clip.rate_hz;
                    assert!(rate.abs() < 26.0, "{} frame {frame}: {rate} rad/s", spec.name);
                }
                before = Some(flexion);
            }
        }
    }
}

#[test]
fn bones_keep_their_length() {
    for spec in many().into_iter().step_by(7) {
        let (made, poses) = made(&spec);
        for (index, joint) in made.clip.skeleton.joints.iter().enumerate() {
            let Some(parent) = joint.parent else { continue };
            let length = |frame| (poses.at(frame, index) - poses.at(frame, parent)).length();
            let spread = (0..poses.n_frames).map(|frame| (length(frame) - length(0)).abs()).fold(0.0, f64::max);
            assert!(spread < 1e-6, "{} {}: {spread} m", spec.name, joint.name);
        }
    }
}

#[test]
fn the_truth_fits_the_name_of_the_clip() {
    for spec in of_the_corpus() {
        let (made, _) = made(&spec);
        let truth = &made.truth;
        let n = made.clip.n_frames;
        assert_eq!([truth.left_contact.len(), truth.right_contact.len(), truth.gait.len()], [n; 3]);
        let share = |gait: Gait| truth.gait.iter().filter(|&&found| found == gait).count() as f64 / n as f64;
        let feet = |frame: usize| usize::from(truth.left_contact[frame]) + usize::from(truth.right_contact[frame]);
        let flights = (0..n).filter(|&frame| feet(frame) == 0).count() as f64 / n as f64;
        match spec.name.split('_').next().unwrap() {
            "stand" if spec.name.starts_with("stand_walk") => {
                assert!(share(Gait::Stand) > 0.2 && share(Gait::Walk) > 0.3 && flights == 0.0);
            }
            "stand" => assert!(share(Gait::Stand) == 1.0 && (0..n).all(|frame| feet(frame) == 2)),
            "walk" if spec.name.starts_with("walk_run") => {
                assert!(share(Gait::Walk) > 0.3 && share(Gait::Run) > 0.2 && flights > 0.02);
            }
            "walk" => assert!(share(Gait::Walk) == 1.0 && flights == 0.0, "{}", spec.name),
            "run" => assert!(share(Gait::Run) == 1.0 && flights > 0.1, "{} {flights}", spec.name),
            "jump" => assert!(share(Gait::Jump) > 0.99 && flights > 0.1, "{} {flights}", spec.name),
            "balance" => assert!(share(Gait::Unknown) > 0.2 && share(Gait::Stand) > 0.2),
            other => panic!("no rule for {other}"),
        }
        // The stances, given to the moment, say the same as the frames.
        for (frame, &left) in truth.left_contact.iter().enumerate() {
            let time_s = frame as f64 / made.clip.rate_hz;
            let stands = |s: &&TrueStance| s.foot == Foot::Left && s.strike_s <= time_s && time_s < s.lift_s;
            assert_eq!(left, truth.stances.iter().any(|s| stands(&s)), "{} frame {frame}", spec.name);
        }
    }
}

#[test]
fn clips_of_one_subject_can_be_grafted_and_all_share_one_layout() {
    let made: Vec<SyntheticClip> = corpus(21, 1).iter().map(|spec| make(spec, Format::Amc).unwrap()).collect();
    let ids = |clip: &SyntheticClip| (clip.clip.skeleton.layout_id(), clip.clip.skeleton.skeleton_id(&[0.0; 31]));
    assert!(made[1..20].iter().all(|clip| ids(clip) == ids(&made[0]) && clip.asf == made[0].asf));
    assert_eq!(ids(&made[20]).0, ids(&made[0]).0);
    assert_ne!(ids(&made[20]).1, ids(&made[0]).1);
}

/// The same bits on every machine and in every build profile. A change of the generator changes this on purpose.
#[test]
fn the_corpus_is_the_same_everywhere() {
    let mut hasher = blake3::Hasher::new();
    for spec in corpus(20, 1) {
        for format in [Format::Amc, Format::Bvh] {
            let made = make(&spec, format).unwrap();
            for value in &made.clip.channels {
                hasher.update(&value.to_le_bytes());
            }
        }
    }
    assert_eq!(hasher.finalize().to_hex().as_str(), "0554309a299340b571617972ce5269fd86cceb3a3b63fc706116e8d7581868e2");
}
