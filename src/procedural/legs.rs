//! Legs: two-link inverse kinematics to an ankle, and the foot that goes with it.

use super::body::{Body, rotation_between};
use super::feet::FootPose;
use super::path::smoothstep;
use super::skeleton::joint;
use crate::motion::Axis;
use crate::motion::rotation::about;
use glam::{DQuat, DVec3};

/// Local rotations of one leg.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegTurns {
    pub(crate) femur: DQuat,
    pub(crate) tibia: DQuat,
    pub(crate) foot: DQuat,
    pub(crate) toes: DQuat,
}

/// The plane triangle of thigh and shank: where the knee is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TwoLink {
    /// Unit vector from hip to knee.
    pub(crate) thigh: DVec3,
    /// Unit vector from knee to ankle (to where the ankle is, if the target is out of reach).
    pub(crate) shank: DVec3,
    /// Unit vector of the hinge: turning the shank about it by a positive angle bends the knee.
    pub(crate) hinge: DVec3,
    /// 0 = straight.
    pub(crate) flexion_rad: f64,
}

/// Of the straight leg: what an ankle beyond reach is brought back to.
const FULL_REACH: f64 = 0.9995;

/// Bends a leg of two bones so that it ends at `target_m` (from the hip), or as near as it reaches.
///
/// `left` is the direction that the hinge should point to; it must not be parallel to the target. The knee goes to the
/// side of `target x left` (forward for a leg that hangs down), whatever the target: so it never flips.
pub(crate) fn two_link(thigh_m: f64, shank_m: f64, target_m: DVec3, left: DVec3) -> TwoLink {
    let nearest = (thigh_m - shank_m).abs() + 1e-3 * (thigh_m + shank_m);
    let reach_m = target_m.length().clamp(nearest, FULL_REACH * (thigh_m + shank_m));
    let along = target_m.normalize_or(DVec3::NEG_Y);
    let hinge = (left - along * left.dot(along)).normalize_or(DVec3::X);
    let forward = along.cross(hinge);
    let cos = (thigh_m * thigh_m + reach_m * reach_m - shank_m * shank_m) / (2.0 * thigh_m * reach_m);
    let cos = cos.clamp(-1.0, 1.0);
    let thigh = along * cos + forward * libm::sqrt(1.0 - cos * cos);
    let shank = ((along * reach_m - thigh * thigh_m) / shank_m).normalize();
    let flexion_rad = libm::atan2(thigh.cross(shank).length(), thigh.dot(shank));
    TwoLink { thigh, shank, hinge, flexion_rad }
}

/// Solves the leg of one side (0 left, 1 right) for a foot, from the pelvis' rotation and the hip joint's position.
pub(crate) fn leg(body: &Body, side: usize, pelvis: DQuat, hip_m: DVec3, foot: &FootPose) -> LegTurns {
    let (femur, tibia) = (&body.joints[joint::FEMUR[side]], &body.joints[joint::TIBIA[side]]);
    let (sin, cos) = libm::sincos(foot.yaw_rad);
    let foot_left = DVec3::new(cos, 0.0, -sin);
    let bent = two_link(body.thigh_m, body.shank_m, foot.ankle_m - hip_m, pelvis * DVec3::X * 0.55 + foot_left * 0.45);
    let femur_world = rotation_between([femur.rest * DVec3::X, femur.bone_m.normalize()], [bent.hinge, bent.thigh]);
    let tibia_local = tibia.rest * about(Axis::X, bent.flexion_rad) * tibia.rest.conjugate();
    let tibia_world = femur_world * tibia_local;

    // A foot in the air hangs at a right angle to the shank.
    let heading = DVec3::new(sin, 0.0, cos);
    let hanging_rad = -libm::atan2(-bent.shank.dot(heading), -bent.shank.y) - 0.08;
    let pitch_rad = foot.pitch_rad + (hanging_rad - foot.pitch_rad) * foot.hanging;
    let (sin_down, cos_down) = libm::sincos(pitch_rad - body.sole.slope_rad);
    let toward_ball = heading * cos_down + DVec3::Y * sin_down;
    let foot_joint = &body.joints[joint::FOOT[side]];
    let rest = foot_joint.rest;
    // Two degrees of freedom, M = Rz(b) Rx(a): they reach any direction of the bone.
    let from = rest.conjugate() * foot_joint.bone_m.normalize();
    let to = rest.conjugate() * (tibia_world.conjugate() * toward_ball);
    let a = libm::asin((-to.z).clamp(-1.0, 1.0)) - libm::atan2(-from.z, -from.y);
    let b = libm::atan2(to.x, -to.y);
    let foot_local = rest * (about(Axis::Z, b) * about(Axis::X, a)) * rest.conjugate();

    let toes_rest = body.joints[joint::TOES[side]].rest;
    let toes = toes_rest * about(Axis::X, foot.toe_bend * (pitch_rad - foot.toes_rad).min(0.0)) * toes_rest.conjugate();
    LegTurns { femur: pelvis.conjugate() * femur_world, tibia: tibia_local, foot: foot_local, toes }
}

/// The largest height of a hip joint that leaves an ankle within `share` of the straight leg's length.
///
/// `None` if the ankle is too far away sideways for any height.
pub(crate) fn highest_hip_m(body: &Body, hip_m: DVec3, ankle_m: DVec3, share: f64) -> Option<f64> {
    let reach_m = share * body.reach_m();
    let aside = DVec3::new(hip_m.x - ankle_m.x, 0.0, hip_m.z - ankle_m.z).length_squared();
    let up = reach_m * reach_m - aside;
    (up > 0.0).then(|| ankle_m.y + libm::sqrt(up))
}

/// How much of a swing (0 to 1) the foot hangs from the shank instead of following its planned pitch.
pub(crate) fn hanging_share(swing: f64, rise: f64, fall: f64) -> f64 {
    smoothstep(swing / rise) * (1.0 - smoothstep((swing - fall) / (1.0 - fall)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::skeleton::Subject;

    #[test]
    fn the_ankle_gets_where_it_should_and_the_knee_bends_forward() {
        for (x, y, z) in [(0.0, -0.7, 0.0), (0.1, -0.6, 0.35), (-0.2, -0.5, -0.5), (0.0, -0.3, 0.1), (0.05, 0.1, 0.6)] {
            let target = DVec3::new(x, y, z);
            let bent = two_link(0.43, 0.41, target, DVec3::X);
            let ankle = bent.thigh * 0.43 + bent.shank * 0.41;
            assert!((ankle - target).length() < 1e-9, "{target} {ankle}");
            let knee_ahead = bent.thigh.dot(target.normalize().cross(bent.hinge));
            assert!(knee_ahead > 0.0 && bent.flexion_rad > 0.0, "{target}");
        }
    }

    #[test]
    fn out_of_reach_means_nearly_straight_towards_it() {
        let target = DVec3::new(0.0, -2.0, 1.0);
        let bent = two_link(0.43, 0.41, target, DVec3::X);
        assert!((bent.thigh * 0.43 + bent.shank * 0.41).normalize().dot(target.normalize()) > 1.0 - 1e-9);
        assert!(bent.flexion_rad < 0.1);
        let near = two_link(0.43, 0.41, DVec3::new(0.0, -1e-5, 0.0), DVec3::X);
        assert!(near.thigh.is_finite() && near.flexion_rad > 3.0);
    }

    #[test]
    fn the_whole_leg_meets_ankle_and_ball() {
        let body = Body::new(&Subject { name: "s".to_owned(), height_m: 1.75 });
        let hip = DVec3::new(0.09, 0.9, 0.0);
        for (side, pitch_rad, z) in [(0, 0.0, 0.0), (1, 0.3, 0.3), (0, -0.9, -0.3), (1, -0.4, 0.1)] {
            let foot = FootPose {
                ankle_m: DVec3::new([0.1, -0.1][side], 0.15, z),
                yaw_rad: 0.1,
                pitch_rad,
                hanging: 0.0,
                toes_rad: 0.0,
                toe_bend: 1.0,
            };
            let hip = if side == 0 { hip } else { DVec3::new(-hip.x, hip.y, hip.z) };
            let turns = leg(&body, side, DQuat::IDENTITY, hip, &foot);
            let knee = hip + turns.femur * body.joints[joint::FEMUR[side]].bone_m;
            let ankle = knee + turns.femur * turns.tibia * body.joints[joint::TIBIA[side]].bone_m;
            assert!((ankle - foot.ankle_m).length() < 1e-5, "{ankle}");
            let foot_world = turns.femur * turns.tibia * turns.foot;
            let ball = foot_world * body.joints[joint::FOOT[side]].bone_m;
            let down_rad = libm::atan2(-ball.y, libm::sqrt(ball.x * ball.x + ball.z * ball.z));
            assert!((down_rad - (body.sole.slope_rad - pitch_rad)).abs() < 1e-5, "{down_rad}");
            assert!((libm::atan2(ball.x, ball.z) - 0.1).abs() < 1e-5);
            let toe = foot_world * turns.toes * body.joints[joint::TOES[side]].bone_m;
            if pitch_rad < 0.0 {
                assert!(toe.y.abs() < 0.012, "planted toes lie flat: {}", toe.y);
            }
        }
    }
}
