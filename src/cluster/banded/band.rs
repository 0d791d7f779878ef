//! What the merges of a band work on, and all of them together.

use super::super::metric::{LANES, Vector};
use super::super::search_basis::SearchBasis;
use super::components::{Components, Parts};
use super::items::Items;
use super::join::HalfGraph;
use super::merge_loop::{Outcome, Workshop, merge_component};
use super::point_tree::PointTree;
use super::{Reach, Step, touching};
use rayon::prelude::*;
use std::cmp::Reverse;

/// What the merges of a band work on.
pub(super) struct Band<'a> {
    pub(super) basis: &'a SearchBasis,
    pub(super) tree: &'a PointTree,
    /// `[slot]`
    pub(super) vectors: &'a [Vector],
    /// `[slot]`
    pub(super) members: &'a [u32],
    pub(super) graph: &'a HalfGraph,
    pub(super) components: Components,
    pub(super) reach: Reach,
    /// What a deficit may be.
    pub(super) slack_m2: f64,
    /// What E moves by where a mean is rounded.
    pub(super) rounding_m2: f64,
}

/// Where the vector of an item is: in the slot it had at the beginning of the band, or among the means of its component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source(u32);

/// Set for means; slots and means are fewer than samples, of which there are at most this many.
const MEAN: u32 = 1 << 31;

impl Source {
    pub(super) fn of_slot(slot: u32) -> Source {
        Source(slot)
    }

    pub(super) fn of_mean(mean: u32) -> Source {
        Source(mean | MEAN)
    }

    pub(super) fn slot(self) -> Option<u32> {
        (self.0 & MEAN == 0).then_some(self.0)
    }

    pub(super) fn mean(self) -> Option<u32> {
        (self.0 & MEAN != 0).then_some(self.0 & !MEAN)
    }

    #[inline(always)]
    pub(super) fn vector<'a>(self, by_slot: &'a [Vector], means: &'a [Vector]) -> &'a Vector {
        if self.0 & MEAN == 0 { &by_slot[self.0 as usize] } else { &means[(self.0 & !MEAN) as usize] }
    }
}

/// A component, by its first slot, and what came of it.
pub(super) type Done = (u32, Outcome);

/// Merges what is closer than the band's top, in all components. Those that touch others are done again as one.
pub(super) fn merge_band(
    basis: &SearchBasis,
    tree: &PointTree,
    items: &Items,
    graph: &HalfGraph,
    reach: Reach,
) -> (Vec<Outcome>, Step) {
    let mut parts = Parts::of_graph(items.len(), graph);
    let mut band = Band {
        basis,
        tree,
        vectors: &items.vectors,
        members: &items.members,
        graph,
        components: Components::new(&mut parts, &items.numbers),
        reach,
        slack_m2: (reach.radius_m2 - reach.top_m2) / 2.0 * (1.0 - 1e-9),
        rounding_m2: rounding_m2(&items.vectors, reach.radius_m2),
    };
    let mut pending = with_something_to_merge(&band);
    let mut largest = 0;
    let mut again = 0;
    let mut done: Vec<Done> = Vec::new();
    loop {
        // The largest first, so that no thread begins it when all others are through.
        pending.sort_by_key(|&component| (Reverse(band.components.slots(component).len()), component));
        largest = pending.first().map_or(0, |&component| band.components.slots(component).len()).max(largest);
        done.par_extend(pending.into_par_iter().with_max_len(1).map_init(Workshop::default, |workshop, component| {
            (band.components.slots(component)[0], merge_component(&band, component, workshop))
        }));
        if !touching::unite(&band, &mut done, &mut parts) {
            let refreshed = done.iter().map(|(_, outcome)| outcome.refreshed.len()).sum();
            let outcomes = done.into_iter().map(|(_, outcome)| outcome).collect();
            return (outcomes, Step::Merged { refreshed, largest, again });
        }
        let components = Components::new(&mut parts, &items.numbers);
        pending = Vec::new();
        done.retain(|&(slot, _)| {
            let component = components.of(slot);
            let has_grown = components.slots(component).len() > band.components.slots(band.components.of(slot)).len();
            if has_grown {
                pending.push(component);
            }
            !has_grown
        });
        pending.sort_unstable();
        pending.dedup();
        again += pending.len();
        band.components = components;
    }
}

/// Components in which some pair is closer than the band's top.
fn with_something_to_merge(band: &Band<'_>) -> Vec<u32> {
    let mut merges = vec![false; band.components.len()];
    for slot in 0..band.vectors.len() as u32 {
        if band.graph.row(slot).any(|(_, e)| e < band.reach.top_m2) {
            merges[band.components.of(slot) as usize] = true;
        }
    }
    (0..band.components.len() as u32).filter(|&component| merges[component as usize]).collect()
}

/// What E of a pair within the radius moves by where one of both is rounded to f32.
fn rounding_m2(vectors: &[Vector], radius_m2: f64) -> f64 {
    let largest_of = |vector: &Vector| vector.0.iter().fold(0.0_f32, |largest, x| largest.max(x.abs()));
    let largest = vectors.par_iter().map(largest_of).reduce(|| 0.0, f32::max);
    // Half a unit in the last place of f32, in each coordinate.
    let rho = 2.0_f64.powi(-24) * (LANES as f64).sqrt() * f64::from(largest);
    2.0 * radius_m2.sqrt() * rho + rho * rho
}
