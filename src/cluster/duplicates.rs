//! Exact duplicates are merged first.
//!
//! k equal frames (a frozen take, a clip that lies in the corpus twice) make k^2/2 pairs at distance zero, and
//! the queue would ask each of them again after every merge. But those merges need no search: E = 0 comes
//! before everything else, a mean of equals equals them, and the tie rule alone (least lower item, then least
//! higher) says who goes first.

use super::Vector;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Merges equal vectors until all are distinct: pairs in merge order. The m-th pair makes item n + m.
///
/// `vectors` must be finite, with 0 for -0.
pub(super) fn merge_duplicates(vectors: &[Vector]) -> Vec<[u32; 2]> {
    let mut groups = groups(vectors);
    let mut next: BinaryHeap<_> =
        groups.iter().enumerate().map(|(group, items)| Reverse((items[0], items[1], group))).collect();
    let mut pairs = Vec::new();
    while let Some(Reverse((a, b, group))) = next.pop() {
        // Item numbers fit u32: the caller has checked the count.
        let made = (vectors.len() + pairs.len()) as u32;
        pairs.push([a, b]);
        let items = &mut groups[group];
        items.drain(..2);
        items.push_back(made);
        if items.len() > 1 {
            next.push(Reverse((items[0], items[1], group)));
        }
    }
    pairs
}

/// Items with equal vectors, ascending, wherever there are at least two.
fn groups(vectors: &[Vector]) -> Vec<VecDeque<u32>> {
    let mut order: Vec<(u64, u32)> = vectors.iter().zip(0..).map(|(vector, item)| (hash(vector), item)).collect();
    let bits = |item: u32| vectors[item as usize].0.iter().map(|x| x.to_bits());
    order.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| bits(a.1).cmp(bits(b.1))).then(a.1.cmp(&b.1)));
    order
        .chunk_by(|a, b| a.0 == b.0 && vectors[a.1 as usize] == vectors[b.1 as usize])
        .filter(|group| group.len() > 1)
        .map(|group| group.iter().map(|&(_, item)| item).collect())
        .collect()
}

/// Brings equals together cheaply. Nothing else depends on it: within one hash the bits decide.
fn hash(vector: &Vector) -> u64 {
    vector
        .0
        .iter()
        .fold(0, |hash, x| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_pair_goes_first_across_groups() {
        let of = |x: f32| {
            let mut vector = Vector::default();
            vector.0[47] = x;
            vector
        };
        // Items 0 2 3 6 are equal, 1 4 are equal, 5 is alone.
        let vectors = [1.0, 2.0, 1.0, 1.0, 2.0, 3.0, 1.0].map(of);
        assert_eq!(merge_duplicates(&vectors), [[0, 2], [1, 4], [3, 6], [7, 9]]);
        assert!(merge_duplicates(&[]).is_empty());
    }
}
