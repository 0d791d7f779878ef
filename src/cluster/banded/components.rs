//! Which live items hang together by pairs of a band's graph.

use super::join::HalfGraph;
use rayon::prelude::*;

/// The slots of each component.
pub(super) struct Components {
    /// `[slot]`: its component.
    of: Vec<u32>,
    /// `[slot]`: its place among the slots of its component.
    places: Vec<u32>,
    /// `[component]`: where its slots begin; closed by the end of the last.
    starts: Vec<u32>,
    /// By component, then by the number of the item in the slot.
    slots: Vec<u32>,
}

/// Sets of slots that are being united: each slot leads to a lower one of its set, the lowest to itself.
pub(super) struct Parts(Vec<u32>);

impl Parts {
    pub(super) fn of_graph(n: usize, graph: &HalfGraph) -> Parts {
        let mut parts = Parts((0..n as u32).collect());
        for slot in 0..n as u32 {
            graph.row(slot).for_each(|(other, _)| parts.unite(slot, other));
        }
        parts
    }

    fn lowest(&mut self, slot: u32) -> u32 {
        let mut slot = slot;
        while self.0[slot as usize] != slot {
            let next = self.0[slot as usize];
            self.0[slot as usize] = self.0[next as usize];
            slot = self.0[slot as usize];
        }
        slot
    }

    pub(super) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.lowest(a), self.lowest(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

impl Components {
    /// `numbers`: of the item in each slot.
    pub(super) fn new(parts: &mut Parts, numbers: &[u32]) -> Components {
        let n = numbers.len();
        let mut of = vec![0; n];
        let mut starts = vec![0];
        for slot in 0..n {
            // The lowest slot of a part comes first.
            let lowest = parts.lowest(slot as u32) as usize;
            if lowest == slot {
                of[slot] = starts.len() as u32 - 1;
                starts.push(0);
            } else {
                of[slot] = of[lowest];
            }
            starts[of[slot] as usize + 1] += 1;
        }
        for component in 1..starts.len() {
            starts[component] += starts[component - 1];
        }
        let mut slots = vec![0; n];
        let mut ends = starts.clone();
        for slot in 0..n {
            let end = &mut ends[of[slot] as usize];
            slots[*end as usize] = slot as u32;
            *end += 1;
        }
        drop(ends);
        let mut rows: Vec<&mut [u32]> = Vec::new();
        let mut rest = &mut slots[..];
        for range in starts.array_windows() {
            let [start, end] = *range;
            let (row, later) = rest.split_at_mut((end - start) as usize);
            rest = later;
            if row.len() > 1 {
                rows.push(row);
            }
        }
        rows.into_par_iter().for_each(|row| row.sort_unstable_by_key(|&slot| numbers[slot as usize]));
        let mut places = vec![0; n];
        for row in starts.array_windows() {
            let [start, end] = *row;
            for (place, &slot) in (0..).zip(&slots[start as usize..end as usize]) {
                places[slot as usize] = place;
            }
        }
        Components { of, places, starts, slots }
    }

    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn of(&self, slot: u32) -> u32 {
        self.of[slot as usize]
    }

    /// The place of a slot among those of its component.
    pub(super) fn place(&self, slot: u32) -> u32 {
        self.places[slot as usize]
    }

    /// The slots of a component, by the number of their item.
    pub(super) fn slots(&self, component: u32) -> &[u32] {
        let component = component as usize;
        &self.slots[self.starts[component] as usize..self.starts[component + 1] as usize]
    }
}
