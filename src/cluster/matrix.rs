//! The cluster tree by the matrix of all distances (T 4.2.3): as slow as that is, and as plain. To compare others with.

use super::error::ClusterError;
use super::log::Log;
use super::metric::{Settings, Vector, centroid, error_m2};
use super::tables::Merge;

/// The cluster tree, as [`tree()`](super::tree()) makes it. Time and memory grow with n²: 20,000 samples need 3.2 GB.
///
/// # Errors
/// As [`tree()`](super::tree()).
pub fn tree_by_matrix(vectors: &[Vector], settings: &Settings) -> Result<Vec<Merge>, ClusterError> {
    super::queue::check(vectors, settings)?;
    let n = vectors.len();
    let mut log = Log::new(n);
    let mut live = Live {
        vectors: vectors.to_vec(),
        numbers: (0..n as u32).map(Some).collect(),
        errors: vec![f64::INFINITY; n * n],
        nearest: Vec::new(),
    };
    for place in 0..n {
        live.measure(place);
    }
    live.nearest = (0..n).map(|place| live.nearest_older(place)).collect();
    loop {
        let offers = (0..n).filter_map(|place| live.offer(place));
        let Some((e, a, b, place_a, place_b)) =
            offers.min_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))))
        else {
            break;
        };
        if e >= settings.t_max_m2 {
            break;
        }
        let [of_a, of_b] = [a, b].map(|item| log.members[item as usize]);
        let mean = centroid(&live.vectors[place_a], of_a, &live.vectors[place_b], of_b);
        live.numbers[place_a] = None;
        live.numbers[place_b] = Some(log.merge(e, a, b));
        live.vectors[place_b] = mean;
        live.measure(place_b);
        for place in 0..n {
            let is_lost = live.nearest[place].is_some_and(|(_, other)| other == place_a || other == place_b);
            if place == place_b || is_lost {
                live.nearest[place] = live.nearest_older(place);
            }
        }
    }
    Ok(log.merges)
}

/// Live items in places; a mean takes the place of its younger part.
struct Live {
    vectors: Vec<Vector>,
    /// None: nobody.
    numbers: Vec<Option<u32>>,
    /// `[place][place]`
    errors: Vec<f64>,
    /// `[place]`: E, and the place of the nearest older item.
    nearest: Vec<Option<(f64, usize)>>,
}

impl Live {
    /// E from one place to all others.
    fn measure(&mut self, place: usize) {
        let n = self.vectors.len();
        for other in 0..n {
            if other != place && self.numbers[other].is_some() {
                let e = error_m2(&self.vectors[place], &self.vectors[other]);
                self.errors[place * n + other] = e;
                self.errors[other * n + place] = e;
            }
        }
    }

    fn nearest_older(&self, place: usize) -> Option<(f64, usize)> {
        let own = self.numbers[place]?;
        let row = &self.errors[place * self.vectors.len()..];
        let older = self.numbers.iter().zip(row).enumerate().filter_map(|(other, (number, &e))| {
            let number = (*number).filter(|&number| number < own)?;
            Some((e, number, other))
        });
        older.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(e, _, other)| (e, other))
    }

    /// E, both items, older first, and their places.
    fn offer(&self, place: usize) -> Option<(f64, u32, u32, usize, usize)> {
        let own = self.numbers[place]?;
        let (e, other) = self.nearest[place]?;
        Some((e, self.numbers[other]?, own, other, place))
    }
}
