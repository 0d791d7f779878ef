//! Sixteen directions in which the vectors at hand vary most: where the search looks first.
//!
//! Only the *speed* of a search depends on them. Distances between projections never exceed true ones, so
//! whatever the basis, nothing near is overlooked; E itself is always computed from the canonical vectors.
//! That is why the basis may be fitted to the data, while the metric may not (DESIGN 6).

use super::metric::{LANES, Vector};

/// Coordinates of a projection.
pub(super) const DIMENSIONS: usize = 16;

/// A vector's coordinates in the basis.
pub(super) type Point = [f32; DIMENSIONS];

/// An orthonormal basis of a subspace, and the point that it is centered on.
pub(super) struct SearchBasis {
    center: [f64; LANES],
    /// `[lane][direction]`.
    columns: [[f64; DIMENSIONS]; LANES],
}

/// Vectors that the basis is fitted to, at most.
const FITTED: usize = 4096;

impl SearchBasis {
    /// The principal directions of an even selection of `n_vectors` vectors.
    pub(super) fn of<'a>(n_vectors: usize, vector: impl Fn(usize) -> &'a Vector) -> SearchBasis {
        let fitted = || (0..n_vectors).step_by(n_vectors.div_ceil(FITTED).max(1)).map(&vector);
        let n = fitted().count().max(1) as f64;
        let mut center = [0.0; LANES];
        for vector in fitted() {
            for (sum, &x) in center.iter_mut().zip(&vector.0) {
                *sum += f64::from(x) / n;
            }
        }
        let mut covariance = [[0.0; LANES]; LANES];
        for vector in fitted() {
            let offset: [f64; LANES] = std::array::from_fn(|lane| f64::from(vector.0[lane]) - center[lane]);
            for (row, &x) in covariance.iter_mut().zip(&offset) {
                for (sum, &y) in row.iter_mut().zip(&offset) {
                    *sum += x * y;
                }
            }
        }
        let directions = diagonalize(&mut covariance);
        let mut order: [usize; LANES] = std::array::from_fn(|i| i);
        order.sort_by(|&a, &b| covariance[b][b].total_cmp(&covariance[a][a]).then(a.cmp(&b)));
        let columns = std::array::from_fn(|lane| std::array::from_fn(|k| directions[lane][order[k]]));
        SearchBasis { center, columns }
    }

    /// Coordinates of a vector in the basis, largest variance first: metres.
    pub(super) fn project(&self, vector: &Vector) -> Point {
        let mut point = [0.0; DIMENSIONS];
        for lane in 0..LANES {
            let x = f64::from(vector.0[lane]) - self.center[lane];
            for (sum, column) in point.iter_mut().zip(&self.columns[lane]) {
                *sum += x * column;
            }
        }
        point.map(|x| x as f32)
    }
}

/// Diagonalizes a symmetric matrix by Jacobi rotations; returns the directions, `[lane][direction]`.
///
/// Stops after a fixed number of sweeps at the latest: a poor basis costs time only, and the product of
/// rotations is orthonormal at any moment.
fn diagonalize(matrix: &mut [[f64; LANES]; LANES]) -> Box<[[f64; LANES]; LANES]> {
    let mut directions = Box::new([[0.0; LANES]; LANES]);
    for (lane, row) in directions.iter_mut().enumerate() {
        row[lane] = 1.0;
    }
    let trace: f64 = (0..LANES).map(|i| matrix[i][i]).sum();
    for _sweep in 0..12 {
        let mut largest = 0.0_f64;
        for p in 0..LANES {
            for q in p + 1..LANES {
                largest = largest.max(matrix[p][q].abs());
                if matrix[p][q].abs() > 1e-9 * trace {
                    rotate(matrix, &mut directions, p, q);
                }
            }
        }
        if largest <= 1e-9 * trace {
            break;
        }
    }
    directions
}

/// Turns the plane of directions p and q so that `matrix[p][q]` vanishes.
fn rotate(matrix: &mut [[f64; LANES]; LANES], directions: &mut [[f64; LANES]; LANES], p: usize, q: usize) {
    let slope = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
    let tangent = slope.signum() / (slope.abs() + (slope * slope + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let turn = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
    for row in matrix.iter_mut().chain(directions.iter_mut()) {
        (row[p], row[q]) = turn(row[p], row[q]);
    }
    let (upper, lower) = matrix.split_at_mut(q);
    for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
        (*x, *y) = turn(*x, *y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::metric::error_m2;
    use crate::cluster::walks;

    #[test]
    fn projections_never_lengthen_and_keep_most_of_the_distance() {
        let vectors = walks::smooth(3, 500);
        let basis = SearchBasis::of(vectors.len(), |i| &vectors[i]);
        let (mut kept, mut all) = (0.0, 0.0);
        for (a, b) in vectors.iter().zip(&vectors[1..]).chain(vectors.iter().zip(&vectors[137..])) {
            let (p, q) = (basis.project(a), basis.project(b));
            let projected: f64 = p.iter().zip(&q).map(|(x, y)| (f64::from(*x) - f64::from(*y)).powi(2)).sum();
            let e = error_m2(a, b);
            assert!(projected.sqrt() <= e.sqrt() + 2e-6, "{projected} {e}");
            kept += projected;
            all += e;
        }
        assert!(kept > 0.6 * all, "{kept} of {all}");
    }

    #[test]
    fn the_first_direction_is_the_longest() {
        let mut vectors = vec![Vector::default(); 40];
        for (i, vector) in vectors.iter_mut().enumerate() {
            vector.0[7] = 3.0 * i as f32;
            vector.0[9] = 4.0 * i as f32;
            vector.0[20] = (i % 2) as f32;
        }
        let basis = SearchBasis::of(vectors.len(), |i| &vectors[i]);
        let (a, b) = (basis.project(&vectors[0]), basis.project(&vectors[2]));
        assert!(((a[0] - b[0]).abs() - 10.0).abs() < 1e-3, "{a:?} {b:?}");
        assert!(a[2..].iter().all(|x| x.abs() < 1e-6));
    }
}
