//! Belts: a walker who stays in place while the feet are carried back (CONTACTS 8).
//!
//! On a treadmill a planted foot is never at rest, so that no detector of resting feet finds it. Its speed is the belt's,
//! though, stride after stride; taken off everything, the clip is one over ground. The same goes for captures whose
//! horizontal root motion was taken out ("in place").

use super::foot_paths::{FEET, FootPaths, joints_of};
use super::resting_height::half_sample_mode;
use crate::annotate::order_statistics::percentile;
use crate::motion::{Poses, Role, RoleMap};
use glam::DVec3;

/// A belt is faster than this, scaled m/s.
const SLOWEST_MPS: f64 = 0.3;
/// Feet this close above their lowest heights are on the belt, scaled metres; and the percentile that is lowest.
const LOW_M: f64 = 0.03;
const LOWEST_PERCENT: f64 = 5.0;
/// A foot is carried by the belt within this share of its velocity, scaled m/s at least.
const CARRIED_SHARE: f64 = 0.25;
const CARRIED_MPS: f64 = 0.15;
/// This share of the low samples of either foot must be carried, and no more than that be at rest.
const LEAST_CARRIED: f64 = 0.5;
const MOST_AT_REST: f64 = 0.1;
/// The hips stay in place: on the whole they move at less than this share of the belt's speed.
const IN_PLACE_SHARE: f64 = 0.25;
/// Less than this is too short to tell, seconds.
const SHORTEST_S: f64 = 1.0;

/// Velocity of the belt that the feet stand on, scaled m/s, horizontal. None: the ground is at rest.
pub fn belt_velocity(poses: &Poses, roles: &RoleMap, feet: &FootPaths) -> Option<DVec3> {
    let duration_s = feet.n_frames as f64 / feet.rate_hz;
    if duration_s < SHORTEST_S {
        return None;
    }
    let step = feet.frames_in(1.0 / 30.0);
    let baseline_s = step as f64 / feet.rate_hz;
    let velocities = FEET.map(|foot| {
        let [ankle, toe] = joints_of(foot);
        let path = feet.paths[toe].as_deref().or(feet.paths[ankle].as_deref()).unwrap_or(&[]);
        low_velocities(path, step, baseline_s)
    });
    let both = || velocities.iter().flatten();
    let mode = |axis: usize| {
        let mut values: Vec<f64> = both().map(|velocity| velocity[axis]).collect();
        values.sort_unstable_by(f64::total_cmp);
        half_sample_mode(&values)
    };
    let belt = DVec3::new(mode(0)?, 0.0, mode(2)?);
    let speed = belt.length();
    if speed < SLOWEST_MPS || !speed.is_finite() || drift_mps(poses, roles, feet, duration_s) > IN_PLACE_SHARE * speed {
        return None;
    }
    let near = (CARRIED_SHARE * speed).max(CARRIED_MPS);
    let share = |velocities: &[DVec3], of: DVec3| {
        let close = velocities.iter().filter(|velocity| (**velocity - of).length() < near).count();
        close as f64 / velocities.len().max(1) as f64
    };
    let carried = velocities.iter().all(|velocities| share(velocities, belt) >= LEAST_CARRIED);
    let at_rest = velocities.iter().any(|velocities| share(velocities, DVec3::ZERO) > MOST_AT_REST);
    (carried && !at_rest).then_some(belt)
}

/// The clip as it would be over ground at rest; `belt` in m/s of the poses' own size.
pub fn over_ground(poses: &Poses, belt: DVec3, rate_hz: f64) -> Poses {
    let mut moved = poses.clone();
    for (frame, points) in moved.world.chunks_mut(poses.n_points.max(1)).enumerate() {
        let carried = belt * (frame as f64 / rate_hz);
        points.iter_mut().for_each(|point| *point -= carried);
    }
    moved
}

/// Horizontal velocities of a path over a baseline, in frames in which it is low.
fn low_velocities(path: &[DVec3], step: usize, baseline_s: f64) -> Vec<DVec3> {
    let mut heights: Vec<f64> = path.iter().map(|place| place.y).collect();
    let Some(lowest) = percentile(&mut heights, LOWEST_PERCENT) else { return Vec::new() };
    let later = path.get(step..).unwrap_or(&[]);
    path.iter()
        .zip(later)
        .filter(|(from, to)| from.y.max(to.y) < lowest + LOW_M)
        .map(|(from, to)| (*to - *from) / baseline_s)
        .map(|velocity| DVec3::new(velocity.x, 0.0, velocity.z))
        .collect()
}

/// Speed of the hips from the first to the last frame, scaled m/s.
fn drift_mps(poses: &Poses, roles: &RoleMap, feet: &FootPaths, duration_s: f64) -> f64 {
    let hips = roles.get(Role::Hips).or(roles.get(Role::ThighLeft)).unwrap_or(0);
    let way = (poses.at(feet.n_frames - 1, hips) - poses.at(0, hips)) / feet.scale;
    (way.x * way.x + way.z * way.z).sqrt() / duration_s
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    /// Hips in place over a belt at `belt_mps` along X, one foot down while the other swings; each step takes 0.5 s.
    fn walk(belt_mps: f64, walker_mps: f64) -> (Poses, RoleMap) {
        let mut roles = RoleMap::default();
        let named = [Role::ThighLeft, Role::KneeLeft, Role::AnkleLeft, Role::ToeLeft].into_iter().chain([
            Role::ThighRight,
            Role::KneeRight,
            Role::AnkleRight,
            Role::ToeRight,
            Role::Hips,
        ]);
        for (point, role) in named.enumerate() {
            roles.set(role, point);
        }
        let foot = |frame: u32, half: u32| {
            let at = f64::from((frame + half) % 60) / 60.0;
            let x = belt_mps * 0.5;
            if at < 0.5 { DVec3::X * x * (2.0 * at - 0.5) } else { DVec3::new(x * (1.5 - 2.0 * at), 0.1, 0.0) }
        };
        let world = (0..180_u32).flat_map(|frame| {
            let moved = DVec3::X * walker_mps * f64::from(frame) / 60.0;
            let leg = |half: u32| {
                let toe = foot(frame, half);
                [DVec3::Y * 0.9, DVec3::Y * 0.45, toe + DVec3::Y * 0.05, toe]
            };
            let points: Vec<DVec3> = leg(0).into_iter().chain(leg(30)).chain([DVec3::Y * 0.95]).collect();
            points.into_iter().map(move |point| point + moved)
        });
        (Poses { n_frames: 180, n_points: 9, world: world.collect() }, roles)
    }

    fn belt(belt_mps: f64, walker_mps: f64) -> Option<DVec3> {
        let (poses, roles) = walk(belt_mps, walker_mps);
        belt_velocity(&poses, &roles, &FootPaths::unscaled(&poses, &roles, 60.0).unwrap())
    }

    #[test]
    fn a_walker_in_place_stands_on_a_belt_and_one_who_goes_does_not() {
        let found = belt(1.2, 0.0).unwrap();
        assert!((found - DVec3::X * 1.2).length() < 1e-9, "{found}");
        assert_eq!(belt(1.2, -1.2), None, "over ground");
        assert_eq!(belt(0.2, 0.0), None, "on the spot");
        assert!(belt(-2.5, 0.1).is_some(), "a little drift, the other way");
    }

    #[test]
    fn over_ground_the_feet_rest() {
        let (poses, roles) = walk(1.2, 0.0);
        let moved = over_ground(&poses, DVec3::X * 1.2, 60.0);
        let toe = moved.path(roles.get(Role::ToeLeft).unwrap());
        assert!((toe[25] - toe[5]).length() < 1e-9);
    }
}
