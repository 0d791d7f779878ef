//! What happens to a corpus later (DESIGN 4): nothing where nothing changed; clips that come, change, go or are broken; other
//! settings; and that it can be made as if from nothing again.

use crate::running::*;
use motionmill::corpus::{Catalog, ClipRow, Store, open_to_read};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[test]
fn a_run_on_a_finished_corpus_changes_no_file() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    copy(&reference.folder.path().join("corpus"), &out);
    let times = || -> Vec<_> {
        let files = files_below(&out).into_iter().filter(|path| !path.ends_with(".lock"));
        files.map(|path| (fs::metadata(&path).unwrap().modified().unwrap(), path)).collect()
    };
    let before = times();
    let ended = run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
    assert_eq!((ended.parsed(), &ended.json()["up_to_date"]), (0, &Value::Bool(true)));
    assert_eq!(times(), before);
    let words = ["run", "enrich", "--out", out.to_str().unwrap(), "--input", a.to_str().unwrap()];
    let said = Running::start(&[&words[..], &["--input", b.to_str().unwrap()], &SMALL[..]].concat()).end().with(0);
    assert_eq!(said.out, "corpus is up to date (12 clips); nothing to do\n");
    // Files that somebody deleted are made anew, and no others.
    for name in ["clips.parquet", "edges.parquet", "recipes.parquet", "made.parquet", "README.md"] {
        fs::remove_file(out.join(name)).unwrap();
    }
    for folder in ["merges", "features", "channels"] {
        fs::remove_file(files_below(&out.join(folder)).remove(0)).unwrap();
    }
    run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
    reference.equals(&out, "after files were deleted");
}

#[test]
fn another_threshold_makes_the_labels_anew_without_parsing() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (out, fresh) = (folder.path().join("out"), folder.path().join("fresh"));
    let threshold = ["-w", "2", "--set", "contacts.detector=thesis"];
    run("graph", &[a, b], &out, &["-w", "2"]).with(0);
    let before = digests(&out);
    // A kill between: the files of one threshold must not pass for those of the other.
    let running = start("graph", &[a, b], &out, &threshold);
    std::thread::sleep(reference.took / 6);
    running.signal("-KILL");
    running.end();
    assert_eq!(run("graph", &[a, b], &out, &["-w", "2"]).with(0).parsed(), 0);
    same(&before, &digests(&out), "back at the first threshold");
    assert_eq!(run("graph", &[a, b], &out, &threshold).with(0).parsed(), 0);
    assert_eq!(run("graph", &[a, b], &fresh, &threshold).with(0).parsed(), 12);
    same(&digests(&fresh), &digests(&out), "another threshold");
    assert_ne!(digests(&out), before);
}

#[test]
fn a_kill_after_the_last_shard_does_not_leave_old_tables_behind() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    run("annotate", &[a], &out, &["-w", "1"]).with(0);
    let old = fs::read(out.join("clips.parquet")).unwrap();
    let given = || open_to_read(&out).unwrap().1.next_shard;
    let shards = || fs::read_dir(out.join("commits")).unwrap().count() as u32;
    let first = given();
    let running = start("annotate", &[a, b], &out, &["-w", "1"]);
    // Stopped the moment that all shards are there: before, in or after the fold.
    while (given() == first || shards() < given()) && running.since.elapsed() < DEADLINE / 2 {
        std::thread::sleep(Duration::from_millis(1));
    }
    running.signal("-KILL");
    running.end();
    run("annotate", &[a, b], &out, &["-w", "1"]).with(0);
    assert_ne!(fs::read(out.join("clips.parquet")).unwrap(), old);
    let rows = rows(&out);
    assert_eq!(rows.len(), 12, "{:?}", rows.keys());
}

/// Rows by full name, but for numbers that depend on history.
fn rows(corpus: &Path) -> BTreeMap<String, ClipRow> {
    let (store, _) = open_to_read(corpus).unwrap();
    let clips = motionmill::corpus::read_clips(&store).unwrap();
    clips.into_iter().map(|row| (row.full_name(), ClipRow { clip_id: 0, ..row })).collect()
}

#[test]
fn a_grown_corpus_holds_the_rows_of_a_fresh_one() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out, fresh) = (folder.path().join("a"), folder.path().join("out"), folder.path().join("fresh"));
    copy(a, &input);
    let later: Vec<PathBuf> = files_below(&input)
        .into_iter()
        .filter(|path| path.extension().is_some_and(|e| e == "amc"))
        .step_by(2)
        .collect();
    let aside = folder.path().join("aside");
    fs::create_dir(&aside).unwrap();
    for (n, file) in later.iter().enumerate() {
        fs::rename(file, aside.join(n.to_string())).unwrap();
    }
    let first = run("annotate", &[&input], &out, &["-w", "2"]).with(0);
    assert_eq!(first.parsed(), 7 - later.len() as u64);
    for (n, file) in later.iter().enumerate() {
        fs::rename(aside.join(n.to_string()), file).unwrap();
    }
    assert_eq!(run("annotate", &[&input, b], &out, &["-w", "2"]).with(0).parsed(), 5 + later.len() as u64);
    run("annotate", &[&input, b], &fresh, &["-w", "2"]).with(0);
    assert_eq!(rows(&out), rows(&fresh));
    let [grown, fresh] = [&out, &fresh].map(|corpus| Catalog::open(&Store::new(corpus)).unwrap());
    for row in fresh.clips() {
        let twin = grown.clips().find(|twin| twin.full_name() == row.full_name()).unwrap();
        let (here, there) = (fresh.shard_of(row.clip_id).unwrap(), grown.shard_of(twin.clip_id).unwrap());
        let name = row.full_name();
        assert_eq!(here.channels(row.clip_id).unwrap(), there.channels(twin.clip_id).unwrap(), "{name}");
        assert_eq!(here.labels(row.clip_id).unwrap(), there.labels(twin.clip_id).unwrap(), "{name}");
        assert_eq!(here.plants(row.clip_id).unwrap(), there.plants(twin.clip_id).unwrap(), "{name}");
        assert_eq!(here.features(row.clip_id).unwrap().values, there.features(twin.clip_id).unwrap().values, "{name}");
    }
}

#[test]
fn a_changed_clip_is_read_again_and_a_gone_one_stays_until_it_is_pruned() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("b"), folder.path().join("corpus"));
    copy(b, &input);
    let clips: Vec<PathBuf> =
        files_below(&input).into_iter().filter(|path| path.extension().is_some_and(|e| e == "bvh")).collect();
    // One shard for all: what happens to one clip happens to its neighbors' shard.
    let whole = ["-w", "2", "--set", "shards.text_bytes=100000000", "--set", "shards.min_count=1"];
    run("annotate", &[a, &input], &out, &whole).with(0);
    let old = rows(&out);
    let text = fs::read_to_string(&clips[0]).unwrap();
    let frames = text.lines().find_map(|line| line.strip_prefix("Frames:")).unwrap().trim().to_owned();
    let fewer = (frames.parse::<u32>().unwrap() - 1).to_string();
    let without_last = text.trim_end().rsplit_once('\n').unwrap().0;
    let header = format!("Frames: {frames}");
    assert!(without_last.contains(&header));
    fs::write(&clips[0], without_last.replacen(&header, &format!("Frames: {fewer}"), 1) + "\n").unwrap();
    fs::remove_file(&clips[1]).unwrap();
    // The source of the other clips in the shard is not even named this time.
    let ended = run("annotate", &[&input], &out, &whole).with(0);
    assert_eq!(ended.parsed(), 4, "the changed clip and its neighbors that are there");
    assert_eq!(ended.json()["gone"].as_array().unwrap().len(), 1);
    assert!(
        ended.err.contains("its file has gone, or the config skips it; its rows stay (--prune removes them)"),
        "{}",
        ended.err
    );
    let now = rows(&out);
    assert_eq!(old.keys().collect::<Vec<_>>(), now.keys().collect::<Vec<_>>());
    let differ: Vec<u32> = old.iter().filter(|(name, row)| now[*name] != **row).map(|(_, row)| row.frames).collect();
    assert_eq!(differ, [frames.parse::<u32>().unwrap()], "one clip has changed, by a frame");
    assert_eq!(run("annotate", &[a, &input], &out, &whole).with(0).json()["gone"].as_array().unwrap().len(), 1);
    let pruned = run("annotate", &[a, &input], &out, &[&whole[..], &["--prune"]].concat()).with(0);
    assert_eq!(pruned.json()["gone"].as_array().unwrap().len(), 1);
    assert_eq!(rows(&out).len(), 11);
    let again = run("annotate", &[a, &input], &out, &whole).with(0);
    assert_eq!(again.json()["up_to_date"], Value::Bool(true));
}

#[test]
fn a_broken_clip_is_left_out_and_read_again_once_it_is_mended() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out, fresh) = (folder.path().join("b"), folder.path().join("corpus"), folder.path().join("fresh"));
    copy(b, &input);
    let clip = files_below(&input).into_iter().find(|path| path.extension().is_some_and(|e| e == "bvh")).unwrap();
    let text = fs::read_to_string(&clip).unwrap();
    fs::write(&clip, &text[..text.len() / 2]).unwrap();
    // Finite numbers that no position holds, in metres.
    let as_metres = ["-w", "2", "--set", "inputs.unit_m=1"];
    let huge = "HIERARCHY\nROOT hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\nJOINT leg\n{\nOFFSET 3e38 3e38 0\nEnd Site\n{\nOFFSET 3e38 3e38 0\n}\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n3e38 3e38 0\n3e38 3e38 0\n";
    fs::write(input.join("huge.bvh"), huge).unwrap();
    for parsed in [13, 0] {
        let ended = run("graph", &[a, &input], &out, &as_metres).with(3);
        assert_eq!((ended.parsed(), &ended.json()["quarantined"]), (parsed, &Value::from(2)));
    }
    let (store, _) = open_to_read(&out).unwrap();
    let faults = motionmill::corpus::read_faults(&store).unwrap();
    let faulted: Vec<&str> = faults
        .iter()
        .filter(|row| row.notice.severity == motionmill::motion::Severity::Fault)
        .map(|row| row.name.as_str())
        .collect();
    let name = clip.strip_prefix(&input).unwrap().with_extension("");
    assert_eq!(faulted, ["huge", name.to_str().unwrap()]);
    assert_eq!(rows(&out).len(), 11);
    // Another threshold must not bring them back, nor fail on them.
    let threshold = ["-w", "2", "--set", "inputs.unit_m=1", "--set", "contacts.detector=thesis"];
    run("graph", &[a, &input], &out, &threshold).with(3);
    assert_eq!(run("graph", &[a, &input], &out, &threshold).with(3).json()["up_to_date"], Value::Bool(true));
    fs::remove_file(input.join("huge.bvh")).unwrap();
    fs::write(&clip, &text).unwrap();
    let mended = run("graph", &[a, &input], &out, &[&as_metres[..], &["--prune"]].concat()).with(0);
    assert_eq!(mended.json()["quarantined"], Value::from(0));
    run("graph", &[a, &input], &fresh, &as_metres).with(0);
    assert_eq!(rows(&out), rows(&fresh));
}

/// A corpus that was fed in four runs, with a clip that changed and one that went, is made anew: the same files as from one run.
#[test]
fn a_compacted_corpus_has_the_bytes_of_one_run_over_all_inputs() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("a"), folder.path().join("corpus"));
    copy(a, &input);
    let clips: Vec<PathBuf> =
        files_below(&input).into_iter().filter(|path| path.extension().is_some_and(|e| e == "amc")).collect();
    let whole = fs::read(&clips[2]).unwrap();
    let aside = folder.path().join("aside");
    fs::rename(&clips[0], &aside).unwrap();
    fs::write(&clips[2], &whole[..whole.len() / 2]).unwrap();
    run("annotate", &[&input], &out, &["-w", "2"]);
    fs::rename(&aside, &clips[0]).unwrap();
    fs::write(&clips[2], &whole).unwrap();
    let twin = clips[0].with_file_name("twin.amc");
    fs::copy(&clips[0], &twin).unwrap();
    run("enrich", &[&input], &out, &["-w", "2"]).with(0);
    fs::remove_file(&twin).unwrap();
    run("enrich", &[&input, b], &out, &["-w", "2", "--prune"]).with(0);
    assert_ne!(digests(&out).keys().collect::<Vec<_>>(), reference.files.keys().collect::<Vec<_>>());
    fs::write(out.join("notes.txt"), "mine").unwrap();
    // No input is read for it.
    let gone = folder.path().join("gone");
    fs::rename(&input, &gone).unwrap();
    let compact = |corpus: &Path| ["compact".to_owned(), corpus.to_str().unwrap().to_owned(), "--json".to_owned()];
    let words = compact(&out);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    // Killed twice before it is done.
    for part in [0.15, 0.4] {
        let running = Running::start(&words);
        std::thread::sleep(reference.took.mul_f64(part));
        running.signal("-KILL");
        running.end();
    }
    let ended = Running::start(&words).end().with(0);
    assert_eq!(ended.json()["after"]["clips"], ended.json()["before"]["clips"], "{}", ended.out);
    assert_eq!(fs::read_to_string(out.join("notes.txt")).unwrap(), "mine");
    fs::remove_file(out.join("notes.txt")).unwrap();
    reference.equals(&out, "compacted");
    let beside: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(beside.iter().all(|name| !name.to_str().unwrap().starts_with('.')), "{beside:?}");
    fs::rename(&gone, &input).unwrap();
    let again = run("enrich", &[&input, b], &out, &["-w", "2"]).with(0);
    assert_eq!(again.json()["up_to_date"], Value::Bool(true));
}

#[test]
fn a_flipped_bit_is_never_taken_for_a_number_and_a_cut_file_is_made_anew() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    for table in ["channels", "features", "annotations"] {
        let out = folder.path().join(table);
        copy(&reference.folder.path().join("corpus"), &out);
        let file = captured_file(&out, table);
        let sound = fs::read(&file).unwrap();
        flip(&file);
        // What reads it: labels and grafts read channels, trees read features and plant states.
        let changed = match table {
            "channels" => "contacts.detector=thesis",
            _ => "cluster.t_max_m2=0.4",
        };
        let ended = run("enrich", &[a, b], &out, &["-w", "2", "--set", changed]).fails_with("damaged");
        assert!(ended.err.contains(file.file_name().unwrap().to_str().unwrap()), "{}", ended.err);
        fs::write(&file, &sound[..sound.len() / 2]).unwrap();
        run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
        reference.equals(&out, &format!("after a file of {table} was cut"));
    }
}

#[test]
fn strict_counts_on_a_corpus_that_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("a"), folder.path().join("corpus"));
    synth(&input, 3, 5, "bvh");
    let clip = files_below(&input).into_iter().find(|path| path.extension().is_some_and(|e| e == "bvh")).unwrap();
    let text = fs::read_to_string(&clip).unwrap();
    let declared = text.lines().find(|line| line.starts_with("Frames:")).unwrap();
    fs::write(&clip, text.replacen(declared, "Frames: 7", 1)).unwrap();
    run("annotate", &[&input], &out, &[]).with(0);
    assert_eq!(rows(&out).len(), 3);
    run("annotate", &[&input], &out, &["--strict"]).with(3);
    assert_eq!(rows(&out).len(), 2);
    run("annotate", &[&input], &out, &[]).with(0);
    assert_eq!(rows(&out).len(), 3);
}

#[test]
fn what_never_came_to_a_shard_counts_as_quarantined_and_an_absurd_place_costs_its_clip_alone() {
    let reference = Reference::get();
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("b"), folder.path().join("corpus"));
    copy(&reference.inputs()[1], &input);
    fs::write(input.join("alone.amc"), ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n").unwrap();
    let clip = files_below(&input).into_iter().find(|path| path.extension().is_some_and(|e| e == "bvh")).unwrap();
    let text = fs::read_to_string(&clip).unwrap();
    let (head, rows_of_it) = text.rsplit_once("Frame Time").unwrap();
    let mut lines: Vec<String> = rows_of_it.lines().map(str::to_owned).collect();
    lines[3] = lines[3].replacen(lines[3].split_whitespace().next().unwrap(), "1e12", 1);
    fs::write(&clip, format!("{head}Frame Time{}\n", lines.join("\n"))).unwrap();
    let ended = run("enrich", &[&input], &out, &["-w", "2"]).with(3);
    assert_eq!(ended.json()["quarantined"], Value::from(2), "{}", ended.err);
    assert_eq!(rows(&out).values().filter(|row| !row.origin.is_made()).count(), 4);
    let (store, _) = open_to_read(&out).unwrap();
    let faults = motionmill::corpus::read_faults(&store).unwrap();
    let absurd = faults.iter().find(|row| row.notice.kind == "position-absurd").unwrap();
    assert_eq!(absurd.notice.frame, Some(2), "{:?}", absurd.notice);
}

#[test]
fn another_folder_of_the_same_name_is_noticed() {
    let reference = Reference::get();
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("b"), folder.path().join("corpus"));
    run("annotate", &[&reference.inputs()[1]], &out, &[]).with(0);
    synth(&input, 2, 77, "bvh");
    let ended = run("annotate", &[&input], &out, &[]).with(0);
    assert!(ended.err.contains("warning: source `b`: none of its clips is as it was"), "{}", ended.err);
}

/// One skeleton, since ends don't count in its id; and yet two clips whose heads end elsewhere.
#[test]
fn a_clip_that_is_taken_from_the_corpus_keeps_its_own_ends() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("a"), folder.path().join("corpus"));
    synth(&folder.path().join("made"), 1, 5, "bvh");
    let made = files_below(&folder.path().join("made"));
    let clip = made.into_iter().find(|path| path.extension().is_some_and(|e| e == "bvh")).unwrap();
    let text = fs::read_to_string(&clip).unwrap();
    let (before, after) = text.split_once("End Site").unwrap();
    let line = after.lines().find(|line| line.trim_start().starts_with("OFFSET")).unwrap();
    fs::create_dir(&input).unwrap();
    fs::write(input.join("first.bvh"), &text).unwrap();
    let longer = format!("{before}End Site{}", after.replacen(line, "OFFSET 1 2 3", 1));
    fs::write(input.join("second.bvh"), longer).unwrap();
    run("annotate", &[&input], &out, &[]).with(0);
    let catalog = Catalog::open(&Store::new(&out)).unwrap();
    let ids: Vec<(u32, String)> = catalog.clips().map(|row| (row.clip_id, row.skeleton.clone())).collect();
    assert_eq!((ids.len(), &ids[0].1), (2, &ids[1].1));
    let bodies = ids.iter().map(|(id, _)| catalog.shard_of(*id).unwrap().skeleton(*id).unwrap().body.clone());
    let bodies: Vec<_> = bodies.collect();
    assert_ne!(bodies[0], bodies[1]);
    let whole = digests(&out);
    Running::start(&["compact", out.to_str().unwrap()]).end().with(0);
    same(&whole, &digests(&out), "compacted");
}
