//! All pairs of live items within a radius, and the range query: by boxes, then points, then E.

use super::super::metric::{Vector, error_m2};
use super::super::search_basis::DIMENSIONS;
use super::kernels::{self, AHEAD, Floats, Registers, WIDTH};
use super::point_tree::{Block, Bounds, GROUP, Pile, PointTree, Query, Span};
use rayon::prelude::*;

/// How far apart a pair may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit {
    /// E below this, m^2; may be infinite.
    pub(super) e_m2: f64,
}

/// Pairs within the radius: of each slot, those with a *later* one.
#[derive(Default)]
pub(super) struct HalfGraph {
    chunks: Vec<HalfRows>,
}

/// The rows of consecutive slots.
#[derive(Default)]
pub(super) struct HalfRows {
    /// Where the row of each slot begins; closed by the end of the last.
    starts: Vec<u32>,
    others: Vec<u32>,
    errors: Vec<f64>,
    scratch: Scratch,
}

/// Memory that is used again from one group to the next.
#[derive(Default)]
struct Scratch {
    candidates: Vec<Span>,
    rows: [Vec<(u32, f64)>; WIDTH],
    near: Vec<[u32; 2]>,
}

/// A tree with its vectors, to be joined with itself.
pub(super) struct Groups<'a> {
    pub(super) tree: &'a PointTree,
    /// `[slot]`
    pub(super) vectors: &'a [Vector],
}

/// Groups whose rows are kept together.
const GROUPS_A_CHUNK: usize = 64;
/// Slots whose rows are kept together.
const CHUNK: usize = GROUPS_A_CHUNK * GROUP * WIDTH;
/// Directions after which most points that are too far are known to be.
const FIRST: usize = 6;

impl Limit {
    /// Squared distance between projections beyond which no pair can be within the limit.
    ///
    /// For E <= e the true distance of the projections is at most sqrt(e). Rounding to f32 moves each of the 16
    /// coordinates of either by at most 2^-24 of its size, which is at most `largest` + sqrt(e): together at most
    /// 4 x 2^-24 x (2 largest + sqrt(e)). The sum of squares in f32 is good to 20 x 2^-24. Both margins are taken eight
    /// times as wide.
    pub(super) fn reach(self, largest: f32) -> f32 {
        let distance = self.e_m2.sqrt();
        let rounding = 2e-6 * (2.0 * f64::from(largest) + distance);
        let reach = ((distance + rounding) * (distance + rounding) * (1.0 + 1e-5)) as f32;
        // Slots without a point are infinitely far, and beyond even this.
        if reach < f32::MAX { reach } else { f32::MAX }
    }
}

impl HalfGraph {
    /// Joins a tree with itself. None: more than `max_pairs`.
    pub(super) fn join(tree: &PointTree, vectors: &[Vector], limit: Limit, max_pairs: usize) -> Option<HalfGraph> {
        let groups = Groups { tree, vectors };
        let n_groups = if tree.n_points == 0 { 0 } else { tree.blocks.len().div_ceil(GROUP) };
        let found = std::sync::atomic::AtomicUsize::new(0);
        let chunks = (0..n_groups.div_ceil(GROUPS_A_CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut rows = HalfRows { starts: vec![0], ..HalfRows::default() };
                for group in chunk * GROUPS_A_CHUNK..((chunk + 1) * GROUPS_A_CHUNK).min(n_groups) {
                    let before = rows.others.len();
                    kernels::rows_of_group(tree.level, &groups, group * GROUP, limit, &mut rows);
                    // Only whether there are too many is read from it, which does not depend on who counts first.
                    let new = rows.others.len() - before;
                    if found.fetch_add(new, std::sync::atomic::Ordering::Relaxed) + new > max_pairs {
                        return None;
                    }
                }
                rows.scratch = Scratch::default();
                rows.others.shrink_to_fit();
                rows.errors.shrink_to_fit();
                Some(rows)
            })
            .collect::<Option<Vec<_>>>()?;
        Some(HalfGraph { chunks })
    }

    /// Pairs of a slot with later ones: slot, E.
    pub(super) fn row(&self, slot: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        let rows = &self.chunks[slot as usize / CHUNK];
        let at = slot as usize % CHUNK;
        let range = rows.starts[at] as usize..rows.starts[at + 1] as usize;
        rows.others[range.clone()].iter().copied().zip(rows.errors[range].iter().copied())
    }

    pub(super) fn n_pairs(&self) -> usize {
        self.chunks.iter().map(|rows| rows.others.len()).sum()
    }
}

/// Appends the rows of the slots of one group: [`GROUP`] blocks from block `first` on.
#[inline(always)]
pub(super) fn rows_of_group<R: Registers>(groups: &Groups<'_>, first: usize, limit: Limit, rows: &mut HalfRows) {
    let Groups { tree, vectors } = groups;
    let end = (first + GROUP).min(tree.blocks.len());
    let mut around = tree.bounds_of_block(first);
    for block in first + 1..end {
        around = around.with(&tree.bounds_of_block(block));
    }
    let reach = limit.reach(around.largest());
    let mut candidates = std::mem::take(&mut rows.scratch.candidates);
    candidates.clear();
    visit::<R>(tree, &around, reach, first, |span| candidates.push(span));
    for block in first..end {
        rows.scratch.rows.iter_mut().for_each(Vec::clear);
        let mut near = std::mem::take(&mut rows.scratch.near);
        near.clear();
        // A group is within reach of itself, and nothing before it is looked at: its blocks come first.
        let (own, later) = (tree.bounds(candidates[block - first]), &candidates[block - first..]);
        for &span in later {
            let (other, theirs) = (span.first, tree.bounds(span));
            if own.distance2::<R>(theirs) > reach {
                continue;
            }
            if other == block {
                for lane in 0..WIDTH - 1 {
                    let later = u32::MAX << (lane + 1);
                    points_near::<R>(&tree.blocks[block], lane, &tree.blocks[other], reach, later, other, &mut near);
                }
            } else {
                let mut lanes = lanes_near::<R>(&tree.blocks[block], theirs, reach);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    points_near::<R>(&tree.blocks[block], lane, &tree.blocks[other], reach, u32::MAX, other, &mut near);
                }
            }
        }
        for (at, &[lane, slot]) in near.iter().enumerate() {
            if let Some(&[_, later]) = near.get(at + AHEAD) {
                R::prefetch(&vectors[later as usize]);
            }
            let e = error_m2(&vectors[block * WIDTH + lane as usize], &vectors[slot as usize]);
            if e < limit.e_m2 {
                rows.scratch.rows[lane as usize].push((slot, e));
            }
        }
        rows.scratch.near = near;
        for lane in 0..WIDTH.min(tree.n_points.saturating_sub(block * WIDTH)) {
            for &(slot, e) in &rows.scratch.rows[lane] {
                rows.others.push(slot);
                rows.errors.push(e);
            }
            rows.starts.push(rows.others.len() as u32);
        }
    }
    rows.scratch.candidates = candidates;
}

/// Calls with each block from `first` on whose box may be within reach of a box.
#[inline(always)]
fn visit<R: Registers>(tree: &PointTree, around: &Bounds, reach: f32, first: usize, mut found: impl FnMut(Span)) {
    // A tree over 2^32 points is 28 deep, and a visit adds one span net.
    let mut waiting = [tree.root(); 40];
    let mut n_waiting = 1;
    while n_waiting > 0 {
        n_waiting -= 1;
        let span = waiting[n_waiting];
        if span.end <= first || around.distance2::<R>(tree.bounds(span)) > reach {
            continue;
        }
        match span.children() {
            None => found(span),
            Some((left, right)) => {
                R::prefetch(tree.bounds(right));
                R::prefetch(tree.bounds(left));
                waiting[n_waiting] = right;
                waiting[n_waiting + 1] = left;
                n_waiting += 2;
            }
        }
    }
}

/// Which of sixteen points are within reach of a box.
#[inline(always)]
fn lanes_near<R: Registers>(block: &Block, bounds: &Bounds, reach: f32) -> u32 {
    let mut sums = Floats([0.0; WIDTH]);
    for (direction, (&low, &high)) in block.iter().zip(bounds.low.0.iter().zip(&bounds.high.0)) {
        for lane in 0..WIDTH {
            let x = direction.0[lane];
            let (below, above) = (low - x, x - high);
            let outside = if below > above { below } else { above };
            let outside = if outside > 0.0 { outside } else { 0.0 };
            sums.0[lane] = R::fused(outside, outside, sums.0[lane]);
        }
    }
    R::at_most(&sums, reach)
}

/// Which points of a block are within reach of one point: pushes (lane of the point, slot of the other).
#[inline(always)]
fn points_near<R: Registers>(
    block: &Block,
    lane: usize,
    others: &Block,
    reach: f32,
    allowed: u32,
    other: usize,
    near: &mut Vec<[u32; 2]>,
) {
    let mut sums = Floats([0.0; WIDTH]);
    let add = |sums: &mut Floats, d: usize| {
        let x = block[d].0[lane];
        for l in 0..WIDTH {
            let apart = x - others[d].0[l];
            sums.0[l] = R::fused(apart, apart, sums.0[l]);
        }
    };
    for d in 0..FIRST {
        add(&mut sums, d);
    }
    if R::at_most(&sums, reach) & allowed == 0 {
        return;
    }
    for d in FIRST..DIMENSIONS {
        add(&mut sums, d);
    }
    let mut bits = R::at_most(&sums, reach) & allowed;
    while bits != 0 {
        near.push([lane as u32, (other * WIDTH) as u32 + bits.trailing_zeros()]);
        bits &= bits - 1;
    }
}

/// Slots whose vector is within the limit of the query's, ascending.
#[inline(always)]
pub(super) fn within<R: Registers>(
    tree: &PointTree,
    vectors: &[Vector],
    query: &Query<'_>,
    limit: Limit,
    found: &mut Vec<u32>,
) {
    let around = Bounds::of_point(query.point);
    let reach = limit.reach(around.largest());
    found.clear();
    let mut spread: Block = [Floats([0.0; WIDTH]); DIMENSIONS];
    for (direction, &x) in spread.iter_mut().zip(query.point) {
        direction.0[0] = x;
    }
    let mut blocks = Vec::new();
    visit::<R>(tree, &around, reach, 0, |span| {
        R::prefetch(&tree.blocks[span.first]);
        blocks.push(span.first);
    });
    let mut near = Vec::new();
    for block in blocks {
        points_near::<R>(&spread, 0, &tree.blocks[block], reach, u32::MAX, block, &mut near);
    }
    for &[_, slot] in &near {
        R::prefetch(&vectors[slot as usize]);
    }
    found.extend(
        near.iter().map(|near| near[1]).filter(|&slot| error_m2(query.vector, &vectors[slot as usize]) < limit.e_m2),
    );
}

/// The same among vectors in the order they came, without boxes.
#[inline(always)]
pub(super) fn within_pile<R: Registers>(pile: &Pile, query: &Query<'_>, limit: Limit, found: &mut Vec<u32>) {
    let reach = limit.reach(Bounds::of_point(query.point).largest());
    found.clear();
    let mut spread: Block = [Floats([0.0; WIDTH]); DIMENSIONS];
    for (direction, &x) in spread.iter_mut().zip(query.point) {
        direction.0[0] = x;
    }
    let mut near = Vec::new();
    for (block, points) in pile.blocks.iter().enumerate() {
        near.clear();
        points_near::<R>(&spread, 0, points, reach, u32::MAX, block, &mut near);
        for &[_, at] in &near {
            if error_m2(query.vector, &pile.vectors[at as usize]) < limit.e_m2 {
                found.push(at);
            }
        }
    }
}
