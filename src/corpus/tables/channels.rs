//! The `channels` table: every number of the file, one column a channel, one dataset a layout.

use super::expect_frames;
use super::float_block::{FloatBlock, first_not_finite};
use crate::corpus::columns::{PLAIN, field};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::motion::{ChannelKind, Role, RoleMap, Skeleton};
use arrow::array::RecordBatch;
use arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use std::sync::Arc;

/// The `channels` table of one layout, being filled.
#[derive(Debug)]
pub(in crate::corpus) struct ChannelsTable {
    block: FloatBlock,
    n_channels: usize,
}

/// Gathers a clip's channels: `[frame][channel]`.
#[derive(Debug, Default)]
pub(in crate::corpus) struct GatherChannels {
    n_frames: usize,
    values: Vec<f32>,
}

impl ChannelsTable {
    /// Columns: `clip_id`, `frame`, channels in file order.
    pub(in crate::corpus) fn schema(skeleton: &Skeleton, roles: &RoleMap) -> SchemaRef {
        let mut fields = key_fields(false);
        let joints = skeleton.unique_joint_names();
        let parts = parts(skeleton, roles);
        let mut names = skeleton.channel_names().into_iter();
        for (index, joint) in skeleton.joints.iter().enumerate() {
            let role = roles.of_point(index).map_or("", Role::name);
            for (channel, name) in joint.channels.iter().zip(&mut names) {
                let unit = match (channel.kind, skeleton.angle_unit) {
                    (ChannelKind::Rotation, crate::motion::skeleton::AngleUnit::Degrees) => "deg",
                    (ChannelKind::Rotation, crate::motion::skeleton::AngleUnit::Radians) => "rad",
                    _ => "file",
                };
                let notes = [
                    ("unit", unit),
                    ("space", "file"),
                    ("joint", &joints[index]),
                    ("role", role),
                    ("part", parts[index]),
                ];
                fields.push(field(&name, DataType::Float32, false, &notes));
            }
        }
        Arc::new(Schema::new(fields))
    }

    pub(in crate::corpus) fn new(schema: SchemaRef, block_rows: usize, n_channels: usize) -> ChannelsTable {
        ChannelsTable { block: FloatBlock::new(schema, block_rows, false, n_channels), n_channels }
    }

    /// What is wrong with a clip's channels, if anything.
    pub(in crate::corpus) fn refuse(values: &[f32], n_frames: usize, n_channels: usize) -> Result<(), String> {
        if values.len() != n_frames * n_channels {
            return Err(format!("{} values for {n_frames} frames of {n_channels} channels", values.len()));
        }
        match first_not_finite(values) {
            None => Ok(()),
            Some(at) => Err(format!("frame {}, channel {}: {}", at / n_channels, at % n_channels, values[at])),
        }
    }

    /// Adds a clip; every full block goes to `out`.
    pub(in crate::corpus) fn push(
        &mut self,
        clip_id: u32,
        n_frames: usize,
        values: &[f32],
        mut out: impl FnMut(RecordBatch) -> Result<(), CorpusError>,
    ) -> Result<(), CorpusError> {
        let mut first = 0;
        while first < n_frames {
            let n = self.block.room().min(n_frames - first);
            self.block.begin_rows(clip_id, 1.0, first, n);
            self.block.fill(0, &values[first * self.n_channels..(first + n) * self.n_channels], self.n_channels);
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

impl crate::corpus::reader::Gather for GatherChannels {
    type Clip = Vec<f32>;

    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError> {
        expect_frames(rows, self.n_frames)?;
        gather_floats(rows, 2, &mut self.values)?;
        self.n_frames += rows.len();
        Ok(())
    }

    fn done(self) -> Vec<f32> {
        self.values
    }
}

/// Appends the columns from `skip` on, row by row.
pub(super) fn gather_floats(rows: &Rows<'_>, skip: usize, values: &mut Vec<f32>) -> Result<(), CorpusError> {
    let columns = (skip..rows.names().len()).map(|column| rows.nth_f32(column));
    let columns: Vec<&[f32]> = columns.collect::<Result<_, _>>()?;
    let width = columns.len();
    let from = values.len();
    values.resize(from + rows.len() * width, 0.0);
    // A strip of rows at a time, so that the rows being filled stay in the cache.
    for (strip, filled) in values[from..].chunks_mut((64 * width).max(1)).enumerate() {
        for (at, column) in columns.iter().enumerate() {
            for (row, value) in filled[at..].iter_mut().step_by(width).zip(&column[strip * 64..]) {
                *row = *value;
            }
        }
    }
    Ok(())
}

/// `clip_id`, `frame`, and `time_s` where the table has it.
pub(super) fn key_fields(timed: bool) -> Vec<Field> {
    let mut fields =
        vec![field("clip_id", DataType::UInt32, false, PLAIN), field("frame", DataType::UInt32, false, PLAIN)];
    if timed {
        fields.push(field("time_s", DataType::Float64, false, crate::corpus::columns::SECONDS));
    }
    fields
}

/// The part of the body that each joint belongs to, in `provenance`'s words: that of its own role, else that of the
/// nearest joint above it that has one; `root` above the hips; `""` where no role is known at all.
pub(super) fn parts(skeleton: &Skeleton, roles: &RoleMap) -> Vec<&'static str> {
    let of_role = |role: Role| match role {
        Role::Hips => "root",
        Role::Spine | Role::Chest => "trunk",
        Role::Neck | Role::Head => "head",
        Role::ClavicleLeft | Role::ShoulderLeft | Role::ElbowLeft | Role::WristLeft => "arm_left",
        Role::ClavicleRight | Role::ShoulderRight | Role::ElbowRight | Role::WristRight => "arm_right",
        _ => "legs",
    };
    let above_all = if roles.get(Role::Hips).is_some() { "root" } else { "" };
    let mut parts: Vec<&'static str> = Vec::with_capacity(skeleton.joints.len());
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let inherited = joint.parent.map_or(above_all, |parent| parts[parent]);
        parts.push(roles.of_point(index).map_or(inherited, of_role));
    }
    parts
}
