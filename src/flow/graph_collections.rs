//! The cluster graph's edges and node counts as differential collections, consistent while clips come and go.
//!
//! ```text
//! clips (clip, all its runs) -> pairs of neighboring runs -> (from, to) counted: transitions
//!                                                         -> (from, to) of distinct clips counted: clips
//!                            -> runs, exploded by their samples -> node counted: members
//!                            -> (node, clip) distinct, node counted: clips
//! ```
//!
//! The record is a clip with all its runs: a frame as record costs three times the time and memory for nothing
//! (DATAFLOW 5). A clip goes by presenting the identical record with -1. `cluster::graph` has the pure function
//! that these collections must equal.

use crate::cluster::{ClipRuns, Edge, Visits, sequences};
use differential_dataflow::input::{Input, InputSession};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use timely::ExchangeData;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::Stream;
use timely::dataflow::channels::pact::Exchange;
use timely::dataflow::operators::Probe;
use timely::dataflow::operators::generic::operator::Operator;
use timely::dataflow::operators::probe::Handle;
use timely::worker::Worker;

type Updates<D> = Rc<RefCell<Vec<(D, u64, isize)>>>;
/// ((from, to), (transitions, clips)).
type EdgeCounts = ((u32, u32), (isize, isize));
/// (node, ((samples, native frames), clips)).
type NodeCounts = (u32, ((isize, isize), isize));

/// The collections of one worker. Every worker holds the inputs of some clips; worker 0 gets all results.
pub(crate) struct GraphCollections {
    clips: InputSession<u64, ClipRuns, isize>,
    probe: Handle<u64>,
    edges: Updates<EdgeCounts>,
    nodes: Updates<NodeCounts>,
}

impl GraphCollections {
    /// Builds the dataflow, empty at time 0.
    pub(crate) fn open(worker: &mut Worker) -> GraphCollections {
        worker.dataflow::<u64, _, _>(|scope| {
            let (input, clips) = scope.new_collection::<ClipRuns, isize>();
            let sequences = clips.flat_map(|clip| sequences(&clip).collect::<Vec<_>>());
            let links = sequences.clone().flat_map(|s| s.next_node.map(|next| ((s.node, next), s.clip_id)));
            let transitions = links.clone().map(|(edge, _)| edge).count();
            let edge_clips = links.distinct().map(|(edge, _)| edge).count();
            let edges = transitions.join(edge_clips);
            let visits = sequences.clone().map(|s| (s.node, s.clip_id)).distinct().map(|(node, _)| node).count();
            let samples = sequences.clone().explode(|s| Some((s.node, s.samples as isize))).count();
            let frames = sequences.explode(|s| Some((s.node, (s.end - s.first) as isize))).count();
            let nodes = samples.join(frames).join(visits);

            let probe = Handle::new();
            let (edge_updates, node_updates) = (Updates::default(), Updates::default());
            gather(edges.inner, "Edges", &edge_updates, &probe);
            gather(nodes.inner, "Nodes", &node_updates, &probe);
            GraphCollections { clips: input, probe, edges: edge_updates, nodes: node_updates }
        })
    }

    /// Presents changes (+1 a clip that comes, -1 one that goes) and works until they are through everywhere.
    pub(crate) fn update(&mut self, worker: &mut Worker, changes: Vec<(ClipRuns, isize)>) {
        for (clip, change) in changes {
            self.clips.update(clip, change);
        }
        let next = self.clips.time() + 1;
        self.clips.advance_to(next);
        self.clips.flush();
        while self.probe.less_than(&next) {
            worker.step_or_park(None);
        }
    }

    /// The edges as of now, by (from, to). Empty but on worker 0.
    pub(crate) fn edges(&self) -> Vec<Edge> {
        let now = as_of(&self.edges, *self.clips.time());
        now.into_iter()
            .map(|((from_node, to_node), (transitions, clips))| Edge {
                from_node,
                to_node,
                transitions: transitions as u32,
                clips: clips as u32,
            })
            .collect()
    }

    /// How much of the clips is in each node as of now, by node. Empty but on worker 0.
    pub(crate) fn visits(&self) -> Vec<Visits> {
        let now = as_of(&self.nodes, *self.clips.time());
        now.into_iter()
            .map(|(node, ((samples, frames), clips))| Visits {
                node,
                samples: samples as u32,
                clips: clips as u32,
                frames: frames as u64,
            })
            .collect()
    }
}

/// Brings all updates of a collection to worker 0. The probe passes a time when its updates have been gathered.
fn gather<'scope, D: ExchangeData>(
    updates: Stream<'scope, u64, Vec<(D, u64, isize)>>,
    name: &str,
    into: &Updates<D>,
    probe: &Handle<u64>,
) {
    let into = Rc::clone(into);
    let to_worker_0 = Exchange::new(|_: &(D, u64, isize)| 0);
    updates
        .unary::<CapacityContainerBuilder<Vec<()>>, _, _, _>(to_worker_0, name, move |_, _| {
            move |input, _| {
                input.for_each_stamp(|_, updates| into.borrow_mut().extend(updates.flat_map(|batch| batch.drain(..))));
            }
        })
        .probe_with(probe);
}

/// What holds before `time`: later updates may have come already and don't count.
fn as_of<K: Ord + Copy, V: Ord + Copy>(updates: &Updates<(K, V)>, time: u64) -> Vec<(K, V)> {
    let mut sums = BTreeMap::<(K, V), isize>::new();
    for &(record, at, change) in updates.borrow().iter() {
        if at < time {
            *sums.entry(record).or_default() += change;
        }
    }
    sums.into_iter().filter(|&(_, sum)| sum != 0).map(|(record, _)| record).collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::cluster::{Run, graph};
    use std::sync::{Arc, Mutex};

    fn clips() -> Vec<ClipRuns> {
        let run = |clip: u32, k: u32| Run {
            first: 10 * k,
            end: 10 * k + if (clip + k).is_multiple_of(5) { 7 } else { 10 },
            node: (clip * 3 + k * k) % 11,
            samples: k % 4 + 1,
        };
        (0..40)
            .map(|clip| ClipRuns { clip_id: clip, runs: (0..clip % 7 + 1).map(|k| run(clip, k)).collect() })
            .collect()
    }

    fn plain(clips: &[ClipRuns]) -> (Vec<Edge>, Vec<Visits>) {
        let graph = graph(clips);
        (graph.edges, graph.visits)
    }

    #[test]
    fn the_collections_equal_the_plain_tables_while_clips_come_and_go() {
        for workers in [1, 2, 3] {
            let found = Arc::new(Mutex::new(Vec::new()));
            let into = Arc::clone(&found);
            timely::execute(timely::Config::process(workers), move |worker| {
                let mut graph = GraphCollections::open(worker);
                let (index, peers) = (worker.index() as u32, worker.peers() as u32);
                let mine = |change: isize, range: std::ops::Range<u32>| -> Vec<(ClipRuns, isize)> {
                    let mine = clips().into_iter().filter(|c| c.clip_id % peers == index && range.contains(&c.clip_id));
                    mine.map(|clip| (clip, change)).collect()
                };
                for changes in [mine(1, 0..30), mine(-1, 5..8), mine(1, 30..40)] {
                    graph.update(worker, changes);
                    if index == 0 {
                        into.lock().unwrap().push((graph.edges(), graph.visits()));
                    }
                }
            })
            .unwrap()
            .join()
            .into_iter()
            .for_each(|result| result.unwrap());
            let all = clips();
            let without: Vec<ClipRuns> =
                all[..30].iter().filter(|clip| !(5..8).contains(&clip.clip_id)).cloned().collect();
            let with: Vec<ClipRuns> = without.iter().chain(&all[30..]).cloned().collect();
            assert_eq!(*found.lock().unwrap(), [plain(&all[..30]), plain(&without), plain(&with)], "{workers} workers");
        }
    }
}
