//! The cluster graph: clip-frame sequences, and the edges between nodes (T 4.2).
//!
//! Its record is a clip with all its runs (DATAFLOW 5). What is here is the graph of all clips at once; `flow`
//! keeps the same tables up to date as clips come and go, and is compared with this.

use super::tables::{Edge, Sequence};
use std::ops::Range;

/// A sample of a clip with the native frames that it stands for ([`frame_ranges`](super::frame_ranges())).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacedSample {
    /// Half-open.
    pub frames: Range<u32>,
    /// Node that the sample is in.
    pub node: u32,
}

/// A longest run of consecutive samples of a clip in one node: half-open range of native frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Run {
    pub first: u32,
    pub end: u32,
    pub node: u32,
    pub samples: u32,
}

/// A clip as the graph sees it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipRuns {
    /// The clip; each clip once.
    pub clip_id: u32,
    /// Its runs, in time.
    pub runs: Vec<Run>,
}

/// The graph's tables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    /// By (node, clip, first frame), without alignment frames.
    pub sequences: Vec<Sequence>,
    /// By (from, to).
    pub edges: Vec<Edge>,
    /// By node; only nodes that some clip visits.
    pub visits: Vec<Visits>,
}

/// How much of the corpus is in a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Visits {
    pub node: u32,
    pub samples: u32,
    pub clips: u32,
    /// Native frames.
    pub frames: u64,
}

/// The runs of a clip. `samples` in time; a gap between their frames ends a run.
pub fn runs(samples: &[PlacedSample]) -> Vec<Run> {
    samples
        .chunk_by(|a, b| a.node == b.node && a.frames.end == b.frames.start)
        .map(|run| Run {
            first: run[0].frames.start,
            end: run[run.len() - 1].frames.end,
            node: run[0].node,
            samples: run.len() as u32,
        })
        .collect()
}

/// The clip-frame sequences of a clip, in time, with the nodes just before and after; none across a gap.
pub fn sequences(clip: &ClipRuns) -> impl Iterator<Item = Sequence> + '_ {
    clip.runs.iter().enumerate().map(move |(at, run)| {
        let (before, after) = (at.checked_sub(1).and_then(|at| clip.runs.get(at)), clip.runs.get(at + 1));
        Sequence {
            node: run.node,
            clip_id: clip.clip_id,
            first: run.first,
            end: run.end,
            samples: run.samples,
            alignment_frame: None,
            previous_node: before.filter(|before| before.end == run.first).map(|before| before.node),
            next_node: after.filter(|after| run.end == after.first).map(|after| after.node),
        }
    })
}

/// The cluster graph of these clips, in whatever order they are given.
pub fn graph(clips: &[ClipRuns]) -> Graph {
    let mut sequences: Vec<Sequence> = clips.iter().flat_map(self::sequences).collect();
    sequences.sort_unstable();
    let mut links: Vec<(u32, u32, u32)> =
        sequences.iter().filter_map(|sequence| Some((sequence.node, sequence.next_node?, sequence.clip_id))).collect();
    links.sort_unstable();
    let edges = links
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .map(|links| Edge {
            from_node: links[0].0,
            to_node: links[0].1,
            transitions: links.len() as u32,
            clips: links.chunk_by(|a, b| a.2 == b.2).count() as u32,
        })
        .collect();
    let visits = sequences
        .chunk_by(|a, b| a.node == b.node)
        .map(|visits| Visits {
            node: visits[0].node,
            samples: visits.iter().map(|sequence| sequence.samples).sum(),
            clips: visits.chunk_by(|a, b| a.clip_id == b.clip_id).count() as u32,
            frames: visits.iter().map(|sequence| u64::from(sequence.end - sequence.first)).sum(),
        })
        .collect();
    Graph { sequences, edges, visits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::walks::Random;
    use std::collections::{BTreeMap, BTreeSet};

    fn placed(nodes: &[(u32, u32, u32)]) -> Vec<PlacedSample> {
        nodes.iter().map(|&(first, end, node)| PlacedSample { frames: first..end, node }).collect()
    }

    #[test]
    fn runs_end_where_the_node_changes_or_frames_are_missing() {
        let samples = placed(&[(0, 3, 7), (3, 6, 7), (6, 9, 8), (9, 12, 7), (13, 15, 7)]);
        let run = |first, end, node, samples| Run { first, end, node, samples };
        let found = runs(&samples);
        assert_eq!(found, [run(0, 6, 7, 2), run(6, 9, 8, 1), run(9, 12, 7, 1), run(13, 15, 7, 1)]);
        let all: Vec<Sequence> = sequences(&ClipRuns { clip_id: 4, runs: found }).collect();
        let links: Vec<_> = all.iter().map(|sequence| (sequence.previous_node, sequence.next_node)).collect();
        assert_eq!(links, [(None, Some(8)), (Some(7), Some(7)), (Some(8), None), (None, None)]);
        assert_eq!(runs(&[]), []);
    }

    #[test]
    fn equals_counting_frame_by_frame() {
        for seed in 0..40 {
            let mut random = Random(seed);
            let clips: Vec<Vec<u32>> =
                (0..random.below(6)).map(|_| (0..random.below(60)).map(|_| random.below(5) as u32).collect()).collect();
            let mut records: Vec<ClipRuns> = clips
                .iter()
                .zip(0..)
                .map(|(nodes, clip_id)| {
                    let samples: Vec<_> = nodes.iter().zip(0..).map(|(&node, at)| (at, at + 1, node)).collect();
                    ClipRuns { clip_id, runs: runs(&placed(&samples)) }
                })
                .collect();
            let found = graph(&records);
            records.reverse();
            assert_eq!(found, graph(&records), "seed {seed}: the order of clips shows");

            let mut edges: BTreeMap<(u32, u32), (u32, BTreeSet<usize>)> = BTreeMap::new();
            let mut visits: BTreeMap<u32, (u32, BTreeSet<usize>)> = BTreeMap::new();
            for (clip, nodes) in clips.iter().enumerate() {
                for pair in nodes.windows(2).filter(|pair| pair[0] != pair[1]) {
                    let edge = edges.entry((pair[0], pair[1])).or_default();
                    edge.0 += 1;
                    edge.1.insert(clip);
                }
                for &node in nodes {
                    let visit = visits.entry(node).or_default();
                    visit.0 += 1;
                    visit.1.insert(clip);
                }
            }
            let ours: Vec<_> = found.edges.iter().map(|e| (e.from_node, e.to_node, e.transitions, e.clips)).collect();
            let theirs: Vec<_> = edges.iter().map(|(k, v)| (k.0, k.1, v.0, v.1.len() as u32)).collect();
            assert_eq!(ours, theirs, "seed {seed}");
            let ours: Vec<_> = found.visits.iter().map(|v| (v.node, v.samples, v.clips)).collect();
            let theirs: Vec<_> = visits.iter().map(|(k, v)| (*k, v.0, v.1.len() as u32)).collect();
            assert_eq!(ours, theirs, "seed {seed}");
            for visit in &found.visits {
                assert_eq!(visit.frames, u64::from(visit.samples));
            }
        }
    }
}
