//! Groups of alike clips, the same on every machine: farthest-point seeds, then Lloyd's rounds in a fixed order.

/// Rounds after which the groups stay as they are.
const MAX_ROUNDS: usize = 30;

/// Points in groups.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    /// Group of each point.
    pub of: Vec<usize>,
    /// Centre of each group.
    pub centers: Vec<Vec<f64>>,
}

impl Groups {
    /// Sorts points into at most `n` groups. Ties go to the earlier point or group.
    pub fn of(points: &[&[f64]], n: usize) -> Groups {
        let mut centers: Vec<Vec<f64>> = Vec::new();
        let Some(first) = nearest_to_mean(points) else { return Groups { of: Vec::new(), centers } };
        centers.push(points[first].to_vec());
        let mut far: Vec<f64> = points.iter().map(|point| distance2(point, &centers[0])).collect();
        while centers.len() < n {
            let farthest = (0..points.len()).rev().max_by(|&a, &b| far[a].total_cmp(&far[b])).unwrap_or(0);
            if far[farthest] <= 0.0 {
                break;
            }
            centers.push(points[farthest].to_vec());
            for (point, far) in points.iter().zip(&mut far) {
                *far = far.min(distance2(point, points[farthest]));
            }
        }
        let mut of: Vec<usize> = points.iter().map(|point| nearest(point, &centers)).collect();
        for _ in 0..MAX_ROUNDS {
            for (group, center) in centers.iter_mut().enumerate() {
                let members = || points.iter().zip(&of).filter(|&(_, &own)| own == group).map(|(point, _)| point);
                let count = members().count();
                if count == 0 {
                    continue; // it keeps its place
                }
                for (dimension, value) in center.iter_mut().enumerate() {
                    *value = members().map(|point| point[dimension]).sum::<f64>() / count as f64;
                }
            }
            let next: Vec<usize> = points.iter().map(|point| nearest(point, &centers)).collect();
            if next == of {
                break;
            }
            of = next;
        }
        Groups { of, centers }
    }
}

/// Squared distance of two points.
pub fn distance2(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

fn nearest(point: &[f64], centers: &[Vec<f64>]) -> usize {
    (0..centers.len())
        .min_by(|&a, &b| distance2(point, &centers[a]).total_cmp(&distance2(point, &centers[b])))
        .unwrap_or(0)
}

fn nearest_to_mean(points: &[&[f64]]) -> Option<usize> {
    let width = points.first()?.len();
    let mean: Vec<f64> = (0..width)
        .map(|dimension| points.iter().map(|point| point[dimension]).sum::<f64>() / points.len() as f64)
        .collect();
    (0..points.len()).min_by(|&a, &b| distance2(points[a], &mean).total_cmp(&distance2(points[b], &mean)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_heaps_make_three_groups() {
        let points: Vec<[f64; 2]> = (0..30).map(|n| [f64::from(n % 3) * 10.0, f64::from(n) * 0.01]).collect();
        let points: Vec<&[f64]> = points.iter().map(|point| &point[..]).collect();
        let groups = Groups::of(&points, 3);
        assert_eq!(groups.centers.len(), 3);
        assert!((0..30).all(|n| groups.of[n] == groups.of[n % 3]));
        assert_ne!(groups.of[0], groups.of[1]);
    }

    #[test]
    fn equal_points_make_one_group_and_none_make_none() {
        assert_eq!(Groups::of(&[&[1.0], &[1.0], &[1.0]], 5).centers.len(), 1);
        assert_eq!(Groups::of(&[], 5), Groups { of: vec![], centers: vec![] });
    }
}
