//! `evaluate`: a corpus against truth from files, from names, and from the plan of the program's own people.

use crate::running::{Said, mill};
use motionmill::corpus::{Catalog, ClipRow, Store, read_clips};
use motionmill::plan::load_name_rules;
use motionmill::plan::shipped::TRUTHS;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

fn evaluate(folder: &Path, args: &[&str]) -> Said {
    mill(folder, &[&["evaluate"], args].concat())
}

#[track_caller]
fn json(folder: &Path, args: &[&str]) -> Value {
    let said = evaluate(folder, &[args, &["--json"]].concat());
    assert_eq!(said.code, 0, "{args:?}: {}{}", said.out, said.err);
    serde_json::from_str(&said.out).unwrap()
}

/// Three lines, that begin so and have these words; nothing on standard output.
#[track_caller]
fn refused(folder: &Path, args: &[&str], code: i32, begins: &str, remedy: &str) {
    let said = evaluate(folder, args);
    assert_eq!((said.code, said.out.as_str()), (code, ""), "{args:?}: {}", said.err);
    assert!(said.err.starts_with(begins), "{args:?}: {}", said.err);
    let tries = said.err.lines().last().unwrap();
    assert!(said.err.contains("\n  why: ") && tries.starts_with("  try: ") && tries.contains(remedy), "{}", said.err);
}

const PEOPLE: &str = "demo/corpus";
const CAPTURED: &str = "corpus";

/// Of [`CAPTURED`]'s captures and a few more, of the same names.
const BOTH: &str = "both";

/// A folder with `demo/corpus`, of the program's own people, `corpus`, of captures beside their truth, and `both`; made
/// once. Nobody writes there.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("evaluate");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        for command in [
            "run annotate --set ingest.without_input=procedural --set procedural.clips=8 --out demo/corpus",
            "synth --clips 6 --seed 3 --format bvh --out captures",
            "run annotate --input captures --out corpus",
            "synth --clips 2 --seed 4 --format bvh --out more",
            "run annotate --input captures --input more --out both",
        ] {
            let done = mill(&folder, &command.split(' ').collect::<Vec<_>>());
            assert_eq!(done.code, 0, "{command}: {}{}", done.out, done.err);
        }
        folder
    })
}

fn clips(corpus: &str) -> Vec<ClipRow> {
    read_clips(&Store::new(folder().join(corpus))).unwrap()
}

/// The absolute path of a corpus of [`folder`].
fn there(corpus: &str) -> String {
    folder().join(corpus).to_str().unwrap().to_owned()
}

/// A fresh folder with a file in it.
fn with_file(name: &str, text: impl AsRef<[u8]>) -> tempfile::TempDir {
    let fresh = tempfile::tempdir().unwrap();
    fs::create_dir_all(fresh.path().join(name).parent().unwrap()).unwrap();
    fs::write(fresh.path().join(name), text).unwrap();
    fresh
}

#[test]
fn people_of_the_program_need_no_file() {
    let value = json(folder(), &[PEOPLE, "--procedural", "--by-clip", "--min-confidence", "0.8"]);
    let contacts = &value["contacts"];
    let count = |name: &str| contacts[name].as_u64().unwrap();
    let frames: u64 = clips(PEOPLE).iter().map(|clip| u64::from(clip.frames)).sum();
    let cells = ["true_positives", "false_positives", "false_negatives", "true_negatives"];
    assert_eq!(cells.map(count).iter().sum::<u64>(), 2 * frames);
    let (hits, found) = (count("true_positives") as f64, count("true_positives") + count("false_positives"));
    assert_eq!(contacts["precision"].as_f64().unwrap(), hits / found as f64);
    assert!(contacts["f1"].as_f64().unwrap() > 0.95 && contacts["strikes"]["count"].as_u64().unwrap() > 40);
    assert!(contacts["strikes"]["sd_ms"].as_f64().unwrap() < 100.0);
    assert!(value["gait_frames"]["share_right"].as_f64().unwrap() > 0.95);
    assert_eq!((&value["clips"]["compared"], &value["clips"]["by_frames"]), (&8.into(), &8.into()));
    assert_eq!(value["clip_classes"]["known"], 8);
    assert_eq!(value["confident"]["min_confidence"], 0.8);
    // The classes' sums are those of all.
    let parts = value["by_class"].as_object().unwrap().values();
    assert_eq!(parts.map(|part| part["contacts"]["true_positives"].as_u64().unwrap()).sum::<u64>(), hits as u64);
    // The worst first.
    let by_clip = value["by_clip"].as_array().unwrap();
    let right: Vec<f64> = by_clip
        .iter()
        .filter(|clip| clip["wrong"] == false)
        .map(|clip| {
            let gait = clip["gait_frames"]["share_right"].as_f64().unwrap_or(1.0);
            gait.min(clip["contacts"]["accuracy"].as_f64().unwrap())
        })
        .collect();
    assert!(by_clip.len() == 8 && right.is_sorted(), "{right:?}");
}

#[test]
fn a_plan_made_again_and_the_files_of_it_say_the_same_frames() {
    let (plan, files) = (json(folder(), &[PEOPLE, "--procedural"]), json(folder(), &[PEOPLE, "--truth", "demo"]));
    for name in ["true_positives", "false_positives", "true_negatives", "missed", "spurious", "true_stances"] {
        assert_eq!(plan["contacts"][name], files["contacts"][name], "{name}");
    }
    assert_eq!(plan["gait_frames"], files["gait_frames"]);
    assert_eq!(plan["contacts"]["strikes"]["count"], files["contacts"]["strikes"]["count"]);
    // Files know no times between frames, and a frame lasts 33 ms at most.
    let mean = |value: &Value| value["contacts"]["strikes"]["mean_ms"].as_f64().unwrap();
    assert!((mean(&plan) - mean(&files)).abs() < 17.0 && mean(&plan) != mean(&files));
}

#[test]
fn tables_show_contacts_stances_gaits_and_classes() {
    let said = evaluate(folder(), &[CAPTURED, "--truth", "captures", "--by-clip", "--min-confidence", "0"]);
    assert_eq!((said.code, said.err.as_str()), (0, ""), "{}", said.out);
    assert!(said.out.starts_with("corpus: 6 of 6 clips compared\n\n  contacts  clips  "), "{}", said.out);
    for words in [
        "  specificity  accuracy\n  all           6  ",
        "\n  stances ",
        "missed",
        "\n  gait of frames: ",
        "\n  true \\ found  unknown  stand ",
        "\n  class of clips, true by frames: ",
        "\nof 6 clips of confidence 0 or more, ",
        "\n  clip ",
    ] {
        assert!(said.out.contains(words), "{words}: {}", said.out);
    }
    assert_eq!(said.out.matches("captures/p01/").count(), 6, "{}", said.out);
}

#[test]
fn labels_that_are_true_are_perfect_and_partial_truth_is_enough() {
    let store = Store::new(folder().join(CAPTURED));
    let catalog = Catalog::open(&store).unwrap();
    let fresh = tempfile::tempdir().unwrap();
    let truth = |columns: &str, shift: usize| {
        for clip in clips(CAPTURED) {
            let labels = catalog.shard_of(clip.clip_id).unwrap().labels(clip.clip_id).unwrap().unwrap();
            let mut text = columns.to_owned();
            for frame in 0..labels.gait.len() {
                let planted = |foot: usize| {
                    let from = frame.saturating_sub(shift);
                    u8::from(labels.stance[foot][from].unwrap()).to_string()
                };
                let cells = columns.split(',').map(|column| match column {
                    "frame" => frame.to_string(),
                    "left" => planted(0),
                    "right" => planted(1),
                    _ => labels.gait[frame].unwrap().name().to_owned(),
                });
                text += &format!("\n{}", cells.collect::<Vec<_>>().join(","));
            }
            fs::write(fresh.path().join(format!("{}.truth.csv", clip.name.rsplit('/').next().unwrap())), text).unwrap();
        }
        json(fresh.path(), &[&there(CAPTURED), "--truth", "."])
    };
    let perfect = truth("gait,right,frame,left", 0);
    for figure in ["precision", "recall", "f1", "specificity", "accuracy"] {
        assert_eq!(perfect["contacts"][figure], 1.0, "{figure}");
    }
    assert_eq!((&perfect["contacts"]["missed"], &perfect["contacts"]["spurious"]), (&0.into(), &0.into()));
    assert_eq!(perfect["contacts"]["lift_offs"]["mean_ms"], 0.0);
    assert!(perfect["gait_frames"]["right"] == perfect["gait_frames"]["known"]);
    // Found a frame before it is true.
    let late = truth("frame,left,right", 1);
    let mean_ms = late["contacts"]["strikes"]["mean_ms"].as_f64().unwrap();
    assert!((-34.0..-8.0).contains(&mean_ms), "{mean_ms}");
    assert!(late["gait_frames"].is_null() && late["clip_classes"].is_null());
    let gait = truth("frame,gait", 0);
    assert!(gait["contacts"].is_null() && gait["gait_frames"]["share_right"] == 1.0);
    let left = truth("frame,left", 0);
    assert!(left["contacts"]["true_positives"].as_u64() < perfect["contacts"]["true_positives"].as_u64());
}

#[test]
fn names_promise_classes() {
    let rules = "# first that fits\n[[rule]]\nname = \"stand\"\ngait = \"unknown\"\n[[rule]]\nname = \"/walk\"\ngait = \"walk\"\n[[rule]]\nname = \"run_01$\"\ngait = \"jump\"\n";
    let fresh = with_file("rules.toml", rules);
    let captured = there(CAPTURED);
    let args = [captured.as_str(), "--names", "rules.toml", "--min-confidence", "0"];
    let value = json(fresh.path(), &args);
    let names: Vec<String> = clips(CAPTURED).iter().map(ClipRow::full_name).collect();
    let walks = names.iter().filter(|name| name.contains("/walk") && !name.contains("stand")).count();
    assert_eq!(value["clips"]["compared"], walks + 1);
    assert_eq!(value["clips"]["left_out"]["without_truth"].as_array().unwrap().len(), names.len() - walks - 1);
    assert_eq!((&value["classes_by"], &value["contacts"]), (&"name".into(), &Value::Null));
    assert_eq!(value["confident"]["wrong_clips"], serde_json::json!(["captures/p01/run_01"]));
    assert_eq!(value["clip_classes"]["found_by_truth"]["jump"]["run"], 1);
    assert_eq!(value["clip_classes"]["recall"]["jump"], 0.0);
    let text = evaluate(fresh.path(), &args).out;
    assert!(text.contains("1 of the wrong class:\n  captures/p01/run_01: jump, found run, "), "{text}");
    assert!(text.contains("\n  class of clips, true by name: "), "{text}");
    // Classes by name group what frames say.
    let (captures, both) = (there("captures"), [captured.as_str(), "--names", "rules.toml", "--truth"]);
    let both = json(fresh.path(), &[&both[..], &[captures.as_str()]].concat());
    assert_eq!(both["by_class"].as_object().unwrap().keys().collect::<Vec<_>>(), ["jump", "walk"]);
    assert_eq!((&both["clips"]["compared"], &both["by_class"]["jump"]["clips"]), (&6.into(), &1.into()));
}

#[test]
fn filters_leave_clips_out_and_files_without_a_clip_are_told() {
    let one = json(folder(), &[CAPTURED, "--truth", "captures", "--name", "walk_01", "--source", "captures"]);
    assert_eq!(one["clips"]["compared"], 1);
    let fresh = with_file("x/nobody.truth.csv", "");
    fs::copy(folder().join("captures/p01/walk_01.truth.csv"), fresh.path().join("x/walk_01.truth.csv")).unwrap();
    let said = evaluate(fresh.path(), &[&there(CAPTURED), "--truth", "x"]);
    assert_eq!(said.code, 0);
    assert!(said.out.contains(": 1 of 6 clips compared; left out: 5 without truth\n"), "{}", said.out);
    assert_eq!(said.err, "note: truth about none of the clips: 1 file, such as x/nobody.truth.csv\n");
}

#[test]
fn filters_do_not_change_whose_truth_a_file_is() {
    let both = there(BOTH);
    let twin = clips(BOTH).into_iter().find(|clip| clip.source == "more").unwrap();
    let last = twin.name.rsplit('/').next().unwrap().to_owned();
    // Named in full it is one clip's, and stays so if only its namesake is asked for.
    let own = with_file(&format!("t/captures/{}.truth.csv", twin.name), "no table");
    let begins =
        format!("error: {both}: no clip could be compared\n  why: no file of truth there is called as a clip ");
    refused(own.path(), &[&both, "--truth", "t", "--source", "more"], 1, &begins, ".truth.csv");
    refused(own.path(), &[&both, "--truth", "t", "--source", "captures"], 1, "error: t/captures/", "");
    // Two are called so, also if only one of them is asked for; who asks for neither needs not care.
    let doubtful = with_file(&format!("t/{last}.truth.csv"), "no table");
    let begins =
        format!("error: t/{last}.truth.csv is called as clips captures/{} and more/{}\n", twin.name, twin.name);
    for source in ["captures", "more"] {
        refused(doubtful.path(), &[&both, "--truth", "t", "--source", source], 1, &begins, "its full name, captures/");
    }
    let others = clips(CAPTURED).into_iter().filter(|clip| clip.name != twin.name && !clip.name.ends_with(&last));
    let other = others.map(|clip| clip.name).next_back().unwrap();
    fs::create_dir_all(doubtful.path().join("t/captures").join(&other).parent().unwrap()).unwrap();
    let truth = format!("{other}.truth.csv");
    fs::copy(folder().join("captures").join(&truth), doubtful.path().join("t/captures").join(&truth)).unwrap();
    let one = json(doubtful.path(), &[&both, "--truth", "t", "--name", &format!("^captures/{other}$")]);
    assert_eq!(one["clips"]["compared"], 1);
}

#[test]
fn truth_that_cannot_be_used_says_where() {
    let captured = there(CAPTURED);
    let says = |text: &str, begins: &str, remedy: &str| {
        let fresh = with_file("t/walk_01.truth.csv", text);
        refused(fresh.path(), &[&captured, "--truth", "t"], 1, begins, remedy);
    };
    says("frame,left\n0,1\n1,yes\n", "error: t/walk_01.truth.csv:3: `left` is `yes`\n", "1 or 0");
    says("frame,gait\n0,limp\n", "error: t/walk_01.truth.csv:2: `gait` is `limp`\n", "one of these words");
    says("", "error: t/walk_01.truth.csv: there is nothing in it\n", "frame,left,right,gait");
    let frames = clips(CAPTURED).iter().find(|clip| clip.name.ends_with("/walk_01")).unwrap().frames;
    let begins =
        format!("error: t/walk_01.truth.csv: rows for 2 frames, clip captures/p01/walk_01 has {frames}\n  why: ");
    says("frame,left\n0,1\n1,1\n", &begins, "a row for each of its frames, at ");
    says("frame,left\n", &begins.replace("for 2", "for 0"), "a row for each");
    let twice = with_file("t/a/walk_01.truth.csv", "");
    fs::write(twice.path().join("t/walk_01.truth.csv"), "").unwrap();
    let begins = "error: t/a/walk_01.truth.csv and t/walk_01.truth.csv are both called as clip captures/p01/walk_01\n";
    refused(twice.path(), &[&captured, "--truth", "t"], 1, begins, "move t/a/walk_01.truth.csv away");
    // Empty cells know nothing.
    let text: String = (0..frames).map(|frame| format!("{frame},,\n")).collect();
    let empty = with_file("t/walk_01.truth.csv", format!("frame,left,right\n{text}"));
    let begins = format!("error: {captured}: no clip could be compared\n  why: the truth leaves every frame open\n");
    refused(empty.path(), &[&captured, "--truth", "t", "--name", "walk_01"], 1, &begins, "not empty");
    let text: String = (0..frames).map(|frame| format!("{frame},{}\n", ["", "unknown"][frame as usize % 2])).collect();
    let empty = with_file("t/walk_01.truth.csv", format!("frame,gait\n{text}"));
    refused(empty.path(), &[&captured, "--truth", "t", "--name", "walk_01"], 1, &begins, "not empty");
    // With contacts in it the clip is compared, and its class is not.
    let text: String = (0..frames).map(|frame| format!("{frame},1,\n")).collect();
    let contacts = with_file("t/walk_01.truth.csv", format!("frame,left,gait\n{text}"));
    let value = json(contacts.path(), &[&captured, "--truth", "t", "--name", "walk_01"]);
    assert_eq!(value["clips"]["compared"], 1);
    assert!(value["gait_frames"].is_null() && value["clip_classes"].is_null(), "{value}");
    #[cfg(unix)]
    {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("t")).unwrap();
        std::os::unix::fs::symlink("gone", folder.path().join("t/walk_01.truth.csv")).unwrap();
        let begins = "error: t/walk_01.truth.csv is no file that can be read: ";
        refused(folder.path(), &[&captured, "--truth", "t"], 1, begins, "a file in its place");
    }
}

#[test]
fn what_cannot_be_compared_says_what_to_try() {
    let here = folder();
    refused(here, &["captures", "--truth", "captures"], 1, "error: captures: not a corpus", "");
    refused(here, &[CAPTURED, "--truth", "nowhere"], 2, "error: nowhere can't be read: ", "--truth with a folder");
    let nothing = "error: corpus: no clip could be compared\n  why: ";
    refused(here, &[CAPTURED, "--truth", "corpus"], 1, &format!("{nothing}there is no file"), ".truth.csv");
    refused(here, &[CAPTURED, "--procedural"], 1, &format!("{nothing}the program made none"), ".truth.csv");
    let begins = format!("{nothing}no rule gives a gait to a name such as captures/p01/");
    refused(here, &[CAPTURED, "--names", "bandai-namco"], 1, &begins, "a rule with a gait");
    let args = [CAPTURED, "--truth", "captures", "--name", "nobody"];
    refused(here, &args, 1, &format!("{nothing}none of its 6 clips fits --name"), "motionmill search corpus");
    let args = [CAPTURED, "--truth", "captures", "--name", "("];
    refused(here, &args, 2, "error: --name (: unclosed group", "--name '\\('");
    for (text, begins, remedy) in [
        (
            "[[rule]]\nname = \"a\"\ngait = \"wlak\"\n",
            "error: r.toml:3:8: `gait` in [[rule]] is \"wlak\"",
            "gait = \"walk\"",
        ),
        (
            "[[rule]]\nname = \"(\"\ngait = \"walk\"\n",
            "error: r.toml:2:8: `name` in [[rule]] is \"(\": unclosed",
            "\\\\(",
        ),
        ("", "error: r.toml:1:1: no rule in it", "[[rule]]"),
    ] {
        let fresh = with_file("r.toml", text);
        refused(fresh.path(), &[&there(CAPTURED), "--names", "r.toml"], 2, begins, remedy);
    }
    refused(here, &[CAPTURED, "--names", "bandai"], 2, "error: bandai: no such file of rules", "`bandai-namco`");
    let none = evaluate(here, &[CAPTURED]);
    assert!(none.code == 2 && none.err.contains("--truth <DIR>|--procedural|--names <RULES>"), "{}", none.err);
    assert_eq!(evaluate(here, &[CAPTURED, "--procedural", "--min-confidence", "80"]).code, 2);
}

#[test]
fn people_made_by_other_settings_are_not_compared() {
    let fresh = tempfile::tempdir().unwrap();
    let run = |args: &str| {
        let args = format!("run annotate --out corpus {args}");
        let done = mill(fresh.path(), &args.split(' ').collect::<Vec<_>>());
        assert_eq!(done.code, 0, "{}", done.err);
    };
    run("--set ingest.without_input=procedural --set procedural.clips=3");
    // The settings know of two clips, the corpus has a third.
    run("--set ingest.without_input=procedural --set procedural.clips=2");
    let value = json(fresh.path(), &["corpus", "--procedural"]);
    assert_eq!(value["clips"]["compared"], 2);
    assert_eq!(value["clips"]["left_out"]["without_truth"].as_array().unwrap().len(), 1);
    // Settings that made none of them.
    run("--input captures --set procedural.seed=2");
    let begins = "error: captures/p01/run_01: made again it is another clip than in the corpus\n";
    refused(fresh.path(), &["corpus", "--procedural"], 1, begins, "the run's command once more");
}

#[test]
fn shipped_rules_can_be_read() {
    for shipped in TRUTHS {
        assert!(!load_name_rules(shipped.name).unwrap().rules.is_empty(), "{}", shipped.name);
    }
}
