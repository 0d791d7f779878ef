//! Channels to text and back are bit-identical; motion converted between the formats stays where it was.

use crate::captures::{CMU_UNIT_M, amc, asf, bvh, clip, files};
use crate::shared_data::{captures, shared};
use motionmill::formats::{
    Motion, ReadOptions, acclaim_to_bvh, bvh_to_acclaim, read_amc, read_asf, read_bvh, write_amc, write_asf, write_bvh,
};
use motionmill::motion::skeleton::PositionRule;
use motionmill::motion::{Skeleton, kinematics};
use proptest::prelude::*;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

fn bits(channels: &[f32]) -> Vec<u32> {
    channels.iter().map(|value| value.to_bits()).collect()
}

/// Every `step`-th BVH clip of a folder.
fn some_bvh(folder: &Path, step: usize) -> Vec<PathBuf> {
    let found = files(folder, "bvh");
    assert!(!found.is_empty(), "{}", folder.display());
    found.into_iter().step_by(step).collect()
}

fn reread_bvh(text: &[u8]) -> Motion {
    let reading = read_bvh(text, &ReadOptions::default()).unwrap();
    assert_eq!(reading.findings, []);
    reading.value
}

/// The motion as ASF and AMC text, read again.
fn reread_amc(motion: &Motion, header: Option<&str>, unit_m: f64) -> Motion {
    let options = ReadOptions::default();
    let skeleton = read_asf(&write_asf(&motion.skeleton, header, unit_m).unwrap(), &options).unwrap();
    assert_eq!(skeleton.findings, []);
    let text =
        write_amc(&motion.skeleton, &motion.channels, motion.frame_time_s.map(f64::recip), motion.first_frame_number)
            .unwrap();
    let reading = read_amc(&text, &skeleton.value, &options).unwrap();
    assert_eq!(reading.findings, []);
    reading.value
}

fn with(motion: &Motion, (skeleton, channels): (Skeleton, Vec<f32>)) -> Motion {
    Motion { skeleton, channels, ..motion.clone() }
}

/// Largest distance between the points of two clips that bear the same name, metres.
fn largest_distance(a: &Motion, b: &Motion, unit_m: f64) -> f64 {
    let names = |motion: &Motion| -> HashMap<String, usize> {
        let skeleton = &motion.skeleton;
        let joints = skeleton.joints.iter().enumerate().map(|(at, joint)| {
            // The conversion calls the root `root`.
            (if joint.parent.is_none() { "root".to_owned() } else { joint.name.clone() }, at)
        });
        let ends = skeleton.ends().into_iter().enumerate();
        let ends = ends.map(|(k, joint)| (format!("{} end", skeleton.joints[joint].name), skeleton.joints.len() + k));
        joints.chain(ends).collect()
    };
    let (names_a, names_b) = (names(a), names(b));
    let (poses_a, poses_b) = (kinematics::poses(&clip(a.clone(), unit_m)), kinematics::poses(&clip(b.clone(), unit_m)));
    assert_eq!(poses_a.n_frames, poses_b.n_frames);
    let shared: Vec<(usize, usize)> =
        names_a.iter().filter_map(|(name, &at)| Some((at, *names_b.get(name)?))).collect();
    assert!(shared.len() >= a.skeleton.joints.len().min(b.skeleton.joints.len()), "{}", shared.len());
    (0..poses_a.n_frames)
        .flat_map(|frame| shared.iter().map(move |&(a, b)| (frame, a, b)))
        .map(|(frame, a, b)| poses_a.at(frame, a).distance(poses_b.at(frame, b)))
        .fold(0.0, f64::max)
}

#[test]
fn bvh_clips_of_every_set_come_back_bit_for_bit() {
    let Some(data) = captures() else { return };
    let mut clips = some_bvh(&data.join("bandai-namco/dataset-1"), 12);
    clips.extend(some_bvh(&data.join("bandai-namco/dataset-2"), 100));
    clips.extend(some_bvh(&data.join("extra"), 1));
    for path in clips {
        let motion = bvh(&path);
        let frame_time_s = motion.frame_time_s.unwrap();
        for header in [Some(motion.header.as_str()), None] {
            let text = write_bvh(&motion.skeleton, header, frame_time_s, &motion.channels).unwrap();
            let again = reread_bvh(&text);
            assert_eq!(bits(&again.channels), bits(&motion.channels), "{}", path.display());
            assert_eq!(again.frame_time_s, motion.frame_time_s);
            assert_eq!(again.skeleton.layout_id(), motion.skeleton.layout_id());
            if header.is_some() {
                assert_eq!((&again.skeleton, &again.header), (&motion.skeleton, &motion.header));
            }
        }
    }
}

#[test]
fn amc_clips_come_back_bit_for_bit() {
    let Some(data) = captures() else { return };
    for path in files(&data.join("cmu"), "amc").into_iter().step_by(3) {
        let motion = amc(&path);
        let again = reread_amc(&motion, Some(&motion.header), CMU_UNIT_M);
        assert_eq!(bits(&again.channels), bits(&motion.channels), "{}", path.display());
        assert_eq!((again.skeleton, again.header), (motion.skeleton, motion.header));
    }
}

#[test]
fn a_made_asf_is_the_same_skeleton() {
    let Some(data) = captures() else { return };
    for path in files(&data, "asf") {
        let first = asf(&path);
        let text = write_asf(&first.skeleton, None, first.unit_m).unwrap();
        let second = read_asf(&text, &ReadOptions::default()).unwrap();
        assert_eq!(second.findings, [], "{}", path.display());
        assert_eq!(second.value.skeleton, first.skeleton, "{}", path.display());
        assert!((second.value.unit_m - first.unit_m).abs() < 1e-15);
    }
}

#[test]
fn acclaim_to_bvh_and_back_keeps_positions() {
    let Some(data) = captures() else { return };
    for name in ["02/02_01", "02/02_04", "02/02_05", "03/03_01", "01/01_14"] {
        let motion = amc(&data.join("cmu").join(format!("{name}.amc")));
        let (skeleton, channels) = acclaim_to_bvh(&motion.skeleton, &motion.channels).unwrap();
        let there = reread_bvh(&write_bvh(&skeleton, None, 1.0 / 120.0, &channels).unwrap());
        assert_eq!(bits(&there.channels), bits(&channels), "{name}");
        let off = largest_distance(&motion, &there, CMU_UNIT_M);
        assert!(off < 1e-5, "{name} there: {off} m");
        let back = with(&motion, bvh_to_acclaim(&there.skeleton, &there.channels).unwrap());
        let back = reread_amc(&back, None, CMU_UNIT_M);
        assert_eq!(back.skeleton.joints.len(), motion.skeleton.joints.len(), "{name}: no bone is needed in between");
        let off = largest_distance(&motion, &back, CMU_UNIT_M);
        assert!(off < 1e-4, "{name} back: {off} m");
    }
}

#[test]
fn made_angles_do_not_jump_from_frame_to_frame() {
    let Some(data) = captures() else { return };
    let motion = amc(&data.join("cmu/02/02_01.amc"));
    let (skeleton, channels) = acclaim_to_bvh(&motion.skeleton, &motion.channels).unwrap();
    let names = skeleton.channel_names();
    let width = names.len();
    for frame in 1..motion.n_frames {
        for (column, name) in names.iter().enumerate() {
            let step = channels[frame * width + column] - channels[(frame - 1) * width + column];
            assert!(step.abs() < 60.0, "{name} turns by {step} degrees into frame {frame}");
        }
    }
    let columns: Vec<usize> = (0..6).collect();
    let root: Vec<f32> = columns.iter().flat_map(|&column| [channels[7 * width + column]]).collect();
    let from = 7 * motion.skeleton.n_channels();
    let [x, y, z, a, b, c] = motion.channels[from..from + 6] else { panic!() };
    assert_eq!(root, [x, y, z, c, b, a], "the root's angles are passed on");
}

#[test]
fn bvh_to_acclaim_and_back_keeps_positions() {
    let (Some(data), Some(shared)) = (captures(), shared()) else { return };
    let mut clips = some_bvh(&data.join("bandai-namco/dataset-1"), 30);
    clips.extend(some_bvh(&data.join("extra/cmu-bvh"), 2));
    for quirk in [
        "base",
        "channel-order-per-joint",
        "channel-counts-0-1-2",
        "position-y-only",
        "positions-differ-from-offset",
        "root-offset-and-positions",
        "names-with-spaces",
        "names-odd",
        "no-end-site",
        "travel-on-outer-root",
    ] {
        clips.push(shared.join("data/quirks").join(format!("{quirk}.bvh")));
    }
    for path in clips {
        let mut motion = bvh(&path);
        for joint in &mut motion.skeleton.joints {
            joint.name = joint.name.replace(' ', "_");
        }
        for rule in [PositionRule::Replace, PositionRule::Add] {
            motion.skeleton.position_rule = rule;
            let there = with(&motion, bvh_to_acclaim(&motion.skeleton, &motion.channels).unwrap());
            let there = reread_amc(&there, None, 0.01);
            let off = largest_distance(&motion, &there, 0.01);
            assert!(off < 1e-5, "{} there, {rule:?}: {off} m", path.display());
            let back = with(&motion, acclaim_to_bvh(&there.skeleton, &there.channels).unwrap());
            let off = largest_distance(&motion, &back, 0.01);
            assert!(off < 1e-4, "{} back, {rule:?}: {off} m", path.display());
        }
    }
}

#[test]
fn every_acclaim_quirk_keeps_its_positions_as_bvh() {
    let Some(shared) = shared() else { return };
    let folder = shared.join("data/quirks");
    let mut converted = 0;
    for path in files(&folder, "amc") {
        let options = ReadOptions::default();
        let Ok(skeleton) = read_asf(&std::fs::read(path.with_extension("asf")).unwrap(), &options) else { continue };
        let Ok(motion) = read_amc(&std::fs::read(&path).unwrap(), &skeleton.value, &options) else { continue };
        let motion = motion.value;
        let there = with(&motion, acclaim_to_bvh(&motion.skeleton, &motion.channels).unwrap());
        let unit_m = motion.unit_m.unwrap();
        let off = largest_distance(&motion, &there, unit_m);
        assert!(off < 1e-5, "{} there: {off} m", path.display());
        let back = with(&motion, bvh_to_acclaim(&there.skeleton, &there.channels).unwrap());
        let off = largest_distance(&motion, &back, unit_m);
        assert!(off < 1e-4, "{} back: {off} m", path.display());
        converted += 1;
    }
    assert!(converted >= 25, "{converted}");
}

#[test]
fn two_bodies_are_no_acclaim_file() {
    let Some(shared) = shared() else { return };
    let motion = bvh(&shared.join("data/quirks/two-roots.bvh"));
    let error = bvh_to_acclaim(&motion.skeleton, &motion.channels).unwrap_err();
    assert_eq!(error.to_string(), "2 roots, where Acclaim holds one");
}

/// Any finite f32, all exponents alike.
fn any_finite() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |value| value.is_finite())
}

const SMALL_BVH: &str = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 2 Xposition Zrotation\nJOINT b\n{\nOFFSET 1 0 0\n\
    CHANNELS 1 Yrotation\n}\n}\nMOTION\nFrames: 0\nFrame Time: 0.1\n";
const SMALL_ASF: &str = ":units\nlength 1\nangle deg\n:root\norder TX RZ\n:bonedata\nbegin\nname b\ndirection 1 0 0\n\
    length 1\ndof ry\nend\n:hierarchy\nroot b\n";

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_table_comes_back_bit_for_bit(frames in proptest::collection::vec([any_finite(), any_finite(), any_finite()], 1..20)) {
        let channels = frames.concat();
        let options = ReadOptions::default();
        let skeleton = read_bvh(SMALL_BVH.as_bytes(), &options).unwrap().value.skeleton;
        let text = write_bvh(&skeleton, None, 0.1, &channels).unwrap();
        prop_assert_eq!(bits(&read_bvh(&text, &options).unwrap().value.channels), bits(&channels));
        let skeleton = read_asf(SMALL_ASF.as_bytes(), &options).unwrap().value;
        let text = write_amc(&skeleton.skeleton, &channels, None, 1).unwrap();
        prop_assert_eq!(bits(&read_amc(&text, &skeleton, &options).unwrap().value.channels), bits(&channels));
    }
}
