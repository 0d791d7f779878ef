//! Gaits from steps: the gap between one foot's lift-off and the other's strike tells a run from a walk
//! (CONTACTS 3.4 to 3.6).
//!
//! Where the thesis' machine asks for a perfect string of tokens, this asks each step for its opinion and lets the
//! bout decide, so that one odd frame can't split a walk.

use super::gait_segments::absorb_short;
use super::gait_supports::{Support, supports};
use super::gait_tokens::{Token, TokenRun, steady_runs};
use super::labels::{Foot, Gait};

/// Gap that a walk and a run step have equally often, and the gap that counts one unit of evidence, seconds (3.4).
const GAP_S: (f64, f64) = (0.040, 0.020);
/// Least force that speaks neither way, and what the evidence from force is scaled by, body weights (3.4).
const LEAST_FORCE_BW: f64 = 0.15;
/// Limits of the evidence of a step, and of the part of it that force gives (3.4).
const STEP_LIMIT: f64 = 2.0;
const FORCE_LIMIT: f64 = 1.25;
/// The least force is sought this far around the middle of the step, seconds (3.4).
const FORCE_REACH_S: f64 = 0.05;
/// What a change between walk and run costs within a bout (3.5).
const CHANGE_COST: f64 = 2.0;
/// A flight at an edge takes its neighbor's gait if it is no longer than this, seconds (3.6).
const LONGEST_EDGE_FLIGHT_S: f64 = 0.6;
/// Both feet planted are a jump's crouch or recovery for this long beside its flight, seconds (3.6).
const CROUCH_S: f64 = 0.6;

/// What a detector knows beyond tokens.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evidence<'a> {
    /// `[frame]`: log-odds of left and right foot being planted.
    pub log_odds: Option<&'a [[f64; 2]]>,
    /// `[frame]`: vertical force in body weights; None where undefined.
    pub force_bw: Option<&'a [Option<f64>]>,
    /// How much longer the gap of a step is by this detector than by the one that the constants of gaps were fixed
    /// with (CONTACTS 2, as written), seconds: it finds strikes later or lift-offs earlier.
    pub wider_gaps_s: f64,
}

/// A step from one foot to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The foot that strikes.
    pub foot: Foot,
    /// Frame, with a fraction, at which the old foot lifts off.
    pub liftoff: f64,
    /// Frame, with a fraction, at which the new foot strikes.
    pub strike: f64,
    /// Evidence in -2..2: a run step if positive, a walk step if negative.
    pub run_evidence: f64,
}

/// Gaits of a token string.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepGaits {
    /// `[frame]`: unknown, stand, walk, run or jump.
    pub gaits: Vec<Gait>,
    /// Steps between opposite feet, in time.
    pub steps: Vec<Step>,
    /// Runs of tokens without flicker, which steps were read from.
    pub runs: Vec<TokenRun>,
}

impl Step {
    /// Frame, with a fraction, between lift-off and strike.
    pub fn middle(&self) -> f64 {
        (self.liftoff + self.strike) / 2.0
    }
}

/// The gait of every frame (CONTACTS 3). Works from tokens alone; log-odds make lift-off and strike sharper than a
/// frame, force weighs in where the gap doesn't decide.
///
/// Differs from CONTACTS 3.6 in one point: both feet planted for less than a stand, with no known gait beside, are a
/// stand only if they are all of the clip. In `B L B` or `N B` they are unknown, since a grammar that has these
/// strings is a walk's or a jump's.
pub fn step_gaits(tokens: &[Token], rate_hz: f64, evidence: Evidence<'_>) -> StepGaits {
    let runs = steady_runs(tokens, rate_hz);
    let supports = supports(&runs, rate_hz);
    let mut frames = Frames { gaits: vec![Gait::Unknown; tokens.len()], runs: &runs, rate_hz };
    for (run, support) in runs.iter().zip(&supports) {
        match support {
            Support::Open => {}
            Support::Stand => frames.fill(run.first, run.end, Gait::Stand),
            Support::Jump | Support::Hop => frames.fill(run.first, run.end, Gait::Jump),
        }
    }
    let bouts = bouts(&runs, &supports, rate_hz, evidence);
    let mut sides = vec![Sides::default(); runs.len()];
    let mut steps = Vec::new();
    for bout in &bouts {
        for (passage, gait) in bout.iter().zip(bout_gaits(bout)) {
            sides[passage.from].after = Some(gait);
            sides[passage.to].before = Some(gait);
            frames.fill(runs[passage.from].end, runs[passage.to].first, gait);
            steps.extend(passage.step);
        }
    }
    frames.fill_single_supports(&supports, &sides);
    frames.fill_edges();
    frames.fill_crouches(&supports);
    let gaits = absorb_short(frames.gaits, rate_hz);
    StepGaits { gaits, steps, runs }
}

/// From one single support to the next: two runs, and the step between them if the feet differ.
#[derive(Clone, Copy, Debug)]
struct Passage {
    from: usize,
    to: usize,
    step: Option<Step>,
}

/// Gaits of the steps into and out of a single support.
#[derive(Clone, Copy, Debug, Default)]
struct Sides {
    before: Option<Gait>,
    after: Option<Gait>,
}

/// Passages without a stand, jump or hop between them (3.5).
fn bouts(runs: &[TokenRun], supports: &[Support], rate_hz: f64, evidence: Evidence<'_>) -> Vec<Vec<Passage>> {
    let singles: Vec<usize> =
        (0..runs.len()).filter(|&at| runs[at].token.single().is_some() && supports[at] != Support::Jump).collect();
    let mut bouts = vec![Vec::new()];
    for pair in singles.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if supports[from + 1..to].iter().any(|&support| support != Support::Open) {
            bouts.push(Vec::new());
        } else if let Some(bout) = bouts.last_mut() {
            let step = match runs[to].token.single() {
                Some(foot) if runs[from].token != runs[to].token => Some(step(runs, from, to, foot, rate_hz, evidence)),
                _ => None,
            };
            bout.push(Passage { from, to, step });
        }
    }
    bouts
}

/// The step from the single support `from` to that of the other foot, `to` (3.4).
fn step(runs: &[TokenRun], from: usize, to: usize, foot: Foot, rate_hz: f64, evidence: Evidence<'_>) -> Step {
    let doubles = || runs[from + 1..to].iter().filter(|run| run.token == Token::Both);
    let old_foot = if foot == Foot::Left { Foot::Right } else { Foot::Left };
    let liftoff = crossing(evidence, old_foot, doubles().next_back().map_or(runs[from].end, |run| run.end));
    let strike = crossing(evidence, foot, doubles().next().map_or(runs[to].first, |run| run.first));
    let step = Step { foot, liftoff, strike, run_evidence: 0.0 };
    let gap = ((strike - liftoff) / rate_hz - evidence.wider_gaps_s - GAP_S.0) / GAP_S.1;
    let run_evidence = match evidence.force_bw.and_then(|force| least_force(force, step.middle(), rate_hz)) {
        None => gap,
        Some(least) => {
            let force = (LEAST_FORCE_BW - least) / LEAST_FORCE_BW;
            gap.clamp(-STEP_LIMIT, STEP_LIMIT) + force.clamp(-FORCE_LIMIT, FORCE_LIMIT)
        }
    };
    Step { run_evidence: run_evidence.clamp(-STEP_LIMIT, STEP_LIMIT), ..step }
}

/// Where a foot's log-odds pass zero between a frame and the one before; half-way where they don't or aren't known.
fn crossing(evidence: Evidence<'_>, foot: Foot, frame: usize) -> f64 {
    let odds = |frame: usize| Some(evidence.log_odds?.get(frame)?[foot as usize]);
    match (frame.checked_sub(1).and_then(odds), odds(frame)) {
        (Some(before), Some(after)) if before * after < 0.0 => {
            frame as f64 - 1.0 + before.abs() / (before.abs() + after.abs())
        }
        _ => frame as f64 - 0.5,
    }
}

/// The least defined force around a frame.
fn least_force(force_bw: &[Option<f64>], middle: f64, rate_hz: f64) -> Option<f64> {
    let reach = ((FORCE_REACH_S * rate_hz).round_ties_even() as usize).max(1);
    let middle = middle.round_ties_even().max(0.0) as usize;
    let end = middle.saturating_add(reach + 1).min(force_bw.len());
    let near = force_bw.get(middle.saturating_sub(reach)..end)?;
    near.iter().copied().flatten().min_by(f64::total_cmp)
}

/// Walk or run for each passage of a bout (3.5): the cheapest course, where a change costs; a tie is a walk.
fn bout_gaits(bout: &[Passage]) -> Vec<Gait> {
    let mut score = [0.0, 0.0];
    let mut came_from = Vec::with_capacity(bout.len());
    for (index, passage) in bout.iter().enumerate() {
        let evidence = passage.step.map_or(0.0, |step| step.run_evidence);
        let cost = if index == 0 { f64::INFINITY } else { CHANGE_COST };
        let from_run = [score[1] - cost > score[0], score[1] > score[0] - cost];
        let best = |state: usize, other: usize, from_other: bool| {
            if from_other { score[other] - cost } else { score[state] }
        };
        score = [best(0, 1, from_run[0]) - evidence, best(1, 0, !from_run[1]) + evidence];
        came_from.push(from_run);
    }
    let mut run = score[1] > score[0];
    let mut gaits = vec![Gait::Walk; bout.len()];
    for (gait, from_run) in gaits.iter_mut().zip(came_from).rev() {
        if run {
            *gait = Gait::Run;
        }
        run = from_run[usize::from(run)];
    }
    gaits
}

/// Gaits under construction.
struct Frames<'a> {
    gaits: Vec<Gait>,
    runs: &'a [TokenRun],
    rate_hz: f64,
}

impl Frames<'_> {
    fn fill(&mut self, first: usize, end: usize, gait: Gait) {
        self.gaits[first..end].fill(gait);
    }

    /// A single support is split at its middle between the steps before and after it; a jump or hop beside it counts
    /// as such a step. One without steps beside a stand is a shift of weight.
    fn fill_single_supports(&mut self, supports: &[Support], sides: &[Sides]) {
        for (at, run) in self.runs.iter().enumerate() {
            if run.token.single().is_none() || supports[at] == Support::Jump {
                continue;
            }
            let beside = [at.checked_sub(1), Some(at + 1)].map(|near| supports.get(near?).copied());
            let flown =
                |support: Option<Support>| matches!(support, Some(Support::Jump | Support::Hop)).then_some(Gait::Jump);
            let before = sides[at].before.or(flown(beside[0]));
            let after = sides[at].after.or(flown(beside[1]));
            let middle = (run.first + run.end) / 2;
            if let (Some(before), Some(after)) = (before.or(after), after.or(before)) {
                self.fill(run.first, middle, before);
                self.fill(middle, run.end, after);
            } else if beside.contains(&Some(Support::Stand)) {
                self.fill(run.first, run.end, Gait::Stand);
            }
        }
    }

    /// What is left of B and N at the edges takes its neighbor's gait: B always (the earlier neighbor first), N if it
    /// is short and that is no stand.
    fn fill_edges(&mut self) {
        for run in self.runs {
            if run.token.single().is_some() || self.gaits[run.first] != Gait::Unknown {
                continue;
            }
            let near = [run.first.checked_sub(1), Some(run.end)];
            let near = near
                .into_iter()
                .find_map(|frame| self.gaits.get(frame?).copied().filter(|&gait| gait != Gait::Unknown));
            let gait = match (run.token, near) {
                (Token::Both, Some(near)) => near,
                (Token::Both, None) if self.runs.len() == 1 => Gait::Stand,
                (Token::Neither, Some(near))
                    if near != Gait::Stand && run.duration_s(self.rate_hz) <= LONGEST_EDGE_FLIGHT_S =>
                {
                    near
                }
                _ => continue,
            };
            self.fill(run.first, run.end, gait);
        }
    }

    /// Crouch before and recovery after a jump's flight.
    fn fill_crouches(&mut self, supports: &[Support]) {
        let reach = (CROUCH_S * self.rate_hz).round_ties_even() as usize;
        for (at, flight) in self.runs.iter().enumerate() {
            if flight.token != Token::Neither || supports[at] != Support::Jump {
                continue;
            }
            let outside = |near: &usize| supports[*near] != Support::Jump;
            if let Some(before) = (0..at).rev().find(outside).map(|near| self.runs[near])
                && before.token == Token::Both
            {
                self.fill(before.end.saturating_sub(reach).max(before.first), before.end, Gait::Jump);
            }
            if let Some(after) = (at + 1..self.runs.len()).find(outside).map(|near| self.runs[near])
                && after.token == Token::Both
            {
                self.fill(after.first, after.first.saturating_add(reach).min(after.end), Gait::Jump);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::gait_segments::gait_runs;
    use super::super::gait_tokens::tests::spelled;
    use super::*;

    fn words(text: &str, rate_hz: f64) -> String {
        let gaits = step_gaits(&spelled(text, rate_hz), rate_hz, Evidence::default()).gaits;
        gait_runs(&gaits).iter().map(|(gait, _)| gait.name()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn segments_of_short_stories() {
        for (text, wanted) in [
            ("L.3", "unknown"),
            ("B.3", "stand"),
            ("B.3 L.3", "unknown"),
            ("B.3 L.3 B.3", "unknown"),
            ("N.3 B.3", "unknown"),
            ("L.3 B.1", "unknown"),
            ("B1 L.3 B.5", "stand"),
            ("B.1 L.4 B.1 R.4 B.1", "walk"),
            ("N.1 L.2 N.1 R.2 N.1", "run"),
            ("L.4 B.1 R.4 B.1 L.4 N.1 R.2 N.1 L.2 N.1 R.2 N.1 L.2", "walk run"),
            ("B2 L.3 N.3 L.3 N.3 L.3 B2", "stand jump stand"),
            ("N1 B.4 L.4 B.1 R.4", "unknown walk"),
        ] {
            assert_eq!(words(text, 60.0), wanted, "{text}");
        }
    }

    #[test]
    fn one_odd_step_does_not_split_a_bout_but_three_do() {
        assert_eq!(words("L.4 B.1 R.4 B.1 L.4 N.1 R.4 B.1 L.4 B.1 R.4", 60.0), "walk");
        let runs = "L.2 N.1 R.2 N.1 ".repeat(3);
        let walks = "L.4 B.1 R.4 B.1 ".repeat(2);
        assert_eq!(words(&format!("{walks}{runs}{walks}"), 60.0), "walk run walk");
    }

    #[test]
    fn log_odds_place_the_crossing_between_frames() {
        let odds = [[3.0, -1.0], [1.0, 1.0], [-3.0, 3.0]];
        let evidence = Evidence { log_odds: Some(&odds), ..Evidence::default() };
        assert_eq!(crossing(evidence, Foot::Left, 2), 1.25);
        assert_eq!(crossing(evidence, Foot::Right, 1), 0.5);
        assert_eq!(crossing(evidence, Foot::Left, 1), 0.5);
        assert_eq!(crossing(evidence, Foot::Left, 7), 6.5);
        assert_eq!(crossing(Evidence::default(), Foot::Left, 2), 1.5);
    }

    #[test]
    fn force_decides_where_the_gap_does_not() {
        // A gap of 0.04 s speaks neither way.
        let tokens = spelled("L.4 N.04 R.4", 100.0);
        let step = |force: Option<f64>| {
            let force_bw = vec![force; tokens.len()];
            let evidence = Evidence { force_bw: Some(&force_bw), ..Evidence::default() };
            step_gaits(&tokens, 100.0, evidence).steps[0].run_evidence
        };
        assert!(step(None).abs() < 1e-9);
        assert!((step(Some(0.0)) - 1.0).abs() < 1e-9);
        assert!((step(Some(0.9)) + 1.25).abs() < 1e-9);
        assert_eq!(step_gaits(&tokens, 100.0, Evidence::default()).steps[0].foot, Foot::Right);
    }
}
