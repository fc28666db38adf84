//! Tables of numbers in CSV, with the place of every field for errors.

use super::error::ScenarioError;
use crate::quantity::OutOfRange;
use std::ops::Range;

type Field<'a> = (Range<usize>, &'a str);

/// Mark at the beginning of some files in UTF-8.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// The separators between the fields of a line.
const SEPARATORS: [char; 3] = [',', ';', '\t'];

/// A CSV text: a line of names, then lines of numbers. The line of names decides which separator it has. Fields may
/// stand in quotes. Empty lines and those that start with `#` are passed over. Where commas do not separate, a number
/// may have a decimal comma.
pub(crate) struct Table<'a> {
    source: &'a str,
    text: &'a str,
    separator: char,
    names: Vec<Field<'a>>,
    rows: Vec<Vec<Field<'a>>>,
}

impl<'a> Table<'a> {
    /// Splits `text`; `source` stands for it in errors.
    pub(crate) fn split(source: &'a str, text: &'a str) -> Self {
        let separator = SEPARATORS[0];
        let mut table = Self { source, text, separator, names: Vec::new(), rows: Vec::new() };
        let mut offset = text.len() - text.trim_start_matches(BYTE_ORDER_MARK).len();
        for line in text[offset..].split_inclusive('\n') {
            let bare = line.trim_end_matches(['\n', '\r']);
            if !bare.trim().is_empty() && !bare.starts_with('#') {
                if table.names.is_empty() {
                    let counts = SEPARATORS.map(|separator| split(offset, bare, separator).len());
                    // The first of those with the most fields.
                    let most = counts.iter().max().copied().unwrap_or_default();
                    let best = counts.iter().position(|count| *count == most).unwrap_or_default();
                    table.separator = SEPARATORS[best];
                    table.names = split(offset, bare, table.separator);
                } else {
                    table.rows.push(split(offset, bare, table.separator));
                }
            }
            offset += line.len();
        }
        table
    }

    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Place of the column `name`.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|(_, field)| *field == name)
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &'a str> + '_ {
        self.names.iter().map(|(_, name)| *name)
    }

    /// Place of the column `name`, which must be there; `all` is the line of names as it should be.
    pub(crate) fn column(&self, name: &str, all: &str) -> Result<usize, ScenarioError> {
        self.find(name).ok_or_else(|| {
            let span = self.names.first().map_or(0..0, |(span, _)| span.clone());
            ScenarioError::at(self.source, self.text, span, &format!("no column `{name}`"))
                .expecting(format!("the names of the columns in the first line: {all}"))
        })
    }

    pub(crate) fn text(&self, row: usize, column: usize) -> Option<&'a str> {
        self.rows[row].get(column).map(|(_, field)| *field)
    }

    /// The number in a field, in the range of its quantity.
    pub(crate) fn number<T: TryFrom<f64, Error = OutOfRange<f64>>>(
        &self,
        row: usize,
        column: usize,
    ) -> Result<T, ScenarioError> {
        let value = self.float(row, column)?;
        T::try_from(value).map_err(|OutOfRange { value, range }| {
            let message = format!("{value} is out of range");
            self.fault(row, column, &message).expecting(range.to_string())
        })
    }

    /// The number in a field, which may be NaN.
    pub(crate) fn float(&self, row: usize, column: usize) -> Result<f64, ScenarioError> {
        let (_, name) = self.names[column];
        let Some((span, field)) = self.rows[row].get(column) else {
            let span = self.rows[row].last().map_or(0..0, |(span, _)| span.clone());
            return Err(self
                .refusal(span, &format!("no `{name}` in this line"))
                .expecting("as many columns as in the first line"));
        };
        let point = if self.separator == ',' { "," } else { "." };
        field.replace(',', point).parse().map_err(|_| {
            self.refusal(span.clone(), &format!("`{field}` is not a number"))
                .expecting(format!("`{name}`"))
        })
    }

    pub(crate) fn fault(&self, row: usize, column: usize, message: &str) -> ScenarioError {
        let span = self.rows[row].get(column).map_or(0..0, |(span, _)| span.clone());
        self.refusal(span, message)
    }

    fn refusal(&self, span: Range<usize>, message: &str) -> ScenarioError {
        ScenarioError::at(self.source, self.text, span, message)
    }
}

/// Fields of a line that begins at `offset`. A separator in quotes separates nothing.
fn split(offset: usize, line: &str, separator: char) -> Vec<Field<'_>> {
    let mut is_quoted = false;
    let mut at = offset;
    line.split(|c: char| {
        is_quoted ^= c == '"';
        c == separator && !is_quoted
    })
    .map(|field| {
        let lead = field.len() - field.trim_start().len();
        let text = field.trim();
        let span = at + lead..at + lead + text.len();
        at += field.len() + separator.len_utf8();
        let bare = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        bare.map_or((span.clone(), text), |bare| (span.start + 1..span.end - 1, bare))
    })
    .collect()
}
