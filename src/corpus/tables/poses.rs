//! The `poses` table: where every point of the body is, in world metres; local rotations if they are asked for.

use super::channels::{key_fields, parts};
use super::expect_frames;
use super::float_block::{FloatBlock, first_not_finite};
use crate::corpus::columns::field;
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::motion::skeleton::unique_names;
use crate::motion::{Poses, Role, RoleMap, Rotations, Skeleton};
use arrow::array::RecordBatch;
use arrow::datatypes::{DataType, Schema, SchemaRef};
use glam::DVec3;
use std::sync::Arc;

/// The `poses` table of one layout, being filled.
#[derive(Debug)]
pub(in crate::corpus) struct PosesTable {
    block: FloatBlock,
    n_points: usize,
    /// 0: the table has no rotations.
    n_rotations: usize,
}

/// Gathers a clip's positions.
#[derive(Debug, Default)]
pub(in crate::corpus) struct GatherPoses {
    n_frames: usize,
    world: Vec<DVec3>,
    n_points: usize,
}

/// The layout that a skeleton's poses are filed under: its own, and where not just the leaves have ends, so that the
/// columns are others, a name derived from it.
pub(in crate::corpus) fn pose_layout(skeleton: &Skeleton) -> String {
    let layout = skeleton.layout_id();
    let children = skeleton.children();
    let ends = skeleton.ends();
    let leaves = (0..children.len()).filter(|&joint| children[joint].is_empty());
    if leaves.eq(ends.iter().copied()) {
        return layout;
    }
    let mut hasher = blake3::Hasher::new();
    ends.iter().for_each(|&end| {
        hasher.update(&(end as u64).to_le_bytes());
    });
    format!("{layout}e{}", hasher.finalize().to_hex().split_at(6).0)
}

impl PosesTable {
    /// Columns: `clip_id`, `frame`, `time_s`, positions of joints, of leaf ends, then rotations.
    pub(in crate::corpus) fn schema(skeleton: &Skeleton, roles: &RoleMap, rotations: bool) -> SchemaRef {
        let joints = skeleton.unique_joint_names();
        let parts = parts(skeleton, roles);
        let n_joints = joints.len();
        let role = |point: usize| roles.of_point(point).map_or("", Role::name);
        let mut names = Vec::new();
        let mut notes = Vec::new();
        for (joint, name) in joints.iter().enumerate() {
            names.extend(["x", "y", "z"].map(|axis| format!("{name}.{axis}")));
            notes.extend([("m", "world", joint, role(joint)); 3]);
        }
        for (k, joint) in skeleton.ends().into_iter().enumerate() {
            names.extend(["x", "y", "z"].map(|axis| format!("{}.end.{axis}", joints[joint])));
            notes.extend([("m", "world", joint, role(n_joints + k)); 3]);
        }
        if rotations {
            for (joint, name) in joints.iter().enumerate() {
                names.extend(["qx", "qy", "qz", "qw"].map(|part| format!("{name}.{part}")));
                notes.extend([("", "local", joint, role(joint)); 4]);
            }
        }
        let mut fields = key_fields(true);
        for (name, (unit, space, joint, role)) in unique_names(names.into_iter()).into_iter().zip(notes) {
            let notes =
                [("unit", unit), ("space", space), ("joint", &joints[joint]), ("role", role), ("part", parts[joint])];
            fields.push(field(&name, DataType::Float32, false, &notes));
        }
        Arc::new(Schema::new(fields))
    }

    pub(in crate::corpus) fn new(
        schema: SchemaRef,
        block_rows: usize,
        n_points: usize,
        n_rotations: usize,
    ) -> PosesTable {
        let block = FloatBlock::new(schema, block_rows, true, 3 * n_points + 4 * n_rotations);
        PosesTable { block, n_points, n_rotations }
    }

    /// What is wrong with a clip's poses, if anything.
    pub(in crate::corpus) fn refuse(
        skeleton: &Skeleton,
        n_frames: usize,
        poses: &Poses,
        rotations: Option<&Rotations>,
    ) -> Result<(), String> {
        let n_joints = skeleton.joints.len();
        let n_points = n_joints + skeleton.ends().len();
        if (poses.n_frames, poses.n_points) != (n_frames, n_points) || poses.world.len() != n_frames * n_points {
            return Err(format!("{} positions for {n_frames} frames of {n_points} points", poses.world.len()));
        }
        if let Some(at) = first_not_finite(&poses.world) {
            return Err(format!("frame {}, point {}: {}", at / n_points, at % n_points, poses.world[at]));
        }
        let Some(rotations) = rotations else { return Ok(()) };
        if rotations.local.len() != n_frames * n_joints {
            return Err(format!("{} rotations for {n_frames} frames of {n_joints} joints", rotations.local.len()));
        }
        match first_not_finite(&rotations.local) {
            None => Ok(()),
            Some(at) => Err(format!("frame {}, joint {}: {}", at / n_joints, at % n_joints, rotations.local[at])),
        }
    }

    /// Adds a clip; every full block goes to `out`.
    pub(in crate::corpus) fn push(
        &mut self,
        clip_id: u32,
        rate_hz: f64,
        poses: &Poses,
        rotations: Option<&Rotations>,
        mut out: impl FnMut(RecordBatch) -> Result<(), CorpusError>,
    ) -> Result<(), CorpusError> {
        let mut first = 0;
        while first < poses.n_frames {
            let n = self.block.room().min(poses.n_frames - first);
            self.block.begin_rows(clip_id, rate_hz, first, n);
            self.block.fill(0, &poses.world[first * self.n_points..(first + n) * self.n_points], self.n_points);
            if let Some(rotations) = rotations {
                let local = &rotations.local[first * self.n_rotations..(first + n) * self.n_rotations];
                self.block.fill(3 * self.n_points, local, self.n_rotations);
            }
            first += n;
            if self.block.room() == 0 {
                self.take(&mut out)?;
            }
        }
        Ok(())
    }

    /// Gives what is left.
    pub(in crate::corpus) fn take(
        &mut self,
        mut out: impl FnMut(RecordBatch) -> Result<(), CorpusError>,
    ) -> Result<(), CorpusError> {
        self.block.take()?.map_or(Ok(()), &mut out)
    }
}

impl crate::corpus::reader::Gather for GatherPoses {
    type Clip = Poses;

    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError> {
        expect_frames(rows, self.n_frames)?;
        // Rotations follow the positions; a point's columns may carry `#2`, its metadata doesn't change with it.
        let schema = rows.schema();
        let in_world = |n: &usize| schema.field(*n).metadata().get("space").is_some_and(|space| space == "world");
        let n_columns = (3..schema.fields().len()).take_while(in_world).count();
        if n_columns % 3 != 0 {
            return Err(rows.damaged(format!("{n_columns} columns of positions")));
        }
        self.n_points = n_columns / 3;
        let columns = (3..3 + n_columns).map(|column| rows.nth_f32(column));
        let columns: Vec<&[f32]> = columns.collect::<Result<_, _>>()?;
        self.world.reserve(rows.len() * self.n_points);
        for row in 0..rows.len() {
            let points = columns.chunks_exact(3);
            self.world.extend(points.map(|point| DVec3::from([0, 1, 2].map(|axis| f64::from(point[axis][row])))));
        }
        self.n_frames += rows.len();
        Ok(())
    }

    fn done(self) -> Poses {
        Poses { n_frames: self.n_frames, n_points: self.n_points, world: self.world }
    }
}
