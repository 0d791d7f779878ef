//! The merges of all components of a band in one order: of their next ones the least goes first.

use super::super::log::Log;
use super::items::Items;
use super::merge_loop::Outcome;
use std::cmp::Reverse;
use std::collections::binary_heap::{BinaryHeap, PeekMut};

/// Logs the merges in order. Returns of each component the numbers of its items in the tree.
pub(super) fn put_in_order(items: &Items, merged: &[Outcome], log: &mut Log) -> Vec<Vec<u32>> {
    let of_slot = |slot: Option<u32>| slot.map_or(u32::MAX, |slot| items.numbers[slot as usize]);
    let mut numbers: Vec<Vec<u32>> =
        merged.iter().map(|of| of.slots.iter().map(|&slot| of_slot(slot)).collect()).collect();
    let mut next = vec![0; merged.len()];
    let head = |numbers: &[Vec<u32>], next: &[usize], component: usize| {
        let merge = merged[component].merges.get(next[component])?;
        let [a, b] = [merge.a, merge.b].map(|item| numbers[component][item as usize]);
        Some(Reverse((merge.e.to_bits(), a.min(b), a.max(b), component)))
    };
    let mut heads: BinaryHeap<_> =
        (0..merged.len()).filter_map(|component| head(&numbers, &next, component)).collect::<Vec<_>>().into();
    while let Some(mut least) = heads.peek_mut() {
        let Reverse((e_bits, a, b, component)) = *least;
        let made = merged[component].merges[next[component]].made;
        numbers[component][made as usize] = log.merge(f64::from_bits(e_bits), a, b);
        next[component] += 1;
        match head(&numbers, &next, component) {
            Some(after) => *least = after,
            None => drop(PeekMut::pop(least)),
        }
    }
    numbers
}
