//! The cluster tree by the nearest-older-neighbor queue: exact centroid linkage without all pairs (T 4.2.3).
//!
//! Every live item offers the pair with its nearest *older* live item, so the least offer is the closest pair
//! of all. Offers stand in a priority queue by (E, lower item, higher item). When the first one's older partner
//! is gone, the item asks again; nothing else has to be kept up, since a new mean is younger than all others
//! and makes its own offer (FEASIBILITY 9a). The outcome does not depend on how the nearest are found.

use super::box_tree::{BoxTree, Nearest};
use super::duplicates::merge_duplicates;
use super::error::ClusterError;
use super::log::Log;
use super::metric::{Settings, Vector, centroid, check_threshold, error_m2};
use super::tables::Merge;
use rayon::prelude::*;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Samples of one plant state at most: item numbers are u32, and there is a merge for nearly every sample.
pub const MAX_SAMPLES: usize = 1 << 31;

/// Coordinates larger than this are no motion, and their squares would leave f32.
const MAX_COORDINATE: f32 = 1e9;

/// The cluster tree, as [`tree()`](super::tree()) makes it: another way to the same merges, to compare it with.
///
/// Needs about 2.5 copies of the vectors. The first searches run on rayon's pool, the rest on one thread; neither shows.
///
/// # Errors
/// As [`tree()`](super::tree()).
pub fn tree_by_queue(vectors: &[Vector], settings: &Settings) -> Result<Vec<Merge>, ClusterError> {
    check(vectors, settings)?;
    let mut log = Log::new(vectors.len());
    // The sample that an item equals, while duplicates are merged.
    let mut sample: Vec<u32> = (0..vectors.len() as u32).collect();
    let mut consumed = vec![false; vectors.len()];
    for [a, b] in merge_duplicates(vectors) {
        log.merge(0.0, a, b);
        sample.push(sample[a as usize]);
        consumed.push(false);
        consumed[a as usize] = true;
        consumed[b as usize] = true;
    }
    let live: Vec<u32> = (0..sample.len() as u32).filter(|&item| !consumed[item as usize]).collect();
    let n_items = sample.len() + live.len();
    let arranged = BoxTree::new(&live, |item| &vectors[sample[item as usize] as usize], n_items);
    drop((sample, consumed, live));
    merge_distinct(arranged, settings.t_max_m2, &mut log);
    Ok(log.merges)
}

/// The pair of an item with its nearest older one. Less = merges first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Offer {
    e: f64,
    older: u32,
    younger: u32,
}

/// Merges distinct live items until the closest pair is at T_max.
fn merge_distinct(mut live: BoxTree, t_max_m2: f64, log: &mut Log) {
    let nobody = Nearest { e: t_max_m2, item: 0 };
    let offer = |live: &BoxTree, younger: u32, bound: Nearest| {
        let nearest = live.nearest_older(younger, bound);
        (nearest.e < t_max_m2).then_some(Reverse(Offer { e: nearest.e, older: nearest.item, younger }))
    };
    // In the order of the tree's leaves, so that a search finds in the cache what the one before has read.
    let items: Vec<u32> = live.live().collect();
    let first: Vec<_> = items
        .par_iter()
        .filter_map(|&item| {
            // The sample before is mostly the frame before, and near.
            let before = item.checked_sub(1).filter(|&before| live.is_live(before));
            let bound = before.map_or(nobody, |before| {
                let e = error_m2(live.vector(item), live.vector(before));
                if e < t_max_m2 { Nearest { e, item: before } } else { nobody }
            });
            offer(&live, item, bound)
        })
        .collect();
    drop(items);
    let mut offers = BinaryHeap::from(first);
    while let Some(Reverse(least)) = offers.pop() {
        if !live.is_live(least.younger) {
            continue;
        }
        if !live.is_live(least.older) {
            offers.extend(offer(&live, least.younger, nobody));
            continue;
        }
        let (a, b) = (least.older, least.younger);
        let [of_a, of_b] = [a, b].map(|item| log.members[item as usize]);
        let mean = centroid(live.vector(a), of_a, live.vector(b), of_b);
        let made = log.merge(least.e, a, b);
        let (heavier, lighter) = if of_b > of_a { (b, a) } else { (a, b) };
        live.replace(heavier, lighter, made, mean);
        offers.extend(offer(&live, made, nobody));
    }
}

impl Eq for Offer {}

impl PartialOrd for Offer {
    fn partial_cmp(&self, other: &Offer) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Offer {
    fn cmp(&self, other: &Offer) -> Ordering {
        self.e.total_cmp(&other.e).then(self.older.cmp(&other.older)).then(self.younger.cmp(&other.younger))
    }
}

/// Refuses what can't be clustered.
pub(super) fn check(vectors: &[Vector], settings: &Settings) -> Result<(), ClusterError> {
    check_threshold(settings.t_max_m2)?;
    if vectors.len() > MAX_SAMPLES {
        return Err(ClusterError::TooMany { found: vectors.len(), limit: MAX_SAMPLES });
    }
    check_coordinates(vectors)
}

fn check_coordinates(vectors: &[Vector]) -> Result<(), ClusterError> {
    for (item, vector) in vectors.iter().enumerate() {
        if let Some(lane) = vector.0.iter().position(|x| x.is_nan() || x.abs() > MAX_COORDINATE) {
            return Err(ClusterError::Coordinate { item, lane, value: vector.0[lane] });
        }
    }
    Ok(())
}
