//! What travels through the dataflows: shards of jobs, and a clip on its way through the stages.

use crate::annotate::root::RootTrack;
use crate::annotate::{Annotated, Features};
use crate::corpus::{ClipRow, InputFile, ShardId, StageKeys};
use crate::inputs::SourceSettings;
use crate::motion::{Clip, Notice, Poses, RoleMap, Rotations};
use crate::synthesis::{Made, ProvenanceRow, Recipe};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// A fixed list of clips: the unit of work, commit and resume. Travels to whoever mills it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ShardJob {
    pub(crate) shard: ShardId,
    /// Shards that this one takes the place of.
    pub(crate) replaces: Vec<ShardId>,
    pub(crate) todo: Todo,
    /// What the stages' keys are once the shard is done.
    pub(crate) keys: StageKeys,
    /// In clip order.
    pub(crate) clips: Vec<ClipJob>,
}

/// How much of a shard has to be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Todo {
    /// All tables, from text or from recipes.
    Everything,
    /// Some tables, from the stored channels.
    Again {
        /// Features are made anew.
        features: bool,
        /// Contacts, gait and all that rests on them are made anew.
        labels: bool,
    },
    /// Nothing is written: the shard's samples are read for the trees of some plant states (bit n: the n-th).
    Samples { states: u8 },
}

/// One clip of a shard.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ClipJob {
    pub(crate) clip_id: u32,
    pub(crate) source: String,
    pub(crate) name: String,
    pub(crate) origin: ClipOrigin,
}

/// Where a clip's frames come from.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum ClipOrigin {
    /// A file, with its skeleton file if it has one, and what the config says about it.
    File(Box<FileJob>),
    /// The corpus itself: the stored channels.
    Stored,
    /// The corpus too, but another shard of it: the clip's file is not there, and its shard is made anew.
    Kept(Box<KeptJob>),
    /// A recipe, and the clips it is made from.
    Recipe(Box<RecipeJob>),
}

/// A file to read.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct FileJob {
    pub(crate) path: PathBuf,
    pub(crate) asf: Option<PathBuf>,
    pub(crate) blake3: String,
    pub(crate) skeleton_blake3: Option<String>,
    pub(crate) settings: SourceSettings,
    pub(crate) procedural: bool,
}

/// What the corpus has of a clip that can't be read again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct KeptJob {
    /// Its number where its frames are stored.
    pub(crate) stored_as: u32,
    pub(crate) input: InputFile,
    /// None: it is quarantined.
    pub(crate) row: Option<ClipRow>,
    pub(crate) notices: Vec<Notice>,
}

/// A recipe to make.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RecipeJob {
    pub(crate) recipe: Recipe,
    pub(crate) base: u32,
    pub(crate) donor: u32,
}

/// What was read of a file, as long as it is not parsed.
#[derive(Default)]
pub(crate) struct Text {
    pub(crate) motion: Vec<u8>,
    pub(crate) skeleton: Vec<u8>,
}

/// What the file said about itself, beside its frames.
#[derive(Clone, Debug, Default)]
pub(crate) struct FileFacts {
    pub(crate) header: String,
    pub(crate) frame_time_s: Option<f64>,
    pub(crate) max_rounding: f32,
}

/// What making and judging gave.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) made: Made,
    pub(crate) provenance: Vec<ProvenanceRow>,
}

/// A clip on its way: each stage fills in what it makes, and drops what nobody needs any more.
pub(crate) struct Work {
    pub(crate) shard: Arc<ShardJob>,
    /// The worker's n-th shard: the second half of its [`Lane`](super::lane::Lane).
    pub(crate) taken: u64,
    /// Place in the shard.
    pub(crate) index: usize,
    pub(crate) text: Text,
    pub(crate) facts: FileFacts,
    pub(crate) clip: Option<Arc<Clip>>,
    pub(crate) roles: RoleMap,
    pub(crate) notices: Vec<Notice>,
    pub(crate) poses: Option<Poses>,
    pub(crate) rotations: Option<Rotations>,
    pub(crate) root: Option<RootTrack>,
    pub(crate) features: Features,
    pub(crate) annotated: Annotated,
    pub(crate) outcome: Option<Outcome>,
}

/// A clip that goes no further: quarantined, or a recipe that made nothing worth keeping.
pub(crate) struct Faulted {
    pub(crate) shard: Arc<ShardJob>,
    pub(crate) taken: u64,
    pub(crate) index: usize,
    pub(crate) notices: Vec<Notice>,
    pub(crate) made: Option<Made>,
}

/// Why a stage took a clip out.
pub(crate) enum Out {
    /// It can't be used.
    Fault(Notice),
    /// The recipe could not be made, or the judge refused what it made.
    Rejected(Box<Made>),
}

impl From<Notice> for Out {
    fn from(fault: Notice) -> Out {
        Out::Fault(fault)
    }
}

impl Work {
    pub(crate) fn new(shard: Arc<ShardJob>, taken: u64, index: usize) -> Work {
        Work {
            shard,
            taken,
            index,
            text: Text::default(),
            facts: FileFacts::default(),
            clip: None,
            roles: RoleMap::default(),
            notices: Vec::new(),
            poses: None,
            rotations: None,
            root: None,
            features: Features::default(),
            annotated: Annotated::default(),
            outcome: None,
        }
    }

    pub(crate) fn job(&self) -> &ClipJob {
        &self.shard.clips[self.index]
    }

    /// The clip; a bug in the wiring if no stage has made it yet.
    pub(crate) fn clip(&self) -> &Arc<Clip> {
        self.clip.as_ref().expect("the stages that make the clip come before those that use it")
    }

    /// The poses; a bug in the wiring if kinematics did not come before.
    pub(crate) fn poses(&self) -> &Poses {
        self.poses.as_ref().expect("kinematics comes before the stages that use poses")
    }

    pub(crate) fn out(mut self, out: Out) -> Faulted {
        let mut made = None;
        match out {
            Out::Fault(fault) => self.notices.push(fault),
            Out::Rejected(row) => made = Some(*row),
        }
        Faulted { shard: self.shard, taken: self.taken, index: self.index, notices: self.notices, made }
    }
}

#[cfg(test)]
impl ShardJob {
    /// The first shard, with so many stored clips, for tests of operators.
    pub(crate) fn of_stored(n_clips: u32) -> ShardJob {
        let clip = |clip_id| ClipJob {
            clip_id,
            source: "tests".to_owned(),
            name: format!("clip_{clip_id}"),
            origin: ClipOrigin::Stored,
        };
        ShardJob {
            shard: ShardId::captured(0),
            replaces: Vec::new(),
            todo: Todo::Everything,
            keys: StageKeys { ingest: "key".to_owned(), ..StageKeys::default() },
            clips: (0..n_clips).map(clip).collect(),
        }
    }
}
