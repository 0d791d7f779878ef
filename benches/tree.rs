//! The cluster tree alone: canonical vectors in memory to merges. Where the time goes, and live items by level.
//!
//! `cargo bench --bench tree [-- COUNT|FILE.f32 ...] [--skin 2] [--growth 1.8] [--threads 2] [--plain] [--check] [--steps]`,
//! by default 20,000 and 100,000 vectors; a file holds rows of 48 little-endian floats. `--check` compares the merges with those
//! of the queue before it prints a time; `--steps` prints each step of each band. The data made here is a smooth walk
//! through a space of 8 + 37 directions of falling variance, stopped and started anew every few seconds, so that about
//! as many items are left at each level as among captured frames (FEASIBILITY 1).
#![expect(clippy::unwrap_used, reason = "benches")]

use clap::Parser;
use motionmill::cluster::banded::{Bands, Step, tree_in_bands};
use motionmill::cluster::{Merge, Settings, Vector, tree_by_queue};
use std::ops::ControlFlow;
use std::time::Instant;

#[derive(Parser)]
struct Options {
    /// Numbers of vectors, or files of them.
    vectors: Vec<String>,
    #[arg(long, default_value_t = Bands::default().skin)]
    skin: f64,
    #[arg(long, default_value_t = Bands::default().growth)]
    growth: f64,
    #[arg(long, default_value_t = 0)]
    threads: usize,
    #[arg(long)]
    plain: bool,
    #[arg(long)]
    check: bool,
    #[arg(long)]
    steps: bool,
    /// What cargo says to every bench.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let mut options = Options::parse();
    if options.vectors.is_empty() {
        options.vectors = vec!["20000".into(), "100000".into()];
    }
    rayon::ThreadPoolBuilder::new().num_threads(options.threads).build_global().unwrap();
    for argument in &options.vectors {
        let vectors = argument.parse().map_or_else(|_| read(argument), walk);
        let n = vectors.len();
        let reference = options.check.then(|| tree_by_queue(&vectors, &Settings::default()).unwrap());
        let (merges, seconds) = timed(vectors, &options);
        assert!(!merges.is_empty());
        if let Some(reference) = reference {
            assert_eq!(reference.len(), merges.len());
            for (at, (queue, bands)) in reference.iter().zip(&merges).enumerate() {
                assert_eq!(queue, bands, "merge {at}");
            }
            println!("all {} merges are those of the queue", merges.len());
        }
        let all: f64 = seconds.iter().sum();
        println!("{n} vectors: {all:.2} s, {:.0} a second, {} merges", n as f64 / all, merges.len());
        let [arrange, join, merge, order] = seconds;
        println!("  boxes {arrange:.2} s, join {join:.2} s, merges {merge:.2} s, their order {order:.2} s");
        let left = |level: f64| 100.0 - 100.0 * merges.iter().filter(|m| m.e < level).count() as f64 / n as f64;
        let shares = [1e-4, 1e-3, 5e-3, 0.02, 0.05, 0.1, 0.2].map(|e| format!("{:.1} % at {e}", left(e)));
        println!("  live: {}", shares.join(", "));
    }
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        println!("{}", status.lines().filter(|line| line.starts_with("VmHWM")).collect::<String>());
    }
}

/// The merges, and seconds that were spent on: order and boxes, join, merges, their order.
fn timed(vectors: Vec<Vector>, options: &Options) -> (Vec<Merge>, [f64; 4]) {
    let bands = Bands { growth: options.growth, skin: options.skin, plain: options.plain, ..Default::default() };
    let mut seconds = [0.0; 4];
    let mut since = Instant::now();
    let mut tell = |step| {
        let kind = match step {
            Step::Arranged { .. } => 0,
            Step::Joined { .. } => 1,
            Step::Merged { .. } => 2,
            Step::Ordered { .. } => 3,
        };
        let spent = since.elapsed().as_secs_f64();
        seconds[kind] += spent;
        if options.steps {
            println!("  {spent:7.3} s {step:?}");
        }
        since = Instant::now();
        ControlFlow::Continue(())
    };
    let merges = tree_in_bands(vectors, &Settings::default(), &bands, &mut tell).unwrap();
    (merges, seconds)
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
