//! The body in metres: postures, where they put every joint, and the centre of mass.

use super::skeleton::{ASF_UNIT_M, Subject, acclaim_skeleton, joint};
use crate::motion::kinematics::rest_rotation;
use glam::{DMat3, DQuat, DVec3};

/// A skeleton in metres, with the figures that planning and posing need.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) joints: Vec<BodyJoint>,
    pub(crate) thigh_m: f64,
    pub(crate) shank_m: f64,
    pub(crate) sole: Sole,
    /// Middle of the hip joints from the root, at rest.
    pub(crate) mid_hips_m: DVec3,
}

/// A joint in metres.
#[derive(Clone, Debug)]
pub(crate) struct BodyJoint {
    pub(crate) parent: Option<usize>,
    /// From the parent's joint, at rest.
    pub(crate) offset_m: DVec3,
    /// To the far end of the bone, at rest.
    pub(crate) bone_m: DVec3,
    /// Rest axis of the bone: `C` of `C M C^-1`.
    pub(crate) rest: DQuat,
}

/// The foot seen from its side, flat on the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sole {
    /// Height of the ankle above the ground.
    pub(crate) ankle_m: f64,
    /// Height of the ball joint above the ground.
    pub(crate) ball_m: f64,
    /// From the ankle forward to the ball.
    pub(crate) length_m: f64,
    /// From the ankle back to the heel.
    pub(crate) heel_m: f64,
    /// From the ball forward to the tip of the toes.
    pub(crate) toes_m: f64,
    /// How far the bone from ankle to ball points down.
    pub(crate) slope_rad: f64,
}

/// Where the root is and how every joint turns against its parent.
#[derive(Clone, Debug)]
pub(crate) struct Posture {
    pub(crate) root_m: DVec3,
    pub(crate) local: [DQuat; joint::COUNT],
}

/// Every joint in the world.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub(crate) position_m: [DVec3; joint::COUNT],
    pub(crate) rotation: [DQuat; joint::COUNT],
}

/// Share of the body's mass that a bone carries, and where along the bone: trunk and pelvis in four parts, head with
/// neck, limbs (after the usual anthropometric tables, rounded).
const MASSES: [(usize, f64, f64); 17] = [
    (joint::ROOT, 0.142, 0.0),
    (joint::LOWER_BACK, 0.139, 0.5),
    (joint::UPPER_BACK, 0.100, 0.5),
    (joint::THORAX, 0.116, 0.5),
    (joint::UPPER_NECK, 0.081, 1.0),
    (joint::FEMUR[0], 0.100, 0.43),
    (joint::FEMUR[1], 0.100, 0.43),
    (joint::TIBIA[0], 0.0465, 0.43),
    (joint::TIBIA[1], 0.0465, 0.43),
    (joint::FOOT[0], 0.0145, 0.5),
    (joint::FOOT[1], 0.0145, 0.5),
    (joint::HUMERUS[0], 0.028, 0.44),
    (joint::HUMERUS[1], 0.028, 0.44),
    (joint::RADIUS[0], 0.016, 0.43),
    (joint::RADIUS[1], 0.016, 0.43),
    (joint::HAND[0], 0.006, 0.5),
    (joint::HAND[1], 0.006, 0.5),
];

impl Body {
    pub(crate) fn new(subject: &Subject) -> Body {
        let skeleton = acclaim_skeleton(subject);
        let joints: Vec<BodyJoint> = skeleton
            .joints
            .iter()
            .map(|joint| BodyJoint {
                parent: joint.parent,
                offset_m: joint.offset * ASF_UNIT_M,
                bone_m: joint.bone.map_or(DVec3::ZERO, |bone| bone.direction * bone.length * ASF_UNIT_M),
                rest: joint.axis.map_or(DQuat::IDENTITY, rest_rotation),
            })
            .collect();
        let foot_m = joints[joint::FOOT[0]].bone_m;
        // At rest the leg is spread sideways; in the leg's own frame the bone points forward and down.
        let upright = joints[joint::TIBIA[0]].rest.conjugate() * foot_m;
        let ball_m = 0.05 * subject.height_m / 1.75;
        Body {
            thigh_m: joints[joint::FEMUR[0]].bone_m.length(),
            shank_m: joints[joint::TIBIA[0]].bone_m.length(),
            sole: Sole {
                ankle_m: ball_m - upright.y,
                ball_m,
                length_m: upright.z,
                heel_m: ball_m,
                toes_m: joints[joint::TOES[0]].bone_m.length(),
                slope_rad: libm::atan2(-upright.y, upright.z),
            },
            mid_hips_m: 0.5 * (joints[joint::FEMUR[0]].offset_m + joints[joint::FEMUR[1]].offset_m),
            joints,
        }
    }

    /// From hip joint to ankle, straight.
    pub(crate) fn reach_m(&self) -> f64 {
        self.thigh_m + self.shank_m
    }

    /// From hip joint to the ground, standing.
    pub(crate) fn leg_m(&self) -> f64 {
        self.reach_m() + self.sole.ankle_m
    }

    /// Forward kinematics.
    pub(crate) fn place(&self, posture: &Posture) -> Placed {
        let mut placed =
            Placed { position_m: [posture.root_m; joint::COUNT], rotation: [DQuat::IDENTITY; joint::COUNT] };
        for (index, joint) in self.joints.iter().enumerate() {
            match joint.parent {
                None => placed.rotation[index] = posture.local[index],
                Some(parent) => {
                    placed.rotation[index] = placed.rotation[parent] * posture.local[index];
                    placed.position_m[index] = placed.position_m[parent] + placed.rotation[parent] * joint.offset_m;
                }
            }
        }
        placed
    }

    /// Centre of mass.
    pub(crate) fn mass_center_m(&self, placed: &Placed) -> DVec3 {
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (joint, mass, along) in MASSES {
            let at = placed.position_m[joint] + placed.rotation[joint] * (self.joints[joint].bone_m * along);
            sum += at * mass;
            total += mass;
        }
        sum / total
    }
}

/// The rotation that takes one pair of perpendicular unit vectors to another.
pub(crate) fn rotation_between(from: [DVec3; 2], to: [DVec3; 2]) -> DQuat {
    let frame = |[a, b]: [DVec3; 2]| {
        let a = a.normalize();
        let c = a.cross(b).normalize();
        DMat3::from_cols(a, c.cross(a), c)
    };
    DQuat::from_mat3(&(frame(to) * frame(from).transpose())).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_take_pairs_to_pairs() {
        let turn = rotation_between([DVec3::X, DVec3::Y], [DVec3::Z, DVec3::X]);
        assert!((turn * DVec3::X - DVec3::Z).length() < 1e-12);
        assert!((turn * DVec3::Y - DVec3::X).length() < 1e-12);
    }

    #[test]
    fn a_body_of_1_75_m_has_the_proportions_of_one() {
        let body = Body::new(&Subject { name: "s".to_owned(), height_m: 1.75 });
        assert!((0.88..0.95).contains(&body.leg_m()), "{}", body.leg_m());
        assert!((0.06..0.10).contains(&body.sole.ankle_m), "{}", body.sole.ankle_m);
        assert!((body.sole.slope_rad - 0.263).abs() < 0.01, "{}", body.sole.slope_rad);
        let rest = Posture { root_m: DVec3::Y, local: [DQuat::IDENTITY; joint::COUNT] };
        let placed = body.place(&rest);
        let center = body.mass_center_m(&placed);
        assert!(center.x.abs() < 1e-9 && (0.95..1.05).contains(&center.y), "{center}");
        assert!((MASSES.iter().map(|(_, mass, _)| mass).sum::<f64>() - 1.0).abs() < 1e-9);
    }
}
