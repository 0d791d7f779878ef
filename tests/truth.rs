//! Contacts and gaits against what is true of made people: labels from the footstep plan, never from poses.

use motionmill::annotate::{Gait, Settings, annotate};
use motionmill::motion::Format;
use motionmill::motion::kinematics::poses;
use motionmill::motion::role_assign::assign_roles;
use motionmill::procedural::{corpus, make};

/// Clips of the corpus that are compared: three rounds of its twenty kinds.
const CLIPS: usize = 60;

#[test]
fn plants_of_made_people_are_found_where_the_plan_put_them() {
    let names = motionmill::flow::settings::shipped_names();
    let [mut hits, mut spurious, mut missed] = [0_u64; 3];
    let [mut gait_right, mut gait_known] = [0_u64; 2];
    for spec in corpus(CLIPS, 1) {
        let made = make(&spec, Format::Amc).unwrap();
        let poses = poses(&made.clip);
        let (roles, ..) = assign_roles(&made.clip.skeleton, &names, None);
        let labels = annotate(&poses, &roles, made.clip.rate_hz, &Settings::default());
        for (found, truth) in labels.frames.stance.iter().zip([&made.truth.left_contact, &made.truth.right_contact]) {
            for (found, &truth) in found.iter().zip(truth) {
                match (found.unwrap(), truth) {
                    (true, true) => hits += 1,
                    (true, false) => spurious += 1,
                    (false, true) => missed += 1,
                    (false, false) => {}
                }
            }
        }
        for (found, truth) in labels.frames.gait.iter().zip(&made.truth.gait) {
            if *truth != Gait::Unknown {
                gait_known += 1;
                gait_right += u64::from(*found == Some(*truth));
            }
        }
    }
    let precision = hits as f64 / (hits + spurious) as f64;
    let recall = hits as f64 / (hits + missed) as f64;
    let gait = gait_right as f64 / gait_known as f64;
    println!("plants: precision {precision:.4}, recall {recall:.4}; gait frames right {gait:.4}");
    assert!(precision >= 0.97, "precision {precision}");
    assert!(recall >= 0.97, "recall {recall}");
    assert!(gait >= 0.95, "gait {gait}");
}
