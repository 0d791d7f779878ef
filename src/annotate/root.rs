//! Where the hips are, where the body faces, and how fast both change.

use super::baseline::Baseline;
use crate::motion::{Poses, Role, RoleMap, rotation};
use core::f64::consts::TAU;
use glam::DVec3;

/// A hip line whose horizontal part is a smaller share of it than this says nothing about the heading.
const LEVEL_SHARE: f64 = 0.2;

/// The root's motion, one entry a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RootTrack {
    /// World position of the hips (of the hierarchy's root where the hips are unknown), metres.
    pub position: Vec<DVec3>,
    /// Unit vector in the ground plane that the body faces; +X in every frame where the heading is unknown.
    pub forward: Vec<DVec3>,
    /// Radians, 0 = +X, counter-clockwise seen from above, unwrapped in time. None: no thighs, or a hip line that
    /// is never level.
    pub heading_rad: Option<Vec<f64>>,
    /// Horizontal speed, m/s, over 1/30 s on either side.
    pub speed_mps: Vec<f64>,
    /// Change of heading, rad/s, over 1/30 s on either side. None with the heading.
    pub turn_rate_radps: Option<Vec<f64>>,
}

/// The root's motion (T 4.2.1; DESIGN 3).
///
/// The body faces along the horizontal normal of the hip line, `(left hip - right hip) x up`. Where that line is
/// near vertical (somersaults, lying on a side) the heading before is carried on; frames before the first
/// level one take that one's. Forward `(x, 0, z)` has heading `atan2(-z, x)`.
pub fn root_track(poses: &Poses, roles: &RoleMap, rate_hz: f64) -> RootTrack {
    let n_frames = poses.n_frames;
    let hips = roles.get(Role::Hips).unwrap_or(0);
    let position = if poses.n_points == 0 { vec![DVec3::ZERO; n_frames] } else { poses.path(hips) };
    let baseline = Baseline::new(rate_hz);
    let speed_mps = (0..n_frames)
        .map(|frame| baseline.velocity(&position, frame))
        .map(|velocity| (velocity.x * velocity.x + velocity.z * velocity.z).sqrt())
        .collect();
    let forward = facing(poses, roles);
    let heading_rad = forward.as_ref().map(|forward| unwrapped_headings(forward));
    let turn_rate_radps =
        heading_rad.as_ref().map(|heading| (0..n_frames).map(|frame| baseline.velocity(heading, frame)).collect());
    let forward = forward.unwrap_or_else(|| vec![DVec3::X; n_frames]);
    RootTrack { position, forward, heading_rad, speed_mps, turn_rate_radps }
}

/// The forward vector of every frame. None where no frame has one.
fn facing(poses: &Poses, roles: &RoleMap) -> Option<Vec<DVec3>> {
    let (left, right) = (roles.get(Role::ThighLeft)?, roles.get(Role::ThighRight)?);
    let level = |frame: usize| {
        let line = poses.at(frame, left) - poses.at(frame, right);
        let horizontal = (line.x * line.x + line.z * line.z).sqrt();
        (horizontal > LEVEL_SHARE * line.length()).then(|| DVec3::new(-line.z, 0.0, line.x) / horizontal)
    };
    let mut carried = (0..poses.n_frames).find_map(level)?;
    Some(
        (0..poses.n_frames)
            .map(|frame| {
                carried = level(frame).unwrap_or(carried);
                carried
            })
            .collect(),
    )
}

fn unwrapped_headings(forward: &[DVec3]) -> Vec<f64> {
    let mut previous = 0.0;
    forward
        .iter()
        .enumerate()
        .map(|(frame, forward)| {
            let angle = libm::atan2(-forward.z, forward.x);
            previous = if frame == 0 { angle } else { rotation::unwrap(angle, previous, TAU) };
            previous
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};

    /// Hips at 1 m that face `heading(frame)`, with the hip line tilted by `tilt(frame)`.
    fn body(
        n_frames: usize,
        heading: impl Fn(usize) -> f64,
        tilt: impl Fn(usize) -> f64,
        position: impl Fn(usize) -> DVec3,
    ) -> (Poses, RoleMap) {
        let mut roles = RoleMap::default();
        for (point, role) in [Role::Hips, Role::ThighLeft, Role::ThighRight].into_iter().enumerate() {
            roles.set(role, point);
        }
        let world = (0..n_frames)
            .flat_map(|frame| {
                let (sin, cos) = libm::sincos(heading(frame));
                let (up, level) = libm::sincos(tilt(frame));
                let left = DVec3::new(-sin * level, up, -cos * level) * 0.1;
                let hips = position(frame) + DVec3::Y;
                [hips, hips + left, hips - left]
            })
            .collect();
        (Poses { n_frames, n_points: 3, world }, roles)
    }

    #[test]
    fn a_left_turn_counts_up_and_past_the_full_circle() {
        let (poses, roles) = body(200, |frame| 0.5 + frame as f64 * 0.1, |_| 0.3, |_| DVec3::ZERO);
        let track = root_track(&poses, &roles, 60.0);
        let heading = track.heading_rad.unwrap();
        for (frame, angle) in heading.iter().enumerate() {
            assert!((angle - 0.5 - frame as f64 * 0.1).abs() < 1e-9, "frame {frame}");
        }
        assert!(track.turn_rate_radps.unwrap().iter().all(|rate| (rate - 6.0).abs() < 1e-6));
        assert!(track.speed_mps.iter().all(|&speed| speed == 0.0));
        // Heading pi/2 faces -Z: counter-clockwise seen from above.
        let (poses, roles) = body(1, |_| FRAC_PI_2, |_| 0.0, |_| DVec3::ZERO);
        assert!((root_track(&poses, &roles, 60.0).forward[0] - DVec3::NEG_Z).length() < 1e-12);
    }

    #[test]
    fn a_vertical_hip_line_keeps_the_heading_before() {
        let tilt = |frame: usize| if frame < 5 || (20..30).contains(&frame) { 1.5 } else { 0.0 };
        let (poses, roles) = body(40, |frame| if frame < 20 { 1.0 } else { 2.0 }, tilt, |_| DVec3::ZERO);
        let heading = root_track(&poses, &roles, 30.0).heading_rad.unwrap();
        for (frame, angle) in heading.iter().enumerate() {
            let wanted = if frame < 30 { 1.0 } else { 2.0 };
            assert!((angle - wanted).abs() < 1e-9, "frame {frame}: {angle}");
        }
    }

    #[test]
    fn speed_is_horizontal() {
        let (poses, roles) =
            body(60, |_| PI, |_| 0.0, |frame| DVec3::new(0.03, 0.5, 0.04) * (frame as f64 / 30.0) * 30.0);
        let track = root_track(&poses, &roles, 30.0);
        assert!(track.speed_mps.iter().all(|speed| (speed - 1.5).abs() < 1e-9));
        assert_eq!(track.position[0], DVec3::Y);
    }

    #[test]
    fn without_hips_or_thighs_the_root_is_the_first_joint_and_faces_nowhere() {
        let (poses, _) = body(3, |_| 1.0, |_| 0.0, |_| DVec3::X);
        let track = root_track(&poses, &RoleMap::default(), 30.0);
        assert_eq!(track.position[2], DVec3::new(1.0, 1.0, 0.0));
        assert_eq!((track.heading_rad, track.turn_rate_radps), (None, None));
        assert_eq!(track.forward, [DVec3::X; 3]);
        let empty = Poses { n_frames: 2, n_points: 0, world: vec![] };
        assert_eq!(root_track(&empty, &RoleMap::default(), 30.0).position, [DVec3::ZERO; 2]);
    }
}
