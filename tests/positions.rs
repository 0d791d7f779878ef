//! World positions are those of the oracle, and of a conversion made by others from the same capture.

use crate::captures::{CMU_UNIT_M, amc, bvh, clip, compare, positions};
use crate::shared_data::{captures, reference, shared};
use motionmill::motion::{Clip, kinematics};
use std::path::Path;

/// The capture that a reference is of, with its unit.
fn capture(data: &Path, set: &str, name: &str) -> Clip {
    match set {
        "bandai-namco" => {
            let dataset = name.split('_').next().unwrap();
            clip(bvh(&data.join(set).join(dataset).join(format!("{name}.bvh"))), 0.01)
        }
        _ => {
            let subject = name.split('_').next().unwrap();
            let folder = if set == "cmu" { data.join("cmu") } else { data.join("extra/cmu") };
            let motion = folder.join(subject).join(format!("{name}.amc"));
            if motion.exists() {
                let motion = amc(&motion);
                let unit_m = motion.unit_m.unwrap();
                assert!((unit_m - CMU_UNIT_M).abs() < 1e-15);
                return clip(motion, unit_m);
            }
            let unit_m = if name.ends_with("metres") { 1.0 } else { CMU_UNIT_M };
            clip(bvh(&data.join("extra/cmu-bvh").join(format!("{name}.bvh"))), unit_m)
        }
    }
}

#[test]
fn every_reference_is_met() {
    let (Some(data), Some(shared)) = (captures(), shared()) else { return };
    let mut compared = 0;
    for entry in std::fs::read_dir(shared.join("oracle/reference")).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        let Some(stem) = file.strip_suffix(".csv.xz").filter(|stem| *stem != "quirks") else { continue };
        let (set, name) = stem.split_once('.').unwrap();
        let expected = positions(&reference(&file).unwrap(), 0).remove("").unwrap();
        let worst = compare(stem, &capture(&data, set, name), &expected);
        assert!(worst < 1e-5, "{stem}: {worst} m");
        compared += 1;
    }
    assert!(compared >= 37, "{compared} references");
}

#[test]
fn an_amc_and_its_bvh_conversion_agree_in_legs_and_spine() {
    let Some(data) = captures() else { return };
    let ours = capture(&data, "cmu", "01_01");
    let theirs = clip(bvh(&data.join("extra/cmu-bvh/01_01.bvh")), CMU_UNIT_M);
    assert_eq!(theirs.n_frames, ours.n_frames + 1, "a T-pose comes first");
    let (our_poses, their_poses) = (kinematics::poses(&ours), kinematics::poses(&theirs));
    let joint = |clip: &Clip, name: &str| clip.skeleton.joints.iter().position(|joint| joint.name == name).unwrap();
    let pairs = [
        ("root", "Hips"),
        ("lfemur", "LeftUpLeg"),
        ("ltibia", "LeftLeg"),
        ("lfoot", "LeftFoot"),
        ("ltoes", "LeftToeBase"),
        ("rfemur", "RightUpLeg"),
        ("rtibia", "RightLeg"),
        ("rfoot", "RightFoot"),
        ("rtoes", "RightToeBase"),
        ("upperback", "Spine"),
        ("thorax", "Spine1"),
    ];
    let mut worst = 0.0_f64;
    for (our_name, their_name) in pairs {
        let (our_joint, their_joint) = (joint(&ours, our_name), joint(&theirs, their_name));
        for frame in 0..ours.n_frames {
            let off = our_poses.at(frame, our_joint).distance(their_poses.at(frame + 1, their_joint));
            assert!(off < 1e-5, "{our_name} in frame {frame}: {off} m");
            worst = worst.max(off);
        }
    }
    assert!(worst > 1e-7, "two files with four decimals can't agree to {worst} m");
}
