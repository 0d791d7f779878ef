//! Every file that breaks one rule is read, told about or refused as `quirks/expected.toml` says.

use crate::captures::{clip, compare, positions};
use crate::shared_data;
use motionmill::formats::{Finding, Motion, ReadOptions, read_amc, read_asf, read_bvh};
use motionmill::motion::Severity;
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct Expected {
    file: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    asf: Option<String>,
    class: String,
    frames: Option<usize>,
    joints: Option<usize>,
    line: Option<u32>,
    r#in: Option<String>,
}

/// What came of a file: the motion, and findings with the extension of the file they speak of.
struct Outcome {
    motion: Option<Motion>,
    findings: Vec<(&'static str, Finding)>,
}

fn read(folder: &Path, case: &Case, options: &ReadOptions) -> Outcome {
    let bytes = std::fs::read(folder.join(&case.name)).unwrap();
    let mut findings = Vec::new();
    let skeleton = match &case.asf {
        None => None,
        Some(asf) => match read_asf(&std::fs::read(folder.join(asf)).unwrap(), options) {
            Ok(reading) => {
                findings.extend(reading.findings.into_iter().map(|finding| ("asf", finding)));
                Some(reading.value)
            }
            Err(fault) => return Outcome { motion: None, findings: vec![("asf", fault)] },
        },
    };
    let (file, reading) = match &skeleton {
        Some(skeleton) => ("amc", read_amc(&bytes, skeleton, options)),
        None => ("bvh", read_bvh(&bytes, options)),
    };
    match reading {
        Ok(reading) => {
            findings.extend(reading.findings.into_iter().map(|finding| (file, finding)));
            Outcome { motion: Some(reading.value), findings }
        }
        Err(fault) => Outcome { motion: None, findings: vec![(file, fault)] },
    }
}

fn cases() -> Option<(std::path::PathBuf, Vec<Case>)> {
    let folder = shared_data::shared()?.join("data/quirks");
    let expected: Expected = toml::from_str(&std::fs::read_to_string(folder.join("expected.toml")).unwrap()).unwrap();
    Some((folder, expected.file))
}

/// The last line of the joint, bone or frame that holds a line: up to there a reader may point.
fn last_line(folder: &Path, case: &Case, line: u32) -> u32 {
    let name = if case.r#in.as_deref() == Some("asf") { case.asf.as_ref().unwrap() } else { &case.name };
    let bytes = std::fs::read(folder.join(name)).unwrap();
    let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n").replace('\r', "\n");
    let ends = |line: &str| {
        let line = line.trim();
        let next_bone = line == "end" || line.starts_with(":");
        line == "}" || next_bone || line.starts_with("JOINT") || line.parse::<f64>().is_ok()
    };
    let lines: Vec<&str> = text.lines().collect();
    let is_row = name.ends_with(".bvh") && lines.iter().take(line as usize).any(|line| line.trim() == "MOTION");
    if is_row {
        return line;
    }
    let after = lines
        .iter()
        .skip(line as usize)
        .position(|line| ends(line))
        .unwrap_or(lines.len().saturating_sub(line as usize));
    line + after as u32
}

#[test]
fn every_case_has_its_class_count_and_line() {
    let Some((folder, cases)) = cases() else { return };
    assert!(cases.len() >= 122, "{} cases", cases.len());
    let mut failures = Vec::new();
    for case in &cases {
        let name = &case.name;
        let Outcome { motion, findings } = read(&folder, case, &ReadOptions::default());
        let told: Vec<String> =
            findings.iter().map(|(file, finding)| format!("{file} {} {finding}", finding.severity.name())).collect();
        let class = match (&motion, findings.as_slice()) {
            (None, _) => "fault",
            (Some(_), []) => "ok",
            (Some(_), _) => "warning",
        };
        if class != case.class {
            failures.push(format!("{name}: {class} for {}: {told:?}", case.class));
            continue;
        }
        if let Some(motion) = &motion {
            assert_eq!(motion.channels.len(), motion.n_frames * motion.skeleton.n_channels(), "{name}");
            let found = (Some(motion.n_frames), Some(motion.skeleton.joints.len()));
            if found != (case.frames, case.joints) {
                failures.push(format!("{name}: frames, joints {found:?} for {:?}", (case.frames, case.joints)));
            }
        }
        if let Some(line) = case.line {
            let file = case.r#in.as_deref().unwrap_or("bvh");
            let last = last_line(&folder, case, line);
            if findings.len() != 1 || findings[0].0 != file || !(line..=last).contains(&findings[0].1.line) {
                failures.push(format!("{name}: not one finding in {file}:{line}..={last}: {told:?}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn strict_refuses_what_is_warned_of_and_nothing_else() {
    let Some((folder, cases)) = cases() else { return };
    let strict = ReadOptions { strict: true, ..ReadOptions::default() };
    for case in &cases {
        let outcome = read(&folder, case, &strict);
        assert_eq!(outcome.motion.is_some(), case.class == "ok", "{}", case.name);
        assert!(outcome.findings.iter().all(|(_, finding)| finding.severity == Severity::Fault), "{}", case.name);
    }
}

#[test]
fn every_finding_says_what_why_and_what_to_do() {
    let Some((folder, cases)) = cases() else { return };
    for case in &cases {
        for (_, finding) in read(&folder, case, &ReadOptions::default()).findings {
            let notice = finding.notice();
            assert!(
                notice.kind.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'),
                "{}",
                notice.kind
            );
            for text in [&notice.message, &notice.why, &notice.remedy] {
                assert!(text.len() > 5 && !text.ends_with('.'), "{}: {text}", case.name);
            }
        }
    }
}

#[test]
fn positions_of_every_readable_case_are_the_oracles() {
    let (Some((folder, cases)), Some(text)) = (cases(), shared_data::reference("quirks.csv.xz")) else { return };
    let mut expected = positions(&text, 1);
    let mut compared = 0;
    for case in cases.iter().filter(|case| case.class != "fault" && case.frames != Some(0)) {
        let mut expected = expected.remove(&case.name).unwrap_or_else(|| panic!("{}: no reference", case.name));
        if case.name == "names-latin-1.bvh" {
            // The oracle repairs the name to U+FFFD, we read it as Latin-1.
            expected = expected
                .into_iter()
                .map(|((frame, joint), at)| ((frame, joint.replace('\u{fffd}', "\u{df}")), at))
                .collect();
        }
        let motion = read(&folder, case, &ReadOptions::default()).motion.unwrap();
        let unit_m = motion.unit_m.unwrap_or(0.01);
        let frames: std::collections::BTreeSet<usize> = expected.keys().map(|(frame, _)| *frame).collect();
        assert_eq!(frames.len(), case.frames.unwrap(), "{}: every frame", case.name);
        compare(&case.name, &clip(motion, unit_m), &expected);
        compared += 1;
    }
    assert!(compared >= 80, "{compared} cases compared");
}
