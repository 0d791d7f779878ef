//! Tokens N L R B: which feet are planted, as letters of a gait's grammar (T 3.2).

use super::labels::Foot;

/// Which feet are planted in a frame (T 3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Token {
    /// `N`: neither foot.
    Neither,
    /// `L`: the left one alone.
    Left,
    /// `R`: the right one alone.
    Right,
    /// `B`: both feet.
    Both,
}

/// A longest run of one token: half-open frame range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TokenRun {
    /// Its token.
    pub token: Token,
    /// First frame.
    pub first: usize,
    /// Frame after the last.
    pub end: usize,
}

impl Token {
    /// The token of two feet.
    pub fn of_feet(left: bool, right: bool) -> Token {
        match (left, right) {
            (false, false) => Token::Neither,
            (true, false) => Token::Left,
            (false, true) => Token::Right,
            (true, true) => Token::Both,
        }
    }

    /// The foot of a single support.
    pub fn single(self) -> Option<Foot> {
        match self {
            Token::Left => Some(Foot::Left),
            Token::Right => Some(Foot::Right),
            Token::Neither | Token::Both => None,
        }
    }

    /// Whether that foot is planted.
    pub fn plants(self, foot: Foot) -> bool {
        self == Token::Both || self.single() == Some(foot)
    }

    /// N, L, R or B.
    pub fn letter(self) -> char {
        ['N', 'L', 'R', 'B'][self as usize]
    }

    /// From its letter.
    pub fn from_letter(letter: char) -> Option<Token> {
        [Token::Neither, Token::Left, Token::Right, Token::Both].into_iter().find(|token| token.letter() == letter)
    }
}

impl TokenRun {
    /// Number of frames.
    pub fn n_frames(&self) -> usize {
        self.end - self.first
    }

    /// Duration.
    pub fn duration_s(&self, rate_hz: f64) -> f64 {
        self.n_frames() as f64 / rate_hz
    }
}

/// The runs of a token string.
pub fn token_runs(tokens: &[Token]) -> Vec<TokenRun> {
    let mut runs: Vec<TokenRun> = Vec::new();
    for (frame, &token) in tokens.iter().enumerate() {
        match runs.last_mut() {
            Some(run) if run.token == token => run.end = frame + 1,
            _ => runs.push(TokenRun { token, first: frame, end: frame + 1 }),
        }
    }
    runs
}

/// Runs shorter than this that return to the token before are flicker (CONTACTS 3.1), seconds.
const FLICKER_S: f64 = 0.045;

/// Runs without flicker (CONTACTS 3.1): a short run between equal tokens joins them, the first such run first, until
/// none is left. A foot lost or touched in passing (X N X, X B X, B L B, N R N) is flicker; L R L is not, nor is
/// L N R, the gap that tells a run from a walk.
pub fn steady_runs(tokens: &[Token], rate_hz: f64) -> Vec<TokenRun> {
    let mut steady: Vec<TokenRun> = Vec::new();
    for mut run in token_runs(tokens) {
        // No run in `steady` is flicker; joining one to its neighbors makes none of the earlier ones so.
        if let [.., before, short] = steady[..]
            && before.token == run.token
            && short.duration_s(rate_hz) < FLICKER_S
            && !(short.token.single().is_some() && before.token.single().is_some())
        {
            run.first = before.first;
            steady.truncate(steady.len() - 2);
        }
        steady.push(run);
    }
    steady
}

#[cfg(test)]
pub(super) mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    /// Tokens of a text such as `B2 L.4 B.15`: letters with seconds.
    pub(crate) fn spelled(text: &str, rate_hz: f64) -> Vec<Token> {
        text.split_whitespace()
            .flat_map(|word| {
                let token = Token::from_letter(word.chars().next().unwrap()).unwrap();
                let seconds: f64 = word[1..].parse().unwrap();
                vec![token; (seconds * rate_hz).round() as usize]
            })
            .collect()
    }

    fn steady(letters: &str) -> String {
        let tokens: Vec<Token> = letters.chars().map(|letter| Token::from_letter(letter).unwrap()).collect();
        let runs = steady_runs(&tokens, 30.0);
        runs.iter().flat_map(|run| vec![run.token.letter(); run.n_frames()]).collect()
    }

    #[test]
    fn runs_cover_every_frame_once() {
        let tokens = spelled("B2 L.4 B.1 R.3", 30.0);
        let runs = token_runs(&tokens);
        assert_eq!(runs.iter().map(|run| run.n_frames()).collect::<Vec<_>>(), [60, 12, 3, 9]);
        assert!(runs.windows(2).all(|pair| pair[0].end == pair[1].first));
        assert_eq!(token_runs(&[]), []);
    }

    #[test]
    fn flicker_joins_its_neighbors_and_the_gap_of_a_step_stays() {
        for (before, after) in [
            ("LLNLL", "LLLLL"),
            ("LLBLL", "LLLLL"),
            ("BBLBB", "BBBBB"),
            ("NNRNN", "NNNNN"),
            ("NNBNN", "NNNNN"),
            ("LLRLL", "LLRLL"),
            ("LLNRR", "LLNRR"),
            ("LLNNLL", "LLNNLL"),
            ("NLL", "NLL"),
            ("LLN", "LLN"),
            ("BLBLBLB", "BBBBBBB"),
            ("LNLBL", "LLLLL"),
            // The first goes first: N joins the Bs, which leaves a long B.
            ("NBNBB", "NNNBB"),
        ] {
            assert_eq!(steady(before), after, "{before}");
        }
    }

    #[test]
    fn tokens_know_their_feet() {
        assert!(Token::Both.plants(Foot::Left) && Token::Right.plants(Foot::Right));
        assert!(!Token::Right.plants(Foot::Left) && !Token::Neither.plants(Foot::Right));
        assert_eq!("NLRB".chars().map(|c| Token::from_letter(c).unwrap().letter()).collect::<String>(), "NLRB");
    }

    /// The definition, word for word.
    fn plain(mut tokens: Vec<Token>, rate_hz: f64) -> Vec<Token> {
        let single = |token: Token| token.single().is_some();
        while let Some((run, token)) = token_runs(&tokens).windows(3).find_map(|three| {
            let returns = three[0].token == three[2].token;
            let step = single(three[0].token) && single(three[1].token);
            (returns && !step && three[1].duration_s(rate_hz) < FLICKER_S).then_some((three[1], three[0].token))
        }) {
            tokens[run.first..run.end].fill(token);
        }
        tokens
    }

    proptest::proptest! {
        #[test]
        fn one_pass_does_what_starting_over_does(
            runs in proptest::collection::vec((0_usize..4, 1_usize..9), 0..20),
        ) {
            let all = [Token::Neither, Token::Left, Token::Right, Token::Both];
            let tokens: Vec<Token> = runs.iter().flat_map(|&(token, n)| vec![all[token]; n]).collect();
            proptest::prop_assert_eq!(steady_runs(&tokens, 100.0), token_runs(&plain(tokens, 100.0)));
        }
    }
}
