//! `annotations.diagnostics`: what the detector of contacts weighed, frame by frame, in the table that has its labels.

use crate::running::{Reference, digests, run, same};
use motionmill::annotate::FrameLabels;
use motionmill::corpus::{Catalog, Store};
use std::path::Path;

const ASKED: [&str; 2] = ["--set", "annotations.diagnostics=true"];

fn labels(corpus: &Path) -> Vec<FrameLabels> {
    let store = Store::new(corpus);
    let catalog = Catalog::open(&store).unwrap();
    catalog
        .shards()
        .flat_map(|shard| shard.all_labels().unwrap().map(Result::unwrap).map(|(_, labels)| labels).collect::<Vec<_>>())
        .collect()
}

#[test]
fn diagnostics_are_columns_that_agree_with_the_labels_for_any_number_of_workers() {
    let reference = Reference::get();
    let inputs = reference.inputs();
    let inputs: Vec<&Path> = inputs.iter().map(|input| input.as_path()).collect();
    let folder = tempfile::tempdir().unwrap();
    let [one, three, plain] = ["one", "three", "plain"].map(|name| folder.path().join(name));
    run("annotate", &inputs, &one, &[&ASKED[..], &["-w", "1"]].concat()).with(0);
    run("annotate", &inputs, &three, &[&ASKED[..], &["-w", "3"]].concat()).with(0);
    same(&digests(&one), &digests(&three), "3 workers");
    run("annotate", &inputs, &plain, &["-w", "2"]).with(0);
    let [with, without] = [labels(&one), labels(&plain)];
    assert!(with.len() > 5 && without.iter().all(|labels| labels.diagnostics.is_none()));
    let [mut planted, mut agree] = [0, 0];
    for (labels, plain) in with.iter().zip(&without) {
        let shown = labels.diagnostics.as_ref().unwrap();
        assert_eq!(labels.stance, plain.stance, "labels are the same with and without");
        let n_frames = labels.stance[0].len();
        assert!(shown.force.len() == n_frames && shown.force.iter().flatten().count() > n_frames / 2);
        for foot in 0..2 {
            assert!(shown.ground[foot].iter().flatten().all(|height_m| (-0.1..0.3).contains(height_m)));
            for (odds, stance) in shown.log_odds[foot].iter().zip(&labels.stance[foot]) {
                planted += 1;
                agree += usize::from((odds.unwrap() > 0.0) == stance.unwrap());
            }
        }
    }
    // Decoding settles the doubtful ones.
    assert!(agree as f64 > 0.97 * planted as f64, "{agree} of {planted}");
}

#[test]
fn asking_for_diagnostics_makes_the_labels_anew_and_nothing_else() {
    let reference = Reference::get();
    let inputs = reference.inputs();
    let inputs: Vec<&Path> = inputs.iter().map(|input| input.as_path()).collect();
    let folder = tempfile::tempdir().unwrap();
    let [grown, fresh] = ["grown", "fresh"].map(|name| folder.path().join(name));
    run("annotate", &inputs, &grown, &["-w", "2"]).with(0);
    let again = run("annotate", &inputs, &grown, &[&ASKED[..], &["-w", "2"]].concat()).with(0);
    assert_eq!(again.parsed(), 0);
    run("annotate", &inputs, &fresh, &[&ASKED[..], &["-w", "2"]].concat()).with(0);
    same(&digests(&fresh), &digests(&grown), "made anew");
}
