//! The frame's features: what two frames are compared by (T 4.2.1).

use super::baseline::Baseline;
use super::labels::Features;
use super::root::{RootTrack, root_track};
use crate::motion::{Poses, Role, RoleMap};
use glam::DVec3;

/// The five end effectors, in the order of the `features` table's columns.
pub const EFFECTORS: [Role; 5] = [Role::Head, Role::WristLeft, Role::WristRight, Role::ToeLeft, Role::ToeRight];

/// Numbers of one frame: position, velocity and acceleration of the effectors.
pub const FEATURE_WIDTH: usize = EFFECTORS.len() * 9;

/// Features of every frame of a clip (T 4.2.1; DESIGN 3, neutral frame).
///
/// Positions: hips moved to 0 horizontally, heights kept, heading turned to +X. Velocities and accelerations: world
/// differences over 1/30 s on either side ([`Baseline`]), turned into the frame's heading; one-sided at the ends.
/// In clips too short for a difference (one frame; fewer than two whole steps) they are zero.
///
/// Where a foot has no toe its ankle stands in; `effectors` names the points used. Both lists are empty where the
/// hips or an effector are unknown.
pub fn features(poses: &Poses, roles: &RoleMap, rate_hz: f64) -> Features {
    features_about(&root_track(poses, roles, rate_hz), poses, roles, rate_hz)
}

/// [`features`] for a caller that has the clip's root track already.
pub fn features_about(root: &RootTrack, poses: &Poses, roles: &RoleMap, rate_hz: f64) -> Features {
    let Some(effectors) = known_effectors(roles) else { return Features::default() };
    let baseline = Baseline::new(rate_hz);
    let mut values = vec![0.0; poses.n_frames * FEATURE_WIDTH];
    for (slot, &(_, point)) in effectors.iter().enumerate() {
        let path = poses.path(point);
        for (frame, row) in values.chunks_exact_mut(FEATURE_WIDTH).enumerate() {
            let forward = root.forward[frame];
            let hips = root.position[frame];
            let position = path[frame] - DVec3::new(hips.x, 0.0, hips.z);
            let vectors = [position, baseline.velocity(&path, frame), baseline.acceleration(&path, frame)];
            for (place, vector) in row[slot * 9..slot * 9 + 9].chunks_exact_mut(3).zip(vectors) {
                // The new X is the part along `forward`, the new Z the part along `forward x up`.
                place[0] = (vector.x * forward.x + vector.z * forward.z) as f32;
                place[1] = vector.y as f32;
                place[2] = (vector.z * forward.x - vector.x * forward.z) as f32;
            }
        }
    }
    Features { effectors: effectors.map(|(role, _)| role).to_vec(), values }
}

/// Role and point of each effector.
fn known_effectors(roles: &RoleMap) -> Option<[(Role, usize); 5]> {
    roles.get(Role::Hips)?;
    let mut known = [(Role::Head, 0); 5];
    for (place, role) in known.iter_mut().zip(EFFECTORS) {
        let stand_in = match role {
            Role::ToeLeft => Role::AnkleLeft,
            Role::ToeRight => Role::AnkleRight,
            other => other,
        };
        *place = [role, stand_in].into_iter().find_map(|role| Some((role, roles.get(role)?)))?;
    }
    Some(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROLES: [Role; 8] = [
        Role::Hips,
        Role::ThighLeft,
        Role::ThighRight,
        Role::Head,
        Role::WristLeft,
        Role::WristRight,
        Role::ToeLeft,
        Role::AnkleRight,
    ];

    /// A body that slides at 1 m/s along its own forward axis; the left wrist falls freely in the body's frame.
    fn sliding(heading_rad: f64, from: DVec3, n_frames: usize, rate_hz: f64) -> (Poses, RoleMap) {
        let mut roles = RoleMap::default();
        for (point, role) in ROLES.into_iter().enumerate() {
            roles.set(role, point);
        }
        let (sin, cos) = libm::sincos(heading_rad);
        let world_from_body = |p: DVec3| DVec3::new(cos * p.x + sin * p.z, p.y, cos * p.z - sin * p.x);
        let world = (0..n_frames)
            .flat_map(|frame| {
                let t = frame as f64 / rate_hz;
                let body = [
                    DVec3::new(0.0, 0.9, 0.0),
                    DVec3::new(0.0, 0.9, -0.1),
                    DVec3::new(0.0, 0.9, 0.1),
                    DVec3::new(0.1, 1.6, 0.0),
                    DVec3::new(0.2, 1.0 - 4.905 * t * t, -0.4),
                    DVec3::new(0.2, 1.0, 0.4),
                    DVec3::new(0.15, 0.05, -0.1),
                    DVec3::new(0.0, 0.1, 0.1),
                ];
                body.map(|p| from + world_from_body(p + DVec3::X * t))
            })
            .collect();
        (Poses { n_frames, n_points: ROLES.len(), world }, roles)
    }

    #[test]
    fn place_and_heading_do_not_matter() {
        for (heading_rad, from) in [(0.0, DVec3::ZERO), (2.1, DVec3::new(4.0, 0.0, -7.0)), (-3.0, DVec3::X)] {
            let (poses, roles) = sliding(heading_rad, from, 20, 60.0);
            let features = features(&poses, &roles, 60.0);
            assert_eq!(features.values.len(), 20 * FEATURE_WIDTH);
            assert_eq!(features.effectors[3..], [Role::ToeLeft, Role::AnkleRight]);
            let row = &features.values[10 * FEATURE_WIDTH..11 * FEATURE_WIDTH];
            let t = 10.0 / 60.0;
            let wanted = [
                [0.1, 1.6, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.2, 1.0 - 4.905 * t * t, -0.4, 1.0, -9.81 * t, 0.0, 0.0, -9.81, 0.0],
                [0.2, 1.0, 0.4, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.15, 0.05, -0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 0.1, 0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            ];
            for (place, (got, wanted)) in row.iter().zip(wanted.iter().flatten()).enumerate() {
                assert!((f64::from(*got) - wanted).abs() < 2e-6, "heading {heading_rad}, number {place}: {got}");
            }
        }
    }

    #[test]
    fn heights_are_kept() {
        let (poses, roles) = sliding(0.0, DVec3::Y * 2.0, 3, 30.0);
        assert!((features(&poses, &roles, 30.0).values[1] - 3.6).abs() < 1e-6);
    }

    #[test]
    fn short_clips_have_zero_velocities_and_missing_effectors_no_features() {
        let (poses, mut roles) = sliding(1.0, DVec3::ZERO, 1, 30.0);
        let one = features(&poses, &roles, 30.0);
        assert!(one.values.chunks_exact(9).all(|effector| effector[3..].iter().all(|&value| value == 0.0)));
        let (none, _) = sliding(1.0, DVec3::ZERO, 0, 30.0);
        assert!(features(&none, &roles, 30.0).values.is_empty());
        roles = RoleMap::default();
        roles.set(Role::Hips, 0);
        assert_eq!(features(&poses, &roles, 30.0), Features::default());
    }
}
