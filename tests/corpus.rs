//! The corpus as a whole: commits, kills, the lock, digests, names, the card.

use crate::corpus_samples::{Dice, SampleClip, all_tables, clip_row, commit, fault_row, record_of, sample_clips};
use motionmill::corpus::*;
use std::fs;

fn folder_and_store() -> (tempfile::TempDir, Store) {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::new(folder.path());
    (folder, store)
}

fn labels_only() -> ShardSettings {
    let tables = vec![Table::Annotations, Table::Plants, Table::Segments];
    ShardSettings { tables, ..ShardSettings::default() }
}

fn finished(store: &Store, clips: &[SampleClip], settings: ShardSettings) -> FinishedShard {
    let mut writer = ShardWriter::create(store, ShardId::captured(0), settings);
    clips.iter().for_each(|clip| writer.push(&clip.tables()).unwrap());
    writer.finish().unwrap()
}

/// Clips that all have labels.
fn labelled(seed: u64) -> Vec<SampleClip> {
    (seed..).map(|seed| sample_clips(seed, 4, 30)).find(|clips| clips.iter().all(|clip| clip.labels.is_some())).unwrap()
}

#[test]
fn a_shard_without_its_record_is_not_there() {
    let (folder, store) = folder_and_store();
    let clips = sample_clips(1, 4, 30);
    // Killed before the renames: temporary files stay.
    std::mem::forget(finished(&store, &clips, all_tables()));
    assert!(store.list("").unwrap().iter().all(|name| name.ends_with(".partial")));
    assert!(read_records(&store).unwrap().is_empty());
    // Killed before the record.
    let record = commit(&store, ShardId::captured(0), &clips, all_tables());
    fs::remove_file(folder.path().join("commits/shard-00000.json")).unwrap();
    fs::write(folder.path().join("poses/notes.txt"), "mine").unwrap();
    fs::write(folder.path().join("channels/mine.parquet"), "mine").unwrap();
    assert!(Catalog::open(&store).unwrap().clips().next().is_none());
    // The next run clears them away, and nothing of the user's.
    let open = open_to_run(folder.path()).unwrap();
    let wanted: Vec<String> = record.files.iter().map(|file| file.path.clone()).collect();
    assert_eq!(open.cleared, wanted);
    let left: Vec<String> = store.list("").unwrap().into_iter().filter(|name| !name.starts_with('.')).collect();
    assert_eq!(left, ["channels/mine.parquet", "poses/notes.txt"]);
    drop(open);
    // Dropped without a commit: nothing stays at all.
    drop(finished(&store, &clips, all_tables()));
    assert_eq!(store.list("").unwrap().len(), 3, "{:?}", store.list(""));
}

#[test]
fn labels_alone_can_be_made_anew() {
    let (_folder, store) = folder_and_store();
    let clips = labelled(7);
    let before = commit(&store, ShardId::captured(0), &clips, all_tables());
    let mut other = clips.clone();
    for clip in &mut other {
        clip.labels.as_mut().unwrap().speed.iter_mut().for_each(|speed| *speed += 1.0);
        clip.plants.clear();
    }
    let mut record = record_of(ShardId::captured(0), &other);
    record.keys.labels = "l2".to_owned();
    let after = finished(&store, &other, labels_only()).commit(record).unwrap();
    assert_eq!(read_record(&store, ShardId::captured(0)).unwrap().unwrap(), after);
    for (old, new) in before.files.iter().zip(&after.files) {
        let relabelled = ["annotations/", "plants/"].iter().any(|table| old.path.starts_with(table));
        let had = old.rows > 0;
        assert_eq!((old.path == new.path, old == new), (true, !(relabelled && had)), "{}", old.path);
    }
    let catalog = Catalog::open(&store).unwrap();
    for clip in &other {
        let id = clip.row.clip_id;
        let shard = catalog.shard_of(id).unwrap();
        assert_eq!(shard.labels(id).unwrap(), clip.labels);
        assert!(shard.plants(id).unwrap().is_empty());
        assert_eq!(shard.channels(id).unwrap(), clip.channels);
    }
}

#[test]
fn a_kill_while_labels_are_replaced_leaves_a_stage_to_make_and_no_lie() {
    let (folder, store) = folder_and_store();
    let clips = labelled(9);
    commit(&store, ShardId::captured(0), &clips, all_tables());
    // The rename of plants fails, after that of annotations: as if killed between them.
    let plants = folder.path().join("plants/shard-00000.parquet");
    fs::remove_file(&plants).unwrap();
    fs::create_dir_all(plants.join("in the way")).unwrap();
    let mut record = record_of(ShardId::captured(0), &clips);
    record.keys.labels = "l2".to_owned();
    let error = finished(&store, &clips, labels_only()).commit(record.clone()).unwrap_err();
    assert!(error.to_string().contains("plants"), "{error}");
    let between = read_record(&store, ShardId::captured(0)).unwrap().unwrap();
    assert_eq!(between.keys, StageKeys { ingest: "i1".to_owned(), features: "f1".to_owned(), labels: String::new() });
    assert!(between.files.iter().all(|file| Table::of_file(&file.path).unwrap().stage() != ShardStage::Labels));
    let catalog = Catalog::open(&store).unwrap();
    let id = clips[0].row.clip_id;
    let shard = catalog.shard_of(id).unwrap();
    assert!(matches!(shard.labels(id), Err(CorpusError::NotThere { .. })));
    assert_eq!(shard.channels(id).unwrap(), clips[0].channels);
    let found = verify(&store).unwrap().findings;
    assert!(found.contains(&Finding { path: "commits/shard-00000.json".to_owned(), what: Wrong::Unfinished }));
    // The next run makes the stage again.
    fs::remove_dir_all(&plants).unwrap();
    let open = open_to_run(folder.path()).unwrap();
    assert!(open.cleared.contains(&"annotations/shard-00000.parquet".to_owned()), "{:?}", open.cleared);
    let whole = finished(&store, &clips, labels_only()).commit(record).unwrap();
    assert_eq!(Catalog::open(&store).unwrap().shard_of(id).unwrap().labels(id).unwrap(), clips[0].labels);
    assert_eq!(whole.keys.labels, "l2");
}

#[test]
fn a_layout_that_is_gone_takes_its_files_with_it() {
    let (_folder, store) = folder_and_store();
    let many = (0..)
        .map(|seed| sample_clips(seed, 6, 9))
        .find(|clips| clips.iter().any(|clip| clip.row.layout != clips[0].row.layout));
    let many = many.unwrap();
    let one: Vec<SampleClip> = many.iter().filter(|clip| clip.row.layout == many[0].row.layout).cloned().collect();
    let before = commit(&store, ShardId::captured(0), &many, all_tables());
    let after = commit(&store, ShardId::captured(0), &one, all_tables());
    assert!(after.files.len() < before.files.len());
    let lying: Vec<String> =
        store.list("").unwrap().into_iter().filter(|name| ShardId::of_file(name).is_some()).collect();
    let mut wanted: Vec<String> = after.files.iter().map(|file| file.path.clone()).collect();
    wanted.push("commits/shard-00000.json".to_owned());
    wanted.sort();
    assert_eq!(lying, wanted);
}

#[test]
fn a_shard_can_take_the_place_of_others() {
    let (folder, store) = folder_and_store();
    let clips = sample_clips(3, 4, 9);
    commit(&store, ShardId::captured(0), &clips[..2], all_tables());
    commit(&store, ShardId::captured(1), &clips[2..], all_tables());
    let mut writer = ShardWriter::create(&store, ShardId::captured(2), all_tables());
    clips[..2].iter().for_each(|clip| writer.push(&clip.tables()).unwrap());
    let mut record = record_of(ShardId::captured(2), &clips[..2]);
    record.replaces = vec![ShardId::captured(0)];
    writer.finish().unwrap().commit(record).unwrap();
    assert!(!store.is_there("commits/shard-00000.json"));
    // Killed before the old one is removed: it counts as gone already.
    let old = commit(&store, ShardId::captured(0), &clips[..2], all_tables());
    let catalog = Catalog::open(&store).unwrap();
    assert_eq!(catalog.shard_of(clips[0].row.clip_id).unwrap().record().shard, ShardId::captured(2));
    let open = open_to_run(folder.path()).unwrap();
    let mut wanted: Vec<String> = old.files.iter().map(|file| file.path.clone()).collect();
    wanted.push("commits/shard-00000.json".to_owned());
    wanted.sort();
    assert_eq!(open.cleared, wanted);
    assert!(!store.is_there("commits/shard-00000.json"));
    assert_eq!(Catalog::open(&store).unwrap().clips().count(), 4);
    // One clip in two shards is refused.
    commit(&store, ShardId::captured(3), &clips[2..], all_tables());
    assert!(Catalog::open(&store).unwrap_err().to_string().contains("is in two shards"));
}

#[test]
fn rows_that_no_table_can_hold_are_refused_before_anything_is_written() {
    let (_folder, store) = folder_and_store();
    let clips = labelled(21);
    let good = &clips[0];
    let mut writer = ShardWriter::create(&store, ShardId::captured(0), all_tables());
    writer.push(&good.tables()).unwrap();
    type Break = fn(&mut SampleClip);
    let breaks: [(&str, Break); 8] = [
        ("channels", |clip| clip.channels.push(0.0)),
        ("poses", |clip| clip.poses.world[0].y = f64::NAN),
        ("poses", |clip| clip.rotations.local.clear()),
        ("annotations", |clip| clip.labels.as_mut().unwrap().phase.truncate(0)),
        ("annotations", |clip| clip.labels.as_mut().unwrap().heading[0] = Some(f32::INFINITY)),
        ("plants", |clip| {
            let position = [0.0; 3];
            let foot = motionmill::annotate::Foot::Left;
            let plant =
                motionmill::annotate::Plant { foot, first: 0, end: 31, position, slip_m: 0.0, confidence: None };
            clip.plants = vec![plant];
        }),
        ("provenance", |clip| {
            let row = motionmill::synthesis::ProvenanceRow {
                frame: 0,
                part: "tail",
                parent: 0,
                parent_frame: 0.0,
                weight: 1.0,
            };
            clip.provenance = vec![row];
        }),
        ("clips", |clip| clip.row.clip_id = 1),
    ];
    for (table, break_it) in breaks {
        let mut clip = clips[1].clone();
        break_it(&mut clip);
        match writer.push(&clip.tables()).unwrap_err() {
            CorpusError::Refused { table: refused, .. } => assert_eq!(refused, table),
            other => panic!("{other}"),
        }
    }
    writer.push(&clips[1].tables()).unwrap();
    let record = writer.finish().unwrap().commit(record_of(ShardId::captured(0), &clips[..2])).unwrap();
    let frames: u64 = clips[..2].iter().map(|clip| u64::from(clip.row.frames)).sum();
    assert_eq!(record.file(Table::Annotations, "").unwrap().rows, frames);
}

fn whole_corpus(folder: &std::path::Path) -> Store {
    let open = open_to_run(folder).unwrap();
    let store = open.store.clone();
    let clips = labelled(30);
    commit(&store, ShardId::captured(0), &clips, all_tables());
    let mut manifest = open.manifest;
    let catalog = Catalog::open(&store).unwrap();
    let folded = Folded::gather(&catalog, &[fault_row(&mut Dice(4))]);
    let terms = SourceTerms { source: "cmu".to_owned(), license: Some("free".to_owned()), attribution: None };
    manifest.note_files(folded.write(&store, &FileNotes::new()).unwrap());
    manifest.note_files([write_card(&store, &folded, &[terms]).unwrap()]);
    manifest.next_clip_id = 20;
    manifest.set_product("walk<-stand", u128::MAX);
    for clip in &clips {
        let entry = ClipEntry {
            clip_id: clip.row.clip_id,
            blake3: "0".repeat(64),
            skeleton_blake3: None,
            key: "key".to_owned(),
            bytes: 17,
            state: ClipState::Present,
            shard: ShardId::captured(0),
        };
        manifest.sources.entry(clip.row.source.clone()).or_default().clips.insert(clip.row.name.clone(), entry);
    }
    manifest.put(&store).unwrap();
    let (_, read) = open_to_read(folder).unwrap();
    assert_eq!(read, manifest);
    assert_eq!(read.product("walk<-stand"), Some(u128::MAX));
    store
}

#[test]
fn a_flipped_byte_is_found_in_every_file() {
    let (folder, _) = folder_and_store();
    let store = whole_corpus(folder.path());
    let verified = verify(&store).unwrap();
    assert_eq!(verified.findings, []);
    let files: Vec<String> = store.list("").unwrap().into_iter().filter(|name| !name.starts_with('.')).collect();
    assert!(verified.files >= 11 && files.len() == verified.files + 2, "{files:?}");
    let mut dice = Dice(77);
    for name in files {
        let whole = store.read(&name).unwrap().unwrap();
        for _ in 0..3 {
            let mut bytes = whole.clone();
            bytes[dice.below(whole.len())] ^= 1 << dice.below(8);
            fs::write(store.path(&name), &bytes).unwrap();
            let findings = verify(&store).unwrap().findings;
            assert!(findings.iter().any(|finding| finding.path == name), "{name}: {findings:?}");
        }
        fs::remove_file(store.path(&name)).unwrap();
        let findings = verify(&store).unwrap().findings;
        assert!(findings.contains(&Finding { path: name.clone(), what: Wrong::Missing }), "{name}: {findings:?}");
        fs::write(store.path(&name), &whole).unwrap();
    }
    assert_eq!(verify(&store).unwrap().findings, []);
    fs::write(store.path("poses/layout=L00000000/shard-00009.parquet.partial"), b"").unwrap_err();
    fs::write(store.path("plants/shard-00009.parquet"), b"").unwrap();
    fs::write(store.path("plants/shard-00000.parquet.partial"), b"").unwrap();
    assert_eq!(verify(&store).unwrap().findings.len(), 2);
}

#[test]
fn a_second_run_is_refused_and_reading_goes_on() {
    let (folder, _) = folder_and_store();
    assert!(matches!(open_to_read(folder.path()), Err(CorpusError::NotACorpus { .. })));
    let store = whole_corpus(folder.path());
    let first = open_to_run(folder.path()).unwrap();
    let error = open_to_run(folder.path()).unwrap_err();
    assert!(error.to_string().contains("another run is at work in this corpus"), "{error}");
    assert!(!error.remedy().is_empty() && !error.why().is_empty());
    check_token(&store, first.lock.token()).unwrap();
    assert!(check_token(&store, "0123").is_err());
    assert!(!read_clips(&store).unwrap().is_empty());
    drop(first);
    assert!(open_to_run(folder.path()).unwrap().cleared.is_empty());
}

#[test]
fn a_folder_with_other_things_in_it_is_left_alone() {
    let (folder, store) = folder_and_store();
    fs::write(folder.path().join("README.md"), "mine").unwrap();
    assert!(matches!(open_to_run(folder.path()), Err(CorpusError::Occupied { .. })));
    assert_eq!(store.list("").unwrap(), ["README.md"]);
    // In a corpus, a user's own files stay, whatever their endings.
    fs::remove_file(folder.path().join("README.md")).unwrap();
    drop(open_to_run(folder.path()).unwrap());
    fs::create_dir_all(folder.path().join("downloads")).unwrap();
    fs::write(folder.path().join("downloads/film.partial"), "mine").unwrap();
    fs::write(folder.path().join("film.partial"), "mine").unwrap();
    fs::write(folder.path().join("clips.parquet.partial"), "left").unwrap();
    assert_eq!(open_to_run(folder.path()).unwrap().cleared, ["clips.parquet.partial"]);
    assert!(folder.path().join("downloads/film.partial").is_file() && folder.path().join("film.partial").is_file());
}

#[test]
fn a_record_that_would_not_come_back_is_refused_before_the_old_one_goes() {
    let (_folder, store) = folder_and_store();
    let clips = sample_clips(50, 3, 9);
    let before = commit(&store, ShardId::captured(0), &clips, all_tables());
    type Break = fn(&mut ShardRecord);
    let breaks: [Break; 5] = [
        |record| record.clips[0].rate_hz = f64::NAN,
        |record| record.clips[0].labels.noise_m = Some(f32::INFINITY),
        |record| drop(record.clips.pop()),
        |record| record.skeletons.clear(),
        |record| record.shard = ShardId::made(0),
    ];
    for break_it in breaks {
        let mut record = record_of(ShardId::captured(0), &clips);
        break_it(&mut record);
        let error = finished(&store, &clips, all_tables()).commit(record).unwrap_err();
        assert!(matches!(error, CorpusError::Encoding { .. }), "{error}");
        assert_eq!(read_record(&store, ShardId::captured(0)).unwrap().unwrap(), before);
    }
    // A record may not name files of others.
    let text = String::from_utf8(store.read("commits/shard-00000.json").unwrap().unwrap()).unwrap();
    let rest = text.split_once('\n').unwrap().1.replace("plants/shard-00000", "plants/shard-00001");
    let sealed = format!("{{\"blake3\": \"{}\",\n{rest}", blake3::hash(rest.as_bytes()).to_hex());
    store.put_atomic("commits/shard-00000.json", sealed.as_bytes()).unwrap();
    let error = read_record(&store, ShardId::captured(0)).unwrap_err();
    assert!(error.to_string().contains("no file of it"), "{error}");
}

#[test]
fn another_version_is_named_and_damage_is_not_taken_for_it() {
    let (folder, _) = folder_and_store();
    let store = whole_corpus(folder.path());
    let text = String::from_utf8(store.read(MANIFEST).unwrap().unwrap()).unwrap();
    let rest = text.split_once('\n').unwrap().1.replace("\"format_version\": 2", "\"format_version\": 9, \"new\": 1");
    let sealed = format!("{{\"blake3\": \"{}\",\n{rest}", blake3::hash(rest.as_bytes()).to_hex());
    store.put_atomic(MANIFEST, sealed.as_bytes()).unwrap();
    assert!(matches!(open_to_read(folder.path()), Err(CorpusError::Version { found: 9, known: 2, .. })));
    store.put_atomic(MANIFEST, text.replace("present", "Present").as_bytes()).unwrap();
    assert!(matches!(open_to_read(folder.path()), Err(CorpusError::Damaged { .. })));
}

#[test]
fn records_fold_into_tables_whatever_the_split() {
    let clips = sample_clips(40, 6, 5);
    let folded = |cuts: &[usize]| {
        let (_folder, store) = folder_and_store();
        for (number, cut) in cuts.windows(2).enumerate() {
            let shard = ShardId::captured(number as u32);
            let mut record = record_of(shard, &clips[cut[0]..cut[1]]);
            for skeleton in &mut record.skeletons {
                let of = |clip: &&SampleClip| clip.row.skeleton == skeleton.skeleton_id;
                let first = clips[cut[0]..cut[1]].iter().filter(of).map(|clip| clip.row.name.clone()).min().unwrap();
                skeleton.header = format!("header of {first}");
                skeleton.first_clip = [String::new(), first];
            }
            let fault = fault_row(&mut Dice(8));
            record.faults = vec![fault; if number == 0 { 30 } else { 0 }];
            let writer = ShardWriter::create(&store, shard, ShardSettings::default());
            writer.finish().unwrap().commit(record).unwrap();
        }
        let folded = Folded::gather(&Catalog::open(&store).unwrap(), &[]);
        let files = folded.write(&store, &FileNotes::new()).unwrap();
        (folded, files)
    };
    let (one, files) = folded(&[0, 6]);
    assert_eq!(one.clips.iter().map(|clip| clip.clip_id).collect::<Vec<_>>(), [1, 4, 7, 10, 13, 16]);
    assert_eq!(one.faults.len(), FAULT_ROWS_A_KIND);
    assert_eq!(folded(&[0, 1, 2, 5, 6]), (one, files));
}

#[test]
fn clips_are_looked_up_as_people_name_them() {
    let mut dice = Dice(2);
    let mut clip = |source: &str, name: &str| {
        let mut row = clip_row(&mut dice, 0);
        row.source = source.to_owned();
        row.name = name.to_owned();
        row
    };
    let clips = [
        clip("cmu", "02/02_01"),
        clip("cmu", "02/02_02"),
        clip("cmu", "16/16_36"),
        clip("cmu", "walk"),
        clip("studio", "walk"),
        clip("studio", "歩く"),
        clip("studio", "take_1"),
        clip("studio", "take_10"),
    ];
    for (name, wanted) in [
        ("cmu/02/02_01", "cmu/02/02_01"),
        ("02/02_01", "cmu/02/02_01"),
        ("02_01", "cmu/02/02_01"),
        ("16", "cmu/16/16_36"),
        ("16_3", "cmu/16/16_36"),
        ("cmu/16", "cmu/16/16_36"),
        ("cmu/walk", "cmu/walk"),
        ("歩", "studio/歩く"),
        // A whole name wins over the prefix of another.
        ("take_1", "studio/take_1"),
    ] {
        assert_eq!(look_up(&clips, name).map(|clip| clip.full_name()).as_deref(), Ok(wanted), "{name}");
    }
    let ambiguous = look_up(&clips, "walk").unwrap_err();
    assert_eq!(ambiguous.to_string(), "`walk` fits 2 clips: cmu/walk, studio/walk");
    assert_eq!(look_up(&clips, "02_0").unwrap_err().to_string(), "`02_0` fits 2 clips: cmu/02/02_01, cmu/02/02_02");
    assert_eq!(
        look_up(&clips, "16_63").unwrap_err().to_string(),
        "no clip is called `16_63`; the nearest is `cmu/16/16_36`"
    );
    for odd in ["", "/", "zzz", "Walk/"] {
        assert!(matches!(look_up(&clips, odd), Err(LookUpError::NotFound { .. })), "{odd}");
    }
}

#[test]
fn the_card_names_the_terms_of_every_source() {
    let (folder, _) = folder_and_store();
    let store = whole_corpus(folder.path());
    let folded = Folded::gather(&Catalog::open(&store).unwrap(), &[]);
    let terms = |source: &str, license: Option<&str>| SourceTerms {
        source: source.to_owned(),
        license: license.map(str::to_owned),
        attribution: Some("Name\n us".to_owned()),
    };
    let digest = write_card(&store, &folded, &[terms("studio", None), terms("bandai", Some("CC BY-NC 4.0"))]).unwrap();
    let card = String::from_utf8(store.read(CARD).unwrap().unwrap()).unwrap();
    assert_eq!(digest.blake3, blake3::hash(card.as_bytes()).to_hex().to_string());
    assert!(card.starts_with("---\nlicense: other\n"));
    let bandai = card.find("- **bandai**: CC BY-NC 4.0. Name us\n").unwrap();
    assert!(bandai < card.find("- **studio**: license not given").unwrap());
    for clip in &folded.clips {
        assert!(card.contains(&format!("data_files: \"channels/layout={}/*.parquet\"", clip.layout)));
    }
}
