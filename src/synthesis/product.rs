//! The Cartesian product of what can be combined, counted exactly and walked lazily, never stored (T 5.4.2, DESIGN 6).
//!
//! A member is (base, donor, chain subset, alternate) of a pair that a composition rule allows, before any refusal.
//! Stand and jump donors have one alternate (they are placed by rule), cyclic ones as many as their ankle passes
//! allow. Only clips of one layout meet, for rotations are copied as they are; a clip is never its own donor.

use super::compose::Rule;
use super::correlation::{AnklePass, CorrelationSettings, count_alternates};
use super::parts::Part;
use super::portrait::Portrait;
use crate::annotate::{Foot, Gait};
use std::collections::BTreeMap;

/// Subsets of the four graftable chains that hold at least one.
pub const CHAIN_SUBSETS: u32 = 15;

/// One member of the product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Index of the base among the portraits.
    pub base: usize,
    /// Index of the donor.
    pub donor: usize,
    /// Bit n: the n-th of trunk, head, left arm, right arm.
    pub chains: u32,
    /// From 0, the default one.
    pub alternate: usize,
}

/// How many members the product has, by rule. `portraits` in the order of (source, name).
pub fn count(portraits: &[Portrait], settings: &CorrelationSettings) -> BTreeMap<Rule, u128> {
    // Whether two clips meet, and in how many ways, depends on this only; so classes are counted, not pairs.
    let mut classes = BTreeMap::<(&str, Gait, usize, Option<Foot>), (u128, &[AnklePass])>::new();
    for portrait in portraits {
        let passes = if is_cyclic(portrait.gait) { &portrait.passes[..] } else { &[] };
        let key = (portrait.layout.as_str(), portrait.gait, passes.len(), passes.first().map(|pass| pass.ahead));
        classes.entry(key).or_insert((0, passes)).0 += 1;
    }
    let mut sizes = BTreeMap::new();
    for (base, &(n_bases, base_passes)) in &classes {
        for (donor, &(n_donors, donor_passes)) in &classes {
            let Some(rule) = Rule::of(base.1, donor.1).filter(|_| base.0 == donor.0) else { continue };
            let pairs = n_bases * (n_donors - u128::from(base == donor));
            let alternates =
                if is_cyclic(donor.1) { count_alternates(base_passes, donor_passes, settings) as u128 } else { 1 };
            *sizes.entry(rule).or_insert(0) += pairs * alternates * u128::from(CHAIN_SUBSETS);
        }
    }
    sizes
}

/// Walks the whole product, by (base, donor, chains, alternate).
pub fn members<'a>(portraits: &'a [Portrait], settings: &'a CorrelationSettings) -> impl Iterator<Item = Member> + 'a {
    let pairs = (0..portraits.len()).flat_map(move |base| (0..portraits.len()).map(move |donor| (base, donor)));
    pairs.flat_map(move |(base, donor)| {
        let (b, d) = (&portraits[base], &portraits[donor]);
        let allowed = base != donor && b.layout == d.layout && Rule::of(b.gait, d.gait).is_some();
        let alternates = match (allowed, is_cyclic(d.gait)) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => count_alternates(&b.passes, &d.passes, settings),
        };
        (1..=CHAIN_SUBSETS)
            .flat_map(move |chains| (0..alternates).map(move |alternate| Member { base, donor, chains, alternate }))
    })
}

/// The parts that the bits of [`Member::chains`] stand for.
pub fn chain_parts(chains: u32) -> Vec<Part> {
    let graftable = Part::ALL.into_iter().filter(|part| part.is_graftable());
    graftable.enumerate().filter(|(bit, _)| chains >> bit & 1 == 1).map(|(_, part)| part).collect()
}

/// Whether ankle passes lay this gait over another.
pub(super) fn is_cyclic(gait: Gait) -> bool {
    matches!(gait, Gait::Walk | Gait::Run)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::portrait::{ARM_NUMBERS, LEG_NUMBERS};
    use super::*;

    fn portrait(n: usize, gait: Gait, n_passes: usize, layout: &str) -> Portrait {
        let foot = |k: usize| if (k + n).is_multiple_of(2) { Foot::Left } else { Foot::Right };
        Portrait {
            name: format!("s/{n}"),
            layout: layout.to_owned(),
            gait,
            rate_hz: 30.0,
            n_frames: 100,
            passes: (0..n_passes).map(|k| AnklePass { frame: 10.0 * k as f64, ahead: foot(k) }).collect(),
            in_step: true,
            active: [true, false],
            action_s: 1.0,
            arms: [0.0; ARM_NUMBERS],
            legs: [0.0; LEG_NUMBERS],
        }
    }

    #[test]
    fn the_count_is_the_length_of_the_walk() {
        let settings = CorrelationSettings::default();
        let gaits = [Gait::Walk, Gait::Stand, Gait::Run, Gait::Other, Gait::Walk, Gait::Jump, Gait::Run, Gait::Jump];
        let portraits: Vec<Portrait> =
            (0..24).map(|n| portrait(n, gaits[n % 8], n % 9, if n % 5 == 0 { "L1" } else { "L2" })).collect();
        let mut walked = BTreeMap::<Rule, u128>::new();
        for member in members(&portraits, &settings) {
            let (base, donor) = (&portraits[member.base], &portraits[member.donor]);
            assert_eq!(base.layout, donor.layout);
            *walked.entry(Rule::of(base.gait, donor.gait).unwrap()).or_insert(0) += 1;
        }
        let counted: BTreeMap<Rule, u128> =
            count(&portraits, &settings).into_iter().filter(|&(_, size)| size > 0).collect();
        assert_eq!(counted, walked);
        assert!(counted.contains_key(&Rule::JumpJump) && counted.contains_key(&Rule::WalkRun));
    }

    #[test]
    fn every_subset_of_chains_is_there_once() {
        let subsets: std::collections::BTreeSet<Vec<Part>> = (1..=CHAIN_SUBSETS).map(chain_parts).collect();
        assert_eq!(subsets.len(), 15);
        assert!(subsets.iter().all(|parts| !parts.is_empty()));
    }
}
