//! `compact`: a grown corpus, made anew from what it holds.

use super::args::Compact;
use super::numbers::{bytes, counted};
use super::output::{Answer, tell};
use super::progress::Progress;
use super::run::{interruptible, workers};
use super::{Ending, give};
use crate::corpus::{Catalog, CorpusError, Store};
use crate::flow::RunError;
use crate::flow::gauges::Gauges;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

/// Runs the verb.
pub(super) fn compact(args: &Compact) -> Ending {
    let name = args.corpus.display().to_string();
    let before = match extent(&args.corpus) {
        Ok(before) => before,
        Err(error) => return give(Err(error.into())),
    };
    let flag = interruptible();
    let gauges = Arc::new(Gauges::default());
    let progress = Progress::show(Arc::clone(&gauges));
    let result = crate::flow::compact(&args.corpus, workers(args.workers), &gauges, &flag);
    drop(progress);
    match result {
        Ok(_) => give(extent(&args.corpus).map_err(Into::into).map(|after| answer(args, &before, &after))),
        Err(RunError::Interrupted { .. }) => {
            tell(&format!("interrupted: {name} is as it was; the same command continues"));
            Ending::Interrupted
        }
        Err(error) => {
            tell(&format!("error: {error}"));
            Ending::Failed
        }
    }
}

/// What shows whether it was worth it.
struct Extent {
    clips: usize,
    shards: usize,
    bytes: u64,
}

fn extent(corpus: &Path) -> Result<Extent, CorpusError> {
    let store = Store::new(corpus);
    let catalog = Catalog::open(&store)?;
    let files = store.list("")?;
    let lengths = files.iter().filter_map(|name| store.path(name).metadata().ok());
    Ok(Extent {
        clips: catalog.clips().count(),
        shards: catalog.records().len(),
        bytes: lengths.map(|file| file.len()).sum(),
    })
}

fn answer(args: &Compact, before: &Extent, after: &Extent) -> Answer {
    let name = args.corpus.display().to_string();
    if args.json {
        let of = |extent: &Extent| json!({"clips": extent.clips, "shards": extent.shards, "bytes": extent.bytes});
        return Answer::json(&json!({"corpus": name, "before": of(before), "after": of(after)}));
    }
    let of = |extent: &Extent| format!("{}, {}", counted(extent.shards as u64, "shard"), bytes(extent.bytes));
    Answer::text(format!("{name}: {}; {}, was {}\n", counted(after.clips as u64, "clip"), of(after), of(before)))
}
