//! Where the pictures of a clip go: each to a file of its own, outside the corpus.

use super::args::Inspect;
use super::output::Refusal;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

/// Refuses files that can't be meant, before anything is drawn.
pub(super) fn check_targets(args: &Inspect) -> Result<(), Refusal> {
    let strip = args.strip.as_deref().map(target);
    let plot = args.plot.as_deref().map(target);
    if plot.is_some() && plot == strip {
        let why = "each is a picture of its own";
        return Err(Refusal::new("--strip and --plot name one file", why, "two files").in_arguments());
    }
    // It was opened, so it is there.
    let Ok(corpus) = args.corpus.canonicalize() else { return Ok(()) };
    for (option, file, target) in [("--strip", &args.strip, strip), ("--plot", &args.plot, plot)] {
        let Some((file, target)) = file.as_deref().zip(target) else { continue };
        if target.starts_with(&corpus) {
            let what = format!("{option} {} lies in the corpus", file.display());
            let name = target.file_name().map_or_else(OsString::new, OsString::from);
            let why = "a corpus holds what runs write, and each of its files is on record";
            return Err(Refusal::new(what, why, format!("{option} {}", name.display())).in_arguments());
        }
    }
    Ok(())
}

/// Writes a drawn picture.
pub(super) fn write(option: &str, file: &Path, svg: &str) -> Result<(), Refusal> {
    std::fs::write(file, svg).map_err(|error| {
        let remedy = format!("{option} with a file in a folder that can be written");
        Refusal::new(format!("{}: {error}", file.display()), "the picture is written there", remedy)
    })
}

/// The file that is meant: links and detours resolved as far as what they lead through is there.
fn target(file: &Path) -> PathBuf {
    let resolved = || -> io::Result<PathBuf> {
        if let Ok(there) = file.canonicalize() {
            return Ok(there);
        }
        let whole = std::path::absolute(file)?;
        match (whole.parent(), whole.file_name()) {
            (Some(folder), Some(name)) => Ok(folder.canonicalize()?.join(name)),
            _ => Ok(whole),
        }
    };
    resolved().unwrap_or_else(|_| file.to_owned())
}
