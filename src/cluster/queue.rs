//! The cluster tree by the nearest-older-neighbor queue: exact centroid linkage without all pairs (T 4.2.3).
//!
//! Every live item offers the pair with its nearest *older* live item, so the least offer is the closest pair
//! of all. Offers stand in a priority queue by (E, lower item, higher item). When the first one's older partner
//! is gone, the item asks again; nothing else has to be kept up, since a new mean is younger than all others
//! and makes its own offer (FEASIBILITY 9a). The outcome does not depend on how the nearest are found.

use super::box_tree::{BoxTree, Nearest};
use super::duplicates::merge_duplicates;
use super::error::ClusterError;
use super::metric::{Settings, Vector, centroid, check_threshold, error_m2};
use super::tables::Merge;
use rayon::prelude::*;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Samples of one plant state at most: item numbers are u32, and there is a merge for nearly every sample.
pub const MAX_SAMPLES: usize = 1 << 31;

/// Coordinates larger than this are no motion, and their squares would leave f32.
const MAX_COORDINATE: f32 = 1e9;

/// The cluster tree of the samples of one plant state, up to the first merge at E >= T_max.
///
/// The closest live pair merges into its count-weighted mean (T 4.2.3), ties by (E, lower item, higher item). Items
/// count from 0: the samples as given, which should be by (source, name, frame), then the merges as they are made.
///
/// # Shapes and units
/// `vectors`: one canonical vector a sample. Returns the merges in order; `e`, `radius2` in m^2.
/// Needs about 2.5 copies of the vectors. Searches for all samples at once run on rayon's pool, the rest on one thread;
/// neither the pool nor its size shows in the result.
///
/// # Errors
/// [`ClusterError::Coordinate`] at the first NaN, infinity or value beyond 1e9; [`ClusterError::Threshold`];
/// [`ClusterError::TooMany`].
///
/// # Example
/// ```
/// use motionmill::cluster::{Settings, Vector, tree};
/// let mut vectors = [Vector::default(); 3];
/// vectors[1].0[0] = 0.3;
/// vectors[2].0[0] = 9.0;
/// let merges = tree(&vectors, &Settings::default())?;
/// assert_eq!((merges.len(), merges[0].item, merges[0].a, merges[0].b), (1, 3, 0, 1));
/// # Ok::<(), motionmill::cluster::ClusterError>(())
/// ```
pub fn tree(vectors: &[Vector], settings: &Settings) -> Result<Vec<Merge>, ClusterError> {
    check_threshold(settings.t_max_m2)?;
    if vectors.len() > MAX_SAMPLES {
        return Err(ClusterError::TooMany { found: vectors.len(), limit: MAX_SAMPLES });
    }
    check_coordinates(vectors)?;
    let mut log = Log::new(vectors.len());
    // The sample that an item equals, while duplicates are merged.
    let mut sample: Vec<u32> = (0..vectors.len() as u32).collect();
    let mut consumed = vec![false; vectors.len()];
    for [a, b] in merge_duplicates(vectors) {
        log.merge(Offer { e: 0.0, older: a, younger: b });
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

/// The merges so far, and what they need to know of each item.
struct Log {
    merges: Vec<Merge>,
    members: Vec<u32>,
    radius2: Vec<f64>,
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
        let made = log.merge(least);
        let (heavier, lighter) = if of_b > of_a { (b, a) } else { (a, b) };
        live.replace(heavier, lighter, made, mean);
        offers.extend(offer(&live, made, nobody));
    }
}

impl Log {
    fn new(n_samples: usize) -> Log {
        Log { merges: Vec::new(), members: vec![1; n_samples], radius2: vec![0.0; n_samples] }
    }

    /// Writes a merge down; returns the new item.
    fn merge(&mut self, pair: Offer) -> u32 {
        let Offer { e, older: a, younger: b } = pair;
        let [members_a, members_b] = [a, b].map(|item| self.members[item as usize]);
        let [radius2_a, radius2_b] = [a, b].map(|item| self.radius2[item as usize]);
        let members = members_a + members_b;
        let (share_a, share_b) = (f64::from(members_a) / f64::from(members), f64::from(members_b) / f64::from(members));
        // Mean squares add up about the common mean by its distance to either part's.
        let radius2 = share_a * radius2_a + share_b * radius2_b + share_a * share_b * e;
        let item = self.members.len() as u32;
        self.members.push(members);
        self.radius2.push(radius2);
        self.merges.push(Merge { item, a, b, e, members, radius2 });
        item
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

fn check_coordinates(vectors: &[Vector]) -> Result<(), ClusterError> {
    for (item, vector) in vectors.iter().enumerate() {
        if let Some(lane) = vector.0.iter().position(|x| x.is_nan() || x.abs() > MAX_COORDINATE) {
            return Err(ClusterError::Coordinate { item, lane, value: vector.0[lane] });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::cluster::{dense, walks};
    use proptest::prelude::*;

    fn up_to(t_max_m2: f64) -> Settings {
        Settings { t_max_m2, ..Default::default() }
    }

    /// Both logs, bit by bit.
    fn assert_equals_dense(vectors: &[Vector], t_max_m2: f64, what: &str) -> usize {
        let merges = tree(vectors, &up_to(t_max_m2)).unwrap();
        let reference = dense::merges(vectors, t_max_m2);
        // Means are rounded to f32, which is felt by as much as the coordinates are large.
        let largest =
            vectors.iter().flat_map(|vector| vector.0).fold(0.0, |largest, x| f64::from(x.abs()).max(largest));
        for (at, (ours, theirs)) in merges.iter().zip(&reference).enumerate() {
            let found = (ours.item, ours.a, ours.b, ours.e.to_bits(), ours.members);
            let expected = (theirs.item, theirs.a, theirs.b, theirs.e.to_bits(), theirs.members);
            assert_eq!(found, expected, "{what}: merge {at}, e {} and {}", ours.e, theirs.e);
            let difference = (ours.radius2 - theirs.radius2).abs();
            let (radius, rounding) = (theirs.radius2.sqrt(), 1e-6 * largest);
            let tolerance = 1e-9 * theirs.radius2 + rounding * (radius + rounding);
            assert!(difference <= tolerance, "{what}: merge {at}: {ours:?} {theirs:?}");
        }
        assert_eq!(merges.len(), reference.len(), "{what}");
        merges.len()
    }

    #[test]
    fn equals_the_dense_tree_where_ties_abound() {
        let mut n_merges = 0;
        for seed in 0..60 {
            let n = 1 + (seed as usize * 37) % 300;
            let vectors = walks::quantized(seed, n, 1 + seed as usize % 4, 2 + seed as usize % 7);
            n_merges += assert_equals_dense(&vectors, [0.5, 3.0, 1e4][seed as usize % 3], &format!("seed {seed}"));
        }
        assert!(n_merges > 3000, "{n_merges}");
    }

    #[test]
    fn equals_the_dense_tree_on_walks() {
        for seed in 0..10 {
            for t_max_m2 in [0.003, 0.5, 1e6] {
                assert_equals_dense(&walks::smooth(seed, 290), t_max_m2, &format!("seed {seed}, T {t_max_m2}"));
            }
        }
        assert!(assert_equals_dense(&walks::smooth(77, 2000), 0.5, "2,000") > 1800);
    }

    #[test]
    fn equals_the_dense_tree_with_a_tenth_duplicated_and_shuffled() {
        let mut vectors = walks::smooth(5, 1000);
        for i in 0..100 {
            vectors[(i * 7919 + 13) % 1000] = vectors[(i * 104_729 + 500) % 1000];
        }
        vectors.swap(3, 700);
        assert_equals_dense(&vectors, 0.5, "duplicates");
    }

    #[test]
    fn equals_the_dense_tree_where_means_drift() {
        for (shape, n) in [("ring", 240), ("line", 240), ("star", 181), ("grid", 256)] {
            assert_equals_dense(&walks::shape(shape, n), 1e5, shape);
        }
    }

    #[test]
    fn equals_the_dense_tree_far_from_the_origin() {
        let mut vectors = walks::smooth(9, 200);
        vectors.iter_mut().for_each(|vector| vector.0.iter_mut().for_each(|x| *x += 4000.0));
        vectors[50].0[3] = 1e9;
        vectors[51].0[3] = -1e9;
        vectors[52].0 = [1e9; 48];
        assert_equals_dense(&vectors, 0.5, "far");
        assert_equals_dense(&vectors, 1e300, "far, all");
    }

    #[test]
    fn thousands_of_frozen_frames_cost_little() {
        let mut vectors = walks::smooth(1, 2000);
        vectors.extend(vec![vectors[1000]; 5000]);
        vectors.extend(vec![vectors[1500]; 5000]);
        let merges = tree(&vectors, &up_to(0.5)).unwrap();
        // 12,000 samples, 2,000 distinct ones.
        assert_eq!(merges.iter().filter(|merge| merge.e == 0.0).count(), 10_000);
        assert_eq!((merges[0].a, merges[0].b, merges[1].a, merges[1].b), (1000, 2000, 1500, 7000));
        assert_eq!((merges[2].a, merges[2].b), (2001, 2002));
        let one = merges.iter().filter(|merge| merge.e == 0.0 && merge.members == 5001);
        assert_eq!(one.count(), 2);
    }

    #[test]
    fn the_number_of_threads_does_not_show() {
        let vectors = walks::smooth(21, 3000);
        let with = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| tree(&vectors, &up_to(0.5)).unwrap())
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn nothing_and_one_make_no_merges() {
        assert_eq!(tree(&[], &up_to(0.5)).unwrap(), []);
        assert_eq!(tree(&walks::smooth(1, 1), &up_to(0.5)).unwrap(), []);
    }

    #[test]
    fn the_threshold_itself_does_not_merge() {
        let vectors = walks::shape("line", 2); // 1 m apart
        assert_eq!(tree(&vectors, &up_to(1.0)).unwrap(), []);
        assert_eq!(tree(&vectors, &up_to(1.000001)).unwrap().len(), 1);
    }

    #[test]
    fn what_is_no_motion_is_refused() {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e9] {
            let mut vectors = walks::smooth(1, 20);
            vectors[13].0[44] = value;
            let error = tree(&vectors, &up_to(0.5)).unwrap_err();
            assert!(matches!(error, ClusterError::Coordinate { item: 13, lane: 44, .. }), "{error}");
        }
        for t_max_m2 in [0.0, -0.5, f64::NAN, f64::INFINITY] {
            assert!(matches!(tree(&[], &up_to(t_max_m2)), Err(ClusterError::Threshold { .. })));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, ..Default::default() })]

        #[test]
        fn equals_the_dense_tree_on_anything(
            rows in prop::collection::vec(prop::array::uniform3(-3_i8..4), 0..70), t_max_m2 in 0.01..40.0_f64
        ) {
            let vectors: Vec<Vector> = rows
                .iter()
                .map(|row| {
                    let mut vector = Vector::default();
                    for (axis, &x) in row.iter().enumerate() {
                        vector.0[axis * 20] = f32::from(x) * 0.7;
                    }
                    vector
                })
                .collect();
            assert_equals_dense(&vectors, t_max_m2, "random rows");
        }
    }
}
