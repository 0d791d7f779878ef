//! `inspect --plot`: a clip's feet and gait as a picture that any reader of SVG takes.

use crate::running::{Said, copy, digests, mill, same};
use motionmill::corpus::{ClipRow, Manifest, Store, read_clips};
use roxmltree::Document;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A body without legs.
const ARM: &str = "HIERARCHY\nROOT arm\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n\
JOINT hand\n{\nOFFSET 0 30 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 10 0\n}\n}\n}\n\
MOTION\nFrames: 3\nFrame Time: 0.0333333\n0 90 0 0 0 0 0 0 0\n0 91 0 0 5 0 0 5 0\n0 92 0 0 9 0 0 9 0\n";

/// A folder with `corpus`, and `fixed` by the thesis' detector, made once. Pictures are put elsewhere.
fn made() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("plots");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let run = |args: &[&str]| {
            let said = mill(&folder, args);
            assert_eq!(said.code, 0, "{args:?}: {}{}", said.out, said.err);
        };
        run(&["synth", "--clips", "2", "--seed", "1", "--out", "captures"]);
        fs::write(folder.join("captures/arm.bvh"), ARM).unwrap();
        run(&["run", "annotate", "--input", "captures", "--out", "corpus"]);
        run(&["run", "annotate", "--input", "captures", "--out", "fixed", "--set", "contacts.detector=thesis"]);
        folder
    })
}

fn clip() -> ClipRow {
    let clips = read_clips(&Store::new(made().join("corpus"))).unwrap();
    clips.into_iter().find(|clip| clip.labels.gait_class.is_some()).unwrap()
}

/// Plots a clip of one of the corpora into a folder of its own, with more arguments.
fn plotted(corpus: &str, clip: &str, more: &[&str]) -> (Said, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let corpus = made().join(corpus);
    let args = [&["inspect", corpus.to_str().unwrap(), clip, "--plot", "feet.svg"], more].concat();
    (mill(folder.path(), &args), folder)
}

/// The words of a picture.
fn words(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    assert_eq!(document.root_element().tag_name().name(), "svg");
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.map(|node| node.text().unwrap_or("").trim().to_owned()).collect()
}

#[test]
fn a_plot_says_what_the_corpus_says_and_is_the_same_every_time() {
    let row = clip();
    let (said, folder) = plotted("corpus", &row.full_name(), &[]);
    assert_eq!((said.code, said.err.as_str()), (0, ""), "{}", said.out);
    assert!(said.out.contains("\nplot       feet.svg: "), "{}", said.out);
    let svg = fs::read_to_string(folder.path().join("feet.svg")).unwrap();
    let words = words(&svg);
    assert_eq!(words[0], row.full_name());
    // Found anew from the stored motion: the labels that were stored.
    let labels = &row.labels;
    let gait = format!(
        "{}, confidence {:.2};  detector: adaptive",
        labels.gait_class.unwrap().name(),
        labels.gait_confidence.unwrap()
    );
    assert!(words[1].ends_with(&gait), "{} {gait}", words[1]);
    for title in [
        "Left foot: height above the resting ground (m)",
        "Left foot: speed (m/s)",
        "Right foot: height above the resting ground (m)",
        "Right foot: speed (m/s)",
        "Log-odds of the foot being planted",
        "Contacts: raw (log-odds above 0), decoded stance, pinned",
        "Vertical force on the feet (body weights)",
        "Gait",
        "Confidence in the gait (0 to 1)",
    ] {
        assert!(words.iter().any(|word| word == title), "{title}: {words:?}");
    }
    let (_, again) = plotted("corpus", &row.full_name(), &["--json"]);
    assert!(svg == fs::read_to_string(again.path().join("feet.svg")).unwrap(), "other bytes");
}

#[test]
fn fixed_thresholds_weigh_nothing_and_are_drawn() {
    let (said, folder) = plotted("fixed", &clip().full_name(), &["--strip", "strip.svg", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let value: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert!(value["plot"].as_str().unwrap().starts_with("feet.svg: "), "{}", value["plot"]);
    assert!(value["strip"].as_str().unwrap().starts_with("strip.svg: "));
    let words = words(&fs::read_to_string(folder.path().join("feet.svg")).unwrap());
    assert!(words[1].ends_with("detector: thesis"), "{}", words[1]);
    assert!(words.iter().any(|word| word == "Contacts: stance, pinned"));
    assert!(words.iter().any(|word| word.starts_with("threshold, ") && word.ends_with(" m/s")), "{words:?}");
    assert!(!words.iter().any(|word| word.contains("Log-odds") || word.contains("force") || word.contains("raw")));
}

#[test]
fn what_cannot_be_plotted_is_refused_and_nothing_is_written() {
    let (said, folder) = plotted("corpus", "arm", &["--strip", "strip.svg"]);
    assert_eq!((said.code, said.out.as_str()), (1, ""));
    let name = "captures/arm";
    assert!(said.err.starts_with(&format!("error: {name}: no feet are known, so there is nothing to plot\n  why: ")));
    assert!(said.err.contains(&format!("corpus {name} --raw lists joints")), "{}", said.err);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

    let (said, folder) = plotted("corpus", "no_such_clip", &[]);
    assert_eq!(said.code, 1);
    assert!(said.err.starts_with("error: no clip is called `no_such_clip`"), "{}", said.err);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

    for again in ["feet.svg", "./feet.svg", "././feet.svg"] {
        let (said, folder) = plotted("corpus", &clip().full_name(), &["--strip", again]);
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.starts_with("error: --strip and --plot name one file\n"), "{}", said.err);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    let corpus = made().join("corpus");
    for (option, file) in
        [("--strip", "corpus/s.svg"), ("--strip", "fixed/../corpus/s.svg"), ("--plot", "corpus/clips.parquet")]
    {
        let before = digests(&corpus);
        let said = mill(made(), &["inspect", "corpus", &clip().full_name(), option, file]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
        let begins = format!("error: {option} {file} lies in the corpus\n  why: ");
        let remedy = format!("\n  try: {option} {}\n", file.rsplit('/').next().unwrap());
        assert!(said.err.starts_with(&begins) && said.err.ends_with(&remedy), "{}", said.err);
        same(&before, &digests(&corpus), file);
    }

    let args = ["inspect", corpus.to_str().unwrap(), &clip().full_name(), "--plot", "no/such/folder/feet.svg"];
    let said = mill(made(), &args);
    assert_eq!(said.code, 1);
    assert!(said.err.starts_with("error: no/such/folder/feet.svg: "), "{}", said.err);

    let said = mill(made(), &["inspect", "corpus", "--plot", "feet.svg"]);
    assert_eq!(said.code, 2, "a plot is of a clip: {}", said.err);
}

#[test]
fn a_corpus_that_does_not_know_its_plan_is_plotted_by_the_defaults() {
    let folder = tempfile::tempdir().unwrap();
    copy(&made().join("fixed"), &folder.path().join("fixed"));
    let store = Store::new(folder.path().join("fixed"));
    let mut manifest = Manifest::read(&store).unwrap().unwrap();
    manifest.plan = serde_json::Value::Null;
    manifest.put(&store).unwrap();
    let said = mill(folder.path(), &["inspect", "fixed", &clip().full_name(), "--plot", "feet.svg"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(
        said.err,
        "fixed: the plan that it was made by is not known; contacts are plotted by the default settings\n"
    );
    assert!(words(&fs::read_to_string(folder.path().join("feet.svg")).unwrap())[1].ends_with("detector: adaptive"));
}
