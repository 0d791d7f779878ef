//! Gaits: the thesis' tables and grammars, the reference's token checks, and what clips are by their names.
//!
//! `golden/gait-evidence.jsonl` holds, for five clips, the reference detector's tokens, log-odds and force (to six
//! decimals) and what `gaits.py` made of them:
//!
//! ```text
//! body, rate = contacts.read_clip(file); d = contacts.detect(body, rate)
//! segments, z = gaits.classify(d["tokens"], rate, d["odds"], d["force"])
//! ```
//!
//! `golden/contacts-fixed.jsonl` (see `contacts.rs`) holds what it made of tokens alone.

use crate::{bandai, golden, shared_data};
use motionmill::annotate::contacts::extrema::extrema_contacts;
use motionmill::annotate::contacts::foot_paths::FootPaths;
use motionmill::annotate::contacts::resting_height::clip_minimum;
use motionmill::annotate::contacts::thesis::thesis_contacts;
use motionmill::annotate::contacts::{ExtremaSettings, ThesisSettings};
use motionmill::annotate::gait_machine::{machine_class, machine_gaits};
use motionmill::annotate::gait_segments::gait_runs;
use motionmill::annotate::gait_steps::{Evidence, step_gaits};
use motionmill::annotate::gait_summary::{FRAME_GAITS, clip_gait};
use motionmill::annotate::gait_tokens::{Token, token_runs};
use motionmill::annotate::{Gait, Settings, annotate};
use motionmill::motion::{Poses, RoleMap};
use proptest::prelude::*;
use std::path::Path;

/// Tokens of a text such as `B2 L.4 B.15`: letters with seconds.
fn spelled(text: &str, rate_hz: f64) -> Vec<Token> {
    text.split_whitespace()
        .flat_map(|word| {
            let seconds: f64 = word[1..].parse().unwrap();
            held(word.chars().next().unwrap(), seconds, rate_hz)
        })
        .collect()
}

fn held(letter: char, seconds: f64, rate_hz: f64) -> Vec<Token> {
    vec![Token::from_letter(letter).unwrap(); (seconds * rate_hz).round() as usize]
}

fn by_steps(tokens: &[Token], rate_hz: f64) -> Vec<Gait> {
    step_gaits(tokens, rate_hz, Evidence::default()).gaits
}

fn names(gaits: &[Gait]) -> String {
    gait_runs(gaits).iter().map(|(gait, _)| gait.name()).collect::<Vec<_>>().join(" ")
}

#[test]
fn table_c1_gives_table_c2() {
    let frames = [("B", 79), ("L", 47), ("B", 39), ("R", 36), ("B", 44), ("N", 30), ("B", 19)];
    let tokens: Vec<Token> = frames
        .into_iter()
        .flat_map(|(letter, n)| vec![Token::from_letter(letter.chars().next().unwrap()).unwrap(); n])
        .collect();
    let gaits = machine_gaits(&tokens);
    // Frames 1-245 and 246-294 of the table, which counts from 1.
    assert_eq!(gait_runs(&gaits), [(Gait::Walk, 0..245), (Gait::Jump, 245..294)]);
    assert_eq!(machine_class(&gaits), Gait::Other);
    let percent = |gait: Gait| 100.0 * gaits.iter().filter(|&&other| other == gait).count() as f64 / 294.0;
    assert_eq!((percent(Gait::Walk).round(), percent(Gait::Jump).round()), (83.0, 17.0));
    assert_eq!(gait_runs(&by_steps(&tokens, 30.0)), [(Gait::Stand, 0..227), (Gait::Jump, 227..294)]);
}

#[test]
fn token_checks() {
    for (text, by_thesis, class, segments) in [
        ("B2", "stand", "stand", "stand"),
        ("L.3 R.3 L.3 R.3", "unknown", "walk", "walk"),
        ("L.3 N.2 L.3 N.2 L.3", "other", "jump", "jump"),
        ("B2 L.4 B.15 R.4 B.15 L.4 B2", "walk", "other", "stand walk stand"),
        ("L.4 N.017 R.4 N.017 L.4 N.017 R.4", "run", "walk", "walk"),
        ("L.4 B.12 R.4 B.12 L.2 N.033 L.2 B.12 R.4", "other", "walk", "walk"),
        // CONTACTS 3 has "other" here; see `clip_gait`.
        ("B1 N.4 B1", "jump", "jump", "stand jump stand"),
        ("L.25 N.1 R.25 N.1 L.25 N.1", "run", "run", "run"),
        ("B.15 L.4 B.12 R.4 B.12 L.4 B.12", "walk", "walk", "walk"),
        ("B2 L.4 B2", "walk", "stand", "stand"),
    ] {
        let tokens = spelled(text, 60.0);
        let gaits = step_gaits(&tokens, 60.0, Evidence::default());
        assert_eq!(machine_class(&machine_gaits(&tokens)).name(), by_thesis, "{text}");
        assert_eq!(names(&gaits.gaits), segments, "{text}");
        assert_eq!(clip_gait(&gaits, Evidence::default()).unwrap().class.name(), class, "{text}");
    }
}

/// The grammars of T 3.2: class, the part that repeats, what ends it.
const GRAMMARS: [(Gait, &str, &str); 10] = [
    (Gait::Stand, "", "B"),
    (Gait::Walk, "BLBR", ""),
    (Gait::Walk, "BRBL", ""),
    (Gait::Walk, "LBRB", ""),
    (Gait::Walk, "RBLB", ""),
    (Gait::Run, "LNRN", ""),
    (Gait::Run, "RNLN", ""),
    (Gait::Jump, "BN", "B"),
    (Gait::Jump, "LN", "L"),
    (Gait::Jump, "RN", "R"),
];

/// Classes whose grammar has strings that these letters are a part of.
fn classes_with(letters: &str) -> Vec<Gait> {
    let mut classes: Vec<Gait> = GRAMMARS
        .iter()
        .filter(|(_, repeated, end)| format!("{}{end}", repeated.repeat(letters.len() + 2)).contains(letters))
        .map(|(gait, ..)| *gait)
        .collect();
    classes.dedup();
    classes
}

fn letters(tokens: &[Token]) -> String {
    token_runs(tokens).iter().map(|run| run.token.letter()).collect()
}

/// A string of a grammar: its index, and tokens of 0.1 to 0.4 s (a stand's B: 1 s).
fn grammar_string() -> impl Strategy<Value = (usize, f64, Vec<Token>)> {
    (
        0..GRAMMARS.len(),
        1_usize..5,
        prop::sample::select(vec![24.0, 30.0, 60.0, 120.0]),
        prop::collection::vec(0.1..0.4_f64, 20),
    )
        .prop_map(|(grammar, repeats, rate_hz, seconds)| {
            let (gait, repeated, end) = GRAMMARS[grammar];
            let letters = format!("{}{end}", repeated.repeat(repeats));
            let held =
                |(letter, seconds): (char, f64)| held(letter, if gait == Gait::Stand { 1.0 } else { seconds }, rate_hz);
            (grammar, rate_hz, letters.chars().zip(seconds).flat_map(held).collect())
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn strings_of_the_grammars_are_homogeneous((grammar, rate_hz, tokens) in grammar_string()) {
        let (gait, repeated, _) = GRAMMARS[grammar];
        prop_assert_eq!(machine_class(&by_steps(&tokens, rate_hz)), gait, "{} by steps", letters(&tokens));
        // The machine has met one foot before it can tell a hop from a run.
        let by_machine = if ["LN", "RN"].contains(&repeated) { Gait::Other } else { gait };
        prop_assert_eq!(machine_class(&machine_gaits(&tokens)), by_machine, "{} by the machine", letters(&tokens));
    }

    #[test]
    fn no_part_of_a_string_is_called_what_it_cannot_be(
        (grammar, rate_hz, tokens) in grammar_string(),
        cut in (0.0..1.0_f64, 0.0..1.0_f64),
    ) {
        let at = |share: f64| (share * tokens.len() as f64) as usize;
        let part = &tokens[at(cut.0.min(cut.1))..=at(cut.0.max(cut.1)).min(tokens.len() - 1)];
        let letters = letters(part);
        let mut possible = classes_with(&letters);
        prop_assert!(possible.contains(&GRAMMARS[grammar].0), "{}", letters);
        possible.push(Gait::Unknown);
        for gait in by_steps(part, rate_hz) {
            prop_assert!(possible.contains(&gait), "{} has {} by steps", letters, gait.name());
        }
        // The machine calls the first hop of a row a run.
        if letters.contains("LNL") || letters.contains("RNR") {
            possible.push(Gait::Run);
        }
        for gait in machine_gaits(part) {
            prop_assert!(possible.contains(&gait), "{} has {} by the machine", letters, gait.name());
        }
    }

    #[test]
    fn any_tokens_at_any_rate_get_one_gait_a_frame(
        runs in prop::collection::vec((0_usize..4, 1_usize..60), 0..30),
        rate_hz in prop::sample::select(vec![1e-3, 1.0, 24.0, 30.0, 59.94, 120.0, 1e6]),
    ) {
        let tokens: Vec<Token> =
            runs.iter().flat_map(|&(letter, n)| vec![Token::from_letter(['N', 'L', 'R', 'B'][letter]).unwrap(); n]).collect();
        let gaits = step_gaits(&tokens, rate_hz, Evidence::default());
        prop_assert_eq!(gaits.gaits.len(), tokens.len());
        prop_assert_eq!(machine_gaits(&tokens).len(), tokens.len());
        prop_assert!(gaits.gaits.iter().all(|gait| FRAME_GAITS.contains(gait)));
        prop_assert!(gaits.steps.iter().all(|step| step.run_evidence.abs() <= 2.0));
        prop_assert!(gaits.steps.windows(2).all(|pair| pair[0].middle() <= pair[1].middle()));
        let clip = clip_gait(&gaits, Evidence::default());
        prop_assert_eq!(clip.is_some(), !tokens.is_empty());
        prop_assert!(clip.is_none_or(|clip| (0.0..=1.0).contains(&clip.confidence)));
    }
}

#[test]
fn tokens_alone_give_the_references_gaits() {
    for line in golden::lines("contacts-fixed.jsonl") {
        let file = line["file"].as_str().unwrap();
        let (tokens, rate_hz) = (golden::tokens(&line), line["rate"].as_f64().unwrap());
        let gaits = step_gaits(&tokens, rate_hz, Evidence::default());
        assert_eq!(gaits.gaits, golden::gaits(&line), "{file}");
        check_clip(file, &gaits, Evidence::default(), &tokens, &line);
    }
}

#[test]
fn log_odds_and_force_give_the_references_gaits() {
    let mut otherwise = 0;
    for line in golden::lines("gait-evidence.jsonl") {
        let file = line["file"].as_str().unwrap();
        let (tokens, rate_hz) = (golden::tokens(&line), line["rate"].as_f64().unwrap());
        let log_odds: Vec<[f64; 2]> = serde_json::from_value(line["odds"].clone()).unwrap();
        let force_bw: Vec<Option<f64>> = serde_json::from_value(line["force"].clone()).unwrap();
        let evidence = Evidence { log_odds: Some(&log_odds), force_bw: Some(&force_bw), ..Evidence::default() };
        let gaits = step_gaits(&tokens, rate_hz, evidence);
        assert_eq!(gaits.gaits, golden::gaits(&line), "{file}");
        let scores: Vec<f64> = serde_json::from_value(line["z"].clone()).unwrap();
        assert_eq!(gaits.steps.len(), scores.len(), "{file}");
        for (step, score) in gaits.steps.iter().zip(scores) {
            assert!((step.run_evidence - score).abs() < 1e-4, "{file}: {step:?}, not {score}");
        }
        check_clip(file, &gaits, evidence, &tokens, &line);
        otherwise += usize::from(by_steps(&tokens, rate_hz) != gaits.gaits);
    }
    assert!(otherwise > 0, "no clip here needs the evidence");
}

fn check_clip(
    file: &str,
    gaits: &motionmill::annotate::gait_steps::StepGaits,
    evidence: Evidence<'_>,
    tokens: &[Token],
    line: &serde_json::Value,
) {
    let clip = clip_gait(gaits, evidence).unwrap();
    assert_eq!(machine_class(&machine_gaits(tokens)).name(), line["thesis_class"], "{file}");
    if file.ends_with("02_04.amc") {
        // A jump and a stand: "other" in CONTACTS, see `clip_gait`.
        assert_eq!((clip.class, line["class"].as_str()), (Gait::Jump, Some("other")));
        return;
    }
    assert_eq!(clip.class.name(), line["class"], "{file}");
    assert!((clip.confidence - line["confidence"].as_f64().unwrap()).abs() < 1e-4, "{file}: {}", clip.confidence);
}

#[test]
fn the_machine_agrees_with_the_reference_on_every_clip() {
    let Some(reference) = shared_data::reference("contacts.jsonl.xz") else { return };
    let lines = golden::parse(&reference);
    assert!(lines.len() > 100);
    for line in lines {
        let gaits = machine_gaits(&golden::tokens(&line));
        assert_eq!(machine_class(&gaits).name(), line["thesis_class"], "{}", line["file"]);
    }
}

/// A way to a clip's class from its poses.
type Classifier = fn(&Poses, &RoleMap) -> Gait;

/// Class and confidence by the settings that ship.
fn shipped(poses: &Poses, roles: &RoleMap) -> (Gait, f32) {
    let clip = annotate(poses, roles, bandai::RATE_HZ, &Settings::default()).clip;
    (clip.gait_class.unwrap(), clip.gait_confidence.unwrap())
}

/// Tokens by the fixed thresholds of CONTACTS 4: heights above the clip's lowest, in the body's own size.
fn fixed_tokens(poses: &Poses, roles: &RoleMap, max_speed_mps: f64) -> Vec<Token> {
    let feet = FootPaths::unscaled(poses, roles, bandai::RATE_HZ).unwrap();
    let settings = ThesisSettings { max_speed_mps, ..ThesisSettings::default() };
    thesis_contacts(&feet, &clip_minimum(&feet), &settings).tokens()
}

/// Tokens from low turning points of the height (CONTACTS 7, T 5.5.1).
fn extrema_tokens(poses: &Poses, roles: &RoleMap) -> Vec<Token> {
    let feet = FootPaths::unscaled(poses, roles, bandai::RATE_HZ).unwrap();
    extrema_contacts(&feet, &clip_minimum(&feet), &ExtremaSettings::default()).tokens()
}

fn class_by_steps(tokens: &[Token]) -> Gait {
    clip_gait(&step_gaits(tokens, bandai::RATE_HZ, Evidence::default()), Evidence::default()).unwrap().class
}

/// The clips of a folder whose name says a gait, with it.
fn named_clips(folder: &Path) -> Vec<(String, Gait, Poses, RoleMap)> {
    let names = bandai::clips_with_a_gait(folder).into_iter();
    names
        .map(|name| {
            let (poses, roles) = bandai::read(&folder.join(&name));
            (name.clone(), bandai::gait_by_name(&name).unwrap(), poses, roles)
        })
        .collect()
}

#[test]
fn captured_clips_are_what_their_names_say() {
    let Some(data) = shared_data::captures() else { return };
    for (set, n_gaits, least_right, n_stands) in [("dataset-2", 556, 556, 1186), ("dataset-1", 56, 55, 0)] {
        let [mut gaits, mut stands] = [(0, 0); 2];
        for (name, wanted, poses, roles) in named_clips(&data.join("bandai-namco").join(set)) {
            let (class, confidence) = shipped(&poses, &roles);
            let count = if wanted == Gait::Stand { &mut stands } else { &mut gaits };
            count.0 += usize::from(class == wanted);
            count.1 += 1;
            if class != wanted {
                println!("{name}: {}, not {}, confidence {confidence:.2}", class.name(), wanted.name());
                assert!(confidence < 0.8, "{name} is surely {}", class.name());
            }
        }
        println!("{set}: {} of {} gait clips, {} of {} stands", gaits.0, gaits.1, stands.0, stands.1);
        assert_eq!((gaits.1, stands), (n_gaits, (n_stands, n_stands)));
        assert!(gaits.0 >= least_right, "{set}");
    }
}

/// CONTACTS 4 and 7: what fixed thresholds make of dataset-2's gait clips, by the thesis' machine and by steps.
#[test]
fn fixed_thresholds_are_as_good_as_was_measured() {
    let Some(data) = shared_data::captures() else { return };
    let clips = named_clips(&data.join("bandai-namco/dataset-2"));
    let clips: Vec<_> = clips.into_iter().filter(|(_, wanted, ..)| *wanted != Gait::Stand).collect();
    let by_machine: [Classifier; 2] = [
        |poses, roles| machine_class(&machine_gaits(&fixed_tokens(poses, roles, 0.6))),
        |poses, roles| machine_class(&machine_gaits(&fixed_tokens(poses, roles, 1.0))),
    ];
    let by_steps: [Classifier; 2] = [
        |poses, roles| class_by_steps(&fixed_tokens(poses, roles, 0.6)),
        |poses, roles| class_by_steps(&fixed_tokens(poses, roles, 1.0)),
    ];
    let by_extrema: [Classifier; 2] = [
        |poses, roles| machine_class(&machine_gaits(&extrema_tokens(poses, roles))),
        |poses, roles| class_by_steps(&extrema_tokens(poses, roles)),
    ];
    for (what, classifier, measured) in [
        ("turning points, machine", by_extrema[0], 0.572),
        ("turning points, steps", by_extrema[1], 0.894),
        ("5 cm / 0.6 m/s, machine", by_machine[0], 0.700),
        ("5 cm / 1.0 m/s, machine", by_machine[1], 0.942),
        ("5 cm / 0.6 m/s, steps", by_steps[0], 0.969),
        ("5 cm / 1.0 m/s, steps", by_steps[1], 0.996),
    ] {
        let right = clips.iter().filter(|(_, wanted, poses, roles)| classifier(poses, roles) == *wanted).count();
        let share = right as f64 / clips.len() as f64;
        println!("{what}: {right} of {}, {share:.3}", clips.len());
        assert!((share - measured).abs() < 0.0025, "{what}: {share:.3}, {measured} in CONTACTS");
    }
}

/// Segments of a capture of CMU's, and its class.
fn cmu(data: &Path, file: &str) -> (Vec<(Gait, f64)>, Gait) {
    let (poses, roles, rate_hz) = crate::adaptive::capture(&data.join(file));
    let labels = annotate(&poses, &roles, rate_hz, &Settings::default());
    let seconds = |first: u32, end: u32| f64::from(end - first) / rate_hz;
    let segments = labels.segments.iter().map(|segment| (segment.gait, seconds(segment.first, segment.end)));
    (segments.collect(), labels.clip.gait_class.unwrap())
}

#[test]
fn captures_of_cmu_are_what_was_performed() {
    let Some(data) = shared_data::captures() else { return };
    for (files, wanted) in [
        (
            &["cmu/02/02_01.amc", "cmu/02/02_02.amc", "cmu/03/03_01.amc", "cmu/03/03_02.amc", "cmu/03/03_03.amc"][..],
            Gait::Walk,
        ),
        (&["cmu/02/02_03.amc"], Gait::Run),
    ] {
        for file in files {
            let (segments, class) = cmu(&data, file);
            assert_eq!((class, segments.len()), (wanted, 1), "{file}: {segments:?}");
        }
    }
    let (segments, class) = cmu(&data, "cmu/02/02_04.amc");
    assert_eq!(
        segments.iter().map(|segment| segment.0).collect::<Vec<_>>(),
        [Gait::Jump, Gait::Stand],
        "jump, then stand"
    );
    assert_eq!(class, Gait::Jump);
    // Forward jumps with stands and a few steps between them.
    let (segments, _) = cmu(&data, "cmu/01/01_01.amc");
    let total: f64 = segments.iter().map(|segment| segment.1).sum();
    let jumps: f64 = segments.iter().filter(|segment| segment.0 == Gait::Jump).map(|segment| segment.1).sum();
    assert!((0.65..0.85).contains(&(jumps / total)), "{segments:?}");
    // A kick at a football.
    let (segments, class) = cmu(&data, "extra/cmu/11/11_01.amc");
    println!("11_01: {} {segments:?}", class.name());
    assert!(segments.len() > 1, "{segments:?}");
}
