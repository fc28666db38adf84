//! Lines through one value a row: parallel coordinates.

use super::axis::Axis;
use super::data::{Chart, Series};
use super::{Picture, Stroke, Tone};

/// Height of a row, px: its name above its line.
const ROW_PX: f64 = 42.0;
/// Height of a row's line in it, as a share of the row.
const LINE: f64 = 0.2;
/// Widths of the lines of the first kinds, px; further kinds have the last one. They differ in grey too.
const WIDTHS_PX: [f64; 3] = [2.0, 1.4, 0.7];

/// A line: one value in each row.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Places on the rows, from 0 to 1.
    pub shares: Vec<f64>,
    /// Index of its kind in [`Parallel::kinds`].
    pub kind: usize,
}

/// Many lines over the same rows.
///
/// ```
/// use report::chart::{Parallel, Picture, Polyline, Tone};
///
/// let picture = Parallel {
///     title: "Runs".into(),
///     rows: vec!["speed: 12..36".into(), "gap: 5..80".into()],
///     kinds: vec![("failure".into(), Tone::Alarm), ("others".into(), Tone::Muted)],
///     lines: vec![Polyline { shares: vec![0.9, 0.1], kind: 0 }],
/// };
/// assert_eq!(picture.chart().series.len(), 1, "a kind without a line has no entry");
/// ```
#[derive(Clone, Debug)]
pub struct Parallel {
    pub title: String,
    /// Names of the rows, from top to bottom.
    pub rows: Vec<String>,
    /// Kinds of lines: label and colour. The first is on top.
    pub kinds: Vec<(String, Tone)>,
    pub lines: Vec<Polyline>,
}

impl Picture for Parallel {
    fn title(&self) -> &str {
        &self.title
    }

    fn chart(&self) -> Chart {
        let count = self.rows.len() as f64;
        let (x, y) =
            (Axis::linear("share of the range", 0.0, 1.0), Axis::linear("", 0.0, count.max(1.0)));
        let mut chart = Chart::new(&x, &y, ROW_PX * count);
        chart.y.rows = Some(self.rows.clone());
        chart.y.row_line = Some(LINE);
        for (kind, (label, tone)) in self.kinds.iter().enumerate() {
            let lines = self.lines.iter().filter(|line| line.kind == kind);
            let points: Vec<(f64, f64)> = lines
                .flat_map(|line| {
                    let place =
                        |(row, share): (usize, &f64)| (*share, count - 1.0 - row as f64 + LINE);
                    // A gap after each line.
                    line.shares.iter().enumerate().map(place).chain([(0.0, f64::NAN)])
                })
                .collect();
            if !points.is_empty() {
                let name = (label.as_str(), *tone, Stroke::Solid);
                let width = WIDTHS_PX[kind.min(WIDTHS_PX.len() - 1)];
                chart.series.push(Series::line(name, (width, false), &points, (&x, &y)));
            }
        }
        chart
    }
}
