//! Random rows for the tables of a corpus.

use glam::{DQuat, DVec3};
use motionmill::annotate::{ClipLabels, Features, Foot, FrameLabels, Gait, Plant, PlantState, Segment};
use motionmill::corpus::{
    ClipFormat, ClipRow, ClipTables, FaultRow, InputFile, Origin, PARTS, ShardId, ShardRecord, ShardSettings,
    ShardWriter, SkeletonRow, Store, Table,
};
use motionmill::motion::skeleton::{AngleUnit, PositionRule};
use motionmill::motion::{
    Axis, Bone, Channel, ChannelKind, Format, Joint, Notice, Poses, RestAxis, Role, RoleMap, Rotations, Severity,
    Skeleton, UpAxis,
};
use motionmill::synthesis::ProvenanceRow;

/// Numbers from a seed.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (self.0 ^ (self.0 >> 22)) >> 22;
        (word ^ (word >> 17)).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 16
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub(crate) fn f64(&mut self) -> f64 {
        let unit = self.next() as f64 / (1u64 << 48) as f64 - 0.5;
        let scale = [1e-30, 1e-3, 1.0, 100.0, 1e6][self.below(5)];
        if self.below(20) == 0 { [0.0, -0.0][self.below(2)] } else { unit * scale }
    }

    pub(crate) fn f32(&mut self) -> f32 {
        self.f64() as f32
    }

    pub(crate) fn maybe<T>(&mut self, make: impl FnOnce(&mut Dice) -> T) -> Option<T> {
        (self.below(3) > 0).then(|| make(self))
    }

    pub(crate) fn pick<T: Clone>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())].clone()
    }

    pub(crate) fn text(&mut self) -> String {
        let words = ["walk", "ひざ", "çà", "a b", "", "Ünïcode/02_01", "\"quoted\"", "tab\there", "🦵", "x,y;z"];
        format!("{}{}", self.pick(&words), self.pick(&words))
    }

    pub(crate) fn many<T>(&mut self, below: usize, mut make: impl FnMut(&mut Dice) -> T) -> Vec<T> {
        (0..self.below(below)).map(|_| make(self)).collect()
    }
}

pub(crate) const GAITS: [Gait; 6] = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump, Gait::Other];

/// A tree of joints whose names repeat, differ in case alone, and are not ASCII.
pub(crate) fn skeleton(dice: &mut Dice) -> Skeleton {
    let names = ["Hips", "hips", "Foot", "FOOT", "ひざ", "left knee", "mixamorig:Leg", "a.b", "foot#2", ""];
    let format = dice.pick(&[Format::Bvh, Format::Amc]);
    let n = 1 + dice.below(9);
    let axes = [Axis::X, Axis::Y, Axis::Z];
    let mut joints: Vec<Joint> = (0..n)
        .map(|index| {
            let amc = format == Format::Amc;
            let channels = dice.many(7, |dice| match dice.below(if amc { 9 } else { 8 }) {
                0..4 => Channel { kind: ChannelKind::Position, axis: dice.pick(&axes) },
                8 => Channel { kind: ChannelKind::Length, axis: Axis::X },
                _ => Channel { kind: ChannelKind::Rotation, axis: dice.pick(&axes) },
            });
            Joint {
                name: dice.pick(&names).to_owned(),
                parent: index.checked_sub(1).map(|last| dice.below(last + 1)),
                offset: DVec3::new(dice.f64(), dice.f64(), dice.f64()),
                end: None,
                channels,
                axis: amc.then(|| RestAxis {
                    degrees: [dice.f64(), dice.f64(), dice.f64()],
                    order: dice.pick(&[[Axis::X, Axis::Y, Axis::Z], [Axis::Z, Axis::X, Axis::Y]]),
                }),
                bone: (amc && index > 0)
                    .then(|| Bone { direction: DVec3::new(dice.f64(), dice.f64(), dice.f64()), length: dice.f64() }),
            }
        })
        .collect();
    for index in 0..n {
        let leaf = joints.iter().all(|joint| joint.parent != Some(index));
        if if leaf { dice.below(8) > 0 } else { dice.below(20) == 0 } {
            joints[index].end = Some(DVec3::new(dice.f64(), dice.f64(), dice.f64()));
        }
    }
    let angle_unit = dice.pick(&[AngleUnit::Degrees, AngleUnit::Radians]);
    let position_rule = dice.pick(&[PositionRule::Replace, PositionRule::Add]);
    Skeleton { format, joints, angle_unit, position_rule }
}

pub(crate) fn skeleton_row(dice: &mut Dice) -> SkeletonRow {
    let body = skeleton(dice);
    let n_points = body.joints.len() + body.ends().len();
    let mut roles = RoleMap::default();
    for role in Role::ALL {
        if dice.below(2) == 0 {
            roles.set(role, dice.below(n_points));
        }
    }
    let lengths: Vec<f64> = body.joints.iter().map(|_| 100.0).collect();
    let header = format!("HIERARCHY\r\n{}\n", dice.text());
    SkeletonRow {
        skeleton_id: body.skeleton_id(&lengths),
        first_clip: [String::new(), String::new()],
        body,
        roles,
        header,
    }
}

pub(crate) fn clip_row(dice: &mut Dice, clip_id: u32) -> ClipRow {
    ClipRow {
        clip_id,
        name: dice.text(),
        source: dice.text(),
        format: dice.pick(&[ClipFormat::Bvh, ClipFormat::Amc, ClipFormat::Made]),
        layout: format!("L{:08x}", dice.next() as u32),
        skeleton: format!("S{:012x}", dice.next()),
        subject: dice.maybe(Dice::text),
        frames: dice.next() as u32,
        rate_hz: dice.f64(),
        frame_time_s: dice.maybe(Dice::f64),
        duration_s: dice.f64(),
        unit_m: dice.f64(),
        max_rounding: dice.f32(),
        licenses: dice.many(3, Dice::text),
        attribution: dice.maybe(Dice::text),
        may_share: dice.maybe(|dice| dice.below(2) == 0),
        may_sell: dice.maybe(|dice| dice.below(2) == 0),
        origin: dice.pick(&[Origin::Captured, Origin::Procedural, Origin::Graft, Origin::Loop, Origin::Walk]),
        parents: dice.many(3, |dice| dice.next() as u32),
        recipe: dice.maybe(Dice::text),
        labels: ClipLabels {
            leg_length_m: dice.maybe(Dice::f32),
            leg_spread_m: dice.maybe(Dice::f32),
            ground_height_m: dice.maybe(Dice::f32),
            ground_spread_m: dice.maybe(Dice::f32),
            ground_slope_x: dice.maybe(Dice::f32),
            ground_slope_z: dice.maybe(Dice::f32),
            ground_slope_share: dice.maybe(Dice::f32),
            uneven: dice.maybe(|dice| dice.below(2) == 0),
            belt_mps: dice.maybe(Dice::f32),
            noise_m: dice.maybe(Dice::f32),
            noise_spread_m: dice.maybe(Dice::f32),
            gait_class: dice.maybe(|dice| dice.pick(&GAITS)),
            thesis_class: dice.maybe(|dice| dice.pick(&GAITS)),
            stand_fraction: dice.maybe(Dice::f32),
            walk_fraction: dice.maybe(Dice::f32),
            run_fraction: dice.maybe(Dice::f32),
            jump_fraction: dice.maybe(Dice::f32),
            unknown_fraction: dice.maybe(Dice::f32),
            gait_confidence: dice.maybe(Dice::f32),
            duty_factor: dice.maybe(Dice::f32),
            flight_fraction: dice.maybe(Dice::f32),
            checks: dice.many(3, Dice::text),
        },
        warnings: dice.next() as u32,
        up_axis: dice.pick(&[UpAxis::Y, UpAxis::Z]),
    }
}

pub(crate) fn fault_row(dice: &mut Dice) -> FaultRow {
    let notice = Notice {
        severity: dice.pick(&[Severity::Note, Severity::Warning, Severity::Fault]),
        kind: dice.text(),
        line: dice.maybe(|dice| dice.next() as u32),
        frame: dice.maybe(|dice| dice.next() as u32),
        count: dice.next() as u32,
        message: dice.text(),
        why: dice.text(),
        remedy: dice.text(),
    };
    FaultRow { source: dice.text(), name: dice.text(), notice }
}

/// All that the tables hold of one clip.
#[derive(Clone, Debug)]
pub(crate) struct SampleClip {
    pub(crate) row: ClipRow,
    pub(crate) skeleton: SkeletonRow,
    pub(crate) channels: Vec<f32>,
    pub(crate) poses: Poses,
    pub(crate) rotations: Rotations,
    pub(crate) labels: Option<FrameLabels>,
    pub(crate) features: Features,
    pub(crate) plants: Vec<Plant>,
    pub(crate) segments: Vec<Segment>,
    pub(crate) provenance: Vec<ProvenanceRow>,
}

pub(crate) fn sample_clip(dice: &mut Dice, clip_id: u32, n_frames: usize, skeleton: &SkeletonRow) -> SampleClip {
    let body = &skeleton.body;
    let (n_joints, n_points) = (body.joints.len(), body.joints.len() + body.ends().len());
    let mut row = clip_row(dice, clip_id);
    row.layout = body.layout_id();
    row.skeleton = skeleton.skeleton_id.clone();
    row.frames = n_frames as u32;
    row.rate_hz = dice.pick(&[30.0, 120.0, 30000.0 / 1001.0]);
    let range = |dice: &mut Dice| {
        let first = dice.below(n_frames);
        (first as u32, (first + 1 + dice.below(n_frames - first)) as u32)
    };
    let quaternion = |dice: &mut Dice| DQuat::from_xyzw(dice.f64(), dice.f64(), dice.f64(), 1.0).normalize();
    let local: Vec<DQuat> = (0..n_frames * n_joints).map(|_| quaternion(dice)).collect();
    let feet = [Role::ToeLeft, Role::ToeRight];
    let effectors = [[Role::Head, Role::WristLeft, Role::WristRight].as_slice(), &feet].concat();
    let features = match dice.below(4) {
        0 => Features::default(),
        _ => Features { effectors, values: (0..n_frames * 45).map(|_| dice.f32()).collect() },
    };
    SampleClip {
        channels: (0..n_frames * body.n_channels()).map(|_| dice.f32()).collect(),
        poses: Poses {
            n_frames,
            n_points,
            // As f32, so that they come back equal.
            world: (0..n_frames * n_points)
                .map(|_| DVec3::new(dice.f32().into(), dice.f32().into(), dice.f32().into()))
                .collect(),
        },
        rotations: Rotations { n_frames, n_joints, world: local.clone(), local },
        labels: (dice.below(4) > 0).then(|| frame_labels(dice, n_frames, row.rate_hz)),
        features,
        plants: dice.many(5, |dice| {
            let (first, end) = range(dice);
            let (position, slip_m) = ([dice.f32(), dice.f32(), dice.f32()], dice.f32());
            Plant {
                foot: dice.pick(&[Foot::Left, Foot::Right]),
                first,
                end,
                position,
                slip_m,
                confidence: dice.maybe(Dice::f32),
            }
        }),
        segments: dice.many(5, |dice| {
            let (first, end) = range(dice);
            Segment { gait: dice.pick(&GAITS), first, end, confidence: dice.maybe(Dice::f32) }
        }),
        provenance: (0..dice.below(2 * n_frames))
            .map(|n| ProvenanceRow {
                frame: (n / 2) as u32,
                part: dice.pick(&PARTS),
                parent: dice.next() as u32,
                parent_frame: dice.f64(),
                weight: dice.f32(),
            })
            .collect(),
        row,
        skeleton: skeleton.clone(),
    }
}

fn frame_labels(dice: &mut Dice, n: usize, rate_hz: f64) -> FrameLabels {
    let mut floats = || (0..n).map(|_| dice.maybe(Dice::f32)).collect::<Vec<_>>();
    let (heading, turn_rate, gait_confidence, phase) = (floats(), floats(), floats(), floats());
    let heights = [floats(), floats(), floats(), floats()];
    let speeds = [floats(), floats(), floats(), floats()];
    let mut flags = || (0..n).map(|_| dice.maybe(|dice| dice.below(2) == 0)).collect::<Vec<_>>();
    let (stance, pinned) = ([flags(), flags()], [flags(), flags()]);
    FrameLabels {
        time_s: (0..n).map(|frame| frame as f64 / rate_hz).collect(),
        root: (0..n).map(|_| [dice.f32(), dice.f32(), dice.f32()]).collect(),
        heading,
        speed: (0..n).map(|_| dice.f32()).collect(),
        turn_rate,
        heights,
        speeds,
        stance,
        pinned,
        plant_state: (0..n).map(|_| dice.maybe(|dice| dice.pick(&PlantState::ALL))).collect(),
        gait: (0..n).map(|_| dice.maybe(|dice| dice.pick(&GAITS))).collect(),
        gait_confidence,
        phase,
        diagnostics: None,
    }
}

impl SampleClip {
    pub(crate) fn tables(&self) -> ClipTables<'_> {
        ClipTables {
            clip_id: self.row.clip_id,
            n_frames: self.row.frames as usize,
            rate_hz: self.row.rate_hz,
            skeleton: &self.skeleton.body,
            roles: &self.skeleton.roles,
            channels: Some(&self.channels),
            poses: Some(&self.poses),
            rotations: Some(&self.rotations),
            labels: self.labels.as_ref(),
            features: Some(&self.features),
            plants: &self.plants,
            segments: &self.segments,
            provenance: &self.provenance,
        }
    }
}

/// A few clips of a few skeletons, by clip_id.
pub(crate) fn sample_clips(seed: u64, n_clips: usize, max_frames: usize) -> Vec<SampleClip> {
    let mut dice = Dice(seed);
    let skeletons: Vec<SkeletonRow> = (0..1 + dice.below(3)).map(|_| skeleton_row(&mut dice)).collect();
    (0..n_clips)
        .map(|n| {
            let skeleton = dice.pick(&skeletons);
            let n_frames = 1 + dice.below(max_frames);
            sample_clip(&mut dice, 3 * n as u32 + 1, n_frames, &skeleton)
        })
        .collect()
}

pub(crate) fn record_of(shard: ShardId, clips: &[SampleClip]) -> ShardRecord {
    let mut record = ShardRecord::new(shard);
    record.keys.ingest = "i1".to_owned();
    record.keys.features = "f1".to_owned();
    record.keys.labels = "l1".to_owned();
    record.clips = clips.iter().map(|clip| clip.row.clone()).collect();
    record.skeletons = clips.iter().map(|clip| clip.skeleton.clone()).collect();
    record.skeletons.sort_by(|a, b| a.skeleton_id.cmp(&b.skeleton_id));
    record.skeletons.dedup_by(|a, b| a.skeleton_id == b.skeleton_id);
    record.inputs = clips
        .iter()
        .map(|clip| InputFile {
            source: clip.row.source.clone(),
            name: clip.row.name.clone(),
            clip_id: clip.row.clip_id,
            blake3: "0".repeat(64),
            skeleton_blake3: None,
        })
        .collect();
    record
}

pub(crate) fn all_tables() -> ShardSettings {
    ShardSettings { tables: Table::ALL.to_vec(), rotations: true, ..ShardSettings::default() }
}

/// Writes and commits a shard.
pub(crate) fn commit(store: &Store, shard: ShardId, clips: &[SampleClip], settings: ShardSettings) -> ShardRecord {
    let mut writer = ShardWriter::create(store, shard, settings);
    for clip in clips {
        writer.push(&clip.tables()).unwrap();
    }
    writer.finish().unwrap().commit(record_of(shard, clips)).unwrap()
}
