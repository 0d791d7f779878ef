//! The adaptive detector and the classifier of gaits against the slow reference, clip by clip and frame by frame.
//!
//! When the detector was as CONTACTS 2 has it, no token, no gait frame and no estimate differed. What differs since, and
//! why: noise is estimated in a way that doesn't depend on where the clip faces, which moves single frames of noisy or
//! fast clips; jumps among stands make a clip a jump.

use crate::captures::{CMU_UNIT_M, amc, bvh, clip};
use crate::{golden, shared_data};
use motionmill::annotate::contacts::adaptive::adaptive_contacts;
use motionmill::annotate::contacts::foot_paths::FootPaths;
use motionmill::annotate::gait_machine::{machine_class, machine_gaits};
use motionmill::annotate::gait_steps::step_gaits;
use motionmill::annotate::gait_summary::clip_gait;
use motionmill::motion::kinematics::poses;
use motionmill::motion::{Poses, RoleMap, assign_roles};
use std::path::Path;

/// Poses, roles and rate of a capture, units as `shared/data/README.md` says.
pub(crate) fn capture(path: &Path) -> (Poses, RoleMap, f64) {
    let file = path.to_str().unwrap();
    let clip = match file.ends_with(".amc") {
        true => clip(amc(path), CMU_UNIT_M),
        false if file.contains("bandai-namco") => clip(bvh(path), 0.01),
        false => clip(bvh(path), if file.contains("metres") { 1.0 } else { CMU_UNIT_M }),
    };
    let poses = poses(&clip);
    let names = motionmill::flow::settings::shipped_names();
    let (roles, ..) = assign_roles(&clip.skeleton, &names, Some(&poses.world[..poses.n_points]));
    (poses, roles, clip.rate_hz)
}

#[test]
fn tokens_gaits_and_estimates_are_the_references() {
    let Some(data) = shared_data::captures() else { return };
    let Some(reference) = shared_data::reference("contacts.jsonl.xz") else { return };
    let lines = golden::parse(&reference);
    assert_eq!(lines.len(), 117);
    let [mut frames, mut other_tokens, mut other_gaits] = [0; 3];
    for line in lines {
        let file = line["file"].as_str().unwrap();
        let (poses, roles, rate_hz) = capture(&data.join(file));
        assert!((rate_hz - line["rate"].as_f64().unwrap()).abs() < 1e-9, "{file}");
        let feet = FootPaths::new(&poses, &roles, rate_hz).unwrap();
        let contacts = adaptive_contacts(&poses, &roles, &feet);
        let number = |field: &str| line[field].as_f64().unwrap();
        assert!((feet.leg_length_m - number("leg")).abs() < 1e-5, "{file}");
        let diagnosis = contacts.diagnosis.as_ref().unwrap();
        let noise_m = number("noise");
        assert!(
            (diagnosis.noise_m - noise_m).abs() < 1e-4 + 0.25 * noise_m,
            "{file}: {}, not {noise_m}",
            diagnosis.noise_m
        );
        let slope = contacts.ground.tilt.map_or([0.0; 2], |tilt| tilt.slope);
        for (found, wanted) in slope.iter().zip(line["tilt"].as_array().unwrap()) {
            assert!((found - wanted.as_f64().unwrap()).abs() < 5e-4, "{file}: {slope:?} not {}", line["tilt"]);
        }
        assert_eq!(contacts.ground.uneven, line["uneven"].as_bool(), "{file}");
        let (tokens, wanted) = (contacts.tokens(), golden::tokens(&line));
        assert_eq!(tokens.len(), wanted.len(), "{file}");
        let differing: Vec<usize> = (0..tokens.len()).filter(|&frame| tokens[frame] != wanted[frame]).collect();
        if !differing.is_empty() {
            println!("{file}: {} tokens differ, first at {}", differing.len(), differing[0]);
        }
        let gaits = step_gaits(&tokens, rate_hz, contacts.evidence());
        let wanted = golden::gaits(&line);
        let differing_gaits = (0..tokens.len()).filter(|&frame| gaits.gaits[frame] != wanted[frame]).count();
        if differing_gaits > 0 {
            println!("{file}: {differing_gaits} gaits differ");
        }
        let summary = clip_gait(&gaits, contacts.evidence()).unwrap();
        let class = if file.ends_with("02_04.amc") { "jump" } else { line["class"].as_str().unwrap() };
        assert_eq!(summary.class.name(), class, "{file}");
        let sure = number("confidence");
        assert!(
            (summary.confidence - sure).abs() < 0.03 || class == "jump",
            "{file}: {}, not {sure}",
            summary.confidence
        );
        assert_eq!(machine_class(&machine_gaits(&tokens)).name(), line["thesis_class"], "{file}");
        frames += tokens.len();
        other_tokens += differing.len();
        other_gaits += differing_gaits;
    }
    println!("{frames} frames, {other_tokens} tokens and {other_gaits} gaits differ");
    assert!(other_tokens <= 3 && other_gaits == 0);
}
