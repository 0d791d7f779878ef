//! The medoid of a node: its most central sample.

use super::cut::Cut;
use super::metric::{LANES, Vector, add_up};
use rayon::prelude::*;

/// The most central sample of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medoid {
    /// The member nearest to the mean of all members; of equals the first in tie order.
    pub sample: u32,
    /// Squared distance of the farthest member from that mean, m^2.
    pub max_radius2_m2: f64,
}

/// Medoids of all nodes of a cut.
///
/// `vectors`: those of the tree's samples. The mean is taken in f64 over the members in order, not rounded to f32 as the
/// tree's is: so the two members of a pair are equally near to it, and order decides between them.
pub fn medoids(vectors: &[Vector], cut: &Cut) -> Vec<Medoid> {
    (0..cut.n_nodes()).into_par_iter().map(|node| medoid(vectors, cut.members(node))).collect()
}

fn medoid(vectors: &[Vector], members: &[u32]) -> Medoid {
    let mut mean = [0.0_f64; LANES];
    for &member in members {
        for (sum, &x) in mean.iter_mut().zip(&vectors[member as usize].0) {
            *sum += f64::from(x);
        }
    }
    mean.iter_mut().for_each(|sum| *sum /= members.len() as f64);
    let mut medoid = Medoid { sample: 0, max_radius2_m2: 0.0 };
    let mut least = f64::INFINITY;
    for &member in members {
        let e = distance2(&vectors[member as usize], &mean);
        medoid.max_radius2_m2 = medoid.max_radius2_m2.max(e);
        if e < least {
            least = e;
            medoid.sample = member;
        }
    }
    medoid
}

/// E between a sample and a mean, in the order of lanes of [`error_m2`](super::error_m2).
fn distance2(vector: &Vector, mean: &[f64; LANES]) -> f64 {
    let mut sums = [0.0; 8];
    for (lane, (&x, mean)) in vector.0.iter().zip(mean).enumerate() {
        let difference = f64::from(x) - mean;
        sums[lane % 8] += difference * difference;
    }
    add_up(sums)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::cluster::{Merge, Settings, cut, tree, walks};

    #[test]
    fn of_three_on_a_line_the_middle_one() {
        let mut vectors = [Vector::default(); 4];
        for (vector, x) in vectors.iter_mut().zip([1.0, 9.0, 2.0, 3.5]) {
            vector.0[5] = x;
        }
        let merge = |item, a, b, members| Merge { item, a, b, e: 0.1, members, radius2: 0.0 };
        let at = cut(4, &[merge(4, 0, 2, 2), merge(5, 3, 4, 3)], 0.5).unwrap();
        let found = medoids(&vectors, &at);
        assert_eq!(found[0], Medoid { sample: 1, max_radius2_m2: 0.0 });
        assert_eq!(found[1].sample, 2);
        let mean = 6.5 / 3.0;
        assert!((found[1].max_radius2_m2 - (3.5 - mean) * (3.5 - mean)).abs() < 1e-12);
    }

    #[test]
    fn of_two_the_first_and_radii_agree_with_the_tree() {
        let vectors = walks::smooth(4, 600);
        let merges = tree(vectors.clone(), &Settings::default()).unwrap();
        let at = cut(600, &merges, 0.01).unwrap();
        let found = medoids(&vectors, &at);
        let mut n_pairs = 0;
        for (node, medoid) in found.iter().enumerate() {
            let members = at.members(node);
            assert!(members.contains(&medoid.sample));
            if members.len() == 2 {
                assert_eq!(medoid.sample, members[0]);
                n_pairs += 1;
            }
            if let Some(merge) = (at.items[node] as usize).checked_sub(600).map(|at| &merges[at]) {
                assert!(merge.radius2 <= medoid.max_radius2_m2 * (1.0 + 1e-6));
                assert!(merge.radius2 * f64::from(merge.members) >= medoid.max_radius2_m2 * (1.0 - 1e-6));
            }
        }
        assert!(n_pairs > 10);
    }
}
