//! Tables as Parquet files, which pandas, polars, Julia and R read with their types.
//!
//! Tested by `tests/ensembles/large_tables.rs`.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::table::{Column, Table};

impl Table {
    /// A Parquet file with one group of rows.
    ///
    /// # Errors
    /// The errors of `to`.
    pub fn write_parquet(&self, to: &mut (impl Write + Send)) -> io::Result<()> {
        self.write_groups(std::iter::empty(), to).map_err(io::Error::other)
    }

    /// The rows of this one and those of others with the same columns, a group each.
    pub(crate) fn write_parquet_parts(
        &self,
        rest: impl Iterator<Item = Self>,
        to: &mut (impl Write + Send),
    ) -> io::Result<()> {
        self.write_groups(rest, to).map_err(io::Error::other)
    }

    fn write_groups(
        &self,
        rest: impl Iterator<Item = Self>,
        to: &mut (impl Write + Send),
    ) -> Result<(), ParquetError> {
        let fields = self.columns().iter().map(|(name, column)| {
            let (physical, logical) = match column {
                Column::Number(_) => (Physical::DOUBLE, None),
                Column::Count(_) => (Physical::INT64, Some(LogicalType::integer(64, false))),
                Column::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED);
            field.with_logical_type(logical).build().map(Arc::new)
        });
        let fields = fields.collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder(self.name()).with_fields(fields).build()?;
        let properties = Arc::new(WriterProperties::builder().build());
        let mut file = SerializedFileWriter::new(to, Arc::new(schema), properties)?;
        self.write_group(&mut file)?;
        for part in rest {
            part.write_group(&mut file)?;
        }
        file.close()?;
        Ok(())
    }

    fn write_group(&self, file: &mut SerializedFileWriter<impl Write + Send>) -> Result<(), ParquetError> {
        let mut rows = file.next_row_group()?;
        for (_, column) in self.columns() {
            let Some(mut writer) = rows.next_column()? else { break };
            match column {
                Column::Number(entries) => {
                    writer.typed::<DoubleType>().write_batch(entries, None, None)?;
                }
                Column::Count(entries) => {
                    let entries: Vec<i64> = entries.iter().map(|entry| entry.cast_signed()).collect();
                    writer.typed::<Int64Type>().write_batch(&entries, None, None)?;
                }
                Column::Text(entries) => {
                    let entries: Vec<ByteArray> = entries.iter().map(|entry| entry.as_str().into()).collect();
                    writer.typed::<ByteArrayType>().write_batch(&entries, None, None)?;
                }
            }
            writer.close()?;
        }
        rows.close()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs::{self, File};

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use crate::saving::table::TableRows;

    /// Every entry comes back, to the last bit.
    #[test]
    fn files_are_read_back() {
        let numbers = [0.1, -0.0, f64::NAN, f64::INFINITY, 5e-324, f64::MAX];
        let table = TableRows::of(numbers.iter().enumerate())
            .column("name", |(i, _)| format!("é, \"{i}\""))
            .column("count", |(i, _)| 10_u64.pow(3 * *i as u32))
            .column("number", |(_, number)| **number)
            .table("mixed");
        let path = std::env::temp_dir().join(format!("wzvi-columnar-{}.parquet", std::process::id()));
        crate::saving::file::replace(&path, |file| table.write_parquet(file)).unwrap();
        let file = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        let mut rows = 0;
        for (i, row) in file.get_row_iter(None).unwrap().enumerate() {
            let row = row.unwrap();
            let entries: Vec<(&String, &Field)> = row.get_column_iter().collect();
            assert_eq!(*entries[0].1, Field::Str(format!("é, \"{i}\"")));
            assert_eq!(*entries[1].1, Field::ULong(10_u64.pow(3 * i as u32)));
            let Field::Double(number) = *entries[2].1 else { panic!("{entries:?}") };
            assert_eq!(number.to_bits(), numbers[i].to_bits());
            assert_eq!(entries[2].0, "number");
            rows += 1;
        }
        assert_eq!(rows, numbers.len());
        fs::remove_file(path).unwrap();
    }
}
