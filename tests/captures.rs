//! Captures as clips, with the units that `shared/data/README.md` gives them, and positions of the oracle.

use motionmill::formats::{AsfSkeleton, Motion, ReadOptions, read_amc, read_asf, read_bvh};
use motionmill::motion::clip::snap_rate_hz;
use motionmill::motion::{Clip, Skeleton, UpAxis, kinematics, skeleton::unique_names};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// Metres a unit of CMU's files.
pub(crate) const CMU_UNIT_M: f64 = 0.0254 / 0.45;

/// World position of a joint in a frame, by (frame, joint).
pub(crate) type Positions = BTreeMap<(usize, String), [f64; 3]>;

pub(crate) fn bvh(path: &Path) -> Motion {
    read_bvh(&std::fs::read(path).unwrap(), &ReadOptions::default())
        .unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
        .value
}

pub(crate) fn asf(path: &Path) -> AsfSkeleton {
    read_asf(&std::fs::read(path).unwrap(), &ReadOptions::default())
        .unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
        .value
}

/// A clip and the skeleton in the folder around it: `01/01_03.amc`, `01/01.asf`.
pub(crate) fn amc(path: &Path) -> Motion {
    let stem = path.file_stem().unwrap().to_str().unwrap();
    let skeleton = path.with_file_name(format!("{}.asf", stem.split('_').next().unwrap()));
    read_amc(&std::fs::read(path).unwrap(), &asf(&skeleton), &ReadOptions::default())
        .unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
        .value
}

/// As a clip, for kinematics.
pub(crate) fn clip(motion: Motion, unit_m: f64) -> Clip {
    let rate_hz = motion.frame_time_s.map_or(120.0, snap_rate_hz);
    motion.into_clip(rate_hz, unit_m, UpAxis::Y)
}

/// The names that the oracle uses, each with its point in `Poses`. A BVH joint is itself, its End Site
/// `<joint>_End`; an Acclaim bone is its far end.
pub(crate) fn oracle_points(skeleton: &Skeleton) -> Vec<(String, usize)> {
    let is_acclaim = skeleton.joints.iter().any(|joint| joint.bone.is_some());
    let children = skeleton.children();
    let ends: HashMap<usize, usize> =
        skeleton.ends().into_iter().enumerate().map(|(k, joint)| (joint, skeleton.joints.len() + k)).collect();
    let mut named = Vec::new();
    for (index, joint) in skeleton.joints.iter().enumerate() {
        if is_acclaim && joint.parent.is_some() {
            named.push((joint.name.clone(), ends.get(&index).copied().unwrap_or_else(|| children[index][0])));
        } else {
            named.push((joint.name.clone(), index));
            named.extend(ends.get(&index).map(|&end| (format!("{}_End", joint.name), end)));
        }
    }
    let (names, points): (Vec<String>, Vec<usize>) = named.into_iter().unzip();
    unique_names(names.into_iter()).into_iter().zip(points).collect()
}

/// How far a position may lie from the truth (DESIGN 3): the chain's bones plus the root's distance.
pub(crate) fn allowed_m(clip: &Clip, point: usize) -> f64 {
    let skeleton = &clip.skeleton;
    let ends = skeleton.ends();
    let (mut joint, mut reach) = match point.checked_sub(skeleton.joints.len()) {
        Some(end) => (ends[end], skeleton.joints[ends[end]].end.unwrap().length()),
        None => (point, 0.0),
    };
    while let Some(parent) = skeleton.joints[joint].parent {
        reach += skeleton.joints[joint].offset.length();
        joint = parent;
    }
    let root_distance = (0..clip.n_frames)
        .flat_map(|frame| clip.frame(frame).iter().take(3))
        .fold(skeleton.joints[joint].offset.length(), |far, value| far.max(f64::from(value.abs())));
    (1e-6 * (reach + 3.0 * root_distance) * clip.unit_m).max(1e-5)
}

/// Compares every position of the oracle; all of them must be known. Returns the largest difference in metres.
pub(crate) fn compare(what: &str, clip: &Clip, expected: &Positions) -> f64 {
    let poses = kinematics::poses(clip);
    let points: HashMap<String, usize> = oracle_points(&clip.skeleton).into_iter().collect();
    let mut worst = 0.0_f64;
    for ((frame, joint), position) in expected {
        let point = *points.get(joint).unwrap_or_else(|| panic!("{what}: no joint {joint}"));
        let found = poses.at(*frame, point);
        let error = (found - glam::DVec3::from_array(*position)).abs().max_element();
        let allowed = allowed_m(clip, point);
        assert!(
            error <= allowed,
            "{what}: frame {frame}, {joint}: {error} m off, {allowed} allowed; {found} for {position:?}"
        );
        worst = worst.max(error);
    }
    worst
}

/// Rows of a reference; `key` is how many columns stand before `frame`.
pub(crate) fn positions(text: &str, key: usize) -> BTreeMap<String, Positions> {
    let mut files: BTreeMap<String, Positions> = BTreeMap::new();
    for row in text.lines().skip(1) {
        let columns = csv_row(row);
        let [frame, joint, x, y, z] = &columns[key..] else { panic!("{row}") };
        let position = [x, y, z].map(|value| value.parse().unwrap());
        let file = columns[..key].join("/");
        files.entry(file).or_default().insert((frame.parse().unwrap(), joint.clone()), position);
    }
    files
}

/// Columns of a CSV row with quotes.
fn csv_row(row: &str) -> Vec<String> {
    let mut columns = vec![String::new()];
    let mut quoted = false;
    for c in row.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => columns.push(String::new()),
            c => columns.last_mut().unwrap().push(c),
        }
    }
    columns
}

/// All files below a folder with an extension, sorted.
pub(crate) fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|found| found == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
