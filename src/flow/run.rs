//! A run: inputs and plan in, a corpus out. Three dataflows one after the other; between them all workers
//! meet, and go on or leave together.

use super::agree::agree;
use super::compact::prepare_stored;
use super::enrich::{MADE_KEY, RECIPES_KEY, plan_enrichment, write_made_table};
use super::gauges::{Gauges, Station};
use super::graph::{make_graph, write_graph};
use super::halt::{Halt, HaltFlag};
use super::memory::{forget_peak, peak_bytes};
use super::mesh::{Hello, Hosts, MeshError, TOKEN_BYTES, connect};
use super::mill::{MillContext, mill};
use super::prepare::{Prepared, note_quarantined, prepare};
use super::settings::RunSettings;
use super::shard_writer::fatal_text;
use super::tree::{TREE, TreePlan, grow_trees, plan_trees, state_key};
use super::work::ShardJob;
use crate::annotate::PlantState;
use crate::corpus::{
    Catalog, CorpusError, EDGES, FileNotes, Folded, MADE, Manifest, NODES, RECIPES, REFERENCE, SEQUENCES, SourceTerms,
    Store, check_token, items_file, merges_file, open_to_run, read_records, read_reference, write_card,
};
use crate::inputs::InputError;
use crate::plan::keys::digest;
use crate::plan::{Plan, Stage};
use crate::synthesis::Recipe;
use crate::synthesis::judge::Reference;
use serde_json::json;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::net::TcpStream;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use timely::communication::Hooks;
use timely::communication::allocator::zero_copy::initialize::initialize_networking_from_sockets;
use timely::communication::allocator::{AllocatorBuilder, ProcessBuilder};
use timely::worker::Worker;
use timely::{CommunicationConfig, WorkerConfig};

/// The graph's key in the manifest.
const GRAPH_KEY: &str = "graph";
/// The key of the tables over all shards.
const FOLD_KEY: &str = "fold";

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
    /// Clips whose files have gone are removed.
    pub prune: bool,
    /// A corpus whose stored clips are taken in place of inputs.
    pub from: Option<PathBuf>,
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
    /// Sources that none of the known clips of is as it was.
    pub replaced: Vec<String>,
    /// Each dataflow, in order.
    pub dataflows: Vec<Dataflow>,
}

/// What a dataflow took.
#[derive(Clone, Copy, Debug)]
pub struct Dataflow {
    /// `clips`, `cluster` or `enrich`.
    pub name: &'static str,
    /// Frames that went through it.
    pub frames: u64,
    /// Wall time.
    pub time: Duration,
    /// Largest resident memory of this process meanwhile, where the system tells.
    pub peak_bytes: Option<u64>,
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
    #[error(
        "{}: process 0 ({address}) is at work in another corpus\n  why: all processes of a run write one corpus\n  try: --out with the same folder everywhere, on a disk that all of them see",
        out.display()
    )]
    OtherCorpus { out: PathBuf, address: String },
    #[error(
        "{}: it does not say how it was made\n  why: a corpus is made anew by the plan of its last run, and this program can't read the one that it has\n  try: the run's command once more, then compact",
        corpus.display()
    )]
    NoPlan { corpus: PathBuf },
    #[error("{0}")]
    Fatal(String),
    #[error("interrupted")]
    Interrupted { safe: usize, of: usize },
}

/// What process 0 has and the others have not.
#[derive(Default)]
struct Head {
    manifest: Manifest,
    prepared: Prepared,
    /// Whether anything had to be done.
    worked: bool,
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
    let settings = RunSettings::of(&request.plan);
    gauges.begin("inputs", 0);
    let mut held = if leads { Some(open_to_run(&request.out)?) } else { None };
    let manifest = held.as_mut().map(|corpus| std::mem::take(&mut corpus.manifest));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(request.workers).build();
    let pool = pool.map_err(|error| RunError::Fatal(format!("no threads to work with: {error}")))?;
    let context = Context {
        request: Arc::new(request.clone()),
        settings: Arc::new(settings),
        store: Store::new(&request.out),
        flag: Arc::clone(flag),
        gauges: Arc::clone(gauges),
        pool: Arc::new(pool),
        head: Arc::new(Mutex::new(manifest.map(|manifest| Head { manifest, ..Head::default() }))),
    };
    let token = held.as_ref().map_or("", |corpus| corpus.lock.token());
    let result = execute(context, token, say);
    drop(held);
    result
}

/// What the workers of a process share.
#[derive(Clone)]
struct Context {
    request: Arc<RunRequest>,
    settings: Arc<RunSettings>,
    store: Store,
    flag: Arc<HaltFlag>,
    gauges: Arc<Gauges>,
    pool: Arc<rayon::ThreadPool>,
    /// Taken by worker 0.
    head: Arc<Mutex<Option<Head>>>,
}

fn execute(context: Context, token: &str, say: impl FnMut(&str)) -> Result<RunReport, RunError> {
    let refused = |error: String| RunError::Fatal(format!("the workers could not be started: {error}"));
    let request = Arc::clone(&context.request);
    let guards = match &request.hosts {
        None => {
            let config = timely::Config {
                communication: CommunicationConfig::Process(request.workers),
                worker: WorkerConfig::default(),
            };
            timely::execute(config, move |worker: &mut Worker| work(worker, &context)).map_err(refused)?
        }
        Some(hosts) => {
            let sockets = meet(hosts, token, &context, say)?;
            let hooks = Hooks::default();
            let processes =
                ProcessBuilder::new_typed_vector(request.workers, hooks.refill.clone(), hooks.spill.clone());
            let (builders, guard) =
                initialize_networking_from_sockets(processes, sockets, hosts.process, request.workers, hooks)
                    .map_err(|error| refused(error.to_string()))?;
            let builders = builders.into_iter().map(AllocatorBuilder::Tcp).collect();
            let work = move |worker: &mut Worker| work(worker, &context);
            timely::execute::execute_from(builders, Box::new(guard), WorkerConfig::default(), work).map_err(refused)?
        }
    };
    // All workers end alike; the first one has the report.
    let mut results = guards.join().into_iter();
    let first = results.next().ok_or_else(|| refused("there are none".to_owned()))?.map_err(refused)?;
    results.try_for_each(|result| result.map(drop).map_err(refused))?;
    first
}

/// Sockets to the other processes, once all of them run the same plan on the corpus that process 0 holds.
fn meet(
    hosts: &Hosts,
    token: &str,
    context: &Context,
    say: impl FnMut(&str),
) -> Result<Vec<Option<TcpStream>>, RunError> {
    let request = &context.request;
    let mut hello = Hello {
        process: hosts.process as u64,
        workers: request.workers as u64,
        digest: *blake3::hash(request.plan.digest().as_bytes()).as_bytes(),
        token: [0; TOKEN_BYTES],
    };
    hello.token.iter_mut().zip(token.bytes()).for_each(|(to, byte)| *to = byte);
    let stop = || context.flag.reason().is_some();
    let mesh = match connect(hosts, &hello, stop, say) {
        Err(MeshError::Interrupted) => return Err(stopped(context, Halt::Interrupted)),
        mesh => mesh?,
    };
    if hosts.process > 0 && check_token(&context.store, &String::from_utf8_lossy(&mesh.token)).is_err() {
        return Err(RunError::OtherCorpus { out: request.out.clone(), address: hosts.addresses[0].clone() });
    }
    Ok(mesh.sockets)
}

/// One worker's part of the run.
///
/// Whatever fails on one worker only sets the flag; all leave together, where they agree on it.
fn work(worker: &mut Worker, context: &Context) -> Result<RunReport, RunError> {
    let plan = &context.request.plan;
    let mut lead = if worker.index() == 0 { context.head.lock().ok().and_then(|mut head| head.take()) } else { None };
    let mut report = RunReport::default();

    // Clips.
    let mut shards = Vec::new();
    if let Some(lead) = &mut lead {
        shards = context.attempt(look_at_inputs(lead, context)).unwrap_or_default();
    }
    go_on(worker, context)?;
    let mut mill_context = MillContext {
        store: context.store.clone(),
        settings: Arc::clone(&context.settings),
        flag: Arc::clone(&context.flag),
        gauges: Arc::clone(&context.gauges),
        catalog: context.stored_clips(),
        reference: Arc::default(),
    };
    go_on(worker, context)?;
    let start = Instant::now();
    context.begin(worker, "clips", &shards);
    let landed = mill(worker, shards, &mill_context);
    if lead.is_some() {
        report.note("clips", landed.frames, start);
    }
    go_on(worker, context)?;
    if let Some(lead) = &mut lead {
        context.attempt(fold(lead, context));
    }
    go_on(worker, context)?;

    // Cluster.
    mill_context.catalog = context.catalog();
    go_on(worker, context)?;
    if plan.has(Stage::Tree) {
        let start = Instant::now();
        let key = trees(worker, &mut lead, &mill_context, context)?;
        if plan.has(Stage::Graph) {
            graph(worker, &mut lead, &key, &mill_context, context)?;
        }
        let clips = mill_context.catalog.iter().flat_map(Catalog::clips).filter(|row| !row.origin.is_made());
        let frames = clips.map(|row| u64::from(row.frames)).sum();
        if lead.is_some() {
            report.note("cluster", frames, start);
        }
    }

    // Enrich.
    if plan.has(Stage::Make) {
        let start = Instant::now();
        let (mut shards, mut recipes) = (Vec::new(), Vec::new());
        if let Some(lead) = &mut lead
            && let Some(planned) = context.attempt(choose_recipes(lead, &mill_context, context))
        {
            (recipes, shards) = planned;
        }
        go_on(worker, context)?;
        mill_context.reference = Arc::new(context.reference());
        go_on(worker, context)?;
        context.begin(worker, "enrich", &shards);
        let landed = mill(worker, shards, &mill_context);
        if lead.is_some() {
            report.note("enrich", landed.frames, start);
        }
        go_on(worker, context)?;
        if let Some(lead) = &mut lead {
            let wrote = write_made_table(&recipes, &mut lead.manifest, &mill_context);
            lead.worked |= context.attempt(wrote.map_err(RunError::from)).unwrap_or_default();
            context.attempt(fold(lead, context));
        }
        go_on(worker, context)?;
    }
    Ok(match lead {
        Some(lead) => lead.report(report),
        None => report,
    })
}

impl Context {
    /// What a step of one worker gave; its error becomes the reason for the run to end.
    fn attempt<T>(&self, step: Result<T, RunError>) -> Option<T> {
        step.map_err(|error| self.flag.halt(Halt::Fatal(error.to_string()))).ok()
    }

    /// The corpus as it is now. None: it can't be read, and the run is to end.
    fn catalog(&self) -> Option<Catalog> {
        self.attempt(Catalog::open(&self.store).map_err(RunError::from))
    }

    /// Where the clips dataflow finds stored clips: in this corpus, or in the one that they are taken from.
    fn stored_clips(&self) -> Option<Catalog> {
        let store = self.request.from.as_ref().map_or_else(|| self.store.clone(), Store::new);
        self.attempt(Catalog::open(&store).map_err(RunError::from))
    }

    /// What made clips are judged by; worker 0 has seen to it. Where it can't be read the run is to end.
    fn reference(&self) -> Reference {
        let read = self.attempt(read_reference(&self.store).map_err(RunError::from));
        read.unwrap_or_default().lasting(self.settings.gates.min_reference_s)
    }

    /// Starts the gauges of a dataflow, once a process.
    fn begin(&self, worker: &Worker, phase: &str, shards: &[ShardJob]) {
        if worker.index().is_multiple_of(self.request.workers) {
            self.gauges.begin(phase, shards.iter().map(|shard| shard.clips.len() as u64).sum());
        }
    }
}

impl RunReport {
    /// Notes what a dataflow took since it was started. One worker a process may: it sets the system's mark back.
    fn note(&mut self, name: &'static str, frames: u64, start: Instant) {
        self.dataflows.push(Dataflow { name, frames, time: start.elapsed(), peak_bytes: peak_bytes() });
        forget_peak();
    }
}

impl Head {
    fn report(self, report: RunReport) -> RunReport {
        let Prepared { found, bytes, finished, to_read, gone, replaced, .. } = self.prepared;
        let up_to_date = !self.worked;
        RunReport { found, bytes, finished, parsed: to_read, gone, replaced, up_to_date, ..report }
    }
}

/// Where all workers meet: they go on together, or end together.
fn go_on(worker: &mut Worker, context: &Context) -> Result<(), RunError> {
    match agree(worker, &context.flag) {
        None => Ok(()),
        Some(halt) => Err(stopped(context, halt)),
    }
}

fn stopped(context: &Context, halt: Halt) -> RunError {
    match halt {
        Halt::Fatal(text) => RunError::Fatal(text),
        Halt::Interrupted => {
            let of = context.gauges.clips_total.load(std::sync::atomic::Ordering::Relaxed) as usize;
            let safe = Catalog::open(&context.store).map_or(0, |catalog| catalog.clips().count());
            RunError::Interrupted { safe, of }
        }
    }
}

/// Compares the inputs with the corpus; what has to be milled.
fn look_at_inputs(lead: &mut Head, context: &Context) -> Result<Vec<ShardJob>, RunError> {
    let RunRequest { plan, inputs, procedural, prune, from, .. } = &*context.request;
    forget_lost(&mut lead.manifest, &context.store);
    note_plan(&mut lead.manifest, plan);
    lead.prepared = match from {
        None => prepare(plan, inputs, *procedural, *prune, &context.store, &mut lead.manifest)?,
        Some(from) => prepare_stored(plan, &Store::new(from), &context.store, &mut lead.manifest)?,
    };
    let shards = std::mem::take(&mut lead.prepared.shards);
    lead.worked |= !shards.is_empty();
    Ok(shards)
}

/// Notes by which plan the corpus is made. A shorter pipeline with the same settings takes nothing back.
fn note_plan(manifest: &mut Manifest, plan: &Plan) {
    let covers =
        |known: Plan| known.config == plan.config && plan.stages.iter().all(|planned| known.stages.contains(planned));
    if !noted_plan(manifest).is_some_and(covers) {
        manifest.plan = json!(plan);
    }
}

/// The plan that a corpus was made by, if a program of this version can tell.
pub fn noted_plan(manifest: &Manifest) -> Option<Plan> {
    serde_json::from_value(manifest.plan.clone()).ok()
}

/// Forgets files that are not there any more, or not as they were written, with the keys of their stages: they are made
/// anew.
fn forget_lost(manifest: &mut Manifest, store: &Store) {
    let lost: Vec<String> = manifest.changed_tables(store);
    for file in lost {
        // Of a grown corpus it can't be made as it was: where it is damaged, the user decides.
        if file == REFERENCE && store.is_there(REFERENCE) {
            continue;
        }
        let state = PlantState::ALL
            .into_iter()
            .find(|&state| [items_file(TREE, state), merges_file(TREE, state)].contains(&file));
        let stage = match (state, file.as_str()) {
            (Some(state), _) => state_key(state),
            (None, NODES | SEQUENCES | EDGES) => GRAPH_KEY.to_owned(),
            // Drawn in one pass with what recipes are chosen by.
            (None, RECIPES | REFERENCE) => RECIPES_KEY.to_owned(),
            (None, MADE) => MADE_KEY.to_owned(),
            (None, _) => FOLD_KEY.to_owned(),
        };
        if file == REFERENCE {
            manifest.reference = None;
        }
        manifest.tables.remove(&file);
        manifest.stages.remove(&stage);
    }
}

/// Grows the trees that are not there. The answer is worker 0's: the key of all of them.
fn trees(
    worker: &mut Worker,
    lead: &mut Option<Head>,
    mill: &MillContext,
    context: &Context,
) -> Result<String, RunError> {
    let mut trees = TreePlan::default();
    let manifest = Rc::new(RefCell::new(Manifest::default()));
    if let (Some(lead), Some(catalog)) = (&mut *lead, &mill.catalog) {
        let plan = &context.request.plan;
        trees = plan_trees(&plan.keys().tree, &plan.filter(Stage::Tree), catalog, &lead.manifest);
        lead.worked |= !trees.states.is_empty();
        let keys: Vec<String> = trees.states.iter().map(|&state| state_key(state)).collect();
        let forgotten = lead.manifest.forget(keys.iter().map(String::as_str), &context.store);
        context.attempt(forgotten.map_err(RunError::from));
        *manifest.borrow_mut() = lead.manifest.clone();
    }
    context.begin(worker, "cluster", &trees.tickets);
    let key = trees.key.clone();
    let halt = grow_trees(worker, trees, &manifest, mill);
    if let Some(lead) = lead {
        lead.manifest = manifest.take();
    }
    if let Some(halt) = halt {
        return Err(stopped(context, halt));
    }
    go_on(worker, context)?;
    Ok(key)
}

/// Cuts, counts and writes the graph, unless its key says that it is there.
fn graph(
    worker: &mut Worker,
    lead: &mut Option<Head>,
    tree_key: &str,
    mill: &MillContext,
    context: &Context,
) -> Result<(), RunError> {
    let key = format!("{}/{tree_key}", context.request.plan.keys().graph);
    let wanted = lead.as_ref().is_some_and(|lead| lead.manifest.stages.get(GRAPH_KEY) != Some(&key));
    if wanted {
        context.gauges.begin("graph", 0);
    }
    let tables = make_graph(worker, wanted, mill);
    if let (Some(lead), Some(tables)) = (lead, tables) {
        lead.worked = true;
        let write = || {
            lead.manifest.forget([GRAPH_KEY], &context.store)?;
            lead.manifest.note_files(write_graph(&tables, mill)?);
            lead.manifest.stages.insert(GRAPH_KEY.to_owned(), key);
            Ok(lead.manifest.put(&context.store)?)
        };
        context.attempt(write());
    }
    go_on(worker, context)
}

/// The recipes, and those of their shards that have to be made.
fn choose_recipes(
    lead: &mut Head,
    mill: &MillContext,
    context: &Context,
) -> Result<(Vec<Recipe>, Vec<ShardJob>), RunError> {
    let start = Instant::now();
    let plan = &context.request.plan;
    context.gauges.begin("recipes", 0);
    let no_derivatives = no_derivatives(plan, &lead.manifest);
    let (keys, filter) = (plan.keys(), plan.filter(Stage::Recipes));
    let planned =
        context.pool.install(|| plan_enrichment(&keys, &filter, &no_derivatives, &mut lead.manifest, mill))?;
    context.gauges.spent(Station::Recipes, start.elapsed());
    lead.worked |= !planned.1.is_empty();
    Ok(planned)
}

/// Folds the records into the tables over all shards, and puts the manifest; unless these records have been folded.
fn fold(lead: &mut Head, context: &Context) -> Result<(), RunError> {
    let records = read_records(&context.store)?;
    note_quarantined(&mut lead.manifest, &records);
    let catalog = Catalog::open(&context.store)?;
    let folded = Folded::gather(&catalog, &lead.prepared.faults);
    let rules = context.request.plan.config.input_rules();
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
    let said: Vec<_> = terms.iter().map(|terms| (&terms.source, &terms.license, &terms.attribution)).collect();
    let key = digest(&json!([folded.clips, folded.skeletons, folded.faults, said]));
    if lead.manifest.stages.get(FOLD_KEY) != Some(&key) {
        lead.worked = true;
        lead.manifest.forget([FOLD_KEY], &context.store)?;
        lead.manifest.note_files(folded.write(&context.store, &FileNotes::new())?);
        lead.manifest.note_files([write_card(&context.store, &folded, &terms)?]);
        lead.manifest.stages.insert(FOLD_KEY.to_owned(), key);
    }
    Ok(lead.manifest.put(&context.store)?)
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
