//! All labels of one clip, from its poses.

use super::checks::{Facts, checks};
use super::contacts::foot_paths::FootPaths;
use super::contacts::{ContactSettings, Contacts, contacts};
use super::gait_machine::{machine_class, machine_gaits};
use super::gait_steps::{StepGaits, step_gaits};
use super::gait_summary::{clip_gait, duty_factor, frame_confidences, segments};
use super::gait_tokens::Token;
use super::labels::{ClipLabels, FrameDiagnostics, FrameLabels, Gait, Plant, Segment};
use super::phase::stride_phases;
use super::plant_state::plant_states;
use super::plants::plants;
use super::root::{RootTrack, root_track};
use crate::motion::{Poses, RoleMap};
use serde::{Deserialize, Serialize};

/// What annotation can be told.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Foot contacts.
    pub contacts: ContactSettings,
    /// Whether frames say what the detector of contacts weighed.
    pub diagnostics: bool,
}

/// Rows of the tables `annotations`, `plants`, `segments` and `clips` for one clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Annotated {
    /// Every frame.
    pub frames: FrameLabels,
    /// Left foot first, then in time.
    pub plants: Vec<Plant>,
    /// They cover the clip in time; none where the feet are unknown.
    pub segments: Vec<Segment>,
    /// The clip as a whole.
    pub clip: ClipLabels,
}

/// Labels a clip: root, contacts (T 3.1), gait (T 3.2; CONTACTS 3), plant states (T 4.2.2), phase, plants, checks.
///
/// Where the legs aren't known from hip to ankle everything about feet and gait is None or empty; the root's columns
/// stand. Where the hips aren't known the root is the first joint and has no heading. No frames: nothing.
pub fn annotate(poses: &Poses, roles: &RoleMap, rate_hz: f64, settings: &Settings) -> Annotated {
    annotate_about(&root_track(poses, roles, rate_hz), poses, roles, rate_hz, settings)
}

/// [`annotate`] for a caller that has the clip's root track already.
pub fn annotate_about(
    root: &RootTrack,
    poses: &Poses,
    roles: &RoleMap,
    rate_hz: f64,
    settings: &Settings,
) -> Annotated {
    let mut frames = root_columns(root, poses.n_frames, rate_hz);
    let feet = FootPaths::new(poses, roles, rate_hz).filter(|feet| feet.n_frames > 0);
    let Some(feet) = feet else {
        frames.diagnostics = settings.diagnostics.then(|| frame_diagnostics(None, poses.n_frames));
        return Annotated { frames: without_feet(frames, poses.n_frames), ..Annotated::default() };
    };
    let contacts = contacts(poses, roles, &feet, &settings.contacts);
    let tokens = contacts.tokens();
    let evidence = contacts.evidence();
    let gaits = step_gaits(&tokens, rate_hz, evidence);
    fill_feet_columns(&mut frames, &contacts);
    frames.plant_state = plant_states(&tokens).into_iter().map(Some).collect();
    frames.gait = gaits.gaits.iter().copied().map(Some).collect();
    frames.gait_confidence = frame_confidences(&gaits, evidence);
    frames.phase = stride_phases(&gaits);
    frames.diagnostics = settings.diagnostics.then(|| frame_diagnostics(Some(&contacts), poses.n_frames));
    Annotated {
        frames,
        plants: plants(&feet, &contacts.stance, evidence.log_odds),
        segments: segments(&gaits, evidence),
        clip: clip_labels(root, &feet, &contacts, &tokens, &gaits),
    }
}

fn root_columns(root: &RootTrack, n_frames: usize, rate_hz: f64) -> FrameLabels {
    let angles = |values: &Option<Vec<f64>>| match values {
        Some(values) => values.iter().map(|&value| Some(value as f32)).collect(),
        None => vec![None; n_frames],
    };
    FrameLabels {
        time_s: (0..n_frames).map(|frame| frame as f64 / rate_hz).collect(),
        root: root.position.iter().map(|position| position.as_vec3().to_array()).collect(),
        heading: angles(&root.heading_rad),
        speed: root.speed_mps.iter().map(|&speed| speed as f32).collect(),
        turn_rate: angles(&root.turn_rate_radps),
        ..FrameLabels::default()
    }
}

fn without_feet(frames: FrameLabels, n_frames: usize) -> FrameLabels {
    FrameLabels {
        heights: core::array::from_fn(|_| vec![None; n_frames]),
        speeds: core::array::from_fn(|_| vec![None; n_frames]),
        stance: core::array::from_fn(|_| vec![None; n_frames]),
        pinned: core::array::from_fn(|_| vec![None; n_frames]),
        plant_state: vec![None; n_frames],
        gait: vec![None; n_frames],
        gait_confidence: vec![None; n_frames],
        phase: vec![None; n_frames],
        ..frames
    }
}

fn fill_feet_columns(frames: &mut FrameLabels, contacts: &Contacts) {
    let n_frames = frames.root.len();
    let numbers = |values: &Option<Vec<f64>>| match values {
        Some(values) => values.iter().map(|&value| Some(value as f32)).collect(),
        None => vec![None; n_frames],
    };
    let marks = |values: &Vec<bool>| values.iter().copied().map(Some).collect();
    frames.heights = contacts.heights_m.each_ref().map(numbers);
    frames.speeds = contacts.speeds_mps.each_ref().map(numbers);
    frames.stance = contacts.stance.each_ref().map(marks);
    frames.pinned = contacts.pinned.each_ref().map(marks);
}

/// What the detector weighed, as columns; nothing is known without feet, or of a detector that weighs nothing.
fn frame_diagnostics(contacts: Option<&Contacts>, n_frames: usize) -> FrameDiagnostics {
    let unknown = || vec![None; n_frames];
    let Some(diagnosis) = contacts.and_then(|contacts| contacts.diagnosis.as_ref()) else {
        return FrameDiagnostics { log_odds: [unknown(), unknown()], force: unknown(), ground: [unknown(), unknown()] };
    };
    FrameDiagnostics {
        log_odds: [0, 1].map(|foot| diagnosis.log_odds.iter().map(|odds| Some(odds[foot] as f32)).collect()),
        force: diagnosis.force_bw.iter().map(|force| force.map(|force| force as f32)).collect(),
        ground: diagnosis.ground_m.each_ref().map(|heights| heights.iter().map(|&at| Some(at as f32)).collect()),
    }
}

fn clip_labels(
    root: &RootTrack,
    feet: &FootPaths,
    contacts: &Contacts,
    tokens: &[Token],
    gaits: &StepGaits,
) -> ClipLabels {
    let Some(clip) = clip_gait(gaits, contacts.evidence()) else { return ClipLabels::default() };
    let duty_factor = duty_factor(gaits);
    let in_flight = tokens.iter().filter(|&&token| token == Token::Neither).count();
    let flight_fraction = in_flight as f64 / tokens.len() as f64;
    let ground = &contacts.ground;
    let facts = Facts {
        class: clip.class,
        confidence: clip.confidence as f32,
        duty_factor,
        flight_fraction,
        n_steps: gaits.steps.len(),
        jumps: gaits.gaits.contains(&Gait::Jump),
        travel_in_legs: travel_m(root) / feet.leg_length_m.max(1e-3),
        feet_rest_apart: ground.feet_rest_apart,
        uneven: ground.uneven == Some(true),
        treadmill: ground.belt_mps.is_some_and(|belt_mps| belt_mps > 0.0),
    };
    let fraction = |gait: Gait| Some(clip.fractions[gait as usize] as f32);
    let number = |value: Option<f64>| value.map(|value| value as f32);
    let diagnosis = contacts.diagnosis.as_ref();
    ClipLabels {
        leg_length_m: Some(feet.leg_length_m as f32),
        leg_spread_m: Some(feet.leg_spread_m as f32),
        ground_height_m: number(ground.height_m),
        ground_spread_m: number(ground.spread_m),
        ground_slope_x: number(ground.tilt.map(|tilt| tilt.slope[0])),
        ground_slope_z: number(ground.tilt.map(|tilt| tilt.slope[1])),
        ground_slope_share: number(ground.tilt.map(|tilt| tilt.share)),
        uneven: ground.uneven,
        belt_mps: number(ground.belt_mps),
        noise_m: number(diagnosis.map(|diagnosis| diagnosis.noise_m)),
        noise_spread_m: number(diagnosis.map(|diagnosis| diagnosis.noise_spread_m)),
        gait_class: Some(clip.class),
        thesis_class: Some(machine_class(&machine_gaits(tokens))),
        stand_fraction: fraction(Gait::Stand),
        walk_fraction: fraction(Gait::Walk),
        run_fraction: fraction(Gait::Run),
        jump_fraction: fraction(Gait::Jump),
        unknown_fraction: fraction(Gait::Unknown),
        gait_confidence: Some(clip.confidence as f32),
        duty_factor: number(duty_factor),
        flight_fraction: Some(flight_fraction as f32),
        checks: checks(&facts),
    }
}

/// Largest horizontal distance of the root from where it began, metres.
fn travel_m(root: &RootTrack) -> f64 {
    let Some(&start) = root.position.first() else { return 0.0 };
    root.position
        .iter()
        .map(|position| *position - start)
        .map(|away| (away.x * away.x + away.z * away.z).sqrt())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::annotate::features::features;
    use crate::motion::Role;
    use glam::DVec3;
    use proptest::prelude::*;

    fn all_roles() -> RoleMap {
        let mut roles = RoleMap::default();
        for (point, role) in Role::ALL.into_iter().enumerate() {
            roles.set(role, point);
        }
        roles
    }

    fn check_lengths(annotated: &Annotated, n_frames: usize) {
        let frames = &annotated.frames;
        let lengths = [
            frames.time_s.len(),
            frames.root.len(),
            frames.heading.len(),
            frames.speed.len(),
            frames.turn_rate.len(),
            frames.plant_state.len(),
            frames.gait.len(),
            frames.gait_confidence.len(),
            frames.phase.len(),
        ];
        assert_eq!(lengths, [n_frames; 9]);
        assert!(frames.heights.iter().chain(&frames.speeds).all(|column| column.len() == n_frames));
        assert!(frames.stance.iter().chain(&frames.pinned).all(|column| column.len() == n_frames));
    }

    #[test]
    fn a_body_that_stands_still_stands() {
        // Thigh, knee, ankle and toe of either leg below each other.
        let height = |point: usize| 1.0 - 0.3 * f64::from(point as u32 % 4);
        let world = (0..60).flat_map(|_| (0..Role::COUNT).map(|point| DVec3::Y * height(point + 3)));
        let poses = Poses { n_frames: 60, n_points: Role::COUNT, world: world.collect() };
        let annotated = annotate(&poses, &all_roles(), 30.0, &Settings::default());
        check_lengths(&annotated, 60);
        assert_eq!(annotated.clip.gait_class, Some(Gait::Stand));
        assert_eq!(annotated.clip.thesis_class, Some(Gait::Stand));
        assert_eq!(annotated.clip.flight_fraction, Some(0.0));
        assert_eq!(annotated.plants.len(), 2);
        assert_eq!(annotated.segments.len(), 1);
        assert_eq!(annotated.frames.pinned[1], vec![Some(true); 60]);
        assert_eq!(annotated.frames.time_s[30], 1.0);
        // All joints above each other: the body faces nowhere.
        assert_eq!(annotated.frames.heading, vec![None; 60]);
    }

    #[test]
    fn without_feet_only_the_root_is_known() {
        let mut roles = RoleMap::default();
        roles.set(Role::Hips, 1);
        let world = (0..5).flat_map(|frame| [DVec3::ZERO, DVec3::new(f64::from(frame), 1.0, 0.0)]).collect();
        let poses = Poses { n_frames: 5, n_points: 2, world };
        let annotated = annotate(&poses, &roles, 30.0, &Settings::default());
        check_lengths(&annotated, 5);
        assert_eq!(annotated.frames.root[4], [4.0, 1.0, 0.0]);
        assert!((annotated.frames.speed[2] - 30.0).abs() < 1e-4);
        assert_eq!(annotated.clip, ClipLabels::default());
        assert!(annotated.plants.is_empty() && annotated.segments.is_empty());
        assert_eq!(annotated.frames.stance[0], vec![None; 5]);
    }

    #[test]
    fn settings_name_their_units_and_refuse_unknown_fields() {
        let settings: Settings = toml::from_str("[contacts.thesis]\nmax_speed_mps = 0.6").unwrap();
        assert_eq!((settings.contacts.thesis.max_speed_mps, settings.contacts.thesis.max_height_m), (0.6, 0.05));
        assert!(toml::from_str::<Settings>("[contacts.thesis]\nmax_speed = 0.6").is_err());
        assert!(toml::from_str::<Settings>("[contacts]\ndetector = 'none'").is_err());
    }

    proptest! {
        #[test]
        fn no_poses_panic(
            n_frames in 0_usize..80,
            numbers in prop::collection::vec(-2.0..2.0_f64, 64),
            scale in prop::sample::select(vec![0.0, 1e-9, 1e-3, 1.0, 1e6, 1e150]),
            rate_hz in prop::sample::select(vec![1e-3, 1.0, 15.0, 24.0, 30.0, 59.94, 120.0, 250.0, 1e6]),
            lost in prop::collection::vec(any::<bool>(), Role::COUNT),
        ) {
            let mut roles = RoleMap::default();
            for (point, role) in Role::ALL.into_iter().enumerate() {
                // Most runs have feet.
                if !lost[point] || lost[0] {
                    roles.set(role, point);
                }
            }
            let world = (0..n_frames * Role::COUNT)
                .map(|at| DVec3::new(numbers[at * 7 % 64], numbers[at * 11 % 61], numbers[(at * at + 5) % 59]) * scale);
            let poses = Poses { n_frames, n_points: Role::COUNT, world: world.collect() };
            let annotated = annotate(&poses, &roles, rate_hz, &Settings::default());
            check_lengths(&annotated, n_frames);
            let features = features(&poses, &roles, rate_hz);
            prop_assert!(features.values.is_empty() || features.values.len() == n_frames * 45);
            if let Some(first) = annotated.segments.first() {
                prop_assert_eq!(first.first, 0);
                prop_assert!(annotated.segments.windows(2).all(|pair| pair[0].end == pair[1].first));
                prop_assert_eq!(annotated.segments.last().map(|last| last.end as usize), Some(n_frames));
            }
            prop_assert!(annotated.frames.phase.iter().flatten().all(|phase| (0.0..1.0).contains(phase)));
            prop_assert!(annotated.frames.gait_confidence.iter().flatten().all(|sure| (0.0..=1.0).contains(sure)));
            if scale <= 1.0 {
                prop_assert!(features.values.iter().all(|value| value.is_finite()));
            }
        }
    }
}
