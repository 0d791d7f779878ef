//! Columns of a table being built: names, metadata and values side by side, so that a schema can't differ from its rows.

use super::error::CorpusError;
use arrow::array::{
    ArrayRef, BooleanArray, Float32Array, Float64Array, Int32Array, Int32Builder, ListBuilder, StringArray,
    StringBuilder, UInt32Array, UInt32Builder, UInt64Array,
};
use arrow::array::{Float64Builder, RecordBatch};
use arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Metadata of a column: `unit`, `space`, `joint`, `role`, `part`.
pub(super) type Notes<'a> = &'a [(&'a str, &'a str)];

/// No metadata.
pub(super) const PLAIN: Notes<'static> = &[];
/// Seconds.
pub(super) const SECONDS: Notes<'static> = &[("unit", "s")];
/// Lengths.
pub(super) const METERS: Notes<'static> = &[("unit", "m")];
/// Positions.
pub(super) const METERS_WORLD: Notes<'static> = &[("unit", "m"), ("space", "world")];
/// Squared distances of eq. 4.1.
pub(super) const SQUARE_METERS: Notes<'static> = &[("unit", "m^2")];

/// Columns in the order of the table.
#[derive(Debug, Default)]
pub(super) struct Columns {
    fields: Vec<Field>,
    arrays: Vec<ArrayRef>,
}

/// A field with metadata; empty values are left out.
pub(super) fn field(name: &str, kind: DataType, nullable: bool, notes: Notes<'_>) -> Field {
    let notes = notes.iter().filter(|(_, value)| !value.is_empty());
    let metadata: BTreeMap<String, String> = notes.map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    Field::new(name, kind, nullable).with_metadata(metadata)
}

/// The type of a list column. `element` is the name that the Parquet format asks for.
pub(super) fn list_of(kind: DataType, nullable: bool) -> DataType {
    DataType::List(Arc::new(element(kind, nullable)))
}

impl Columns {
    pub(super) fn new() -> Columns {
        Columns::default()
    }

    /// The columns' schema.
    pub(super) fn schema(&self) -> SchemaRef {
        Arc::new(Schema::new(self.fields.clone()))
    }

    /// The columns as a batch.
    pub(super) fn into_batch(self) -> Result<RecordBatch, CorpusError> {
        RecordBatch::try_new(Arc::new(Schema::new(self.fields)), self.arrays).map_err(CorpusError::batch)
    }

    fn push(mut self, name: &str, notes: Notes<'_>, kind: DataType, nullable: bool, array: ArrayRef) -> Columns {
        self.fields.push(field(name, kind, nullable, notes));
        self.arrays.push(array);
        self
    }

    pub(super) fn u32(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = u32>) -> Columns {
        self.push(name, notes, DataType::UInt32, false, Arc::new(UInt32Array::from_iter_values(values)))
    }

    pub(super) fn u32_opt(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = Option<u32>>) -> Columns {
        self.push(name, notes, DataType::UInt32, true, Arc::new(UInt32Array::from_iter(values)))
    }

    pub(super) fn u64(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = u64>) -> Columns {
        self.push(name, notes, DataType::UInt64, false, Arc::new(UInt64Array::from_iter_values(values)))
    }

    pub(super) fn i32_opt(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = Option<i32>>) -> Columns {
        self.push(name, notes, DataType::Int32, true, Arc::new(Int32Array::from_iter(values)))
    }

    pub(super) fn f32(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = f32>) -> Columns {
        self.push(name, notes, DataType::Float32, false, Arc::new(Float32Array::from_iter_values(values)))
    }

    pub(super) fn f32_opt(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = Option<f32>>) -> Columns {
        self.push(name, notes, DataType::Float32, true, Arc::new(Float32Array::from_iter(values)))
    }

    pub(super) fn f64(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = f64>) -> Columns {
        self.push(name, notes, DataType::Float64, false, Arc::new(Float64Array::from_iter_values(values)))
    }

    pub(super) fn f64_opt(self, name: &str, notes: Notes<'_>, values: impl Iterator<Item = Option<f64>>) -> Columns {
        self.push(name, notes, DataType::Float64, true, Arc::new(Float64Array::from_iter(values)))
    }

    pub(super) fn bool(self, name: &str, values: impl Iterator<Item = bool>) -> Columns {
        let array = BooleanArray::from_iter(values.map(Some));
        self.push(name, PLAIN, DataType::Boolean, false, Arc::new(array))
    }

    pub(super) fn bool_opt(self, name: &str, values: impl Iterator<Item = Option<bool>>) -> Columns {
        self.push(name, PLAIN, DataType::Boolean, true, Arc::new(BooleanArray::from_iter(values)))
    }

    pub(super) fn str<'v>(self, name: &str, values: impl Iterator<Item = &'v str>) -> Columns {
        self.push(name, PLAIN, DataType::Utf8, false, Arc::new(StringArray::from_iter_values(values)))
    }

    pub(super) fn str_opt<'v>(self, name: &str, values: impl Iterator<Item = Option<&'v str>>) -> Columns {
        self.push(name, PLAIN, DataType::Utf8, true, Arc::new(StringArray::from_iter(values)))
    }

    pub(super) fn str_list<'v>(self, name: &str, lists: impl Iterator<Item = &'v [String]>) -> Columns {
        let mut builder = ListBuilder::new(StringBuilder::new()).with_field(element(DataType::Utf8, false));
        for list in lists {
            list.iter().for_each(|value| builder.values().append_value(value));
            builder.append(true);
        }
        self.push(name, PLAIN, list_of(DataType::Utf8, false), false, Arc::new(builder.finish()))
    }

    pub(super) fn str_opt_list(self, name: &str, lists: impl Iterator<Item = Vec<Option<String>>>) -> Columns {
        let mut builder = ListBuilder::new(StringBuilder::new()).with_field(element(DataType::Utf8, true));
        for list in lists {
            list.iter().for_each(|value| builder.values().append_option(value.as_deref()));
            builder.append(true);
        }
        self.push(name, PLAIN, list_of(DataType::Utf8, true), false, Arc::new(builder.finish()))
    }

    pub(super) fn u32_list<'v>(self, name: &str, lists: impl Iterator<Item = &'v [u32]>) -> Columns {
        let mut builder = ListBuilder::new(UInt32Builder::new()).with_field(element(DataType::UInt32, false));
        for list in lists {
            builder.values().append_slice(list);
            builder.append(true);
        }
        self.push(name, PLAIN, list_of(DataType::UInt32, false), false, Arc::new(builder.finish()))
    }

    /// Integers; `nullable` says whether the elements may be null.
    pub(super) fn i32_list(self, name: &str, nullable: bool, lists: impl Iterator<Item = Vec<Option<i32>>>) -> Columns {
        let mut builder = ListBuilder::new(Int32Builder::new()).with_field(element(DataType::Int32, nullable));
        for list in lists {
            list.iter().for_each(|&value| builder.values().append_option(value));
            builder.append(true);
        }
        self.push(name, PLAIN, list_of(DataType::Int32, nullable), false, Arc::new(builder.finish()))
    }

    /// Numbers; `nullable` says whether the elements may be null.
    pub(super) fn f64_list(
        self,
        name: &str,
        notes: Notes<'_>,
        nullable: bool,
        lists: impl Iterator<Item = Vec<Option<f64>>>,
    ) -> Columns {
        let mut builder = ListBuilder::new(Float64Builder::new()).with_field(element(DataType::Float64, nullable));
        for list in lists {
            list.iter().for_each(|&value| builder.values().append_option(value));
            builder.append(true);
        }
        self.push(name, notes, list_of(DataType::Float64, nullable), false, Arc::new(builder.finish()))
    }
}

fn element(kind: DataType, nullable: bool) -> Field {
    Field::new("element", kind, nullable)
}
