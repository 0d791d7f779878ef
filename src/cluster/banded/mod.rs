//! The cluster tree by the banded neighbor graph: exact centroid linkage of millions of samples (FEASIBILITY 2).
//!
//! E is cut into *bands*. At the beginning of a band that reaches up to its *top* t, all pairs of live items closer than a
//! *radius* R = skin x t are listed once (`join`); then items merge, closest pair first, on these lists alone
//! (`merge_loop`), until no pair closer than t is left. What is left goes into the next band.
//!
//! # Why no pair is missed
//! For a mean c of a and b with shares α + β = 1, and any x (Stewart's theorem):
//!
//! ```text
//! E(c, x) + α β E(a, b) = α E(a, x) + β E(b, x)
//! ```
//!
//! Each item has *anchors*: at the beginning of the band itself; a mean has those of both parts. Its *deficit* is
//! δ(c) = α δ(a) + β δ(b) + α β E(a, b), and 0 at the beginning. Then, by induction over the merges,
//!
//! ```text
//! the least E(p, x) over the anchors p of c  <=  α E(a, x) + α δ(a) + β E(b, x) + β δ(b)  =  E(c, x) + δ(c)
//! ```
//!
//! for any x, and so the least E(p, q) over the anchors of two items is at most E + both deficits. While no deficit is
//! over the *slack* D = (R - t) / 2, a pair with E < t has anchors with E < t + 2 D = R. Such a pair of anchors was listed, and
//! lists are handed on at each merge: an entry stands for the live item that it has become part of. An entry is
//! dropped only where E >= R, and this loses nothing: were E(x, y) < R - δ(x) - δ(y) at any later time, then by the same
//! inequality of one part of each as well, back to the first lists; there, all such pairs are in.
//!
//! (FEASIBILITY takes the larger of both deficits instead of their mean. The mean is what Stewart's theorem gives, grows
//! three times more slowly, and asks the tree a third as often.)
//!
//! A mean whose deficit would be over the slack *refreshes*: it becomes its only anchor, with deficit 0. Its list is made
//! anew, of what the anchors within R lead to: those from the beginning of the band, which the tree of boxes finds, and
//! earlier refreshed ones, from a pile of their own. It is entered in the lists of all that it finds.
//!
//! Means are rounded to f32, by which E moves by at most 2 sqrt(R) ρ + ρ² with ρ = 2^-24 sqrt(48) x the largest coordinate;
//! each merge adds as much to the deficit.
//!
//! # Why components can go by themselves
//! Pairs below t have anchors within R of each other. So two components of the band's graph have nothing to do with each
//! other until a refreshed mean of one comes within R of an anchor of the other. Where that happens, they are united
//! (`touching`). The merges of all components are then put in the one order that they have (`heads`): of their
//! next merges the least comes first.
//!
//! # What shows
//! Bands, their skin, threads and registers change what it costs, never a bit of the result.

mod band;
mod components;
mod heads;
mod items;
mod join;
mod kernels;
mod level;
mod merge_loop;
mod point_tree;
mod touching;

use super::error::ClusterError;
use super::log::Log;
use super::metric::{Settings, Vector};
use super::search_basis::SearchBasis;
use super::tables::Merge;
use band::merge_band;
use items::Items;
use join::{HalfGraph, Limit};
use kernels::Level;
use point_tree::PointTree;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// How bands are laid.
#[derive(Clone, Copy, Debug)]
pub struct Bands {
    /// Top of a band over the top of the one before, where the graph stays thin enough; above 1.
    pub growth: f64,
    /// Radius of a band's graph over its top, both in m^2; above 1.
    pub skin: f64,
    /// With no more live items than this, the rest is one band of all pairs.
    pub few: usize,
    /// Pairs of a band's graph that are no burden, however few the items.
    pub pairs: usize,
    /// Only what any processor of this kind can do.
    pub plain: bool,
}

impl Default for Bands {
    fn default() -> Bands {
        Bands { growth: 1.8, skin: 2.0, few: 300, pairs: 400_000, plain: false }
    }
}

/// What has been done of a band.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// Live items are in order, with boxes around them.
    Arranged {
        /// How many.
        items: usize,
    },
    /// The band's graph is there.
    Joined {
        /// The band's top, m^2.
        top_m2: f64,
        /// Pairs in it.
        pairs: usize,
    },
    /// All components have merged what they could.
    Merged {
        /// Means that asked the tree again.
        refreshed: usize,
        /// Items of the largest component.
        largest: usize,
        /// Components that were done again, as one with others.
        again: usize,
    },
    /// The merges are in order.
    Ordered {
        /// Merges of this band.
        merges: usize,
    },
}

/// Pairs a live item that a band's graph may have, on average.
const PAIRS_AN_ITEM: usize = 24;

/// The cluster tree of the samples of one plant state, up to the first merge at E >= T_max.
///
/// The closest live pair merges into its count-weighted mean (T 4.2.3), ties by (E, lower item, higher item). Items
/// count from 0: the samples as given, which should be by (source, name, frame), then the merges as they are made.
///
/// # Shapes and units
/// `vectors`: one canonical vector a sample. Returns the merges in order; `e`, `radius2` in m^2.
/// Needs about 450 bytes a sample at its peak, `vectors` included. Runs on rayon's pool, whose size does not show.
///
/// # Errors
/// [`ClusterError::Coordinate`] at the first NaN, infinity or value beyond 1e9; [`ClusterError::Threshold`];
/// [`ClusterError::TooMany`].
///
/// # Example
/// ```
/// use motionmill::cluster::{Settings, Vector, tree};
/// let mut vectors = vec![Vector::default(); 3];
/// vectors[1].0[0] = 0.3;
/// vectors[2].0[0] = 9.0;
/// let merges = tree(vectors, &Settings::default())?;
/// assert_eq!((merges.len(), merges[0].item, merges[0].a, merges[0].b), (1, 3, 0, 1));
/// # Ok::<(), motionmill::cluster::ClusterError>(())
/// ```
pub fn tree(vectors: Vec<Vector>, settings: &Settings) -> Result<Vec<Merge>, ClusterError> {
    tree_in_bands(vectors, settings, &Bands::default(), &mut |_| ControlFlow::Continue(()))
}

/// The same in bands of one's own choice. Tells of each step, after which it may be stopped.
///
/// # Errors
/// As [`tree()`]; [`ClusterError::Bands`]; [`ClusterError::Stopped`].
pub fn tree_in_bands(
    vectors: Vec<Vector>,
    settings: &Settings,
    bands: &Bands,
    tell: &mut dyn FnMut(Step) -> ControlFlow<()>,
) -> Result<Vec<Merge>, ClusterError> {
    super::queue::check(&vectors, settings)?;
    for (name, found) in [("growth", bands.growth), ("skin", bands.skin)] {
        if !(found > 1.0 && found.is_finite()) {
            return Err(ClusterError::Bands { name, found });
        }
    }
    let widest = Level::all().pop().unwrap_or(Level::Plain);
    let level = if bands.plain { Level::Plain } else { widest };
    let mut log = Log::new(vectors.len());
    let mut items = Items::distinct(vectors, &mut log);
    let basis = SearchBasis::of(items.len(), |at| &items.vectors[at]);
    let mut points: Vec<_> = items.vectors.par_iter().map(|vector| basis.project(vector)).collect();
    let mut top_m2 = 0.0;
    let mut growth = bands.growth;
    while items.len() > 1 && top_m2 < settings.t_max_m2 {
        let (tree, order) = PointTree::arrange(&points, level);
        drop(points);
        items.permute(&order);
        drop(order);
        went_on(tell(Step::Arranged { items: items.len() }))?;
        let (reach, graph) = next_graph(&tree, &items, &basis, top_m2, bands, growth, settings.t_max_m2);
        top_m2 = reach.top_m2;
        went_on(tell(Step::Joined { top_m2, pairs: graph.n_pairs() }))?;
        let (merged, step) = merge_band(&basis, &tree, &items, &graph, reach);
        went_on(tell(step))?;
        drop(graph);
        let n_before = log.merges.len();
        let numbers = heads::put_in_order(&items, &merged, &mut log);
        let merges = log.merges.len() - n_before;
        // Nothing there: farther the next time, however far apart the items are.
        growth = if merges == 0 { (growth * growth).min(1e12) } else { bands.growth };
        points = items.next(merged, numbers, tree, &basis);
        went_on(tell(Step::Ordered { merges }))?;
    }
    Ok(log.merges)
}

fn went_on(flow: ControlFlow<()>) -> Result<(), ClusterError> {
    if flow.is_break() { Err(ClusterError::Stopped) } else { Ok(()) }
}

/// How far a band reaches.
#[derive(Clone, Copy, Debug)]
struct Reach {
    top_m2: f64,
    /// May be infinite.
    radius_m2: f64,
}

/// The graph of the next band, whose top is where the graph stays thin, or just above the last one.
fn next_graph(
    tree: &PointTree,
    items: &Items,
    basis: &SearchBasis,
    last_m2: f64,
    bands: &Bands,
    growth: f64,
    t_max_m2: f64,
) -> (Reach, HalfGraph) {
    if items.len() <= bands.few {
        let all = Limit { e_m2: f64::INFINITY };
        let graph = HalfGraph::join(tree, &items.vectors, all, usize::MAX).unwrap_or_default();
        return (Reach { top_m2: t_max_m2, radius_m2: f64::INFINITY }, graph);
    }
    let mut top_m2 = level::next_top(tree, &items.vectors, basis, last_m2, growth, bands, t_max_m2);
    let mut budget = PAIRS_AN_ITEM * items.len().max(bands.pairs / 10);
    loop {
        let radius_m2 = bands.skin * top_m2;
        match HalfGraph::join(tree, &items.vectors, Limit { e_m2: radius_m2 }, budget) {
            Some(graph) => return (Reach { top_m2, radius_m2 }, graph),
            None if last_m2 == 0.0 => top_m2 /= 8.0,
            None if top_m2 > last_m2 * 1.05 => top_m2 = (top_m2 * last_m2).sqrt(),
            // However many pairs there are: they have to be met.
            None => budget *= 2,
        }
    }
}
