//! Sine and cosine of one angle in plain arithmetic: no branches, no tables, no fused steps, so that loops over
//! lanes vectorize and every x86-64 machine computes the same bits.
//!
//! Degrees are reduced modulo 90 before they meet pi, which is exact for every angle a file can hold; so a joint
//! turned by a whole number of quarter turns stays exact, and 36,000,010 degrees are as good as 10. The
//! polynomials interpolate at Chebyshev nodes over a little more than [-pi/4, pi/4]; their own error is below
//! 2e-17, the result's about 1e-16.

/// Degrees below this magnitude are reduced exactly.
pub(super) const DEGREES_LIMIT: f32 = (1u64 << 30) as f32;

/// Radians below this magnitude are reduced to about 1e-16.
pub(super) const RADIANS_LIMIT: f32 = (1u64 << 19) as f32;

/// Adding this rounds to a whole number (half to even) that then stands in the low bits.
const ROUNDER: f64 = 1.5 * (1u64 << 52) as f64;

/// pi / 2 as 33 + 33 + 53 bits: a quarter-turn count below 2^20 times either of the first two is exact.
const QUARTER: [f64; 3] = [1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21];

/// (sin r - r) / r^3 in powers of r^2.
const SIN: [f64; 6] = [
    -0.16666666666666666,
    0.008333333333330946,
    -0.0001984126983675497,
    2.755731610068303e-06,
    -2.5051131455427946e-08,
    1.591810123027412e-10,
];

/// (cos r - 1 + r^2 / 2) / r^4 in powers of r^2.
const COS: [f64; 6] = [
    0.041666666666666664,
    -0.0013888888888887395,
    2.4801587298763433e-05,
    -2.7557317270560326e-07,
    2.0876146024689747e-09,
    -1.1382614868556325e-11,
];

/// `(sin, cos)` of an angle in degrees, `|degrees| <` [`DEGREES_LIMIT`].
#[inline(always)]
pub(super) fn sincos_degrees(degrees: f64) -> (f64, f64) {
    let shifted = degrees * (1.0 / 90.0) + ROUNDER;
    let quarters = shifted - ROUNDER;
    let rest = degrees - quarters * 90.0;
    turn_back(rest * (core::f64::consts::PI / 180.0), shifted.to_bits())
}

/// `(sin, cos)` of an angle in radians, `|radians| <` [`RADIANS_LIMIT`].
#[inline(always)]
pub(super) fn sincos_radians(radians: f64) -> (f64, f64) {
    let shifted = radians * core::f64::consts::FRAC_2_PI + ROUNDER;
    let quarters = shifted - ROUNDER;
    let rest = ((radians - quarters * QUARTER[0]) - quarters * QUARTER[1]) - quarters * QUARTER[2];
    turn_back(rest, shifted.to_bits())
}

/// `(sin, cos)` of `rest` plus as many quarter turns as the two low bits of `quarters` say.
#[inline(always)]
fn turn_back(rest: f64, quarters: u64) -> (f64, f64) {
    let square = rest * rest;
    let series =
        |c: &[f64; 6]| c[0] + square * (c[1] + square * (c[2] + square * (c[3] + square * (c[4] + square * c[5]))));
    let sin = rest + rest * square * series(&SIN);
    let cos = (1.0 - 0.5 * square) + square * square * series(&COS);
    // Odd quarters exchange sine and cosine; bit masks, since a branch would stop the vectorizer.
    let odd = 0u64.wrapping_sub(quarters & 1);
    let exchanged = (sin.to_bits() ^ cos.to_bits()) & odd;
    let sin_sign = (quarters & 2) << 62;
    let cos_sign = (quarters.wrapping_add(1) & 2) << 62;
    (f64::from_bits(sin.to_bits() ^ exchanged ^ sin_sign), f64::from_bits(cos.to_bits() ^ exchanged ^ cos_sign))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fixed walk over 64-bit states; wide enough to reach every quadrant and many magnitudes.
    fn draws(count: usize) -> impl Iterator<Item = f64> {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        (0..count).map(move |_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
        })
    }

    #[test]
    fn radians_agree_with_libm_over_wide_ranges() {
        for scale in [1e-8, 0.5, 0.8, 4.0, 100.0, 3e4, 5e5] {
            for draw in draws(20_000) {
                let angle = f64::from((draw * scale) as f32);
                let (sin, cos) = sincos_radians(angle);
                let (sin_libm, cos_libm) = libm::sincos(angle);
                assert!((sin - sin_libm).abs() <= 3e-16 && (cos - cos_libm).abs() <= 3e-16, "{angle}");
            }
        }
    }

    #[test]
    fn degrees_agree_with_libm_of_the_exact_remainder() {
        for scale in [1e-6, 30.0, 90.0, 400.0, 1e5, 1e9] {
            for draw in draws(20_000) {
                let degrees = f64::from((draw * scale) as f32);
                let (sin, cos) = sincos_degrees(degrees);
                // `%` is exact in any precision, so libm gets the same angle within one turn.
                let (sin_libm, cos_libm) = libm::sincos((degrees % 360.0).to_radians());
                assert!((sin - sin_libm).abs() <= 1.2e-15 && (cos - cos_libm).abs() <= 1.2e-15, "{degrees}");
                assert!((sin * sin + cos * cos - 1.0).abs() < 1e-15, "{degrees}");
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        for (degrees, wanted) in [(0.0, (0.0, 1.0)), (90.0, (1.0, 0.0)), (-180.0, (0.0, -1.0)), (270.0, (-1.0, 0.0))] {
            for turns in [0.0, 360.0, -720.0, 360.0 * 4096.0] {
                assert_eq!(sincos_degrees(degrees + turns), wanted, "{degrees} + {turns}");
            }
        }
    }

    #[test]
    fn small_angles_keep_their_relative_precision() {
        for exponent in 1..30 {
            let degrees = libm::exp2(f64::from(-exponent));
            let wanted = libm::sin(degrees.to_radians());
            assert!((sincos_degrees(degrees).0 / wanted - 1.0).abs() < 5e-16, "{degrees}");
        }
    }
}
