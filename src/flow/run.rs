//! A run: inputs and plan in, a corpus out. Three dataflows one after the other, with a barrier and a fold after each.

use super::barrier::barrier;
use super::enrich::{plan_enrichment, write_made_table};
use super::gauges::{Gauges, Station};
use super::graph::{GraphError, make_graph, write_graph};
use super::halt::{Halt, HaltFlag};
use super::mesh::{Hosts, MeshError, connect};
use super::mill::{MillContext, mill};
use super::prepare::{Prepared, note_quarantined, prepare};
use super::settings::RunSettings;
use super::shard_writer::fatal_text;
use super::tree::{TreePlan, grow_trees, plan_trees};
use super::work::ShardJob;
use crate::corpus::{
    Catalog, CorpusError, FaultRow, FileNotes, Folded, Manifest, OpenCorpus, SourceTerms, Store, open_to_run,
    read_records, write_card,
};
use crate::inputs::InputError;
use crate::plan::{Plan, Stage};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use timely::communication::Hooks;
use timely::communication::allocator::zero_copy::initialize::initialize_networking_from_sockets;
use timely::communication::allocator::{AllocatorBuilder, ProcessBuilder};
use timely::worker::Worker;
use timely::{CommunicationConfig, WorkerConfig};

/// What is asked for.
#[derive(Clone, Debug)]
pub struct RunRequest {
    /// The checked plan.
    pub plan: Plan,
    /// Folders with captures.
    pub inputs: Vec<PathBuf>,
    /// Whether these were made by the program.
    pub procedural: bool,
    /// The corpus.
    pub out: PathBuf,
    /// Threads that mill, in this process.
    pub workers: usize,
    /// Other processes of the run.
    pub hosts: Option<Hosts>,
    /// Warnings are faults.
    pub strict: bool,
    /// Clips whose files have gone are removed.
    pub prune: bool,
}

/// What a run did, for the table at its end.
#[derive(Clone, Debug, Default)]
pub struct RunReport {
    /// Clips found among the inputs, and their text.
    pub found: usize,
    /// Bytes of that.
    pub bytes: u64,
    /// Clips that needed nothing.
    pub finished: usize,
    /// Clips that were parsed.
    pub parsed: usize,
    /// Whether there was nothing to do at all.
    pub up_to_date: bool,
    /// Clips whose files have gone, `source/name`.
    pub gone: Vec<String>,
    /// Clips that are quarantined now.
    pub quarantined: usize,
    /// Each dataflow: name, frames that went through it, wall time.
    pub dataflows: Vec<(&'static str, u64, Duration)>,
}

/// Why a run did not do its work.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum RunError {
    #[error("{}", fatal_text(.0))]
    Corpus(#[from] CorpusError),
    #[error("{}", .0.iter().map(|error| error.to_string()).collect::<Vec<_>>().join("\n"))]
    Inputs(Vec<InputError>),
    #[error(
        "no clip to read in the inputs\n  why: there is no .bvh and no .amc with its .asf below them ({faults} clips can't be used)\n  try: --input DIR with a folder of motion captures"
    )]
    NothingToRead { faults: usize },
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error("{0}")]
    Fatal(String),
    #[error("interrupted")]
    Interrupted { safe: usize, of: usize },
    #[error(transparent)]
    Graph(#[from] GraphError),
}

/// What process 0 has and the others have not.
struct Head {
    manifest: Manifest,
    prepared: Prepared,
}

/// Runs a plan. Progress goes to the gauges; `say` gets lines for the user (waiting for a process).
///
/// # Errors
/// [`RunError`]. What was committed is safe, and the same request continues.
pub fn run(
    request: &RunRequest,
    gauges: &Arc<Gauges>,
    flag: &Arc<HaltFlag>,
    say: impl FnMut(&str),
) -> Result<RunReport, RunError> {
    let leads = request.hosts.as_ref().is_none_or(|hosts| hosts.process == 0);
    let mut settings = RunSettings::of(&request.plan);
    settings.read.strict = request.strict;
    let mut head = None;
    let mut held: Option<OpenCorpus> = None;
    let store = Store::new(&request.out);
    if leads {
        let mut corpus = open_to_run(&request.out)?;
        gauges.begin("inputs", 0);
        let prepared = prepare(
            &request.plan,
            &request.inputs,
            request.procedural,
            request.prune,
            &corpus.store,
            &mut corpus.manifest,
        )?;
        head = Some(Head { manifest: std::mem::take(&mut corpus.manifest), prepared });
        held = Some(corpus);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(request.workers).build();
    let pool = pool.map_err(|error| RunError::Fatal(format!("no threads to work with: {error}")))?;
    let context = Context {
        plan: request.plan.clone(),
        settings: Arc::new(settings),
        store,
        flag: Arc::clone(flag),
        gauges: Arc::clone(gauges),
        pool: Arc::new(pool),
        head: Arc::new(Mutex::new(head)),
    };
    let results = execute(request, context, say)?;
    drop(held);
    results
}

/// What the workers of a process share.
#[derive(Clone)]
struct Context {
    plan: Plan,
    settings: Arc<RunSettings>,
    store: Store,
    flag: Arc<HaltFlag>,
    gauges: Arc<Gauges>,
    pool: Arc<rayon::ThreadPool>,
    /// Taken by worker 0.
    head: Arc<Mutex<Option<Head>>>,
}

fn execute(
    request: &RunRequest,
    context: Context,
    say: impl FnMut(&str),
) -> Result<Result<RunReport, RunError>, RunError> {
    let refused = |error: String| RunError::Fatal(format!("the workers could not be started: {error}"));
    let work = move |worker: &mut Worker| work(worker, &context);
    let guards = match &request.hosts {
        None => {
            let config = timely::Config {
                communication: CommunicationConfig::Process(request.workers),
                worker: WorkerConfig::default(),
            };
            timely::execute(config, work).map_err(refused)?
        }
        Some(hosts) => {
            let digest = *blake3::hash(request.plan.digest().as_bytes()).as_bytes();
            let sockets = connect(hosts, request.workers, digest, say)?;
            let hooks = Hooks::default();
            let processes =
                ProcessBuilder::new_typed_vector(request.workers, hooks.refill.clone(), hooks.spill.clone());
            let (builders, guard) =
                initialize_networking_from_sockets(processes, sockets, hosts.process, request.workers, hooks)
                    .map_err(|error| refused(error.to_string()))?;
            let builders = builders.into_iter().map(AllocatorBuilder::Tcp).collect();
            timely::execute::execute_from(builders, Box::new(guard), WorkerConfig::default(), work).map_err(refused)?
        }
    };
    let mut report = Ok(RunReport::default());
    for (index, result) in guards.join().into_iter().enumerate() {
        let result = result.map_err(refused)?;
        if index == 0 || result.is_err() {
            report = result;
        }
    }
    Ok(report)
}

/// One worker's part of the run.
fn work(worker: &mut Worker, context: &Context) -> Result<RunReport, RunError> {
    let mut lead = if worker.index() == 0 { context.head.lock().ok().and_then(|mut head| head.take()) } else { None };
    let mut report = RunReport::default();
    let mut mill_context = MillContext {
        store: context.store.clone(),
        settings: Arc::clone(&context.settings),
        flag: Arc::clone(&context.flag),
        gauges: Arc::clone(&context.gauges),
        catalog: catalog(context),
    };
    // Clips.
    let start = Instant::now();
    let shards: Vec<ShardJob> = lead.as_mut().map(|lead| std::mem::take(&mut lead.prepared.shards)).unwrap_or_default();
    let mut worked = !shards.is_empty();
    context.gauges.begin("clips", shards.iter().map(|shard| shard.clips.len() as u64).sum());
    let landed = mill(worker, shards, &mill_context);
    report.dataflows.push(("clips", landed.frames, start.elapsed()));
    halted(context)?;
    if let Some(lead) = &mut lead {
        fold(lead, context, worked)?;
    }
    barrier(worker);
    halted(context)?;

    // Cluster.
    mill_context.catalog = catalog(context);
    if context.plan.has(Stage::Tree) {
        let start = Instant::now();
        let manifest = Rc::new(RefCell::new(lead.as_ref().map(|lead| lead.manifest.clone()).unwrap_or_default()));
        let mut trees = TreePlan::default();
        if let (Some(_), Some(catalog)) = (&lead, &mill_context.catalog) {
            trees =
                plan_trees(&context.plan.keys().tree, &context.plan.filter(Stage::Tree), catalog, &manifest.borrow());
            worked |= !trees.states.is_empty();
            context.gauges.begin("cluster", trees.tickets.iter().map(|ticket| ticket.clips.len() as u64).sum());
        }
        let key = trees.key.clone();
        grow_trees(worker, trees, &manifest, &mill_context);
        halted(context)?;
        if let Some(lead) = &mut lead {
            lead.manifest = manifest.borrow().clone();
        }
        barrier(worker);
        if context.plan.has(Stage::Graph) {
            worked |= graph(worker, &mut lead, &key, &mill_context, context)?;
        }
        let frames = mill_context.catalog.iter().flat_map(Catalog::clips).map(|row| u64::from(row.frames)).sum();
        report.dataflows.push(("cluster", frames, start.elapsed()));
    }
    halted(context)?;

    // Enrich.
    if context.plan.has(Stage::Make) {
        let start = Instant::now();
        let mut shards = Vec::new();
        let mut recipes = Vec::new();
        if let Some(lead) = &mut lead {
            let choosing = Instant::now();
            context.gauges.begin("recipes", 0);
            let no_derivatives: BTreeSet<String> = no_derivatives(&context.plan, &lead.manifest);
            let (keys, filter) = (context.plan.keys(), context.plan.filter(Stage::Recipes));
            (recipes, shards) = context
                .pool
                .install(|| plan_enrichment(&keys, &filter, &no_derivatives, &mut lead.manifest, &mill_context))?;
            context.gauges.spent(Station::Recipes, choosing.elapsed());
            worked |= !shards.is_empty();
            context.gauges.begin("enrich", shards.iter().map(|shard| shard.clips.len() as u64).sum());
        }
        let any = !shards.is_empty();
        let landed = mill(worker, shards, &mill_context);
        report.dataflows.push(("enrich", landed.frames, start.elapsed()));
        halted(context)?;
        if let Some(lead) = &mut lead
            && any
        {
            let made = write_made_table(&recipes, &mill_context)?;
            lead.manifest.note_files([made]);
            fold(lead, context, true)?;
        }
        barrier(worker);
        halted(context)?;
    }
    if let Some(lead) = lead {
        let Prepared { found, bytes, finished, to_read, gone, .. } = lead.prepared;
        let quarantined = lead
            .manifest
            .sources
            .values()
            .flat_map(|source| source.clips.values())
            .filter(|clip| clip.state == crate::corpus::ClipState::Quarantined)
            .count();
        report =
            RunReport { found, bytes, finished, parsed: to_read, gone, quarantined, up_to_date: !worked, ..report };
    }
    Ok(report)
}

/// Cuts, counts and writes the graph, unless its key says that it is there. Answers whether it did.
fn graph(
    worker: &mut Worker,
    lead: &mut Option<Head>,
    tree_key: &str,
    mill: &MillContext,
    context: &Context,
) -> Result<bool, RunError> {
    const KEY: &str = "graph";
    let key = format!("{}/{tree_key}", context.plan.keys().graph);
    let wanted = lead.as_ref().is_some_and(|lead| lead.manifest.stages.get(KEY) != Some(&key));
    if wanted {
        context.gauges.begin("graph", 0);
    }
    let tables = make_graph(worker, wanted, mill);
    let tables = match tables {
        Ok(tables) => tables,
        Err(error) => {
            context.flag.halt(Halt::Fatal(error.to_string()));
            return Err(error.into());
        }
    };
    if let (Some(lead), Some(tables)) = (lead, tables) {
        lead.manifest.note_files(write_graph(&tables, mill)?);
        lead.manifest.stages.insert(KEY.to_owned(), key);
        lead.manifest.put(&context.store)?;
    }
    Ok(wanted)
}

/// Folds the records into the tables over all shards, and puts the manifest.
fn fold(lead: &mut Head, context: &Context, changed: bool) -> Result<(), RunError> {
    let there = lead.manifest.tables.contains_key(crate::corpus::CLIPS);
    if !changed && there && lead.prepared.gone.is_empty() {
        return Ok(());
    }
    let records = read_records(&context.store)?;
    note_quarantined(&mut lead.manifest, &records);
    let catalog = Catalog::open(&context.store)?;
    let more: &[FaultRow] = &lead.prepared.faults;
    let folded = Folded::gather(&catalog, more);
    let files = folded.write(&context.store, &FileNotes::new())?;
    lead.manifest.note_files(files);
    let rules = context.plan.config.input_rules();
    let terms: Vec<SourceTerms> = lead
        .manifest
        .sources
        .keys()
        .map(|source| {
            let row = folded.clips.iter().find(|row| row.source == *source && !row.origin.is_made());
            let said = rules.resolve(None, source, "");
            SourceTerms {
                source: source.clone(),
                license: row.and_then(|row| row.licenses.first().cloned()).or(said.license),
                attribution: row.and_then(|row| row.attribution.clone()).or(said.attribution),
            }
        })
        .collect();
    lead.manifest.note_files([write_card(&context.store, &folded, &terms)?]);
    lead.manifest.put(&context.store)?;
    Ok(())
}

fn catalog(context: &Context) -> Option<Catalog> {
    Catalog::open(&context.store).ok()
}

/// Sources whose license forbids derivatives.
fn no_derivatives(plan: &Plan, manifest: &Manifest) -> BTreeSet<String> {
    let rules = plan.config.input_rules();
    let forbids = |source: &&String| {
        rules.sources.iter().any(|rule| rule.no_derivatives && rule.label.as_deref() == Some(source.as_str()))
            || rules.source_rule(source).is_some_and(|(_, rule)| rule.no_derivatives)
    };
    manifest.sources.keys().filter(forbids).cloned().collect()
}

fn halted(context: &Context) -> Result<(), RunError> {
    match context.flag.reason() {
        None => Ok(()),
        Some(Halt::Fatal(text)) => Err(RunError::Fatal(text)),
        Some(Halt::Interrupted) => {
            let of = context.gauges.clips_total.load(std::sync::atomic::Ordering::Relaxed) as usize;
            let safe = catalog(context).map_or(0, |catalog| catalog.clips().count());
            Err(RunError::Interrupted { safe, of })
        }
    }
}
