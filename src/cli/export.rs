//! `export`: clips of a corpus as BVH, or as ASF and AMC.
//!
//! In the format that a clip came in, its own header is written word for word and its numbers so that they read back
//! bit for bit; in the other one it is converted, with the same positions. Files are named `SOURCE/NAME` below the
//! folder, so that no two clips can meet in one.

use super::Ending;
use super::args::{Export, TextFormat};
use super::numbers::counted;
use super::output::{Answer, Refusal, three_lines};
use crate::corpus::{Catalog, ClipRow, Store, look_up, open_to_read, read_clips};
use crate::formats::{WriteError, acclaim_to_bvh, bvh_to_acclaim, write_amc, write_asf, write_bvh};
use crate::motion::clip::snap_rate_hz;
use crate::motion::{Clip, Format};
use serde_json::json;
use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};

/// What readers take for an AMC that doesn't say its rate.
const USUAL_AMC_RATE_HZ: f64 = 120.0;

/// A clip that was written.
struct Written {
    clip: String,
    files: Vec<PathBuf>,
    converted: bool,
    rate_hz: f64,
    unit_m: f64,
}

/// Runs the verb.
pub(super) fn export(args: &Export) -> Result<Answer, Refusal> {
    let (store, _) = open_to_read(&args.corpus)?;
    let clips = read_clips(&store)?;
    let wanted = wanted(&args.corpus, &names(args)?, &clips)?;
    let catalog = Catalog::open(&store)?;
    let (mut written, mut refused, mut taken) = (Vec::new(), Vec::new(), BTreeSet::new());
    for row in wanted {
        match export_one(args, row, &store, &catalog, &mut taken) {
            Ok(one) => written.push(one),
            Err(refusal) => refused.push(refusal.text),
        }
    }
    let answer = match args.json {
        true => Answer::json(
            &written
                .iter()
                .map(|one| {
                    json!({"clip": one.clip, "files": one.files, "converted": one.converted,
                        "rate_hz": one.rate_hz, "unit_m": one.unit_m})
                })
                .collect::<Vec<_>>(),
        ),
        false => {
            let files = written.iter().flat_map(|one| &one.files);
            Answer::text(files.map(|file| format!("{}\n", file.display())).collect())
        }
    };
    let converted = written.iter().filter(|one| one.converted).count() as u64;
    let how = if converted > 0 { format!(", {} converted", counted(converted, "clip")) } else { String::new() };
    let failed = !refused.is_empty();
    let mut answer = answer.remark(format!("{} written{how}", counted(written.len() as u64, "clip")));
    answer.remarks.extend(refused);
    Ok(if failed { answer.ending(Ending::Failed) } else { answer })
}

/// The names that were asked for; `-` stands for those of standard input, one a line.
fn names(args: &Export) -> Result<Vec<String>, Refusal> {
    let mut names = Vec::new();
    for name in &args.clips {
        if name != "-" {
            names.push(name.clone());
            continue;
        }
        let mut text = String::new();
        std::io::stdin().lock().read_to_string(&mut text).map_err(|error| {
            let corpus = args.corpus.display();
            Refusal::new(
                format!("standard input: {error}"),
                "names are read from it, one a line",
                format!("motionmill search {corpus} --quiet | motionmill export {corpus} - --format bvh"),
            )
        })?;
        names.extend(text.lines().map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned));
    }
    Ok(names)
}

/// The clips of the names, each once; before anything is written all names must be found.
fn wanted<'a>(corpus: &Path, names: &[String], clips: &'a [ClipRow]) -> Result<Vec<&'a ClipRow>, Refusal> {
    let (mut found, mut seen, mut refused) = (Vec::new(), BTreeSet::new(), Vec::new());
    for name in names {
        match look_up(clips, name) {
            Ok(row) if seen.insert(row.clip_id) => found.push(row),
            Ok(_) => {}
            Err(error) => refused.push(Refusal::of_look_up(&error, corpus).text),
        }
    }
    match refused.is_empty() {
        true => Ok(found),
        false => Err(Refusal { text: refused.join("\n\n"), ending: Ending::Failed }),
    }
}

fn export_one(
    args: &Export,
    row: &ClipRow,
    store: &Store,
    catalog: &Catalog,
    taken: &mut BTreeSet<PathBuf>,
) -> Result<Written, Refusal> {
    let shard = catalog.shard_of(row.clip_id)?;
    let clip = shard.motion(row.clip_id)?;
    let header = Some(shard.skeleton(row.clip_id)?.header.as_str()).filter(|header| !header.is_empty());
    let files = files_of(&clip, row, header, args.format).map_err(|error| {
        let name = row.full_name();
        Refusal::new(
            format!("{name}: {error}"),
            "the format can't hold it, so the clip is left out; the others are written",
            format!("--format {}", clip.skeleton.format.name()),
        )
    })?;
    let stem = args.out.join(safe_path(&row.full_name()));
    if is_below(&stem, store.root()) {
        return Err(Refusal::new(
            format!("{}: it is inside the corpus", stem.display()),
            "a corpus holds what a run wrote, and nothing else",
            "--out with another folder",
        ));
    }
    let mut written = Vec::new();
    for (extension, bytes) in &files {
        // `with_extension` would take `take.1` for a stem with an extension.
        let mut name = stem.clone().into_os_string();
        name.push(format!(".{extension}"));
        let file = PathBuf::from(name);
        put(&file, bytes, args.force, taken)?;
        written.push(file);
    }
    Ok(Written {
        clip: row.full_name(),
        files: written,
        converted: clip.skeleton.format != format_of(args.format),
        rate_hz: row.rate_hz,
        unit_m: row.unit_m,
    })
}

/// Extensions and contents.
fn files_of(
    clip: &Clip,
    row: &ClipRow,
    header: Option<&str>,
    format: TextFormat,
) -> Result<Vec<(&'static str, Vec<u8>)>, WriteError> {
    let (skeleton, channels) = (&*clip.skeleton, &clip.channels);
    // As it was read, unless the config gave the clip another rate.
    let as_read = row.frame_time_s.filter(|&time_s| snap_rate_hz(time_s) == row.rate_hz);
    let frame_time_s = as_read.unwrap_or(1.0 / row.rate_hz);
    let amc_rate_hz = Some(row.rate_hz).filter(|&rate_hz| rate_hz != USUAL_AMC_RATE_HZ);
    Ok(match (format, skeleton.format) {
        (TextFormat::Bvh, Format::Bvh) => vec![("bvh", write_bvh(skeleton, header, frame_time_s, channels)?)],
        (TextFormat::Bvh, Format::Amc) => {
            let (skeleton, channels) = acclaim_to_bvh(skeleton, channels)?;
            vec![("bvh", write_bvh(&skeleton, None, frame_time_s, &channels)?)]
        }
        (TextFormat::Amc, Format::Amc) => vec![
            ("asf", write_asf(skeleton, header, row.unit_m)?),
            ("amc", write_amc(skeleton, channels, amc_rate_hz, 1)?),
        ],
        (TextFormat::Amc, Format::Bvh) => {
            let (skeleton, channels) = bvh_to_acclaim(skeleton, channels)?;
            vec![
                ("asf", write_asf(&skeleton, None, row.unit_m)?),
                ("amc", write_amc(&skeleton, &channels, amc_rate_hz, 1)?),
            ]
        }
    })
}

fn format_of(format: TextFormat) -> Format {
    match format {
        TextFormat::Bvh => Format::Bvh,
        TextFormat::Amc => Format::Amc,
    }
}

/// A clip's name as a path that stays below the folder it is put in, whatever a config called the source.
fn safe_path(name: &str) -> PathBuf {
    let is_odd = |c: char| c.is_control() || (cfg!(windows) && "\\:*?\"<>|".contains(c));
    let part = |part: &str| match part {
        "" | "." | ".." => "_".to_owned(),
        part => part.chars().map(|c| if is_odd(c) { '_' } else { c }).collect(),
    };
    name.split('/').map(part).collect()
}

/// Whether a path lies in a folder, however either is written.
fn is_below(path: &Path, folder: &Path) -> bool {
    match (std::path::absolute(path), std::path::absolute(folder)) {
        (Ok(path), Ok(folder)) => path.starts_with(folder),
        _ => false,
    }
}

/// Writes a file; one that is there and differs stays, unless it may go.
fn put(file: &Path, bytes: &[u8], force: bool, taken: &mut BTreeSet<PathBuf>) -> Result<(), Refusal> {
    if !taken.insert(file.to_owned()) {
        return Err(Refusal::new(
            format!("{}: another clip was just written there", file.display()),
            "their names differ only in characters that a path can't have",
            "export them one by one, each with its own --out",
        ));
    }
    let differs = file.exists() && std::fs::read(file).ok().as_deref() != Some(bytes);
    if differs && !force {
        return Err(Refusal::new(
            format!("{}: there is another file of this name", file.display()),
            "it may be the one that the clip was read from",
            "another folder for --out, or --force to overwrite it",
        ));
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).and_then(|()| std::fs::write(file, bytes)).map_err(|error| {
        let what = format!("{}: {error}", file.display());
        Refusal {
            text: three_lines("error", &what, "the clip is written there", "--out with a folder that can be written"),
            ending: Ending::Failed,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_below_the_folder() {
        assert_eq!(safe_path("cmu/02/02_01"), Path::new("cmu/02/02_01"));
        assert_eq!(safe_path("../../etc/passwd"), Path::new("_/_/etc/passwd"));
        assert_eq!(safe_path("/x//y\n"), Path::new("_/x/_/y_"));
    }
}
