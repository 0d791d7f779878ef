//! Which frames clustering works on (DESIGN 3, samples).

use super::labels::PlantState;

/// Samples a second where the config doesn't say.
pub const DEFAULT_CLUSTER_RATE_HZ: f64 = 30.0;

/// Native frames that clustering works on, ascending: frame `round(k x rate / cluster rate)`, and the middle frame (the
/// earlier of two) of any plant-state run that has none; every frame at or below the cluster rate.
///
/// `plant_states` has one entry a frame; `cluster_rate_hz` is 30 where None, and asks for every frame if at least
/// the clip's rate.
pub fn samples(
    n_frames: usize,
    rate_hz: f64,
    plant_states: &[Option<PlantState>],
    cluster_rate_hz: Option<f64>,
) -> Vec<u32> {
    let step = rate_hz / cluster_rate_hz.unwrap_or(DEFAULT_CLUSTER_RATE_HZ);
    if step <= 1.0 || step.is_nan() {
        return (0..n_frames as u32).collect();
    }
    let mut regular = (0_usize..).map(|k| (k as f64 * step).round()).take_while(|&at| at < n_frames as f64).peekable();
    let mut samples = Vec::new();
    for run in state_runs(plant_states.get(..n_frames).unwrap_or(plant_states)) {
        let before = samples.len();
        while let Some(at) = regular.next_if(|&at| at < run.end as f64) {
            samples.push(at as u32);
        }
        if samples.len() == before {
            samples.push(((run.start + run.end - 1) / 2) as u32);
        }
    }
    samples.extend(regular.map(|at| at as u32));
    samples
}

/// For every frame the place in `samples` of the sample it belongs to: the nearest one of its own plant-state run, the
/// earlier of two. A run without samples takes the nearest of all; none at all gives an empty list.
pub fn sample_of_frame(samples: &[u32], plant_states: &[Option<PlantState>]) -> Vec<u32> {
    let Some(last) = samples.len().checked_sub(1) else { return Vec::new() };
    let mut places = Vec::with_capacity(plant_states.len());
    for run in state_runs(plant_states) {
        let first_own = samples.partition_point(|&sample| (sample as usize) < run.start);
        let end_own = samples.partition_point(|&sample| (sample as usize) < run.end);
        let (mut place, furthest) = if first_own < end_own {
            (first_own, end_own - 1)
        } else {
            (first_own.saturating_sub(1), first_own.min(last))
        };
        for frame in run {
            let far = |place: usize| samples[place].abs_diff(frame as u32);
            while place < furthest && far(place + 1) < far(place) {
                place += 1;
            }
            places.push(place as u32);
        }
    }
    places
}

fn state_runs(states: &[Option<PlantState>]) -> impl Iterator<Item = core::ops::Range<usize>> + '_ {
    let mut first = 0;
    states.chunk_by(|a, b| a == b).map(move |run| {
        let range = first..first + run.len();
        first = range.end;
        range
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use PlantState::{L, R, RB};

    fn states(runs: &[(PlantState, usize)]) -> Vec<Option<PlantState>> {
        runs.iter().flat_map(|&(state, n)| vec![Some(state); n]).collect()
    }

    #[test]
    fn thirty_a_second_and_every_run() {
        let states = states(&[(L, 9), (RB, 2), (R, 1), (L, 8)]);
        assert_eq!(samples(20, 120.0, &states, None), [0, 4, 8, 9, 11, 12, 16]);
        assert_eq!(samples(20, 60.0, &states, None), [0, 2, 4, 6, 8, 10, 11, 12, 14, 16, 18]);
        assert_eq!(samples(20, 45.0, &states, None), [0, 2, 3, 5, 6, 8, 9, 11, 12, 14, 15, 17, 18]);
        let all: Vec<u32> = (0..20).collect();
        assert_eq!(samples(20, 30.0, &states, None), all);
        assert_eq!(samples(20, 24.0, &states, None), all);
        assert_eq!(samples(20, 120.0, &states, Some(120.0)), all);
        assert_eq!(samples(20, 30.0, &states, Some(7.5)), [0, 4, 8, 9, 11, 12, 16]);
        assert!(samples(0, 120.0, &[], None).is_empty());
    }

    #[test]
    fn frames_belong_to_the_nearest_sample_of_their_run() {
        let states = states(&[(L, 9), (RB, 2), (R, 1), (L, 8)]);
        let samples = samples(20, 120.0, &states, None);
        let frames: Vec<u32> =
            sample_of_frame(&samples, &states).into_iter().map(|place| samples[place as usize]).collect();
        assert_eq!(frames, [0, 0, 0, 4, 4, 4, 4, 8, 8, 9, 9, 11, 12, 12, 12, 16, 16, 16, 16, 16]);
        assert!(sample_of_frame(&[], &states).is_empty());
    }

    #[test]
    fn without_feet_the_clip_is_one_run() {
        let states = vec![None; 10];
        let samples = samples(10, 120.0, &states, None);
        assert_eq!(samples, [0, 4, 8]);
        assert_eq!(sample_of_frame(&samples, &states), [0, 0, 0, 1, 1, 1, 1, 2, 2, 2]);
    }

    proptest::proptest! {
        #[test]
        fn every_run_has_a_sample_and_every_frame_one_of_its_run(
            runs in proptest::collection::vec((0_usize..7, 1_usize..9), 0..12),
            rate_hz in 1.0..500.0_f64,
            cluster_rate_hz in proptest::option::of(1.0..200.0_f64),
        ) {
            let states: Vec<Option<PlantState>> =
                runs.iter().flat_map(|&(state, n)| vec![Some(PlantState::ALL[state]); n]).collect();
            let samples = samples(states.len(), rate_hz, &states, cluster_rate_hz);
            proptest::prop_assert!(samples.windows(2).all(|pair| pair[0] < pair[1]));
            let places = sample_of_frame(&samples, &states);
            proptest::prop_assert_eq!(places.len(), states.len());
            for run in state_runs(&states) {
                for frame in run.clone() {
                    let sample = samples[places[frame] as usize] as usize;
                    proptest::prop_assert!(run.contains(&sample), "frame {} of {:?}: {}", frame, run, sample);
                    let nearest = samples.iter().map(|&sample| sample as usize).filter(|sample| run.contains(sample))
                        .map(|sample| sample.abs_diff(frame)).min();
                    proptest::prop_assert_eq!(nearest, Some(sample.abs_diff(frame)));
                }
            }
        }
    }
}
