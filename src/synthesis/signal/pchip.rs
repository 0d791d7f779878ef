//! Monotone cubic interpolation (PCHIP, Fritsch and Butland): between two knots it never leaves their values.

/// A cubic through each pair of knots, monotone where the knots are.
#[derive(Clone, Debug, PartialEq)]
pub struct Pchip {
    x: Vec<f64>,
    y: Vec<f64>,
    slopes: Vec<f64>,
}

impl Pchip {
    /// Through the knots `(x, y)`. None: fewer than two, or `x` not strictly rising.
    pub fn new(knots: &[[f64; 2]]) -> Option<Pchip> {
        if knots.len() < 2 || !knots.windows(2).all(|pair| pair[0][0] < pair[1][0]) {
            return None;
        }
        let x: Vec<f64> = knots.iter().map(|knot| knot[0]).collect();
        let y: Vec<f64> = knots.iter().map(|knot| knot[1]).collect();
        let widths: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let secants: Vec<f64> = (0..widths.len()).map(|n| (y[n + 1] - y[n]) / widths[n]).collect();
        let last = secants.len() - 1;
        let mut slopes = vec![secants[0]; knots.len()];
        if last > 0 {
            for n in 1..=last {
                slopes[n] = inner_slope([widths[n - 1], widths[n]], [secants[n - 1], secants[n]]);
            }
            slopes[0] = end_slope([widths[0], widths[1]], [secants[0], secants[1]]);
            slopes[last + 1] = end_slope([widths[last], widths[last - 1]], [secants[last], secants[last - 1]]);
        }
        Some(Pchip { x, y, slopes })
    }

    /// The value at `x`; outside the knots the outermost cubic goes on.
    pub fn at(&self, x: f64) -> f64 {
        let n = (self.x.partition_point(|&knot| knot <= x)).clamp(1, self.x.len() - 1) - 1;
        let width = self.x[n + 1] - self.x[n];
        let secant = (self.y[n + 1] - self.y[n]) / width;
        let bend = (self.slopes[n] + self.slopes[n + 1] - 2.0 * secant) / width;
        let d = x - self.x[n];
        let square = (secant - self.slopes[n]) / width - bend;
        self.y[n] + d * (self.slopes[n] + d * (square + d * (bend / width)))
    }
}

/// The weighted harmonic mean of the secants on both sides; 0 where they disagree in sign.
fn inner_slope(widths: [f64; 2], secants: [f64; 2]) -> f64 {
    let [before, after] = secants;
    // Signs, not the product: that can underflow.
    if !((before > 0.0 && after > 0.0) || (before < 0.0 && after < 0.0)) {
        return 0.0;
    }
    let weights = [2.0 * widths[1] + widths[0], widths[1] + 2.0 * widths[0]];
    (weights[0] + weights[1]) / (weights[0] / before + weights[1] / after)
}

/// The three-point slope at an end, limited so that the cubic keeps the shape. Nearest width and secant first.
fn end_slope(widths: [f64; 2], secants: [f64; 2]) -> f64 {
    let sign = |value: f64| if value == 0.0 { 0.0 } else { value.signum() };
    let slope = ((2.0 * widths[0] + widths[1]) * secants[0] - widths[0] * secants[1]) / (widths[0] + widths[1]);
    if sign(slope) != sign(secants[0]) {
        0.0
    } else if sign(secants[0]) != sign(secants[1]) && slope.abs() > 3.0 * secants[0].abs() {
        3.0 * secants[0]
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    /// Made once with scipy 1.17: `PchipInterpolator(x, y)(at)`.
    #[test]
    fn it_equals_scipy() {
        /// Points, as (x, y).
        type Curve = &'static [[f64; 2]];
        let curves: [(Curve, Curve); 3] = [
            (
                &[[0.0, 0.0], [1.0, 1.0], [2.5, 1.2], [3.0, 4.0], [5.0, 3.9], [7.0, 3.9]],
                &[
                    [0.3, 0.39834016528925614],
                    [1.0, 1.0],
                    [1.7, 1.0854285178273446],
                    [2.9, 3.7137548387096766],
                    [4.2, 3.9352],
                    [6.5, 3.9],
                ],
            ),
            (
                &[[0.0, 0.0], [1.0, 4.0], [3.0, 4.5]],
                &[[0.5, 2.5910326086956523], [2.0, 4.380434782608695], [2.9, 4.498853260869565]],
            ),
            (
                &[[0.0, 0.0], [1.0, 0.1], [2.0, 4.0], [3.0, 3.0]],
                &[[0.1, 0.0010450000000000006], [0.5, 0.025625000000000005], [2.5, 3.875], [2.9, 3.2710000000000004]],
            ),
        ];
        for (knots, expected) in curves {
            let curve = Pchip::new(knots).unwrap();
            for &[x, y] in expected {
                assert!((curve.at(x) - y).abs() < 1e-14, "{x}: {} {y}", curve.at(x));
            }
        }
    }

    #[test]
    fn two_knots_make_a_line_and_bad_knots_nothing() {
        assert_eq!(Pchip::new(&[[1.0, 2.0], [3.0, 6.0]]).unwrap().at(2.0), 4.0);
        assert!(Pchip::new(&[[1.0, 2.0]]).is_none());
        assert!(Pchip::new(&[[1.0, 2.0], [1.0, 3.0]]).is_none());
        assert!(Pchip::new(&[[1.0, 2.0], [f64::NAN, 3.0]]).is_none());
    }
}
