//! Cells of one column of a row group, whatever type the writer chose for it.

use parquet::basic::{ConvertedType, LogicalType};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::reader::RowGroupReader;
use parquet::schema::types::ColumnDescPtr;

use super::corrupt;
use crate::columns::Complaint;
use crate::values::Cell;

/// Rows decoded at a time.
const BATCH: usize = 1 << 16;

/// Passes each of the `rows` cells of column `index` to `take`, none for a null.
pub(super) fn each_cell(
    group: &dyn RowGroupReader,
    index: usize,
    rows: usize,
    take: impl FnMut(Option<Cell>) -> Result<(), Complaint>,
) -> Result<(), Complaint> {
    let descriptor = group.metadata().schema_descr().column(index);
    let pages = group.get_column_page_reader(index).map_err(corrupt)?;
    let reader = get_column_reader(descriptor.clone(), Box::new(PlausiblePages { pages, rows }));
    let unsigned = is_unsigned(&descriptor);
    match reader {
        ColumnReader::BoolColumnReader(reader) => cells(reader, rows, |flag| Ok(Cell::Text(flag.to_string())), take),
        ColumnReader::Int32ColumnReader(reader) if unsigned => {
            cells(reader, rows, |bits| Ok(Cell::Whole(bits.cast_unsigned().into())), take)
        }
        ColumnReader::Int64ColumnReader(reader) if unsigned => {
            cells(reader, rows, |bits| Ok(Cell::Whole(bits.cast_unsigned().into())), take)
        }
        ColumnReader::Int32ColumnReader(reader) => cells(reader, rows, |whole| Ok(Cell::Whole((*whole).into())), take),
        ColumnReader::Int64ColumnReader(reader) => cells(reader, rows, |whole| Ok(Cell::Whole((*whole).into())), take),
        ColumnReader::FloatColumnReader(reader) => cells(reader, rows, |real| Ok(Cell::Real((*real).into())), take),
        ColumnReader::DoubleColumnReader(reader) => cells(reader, rows, |real| Ok(Cell::Real(*real)), take),
        ColumnReader::ByteArrayColumnReader(reader) => cells(reader, rows, text, take),
        ColumnReader::Int96ColumnReader(_) | ColumnReader::FixedLenByteArrayColumnReader(_) => {
            let message = format!("holds {}, which is neither number nor text", descriptor.physical_type());
            Err(Complaint::new(descriptor.name(), message))
        }
    }
}

fn is_unsigned(descriptor: &ColumnDescPtr) -> bool {
    matches!(descriptor.logical_type(), Some(LogicalType::Integer { is_signed: false, .. }))
        || matches!(
            descriptor.converted_type(),
            ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64
        )
}

fn text(bytes: &ByteArray) -> Result<Cell, Complaint> {
    Ok(Cell::Text(bytes.as_utf8().map_err(corrupt)?.to_owned()))
}

fn cells<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    cell: impl Fn(&T::T) -> Result<Cell, Complaint>,
    mut take: impl FnMut(Option<Cell>) -> Result<(), Complaint>,
) -> Result<(), Complaint> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let mut left = rows;
    while left > 0 {
        values.clear();
        levels.clear();
        let (read, ..) = reader.read_records(left.min(BATCH), Some(&mut levels), None, &mut values).map_err(corrupt)?;
        if read == 0 {
            return Err(corrupt(format!("a column ends {left} rows early")));
        }
        left = left.saturating_sub(read);
        if levels.is_empty() {
            values.iter().try_for_each(|value| take(Some(cell(value)?)))?;
        } else {
            let mut values = values.iter();
            for level in &levels {
                let value = if *level == 0 { None } else { values.next() };
                take(value.map(&cell).transpose()?)?;
            }
        }
    }
    Ok(())
}

/// Pages whose counts can be true: the decoder allots memory by them before it looks at the data.
struct PlausiblePages {
    pages: Box<dyn PageReader>,
    /// Of the row group.
    rows: usize,
}

impl PageReader for PlausiblePages {
    fn get_next_page(&mut self) -> ParquetResult<Option<Page>> {
        let page = self.pages.get_next_page()?;
        let plausible = match &page {
            // A number takes four bytes at least, and a text the four of its length.
            Some(Page::DictionaryPage { buf, num_values, .. }) => *num_values as usize <= buf.len() / 4,
            Some(page) => page.num_values() as usize <= self.rows,
            None => true,
        };
        if plausible {
            Ok(page)
        } else {
            Err(ParquetError::General("a page claims more values than it can hold".into()))
        }
    }

    fn peek_next_page(&mut self) -> ParquetResult<Option<PageMetadata>> {
        self.pages.peek_next_page()
    }

    fn skip_next_page(&mut self) -> ParquetResult<()> {
        self.pages.skip_next_page()
    }

    fn at_record_boundary(&mut self) -> ParquetResult<bool> {
        self.pages.at_record_boundary()
    }
}

impl Iterator for PlausiblePages {
    type Item = ParquetResult<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}
