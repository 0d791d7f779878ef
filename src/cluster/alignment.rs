//! Alignment frames: where in each clip-frame sequence of a node turning into its siblings is best (T 4.2.4).
//!
//! The default takes in each sequence the sample nearest to the node's medoid: linear, never without an answer, and as
//! good as the chain of Fig. 4.6 (mean cost of both 1.05 to 1.1 of the free pairwise best, GRAFTS 4).

use super::cut::Cut;
use super::medoid::Medoid;
use super::metric::{Vector, error_m2};
use super::tables::{Sample, Sequence};
use serde::{Deserialize, Serialize};

/// How alignment frames are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlignmentRule {
    /// The sample nearest to the node's medoid, the earlier one if two are as near.
    #[default]
    Medoid,
    /// T Fig. 4.6: one frame a sequence, such that those of adjacent sequences are among the 20 best pairs. Where
    /// there is no such choice, the medoid's rule.
    Chain,
}

/// Pairs of adjacent sequences that the chain looks at (k of Fig. 4.6; with fewer it often finds nothing, GRAFTS 4).
const BEST_PAIRS: usize = 20;

/// Pairs of frames beyond which two sequences are not compared: the medoid's rule is taken.
const MAX_PAIRS: usize = 1 << 22;

/// A cut of one plant state's tree, with its samples.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs, reason = "said at the types")]
pub struct StateCut<'a> {
    pub cut: &'a Cut,
    /// Number of the cut's first node in the tables.
    pub first_node: u32,
    /// In tie order, as the tree has them.
    pub samples: &'a [Sample],
    pub vectors: &'a [Vector],
    pub medoids: &'a [Medoid],
}

/// Sets the alignment frames of the sequences of one cut. `sequences` by (node, clip, first frame), of any cuts.
pub fn align(sequences: &mut [Sequence], state: StateCut<'_>, rule: AlignmentRule) {
    for node in 0..state.cut.n_nodes() {
        let members = members_by_sequence(sequences, state, node);
        let chosen = match rule {
            AlignmentRule::Medoid => None,
            AlignmentRule::Chain => chain(&members, state.vectors),
        };
        let medoid = &state.vectors[state.medoids[node].sample as usize];
        for (at, (sequence, samples)) in members.iter().enumerate() {
            let sample = match &chosen {
                Some(chosen) => chosen[at],
                None => nearest(samples, state.vectors, medoid),
            };
            sequences[*sequence].alignment_frame = Some(state.samples[sample as usize].frame);
        }
    }
}

/// The node's sequences (places in the table) with their samples, in tie order.
fn members_by_sequence(sequences: &[Sequence], state: StateCut<'_>, node: usize) -> Vec<(usize, Vec<u32>)> {
    let number = state.first_node + node as u32;
    let mut members: Vec<(usize, Vec<u32>)> = Vec::new();
    for &member in state.cut.members(node) {
        let Sample { clip_id, frame } = state.samples[member as usize];
        let after = sequences.partition_point(|s| (s.node, s.clip_id, s.first) <= (number, clip_id, frame));
        let found = after.checked_sub(1).filter(|&at| {
            let sequence = &sequences[at];
            (sequence.node, sequence.clip_id) == (number, clip_id) && frame < sequence.end
        });
        // A sample of a clip that is not in the graph has no sequence.
        let Some(at) = found else { continue };
        match members.last_mut() {
            Some((last, samples)) if *last == at => samples.push(member),
            _ => members.push((at, vec![member])),
        }
    }
    members
}

/// The sample nearest to a vector, the first of equals.
fn nearest(samples: &[u32], vectors: &[Vector], to: &Vector) -> u32 {
    let mut best = (f64::INFINITY, 0);
    for &sample in samples {
        let e = error_m2(&vectors[sample as usize], to);
        if e < best.0 {
            best = (e, sample);
        }
    }
    best.1
}

/// The chain of Fig. 4.6 with the least sum of E: a sample for each sequence. None where no chain exists.
///
/// The figure lists all chains and they can be very many; keeping the best one up to each sample finds the same least.
fn chain(members: &[(usize, Vec<u32>)], vectors: &[Vector]) -> Option<Vec<u32>> {
    // Per sequence after the first: (sample, cost so far, place of the one before in the last list).
    let mut lists: Vec<Vec<(u32, f64, usize)>> = Vec::new();
    for pair in members.windows(2) {
        let pairs = best_pairs(&pair[0].1, &pair[1].1, vectors)?;
        let mut list: Vec<(u32, f64, usize)> = Vec::new();
        if lists.is_empty() {
            lists.push(pair[0].1.iter().map(|&sample| (sample, 0.0, 0)).collect());
        }
        for (e, from, to) in pairs {
            let Some(before) = lists[lists.len() - 1].iter().position(|step| step.0 == from) else { continue };
            let step = (to, lists[lists.len() - 1][before].1 + e, before);
            match list.iter_mut().find(|other| other.0 == to) {
                Some(other) if step.1 < other.1 => *other = step,
                Some(_) => {}
                None => list.push(step),
            }
        }
        lists.push(list);
    }
    let last = lists.last()?;
    let least = last.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1).then(a.1.0.cmp(&b.1.0)))?;
    let mut at = least.0;
    let mut chosen: Vec<u32> = Vec::with_capacity(lists.len());
    for list in lists.iter().rev() {
        chosen.push(list[at].0);
        at = list[at].2;
    }
    chosen.reverse();
    Some(chosen)
}

/// The k best pairs between two sequences, by (E, samples). None where there are too many to look at.
fn best_pairs(from: &[u32], to: &[u32], vectors: &[Vector]) -> Option<Vec<(f64, u32, u32)>> {
    if from.len().saturating_mul(to.len()) > MAX_PAIRS {
        return None;
    }
    let mut best: Vec<(f64, u32, u32)> = Vec::with_capacity(BEST_PAIRS + 1);
    for &a in from {
        for &b in to {
            let pair = (error_m2(&vectors[a as usize], &vectors[b as usize]), a, b);
            if best.len() < BEST_PAIRS || pair < best[BEST_PAIRS - 1] {
                best.insert(best.partition_point(|other| *other < pair), pair);
                best.truncate(BEST_PAIRS);
            }
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::cluster::graph::{ClipRuns, PlacedSample, graph, runs};
    use crate::cluster::{Settings, cut, medoids, tree, walks};

    /// Three clips of one walk each, cut at a threshold; sequences aligned.
    fn aligned(rule: AlignmentRule, threshold_m2: f64) -> (Vec<Sequence>, Vec<Vector>, Cut, Vec<Medoid>) {
        let vectors = walks::smooth(8, 600);
        let samples: Vec<Sample> = (0..600).map(|i| Sample { clip_id: 9 - i / 200, frame: i % 200 }).collect();
        let merges = tree(vectors.clone(), &Settings::default()).unwrap();
        let at = cut(600, &merges, threshold_m2).unwrap();
        let nodes = at.nodes_of_samples();
        let clips: Vec<ClipRuns> = (0..3)
            .map(|clip| {
                let placed: Vec<PlacedSample> = (0..200)
                    .map(|f| PlacedSample { frames: f..f + 1, node: 100 + nodes[(clip * 200 + f) as usize] })
                    .collect();
                ClipRuns { clip_id: 9 - clip, runs: runs(&placed) }
            })
            .collect();
        let mut sequences = graph(&clips).sequences;
        let central = medoids(&vectors, &at);
        let state = StateCut { cut: &at, first_node: 100, samples: &samples, vectors: &vectors, medoids: &central };
        align(&mut sequences, state, rule);
        (sequences, vectors, at, central)
    }

    fn sample_of(sequence: &Sequence, frame: u32) -> usize {
        ((9 - sequence.clip_id) * 200 + frame) as usize
    }

    #[test]
    fn every_sequence_has_the_frame_nearest_to_the_medoid() {
        let (sequences, vectors, _, central) = aligned(AlignmentRule::Medoid, 0.1);
        assert!(sequences.len() > 30);
        let mut n_medoids = 0;
        for sequence in &sequences {
            let medoid = central[sequence.node as usize - 100].sample as usize;
            let frame = sequence.alignment_frame.unwrap();
            let e = |frame: u32| error_m2(&vectors[sample_of(sequence, frame)], &vectors[medoid]);
            for other in sequence.first..sequence.end {
                assert!((e(frame), frame) <= (e(other), other), "{sequence:?}: frame {other}");
            }
            n_medoids += usize::from(sample_of(sequence, frame) == medoid);
        }
        assert_eq!(n_medoids, central.len());
    }

    #[test]
    fn chains_stay_inside_and_cost_no_more_than_the_medoid_where_they_may() {
        let cost = |rule| {
            let (sequences, vectors, at, _) = aligned(rule, 0.5);
            let mut of_node = vec![Vec::new(); at.n_nodes()];
            for sequence in &sequences {
                let frame = sequence.alignment_frame.unwrap();
                assert!((sequence.first..sequence.end).contains(&frame), "{sequence:?}");
                of_node[sequence.node as usize - 100].push(sample_of(sequence, frame));
            }
            let of_node = of_node.into_iter().map(|mut samples| {
                samples.sort_unstable(); // tie order
                samples.windows(2).map(|pair| error_m2(&vectors[pair[0]], &vectors[pair[1]])).sum::<f64>()
            });
            of_node.collect::<Vec<f64>>()
        };
        let (chains, medoid) = (cost(AlignmentRule::Chain), cost(AlignmentRule::Medoid));
        assert!(chains.iter().sum::<f64>() < medoid.iter().sum::<f64>());
    }

    #[test]
    fn the_chain_equals_trying_them_all() {
        let vectors = walks::smooth(12, 400);
        let members = vec![
            (0, (0..9).collect::<Vec<u32>>()),
            (1, (3..14).collect()),
            (2, (200..206).collect()),
            (3, (203..215).collect()),
        ];
        let lists: Vec<_> =
            members.windows(2).map(|pair| best_pairs(&pair[0].1, &pair[1].1, &vectors).unwrap()).collect();
        let mut all: Vec<(f64, Vec<u32>)> = lists[0].iter().map(|&(e, a, b)| (e, vec![a, b])).collect();
        for list in &lists[1..] {
            all = all
                .iter()
                .flat_map(|(cost, chain)| {
                    let goes_on = list.iter().filter(|pair| Some(&pair.1) == chain.last());
                    goes_on.map(move |&(e, _, to)| (cost + e, [&chain[..], &[to]].concat()))
                })
                .collect();
        }
        let least = all.iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        assert_eq!(chain(&members, &vectors), Some(least.1.clone()));
        assert_eq!(chain(&members[..1], &vectors), None);
    }

    #[test]
    fn the_best_pairs_are_the_best() {
        let vectors = walks::smooth(6, 100);
        let (from, to): (Vec<u32>, Vec<u32>) = ((0..30).collect(), (40..75).collect());
        let mut all: Vec<(f64, u32, u32)> = Vec::new();
        for &a in &from {
            all.extend(to.iter().map(|&b| (error_m2(&vectors[a as usize], &vectors[b as usize]), a, b)));
        }
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(best_pairs(&from, &to, &vectors).unwrap(), all[..BEST_PAIRS]);
    }
}
