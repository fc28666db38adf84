//! Rows under their columns, ready for every output.

use serde::Serialize;
use serde_json::Value;

use super::column::{Column, cells};
use super::head::{Good, Head};
use crate::table::csv_row;

/// A name and its value in words. A fact without a name belongs to the one before it.
pub type Fact = (String, String);

/// A table of a result. It does not depend on the type of its rows any more.
#[derive(Clone, Debug)]
pub struct Table {
    pub(super) heading: String,
    pub(super) columns: Vec<Head>,
    pub(super) rows: Vec<Vec<Value>>,
    /// Place of the column that splits the rows into blocks.
    pub(super) block: Option<usize>,
    /// Most rows that a terminal shows.
    pub(super) most_rows: usize,
    /// The outputs that show it.
    pub(super) place: Place,
    /// Its rows are cases of a continuous integration job.
    pub(super) has_cases: bool,
    /// HTML behind the block of this name.
    pub(super) figures: Vec<(String, String)>,
}

/// The outputs for people that show a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Everywhere,
    Pages,
    Terminals,
}

impl Table {
    /// A table of `rows`.
    ///
    /// ```
    /// use report::results::{Column, Table, number, word};
    ///
    /// #[derive(serde::Serialize)]
    /// struct Row { law: &'static str, jerk_mps3: f64 }
    /// const COLUMNS: &[Column<Row>] = &[
    ///     word("law", "law", "Control law"),
    ///     number("jerk_mps3", "jerk", "m/s³", 1, "Largest jerk").less(),
    /// ];
    /// let rows = [Row { law: "a", jerk_mps3: 2.0 }, Row { law: "b", jerk_mps3: 1.0 }];
    /// let table = Table::new("Laws", COLUMNS, &rows);
    /// assert_eq!(table.console(80), "  law  jerk, m/s³\n  a           2.0\n  b           1.0*\n");
    /// assert_eq!(table.csv(), "law,jerk_mps3\na,2\nb,1\n");
    /// ```
    pub fn new<'a, R: Serialize + 'a>(
        heading: &str,
        columns: &[Column<R>],
        rows: impl IntoIterator<Item = &'a R>,
    ) -> Self {
        Self {
            heading: heading.to_owned(),
            columns: columns.iter().map(|column| column.head.clone()).collect(),
            rows: rows.into_iter().map(|row| cells(columns, row)).collect(),
            block: None,
            most_rows: usize::MAX,
            place: Place::Everywhere,
            has_cases: true,
            figures: Vec::new(),
        }
    }

    /// The same in blocks: rows with the same value of column `name` stand below it.
    ///
    /// # Panics
    /// If there is no such column.
    pub fn blocks(mut self, name: &str) -> Self {
        let place = self.columns.iter().position(|column| column.name == name);
        self.block = Some(place.expect("blocks are by a column of the table"));
        self
    }

    /// The same with at most this number of rows on a terminal: the first ones, and the last.
    pub fn most_rows(mut self, rows: usize) -> Self {
        self.most_rows = rows;
        self
    }

    /// The same on the page and in Markdown alone.
    pub fn for_pages(mut self) -> Self {
        self.place = Place::Pages;
        self
    }

    /// The same on a terminal alone.
    pub fn for_terminals(mut self) -> Self {
        self.place = Place::Terminals;
        self
    }

    /// True if pages and Markdown show it.
    pub(super) fn is_on_pages(&self) -> bool {
        self.place != Place::Terminals && !self.rows.is_empty()
    }

    pub(super) fn is_on_terminals(&self) -> bool {
        self.place != Place::Pages && !self.rows.is_empty()
    }

    /// The same whose rows are not cases of a job.
    pub fn without_cases(mut self) -> Self {
        self.has_cases = false;
        self
    }

    /// Adds HTML that the page shows behind the block of this name (behind the table: an empty name).
    pub fn figures(mut self, block: &str, html: String) -> Self {
        self.figures.push((block.to_owned(), html));
        self
    }

    /// One line for each row, under the names of the columns; empty where a figure does not apply.
    pub fn csv(&self) -> String {
        let named: Vec<usize> = self.csv_columns().collect();
        let mut text = csv_row(named.iter().map(|&place| self.columns[place].field()));
        for row in &self.rows {
            text.extend(csv_row(named.iter().map(|&place| field(&row[place]))));
        }
        String::from_utf8(text).expect("made of strings")
    }

    fn csv_columns(&self) -> impl Iterator<Item = usize> {
        (0..self.columns.len()).filter(|&place| in_csv(&self.columns[place]))
    }

    pub(super) fn row_blocks(&self) -> Vec<(String, std::ops::Range<usize>)> {
        let Some(place) = self.block else { return vec![(String::new(), 0..self.rows.len())] };
        let mut first = 0;
        let blocks = self.rows.chunk_by(|a, b| a[place] == b[place]).map(|rows| {
            let range = first..first + rows.len();
            first = range.end;
            (self.columns[place].text(&rows[0][place]), range)
        });
        blocks.collect()
    }

    /// Places of the columns that a block shows: those with a value in one of its rows.
    pub(super) fn shown(&self, rows: &std::ops::Range<usize>) -> Vec<usize> {
        let has_value = |place: usize| {
            rows.is_empty() || self.rows[rows.clone()].iter().any(|row| !row[place].is_null())
        };
        (0..self.columns.len())
            .filter(|&place| Some(place) != self.block && !self.columns[place].is_hidden)
            .filter(|&place| has_value(place))
            .collect()
    }

    /// True if the row broke nothing.
    pub(super) fn is_good(&self, row: usize) -> bool {
        let pairs = self.columns.iter().zip(&self.rows[row]);
        pairs
            .filter(|(head, _)| head.is_verdict())
            .all(|(head, v)| head.judgement(v) != Some(false))
    }

    /// The text of the best cell of a column in a block. A row that broke something cannot be the best. One row alone,
    /// or equal ones, are not the best of anything.
    pub(super) fn best(&self, column: usize, rows: &std::ops::Range<usize>) -> Option<String> {
        let head = &self.columns[column];
        let sign = match head.good {
            Good::Neither => return None,
            Good::Less => 1.0,
            Good::More => -1.0,
        };
        let all = rows.clone().filter(|&row| !self.rows[row][column].is_null());
        let texts: Vec<String> = all.map(|row| head.text(&self.rows[row][column])).collect();
        if texts.iter().all(|text| *text == texts[0]) {
            return None;
        }
        let good = rows.clone().filter(|&row| self.is_good(row));
        let ranked = good.filter_map(|row| Some((head.rank(&self.rows[row][column])?, row)));
        let best = ranked.min_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)))?;
        Some(head.text(&self.rows[best.1][column]))
    }
}

impl Head {
    pub(super) fn is_verdict(&self) -> bool {
        matches!(
            self.format,
            super::Format::Flag(..) | super::Format::Verdict(_) | super::Format::Judged
        )
    }
}

fn in_csv(head: &Head) -> bool {
    !head.name.is_empty() && !matches!(head.format, super::Format::Judged)
}

/// A field of CSV: all digits of a number; nothing where nothing applies.
pub fn field(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Number(number) => match (number.as_i64(), number.as_f64()) {
            // As Rust writes it: without an exponent, and without `.0`.
            (None, Some(number)) => number.to_string(),
            _ => number.to_string(),
        },
        Value::Array(list) => list.iter().map(field).collect::<Vec<_>>().join(" "),
        value => value.to_string(),
    }
}

pub fn csv_names<R>(columns: &[Column<R>]) -> impl Iterator<Item = &str> {
    columns.iter().filter(|column| in_csv(&column.head)).map(|column| column.head.field())
}

/// The fields of a row under these names.
pub fn csv_fields<R: Serialize>(columns: &[Column<R>], row: &R) -> impl Iterator<Item = String> {
    // Rows without columns are not turned into JSON: there may be a million of them.
    let cells = if columns.is_empty() { Vec::new() } else { cells(columns, row) };
    let named = columns.iter().zip(cells).filter(|(column, _)| in_csv(&column.head));
    named.map(|(_, value)| field(&value))
}

#[cfg(test)]
mod tests {
    use super::super::column::{number, outcome, word};
    use super::*;
    use serde_json::json;

    pub(crate) fn table(rows: &[Value]) -> Table {
        let columns: [Column<Value>; 4] = [
            word("scene", "scene", ""),
            word("law", "law", ""),
            outcome("outcome"),
            number("gap_m", "gap", "m", 1, "").more(),
        ];
        Table::new("Runs", &columns, rows)
    }

    #[test]
    fn a_row_that_broke_something_is_not_the_best_and_blocks_are_judged_apart() {
        let row = |scene, law, outcome, gap| json!({"scene": scene, "law": law, "outcome": outcome, "gap_m": gap});
        let table = table(&[
            row("a", "x", "completed", 2.0),
            row("a", "y", "completed", 1.0),
            row("a", "z", "collision", 9.0),
            row("b", "x", "completed", 5.0),
        ])
        .blocks("scene");
        let blocks = table.row_blocks();
        assert_eq!(blocks.len(), 2);
        assert_eq!(table.best(3, &blocks[0].1).as_deref(), Some("2.0"));
        assert_eq!(table.best(3, &blocks[1].1), None);
    }

    #[test]
    fn csv_has_all_digits_and_the_same_fields_one_by_one() {
        let rows = [json!({"law": "a, b", "gap_m": 0.1234567}), json!({"law": "c", "gap_m": null})];
        let columns: [Column<Value>; 2] = [
            word("law", "law", ""),
            number("control.gap_m", "gap", "m", 1, "").of(|row| row["gap_m"].clone()),
        ];
        let whole = Table::new("", &columns, &rows).csv();
        assert_eq!(whole, "law,gap_m\n\"a, b\",0.1234567\nc,\n");
        assert_eq!(csv_names(&columns).collect::<Vec<_>>(), ["law", "gap_m"]);
        assert_eq!(csv_fields(&columns, &rows[1]).collect::<Vec<_>>(), ["c", ""]);
    }
}
