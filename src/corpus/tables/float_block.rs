//! Rows of a wide table of floats, turned from frames into columns a block at a time.

use crate::corpus::error::CorpusError;
use arrow::array::{ArrayRef, Float32Array, Float64Array, RecordBatch, UInt32Array};
use arrow::datatypes::SchemaRef;
use std::sync::Arc;

/// Rows that are turned at once: they stay in the nearest caches while every column picks its values.
const STRIP: usize = 64;

/// Collects frames of one clip after the other; full blocks come out as batches.
#[derive(Debug)]
pub(in crate::corpus) struct FloatBlock {
    schema: SchemaRef,
    capacity: usize,
    clip_id: Vec<u32>,
    frame: Vec<u32>,
    /// Only where the table has the column.
    time_s: Option<Vec<f64>>,
    columns: Vec<Vec<f32>>,
}

/// A value of a row that becomes one or more columns.
pub(in crate::corpus) trait Cell: Copy {
    /// Columns it becomes.
    const WIDTH: usize;
    /// The value of one of them.
    fn get(self, n: usize) -> f32;
    /// Whether all of it is finite as an f32.
    fn is_finite(self) -> bool;
}

impl Cell for f32 {
    const WIDTH: usize = 1;

    fn get(self, _: usize) -> f32 {
        self
    }

    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

impl Cell for glam::DVec3 {
    const WIDTH: usize = 3;

    fn get(self, n: usize) -> f32 {
        self[n] as f32
    }

    fn is_finite(self) -> bool {
        // Beyond f32's range a finite f64 becomes infinite.
        self.abs().max_element() <= f64::from(f32::MAX) && !self.is_nan()
    }
}

impl Cell for glam::DQuat {
    const WIDTH: usize = 4;

    fn get(self, n: usize) -> f32 {
        self.to_array()[n] as f32
    }

    fn is_finite(self) -> bool {
        glam::DQuat::is_finite(self)
    }
}

/// Where the first value that isn't finite lies.
pub(in crate::corpus) fn first_not_finite<C: Cell>(values: &[C]) -> Option<usize> {
    // Most clips have none: a sum of flags over a strip goes faster than a search.
    let strips = values.chunks(4096).enumerate();
    let mut bad = strips.filter(|(_, strip)| strip.iter().fold(false, |bad, value| bad | !value.is_finite()));
    bad.next().and_then(|(n, strip)| strip.iter().position(|value| !value.is_finite()).map(|at| n * 4096 + at))
}

impl FloatBlock {
    /// `n_columns` floats after `clip_id`, `frame` and, if the table has it, `time_s`.
    pub(in crate::corpus) fn new(schema: SchemaRef, capacity: usize, timed: bool, n_columns: usize) -> FloatBlock {
        FloatBlock {
            schema,
            capacity,
            clip_id: Vec::new(),
            frame: Vec::new(),
            time_s: timed.then(Vec::new),
            columns: vec![Vec::new(); n_columns],
        }
    }

    /// Rows that still fit.
    pub(in crate::corpus) fn room(&self) -> usize {
        self.capacity - self.clip_id.len()
    }

    /// Appends `n` rows of a clip from `first`; their columns follow with [`FloatBlock::fill`].
    pub(in crate::corpus) fn begin_rows(&mut self, clip_id: u32, rate_hz: f64, first: usize, n: usize) {
        self.clip_id.resize(self.clip_id.len() + n, clip_id);
        self.frame.extend((first..first + n).map(|frame| frame as u32));
        if let Some(time_s) = &mut self.time_s {
            time_s.extend((first..first + n).map(|frame| frame as f64 / rate_hz));
        }
    }

    /// The columns from `column` on, of the rows just begun: `values` is `[row][cell]`.
    pub(in crate::corpus) fn fill<C: Cell>(&mut self, column: usize, values: &[C], cells: usize) {
        if cells == 0 {
            return;
        }
        let columns = &mut self.columns[column..column + cells * C::WIDTH];
        for column in columns.iter_mut().filter(|column| column.is_empty()) {
            column.reserve_exact(self.capacity);
        }
        for strip in values.chunks(STRIP * cells) {
            for (at, columns) in columns.chunks_exact_mut(C::WIDTH).enumerate() {
                for (n, column) in columns.iter_mut().enumerate() {
                    // Of known length, so that the vector grows once a strip.
                    column.extend(strip.chunks_exact(cells).map(|row| row[at].get(n)));
                }
            }
        }
    }

    /// What has been collected, as a batch; empties the block. None: nothing.
    pub(in crate::corpus) fn take(&mut self) -> Result<Option<RecordBatch>, CorpusError> {
        if self.clip_id.is_empty() {
            return Ok(None);
        }
        let mut arrays: Vec<ArrayRef> = vec![
            Arc::new(UInt32Array::from(std::mem::take(&mut self.clip_id))),
            Arc::new(UInt32Array::from(std::mem::take(&mut self.frame))),
        ];
        if let Some(time_s) = &mut self.time_s {
            arrays.push(Arc::new(Float64Array::from(std::mem::take(time_s))));
        }
        for column in &mut self.columns {
            arrays.push(Arc::new(Float32Array::from(std::mem::take(column))));
        }
        RecordBatch::try_new(self.schema.clone(), arrays).map(Some).map_err(CorpusError::batch)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn what_is_not_finite_is_found_where_it_is() {
        let mut values = vec![0.5f32; 10_000];
        assert_eq!(first_not_finite(&values), None);
        values[9_000] = f32::NAN;
        values[9_500] = f32::INFINITY;
        assert_eq!(first_not_finite(&values), Some(9_000));
        assert_eq!(first_not_finite(&[glam::DVec3::new(0.0, 1e39, 0.0)]), Some(0));
        assert_eq!(first_not_finite(&[glam::DVec3::new(0.0, -3e38, 0.0)]), None);
        assert_eq!(first_not_finite(&[glam::DVec3::ONE, glam::DVec3::new(0.0, 0.0, f64::NAN)]), Some(1));
    }

    #[test]
    fn frames_become_columns() {
        use arrow::datatypes::{DataType, Field, Schema};
        let fields = [("clip_id", DataType::UInt32), ("frame", DataType::UInt32), ("a", DataType::Float32)];
        let mut fields: Vec<Field> = fields.map(|(name, kind)| Field::new(name, kind, false)).into();
        fields.push(Field::new("b", DataType::Float32, false));
        let mut block = FloatBlock::new(Arc::new(Schema::new(fields)), 200, false, 2);
        let values: Vec<f32> = (0..300).map(|n| n as f32).collect();
        block.begin_rows(7, 30.0, 5, 150);
        block.fill(0, &values, 2);
        assert_eq!(block.room(), 50);
        let batch = block.take().unwrap().unwrap();
        let odd = batch.column(3).as_any().downcast_ref::<Float32Array>().unwrap();
        assert!((0..150).all(|row| odd.value(row) == (2 * row + 1) as f32));
        assert_eq!(block.room(), 200);
        assert!(block.take().unwrap().is_none());
    }
}
