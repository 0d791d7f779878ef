//! A second-order Butterworth low-pass, run forwards and backwards so that nothing is delayed.
//!
//! Both ends are padded oddly (point reflection) by up to one second, and each run starts in the state that a
//! constant input would have left (GRAFTS 2: "every low-pass").

use glam::DVec3;

/// One second-order section, direct form II transposed, of unit gain at 0 Hz.
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// The low-passed signal, as long as `signal`.
///
/// `cutoff_hz` is where each of the two runs has -3 dB; it is kept below 0.95 of half the rate. `rate_hz` > 0.
pub fn lowpass(signal: &[f64], cutoff_hz: f64, rate_hz: f64) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (signal.first(), signal.last()) else {
        return Vec::new();
    };
    let section = Section::new((cutoff_hz / (rate_hz / 2.0)).min(0.95));
    let pad = (signal.len() - 1).min(rate_hz as usize);
    let mut run: Vec<f64> = signal[1..=pad].iter().rev().map(|value| 2.0 * first - value).collect();
    run.extend_from_slice(signal);
    run.extend(signal[signal.len() - 1 - pad..signal.len() - 1].iter().rev().map(|value| 2.0 * last - value));
    section.run(run.iter_mut());
    section.run(run.iter_mut().rev());
    run.drain(..pad);
    run.truncate(signal.len());
    run
}

/// The low-passed path of a point, each coordinate on its own.
pub fn lowpass_points(path: &[DVec3], cutoff_hz: f64, rate_hz: f64) -> Vec<DVec3> {
    let [x, y, z] =
        [0, 1, 2].map(|axis| lowpass(&path.iter().map(|point| point[axis]).collect::<Vec<_>>(), cutoff_hz, rate_hz));
    (0..path.len()).map(|frame| DVec3::new(x[frame], y[frame], z[frame])).collect()
}

impl Section {
    /// `cutoff`: as a share of half the rate, in 0..1. By the bilinear transform, prewarped.
    fn new(cutoff: f64) -> Section {
        let warped = libm::tan(core::f64::consts::FRAC_PI_2 * cutoff);
        let square = warped * warped;
        let damping = core::f64::consts::SQRT_2 * warped;
        let scale = 1.0 / (1.0 + damping + square);
        Section {
            b: [square * scale, 2.0 * square * scale, square * scale],
            a: [2.0 * (square - 1.0) * scale, (1.0 - damping + square) * scale],
        }
    }

    /// Replaces the values, in the order given, by what the section makes of them.
    fn run<'a>(&self, values: impl Iterator<Item = &'a mut f64>) {
        let mut values = values.peekable();
        let Some(start) = values.peek().map(|value| **value) else {
            return;
        };
        // The state that an endless `start` leaves: output equals input.
        let mut second = (self.b[2] - self.a[1]) * start;
        let mut first = (self.b[1] - self.a[0]) * start + second;
        for value in values {
            let input = *value;
            let output = self.b[0] * input + first;
            first = self.b[1] * input - self.a[0] * output + second;
            second = self.b[2] * input - self.a[1] * output;
            *value = output;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::saw;
    use super::*;

    /// Made once with scipy 1.17: `sosfiltfilt(butter(2, min(hertz / (rate / 2), 0.95), output="sos"), saw(n),
    /// padlen=min(n - 1, int(rate)))` at 0, 1, n / 2, n - 2, n - 1.
    #[test]
    fn it_equals_scipy() {
        let golden: [(usize, f64, f64, [f64; 5]); 4] = [
            (
                40,
                4.0,
                30.0,
                [
                    -0.40000000056531987,
                    -0.29527396463551847,
                    0.2969914921572775,
                    0.35518057286011256,
                    0.2158064488408474,
                ],
            ),
            (
                200,
                0.7,
                120.0,
                [-0.4084251703791214, -0.3871232457383096, 1.0457529350147476, 2.014733142403123, 2.0252327937905914],
            ),
            (
                12,
                20.0,
                30.0,
                [
                    -0.3917211796202203,
                    -0.07639384703863365,
                    0.3759884793091623,
                    0.24387883047316783,
                    0.10557206437232049,
                ],
            ),
            (
                90,
                0.35,
                30000.0 / 1001.0,
                [-0.4180556249062989, -0.3833678669061918, 0.5183853867977052, 0.7230713069745303, 0.7211612121202956],
            ),
        ];
        for (length, cutoff, rate, expected) in golden {
            let got = lowpass(&saw(length), cutoff, rate);
            assert_eq!(got.len(), length);
            for (frame, expected) in [0, 1, length / 2, length - 2, length - 1].into_iter().zip(expected) {
                assert!((got[frame] - expected).abs() < 1e-11, "{length} {frame}: {} {expected}", got[frame]);
            }
        }
    }

    #[test]
    fn constants_and_long_lines_pass() {
        for length in [1, 2, 31, 200] {
            assert!(lowpass(&vec![5.0; length], 4.0, 120.0).iter().all(|value| (value - 5.0).abs() < 1e-9));
        }
        let line: Vec<f64> = (0..400).map(|k| 3.0 + 0.25 * f64::from(k)).collect();
        assert!(lowpass(&line, 4.0, 120.0).iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!(lowpass(&[], 4.0, 30.0).is_empty());
    }
}
