//! The top of the next band: as far as the graph stays thin.

use super::super::metric::Vector;
use super::super::search_basis::SearchBasis;
use super::Bands;
use super::join::Limit;
use super::kernels;
use super::point_tree::{PointTree, Query};

/// Items that are asked.
const ASKED: usize = 200;
/// Neighbors within the radius that one of them has, on average.
const NEIGHBORS: usize = 20;

pub(super) fn next_top(
    tree: &PointTree,
    vectors: &[Vector],
    basis: &SearchBasis,
    last_m2: f64,
    growth: f64,
    bands: &Bands,
    t_max_m2: f64,
) -> f64 {
    let mut top_m2 = if last_m2 > 0.0 { (last_m2 * growth).min(t_max_m2) } else { t_max_m2 };
    let floor_m2 = last_m2 * 1.05;
    let mut found = Vec::new();
    let neighbors = NEIGHBORS.max(bands.pairs / vectors.len());
    let step = vectors.len().div_ceil(ASKED).max(1);
    while top_m2 > floor_m2 && top_m2 > 1e-30 * t_max_m2 {
        let mut n = 0;
        let mut asked = 0;
        for slot in (0..vectors.len()).step_by(step) {
            let point = basis.project(&vectors[slot]);
            let query = Query { vector: &vectors[slot], point: &point };
            kernels::within(tree.level, tree, vectors, &query, Limit { e_m2: bands.skin * top_m2 }, &mut found);
            n += found.len() - 1;
            asked += 1;
            if n > neighbors * ASKED {
                break;
            }
        }
        if n <= neighbors * asked {
            return top_m2;
        }
        top_m2 /= if last_m2 > 0.0 { 1.2 } else { 1.6 };
    }
    top_m2.max(floor_m2).min(t_max_m2)
}
