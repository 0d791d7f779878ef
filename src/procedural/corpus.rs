//! A varied corpus: a round of twenty kinds of clips a subject, as many rounds as are asked for.

use super::act::Act;
use super::arms::{ArmAction, Gesture};
use super::clip::ClipSpec;
use super::draws::Draws;
use super::skeleton::Subject;
use super::style::Style;
use crate::annotate::Foot;

/// What a clip of the round shows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Walk { low_mps: f64, high_mps: f64, turn: Turn, waves: bool },
    Run { low_mps: f64, high_mps: f64, turn: Turn },
    Stand(Option<(Gesture, Arms)>),
    Jump { forward: bool },
    StandWalkStand,
    WalkRunWalk,
    Balance,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    None,
    Left,
    Right,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Arms {
    Left,
    Right,
    Both,
}

/// One round, in an order that makes a short corpus varied too.
const ROUND: [(&str, Kind); 20] = [
    ("walk", Kind::Walk { low_mps: 0.95, high_mps: 1.35, turn: Turn::None, waves: false }),
    ("stand_wave_right", Kind::Stand(Some((Gesture::Wave, Arms::Right)))),
    ("run", Kind::Run { low_mps: 2.2, high_mps: 2.9, turn: Turn::None }),
    ("walk_turn_left", Kind::Walk { low_mps: 0.8, high_mps: 1.3, turn: Turn::Left, waves: false }),
    ("stand_raise_left", Kind::Stand(Some((Gesture::Raise, Arms::Left)))),
    ("jump", Kind::Jump { forward: false }),
    ("walk_slow", Kind::Walk { low_mps: 0.45, high_mps: 0.8, turn: Turn::None, waves: false }),
    ("stand_wave_left", Kind::Stand(Some((Gesture::Wave, Arms::Left)))),
    ("run_fast", Kind::Run { low_mps: 3.1, high_mps: 4.0, turn: Turn::None }),
    ("stand_walk_stand", Kind::StandWalkStand),
    ("walk_turn_right", Kind::Walk { low_mps: 0.8, high_mps: 1.3, turn: Turn::Right, waves: false }),
    ("stand_punch_right", Kind::Stand(Some((Gesture::Punch, Arms::Right)))),
    ("jump_forward", Kind::Jump { forward: true }),
    ("walk_fast", Kind::Walk { low_mps: 1.45, high_mps: 1.8, turn: Turn::None, waves: false }),
    ("stand_raise_both", Kind::Stand(Some((Gesture::Raise, Arms::Both)))),
    ("run_turn_left", Kind::Run { low_mps: 2.2, high_mps: 2.9, turn: Turn::Left }),
    ("walk_wave_right", Kind::Walk { low_mps: 0.9, high_mps: 1.3, turn: Turn::None, waves: true }),
    ("stand", Kind::Stand(None)),
    ("walk_run_walk", Kind::WalkRunWalk),
    ("balance", Kind::Balance),
];

/// The first `n_clips` specs of a corpus: names such as `walk_turn_left_02`; every twenty clips share a subject, so
/// that each can be grafted on the others.
///
/// A longer corpus of the same seed begins with the same specs.
pub fn corpus(n_clips: usize, seed: u64) -> Vec<ClipSpec> {
    (0..n_clips)
        .map(|index| {
            let (round, at) = (index / ROUND.len(), index % ROUND.len());
            let (kind_name, kind) = ROUND[at];
            spec(&format!("{kind_name}_{:02}", round + 1), kind, subject(round, seed), seed)
        })
        .collect()
}

/// Somebody; the first two are grown up, the others of any size.
fn subject(round: usize, seed: u64) -> Subject {
    let name = format!("p{:02}", round + 1);
    let (low_m, high_m) = if round < 2 { (1.60, 1.88) } else { (1.2, 2.1) };
    let height_m = Draws::new(seed, &name, "height").uniform(low_m, high_m);
    Subject { name, height_m: (height_m * 100.0).round() / 100.0 }
}

fn spec(name: &str, kind: Kind, subject: Subject, seed: u64) -> ClipSpec {
    let style = Style::draw(&mut Draws::new(seed, name, "style"));
    let mut draws = Draws::new(seed, name, "acts");
    let rate_hz = [30, 60, 60, 120][draws.pick(4)];
    let yaw_rad = draws.uniform(-3.1, 3.1);
    // Bodies of different size move alike at equal Froude numbers.
    let pace = libm::sqrt(subject.height_m / 1.75);
    let mut between = |low: f64, high: f64| (draws.uniform(low, high) * 1000.0).round() / 1000.0;
    let mut actions = Vec::new();
    let acts = match kind {
        Kind::Walk { low_mps, high_mps, turn, waves } => {
            let speed_mps = (between(low_mps, high_mps) * pace).clamp(0.4, 2.0);
            let seconds = between(5.5, 9.0);
            if waves {
                let start_s = between(0.6, 1.2);
                actions.push(gesture(Gesture::Wave, Foot::Right, start_s, seconds - start_s - 0.8, &mut between));
            }
            way(seconds, turn, between(0.25, 0.6), |seconds, turn_rate_radps| Act::Walk {
                seconds,
                speed_mps,
                turn_rate_radps,
            })
        }
        Kind::Run { low_mps, high_mps, turn } => {
            let speed_mps = (between(low_mps, high_mps) * pace).clamp(1.6, 4.0);
            way(between(5.0, 7.0), turn, between(0.3, 0.55), |seconds, turn_rate_radps| Act::Run {
                seconds,
                speed_mps,
                turn_rate_radps,
            })
        }
        Kind::Stand(doing) => {
            let seconds = between(5.0, 8.0);
            if let Some((what, arms)) = doing {
                let (start_s, length_s) = (between(0.5, 1.0), seconds - between(1.6, 2.2));
                let sides: &[Foot] = match arms {
                    Arms::Left => &[Foot::Left],
                    Arms::Right => &[Foot::Right],
                    Arms::Both => &[Foot::Left, Foot::Right],
                };
                actions.extend(sides.iter().map(|&side| gesture(what, side, start_s, length_s, &mut between)));
            }
            vec![Act::Stand { seconds }]
        }
        Kind::Jump { forward } => (0..4)
            .map(|_| Act::Jump {
                height_m: between(0.12, 0.32) * subject.height_m / 1.75,
                forward_m: if forward { between(0.4, 0.9) * subject.height_m / 1.75 } else { 0.0 },
            })
            .collect(),
        Kind::StandWalkStand => {
            let speed_mps = (between(0.9, 1.3) * pace).clamp(0.4, 2.0);
            let walk = Act::Walk { seconds: between(3.0, 4.5), speed_mps, turn_rate_radps: between(-0.2, 0.2) };
            vec![Act::Stand { seconds: between(1.5, 2.5) }, walk, Act::Stand { seconds: between(1.5, 2.5) }]
        }
        Kind::WalkRunWalk => {
            let walk_mps = (between(1.3, 1.6) * pace).clamp(0.4, 2.0);
            let run_mps = (between(2.3, 2.8) * pace).clamp(1.6, 4.0);
            let walk = |seconds| Act::Walk { seconds, speed_mps: walk_mps, turn_rate_radps: 0.0 };
            let run = Act::Run { seconds: between(2.5, 3.5), speed_mps: run_mps, turn_rate_radps: 0.0 };
            vec![walk(between(2.0, 3.0)), run, walk(between(2.0, 3.0))]
        }
        Kind::Balance => {
            let lifted = if between(0.0, 1.0) < 0.5 { Foot::Left } else { Foot::Right };
            let balance = Act::Balance { lifted, seconds: between(1.8, 3.0) };
            vec![Act::Stand { seconds: between(0.8, 1.5) }, balance, Act::Stand { seconds: between(0.8, 1.5) }]
        }
    };
    ClipSpec { name: name.to_owned(), subject, acts, actions, style, yaw_rad, rate_hz, seed }
}

/// Straight on; or straight, a bend, and straight again.
fn way(seconds: f64, turn: Turn, turn_rate_radps: f64, act: impl Fn(f64, f64) -> Act) -> Vec<Act> {
    let signed = match turn {
        Turn::None => return vec![act(seconds, 0.0)],
        Turn::Left => turn_rate_radps,
        Turn::Right => -turn_rate_radps,
    };
    vec![act(0.2 * seconds, 0.0), act(0.6 * seconds, signed), act(0.2 * seconds, 0.0)]
}

/// Something that an arm does, at a pace and of a size of its own.
pub(super) fn gesture(
    gesture: Gesture,
    side: Foot,
    start_s: f64,
    seconds: f64,
    between: &mut impl FnMut(f64, f64) -> f64,
) -> ArmAction {
    let rate_hz = if gesture == Gesture::Punch { between(0.8, 1.1) } else { between(1.1, 1.7) };
    ArmAction { gesture, side, start_s, seconds, rate_hz, size: between(0.85, 1.1) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_longer_corpus_begins_with_the_shorter_one() {
        let (short, long) = (corpus(25, 3), corpus(300, 3));
        assert_eq!(short[..], long[..25]);
        assert_ne!(corpus(25, 4)[0], short[0]);
    }

    #[test]
    fn names_are_unique_and_subjects_are_shared() {
        let specs = corpus(300, 1);
        let names: BTreeSet<&str> = specs.iter().map(|spec| spec.name.as_str()).collect();
        assert_eq!(names.len(), 300);
        assert!(specs[..20].iter().all(|spec| spec.subject == specs[0].subject));
        assert_ne!(specs[20].subject, specs[0].subject);
        assert!(specs.iter().all(|spec| (1.2..=2.1).contains(&spec.subject.height_m)));
    }
}
