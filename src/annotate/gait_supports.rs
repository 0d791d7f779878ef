//! Runs of tokens that settle a gait by themselves: stands, jumps, hops (CONTACTS 3.2, 3.3).

use super::gait_tokens::{Token, TokenRun};
use super::order_statistics::median;

/// Both feet planted for this long is a stand, seconds (3.2).
const STAND_S: f64 = 0.6;
/// At most this long for slow walkers, seconds (3.2).
const LONGEST_STAND_S: f64 = 1.2;
/// A stand lasts this many times the clip's median double support (3.2).
const STAND_IN_DOUBLE_SUPPORTS: f64 = 1.75;
/// From this number of double supports on their median counts (3.2).
const FEWEST_DOUBLE_SUPPORTS: usize = 3;
/// Flights of a jump off and onto both feet last this long, seconds (3.3).
const JUMP_FLIGHT_S: f64 = 0.06;
/// Flights with both feet planted on one side only last this long, seconds (3.3).
const HALF_JUMP_FLIGHT_S: f64 = 0.2;
/// A single support shorter than this between both feet and a flight is part of take-off or landing, seconds (3.3).
const TAKEOFF_S: f64 = 0.09;

/// What a run of tokens is by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Part of a step, or nothing yet.
    Open,
    /// A stand's core.
    Stand,
    /// The flight of a jump, or a short single support of its take-off or landing.
    Jump,
    /// The flight of a hop on one foot.
    Hop,
}

/// What each run is by itself.
pub fn supports(runs: &[TokenRun], rate_hz: f64) -> Vec<Support> {
    let stand_s = stand_length_s(runs, rate_hz);
    let mut supports = vec![Support::Open; runs.len()];
    for (at, run) in runs.iter().enumerate() {
        match run.token {
            Token::Both if run.duration_s(rate_hz) >= stand_s => supports[at] = Support::Stand,
            Token::Neither => {
                let before = at.checked_sub(1).map(|near| beside(runs, near, near.checked_sub(1), rate_hz));
                let after = runs.get(at + 1).map(|_| beside(runs, at + 1, Some(at + 2), rate_hz));
                let (Some(before), Some(after)) = (before, after) else { continue };
                let duration_s = run.duration_s(rate_hz);
                let both = (before == Token::Both, after == Token::Both);
                let jump = match both {
                    (true, true) => duration_s >= JUMP_FLIGHT_S,
                    (true, false) | (false, true) => duration_s >= HALF_JUMP_FLIGHT_S,
                    (false, false) => false,
                };
                if jump {
                    supports[at] = Support::Jump;
                    for (near, is_both) in [(at - 1, both.0), (at + 1, both.1)] {
                        if is_both && runs[near].token.single().is_some() {
                            supports[near] = Support::Jump;
                        }
                    }
                } else if before == after && before.single().is_some() {
                    supports[at] = Support::Hop;
                }
            }
            _ => {}
        }
    }
    supports
}

/// The token beside a flight; a short single support with both feet planted behind it counts as both.
fn beside(runs: &[TokenRun], near: usize, behind: Option<usize>, rate_hz: f64) -> Token {
    let behind = behind.and_then(|behind| runs.get(behind));
    let short = runs[near].token.single().is_some() && runs[near].duration_s(rate_hz) < TAKEOFF_S;
    if short && behind.is_some_and(|run| run.token == Token::Both) { Token::Both } else { runs[near].token }
}

/// How long both feet are planted in a stand: longer for slow walkers.
fn stand_length_s(runs: &[TokenRun], rate_hz: f64) -> f64 {
    let mut doubles: Vec<f64> = runs
        .windows(3)
        .filter(|three| three[1].token == Token::Both)
        .filter(|three| match (three[0].token.single(), three[2].token.single()) {
            (Some(before), Some(after)) => before != after,
            _ => false,
        })
        .map(|three| three[1].duration_s(rate_hz))
        .collect();
    match median(&mut doubles) {
        Some(median) if doubles.len() >= FEWEST_DOUBLE_SUPPORTS => {
            (STAND_IN_DOUBLE_SUPPORTS * median).clamp(STAND_S, LONGEST_STAND_S)
        }
        _ => STAND_S,
    }
}

#[cfg(test)]
mod tests {
    use super::super::gait_tokens::tests::spelled;
    use super::super::gait_tokens::token_runs;
    use super::Support::{Hop, Jump, Open, Stand};
    use super::*;

    #[test]
    fn stands_jumps_and_hops() {
        for (text, wanted) in [
            ("B.6", vec![Stand]),
            ("B.55", vec![Open]),
            ("B.3 N.1 B.3", vec![Open, Jump, Open]),
            ("B.3 N.05 B.3", vec![Open, Open, Open]),
            ("B.3 L.05 N.1 R.05 B.3", vec![Open, Jump, Jump, Jump, Open]),
            ("B.3 L.15 N.1 R.15 B.3", vec![Open, Open, Open, Open, Open]),
            ("L.3 N.2 B.3", vec![Open, Jump, Open]),
            ("L.3 N.15 B.3", vec![Open, Open, Open]),
            ("L.3 N.1 L.3", vec![Open, Hop, Open]),
            ("L.3 N.1 R.3", vec![Open, Open, Open]),
            ("N.3 L.3 N.3", vec![Open, Open, Open]),
        ] {
            assert_eq!(supports(&token_runs(&spelled(text, 100.0)), 100.0), wanted, "{text}");
        }
    }

    #[test]
    fn slow_walkers_stand_longer() {
        let double = |seconds: &str| format!("L.5 B{seconds} R.5 B{seconds} L.5 B{seconds} R.5 B.9");
        let last = |text: &str| supports(&token_runs(&spelled(text, 100.0)), 100.0).last().copied();
        assert_eq!(last(&double(".2")), Some(Stand));
        assert_eq!(last(&double(".55")), Some(Open));
        assert_eq!(last("L.5 B.55 R.5 B.55 L.5 B.9"), Some(Stand));
    }
}
