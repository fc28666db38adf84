//! A writer of flat Parquet files: numbers, whole numbers and texts, any of which may be absent.
//!
//! It writes only the needs of tables of results: plain encoding, one page for each column and row group, compressed
//! with LZ4. pandas, polars, DuckDB and Arrow read it. The crates `parquet` and `arrow` are complete, and take minutes
//! of a first build. A test reads this crate's files with pyarrow.
//!
//! ```text
//! "PAR1", row group*, footer, footer length u32, "PAR1"
//! row group:    column chunk*              one for each column
//! column chunk: page header, page          (page)
//! page:         definition levels, values  out of their compression
//! footer:       schema, places of the column chunks, metadata (thrift)
//! ```
//!
//! Source: the Apache Parquet format, <https://parquet.apache.org/docs/file-format/>, and its `parquet.thrift`.
//!
//! ```
//! use parquet_writer::{Cells, Writer};
//!
//! let mut writer = Writer::new(Vec::new(), &["law", "gap_m"], &[("unit.gap_m", "m")])?;
//! let laws = ["acc-mpc", "six-mode"].map(|law| Some(law.to_owned()));
//! writer.group(&[Cells::Text(laws.to_vec()), Cells::Number(vec![Some(8.25), None])])?;
//! let file = writer.finish()?;
//! assert!(file.starts_with(b"PAR1") && file.ends_with(b"PAR1"));
//! # Ok::<(), std::io::Error>(())
//! ```

mod page;
mod thrift;

pub use page::Cells;

use page::{Kind, LZ4_RAW, PLAIN, RLE};
use std::io::{self, Write};
use thrift::Struct;

/// Begin and end of a file.
const MAGIC: &[u8] = b"PAR1";
/// `OPTIONAL`: every cell may be absent.
const OPTIONAL: i64 = 1;

/// Place and size of a column chunk.
struct Chunk {
    offset: u64,
    values: usize,
    unpacked: usize,
    packed: usize,
}

/// A file that is being written, row group by row group.
pub struct Writer<W> {
    to: W,
    at: u64,
    names: Vec<String>,
    /// Types of the columns, known with the first row group.
    types: Vec<Kind>,
    metadata: Vec<(String, String)>,
    groups: Vec<(usize, Vec<Chunk>)>,
}

impl<W: Write> Writer<W> {
    /// Begins a file with the columns of these names and the metadata of these keys.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(mut to: W, names: &[&str], metadata: &[(&str, &str)]) -> io::Result<Self> {
        to.write_all(MAGIC)?;
        let owned = |text: &&str| (*text).to_owned();
        Ok(Self {
            to,
            at: MAGIC.len() as u64,
            names: names.iter().map(owned).collect(),
            types: Vec::new(),
            metadata: metadata.iter().map(|(key, value)| (owned(key), owned(value))).collect(),
            groups: Vec::new(),
        })
    }

    pub fn metadata(&mut self, key: &str, value: &str) {
        self.metadata.retain(|(known, _)| known != key);
        self.metadata.push((key.to_owned(), value.to_owned()));
    }

    /// Writes a row group: the cells of each column, equally many. One without rows is left out.
    ///
    /// # Errors
    /// If it cannot be written, or does not have the columns and types of the file.
    pub fn group(&mut self, columns: &[Cells]) -> io::Result<()> {
        let rows = columns.first().map_or(0, Cells::len);
        let types: Vec<Kind> = columns.iter().map(Cells::kind).collect();
        let is_table = columns.len() == self.names.len() && columns.iter().all(|c| c.len() == rows);
        if !is_table || !(self.types.is_empty() || self.types == types) {
            let said =
                "a row group with other columns than the file, expected one cell a column and row";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, said));
        }
        self.types = types;
        if rows == 0 {
            return Ok(());
        }
        let mut chunks = Vec::with_capacity(columns.len());
        for cells in columns {
            let (bytes, unpacked) = page::chunk(cells)?;
            self.to.write_all(&bytes)?;
            let packed = bytes.len();
            chunks.push(Chunk { offset: self.at, values: rows, unpacked, packed });
            self.at += packed as u64;
        }
        self.groups.push((rows, chunks));
        Ok(())
    }

    /// Ends the file. One without row groups has columns of numbers.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        self.types.resize(self.names.len(), Kind::NUMBER);
        let footer = self.footer();
        let length = u32::try_from(footer.len()).map_err(io::Error::other)?;
        self.to.write_all(&footer)?;
        self.to.write_all(&length.to_le_bytes())?;
        self.to.write_all(MAGIC)?;
        self.to.flush()?;
        Ok(self.to)
    }

    fn footer(&self) -> Vec<u8> {
        let mut root = Struct::default();
        root.text(4, "schema").i32(5, self.names.len() as i64);
        let mut schema = vec![root];
        for (name, kind) in self.names.iter().zip(&self.types) {
            let mut element = Struct::default();
            element.i32(1, kind.physical).i32(3, OPTIONAL).text(4, name);
            if let Some(converted) = kind.converted {
                element.i32(6, converted);
            }
            schema.push(element);
        }
        let groups = self.groups.iter().map(|(rows, chunks)| {
            let columns = chunks.iter().enumerate().map(|(index, chunk)| {
                let mut about = Struct::default();
                about
                    .i32(1, self.types[index].physical)
                    .i32_list(2, &[PLAIN, RLE])
                    .text_list(3, &[&self.names[index]])
                    .i32(4, LZ4_RAW)
                    .i64(5, chunk.values as i64)
                    .i64(6, chunk.unpacked as i64)
                    .i64(7, chunk.packed as i64)
                    .i64(9, chunk.offset as i64);
                let mut column = Struct::default();
                column.i64(2, chunk.offset as i64).nested(3, about);
                column
            });
            let size: usize = chunks.iter().map(|chunk| chunk.unpacked).sum();
            let mut group = Struct::default();
            group.structs(1, columns.collect()).i64(2, size as i64).i64(3, *rows as i64);
            group
        });
        let metadata = self.metadata.iter().map(|(key, value)| {
            let mut pair = Struct::default();
            pair.text(1, key).text(2, value);
            pair
        });
        let rows: usize = self.groups.iter().map(|(rows, _)| rows).sum();
        let mut file = Struct::default();
        file.i32(1, 1).structs(2, schema).i64(3, rows as i64).structs(4, groups.collect());
        file.structs(5, metadata.collect()).text(6, concat!("timegap ", env!("CARGO_PKG_VERSION")));
        file.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_groups_of_other_shapes_are_refused() {
        let mut writer = Writer::new(Vec::new(), &["a", "b"], &[]).expect("memory");
        let two = |b: Cells| [Cells::Number(vec![Some(1.0)]), b];
        writer.group(&two(Cells::Integer(vec![None]))).expect("it fits");
        assert!(writer.group(&two(Cells::Integer(vec![None, None]))).is_err());
        assert!(writer.group(&two(Cells::Number(vec![None]))).is_err());
        assert!(writer.group(&[Cells::Number(vec![])]).is_err());
        let file = writer.finish().expect("memory");
        let length = u32::from_le_bytes(file[file.len() - 8..][..4].try_into().expect("four"));
        assert!((length as usize) < file.len() - 12);
    }
}
