//! Nearest live older item: an exact search among vectors that die and are replaced by means.
//!
//! The tree is laid out once over the live items: leaves of 32 slots, over them boxes in the sixteen
//! directions of the [`SearchBasis`]. A merge then needs no insertion elsewhere. The mean lies between its
//! parents, so it takes the slot of the heavier one, whose boxes grow a little, and the other slot falls
//! empty. When half of the slots are empty the tree is laid out anew: the live items halve between two
//! layouts, so all layouts together cost about two. (A logarithmic forest, FEASIBILITY 9a, does the same
//! with a walk through up to log n trees a query.)
//!
//! Boxes and projections are f32 and only tell what *can't* be near; a margin covers their rounding. What
//! they let through is decided by [`error_m2`].

use super::metric::{Vector, error_m2};
use super::search_basis::{DIMENSIONS, Point, SearchBasis};
use rayon::prelude::*;

/// Slots a leaf.
const LEAF: usize = 32;

/// Directions that a leaf tests for all its slots at once; the others only for slots that pass.
const HEAD: usize = 8;

/// Item of an empty slot: older than nothing.
const NOBODY: u32 = u32::MAX;

/// The live items, arranged for searching.
pub(super) struct BoxTree {
    basis: SearchBasis,
    /// In preorder over the leaves; see [`Span`].
    nodes: Vec<Node>,
    /// First directions of the leaf's slots, `[direction][slot in leaf]`.
    heads: Vec<[[f32; LEAF]; HEAD]>,
    points: Vec<Point>,
    vectors: Vec<Vector>,
    items: Vec<u32>,
    /// Slot of each item, or [`NOBODY`] once it is dead.
    slots: Vec<u32>,
    n_live: usize,
}

/// What lies below a node.
#[derive(Clone)]
struct Node {
    low: Point,
    high: Point,
    /// No item below is older than this.
    oldest: u32,
}

/// A node and the leaves below it: the left child follows its parent, the right one the left subtree.
#[derive(Clone, Copy)]
struct Span {
    node: usize,
    first: usize,
    end: usize,
}

/// A live item and its squared distance: the candidate for nearest so far. Less = nearer, ties by age.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct Nearest {
    pub(super) e: f64,
    pub(super) item: u32,
}

impl BoxTree {
    /// Arranges these live items; items below `n_items` can be put in later.
    pub(super) fn new<'a>(live: &[u32], vector: impl Fn(u32) -> &'a Vector + Sync, n_items: usize) -> BoxTree {
        let basis = SearchBasis::of(live.len(), |i| vector(live[i]));
        let points = live.par_iter().map(|&item| basis.project(vector(item))).collect();
        let mut tree = BoxTree {
            basis,
            nodes: Vec::new(),
            heads: Vec::new(),
            points,
            vectors: Vec::new(),
            items: Vec::new(),
            slots: vec![NOBODY; n_items],
            n_live: live.len(),
        };
        tree.arrange(live, |i| *vector(live[i]));
        tree
    }

    pub(super) fn is_live(&self, item: u32) -> bool {
        self.slots[item as usize] != NOBODY
    }

    /// Vector of a live item.
    pub(super) fn vector(&self, item: u32) -> &Vector {
        &self.vectors[self.slots[item as usize] as usize]
    }

    /// Live items in the order of their slots: neighbors in space are neighbors here.
    pub(super) fn live(&self) -> impl Iterator<Item = u32> {
        self.items.iter().copied().filter(|&item| item != NOBODY)
    }

    /// Puts a mean in the place of its heavier parent and takes the other one out.
    pub(super) fn replace(&mut self, heavier: u32, lighter: u32, made: u32, mean: Vector) {
        let slot = self.slots[heavier as usize];
        self.slots[heavier as usize] = NOBODY;
        self.slots[made as usize] = slot;
        let point = self.basis.project(&mean);
        self.put(slot as usize, made, mean, point);
        self.widen(slot as usize / LEAF, &point);
        let empty = std::mem::replace(&mut self.slots[lighter as usize], NOBODY) as usize;
        self.items[empty] = NOBODY;
        self.heads[empty / LEAF][0][empty % LEAF] = f32::INFINITY;
        self.n_live -= 1;
        if self.n_live * 2 < self.items.len() && self.items.len() > LEAF {
            self.compact();
        }
    }

    /// The live item older than `item` that is nearest to it, ties by age; `bound` if none is nearer than that.
    pub(super) fn nearest_older(&self, item: u32, bound: Nearest) -> Nearest {
        let slot = self.slots[item as usize] as usize;
        let (vector, point) = (&self.vectors[slot], &self.points[slot]);
        let mut search = Search { tree: self, item, vector, point, best: bound, reach: 0.0, largest: 0.0 };
        search.largest = point.iter().fold(0.0, |largest, &x| f64::from(x).abs().max(largest));
        search.narrow(bound);
        search.run(slot / LEAF);
        search.best
    }

    /// Lays the tree out anew over the live items.
    fn compact(&mut self) {
        let old: Vec<usize> = (0..self.items.len()).filter(|&slot| self.items[slot] != NOBODY).collect();
        let live: Vec<u32> = old.iter().map(|&slot| self.items[slot]).collect();
        self.points = old.iter().map(|&slot| self.points[slot]).collect();
        let vectors = std::mem::take(&mut self.vectors);
        self.arrange(&live, |i| vectors[old[i]]);
    }

    /// Lays out live items, whose points are in `self.points` in the same order.
    fn arrange(&mut self, live: &[u32], vector: impl Fn(usize) -> Vector) {
        let n_leaves = live.len().div_ceil(LEAF).max(1);
        let points = std::mem::take(&mut self.points);
        let mut order: Vec<u32> = (0..live.len() as u32).collect();
        split(&mut order, &points, n_leaves);
        self.items = vec![NOBODY; n_leaves * LEAF];
        self.points = vec![[0.0; DIMENSIONS]; n_leaves * LEAF];
        self.vectors = vec![Vector::default(); n_leaves * LEAF];
        self.heads = vec![[[f32::INFINITY; LEAF]; HEAD]; n_leaves];
        self.nodes = vec![Node::empty(); 2 * n_leaves - 1];
        for (slot, &i) in order.iter().enumerate() {
            let i = i as usize;
            self.slots[live[i] as usize] = slot as u32;
            self.put(slot, live[i], vector(i), points[i]);
        }
        self.fill(Span { node: 0, first: 0, end: n_leaves });
    }

    fn put(&mut self, slot: usize, item: u32, vector: Vector, point: Point) {
        self.items[slot] = item;
        self.vectors[slot] = vector;
        self.points[slot] = point;
        for (head, &x) in self.heads[slot / LEAF].iter_mut().zip(&point) {
            head[slot % LEAF] = x;
        }
    }

    /// Computes the boxes of a span from the leaves up.
    fn fill(&mut self, span: Span) {
        let mut node = Node::empty();
        if let Some((left, right)) = span.children() {
            self.fill(left);
            self.fill(right);
            node.widen(&self.nodes[left.node].low, self.nodes[left.node].oldest);
            node.widen(&self.nodes[left.node].high, self.nodes[left.node].oldest);
            node.widen(&self.nodes[right.node].low, self.nodes[right.node].oldest);
            node.widen(&self.nodes[right.node].high, self.nodes[right.node].oldest);
        } else {
            for slot in span.first * LEAF..span.end * LEAF {
                if self.items[slot] != NOBODY {
                    node.widen(&self.points[slot], self.items[slot]);
                }
            }
        }
        self.nodes[span.node] = node;
    }

    /// Makes room for a point in a leaf and in all above it.
    fn widen(&mut self, leaf: usize, point: &Point) {
        let mut span = Span { node: 0, first: 0, end: self.heads.len() };
        loop {
            // A mean is younger than all that is there: `oldest` stays.
            self.nodes[span.node].widen(point, NOBODY);
            let Some((left, right)) = span.children() else { return };
            span = if leaf < left.end { left } else { right };
        }
    }
}

impl Node {
    fn empty() -> Node {
        Node { low: [f32::INFINITY; DIMENSIONS], high: [f32::NEG_INFINITY; DIMENSIONS], oldest: NOBODY }
    }

    fn widen(&mut self, point: &Point, item: u32) {
        for (low, &x) in self.low.iter_mut().zip(point) {
            *low = if x < *low { x } else { *low };
        }
        for (high, &x) in self.high.iter_mut().zip(point) {
            *high = if x > *high { x } else { *high };
        }
        self.oldest = self.oldest.min(item);
    }

    /// Squared distance from a point to the box.
    fn distance2(&self, point: &Point) -> f32 {
        let mut sums = [0.0_f32; 4];
        for ((low, high), x) in
            self.low.as_chunks::<4>().0.iter().zip(self.high.as_chunks::<4>().0).zip(point.as_chunks::<4>().0)
        {
            for lane in 0..4 {
                let (below, above) = (low[lane] - x[lane], x[lane] - high[lane]);
                let outside = if below > above { below } else { above };
                let outside = if outside > 0.0 { outside } else { 0.0 };
                sums[lane] += outside * outside;
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
}

impl Span {
    fn children(self) -> Option<(Span, Span)> {
        let n_left = (self.end - self.first) / 2;
        (n_left > 0).then(|| {
            let middle = self.first + n_left;
            let left = Span { node: self.node + 1, first: self.first, end: middle };
            (left, Span { node: self.node + 2 * n_left, first: middle, end: self.end })
        })
    }
}

/// Spans waiting to be visited. A tree over 2^32 items is 28 deep, and a visit adds one span net.
const WAITING: usize = 40;

/// One search under way.
struct Search<'a> {
    tree: &'a BoxTree,
    item: u32,
    vector: &'a Vector,
    point: &'a Point,
    best: Nearest,
    /// Squared distance between projections beyond which nothing better can lie.
    reach: f32,
    /// Largest coordinate of the point.
    largest: f64,
}

impl Search<'_> {
    fn run(&mut self, own_leaf: usize) {
        self.scan(own_leaf);
        let nodes = &self.tree.nodes;
        let root = Span { node: 0, first: 0, end: self.tree.heads.len() };
        let mut waiting = [(0.0_f32, root); WAITING];
        let mut n_waiting = 1;
        while n_waiting > 0 {
            n_waiting -= 1;
            let (distance2, span) = waiting[n_waiting];
            if distance2 > self.reach || nodes[span.node].oldest >= self.item {
                continue;
            }
            let Some((left, right)) = span.children() else {
                if span.first != own_leaf {
                    self.scan(span.first);
                }
                continue;
            };
            let left = (nodes[left.node].distance2(self.point), left);
            let right = (nodes[right.node].distance2(self.point), right);
            let (near, far) = if right.0 < left.0 { (right, left) } else { (left, right) };
            for next in [far, near] {
                if next.0 <= self.reach {
                    waiting[n_waiting] = next;
                    n_waiting += 1;
                }
            }
        }
    }

    /// Compares with all slots of a leaf.
    fn scan(&mut self, leaf: usize) {
        let mut distances2 = [0.0_f32; LEAF];
        for (head, &x) in self.tree.heads[leaf].iter().zip(self.point) {
            for (sum, &y) in distances2.iter_mut().zip(head) {
                *sum += (x - y) * (x - y);
            }
        }
        for (slot, &head2) in (leaf * LEAF..).zip(&distances2) {
            if head2 <= self.reach && self.tree.items[slot] < self.item {
                self.compare(slot, head2);
            }
        }
    }

    /// Compares with a slot whose first directions are near enough.
    fn compare(&mut self, slot: usize, head2: f32) {
        let tail = self.point[HEAD..].iter().zip(&self.tree.points[slot][HEAD..]);
        if head2 + tail.map(|(x, y)| (x - y) * (x - y)).sum::<f32>() > self.reach {
            return;
        }
        let found = Nearest { e: error_m2(self.vector, &self.tree.vectors[slot]), item: self.tree.items[slot] };
        if found < self.best {
            self.narrow(found);
        }
    }

    /// Takes a better candidate.
    ///
    /// For a y with E <= e, the true distance of the projections is at most sqrt(e). Rounding to f32 moves each
    /// of the 16 coordinates of either by at most 2^-24 of its size, which is at most `largest` + sqrt(e): together
    /// at most 4 x 2^-24 x (2 largest + sqrt(e)). The sum of squares in f32 is good to 20 x 2^-24. Both margins
    /// are taken eight times as wide.
    fn narrow(&mut self, best: Nearest) {
        self.best = best;
        let distance = best.e.sqrt();
        let rounding = 2e-6 * (2.0 * self.largest + distance);
        self.reach = ((distance + rounding) * (distance + rounding) * (1.0 + 1e-5)) as f32;
    }
}

/// Orders points so that each run of [`LEAF`] is a leaf: halves of the leaves, split where they spread most.
fn split(order: &mut [u32], points: &[Point], n_leaves: usize) {
    if n_leaves < 2 {
        return;
    }
    let n_left = n_leaves / 2;
    let direction = widest(order, points);
    let mut keys: Vec<(f32, u32)> = order.iter().map(|&i| (points[i as usize][direction], i)).collect();
    keys.select_nth_unstable_by(n_left * LEAF, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (slot, key) in order.iter_mut().zip(&keys) {
        *slot = key.1;
    }
    drop(keys);
    let (left, right) = order.split_at_mut(n_left * LEAF);
    rayon::join(|| split(left, points, n_left), || split(right, points, n_leaves - n_left));
}

/// The direction in which an even selection of the points varies most.
fn widest(order: &[u32], points: &[Point]) -> usize {
    let mut sums = [[0.0_f64; 2]; DIMENSIONS];
    let selected = || order.iter().step_by(order.len().div_ceil(256).max(1));
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
