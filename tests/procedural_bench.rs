//! Every kind of the bench does what its name says, by its truth and by its poses.

use glam::DVec3;
use motionmill::annotate::{Foot, Gait};
use motionmill::motion::kinematics::poses;
use motionmill::motion::{Format, Poses};
use motionmill::procedural::{Act, BenchGroup, ClipSpec, Draws, Style, SyntheticClip, TrueStance, bench, make};

const ROOT: usize = 0;
const ANKLE: [usize; 2] = [4, 9];
const HEAD: usize = 16;
const HUMERUS: [usize; 2] = [18, 25];
const RADIUS: [usize; 2] = [19, 26];
const WRIST: [usize; 2] = [20, 27];

fn of_kind(kind: &str) -> Vec<(ClipSpec, SyntheticClip, Poses)> {
    let specs = bench(160, 21).into_iter().filter(|spec| spec.name.rsplit_once('_').is_some_and(|it| it.0 == kind));
    let made: Vec<_> = specs
        .map(|spec| {
            let made = make(&spec, Format::Amc).unwrap();
            let poses = poses(&made.clip);
            (spec, made, poses)
        })
        .collect();
    assert_eq!(made.len(), 4, "{kind}");
    made
}

/// Feet on the ground, frame by frame.
fn feet(made: &SyntheticClip) -> Vec<usize> {
    let truth = &made.truth;
    truth.left_contact.iter().zip(&truth.right_contact).map(|(&l, &r)| usize::from(l) + usize::from(r)).collect()
}

fn share(made: &SyntheticClip, gait: Gait) -> f64 {
    made.truth.gait.iter().filter(|&&found| found == gait).count() as f64 / made.truth.gait.len() as f64
}

/// Forward, up and left in the body's own directions at the first frame.
fn axes(spec: &ClipSpec) -> [DVec3; 2] {
    let (sin, cos) = libm::sincos(spec.yaw_rad);
    [DVec3::new(sin, 0.0, cos), DVec3::new(cos, 0.0, -sin)]
}

fn inner(made: &SyntheticClip, foot: Foot) -> Vec<TrueStance> {
    let end_s = made.truth.gait.len() as f64 / made.clip.rate_hz;
    let whole = |s: &&TrueStance| s.foot == foot && s.strike_s > 0.0 && s.lift_s < end_s;
    made.truth.stances.iter().filter(whole).copied().collect()
}

#[test]
fn a_bench_is_made_whole_and_every_gait_fits_its_feet() {
    for spec in bench(160, 21) {
        let made = make(&spec, Format::Bvh).unwrap();
        assert!(made.clip.n_frames > spec.rate_hz as usize, "{}", spec.name);
        assert!(BenchGroup::of(&spec).is_some());
        for (frame, (&feet, &gait)) in feet(&made).iter().zip(&made.truth.gait).enumerate() {
            let fits = match gait {
                Gait::Stand => feet == 2,
                Gait::Walk => feet >= 1,
                // Between a walk and a run both feet may be down.
                Gait::Run => feet <= 1 || spec.name.starts_with("walk_run_walk"),
                Gait::Jump => true,
                Gait::Unknown | Gait::Other => false,
            };
            assert!(fits, "{} frame {frame}: {feet} feet in a {gait:?}", spec.name);
        }
    }
}

#[test]
fn back_and_aside_and_on_the_spot_go_where_they_say() {
    let gone = |spec: &ClipSpec, poses: &Poses| {
        let way = poses.at(poses.n_frames - 1, ROOT) - poses.at(0, ROOT);
        axes(spec).map(|axis| way.dot(axis))
    };
    for (spec, made, poses) in of_kind("walk_back") {
        let [ahead_m, left_m] = gone(&spec, &poses);
        assert!(ahead_m < -1.5 && left_m.abs() < 0.15, "{}: {ahead_m} {left_m}", spec.name);
        assert_eq!(share(&made, Gait::Walk), 1.0);
    }
    for (kind, sign) in [("walk_aside_left", 1.0), ("walk_aside_right", -1.0)] {
        for (spec, made, poses) in of_kind(kind) {
            let [ahead_m, left_m] = gone(&spec, &poses);
            assert!(sign * left_m > 1.0 && ahead_m.abs() < 0.15, "{}: {ahead_m} {left_m}", spec.name);
            assert_eq!(share(&made, Gait::Walk), 1.0);
            let [_, left] = axes(&spec);
            for frame in 0..poses.n_frames {
                let apart_m = (poses.at(frame, ANKLE[0]) - poses.at(frame, ANKLE[1])).dot(left);
                assert!(apart_m > 0.06, "{} frame {frame}: the feet cross, {apart_m}", spec.name);
            }
        }
    }
    for (kind, gait) in [("march", Gait::Walk), ("jog", Gait::Run)] {
        for (spec, made, poses) in of_kind(kind) {
            let [ahead_m, left_m] = gone(&spec, &poses);
            assert!(ahead_m.abs() < 0.1 && left_m.abs() < 0.2, "{}: {ahead_m} {left_m}", spec.name);
            assert_eq!(share(&made, gait), 1.0);
            assert!(made.truth.stances.len() > 8, "{} steps", made.truth.stances.len());
            assert_eq!(feet(&made).contains(&0), gait == Gait::Run);
        }
    }
}

#[test]
fn a_limp_is_short_on_one_foot_and_a_sneak_is_low_and_long_on_both() {
    let stance_s = |made: &SyntheticClip, foot| {
        let stances = inner(made, foot);
        stances.iter().map(|s| s.lift_s - s.strike_s).sum::<f64>() / stances.len() as f64
    };
    for (kind, lame, sound) in [("limp_right", Foot::Right, Foot::Left), ("limp_left", Foot::Left, Foot::Right)] {
        for (spec, made, _) in of_kind(kind) {
            assert!(stance_s(&made, lame) < 0.9 * stance_s(&made, sound), "{}", spec.name);
            assert_eq!(share(&made, Gait::Walk), 1.0);
        }
    }
    let standing = of_kind("stand");
    let head_share = |(spec, _, poses): &(ClipSpec, SyntheticClip, Poses)| {
        let heads = (0..poses.n_frames).map(|frame| poses.at(frame, HEAD).y);
        heads.sum::<f64>() / poses.n_frames as f64 / spec.subject.height_m
    };
    for kind in ["sneak", "tired"] {
        for clip in of_kind(kind) {
            let lower = head_share(&standing[0]) - head_share(&clip);
            assert!(lower > 0.015, "{}: {lower} of the height", clip.0.name);
            let both = feet(&clip.1).iter().filter(|&&feet| feet == 2).count() as f64 / clip.1.clip.n_frames as f64;
            assert!(both > 0.24, "{}: both feet down in {both}", clip.0.name);
        }
    }
}

#[test]
fn hops_are_of_one_foot_and_the_other_is_held_up() {
    for (kind, hopping) in [("hop_left", 0), ("hop_right", 1), ("hop_right_forward", 1)] {
        for (spec, made, poses) in of_kind(kind) {
            let Some(&Act::Hop { foot, hops, forward_m, .. }) = spec.acts.get(1) else { panic!("{kind}") };
            assert_eq!(foot as usize, hopping);
            let contact = [&made.truth.left_contact, &made.truth.right_contact];
            let jumping: Vec<usize> =
                (0..made.clip.n_frames).filter(|&frame| made.truth.gait[frame] == Gait::Jump).collect();
            assert!(jumping.iter().all(|&frame| !contact[1 - hopping][frame]), "{}", spec.name);
            assert_eq!(jumping.last().unwrap() - jumping[0] + 1, jumping.len(), "one stretch");
            let takeoffs = jumping.windows(2).filter(|pair| contact[hopping][pair[0]] && !contact[hopping][pair[1]]);
            assert_eq!(takeoffs.count(), hops as usize, "{}", spec.name);
            let settled = |frame: &&usize| {
                let within = |frame: usize| made.truth.gait.get(frame) == Some(&Gait::Jump);
                let margin = (0.5 * made.clip.rate_hz) as usize;
                within(**frame + margin) && within(frame.saturating_sub(margin))
            };
            let least_m = jumping.iter().filter(settled).map(|&frame| poses.at(frame, ANKLE[1 - hopping]).y);
            let least_m = least_m.fold(9.0, f64::min) / spec.subject.height_m;
            assert!(least_m > 0.10, "{}: the held foot is at {least_m} of the height", spec.name);
            let way = poses.at(poses.n_frames - 1, ROOT) - poses.at(0, ROOT);
            let wanted_m = f64::from(hops) * forward_m;
            assert!((way.dot(axes(&spec)[0]) - wanted_m).abs() < 0.15 + 0.12 * wanted_m, "{}: {way}", spec.name);
        }
    }
}

#[test]
fn stairs_and_slopes_lead_as_high_as_they_say() {
    for (kind, sign) in [("stairs_up", 1.0), ("stairs_down", -1.0)] {
        for (spec, made, poses) in of_kind(kind) {
            let Some(&Act::Stairs { treads, riser_m, tread_m, .. }) = spec.acts.get(1) else { panic!("{kind}") };
            assert_eq!(riser_m.signum(), sign);
            let risen_m = poses.at(poses.n_frames - 1, ROOT).y - poses.at(0, ROOT).y;
            assert!((risen_m - f64::from(treads) * riser_m).abs() < 0.02, "{}: {risen_m} m", spec.name);
            for n in 1..=treads {
                // One foot on each tread, at its own height.
                let on = |s: &&TrueStance| (s.ground_m - f64::from(n) * riser_m).abs() < 1e-9;
                assert!(made.truth.stances.iter().any(|s| on(&s)), "{} tread {n}", spec.name);
            }
            let at = |s: &TrueStance| {
                let frame = 0.5 * (s.strike_s + s.lift_s) * made.clip.rate_hz;
                poses.at(frame as usize, ANKLE[s.foot as usize])
            };
            let stances = &made.truth.stances;
            for pair in stances.windows(2).filter(|p| p[0].ground_m != 0.0 && p[0].ground_m != p[1].ground_m) {
                let step_m = (at(&pair[1]) - at(&pair[0])).dot(axes(&spec)[0]);
                assert!((step_m - tread_m).abs() < 0.01, "{}: {step_m} m from tread to tread", spec.name);
            }
        }
    }
    for (kind, sign) in [("slope_up", 1.0), ("slope_down", -1.0)] {
        for (spec, made, poses) in of_kind(kind) {
            let Some(&Act::Slope { incline_rad, .. }) = spec.acts.first() else { panic!("{kind}") };
            let way = poses.at(poses.n_frames - 1, ROOT) - poses.at(0, ROOT);
            let incline = libm::atan2(way.y, way.dot(axes(&spec)[0]));
            assert!(sign * incline_rad > 0.0 && (incline - incline_rad).abs() < 0.02, "{}: {incline}", spec.name);
            assert!(made.truth.stances.iter().all(|s| (s.slope_rad - incline_rad).abs() < 0.01));
        }
    }
}

/// Any act, ready to follow any other: those that need a stand bring one.
fn any(draws: &mut Draws) -> Vec<Act> {
    let seconds = draws.uniform(1.5, 3.0);
    let turn_rate_radps = draws.uniform(-0.4, 0.4);
    let [foot, other] = if draws.pick(2) == 0 { [Foot::Left, Foot::Right] } else { [Foot::Right, Foot::Left] };
    let stand = Act::Stand { seconds: draws.uniform(0.3, 1.0) };
    match draws.pick(11) {
        0 => vec![stand],
        1 => vec![Act::Walk { seconds, speed_mps: draws.uniform(0.5, 1.6), turn_rate_radps }],
        2 => vec![Act::Run { seconds, speed_mps: draws.uniform(1.8, 3.0), turn_rate_radps }],
        3 => vec![Act::Back { seconds, speed_mps: draws.uniform(0.4, 1.0), turn_rate_radps }],
        4 => vec![Act::Aside { seconds, speed_mps: draws.uniform(0.2, 0.5), toward: foot }],
        5 => vec![Act::March { seconds, lift: draws.uniform(0.1, 0.3) }],
        6 => vec![Act::Jog { seconds, lift: draws.uniform(0.1, 0.2) }],
        7 => vec![Act::Slope { seconds, speed_mps: draws.uniform(0.6, 1.3), incline_rad: draws.uniform(-0.14, 0.14) }],
        8 => {
            let riser_m = draws.uniform(0.14, 0.18) * if draws.pick(2) == 0 { 1.0 } else { -1.0 };
            vec![Act::Stairs { treads: 4, tread_m: 0.28, riser_m, cadence_spm: draws.uniform(80.0, 100.0) }]
        }
        9 => vec![stand, Act::Hop { foot, hops: 3, height_m: 0.07, forward_m: draws.uniform(0.0, 0.3) }],
        _ => {
            let jump = Act::Jump { height_m: draws.uniform(0.1, 0.25), forward_m: draws.uniform(0.0, 0.5) };
            vec![stand, jump, Act::Balance { lifted: other, seconds: 1.0 }]
        }
    }
}

#[test]
fn any_act_can_follow_any_other() {
    for seed in 0..40 {
        let mut draws = Draws::new(seed, "any", "acts");
        let acts: Vec<Act> = (0..6).flat_map(|_| any(&mut draws)).collect();
        let like = bench(1, seed).remove(0);
        let style = Style { limp: draws.uniform(-0.2, 0.2), ..Style::ORDINARY };
        let spec = ClipSpec { acts, style, rate_hz: 60, ..like };
        let made = make(&spec, Format::Amc).unwrap();
        assert!(made.clip.channels.iter().all(|value| value.is_finite()), "seed {seed}");
        for foot in [Foot::Left, Foot::Right] {
            let stances: Vec<&TrueStance> = made.truth.stances.iter().filter(|s| s.foot == foot).collect();
            for pair in stances.windows(2) {
                let swing_s = pair[1].strike_s - pair[0].lift_s;
                assert!(pair[0].strike_s < pair[0].lift_s && swing_s > 0.08, "seed {seed}: {pair:?} {:#?}", spec.acts);
            }
        }
        for (frame, (&feet, &gait)) in feet(&made).iter().zip(&made.truth.gait).enumerate() {
            let fits = match gait {
                Gait::Stand => feet == 2,
                Gait::Walk => feet >= 1,
                _ => true,
            };
            assert!(fits, "seed {seed} frame {frame}: {feet} feet in a {gait:?} {:#?}", spec.acts);
        }
        let poses = poses(&made.clip);
        for stance in &made.truth.stances {
            let side = stance.foot as usize;
            let margin_s = (0.25 * (stance.lift_s - stance.strike_s)).min(0.3);
            let planted = |frame: &usize| {
                let time_s = *frame as f64 / 60.0;
                stance.strike_s + margin_s <= time_s && time_s < stance.lift_s - margin_s
            };
            let frames: Vec<usize> = (0..poses.n_frames).filter(planted).collect();
            let Some(&middle) = frames.get(frames.len() / 2) else { continue };
            for frame in frames {
                let moved_m = (poses.at(frame, ANKLE[side] + 1) - poses.at(middle, ANKLE[side] + 1)).length();
                assert!(moved_m < 0.02, "seed {seed} frame {frame}: the foot slides {moved_m} m {:#?}", spec.acts);
            }
        }
    }
}

#[test]
fn arms_reach_and_carry_in_front() {
    for (spec, made, poses) in of_kind("stand_reach_left") {
        let action = spec.actions[0];
        let frame = ((action.start_s + 0.5 * action.seconds) * made.clip.rate_hz) as usize;
        let reach =
            |frame, side: usize| (poses.at(frame, WRIST[side]) - poses.at(frame, HUMERUS[side])).dot(axes(&spec)[0]);
        let arm_m = 0.26 * spec.subject.height_m;
        assert!(reach(frame, 0) > 0.7 * arm_m, "{}: {}", spec.name, reach(frame, 0));
        assert!(reach(frame, 1) < 0.5 * arm_m && reach(0, 0) < 0.5 * arm_m, "{}", spec.name);
    }
    for (spec, made, poses) in of_kind("walk_carry") {
        let action = spec.actions[0];
        let middle = ((action.start_s + 0.5 * action.seconds) * made.clip.rate_hz) as usize;
        for frame in middle - 5..middle + 5 {
            for side in 0..2 {
                let forearm = (poses.at(frame, WRIST[side]) - poses.at(frame, RADIUS[side])).normalize();
                assert!(forearm.dot(axes(&spec)[0]) > 0.8, "{} {forearm}", spec.name);
            }
        }
    }
}

/// The same bits on every machine and in every build profile. A change of the generator changes this on purpose.
#[test]
fn the_bench_is_the_same_everywhere() {
    let mut hasher = blake3::Hasher::new();
    for spec in bench(40, 1) {
        let made = make(&spec, Format::Bvh).unwrap();
        for value in &made.clip.channels {
            hasher.update(&value.to_le_bytes());
        }
        for stance in &made.truth.stances {
            hasher.update(&stance.strike_s.to_le_bytes());
            hasher.update(&stance.lift_s.to_le_bytes());
        }
    }
    assert_eq!(hasher.finalize().to_hex().as_str(), "39964bc13da4fb8300308d66c5ec9dd4829d7f46123060794aa07602d8f506f1");
}
