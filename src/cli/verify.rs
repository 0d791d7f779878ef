//! `verify`: every file of a corpus beside the digest it was written with.

use super::Ending;
use super::args::Verify;
use super::numbers::{bytes, counted, grouped};
use super::output::{Answer, Refusal};
use crate::corpus::{COMMITS, CorpusError, Finding, MANIFEST, Store, Verified, Wrong};
use serde_json::json;

/// Findings of one kind that are shown.
const SHOWN: usize = 20;

/// Runs the verb.
pub(super) fn verify(args: &Verify) -> Result<Answer, Refusal> {
    let store = Store::new(&args.corpus);
    // Without either there is nothing that could have been changed: most likely another folder was meant.
    if !store.is_there(MANIFEST) && !store.path(COMMITS).is_dir() {
        return Err(CorpusError::NotACorpus { path: args.corpus.clone() }.into());
    }
    let verified = crate::corpus::verify(&store)?;
    let name = args.corpus.display().to_string();
    let answer = match args.json {
        true => Answer::json(&json!({
            "corpus": name,
            "files": verified.files,
            "bytes": verified.bytes,
            "findings": verified
                .findings
                .iter()
                .map(|finding| json!({"path": finding.path, "kind": kind(&finding.what), "what": finding.what.to_string()}))
                .collect::<Vec<_>>(),
        })),
        false => Answer::text(text(&name, &verified)),
    };
    Ok(answer.ending(if verified.findings.is_empty() { Ending::Done } else { Ending::Failed }))
}

fn text(name: &str, verified: &Verified) -> String {
    let looked_at = format!("{}, {}", counted(verified.files as u64, "file"), bytes(verified.bytes));
    if verified.findings.is_empty() {
        return format!("{name}: {looked_at}: every one as it was written\n");
    }
    let mut parts = Vec::new();
    let mut findings = verified.findings.iter().collect::<Vec<_>>();
    findings.sort_by_key(|finding| kind(&finding.what));
    for same in findings.chunk_by(|a, b| kind(&a.what) == kind(&b.what)) {
        let (why, remedy) = why_and_remedy(&same[0].what);
        let line = |finding: &Finding| format!("fault: {name}/{}: {}\n", finding.path, finding.what);
        let mut text: String = same.iter().take(SHOWN).map(|finding| line(finding)).collect();
        if same.len() > SHOWN {
            text.push_str(&format!("... and {} more\n", grouped((same.len() - SHOWN) as u64)));
        }
        parts.push(format!("{text}  why: {why}\n  try: {remedy}\n"));
    }
    let found = verified.findings.len() as u64;
    let wrong = if found == 1 { "is not" } else { "are not" };
    format!("{}\n{name}: {looked_at}; {} {wrong} as written\n", parts.join("\n\n"), counted(found, "file"))
}

/// The word in JSON.
fn kind(wrong: &Wrong) -> &'static str {
    match wrong {
        Wrong::Changed => "changed",
        Wrong::Missing => "missing",
        Wrong::Unreadable(_) => "unreadable",
        Wrong::Stray => "stray",
        Wrong::Unfinished => "unfinished",
    }
}

fn why_and_remedy(wrong: &Wrong) -> (&'static str, &'static str) {
    match wrong {
        Wrong::Missing => (
            "a record or the manifest names it",
            "restore it; or delete the commit record of its shard and run the same command again: it is made anew",
        ),
        Wrong::Changed => (
            "its length or digest is not that of the record, so its numbers can't be trusted",
            "restore it; or delete the commit record of its shard (for a table of the whole corpus: manifest.json) and run again",
        ),
        Wrong::Unreadable(_) => (
            "it says what the corpus holds",
            "restore it, or delete it and run the same command again: what it named is made anew",
        ),
        Wrong::Unfinished => ("a run was ended before it was done", "run the same command again: it continues"),
        Wrong::Stray => ("no record names it", "nothing: the next run removes it"),
    }
}
