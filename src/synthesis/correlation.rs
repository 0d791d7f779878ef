//! Which donor frame goes with which base frame: knots where the ankles pass each other, a monotone cubic between (GRAFTS 2).

use super::Refusal;
use super::heading::{forward, left_ahead};
use super::signal::{Pchip, gradient, lowpass};
use super::subject::{Movement, SIDES, split_frame};
use crate::annotate::labels::Foot;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How clips are laid over each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CorrelationSettings {
    /// Low-pass of the distance between the ankles, before its zeros are sought.
    pub ankle_cutoff_hz: f64,
    /// Fewest pairs of passes that make an alternate.
    pub min_pairs: usize,
    /// Share of the best alternate's pairs that any other must have, 0..1.
    pub min_pair_share: f64,
    /// Weight of velocities beside positions in the distance of leg poses.
    pub velocity_weight_s: f64,
    /// Slowest donor speed allowed at any frame, as a factor of its own.
    pub min_rate_factor: f64,
    /// Fastest donor speed allowed.
    pub max_rate_factor: f64,
}

/// An instant at which the ankles pass each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnklePass {
    /// Fractional frame.
    pub frame: f64,
    /// The foot that goes ahead.
    pub ahead: Foot,
}

/// What correlation needs of a clip; made once a clip, used in every pair.
#[derive(Clone, Debug)]
pub struct Footwork {
    /// Frames a second.
    pub rate_hz: f64,
    /// In time; left and right alternate.
    pub passes: Vec<AnklePass>,
    poses: Vec<[f64; 36]>,
}

/// One way to lay a donor over a base: a shift between their passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternate {
    /// Donor pass minus base pass.
    pub shift: i32,
    /// Base frame and donor frame of each pair of passes.
    pub pairs: Vec<[f64; 2]>,
    /// Mean distance of the leg poses under the map, metres.
    pub distance_m: f64,
    /// The distance, raised for alternates that cover less; the least is the default.
    pub cost_m: f64,
}

/// A donor frame for each base frame of a range.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameMap {
    /// First base frame.
    pub first: usize,
    /// Fractional donor frames of `first`, `first + 1` ...
    pub donor_frames: Vec<f64>,
    /// Least and greatest donor speed, as factors of its own.
    pub rate_factors: [f64; 2],
}

impl Default for CorrelationSettings {
    fn default() -> Self {
        CorrelationSettings {
            ankle_cutoff_hz: 4.0,
            min_pairs: 3,
            min_pair_share: 0.6,
            velocity_weight_s: 0.12,
            min_rate_factor: 0.6,
            max_rate_factor: 1.6,
        }
    }
}

impl Footwork {
    /// Passes and leg poses of a clip.
    pub fn of(movement: &Movement, settings: &CorrelationSettings) -> Footwork {
        let forward = forward(movement);
        let ankles = movement.landmarks.legs.map(|leg| leg.ankle);
        let ahead = left_ahead(movement, ankles, &forward);
        Footwork {
            rate_hz: movement.rate_hz,
            passes: ankle_passes(&lowpass(&ahead, settings.ankle_cutoff_hz, movement.rate_hz)),
            poses: leg_poses(movement, &forward, settings.velocity_weight_s),
        }
    }

    /// Number of frames.
    pub fn n_frames(&self) -> usize {
        self.poses.len()
    }
}

/// Whether any alternate of a pair can be played: its map keeps the donor's speed within the settings' bounds.
///
/// Depends on the passes only, so that hopeless pairs are left alone before any clip is made.
pub fn is_playable(base: (&[AnklePass], f64), donor: (&[AnklePass], f64), settings: &CorrelationSettings) -> bool {
    let ((base, base_hz), (donor, donor_hz)) = (base, donor);
    kept_shifts(base, donor, settings).into_iter().any(|(shift, count)| {
        let pairs = pairs_of(base, donor, shift, count);
        mapped(&pairs).is_some_and(|(_, frames)| {
            let [low, high] = speed_factors(&frames, base_hz, donor_hz);
            frames.len() > 1 && low >= settings.min_rate_factor && high <= settings.max_rate_factor
        })
    })
}

/// How many alternates a pair has; it depends on the passes only, so that a whole product can be counted.
pub fn count_alternates(base: &[AnklePass], donor: &[AnklePass], settings: &CorrelationSettings) -> usize {
    kept_shifts(base, donor, settings).len()
}

/// Every alternate of a pair, the default first: by cost, then more pairs, then the smaller shift.
///
/// # Errors
/// [`Refusal::TooFewPairs`].
pub fn alternates(
    base: &Footwork,
    donor: &Footwork,
    settings: &CorrelationSettings,
) -> Result<Vec<Alternate>, Refusal> {
    let kept = kept_shifts(&base.passes, &donor.passes, settings);
    let most = kept.iter().map(|&(_, count)| count).max().ok_or(Refusal::TooFewPairs)?;
    let mut found = Vec::with_capacity(kept.len());
    for (shift, count) in kept {
        let pairs = pairs_of(&base.passes, &donor.passes, shift, count);
        let Some((first, donor_frames)) = mapped(&pairs) else { continue };
        if donor_frames.is_empty() {
            continue;
        }
        let distances = donor_frames.iter().enumerate().map(|(n, &at)| {
            let (before, share) = split_frame(at, donor.n_frames());
            let (low, high) = (&donor.poses[before], &donor.poses[before + 1]);
            let own = &base.poses[first + n];
            (0..own.len()).map(|k| own[k] - (low[k] + (high[k] - low[k]) * share)).map(|d| d * d).sum::<f64>().sqrt()
        });
        let distance_m = distances.sum::<f64>() / donor_frames.len() as f64;
        found.push(Alternate { shift, pairs, distance_m, cost_m: distance_m * (most as f64 / count as f64).sqrt() });
    }
    let key = |a: &Alternate| (core::cmp::Reverse(a.pairs.len()), a.shift.abs(), a.shift);
    found.sort_by(|a, b| a.cost_m.total_cmp(&b.cost_m).then(key(a).cmp(&key(b))));
    if found.is_empty() { Err(Refusal::TooFewPairs) } else { Ok(found) }
}

/// The map of an alternate: from its first pair to its last.
///
/// # Errors
/// [`Refusal::RateOutOfRange`]; [`Refusal::TooFewPairs`] when fewer than two frames lie between the pairs.
pub fn frame_map(
    alternate: &Alternate,
    base: &Footwork,
    donor: &Footwork,
    settings: &CorrelationSettings,
) -> Result<FrameMap, Refusal> {
    let (first, donor_frames) = mapped(&alternate.pairs).ok_or(Refusal::TooFewPairs)?;
    let factors = donor_frames.windows(2).map(|pair| (pair[1] - pair[0]) / donor.rate_hz * base.rate_hz);
    let [low, high] =
        factors.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], factor| [low.min(factor), high.max(factor)]);
    if donor_frames.len() < 2 {
        return Err(Refusal::TooFewPairs);
    }
    if low < settings.min_rate_factor || high > settings.max_rate_factor {
        return Err(Refusal::RateOutOfRange { low, high });
    }
    Ok(FrameMap { first, donor_frames, rate_factors: [low, high] })
}

/// Zeros of `ahead`, signed by which foot goes ahead; of equal neighbors the first.
fn ankle_passes(ahead: &[f64]) -> Vec<AnklePass> {
    let mut passes: Vec<AnklePass> = Vec::new();
    for (frame, pair) in ahead.windows(2).enumerate() {
        let (now, next) = (pair[0], pair[1]);
        if (now == 0.0 && next != 0.0) || (now < 0.0 && next > 0.0) || (now > 0.0 && next < 0.0) {
            let foot = if next > 0.0 { Foot::Left } else { Foot::Right };
            if passes.last().is_none_or(|last| last.ahead != foot) {
                passes.push(AnklePass { frame: frame as f64 + now / (now - next), ahead: foot });
            }
        }
    }
    passes
}

/// Knees, ankles and toes about the hips in heading space (left, up, forward), then their weighted velocities.
fn leg_poses(movement: &Movement, forward: &[DVec3], velocity_weight_s: f64) -> Vec<[f64; 36]> {
    let marks = &movement.landmarks;
    let mut poses = vec![[0.0; 36]; movement.n_frames()];
    for side in 0..SIDES.len() {
        let leg = marks.legs[side];
        for (joint, point) in [leg.knee, leg.ankle, leg.toe].into_iter().enumerate() {
            let offsets = movement.path_from(point, marks.hips);
            for (frame, (offset, &forward)) in offsets.iter().zip(forward).enumerate() {
                let local = [offset.dot(DVec3::Y.cross(forward)), offset.y, offset.dot(forward)];
                poses[frame][9 * side + 3 * joint..][..3].copy_from_slice(&local);
            }
        }
    }
    for column in 0..18 {
        let values: Vec<f64> = poses.iter().map(|pose| pose[column]).collect();
        for (pose, change) in poses.iter_mut().zip(gradient(&values)) {
            pose[18 + column] = velocity_weight_s * change * movement.rate_hz;
        }
    }
    poses
}

/// Shifts with enough pairs, ascending, and how many pairs each has.
///
/// Passes alternate between the feet, so all pairs of a shift agree in sign if one does.
fn kept_shifts(base: &[AnklePass], donor: &[AnklePass], settings: &CorrelationSettings) -> Vec<(i32, usize)> {
    let (n_base, n_donor) = (base.len() as i32, donor.len() as i32);
    let shifts: Vec<(i32, usize)> = (1 - n_base..n_donor)
        .filter_map(|shift| {
            let first = (-shift).max(0);
            let count = (n_base - first).min(n_donor - (first + shift));
            let agree = || base[first as usize].ahead == donor[(first + shift) as usize].ahead;
            (count > 0 && agree()).then_some((shift, count as usize))
        })
        .collect();
    let most = shifts.iter().map(|&(_, count)| count).max().unwrap_or(0);
    let enough = (settings.min_pairs as f64).max(settings.min_pair_share * most as f64);
    shifts.into_iter().filter(|&(_, count)| count as f64 >= enough).collect()
}

/// Frames of the passes that a shift pairs.
fn pairs_of(base: &[AnklePass], donor: &[AnklePass], shift: i32, count: usize) -> Vec<[f64; 2]> {
    let first = (-shift).max(0);
    let passes = first..first + count as i32;
    passes.map(|pass| [base[pass as usize].frame, donor[(pass + shift) as usize].frame]).collect()
}

/// Least and greatest donor speed along a map, as factors of its own.
fn speed_factors(donor_frames: &[f64], base_hz: f64, donor_hz: f64) -> [f64; 2] {
    let factors = donor_frames.windows(2).map(|pair| (pair[1] - pair[0]) / donor_hz * base_hz);
    factors.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], factor| [low.min(factor), high.max(factor)])
}

/// First base frame between the first and last pair, and the donor frames from there on.
fn mapped(pairs: &[[f64; 2]]) -> Option<(usize, Vec<f64>)> {
    let curve = Pchip::new(pairs)?;
    let first = pairs[0][0].ceil() as usize;
    let last = pairs[pairs.len() - 1][0] as usize;
    Some((first, (first..=last).map(|frame| curve.at(frame as f64)).collect()))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::walker::{walker, waver};
    use super::*;

    #[test]
    fn a_faster_walker_is_slowed_to_the_stride_of_the_base() {
        let settings = CorrelationSettings::default();
        let base = Footwork::of(&walker(30.0, 180, 0.9).movement, &settings);
        let donor = Footwork::of(&walker(60.0, 360, 1.08).movement, &settings);
        assert!(base.passes.windows(2).all(|pair| pair[0].ahead != pair[1].ahead));
        let found = alternates(&base, &donor, &settings).unwrap();
        assert_eq!(found.len(), count_alternates(&base.passes, &donor.passes, &settings));
        assert!(found.windows(2).all(|pair| pair[0].cost_m <= pair[1].cost_m));
        let map = frame_map(&found[0], &base, &donor, &settings).unwrap();
        // Away from the filtered ends the donor runs at 0.9 / 1.08 of its speed.
        let middle = map.donor_frames.len() / 2;
        let factor = (map.donor_frames[middle + 10] - map.donor_frames[middle]) / 10.0 / 2.0;
        assert!((factor - 0.9 / 1.08).abs() < 0.01, "{factor}");
    }

    #[test]
    fn a_stander_has_no_passes_and_a_sprinter_is_too_fast() {
        let settings = CorrelationSettings::default();
        let walk = Footwork::of(&walker(30.0, 180, 0.7).movement, &settings);
        let stand = Footwork::of(&waver(30.0, 180).movement, &settings);
        assert_eq!(alternates(&walk, &stand, &settings), Err(Refusal::TooFewPairs));
        let sprint = Footwork::of(&walker(60.0, 360, 1.5).movement, &settings);
        let found = alternates(&sprint, &walk, &settings).unwrap();
        let refused = frame_map(&found[0], &sprint, &walk, &settings).unwrap_err();
        assert!(matches!(refused, Refusal::RateOutOfRange { high, .. } if high > 1.6), "{refused}");
    }

    #[test]
    fn equal_neighbors_merge_into_the_first() {
        let passes = ankle_passes(&[-1.0, 1.0, 0.0, 0.0, 2.0, -2.0]);
        let frames: Vec<(f64, Foot)> = passes.iter().map(|pass| (pass.frame, pass.ahead)).collect();
        assert_eq!(frames, [(0.5, Foot::Left), (4.5, Foot::Right)]);
    }
}
