//! How many grafts of random pairs of captures the judge lets through, by rule, beside the study's shares (GRAFTS 5).

use crate::shared_data;
use motionmill::annotate::{Gait, Settings, annotate};
use motionmill::formats::{ReadOptions, read_bvh};
use motionmill::motion::UpAxis;
use motionmill::motion::kinematics::poses;
use motionmill::motion::role_assign::assign_roles;
use motionmill::synthesis::judge::{Figures, GateSettings, RangeCounts, Reference, ReferenceCounts, judge};
use motionmill::synthesis::making::make;
use motionmill::synthesis::{Action, ActionSettings, GraftSettings, Movement, Part, Recipe, Rule, Subject};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Pairs a rule; a share of so many is good to about ten points.
const PAIRS: usize = 24;

#[test]
fn grafts_of_random_captures_pass_about_as_often_as_in_the_study() {
    let Some(data) = shared_data::captures() else { return };
    let names = motionmill::flow::settings::shipped_names();
    let mut files: Vec<_> =
        std::fs::read_dir(data.join("bandai-namco/dataset-2")).unwrap().map(|file| file.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "bvh"));
    files.sort();
    let mut by_gait = BTreeMap::<Gait, Vec<Subject>>::new();
    let mut roles_of = None;
    let mut counts = ReferenceCounts::default();
    // Every so-manieth clip of each kind, so that all styles are there; joint ranges are those of all.
    for (n, file) in files.iter().enumerate() {
        let motion = read_bvh(&std::fs::read(file).unwrap(), &ReadOptions::default()).unwrap().value;
        let clip = motion.into_clip(30.0, 0.01, UpAxis::Y);
        let (roles, ..) = assign_roles(&clip.skeleton, &names, None);
        counts.add(&clip.skeleton.layout_id(), RangeCounts::of(&Movement::of_clip(&clip, &roles).unwrap()));
        if n % 13 > 0 {
            continue;
        }
        let labels = annotate(&poses(&clip), &roles, clip.rate_hz, &Settings::default()).clip;
        if labels.gait_confidence.is_some_and(|confidence| confidence >= 0.8) {
            let subject = Subject::new(Arc::new(clip), &roles).unwrap();
            by_gait.entry(labels.gait_class.unwrap()).or_default().push(subject);
        }
        roles_of = Some(roles);
    }
    let roles = roles_of.unwrap();
    let mut reference = Reference::default();
    reference.enter(&counts, 0.0);
    let (action, graft, gates) = (ActionSettings::default(), GraftSettings::default(), GateSettings::default());
    for rule in Rule::ALL {
        let (Some(bases), Some(donors)) = (by_gait.get(&rule.base()), by_gait.get(&rule.donor())) else { continue };
        let (mut made, mut passed, mut tried) = (0, 0, 0);
        let mut reasons = BTreeMap::<String, usize>::new();
        // Strides that share no factor with the lists walk over all pairs without order.
        while made < PAIRS && tried < 40 * PAIRS {
            let (base, donor) = (
                &bases[(tried * 7 + 3) % bases.len()],
                &donors[(tried * 11 + 5 + tried / donors.len()) % donors.len()],
            );
            tried += 1;
            let parts =
                if rule.is_cyclic() { Part::ARMS.to_vec() } else { Action::of(&donor.movement, &action).parts() };
            let recipe = Recipe {
                recipe: String::new(),
                kind: "graft".into(),
                base: "base".into(),
                donor: Some("donor".into()),
                chains: parts.iter().map(|part| part.name().to_owned()).collect(),
                alternate: None,
                options: "{}".into(),
                seed: 0,
                rule: rule.name().into(),
                cell: None,
            };
            if Arc::ptr_eq(&base.clip, &donor.clip) {
                continue;
            }
            let Ok(grafted) = make(&recipe, base, donor, &action, &graft) else { continue };
            made += 1;
            let own = Figures::of(&Movement::of_clip(&grafted.clip, &roles).unwrap(), &reference);
            let parents = [base, donor].map(|parent| Figures::of(&parent.movement, &reference));
            let verdict = judge(&own, &parents[0], &parents[1], rule.is_cyclic(), &gates);
            passed += usize::from(verdict.accepted);
            verdict.reasons.into_iter().for_each(|reason| *reasons.entry(reason).or_default() += 1);
        }
        let share = passed as f64 / made.max(1) as f64;
        let study = rule.expected_pass_share();
        println!("{:<14} {passed:>3} of {made:>3} = {share:.2}, study {study:?}, refused by {reasons:?}", rule.name());
        if let Some(study) = study.filter(|_| made == PAIRS) {
            assert!(share > study - 0.25, "{}: {share} of the study's {study}: {reasons:?}", rule.name());
        }
    }
}
