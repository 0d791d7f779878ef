//! Chains, correlation, grafts and judge against the slow reference's answers (GRAFTS 1, 2, 3, 5).
//!
//! The reference keeps the files' numbers in f64, a clip keeps the nearest f32: an angle of 100 degrees is off by up to
//! 4e-6 degrees, a position of 400 cm by up to 1.5e-5 cm. That moves a wrist by some 1e-7 m and a rotation by 1e-7 rad; a third
//! difference at 30 Hz multiplies it by up to 8 x 27,000, a second one by 4 x 900. The tolerances are a few times what was seen,
//! and below those bounds. With channels rounded to f32 in a copy of the reference all differences shrink to its nine printed
//! digits (jerk of captured clips 5e-9, of grafts 8e-7: theirs are printed before they are rounded), but for the study's leg,
//! which is 0.800665 m here and 0.8007 m there. The reference divides by the frame time as printed (0.0333333), so these
//! clips get that rate and not the snapped one.

use crate::captures::{CMU_UNIT_M, amc, bvh};
use crate::shared_data::{captures, reference};
use glam::DVec3;
use motionmill::annotate::labels::Foot;
use motionmill::motion::chains::raw_chains;
use motionmill::motion::role_names::NameTables;
use motionmill::motion::rotation::{rotation_vector, slerp};
use motionmill::motion::{Clip, UpAxis};
use motionmill::synthesis::correlation::{alternates, frame_map};
use motionmill::synthesis::graft::graft_timed;
use motionmill::synthesis::judge::{Reference, judge};
use motionmill::synthesis::{
    Action, ActionSettings, CorrelationSettings, Figures, Footwork, GateSettings, GraftSettings, Measure, Movement,
    Part, Placement, Refusal, Subject, graft,
};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The largest differences seen, by quantity, held against what is allowed.
#[derive(Default)]
struct Worst {
    seen: BTreeMap<String, (f64, usize)>,
}

impl Worst {
    fn absolute(&mut self, quantity: &str, got: f64, expected: f64, allowed: f64, place: &str) {
        let difference = (got - expected).abs();
        assert!(difference <= allowed, "{place}: {quantity} {got}, the reference has {expected}, off by {difference}");
        let entry = self.seen.entry(quantity.to_owned()).or_default();
        *entry = (entry.0.max(difference), entry.1 + 1);
    }

    fn relative(&mut self, quantity: &str, got: f64, expected: f64, allowed: f64, place: &str) {
        self.absolute(&format!("{quantity} (relative)"), got / expected, 1.0, allowed, place);
    }

    fn print(&self, command: &str) {
        for (quantity, (difference, count)) in &self.seen {
            eprintln!("{command}: {quantity}: {difference:.1e} over {count}");
        }
    }
}

fn tables() -> NameTables {
    NameTables::from_toml(&[
        ("bandai-namco", include_str!("../configs/skeletons/bandai-namco.toml")),
        ("cmu-asf", include_str!("../configs/skeletons/cmu-asf.toml")),
        ("cgspeed", include_str!("../configs/skeletons/cgspeed.toml")),
    ])
    .unwrap()
}

/// A file with what the arguments say of it; the rate is the inverse of the frame time as printed.
fn subject(data: &Path, file: &str) -> Subject {
    let path: PathBuf = data.join(file);
    let clip: Clip = if file.ends_with(".amc") {
        amc(&path).into_clip(120.0, CMU_UNIT_M, UpAxis::Y)
    } else {
        let motion = bvh(&path);
        let rate_hz = 1.0 / motion.frame_time_s.unwrap();
        motion.into_clip(rate_hz, 0.01, UpAxis::Y)
    };
    let (_, roles) = tables().best(&clip.skeleton).map(|(name, roles)| (name.to_owned(), roles)).unwrap();
    Subject::new(Arc::new(clip), &roles).unwrap()
}

/// The lines of a command: files, the whole line.
fn lines(command: &str) -> Option<(PathBuf, Vec<Value>)> {
    let data = captures()?;
    let text = reference("grafts.jsonl.xz")?;
    let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    Some((data, lines.filter(|line| line["args"][0] == command).collect()))
}

fn file(line: &Value, n: usize) -> &str {
    line["args"][n].as_str().unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn chains_and_parts_are_those_of_the_reference() {
    let Some((data, lines)) = lines("chains") else { return };
    assert_eq!(lines.len(), 3);
    for line in lines {
        let subject = subject(&data, file(&line, 1));
        let joints = &subject.clip.skeleton.joints;
        let names = |indices: &[usize]| indices.iter().map(|&joint| joints[joint].name.as_str()).collect::<Vec<_>>();
        let sorted = |mut names: Vec<&str>| {
            names.sort_unstable();
            names.join(" ")
        };
        let words = |list: &Value| -> Vec<String> {
            list.as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
        };
        // The reader may hold siblings in another order than the file; chains are a set.
        let mut got: Vec<String> = raw_chains(&subject.clip.skeleton).iter().map(|c| names(c).join(" ")).collect();
        let mut expected: Vec<String> =
            line["out"]["chains"].as_array().unwrap().iter().map(|chain| words(chain).join(" ")).collect();
        got.sort_unstable();
        expected.sort_unstable();
        assert_eq!(got, expected);
        for (part, roles) in [
            (Part::Root, vec!["pelvis"]),
            (Part::Legs, vec!["leg_left", "leg_right"]),
            (Part::Trunk, vec!["trunk"]),
            (Part::Head, vec!["head"]),
            (Part::ArmLeft, vec!["arm_left"]),
            (Part::ArmRight, vec!["arm_right"]),
        ] {
            let expected: Vec<String> = roles.iter().flat_map(|role| words(&line["out"]["roles"][role])).collect();
            let expected = sorted(expected.iter().map(String::as_str).collect());
            assert_eq!(sorted(names(subject.parts.joints(part))), expected, "{part:?}");
        }
    }
}

#[test]
fn correlation_is_that_of_the_reference() {
    let Some((data, lines)) = lines("correlate") else { return };
    assert_eq!(lines.len(), 29);
    let settings = CorrelationSettings::default();
    let (mut worst, mut refusals) = (Worst::default(), 0);
    for line in &lines {
        let place = format!("{} <- {}", file(line, 1), file(line, 2));
        let out = &line["out"];
        let [base, donor] = [1, 2].map(|n| Footwork::of(&subject(&data, file(line, n)).movement, &settings));
        for (footwork, name) in [(&base, "base_passes"), (&donor, "donor_passes")] {
            let passes = out[name].as_array().unwrap();
            assert_eq!(footwork.passes.len(), passes.len(), "{place}: {name}");
            for (got, expected) in footwork.passes.iter().zip(passes) {
                assert_eq!(got.ahead == Foot::Left, expected["ahead"] == "left", "{place}: {name}");
                let time_s = got.frame / footwork.rate_hz;
                worst.absolute("time of a pass, s", time_s, number(&expected["time"]), 3e-7, &place);
            }
        }
        let found = alternates(&base, &donor, &settings).unwrap();
        let best = &found[0];
        assert_eq!(i64::from(best.shift), out["shift"].as_i64().unwrap(), "{place}");
        worst.absolute("cost, m", best.cost_m, number(&out["cost"]), 3e-7, &place);
        let pairs = out["pairs"].as_array().unwrap();
        assert_eq!(best.pairs.len(), pairs.len(), "{place}");
        for (got, expected) in best.pairs.iter().zip(pairs) {
            worst.absolute("time of a pair, s", got[0] / base.rate_hz, number(&expected[0]), 3e-7, &place);
            worst.absolute("time of a pair, s", got[1] / donor.rate_hz, number(&expected[1]), 3e-7, &place);
        }
        if let Some(expected) = out["alternates"].as_array() {
            assert_eq!(found.len(), expected.len(), "{place}");
            for (got, expected) in found.iter().zip(expected) {
                assert_eq!(i64::from(got.shift), expected["shift"].as_i64().unwrap(), "{place}");
                assert_eq!(got.pairs.len() as u64, expected["pairs"].as_u64().unwrap(), "{place}");
                worst.absolute("cost, m", got.cost_m, number(&expected["cost"]), 3e-7, &place);
                worst.absolute("distance, m", got.distance_m, number(&expected["distance"]), 3e-7, &place);
            }
        }
        // The reference gives the map of a refused pair too.
        let refused = frame_map(best, &base, &donor, &settings);
        assert_eq!(refused.is_err(), out.get("refused").is_some(), "{place}");
        refusals += usize::from(refused.is_err());
        let anything = CorrelationSettings { min_rate_factor: 0.0, max_rate_factor: 99.0, ..settings.clone() };
        let map = frame_map(best, &base, &donor, &anything).unwrap();
        assert_eq!(map.first as u64, out["first_base_frame"].as_u64().unwrap(), "{place}");
        let frames = out["donor_frames"].as_array().unwrap();
        assert_eq!(map.donor_frames.len(), frames.len(), "{place}");
        for (&got, expected) in map.donor_frames.iter().zip(frames) {
            worst.absolute("frame of the map", got, number(expected), 1e-5, &place);
        }
        for (got, expected) in map.rate_factors.into_iter().zip(out["rate"].as_array().unwrap()) {
            worst.absolute("rate factor", got, number(expected), 1e-6, &place);
        }
    }
    assert_eq!(refusals, 2);
    worst.print("correlate");
}

/// Holds figures against the reference's.
fn compare_figures(worst: &mut Worst, got: &Figures, expected: &Value, rate_hz: f64, place: &str) {
    let fast = rate_hz > 60.0;
    for (name, expected) in expected.as_object().unwrap() {
        let measure = Measure::from_name(name).unwrap();
        let place = format!("{place}: {name}");
        let Some(expected) = expected.as_f64() else {
            assert_eq!(got.get(measure), None, "{place}");
            continue;
        };
        let Some(got) = got.get(measure) else { panic!("{place}: the reference has {expected}") };
        let name = if fast { format!("{name} at 120 Hz") } else { name.clone() };
        match measure {
            // Third and second differences of what was rounded to f32.
            Measure::WristJerk => worst.relative(&name, got, expected, if fast { 1e-5 } else { 2e-4 }, &place),
            Measure::UpperAngularAcceleration | Measure::LegAngularAcceleration => {
                worst.relative(&name, got, expected, if fast { 1e-6 } else { 1e-5 }, &place);
            }
            // Metres, and metres a second: differences of rounded positions, once times the rate.
            Measure::Skate => worst.absolute(&name, got, expected, 2e-6, &place),
            Measure::PlantDrift => worst.absolute(&name, got, expected, 1e-6, &place),
            // The study's leg is 0.800665 m here and 0.8007 m there: 4e-5 of a radius on other bodies.
            Measure::Penetration => worst.absolute(&name, got, expected, if fast { 2e-6 } else { 1e-7 }, &place),
            Measure::SelfCollision => worst.absolute(&name, got, expected, if fast { 1e-5 } else { 1e-6 }, &place),
            _ => worst.absolute(&name, got, expected, 2e-7, &place),
        }
    }
}

#[test]
fn figures_are_those_of_the_reference() {
    let Some((data, lines)) = lines("judge") else { return };
    assert_eq!(lines.len(), 30);
    let mut worst = Worst::default();
    for line in &lines {
        let movement = subject(&data, file(line, 1)).movement;
        compare_figures(
            &mut worst,
            &Figures::of(&movement, &Reference::default()),
            &line["out"],
            movement.rate_hz,
            file(line, 1),
        );
    }
    worst.print("judge");
}

#[test]
fn grafts_and_verdicts_are_those_of_the_reference() {
    let Some((data, lines)) = lines("graft") else { return };
    assert_eq!(lines.len(), 28);
    let (mut worst, mut refused) = (Worst::default(), 0);
    for line in &lines {
        let place = format!("{} <- {}", file(line, 1), file(line, 2));
        let out = &line["out"];
        let [base, donor] = [1, 2].map(|n| subject(&data, file(line, n)));
        let option = |name: &str| {
            let args = line["args"].as_array().unwrap();
            args.iter().position(|arg| arg == name).map(|at| args[at + 1].as_str().unwrap())
        };
        let parts: Vec<Part> = match option("--chains").unwrap() {
            "active" => Action::of(&donor.movement, &ActionSettings::default()).parts(),
            names => names.split(',').map(|name| Part::from_name(name).unwrap()).collect(),
        };
        let placement = match option("--at") {
            Some(time_s) => Placement::whole_at(time_s.parse().unwrap(), &donor.movement),
            None => Placement::Correlated { alternate: 0 },
        };
        let made = graft(&base, &donor, &parts, &placement, &GraftSettings::default());
        if let Some(error) = out.get("error") {
            refused += 1;
            let refusal = made.unwrap_err();
            match error.as_str().unwrap() {
                "the rate leaves 0.6 to 1.6" => assert!(matches!(refusal, Refusal::RateOutOfRange { .. }), "{place}"),
                "the base does not hold the whole donor action" => {
                    assert!(matches!(refusal, Refusal::BaseTooShort { .. }), "{place}");
                }
                other => panic!("{place}: {other}"),
            }
            continue;
        }
        let made = made.unwrap();
        let names: Vec<&str> = parts.iter().map(|part| part.name()).collect();
        assert_eq!(serde_json::json!(names), out["chains"], "{place}");
        let timing = placement.timing(&base.movement, &donor.movement, &CorrelationSettings::default()).unwrap();
        worst.absolute("begin and end, s", timing.first_s, number(&out["first"]), 1e-8, &place);
        worst.absolute("begin and end, s", timing.last_s, number(&out["last"]), 1e-8, &place);

        let (_, roles) = tables().best(&made.clip.skeleton).map(|(name, roles)| (name.to_owned(), roles)).unwrap();
        let movement = Movement::of_clip(&made.clip, &roles).unwrap();
        for (side, arm) in ["left", "right"].into_iter().zip(movement.landmarks.arms) {
            let expected = line["wrists"][side].as_array().unwrap();
            for (frame, expected) in line["frames"].as_array().unwrap().iter().zip(expected) {
                let wrist = movement.poses.at(frame.as_u64().unwrap() as usize, arm.wrist);
                let expected = DVec3::from_array([0, 1, 2].map(|axis| number(&expected[axis])));
                worst.absolute("position of a wrist, m", wrist.distance(expected), 0.0, 1.5e-6, &place);
            }
        }

        let own = Figures::of(&movement, &Reference::default());
        compare_figures(&mut worst, &own, &line["judge"]["figures"], movement.rate_hz, &place);
        let parents =
            [&base, &donor].map(|parent| Figures::of_parent(&parent.movement, movement.rate_hz, &Reference::default()));
        let verdict = judge(&own, &parents[0], &parents[1], true, &GateSettings::default());
        for (name, expected) in line["judge"]["accepted"].as_object().unwrap() {
            let gate = verdict.gates[Measure::from_name(name).unwrap() as usize];
            assert_eq!(gate, expected.as_bool(), "{place}: {name}");
        }
        assert!(made.misfit.is_none(), "{place}: Bandai-Namco's joints turn about three axes");
    }
    assert_eq!(refused, 2);
    worst.print("graft");
}

/// A graft's verdict beside its parents.
fn reasons(base: &Subject, donor: &Subject, made: &Clip, cyclic: bool) -> Vec<String> {
    let (_, roles) = tables().best(&made.skeleton).map(|(name, roles)| (name.to_owned(), roles)).unwrap();
    let own = Figures::of(&Movement::of_clip(made, &roles).unwrap(), &Reference::default());
    let [base, donor] =
        [base, donor].map(|parent| Figures::of_parent(&parent.movement, made.rate_hz, &Reference::default()));
    judge(&own, &base, &donor, cyclic, &GateSettings::default()).reasons
}

#[test]
fn broken_grafts_are_refused_by_the_gate_that_is_meant_for_them() {
    let Some((data, lines)) = lines("graft") else { return };
    let (mut without_blend, mut out_of_phase) = (0, 0);
    for line in lines.iter().filter(|line| line["out"].get("error").is_none()) {
        let place = format!("{} <- {}", file(line, 1), file(line, 2));
        let [base, donor] = [1, 2].map(|n| subject(&data, file(line, n)));
        if line["args"].as_array().unwrap().iter().any(|arg| arg == "--at") {
            let parts = Action::of(&donor.movement, &ActionSettings::default()).parts();
            let placement = Placement::whole_at(0.5, &donor.movement);
            let settings = GraftSettings { seam_s: 0.0, ..Default::default() };
            let made = graft(&base, &donor, &parts, &placement, &settings).unwrap();
            let found = reasons(&base, &donor, &made.clip, false);
            assert!(found.contains(&"wrist_jerk".to_owned()), "{place}: {found:?}");
            without_blend += 1;
        } else {
            // Half a stride late: arms swing with the legs of their own side.
            let settings = GraftSettings::default();
            let placement = Placement::Correlated { alternate: 0 };
            let mut timing = placement.timing(&base.movement, &donor.movement, &settings.correlation).unwrap();
            let passes = Footwork::of(&donor.movement, &settings.correlation).passes;
            let step = (passes[passes.len() - 1].frame - passes[0].frame) / (passes.len() - 1) as f64;
            for frame in &mut timing.donor_frames {
                *frame -= step;
            }
            let made = graft_timed(&base, &donor, &Part::ARMS, &timing, &settings).unwrap();
            let found = reasons(&base, &donor, &made.clip, true);
            // The phase itself, or the lock where half of the clip is the base's.
            assert!(found.iter().any(|reason| reason.starts_with("arm_leg_")), "{place}: {found:?}");
            out_of_phase += 1;
        }
    }
    assert_eq!((without_blend, out_of_phase), (8, 18));
}

#[test]
fn an_acclaim_graft_keeps_all_other_numbers_and_says_how_far_its_joints_fall_short() {
    let Some(data) = captures() else { return };
    let [base, donor] = ["cmu/02/02_02.amc", "cmu/02/02_01.amc"].map(|file| subject(&data, file));
    let placement = Placement::Correlated { alternate: 0 };
    let made = graft(&base, &donor, &Part::ARMS, &placement, &GraftSettings::default()).unwrap();
    let skeleton = &base.clip.skeleton;
    let firsts = skeleton.first_channels();
    let grafted: Vec<usize> = Part::ARMS
        .iter()
        .flat_map(|&part| base.parts.joints(part))
        .flat_map(|&joint| firsts[joint]..firsts[joint] + skeleton.joints[joint].channels.len())
        .collect();
    let (width, [first, end]) = (skeleton.n_channels(), made.base_range);
    let mut changed = 0;
    for (n, (new, old)) in made.clip.channels.iter().zip(&base.clip.channels).enumerate() {
        let inside = (first..end).contains(&(n / width)) && grafted.contains(&(n % width));
        assert!(inside || new.to_bits() == old.to_bits(), "frame {} column {}", n / width, n % width);
        changed += usize::from(new != old);
    }
    assert!(changed > (end - first) * grafted.len() / 2, "{changed} numbers changed");
    let (_, roles) = tables().best(skeleton).map(|(name, roles)| (name.to_owned(), roles)).unwrap();
    let movement = Movement::of_clip(&made.clip, &roles).unwrap();
    // Where the donor has full weight its rotations are shown: same body, whole donor frames or nearly.
    let provenance = &made.provenance;
    let mut worst = 0.0_f64;
    for frame in (first..end).filter(|&frame| provenance.weights[frame] == 1.0) {
        let at = provenance.donor_frames[frame];
        for &joint in base.parts.joints(Part::ArmLeft) {
            let [a, b] = [at.floor(), at.ceil()].map(|at| donor.movement.rotations.local_at(at as usize, joint));
            let wanted = slerp(a, b, at.fract());
            worst = worst.max(rotation_vector(wanted.conjugate() * movement.rotations.local_at(frame, joint)).length());
        }
    }
    let misfit = made.misfit.unwrap();
    eprintln!(
        "acclaim graft: misfit {:.2e} rad at {} in frame {}, at full weight {worst:.1e} rad; seams {:?}",
        misfit.angle_rad, skeleton.joints[misfit.joint].name, misfit.frame, made.seams
    );
    assert!(skeleton.joints[misfit.joint].channels.len() < 3);
    assert!(misfit.angle_rad < 0.02 && worst <= misfit.angle_rad + 1e-6, "{misfit:?} {worst}");
}
