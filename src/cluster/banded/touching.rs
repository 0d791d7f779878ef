//! Components of a band that turned out to touch each other: their merges are not independent.

use super::super::metric::Vector;
use super::band::{Band, Done};
use super::components::Parts;
use super::join::{HalfGraph, Limit};
use super::point_tree::PointTree;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};

/// Drops the outcomes of components that others have taken in, and unites what has to be done again as one. `done`: by
/// the first slot of a component. Returns whether there is any to be done again.
pub(super) fn unite(band: &Band<'_>, done: &mut Vec<Done>, parts: &mut Parts) -> bool {
    let components = &band.components;
    let mut unions = Unions { parts, grown: BTreeSet::new() };
    // By component: the one whose outcome counts for it. The largest goes first.
    let mut holders = BTreeMap::<u32, u32>::new();
    done.sort_by_key(|&(slot, _)| (Reverse(components.slots(components.of(slot)).len()), slot));
    done.retain(|(slot, outcome)| {
        let own = components.of(*slot);
        match holders.entry(own) {
            Entry::Vacant(vacant) => vacant.insert(own),
            Entry::Occupied(_) => return false,
        };
        for &slot in &outcome.absorbed {
            let other = components.of(slot);
            let holder = *holders.entry(other).or_insert(own);
            if holder != own {
                unions.unite(band, own, holder);
            }
        }
        outcome.missed.iter().for_each(|&slot| unions.unite(band, own, components.of(slot)));
        true
    });
    let refreshed: Vec<(u32, Vector)> =
        done.iter().flat_map(|(slot, m)| m.refreshed.iter().map(|v| (components.of(*slot), *v))).collect();
    for [a, b] in close_ones(band, &refreshed) {
        unions.unite(band, a, b);
    }
    // What was taken in goes wherever its holder goes, and the other way about.
    loop {
        let n = unions.grown.len();
        for (&other, &holder) in &holders {
            if other != holder && unions.grown.contains(&other) != unions.grown.contains(&holder) {
                unions.unite(band, other, holder);
            }
        }
        if unions.grown.len() == n {
            return n > 0;
        }
    }
}

struct Unions<'a> {
    parts: &'a mut Parts,
    grown: BTreeSet<u32>,
}

impl Unions<'_> {
    fn unite(&mut self, band: &Band<'_>, a: u32, b: u32) {
        self.grown.extend([a, b]);
        let [a, b] = [a, b].map(|component| band.components.slots(component)[0]);
        self.parts.unite(a, b);
    }
}

/// Pairs of components that have refreshed means within the radius of each other.
fn close_ones(band: &Band<'_>, refreshed: &[(u32, Vector)]) -> BTreeSet<[u32; 2]> {
    let points: Vec<_> = refreshed.iter().map(|(_, vector)| band.basis.project(vector)).collect();
    let (tree, order) = PointTree::arrange(&points, band.tree.level);
    let vectors: Vec<Vector> = order.iter().map(|&at| refreshed[at as usize].1).collect();
    let owners: Vec<u32> = order.iter().map(|&at| refreshed[at as usize].0).collect();
    let limit = Limit { e_m2: band.reach.radius_m2 };
    let Some(graph) = HalfGraph::join(&tree, &vectors, limit, usize::MAX) else { return BTreeSet::new() };
    let pairs = (0..vectors.len() as u32).flat_map(|slot| graph.row(slot).map(move |(other, _)| [slot, other]));
    pairs.map(|pair| pair.map(|slot| owners[slot as usize])).filter(|[a, b]| a != b).collect()
}
