//! The cluster tree alone: canonical vectors in memory to merges. Frames per second and live items by level.
//!
//! `cargo bench --bench tree [-- COUNT ...]`, by default 20,000 and 100,000 vectors; `-- FILE.f32` reads rows of 48
//! little-endian floats instead. The data made here is a smooth walk through a space of 8 + 37 directions of
//! falling variance, stopped and started anew every few seconds, so that about as many items are left at each
//! level as among captured frames (FEASIBILITY 1).
#![expect(clippy::unwrap_used, reason = "benches")]

use motionmill::cluster::{Settings, Vector, tree};
use std::time::Instant;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let arguments = if arguments.is_empty() { vec!["20000".into(), "100000".into()] } else { arguments };
    for argument in arguments {
        let vectors = argument.parse().map_or_else(|_| read(&argument), walk);
        let start = Instant::now();
        let merges = tree(&vectors, &Settings::default()).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        assert!(!merges.is_empty());
        let n = vectors.len();
        println!("{n} vectors: {seconds:.2} s, {:.0} a second, {} merges", n as f64 / seconds, merges.len());
        let left = |level: f64| 100.0 - 100.0 * merges.iter().filter(|m| m.e < level).count() as f64 / n as f64;
        let shares = [1e-4, 1e-3, 5e-3, 0.02, 0.05, 0.1, 0.2].map(|e| format!("{:.1} % at {e}", left(e)));
        println!("  live: {}", shares.join(", "));
    }
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        println!("{}", status.lines().filter(|line| line.starts_with("VmHWM")).collect::<String>());
    }
}

fn read(file: &str) -> Vec<Vector> {
    let bytes = std::fs::read(file).unwrap();
    let row = |row: &[u8; 192]| Vector(std::array::from_fn(|i| f32::from_le_bytes(row.as_chunks::<4>().0[i])));
    bytes.as_chunks::<192>().0.iter().map(row).collect()
}

/// A second-order walk, pulled back to the middle.
fn walk(n: usize) -> Vec<Vector> {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut z = state ^ (state >> 31);
        z = z.wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((z >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 3.46
    };
    // Directions: sums and differences of coordinates, each with its size.
    let mixing: Vec<[f64; 45]> = (0..45).map(|_| std::array::from_fn(|_| random() / 6.7)).collect();
    let size: Vec<f64> = (0..45).map(|k| 0.36 * libm::pow(0.80, k as f64)).collect();
    let mut place = [0.0; 45];
    let mut speed = [0.0; 45];
    (0..n)
        .map(|frame| {
            for k in 0..45 {
                if frame % 135 == 0 {
                    (place[k], speed[k]) = (random(), random() * 0.1);
                }
                speed[k] += random() * 0.02 - place[k] * 0.02 - speed[k] * 0.02;
                place[k] += speed[k];
            }
            let mut vector = Vector::default();
            for k in 0..45 {
                for (x, share) in vector.0.iter_mut().zip(&mixing[k]) {
                    *x += (place[k] * size[k] * share) as f32;
                }
            }
            vector
        })
        .collect()
}
