//! Whatever the bytes, reading ends, without a panic, in bounded memory; what is read can be written.

use crate::shared_data::{captures, shared};
use motionmill::formats::{AsfSkeleton, Motion, ReadOptions, read_amc, read_asf, read_bvh, write_amc, write_bvh};
use proptest::prelude::*;
use std::path::PathBuf;
use std::sync::OnceLock;

/// A way to damage a text. Places are thousandths of its length.
#[derive(Clone, Debug)]
enum Damage {
    Cut(usize),
    Flip(usize, u8),
    Insert(usize, Vec<u8>),
    ReplaceWord(usize, String),
    DoubleLine(usize),
    RemoveLine(usize),
    SwapLines(usize, usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    let place = || 0..1000_usize;
    let word = prop_oneof![
        Just("nan".to_owned()),
        Just("-inf".to_owned()),
        Just("1e999".to_owned()),
        Just("1e39".to_owned()),
        Just("12.5.1".to_owned()),
        Just("99999999999999999999".to_owned()),
        Just("-1".to_owned()),
        Just("{".to_owned()),
        Just("}".to_owned()),
        Just("MOTION".to_owned()),
        Just("JOINT".to_owned()),
        Just("root".to_owned()),
        Just("begin".to_owned()),
        Just(":bonedata".to_owned()),
        Just(String::new()),
        "[0-9.eE+,-]{1,25}",
    ];
    prop_oneof![
        place().prop_map(Damage::Cut),
        (place(), any::<u8>()).prop_map(|(at, byte)| Damage::Flip(at, byte)),
        (place(), proptest::collection::vec(any::<u8>(), 1..20)).prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (place(), word).prop_map(|(at, word)| Damage::ReplaceWord(at, word)),
        place().prop_map(Damage::DoubleLine),
        place().prop_map(Damage::RemoveLine),
        (place(), place()).prop_map(|(a, b)| Damage::SwapLines(a, b)),
    ]
}

fn apply(bytes: &mut Vec<u8>, damage: &Damage) {
    let place = |at: usize, length: usize| (at * length / 1000).min(length.saturating_sub(1));
    let mut lines: Vec<Vec<u8>> = bytes.split_inclusive(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
    if bytes.is_empty() {
        return;
    }
    let length = bytes.len();
    match damage {
        Damage::Cut(at) => bytes.truncate(place(*at, length)),
        Damage::Flip(at, byte) => bytes[place(*at, length)] ^= byte,
        Damage::Insert(at, inserted) => {
            let at = place(*at, length);
            bytes.splice(at..at, inserted.iter().copied());
        }
        Damage::ReplaceWord(at, word) => {
            let from = place(*at, length);
            let is_space = |byte: &u8| byte.is_ascii_whitespace();
            let to = bytes[from..].iter().position(is_space).map_or(length, |n| from + n);
            let from = bytes[..from].iter().rposition(is_space).map_or(0, |n| n + 1).min(to);
            bytes.splice(from..to, word.bytes());
        }
        Damage::DoubleLine(at) => {
            let at = place(*at, lines.len());
            lines.insert(at, lines[at].clone());
            *bytes = lines.concat();
        }
        Damage::RemoveLine(at) => {
            lines.remove(place(*at, lines.len()));
            *bytes = lines.concat();
        }
        Damage::SwapLines(a, b) => {
            let (a, b) = (place(*a, lines.len()), place(*b, lines.len()));
            lines.swap(a, b);
            *bytes = lines.concat();
        }
    }
}

/// A file to damage.
struct Original {
    text: Vec<u8>,
    /// The ASF text of an AMC file.
    skeleton: Option<Vec<u8>>,
}

/// Small files of both formats: the quirks, and the first frames of real clips.
fn originals() -> &'static [Original] {
    static FILES: OnceLock<Vec<Original>> = OnceLock::new();
    FILES.get_or_init(|| {
        let (Some(shared), Some(data)) = (shared(), captures()) else { return Vec::new() };
        let head = |path: PathBuf, most: usize| {
            let mut bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            let end = bytes
                .iter()
                .enumerate()
                .skip(most)
                .find(|(_, byte)| **byte == b'\n')
                .map_or(bytes.len(), |(at, _)| at + 1);
            bytes.truncate(end);
            bytes
        };
        let quirks = shared.join("data/quirks");
        let bvh = |path: PathBuf| Original { text: head(path, 12_000), skeleton: None };
        let amc = |path: PathBuf, skeleton: PathBuf| Original {
            text: head(path, 12_000),
            skeleton: Some(head(skeleton, usize::MAX)),
        };
        let mut files = vec![
            bvh(data.join("bandai-namco/dataset-1/dataset-1_bow_happy_001.bvh")),
            bvh(data.join("extra/cmu-bvh/12_01.bvh")),
            amc(data.join("cmu/02/02_01.amc"), data.join("cmu/02/02.asf")),
        ];
        let names =
            ["base", "number-forms", "line-ends-mixed", "rows-wrapped", "two-roots", "names-odd", "trailing-garbage"];
        files.extend(names.map(|name| bvh(quirks.join(format!("{name}.bvh")))));
        let names = ["acclaim-base", "asf-dof-length-and-translation", "amc-exponents", "acclaim-crlf-tabs"];
        let quirk = |name: &str, extension: &str| quirks.join(format!("{name}.{extension}"));
        files.extend(names.map(|name| amc(quirk(name, "amc"), quirk(name, "asf"))));
        files
    })
}

fn check(motion: &Motion, bytes: &[u8]) {
    let width = motion.skeleton.n_channels();
    assert_eq!(motion.channels.len(), motion.n_frames * width);
    assert!(motion.channels.len() <= bytes.len(), "{} values from {} bytes", motion.channels.len(), bytes.len());
    assert!(motion.n_frames * motion.skeleton.joints.len() <= 16 * bytes.len());
    assert!(motion.channels.iter().all(|value| value.is_finite()));
    assert!(motion.max_rounding.is_finite());
    let parents = motion.skeleton.joints.iter().enumerate();
    assert!(parents.into_iter().all(|(at, joint)| joint.parent.is_none_or(|parent| parent < at)));
}

fn read_any_bvh(bytes: &[u8]) {
    match read_bvh(bytes, &ReadOptions::default()) {
        Ok(reading) => {
            let motion = reading.value;
            check(&motion, bytes);
            let text =
                write_bvh(&motion.skeleton, Some(&motion.header), motion.frame_time_s.unwrap(), &motion.channels)
                    .unwrap();
            let again = read_bvh(&text, &ReadOptions::default()).unwrap_or_else(|fault| panic!("{fault}")).value;
            let bits = |motion: &Motion| motion.channels.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&again), bits(&motion));
        }
        Err(fault) => {
            fault.notice();
        }
    }
}

fn read_any_amc(bytes: &[u8], skeleton: &AsfSkeleton) {
    match read_amc(bytes, skeleton, &ReadOptions::default()) {
        Ok(reading) => {
            let motion = reading.value;
            check(&motion, bytes);
            let text = write_amc(
                &motion.skeleton,
                &motion.channels,
                motion.frame_time_s.map(f64::recip),
                motion.first_frame_number,
            )
            .unwrap();
            if motion.n_frames > 0 && motion.skeleton.n_channels() > 0 {
                let again = read_amc(&text, skeleton, &ReadOptions::default());
                let again = again.unwrap_or_else(|fault| panic!("{fault}")).value;
                assert_eq!(again.channels, motion.channels);
            }
        }
        Err(fault) => {
            fault.notice();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn damaged_files_end_in_motion_or_a_fault(
        which in any::<prop::sample::Index>(),
        in_skeleton in any::<bool>(),
        damages in proptest::collection::vec(damage(), 1..4),
    ) {
        let files = originals();
        if files.is_empty() {
            return Ok(());
        }
        let Original { text, skeleton } = &files[which.index(files.len())];
        let (mut text, mut skeleton) = (text.clone(), skeleton.clone());
        for damage in &damages {
            apply(if in_skeleton { skeleton.as_mut().unwrap_or(&mut text) } else { &mut text }, damage);
        }
        match skeleton {
            None => read_any_bvh(&text),
            Some(skeleton) => match read_asf(&skeleton, &ReadOptions::default()) {
                Ok(skeleton) => read_any_amc(&text, &skeleton.value),
                Err(fault) => {
                    fault.notice();
                }
            },
        }
    }

    #[test]
    fn arbitrary_bytes_end_in_motion_or_a_fault(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let asf = b":root\norder TX rx\n:bonedata\nbegin\nname a\ndirection 1 0 0\nlength 1\ndof rx\nend\n:hierarchy\nroot a\n";
        let skeleton = read_asf(asf, &ReadOptions::default()).unwrap().value;
        read_any_bvh(&bytes);
        read_any_amc(&bytes, &skeleton);
        let _ = read_asf(&bytes, &ReadOptions::default());
        read_any_bvh(&[b"HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xposition\n}\nMOTION\nFrames: 2\nFrame Time: 1\n", bytes.as_slice()].concat());
        read_any_amc(&[b":DEGREES\n1\n", bytes.as_slice()].concat(), &skeleton);
        let _ = read_asf(&[&asf[..40], bytes.as_slice()].concat(), &ReadOptions::default());
    }

    #[test]
    fn arbitrary_words_end_in_motion_or_a_fault(
        words in proptest::collection::vec(prop_oneof![
            Just("ROOT"), Just("JOINT"), Just("End Site"), Just("OFFSET 0 0 0"), Just("CHANNELS 1 Xrotation"), Just("{"),
            Just("}"), Just("MOTION"), Just("Frames: 2"), Just("Frame Time: 1"), Just("1"), Just("\n"), Just("x"),
            Just(":bonedata"), Just(":hierarchy"), Just("begin"), Just("end"), Just("name a"), Just("name b"),
            Just("direction 1 0 0"), Just("length 1"), Just("root a"), Just("a b"), Just("b a"), Just("dof rx"),
        ], 0..60)
    ) {
        let text = words.join("\n");
        read_any_bvh(format!("HIERARCHY\n{text}").as_bytes());
        if let Ok(skeleton) = read_asf(text.as_bytes(), &ReadOptions::default()) {
            read_any_amc(b"1\na 1\n2\n", &skeleton.value);
        }
    }
}

#[test]
fn counts_in_the_file_are_not_believed() {
    let rows = "1\n2\n";
    let hierarchy = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xposition\n}\nMOTION\nFrame Time: 1\n";
    for said in ["18446744073709551615", "99999999999999999999999999", "1000000000000"] {
        let text = format!("{hierarchy}Frames: {said}\n{rows}");
        let reading = read_bvh(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!((reading.value.n_frames, reading.findings[0].kind()), (2, "frames-fewer-than-said"));
        assert!(reading.value.channels.capacity() <= text.len());
    }
    let text =
        "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 4000000000 Xposition\n}\nMOTION\nFrames: 1\nFrame Time: 1\n1\n";
    assert_eq!(read_bvh(text.as_bytes(), &ReadOptions::default()).unwrap_err().kind(), "channel-count");
}

#[test]
fn a_small_file_cannot_ask_for_much_memory() {
    let joints: String = (0..3000).map(|n| format!("JOINT j{n}\n{{\nOFFSET 0 1 0\n}}\n")).collect();
    let rows = "1\n".repeat(1_000_000);
    let text = format!(
        "HIERARCHY\nROOT a\n{{\nOFFSET 0 0 0\nCHANNELS 1 Xposition\n{joints}}}\nMOTION\nFrames: 1000000\nFrame Time: 1\n{rows}"
    );
    assert_eq!(read_bvh(text.as_bytes(), &ReadOptions::default()).unwrap_err().kind(), "too-many-poses");
    let asf: String =
        (0..1000).map(|n| format!("begin\nname b{n}\ndirection 1 0 0\nlength 1\ndof rx ry rz\nend\n")).collect();
    let names: String = (0..1000).map(|n| format!(" b{n}")).collect();
    let asf = format!(":bonedata\n{asf}:hierarchy\nroot{names}\n");
    let skeleton = read_asf(asf.as_bytes(), &ReadOptions::default()).unwrap().value;
    let frames: String = (0..100_000).map(|n| format!("{n}\n")).collect();
    let fault = read_amc(frames.as_bytes(), &skeleton, &ReadOptions::default()).unwrap_err();
    assert_eq!(fault.kind(), "bone-lines-mostly-absent");
}

#[test]
fn limits_are_kept() {
    let nested = |depth: usize| {
        let open: String =
            (0..depth).map(|n| format!("{} j{n}\n{{\nOFFSET 0 1 0\n", if n == 0 { "ROOT" } else { "JOINT" })).collect();
        format!("HIERARCHY\n{open}{}MOTION\nFrames: 0\nFrame Time: 1\n", "}\n".repeat(depth))
    };
    let kind = |text: String, options: &ReadOptions| match read_bvh(text.as_bytes(), options) {
        Ok(reading) => reading.findings[0].kind(),
        Err(fault) => fault.kind(),
    };
    let mut options = ReadOptions::default();
    assert_eq!(kind(nested(4096), &options), "zero-frames");
    assert_eq!(kind(nested(4097), &options), "too-many-joints");
    options.limits.max_depth = 10;
    assert_eq!(kind(nested(10), &options), "zero-frames");
    assert_eq!(kind(nested(11), &options), "too-deep");
    let named = format!("HIERARCHY\nROOT {}\n{{\n", "x".repeat(2000));
    assert_eq!(kind(named, &options), "name-too-long");
    options.limits.max_clip_bytes = 10;
    assert_eq!(kind(nested(1), &options), "file-too-large");
}
