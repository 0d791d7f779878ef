//! Inputs: which clips a folder holds, under which names, with which skeletons and settings, in which shards.

use crate::shared_data::captures;
use motionmill::inputs::{
    ClipRule, Difference, Found, InputError, InputRules, Keyed, SourceRule, cut_shards, find_inputs, hash_inputs,
};
use motionmill::motion::{Format, Severity, UpAxis};
use motionmill::plan::Config;
use std::fs;
use std::path::{Path, PathBuf};

const NO_LIMIT: u64 = u64::MAX;

/// A folder with these files; each holds its own name.
fn folder(files: &[&str]) -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    for file in files {
        let path = root.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, file).unwrap();
    }
    root
}

fn find(folder: &Path, rules: &InputRules) -> Found {
    find_inputs(&[folder.to_owned()], rules, NO_LIMIT).unwrap()
}

fn names(found: &Found) -> Vec<&str> {
    found.inputs.iter().map(|input| input.name.as_str()).collect()
}

/// `name kind` of every notice.
fn kinds(found: &Found) -> Vec<String> {
    found.notices.iter().map(|notice| format!("{} {}", notice.name, notice.notice.kind)).collect()
}

fn asf<'a>(found: &'a Found, name: &str) -> Option<&'a str> {
    let input = found.inputs.iter().find(|input| input.name == name).unwrap();
    input.asf.as_ref().map(|path| path.file_name().unwrap().to_str().unwrap())
}

#[test]
fn clips_are_found_in_any_case_below_any_folder_and_sorted_by_name() {
    let root = folder(&["b/z.bvh", "b/a.BVH", "a.bvh", "01/01.asf", "01/01_01.Amc", "readme.txt", "x.fbx", "noext"]);
    let found = find(root.path(), &InputRules::default());
    assert_eq!(names(&found), ["01/01_01", "a", "b/a", "b/z"]);
    assert_eq!(found.inputs[0].kind, Format::Amc);
    assert_eq!(found.inputs[2].path, root.path().join("b/a.BVH"));
    assert_eq!(found.inputs[2].bytes, "b/a.BVH".len() as u64);
    assert!(found.notices.is_empty());
}

#[test]
fn hidden_files_and_folders_are_passed_over() {
    let root = folder(&["a.bvh", ".b.bvh", ".git/c.bvh", "d/.e/f.bvh", "d/._g.bvh"]);
    assert_eq!(names(&find(root.path(), &InputRules::default())), ["a"]);
}

#[test]
fn names_that_collide_keep_their_extension() {
    let root = folder(&["w.bvh", "w.amc", "w.asf", "v.bvh", "x/w.bvh"]);
    assert_eq!(names(&find(root.path(), &InputRules::default())), ["v", "w.amc", "w.bvh", "x/w"]);
}

#[test]
fn a_motion_finds_its_skeleton_by_the_rules_in_their_order() {
    let root = folder(&[
        "a/02_01.amc",
        "a/02_01.asf",
        "a/02.asf",
        "a/02_02.amc",
        "a/03_01.amc",
        "b/walk.amc",
        "b/run.amc",
        "b/actor.ASF",
    ]);
    let found = find(root.path(), &InputRules::default());
    assert_eq!(asf(&found, "a/02_01"), Some("02_01.asf"));
    assert_eq!(asf(&found, "a/02_02"), Some("02.asf"));
    assert_eq!(asf(&found, "b/walk"), Some("actor.ASF"));
    assert_eq!(names(&found), ["a/02_01", "a/02_02", "b/run", "b/walk"]);
    assert_eq!(kinds(&found), ["a/03_01 skeleton-absent", "b/ skeleton-guessed"]);
    let absent = &found.notices[0].notice;
    assert_eq!(absent.severity, Severity::Fault);
    assert_eq!(absent.message, "a/03_01.amc: 2 .asf files, none of its name, beside it");
    assert!(absent.remedy.contains("03_01.asf or 03.asf"), "{}", absent.remedy);
    let guess = &found.notices[1].notice;
    assert_eq!((guess.severity, guess.count), (Severity::Note, 2), "one note a folder");
}

#[test]
fn the_config_names_skeletons_too() {
    let root = folder(&["a/1.amc", "a/2.amc", "a/x.asf", "a/y.asf", "b/3.amc", "a/y_4.amc"]);
    let rules = InputRules {
        sources: vec![SourceRule { asf: Some("a/x.asf".into()), ..Default::default() }],
        clips: vec![
            ClipRule { name: "2".into(), asf: Some("a/y.asf".into()), ..Default::default() },
            ClipRule { name: "b/3".into(), asf: Some("gone.asf".into()), ..Default::default() },
        ],
        ..Default::default()
    };
    let found = find(root.path(), &rules);
    assert_eq!(asf(&found, "a/1"), Some("x.asf"), "the source's, where names say nothing");
    assert_eq!(asf(&found, "a/2"), Some("y.asf"), "the clip's own comes first");
    assert_eq!(asf(&found, "a/y_4"), Some("y.asf"), "a name comes before the source's");
    assert_eq!(kinds(&found), ["b/3 skeleton-absent"]);
    assert!(found.notices[0].notice.message.contains("gone.asf"));
}

#[test]
fn sources_are_named_by_folder_or_config_and_equal_names_are_refused() {
    let root = folder(&["one/cmu/a.bvh", "two/cmu/b.bvh", "lafan/c.bvh", "other/d.bvh"]);
    let folders: Vec<PathBuf> =
        ["two/cmu", "other", "one/cmu", "lafan"].iter().map(|name| root.path().join(name)).collect();
    let rules = InputRules {
        sources: vec![
            SourceRule { folder: "oth*".into(), label: Some("third".into()), ..Default::default() },
            SourceRule { folder: "t*o/cmu".into(), label: Some("second".into()), ..Default::default() },
        ],
        ..Default::default()
    };
    let labels = |folders: &[PathBuf], rules: &InputRules| {
        let found = find_inputs(folders, rules, NO_LIMIT).unwrap();
        found.inputs.iter().map(|input| format!("{}/{}", input.source, input.name)).collect::<Vec<_>>()
    };
    let all = labels(&folders, &rules);
    assert_eq!(all, ["cmu/a", "lafan/c", "second/b", "third/d"]);
    let backwards: Vec<PathBuf> = folders.iter().rev().cloned().collect();
    assert_eq!(labels(&backwards, &rules), all);
    let twice: Vec<PathBuf> = folders.iter().chain(&folders).cloned().collect();
    assert_eq!(labels(&twice, &rules), all, "a folder named twice is one");
    // Without the longer path both are `cmu`: which is which must not depend on where they lie.
    let unnamed = InputRules { sources: rules.sources[..1].to_vec(), ..Default::default() };
    let errors = find_inputs(&folders, &unnamed, NO_LIMIT).unwrap_err();
    let said = errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("");
    assert!(said.ends_with("two/cmu are both called `cmu`") && said.contains("one/cmu"), "{said}");
}

#[test]
fn single_files_are_inputs_of_their_folder() {
    let root = folder(&["cmu/02.asf", "cmu/02_01.amc", "cmu/02_02.amc", "cmu/x/y.bvh"]);
    let file = |name: &str| root.path().join("cmu").join(name);
    let found = find_inputs(&[file("02_02.amc"), file("02_01.amc")], &InputRules::default(), NO_LIMIT).unwrap();
    assert_eq!(names(&found), ["02_01", "02_02"]);
    assert_eq!((found.inputs[0].source.as_str(), asf(&found, "02_01")), ("cmu", Some("02.asf")));
    let whole = find_inputs(&[file("02_02.amc"), root.path().join("cmu")], &InputRules::default(), NO_LIMIT).unwrap();
    assert_eq!(names(&whole), ["02_01", "02_02", "x/y"], "the folder holds the file");
}

#[test]
fn what_is_not_there_or_no_motion_is_an_error_of_the_run() {
    let root = folder(&["notes.txt", "only.asf"]);
    let at = |name: &str| root.path().join(name);
    let errors = find_inputs(&[at("nowhere"), at("notes.txt"), at("only.asf")], &InputRules::default(), 9).unwrap_err();
    assert!(matches!(
        &errors[..],
        [InputError::Absent { .. }, InputError::NotAClip { .. }, InputError::NotAClip { .. }]
    ));
    assert!(errors[0].to_string().contains("nowhere can't be read: No such file"), "{}", errors[0]);
}

#[test]
fn a_clip_above_the_limit_is_a_fault() {
    let root = folder(&["small.bvh", "a-much-larger-one.bvh"]);
    let found = find_inputs(&[root.path().to_owned()], &InputRules::default(), 10).unwrap();
    assert_eq!(names(&found), ["small"]);
    assert_eq!(kinds(&found), ["a-much-larger-one clip-too-large"]);
}

#[test]
fn skipped_clips_are_left_out_and_unused_rules_are_noted() {
    let root = folder(&["a/take_01.bvh", "a/take_02.bvh", "b/take_01.bvh", "b/other.bvh"]);
    let mut rules = InputRules::default();
    rules.inputs.skip = vec!["take_01".into(), "b/oth*".into(), "tkae_02".into()];
    rules.clips = vec![
        ClipRule { name: "take_09".into(), ..Default::default() },
        ClipRule { name: "take_09".into(), source: Some("elsewhere".into()), ..Default::default() },
    ];
    let found = find(root.path(), &rules);
    assert_eq!((names(&found), found.skipped), (vec!["a/take_02"], 3));
    assert_eq!(kinds(&found), ["take_09 rule-unused", "tkae_02 rule-unused"]);
}

#[test]
fn settings_come_from_inputs_then_the_source_then_the_clips() {
    let root = folder(&["s/a.bvh", "s/b.bvh", "s/b2.bvh"]);
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("c.toml");
    fs::write(
        &config,
        "[inputs]\nrate_hz = 30\nunit_m = 1\nup = 'z'\n\
         [[source]]\nfolder = 's'\nunit_m = 0.01\nlicense = 'CC BY 4.0'\nmay_sell = true\nno_derivatives = true\n\
         [[clip]]\nname = 'b*'\nunit_m = 0.1\nsubject = 'anna'\n\
         [[clip]]\nname = 'b'\nsource = 's'\nup = 'y'\nno_derivatives = false\nunit_m = 0.2\n",
    )
    .unwrap();
    let rules = Config::load(config.to_str(), &[]).unwrap().input_rules();
    let found = find(&root.path().join("s"), &rules);
    let [a, b, b2] = [0, 1, 2].map(|index| &found.inputs[index].settings);
    assert_eq!((a.rate_hz, a.unit_m, a.up, a.no_derivatives), (Some(30.0), Some(0.01), Some(UpAxis::Z), true));
    assert_eq!((a.license.as_deref(), a.may_sell, a.may_share), (Some("CC BY 4.0"), Some(true), None));
    assert_eq!((b.unit_m, b.up, b.no_derivatives), (Some(0.2), Some(UpAxis::Y), false));
    assert_eq!((b.subject.as_deref(), b2.unit_m, b2.up), (Some("anna"), Some(0.1), Some(UpAxis::Z)));
    assert_eq!(b2.license.as_deref(), Some("CC BY 4.0"));
}

#[cfg(unix)]
mod on_unix {
    use super::*;
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::os::unix::net::UnixListener;

    #[test]
    fn an_unreadable_folder_is_a_fault_and_the_rest_goes_on() {
        let root = folder(&["a.bvh", "closed/b.bvh", "z/c.bvh"]);
        let closed = root.path().join("closed");
        fs::set_permissions(&closed, fs::Permissions::from_mode(0o0)).unwrap();
        let found = find(root.path(), &InputRules::default());
        let is_closed = fs::read_dir(&closed).is_err();
        fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).unwrap();
        if !is_closed {
            // The superuser reads everything; `walk` is tested with a failing listing besides.
            assert_eq!(names(&found), ["a", "closed/b", "z/c"]);
            return;
        }
        assert_eq!(names(&found), ["a", "z/c"]);
        assert_eq!(kinds(&found), ["closed/ folder-unreadable"]);
        let known =
            [keyed("closed/b", "1"), keyed("gone", "1")].map(|k| Keyed { source: found.sources[0].label.clone(), ..k });
        let difference = found.difference(&[], &known);
        assert_eq!((difference.unsure, difference.gone), (vec![0], vec![1]));
    }

    #[test]
    fn links_are_followed_once_and_never_in_circles() {
        let root = folder(&["in/a.bvh", "in/sub/b.bvh", "out/c.bvh", "out/deep/d.bvh", "e.bvh"]);
        let at = |name: &str| root.path().join(name);
        symlink(at("in"), at("in/sub/up")).unwrap();
        symlink(root.path(), at("in/everything")).unwrap();
        symlink(at("out"), at("in/0-first")).unwrap();
        symlink(at("out"), at("in/again")).unwrap();
        symlink(at("in/sub"), at("in/0-sub")).unwrap();
        symlink(at("e.bvh"), at("in/e.bvh")).unwrap();
        symlink(at("nowhere"), at("in/broken.bvh")).unwrap();
        let found = find(&at("in"), &InputRules::default());
        assert_eq!(names(&found), ["0-first/c", "0-first/deep/d", "a", "e", "sub/b"]);
        assert_eq!(
            kinds(&found),
            [
                "0-sub/ folder-linked-again",
                "again/ folder-linked-again",
                "broken.bvh file-unreadable",
                "everything/ folder-linked-again",
                "sub/up/ folder-linked-again",
            ]
        );
    }

    #[test]
    fn what_is_no_regular_file_is_never_opened() {
        let root = folder(&["a.bvh"]);
        let _socket = UnixListener::bind(root.path().join("pipe.bvh")).unwrap();
        let found = find(root.path(), &InputRules::default());
        assert_eq!(names(&found), ["a"]);
        assert_eq!(kinds(&found), ["pipe.bvh not-a-file"]);
    }

    #[test]
    fn names_that_are_no_text_are_kept_apart() {
        let root = folder(&["plain.bvh"]);
        for name in [&b"take\xff.bvh"[..], b"take\xfe.bvh", b"two\nlines.bvh"] {
            fs::write(root.path().join(OsStr::from_bytes(name)), name).unwrap();
        }
        let found = find(root.path(), &InputRules::default());
        assert_eq!(names(&found), ["plain", "take\\xFE", "take\\xFF", "two\\x0Alines"]);
        assert!(hash_inputs(&found.inputs).iter().all(Result::is_ok));
    }
}

#[test]
fn hashes_follow_the_bytes_and_keys_the_settings() {
    let root = folder(&["a.bvh", "b.bvh", "02.asf", "02_01.amc", "02_02.amc"]);
    fs::write(root.path().join("b.bvh"), "a.bvh").unwrap();
    let found = find(root.path(), &InputRules::default());
    let hashes: Vec<_> = hash_inputs(&found.inputs).into_iter().map(Result::unwrap).collect();
    assert_eq!(names(&found), ["02_01", "02_02", "a", "b"]);
    assert_eq!(hashes[2], hashes[3], "equal bytes");
    assert_ne!(hashes[0].file, hashes[1].file);
    assert_eq!(hashes[0].asf, hashes[1].asf);
    assert_eq!(hashes[2].file, blake3::hash(b"a.bvh").to_hex().to_string());
    let settings = &found.inputs[0].settings;
    let key = hashes[0].key(settings);
    assert_ne!(key, hashes[0].key(&motionmill::inputs::SourceSettings { rate_hz: Some(60.0), ..settings.clone() }));
    fs::write(root.path().join("02.asf"), "another skeleton").unwrap();
    let again = hash_inputs(&found.inputs).into_iter().map(Result::unwrap).collect::<Vec<_>>();
    assert_eq!(again[0].file, hashes[0].file);
    assert_ne!(again[0].key(settings), key, "its skeleton is part of a clip");
    assert_eq!(again[2], hashes[2]);
}

#[test]
fn a_file_that_vanishes_before_it_is_hashed_is_a_fault_of_its_clip() {
    let root = folder(&["a.bvh", "b.bvh"]);
    let found = find(root.path(), &InputRules::default());
    fs::remove_file(root.path().join("a.bvh")).unwrap();
    let hashes = hash_inputs(&found.inputs);
    assert_eq!(hashes[0].as_ref().unwrap_err().kind, "file-unreadable");
    assert!(hashes[1].is_ok());
}

#[test]
fn shards_are_cut_where_the_text_is_full() {
    let sizes = [3, 4, 3, 1, 100, 1, 0];
    let cut = |text_bytes: u64| {
        cut_shards(sizes, text_bytes).iter().map(|shard| (shard.clips.clone(), shard.bytes)).collect::<Vec<_>>()
    };
    assert_eq!(cut(7), [(0..2, 7), (2..4, 4), (4..5, 100), (5..7, 1)]);
    assert_eq!(cut(10), [(0..3, 10), (3..4, 1), (4..5, 100), (5..7, 1)]);
    assert_eq!(cut(u64::MAX), [(0..7, 112)]);
    assert_eq!(cut(1), [(0..1, 3), (1..2, 4), (2..3, 3), (3..4, 1), (4..5, 100), (5..7, 1)]);
    assert!(cut_shards([], 7).is_empty());
}

#[test]
fn shards_do_not_depend_on_the_order_of_the_folders() {
    let root = folder(&["x/a.bvh", "x/b.bvh", "y/a.bvh", "y/deep/er/c.bvh", "z/d.bvh"]);
    let shards = |order: [&str; 3]| {
        let folders = order.map(|name| root.path().join(name));
        let found = find_inputs(&folders, &InputRules::default(), NO_LIMIT).unwrap();
        let clips = |shard: &motionmill::inputs::Shard| {
            found.inputs[shard.clips.clone()].iter().map(|input| format!("{}/{}", input.source, input.name)).collect()
        };
        cut_shards(found.inputs.iter().map(|input| input.bytes), 20).iter().map(clips).collect::<Vec<Vec<String>>>()
    };
    let one = shards(["x", "y", "z"]);
    assert_eq!(one, [vec!["x/a", "x/b"], vec!["y/a"], vec!["y/deep/er/c"], vec!["z/d"]]);
    assert_eq!(one, shards(["z", "x", "y"]));
    assert_eq!(one, shards(["y", "z", "x"]));
}

fn keyed(name: &str, key: &str) -> Keyed {
    Keyed { source: "s".into(), name: name.into(), key: key.into() }
}

#[test]
fn what_is_new_changed_gone_and_unchanged() {
    let found = [keyed("a", "1"), keyed("b", "2"), keyed("c", "1")];
    let elsewhere = Keyed { source: "other".into(), ..keyed("e", "1") };
    let known = [keyed("b", "1"), keyed("c", "1"), keyed("d", "1"), elsewhere];
    let difference = motionmill::inputs::difference(&found, &known, &["s".to_owned()], &[]);
    let expected = Difference { new: vec![0], changed: vec![1], unchanged: vec![2], gone: vec![2], unsure: vec![] };
    assert_eq!(difference, expected, "a source that was not looked through keeps its clips");
}

#[test]
fn a_clip_that_is_there_and_can_not_be_used_is_not_gone() {
    let root = folder(&["x/1_1.amc", "x/1.asf", "x/2.asf"]);
    let rules = InputRules::default();
    let known = [Keyed { source: "x".into(), ..keyed("1_1", "k") }, Keyed { source: "x".into(), ..keyed("1", "k") }];
    fs::remove_file(root.path().join("x/1.asf")).unwrap();
    fs::write(root.path().join("x/3.asf"), "").unwrap();
    let found = find(&root.path().join("x"), &rules);
    assert_eq!(kinds(&found), ["1_1 skeleton-absent"]);
    let difference = found.difference(&[], &known);
    assert_eq!((difference.unsure, difference.gone), (vec![0], vec![1]));
}

#[test]
fn the_shared_captures_are_all_found() {
    let Some(data) = captures() else { return };
    let find = |name: &str, config: &str| {
        let rules = Config::load(Some(config), &[]).unwrap().input_rules();
        find_inputs(&[data.join(name)], &rules, NO_LIMIT).unwrap()
    };
    let cmu = find("cmu", "cmu");
    assert_eq!(cmu.inputs.len(), 23);
    assert!(cmu.notices.is_empty(), "{:?}", cmu.notices);
    assert_eq!(asf(&cmu, "02/02_01"), Some("02.asf"));
    assert_eq!(cmu.inputs[0].settings.rate_hz, Some(120.0));
    assert_eq!(find("bandai-namco", "bandai-namco").inputs.len(), 97 + 1742);
    let extra = find("extra", "cmu");
    assert_eq!((extra.inputs.len(), extra.notices.len()), (6, 0));
    // 45 MB of CMU text: a handful of shards, each within the limit.
    let shards = cut_shards(cmu.inputs.iter().map(|input| input.bytes), 8 << 20);
    assert!((5..=8).contains(&shards.len()), "{}", shards.len());
    assert!(shards.iter().all(|shard| shard.bytes <= 8 << 20));
    assert_eq!(hash_inputs(&cmu.inputs).iter().filter(|hash| hash.is_ok()).count(), 23);
}

#[test]
fn no_notice_says_where_the_input_folder_lies() {
    let root = folder(&["a/walk.amc", "a/actor.asf", "b/run.amc", "c/jump.amc"]);
    let rule = ClipRule { name: "c/*".to_owned(), asf: Some("c/absent.asf".to_owned()), ..ClipRule::default() };
    let found = find(root.path(), &InputRules { clips: vec![rule], ..InputRules::default() });
    assert_eq!(kinds(&found), ["a/ skeleton-guessed", "b/run skeleton-absent", "c/jump skeleton-absent"]);
    let messages: Vec<&str> = found.notices.iter().map(|notice| notice.notice.message.as_str()).collect();
    assert_eq!(messages[0], "AMC files without an ASF of their name take actor.asf, the only one in the folder");
    assert_eq!(messages[2], "c/jump.amc needs c/absent.asf, which is not in the input folder");
    let place = root.path().to_str().unwrap();
    assert!(messages.iter().all(|message| !message.contains(place)), "{messages:?}");
}
