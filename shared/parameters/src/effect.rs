//! Effect of each number of a table. The number is halved and doubled, and words state the figures that change.
//!
//! ```
//! use parameters::effect::{Figure, effects};
//! use parameters::parameters;
//!
//! parameters! {
//!     /// The brakes of a car.
//!     pub struct Brakes {
//!         /// Largest deceleration.
//!         deceleration_mps2: f64 = 8.0, "m/s²", 4.0..=12.0, "Chosen.";
//!         /// Time before the brakes act.
//!         delay_s: f64 = 0.1, "s", 0.0..=1.0, "Chosen.";
//!     }
//! }
//!
//! let figures = [Figure::value("way to a stop from 20 m/s", "m", 1.0)];
//! let measure = |brakes: &Brakes| vec![20.0 * brakes.delay_s + 200.0 / brakes.deceleration_mps2];
//! let base = measure(&Brakes::DEFAULT);
//! let lines: Vec<String> = effects(&Brakes::DEFAULT, &figures, &base, measure).collect();
//! assert_eq!(
//!     lines[0],
//!     "deceleration_mps2: at 4 way to a stop from 20 m/s 52.00 instead of 27.00 m; \
//!      at 12 way to a stop from 20 m/s 18.67 instead of 27.00 m."
//! );
//! assert_eq!(
//!     lines[1],
//!     "delay_s: at 0.05 way to a stop from 20 m/s 26.00 instead of 27.00 m; \
//!      at 0.2 way to a stop from 20 m/s 29.00 instead of 27.00 m."
//! );
//! ```

use std::borrow::Cow;

use crate::{Row, Table};

/// A figure by which effects are judged.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub name: Cow<'static, str>,
    pub unit: &'static str,
    /// Form of a change, and the smallest one that counts.
    pub change: Change,
}

/// Form of a figure's change, with the smallest one that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The new value beside the usual one.
    Value(f64),
    Difference(f64),
    Percent(f64),
}

impl Figure {
    /// A figure whose new value is shown beside the usual one.
    pub const fn value(name: &'static str, unit: &'static str, counts: f64) -> Self {
        Self { name: Cow::Borrowed(name), unit, change: Change::Value(counts) }
    }

    /// A figure whose difference is shown.
    pub const fn difference(name: &'static str, unit: &'static str, counts: f64) -> Self {
        Self { name: Cow::Borrowed(name), unit, change: Change::Difference(counts) }
    }

    /// A figure whose difference is shown in percent.
    pub const fn percent(name: &'static str, unit: &'static str, counts: f64) -> Self {
        Self { name: Cow::Borrowed(name), unit, change: Change::Percent(counts) }
    }

    pub fn text(&self, value: f64) -> String {
        format!("{}: {value:.3} {}", self.name, self.unit).trim_end().to_owned()
    }

    /// The change in words; `None` if it is too small, or if the figure does not exist.
    fn words(&self, was: f64, is: f64) -> Option<String> {
        let (Self { name, unit, .. }, difference) = (self, is - was);
        let (size, counts, words) = match self.change {
            Change::Value(counts) => {
                (difference, counts, format!("{name} {is:.2} instead of {was:.2} {unit}"))
            }
            Change::Difference(counts) => {
                let digits = usize::from(counts < 1.0) + usize::from(counts < 0.1);
                (difference, counts, format!("{name} {difference:+.digits$} {unit}"))
            }
            Change::Percent(counts) => {
                let percent = 100.0 * difference / was;
                let digits = usize::from(counts < 0.5);
                (percent, counts, format!("{name} {percent:+.digits$} %"))
            }
        };
        (size.abs() >= counts).then(|| words.trim_end().to_owned())
    }
}

/// Effects of a number, in one line: the figures at each of the tried values, beside those of the usual one.
pub fn line(name: &str, figures: &[Figure], base: &[f64], tried: &[(f64, Vec<f64>)]) -> String {
    let words = |changed: &[f64]| -> String {
        let all = figures.iter().zip(base.iter().zip(changed));
        let words: Vec<String> = all.filter_map(|(of, (was, is))| of.words(*was, *is)).collect();
        words.join(", ")
    };
    let effects: Vec<_> = tried.iter().map(|(value, changed)| (value, words(changed))).collect();
    if effects.iter().all(|(_, words)| words.is_empty()) {
        let values: Vec<String> = effects.iter().map(|(value, _)| value.to_string()).collect();
        return format!("{name}: at {} nothing changes.", values.join(" and "));
    }
    let effects = effects.iter().map(|(value, words)| {
        format!("at {value} {}", if words.is_empty() { "no change" } else { words })
    });
    format!("{name}: {}.", effects.collect::<Vec<_>>().join("; "))
}

/// A line for each row of a table. Each value is half or double the usual one, within its range.
pub fn effects<T: Table>(
    usual: &T,
    figures: &[Figure],
    base: &[f64],
    mut measure: impl FnMut(&T) -> Vec<f64>,
) -> impl Iterator<Item = String> {
    T::ROWS.iter().enumerate().map(move |(row, Row { name, .. })| {
        let tried = [0.5, 2.0].map(|factor| {
            let changed = usual.scaled(row, factor);
            (changed.value(row), measure(&changed))
        });
        line(name, figures, base, &tried)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_stated_from_the_smallest_one_that_counts_on() {
        let figures = [
            Figure::value("gap", "m", 0.5),
            Figure::difference("late", "s", 0.05),
            Figure::percent("GOSPA", "m", 2.0),
            Figure::difference("stops", "", 1.0),
        ];
        let base = [10.0, 1.0, 4.0, 3.0];
        let tried = [(0.5, vec![10.4, 1.01, 4.04, 3.0]), (2.0, vec![9.0, 1.5, 4.4, 5.0])];
        assert_eq!(
            line("reach_m", &figures, &base, &tried),
            "reach_m: at 0.5 no change; at 2 gap 9.00 instead of 10.00 m, late +0.50 s, GOSPA +10 %, stops +2."
        );
        assert_eq!(
            line("reach_m", &figures, &base, &tried[..1]),
            "reach_m: at 0.5 nothing changes."
        );
    }

    #[test]
    fn a_figure_that_does_not_exist_has_no_change() {
        let figures = [Figure::percent("gap", "m", 0.0)];
        let tried = [(2.0, vec![f64::NAN])];
        assert_eq!(line("a", &figures, &[1.0], &tried), "a: at 2 nothing changes.");
    }
}
