//! The description of a column: name, unit, meaning, format, good values.

use serde_json::Value;
use std::borrow::Cow;

use crate::chart::number as decimals_of;
use crate::table::NONE;

/// Form of a column's cells for people.
#[derive(Clone, Copy, Debug)]
pub enum Format {
    Decimals(usize),
    /// A number with as many decimals as it needs, at most three.
    Exact,
    /// A duration in µs, shown in the unit that suits it.
    Duration,
    /// A whole number.
    Count,
    /// An object `{mean, deviation, n}` with this number of decimals; n is left out where it is null.
    Mean(usize),
    Word,
    /// A number as it was given, or a word.
    Value,
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
}

/// Good values of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Good {
    /// Neither end: the column has no best value.
    #[default]
    Neither,
    /// The least one is the best.
    Less,
    /// The largest one is the best.
    More,
}

/// The description of a column, for rows of any type.
#[derive(Clone, Debug)]
pub struct Head {
    /// Dotted path in the row's JSON (`control.min_gap_m`); empty where only people see the column.
    pub name: Cow<'static, str>,
    /// Heading, without the unit.
    pub heading: Cow<'static, str>,
    /// Unit; empty where there is none.
    pub unit: &'static str,
    pub meaning: &'static str,
    pub format: Format,
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
    pub fn title(&self) -> String {
        match (self.heading.as_ref(), self.unit) {
            (heading, "") => heading.to_owned(),
            ("", unit) => unit.to_owned(),
            (heading, unit) => format!("{heading}, {unit}"),
        }
    }

    /// Name in a table of CSV: the last part of the path.
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
            Format::Decimals(_)
                | Format::Exact
                | Format::Duration
                | Format::Count
                | Format::Mean(_)
        )
    }

    /// True if a cell of it takes lines of its own on a terminal.
    pub(super) fn is_long(&self) -> bool {
        matches!(self.format, Format::Sentence | Format::Command)
    }

    /// A cell's text for people.
    pub fn text(&self, value: &Value) -> String {
        let none = || NONE.to_owned();
        let decimal = |decimals| value.as_f64().map_or_else(none, |v| decimals_of(v, decimals));
        match (self.format, value) {
            (_, Value::Null) => none(),
            (Format::Decimals(decimals), _) => decimal(decimals),
            (Format::Exact, _) => {
                value.as_f64().map_or_else(none, |v| ((v * 1e3).round() / 1e3).to_string())
            }
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

    /// True if a cell is a good or a bad one; `None` where neither is meant.
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

/// A duration in µs with the unit that reads best.
///
/// ```
/// assert_eq!(report::print::duration(1_234.0), "1.23 ms");
/// ```
pub fn duration(us: f64) -> String {
    if us < 1e3 {
        format!("{us:.1} µs")
    } else if us < 1e6 {
        format!("{:.2} ms", us / 1e3)
    } else {
        format!("{:.2} s", us / 1e6)
    }
}
