//! The thesis' state machine: gaits of a token string, strictly (T 3.2.1, appendix C).
//!
//! Figures C.1-C.4 are not in the text; the transitions are as CONTACTS 3 reads them.

use super::gait_tokens::{Token, token_runs};
use super::labels::{Foot, Gait};

/// What the machine knows besides the present token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The thesis' Unknown_None, _Left, _Right, _Both: the token says which.
    Unknown,
    /// Walk_Left, _Right, _Both.
    Walk,
    /// Run_Left, Run_Right.
    Run,
    /// Run_Left_None, Run_Right_None: a flight after that foot; a landing on it is a hop.
    RunFlight(Foot),
    /// Jump_Both, and its kin for hops on one foot.
    Jump,
    /// Jump_None: a flight that must land as it took off.
    JumpFlight(Token),
}

impl State {
    fn gait(self) -> Gait {
        match self {
            State::Unknown => Gait::Unknown,
            State::Walk => Gait::Walk,
            State::Run | State::RunFlight(_) => Gait::Run,
            State::Jump | State::JumpFlight(_) => Gait::Jump,
        }
    }

    /// The state after the token changes from `now` to `new`.
    fn next(self, now: Token, new: Token) -> State {
        use Token::{Both, Left, Neither, Right};
        match (self, now, new) {
            (State::Unknown, Both, Left | Right) | (State::Unknown, Left | Right, Both) => State::Walk,
            (State::Unknown, Both, Neither) => State::JumpFlight(Both),
            (State::Unknown, Left, Neither) => State::RunFlight(Foot::Left),
            (State::Unknown, Right, Neither) => State::RunFlight(Foot::Right),
            (State::Unknown, Neither, Both) => State::Jump,
            (State::Unknown, Neither, Left | Right) => State::Run,

            (State::Walk, Both, Left | Right) | (State::Walk, Left | Right, Both) => State::Walk,

            (State::Run, Left, Neither) => State::RunFlight(Foot::Left),
            (State::Run, Right, Neither) => State::RunFlight(Foot::Right),
            (State::RunFlight(foot), Neither, Left | Right) => {
                if new.plants(foot) {
                    State::Jump
                } else {
                    State::Run
                }
            }

            (State::Jump, Left | Right | Both, Neither) => State::JumpFlight(now),
            (State::JumpFlight(takeoff), Neither, _) if new == takeoff => State::Jump,

            // Ambiguous: N in a walk, a direct exchange of feet, a run or jump that goes on without a flight.
            _ => State::Unknown,
        }
    }
}

/// The gait of every frame by the thesis' machine. Frames whose gait is not known yet take the gait that is entered
/// next; both feet planted to the end of the clip is a stand.
pub fn machine_gaits(tokens: &[Token]) -> Vec<Gait> {
    let runs = token_runs(tokens);
    let mut gaits = Vec::with_capacity(tokens.len());
    let mut state = State::Unknown;
    for pair in runs.windows(2) {
        let after = state.next(pair[0].token, pair[1].token);
        if state == State::Unknown {
            gaits.resize(pair[1].first, after.gait());
        } else if after.gait() != state.gait() {
            gaits.resize(pair[1].first, state.gait());
        }
        state = after;
    }
    let last = match (state, runs.last()) {
        (State::Unknown, Some(run)) if run.token == Token::Both => Gait::Stand,
        _ => state.gait(),
    };
    gaits.resize(tokens.len(), last);
    gaits
}

/// The strict class of a clip (T 3.2.1): the gait that all its frames have, else `other`. No frames: unknown.
pub fn machine_class(gaits: &[Gait]) -> Gait {
    match gaits.first() {
        None => Gait::Unknown,
        Some(&first) if gaits.iter().all(|&gait| gait == first) => first,
        Some(_) => Gait::Other,
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    fn gaits(letters: &str) -> String {
        let tokens: Vec<Token> = letters.chars().map(|letter| Token::from_letter(letter).unwrap()).collect();
        machine_gaits(&tokens).into_iter().map(|gait| gait.name().chars().next().unwrap()).collect()
    }

    #[test]
    fn every_transition_in_words() {
        for (tokens, wanted) in [
            ("", ""),
            ("N", "u"),
            ("L", "u"),
            ("B", "s"),
            ("BL", "ww"),
            ("LB", "ww"),
            ("BN", "jj"),
            ("NB", "jj"),
            ("NL", "rr"),
            ("LN", "rr"),
            ("LR", "uu"),
            ("BLR", "wwu"),
            ("BLN", "wwu"),
            ("BLNR", "wwrr"),
            ("LNRN", "rrrr"),
            ("LNL", "rrj"),
            ("LNLNL", "rrjjj"),
            ("LNLNR", "rrjju"),
            ("LNLB", "rrjs"),
            ("LNB", "rrs"),
            ("LNRB", "rrrs"),
            ("LNRL", "rrru"),
            ("BNBN", "jjjj"),
            ("BNL", "jju"),
            ("BNBL", "jjju"),
            ("BNBLB", "jjjww"),
        ] {
            assert_eq!(gaits(tokens), wanted, "{tokens}");
        }
    }

    #[test]
    fn a_clip_has_a_class_if_all_its_frames_do() {
        assert_eq!(machine_class(&[]), Gait::Unknown);
        assert_eq!(machine_class(&[Gait::Walk; 4]), Gait::Walk);
        assert_eq!(machine_class(&[Gait::Unknown; 4]), Gait::Unknown);
        assert_eq!(machine_class(&[Gait::Walk, Gait::Unknown]), Gait::Other);
    }
}
