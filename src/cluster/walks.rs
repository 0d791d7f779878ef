//! Vectors like those of captured motion, and shapes that try the tree. For tests.

use super::metric::Vector;

/// A stream of random numbers (splitmix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// 0 to 1.
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// Clips of smooth random walks around a few poses, with velocities and accelerations as the metric scales them.
pub(super) fn smooth(seed: u64, n: usize) -> Vec<Vector> {
    let mut random = Random(seed);
    let mut vectors = Vec::with_capacity(n);
    let poses: Vec<[f64; 15]> = (0..6).map(|_| std::array::from_fn(|_| random.unit() * 1.2)).collect();
    while vectors.len() < n {
        let pose = poses[random.below(6)];
        let drift: [[f64; 3]; 15] = std::array::from_fn(|_| std::array::from_fn(|_| random.unit()));
        for frame in 0..(60 + random.below(100)).min(n - vectors.len()) {
            let t = frame as f64 / 30.0;
            let mut vector = Vector::default();
            for (axis, [size, speed, phase]) in drift.iter().enumerate() {
                // A parabola swung to and fro is smooth enough, and needs no sine.
                let turn = (t * (0.3 + speed) + phase).fract() * 4.0 - 2.0;
                let (size, bow) = (size * 0.3, turn.abs());
                let place = pose[axis] + size * turn * (2.0 - bow);
                let lane = axis / 3 * 9 + axis % 3;
                vector.0[lane] = (place + random.unit() * 0.002) as f32;
                vector.0[lane + 3] = (size * (2.0 - 2.0 * bow) * 0.4 * (0.3 + speed) + random.unit() * 0.01) as f32;
                vector.0[lane + 6] = (-size * turn.signum() * 0.3 * (0.3 + speed) + random.unit() * 0.02) as f32;
            }
            vectors.push(vector);
        }
    }
    vectors
}

/// Points of a coarse grid: ties and duplicates abound.
pub(super) fn quantized(seed: u64, n: usize, dimensions: usize, steps: usize) -> Vec<Vector> {
    let mut random = Random(seed ^ 0xABCD);
    (0..n)
        .map(|_| {
            let mut vector = Vector::default();
            for d in 0..dimensions {
                vector.0[(d * 17 + 5) % 48] = random.below(steps) as f32;
            }
            vector
        })
        .collect()
}

/// Rings, lines, stars and grids with exactly or nearly equal gaps.
pub(super) fn shape(name: &str, n: usize) -> Vec<Vector> {
    let at = |x: f64, y: f64| {
        let mut vector = Vector::default();
        vector.0[0] = x as f32;
        vector.0[31] = y as f32;
        vector
    };
    (0..n)
        .map(|i| {
            let x = i as f64;
            match name {
                "line" => at(x, 0.0),
                "ring" => {
                    let angle = x / n as f64 * std::f64::consts::TAU;
                    at(40.0 * libm::cos(angle), 40.0 * libm::sin(angle))
                }
                "star" => {
                    let (angle, radius) = ((i % 5) as f64 * std::f64::consts::TAU / 5.0, (i / 5) as f64);
                    at(radius * libm::cos(angle), radius * libm::sin(angle))
                }
                "grid" => at((i % 16) as f64, (i / 16) as f64),
                _ => panic!("no shape {name}"),
            }
        })
        .collect()
}
