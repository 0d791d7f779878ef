//! The cluster tree read off eq. 4.1 and T 4.2.3 as they stand: all pairs, again after every merge. For tests.

use super::metric::Vector;
use super::tables::Merge;

struct Item {
    number: u32,
    vector: [f32; 48],
    samples: Vec<usize>,
}

/// The merges up to T_max, `radius2` from the members themselves. Time n^3, memory n^2.
pub(super) fn merges(vectors: &[Vector], t_max_m2: f64) -> Vec<Merge> {
    let mut live: Vec<Item> = Vec::new(); // by number
    let mut rows: Vec<Vec<f64>> = Vec::new(); // E to each live item of lower number
    for (sample, vector) in vectors.iter().enumerate() {
        let item = Item { number: sample as u32, vector: vector.0, samples: vec![sample] };
        rows.push(live.iter().map(|other| distance2(&item, other)).collect());
        live.push(item);
    }
    let mut merges = Vec::new();
    for number in vectors.len() as u32.. {
        let mut least = (t_max_m2, 0, 0);
        for (high, row) in rows.iter().enumerate() {
            for (low, &e) in row.iter().enumerate() {
                // Of equal E the lower item decides, then the higher: places are in the order of numbers.
                if e < least.0 || (e == least.0 && e < t_max_m2 && (low, high) < (least.1, least.2)) {
                    least = (e, low, high);
                }
            }
        }
        let (e, low, high) = least;
        if e >= t_max_m2 {
            break;
        }
        for gone in [high, low] {
            rows.remove(gone);
            for row in &mut rows[gone..] {
                row.remove(gone);
            }
        }
        let b = live.remove(high);
        let a = live.remove(low);
        let item = merged(&a, &b, number);
        let members = item.samples.len() as u32;
        merges.push(Merge { item: number, a: a.number, b: b.number, e, members, radius2: spread(vectors, &item) });
        rows.push(live.iter().map(|other| distance2(&item, other)).collect());
        live.push(item);
    }
    merges
}

/// E by the documented order: eight sums over every eighth coordinate, then halves onto halves.
fn distance2(a: &Item, b: &Item) -> f64 {
    let square = |lane: usize| (f64::from(a.vector[lane]) - f64::from(b.vector[lane])).powi(2);
    let eight: Vec<f64> = (0..8).map(|l| (0..6).fold(0.0, |sum, c| sum + square(8 * c + l))).collect();
    let four: Vec<f64> = (0..4).map(|l| eight[l] + eight[l + 4]).collect();
    let two: Vec<f64> = (0..2).map(|l| four[l] + four[l + 2]).collect();
    two[0] + two[1]
}

fn merged(a: &Item, b: &Item, number: u32) -> Item {
    let (n_a, n_b) = (a.samples.len() as f64, b.samples.len() as f64);
    let mean = |lane: usize| (n_a * f64::from(a.vector[lane]) + n_b * f64::from(b.vector[lane])) / (n_a + n_b);
    Item {
        number,
        vector: std::array::from_fn(|lane| mean(lane) as f32),
        samples: [&a.samples[..], &b.samples].concat(),
    }
}

/// Mean squared distance of the members to their mean.
fn spread(vectors: &[Vector], item: &Item) -> f64 {
    let n = item.samples.len() as f64;
    let mut sum = 0.0;
    for lane in 0..48 {
        let of = |&sample: &usize| f64::from(vectors[sample].0[lane]);
        let mean = item.samples.iter().map(of).sum::<f64>() / n;
        sum += item.samples.iter().map(|sample| (of(sample) - mean).powi(2)).sum::<f64>();
    }
    sum / n
}
