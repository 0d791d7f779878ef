//! The live items between bands.

use super::super::duplicates::merge_duplicates;
use super::super::log::Log;
use super::super::metric::Vector;
use super::super::search_basis::{Point, SearchBasis};
use super::merge_loop::Outcome;
use super::point_tree::PointTree;
use rayon::prelude::*;

/// The live items, by slot.
pub(super) struct Items {
    pub(super) vectors: Vec<Vector>,
    /// Number of the item in the tree.
    pub(super) numbers: Vec<u32>,
    pub(super) members: Vec<u32>,
}

impl Items {
    /// Distinct samples: equal ones are merged.
    pub(super) fn distinct(mut vectors: Vec<Vector>, log: &mut Log) -> Items {
        let n = vectors.len();
        let mut numbers: Vec<u32> = (0..n as u32).collect();
        let pairs = merge_duplicates(&vectors);
        if !pairs.is_empty() {
            // The sample whose place each item takes.
            let mut place: Vec<u32> = (0..n as u32).collect();
            for [a, b] in pairs {
                let item = log.merge(0.0, a, b);
                let (kept, gone) = (place[a as usize], place[b as usize]);
                place.push(kept);
                numbers[kept as usize] = item;
                numbers[gone as usize] = u32::MAX;
            }
        }
        let mut kept = 0;
        for at in 0..n {
            if numbers[at] != u32::MAX {
                vectors[kept] = vectors[at];
                numbers[kept] = numbers[at];
                kept += 1;
            }
        }
        vectors.truncate(kept);
        numbers.truncate(kept);
        let members = numbers.iter().map(|&item| log.members[item as usize]).collect();
        Items { vectors, numbers, members }
    }

    pub(super) fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Puts into each slot the item that is in the slot `order` names, in place.
    pub(super) fn permute(&mut self, order: &[u32]) {
        let mut done = vec![false; order.len()];
        for start in 0..order.len() {
            if done[start] || order[start] as usize == start {
                continue;
            }
            let first = (self.vectors[start], self.numbers[start], self.members[start]);
            let mut at = start;
            loop {
                done[at] = true;
                let from = order[at] as usize;
                if from == start {
                    break;
                }
                self.vectors[at] = self.vectors[from];
                self.numbers[at] = self.numbers[from];
                self.members[at] = self.members[from];
                at = from;
            }
            (self.vectors[at], self.numbers[at], self.members[at]) = first;
        }
    }

    /// Takes out what has merged and puts in what was made. Returns the points of all, in the basis.
    pub(super) fn next(
        &mut self,
        merged: Vec<Outcome>,
        numbers: Vec<Vec<u32>>,
        tree: PointTree,
        basis: &SearchBasis,
    ) -> Vec<Point> {
        let n = self.len();
        let mut gone = vec![false; n];
        let mut made = vec![false; n];
        for (outcome, numbers) in merged.into_iter().zip(numbers) {
            for merge in &outcome.merges {
                for item in [merge.a, merge.b] {
                    if let Some(slot) = outcome.slots[item as usize] {
                        gone[slot as usize] = true;
                    }
                }
            }
            for survivor in outcome.survivors {
                let slot = survivor.slot as usize;
                gone[slot] = false;
                made[slot] = true;
                self.vectors[slot] = survivor.vector;
                self.members[slot] = survivor.members;
                self.numbers[slot] = numbers[survivor.item as usize];
            }
        }
        let mut points: Vec<Point> = (0..n)
            .into_par_iter()
            .map(|slot| if made[slot] { basis.project(&self.vectors[slot]) } else { tree.point(slot) })
            .collect();
        drop(tree);
        let mut kept = 0;
        for slot in 0..n {
            if !gone[slot] {
                self.vectors[kept] = self.vectors[slot];
                self.numbers[kept] = self.numbers[slot];
                self.members[kept] = self.members[slot];
                points[kept] = points[slot];
                kept += 1;
            }
        }
        self.vectors.truncate(kept);
        self.numbers.truncate(kept);
        self.members.truncate(kept);
        points.truncate(kept);
        points
    }
}
