//! One published figure beside ours.

use serde::Serialize;
use std::fmt::Write;

/// A published figure and what a run gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Scenario and figure, joined by dots.
    pub id: String,
    /// Which set of weights, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
    /// Unit of the numbers.
    pub unit: &'static str,
    /// The paper's value; null where it gives words only.
    pub paper: Option<f64>,
    /// Ours; null where the run never got there.
    pub ours: Option<f64>,
    /// Largest accepted difference; null where nothing is checked.
    pub tolerance: Option<f64>,
    /// Whether ours is accepted.
    pub ok: bool,
    /// What a number cannot say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<&'static str>,
}

/// What comes of comparing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within the tolerance.
    Within,
    /// Outside, or missing.
    Outside,
    /// Shown, not checked.
    Shown,
}

impl Row {
    /// A figure that must lie within `tolerance` of the paper's.
    pub fn near(
        id: &str,
        unit: &'static str,
        paper: f64,
        ours: Option<f64>,
        tolerance: f64,
    ) -> Self {
        let ok = ours.is_some_and(|ours| (ours - paper).abs() <= tolerance + 1e-9);
        Self {
            id: id.into(),
            weights: None,
            unit,
            paper: Some(paper),
            ours,
            tolerance: Some(tolerance),
            ok,
            note: None,
        }
    }

    /// A figure that must not exceed the paper's by more than `tolerance`.
    pub fn at_most(
        id: &str,
        unit: &'static str,
        paper: f64,
        ours: Option<f64>,
        tolerance: f64,
    ) -> Self {
        let ok = ours.is_some_and(|ours| ours <= paper + tolerance + 1e-9);
        Self { ok, note: Some("an upper bound"), ..Self::near(id, unit, paper, ours, tolerance) }
    }

    /// A figure that the paper gives in words only: shown, not checked.
    pub fn shown(id: &str, unit: &'static str, ours: Option<f64>, note: &'static str) -> Self {
        let row = Self::near(id, unit, 0.0, ours, 0.0);
        Self { paper: None, tolerance: None, ok: true, note: Some(note), ..row }
    }

    /// The same row with what a number cannot say.
    pub fn with_note(self, note: &'static str) -> Self {
        Self { note: Some(note), ..self }
    }

    /// What comes of comparing.
    pub fn verdict(&self) -> Verdict {
        match (self.tolerance, self.ok) {
            (None, _) => Verdict::Shown,
            (Some(_), true) => Verdict::Within,
            (Some(_), false) => Verdict::Outside,
        }
    }
}

/// The rows as a table for people.
pub fn table(paper: &str, rows: &[Row]) -> String {
    let within = rows.iter().filter(|row| row.verdict() == Verdict::Within).count();
    let checked = rows.iter().filter(|row| row.verdict() != Verdict::Shown).count();
    let mut text = format!("{paper}: {within} of {checked} figures within their tolerance\n");
    let width = rows.iter().map(|row| row.id.chars().count()).max().unwrap_or(0);
    let mut weights = None;
    for row in rows {
        if row.weights != weights {
            weights.clone_from(&row.weights);
            if let Some(weights) = &weights {
                writeln!(text, "  weights: {weights}").expect("a string takes all");
            }
        }
        let number = |value: Option<f64>| value.map_or_else(|| "-".into(), |v| format!("{v:.2}"));
        let mark = match row.verdict() {
            Verdict::Within => "ok",
            Verdict::Outside => "OUTSIDE",
            Verdict::Shown => "",
        };
        let tolerance = row.tolerance.map_or_else(String::new, |t| format!("± {t:.2}"));
        let note = row.note.unwrap_or_default();
        let line = format!(
            "  {:<width$}  paper {:>7}  ours {:>7} {:<4} {tolerance:<7} {mark:<7} {note}",
            row.id,
            number(row.paper),
            number(row.ours),
            row.unit,
        );
        writeln!(text, "{}", line.trim_end()).expect("a string takes all");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_judged_by_their_tolerance() {
        assert_eq!(Row::near("a", "s", 4.0, Some(3.9), 0.1).verdict(), Verdict::Within);
        assert_eq!(Row::near("a", "s", 4.0, Some(3.89), 0.1).verdict(), Verdict::Outside);
        assert_eq!(Row::near("a", "s", 4.0, None, 0.1).verdict(), Verdict::Outside);
        assert_eq!(Row::at_most("a", "s", 30.0, Some(24.0), 0.5).verdict(), Verdict::Within);
        assert_eq!(Row::shown("a", "m", Some(1.0), "large").verdict(), Verdict::Shown);
    }

    #[test]
    fn a_row_outside_its_tolerance_is_not_hidden() {
        let text = table("cacc", &[Row::near("A.x", "s", 4.0, Some(3.0), 0.1)]);
        assert!(text.contains("0 of 1") && text.contains("OUTSIDE"), "{text}");
    }
}
