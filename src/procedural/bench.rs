//! A bench for labelers: a round of kinds of clips in five groups, each clip with its own rate, style and body (CONTACTS 6).

use super::act::Act;
use super::arms::Gesture;
use super::clip::ClipSpec;
use super::corpus::gesture;
use super::draws::Draws;
use super::skeleton::Subject;
use super::style::Style;
use crate::annotate::Foot;
use serde::{Deserialize, Serialize};

/// What results are shown by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BenchGroup {
    /// Walks and runs straight on and in bends, at all speeds, with stands between.
    Level,
    /// Walks and runs in other directions and manners.
    Styles,
    /// Stands, and arms that do something while their body stands or walks.
    Arms,
    /// Jumps on both feet, hops on one.
    Leaps,
    /// Stairs and slopes.
    Ground,
}

impl BenchGroup {
    /// In the order of their declaration.
    pub const ALL: [BenchGroup; 5] =
        [BenchGroup::Level, BenchGroup::Styles, BenchGroup::Arms, BenchGroup::Leaps, BenchGroup::Ground];

    /// As in tables of results.
    pub fn name(self) -> &'static str {
        match self {
            BenchGroup::Level => "level",
            BenchGroup::Styles => "styles",
            BenchGroup::Arms => "arms",
            BenchGroup::Leaps => "leaps",
            BenchGroup::Ground => "ground",
        }
    }

    /// The group of the kind that the clip's name names: `stairs_up` of `stairs_up_02`. Only the name is looked at, so
    /// a clip that was not made by [`bench()`] has a group too if it is called like one of its clips.
    pub fn of(spec: &ClipSpec) -> Option<BenchGroup> {
        let (kind, _) = spec.name.rsplit_once('_')?;
        ROUND.iter().find(|(name, ..)| *name == kind).map(|(_, group, _)| *group)
    }
}

/// What a clip of the round shows; speeds in m/s for a body of 1.75 m.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Walk { low: f64, high: f64, turn: f64 },
    Run { low: f64, high: f64, turn: f64 },
    WalkRunWalk,
    StandWalkStand,
    Back { turn: bool },
    Aside(Foot),
    March,
    Jog,
    Tired,
    Sneak,
    Limp(Foot),
    Stand(&'static [(Gesture, Foot)]),
    WalkWith(&'static [(Gesture, Foot)]),
    Jump { forward: bool, stands: bool },
    Hop { foot: Foot, forward: bool },
    Stairs { up: bool },
    Slope { up: bool },
}

use BenchGroup::{Arms, Ground, Leaps, Level, Styles};
use Foot::{Left, Right};

const BOTH_CARRY: &[(Gesture, Foot)] = &[(Gesture::Carry, Left), (Gesture::Carry, Right)];
const BOTH_REACH: &[(Gesture, Foot)] = &[(Gesture::Reach, Left), (Gesture::Reach, Right)];

/// One round: an order in which any stretch of some clips holds every group.
const ROUND: [(&str, BenchGroup, Kind); 40] = [
    ("walk", Level, Kind::Walk { low: 0.9, high: 1.4, turn: 0.0 }),
    ("walk_back", Styles, Kind::Back { turn: false }),
    ("stand", Arms, Kind::Stand(&[])),
    ("jump", Leaps, Kind::Jump { forward: false, stands: false }),
    ("stairs_up", Ground, Kind::Stairs { up: true }),
    ("run", Level, Kind::Run { low: 2.0, high: 2.9, turn: 0.0 }),
    ("walk_aside_left", Styles, Kind::Aside(Left)),
    ("stand_wave_right", Arms, Kind::Stand(&[(Gesture::Wave, Right)])),
    ("hop_left", Leaps, Kind::Hop { foot: Left, forward: false }),
    ("slope_up", Ground, Kind::Slope { up: true }),
    ("walk_slow", Level, Kind::Walk { low: 0.45, high: 0.85, turn: 0.0 }),
    ("march", Styles, Kind::March),
    ("stand_reach_left", Arms, Kind::Stand(&[(Gesture::Reach, Left)])),
    ("jump_single", Leaps, Kind::Jump { forward: false, stands: true }),
    ("stairs_down", Ground, Kind::Stairs { up: false }),
    ("walk_turn_left", Level, Kind::Walk { low: 0.8, high: 1.3, turn: 1.0 }),
    ("sneak", Styles, Kind::Sneak),
    ("walk_carry", Arms, Kind::WalkWith(BOTH_CARRY)),
    ("hop_right_forward", Leaps, Kind::Hop { foot: Right, forward: true }),
    ("slope_down", Ground, Kind::Slope { up: false }),
    ("run_fast", Level, Kind::Run { low: 3.0, high: 4.0, turn: 0.0 }),
    ("limp_right", Styles, Kind::Limp(Right)),
    ("stand_punch_right", Arms, Kind::Stand(&[(Gesture::Punch, Right)])),
    ("jump_forward", Leaps, Kind::Jump { forward: true, stands: false }),
    ("stand_walk_stand", Level, Kind::StandWalkStand),
    ("tired", Styles, Kind::Tired),
    ("stand_raise_left", Arms, Kind::Stand(&[(Gesture::Raise, Left)])),
    ("hop_right", Leaps, Kind::Hop { foot: Right, forward: false }),
    ("walk_fast", Level, Kind::Walk { low: 1.4, high: 1.9, turn: 0.0 }),
    ("jog", Styles, Kind::Jog),
    ("stand_reach_both", Arms, Kind::Stand(BOTH_REACH)),
    ("jump_single_forward", Leaps, Kind::Jump { forward: true, stands: true }),
    ("run_turn_right", Level, Kind::Run { low: 2.1, high: 2.8, turn: -1.0 }),
    ("walk_aside_right", Styles, Kind::Aside(Right)),
    ("stand_carry", Arms, Kind::Stand(BOTH_CARRY)),
    ("walk_run_walk", Level, Kind::WalkRunWalk),
    ("limp_left", Styles, Kind::Limp(Left)),
    ("walk_turn_right", Level, Kind::Walk { low: 0.8, high: 1.3, turn: -1.0 }),
    ("walk_wave_left", Arms, Kind::WalkWith(&[(Gesture::Wave, Left)])),
    ("walk_back_turn", Styles, Kind::Back { turn: true }),
];

/// Clips of one subject that follow each other.
const CLIPS_A_SUBJECT: usize = 5;

/// The first `n_clips` specs of a bench: names such as `stairs_up_02`, bodies of 1.2 to 2.1 m, 24 to 240 frames a second.
///
/// A longer bench of the same seed begins with the same specs. [`BenchGroup::of`] tells the group of each.
///
/// # Source
/// CONTACTS 6, "Generator".
pub fn bench(n_clips: usize, seed: u64) -> Vec<ClipSpec> {
    (0..n_clips)
        .map(|index| {
            let (kind_name, _, kind) = ROUND[index % ROUND.len()];
            let name = format!("{kind_name}_{:02}", index / ROUND.len() + 1);
            spec(name, kind, subject(index / CLIPS_A_SUBJECT, seed), seed)
        })
        .collect()
}

fn subject(index: usize, seed: u64) -> Subject {
    let name = format!("b{:02}", index + 1);
    let height_m = Draws::new(seed, &name, "bench height").uniform(1.2, 2.1);
    Subject { name, height_m: (height_m * 100.0).round() / 100.0 }
}

fn spec(name: String, kind: Kind, subject: Subject, seed: u64) -> ClipSpec {
    let mut draws = Draws::new(seed, &name, "bench acts");
    let rate_hz = [24, 30, 60, 120, 240][draws.pick(5)];
    let yaw_rad = draws.uniform(-3.1, 3.1);
    let style = style(kind, &mut Draws::new(seed, &name, "bench style"));
    let size = subject.height_m / 1.75;
    // Bodies of different size move alike at equal Froude numbers.
    let pace = libm::sqrt(size);
    let mut between = |low: f64, high: f64| (draws.uniform(low, high) * 1000.0).round() / 1000.0;
    let mut actions = Vec::new();
    let straight = |seconds, speed_mps| Act::Walk { seconds, speed_mps, turn_rate_radps: 0.0 };
    let acts = match kind {
        Kind::Walk { low, high, turn } => {
            let speed_mps = (between(low, high) * pace).clamp(0.4, 2.0);
            let walk = |seconds, turn_rate_radps| Act::Walk { seconds, speed_mps, turn_rate_radps };
            way(between(5.5, 8.0), turn * between(0.25, 0.6), walk)
        }
        Kind::Run { low, high, turn } => {
            let speed_mps = (between(low, high) * pace).clamp(1.6, 4.0);
            let run = |seconds, turn_rate_radps| Act::Run { seconds, speed_mps, turn_rate_radps };
            way(between(4.5, 6.5), turn * between(0.3, 0.55), run)
        }
        Kind::WalkRunWalk => {
            let walk_mps = (between(1.3, 1.6) * pace).clamp(0.4, 2.0);
            let run_mps = (between(2.3, 2.8) * pace).clamp(1.6, 4.0);
            let run = Act::Run { seconds: between(2.5, 3.5), speed_mps: run_mps, turn_rate_radps: 0.0 };
            vec![straight(between(2.0, 3.0), walk_mps), run, straight(between(2.0, 3.0), walk_mps)]
        }
        Kind::StandWalkStand => {
            let walk = straight(between(3.0, 4.5), (between(0.9, 1.3) * pace).clamp(0.4, 2.0));
            vec![Act::Stand { seconds: between(1.5, 2.5) }, walk, Act::Stand { seconds: between(1.5, 2.5) }]
        }
        Kind::Back { turn } => {
            let speed_mps = (between(0.45, 1.0) * pace).clamp(0.3, 1.5);
            let turn_rate_radps = if turn { between(-0.4, 0.4) } else { 0.0 };
            vec![Act::Back { seconds: between(5.5, 8.0), speed_mps, turn_rate_radps }]
        }
        Kind::Aside(toward) => {
            let speed_mps = (between(0.25, 0.5) * pace).clamp(0.1, 0.7);
            vec![Act::Aside { seconds: between(5.5, 8.0), speed_mps, toward }]
        }
        Kind::March => vec![Act::March { seconds: between(5.0, 7.0), lift: between(0.1, 0.35) }],
        Kind::Jog => vec![Act::Jog { seconds: between(4.5, 6.5), lift: between(0.07, 0.22) }],
        Kind::Tired => vec![straight(between(6.0, 8.0), (between(0.45, 0.8) * pace).clamp(0.4, 2.0))],
        Kind::Sneak => vec![straight(between(7.0, 9.0), (between(0.4, 0.65) * pace).clamp(0.4, 2.0))],
        Kind::Limp(_) => vec![straight(between(6.0, 8.0), (between(0.55, 1.0) * pace).clamp(0.4, 2.0))],
        Kind::Stand(doing) => {
            let seconds = between(5.0, 8.0);
            let (start_s, length_s) = (between(0.5, 1.0), seconds - between(1.6, 2.2));
            actions.extend(doing.iter().map(|&(what, side)| gesture(what, side, start_s, length_s, &mut between)));
            vec![Act::Stand { seconds }]
        }
        Kind::WalkWith(doing) => {
            let seconds = between(6.0, 8.5);
            let (start_s, length_s) = (between(0.5, 1.0), seconds - between(1.6, 2.2));
            actions.extend(doing.iter().map(|&(what, side)| gesture(what, side, start_s, length_s, &mut between)));
            vec![straight(seconds, (between(0.8, 1.3) * pace).clamp(0.4, 2.0))]
        }
        Kind::Jump { forward, stands } => {
            let mut acts = Vec::new();
            for _ in 0..if stands { 2 } else { 4 } {
                if stands {
                    acts.push(Act::Stand { seconds: between(1.2, 2.2) });
                }
                let forward_m = if forward { between(0.3, 0.75) * size } else { 0.0 };
                acts.push(Act::Jump { height_m: between(0.10, 0.28) * size, forward_m });
            }
            if stands {
                acts.push(Act::Stand { seconds: between(1.2, 2.2) });
            }
            acts
        }
        Kind::Hop { foot, forward } => {
            let forward_m = if forward { between(0.2, 0.5) * size } else { 0.0 };
            let hop = Act::Hop {
                foot,
                hops: 3 + draws.pick(5) as u32,
                height_m: draws.uniform(0.04, 0.12) * size,
                forward_m,
            };
            vec![Act::Stand { seconds: 1.0 }, hop, Act::Stand { seconds: 1.0 }]
        }
        Kind::Stairs { up } => {
            let riser_m = between(0.15, 0.19) * if up { 1.0 } else { -1.0 };
            let (tread_m, cadence_spm) = (between(0.26, 0.30), between(75.0, 105.0));
            let treads = 7 + draws.pick(5) as u32;
            vec![
                Act::Stand { seconds: 1.0 },
                Act::Stairs { treads, tread_m, riser_m, cadence_spm },
                Act::Stand { seconds: 1.0 },
            ]
        }
        Kind::Slope { up } => {
            let incline_rad = between(0.05, 0.14) * if up { 1.0 } else { -1.0 };
            let speed_mps = (between(0.7, 1.3) * pace).clamp(0.4, 2.0);
            vec![Act::Slope { seconds: between(6.0, 8.0), speed_mps, incline_rad }]
        }
    };
    ClipSpec { name, subject, acts, actions, style, yaw_rad, rate_hz, seed }
}

/// Somebody near the ordinary, in the manner that a kind asks for.
fn style(kind: Kind, draws: &mut Draws) -> Style {
    // Walks stay within 0.56 to 0.68, runs within 0.26 to 0.42.
    let duty = draws.uniform(-0.03, 0.03);
    let duty = if matches!(kind, Kind::Run { .. } | Kind::Jog) { duty } else { -duty.abs() };
    let near = Style { duty, ..Style::draw(draws) };
    match kind {
        // Short steps, feet hardly lifted, bent forward.
        Kind::Tired => Style {
            cadence: draws.uniform(1.0, 1.15),
            duty: draws.uniform(0.02, 0.05),
            arm_swing: draws.uniform(0.3, 0.6),
            lean_rad: draws.uniform(0.15, 0.35),
            head_rad: draws.uniform(0.2, 0.5),
            crouch: draws.uniform(0.015, 0.04),
            heel_strike: draws.uniform(0.1, 0.5),
            clearance: draws.uniform(0.2, 0.6),
            ..near
        },
        // Low and slow, the ball of the foot first, feet lifted with care.
        Kind::Sneak => Style {
            cadence: draws.uniform(0.7, 0.9),
            duty: draws.uniform(0.03, 0.08),
            arm_swing: draws.uniform(0.2, 0.6),
            elbow_rad: draws.uniform(0.4, 0.9),
            lean_rad: draws.uniform(0.2, 0.4),
            crouch: draws.uniform(0.09, 0.16),
            heel_strike: draws.uniform(-0.9, -0.5),
            clearance: draws.uniform(3.0, 6.0),
            bounce: 0.3,
            ..near
        },
        Kind::Limp(foot) => {
            let limp = draws.uniform(0.1, 0.22);
            Style { limp: if foot == Right { limp } else { -limp }, duty: draws.uniform(0.0, 0.03), ..near }
        }
        // Knees are never straight where the ground is not level, nor behind one's back.
        Kind::Stairs { .. } | Kind::Slope { .. } => {
            Style { lean_rad: near.lean_rad + draws.uniform(0.0, 0.12), crouch: draws.uniform(0.012, 0.03), ..near }
        }
        Kind::Back { .. } | Kind::Aside(_) => Style { crouch: draws.uniform(0.008, 0.02), ..near },
        // Three runners of ten strike with the ball.
        Kind::Run { .. } if draws.uniform(0.0, 1.0) < 0.3 => Style { heel_strike: -0.9, ..near },
        _ => near,
    }
}

/// Straight on; or straight, a bend, and straight again.
fn way(seconds: f64, turn_rate_radps: f64, act: impl Fn(f64, f64) -> Act) -> Vec<Act> {
    if turn_rate_radps == 0.0 {
        return vec![act(seconds, 0.0)];
    }
    vec![act(0.25 * seconds, 0.0), act(0.5 * seconds, turn_rate_radps), act(0.25 * seconds, 0.0)]
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_longer_bench_begins_with_the_shorter_one() {
        let (short, long) = (bench(25, 3), bench(200, 3));
        assert_eq!(short[..], long[..25]);
        assert_ne!(bench(25, 4)[0], short[0]);
    }

    #[test]
    fn names_are_unique_and_tell_the_group() {
        let specs = bench(200, 1);
        let names: BTreeSet<&str> = specs.iter().map(|spec| spec.name.as_str()).collect();
        assert_eq!(names.len(), 200);
        for group in BenchGroup::ALL {
            assert!(specs.iter().filter(|spec| BenchGroup::of(spec) == Some(group)).count() >= 20, "{}", group.name());
        }
        assert_eq!(BenchGroup::of(&specs[4]), Some(BenchGroup::Ground));
        let rates: BTreeSet<u32> = specs.iter().map(|spec| spec.rate_hz).collect();
        assert_eq!(rates.into_iter().collect::<Vec<u32>>(), [24, 30, 60, 120, 240]);
        let heights = || specs.iter().map(|spec| spec.subject.height_m);
        assert!(heights().fold(9.0, f64::min) < 1.3 && heights().fold(0.0, f64::max) > 2.0);
        let first = specs.iter().position(|spec| BenchGroup::of(spec).is_none());
        assert_eq!(first.map(|index| specs.get(index).unwrap()), None);
    }
}
