//! The dataset card: a README that hubs and people read, with the terms of every source.

use super::error::CorpusError;
use super::fold::Folded;
use super::paths::{CARD, Table};
use super::record::FileRecord;
use super::store::Store;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The terms of a source, as the config gives them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SourceTerms {
    /// Label of the source.
    pub source: String,
    /// License, as its owner calls it.
    pub license: Option<String>,
    /// Whom to name, and how.
    pub attribution: Option<String>,
}

/// Writes `README.md`; the manifest is to note what comes back.
///
/// # Errors
/// The file system's refusals.
pub fn write_card(store: &Store, folded: &Folded, terms: &[SourceTerms]) -> Result<FileRecord, CorpusError> {
    let text = card(folded, terms);
    store.put_atomic(CARD, text.as_bytes())?;
    let blake3 = blake3::hash(text.as_bytes()).to_hex().to_string();
    Ok(FileRecord { path: CARD.to_owned(), bytes: text.len() as u64, blake3, rows: 0 })
}

fn card(folded: &Folded, terms: &[SourceTerms]) -> String {
    let mut text = String::new();
    front_matter(&mut text, folded);
    body(&mut text, folded, terms).expect("a String takes all that is written to it");
    text
}

/// What hubs parse: license, size, and where each table's files are.
fn front_matter(text: &mut String, folded: &Folded) {
    let licenses: BTreeSet<&str> =
        folded.clips.iter().flat_map(|clip| clip.licenses.iter().map(String::as_str)).collect();
    let frames: u64 = folded.clips.iter().map(|clip| u64::from(clip.frames)).sum();
    let size = match frames {
        0..1_000 => "n<1K",
        1_000..10_000 => "1K<n<10K",
        10_000..100_000 => "10K<n<100K",
        100_000..1_000_000 => "100K<n<1M",
        1_000_000..10_000_000 => "1M<n<10M",
        10_000_000..100_000_000 => "10M<n<100M",
        _ => "n>100M",
    };
    let mut lines = vec!["---".to_owned(), "license: other".to_owned()];
    let names: Vec<&str> = licenses.into_iter().collect();
    lines.push(format!("license_name: {}", quoted(&names.join("; "))));
    lines.push(format!("size_categories: [{}]", quoted(size)));
    lines.push("tags: [motion-capture, human-motion, parquet]".to_owned());
    lines.push("configs:".to_owned());
    let mut config = |name: &str, files: &str| {
        lines.push(format!("- config_name: {}", quoted(name)));
        lines.push(format!("  data_files: {}", quoted(files)));
    };
    config("clips", "clips.parquet");
    config("skeletons", "skeletons.parquet");
    for table in Table::ALL {
        let layouts: BTreeSet<&str> = folded.clips.iter().map(|clip| clip.layout.as_str()).collect();
        match table.by_layout() {
            true => layouts.into_iter().for_each(|layout| {
                let name = table.name();
                config(&format!("{name}-{layout}"), &format!("{name}/layout={layout}/*.parquet"));
            }),
            false if table == Table::Provenance && !folded.clips.iter().any(|clip| clip.origin.is_made()) => {}
            false => config(table.name(), &format!("{}/*.parquet", table.name())),
        }
    }
    lines.push("---".to_owned());
    text.push_str(&lines.join("\n"));
    text.push('\n');
}

fn body(text: &mut String, folded: &Folded, terms: &[SourceTerms]) -> std::fmt::Result {
    writeln!(text, "\n# Motion corpus\n")?;
    writeln!(text, "Made by [Motionmill](https://crates.io/crates/motionmill): motion captures as tables, labelled")?;
    writeln!(text, "with foot plants and gait. Lengths in metres, angles in radians, Y up, frames from 0; read the")?;
    writeln!(text, "columns' metadata (`unit`, `space`, `joint`, `role`) instead of splitting their names.\n")?;
    writeln!(text, "| origin | clips | frames | hours |\n| --- | ---: | ---: | ---: |")?;
    let mut origins: BTreeMap<&str, (u64, u64, f64)> = BTreeMap::new();
    for clip in &folded.clips {
        let row = origins.entry(clip.origin.name()).or_default();
        *row = (row.0 + 1, row.1 + u64::from(clip.frames), row.2 + clip.duration_s);
    }
    for (origin, (clips, frames, seconds)) in origins {
        writeln!(text, "| {origin} | {clips} | {frames} | {:.2} |", seconds / 3600.0)?;
    }
    writeln!(text, "\n## Sources and terms\n")?;
    writeln!(text, "Made clips carry the licenses of all their parents (`licenses`, `attribution` in `clips`).\n")?;
    let mut terms: Vec<&SourceTerms> = terms.iter().collect();
    terms.sort_by(|a, b| a.source.cmp(&b.source));
    for SourceTerms { source, license, attribution } in terms {
        let license = license.as_deref().unwrap_or("license not given: ask the owner before passing anything on");
        let attribution = attribution.as_deref().map_or(String::new(), |whom| format!(". {}", one_line(whom)));
        writeln!(text, "- **{}**: {}{attribution}", one_line(source), one_line(license))?;
    }
    writeln!(text, "\n## Tables\n")?;
    for (file, what) in [
        ("clips.parquet", "one row a clip: source, terms, skeleton, gait, origin"),
        ("skeletons.parquet", "one row a body: joints, roles, offsets"),
        ("channels/layout=*/", "every number of the files, by clip and frame, file units"),
        ("poses/layout=*/", "world position of every joint, metres"),
        ("annotations/", "per frame: heading, speed, foot heights, stance, gait, phase"),
        ("features/", "per frame: effectors in the body's own frame"),
        ("plants/, segments/", "feet on the ground, runs of one gait; frame ranges are half-open"),
        ("nodes, sequences, edges", "the cluster graph: where clips can turn into one another"),
        ("recipes, made, provenance/", "clips made from others, how they were judged, where each frame comes from"),
        ("faults.parquet", "what was odd about the input"),
    ] {
        writeln!(text, "- `{file}`: {what}")?;
    }
    writeln!(text, "\n```sql\nSELECT gait_class, sum(duration_s) FROM 'clips.parquet' GROUP BY 1\n```")
}

/// A YAML string in double quotes.
fn quoted(text: &str) -> String {
    // JSON's strings are YAML's.
    serde_json::Value::from(one_line(text)).to_string()
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
