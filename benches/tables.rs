//! What a shard's tables cost: MB of BVH text a second and bytes a byte of text, for the corpus' settings and others.
//!
//! Times are processor seconds of the one thread that works, where the system tells (Linux), so that waiting for
//! neighbors doesn't show (sharing a core with them does); wall seconds elsewhere. Isolated: parsing is outside the clock; writing, compressing, hashing and syncing files are inside (set TMPDIR to
//! a memory file system to leave the disk out). `cargo bench --bench tables -- [FOLDER OF BVH FILES] [MB OF TEXT] [ONLY THIS ROW]`;
//! without a folder a made-up clip of the same shape is written.
#![expect(clippy::unwrap_used, reason = "a bench")]
#![allow(missing_docs, reason = "a bench")]

use glam::DVec3;
use motionmill::annotate::{FrameLabels, Gait, PlantState};
use motionmill::corpus::{
    ClipFormat, ClipRow, ClipTables, Compressing, Origin, ShardId, ShardRecord, ShardSettings, ShardWriter,
    SkeletonRow, Store, Table,
};
use motionmill::motion::skeleton::{AngleUnit, PositionRule};
use motionmill::motion::{
    Axis, Channel, ChannelKind, Clip, Format, Joint, Poses, RoleMap, Skeleton, UpAxis, kinematics,
};
use std::path::Path;
use std::sync::Arc;

/// Runs under one reading of the clock: the system counts a thread's time in ticks of some 4 ms, longer than is
/// small beside one run.
const RUNS: usize = 12;
/// Readings, of which the median counts.
const ROUNDS: usize = 5;

fn main() {
    // `cargo test --benches` and `cargo bench` pass flags of their own.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let megabytes: usize = arguments.get(1).map_or(20, |number| number.parse().unwrap());
    let (clips, text_bytes) = match arguments.first() {
        Some(folder) => read_folder(Path::new(folder), megabytes << 20),
        None => made_up(),
    };
    let frames: usize = clips.iter().map(|clip| clip.n_frames).sum();
    let channels = clips[0].skeleton.n_channels();
    println!(
        "{} clips, {frames} frames of {channels} channels, {:.1} MB of text",
        clips.len(),
        text_bytes as f64 / 1e6
    );

    println!("\n{:<58} {:>10} {:>8} {:>9}", "channels", "bytes/text", "MB/s", "read MB/s");
    let ours = Compressing::default();
    for (name, how) in [
        ("ours", ours),
        ("zstd 3", Compressing { zstd_level: Some(3), ..ours }),
        ("floats plain", Compressing { split_floats: false, ..ours }),
        ("dictionary everywhere", Compressing { dictionary_everywhere: true, ..ours }),
        (
            "floats plain, dictionary everywhere (the crate's default)",
            Compressing { dictionary_everywhere: true, split_floats: false, delta_integers: false, ..ours },
        ),
        ("whole numbers plain", Compressing { delta_integers: false, ..ours }),
        ("statistics a row group only", Compressing { page_statistics: false, ..ours }),
        ("pages of 4,096 rows", Compressing { page_rows: 4096, ..ours }),
        ("pages of 102,400 rows", Compressing { page_rows: 102_400, ..ours }),
        ("no compression, plain", Compressing { zstd_level: None, split_floats: false, ..ours }),
    ] {
        if arguments.get(2).is_some_and(|only| only != name) {
            continue;
        }
        let (bytes, seconds, read) = measure(Table::Channels, how, &clips, |clip, tables| {
            tables.channels = Some(&clip.0.channels);
        });
        println!(
            "{name:<58} {:>10.4} {:>8.0} {:>9.0}",
            bytes as f64 / text_bytes as f64,
            text_bytes as f64 / seconds / 1e6,
            text_bytes as f64 / read / 1e6
        );
    }

    println!("\n{:<58} {:>10} {:>8}", "other tables, ours", "bytes/text", "MB/s");
    for table in [Table::Poses, Table::Annotations] {
        if arguments.get(2).is_some_and(|only| only != table.name()) {
            continue;
        }
        let (bytes, seconds, _) = measure(table, ours, &clips, |clip, tables| {
            tables.poses = Some(&clip.1);
            tables.labels = Some(&clip.2);
        });
        let text = text_bytes as f64;
        println!("{:<58} {:>10.4} {:>8.0}", table.name(), bytes as f64 / text, text / seconds / 1e6);
    }
}

/// Bytes of the table, and the times of writing it and of reading all clips of it back (channels only).
fn measure(
    table: Table,
    compressing: Compressing,
    clips: &[Clip],
    give: impl for<'a> Fn(&'a (&'a Clip, Poses, FrameLabels), &mut ClipTables<'a>),
) -> (u64, f64, f64) {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::new(folder.path());
    let roles = RoleMap::default();
    let clips: Vec<(&Clip, Poses, FrameLabels)> = clips
        .iter()
        .map(|clip| match table {
            Table::Poses => (clip, kinematics::poses(clip), FrameLabels::default()),
            Table::Annotations => {
                let labels = labels(&kinematics::poses(clip), clip.rate_hz);
                (clip, Poses { n_frames: 0, n_points: 0, world: Vec::new() }, labels)
            }
            _ => (clip, Poses { n_frames: 0, n_points: 0, world: Vec::new() }, FrameLabels::default()),
        })
        .collect();
    let settings = ShardSettings { tables: vec![table], compressing, ..ShardSettings::default() };
    let write = || {
        let mut writer = ShardWriter::create(&store, ShardId::captured(0), settings.clone());
        for (at, clip) in clips.iter().enumerate() {
            let mut tables = ClipTables {
                clip_id: at as u32,
                n_frames: clip.0.n_frames,
                rate_hz: clip.0.rate_hz,
                skeleton: &clip.0.skeleton,
                roles: &roles,
                channels: None,
                poses: None,
                rotations: None,
                labels: None,
                features: None,
                plants: &[],
                segments: &[],
                provenance: &[],
            };
            give(clip, &mut tables);
            writer.push(&tables).unwrap();
        }
        writer.finish().unwrap()
    };
    let finished = write();
    let files = finished.files();
    let bytes = files.iter().map(|file| file.bytes).sum();
    let frames: usize = clips.iter().map(|clip| clip.0.n_frames).sum();
    assert_eq!(files.iter().map(|file| file.rows).sum::<u64>(), frames as u64);
    let write_s = seconds_a_run(|| drop(write()));
    if table != Table::Channels {
        return (bytes, write_s, f64::NAN);
    }
    // The runs wrote under the same temporary names: once more, and for good.
    drop(finished);
    let mut record = ShardRecord::new(ShardId::captured(0));
    record.keys.ingest = "bench".to_owned();
    record.clips = clips.iter().enumerate().map(|(at, clip)| row(at as u32, clip.0)).collect();
    record.skeletons = vec![skeleton_row(clips[0].0)];
    let record = write().commit(record).unwrap();
    let reader = motionmill::corpus::ShardReader::new(&store, &record);
    let read_s = seconds_a_run(|| {
        let mut all = clips.iter();
        for clip in reader.all_channels(&clips[0].0.skeleton.layout_id()).unwrap() {
            assert!(clip.unwrap().1 == all.next().unwrap().0.channels);
        }
        assert!(all.next().is_none());
    });
    (bytes, write_s, read_s)
}

/// Seconds that one run takes: the median of some readings over many runs each.
fn seconds_a_run(mut run: impl FnMut()) -> f64 {
    let mut readings: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = now();
            (0..RUNS).for_each(|_| run());
            (now() - start) / RUNS as f64
        })
        .collect();
    readings.sort_by(f64::total_cmp);
    readings[ROUNDS / 2]
}

/// Seconds that this thread has run, else that have passed.
fn now() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    let ran = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let ran = ran.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    let passed = || START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64();
    ran.map_or_else(passed, |nanoseconds| nanoseconds * 1e-9)
}

fn row(clip_id: u32, clip: &Clip) -> ClipRow {
    ClipRow {
        clip_id,
        name: format!("{clip_id}"),
        source: "bench".to_owned(),
        format: ClipFormat::Bvh,
        layout: clip.skeleton.layout_id(),
        skeleton: "S".to_owned(),
        subject: None,
        frames: clip.n_frames as u32,
        rate_hz: clip.rate_hz,
        frame_time_s: None,
        duration_s: clip.duration_s(),
        unit_m: clip.unit_m,
        max_rounding: 0.0,
        licenses: Vec::new(),
        attribution: None,
        may_share: None,
        may_sell: None,
        origin: Origin::Captured,
        parents: Vec::new(),
        recipe: None,
        labels: Default::default(),
        warnings: 0,
        up_axis: UpAxis::Y,
    }
}

fn skeleton_row(clip: &Clip) -> SkeletonRow {
    SkeletonRow {
        skeleton_id: "S".to_owned(),
        first_clip: [String::new(), String::new()],
        body: (*clip.skeleton).clone(),
        roles: RoleMap::default(),
        header: String::new(),
    }
}

/// Labels with the texture of real ones: smooth numbers from the poses, states in runs.
fn labels(poses: &Poses, rate_hz: f64) -> FrameLabels {
    let n = poses.n_frames;
    let height = |point: usize| (0..n).map(|frame| Some(poses.at(frame, point).y as f32)).collect::<Vec<_>>();
    let down = |point: usize| (0..n).map(|frame| Some(poses.at(frame, point).y < 0.1)).collect::<Vec<_>>();
    let points = [0, 1, 2, 3].map(|k| poses.n_points - 1 - k);
    FrameLabels {
        time_s: (0..n).map(|frame| frame as f64 / rate_hz).collect(),
        root: (0..n).map(|frame| poses.at(frame, 0).as_vec3().to_array()).collect(),
        heading: height(points[0]),
        speed: (0..n).map(|frame| poses.at(frame, 0).x as f32).collect(),
        turn_rate: height(points[1]),
        heights: points.map(height),
        speeds: points.map(height),
        stance: [down(points[0]), down(points[1])],
        pinned: [down(points[2]), down(points[3])],
        plant_state: (0..n).map(|frame| Some(PlantState::ALL[frame / 12 % 7])).collect(),
        gait: (0..n).map(|frame| Some(if frame % 300 < 200 { Gait::Walk } else { Gait::Stand })).collect(),
        gait_confidence: vec![Some(0.9); n],
        phase: (0..n).map(|frame| Some((frame % 30) as f32 / 30.0)).collect(),
        diagnostics: None,
    }
}

/// Whole BVH files of a folder, by name, up to so many bytes of text.
fn read_folder(folder: &Path, bytes: usize) -> (Vec<Clip>, usize) {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "bvh"));
    files.sort();
    let (mut clips, mut read): (Vec<Clip>, usize) = (Vec::new(), 0);
    for file in files {
        if read >= bytes {
            break;
        }
        let text = std::fs::read_to_string(file).unwrap();
        let clip = parse(&text);
        if clips.first().is_none_or(|first| first.skeleton.layout_id() == clip.skeleton.layout_id()) {
            read += text.len();
            clips.push(clip);
        }
    }
    assert!(!clips.is_empty(), "no BVH files in the folder");
    (clips, read)
}

/// Just enough of BVH for well-formed files.
fn parse(text: &str) -> Clip {
    let (header, motion) = text.split_once("MOTION").unwrap();
    let mut words = header.split_whitespace();
    let (mut joints, mut open): (Vec<Joint>, Vec<Option<usize>>) = (Vec::new(), Vec::new());
    let next = |words: &mut std::str::SplitWhitespace<'_>| words.next().unwrap().parse::<f64>().unwrap();
    while let Some(word) = words.next() {
        match word {
            "ROOT" | "JOINT" => {
                let parent = open.last().copied().flatten();
                open.push(Some(joints.len()));
                joints.push(Joint {
                    name: words.next().unwrap().to_owned(),
                    parent,
                    offset: DVec3::ZERO,
                    end: None,
                    channels: Vec::new(),
                    axis: None,
                    bone: None,
                });
            }
            "End" => open.push(None),
            "}" => drop(open.pop()),
            "OFFSET" => {
                let offset = DVec3::new(next(&mut words), next(&mut words), next(&mut words));
                match open.last().unwrap() {
                    Some(joint) => joints[*joint].offset = offset,
                    None => joints.last_mut().unwrap().end = Some(offset),
                }
            }
            "CHANNELS" => {
                for _ in 0..next(&mut words) as usize {
                    let word = words.next().unwrap();
                    let kind = if word.ends_with("position") { ChannelKind::Position } else { ChannelKind::Rotation };
                    let axis = Axis::from_letter(word.chars().next().unwrap()).unwrap();
                    joints.last_mut().unwrap().channels.push(Channel { kind, axis });
                }
            }
            _ => {}
        }
    }
    let mut lines = motion.trim().lines();
    let n_frames: usize = lines.next().unwrap().split(':').nth(1).unwrap().trim().parse().unwrap();
    lines.next();
    let channels: Vec<f32> =
        lines.flat_map(|line| line.split_whitespace().map(|number| number.parse::<f32>().unwrap())).collect();
    let skeleton =
        Skeleton { format: Format::Bvh, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::Replace };
    assert_eq!(channels.len(), n_frames * skeleton.n_channels());
    Clip { skeleton: Arc::new(skeleton), rate_hz: 30.0, unit_m: 0.01, up: UpAxis::Y, n_frames, channels }
}

/// Twenty made-up clips of 22 joints with six channels each, smooth with a little noise in the last printed digit.
fn made_up() -> (Vec<Clip>, usize) {
    let all = |kind| [Axis::X, Axis::Y, Axis::Z].map(|axis| Channel { kind, axis });
    let joint = |n: usize| Joint {
        name: format!("joint{n}"),
        parent: n.checked_sub(1),
        offset: DVec3::new(0.0, 10.0, 0.0),
        end: (n == 21).then_some(DVec3::Y),
        channels: [all(ChannelKind::Position), all(ChannelKind::Rotation)].concat(),
        axis: None,
        bone: None,
    };
    let skeleton = Arc::new(Skeleton {
        format: Format::Bvh,
        joints: (0..22).map(joint).collect(),
        angle_unit: AngleUnit::Degrees,
        position_rule: PositionRule::Replace,
    });
    let mut seed = 1u32;
    let mut text_bytes = 0;
    let clips = (0..20).map(|_| {
        let channels: Vec<f32> = (0..600 * 132)
            .map(|n| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let (frame, channel) = ((n / 132) as f32, (n % 132) as f32);
                let smooth = 40.0 * (0.02 * frame * (1.0 + channel / 60.0)).sin() + (seed >> 24) as f32 * 1e-4;
                if (n % 132 / 3) % 2 == 0 && n % 132 > 5 { 10.0 } else { (smooth * 1e4).round() / 1e4 }
            })
            .collect();
        text_bytes += channels.iter().map(|value| format!("{value} ").len()).sum::<usize>();
        Clip { skeleton: skeleton.clone(), rate_hz: 30.0, unit_m: 0.01, up: UpAxis::Y, n_frames: 600, channels }
    });
    (clips.collect(), text_bytes)
}
