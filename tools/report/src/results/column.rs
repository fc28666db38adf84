//! One column of a result, declared once.

use serde::Serialize;
use serde_json::Value;
use std::borrow::Cow;

use crate::chart::number as decimals_of;
use crate::duration::duration;
use crate::table::NONE;

/// How a column's cells look for people.
#[derive(Clone, Copy, Debug)]
pub enum Format {
    /// A number with so many decimals.
    Decimals(usize),
    /// A duration in µs, shown in the unit that suits it.
    Duration,
    /// A whole number.
    Count,
    /// An object `{mean, deviation, n}`, shown with so many decimals; n is left out where it is null.
    Mean(usize),
    /// A short word.
    Word,
    /// A sentence, which a terminal shows below its row.
    Sentence,
    /// A command, which is never broken into lines.
    Command,
    /// True and false in words; only the first is good.
    Flag(&'static str, &'static str),
    /// True and false as yes and no, neither of which is good.
    Fact,
    /// A word that is a verdict; the function gives its text and whether it is good.
    Verdict(fn(&str) -> (&'static str, bool)),
    /// An object `{text, ok}`: words and whether they are good. Only people see it.
    Judged,
    /// A nested object or list. It is in the JSON alone.
    Nested(Kind),
}

/// The type of a nested value in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `{}`.
    Object,
    /// `[]`.
    List,
}

/// Which values of a column are good ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Good {
    /// Neither end: the column has no best value.
    Neither,
    /// The least one is the best.
    Less,
    /// The largest one is the best.
    More,
}

/// What a column is, whatever its rows are.
#[derive(Clone, Debug)]
pub struct Head {
    /// Dotted path in the row's JSON (`control.min_gap_m`); empty where only people see the column.
    pub name: Cow<'static, str>,
    /// Heading, without the unit.
    pub heading: Cow<'static, str>,
    /// Unit; empty where there is none.
    pub unit: &'static str,
    /// What it means, in one sentence.
    pub meaning: &'static str,
    /// How its cells look.
    pub format: Format,
    /// Which values are good.
    pub good: Good,
    /// A limit beyond which a number is bad.
    pub limit: Option<f64>,
    /// Columns of the largest weight are left out first where there is no room; 0: never.
    pub weight: u8,
    /// It is in JSON and CSV alone.
    pub is_hidden: bool,
}

impl Head {
    /// Heading with the unit: `min gap, m`.
    #[must_use]
    pub fn title(&self) -> String {
        match (self.heading.as_ref(), self.unit) {
            (heading, "") => heading.to_owned(),
            ("", unit) => unit.to_owned(),
            (heading, unit) => format!("{heading}, {unit}"),
        }
    }

    /// Name in a table of CSV: the last part of the path.
    #[must_use]
    pub fn field(&self) -> &str {
        match self.name.rsplit('.').next() {
            Some(last) if last.bytes().all(|byte| byte.is_ascii_digit()) => &self.heading,
            last => last.unwrap_or_default(),
        }
    }

    /// True if its cells are flush right.
    pub(super) fn is_number(&self) -> bool {
        matches!(
            self.format,
            Format::Decimals(_) | Format::Duration | Format::Count | Format::Mean(_)
        )
    }

    /// True if a cell of it takes lines of its own on a terminal.
    pub(super) fn is_long(&self) -> bool {
        matches!(self.format, Format::Sentence | Format::Command)
    }

    /// A cell's text for people.
    #[must_use]
    pub fn text(&self, value: &Value) -> String {
        let none = || NONE.to_owned();
        let decimal = |decimals| value.as_f64().map_or_else(none, |v| decimals_of(v, decimals));
        match (self.format, value) {
            (_, Value::Null) => none(),
            (Format::Decimals(decimals), _) => decimal(decimals),
            (Format::Duration, _) => value.as_f64().map_or_else(none, duration),
            (Format::Mean(decimals), Value::Object(parts)) => {
                let part = |name: &str| parts.get(name).and_then(Value::as_f64);
                match (part("mean"), part("deviation"), part("n")) {
                    (None, ..) => none(),
                    (Some(mean), Some(spread), Some(n)) => {
                        format!(
                            "{} ± {} ({n})",
                            decimals_of(mean, decimals),
                            decimals_of(spread, decimals)
                        )
                    }
                    (Some(mean), Some(spread), None) => {
                        format!(
                            "{} ± {}",
                            decimals_of(mean, decimals),
                            decimals_of(spread, decimals)
                        )
                    }
                    (Some(mean), ..) => decimals_of(mean, decimals),
                }
            }
            (Format::Mean(decimals), _) => decimal(decimals),
            (Format::Judged, value) => value["text"].as_str().unwrap_or_default().to_owned(),
            (Format::Flag(yes, no), Value::Bool(flag)) => (if *flag { yes } else { no }).to_owned(),
            (Format::Fact, Value::Bool(fact)) => (if *fact { "yes" } else { "no" }).to_owned(),
            (Format::Verdict(words), Value::String(word)) => words(word).0.to_owned(),
            (Format::Count, Value::Number(_)) => {
                value.as_f64().map_or_else(none, |count| decimals_of(count, 0))
            }
            (_, Value::String(word)) => word.clone(),
            (_, Value::Array(list)) => {
                let words = list
                    .iter()
                    .map(|one| one.as_str().map_or_else(|| one.to_string(), str::to_owned));
                words.collect::<Vec<_>>().join(" ")
            }
            _ => value.to_string(),
        }
    }

    /// Whether a cell is a good or a bad one; none where neither is meant.
    pub(super) fn judgement(&self, value: &Value) -> Option<bool> {
        match (self.format, value) {
            (Format::Flag(..), Value::Bool(flag)) => Some(*flag),
            (Format::Judged, value) => value["ok"].as_bool(),
            (Format::Verdict(words), Value::String(word)) => Some(words(word).1),
            _ => {
                let (limit, value) = (self.limit?, value.as_f64()?);
                let is_beyond = if self.good == Good::More { value < limit } else { value > limit };
                is_beyond.then_some(false)
            }
        }
    }

    /// The number by which cells are compared.
    pub(super) fn rank(&self, value: &Value) -> Option<f64> {
        match value {
            Value::Object(parts) => parts.get("mean").and_then(Value::as_f64),
            value => value.as_f64(),
        }
    }
}

/// A column of rows `R`.
///
/// A cell is what stands at the column's name in the row's JSON, or what [`Column::of`] computes.
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
    /// What it is.
    pub head: Head,
    value: Option<fn(&R) -> Value>,
}

impl<R> Clone for Column<R> {
    fn clone(&self) -> Self {
        Self { head: self.head.clone(), value: self.value }
    }
}

/// A column with all that is said of it; the functions beside it are shorter.
pub const fn column<R>(
    name: &'static str,
    heading: &'static str,
    unit: &'static str,
    format: Format,
    meaning: &'static str,
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
    Column { head, value: None }
}

/// A number with a unit, shown with so many decimals.
pub const fn number<R>(
    name: &'static str,
    heading: &'static str,
    unit: &'static str,
    decimals: usize,
    meaning: &'static str,
) -> Column<R> {
    column(name, heading, unit, Format::Decimals(decimals), meaning)
}

/// A duration in µs.
pub const fn micros<R>(
    name: &'static str,
    heading: &'static str,
    meaning: &'static str,
) -> Column<R> {
    column(name, heading, "", Format::Duration, meaning)
}

/// A whole number.
pub const fn count<R>(
    name: &'static str,
    heading: &'static str,
    meaning: &'static str,
) -> Column<R> {
    column(name, heading, "", Format::Count, meaning)
}

/// A short word.
pub const fn word<R>(
    name: &'static str,
    heading: &'static str,
    meaning: &'static str,
) -> Column<R> {
    column(name, heading, "", Format::Word, meaning)
}

/// How a run ended.
pub const fn outcome<R>(name: &'static str) -> Column<R> {
    column(name, "outcome", "", Format::Verdict(outcome_words), "How the run ended")
}

/// A fact that is true or false, neither of which is good.
pub const fn fact<R>(
    name: &'static str,
    heading: &'static str,
    meaning: &'static str,
) -> Column<R> {
    column(name, heading, "", Format::Fact, meaning)
}

/// Words with their judgement, `{text, ok}`, for people.
pub const fn judged<R>(
    name: &'static str,
    heading: &'static str,
    meaning: &'static str,
) -> Column<R> {
    column(name, heading, "", Format::Judged, meaning)
}

/// A flag that is a verdict.
pub const fn flag<R>(
    name: &'static str,
    heading: &'static str,
    words: (&'static str, &'static str),
    meaning: &'static str,
) -> Column<R> {
    column(name, heading, "", Format::Flag(words.0, words.1), meaning)
}

/// A nested object or list, in the JSON alone.
pub const fn nested<R>(name: &'static str, kind: Kind, meaning: &'static str) -> Column<R> {
    column(name, "", "", Format::Nested(kind), meaning).hidden()
}

fn outcome_words(name: &str) -> (&'static str, bool) {
    use runtime::report::Outcome;
    let outcome = serde_json::from_value::<Outcome>(Value::String(name.to_owned()));
    let outcome = outcome.unwrap_or(Outcome::Aborted);
    (crate::print::outcome_word(outcome), outcome == Outcome::Completed)
}

impl<R> Column<R> {
    /// The same with the least value as the best.
    #[must_use]
    pub const fn less(mut self) -> Self {
        self.head.good = Good::Less;
        self
    }

    /// The same with the largest value as the best.
    #[must_use]
    pub const fn more(mut self) -> Self {
        self.head.good = Good::More;
        self
    }

    /// The same with numbers beyond `limit` marked as bad.
    #[must_use]
    pub const fn limit(mut self, limit: f64) -> Self {
        self.head.limit = Some(limit);
        self
    }

    /// The same with another weight.
    #[must_use]
    pub const fn weight(mut self, weight: u8) -> Self {
        self.head.weight = weight;
        self
    }

    /// The same in JSON and CSV alone.
    #[must_use]
    pub const fn hidden(mut self) -> Self {
        self.head.is_hidden = true;
        self
    }

    /// The same with a cell that is computed from the row.
    #[must_use]
    pub const fn of(mut self, value: fn(&R) -> Value) -> Self {
        self.value = Some(value);
        self
    }

    /// The same under a name and a heading that are known only when the program runs.
    #[must_use]
    pub fn named(mut self, name: String, heading: String) -> Self {
        (self.head.name, self.head.heading) = (name.into(), heading.into());
        self
    }
}

/// The cells of a row.
pub(super) fn cells<R: Serialize>(columns: &[Column<R>], row: &R) -> Vec<Value> {
    let json = serde_json::to_value(row).expect("rows are plain data");
    let cell = |column: &Column<R>| match column.value {
        Some(value) => value(row),
        None => at(&json, &column.head.name).cloned().unwrap_or_default(),
    };
    columns.iter().map(cell).collect()
}

/// What stands at a dotted path; a number is a place in a list.
#[must_use]
pub fn at<'a>(json: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.').try_fold(json, |json, part| match json {
        Value::Array(list) => list.get(part.parse::<usize>().ok()?),
        json => json.get(part),
    })
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
