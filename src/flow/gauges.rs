//! What a run has done so far, as atomics that operators bump and one thread of the command line reads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// The stages whose time is kept apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Station {
    Read,
    Parse,
    Kinematics,
    Features,
    Contacts,
    Write,
    Tree,
    Graph,
    Recipes,
    Make,
    Judge,
}

/// Counters of one process.
#[derive(Debug, Default)]
pub struct Gauges {
    /// Clips that the current dataflow has to do.
    pub clips_total: AtomicU64,
    /// Clips written or quarantined.
    pub clips_done: AtomicU64,
    /// Frames written.
    pub frames: AtomicU64,
    /// Bytes of text read.
    pub bytes: AtomicU64,
    /// Shards committed.
    pub shards: AtomicU64,
    /// Clips quarantined.
    pub faults: AtomicU64,
    /// Bumped whenever a stage begins or ends a clip: a sign of life.
    pub beats: AtomicU64,
    nanoseconds: [AtomicU64; Station::COUNT],
    phase: Mutex<String>,
    detail: Mutex<String>,
}

impl Station {
    /// Number of stations.
    pub const COUNT: usize = 11;

    /// All of them, in order.
    pub const ALL: [Station; Station::COUNT] = [
        Station::Read,
        Station::Parse,
        Station::Kinematics,
        Station::Features,
        Station::Contacts,
        Station::Write,
        Station::Tree,
        Station::Graph,
        Station::Recipes,
        Station::Make,
        Station::Judge,
    ];

    /// As users read it.
    pub fn name(self) -> &'static str {
        match self {
            Station::Read => "read",
            Station::Parse => "parse",
            Station::Kinematics => "kinematics",
            Station::Features => "features",
            Station::Contacts => "contacts and gait",
            Station::Write => "write",
            Station::Tree => "tree",
            Station::Graph => "graph",
            Station::Recipes => "recipes",
            Station::Make => "make",
            Station::Judge => "judge",
        }
    }
}

impl Gauges {
    /// Adds time spent at a station.
    pub fn spent(&self, station: Station, time: Duration) {
        self.nanoseconds[station as usize].fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
        self.beats.fetch_add(1, Ordering::Relaxed);
    }

    /// Time spent at a station so far, over all workers of the process.
    pub fn time_at(&self, station: Station) -> Duration {
        Duration::from_nanos(self.nanoseconds[station as usize].load(Ordering::Relaxed))
    }

    /// Starts a dataflow of so many clips: counters of clips go back to zero, times stay.
    pub fn begin(&self, phase: &str, clips: u64) {
        if let Ok(mut name) = self.phase.lock() {
            phase.clone_into(&mut name);
        }
        self.say("");
        self.clips_done.store(0, Ordering::Relaxed);
        self.frames.store(0, Ordering::Relaxed);
        self.bytes.store(0, Ordering::Relaxed);
        self.clips_total.store(clips, Ordering::Relaxed);
    }

    /// What is being done within the dataflow, in words.
    pub fn say(&self, detail: &str) {
        if let Ok(mut words) = self.detail.lock() {
            detail.clone_into(&mut words);
        }
        self.beats.fetch_add(1, Ordering::Relaxed);
    }

    /// Name of the current dataflow; empty before the first.
    pub fn phase(&self) -> String {
        self.phase.lock().map(|name| name.clone()).unwrap_or_default()
    }

    /// The last words of [`say`](Gauges::say).
    pub fn detail(&self) -> String {
        self.detail.lock().map(|words| words.clone()).unwrap_or_default()
    }
}
