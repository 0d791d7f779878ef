//! What a donor's arms do, and when: active arms and the window of their action (GRAFTS 3).

use super::Refusal;
use super::parts::Part;
use super::signal::{gradient, lowpass_points, median, percentile};
use super::subject::{Movement, SIDES};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What counts as an action of an arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ActionSettings {
    /// Low-pass of the wrist's path about the shoulder.
    pub wrist_cutoff_hz: f64,
    /// The start (or end) pose is the median over this long.
    pub pose_s: f64,
    /// An arm is active, or busy, when its wrist leaves its start pose by more than this.
    pub min_excursion_m: f64,
    /// And by more than this share of the other arm's, 0..1.
    pub min_share_of_other: f64,
    /// The action holds every frame beyond this share of the peak excursion, 0..1.
    pub window_share: f64,
    /// From there it reaches out to where the wrist is slower than this share of its fast speed, 0..1.
    pub rest_speed_share: f64,
    /// The fast speed is this percentile.
    pub fast_percentile: f64,
}

/// What the arms of a clip do.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// Arms that do something: left, right.
    pub active: [bool; 2],
    /// Largest distance of each wrist from its start pose, metres.
    pub excursion_m: [f64; 2],
    /// First frame of the action; with `end`, half-open. Empty where no arm is active.
    pub first: usize,
    /// Frame after the last.
    pub end: usize,
}

impl Default for ActionSettings {
    fn default() -> Self {
        ActionSettings {
            wrist_cutoff_hz: 6.0,
            pose_s: 0.15,
            min_excursion_m: 0.15,
            min_share_of_other: 0.35,
            window_share: 0.25,
            rest_speed_share: 0.12,
            fast_percentile: 95.0,
        }
    }
}

impl Action {
    /// Finds the active arms of a clip and the window that holds what all of them do.
    pub fn of(movement: &Movement, settings: &ActionSettings) -> Action {
        let paths = [0, 1].map(|side| wrist_path(movement, side, settings.wrist_cutoff_hz));
        let pose_frames = pose_frames(movement.rate_hz, settings.pose_s);
        let excursion_m = [0, 1].map(|side| {
            let start = median_point(&paths[side][..pose_frames.min(paths[side].len())]);
            paths[side].iter().map(|wrist| wrist.distance(start)).fold(0.0, f64::max)
        });
        let most = excursion_m[0].max(excursion_m[1]);
        let active = excursion_m
            .map(|excursion| excursion > settings.min_excursion_m && excursion > settings.min_share_of_other * most);
        let windows = (0..SIDES.len())
            .filter(|&side| active[side])
            .map(|side| window(&paths[side], pose_frames, movement.rate_hz, settings));
        let [first, end] = windows.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or([0, 0]);
        Action { active, excursion_m, first, end }
    }

    /// The parts that a stand donor gives.
    pub fn parts(&self) -> Vec<Part> {
        (0..SIDES.len()).filter(|&side| self.active[side]).map(|side| Part::ARMS[side]).collect()
    }

    /// The donor frames to graft, half-open: the window, widened by a seam on both sides as far as the clip reaches, so
    /// that the blend eats as little of the action as it can.
    pub fn frames_with_seams(&self, seam_s: f64, rate_hz: f64, n_frames: usize) -> [usize; 2] {
        let seam = (seam_s * rate_hz).ceil().max(0.0) as usize;
        [self.first.saturating_sub(seam), (self.end + seam).min(n_frames)]
    }
}

/// Refuses a base whose arm moves where the donor's is to be laid over it (GRAFTS 3: stand <- stand).
///
/// `frames` is a half-open range of the base. An arm is busy when, inside it, its wrist leaves the pose that it has at
/// the range's start by more than `min_excursion_m`.
///
/// # Errors
/// [`Refusal::BaseArmBusy`].
pub fn require_idle_arms(
    base: &Movement,
    parts: &[Part],
    frames: [usize; 2],
    settings: &ActionSettings,
) -> Result<(), Refusal> {
    for (side, &part) in Part::ARMS.iter().enumerate().filter(|(_, part)| parts.contains(part)) {
        let path = wrist_path(base, side, settings.wrist_cutoff_hz);
        let inside = &path[frames[0].min(path.len())..frames[1].min(path.len())];
        let start = median_point(&inside[..pose_frames(base.rate_hz, settings.pose_s).min(inside.len())]);
        if inside.iter().any(|wrist| wrist.distance(start) > settings.min_excursion_m) {
            return Err(Refusal::BaseArmBusy(part));
        }
    }
    Ok(())
}

/// A wrist about its shoulder in the chest's axes, low-passed, `[frame]`.
pub(super) fn wrist_path(movement: &Movement, side: usize, cutoff_hz: f64) -> Vec<DVec3> {
    let arm = movement.landmarks.arms[side];
    lowpass_points(&movement.path_in_chest(arm.wrist, arm.shoulder), cutoff_hz, movement.rate_hz)
}

fn pose_frames(rate_hz: f64, pose_s: f64) -> usize {
    // The hair of slack takes a file's 29.99997 for 30.
    ((pose_s * rate_hz + 1e-3) as usize).max(3)
}

fn median_point(points: &[DVec3]) -> DVec3 {
    let of = |axis: usize| median(&points.iter().map(|point| point[axis]).collect::<Vec<_>>()).unwrap_or(0.0);
    DVec3::new(of(0), of(1), of(2))
}

/// The frames of one arm's action, half-open.
fn window(path: &[DVec3], pose_frames: usize, rate_hz: f64, settings: &ActionSettings) -> [usize; 2] {
    let n = path.len();
    let start = median_point(&path[..pose_frames.min(n)]);
    let end = median_point(&path[n - pose_frames.min(n)..]);
    let excursion: Vec<f64> = path.iter().map(|wrist| wrist.distance(start).min(wrist.distance(end))).collect();
    let peak = excursion.iter().copied().fold(0.0, f64::max);
    let beyond = |frame: &usize| excursion[*frame] > settings.window_share * peak;
    let (Some(mut first), Some(mut last)) = ((0..n).find(beyond), (0..n).rev().find(beyond)) else {
        return [0, n];
    };
    let axes = [0, 1, 2].map(|axis| gradient(&path.iter().map(|wrist| wrist[axis]).collect::<Vec<_>>()));
    let speeds: Vec<f64> =
        (0..n).map(|frame| DVec3::new(axes[0][frame], axes[1][frame], axes[2][frame]).length() * rate_hz).collect();
    let rest = settings.rest_speed_share * percentile(&speeds, settings.fast_percentile).unwrap_or(0.0);
    while first > 0 && speeds[first] > rest {
        first -= 1;
    }
    while last + 1 < n && speeds[last] > rest {
        last += 1;
    }
    [first, last + 1]
}

#[cfg(test)]
mod tests {
    use super::super::walker::{mover, walker, waver};
    use super::*;
    use crate::motion::Role;

    #[test]
    fn one_raised_arm_is_active_and_the_idle_one_is_not() {
        let action = Action::of(&waver(30.0, 90).movement, &ActionSettings::default());
        assert_eq!(action.active, [true, false]);
        assert_eq!(action.parts(), [Part::ArmLeft]);
        assert!(action.excursion_m[0] > 0.5 && action.excursion_m[1] < 0.01, "{:?}", action.excursion_m);
    }

    #[test]
    fn the_window_leaves_out_the_wait_before_and_after() {
        // Waits 2 s, raises the arm for 2 s, waits 2 s.
        let subject = mover(30.0, 180, 1.0, 0.0, &|time_s, _| {
            let raise = libm::sin(core::f64::consts::PI * ((time_s - 2.0) / 2.0).clamp(0.0, 1.0));
            vec![(Role::ShoulderRight, [-90.0 * raise * raise, 0.0, 0.0])]
        });
        let action = Action::of(&subject.movement, &ActionSettings::default());
        assert_eq!(action.active, [false, true]);
        assert!((58..68).contains(&action.first) && (112..123).contains(&action.end), "{action:?}");
        let [first, end] = action.frames_with_seams(0.5, 30.0, 180);
        assert_eq!([first, end], [action.first - 15, action.end + 15]);
    }

    #[test]
    fn a_swinging_arm_is_busy_and_a_hanging_one_idle() {
        let settings = ActionSettings::default();
        let walk = walker(30.0, 90, 1.0).movement;
        let busy = require_idle_arms(&walk, &[Part::ArmRight], [0, 60], &settings);
        assert_eq!(busy, Err(Refusal::BaseArmBusy(Part::ArmRight)));
        let wave = waver(30.0, 90).movement;
        assert_eq!(require_idle_arms(&wave, &[Part::ArmRight, Part::Head], [0, 90], &settings), Ok(()));
        assert!(require_idle_arms(&wave, &[Part::ArmLeft], [0, 90], &settings).is_err());
        assert!(require_idle_arms(&wave, &[Part::ArmLeft], [0, 2], &settings).is_ok());
    }
}
