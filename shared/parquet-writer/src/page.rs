//! A column of a row group: one page with its header.

use crate::thrift::Struct;
use std::io;

/// Physical types.
const INT64: i64 = 2;
const DOUBLE: i64 = 5;
const BYTE_ARRAY: i64 = 6;
/// Converted types.
const UTF8: i64 = 0;
const UINT_64: i64 = 14;
pub(crate) const PLAIN: i64 = 0;
pub(crate) const RLE: i64 = 3;
/// The codec: LZ4's block format without a frame.
pub(crate) const LZ4_RAW: i64 = 7;

/// Type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    pub(crate) physical: i64,
    pub(crate) converted: Option<i64>,
}

impl Kind {
    pub(crate) const NUMBER: Self = Self { physical: DOUBLE, converted: None };
}

#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    Number(Vec<Option<f64>>),
    /// Whole numbers.
    Integer(Vec<Option<i64>>),
    /// Whole numbers without a sign.
    Unsigned(Vec<Option<u64>>),
    Text(Vec<Option<String>>),
}

impl Cells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        match self {
            Self::Number(cells) => cells.len(),
            Self::Integer(cells) => cells.len(),
            Self::Unsigned(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
        }
    }

    /// True if there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn kind(&self) -> Kind {
        match self {
            Self::Number(_) => Kind::NUMBER,
            Self::Integer(_) => Kind { physical: INT64, converted: None },
            Self::Unsigned(_) => Kind { physical: INT64, converted: Some(UINT_64) },
            Self::Text(_) => Kind { physical: BYTE_ARRAY, converted: Some(UTF8) },
        }
    }
}

/// The bytes of a column chunk, and their number out of the compression.
pub(crate) fn chunk(cells: &Cells) -> io::Result<(Vec<u8>, usize)> {
    let mut page = Vec::new();
    match cells {
        Cells::Number(cells) => {
            levels(cells, &mut page);
            cells.iter().flatten().for_each(|cell| page.extend(cell.to_le_bytes()));
        }
        Cells::Integer(cells) => {
            levels(cells, &mut page);
            cells.iter().flatten().for_each(|cell| page.extend(cell.to_le_bytes()));
        }
        Cells::Unsigned(cells) => {
            levels(cells, &mut page);
            cells.iter().flatten().for_each(|cell| page.extend(cell.to_le_bytes()));
        }
        Cells::Text(cells) => {
            levels(cells, &mut page);
            for cell in cells.iter().flatten() {
                page.extend(u32::try_from(cell.len()).map_err(io::Error::other)?.to_le_bytes());
                page.extend(cell.as_bytes());
            }
        }
    }
    let packed = lz4::block::compress(&page, None, false)?;
    // The header's lengths have 31 bits.
    let length = |bytes: usize| i32::try_from(bytes).map(i64::from).map_err(io::Error::other);
    let mut data = Struct::default();
    data.i32(1, length(cells.len())?).i32(2, PLAIN).i32(3, RLE).i32(4, RLE);
    let mut header = Struct::default();
    header.i32(1, 0).i32(2, length(page.len())?).i32(3, length(packed.len())?).nested(5, data);
    let mut bytes = header.finish();
    let unpacked = bytes.len() + page.len();
    bytes.extend(packed);
    Ok((bytes, unpacked))
}

/// Definition levels: 1 for a cell that exists, 0 for one that does not. They are runs behind their length in bytes.
fn levels<T>(cells: &[Option<T>], page: &mut Vec<u8>) {
    let begin = page.len();
    page.extend([0; 4]);
    for run in cells.chunk_by(|a, b| a.is_some() == b.is_some()) {
        let mut head = (run.len() as u64) << 1;
        while head >= 0x80 {
            page.push(head as u8 | 0x80);
            head >>= 7;
        }
        page.push(head as u8);
        page.push(u8::from(run[0].is_some()));
    }
    let length = (page.len() - begin - 4) as u32;
    page[begin..begin + 4].copy_from_slice(&length.to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_runs() {
        let mut page = Vec::new();
        let cells: Vec<Option<u8>> = [vec![Some(1); 100], vec![None; 3]].concat();
        levels(&cells, &mut page);
        assert_eq!(page, [5, 0, 0, 0, 0xC8, 0x01, 1, 6, 0]);
    }
}
