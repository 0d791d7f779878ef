//! Foot plant states: what is planted now, and the single support before it (T 4.2.2).

use super::gait_tokens::{Token, token_runs};
use super::labels::{Foot, PlantState};

/// The plant state of every frame.
///
/// L, R: that foot alone. LB, RB: both, the single support before was L, R. LN, RN: none, straight after L, R.
/// N: none, after both. Where T 4.2.2 is silent (DESIGN 6): both feet after a flight take the single support before
/// the flight; a leading B takes the foot that lifts first (RB before L, as R RB L in a walk); with no foot to
/// take, LB; a leading N is N.
pub fn plant_states(tokens: &[Token]) -> Vec<PlantState> {
    let runs = token_runs(tokens);
    let mut states = Vec::with_capacity(tokens.len());
    let mut last_single: Option<Foot> = None;
    for (at, run) in runs.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| runs[before].token);
        let state = match run.token {
            Token::Left => PlantState::L,
            Token::Right => PlantState::R,
            Token::Both => {
                // The foot that lifts first out of a leading B is the one that is not planted next.
                let next_single = runs.get(at + 1).filter(|_| at == 0).and_then(|next| next.token.single());
                let lifts_first = next_single.map(|foot| if foot == Foot::Left { Foot::Right } else { Foot::Left });
                match last_single.or(lifts_first) {
                    Some(Foot::Right) => PlantState::RB,
                    Some(Foot::Left) | None => PlantState::LB,
                }
            }
            Token::Neither => match before {
                Some(Token::Left) => PlantState::LN,
                Some(Token::Right) => PlantState::RN,
                _ => PlantState::N,
            },
        };
        last_single = run.token.single().or(last_single);
        states.resize(run.end, state);
    }
    states
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    #[test]
    fn the_thesis_states_and_where_it_is_silent() {
        for (tokens, wanted) in [
            ("", ""),
            ("L B R B L", "L LB R RB L"),
            ("L N R N L", "L LN R RN L"),
            ("L B N B R", "L LB N LB R"),
            ("R N B L", "R RN RB L"),
            ("R B N B", "R RB N RB"),
            ("L R N", "L R RN"),
            // Leading tokens.
            ("B L", "RB L"),
            ("B R", "LB R"),
            ("B", "LB"),
            ("B N B L", "LB N LB L"),
            ("N B R", "N LB R"),
            ("N L", "N L"),
        ] {
            let tokens: Vec<Token> = tokens
                .split_whitespace()
                .map(|word| Token::from_letter(word.chars().next().unwrap()).unwrap())
                .collect();
            // Every token lasts three frames.
            let held: Vec<Token> = tokens.iter().flat_map(|&token| [token; 3]).collect();
            let states = plant_states(&held);
            assert!(states.chunks(3).all(|run| run[0] == run[1] && run[1] == run[2]));
            let names: Vec<&str> = states.iter().step_by(3).map(|state| state.name()).collect();
            assert_eq!(names.join(" "), wanted);
        }
    }
}
