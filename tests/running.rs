//! The program as a child process: started, killed, waited for; and the files that it left.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A child that runs longer hangs.
pub(crate) const DEADLINE: Duration = Duration::from_secs(120);
/// Small shards and few recipes: many commits in little time. A reference of what little there is.
pub(crate) const SMALL: [&str; 6] =
    ["--set", "shards.text_bytes=200000", "--set", "recipes.select=48", "--set", "judge.min_reference_s=10"];

/// A process of the program, and what it says meanwhile.
pub(crate) struct Running {
    pub(crate) child: Child,
    pub(crate) out: JoinHandle<String>,
    pub(crate) err: JoinHandle<String>,
    pub(crate) since: Instant,
    pub(crate) command: String,
}

/// How one ended.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
    pub(crate) took: Duration,
    pub(crate) command: String,
}

impl Running {
    pub(crate) fn start(args: &[&str]) -> Running {
        let mut command = Command::new(env!("CARGO_BIN_EXE_motionmill"));
        command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (out, err) = (hear(child.stdout.take().unwrap()), hear(child.stderr.take().unwrap()));
        Running { child, out, err, since: Instant::now(), command: args.join(" ") }
    }

    pub(crate) fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([name, &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success() || cfg!(not(unix)));
    }

    pub(crate) fn end(mut self) -> Ended {
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
    pub(crate) fn with(self, code: i32) -> Ended {
        assert_eq!(self.code, Some(code), "motionmill {}\n{}{}", self.command, self.out, self.err);
        self
    }

    /// Exit 1 and one message, which has these words.
    #[track_caller]
    pub(crate) fn fails_with(self, words: &str) -> Ended {
        let ended = self.with(1);
        assert_eq!(ended.err.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{}", ended.err);
        assert!(ended.err.contains(words), "{}", ended.err);
        ended
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap()
    }

    /// `parsed` of a run that succeeded.
    pub(crate) fn parsed(&self) -> u64 {
        self.json()["parsed"].as_u64().unwrap()
    }
}

/// What a command said, and its exit code.
pub(crate) struct Said {
    pub(crate) out: String,
    pub(crate) err: String,
    pub(crate) code: i32,
}

/// Runs the program in a folder, and waits for it.
pub(crate) fn mill(folder: &Path, args: &[&str]) -> Said {
    said(Command::new(env!("CARGO_BIN_EXE_motionmill")).current_dir(folder).args(args).output().unwrap())
}

pub(crate) fn said(output: Output) -> Said {
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Said { out: text(output.stdout), err: text(output.stderr), code: output.status.code().unwrap() }
}

pub(crate) fn hear(mut from: impl Read + Send + 'static) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = from.read_to_end(&mut text);
        String::from_utf8_lossy(&text).into_owned()
    })
}

pub(crate) fn start(pipeline: &str, inputs: &[&Path], out: &Path, more: &[&str]) -> Running {
    let mut args = vec!["run", pipeline, "--json", "--out", out.to_str().unwrap()];
    inputs.iter().for_each(|input| args.extend(["--input", input.to_str().unwrap()]));
    args.extend(SMALL);
    args.extend(more);
    Running::start(&args)
}

pub(crate) fn run(pipeline: &str, inputs: &[&Path], out: &Path, more: &[&str]) -> Ended {
    start(pipeline, inputs, out, more).end()
}

/// Two processes of one worker over loopback; `more` is what each is told beside.
pub(crate) fn start_two(
    folder: &Path,
    pipeline: &str,
    inputs: &[&Path],
    out: &Path,
    more: [&[&str]; 2],
) -> [Running; 2] {
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
pub(crate) struct Reference {
    pub(crate) folder: TempDir,
    pub(crate) files: BTreeMap<String, String>,
    pub(crate) took: Duration,
}

impl Reference {
    pub(crate) fn get() -> &'static Reference {
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

    pub(crate) fn inputs(&self) -> [PathBuf; 2] {
        ["a", "b"].map(|name| self.folder.path().join(name))
    }

    #[track_caller]
    pub(crate) fn equals(&self, out: &Path, what: &str) {
        same(&self.files, &digests(out), what);
    }
}

pub(crate) fn synth(out: &Path, clips: usize, seed: u64, format: &str) {
    let (clips, seed) = (clips.to_string(), seed.to_string());
    let args = ["synth", "--clips", &clips, "--seed", &seed, "--format", format, "--out", out.to_str().unwrap()];
    Running::start(&args).end().with(0);
}

pub(crate) fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { files.extend(files_below(&path)) } else { files.push(path) }
    }
    files.sort();
    files
}

/// The first file of a table with captured clips.
pub(crate) fn captured_file(corpus: &Path, table: &str) -> PathBuf {
    let is_captured = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().starts_with("shard-");
    files_below(&corpus.join(table)).into_iter().find(is_captured).unwrap()
}

/// Changes a bit in the middle of a file.
pub(crate) fn flip(file: &Path) {
    let mut bytes = fs::read(file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(file, bytes).unwrap();
}

/// Digest of every file of a corpus but its lock.
pub(crate) fn digests(corpus: &Path) -> BTreeMap<String, String> {
    let name = |path: &Path| path.strip_prefix(corpus).unwrap().to_str().unwrap().to_owned();
    let files = files_below(corpus).into_iter().map(|path| (name(&path), fs::read(&path).unwrap()));
    files.filter(|(name, _)| name != ".lock").map(|(name, bytes)| (name, blake3::hash(&bytes).to_string())).collect()
}

#[track_caller]
pub(crate) fn same(expected: &BTreeMap<String, String>, found: &BTreeMap<String, String>, what: &str) {
    let names = expected.keys().chain(found.keys());
    let differ: Vec<&String> = names.filter(|name| expected.get(*name) != found.get(*name)).collect();
    assert!(differ.is_empty(), "{what}: these differ: {differ:?}");
}

pub(crate) fn copy(from: &Path, to: &Path) {
    for file in files_below(from) {
        let there = to.join(file.strip_prefix(from).unwrap());
        fs::create_dir_all(there.parent().unwrap()).unwrap();
        fs::copy(&file, &there).unwrap();
    }
}

/// Numbers in [0, 1) from a seed.
pub(crate) fn draws(mut seed: u64) -> impl Iterator<Item = f64> {
    std::iter::repeat_with(move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    })
}
