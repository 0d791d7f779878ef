//! The promises of a run (DESIGN 3, 4, 5): the same bytes however it is run, killed, interrupted or grown; and an end with
//! one message where it can't go on, never a wait for ever. Every child has a deadline.

use crate::shared_data::captures;
use motionmill::corpus::{Catalog, ClipRow, Store, open_to_read};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A child that runs longer hangs.
const DEADLINE: Duration = Duration::from_secs(120);
/// Small shards and few recipes: many commits in little time.
const SMALL: [&str; 4] = ["--set", "shards.text_bytes=200000", "--set", "recipes.select=48"];

/// A process of the program, and what it says meanwhile.
struct Running {
    child: Child,
    out: JoinHandle<String>,
    err: JoinHandle<String>,
    since: Instant,
    command: String,
}

/// How one ended.
#[derive(Debug)]
struct Ended {
    code: Option<i32>,
    out: String,
    err: String,
    took: Duration,
    command: String,
}

impl Running {
    fn start(args: &[&str]) -> Running {
        let mut command = Command::new(env!("CARGO_BIN_EXE_motionmill"));
        command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (out, err) = (hear(child.stdout.take().unwrap()), hear(child.stderr.take().unwrap()));
        Running { child, out, err, since: Instant::now(), command: args.join(" ") }
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([name, &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success() || cfg!(not(unix)));
    }

    fn end(mut self) -> Ended {
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            if self.since.elapsed() > DEADLINE {
                self.child.kill().unwrap();
                panic!("hangs: motionmill {}\n{}", self.command, self.err.join().unwrap());
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let (out, err) = (self.out.join().unwrap(), self.err.join().unwrap());
        Ended { code: status.code(), out, err, took: self.since.elapsed(), command: self.command }
    }
}

impl Ended {
    #[track_caller]
    fn with(self, code: i32) -> Ended {
        assert_eq!(self.code, Some(code), "motionmill {}\n{}{}", self.command, self.out, self.err);
        self
    }

    /// Exit 1 and one message, which has these words.
    #[track_caller]
    fn fails_with(self, words: &str) -> Ended {
        let ended = self.with(1);
        assert_eq!(ended.err.matches("error: ").count(), 1, "{}", ended.err);
        assert!(ended.err.contains(words), "{}", ended.err);
        ended
    }

    fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap()
    }

    /// `parsed` of a run that succeeded.
    fn parsed(&self) -> u64 {
        self.json()["parsed"].as_u64().unwrap()
    }
}

fn hear(mut from: impl Read + Send + 'static) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = from.read_to_end(&mut text);
        String::from_utf8_lossy(&text).into_owned()
    })
}

fn start(pipeline: &str, inputs: &[&Path], out: &Path, more: &[&str]) -> Running {
    let mut args = vec!["run", pipeline, "--json", "--out", out.to_str().unwrap()];
    inputs.iter().for_each(|input| args.extend(["--input", input.to_str().unwrap()]));
    args.extend(SMALL);
    args.extend(more);
    Running::start(&args)
}

fn run(pipeline: &str, inputs: &[&Path], out: &Path, more: &[&str]) -> Ended {
    start(pipeline, inputs, out, more).end()
}

/// Two processes of one worker over loopback; `more` is what each is told beside.
fn start_two(folder: &Path, pipeline: &str, inputs: &[&Path], out: &Path, more: [&[&str]; 2]) -> [Running; 2] {
    let listeners = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").unwrap());
    let ports: Vec<String> = listeners.iter().map(|l| l.local_addr().unwrap().to_string()).collect();
    drop(listeners);
    let hosts = folder.join("hosts");
    fs::write(&hosts, ports.join("\n")).unwrap();
    [0, 1].map(|process| {
        let own = process.to_string();
        let mut args = vec!["--hosts", hosts.to_str().unwrap(), "--process", &own, "-w", "1"];
        args.extend(more[process]);
        start(pipeline, inputs, out, &args)
    })
}

/// Captures and a corpus of them that was made in one go by one worker; made once.
struct Reference {
    folder: TempDir,
    files: BTreeMap<String, String>,
    took: Duration,
}

impl Reference {
    fn get() -> &'static Reference {
        static REFERENCE: OnceLock<Reference> = OnceLock::new();
        REFERENCE.get_or_init(|| {
            let folder = tempfile::tempdir().unwrap();
            synth(&folder.path().join("a"), 7, 3, "amc");
            synth(&folder.path().join("b"), 5, 4, "bvh");
            let out = folder.path().join("corpus");
            let inputs = [folder.path().join("a"), folder.path().join("b")];
            let ended = run("enrich", &[&inputs[0], &inputs[1]], &out, &["-w", "1"]).with(0);
            let files = digests(&out);
            let many = |folder: &str| files.keys().filter(|name| name.starts_with(folder)).count();
            assert!(many("commits/shard-") >= 8 && many("commits/made-") >= 2 && many("merges/") >= 3, "{files:#?}");
            Reference { folder, files, took: ended.took }
        })
    }

    fn inputs(&self) -> [PathBuf; 2] {
        ["a", "b"].map(|name| self.folder.path().join(name))
    }

    #[track_caller]
    fn equals(&self, out: &Path, what: &str) {
        same(&self.files, &digests(out), what);
    }
}

fn synth(out: &Path, clips: usize, seed: u64, format: &str) {
    let (clips, seed) = (clips.to_string(), seed.to_string());
    let args = ["synth", "--clips", &clips, "--seed", &seed, "--format", format, "--out", out.to_str().unwrap()];
    Running::start(&args).end().with(0);
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { files.extend(files_below(&path)) } else { files.push(path) }
    }
    files.sort();
    files
}

/// Digest of every file of a corpus but its lock.
fn digests(corpus: &Path) -> BTreeMap<String, String> {
    let name = |path: &Path| path.strip_prefix(corpus).unwrap().to_str().unwrap().to_owned();
    let files = files_below(corpus).into_iter().map(|path| (name(&path), fs::read(&path).unwrap()));
    files.filter(|(name, _)| name != ".lock").map(|(name, bytes)| (name, blake3::hash(&bytes).to_string())).collect()
}

#[track_caller]
fn same(expected: &BTreeMap<String, String>, found: &BTreeMap<String, String>, what: &str) {
    let names = expected.keys().chain(found.keys());
    let differ: Vec<&String> = names.filter(|name| expected.get(*name) != found.get(*name)).collect();
    assert!(differ.is_empty(), "{what}: these differ: {differ:?}");
}

fn copy(from: &Path, to: &Path) {
    for file in files_below(from) {
        let there = to.join(file.strip_prefix(from).unwrap());
        fs::create_dir_all(there.parent().unwrap()).unwrap();
        fs::copy(&file, &there).unwrap();
    }
}

/// Numbers in [0, 1) from a seed.
fn draws(mut seed: u64) -> impl Iterator<Item = f64> {
    std::iter::repeat_with(move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    })
}

#[test]
fn the_same_bytes_for_any_number_of_workers_and_processes_and_order_of_inputs() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    run("enrich", &[a, b], &out("two"), &["-w", "2"]).with(0);
    reference.equals(&out("two"), "2 workers");
    run("enrich", &[b, a], &out("four"), &["-w", "4"]).with(0);
    reference.equals(&out("four"), "4 workers, inputs in the other order");
    for process in start_two(folder.path(), "enrich", &[b, a], &out("hosts"), [&[], &[]]) {
        process.end().with(0);
    }
    reference.equals(&out("hosts"), "2 processes");
}

#[test]
fn killed_at_any_instant_a_run_continues_to_the_same_bytes() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let seed = 20;
    for (n, draw) in draws(seed).take(6).enumerate() {
        let out = folder.path().join(n.to_string());
        // Some are killed twice: the second time while they pick up what the first left.
        for kill in 0..1 + n % 2 {
            let running = start("enrich", &[a, b], &out, &["-w", if n % 3 == 0 { "1" } else { "2" }]);
            std::thread::sleep(reference.took.mul_f64((n as f64 + draw) / 6.0 / (1 + kill) as f64));
            running.signal("-KILL");
            running.end();
        }
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("kill {n} of seed {seed}"));
    }
}

#[test]
fn interrupted_a_run_says_what_is_safe_and_continues_to_the_same_bytes() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let seed = 5;
    let mut interrupted = 0;
    for (n, draw) in draws(seed).take(4).enumerate() {
        let out = folder.path().join(n.to_string());
        let running = start("enrich", &[a, b], &out, &["-w", "2"]);
        std::thread::sleep(Duration::from_millis(60) + reference.took.mul_f64((n as f64 + draw) / 6.0));
        running.signal("-INT");
        let ended = running.end();
        if ended.code == Some(130) {
            interrupted += 1;
            let last = ended.err.lines().last().unwrap_or_default();
            let safe = format!("safe in {}; the same command continues", out.display());
            assert!(last.starts_with("interrupted: ") && last.ends_with(&safe), "{}", ended.err);
            let left: Vec<String> = digests(&out).into_keys().filter(|name| !is_whole(name)).collect();
            assert!(left.is_empty(), "left by interrupt {n}: {left:?}");
        } else {
            ended.with(0);
        }
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("interrupt {n} of seed {seed}"));
    }
    assert!(interrupted >= 2, "the machine was too fast for {} of 4", 4 - interrupted);
}

fn is_whole(name: &str) -> bool {
    !name.ends_with(".partial") && name != ".run"
}

#[test]
fn an_interrupt_of_one_process_ends_both() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    for victim in [0, 1] {
        let out = folder.path().join(victim.to_string());
        let running = start_two(folder.path(), "enrich", &[a, b], &out, [&[], &[]]);
        std::thread::sleep(reference.took / 4);
        running[victim].signal("-INT");
        for process in running {
            assert!(process.end().with(130).err.contains("safe in"));
        }
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("after an interrupt of process {victim}"));
    }
}

#[test]
fn a_process_that_is_lost_ends_the_other_with_one_message() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    for (victim, part) in [(0, 0.2), (1, 0.3), (1, 0.7)] {
        let out = folder.path().join(format!("{victim}-{part}"));
        let mut running = start_two(folder.path(), "enrich", &[a, b], &out, [&[], &[]]);
        std::thread::sleep(Duration::from_millis(200) + reference.took.mul_f64(part * 0.5));
        running[victim].child.kill().unwrap();
        let killed = Instant::now();
        let [first, second] = running;
        let other = if victim == 0 { second } else { first };
        other.end().fails_with("another process of this run was lost");
        assert!(killed.elapsed() < Duration::from_secs(10), "the other took {:?}", killed.elapsed());
        run("enrich", &[a, b], &out, &["-w", "1"]).with(0);
        reference.equals(&out, &format!("after the loss of process {victim}"));
    }
}

#[test]
fn processes_that_do_not_belong_together_refuse_each_other() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    let more: [&[&str]; 2] = [&[], &["--set", "cluster.t_max_m2=0.4"]];
    for process in start_two(folder.path(), "enrich", &[a, b], &out, more) {
        process.end().fails_with("runs another plan");
    }
    let elsewhere = folder.path().join("elsewhere");
    let [first, second] = start_two(folder.path(), "enrich", &[a, b], &out, [&[], &[]]);
    second.signal("-KILL");
    second.end();
    first.signal("-INT");
    first.end().with(130);
    let hosts = folder.path().join("hosts");
    let told = |process| ["--hosts", hosts.to_str().unwrap(), "--process", process, "-w", "1"];
    let first = start("enrich", &[a, b], &out, &told("0"));
    let second = start("enrich", &[a, b], &elsewhere, &told("1"));
    second.end().fails_with("is at work in another corpus");
    first.end().fails_with("another process of this run was lost");
    assert!(!elsewhere.exists());
    let mut late = told("0").to_vec();
    late.extend(["--hosts-deadline-s", "1"]);
    run("enrich", &[a, b], &out, &late).fails_with("after 1 s these processes have not connected: 1 (127.0.0.1:");
}

#[test]
fn a_second_run_in_a_corpus_is_told_so() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    let _lock = motionmill::corpus::RunLock::acquire(&Store::new(&out)).unwrap();
    let ended =
        run("enrich", &[a, b], &out, &["-w", "2"]).fails_with("another run is at work in this corpus (process ");
    assert!(ended.took < Duration::from_secs(20), "{:?}", ended.took);
    assert_eq!(digests(&out).into_keys().collect::<Vec<_>>(), [".run"]);
}

/// What fails on worker 0 alone, between two dataflows or in them, reaches all workers of all processes.
#[test]
fn what_one_worker_can_not_do_ends_the_run_everywhere() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let all_end = |out: &Path, more: &[&str], words: &str| {
        let mut with_workers = more.to_vec();
        with_workers.extend(["-w", "3"]);
        run("enrich", &[a, b], out, &with_workers).fails_with(words);
        for process in start_two(folder.path(), "enrich", &[a, b], out, [more, more]) {
            process.end().fails_with(words);
        }
    };
    // Reading a tree for the graph.
    let graph = folder.path().join("graph");
    copy(&reference.folder.path().join("corpus"), &graph);
    let merges = files_below(&graph.join("merges")).remove(0);
    fs::write(&merges, "not a table").unwrap();
    all_end(&graph, &["--set", "graph.thresholds_m2=[0.2]"], "damaged");
    fs::remove_file(&merges).unwrap();
    run("enrich", &[a, b], &graph, &["-w", "2"]).with(0);
    reference.equals(&graph, "after the damaged tree was deleted");
    // Choosing recipes.
    let recipes = folder.path().join("recipes");
    copy(&reference.folder.path().join("corpus"), &recipes);
    fs::write(recipes.join("recipes.parquet"), "not a table").unwrap();
    all_end(&recipes, &[], "recipes.parquet: damaged");
    // Writing a shard, folding: a file where a folder should be, and a folder where a file should be.
    for (name, is_folder) in [("poses", false), ("merges", false), ("clips.parquet", true), ("made.parquet", true)] {
        let blocked = folder.path().join(format!("blocked-{name}"));
        fs::create_dir_all(&blocked).unwrap();
        fs::write(blocked.join(".lock"), "").unwrap();
        let obstacle = blocked.join(name);
        if is_folder {
            fs::create_dir_all(obstacle.join("in the way")).unwrap();
        } else {
            fs::write(&obstacle, "").unwrap();
        }
        all_end(&blocked, &[], name);
        if is_folder {
            fs::remove_dir_all(&obstacle).unwrap();
        } else {
            fs::remove_file(&obstacle).unwrap();
        }
        run("enrich", &[a, b], &blocked, &["-w", "2"]).with(0);
        reference.equals(&blocked, &format!("after {name} was out of the way"));
    }
}

#[test]
fn a_run_on_a_finished_corpus_changes_no_file() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    copy(&reference.folder.path().join("corpus"), &out);
    let times = || -> Vec<_> {
        let files = files_below(&out).into_iter().filter(|path| !path.ends_with(".lock"));
        files.map(|path| (fs::metadata(&path).unwrap().modified().unwrap(), path)).collect()
    };
    let before = times();
    let ended = run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
    assert_eq!((ended.parsed(), &ended.json()["up_to_date"]), (0, &Value::Bool(true)));
    assert_eq!(times(), before);
    let words = ["run", "enrich", "--out", out.to_str().unwrap(), "--input", a.to_str().unwrap()];
    let said = Running::start(&[&words[..], &["--input", b.to_str().unwrap()], &SMALL[..]].concat()).end().with(0);
    assert_eq!(said.out, "corpus is up to date (12 clips); nothing to do\n");
    // Files that somebody deleted are made anew, and no others.
    for name in ["clips.parquet", "edges.parquet", "recipes.parquet", "made.parquet", "README.md"] {
        fs::remove_file(out.join(name)).unwrap();
    }
    for folder in ["merges", "features", "channels"] {
        fs::remove_file(files_below(&out.join(folder)).remove(0)).unwrap();
    }
    run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
    reference.equals(&out, "after files were deleted");
}

#[test]
fn another_threshold_makes_the_labels_anew_without_parsing() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (out, fresh) = (folder.path().join("out"), folder.path().join("fresh"));
    let threshold = ["-w", "2", "--set", "contacts.thesis.max_speed_mps=0.8"];
    run("graph", &[a, b], &out, &["-w", "2"]).with(0);
    let before = digests(&out);
    // A kill between: the files of one threshold must not pass for those of the other.
    let running = start("graph", &[a, b], &out, &threshold);
    std::thread::sleep(reference.took / 6);
    running.signal("-KILL");
    running.end();
    assert_eq!(run("graph", &[a, b], &out, &["-w", "2"]).with(0).parsed(), 0);
    same(&before, &digests(&out), "back at the first threshold");
    assert_eq!(run("graph", &[a, b], &out, &threshold).with(0).parsed(), 0);
    assert_eq!(run("graph", &[a, b], &fresh, &threshold).with(0).parsed(), 12);
    same(&digests(&fresh), &digests(&out), "another threshold");
    assert_ne!(digests(&out), before);
}

#[test]
fn a_kill_after_the_last_shard_does_not_leave_old_tables_behind() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    run("annotate", &[a], &out, &["-w", "1"]).with(0);
    let old = fs::read(out.join("clips.parquet")).unwrap();
    let given = || open_to_read(&out).unwrap().1.next_shard;
    let shards = || fs::read_dir(out.join("commits")).unwrap().count() as u32;
    let first = given();
    let running = start("annotate", &[a, b], &out, &["-w", "1"]);
    // Stopped the moment that all shards are there: before, in or after the fold.
    while (given() == first || shards() < given()) && running.since.elapsed() < DEADLINE / 2 {
        std::thread::sleep(Duration::from_millis(1));
    }
    running.signal("-KILL");
    running.end();
    run("annotate", &[a, b], &out, &["-w", "1"]).with(0);
    assert_ne!(fs::read(out.join("clips.parquet")).unwrap(), old);
    let rows = rows(&out);
    assert_eq!(rows.len(), 12, "{:?}", rows.keys());
}

/// Rows by full name, but for numbers that depend on history.
fn rows(corpus: &Path) -> BTreeMap<String, ClipRow> {
    let (store, _) = open_to_read(corpus).unwrap();
    let clips = motionmill::corpus::read_clips(&store).unwrap();
    clips.into_iter().map(|row| (row.full_name(), ClipRow { clip_id: 0, ..row })).collect()
}

#[test]
fn a_grown_corpus_holds_the_rows_of_a_fresh_one() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out, fresh) = (folder.path().join("a"), folder.path().join("out"), folder.path().join("fresh"));
    copy(a, &input);
    let later: Vec<PathBuf> = files_below(&input)
        .into_iter()
        .filter(|path| path.extension().is_some_and(|e| e == "amc"))
        .step_by(2)
        .collect();
    let aside = folder.path().join("aside");
    fs::create_dir(&aside).unwrap();
    for (n, file) in later.iter().enumerate() {
        fs::rename(file, aside.join(n.to_string())).unwrap();
    }
    let first = run("annotate", &[&input], &out, &["-w", "2"]).with(0);
    assert_eq!(first.parsed(), 7 - later.len() as u64);
    for (n, file) in later.iter().enumerate() {
        fs::rename(aside.join(n.to_string()), file).unwrap();
    }
    assert_eq!(run("annotate", &[&input, b], &out, &["-w", "2"]).with(0).parsed(), 5 + later.len() as u64);
    run("annotate", &[&input, b], &fresh, &["-w", "2"]).with(0);
    assert_eq!(rows(&out), rows(&fresh));
    let [grown, fresh] = [&out, &fresh].map(|corpus| Catalog::open(&Store::new(corpus)).unwrap());
    for row in fresh.clips() {
        let twin = grown.clips().find(|twin| twin.full_name() == row.full_name()).unwrap();
        let (here, there) = (fresh.shard_of(row.clip_id).unwrap(), grown.shard_of(twin.clip_id).unwrap());
        let name = row.full_name();
        assert_eq!(here.channels(row.clip_id).unwrap(), there.channels(twin.clip_id).unwrap(), "{name}");
        assert_eq!(here.labels(row.clip_id).unwrap(), there.labels(twin.clip_id).unwrap(), "{name}");
        assert_eq!(here.plants(row.clip_id).unwrap(), there.plants(twin.clip_id).unwrap(), "{name}");
        assert_eq!(here.features(row.clip_id).unwrap().values, there.features(twin.clip_id).unwrap().values, "{name}");
    }
}

#[test]
fn a_changed_clip_is_read_again_and_a_gone_one_stays_until_it_is_pruned() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("b"), folder.path().join("corpus"));
    copy(b, &input);
    let clips: Vec<PathBuf> =
        files_below(&input).into_iter().filter(|path| path.extension().is_some_and(|e| e == "bvh")).collect();
    // One shard for all: what happens to one clip happens to its neighbors' shard.
    let whole = ["-w", "2", "--set", "shards.text_bytes=100000000"];
    run("annotate", &[a, &input], &out, &whole).with(0);
    let old = rows(&out);
    let text = fs::read_to_string(&clips[0]).unwrap();
    let frames = text.lines().find_map(|line| line.strip_prefix("Frames:")).unwrap().trim().to_owned();
    let fewer = (frames.parse::<u32>().unwrap() - 1).to_string();
    let without_last = text.trim_end().rsplit_once('\n').unwrap().0;
    let header = format!("Frames: {frames}");
    assert!(without_last.contains(&header));
    fs::write(&clips[0], without_last.replacen(&header, &format!("Frames: {fewer}"), 1) + "\n").unwrap();
    fs::remove_file(&clips[1]).unwrap();
    // The source of the other clips in the shard is not even named this time.
    let ended = run("annotate", &[&input], &out, &whole).with(0);
    assert_eq!(ended.parsed(), 4, "the changed clip and its neighbors that are there");
    assert_eq!(ended.json()["gone"].as_array().unwrap().len(), 1);
    assert!(ended.err.contains("its file has gone; its rows stay (--prune removes them)"), "{}", ended.err);
    let now = rows(&out);
    assert_eq!(old.keys().collect::<Vec<_>>(), now.keys().collect::<Vec<_>>());
    let differ: Vec<u32> = old.iter().filter(|(name, row)| now[*name] != **row).map(|(_, row)| row.frames).collect();
    assert_eq!(differ, [frames.parse::<u32>().unwrap()], "one clip has changed, by a frame");
    assert_eq!(run("annotate", &[a, &input], &out, &whole).with(0).json()["gone"].as_array().unwrap().len(), 1);
    let pruned = run("annotate", &[a, &input], &out, &[&whole[..], &["--prune"]].concat()).with(0);
    assert_eq!(pruned.json()["gone"].as_array().unwrap().len(), 1);
    assert_eq!(rows(&out).len(), 11);
    let again = run("annotate", &[a, &input], &out, &whole).with(0);
    assert_eq!(again.json()["up_to_date"], Value::Bool(true));
}

#[test]
fn a_broken_clip_is_left_out_and_read_again_once_it_is_mended() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out, fresh) = (folder.path().join("b"), folder.path().join("corpus"), folder.path().join("fresh"));
    copy(b, &input);
    let clip = files_below(&input).into_iter().find(|path| path.extension().is_some_and(|e| e == "bvh")).unwrap();
    let text = fs::read_to_string(&clip).unwrap();
    fs::write(&clip, &text[..text.len() / 2]).unwrap();
    // Finite numbers that no position holds.
    let huge = "HIERARCHY\nROOT hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\nJOINT leg\n{\nOFFSET 3e38 3e38 0\nEnd Site\n{\nOFFSET 3e38 3e38 0\n}\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n3e38 3e38 0\n3e38 3e38 0\n";
    fs::write(input.join("huge.bvh"), huge).unwrap();
    for parsed in [13, 0] {
        let ended = run("graph", &[a, &input], &out, &["-w", "2"]).with(3);
        assert_eq!((ended.parsed(), &ended.json()["quarantined"]), (parsed, &Value::from(2)));
    }
    let (store, _) = open_to_read(&out).unwrap();
    let faults = motionmill::corpus::read_faults(&store).unwrap();
    let faulted: Vec<&str> = faults
        .iter()
        .filter(|row| row.notice.severity == motionmill::motion::Severity::Fault)
        .map(|row| row.name.as_str())
        .collect();
    let name = clip.strip_prefix(&input).unwrap().with_extension("");
    assert_eq!(faulted, ["huge", name.to_str().unwrap()]);
    assert_eq!(rows(&out).len(), 11);
    // Another threshold must not bring them back, nor fail on them.
    let threshold = ["-w", "2", "--set", "contacts.thesis.max_speed_mps=0.8"];
    run("graph", &[a, &input], &out, &threshold).with(3);
    assert_eq!(run("graph", &[a, &input], &out, &threshold).with(3).json()["up_to_date"], Value::Bool(true));
    fs::remove_file(input.join("huge.bvh")).unwrap();
    fs::write(&clip, &text).unwrap();
    let mended = run("graph", &[a, &input], &out, &["-w", "2", "--prune"]).with(0);
    assert_eq!(mended.json()["quarantined"], Value::from(0));
    run("graph", &[a, &input], &fresh, &["-w", "2"]).with(0);
    assert_eq!(rows(&out), rows(&fresh));
}

#[test]
fn real_captures_give_the_same_bytes_for_one_worker_two_and_after_a_kill() {
    let Some(data) = captures() else { return };
    let cmu = data.join("cmu/02");
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("02");
    fs::create_dir(&input).unwrap();
    for name in ["02.asf", "02_01.amc", "02_02.amc", "02_03.amc", "02_04.amc"] {
        fs::copy(cmu.join(name), input.join(name)).unwrap();
    }
    let [one, two, killed] = ["one", "two", "killed"].map(|name| folder.path().join(name));
    let first = run("enrich", &[&input], &one, &["-w", "1", "--config", "cmu"]).with(0);
    run("enrich", &[&input], &two, &["-w", "2", "--config", "cmu"]).with(0);
    same(&digests(&one), &digests(&two), "2 workers");
    let running = start("enrich", &[&input], &killed, &["-w", "2", "--config", "cmu"]);
    std::thread::sleep(first.took.mul_f64(0.4));
    running.signal("-KILL");
    running.end();
    run("enrich", &[&input], &killed, &["-w", "2", "--config", "cmu"]).with(0);
    same(&digests(&one), &digests(&killed), "after a kill");
}
