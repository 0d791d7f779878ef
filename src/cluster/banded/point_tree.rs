//! The live items of a band as points in sixteen directions, in blocks of sixteen that lie close together.
//!
//! Directions are those of a [`SearchBasis`]: distances in it never exceed true ones, so whatever two boxes or points
//! are too far apart here need not be looked at. What is not is decided by E.

use super::super::metric::Vector;
use super::super::search_basis::{DIMENSIONS, Point};
use super::kernels::{Floats, Level, Registers, WIDTH};
use rayon::prelude::*;

/// A box around points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) low: Floats,
    pub(super) high: Floats,
}

/// Sixteen points, `[direction][slot]`. Slots beyond the last item lie at infinity.
pub(super) type Block = [Floats; DIMENSIONS];

/// Points in blocks, and a binary tree of boxes over the blocks.
///
/// *Slot* s is place s % 16 of block s / 16.
pub(super) struct PointTree {
    pub(super) level: Level,
    pub(super) n_points: usize,
    pub(super) blocks: Vec<Block>,
    /// In preorder; see [`Span`].
    bounds: Vec<Bounds>,
}

/// A node and the blocks below it: the left child follows its parent, the right one the left subtree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    node: usize,
    pub(super) first: usize,
    pub(super) end: usize,
}

/// What is searched for: a vector and its point.
pub(super) struct Query<'a> {
    pub(super) vector: &'a Vector,
    pub(super) point: &'a Point,
}

/// Vectors with their points in blocks, in the order they came.
#[derive(Default)]
pub(super) struct Pile {
    pub(super) blocks: Vec<Block>,
    pub(super) vectors: Vec<Vector>,
}

impl Pile {
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.vectors.clear();
    }

    pub(super) fn push(&mut self, point: &Point, vector: Vector) {
        let lane = self.vectors.len() % WIDTH;
        if lane == 0 {
            self.blocks.push([Floats([f32::INFINITY; WIDTH]); DIMENSIONS]);
        }
        if let Some(block) = self.blocks.last_mut() {
            for (direction, &x) in block.iter_mut().zip(point) {
                direction.0[lane] = x;
            }
        }
        self.vectors.push(vector);
    }
}

/// Blocks that are searched for together.
pub(super) const GROUP: usize = 4;

/// Below this many points the two halves of a split are not worth two threads.
const POINTS_A_THREAD: usize = 1 << 14;

impl Bounds {
    fn empty() -> Bounds {
        Bounds { low: Floats([f32::INFINITY; WIDTH]), high: Floats([f32::NEG_INFINITY; WIDTH]) }
    }

    /// The box around both.
    pub(super) fn with(&self, other: &Bounds) -> Bounds {
        let less = |a: f32, b: f32| if a < b { a } else { b };
        let more = |a: f32, b: f32| if a > b { a } else { b };
        Bounds {
            low: Floats(std::array::from_fn(|d| less(self.low.0[d], other.low.0[d]))),
            high: Floats(std::array::from_fn(|d| more(self.high.0[d], other.high.0[d]))),
        }
    }

    pub(super) fn of_point(point: &Point) -> Bounds {
        Bounds { low: Floats(*point), high: Floats(*point) }
    }

    /// Squared distance between two boxes.
    #[inline(always)]
    pub(super) fn distance2<R: Registers>(&self, other: &Bounds) -> f32 {
        let mut sums = [0.0_f32; WIDTH];
        for (d, sum) in sums.iter_mut().enumerate() {
            let (below, above) = (self.low.0[d] - other.high.0[d], other.low.0[d] - self.high.0[d]);
            let apart = if below > above { below } else { above };
            let apart = if apart > 0.0 { apart } else { 0.0 };
            *sum = apart * apart;
        }
        add_up(&sums)
    }

    /// The largest coordinate of any point inside.
    pub(super) fn largest(&self) -> f32 {
        self.low.0.iter().chain(&self.high.0).fold(0.0, |largest: f32, x| largest.max(x.abs()))
    }
}

/// In halves, as registers add up.
#[inline(always)]
fn add_up(values: &[f32; WIDTH]) -> f32 {
    let eight: [f32; 8] = std::array::from_fn(|l| values[l] + values[l + 8]);
    let four: [f32; 4] = std::array::from_fn(|l| eight[l] + eight[l + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}

impl Span {
    pub(super) fn children(self) -> Option<(Span, Span)> {
        let n = self.end - self.first;
        (n > 1).then(|| {
            let n_left = n_left(n);
            let middle = self.first + n_left;
            let left = Span { node: self.node + 1, first: self.first, end: middle };
            (left, Span { node: self.node + 2 * n_left, first: middle, end: self.end })
        })
    }
}

/// Blocks in the left half of n; whole groups where there are several.
fn n_left(n: usize) -> usize {
    if n > GROUP { (n / 2).next_multiple_of(GROUP).min((n - 1) / GROUP * GROUP) } else { n / 2 }
}

impl PointTree {
    /// Arranges points. Also returns which point is in each slot.
    pub(super) fn arrange(points: &[Point], level: Level) -> (PointTree, Vec<u32>) {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let n_blocks = points.len().div_ceil(WIDTH).max(1);
        split(&mut order, points, n_blocks);
        let blocks: Vec<Block> = (0..n_blocks)
            .into_par_iter()
            .map(|block| {
                let mut filled = [Floats([f32::INFINITY; WIDTH]); DIMENSIONS];
                for (lane, &at) in order[block * WIDTH..].iter().take(WIDTH).enumerate() {
                    for (direction, &x) in filled.iter_mut().zip(&points[at as usize]) {
                        direction.0[lane] = x;
                    }
                }
                filled
            })
            .collect();
        let mut tree = PointTree { level, n_points: points.len(), blocks, bounds: Vec::new() };
        let mut bounds = vec![Bounds::empty(); 2 * n_blocks - 1];
        tree.fill(tree.root(), &mut bounds);
        tree.bounds = bounds;
        (tree, order)
    }

    pub(super) fn root(&self) -> Span {
        Span { node: 0, first: 0, end: self.blocks.len() }
    }

    #[inline(always)]
    pub(super) fn bounds(&self, span: Span) -> &Bounds {
        &self.bounds[span.node]
    }

    /// The point in a slot.
    pub(super) fn point(&self, slot: usize) -> Point {
        std::array::from_fn(|d| self.blocks[slot / WIDTH][d].0[slot % WIDTH])
    }

    /// The box around the points of one block.
    pub(super) fn bounds_of_block(&self, block: usize) -> Bounds {
        let mut bounds = Bounds::empty();
        for slot in block * WIDTH..((block + 1) * WIDTH).min(self.n_points) {
            bounds = bounds.with(&Bounds::of_point(&self.point(slot)));
        }
        bounds
    }

    /// Computes the boxes of a span; `bounds` are those of the span's nodes.
    fn fill(&self, span: Span, bounds: &mut [Bounds]) -> Bounds {
        let own = match span.children() {
            None => self.bounds_of_block(span.first),
            Some((left, right)) => {
                let (of_left, of_right) = bounds[1..].split_at_mut(right.node - left.node);
                let both = (span.end - span.first) * WIDTH > POINTS_A_THREAD;
                let mut fill_left = || self.fill(left, of_left);
                let mut fill_right = || self.fill(right, of_right);
                let (left, right) =
                    if both { rayon::join(&mut fill_left, &mut fill_right) } else { (fill_left(), fill_right()) };
                left.with(&right)
            }
        };
        bounds[0] = own;
        own
    }
}

/// Orders points so that each run of sixteen is a block: halves of the blocks, split where they spread most.
fn split(order: &mut [u32], points: &[Point], n_blocks: usize) {
    if n_blocks < 2 {
        return;
    }
    let n_left = n_left(n_blocks);
    let direction = widest(order, points);
    let mut keys: Vec<(f32, u32)> = order.iter().map(|&i| (points[i as usize][direction], i)).collect();
    keys.select_nth_unstable_by(n_left * WIDTH, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (slot, key) in order.iter_mut().zip(&keys) {
        *slot = key.1;
    }
    drop(keys);
    let both = order.len() > POINTS_A_THREAD;
    let (left, right) = order.split_at_mut(n_left * WIDTH);
    let mut split_left = || split(left, points, n_left);
    let mut split_right = || split(right, points, n_blocks - n_left);
    if both {
        rayon::join(&mut split_left, &mut split_right);
    } else {
        split_left();
        split_right();
    }
}

/// The direction in which an even selection of the points varies most.
fn widest(order: &[u32], points: &[Point]) -> usize {
    let mut sums = [[0.0_f64; 2]; DIMENSIONS];
    let selected = || order.iter().step_by(order.len().div_ceil(128).max(1));
    for &i in selected() {
        for (sum, &x) in sums.iter_mut().zip(&points[i as usize]) {
            sum[0] += f64::from(x);
            sum[1] += f64::from(x) * f64::from(x);
        }
    }
    let n = selected().count() as f64;
    let spread = |d: &usize| sums[*d][1] - sums[*d][0] * sums[*d][0] / n;
    (0..DIMENSIONS).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0)
}
