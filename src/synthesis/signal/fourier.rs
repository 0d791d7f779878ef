//! The discrete Fourier transform of any length, and what is made of it: spectrum and analytic signal.
//!
//! Ours rather than a crate's: those take sines from the platform and choose instructions by processor, so their bits
//! differ from machine to machine (DESIGN 3).

use core::f64::consts::PI;
use core::ops::{Add, Mul, Sub};

/// A complex number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

/// Absolute values of the Fourier transform at 0, 1 ... `length / 2` cycles per `length` samples.
///
/// The signal is padded with zeros, or cut, to `length`, a power of two.
pub fn spectrum(signal: &[f64], length: usize) -> Vec<f64> {
    debug_assert!(length.is_power_of_two(), "a power of two");
    let mut values: Vec<Complex> = signal.iter().take(length).map(|&re| Complex { re, im: 0.0 }).collect();
    values.resize(length, Complex::default());
    Radix2::new(length).forward(&mut values);
    values[..=length / 2].iter().map(|value| value.norm()).collect()
}

/// The analytic signal: `signal` plus i times its Hilbert transform, taken over the whole (periodic) length.
pub fn analytic(signal: &[f64]) -> Vec<Complex> {
    let n = signal.len();
    if n == 0 {
        return Vec::new();
    }
    let transform = Bluestein::new(n);
    let mut values = transform.forward(&signal.iter().map(|&re| Complex { re, im: 0.0 }).collect::<Vec<_>>());
    // Positive frequencies twice, negative ones not at all; 0 and half the rate once.
    for value in &mut values[1..n.div_ceil(2)] {
        *value = value.scaled(2.0);
    }
    for value in &mut values[n / 2 + 1..] {
        *value = Complex::default();
    }
    // The inverse transform is the conjugate of the transform of the conjugate.
    let conjugates: Vec<Complex> = values.into_iter().map(Complex::conjugate).collect();
    transform.forward(&conjugates).into_iter().map(|value| value.conjugate().scaled(1.0 / n as f64)).collect()
}

/// Transform of a power-of-two length, in place.
struct Radix2 {
    /// exp(-2 pi i k / n), k < n / 2.
    turns: Vec<Complex>,
}

/// Transform of any length as a convolution with a chirp (Bluestein).
struct Bluestein {
    /// exp(-pi i k^2 / n).
    chirp: Vec<Complex>,
    /// Transform of the conjugate chirp, mirrored.
    kernel: Vec<Complex>,
    inner: Radix2,
}

impl Radix2 {
    fn new(length: usize) -> Radix2 {
        let turns = (0..length / 2).map(|k| Complex::turn(-2.0 * PI * k as f64 / length as f64)).collect();
        Radix2 { turns }
    }

    fn forward(&self, values: &mut [Complex]) {
        let n = values.len();
        if n < 2 {
            return;
        }
        let bits = n.trailing_zeros();
        for k in 0..n {
            let mirrored = k.reverse_bits() >> (usize::BITS - bits);
            if k < mirrored {
                values.swap(k, mirrored);
            }
        }
        let mut half = 1;
        while half < n {
            let stride = n / (2 * half);
            for block in values.chunks_exact_mut(2 * half) {
                let (low, high) = block.split_at_mut(half);
                for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                    let turned = *b * self.turns[k * stride];
                    (*a, *b) = (*a + turned, *a - turned);
                }
            }
            half *= 2;
        }
    }
}

impl Bluestein {
    fn new(n: usize) -> Bluestein {
        let length = (2 * n - 1).next_power_of_two();
        // k^2 modulo 2 n first: the angle stays small and exact.
        let square = |k: usize| ((k as u128 * k as u128) % (2 * n as u128)) as f64;
        let chirp: Vec<Complex> = (0..n).map(|k| Complex::turn(-PI * square(k) / n as f64)).collect();
        let mut kernel = vec![Complex::default(); length];
        for (k, value) in chirp.iter().enumerate() {
            kernel[k] = value.conjugate();
            kernel[(length - k) % length] = value.conjugate();
        }
        let inner = Radix2::new(length);
        inner.forward(&mut kernel);
        Bluestein { chirp, kernel, inner }
    }

    fn forward(&self, values: &[Complex]) -> Vec<Complex> {
        let length = self.kernel.len();
        let mut product = vec![Complex::default(); length];
        for ((slot, &value), &chirp) in product.iter_mut().zip(values).zip(&self.chirp) {
            *slot = value * chirp;
        }
        self.inner.forward(&mut product);
        for (value, &kernel) in product.iter_mut().zip(&self.kernel) {
            *value = (*value * kernel).conjugate();
        }
        self.inner.forward(&mut product);
        let scale = 1.0 / length as f64;
        product.iter().zip(&self.chirp).map(|(value, &chirp)| value.conjugate().scaled(scale) * chirp).collect()
    }
}

impl Complex {
    /// Of length 1 at that angle.
    pub fn turn(angle_rad: f64) -> Complex {
        let (im, re) = libm::sincos(angle_rad);
        Complex { re, im }
    }

    /// Length.
    pub fn norm(self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// In (-pi, pi].
    pub fn angle_rad(self) -> f64 {
        libm::atan2(self.im, self.re)
    }

    fn conjugate(self) -> Complex {
        Complex { re: self.re, im: -self.im }
    }

    fn scaled(self, factor: f64) -> Complex {
        Complex { re: self.re * factor, im: self.im * factor }
    }
}

impl Add for Complex {
    type Output = Complex;

    fn add(self, other: Complex) -> Complex {
        Complex { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Complex;

    fn sub(self, other: Complex) -> Complex {
        Complex { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Complex;

    fn mul(self, other: Complex) -> Complex {
        Complex { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

#[cfg(test)]
mod tests {
    use super::super::saw;
    use super::*;

    /// Made once with scipy 1.17: `hilbert(saw(n))` at 0, n / 2, n - 1.
    #[test]
    fn the_analytic_signal_equals_scipy() {
        let golden = [
            (8, [[-0.4, 0.27134471428465273], [-0.36, 0.05510689861857311], [0.4119354838709677, 0.4565911880626942]]),
            (
                15,
                [
                    [-0.4000000000000001, 0.38001186703409334],
                    [0.41193548387096773, 0.05087440473397407],
                    [0.35290322580645167, 0.4325039817412986],
                ],
            ),
            (
                37,
                [
                    [-0.4000000000000001, 0.2305811164043126],
                    [0.6832258064516129, 0.17679444579185014],
                    [0.0890322580645161, 0.3584947764418604],
                ],
            ),
        ];
        for (n, expected) in golden {
            let got = analytic(&saw(n));
            for (k, [re, im]) in [0, n / 2, n - 1].into_iter().zip(expected) {
                assert!((got[k] - Complex { re, im }).norm() < 1e-13, "{n} {k}: {:?}", got[k]);
            }
        }
        assert!(analytic(&[]).is_empty());
        assert_eq!(analytic(&[2.5]), [Complex { re: 2.5, im: 0.0 }]);
    }

    #[test]
    fn both_transforms_equal_the_plain_sum() {
        for n in [1, 2, 3, 16, 17, 100] {
            let values: Vec<Complex> =
                saw(n).into_iter().zip(saw(n + 1).into_iter().skip(1)).map(|(re, im)| Complex { re, im }).collect();
            let plain: Vec<Complex> = (0..n)
                .map(|k| {
                    values.iter().enumerate().fold(Complex::default(), |sum, (j, &value)| {
                        sum + value * Complex::turn(-2.0 * PI * ((j * k) % n) as f64 / n as f64)
                    })
                })
                .collect();
            let close = |got: &[Complex]| got.iter().zip(&plain).all(|(&a, &b)| (a - b).norm() < 1e-11);
            assert!(close(&Bluestein::new(n).forward(&values)), "Bluestein {n}");
            if n.is_power_of_two() {
                let mut got = values.clone();
                Radix2::new(n).forward(&mut got);
                assert!(close(&got), "radix 2, {n}");
            }
        }
    }

    #[test]
    fn the_spectrum_finds_a_tone() {
        let tone: Vec<f64> = (0..300).map(|k| libm::sin(2.0 * PI * 5.0 * k as f64 / 64.0)).collect();
        let heights = spectrum(&tone, 64);
        assert_eq!(heights.len(), 33);
        let top = (0..33).max_by(|&a, &b| heights[a].total_cmp(&heights[b]));
        assert_eq!(top, Some(5));
        assert!((heights[5] - 32.0).abs() < 1e-10);
    }
}
