//! Recordings and other tables as Parquet: one row group, every column required.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type, Int64Type};
use parquet::errors::Result;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::mark;
use crate::{Cells, Recording};

/// Writes the recording.
pub(super) fn write(recording: &Recording, to: impl Write + Send) -> Result<()> {
    write_table("recording", &recording.columns(), to)
}

/// Writes columns of one length, compressed with Snappy, with the mark of this tool in the metadata.
pub(super) fn write_table(name: &str, columns: &[(&str, Cells<'_>)], to: impl Write + Send) -> Result<()> {
    let fields = columns.iter().map(|(name, cells)| field(name, cells)).collect::<Result<_>>()?;
    let schema = Arc::new(Type::group_type_builder(name).with_fields(fields).build()?);
    let written_by = KeyValue::new("written_by".to_owned(), mark::WORDS.to_owned());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(vec![written_by]))
        .build();
    let mut writer = SerializedFileWriter::new(to, schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, cells) in columns {
        if let Some(mut column) = group.next_column()? {
            write_column(&mut column, cells)?;
            column.close()?;
        }
    }
    group.close()?;
    writer.close().map(drop)
}

fn field(name: &str, cells: &Cells<'_>) -> Result<TypePtr> {
    let unsigned = |bit_width| Some(LogicalType::Integer { bit_width, is_signed: false });
    let (physical, logical) = match cells {
        Cells::Real(_) => (PhysicalType::DOUBLE, None),
        Cells::Seq(_) => (PhysicalType::INT64, unsigned(64)),
        Cells::Fault(_) => (PhysicalType::INT32, unsigned(32)),
        Cells::Counts(_) => (PhysicalType::INT64, None),
        Cells::Mode(_) | Cells::Text(_) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let field = Type::primitive_type_builder(name, physical)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(logical)
        .build()?;
    Ok(Arc::new(field))
}

fn write_column(column: &mut SerializedColumnWriter<'_>, cells: &Cells<'_>) -> Result<()> {
    match cells {
        Cells::Real(values) => column.typed::<DoubleType>().write_batch(values, None, None)?,
        // The bits of an unsigned number; the logical type tells the reader.
        Cells::Seq(values) => {
            let bits: Vec<i64> = values.iter().map(|value| value.cast_signed()).collect();
            column.typed::<Int64Type>().write_batch(&bits, None, None)?
        }
        Cells::Fault(values) => {
            let bits: Vec<i32> = values.iter().map(|value| value.cast_signed()).collect();
            column.typed::<Int32Type>().write_batch(&bits, None, None)?
        }
        Cells::Counts(values) => column.typed::<Int64Type>().write_batch(values, None, None)?,
        Cells::Mode(values) => {
            let words: Vec<ByteArray> = values.iter().map(|mode| ByteArray::from(mode.name())).collect();
            column.typed::<ByteArrayType>().write_batch(&words, None, None)?
        }
        Cells::Text(values) => {
            let texts: Vec<ByteArray> = values.iter().map(|text| ByteArray::from(text.as_str())).collect();
            column.typed::<ByteArrayType>().write_batch(&texts, None, None)?
        }
    };
    Ok(())
}
