//! Eight frames side by side: the arithmetic of one joint for a block of frames, as plain loops over arrays.
//!
//! Every operation works lane by lane in the order written, without fused steps, so the compiler may use vector
//! registers of any width and the bits stay the same.

use super::sincos::{sincos_degrees, sincos_radians};
use super::skeleton::{AngleUnit, Axis};

/// Frames in a block.
pub(super) const LANES: usize = 8;

/// One number for each frame of a block.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Lanes(pub(super) [f64; LANES]);

/// A rotation for each frame of a block: `[row][column]`.
pub(super) type LanesMatrix = [[Lanes; 3]; 3];

/// A point for each frame of a block.
pub(super) type LanesPoint = [Lanes; 3];

/// No rotation, in every lane.
pub(super) const IDENTITY: LanesMatrix = {
    let (zero, one) = (Lanes([0.0; LANES]), Lanes([1.0; LANES]));
    [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
};

impl Lanes {
    /// The same number in every lane.
    #[inline(always)]
    pub(super) fn all(value: f64) -> Lanes {
        Lanes([value; LANES])
    }

    /// `self * a + other * b`, each product rounded.
    #[inline(always)]
    fn blend(self, a: Lanes, other: Lanes, b: Lanes) -> Lanes {
        Lanes(core::array::from_fn(|lane| self.0[lane] * a.0[lane] + other.0[lane] * b.0[lane]))
    }

    /// `self * a - other * b`, each product rounded.
    #[inline(always)]
    fn blend_away(self, a: Lanes, other: Lanes, b: Lanes) -> Lanes {
        Lanes(core::array::from_fn(|lane| self.0[lane] * a.0[lane] - other.0[lane] * b.0[lane]))
    }

    /// Adds `value * scale` in every lane.
    #[inline(always)]
    pub(super) fn add_scaled(&mut self, value: Lanes, scale: f64) {
        for lane in 0..LANES {
            self.0[lane] += value.0[lane] * scale;
        }
    }
}

/// Sines and cosines of a block of angles.
#[inline(always)]
pub(super) fn sincos(angles: Lanes, unit: AngleUnit) -> (Lanes, Lanes) {
    let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
    match unit {
        AngleUnit::Degrees => {
            for lane in 0..LANES {
                (sin[lane], cos[lane]) = sincos_degrees(angles.0[lane]);
            }
        }
        AngleUnit::Radians => {
            for lane in 0..LANES {
                (sin[lane], cos[lane]) = sincos_radians(angles.0[lane]);
            }
        }
    }
    (Lanes(sin), Lanes(cos))
}

/// `matrix` times a rotation about an axis: it mixes two columns.
#[inline(always)]
pub(super) fn turn(matrix: &mut LanesMatrix, axis: Axis, sin: Lanes, cos: Lanes) {
    // Spelled out, since an index known only at run time would keep the matrix out of registers.
    match axis {
        Axis::X => mix::<1, 2>(matrix, sin, cos),
        Axis::Y => mix::<2, 0>(matrix, sin, cos),
        Axis::Z => mix::<0, 1>(matrix, sin, cos),
    }
}

/// `matrix` times the same rotation (`[row][column]`) in every lane.
#[inline(always)]
pub(super) fn turn_fixed(matrix: &mut LanesMatrix, fixed: &[[f64; 3]; 3]) {
    for row in matrix {
        let mut turned = [Lanes::all(0.0); 3];
        for (column, sum) in turned.iter_mut().enumerate() {
            for (inner, factors) in row.iter().zip(fixed) {
                sum.add_scaled(*inner, factors[column]);
            }
        }
        *row = turned;
    }
}

/// `base + matrix * offset`.
#[inline(always)]
pub(super) fn place(base: &LanesPoint, matrix: &LanesMatrix, offset: &LanesPoint) -> LanesPoint {
    let mut point = [Lanes::all(0.0); 3];
    for (axis, sum) in point.iter_mut().enumerate() {
        for lane in 0..LANES {
            sum.0[lane] = base[axis].0[lane]
                + (matrix[axis][0].0[lane] * offset[0].0[lane]
                    + matrix[axis][1].0[lane] * offset[1].0[lane]
                    + matrix[axis][2].0[lane] * offset[2].0[lane]);
        }
    }
    point
}

#[inline(always)]
fn mix<const A: usize, const B: usize>(matrix: &mut LanesMatrix, sin: Lanes, cos: Lanes) {
    for row in matrix {
        let (a, b) = (row[A], row[B]);
        row[A] = a.blend(cos, b, sin);
        row[B] = b.blend_away(cos, a, sin);
    }
}
