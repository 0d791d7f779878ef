//! The `features` table: position, velocity and acceleration of the effectors in the neutral frame, unweighted.

use super::channels::{gather_floats, key_fields};
use super::expect_frames;
use super::float_block::{FloatBlock, first_not_finite};
use crate::annotate::Features;
use crate::corpus::columns::field;
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::motion::Role;
use arrow::array::RecordBatch;
use arrow::datatypes::{DataType, Schema, SchemaRef};
use std::sync::Arc;

/// Effectors in the order of the table. Where a body has no toes its ankles stand in these columns.
const EFFECTORS: [Role; 5] = [Role::Head, Role::WristLeft, Role::WristRight, Role::ToeLeft, Role::ToeRight];

/// Numbers of a frame.
const WIDTH: usize = 45;

/// The `features` table, being filled.
#[derive(Debug)]
pub(in crate::corpus) struct FeaturesTable {
    block: FloatBlock,
}

/// Gathers a clip's features.
#[derive(Debug, Default)]
pub(in crate::corpus) struct GatherFeatures {
    n_frames: usize,
    values: Vec<f32>,
}

impl FeaturesTable {
    /// Columns: `clip_id`, `frame`, 45 numbers.
    pub(in crate::corpus) fn schema() -> SchemaRef {
        let mut fields = key_fields(false);
        for effector in EFFECTORS {
            for (letter, unit) in [("p", "m"), ("v", "m/s"), ("a", "m/s^2")] {
                for axis in ["x", "y", "z"] {
                    let notes = [("unit", unit), ("space", "neutral"), ("role", effector.name())];
                    let name = format!("{}.{letter}{axis}", effector.name());
                    fields.push(field(&name, DataType::Float32, false, &notes));
                }
            }
        }
        Arc::new(Schema::new(fields))
    }

    pub(in crate::corpus) fn new(schema: SchemaRef, block_rows: usize) -> FeaturesTable {
        FeaturesTable { block: FloatBlock::new(schema, block_rows, false, WIDTH) }
    }

    /// What is wrong with a clip's features, if anything.
    pub(in crate::corpus) fn refuse(features: &Features, n_frames: usize) -> Result<(), String> {
        let column = |role: &Role| match role {
            Role::AnkleLeft => Role::ToeLeft,
            Role::AnkleRight => Role::ToeRight,
            role => *role,
        };
        if !features.effectors.iter().map(column).eq(EFFECTORS) {
            return Err(format!("effectors {:?}, the table has {EFFECTORS:?}", features.effectors));
        }
        if features.values.len() != n_frames * WIDTH {
            return Err(format!("{} numbers for {n_frames} frames of {WIDTH}", features.values.len()));
        }
        match first_not_finite(&features.values) {
            None => Ok(()),
            Some(at) => Err(format!("frame {}, number {}: {}", at / WIDTH, at % WIDTH, features.values[at])),
        }
    }

    /// Adds a clip; every full block goes to `out`.
    pub(in crate::corpus) fn push(
        &mut self,
        clip_id: u32,
        values: &[f32],
        mut out: impl FnMut(RecordBatch) -> Result<(), CorpusError>,
    ) -> Result<(), CorpusError> {
        let n_frames = values.len() / WIDTH;
        let mut first = 0;
        while first < n_frames {
            let n = self.block.room().min(n_frames - first);
            self.block.begin_rows(clip_id, 1.0, first, n);
            self.block.fill(0, &values[first * WIDTH..(first + n) * WIDTH], WIDTH);
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

impl crate::corpus::reader::Gather for GatherFeatures {
    type Clip = Features;

    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError> {
        expect_frames(rows, self.n_frames)?;
        let schema = FeaturesTable::schema();
        if !rows.names().iter().eq(schema.fields().iter().map(|field| field.name())) {
            return Err(rows.damaged("not the columns of features"));
        }
        gather_floats(rows, 2, &mut self.values)?;
        self.n_frames += rows.len();
        Ok(())
    }

    fn done(self) -> Features {
        match self.n_frames {
            0 => Features::default(),
            _ => Features { effectors: EFFECTORS.to_vec(), values: self.values },
        }
    }
}
