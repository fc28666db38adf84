//! Tables of numbers in CSV, with the place of every field for errors.

use super::error::ScenarioError;
use super::quantity::OutOfRange;
use std::ops::Range;

type Field<'a> = (Range<usize>, &'a str);

/// What some programs begin a file of UTF-8 with.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// A CSV text: a line of names, then lines of numbers. Empty lines and those that start with `#`
/// are passed over.
pub(super) struct Table<'a> {
    source: &'a str,
    text: &'a str,
    names: Vec<Field<'a>>,
    rows: Vec<Vec<Field<'a>>>,
}

impl<'a> Table<'a> {
    /// Splits `text`; `source` stands for it in errors.
    pub(super) fn split(source: &'a str, text: &'a str) -> Self {
        let mut table = Self { source, text, names: Vec::new(), rows: Vec::new() };
        let mut offset = text.len() - text.trim_start_matches(BYTE_ORDER_MARK).len();
        for line in text[offset..].split_inclusive('\n') {
            let bare = line.trim_end_matches(['\n', '\r']);
            if !bare.trim().is_empty() && !bare.starts_with('#') {
                let fields = split(offset, bare);
                if table.names.is_empty() {
                    table.names = fields;
                } else {
                    table.rows.push(fields);
                }
            }
            offset += line.len();
        }
        table
    }

    /// Number of lines of numbers.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Place of the column `name`.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|(_, field)| *field == name)
    }

    /// Place of the column `name`, which must be there; `all` is the line of names as it should be.
    pub(super) fn column(&self, name: &str, all: &str) -> Result<usize, ScenarioError> {
        self.find(name).ok_or_else(|| {
            let span = self.names.first().map_or(0..0, |(span, _)| span.clone());
            ScenarioError::at(self.source, self.text, span, &format!("no column `{name}`"))
                .expecting(format!("the names of the columns in the first line: {all}"))
        })
    }

    /// The number in a field.
    pub(super) fn number<T: TryFrom<f64, Error = OutOfRange<f64>>>(
        &self,
        row: usize,
        column: usize,
    ) -> Result<T, ScenarioError> {
        let (_, name) = self.names[column];
        let Some((span, field)) = self.rows[row].get(column) else {
            let span = self.rows[row].last().map_or(0..0, |(span, _)| span.clone());
            return Err(self
                .refusal(span, &format!("no `{name}` in this line"))
                .expecting("as many columns as in the first line"));
        };
        let value: f64 = field.parse().map_err(|_| {
            self.refusal(span.clone(), &format!("`{field}` is not a number"))
                .expecting(format!("`{name}`"))
        })?;
        T::try_from(value).map_err(|error| self.refusal(span.clone(), &error.to_string()))
    }

    /// An error at a field.
    pub(super) fn fault(&self, row: usize, column: usize, message: &str) -> ScenarioError {
        let span = self.rows[row].get(column).map_or(0..0, |(span, _)| span.clone());
        self.refusal(span, message)
    }

    fn refusal(&self, span: Range<usize>, message: &str) -> ScenarioError {
        ScenarioError::at(self.source, self.text, span, message)
    }
}

fn split(offset: usize, line: &str) -> Vec<Field<'_>> {
    let mut at = offset;
    line.split(',')
        .map(|field| {
            let lead = field.len() - field.trim_start().len();
            let text = field.trim();
            let span = at + lead..at + lead + text.len();
            at += field.len() + 1;
            (span, text)
        })
        .collect()
}
