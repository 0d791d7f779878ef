//! The command line: what each verb prints, and how it ends, on a small corpus of the program's own people.

use crate::running::{mill, said};
use motionmill::corpus::{Catalog, ClipRow, Store, open_to_run, read_clips};
use motionmill::formats::{ReadOptions, read_amc, read_asf, read_bvh};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

fn json(folder: &Path, args: &[&str]) -> Value {
    let said = mill(folder, args);
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{args:?}: {error}: {}{}", said.out, said.err))
}

/// A folder with `demo/corpus` and `demo/captures`, made once. Nobody writes there.
fn demo() -> &'static Path {
    static DEMO: OnceLock<PathBuf> = OnceLock::new();
    DEMO.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli-demo");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let done = mill(&folder, &RUN);
        assert_eq!(done.code, 0, "{}{}", done.out, done.err);
        folder
    })
}

const RUN: [&str; 6] = ["run", "demo", "--set", "procedural.clips=8", "--set", "recipes.select=6"];

/// A copy of the demo that may be changed.
fn copy() -> tempfile::TempDir {
    let to = tempfile::tempdir().unwrap();
    copy_folder(demo(), to.path());
    to
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let there = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy_folder(&entry.path(), &there),
            false => drop(fs::copy(entry.path(), there).unwrap()),
        }
    }
}

fn clips() -> Vec<ClipRow> {
    read_clips(&Store::new(demo().join("demo/corpus"))).unwrap()
}

fn graft() -> ClipRow {
    clips().into_iter().find(|clip| clip.origin.is_made()).unwrap()
}

const CORPUS: &str = "demo/corpus";

#[test]
fn a_second_run_is_up_to_date() {
    let copy = copy();
    let again = mill(copy.path(), &RUN);
    assert_eq!((again.code, again.out.as_str()), (0, "corpus is up to date (8 clips); nothing to do\n"));
    let report = json(copy.path(), &[&RUN[..], &["--json"]].concat());
    assert_eq!(report["up_to_date"], true);
    assert_eq!(report["holds"]["captured"]["clips"], 8);
}

#[test]
fn inspect_shows_what_is_there_and_what_to_distrust() {
    let seen = mill(demo(), &["inspect", CORPUS]);
    assert_eq!(seen.code, 0);
    let lines: Vec<&str> = seen.out.lines().collect();
    assert_eq!(lines[0], "                          clips      frames   hours");
    assert!(lines[1].starts_with("  procedural                  8"), "{}", lines[1]);
    assert!(seen.out.contains("\n  grafted  ") && seen.out.contains("graph    "), "{}", seen.out);
    assert!(seen.out.contains("distrust"), "{}", seen.out);
    let value = json(demo(), &["inspect", CORPUS, "--json"]);
    assert_eq!(value["holds"]["captured"]["clips"], 8);
    let frames: u64 = clips().iter().filter(|clip| !clip.origin.is_made()).map(|clip| u64::from(clip.frames)).sum();
    assert_eq!(value["holds"]["captured"]["frames"], frames);
    assert!(value["distrust"]["doubtful"].is_array());
}

#[test]
fn inspect_tells_all_about_a_clip() {
    let page = mill(demo(), &["inspect", CORPUS, "walk_01"]);
    assert_eq!(page.code, 0, "{}", page.err);
    let row = clips().into_iter().find(|clip| clip.name.ends_with("/walk_01")).unwrap();
    assert!(page.out.starts_with(&format!("{}\n", row.full_name())), "{}", page.out);
    let gait = page.out.lines().find_map(|line| line.strip_prefix("  gait     ")).unwrap();
    assert_eq!(gait, "W".repeat(72));
    assert!(page.out.contains(&format!("{} frames at {} Hz", row.frames, row.rate_hz)), "{}", page.out);
    let value = json(demo(), &["inspect", CORPUS, "walk_01", "--json", "--raw"]);
    assert_eq!((value["name"].as_str().unwrap(), value["gait_class"].as_str().unwrap()), (row.name.as_str(), "walk"));
    assert!(value["plants"].as_array().unwrap().len() > 4);
    assert_eq!(value["raw"]["joints"][0]["role"], "hips");
    let raw = mill(demo(), &["inspect", CORPUS, "walk_01", "--raw"]).out;
    assert!(raw.contains("  arm_left   lclavicle lhumerus lradius"), "{raw}");
}

#[test]
fn a_made_clip_is_shown_and_drawn_below_its_parents() {
    let folder = tempfile::tempdir().unwrap();
    let (corpus, name) = (demo().join(CORPUS), graft().full_name());
    let args = ["inspect", corpus.to_str().unwrap(), &name, "--strip", "three.svg"];
    let page = mill(folder.path(), &args);
    assert_eq!(page.code, 0, "{}", page.err);
    assert!(page.out.contains("verdict    accepted") && page.out.contains("  skate "), "{}", page.out);
    assert!(page.out.contains("strip      three.svg: 3 strips, "), "{}", page.out);
    let svg = fs::read_to_string(folder.path().join("three.svg")).unwrap();
    for word in ["base  ", "donor  ", "graft  "] {
        assert_eq!(svg.matches(&format!(">{word}")).count(), 1, "{word}");
    }
    let value = json(demo(), &["inspect", CORPUS, &name, "--json"]);
    assert_eq!(value["parent_names"].as_array().unwrap().len(), 2);
    assert!(value["made"]["figures"]["skate"]["own"].is_number());
    let made = json(demo(), &["inspect", CORPUS, "--made", "--json"]);
    let verdicts = made.as_array().unwrap();
    assert_eq!(verdicts.len(), 6);
    let accepted = verdicts.iter().filter(|recipe| recipe["made"]["accepted"] == true).count();
    let text = mill(demo(), &["inspect", CORPUS, "--made"]).out;
    assert!(text.starts_with(&format!("6 recipes: {accepted} accepted, {} rejected", 6 - accepted)), "{text}");
}

#[test]
fn a_name_that_is_not_there_is_answered_with_the_nearest() {
    for verb in [&["inspect", CORPUS, "walk_slwo_01"][..], &["export", CORPUS, "walk_slwo_01", "-f", "bvh"][..]] {
        let said = mill(demo(), verb);
        assert_eq!((said.code, said.out.as_str()), (1, ""), "{}", said.err);
        assert!(
            said.err.starts_with("error: no clip is called `walk_slwo_01`; the nearest is `captures/"),
            "{}",
            said.err
        );
        assert_eq!(said.err.lines().count(), 3);
        assert!(said.err.contains("\n  try: captures/p01/walk_slow_01"), "{}", said.err);
    }
    let several = mill(demo(), &["inspect", CORPUS, "walk"]);
    assert_eq!(several.code, 1);
    assert!(several.err.starts_with("error: `walk` fits "), "{}", several.err);
    let nowhere = mill(demo(), &["inspect", "demo/captures"]);
    assert!(nowhere.err.starts_with("error: demo/captures: not a corpus"), "{}", nowhere.err);
    assert_eq!((nowhere.code, nowhere.err.lines().count()), (1, 3));
}

#[test]
fn search_finds_by_gait_length_name_and_origin() {
    let names = |args: &[&str]| -> Vec<String> {
        let said = mill(demo(), &[&["search", CORPUS, "--quiet"], args].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        said.out.lines().map(str::to_owned).collect()
    };
    let wanted = |fits: &dyn Fn(&ClipRow) -> bool| -> Vec<String> {
        let mut names: Vec<String> = clips().iter().filter(|clip| fits(clip)).map(ClipRow::full_name).collect();
        names.sort();
        names
    };
    assert_eq!(names(&[]), wanted(&|_| true));
    let walks = wanted(&|clip| clip.labels.gait_class.is_some_and(|gait| gait.name() == "walk"));
    assert!(walks.len() > 2 && walks.len() < clips().len());
    assert_eq!(names(&["--gait", "walk"]), walks);
    let long = wanted(&|clip| clip.labels.walk_fraction.is_some_and(|share| share >= 0.75) && clip.duration_s >= 8.0);
    assert!(!long.is_empty() && long.len() < walks.len());
    assert_eq!(names(&["--gait", "walk", "--min-fraction", "0.75", "--min-seconds", "8"]), long);
    assert_eq!(
        names(&["--name", "run|jump", "--origin", "procedural"]),
        wanted(&|clip| { !clip.origin.is_made() && (clip.name.contains("run") || clip.name.contains("jump")) })
    );
    assert_eq!(names(&["--source", "grafts"]), wanted(&|clip| clip.source == "grafts"));
    let none = mill(demo(), &["search", CORPUS, "--min-seconds", "1000"]);
    assert_eq!((none.code, none.out.as_str(), none.err.as_str()), (0, "", "no clip fits\n"));
    let rows = json(demo(), &["search", CORPUS, "--gait", "walk", "--json"]);
    assert_eq!(rows.as_array().unwrap().len(), walks.len());
    assert!(rows[0]["walk_fraction"].is_number() && rows[0]["labels"].is_null());
    let table = mill(demo(), &["search", CORPUS, "--gait", "walk"]).out;
    assert!(table.ends_with(" s\n") && table.contains(&format!("\n{} clips, ", walks.len())), "{table}");
    for wrong in [&["--name", "("][..], &["--gait", "wlak"], &["--gait", "walk", "--min-fraction", "75"]] {
        assert_eq!(mill(demo(), &[&["search", CORPUS], wrong].concat()).code, 2, "{wrong:?}");
    }
}

#[test]
fn a_reader_that_has_gone_is_no_error() {
    for args in [&["search", CORPUS][..], &["inspect", CORPUS], &["inspect", CORPUS, "walk_01", "--json"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_motionmill"));
        let output = command.current_dir(demo()).args(args).stdout(writer).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(
            (output.status.code(), String::from_utf8(output.stderr).unwrap().as_str()),
            (Some(0), ""),
            "{args:?}"
        );
    }
}

#[test]
fn mistakes_in_a_plan_say_where_and_end_with_2() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.toml"), "[contacts.thesis]\nmax_hieght_m = 0.05\n").unwrap();
    for verb in ["run", "check"] {
        let said = mill(folder.path(), &[verb, "annotate", "--config", "mine.toml"]);
        assert_eq!((said.code, said.out.as_str()), (2, ""));
        let wanted = "error: mine.toml:2:1: unknown field `max_hieght_m` in [contacts.thesis]\n  why: ";
        assert!(said.err.starts_with(wanted), "{}", said.err);
    }
    let value = json(folder.path(), &["check", "annotate", "--config", "mine.toml", "--json"]);
    assert_eq!((&value["mistakes"][0]["line"], &value["mistakes"][0]["column"]), (&2.into(), &1.into()));
    for args in [&["run", "annotate"][..], &["run", "annotate", "--input", "absent"], &["check", "absent.toml"]] {
        let said = mill(folder.path(), args);
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains("error: ") && said.err.contains("\n  try: "), "{}", said.err);
    }
    assert!(!folder.path().join("corpus").join("manifest.json").exists());
}

#[test]
fn thresholds_that_nothing_goes_by_are_noted() {
    const NOTE: &str = "note: [contacts.thesis] has no effect: the detector in force is `adaptive`\n  why: ";
    const REMEDY: &str = "\n  try: contacts.detector=\"thesis\"\n";
    let set = ["--set", "contacts.thesis.max_height_m=0.04", "--set", "contacts.extrema.max_speed_mps=0.6"];
    let noted = mill(demo(), &[&["check", "annotate"], &set[..]].concat());
    assert_eq!(noted.code, 0, "{}", noted.out);
    assert!(noted.err.starts_with(NOTE) && noted.err.ends_with(REMEDY), "{}", noted.err);
    assert_eq!(noted.err.lines().count(), 3, "{}", noted.err);
    let value = json(demo(), &[&["check", "annotate", "--json"], &set[..]].concat());
    assert_eq!(value["notes"][0]["try"], "contacts.detector=\"thesis\"");
    let remedied = mill(demo(), &[&["check", "annotate", "--set", "contacts.detector=\"thesis\""], &set[..]].concat());
    assert_eq!(remedied.err, "");
    assert_eq!(mill(demo(), &["check", "demo"]).err, "");
    let run = mill(copy().path(), &[&RUN[..], &set].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.err.starts_with(NOTE) && run.err.contains(REMEDY), "{}", run.err);
}

#[test]
fn check_counts_what_would_be_read() {
    let seen = mill(demo(), &["check", "enrich", "--input", "demo/captures"]);
    assert_eq!(seen.code, 0, "{}", seen.err);
    assert!(seen.out.contains("inputs   8 clips, ") && seen.out.contains("\n  captures  amc "), "{}", seen.out);
    assert!(seen.out.contains("note: captures/p01/: AMC files without an ASF of their name"), "{}", seen.out);
    let value = json(demo(), &["check", "enrich", "--input", "demo/captures", "--json"]);
    assert_eq!((&value["inputs"][0]["clips"], &value["inputs"][0]["skeletons"]), (&8.into(), &1.into()));
    assert_eq!(mill(demo(), &["check", "demo"]).code, 0);
}

/// Good and bad clips in one folder.
fn mixed() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let captures = demo().join("demo/captures/p01");
    let put = |name: &str, bytes: &[u8]| fs::write(folder.path().join("mixed").join(name), bytes).unwrap();
    fs::create_dir(folder.path().join("mixed")).unwrap();
    put("p01.asf", &fs::read(captures.join("p01.asf")).unwrap());
    put("good.amc", &fs::read(captures.join("walk_01.amc")).unwrap());
    put("same.amc", &fs::read(captures.join("walk_01.amc")).unwrap());
    let bad = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\n}\nMOTION\nFrames: 2\nFrame Time: .1\n1 2 3\n4 five 6\n";
    put("bad.bvh", bad.as_bytes());
    put("worse.bvh", b"HIERARCHY\nROOT a\n{\n");
    folder
}

#[test]
fn clips_that_cannot_be_used_end_a_run_with_3_and_are_explained() {
    let folder = mixed();
    let done = mill(folder.path(), &["run", "annotate", "--input", "mixed"]);
    assert_eq!(done.code, 3, "{}{}", done.out, done.err);
    assert!(done.out.contains("\n  quarantined                 2"), "{}", done.out);
    let faults = mill(folder.path(), &["inspect", "corpus", "--faults"]);
    assert_eq!(faults.code, 0);
    assert!(faults.out.starts_with("fault: mixed/"), "{}", faults.out);
    let of_it = faults.out.lines().find(|line| line.starts_with("fault: mixed/bad:11: ")).unwrap();
    assert!(of_it.contains("`five`"), "{of_it}");
    let rows = json(folder.path(), &["inspect", "corpus", "--faults", "--json"]);
    assert_eq!(rows.as_array().unwrap().iter().filter(|row| row["severity"] == "fault").count(), 2);
    // A quarantined clip has no row, but its own faults.
    let own = mill(folder.path(), &["inspect", "corpus", "bad"]);
    assert!(own.code == 1 && own.out.starts_with(of_it), "{}{}", own.out, own.err);
    let distrust = json(folder.path(), &["inspect", "corpus", "--json"])["distrust"].clone();
    assert_eq!(distrust["quarantined"], serde_json::json!(["mixed/bad", "mixed/worse"]));
    assert_eq!(distrust["duplicates"], serde_json::json!([["mixed/good", "mixed/same"]]));
    // `check` reads the first frame only, so it finds the worse one.
    let checked = mill(folder.path(), &["check", "annotate", "--input", "mixed"]);
    assert_eq!(checked.code, 3, "{}", checked.err);
    assert!(
        checked.out.contains("fault: mixed/worse:") && checked.out.contains("1 clip can't be used"),
        "{}",
        checked.out
    );
}

#[test]
fn export_in_the_own_format_reads_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let corpus = demo().join(CORPUS);
    let corpus = corpus.to_str().unwrap();
    let names = mill(demo(), &["search", CORPUS, "--quiet"]).out;
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_motionmill"));
    command.current_dir(folder.path()).args(["export", corpus, "-", "--format", "amc", "--out", "amc"]);
    let written = said(command.write_stdin(names).output().unwrap());
    assert_eq!(written.code, 0, "{}", written.err);
    let catalog = Catalog::open(&Store::new(corpus)).unwrap();
    for clip in clips() {
        let path = folder.path().join("amc").join(format!("{}.amc", clip.full_name()));
        let asf_bytes = fs::read(format!("{}.asf", path.to_str().unwrap().strip_suffix(".amc").unwrap())).unwrap();
        let asf = read_asf(&asf_bytes, &ReadOptions::default()).unwrap().value;
        let read = read_amc(&fs::read(path).unwrap(), &asf, &ReadOptions::default()).unwrap();
        assert!(read.findings.is_empty(), "{:?}", read.findings);
        let stored = catalog.shard_of(clip.clip_id).unwrap().channels(clip.clip_id).unwrap();
        assert!(!stored.is_empty());
        assert!(
            read.value.channels.iter().map(|v| v.to_bits()).eq(stored.iter().map(|v| v.to_bits())),
            "{}",
            clip.name
        );
        // The rate is said where it is not what readers take.
        let said = (clip.rate_hz != 120.0).then_some(1.0 / clip.rate_hz);
        assert_eq!(read.value.frame_time_s, said, "{}", clip.name);
    }
    let original = fs::read(demo().join("demo/captures/p01/p01.asf")).unwrap();
    assert_eq!(fs::read(folder.path().join("amc/captures/p01/walk_01.asf")).unwrap(), original);
}

#[test]
fn a_converted_clip_keeps_its_place_and_a_bvh_of_a_corpus_is_written_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let corpus = demo().join(CORPUS);
    let export = |corpus: &str, out: &str| {
        mill(folder.path(), &["export", corpus, "walk_01", "run_01", "--format", "bvh", "--out", out])
    };
    let converted = export(corpus.to_str().unwrap(), "take");
    assert_eq!(converted.code, 0, "{}", converted.err);
    assert!(converted.err.contains("2 clips converted"), "{}", converted.err);
    // A corpus of the BVH files: exported again they are the same files.
    let annotated = mill(folder.path(), &["run", "annotate", "--input", "take", "--set", "inputs.unit_m=0.0564444444"]);
    assert_eq!(annotated.code, 0, "{}", annotated.err);
    assert_eq!(export("corpus", "again").code, 0);
    let file = "captures/p01/walk_01.bvh";
    let (first, again) = (folder.path().join("take").join(file), folder.path().join("again/take").join(file));
    assert_eq!(fs::read(&first).unwrap(), fs::read(again).unwrap());
    let motion = read_bvh(&fs::read(&first).unwrap(), &ReadOptions::default()).unwrap().value;
    let row = clips().into_iter().find(|clip| clip.name.ends_with("/walk_01")).unwrap();
    assert_eq!(motion.n_frames, row.frames as usize);
    // The same positions, frame by frame, as the clip that it was made from.
    let own = Catalog::open(&Store::new(&corpus)).unwrap();
    let own = own.shard_of(row.clip_id).unwrap().labels(row.clip_id).unwrap().unwrap();
    let store = Store::new(folder.path().join("corpus"));
    let other = read_clips(&store).unwrap().into_iter().find(|clip| clip.name.ends_with("/walk_01")).unwrap();
    let labels =
        Catalog::open(&store).unwrap().shard_of(other.clip_id).unwrap().labels(other.clip_id).unwrap().unwrap();
    let far = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3);
    assert!(!own.root.iter().zip(&labels.root).any(|(a, b)| far(a, b)));
    assert_eq!(own.root.len(), labels.root.len());
    // And back: BVH to Acclaim.
    let back = mill(folder.path(), &["export", "corpus", "walk_01", "--format", "amc", "--out", "back"]);
    assert_eq!(back.code, 0, "{}", back.err);
    let checked = mill(folder.path(), &["check", "annotate", "--input", "back"]);
    assert!(checked.code == 0 && checked.out.contains("check    no mistake"), "{}", checked.out);
}

#[test]
fn export_overwrites_nothing_by_surprise() {
    let folder = tempfile::tempdir().unwrap();
    // Two clips of one last name.
    for part in ["a", "b"] {
        let (from, to) = (demo().join("demo/captures/p01"), folder.path().join("twins").join(part));
        fs::create_dir_all(&to).unwrap();
        fs::copy(from.join("p01.asf"), to.join("walk.asf")).unwrap();
        let clip = if part == "a" { "walk_01.amc" } else { "run_01.amc" };
        fs::copy(from.join(clip), to.join("walk.amc")).unwrap();
    }
    assert_eq!(mill(folder.path(), &["run", "annotate", "--input", "twins"]).code, 0);
    let export = |more: &[&str]| {
        let args = ["export", "corpus", "a/walk", "b/walk", "a/walk", "--format", "amc", "--out", "out"];
        mill(folder.path(), &[&args[..], more].concat())
    };
    let first = export(&[]);
    assert_eq!(first.out, "out/twins/a/walk.asf\nout/twins/a/walk.amc\nout/twins/b/walk.asf\nout/twins/b/walk.amc\n");
    let read = |part: &str| fs::read(folder.path().join("out/twins").join(part).join("walk.amc")).unwrap();
    assert_ne!(read("a"), read("b"));
    assert_eq!(export(&[]).code, 0, "the same bytes may be written again");
    fs::write(folder.path().join("out/twins/b/walk.amc"), "mine").unwrap();
    let kept = export(&[]);
    assert_eq!(kept.code, 1);
    assert!(kept.err.contains("error: out/twins/b/walk.amc: there is another file of this name\n"), "{}", kept.err);
    assert_eq!(read("b"), b"mine");
    assert_eq!(export(&["--force"]).code, 0);
    assert_ne!(read("b"), b"mine");
    let place = folder.path().join("corpus/x");
    let inside =
        mill(folder.path(), &["export", "corpus", "a/walk", "--format", "amc", "--out", place.to_str().unwrap()]);
    assert!(inside.code == 1 && inside.err.contains("inside the corpus"), "{}", inside.err);
}

#[test]
fn verify_sees_a_flipped_bit() {
    let copy = copy();
    let whole = mill(copy.path(), &["verify", CORPUS]);
    assert_eq!(whole.code, 0, "{}", whole.out);
    assert!(whole.out.ends_with(": every one as it was written\n"), "{}", whole.out);
    let path = copy.path().join(CORPUS).join("annotations/shard-00000.parquet");
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).unwrap();
    fs::remove_file(copy.path().join(CORPUS).join("nodes.parquet")).unwrap();
    let flipped = mill(copy.path(), &["verify", CORPUS]);
    assert_eq!(flipped.code, 1);
    assert!(flipped.out.contains("fault: demo/corpus/annotations/shard-00000.parquet: not what was written\n"));
    assert!(flipped.out.contains("fault: demo/corpus/nodes.parquet: missing\n"), "{}", flipped.out);
    assert!(flipped.out.ends_with("; 2 files are not as written\n"), "{}", flipped.out);
    let value = json(copy.path(), &["verify", CORPUS, "--json"]);
    let kinds: Vec<&str> = value["findings"].as_array().unwrap().iter().map(|f| f["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["changed", "missing"]);
    assert_eq!(mill(copy.path(), &["verify", "demo/captures"]).code, 1);
    // Looking at a damaged table is an error in three lines, not a crash.
    let clips = copy.path().join(CORPUS).join("clips.parquet");
    let half = fs::read(&clips).unwrap();
    fs::write(&clips, &half[..half.len() / 2]).unwrap();
    let damaged = mill(copy.path(), &["inspect", CORPUS]);
    assert_eq!((damaged.code, damaged.err.lines().count()), (1, 3), "{}", damaged.err);
    assert!(damaged.err.starts_with("error: demo/corpus/clips.parquet: damaged: "), "{}", damaged.err);
}

#[test]
fn a_corpus_that_another_run_holds_is_left_alone() {
    let copy = copy();
    let held = open_to_run(copy.path().join(CORPUS)).unwrap();
    let told = mill(copy.path(), &RUN);
    assert_eq!(told.code, 1);
    let process = format!("demo/corpus: another run is at work in this corpus (process {})\n", std::process::id());
    assert!(told.err.contains(&process) && told.err.contains("\n  try: wait for it"), "{}", told.err);
    assert_eq!(mill(copy.path(), &["inspect", CORPUS]).code, 0, "looking needs no lock");
    drop(held);
    assert_eq!(mill(copy.path(), &RUN).code, 0);
}

#[test]
fn synth_writes_the_bench_and_its_noise_as_positions_of_every_joint() {
    let folder = tempfile::tempdir().unwrap();
    let bench = ["synth", "--bench", "--clips", "2", "--out", "made", "--format"];
    assert_eq!(mill(folder.path(), &[&bench[..], &["bvh"]].concat()).code, 0);
    let file = folder.path().join("made/b01/walk_back_01.bvh");
    let sixes = |text: &str| text.matches("CHANNELS 6").count();
    let clean = fs::read_to_string(&file).unwrap();
    assert_eq!((sixes(&clean), clean.matches("CHANNELS 3").count()), (1, 30));
    assert!(folder.path().join("made/b01/walk_back_01.truth.csv").exists());
    assert_eq!(mill(folder.path(), &[&bench[..], &["bvh", "--noise-mm", "5"]].concat()).code, 0);
    assert_eq!(sixes(&fs::read_to_string(&file).unwrap()), 31);
    for (format, option, value, words) in [
        ("amc", "--noise-mm", "5", "--format bvh"),
        ("bvh", "--noise-mm", "1000.5", "a number of millimetres from 0 to 1000 is needed"),
        ("bvh", "--noise-mm", "nan", "from 0 to 1000 is needed"),
        ("bvh", "--noise-mm", "inf", "from 0 to 1000 is needed"),
        ("bvh", "--noise-mm=-1", "--bench", "from 0 to 1000 is needed"),
        ("bvh", "--clips=0", "--bench", "a whole number from 1 to 1000000 is needed"),
        ("bvh", "--clips=1000001", "--bench", "a whole number from 1 to 1000000 is needed"),
    ] {
        let said = mill(folder.path(), &["synth", "--out", "made", "--format", format, option, value]);
        assert!(said.code == 2 && said.err.contains(words), "{option} {value}: {} {}", said.code, said.err);
    }
}

/// Every example of the verbs that look, as the help shows it, in a shell.
#[cfg(unix)]
#[test]
fn the_examples_in_the_help_work() {
    let copy = copy();
    fs::create_dir(copy.path().join("cmu")).unwrap();
    for file in ["p01.asf", "walk_01.amc"] {
        fs::copy(copy.path().join("demo/captures/p01").join(file), copy.path().join("cmu").join(file)).unwrap();
    }
    let program = Path::new(env!("CARGO_BIN_EXE_motionmill"));
    let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
    for verb in ["run", "inspect", "search", "export", "synth", "evaluate", "check", "verify"] {
        let help = mill(copy.path(), &[verb, "--help"]).out;
        let examples: Vec<&str> = help
            .lines()
            .skip_while(|line| *line != "Examples:")
            .skip(1)
            .filter_map(|line| line.strip_prefix("  ").filter(|line| line.starts_with("motionmill ")))
            .collect();
        assert_eq!(examples.len(), 2, "{verb}: {help}");
        // Those of `run` and `synth` take longer, and run with other words in the tests above.
        for example in examples.iter().filter(|_| !["run", "synth"].contains(&verb)) {
            let shell = format!("set -o pipefail; {example}");
            let mut command = Command::new("bash");
            let said = said(command.current_dir(copy.path()).env("PATH", &path).args(["-c", &shell]).output().unwrap());
            assert_eq!(said.code, 0, "{example}: {}{}", said.out, said.err);
            assert!(!said.out.is_empty(), "{example}");
        }
    }
}
