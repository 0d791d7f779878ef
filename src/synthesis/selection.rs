//! Which recipes to make first: new kinds before more of the same (GRAFTS 8).
//!
//! Clips are grouped twice, by their legs and by their arms. A *cell* is (rule, leg group of the base, arm group of the
//! donor). Cells come in the order of their distance to the nearest captured (legs, arms) pair, times the share of
//! the rule's grafts that the judge let through in our study; rules take turns, or stand donors would take nearly
//! all; each round takes one recipe from a cell, the clips nearest to the groups' centres first. Everything follows
//! from the portraits, before any clip is made, and ties go by name, so that the choice depends on nothing else.

use super::compose::Rule;
use super::correlation::{CorrelationSettings, is_playable};
use super::groups::{Groups, distance2};
use super::parts::Part;
use super::portrait::Portrait;
use super::product::is_cyclic;
use super::tables::Recipe;
use crate::annotate::Gait;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// How recipes are chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SelectionSettings {
    /// How many recipes to make.
    pub select: usize,
    /// Written into every recipe; grafts draw nothing from it.
    pub seed: u64,
    /// Groups of clips by their legs, at most.
    pub leg_groups: usize,
    /// Groups of clips by their arms, at most.
    pub arm_groups: usize,
}

/// What counts as the pass share of a rule that the study could not measure (there were no jumps in it).
const UNMEASURED_PASS_SHARE: f64 = 0.5;
/// Pairs of a cell that are looked at before it is given up for a round.
const TRIES_A_ROUND: usize = 64;

impl Default for SelectionSettings {
    fn default() -> Self {
        SelectionSettings { select: 200, seed: 1, leg_groups: 25, arm_groups: 60 }
    }
}

struct Cell {
    name: String,
    priority: f64,
    bases: Vec<usize>,
    donors: Vec<usize>,
    /// Pairs looked at so far.
    next: usize,
}

/// The cells of a rule, the most promising first.
struct Queue {
    rule: Rule,
    cells: Vec<Cell>,
    cursor: usize,
}

impl Cell {
    fn is_exhausted(&self) -> bool {
        self.next >= self.bases.len() * self.donors.len()
    }
}

/// Chooses recipes from the product of all clips. `portraits` in the order of (source, name); `may_give` says which
/// of them may become parents (license).
pub fn select(
    portraits: &[Portrait],
    may_give: &[bool],
    settings: &SelectionSettings,
    correlation: &CorrelationSettings,
) -> Vec<Recipe> {
    let legs: Vec<&[f64]> = portraits.iter().map(|portrait| &portrait.legs[..]).collect();
    let arms: Vec<&[f64]> = portraits.iter().map(|portrait| &portrait.arms[..]).collect();
    let leg_groups = Groups::of(&legs, settings.leg_groups);
    let arm_groups = Groups::of(&arms, settings.arm_groups);
    let mut queues: Vec<Queue> = cells_by_rule(portraits, may_give, &leg_groups, &arm_groups)
        .into_iter()
        .map(|(rule, cells)| Queue { rule, cells, cursor: 0 })
        .collect();
    let mut chosen = Vec::new();
    let mut taken = BTreeSet::new();
    while chosen.len() < settings.select && !queues.is_empty() {
        // Rules take turns; one that has nothing left drops out.
        queues.retain_mut(|queue| {
            if chosen.len() == settings.select {
                return true;
            }
            let Some((cell, base, donor)) = queue.next(portraits, correlation, &mut taken) else { return false };
            chosen.push(recipe(&portraits[base], &portraits[donor], queue.rule, &cell, settings.seed));
            true
        });
    }
    chosen
}

impl Queue {
    /// The next pair of the rule: one a cell, then the second of each cell, and so on.
    fn next(
        &mut self,
        portraits: &[Portrait],
        correlation: &CorrelationSettings,
        taken: &mut BTreeSet<(usize, usize)>,
    ) -> Option<(String, usize, usize)> {
        loop {
            let before = self.cells.iter().filter(|cell| !cell.is_exhausted()).count();
            if before == 0 {
                return None;
            }
            for _ in 0..self.cells.len() {
                let place = self.cursor;
                self.cursor = (self.cursor + 1) % self.cells.len();
                let cell = &mut self.cells[place];
                if let Some((base, donor)) = next_pair(cell, portraits, correlation, taken) {
                    return Some((cell.name.clone(), base, donor));
                }
            }
        }
    }
}

/// Cells of every rule, the most promising first.
fn cells_by_rule(portraits: &[Portrait], may_give: &[bool], legs: &Groups, arms: &Groups) -> BTreeMap<Rule, Vec<Cell>> {
    let captured: BTreeSet<(usize, usize)> = (0..portraits.len()).map(|clip| (legs.of[clip], arms.of[clip])).collect();
    // (layout, gait, group) -> clips, nearest to the group's centre first.
    let mut by_legs = BTreeMap::<(&str, Gait, usize), Vec<usize>>::new();
    let mut by_arms = BTreeMap::<(&str, Gait, usize), Vec<usize>>::new();
    for clip in (0..portraits.len()).filter(|&clip| may_give[clip]) {
        let portrait = &portraits[clip];
        by_legs.entry((&portrait.layout, portrait.gait, legs.of[clip])).or_default().push(clip);
        if is_cyclic(portrait.gait) || portrait.active != [false; 2] {
            by_arms.entry((&portrait.layout, portrait.gait, arms.of[clip])).or_default().push(clip);
        }
    }
    for (key, clips) in &mut by_legs {
        sort_by_distance(clips, |clip| distance2(&portraits[clip].legs, &legs.centers[key.2]));
    }
    for (key, clips) in &mut by_arms {
        sort_by_distance(clips, |clip| distance2(&portraits[clip].arms, &arms.centers[key.2]));
    }
    let mut queues = BTreeMap::<Rule, Vec<Cell>>::new();
    for (&(layout, base_gait, leg_group), bases) in &by_legs {
        for (&(donor_layout, donor_gait, arm_group), donors) in &by_arms {
            let Some(rule) = Rule::of(base_gait, donor_gait).filter(|_| layout == donor_layout) else { continue };
            let novelty = captured
                .iter()
                .map(|&(l, a)| {
                    distance2(&legs.centers[leg_group], &legs.centers[l])
                        + distance2(&arms.centers[arm_group], &arms.centers[a])
                })
                .fold(f64::INFINITY, f64::min);
            queues.entry(rule).or_default().push(Cell {
                name: format!("{}/legs{leg_group}/arms{arm_group}", rule.name()),
                priority: novelty.sqrt() * rule.expected_pass_share().unwrap_or(UNMEASURED_PASS_SHARE),
                bases: bases.clone(),
                donors: donors.clone(),
                next: 0,
            });
        }
    }
    for cells in queues.values_mut() {
        cells.sort_by(|a, b| b.priority.total_cmp(&a.priority).then_with(|| a.name.cmp(&b.name)));
    }
    queues
}

fn sort_by_distance(clips: &mut [usize], distance: impl Fn(usize) -> f64) {
    // Clips are numbered by name, so ties go by name.
    clips.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
}

/// The next pair of a cell that could work, walking outwards from the two nearest to the centres.
fn next_pair(
    cell: &mut Cell,
    portraits: &[Portrait],
    correlation: &CorrelationSettings,
    taken: &mut BTreeSet<(usize, usize)>,
) -> Option<(usize, usize)> {
    let (n_bases, n_donors) = (cell.bases.len(), cell.donors.len());
    for _ in 0..TRIES_A_ROUND {
        if cell.is_exhausted() {
            return None;
        }
        let (i, j) = diagonal(cell.next, n_bases, n_donors);
        cell.next += 1;
        let pair = (cell.bases[i], cell.donors[j]);
        if could_work(&portraits[pair.0], &portraits[pair.1], correlation) && taken.insert(pair) {
            return Some(pair);
        }
    }
    None
}

/// The n-th pair of a grid, by diagonals from the corner: (0,0), (0,1), (1,0), (0,2) ...
fn diagonal(n: usize, rows: usize, columns: usize) -> (usize, usize) {
    let mut left = n;
    for sum in 0..rows + columns - 1 {
        let first = (sum + 1).saturating_sub(columns);
        let count = sum.min(rows - 1) + 1 - first;
        if left < count {
            return (first + left, sum - first - left);
        }
        left -= count;
    }
    (0, 0)
}

/// What can be known without making the clip: lengths, passes, arms that keep no time or are in each other's way.
fn could_work(base: &Portrait, donor: &Portrait, correlation: &CorrelationSettings) -> bool {
    if base.name == donor.name {
        return false;
    }
    match donor.gait {
        Gait::Walk | Gait::Run => {
            base.in_step
                && donor.in_step
                && is_playable((&base.passes, base.rate_hz), (&donor.passes, donor.rate_hz), correlation)
        }
        _ => {
            let clash = base.gait == Gait::Stand && (0..2).any(|side| base.active[side] && donor.active[side]);
            donor.action_s > 0.0 && donor.action_s <= base.duration_s() && !clash
        }
    }
}

/// The recipe of a pair: active arms of stand and jump donors, both arms of cyclic ones.
fn recipe(base: &Portrait, donor: &Portrait, rule: Rule, cell: &str, seed: u64) -> Recipe {
    let parts = if is_cyclic(donor.gait) { Part::ARMS.to_vec() } else { donor.active_arms() };
    let mut recipe = Recipe {
        recipe: String::new(),
        kind: "graft".to_owned(),
        base: base.name.clone(),
        donor: Some(donor.name.clone()),
        chains: parts.into_iter().map(|part| part.name().to_owned()).collect(),
        alternate: None,
        options: "{}".to_owned(),
        seed,
        rule: rule.name().to_owned(),
        cell: Some(cell.to_owned()),
    };
    recipe.recipe = recipe.name_from_content();
    recipe
}

#[cfg(test)]
mod tests {
    use super::super::correlation::AnklePass;
    use super::super::portrait::{ARM_NUMBERS, LEG_NUMBERS};
    use super::*;
    use crate::annotate::Foot;

    #[test]
    fn clips_whose_arms_keep_no_time_are_not_paired() {
        let walk = |name: &str, in_step: bool| Portrait {
            name: name.to_owned(),
            layout: "L".to_owned(),
            gait: Gait::Walk,
            rate_hz: 30.0,
            n_frames: 100,
            passes: (0..8)
                .map(|k| AnklePass { frame: 12.0 * k as f64, ahead: [Foot::Left, Foot::Right][k % 2] })
                .collect(),
            in_step,
            active: [true; 2],
            action_s: 1.0,
            arms: [0.0; ARM_NUMBERS],
            legs: [0.0; LEG_NUMBERS],
        };
        let pairs = |a: bool, b: bool| could_work(&walk("a", a), &walk("b", b), &CorrelationSettings::default());
        assert!(pairs(true, true));
        assert!(!pairs(true, false) && !pairs(false, true));
    }

    #[test]
    fn diagonals_visit_every_pair_once() {
        for (rows, columns) in [(1, 1), (3, 5), (5, 3), (4, 4), (1, 7), (7, 1)] {
            let pairs: Vec<_> = (0..rows * columns).map(|n| diagonal(n, rows, columns)).collect();
            let unique: BTreeSet<_> = pairs.iter().copied().collect();
            assert_eq!(unique.len(), rows * columns);
            assert!(pairs.iter().all(|&(i, j)| i < rows && j < columns));
            assert!(pairs.windows(2).all(|two| two[0].0 + two[0].1 <= two[1].0 + two[1].1));
        }
    }
}
