//! The graph's tables from the trees: cuts, runs of every clip, edges and counts as collections, medoids, components.

use super::gauges::Station;
use super::graph_collections::GraphCollections;
use super::halt::Halt;
use super::mill::MillContext;
use super::shard_writer::fatal_text;
use super::tree::TREE;
use crate::annotate::{Features, PlantState};
use crate::cluster::{
    ClipRuns, Cut, Edge, Medoid, Merge, Metric, Node, PlacedSample, Sample, Sequence, StateCut, Vector, Visits, align,
    components, cut, first_nodes, frame_ranges, medoids, nodes, runs, sequences,
};
use crate::corpus::{
    Catalog, CorpusError, FileNotes, FileRecord, ShardKind, read_items, read_merges, write_edges, write_nodes,
    write_sequences,
};
use std::collections::BTreeMap;
use std::time::Instant;
use timely::worker::Worker;

/// Why the graph could not be made.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say it")]
pub(crate) enum GraphError {
    #[error(transparent)]
    Corpus(#[from] CorpusError),
    #[error("the tree of this corpus is not what it was written as: {0}")]
    Tree(#[from] crate::cluster::ClusterError),
}

/// The graph of all captured clips, in one go.
#[derive(Debug, Default)]
pub(crate) struct GraphTables {
    pub(crate) nodes: Vec<Node>,
    pub(crate) sequences: Vec<Sequence>,
    pub(crate) edges: Vec<Edge>,
}

/// One cut of one state's tree.
struct CutState {
    state: PlantState,
    cut: Cut,
    first_node: u32,
}

struct StateTree {
    items: Vec<Sample>,
    merges: Vec<Merge>,
    vectors: Vec<Vector>,
}

/// Makes the graph's tables. All workers take part; worker 0 has the clips and gets the tables. What it can't read
/// halts the run; the others don't wait for it, and are to ask whether that is so.
pub(crate) fn make_graph(worker: &mut Worker, wanted: bool, context: &MillContext) -> Option<GraphTables> {
    let start = Instant::now();
    let mut collections = GraphCollections::open(worker);
    let mut input = None;
    if wanted && worker.index() == 0 {
        match read_trees(context) {
            Ok(trees) => input = Some(trees),
            Err(GraphError::Corpus(error)) => context.flag.halt(Halt::Fatal(fatal_text(&error))),
            Err(error @ GraphError::Tree(_)) => context.flag.halt(Halt::Fatal(error.to_string())),
        }
    }
    let clips: Vec<ClipRuns> = input.as_ref().map(|(_, _, clips)| clips.clone()).unwrap_or_default();
    collections.update(worker, clips.into_iter().map(|clip| (clip, 1)).collect());
    let (trees, cuts, clips) = input?;
    let (edges, visits) = (collections.edges(), collections.visits());
    let mut sequences: Vec<Sequence> = clips.iter().flat_map(sequences).collect();
    sequences.sort_unstable();
    let tables = describe(&trees, &cuts, sequences, edges, &visits, context);
    context.gauges.spent(Station::Graph, start.elapsed());
    Some(tables)
}

/// Writes the three tables.
pub(crate) fn write_graph(tables: &GraphTables, context: &MillContext) -> Result<Vec<FileRecord>, CorpusError> {
    let notes = FileNotes::new();
    Ok(vec![
        write_nodes(&context.store, &tables.nodes, &notes)?,
        write_sequences(&context.store, &tables.sequences, &notes)?,
        write_edges(&context.store, &tables.edges, &notes)?,
    ])
}

type Trees = BTreeMap<PlantState, StateTree>;

fn read_trees(context: &MillContext) -> Result<(Trees, Vec<CutState>, Vec<ClipRuns>), GraphError> {
    let catalog = context.catalog.as_ref().ok_or_else(|| CorpusError::NotThere { what: "the catalog".to_owned() })?;
    let metric = Metric::new(&context.settings.cluster)?;
    let mut trees = Trees::new();
    for state in PlantState::ALL {
        let items = match read_items(&context.store, TREE, state) {
            Ok(items) => items,
            Err(CorpusError::NotThere { .. }) => continue, // no sample is in this state
            Err(error) => return Err(error.into()),
        };
        let merges = read_merges(&context.store, TREE, state)?;
        trees.insert(state, StateTree { items, merges, vectors: Vec::new() });
    }
    let cuts = cut_trees(&trees, &context.settings.thresholds_m2)?;
    let (clips, vectors) = place_samples(&trees, &cuts, catalog, &metric)?;
    for (state, vectors) in vectors {
        if let Some(tree) = trees.get_mut(&state) {
            tree.vectors = vectors;
        }
    }
    Ok((trees, cuts, clips))
}

/// Cuts in the order of (threshold, plant state), with their nodes numbered one after the other.
fn cut_trees(trees: &Trees, thresholds_m2: &[f64]) -> Result<Vec<CutState>, GraphError> {
    let mut cuts = Vec::new();
    for &threshold_m2 in thresholds_m2 {
        for (&state, tree) in trees {
            cuts.push((state, cut(tree.items.len(), &tree.merges, threshold_m2)?));
        }
    }
    let sizes: Vec<usize> = cuts.iter().map(|(_, cut)| cut.n_nodes()).collect();
    let first = first_nodes(&sizes)?;
    Ok(cuts.into_iter().zip(first).map(|((state, cut), first_node)| CutState { state, cut, first_node }).collect())
}

/// The runs of every clip at every threshold, and the vector of every sample.
#[expect(clippy::type_complexity, reason = "two results of one pass over the features")]
fn place_samples(
    trees: &Trees,
    cuts: &[CutState],
    catalog: &Catalog,
    metric: &Metric,
) -> Result<(Vec<ClipRuns>, Vec<(PlantState, Vec<Vector>)>), GraphError> {
    // (clip, frame) -> (state, place in the state's items).
    let mut placed = BTreeMap::<u32, Vec<(u32, PlantState, u32)>>::new();
    for (&state, tree) in trees {
        for (item, sample) in tree.items.iter().enumerate() {
            placed.entry(sample.clip_id).or_default().push((sample.frame, state, item as u32));
        }
    }
    for samples in placed.values_mut() {
        samples.sort_unstable();
    }
    let mut vectors: BTreeMap<PlantState, Vec<Vector>> = trees
        .iter()
        .map(|(&state, tree)| (state, vec![Vector([0.0; crate::cluster::metric::LANES]); tree.items.len()]))
        .collect();
    let nodes_of: Vec<(PlantState, u32, Vec<u32>)> =
        cuts.iter().map(|cut| (cut.state, cut.first_node, cut.cut.nodes_of_samples())).collect();
    let n_thresholds = cuts.len() / trees.len().max(1);
    let mut clips = Vec::new();
    for reader in catalog.shards().filter(|reader| reader.record().shard.kind == ShardKind::Captured) {
        let mut labels = reader.all_labels()?;
        for clip in reader.all_features()? {
            let (clip_id, features): (u32, Features) = clip?;
            let Some(samples) = placed.get(&clip_id) else { continue };
            let states = loop {
                match labels.next() {
                    Some(Ok((id, labels))) if id == clip_id => break labels.plant_state,
                    Some(Ok((id, _))) if id < clip_id => {}
                    Some(Err(error)) => return Err(error.into()),
                    _ => return Err(CorpusError::NotThere { what: format!("labels of clip {clip_id}") }.into()),
                }
            };
            let frames: Vec<u32> = samples.iter().map(|&(frame, ..)| frame).collect();
            let ranges = frame_ranges(&states, &frames);
            for (&(_, state, item), vector) in samples.iter().zip(metric.vectors(&features, &frames)?) {
                if let Some(vectors) = vectors.get_mut(&state) {
                    vectors[item as usize] = vector;
                }
            }
            let mut all_runs = Vec::new();
            for threshold in 0..n_thresholds {
                let at = &nodes_of[threshold * trees.len()..(threshold + 1) * trees.len()];
                let node = |state: PlantState, item: u32| {
                    at.iter()
                        .find(|(own, ..)| *own == state)
                        .map_or(0, |(_, first, nodes)| first + nodes[item as usize])
                };
                let placed: Vec<PlacedSample> = samples
                    .iter()
                    .zip(&ranges)
                    .map(|(&(_, state, item), frames)| PlacedSample { frames: frames.clone(), node: node(state, item) })
                    .collect();
                all_runs.push(runs(&placed));
            }
            clips.extend(all_runs.into_iter().map(|runs| ClipRuns { clip_id, runs }));
        }
    }
    Ok((clips, vectors.into_iter().collect()))
}

/// Medoids, alignment frames, components, and the rows of `nodes`.
fn describe(
    trees: &Trees,
    cuts: &[CutState],
    mut sequences: Vec<Sequence>,
    edges: Vec<Edge>,
    visits: &[Visits],
    context: &MillContext,
) -> GraphTables {
    let all_nodes: Vec<u32> =
        cuts.iter().flat_map(|cut| cut.first_node..cut.first_node + cut.cut.n_nodes() as u32).collect();
    let parts = components(&all_nodes, &edges);
    let mut rows = Vec::new();
    for CutState { state, cut, first_node } in cuts {
        let tree = &trees[state];
        let centers: Vec<Medoid> = medoids(&tree.vectors, cut);
        let state_cut =
            StateCut { cut, first_node: *first_node, samples: &tree.items, vectors: &tree.vectors, medoids: &centers };
        align(&mut sequences, state_cut, context.settings.alignment);
        rows.extend(nodes(TREE, *state, state_cut, &tree.merges, visits, &parts));
    }
    GraphTables { nodes: rows, sequences, edges }
}
