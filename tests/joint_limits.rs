//! What joint ranges say of real captures: little of those that are not in the reference, and much of elbows that bend the
//! wrong way (GRAFTS 5).

use crate::captures::bvh;
use crate::shared_data::captures;
use glam::{DQuat, DVec3};
use motionmill::flow::settings::shipped_names;
use motionmill::motion::role_assign::assign_roles;
use motionmill::motion::rotation::euler_near;
use motionmill::motion::{Axis, Clip, RoleMap, UpAxis};
use motionmill::synthesis::Movement;
use motionmill::synthesis::judge::{GateSettings, RangeCounts, Reference, ReferenceCounts};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// A tenth of the clips is judged by the other nine tenths.
const FOLDS: usize = 10;

fn clip_of(file: &Path) -> (Clip, RoleMap) {
    let clip = bvh(file).into_clip(30.0, 0.01, UpAxis::Y);
    let (roles, ..) = assign_roles(&clip.skeleton, &shipped_names(), None);
    (clip, roles)
}

fn movement_of(file: &Path) -> Movement {
    let (clip, roles) = clip_of(file);
    Movement::of_clip(&clip, &roles).unwrap()
}

/// The clip with its left elbow turned the wrong way about its own hinge: by so many degrees from where it is, or to
/// so many beyond straight.
fn with_bent_elbow(file: &Path, by_deg: f64, from_straight: bool) -> Movement {
    let (mut clip, roles) = clip_of(file);
    let movement = Movement::of_clip(&clip, &roles).unwrap();
    let arm = movement.landmarks.arms[0];
    let bones = |frame: usize| {
        let bone = |from, to| movement.poses.at(frame, to) - movement.poses.at(frame, from);
        let to_parent = movement.rotations.world_at(frame, arm.shoulder).conjugate();
        [bone(arm.shoulder, arm.elbow), bone(arm.elbow, arm.wrist)].map(|bone| (to_parent * bone).normalize())
    };
    let crossed = |frame: usize| bones(frame)[0].cross(bones(frame)[1]);
    let hinge = (0..clip.n_frames).map(crossed).sum::<DVec3>().normalize();
    let skeleton = clip.skeleton.clone();
    let (first, width) = (skeleton.first_channels()[arm.elbow], skeleton.n_channels());
    let order = [Axis::Z, Axis::X, Axis::Y];
    assert_eq!(skeleton.joints[arm.elbow].channels[3..].iter().map(|c| c.axis).collect::<Vec<_>>(), order);
    let mut previous = [0.0; 3];
    for frame in 0..clip.n_frames {
        let [upper, fore] = bones(frame);
        let bend = if from_straight { crossed(frame).dot(hinge).atan2(upper.dot(fore)) } else { 0.0 };
        let turned = DQuat::from_axis_angle(hinge, -bend - by_deg.to_radians());
        previous = euler_near(turned * movement.rotations.local_at(frame, arm.elbow), order, previous);
        for (channel, angle) in clip.channels[frame * width + first + 3..][..3].iter_mut().zip(previous) {
            *channel = angle.to_degrees() as f32;
        }
    }
    Movement::of_clip(&clip, &roles).unwrap()
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

#[test]
fn captures_keep_within_the_ranges_of_other_captures_and_broken_elbows_do_not() {
    let Some(data) = captures() else { return };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(data.join("bandai-namco/dataset-2")).unwrap().map(|file| file.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "bvh"));
    files.sort();
    let counts: Vec<(String, RangeCounts)> = files
        .par_iter()
        .map(|file| {
            let movement = movement_of(file);
            (movement.skeleton.layout_id(), RangeCounts::of(&movement))
        })
        .collect();
    let reference_of = |clips: &mut dyn Iterator<Item = usize>| {
        let mut sum = ReferenceCounts::default();
        clips.for_each(|n| sum.add(&counts[n].0, counts[n].1.clone()));
        let mut reference = Reference::default();
        reference.enter(&sum, 0.0);
        reference
    };
    let reference = reference_of(&mut (0..files.len()));
    let gate = GateSettings::default().max_limit_excess_rad;
    let excess = |reference: &Reference, movement: &Movement| reference.limit_excess(movement).unwrap();

    // Captures by a reference that lacks them, beside two pretend parents of the same content and style.
    let group = |n: usize| files[n].file_stem().unwrap().to_str().unwrap().rsplit_once('_').unwrap().0.to_owned();
    let judged = |fold: usize| (fold..files.len() - 2).step_by(3 * FOLDS).filter(|&n| group(n) == group(n + 2));
    let of_fold = |fold: usize| {
        let others = reference_of(&mut (0..files.len()).filter(|n| n % FOLDS != fold));
        let own = judged(fold).map(|n| {
            let [own, one, two] = [n, n + 1, n + 2].map(|n| excess(&others, &movement_of(&files[n])));
            (own, own - one.max(two))
        });
        own.collect::<Vec<_>>()
    };
    let held_out: Vec<(f64, f64)> = (0..FOLDS).into_par_iter().flat_map_iter(of_fold).collect();
    let own = sorted(held_out.iter().map(|pair| pair.0).collect());
    let over_parents = sorted(held_out.iter().map(|pair| pair.1).collect());
    let inside: Vec<f64> =
        (0..files.len()).into_par_iter().step_by(7).map(|n| excess(&reference, &movement_of(&files[n]))).collect();
    let inside = sorted(inside);
    for (name, values) in
        [("in the reference", &inside), ("not in it", &own), ("not in it, over two parents", &over_parents)]
    {
        let [half, most, nearly_all] = [0.5, 0.9, 0.99].map(|share| quantile(values, share));
        let refused = values.iter().filter(|&&value| value > gate).count();
        println!(
            "{} captures, {name}: {half:.3} {most:.3} {nearly_all:.3} rad (50, 90, 99 %), {refused} > gate",
            values.len()
        );
    }

    let passing = over_parents.iter().filter(|&&value| value <= gate).count();
    assert!(passing as f64 >= 0.94 * over_parents.len() as f64, "{passing} of {}", over_parents.len());

    // Broken elbows, with their own clean clip for a parent.
    let broken: Vec<usize> = (0..files.len()).step_by(31).collect();
    for (what, by_deg, from_straight, least) in
        [("40 degrees beyond straight", 40.0, true, 1.0), ("40 degrees from where it is", 40.0, false, 0.8)]
    {
        let found: Vec<(f64, f64)> = broken
            .par_iter()
            .map(|&n| {
                let clean = excess(&reference, &movement_of(&files[n]));
                let bent = excess(&reference, &with_bent_elbow(&files[n], by_deg, from_straight));
                (bent, bent - clean)
            })
            .collect();
        let refused = found.iter().filter(|pair| pair.1 > gate).count();
        let above = |bent: f64| {
            over_parents.iter().map(|&held| f64::from(held < bent) + 0.5 * f64::from(held == bent)).sum::<f64>()
        };
        let auc = found.iter().map(|pair| above(pair.1)).sum::<f64>() / (found.len() * over_parents.len()) as f64;
        let bent = sorted(found.iter().map(|pair| pair.0).collect());
        println!(
            "elbow {what}: {refused} of {} refused, AUC {auc:.3}, least {:.3}, median {:.3} rad",
            found.len(),
            bent[0],
            quantile(&bent, 0.5)
        );
        assert!(refused as f64 >= least * found.len() as f64, "{what}");
    }

    // How much of captures a reference takes: `judge.min_reference_s`.
    for n_clips in [16, 64, 128, 256, 1024] {
        let (mut refused, mut judged, mut seconds) = (0, 0, 0.0);
        for draw in 0..6 {
            let chosen: Vec<usize> = (0..n_clips).map(|k| (k * 733 + draw * 311) % files.len()).collect();
            seconds += chosen.iter().map(|&n| counts[n].1.captured_ms() as f64 / 1000.0 / 6.0).sum::<f64>();
            let sample = reference_of(&mut chosen.iter().copied());
            for n in (draw..files.len()).step_by(97).filter(|n| !chosen.contains(n)) {
                judged += 1;
                refused += usize::from(excess(&sample, &movement_of(&files[n])) > gate);
            }
        }
        println!("a reference of {n_clips} clips, {seconds:.0} s: {refused} of {judged} other captures above the gate");
        if seconds > GateSettings::default().min_reference_s {
            assert!(10 * refused < judged, "{refused} of {judged}");
        }
    }
}
