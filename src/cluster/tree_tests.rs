//! The tree against the dense reference, for each implementation and however its work is laid out.

#![expect(clippy::unwrap_used, reason = "tests")]

use super::banded::{Bands, Step, tree_in_bands};
use super::metric::{Settings, Vector};
use super::{ClusterError, Merge, dense, tree, tree_by_matrix, tree_by_queue, walks};
use proptest::prelude::*;
use std::ops::ControlFlow;

fn up_to(t_max_m2: f64) -> Settings {
    Settings { t_max_m2, ..Default::default() }
}

/// Samples and T_max to merges.
type Grow = Box<dyn Fn(&[Vector], f64) -> Vec<Merge>>;

/// The same tree by every way that there is: narrow bands and thin skins refresh and redo as wide ones never do.
fn ways() -> Vec<(String, Grow)> {
    let mut ways: Vec<(String, Grow)> = vec![
        ("queue".to_owned(), Box::new(|vectors, t| tree_by_queue(vectors, &up_to(t)).unwrap())),
        ("matrix".to_owned(), Box::new(|vectors, t| tree_by_matrix(vectors, &up_to(t)).unwrap())),
        ("bands".to_owned(), Box::new(|vectors, t| tree(vectors.to_vec(), &up_to(t)).unwrap())),
    ];
    for (growth, skin) in [(1.8, 2.0), (1.3, 1.1), (4.0, 1.02), (1.2, 3.0)] {
        for plain in [false, true] {
            let bands = Bands { growth, skin, few: 2, pairs: 0, plain };
            let grow = move |vectors: &[Vector], t: f64| {
                tree_in_bands(vectors.to_vec(), &up_to(t), &bands, &mut |_| ControlFlow::Continue(())).unwrap()
            };
            ways.push((format!("{bands:?}"), Box::new(grow)));
        }
    }
    ways
}

/// All logs, bit by bit. Returns how many merges there are.
fn assert_equal_dense(vectors: &[Vector], t_max_m2: f64, what: &str) -> usize {
    let reference = dense::merges(vectors, t_max_m2);
    // Means are rounded to f32, which is felt by as much as the coordinates are large.
    let largest = vectors.iter().flat_map(|vector| vector.0).fold(0.0, |largest, x| f64::from(x.abs()).max(largest));
    for (way, grow) in ways() {
        let merges = grow(vectors, t_max_m2);
        for (at, (ours, theirs)) in merges.iter().zip(&reference).enumerate() {
            let found = (ours.item, ours.a, ours.b, ours.e.to_bits(), ours.members);
            let expected = (theirs.item, theirs.a, theirs.b, theirs.e.to_bits(), theirs.members);
            assert_eq!(found, expected, "{what}, {way}: merge {at}, e {} and {}", ours.e, theirs.e);
            let difference = (ours.radius2 - theirs.radius2).abs();
            let (radius, rounding) = (theirs.radius2.sqrt(), 1e-6 * largest);
            let tolerance = 1e-9 * theirs.radius2 + rounding * (radius + rounding);
            assert!(difference <= tolerance, "{what}, {way}: merge {at}: {ours:?} {theirs:?}");
        }
        assert_eq!(merges.len(), reference.len(), "{what}, {way}");
    }
    reference.len()
}

#[test]
fn equal_where_ties_abound() {
    let mut n_merges = 0;
    for seed in 0..60 {
        let n = 1 + (seed as usize * 37) % 300;
        let vectors = walks::quantized(seed, n, 1 + seed as usize % 4, 2 + seed as usize % 7);
        n_merges += assert_equal_dense(&vectors, [0.5, 3.0, 1e4][seed as usize % 3], &format!("seed {seed}"));
    }
    assert!(n_merges > 3000, "{n_merges}");
}

#[test]
fn equal_on_walks() {
    for seed in 0..10 {
        for t_max_m2 in [0.003, 0.5, 1e6] {
            assert_equal_dense(&walks::smooth(seed, 290), t_max_m2, &format!("seed {seed}, T {t_max_m2}"));
        }
    }
    assert!(assert_equal_dense(&walks::smooth(77, 2000), 0.5, "2,000") > 1800);
}

#[test]
fn equal_with_a_tenth_duplicated_and_shuffled() {
    let mut vectors = walks::smooth(5, 1000);
    for i in 0..100 {
        vectors[(i * 7919 + 13) % 1000] = vectors[(i * 104_729 + 500) % 1000];
    }
    vectors.swap(3, 700);
    assert_equal_dense(&vectors, 0.5, "duplicates");
}

#[test]
fn equal_where_means_drift() {
    for (shape, n) in [("ring", 240), ("line", 240), ("star", 181), ("grid", 256)] {
        assert_equal_dense(&walks::shape(shape, n), 1e5, shape);
    }
}

#[test]
fn equal_far_from_the_origin() {
    let mut vectors = walks::smooth(9, 200);
    vectors.iter_mut().for_each(|vector| vector.0.iter_mut().for_each(|x| *x += 4000.0));
    vectors[50].0[3] = 1e9;
    vectors[51].0[3] = -1e9;
    vectors[52].0 = [1e9; 48];
    assert_equal_dense(&vectors, 0.5, "far");
    assert_equal_dense(&vectors, 1e300, "far, all");
}

#[test]
fn thin_skins_refresh_and_have_components_done_again() {
    // Or the ways above would try less than they say.
    let (mut refreshes, mut redone) = (0, 0);
    for seed in 0..8 {
        for (growth, skin) in [(1.3, 1.1), (4.0, 1.02)] {
            let bands = Bands { growth, skin, few: 2, pairs: 0, plain: false };
            let mut tell = |step| {
                if let Step::Merged { refreshed, again, .. } = step {
                    refreshes += refreshed;
                    redone += again;
                }
                ControlFlow::Continue(())
            };
            let vectors = walks::smooth(seed, 1500);
            let merges = tree_in_bands(vectors.clone(), &up_to(0.5), &bands, &mut tell).unwrap();
            assert_eq!(merges, tree_by_queue(&vectors, &up_to(0.5)).unwrap());
        }
    }
    assert!(refreshes > 1000 && redone > 3, "{refreshes} {redone}");
}

#[test]
fn thousands_of_frozen_frames_cost_little() {
    let mut vectors = walks::smooth(1, 2000);
    vectors.extend(vec![vectors[1000]; 5000]);
    vectors.extend(vec![vectors[1500]; 5000]);
    let merges = tree(vectors.clone(), &up_to(0.5)).unwrap();
    // 12,000 samples, 2,000 distinct ones.
    assert_eq!(merges.iter().filter(|merge| merge.e == 0.0).count(), 10_000);
    assert_eq!((merges[0].a, merges[0].b, merges[1].a, merges[1].b), (1000, 2000, 1500, 7000));
    assert_eq!((merges[2].a, merges[2].b), (2001, 2002));
    let one = merges.iter().filter(|merge| merge.e == 0.0 && merge.members == 5001);
    assert_eq!(one.count(), 2);
    assert_eq!(tree_by_queue(&vectors, &up_to(0.5)).unwrap(), merges);
}

#[test]
fn the_number_of_threads_does_not_show() {
    let vectors = walks::smooth(21, 3000);
    let with = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| {
            let by_queue = tree_by_queue(&vectors, &up_to(0.5)).unwrap();
            assert_eq!(tree(vectors.clone(), &up_to(0.5)).unwrap(), by_queue);
            by_queue
        })
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn it_can_be_stopped_after_any_step() {
    let run = |steps: usize| {
        let mut left = steps;
        let mut tell = |_| {
            left -= 1;
            if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        tree_in_bands(walks::smooth(3, 400), &up_to(0.5), &Bands { few: 2, pairs: 0, ..Default::default() }, &mut tell)
    };
    for steps in 1..=8 {
        assert!(matches!(run(steps), Err(ClusterError::Stopped)));
    }
    assert!(run(1000).is_ok());
}

#[test]
fn nothing_and_one_make_no_merges() {
    assert_equal_dense(&[], 0.5, "nothing");
    assert_equal_dense(&walks::smooth(1, 1), 0.5, "one");
}

#[test]
fn the_threshold_itself_does_not_merge() {
    let vectors = walks::shape("line", 2); // 1 m apart
    assert_eq!(assert_equal_dense(&vectors, 1.0, "at it"), 0);
    assert_eq!(assert_equal_dense(&vectors, 1.000001, "above it"), 1);
}

#[test]
fn what_is_no_motion_is_refused() {
    let all = |vectors: &[Vector], t: f64| {
        [tree(vectors.to_vec(), &up_to(t)), tree_by_queue(vectors, &up_to(t)), tree_by_matrix(vectors, &up_to(t))]
            .map(Result::unwrap_err)
    };
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e9] {
        let mut vectors = walks::smooth(1, 20);
        vectors[13].0[44] = value;
        for error in all(&vectors, 0.5) {
            assert!(matches!(error, ClusterError::Coordinate { item: 13, lane: 44, .. }), "{error}");
        }
    }
    for t_max_m2 in [0.0, -0.5, f64::NAN, f64::INFINITY] {
        for error in all(&[], t_max_m2) {
            assert!(matches!(error, ClusterError::Threshold { .. }));
        }
    }
    for (growth, skin) in [(1.0, 2.0), (1.8, 1.0), (f64::NAN, 2.0), (1.8, f64::INFINITY)] {
        let bands = Bands { growth, skin, ..Default::default() };
        let error = tree_in_bands(Vec::new(), &up_to(0.5), &bands, &mut |_| ControlFlow::Continue(())).unwrap_err();
        assert!(matches!(error, ClusterError::Bands { .. }), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..Default::default() })]

    #[test]
    fn equal_on_anything(
        rows in prop::collection::vec(prop::array::uniform3(-3_i8..4), 0..70), t_max_m2 in 0.01..40.0_f64
    ) {
        let vectors: Vec<Vector> = rows
            .iter()
            .map(|row| {
                let mut vector = Vector::default();
                for (axis, &x) in row.iter().enumerate() {
                    vector.0[axis * 20] = f32::from(x) * 0.7;
                }
                vector
            })
            .collect();
        assert_equal_dense(&vectors, t_max_m2, "random rows");
    }
}
