//! One column of a result, declared once.

use serde::Serialize;
use serde_json::Value;
use std::borrow::Cow;

use super::head::{Format, Good, Head};
use crate::figures::{Figure, Fold, Values};

const MEAN_DECIMALS: usize = 2;

/// A column of rows `R`.
///
/// A cell is the value at the column's name in the row's JSON, a figure of the row's drive
/// ([`Figure::of`](crate::figures::Figure::of)), or the value that [`Column::of`] computes.
///
/// ```
/// use report::results::{Column, number, word};
///
/// #[derive(serde::Serialize)]
/// struct Row {
///     law: &'static str,
///     min_gap_m: Option<f64>,
/// }
///
/// const COLUMNS: &[Column<Row>] = &[
///     word("law", "law", "Control law that drove"),
///     number("min_gap_m", "min gap", "m", 1, "Smallest gap to the vehicle ahead").more(),
/// ];
/// assert_eq!(COLUMNS[1].head.title(), "min gap, m");
/// ```
#[derive(Debug)]
pub struct Column<R> {
    pub head: Head,
    cell: Cell<R>,
}

/// Origin of a column's cells.
#[derive(Debug)]
enum Cell<R> {
    /// The row's JSON, at the column's name.
    Json,
    /// A function of the row.
    Of(fn(&R) -> Value),
    /// A figure among those that the row keeps.
    Figure(Figure, fn(&R) -> &Values),
}

// Derived, these would demand a row that can be copied.
impl<R> Copy for Cell<R> {}

impl<R> Clone for Cell<R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R> Clone for Column<R> {
    fn clone(&self) -> Self {
        Self { head: self.head.clone(), cell: self.cell }
    }
}

type Text = &'static str;

/// A column with all that is said of it; the functions beside it are shorter.
pub const fn column<R>(
    name: Text,
    heading: Text,
    unit: Text,
    format: Format,
    meaning: Text,
) -> Column<R> {
    let head = Head {
        name: Cow::Borrowed(name),
        heading: Cow::Borrowed(heading),
        unit,
        meaning,
        format,
        good: Good::Neither,
        limit: None,
        weight: 0,
        is_hidden: false,
    };
    Column { head, cell: Cell::Json }
}

/// A number with a unit and a number of decimals.
pub const fn number<R>(
    name: Text,
    heading: Text,
    unit: Text,
    decimals: usize,
    meaning: Text,
) -> Column<R> {
    column(name, heading, unit, Format::Decimals(decimals), meaning)
}

pub const fn micros<R>(name: Text, heading: Text, meaning: Text) -> Column<R> {
    column(name, heading, "", Format::Duration, meaning)
}

/// A whole number.
pub const fn count<R>(name: Text, heading: Text, meaning: Text) -> Column<R> {
    column(name, heading, "", Format::Count, meaning)
}

pub const fn word<R>(name: Text, heading: Text, meaning: Text) -> Column<R> {
    column(name, heading, "", Format::Word, meaning)
}

/// A number as it was given, or a word: the value of a key.
pub const fn value<R>(name: Text, heading: Text, meaning: Text) -> Column<R> {
    column(name, heading, "", Format::Value, meaning)
}

/// End of a run.
pub const fn outcome<R>(name: Text) -> Column<R> {
    column(name, "outcome", "", Format::Verdict(outcome_words), "How the run ended")
}

/// A fact that is true or false, neither of which is good.
pub const fn fact<R>(name: Text, heading: Text, meaning: Text) -> Column<R> {
    column(name, heading, "", Format::Fact, meaning)
}

/// Words with their judgement, `{text, ok}`, for people.
pub const fn judged<R>(name: Text, heading: Text, meaning: Text) -> Column<R> {
    column(name, heading, "", Format::Judged, meaning)
}

pub const fn flag<R>(name: Text, heading: Text, words: (Text, Text), meaning: Text) -> Column<R> {
    column(name, heading, "", Format::Flag(words.0, words.1), meaning)
}

fn outcome_words(name: &str) -> (&'static str, bool) {
    use supervise::report::Outcome;
    let outcome = serde_json::from_value::<Outcome>(Value::String(name.to_owned()));
    let outcome = outcome.unwrap_or(Outcome::Aborted);
    (crate::print::outcome_word(outcome), outcome == Outcome::Completed)
}

impl<R> Column<R> {
    /// The same with the least value as the best.
    pub const fn less(mut self) -> Self {
        self.head.good = Good::Less;
        self
    }

    /// The same with the largest value as the best.
    pub const fn more(mut self) -> Self {
        self.head.good = Good::More;
        self
    }

    /// The same with numbers beyond `limit` marked as bad.
    pub const fn limit(mut self, limit: f64) -> Self {
        self.head.limit = Some(limit);
        self
    }

    /// The same with another weight.
    pub const fn weight(mut self, weight: u8) -> Self {
        self.head.weight = weight;
        self
    }

    /// The same in JSON and CSV alone.
    pub const fn hidden(mut self) -> Self {
        self.head.is_hidden = true;
        self
    }

    /// The same with a cell that is computed from the row.
    pub const fn of(mut self, value: fn(&R) -> Value) -> Self {
        self.cell = Cell::Of(value);
        self
    }

    /// The same with a figure of the row's drive in each cell.
    pub(crate) const fn figure(mut self, figure: Figure, values: fn(&R) -> &Values) -> Self {
        self.cell = Cell::Figure(figure, values);
        self
    }

    /// The same under a name and a heading that are known only when the program runs.
    pub fn named(mut self, name: String, heading: String) -> Self {
        (self.head.name, self.head.heading) = (name.into(), heading.into());
        self
    }
}

pub(super) fn cells<R: Serialize>(columns: &[Column<R>], row: &R) -> Vec<Value> {
    let json = serde_json::to_value(row).expect("rows are plain data");
    let cell = |column: &Column<R>| match column.cell {
        Cell::Json => at(&json, &column.head.name).cloned().unwrap_or_default(),
        Cell::Of(value) => value(row),
        Cell::Figure(figure, values) => values(row).get(&figure).into(),
    };
    columns.iter().map(cell).collect()
}

/// The value at a dotted path; a number is a place in a list.
pub fn at<'a>(json: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.').try_fold(json, |json, part| match json {
        Value::Array(list) => list.get(part.parse::<usize>().ok()?),
        json => json.get(part),
    })
}

impl Figure {
    /// A column whose rows have the figure at its name in their JSON.
    pub const fn column<R>(&self) -> Column<R> {
        let format = match self.decimals {
            0 => Format::Count,
            decimals => Format::Decimals(decimals),
        };
        self.formatted(format)
    }

    /// A column of rows that keep the figures of their drive.
    pub const fn of<R>(&self, values: fn(&R) -> &Values) -> Column<R> {
        self.column().figure(*self, values)
    }

    /// A column of rows that fold several runs: a number, or an object `{mean, deviation, n}`.
    pub fn folded<R>(&self) -> Column<R> {
        match (self.fold, self.decimals) {
            (Fold::Mean, 0) => self.formatted(Format::Mean(MEAN_DECIMALS)),
            (_, decimals) => self.formatted(Format::Mean(decimals)),
        }
    }

    const fn formatted<R>(&self, format: Format) -> Column<R> {
        let Self { name, heading, unit, meaning, .. } = *self;
        let mut column = column(name, heading, unit, format, meaning);
        column.head.good = self.good;
        column.head.weight = self.weight;
        column
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_cell_is_what_stands_at_its_name() {
        let columns: [Column<Value>; 4] = [
            number("control.min_gap_m", "min gap", "m", 1, ""),
            word("values.1", "x", ""),
            count("absent", "", ""),
            number("", "twice", "", 0, "").of(|row| json!(row["n"].as_f64().map(|n| 2.0 * n))),
        ];
        let row = json!({"control": {"min_gap_m": 2.25}, "values": ["a", "b"], "n": 4});
        let cells = cells(&columns, &row);
        let texts: Vec<_> = columns.iter().zip(&cells).map(|(c, v)| c.head.text(v)).collect();
        assert_eq!(texts, ["2.2", "b", "-", "8"]);
    }

    #[test]
    fn formats_are_for_people_and_verdicts_are_judged() {
        let head = |column: Column<()>| column.head;
        let outcome = head(outcome("outcome"));
        assert_eq!(outcome.text(&json!("red_light")), "RED LIGHT");
        assert_eq!(outcome.judgement(&json!("completed")), Some(true));
        let mean = head(column("x", "", "", Format::Mean(1), ""));
        assert_eq!(mean.text(&json!({"mean": 2.0, "deviation": 0.5, "n": 3})), "2.0 ± 0.5 (3)");
        assert_eq!(mean.text(&json!({"mean": 2.0, "deviation": null, "n": 1})), "2.0");
        let gain = head(number("x", "", "", 3, "").limit(1.0));
        assert_eq!((gain.judgement(&json!(1.1)), gain.judgement(&json!(0.9))), (Some(false), None));
    }
}
