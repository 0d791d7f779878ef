//! Ground that is not one plane: each plant rests at its own level (CONTACTS 2.9).

use super::EVIDENCE_HEIGHT_M;
use crate::annotate::order_statistics::percentile;
use core::ops::Range;

/// For this long the body is carried while no foot is near its rest, seconds.
const CARRIED_S: f64 = 0.25;
/// No foot is near its rest: every joint is higher above it than this many times the height at which evidence turns.
const FAR_IN_EVIDENCE_HEIGHTS: f64 = 1.25;
/// The body is carried: the force is larger, body weights.
const CARRIED_BW: f64 = 0.6;
/// A foot that is still for this long, and at least so many frames, is planted, seconds.
const PLANT_S: f64 = 0.12;
const FEWEST_PLANT_FRAMES: usize = 2;
/// A plant's level is this percentile of its heights.
const LEVEL_PERCENT: f64 = 25.0;

/// Whether the body stands on something other than the ground that its feet rest on: for a quarter of a second it is
/// carried and no foot is near its rest.
///
/// `lowest_m`: height of the lowest joint of both feet above its rest, scaled metres, `[frame]`.
pub fn is_uneven(lowest_m: &[f64], force_bw: &[Option<f64>], rate_hz: f64) -> bool {
    let least = (CARRIED_S * rate_hz).ceil();
    let far = |height_m: f64| height_m > FAR_IN_EVIDENCE_HEIGHTS * EVIDENCE_HEIGHT_M;
    let carried: Vec<bool> = lowest_m
        .iter()
        .zip(force_bw)
        .map(|(&height_m, force)| far(height_m) && force.is_some_and(|force| force > CARRIED_BW))
        .collect();
    runs_of_true(&carried).any(|run| run.len() as f64 >= least)
}

/// Levels of one foot's joints, `[joint][frame]`, scaled metres: the plant's own, from the fastest frame before it to
/// the fastest frame after. None: the foot is never planted.
///
/// `still`: the foot may be planted, `[frame]`; `speed_mps`: its speed; `heights`: of its joints.
pub fn plant_levels<const N: usize>(
    still: &[bool],
    speed_mps: &[f64],
    heights: [&[f64]; N],
    rate_hz: f64,
) -> Option<[Vec<f64>; N]> {
    let least = (PLANT_S * rate_hz).round_ties_even().max(FEWEST_PLANT_FRAMES as f64);
    let plants: Vec<Range<usize>> = runs_of_true(still).filter(|run| run.len() as f64 >= least).collect();
    if plants.is_empty() {
        return None;
    }
    let mut starts = vec![0];
    starts.extend(plants.windows(2).map(|pair| fastest(speed_mps, pair[0].end..pair[1].start)));
    let mut levels = heights.map(|heights| vec![0.0; heights.len()]);
    for (at, plant) in plants.iter().enumerate() {
        let end = starts.get(at + 1).copied().unwrap_or(still.len());
        for (levels, heights) in levels.iter_mut().zip(heights) {
            let level = percentile(&mut heights[plant.clone()].to_vec(), LEVEL_PERCENT).unwrap_or(0.0);
            levels[starts[at]..end].fill(level);
        }
    }
    Some(levels)
}

/// The first of the fastest frames in a range that is not empty.
fn fastest(speed_mps: &[f64], range: Range<usize>) -> usize {
    let mut best = range.start;
    for frame in range {
        if speed_mps[frame] > speed_mps[best] {
            best = frame;
        }
    }
    best
}

/// Longest runs of true.
pub fn runs_of_true(marks: &[bool]) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut first = 0;
    marks
        .chunk_by(|a, b| a == b)
        .map(move |run| {
            let range = first..first + run.len();
            first = range.end;
            (run[0], range)
        })
        .filter(|(marked, _)| *marked)
        .map(|(_, range)| range)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    #[test]
    fn a_body_that_is_carried_far_above_the_rest_of_its_feet_is_on_other_ground() {
        let heights = |n: usize| (0..30).map(|frame| if frame < n { 0.2 } else { 0.0 }).collect::<Vec<f64>>();
        let force = vec![Some(1.0); 30];
        assert!(is_uneven(&heights(8), &force, 30.0));
        assert!(!is_uneven(&heights(7), &force, 30.0), "too short");
        assert!(!is_uneven(&heights(8), &vec![Some(0.1); 30], 30.0), "a flight");
        assert!(!is_uneven(&heights(8), &vec![None; 30], 30.0), "force not known");
        assert!(!is_uneven(&[0.07; 30], &force, 30.0), "near enough");
    }

    #[test]
    fn each_plant_has_its_level_from_swing_to_swing() {
        // Plants at frames 2..8 (height 0.1) and 14..20 (0.4), the swing is fastest at frame 10.
        let still: Vec<bool> = (0..22).map(|frame| (2..8).contains(&frame) || (14..20).contains(&frame)).collect();
        let speed: Vec<f64> =
            (0..22).map(|frame| if frame == 10 { 3.0 } else { f64::from(u8::from(!still[frame])) }).collect();
        let heights: Vec<f64> = (0..22).map(|frame| if frame < 10 { 0.1 } else { 0.4 }).collect();
        let [levels] = plant_levels(&still, &speed, [&heights], 30.0).unwrap();
        assert_eq!(levels, heights);
        assert_eq!(plant_levels(&[false; 22], &speed, [&heights], 30.0), None);
        let short: Vec<bool> = (0..22).map(|frame| frame < 3).collect();
        assert_eq!(plant_levels(&short, &speed, [&heights], 30.0), None, "0.1 s is no plant");
    }
}
