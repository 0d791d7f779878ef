//! Hashes of input files: what decides whether a clip has changed.

use super::find::Input;
use super::settings::SourceSettings;
use crate::motion::{Notice, Severity};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::Path;

/// Hashes (blake3, hexadecimal) of a clip's bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputHash {
    /// Of the clip's file.
    pub file: String,
    /// Of its ASF.
    pub asf: Option<String>,
}

/// Hashes every input, reading each file once and none of them whole; the results are in the order of the inputs.
///
/// # Errors
/// A fault of kind `file-unreadable` for a clip whose bytes, or whose skeleton's, can't be read.
pub fn hash_inputs(inputs: &[Input]) -> Vec<Result<InputHash, Notice>> {
    let mut paths: Vec<&Path> =
        inputs.iter().flat_map(|input| [Some(input.path.as_path()), input.asf.as_deref()]).flatten().collect();
    paths.sort();
    paths.dedup();
    let hashes: Vec<io::Result<String>> = paths.par_iter().map(|path| hash_file(path)).collect();
    let hashes: BTreeMap<&Path, &io::Result<String>> = paths.into_iter().zip(&hashes).collect();
    let hash_of = |path: &Path| match hashes.get(path).copied() {
        Some(Ok(hash)) => Ok(hash.clone()),
        Some(Err(error)) => Err(unreadable(path, &error.to_string())),
        None => Err(unreadable(path, "it was not hashed")),
    };
    inputs
        .iter()
        .map(|input| Ok(InputHash { file: hash_of(&input.path)?, asf: input.asf.as_deref().map(hash_of).transpose()? }))
        .collect()
}

impl InputHash {
    /// What a clip's rows depend on besides the stage's own key: its bytes, its skeleton's, and what the config
    /// says of it. Equal key: nothing to do.
    pub fn key(&self, settings: &SourceSettings) -> String {
        let settings = serde_json::to_string(settings).expect("plain fields always make JSON");
        let mut hasher = blake3::Hasher::new();
        for part in [&self.file, self.asf.as_deref().unwrap_or("none"), &settings] {
            hasher.update(part.as_bytes());
            hasher.update(b"\n");
        }
        hasher.finalize().to_hex().to_string()
    }
}

fn hash_file(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

fn unreadable(path: &Path, error: &str) -> Notice {
    Notice {
        severity: Severity::Fault,
        kind: "file-unreadable".to_owned(),
        line: None,
        frame: None,
        count: 1,
        // Its name only: where the input folder lies must not show in the tables.
        message: format!("{} can't be read: {error}", path.file_name().unwrap_or_default().display()),
        why: "without its bytes the clip is left out; the others go on".to_owned(),
        remedy: "make it readable, or list the clip under `skip` in your config".to_owned(),
    }
}
