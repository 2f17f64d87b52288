//! Tables between Python and the commands, by the Arrow C data interface in Python's capsules.

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type,
    UInt32Type, UInt64Type,
};
use arrow_array::{
    Array, ArrayRef, Float64Array, Int64Array, RecordBatch, RecordBatchIterator, StringArray, UInt32Array, UInt64Array,
};
use arrow_pyarrow::FromPyArrow;
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use pyo3::exceptions::{PyRuntimeError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use recording::{Cell, Cells, InMemory};

/// A table that pandas, polars, pyarrow and every other reader of Arrow takes without a copy: `pandas.DataFrame.from_arrow`,
/// `polars.DataFrame`, `pyarrow.table`.
#[derive(Debug)]
#[pyclass(frozen, module = "servo_lab")]
pub struct Table {
    batch: RecordBatch,
}

#[pymethods]
impl Table {
    /// The table as an Arrow stream; the schema is always its own.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A wish, by the interface: who asks casts what it gets.
        drop(requested_schema);
        let batches = RecordBatchIterator::new([Ok(self.batch.clone())], self.batch.schema());
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), c"arrow_array_stream")
    }

    /// Names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.batch.schema().fields().iter().map(|field| field.name().clone()).collect()
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __repr__(&self) -> String {
        format!("<servo_lab.Table: {} rows of {}>", self.batch.num_rows(), self.column_names().join(", "))
    }
}

impl Table {
    /// Of columns of one length, none of them nullable.
    ///
    /// # Errors
    /// Columns of different lengths.
    pub fn new(columns: &[(&str, Cells<'_>)]) -> PyResult<Self> {
        let arrays: Vec<ArrayRef> = columns.iter().map(|(_, cells)| array(*cells)).collect();
        let fields = columns.iter().zip(&arrays);
        let fields: Vec<Field> =
            fields.map(|((name, _), array)| Field::new(*name, array.data_type().clone(), false)).collect();
        let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays);
        Ok(Self { batch: batch.map_err(|error| PyRuntimeError::new_err(error.to_string()))? })
    }
}

fn array(cells: Cells<'_>) -> ArrayRef {
    match cells {
        Cells::Real(values) => Arc::new(Float64Array::from(values.to_vec())),
        Cells::Mode(modes) => Arc::new(StringArray::from_iter_values(modes.iter().map(|mode| mode.name()))),
        Cells::Seq(values) => Arc::new(UInt64Array::from(values.to_vec())),
        Cells::Fault(values) => Arc::new(UInt32Array::from(values.to_vec())),
        Cells::Counts(values) => Arc::new(Int64Array::from(values.to_vec())),
        Cells::Text(texts) => Arc::new(StringArray::from_iter_values(texts)),
    }
}

/// The batches of whatever offers an Arrow stream, as they lie in memory.
#[derive(Debug)]
pub struct Batches {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

impl Batches {
    /// Of a data frame or table; `name` tells it in the message.
    ///
    /// # Errors
    /// A `TypeError` for what offers none; what its own library raises.
    pub fn of(name: &str, data: &Bound<'_, PyAny>) -> PyResult<Self> {
        if !data.hasattr("__arrow_c_stream__")? {
            let kind = data.get_type().fully_qualified_name()?.to_string();
            return Err(PyTypeError::new_err(format!(
                "{name}: {kind} is neither the path of a recording nor a table that offers Arrow; pandas from 2.2, polars \
                 and pyarrow do"
            )));
        }
        let stream = RecordBatchStreamReader::from_pyarrow_bound(data)?;
        let schema = arrow_array::RecordBatchReader::schema(&stream);
        let batches = stream.collect::<Result<Vec<_>, _>>();
        Ok(Self { schema, batches: batches.map_err(|error| PyRuntimeError::new_err(format!("{name}: {error}")))? })
    }

    /// The columns, whose cells are read where they lie.
    pub fn columns(&self) -> Vec<InMemory<'_>> {
        let column = |(index, field): (usize, &Arc<Field>)| InMemory {
            name: field.name().clone(),
            cells: Box::new(self.batches.iter().flat_map(move |batch| cells(batch.column(index).as_ref()))),
        };
        self.schema.fields().iter().enumerate().map(column).collect()
    }
}

type Iter<'a> = Box<dyn Iterator<Item = Result<Option<Cell>, String>> + 'a>;

/// The cells of one array, as those of a Parquet file are.
fn cells(array: &dyn Array) -> Iter<'_> {
    match array.data_type() {
        DataType::Float64 => numbers::<Float64Type>(array, Cell::Real),
        DataType::Float32 => numbers::<Float32Type>(array, |value| Cell::Real(value.into())),
        DataType::Int8 => numbers::<Int8Type>(array, |value| Cell::Whole(value.into())),
        DataType::Int16 => numbers::<Int16Type>(array, |value| Cell::Whole(value.into())),
        DataType::Int32 => numbers::<Int32Type>(array, |value| Cell::Whole(value.into())),
        DataType::Int64 => numbers::<Int64Type>(array, |value| Cell::Whole(value.into())),
        DataType::UInt8 => numbers::<UInt8Type>(array, |value| Cell::Whole(value.into())),
        DataType::UInt16 => numbers::<UInt16Type>(array, |value| Cell::Whole(value.into())),
        DataType::UInt32 => numbers::<UInt32Type>(array, |value| Cell::Whole(value.into())),
        DataType::UInt64 => numbers::<UInt64Type>(array, |value| Cell::Whole(value.into())),
        DataType::Utf8 => texts(array.as_string::<i32>().iter()),
        DataType::LargeUtf8 => texts(array.as_string::<i64>().iter()),
        DataType::Utf8View => texts(array.as_string_view().iter()),
        // Categories of pandas and polars.
        DataType::Dictionary(_, _) => {
            let dictionary = array.as_any_dictionary();
            let values: Vec<_> = cells(dictionary.values().as_ref()).collect();
            if values.is_empty() {
                return Box::new((0..array.len()).map(|_| Ok(None)));
            }
            let keys = dictionary.normalized_keys();
            Box::new((0..array.len()).map(move |row| {
                if array.is_null(row) { Ok(None) } else { values.get(keys[row]).cloned().unwrap_or(Ok(None)) }
            }))
        }
        other => {
            let message = format!("holds {other}, which is neither number nor text");
            Box::new(std::iter::once(Err(message)))
        }
    }
}

fn numbers<T: ArrowPrimitiveType>(array: &dyn Array, cell: fn(T::Native) -> Cell) -> Iter<'_> {
    Box::new(array.as_primitive::<T>().iter().map(move |value| Ok(value.map(cell))))
}

fn texts<'a>(texts: impl Iterator<Item = Option<&'a str>> + 'a) -> Iter<'a> {
    Box::new(texts.map(|text| Ok(text.map(|text| Cell::Text(text.to_owned())))))
}
