//! What must not change foot plants and gaits, on real clips (CONTACTS 5).
//!
//! Mirrored, scaled, lifted, turned and moved clips have the same tokens, for any amount. Other rates, cuts and
//! tilts change a few: shares of equal tokens, mean and worst clip, are held to the table of CONTACTS 5.

use crate::{bandai, shared_data};
use glam::{DQuat, DVec3};
use motionmill::annotate::contacts::adaptive::adaptive_contacts;
use motionmill::annotate::contacts::foot_paths::FootPaths;
use motionmill::annotate::gait_steps::step_gaits;
use motionmill::annotate::gait_summary::clip_gait;
use motionmill::annotate::gait_tokens::Token;
use motionmill::annotate::{Gait, Settings, annotate};
use motionmill::motion::resample::{frames_at_rate, point_at};
use motionmill::motion::{Poses, Role, RoleMap};
use motionmill::procedural::{Disturbance, Draws, disturb};
use proptest::prelude::*;
use std::sync::OnceLock;

struct Captured {
    name: String,
    wanted: Gait,
    poses: Poses,
    roles: RoleMap,
}

/// Every gait clip of dataset-2.
fn gait_clips() -> &'static [Captured] {
    static CLIPS: OnceLock<Vec<Captured>> = OnceLock::new();
    CLIPS.get_or_init(|| {
        let Some(data) = shared_data::captures() else { return Vec::new() };
        let folder = data.join("bandai-namco/dataset-2");
        let named = bandai::clips_with_a_gait(&folder).into_iter();
        let gaits =
            named.map(|name| (bandai::gait_by_name(&name).unwrap(), name)).filter(|(gait, _)| *gait != Gait::Stand);
        gaits
            .map(|(wanted, name)| {
                let (poses, roles) = bandai::read(&folder.join(&name));
                Captured { name, wanted, poses, roles }
            })
            .collect()
    })
}

fn tokens(poses: &Poses, roles: &RoleMap, rate_hz: f64) -> Vec<Token> {
    adaptive_contacts(poses, roles, &FootPaths::new(poses, roles, rate_hz).unwrap()).tokens()
}

/// The clip with each position changed.
pub(crate) fn moved(poses: &Poses, each: impl Fn(DVec3) -> DVec3) -> Poses {
    Poses { world: poses.world.iter().map(|&position| each(position)).collect(), ..*poses }
}

/// Left and right exchanged.
pub(crate) fn mirrored_roles(roles: &RoleMap) -> RoleMap {
    let mut mirrored = RoleMap::default();
    for role in Role::ALL {
        let other = match role.name().rsplit_once('_') {
            Some((part, "left")) => Role::from_name(&format!("{part}_right")).unwrap(),
            Some((part, "right")) => Role::from_name(&format!("{part}_left")).unwrap(),
            _ => role,
        };
        if let Some(point) = roles.get(role) {
            mirrored.set(other, point);
        }
    }
    mirrored
}

fn mirrored(token: Token) -> Token {
    match token {
        Token::Left => Token::Right,
        Token::Right => Token::Left,
        same => same,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_clip_may_be_mirrored_scaled_lifted_turned_and_moved(
        clip in any::<prop::sample::Index>(),
        mirror in any::<bool>(),
        scale in prop::sample::select(vec![0.01, 0.7, 1.0, 1.9, 100.0]),
        floor_m in -3.0..3.0_f64,
        turn_rad in -3.2..3.2_f64,
        place in (-50.0..50.0_f64, -50.0..50.0_f64),
    ) {
        let clips = gait_clips();
        if clips.is_empty() {
            return Ok(());
        }
        let Captured { name, poses, roles, .. } = &clips[clip.index(clips.len())];
        let turn = DQuat::from_rotation_y(turn_rad);
        let there = moved(poses, |p| {
            let p = if mirror { DVec3::new(p.x, p.y, -p.z) } else { p };
            (turn * p + DVec3::new(place.0, floor_m, place.1)) * scale
        });
        let found = tokens(&there, &if mirror { mirrored_roles(roles) } else { roles.clone() }, bandai::RATE_HZ);
        let wanted: Vec<Token> = tokens(poses, roles, bandai::RATE_HZ);
        let wanted: Vec<Token> = if mirror { wanted.into_iter().map(mirrored).collect() } else { wanted };
        let differing = found.iter().zip(&wanted).filter(|(found, wanted)| found != wanted).count();
        prop_assert_eq!(differing, 0, "{}", name);
    }
}

/// The clip at another rate.
fn resampled(poses: &Poses, rate_hz: f64) -> Poses {
    let frames = frames_at_rate(poses.n_frames, bandai::RATE_HZ, rate_hz);
    let paths: Vec<Vec<DVec3>> = (0..poses.n_points).map(|point| poses.path(point)).collect();
    let world = frames.iter().flat_map(|&frame| paths.iter().map(move |path| point_at(path, frame))).collect();
    Poses { n_frames: frames.len(), n_points: poses.n_points, world }
}

fn cut(poses: &Poses, first: usize, end: usize) -> Poses {
    let world = poses.world[first * poses.n_points..end * poses.n_points].to_vec();
    Poses { n_frames: end - first, n_points: poses.n_points, world }
}

/// What a change did: clips of another class than their name's, and shares of equal tokens, mean and worst.
#[derive(Debug)]
struct Outcome {
    wrong: usize,
    mean: f64,
    worst: f64,
}

/// Changes every clip. `change` gives poses, roles and rate; `original(frame)` the frame of the clip that a frame of the
/// changed one shows, if any.
fn outcome(
    change: impl Fn(&Captured) -> (Poses, RoleMap, f64),
    original: impl Fn(&Captured, usize) -> Option<usize>,
) -> Outcome {
    let clips = gait_clips();
    let mut outcome = Outcome { wrong: 0, mean: 0.0, worst: 1.0 };
    for clip in clips {
        let (poses, roles, rate_hz) = change(clip);
        let before = tokens(&clip.poses, &clip.roles, bandai::RATE_HZ);
        let contacts = adaptive_contacts(&poses, &roles, &FootPaths::new(&poses, &roles, rate_hz).unwrap());
        let after = contacts.tokens();
        let both: Vec<(usize, usize)> =
            (0..after.len()).filter_map(|frame| Some((frame, original(clip, frame)?))).collect();
        let equal = both.iter().filter(|&&(there, here)| after[there] == before[here]).count();
        let share = equal as f64 / both.len() as f64;
        let gaits = step_gaits(&after, rate_hz, contacts.evidence());
        let class = clip_gait(&gaits, contacts.evidence()).unwrap().class;
        outcome.wrong += usize::from(class != clip.wanted);
        outcome.mean += share / clips.len() as f64;
        outcome.worst = outcome.worst.min(share);
    }
    outcome
}

#[test]
fn rates_cuts_and_tilts_change_little() {
    if gait_clips().is_empty() {
        return;
    }
    let at_rate = |rate_hz: f64| {
        outcome(
            |clip| (resampled(&clip.poses, rate_hz), clip.roles.clone(), rate_hz),
            |_, frame| {
                let here = frame as f64 * bandai::RATE_HZ / rate_hz;
                (here.fract() < 1e-9).then_some(here as usize)
            },
        )
    };
    let same = |_: &Captured, frame: usize| Some(frame);
    let tilt = |radians: f64| {
        outcome(
            |clip| {
                let turn = DQuat::from_rotation_z(radians);
                (moved(&clip.poses, |p| turn * p), clip.roles.clone(), bandai::RATE_HZ)
            },
            same,
        )
    };
    let trimmed = outcome(
        |clip| (cut(&clip.poses, 9, clip.poses.n_frames - 9), clip.roles.clone(), bandai::RATE_HZ),
        |_, frame| Some(frame + 9),
    );
    let start =
        outcome(|clip| (cut(&clip.poses, 0, clip.poses.n_frames.min(60)), clip.roles.clone(), bandai::RATE_HZ), same);
    let hips_only = outcome(
        |clip| {
            let mut roles = RoleMap::default();
            for role in Role::ALL.into_iter().filter(|role| *role != Role::Head) {
                if let Some(point) = clip.roles.get(role) {
                    roles.set(role, point);
                }
            }
            (clip.poses.clone(), roles, bandai::RATE_HZ)
        },
        same,
    );
    // What is allowed: clips of another class, mean and worst share of equal tokens. CONTACTS 5 has 366 of these 556 clips,
    // and worst clips 0.01 better at other rates and for the hips.
    let mut failed = Vec::new();
    for (what, found, wrong, mean, worst) in [
        ("60 Hz", at_rate(60.0), 0, 0.995, 0.940),
        ("120 Hz", at_rate(120.0), 0, 0.995, 0.940),
        ("240 Hz", at_rate(240.0), 0, 0.995, 0.940),
        ("24 Hz", at_rate(24.0), 0, 0.0, 0.0),
        ("15 Hz", at_rate(15.0), 1, 0.0, 0.0),
        ("0.3 s cut from both ends", trimmed, 0, 0.993, 0.923),
        ("the first 2 s", start, 0, 0.993, 0.923),
        ("tilt of 2 degrees", tilt(2.0_f64.to_radians()), 0, 0.999, 0.977),
        ("hips for the center of mass", hips_only, 0, 0.999, 0.960),
    ] {
        println!("{what:<28} {} wrong, tokens {:.4}, worst {:.3}", found.wrong, found.mean, found.worst);
        if found.wrong > wrong || found.mean < mean - 0.0005 || found.worst < worst - 0.0005 {
            failed.push(what);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn noise_and_spikes_change_little() {
    if gait_clips().is_empty() {
        return;
    }
    let disturbed = |disturbance: Disturbance, rate_hz: f64| {
        outcome(
            |clip| {
                let poses =
                    if rate_hz == bandai::RATE_HZ { clip.poses.clone() } else { resampled(&clip.poses, rate_hz) };
                let mut draws = Draws::new(3, &clip.name, "disturbance");
                (disturb(&poses, rate_hz, &disturbance, &mut draws), clip.roles.clone(), rate_hz)
            },
            |_, frame| {
                let here = frame as f64 * bandai::RATE_HZ / rate_hz;
                (here.fract() < 1e-9).then_some(here as usize)
            },
        )
    };
    let white = |sd_m: f64| Disturbance::White { sd_m };
    let correlated = Disturbance::Correlated { sd_m: 0.01, correlation_s: 0.025 };
    let mut failed = Vec::new();
    // Wrong clips as in CONTACTS 5, for 556 instead of 366. Its shares of equal tokens are 0.002 to 0.011 better; 0.001 to
    // 0.006 of that comes from the smaller thresholds at strikes and lift-offs, the rest is there with its own, too.
    for (what, found, wrong, mean, worst) in [
        ("noise 5 mm, 30 Hz", disturbed(white(0.005), 30.0), 1, 0.974, 0.920),
        ("noise 5 mm, 120 Hz", disturbed(white(0.005), 120.0), 0, 0.977, 0.910),
        ("noise 10 mm, 30 Hz", disturbed(white(0.01), 30.0), 2, 0.959, 0.890),
        ("noise 10 mm, 120 Hz", disturbed(white(0.01), 120.0), 1, 0.971, 0.897),
        ("10 mm correlated over 25 ms", disturbed(correlated, 30.0), 3, 0.960, 0.890),
        ("spikes of 10 cm", disturbed(Disturbance::SPIKES, 30.0), 2, 0.982, 0.904),
    ] {
        println!("{what:<28} {} wrong, tokens {:.4}, worst {:.3}", found.wrong, found.mean, found.worst);
        if found.wrong > wrong || found.mean < mean - 0.0005 || found.worst < worst - 0.0005 {
            failed.push(what);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

/// Labels of a clip without its toes are those of its ankles, never a guess about toes.
#[test]
fn without_toes_the_ankles_decide() {
    let (mut right, mut equal, mut frames) = (0, 0, 0);
    for clip in gait_clips() {
        let mut roles = RoleMap::default();
        for role in Role::ALL.into_iter().filter(|role| !matches!(role, Role::ToeLeft | Role::ToeRight)) {
            if let Some(point) = clip.roles.get(role) {
                roles.set(role, point);
            }
        }
        let labels = annotate(&clip.poses, &roles, bandai::RATE_HZ, &Settings::default());
        assert!(labels.frames.heights[1].iter().chain(&labels.frames.speeds[3]).all(Option::is_none), "{}", clip.name);
        let class = labels.clip.gait_class.unwrap();
        right += usize::from(class == clip.wanted);
        let other = matches!((class, clip.wanted), (Gait::Walk, Gait::Run) | (Gait::Run, Gait::Walk));
        assert!(!other || labels.clip.gait_confidence.unwrap() < 0.9, "{} is surely {}", clip.name, class.name());
        let whole = tokens(&clip.poses, &clip.roles, bandai::RATE_HZ);
        for (frame, token) in whole.iter().enumerate() {
            let stance = [0, 1].map(|foot| labels.frames.stance[foot][frame] == Some(true));
            equal += usize::from(Token::of_feet(stance[0], stance[1]) == *token);
        }
        frames += whole.len();
    }
    println!(
        "without toes: {right} of {} clips, {:.3} of the tokens",
        gait_clips().len(),
        equal as f64 / frames.max(1) as f64
    );
    assert!(right as f64 >= 0.98 * gait_clips().len() as f64, "{right}");
}

/// A clip whose way is taken out, as on a treadmill, has the plants that it had over ground; no clip over ground is taken
/// for one on a belt.
#[test]
fn a_treadmill_changes_little() {
    let (mut found, mut equal, mut frames, mut right, mut worst) = (0, 0, 0, 0, 1.0_f64);
    let straight: Vec<&Captured> =
        gait_clips().iter().filter(|clip| clip.name.contains("_walk_") || clip.name.contains("_run_")).collect();
    for clip in &straight {
        let hips = clip.poses.path(clip.roles.get(Role::Hips).unwrap());
        let last = clip.poses.n_frames - 1;
        let a_frame = (hips[last] - hips[0]) / last as f64;
        let a_frame = DVec3::new(a_frame.x, 0.0, a_frame.z);
        let mut belt = clip.poses.clone();
        for (at, point) in belt.world.iter_mut().enumerate() {
            *point -= a_frame * (at / belt.n_points) as f64;
        }
        let (there, here) =
            (tokens(&belt, &clip.roles, bandai::RATE_HZ), tokens(&clip.poses, &clip.roles, bandai::RATE_HZ));
        let same = there.iter().zip(&here).filter(|(there, here)| there == here).count();
        let labels = annotate(&belt, &clip.roles, bandai::RATE_HZ, &Settings::default()).clip;
        found += usize::from(labels.belt_mps.unwrap() > 0.0);
        if labels.belt_mps.unwrap() == 0.0 || labels.gait_class != Some(clip.wanted) {
            println!("{}: {:?}, belt {:?}", clip.name, labels.gait_class, labels.belt_mps);
        }
        right += usize::from(labels.gait_class == Some(clip.wanted));
        worst = worst.min(same as f64 / here.len() as f64);
        equal += same;
        frames += here.len();
    }
    let n = straight.len();
    let share = equal as f64 / frames.max(1) as f64;
    println!("in place: {found} of {n} on a belt, {right} of the right class, tokens {share:.4}, worst {worst:.3}");
    for clip in gait_clips() {
        let labels = annotate(&clip.poses, &clip.roles, bandai::RATE_HZ, &Settings::default()).clip;
        assert_eq!(labels.belt_mps, Some(0.0), "{}", clip.name);
    }
    assert!(right as f64 >= 0.98 * n as f64 && (n == 0 || share > 0.97), "{right} of {n}, {share}");
}
