//! How fast files become motion, beside a bare digit loop over the same bytes and, for BVH, beside the crate bvh_anim.
//!
//! The bare loop does nothing but turn digits into `f32`s: no counts, no names, no check that a number ends where
//! it should. All run in turn over files held in memory, after their values have been compared, so what is
//! isolated is the cost of checking. One core.
//!
//!     cargo bench --bench parsing                    a sample of target/data
//!     cargo bench --bench parsing -- FILE ...        these .bvh and .amc files
#![expect(clippy::unwrap_used, reason = "a bench")]

use motionmill::formats::{AsfSkeleton, ReadOptions, read_amc, read_asf, read_bvh, write_amc, write_bvh};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

const ROUNDS: usize = 15;

struct File {
    bytes: Vec<u8>,
    /// Of an AMC file.
    skeleton: Option<AsfSkeleton>,
}

fn main() {
    let arguments: Vec<PathBuf> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).map(PathBuf::from).collect();
    let files = if arguments.is_empty() { sample() } else { arguments };
    let of = |extension: &str| -> Vec<File> {
        files
            .iter()
            .filter(|file| file.extension().is_some_and(|found| found == extension))
            .map(|file| load(file))
            .collect()
    };
    println!(
        "{:<6} {:>6} {:>8} {:>12} {:>10} {:>11} {:>7} {:>14} {:>7} {:>12}",
        "", "files", "MB", "parse MB/s", "frames/s", "bare MB/s", "ratio", "bvh_anim MB/s", "ratio", "write MB/s"
    );
    for (name, files) in [("BVH", of("bvh")), ("AMC", of("amc"))] {
        if !files.is_empty() {
            compare(name, &files);
        }
    }
}

/// A part of the shared captures.
fn sample() -> Vec<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/data");
    let mut files = list(&data.join("bandai-namco")).into_iter().step_by(20).collect::<Vec<_>>();
    files.extend(list(&data.join("cmu")));
    assert!(!files.is_empty(), "no captures in {}; name some files", data.display());
    files
}

/// All files below a folder, sorted.
fn list(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(list(&path));
        } else if path.extension().is_some_and(|found| found == "bvh" || found == "amc") {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn load(path: &Path) -> File {
    let bytes = std::fs::read(path).unwrap();
    let is_amc = path.extension().is_some_and(|found| found == "amc");
    let skeleton = is_amc.then(|| {
        let stem = path.file_stem().unwrap().to_str().unwrap();
        let skeleton = path.with_file_name(format!("{}.asf", stem.split('_').next().unwrap()));
        read_asf(&std::fs::read(skeleton).unwrap(), &ReadOptions::default()).unwrap().value
    });
    File { bytes, skeleton }
}

fn parse(file: &File) -> Vec<f32> {
    match &file.skeleton {
        None => read_bvh(&file.bytes, &ReadOptions::default()).unwrap().value.channels,
        Some(skeleton) => read_amc(&file.bytes, skeleton, &ReadOptions::default()).unwrap().value.channels,
    }
}

fn n_frames(file: &File) -> usize {
    match &file.skeleton {
        None => read_bvh(&file.bytes, &ReadOptions::default()).unwrap().value.n_frames,
        Some(skeleton) => read_amc(&file.bytes, skeleton, &ReadOptions::default()).unwrap().value.n_frames,
    }
}

fn write(file: &File) -> usize {
    match &file.skeleton {
        None => {
            let motion = read_bvh(&file.bytes, &ReadOptions::default()).unwrap().value;
            let started = Instant::now();
            black_box(write_bvh(&motion.skeleton, Some(&motion.header), 0.1, &motion.channels).unwrap());
            started.elapsed().as_nanos() as usize
        }
        Some(skeleton) => {
            let motion = read_amc(&file.bytes, skeleton, &ReadOptions::default()).unwrap().value;
            let started = Instant::now();
            black_box(write_amc(&motion.skeleton, &motion.channels, None, 1).unwrap());
            started.elapsed().as_nanos() as usize
        }
    }
}

/// The values as the crate bvh_anim reads them.
fn peer(file: &File) -> Vec<f32> {
    let motion = bvh_anim::from_bytes(&file.bytes).unwrap();
    motion.frames().flat_map(|frame| frame.as_slice().iter().copied()).collect()
}

fn compare(name: &str, files: &[File]) {
    let megabytes = files.iter().map(|file| file.bytes.len()).sum::<usize>() as f64 / 1e6;
    let mut frames = 0;
    let has_peer = files.iter().all(|file| file.skeleton.is_none());
    for file in files {
        let (ours, theirs) = (parse(file), bare(file));
        assert!(!ours.is_empty());
        assert_eq!(ours.len(), theirs.len());
        // AMC lines come in another order than joints; a frame's numbers are the same.
        let digest = |values: &[f32]| values.iter().fold(0_u64, |sum, value| sum + u64::from(value.to_bits()));
        assert_eq!(digest(&ours), digest(&theirs));
        frames += n_frames(file);
        if has_peer {
            // It rounds to f32 in its own way.
            let theirs = peer(file);
            assert_eq!(ours.len(), theirs.len());
            assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() <= 1e-6 * a.abs().max(1e-3)));
        }
    }
    let seconds = |work: &dyn Fn(&File) -> Vec<f32>| {
        let started = Instant::now();
        for file in files {
            black_box(work(black_box(file)));
        }
        started.elapsed().as_secs_f64()
    };
    let rounds: Vec<[f64; 3]> = (0..ROUNDS)
        .map(|_| [seconds(&parse), seconds(&bare), if has_peer { seconds(&peer) } else { f64::NAN }])
        .collect();
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let [parse_s, bare_s, peer_s] = [0, 1, 2].map(|n| median(rounds.iter().map(|round| round[n]).collect()));
    let [of_bare, of_peer] = [1, 2].map(|n| median(rounds.iter().map(|round| round[n] / round[0]).collect()));
    let written = megabytes / (files.iter().map(write).sum::<usize>() as f64 / 1e9);
    let (parsed, bare) = (megabytes / parse_s, megabytes / bare_s);
    let or_none = |text: String| if has_peer { text } else { "-".to_owned() };
    let (peer, of_peer) = (or_none(format!("{:.0}", megabytes / peer_s)), or_none(format!("{of_peer:.2}")));
    println!(
        "{name:<6} {:>6} {megabytes:>8.1} {parsed:>12.0} {:>10.0} {bare:>11.0} {of_bare:>7.2} {peer:>14} {of_peer:>7} {written:>12.0}",
        files.len(),
        frames as f64 / parse_s
    );
}

/// Every number of the motion, trusting the file.
fn bare(file: &File) -> Vec<f32> {
    match file.skeleton {
        None => {
            let key = b"Frame Time:";
            let from = file.bytes.windows(key.len()).position(|word| word == key).unwrap() + key.len();
            let rows = file.bytes[from..].iter().position(|&byte| byte == b'\n').unwrap();
            bare_rows(&file.bytes[from + rows..])
        }
        Some(_) => bare_lines(&file.bytes),
    }
}

fn bare_rows(bytes: &[u8]) -> Vec<f32> {
    let mut values = Vec::with_capacity(bytes.len() / 8);
    let mut at = 0;
    while at < bytes.len() {
        if bytes[at] <= b' ' {
            at += 1;
            continue;
        }
        values.push(bare_number(bytes, &mut at));
    }
    values
}

fn bare_lines(bytes: &[u8]) -> Vec<f32> {
    let mut values = Vec::with_capacity(bytes.len() / 8);
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            0..=b' ' => at += 1,
            b'a'..=b'z' => {
                while bytes[at] > b' ' {
                    at += 1;
                }
                while at < bytes.len() && bytes[at] != b'\n' {
                    if bytes[at] <= b' ' {
                        at += 1;
                    } else {
                        values.push(bare_number(bytes, &mut at));
                    }
                }
            }
            _ => {
                while at < bytes.len() && bytes[at] != b'\n' {
                    at += 1;
                }
            }
        }
    }
    values
}

#[inline(always)]
fn bare_number(bytes: &[u8], at: &mut usize) -> f32 {
    const POWERS: [f64; 23] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19,
        1e20, 1e21, 1e22,
    ];
    let mut i = *at;
    let negative = bytes[i] == b'-';
    i += usize::from(negative);
    let mut mantissa = 0_u64;
    let mut decimals = 0;
    while i < bytes.len() && bytes[i].is_ascii_digit() {
        mantissa = mantissa * 10 + u64::from(bytes[i] - b'0');
        i += 1;
    }
    if i < bytes.len() && bytes[i] == b'.' {
        i += 1;
        let from = i;
        while i < bytes.len() && bytes[i].is_ascii_digit() {
            mantissa = mantissa * 10 + u64::from(bytes[i] - b'0');
            i += 1;
        }
        decimals = i - from;
    }
    let mut value = mantissa as f64 / POWERS[decimals];
    if i < bytes.len() && bytes[i] == b'e' {
        while i < bytes.len() && bytes[i] > b' ' {
            i += 1;
        }
        value = std::str::from_utf8(&bytes[*at..i]).unwrap().parse::<f64>().unwrap().abs();
    }
    *at = i;
    (if negative { -value } else { value }) as f32
}
