//! The cluster dataflow: samples to the worker of their plant state, a tree a state, committed state by state.
//!
//! ```text
//! desk -> shards -> features and plant states -> canonical vectors --exchange by plant state--> samples of a worker
//! samples -> tree -> write -> worker 0
//! ```
//!
//! Only samples of one plant state meet (T 4.2.2), so states are independent. A state's files are put when its tree is
//! done; what a kill costs is the state in hand.

use super::agree::agree;
use super::gauges::Station;
use super::halt::Halt;
use super::mill::MillContext;
use super::shard_writer::fatal_text;
use super::tickets::open_desk;
use super::work::{ClipJob, ClipOrigin, ShardJob, Todo};
use crate::annotate::PlantState;
use crate::annotate::samples::samples;
use crate::cluster::banded::{Bands, Step, tree_in_bands};
use crate::cluster::metric::LANES;
use crate::cluster::{ClusterError, Merge, Metric, Sample, Vector};
use crate::corpus::{
    Catalog, ClipFormat, ClipRow, CorpusError, FileNotes, FileRecord, Manifest, ShardKind, StageKeys, items_file,
    merges_file, write_items, write_merges,
};
use crate::motion::Format;
use crate::plan::{ClipFacts, ClipFilter};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;
use timely::container::CapacityContainerBuilder;
use timely::dataflow::Stream;
use timely::dataflow::channels::pact::Exchange;
use timely::dataflow::operators::Probe;
use timely::dataflow::operators::generic::operator::{Operator, source};
use timely::dataflow::operators::probe::Handle;
use timely::dataflow::operators::vec::Input;
use timely::worker::Worker;

/// The tree that is built: all effectors. Later: legs, upper, trunk.
pub(crate) const TREE: &str = "body";

/// The samples of one clip that are in one plant state.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Samples {
    state: u8,
    source: String,
    name: String,
    clip_id: u32,
    frames: Vec<u32>,
    /// `[sample][lane]`.
    vectors: Vec<f32>,
}

/// A state whose tree is written.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct TreeWritten {
    state: u8,
    files: Vec<(String, u64, String, u64)>,
}

/// What worker 0 knows of the trees.
#[derive(Debug, Default)]
pub(crate) struct TreePlan {
    /// States to be made; empty: nothing to do.
    pub(crate) states: BTreeSet<PlantState>,
    /// Key that they will have.
    pub(crate) key: String,
    /// The shards as tickets.
    pub(crate) tickets: Vec<ShardJob>,
}

/// Name of a state's key in the manifest.
pub(crate) fn state_key(state: PlantState) -> String {
    format!("tree/{TREE}/{}", state.name())
}

/// Which states have to be made, on worker 0.
pub(crate) fn plan_trees(stage_key: &str, filter: &ClipFilter, catalog: &Catalog, manifest: &Manifest) -> TreePlan {
    let mut hasher = blake3::Hasher::new();
    hasher.update(stage_key.as_bytes());
    let mut tickets = Vec::new();
    for record in catalog.records().iter().filter(|record| record.shard.kind == ShardKind::Captured) {
        hasher.update(format!("\n{} {} {}", record.keys.ingest, record.keys.features, record.keys.labels).as_bytes());
        let clips: Vec<ClipJob> = record
            .clips
            .iter()
            .filter(|row| filter.lets_through(&facts(row)))
            .map(|row| ClipJob {
                clip_id: row.clip_id,
                source: row.source.clone(),
                name: row.name.clone(),
                origin: ClipOrigin::Stored,
            })
            .collect();
        if !clips.is_empty() {
            tickets.push(ShardJob {
                shard: record.shard,
                replaces: Vec::new(),
                todo: Todo::Samples { states: 0 },
                keys: StageKeys::default(),
                clips,
            });
        }
    }
    let key = hasher.finalize().to_hex()[..32].to_owned();
    let states: BTreeSet<PlantState> =
        PlantState::ALL.into_iter().filter(|&state| manifest.stages.get(&state_key(state)) != Some(&key)).collect();
    if states.is_empty() {
        return TreePlan { states, key, tickets: Vec::new() };
    }
    // The states travel with the tickets: a worker in another process knows of nothing else.
    let bits = states.iter().fold(0, |bits, &state| bits | 1 << state as u8);
    tickets.iter_mut().for_each(|ticket| ticket.todo = Todo::Samples { states: bits });
    TreePlan { states, key, tickets }
}

/// What a stage's filter asks of a clip.
pub(crate) fn facts(row: &ClipRow) -> ClipFacts<'_> {
    ClipFacts {
        source: &row.source,
        name: &row.name,
        format: match row.format {
            ClipFormat::Bvh => Some(Format::Bvh),
            ClipFormat::Amc => Some(Format::Amc),
            ClipFormat::Made => None,
        },
        gait: row.labels.gait_class,
        gait_confidence: row.labels.gait_confidence.map(f64::from),
        duration_s: Some(row.duration_s),
    }
}

/// Builds the trees. Worker 0 gives the plan and has the manifest, which notes each state as it is done.
///
/// Two dataflows: no tree may grow before every worker of every process has said that it read all its shards, or a
/// state that lacks the samples of an interrupted process would be written as whole.
pub(crate) fn grow_trees(
    worker: &mut Worker,
    plan: TreePlan,
    manifest: &Rc<RefCell<Manifest>>,
    context: &MillContext,
) -> Option<Halt> {
    let TreePlan { states, key, tickets } = plan;
    let samples = gather_samples(worker, tickets, context);
    if let Some(halt) = agree(worker, &context.flag) {
        return Some(halt);
    }
    let reported = Rc::new(RefCell::new(BTreeSet::<PlantState>::new()));
    let probe = Handle::<u64>::new();
    let mut input = worker.dataflow::<u64, _, _>(|scope| {
        let (input, written) = scope.new_input::<TreeWritten>();
        note_trees(written, &key, manifest, &reported, context).probe_with(&probe);
        input
    });
    for (state, samples) in samples {
        if context.flag.reason().is_some() {
            break;
        }
        let start = Instant::now();
        match grow(state, samples, context) {
            Ok(Some(written)) => input.send(written),
            Ok(None) => break,
            Err(error) => context.flag.halt(Halt::Fatal(error)),
        }
        context.gauges.spent(Station::Tree, start.elapsed());
        let next = input.time() + 1;
        input.advance_to(next);
        worker.step();
    }
    input.close();
    while !probe.done() {
        worker.step_or_park(None);
    }
    let halt = agree(worker, &context.flag);
    if halt.is_none() && worker.index() == 0 {
        let forgotten = forget_empty_states(&reported.borrow(), &states, &key, &mut manifest.borrow_mut(), context);
        if let Err(error) = forgotten {
            context.flag.halt(Halt::Fatal(fatal_text(&error)));
        }
    }
    halt
}

/// The samples of the plant states that are this worker's.
fn gather_samples(worker: &mut Worker, tickets: Vec<ShardJob>, context: &MillContext) -> BTreeMap<u8, Vec<Samples>> {
    let desk = open_desk(worker, tickets, &context.flag);
    let probe = Handle::<u64>::new();
    let peers = worker.peers() as u64;
    let gathered = Rc::new(RefCell::new(BTreeMap::<u8, Vec<Samples>>::new()));
    let into = Rc::clone(&gathered);
    worker.dataflow::<u64, _, _>(|scope| {
        let reading = context.clone();
        let metric = Metric::new(&context.settings.cluster);
        source::<_, CapacityContainerBuilder<Vec<Samples>>, _, _>(scope, "Samples", move |capability, info| {
            let me = scope.activator_for(info.address.clone());
            desk.borrow_mut().wake(scope.activator_for(info.address));
            me.activate();
            let mut capability = Some(capability);
            move |output| {
                let Some(held) = &capability else { return };
                if desk.borrow().open_requests() == 0 {
                    desk.borrow_mut().ask();
                }
                let answer = desk.borrow_mut().take();
                match (answer, &metric, reading.flag.reason()) {
                    (None, ..) => {} // the inbox wakes us
                    (Some(Some(shard)), Ok(metric), None) => {
                        let start = Instant::now();
                        match read_samples(&shard, metric, &reading) {
                            Ok(found) => {
                                let mut session = output.session(held);
                                found.into_iter().for_each(|samples| session.give(samples));
                            }
                            Err(error) => reading.flag.halt(Halt::Fatal(fatal_text(&error))),
                        }
                        reading.gauges.spent(Station::Read, start.elapsed());
                        me.activate();
                    }
                    (Some(_), metric, halt) => {
                        if let Err(error) = metric {
                            reading.flag.halt(Halt::Fatal(error.to_string()));
                        }
                        if let Some(halt) = halt {
                            desk.borrow_mut().halt(halt);
                        }
                        capability = None;
                        desk.borrow_mut().leave();
                    }
                }
            }
        })
        .unary::<CapacityContainerBuilder<Vec<()>>, _, _, _>(
            Exchange::new(move |samples: &Samples| worker_of(samples.state, peers)),
            "GatherSamples",
            move |_, _| {
                move |input, _| {
                    input.for_each_stamp(|_, batch| {
                        for samples in batch.flat_map(|batch| batch.drain(..)) {
                            into.borrow_mut().entry(samples.state).or_default().push(samples);
                        }
                    });
                }
            },
        )
        .probe_with(&probe);
    });
    while !probe.done() {
        worker.step_or_park(None);
    }
    gathered.take()
}

/// Worker 0 notes each tree in the manifest, and puts that.
fn note_trees<'scope>(
    written: Stream<'scope, u64, Vec<TreeWritten>>,
    key: &str,
    manifest: &Rc<RefCell<Manifest>>,
    reported: &Rc<RefCell<BTreeSet<PlantState>>>,
    context: &MillContext,
) -> Stream<'scope, u64, Vec<()>> {
    let (manifest, reported, key) = (Rc::clone(manifest), Rc::clone(reported), key.to_owned());
    let (store, flag) = (context.store.clone(), Arc::clone(&context.flag));
    let to_worker_0 = Exchange::new(|_: &TreeWritten| 0);
    written.unary::<CapacityContainerBuilder<Vec<()>>, _, _, _>(to_worker_0, "TreesWritten", move |_, _| {
        move |input, _| {
            input.for_each_stamp(|_, batch| {
                for TreeWritten { state, files } in batch.flat_map(|batch| batch.drain(..)) {
                    let state = PlantState::ALL[state as usize];
                    reported.borrow_mut().insert(state);
                    let mut manifest = manifest.borrow_mut();
                    manifest.note_files(files.into_iter().map(|(path, bytes, blake3, rows)| FileRecord {
                        path,
                        bytes,
                        blake3,
                        rows,
                    }));
                    manifest.stages.insert(state_key(state), key.clone());
                    if let Err(error) = manifest.put(&store) {
                        flag.halt(Halt::Fatal(fatal_text(&error)));
                    }
                }
            });
        }
    })
}

/// A state that no sample is in has no tree; an older one's files go.
fn forget_empty_states(
    reported: &BTreeSet<PlantState>,
    states: &BTreeSet<PlantState>,
    key: &str,
    manifest: &mut Manifest,
    context: &MillContext,
) -> Result<(), CorpusError> {
    for &state in states.difference(reported) {
        for file in [items_file(TREE, state), merges_file(TREE, state)] {
            if manifest.tables.remove(&file).is_some() {
                context.store.remove(&file)?;
            }
        }
        manifest.stages.insert(state_key(state), key.to_owned());
    }
    manifest.put(&context.store)
}

/// `LB` holds half of all frames; the other states share what workers are left.
fn worker_of(state: u8, peers: u64) -> u64 {
    match PlantState::ALL[state as usize] {
        PlantState::LB => 0,
        _ if peers == 1 => 0,
        other => 1 + other as u64 % (peers - 1),
    }
}

fn read_samples(shard: &ShardJob, metric: &Metric, context: &MillContext) -> Result<Vec<Samples>, CorpusError> {
    let catalog = context.catalog.as_ref().ok_or_else(|| CorpusError::NotThere { what: "the catalog".to_owned() })?;
    let Some(reader) = catalog.shards().find(|reader| reader.record().shard == shard.shard) else {
        return Err(CorpusError::NotThere { what: shard.shard.to_string() });
    };
    let Todo::Samples { states: bits } = shard.todo else { return Ok(Vec::new()) };
    let wanted: BTreeMap<u32, &ClipJob> = shard.clips.iter().map(|clip| (clip.clip_id, clip)).collect();
    let mut labels = reader.all_labels()?.peekable();
    let mut found = Vec::new();
    for clip in reader.all_features()? {
        let (clip_id, features) = clip?;
        let Some(job) = wanted.get(&clip_id) else { continue };
        let states = loop {
            match labels.next() {
                Some(Ok((id, labels))) if id == clip_id => break labels.plant_state,
                Some(Ok((id, _))) if id < clip_id => {}
                Some(Err(error)) => return Err(error),
                _ => return Err(CorpusError::NotThere { what: format!("labels of clip {clip_id}") }),
            }
        };
        let row = reader.row(clip_id)?;
        let frames = samples(row.frames as usize, row.rate_hz, &states, Some(context.settings.cluster_rate_hz));
        for state in PlantState::ALL.into_iter().filter(|&state| bits >> state as u8 & 1 == 1) {
            let own: Vec<u32> = frames.iter().copied().filter(|&frame| states[frame as usize] == Some(state)).collect();
            if own.is_empty() {
                continue;
            }
            let vectors = metric
                .vectors(&features, &own)
                .map_err(|error| CorpusError::NotThere { what: format!("a vector of clip {clip_id} ({error})") })?;
            found.push(Samples {
                state: state as u8,
                source: job.source.clone(),
                name: job.name.clone(),
                clip_id,
                frames: own,
                vectors: vectors.iter().flat_map(|vector| vector.0).collect(),
            });
        }
        context.gauges.clips_done.fetch_add(1, Ordering::Relaxed);
    }
    Ok(found)
}

/// One state: samples in tie order, the tree, its two tables. None: the run halts.
fn grow(state: u8, mut clips: Vec<Samples>, context: &MillContext) -> Result<Option<TreeWritten>, String> {
    let plant_state = PlantState::ALL[state as usize];
    clips.sort_by(|a, b| (&a.source, &a.name).cmp(&(&b.source, &b.name)));
    let items: Vec<Sample> = clips
        .iter()
        .flat_map(|clip| clip.frames.iter().map(|&frame| Sample { clip_id: clip.clip_id, frame }))
        .collect();
    let vectors: Vec<Vector> = clips.into_iter().flat_map(|clip| to_vectors(&clip.vectors)).collect();
    let merges = match grow_in_bands(plant_state, vectors, context) {
        Ok(merges) => merges,
        Err(ClusterError::Stopped) => return Ok(None),
        Err(error) => return Err(format!("plant state {}: {error}", plant_state.name())),
    };
    let notes = FileNotes::from([
        ("t_max_m2".to_owned(), context.settings.cluster.t_max_m2.to_string()),
        ("metric".to_owned(), Metric::new(&context.settings.cluster).map(|metric| metric.digest()).unwrap_or_default()),
    ]);
    let write = || {
        Ok([
            write_items(&context.store, TREE, plant_state, &items, &notes)?,
            write_merges(&context.store, TREE, plant_state, &merges, &notes)?,
        ])
    };
    let files = write().map_err(|error: CorpusError| fatal_text(&error))?;
    let files = files.into_iter().map(|file| (file.path, file.bytes, file.blake3, file.rows)).collect();
    Ok(Some(TreeWritten { state, files }))
}

fn to_vectors(values: &[f32]) -> Vec<Vector> {
    let (whole, _) = values.as_chunks::<LANES>();
    whole.iter().map(|lanes| Vector(*lanes)).collect()
}

/// Says how far it is, and stops when the run halts.
fn grow_in_bands(state: PlantState, vectors: Vec<Vector>, context: &MillContext) -> Result<Vec<Merge>, ClusterError> {
    let n = vectors.len();
    let mut merged = 0;
    let mut tell = |step| {
        if let Step::Arranged { items } = step {
            merged = 100 * (n - items) / n;
        }
        context.gauges.say(&format!("plant state {}: {n} samples, {merged} % merged", state.name()));
        if context.flag.reason().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    tree_in_bands(vectors, &context.settings.cluster, &Bands::default(), &mut tell)
}
