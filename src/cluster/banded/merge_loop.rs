//! The merges of one component of a band's graph, by itself: closest pair first, on lists of neighbors.
//!
//! ```text
//! a, b with E(a, b) least -> c, their mean
//! deficit(c) = share_a deficit(a) + share_b deficit(b) + share_a share_b E(a, b) + rounding
//! deficit(c) within the slack: c's neighbors are among those of a and b; else c asks the tree again (a *refresh*)
//! ```
//!
//! Why no pair is missed: `mod.rs`. A refresh may find samples of a component that has not been looked at: then that one
//! is brought to where this one stands, and both go on as one (*absorbed*). Where that cannot be done, the caller has to
//! do both from the start.

use super::super::metric::{Vector, centroid};
use super::band::{Band, Source};
use super::join::Limit;
use super::kernels;
use super::point_tree::{Pile, Query};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// A pair by (bits of E, lower item, higher item): positive floats are in the order of their bits.
type Key = (u64, u32, u32);

/// A merge inside a component. Its items count in the order in which the component came to know them.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalMerge {
    pub(super) e: f64,
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) made: u32,
}

/// A mean that is alive at the end of the band.
pub(super) struct Survivor {
    /// Slot of its heaviest ancestor at the beginning of the band, which is free now.
    pub(super) slot: u32,
    pub(super) item: u32,
    pub(super) members: u32,
    pub(super) vector: Vector,
}

/// What came of a component.
#[derive(Default)]
pub(super) struct Outcome {
    pub(super) merges: Vec<LocalMerge>,
    /// By item: its slot if it was there at the beginning of the band, else none.
    pub(super) slots: Vec<Option<u32>>,
    pub(super) survivors: Vec<Survivor>,
    /// Means that asked the tree again, as they were then.
    pub(super) refreshed: Vec<Vector>,
    /// Components that were taken in, by their first slot.
    pub(super) absorbed: Vec<u32>,
    /// Components that should have been, but could not: all that was done here is void.
    pub(super) missed: Vec<u32>,
}

/// An item: one that was there at the beginning of the band, or a mean made in it.
#[derive(Clone, Copy)]
struct Item {
    /// Its neighbors, in `neighbors`.
    first: usize,
    end: usize,
    source: Source,
    members: u32,
    /// Its own, or that of its heaviest ancestor.
    slot: u32,
    deficit: f64,
}

/// Memory that is used again from one component to the next.
#[derive(Default)]
pub(super) struct Workshop {
    items: Vec<Item>,
    neighbors: Vec<u32>,
    /// Means made in this band.
    means: Vec<Vector>,
    /// Live item that each item has become part of; found through others.
    became: Vec<u32>,
    /// Last item that each item was a candidate of.
    stamp: Vec<u32>,
    /// First item of each component in here, the own one first.
    offsets: Vec<(u32, u32)>,
    picks: Vec<u32>,
    sources: Vec<Source>,
    errors: Vec<f64>,
    hits: Vec<u32>,
    first_keys: Vec<Key>,
    next_first: usize,
    keys: BinaryHeap<Reverse<Key>>,
    /// The largest E so far, in bits: what is less in another component is merged before what comes here next.
    highest: u64,
    /// Refreshed items that earlier items have as neighbors beside those in their lists.
    later: BTreeMap<u32, Vec<u32>>,
    /// Refreshed items.
    refreshed: Vec<u32>,
    /// Their vectors then.
    pile: Pile,
}

/// Merges what is closer than the band's top.
pub(super) fn merge_component(band: &Band<'_>, component: u32, workshop: &mut Workshop) -> Outcome {
    let mut outcome = Outcome::default();
    workshop.clear();
    workshop.first_keys = workshop.lay_out(band, component);
    workshop.first_keys.sort_unstable();
    workshop.run(band, &mut outcome);
    outcome
}

impl Workshop {
    fn clear(&mut self) {
        self.items.clear();
        self.neighbors.clear();
        self.means.clear();
        self.became.clear();
        self.stamp.clear();
        self.offsets.clear();
        self.first_keys.clear();
        self.next_first = 0;
        self.keys.clear();
        self.highest = 0;
        self.later.clear();
        self.refreshed.clear();
        self.pile.clear();
    }

    /// Takes in the items of a component and their lists of neighbors both ways. Returns the keys of what may merge.
    fn lay_out(&mut self, band: &Band<'_>, component: u32) -> Vec<Key> {
        let slots = band.components.slots(component);
        let offset = self.items.len() as u32;
        let item_of = |slot: u32| offset + band.components.place(slot);
        self.offsets.push((component, offset));
        self.became.extend((offset..).zip(slots).map(|(item, _)| item));
        self.stamp.resize(self.became.len(), u32::MAX);
        self.items.extend(slots.iter().map(|&slot| Item {
            first: 0,
            end: 0,
            source: Source::of_slot(slot),
            members: band.members[slot as usize],
            slot,
            deficit: 0.0,
        }));
        let mut keys = Vec::new();
        for (item, &slot) in (offset..).zip(slots) {
            for (other, e) in band.graph.row(slot) {
                let other = item_of(other);
                self.items[item as usize].end += 1;
                self.items[other as usize].end += 1;
                if e < band.reach.top_m2 {
                    keys.push((e.to_bits(), item.min(other), item.max(other)));
                }
            }
        }
        let mut end = self.neighbors.len();
        for item in &mut self.items[offset as usize..] {
            let n = item.end;
            (item.first, item.end) = (end, end);
            end += n;
        }
        self.neighbors.resize(end, 0);
        for (item, &slot) in (offset..).zip(slots) {
            for (other, _) in band.graph.row(slot) {
                let other = item_of(other);
                for (of, is) in [(item, other), (other, item)] {
                    let of = &mut self.items[of as usize];
                    self.neighbors[of.end] = is;
                    of.end += 1;
                }
            }
        }
        keys
    }

    /// The least key; gone from where it was.
    fn least(&mut self) -> Option<Key> {
        match (self.first_keys.get(self.next_first), self.keys.peek()) {
            (Some(first), Some(Reverse(new))) if first > new => self.keys.pop().map(|Reverse(key)| key),
            (Some(&first), _) => {
                self.next_first += 1;
                Some(first)
            }
            (None, _) => self.keys.pop().map(|Reverse(key)| key),
        }
    }

    /// Merges, closest pair first, until none is left.
    fn run(&mut self, band: &Band<'_>, outcome: &mut Outcome) {
        let mut last = 0;
        while let Some((e_bits, a, b)) = self.least() {
            // Items that were taken in later are not in the order of their numbers, by which ties are broken.
            if e_bits == last && !outcome.absorbed.is_empty() {
                outcome.missed.extend_from_slice(&outcome.absorbed);
            }
            if self.became[a as usize] != a || self.became[b as usize] != b {
                continue;
            }
            last = e_bits;
            self.highest = self.highest.max(e_bits);
            self.merge(band, f64::from_bits(e_bits), a, b, outcome);
        }
        self.close(outcome);
    }

    /// Merges two items.
    fn merge(&mut self, band: &Band<'_>, e: f64, a: u32, b: u32, outcome: &mut Outcome) {
        let [of_a, of_b] = [a, b].map(|item| self.items[item as usize]);
        let members = of_a.members + of_b.members;
        let mean = {
            let [va, vb] = [of_a.source, of_b.source].map(|source| source.vector(band.vectors, &self.means));
            centroid(va, of_a.members, vb, of_b.members)
        };
        let (share_a, share_b) =
            (f64::from(of_a.members) / f64::from(members), f64::from(of_b.members) / f64::from(members));
        let deficit = share_a * of_a.deficit + share_b * of_b.deficit + share_a * share_b * e + band.rounding_m2;
        let is_refresh = deficit > band.slack_m2;
        if is_refresh {
            self.ask_the_tree(band, &mean, outcome);
        }
        let c = self.items.len() as u32;
        outcome.merges.push(LocalMerge { e, a, b, made: c });
        self.became[a as usize] = c;
        self.became[b as usize] = c;
        self.became.push(c);
        self.stamp.push(c);
        if is_refresh {
            self.candidates(c, &[], true);
            self.refreshed.push(c);
            self.pile.push(&band.basis.project(&mean), mean);
        } else {
            self.candidates(c, &[(a, of_a), (b, of_b)], false);
        }
        let Workshop { picks, sources, errors, items, .. } = self;
        sources.clear();
        sources.extend(picks.iter().map(|&pick| items[pick as usize].source));
        kernels::errors(band.tree.level, &mean, band.vectors, &self.means, sources, errors);
        let first = self.neighbors.len();
        for (&other, &e) in self.picks.iter().zip(&self.errors) {
            if e < band.reach.radius_m2 {
                self.neighbors.push(other);
                if e < band.reach.top_m2 {
                    self.keys.push(Reverse((e.to_bits(), other, c)));
                }
                if is_refresh {
                    self.later.entry(other).or_default().push(c);
                }
            }
        }
        self.items.push(Item {
            first,
            end: self.neighbors.len(),
            source: Source::of_mean(self.means.len() as u32),
            members,
            slot: if of_b.members > of_a.members { of_b.slot } else { of_a.slot },
            deficit: if is_refresh { 0.0 } else { deficit },
        });
        self.means.push(mean);
    }

    /// Into `picks`: live items, each once, that the parents' lists or what the tree found (`hits`) lead to.
    fn candidates(&mut self, c: u32, parents: &[(u32, Item)], with_hits: bool) {
        let Workshop { became, stamp, picks, neighbors, later, hits, .. } = self;
        picks.clear();
        let mut pick = |listed: u32| {
            let item = live(became, listed);
            if stamp[item as usize] != c {
                stamp[item as usize] = c;
                picks.push(item);
            }
        };
        for (parent, item) in parents {
            neighbors[item.first..item.end].iter().for_each(|&listed| pick(listed));
            if !later.is_empty()
                && let Some(more) = later.get(parent)
            {
                more.iter().for_each(|&listed| pick(listed));
            }
        }
        if with_hits {
            hits.iter().for_each(|&listed| pick(listed));
        }
    }

    /// Into `hits`: items, dead ones too, near which a mean lies: from the tree, and from the refreshed ones. Takes in
    /// the components that they are of.
    fn ask_the_tree(&mut self, band: &Band<'_>, mean: &Vector, outcome: &mut Outcome) {
        let point = band.basis.project(mean);
        let query = Query { vector: mean, point: &point };
        let limit = Limit { e_m2: band.reach.radius_m2 };
        let mut hits = std::mem::take(&mut self.hits);
        kernels::within(band.tree.level, band.tree, band.vectors, &query, limit, &mut hits);
        hits.retain_mut(|hit| {
            let component = band.components.of(*hit);
            if !self.offsets.iter().any(|&(taken_in, _)| taken_in == component) {
                self.absorb(band, component, outcome);
            }
            let offset = self.offsets.iter().find(|(taken_in, _)| *taken_in == component);
            offset.is_some_and(|&(_, offset)| {
                *hit = offset + band.components.place(*hit);
                true
            })
        });
        let mut places = Vec::new();
        kernels::within_pile(band.tree.level, &self.pile, &query, limit, &mut places);
        hits.extend(places.iter().map(|&at| self.refreshed[at as usize]));
        self.hits = hits;
    }

    /// Takes in a component, unless it would have merged something by now: then it is `missed`.
    fn absorb(&mut self, band: &Band<'_>, component: u32, outcome: &mut Outcome) {
        let slots = band.components.slots(component);
        let mut errors = slots.iter().flat_map(|&slot| band.graph.row(slot)).map(|(_, e)| e);
        if errors.any(|e| e.to_bits() <= self.highest) {
            outcome.missed.push(slots[0]);
            return;
        }
        outcome.absorbed.push(slots[0]);
        let keys = self.lay_out(band, component);
        self.keys.extend(keys.into_iter().map(Reverse));
    }

    /// Hands over what is left.
    fn close(&mut self, outcome: &mut Outcome) {
        outcome.slots.extend(self.items.iter().map(|item| item.source.slot()));
        for (number, item) in (0..).zip(&self.items) {
            if let Some(mean) = item.source.mean()
                && self.became[number as usize] == number
            {
                let &Item { slot, members, .. } = item;
                let vector = self.means[mean as usize];
                outcome.survivors.push(Survivor { slot, item: number, members, vector });
            }
        }
        outcome.refreshed.append(&mut self.pile.vectors);
    }
}

/// The live item that an item has become part of; shortens the way there.
fn live(became: &mut [u32], item: u32) -> u32 {
    let mut item = item;
    while became[item as usize] != item {
        let next = became[item as usize];
        became[item as usize] = became[next as usize];
        item = became[item as usize];
    }
    item
}
