//! Rows of a table being read: columns by name, with the types and nulls that the schema allows, or an error.

use super::error::CorpusError;
use arrow::array::{
    Array, ArrayRef, AsArray, BooleanArray, Float32Array, Float64Array, ListArray, PrimitiveArray, RecordBatch,
    StringArray, UInt32Array,
};
use arrow::datatypes::{
    ArrowPrimitiveType, DataType, Float32Type, Float64Type, Int32Type, Schema, UInt32Type, UInt64Type,
};
use std::path::Path;

/// A batch of a file; every getter checks name, type and nulls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<'a> {
    batch: &'a RecordBatch,
    path: &'a Path,
}

impl<'a> Rows<'a> {
    pub(super) fn new(batch: &'a RecordBatch, path: &'a Path) -> Rows<'a> {
        Rows { batch, path }
    }

    pub(super) fn len(&self) -> usize {
        self.batch.num_rows()
    }

    pub(super) fn damaged(&self, what: impl Into<String>) -> CorpusError {
        CorpusError::damaged(self.path, what)
    }

    pub(super) fn schema(&self) -> &'a Schema {
        self.batch.schema_ref()
    }

    /// Names of all columns, in order.
    pub(super) fn names(&self) -> Vec<&'a str> {
        self.batch.schema_ref().fields().iter().map(|field| field.name().as_str()).collect()
    }

    /// Whether there is a column of that name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.batch.schema_ref().index_of(name).is_ok()
    }

    /// Values of the n-th column, which must be an f32 column without nulls.
    pub(super) fn nth_f32(&self, column: usize) -> Result<&'a [f32], CorpusError> {
        let array = self.batch.columns().get(column).ok_or_else(|| self.damaged(format!("no column {column}")))?;
        let array = array.as_primitive_opt::<Float32Type>();
        let array = array.ok_or_else(|| self.damaged(format!("column {column} is not f32")))?;
        self.no_nulls(array, &format!("number {column}"))?;
        Ok(array.values())
    }

    pub(super) fn u32(&self, name: &str) -> Result<&'a [u32], CorpusError> {
        Ok(self.whole::<UInt32Type>(name)?.values())
    }

    pub(super) fn u64(&self, name: &str) -> Result<&'a [u64], CorpusError> {
        Ok(self.whole::<UInt64Type>(name)?.values())
    }

    pub(super) fn f32(&self, name: &str) -> Result<&'a [f32], CorpusError> {
        Ok(self.whole::<Float32Type>(name)?.values())
    }

    pub(super) fn f64(&self, name: &str) -> Result<&'a [f64], CorpusError> {
        Ok(self.whole::<Float64Type>(name)?.values())
    }

    pub(super) fn u32_opt(&self, name: &str) -> Result<&'a UInt32Array, CorpusError> {
        self.primitive::<UInt32Type>(name)
    }

    pub(super) fn i32_opt(&self, name: &str) -> Result<&'a PrimitiveArray<Int32Type>, CorpusError> {
        self.primitive::<Int32Type>(name)
    }

    pub(super) fn f32_opt(&self, name: &str) -> Result<&'a Float32Array, CorpusError> {
        self.primitive::<Float32Type>(name)
    }

    pub(super) fn f64_opt(&self, name: &str) -> Result<&'a Float64Array, CorpusError> {
        self.primitive::<Float64Type>(name)
    }

    pub(super) fn bool_opt(&self, name: &str) -> Result<&'a BooleanArray, CorpusError> {
        self.column(name)?.as_boolean_opt().ok_or_else(|| self.wrong_type(name, "bool"))
    }

    pub(super) fn bool(&self, name: &str) -> Result<&'a BooleanArray, CorpusError> {
        let array = self.bool_opt(name)?;
        self.no_nulls(array, name)?;
        Ok(array)
    }

    pub(super) fn str_opt(&self, name: &str) -> Result<&'a StringArray, CorpusError> {
        self.column(name)?.as_string_opt().ok_or_else(|| self.wrong_type(name, "str"))
    }

    pub(super) fn str(&self, name: &str) -> Result<&'a StringArray, CorpusError> {
        let array = self.str_opt(name)?;
        self.no_nulls(array, name)?;
        Ok(array)
    }

    pub(super) fn str_opt_lists(&self, name: &str) -> Result<Vec<Vec<Option<String>>>, CorpusError> {
        self.lists(name, |list| {
            let list = list.as_string_opt::<i32>().ok_or_else(|| self.wrong_type(name, "list<str>"))?;
            Ok(list.iter().map(|value| value.map(str::to_owned)).collect())
        })
    }

    pub(super) fn str_lists(&self, name: &str) -> Result<Vec<Vec<String>>, CorpusError> {
        let lists = self.str_opt_lists(name)?.into_iter();
        lists.map(|list| self.all_there(name, list)).collect()
    }

    pub(super) fn u32_lists(&self, name: &str) -> Result<Vec<Vec<u32>>, CorpusError> {
        self.lists(name, |list| self.all_there(name, self.numbers::<UInt32Type>(name, list)?))
    }

    pub(super) fn i32_opt_lists(&self, name: &str) -> Result<Vec<Vec<Option<i32>>>, CorpusError> {
        self.lists(name, |list| self.numbers::<Int32Type>(name, list))
    }

    pub(super) fn f64_opt_lists(&self, name: &str) -> Result<Vec<Vec<Option<f64>>>, CorpusError> {
        self.lists(name, |list| self.numbers::<Float64Type>(name, list))
    }

    fn column(&self, name: &str) -> Result<&'a ArrayRef, CorpusError> {
        self.batch.column_by_name(name).ok_or_else(|| self.damaged(format!("no column `{name}`")))
    }

    fn primitive<T: ArrowPrimitiveType>(&self, name: &str) -> Result<&'a PrimitiveArray<T>, CorpusError> {
        self.column(name)?.as_primitive_opt().ok_or_else(|| self.wrong_type(name, &T::DATA_TYPE.to_string()))
    }

    fn whole<T: ArrowPrimitiveType>(&self, name: &str) -> Result<&'a PrimitiveArray<T>, CorpusError> {
        let array = self.primitive(name)?;
        self.no_nulls(array, name)?;
        Ok(array)
    }

    fn lists<T>(&self, name: &str, each: impl Fn(&ArrayRef) -> Result<T, CorpusError>) -> Result<Vec<T>, CorpusError> {
        let array: &ListArray = self.column(name)?.as_list_opt().ok_or_else(|| self.wrong_type(name, "list"))?;
        self.no_nulls(array, name)?;
        (0..array.len()).map(|row| each(&array.value(row))).collect()
    }

    fn numbers<T: ArrowPrimitiveType>(
        &self,
        name: &str,
        list: &ArrayRef,
    ) -> Result<Vec<Option<T::Native>>, CorpusError> {
        let list = list.as_primitive_opt::<T>();
        Ok(list.ok_or_else(|| self.wrong_type(name, &format!("list<{}>", T::DATA_TYPE)))?.iter().collect())
    }

    fn all_there<T>(&self, name: &str, list: Vec<Option<T>>) -> Result<Vec<T>, CorpusError> {
        let whole: Option<Vec<T>> = list.into_iter().collect();
        whole.ok_or_else(|| self.damaged(format!("null in a list of column `{name}`")))
    }

    fn no_nulls(&self, array: &dyn Array, name: &str) -> Result<(), CorpusError> {
        match array.null_count() {
            0 => Ok(()),
            n => Err(self.damaged(format!("{n} nulls in column `{name}`, which has none"))),
        }
    }

    fn wrong_type(&self, name: &str, wanted: &str) -> CorpusError {
        let found = self.batch.column_by_name(name).map_or(DataType::Null, |array| array.data_type().clone());
        self.damaged(format!("column `{name}` is {found}, not {wanted}"))
    }
}
