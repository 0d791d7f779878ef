//! The pipelines and configs that ship with the program, and how a name finds one of them or a file.

use super::document::{Source, SourceKind};
use super::error::PlanError;
use super::nearest::{list, nearest};
use std::fs::File;
use std::io::Read;
use std::sync::Arc;

/// A file that ships with the program: its bare name, its place in the repository, its text.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// What the user types.
    pub name: &'static str,
    /// Its place in the repository.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! shipped {
    ($folder:literal: $($name:literal)*) => {
        &[$(Shipped {
            name: $name,
            file: concat!($folder, "/", $name, ".toml"),
            text: include_str!(concat!("../../", $folder, "/", $name, ".toml")),
        }),*]
    };
}

/// Pipelines that ship with the program.
pub const PIPELINES: &[Shipped] = shipped!("pipelines": "annotate" "graph" "enrich" "demo");

/// Configs that ship with the program; the first is the reference of all settings.
pub const CONFIGS: &[Shipped] = shipped!("configs": "default" "cmu" "bandai-namco");

/// Rules about the classes that names of clips promise, which ship with the program.
pub const TRUTHS: &[Shipped] = shipped!("configs/truth": "bandai-namco");

/// No settings are larger, bytes.
const MAX_SETTINGS_BYTES: u64 = 16 << 20;

/// A shipped pipeline by its bare name, or a file.
pub(crate) fn pipeline(name: &str) -> Result<Arc<Source>, PlanError> {
    find(name, PIPELINES, SourceKind::Pipeline, "pipeline")
}

/// A shipped config by its bare name, or a file.
pub(crate) fn config(name: &str) -> Result<Arc<Source>, PlanError> {
    find(name, CONFIGS, SourceKind::Config, "config")
}

/// Shipped rules about names by their bare name, or a file.
pub(crate) fn truth(name: &str) -> Result<Arc<Source>, PlanError> {
    find(name, TRUTHS, SourceKind::Truth, "file of rules")
}

/// Rules about names with every field that they have.
pub(crate) fn truth_reference() -> Arc<Source> {
    Source::new(TRUTHS[0].file, TRUTHS[0].text, SourceKind::Truth)
}

/// `configs/default.toml` with the settings that are off by default switched on: an example of every field.
pub(crate) fn reference() -> Arc<Source> {
    let switched_on = |line: &'static str| match line.strip_prefix('#') {
        Some(setting) if setting.starts_with(|c: char| c == '[' || c.is_ascii_lowercase()) => setting,
        _ => line,
    };
    let text: Vec<&str> = CONFIGS[0].text.lines().map(switched_on).collect();
    Source::new(CONFIGS[0].file, &text.join("\n"), SourceKind::Config)
}

fn find(name: &str, shipped: &[Shipped], kind: SourceKind, what: &str) -> Result<Arc<Source>, PlanError> {
    if let Some(shipped) = shipped.iter().find(|shipped| shipped.name == name) {
        return Ok(Source::new(shipped.file, shipped.text, kind));
    }
    let whole = |error: String, why: String, try_: String| PlanError {
        file: name.to_owned(),
        line: None,
        column: None,
        what: error,
        why,
        try_,
    };
    let mut bytes = Vec::new();
    let read = File::open(name).and_then(|file| file.take(MAX_SETTINGS_BYTES + 1).read_to_end(&mut bytes));
    let names: Vec<&str> = shipped.iter().map(|shipped| shipped.name).collect();
    let by_name = match nearest(name, &names) {
        Some(near) => format!("the nearest {what} that ships is `{near}`"),
        None => format!("name a file, or one of {}", list(&names)),
    };
    if let Err(error) = read {
        let is_path = name.contains(['/', '\\', '.']);
        return Err(match is_path {
            true => whole(
                format!("this {what} can't be read: {error}"),
                "it is looked for from the folder that the program runs in".to_owned(),
                by_name,
            ),
            false => {
                whole(format!("no such {what}"), format!("it is neither a file nor one of {}", list(&names)), by_name)
            }
        });
    }
    if bytes.len() as u64 > MAX_SETTINGS_BYTES {
        return Err(whole(
            format!("more than {MAX_SETTINGS_BYTES} bytes"),
            format!("no {what} is that large; most likely this is another file"),
            by_name,
        ));
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(Source::new(name, &text, kind)),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let before = String::from_utf8_lossy(&error.as_bytes()[..at]).into_owned();
            let end = Source::new(name, &before, kind).end();
            Err(end.error(
                "not UTF-8 from here on".to_owned(),
                "settings are text, and TOML is UTF-8".to_owned(),
                "save it as UTF-8 in your editor".to_owned(),
            ))
        }
    }
}
