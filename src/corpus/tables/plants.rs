//! The `plants` and `segments` tables: feet on the ground, and runs of one gait.

use crate::annotate::{Foot, Gait, Plant, Segment};
use crate::corpus::columns::{Columns, METERS, METERS_WORLD, PLAIN};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use arrow::array::Array;

/// Gathers a clip's plants.
#[derive(Debug, Default)]
pub(in crate::corpus) struct GatherPlants(Vec<Plant>);

/// Gathers a clip's segments.
#[derive(Debug, Default)]
pub(in crate::corpus) struct GatherSegments(Vec<Segment>);

/// Columns of one clip's plants.
pub(in crate::corpus) fn plants_columns(clip_id: u32, plants: &[Plant]) -> Columns {
    Columns::new()
        .u32("clip_id", PLAIN, plants.iter().map(|_| clip_id))
        .str("foot", plants.iter().map(|plant| plant.foot.name()))
        .u32("first", PLAIN, plants.iter().map(|plant| plant.first))
        .u32("end", PLAIN, plants.iter().map(|plant| plant.end))
        .f32("x", METERS_WORLD, plants.iter().map(|plant| plant.position[0]))
        .f32("y", METERS_WORLD, plants.iter().map(|plant| plant.position[1]))
        .f32("z", METERS_WORLD, plants.iter().map(|plant| plant.position[2]))
        .f32("slip_m", METERS, plants.iter().map(|plant| plant.slip_m))
        .f32_opt("confidence", PLAIN, plants.iter().map(|plant| plant.confidence))
}

/// Columns of one clip's segments.
pub(in crate::corpus) fn segments_columns(clip_id: u32, segments: &[Segment]) -> Columns {
    Columns::new()
        .u32("clip_id", PLAIN, segments.iter().map(|_| clip_id))
        .str("gait", segments.iter().map(|segment| Gait::name(segment.gait)))
        .u32("first", PLAIN, segments.iter().map(|segment| segment.first))
        .u32("end", PLAIN, segments.iter().map(|segment| segment.end))
        .f32_opt("confidence", PLAIN, segments.iter().map(|segment| segment.confidence))
}

impl GatherPlants {
    /// What is wrong with a clip's plants, if anything.
    pub(in crate::corpus) fn refuse(plants: &[Plant], n_frames: usize) -> Result<(), String> {
        plants.iter().try_for_each(|plant| {
            let numbers = plant.position.into_iter().chain([plant.slip_m]).chain(plant.confidence);
            refuse_range(plant.first, plant.end, n_frames, numbers)
        })
    }
}

impl GatherSegments {
    /// What is wrong with a clip's segments, if anything.
    pub(in crate::corpus) fn refuse(segments: &[Segment], n_frames: usize) -> Result<(), String> {
        segments
            .iter()
            .try_for_each(|segment| refuse_range(segment.first, segment.end, n_frames, segment.confidence.into_iter()))
    }
}

impl crate::corpus::reader::Gather for GatherPlants {
    type Clip = Vec<Plant>;

    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError> {
        let (foot, first, end) = (rows.str("foot")?, rows.u32("first")?, rows.u32("end")?);
        let (x, y, z) = (rows.f32("x")?, rows.f32("y")?, rows.f32("z")?);
        let (slip_m, confidence) = (rows.f32("slip_m")?, rows.f32_opt("confidence")?);
        for at in 0..rows.len() {
            let foot = match foot.value(at) {
                "left" => Foot::Left,
                "right" => Foot::Right,
                other => return Err(rows.damaged(format!("`{other}` is no foot"))),
            };
            self.0.push(Plant {
                foot,
                first: first[at],
                end: end[at],
                position: [x[at], y[at], z[at]],
                slip_m: slip_m[at],
                confidence: confidence.is_valid(at).then(|| confidence.value(at)),
            });
        }
        Ok(())
    }

    fn done(self) -> Vec<Plant> {
        self.0
    }
}

impl crate::corpus::reader::Gather for GatherSegments {
    type Clip = Vec<Segment>;

    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError> {
        let (gait, first, end) = (rows.str("gait")?, rows.u32("first")?, rows.u32("end")?);
        let confidence = rows.f32_opt("confidence")?;
        for at in 0..rows.len() {
            self.0.push(Segment {
                gait: super::gait(rows, gait.value(at))?,
                first: first[at],
                end: end[at],
                confidence: confidence.is_valid(at).then(|| confidence.value(at)),
            });
        }
        Ok(())
    }

    fn done(self) -> Vec<Segment> {
        self.0
    }
}

fn refuse_range(first: u32, end: u32, n_frames: usize, mut numbers: impl Iterator<Item = f32>) -> Result<(), String> {
    if first >= end || end as usize > n_frames {
        return Err(format!("frames {first}..{end} of {n_frames}"));
    }
    match numbers.all(f32::is_finite) {
        true => Ok(()),
        false => Err(format!("a number that isn't finite in frames {first}..{end}")),
    }
}
