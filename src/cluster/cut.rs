//! Cutting the tree at a threshold: which samples share a node of the graph (T 4.2.3).
//!
//! Centroid linkage has inversions: a merge can cost less than one below it. So a node is judged by its *level*,
//! the greatest E at or below it. The merges with level < T are exactly those before the first with E >= T, which
//! is what a tree that stops at T would have made; a cut by a node's own E is not (DESIGN 6, FEASIBILITY 10).

use super::error::ClusterError;
use super::metric::check_threshold;
use super::tables::Merge;

/// The items that are whole at a threshold, and their samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The threshold, m^2.
    pub threshold_m2: f64,
    /// Item of each node, ascending: single samples first, then merges.
    pub items: Vec<u32>,
    /// Samples of all nodes, node after node, ascending within each.
    samples: Vec<u32>,
    /// Where each node's samples begin, and where the last one's end.
    starts: Vec<usize>,
}

impl Cut {
    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.items.len()
    }

    /// Samples of a node (a place in [`items`](Cut::items)), ascending: tie order.
    pub fn members(&self, node: usize) -> &[u32] {
        &self.samples[self.starts[node]..self.starts[node + 1]]
    }

    /// Node of each sample: a place in [`items`](Cut::items).
    pub fn nodes_of_samples(&self) -> Vec<u32> {
        let mut nodes = vec![0; self.samples.len()];
        for node in 0..self.n_nodes() {
            for &sample in self.members(node) {
                nodes[sample as usize] = node as u32;
            }
        }
        nodes
    }
}

/// Level of each merge: the greatest E of it and all below it, m^2.
///
/// # Errors
/// [`ClusterError::Log`] where the merges are no tree over that many samples.
pub fn levels(n_samples: usize, merges: &[Merge]) -> Result<Vec<f64>, ClusterError> {
    let mut levels = Vec::with_capacity(merges.len());
    for (at, merge) in merges.iter().enumerate() {
        if merge.item as usize != n_samples + at || merge.a >= merge.b || merge.b >= merge.item {
            return Err(ClusterError::Log { at });
        }
        let below = |item: u32| (item as usize).checked_sub(n_samples).map_or(0.0, |at| levels[at]);
        levels.push(merge.e.max(below(merge.a)).max(below(merge.b)));
    }
    Ok(levels)
}

/// Cuts a tree over `n_samples` samples at a threshold, which may not lie above the tree's own T_max (the tree
/// doesn't hold what would merge beyond).
///
/// # Errors
/// [`ClusterError::Threshold`] unless positive and finite; [`ClusterError::Log`] where the merges are no tree.
pub fn cut(n_samples: usize, merges: &[Merge], threshold_m2: f64) -> Result<Cut, ClusterError> {
    check_threshold(threshold_m2)?;
    let levels = levels(n_samples, merges)?;
    // Top-most whole item over each item, from the top down; whoever is in nobody is its own.
    let mut top: Vec<u32> = (0..(n_samples + merges.len()) as u32).collect();
    for (merge, level) in merges.iter().zip(&levels).rev() {
        if *level < threshold_m2 {
            for part in [merge.a, merge.b] {
                top[part as usize] = top[merge.item as usize];
            }
        }
    }
    let whole = |item: usize| item < n_samples || levels[item - n_samples] < threshold_m2;
    let items: Vec<u32> =
        (0..top.len()).filter(|&item| whole(item) && top[item] == item as u32).map(|item| item as u32).collect();
    let mut samples: Vec<u32> = (0..n_samples as u32).collect();
    samples.sort_by_key(|&sample| top[sample as usize]);
    let mut starts: Vec<usize> =
        items.iter().map(|item| samples.partition_point(|&sample| top[sample as usize] < *item)).collect();
    starts.push(n_samples);
    Ok(Cut { threshold_m2, items, samples, starts })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::cluster::{Settings, Vector, tree, walks};

    fn up_to(vectors: &[Vector], t_max_m2: f64) -> Vec<Merge> {
        tree(vectors.to_vec(), &Settings { t_max_m2, ..Default::default() }).unwrap()
    }

    #[test]
    fn equals_stopping_at_the_threshold() {
        let mut n_inversions = 0;
        for seed in 0..12 {
            let vectors = if seed % 2 == 0 { walks::smooth(seed, 400) } else { walks::quantized(seed, 200, 5, 9) };
            let merges = up_to(&vectors, 1e6);
            n_inversions += merges.windows(2).filter(|pair| pair[1].e < pair[0].e).count();
            for place in [0.02, 0.2, 0.5, 0.8, 0.97] {
                // Both a merge's own E, which must stay out, and something between.
                let e = merges[(merges.len() as f64 * place) as usize].e;
                for threshold in [e, e * 1.01].into_iter().filter(|&t| t > 0.0) {
                    let stopped = up_to(&vectors, threshold);
                    assert_eq!(stopped, merges[..stopped.len()], "seed {seed}, T {threshold}");
                    let levels = levels(vectors.len(), &merges).unwrap();
                    let whole: Vec<bool> = levels.iter().map(|&level| level < threshold).collect();
                    assert!(whole[..stopped.len()].iter().all(|&whole| whole), "seed {seed}, T {threshold}");
                    assert!(!whole[stopped.len()..].iter().any(|&whole| whole), "seed {seed}, T {threshold}");
                    let at = cut(vectors.len(), &merges, threshold).unwrap();
                    assert_eq!(at, cut(vectors.len(), &stopped, threshold).unwrap());
                    assert_eq!(at.n_nodes(), vectors.len() - stopped.len());
                }
            }
        }
        assert!(n_inversions > 100, "{n_inversions}: without inversions this shows nothing");
    }

    #[test]
    fn a_node_has_the_samples_below_its_item() {
        let vectors = walks::smooth(2, 700);
        let merges = up_to(&vectors, 0.5);
        let at = cut(700, &merges, 0.05).unwrap();
        let mut below: Vec<Vec<u32>> = (0..700).map(|sample| vec![sample]).collect();
        for merge in &merges {
            let mut both = [&below[merge.a as usize][..], &below[merge.b as usize]].concat();
            both.sort_unstable();
            below.push(both);
        }
        let mut seen = 0;
        for (node, &item) in at.items.iter().enumerate() {
            assert_eq!(at.members(node), below[item as usize]);
            seen += at.members(node).len();
            for &sample in at.members(node) {
                assert_eq!(at.nodes_of_samples()[sample as usize], node as u32);
            }
        }
        assert_eq!(seen, 700);
        assert!(at.items.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn an_inversion_goes_with_what_it_stands_on() {
        let merge = |item, a, b, e| Merge { item, a, b, e, members: 2, radius2: 0.0 };
        let merges = [merge(3, 0, 1, 0.3), merge(4, 2, 3, 0.2)];
        assert_eq!(levels(3, &merges).unwrap(), [0.3, 0.3]);
        assert_eq!(cut(3, &merges, 0.25).unwrap().items, [0, 1, 2]);
        assert_eq!(cut(3, &merges, 0.31).unwrap().items, [4]);
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let merge = |item, a, b| Merge { item, a, b, e: 0.1, members: 2, radius2: 0.0 };
        for merges in [[merge(4, 0, 1)], [merge(3, 1, 0)], [merge(3, 0, 3)], [merge(3, 1, 1)]] {
            assert_eq!(cut(3, &merges, 0.5), Err(ClusterError::Log { at: 0 }));
        }
        assert!(matches!(cut(3, &[], f64::NAN), Err(ClusterError::Threshold { .. })));
        assert_eq!(cut(0, &[], 0.5).unwrap().n_nodes(), 0);
    }
}
