//! From evidence to which feet are planted: the likeliest course through N, L, R and B (CONTACTS 2.11).
//!
//! What a change costs is hysteresis, de-bouncing and least duration in one; there is no window to set.

use crate::annotate::gait_tokens::Token;

/// What it costs when a foot is planted or lifted, units of evidence.
pub(super) const CHANGE_COST: f64 = 2.5;
/// Evidence counts once each thirtieth of a second, so that costs are a matter of seconds, not of frames.
pub(super) const EVIDENCE_PER_S: f64 = 30.0;
/// Less force than this speaks for flight, body weights; what a unit of that evidence is, its limits and its weight.
pub(super) const FLIGHT_FORCE_BW: f64 = 0.45;
const FLIGHT_UNIT_BW: f64 = 0.25;
const FLIGHT_LIMITS: [f64; 2] = [-2.0, 0.3];
const FLIGHT_WEIGHT: f64 = 1.5;

const STATES: [Token; 4] = [Token::Neither, Token::Left, Token::Right, Token::Both];

/// What a state costs to come to from each other: two feet change between L and R, N and B.
const COSTS: [[f64; 4]; 4] = {
    let mut costs = [[0.0; 4]; 4];
    let mut to = 0;
    while to < 4 {
        let mut from = 0;
        while from < 4 {
            costs[to][from] = CHANGE_COST * ((to ^ from) as u32).count_ones() as f64;
            from += 1;
        }
        to += 1;
    }
    costs
};

/// The likeliest tokens; of equals the earlier of N, L, R, B.
///
/// `log_odds`: of left and right foot being planted, `[frame]`; `force_bw`: vertical force in body weights, `[frame]`,
/// None where it is not known.
pub fn decode(log_odds: &[[f64; 2]], force_bw: &[Option<f64>], rate_hz: f64) -> Vec<Token> {
    let weight = EVIDENCE_PER_S / rate_hz;
    let gains = |frame: usize| {
        let [left, right] = log_odds[frame];
        let flight = force_bw[frame].map_or(0.0, |force| {
            FLIGHT_WEIGHT * ((FLIGHT_FORCE_BW - force) / FLIGHT_UNIT_BW).clamp(FLIGHT_LIMITS[0], FLIGHT_LIMITS[1])
        });
        [
            weight * (-left / 2.0 + -right / 2.0 + flight),
            weight * (left / 2.0 + -right / 2.0),
            weight * (-left / 2.0 + right / 2.0),
            weight * (left / 2.0 + right / 2.0),
        ]
    };
    let n_frames = log_odds.len();
    if n_frames == 0 {
        return Vec::new();
    }
    let mut score = gains(0);
    let mut came_from: Vec<[u8; 4]> = Vec::with_capacity(n_frames);
    came_from.push([0; 4]);
    for frame in 1..n_frames {
        let gains = gains(frame);
        let mut next = [0.0; 4];
        let mut came = [0_u8; 4];
        for to in 0..4 {
            let mut best = score[0] - COSTS[to][0];
            for from in 1..4 {
                let other = score[from] - COSTS[to][from];
                if other > best {
                    (best, came[to]) = (other, from as u8);
                }
            }
            next[to] = best + gains[to];
        }
        score = next;
        came_from.push(came);
    }
    let mut state = 0;
    for other in 1..4 {
        if score[other] > score[state] {
            state = other;
        }
    }
    let mut tokens = vec![Token::Neither; n_frames];
    for frame in (0..n_frames).rev() {
        tokens[frame] = STATES[state];
        state = usize::from(came_from[frame][state]);
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    fn letters(odds: &[[f64; 2]], force: &[Option<f64>], rate_hz: f64) -> String {
        decode(odds, force, rate_hz).iter().map(|token| token.letter()).collect()
    }

    #[test]
    fn short_doubt_changes_nothing_and_long_evidence_does() {
        let odds: Vec<[f64; 2]> = [3.0, 3.0, 3.0, -1.0, 3.0, -3.0, -3.0, 3.0, 3.0].map(|left| [left, -3.0]).to_vec();
        assert_eq!(letters(&odds, &[None; 9], 30.0), "LLLLLNNLL");
        // At 120 Hz the same frames are a quarter as long: not long enough.
        assert_eq!(letters(&odds, &[None; 9], 120.0), "LLLLLLLLL");
    }

    #[test]
    fn ties_go_to_the_earlier_letter_and_nothing_is_known_of_nothing() {
        assert_eq!(letters(&[[0.0, 0.0]; 3], &[None; 3], 30.0), "NNN");
        assert_eq!(letters(&[], &[], 30.0), "");
    }

    #[test]
    fn weight_on_the_feet_speaks_against_flight() {
        let odds = [[-0.5, -1.0]; 6];
        assert_eq!(letters(&odds, &[None; 6], 30.0), "NNNNNN");
        assert_eq!(letters(&odds, &[Some(1.0); 6], 30.0), "LLLLLL");
        assert_eq!(letters(&odds, &[Some(0.0); 6], 30.0), "NNNNNN");
    }

    /// Every course through the states, tried.
    fn best_by_trial(odds: &[[f64; 2]], force: &[Option<f64>], rate_hz: f64) -> f64 {
        let n = odds.len();
        (0..4_usize.pow(n as u32))
            .map(|course| {
                let states: Vec<usize> = (0..n).map(|frame| course / 4_usize.pow(frame as u32) % 4).collect();
                value(&states, odds, force, rate_hz)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }

    fn value(states: &[usize], odds: &[[f64; 2]], force: &[Option<f64>], rate_hz: f64) -> f64 {
        let gain = |frame: usize, state: usize| {
            let feet = [state & 1, state >> 1];
            let of_feet: f64 =
                (0..2).map(|foot| if feet[foot] == 1 { odds[frame][foot] } else { -odds[frame][foot] }).sum();
            let flight = force[frame].map_or(0.0, |force| 1.5 * ((0.45 - force) / 0.25).clamp(-2.0, 0.3));
            30.0 / rate_hz * (of_feet / 2.0 + if state == 0 { flight } else { 0.0 })
        };
        let gains: f64 = states.iter().enumerate().map(|(frame, &state)| gain(frame, state)).sum();
        gains - states.windows(2).map(|pair| COSTS[pair[1]][pair[0]]).sum::<f64>()
    }

    proptest::proptest! {
        #[test]
        fn no_other_course_is_likelier(
            odds in proptest::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 1..6),
            force in proptest::collection::vec(proptest::option::of(-0.5..2.0_f64), 6),
            rate_hz in proptest::sample::select(vec![15.0, 30.0, 60.0, 120.0]),
        ) {
            let odds: Vec<[f64; 2]> = odds.into_iter().map(|(left, right)| [left, right]).collect();
            let force = &force[..odds.len()];
            let states: Vec<usize> = decode(&odds, force, rate_hz).into_iter().map(|token| token as usize).collect();
            let found = value(&states, &odds, force, rate_hz);
            proptest::prop_assert!((found - best_by_trial(&odds, force, rate_hz)).abs() < 1e-9);
        }
    }
}
