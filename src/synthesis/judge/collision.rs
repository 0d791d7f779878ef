//! How deep a body runs into itself: capsules about bones (GRAFTS 5).

use super::super::subject::Movement;
use super::figures::body_scale;
use glam::DVec3;

const FOREARM_M: f64 = 0.035;
const THIGH_M: f64 = 0.07;
const SHANK_M: f64 = 0.045;
const BELLY_M: f64 = 0.115;
const BREAST_M: f64 = 0.105;
const HEAD_M: f64 = 0.09;
/// The skull, above the head's joint.
const SKULL_M: [f64; 2] = [0.04, 0.12];
const HAND_M: f64 = 0.10;
/// Share of forearm and thigh next to the trunk that is not tested.
const SKIPPED: f64 = 0.2;

/// A segment with a radius.
struct Capsule {
    ends: [DVec3; 2],
    radius_m: f64,
}

/// Deepest overlap over the clip of either forearm and hand with trunk, head and both thighs, of the forearms, and of the
/// shanks; metres, 0 where nothing touches. Radii scale with the leg.
///
/// Captured clips reach 8 cm, so the figure means something only beside the parents'.
pub fn self_collision(movement: &Movement) -> f64 {
    let scale = body_scale(movement);
    let marks = &movement.landmarks;
    let mut deepest = 0.0_f64;
    for frame in 0..movement.n_frames() {
        let at = |point: usize| movement.poses.at(frame, point);
        let capsule = |a: DVec3, b: DVec3, radius_m: f64| Capsule { ends: [a, b], radius_m: radius_m * scale };
        let mut body = match marks.spine {
            Some(spine) => {
                vec![capsule(at(marks.hips), at(spine), BELLY_M), capsule(at(spine), at(marks.chest), BELLY_M)]
            }
            None => vec![capsule(at(marks.hips), at(marks.chest), BELLY_M)],
        };
        if let Some(neck) = marks.neck {
            body.push(capsule(at(marks.chest), at(neck), BREAST_M));
        }
        if let Some(head) = marks.head {
            let [low, high] = SKULL_M.map(|height| at(head) + DVec3::Y * (height * scale));
            body.push(capsule(low, high, HEAD_M));
        }
        for leg in &marks.legs {
            body.push(capsule(at(leg.thigh).lerp(at(leg.knee), SKIPPED), at(leg.knee), THIGH_M));
        }
        let mut forearms = Vec::with_capacity(2);
        for arm in &marks.arms {
            let (elbow, wrist) = (at(arm.elbow), at(arm.wrist));
            let upper = elbow.lerp(wrist, SKIPPED);
            let tip = wrist + (wrist - elbow).normalize_or_zero() * (HAND_M * scale);
            let with_hand = capsule(upper, tip, FOREARM_M);
            deepest = body.iter().map(|part| overlap(&with_hand, part)).fold(deepest, f64::max);
            forearms.push(capsule(upper, wrist, FOREARM_M));
        }
        let shanks = marks.legs.map(|leg| capsule(at(leg.knee), at(leg.ankle), SHANK_M));
        deepest = deepest.max(overlap(&forearms[0], &forearms[1])).max(overlap(&shanks[0], &shanks[1]));
    }
    deepest
}

fn overlap(a: &Capsule, b: &Capsule) -> f64 {
    a.radius_m + b.radius_m - segment_distance(a.ends, b.ends)
}

/// The least distance of two segments: the nearest points of their lines, clamped, one after the other.
fn segment_distance(a: [DVec3; 2], b: [DVec3; 2]) -> f64 {
    const PARALLEL: f64 = 1e-9;
    let (along_a, along_b, between) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, ab, bb) = (along_a.dot(along_a), along_a.dot(along_b), along_b.dot(along_b));
    let (wa, wb) = (along_a.dot(between), along_b.dot(between));
    let determinant = aa * bb - ab * ab;
    let free = if determinant > PARALLEL { (ab * wb - bb * wa) / determinant } else { 0.0 };
    let on_b = ((ab * free.clamp(0.0, 1.0) + wb) / bb.max(PARALLEL)).clamp(0.0, 1.0);
    let on_a = ((ab * on_b - wa) / aa.max(PARALLEL)).clamp(0.0, 1.0);
    (between + along_a * on_a - along_b * on_b).length()
}

#[cfg(test)]
mod tests {
    use super::super::super::walker::{mover, walker};
    use super::*;
    use crate::motion::Role;

    #[test]
    fn segments_are_as_far_apart_as_a_grid_says() {
        let corners = |k: u32| {
            let part = |n: u32| f64::from((k * 37 + n * 101) % 23) / 11.0 - 1.0;
            [[0, 1, 2], [3, 4, 5]].map(|three| DVec3::from_array(three.map(part)))
        };
        for k in 0..40 {
            let (a, b) = (corners(k), corners(k + 57));
            let steps = || (0..=200).map(|n| f64::from(n) / 200.0);
            let grid = steps()
                .flat_map(|s| steps().map(move |t| a[0].lerp(a[1], s).distance(b[0].lerp(b[1], t))))
                .fold(f64::INFINITY, f64::min);
            let found = segment_distance(a, b);
            assert!(found <= grid + 1e-12 && found > grid - 0.02, "{k}: {found} {grid}");
        }
    }

    #[test]
    fn an_arm_through_the_belly_is_seen() {
        let free = self_collision(&walker(30.0, 31, 1.0).movement);
        assert!(free < 0.005, "the hands brush the thighs: {free}");
        let through = mover(30.0, 31, 1.0, 1.2, &|_, _| vec![(Role::ElbowLeft, [-90.0, 0.0, 0.0])]);
        let depth = self_collision(&through.movement);
        assert!((0.05..0.20).contains(&depth), "{depth}");
    }
}
