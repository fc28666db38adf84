//! Rows over one axis: labelled spans, or lines through one value a row (parallel coordinates).

use super::axis::Axis;
use super::data::{Chart, Series};
use super::{Mark, Picture, Stroke, Tone};

/// Height of a row, px: its name above its bar or line.
const ROW_PX: f64 = 42.0;
/// Lower and upper edge of a row's bar, as shares of the row.
const BAR: (f64, f64) = (0.12, 0.6);

/// A part of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Begin on the axis.
    pub from: f64,
    /// End on the axis.
    pub to: f64,
    /// Text inside the span where it fits, and in the legend.
    pub label: String,
    pub tone: Tone,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Text above the bar.
    pub name: String,
    pub spans: Vec<Span>,
}

/// Rows over one axis.
///
/// ```
/// use report::chart::{Axis, Bands, Picture, Row, Span, Tone};
///
/// let span = |from, to, label: &str, tone| Span { from, to, label: label.into(), tone };
/// let spans = vec![
///     span(0.0, 9.0, "cruise", Tone::Series(0)),
///     span(9.0, 20.0, "follow", Tone::Series(1)),
/// ];
/// let rows = vec![Row { name: "mode of the law".into(), spans }];
/// let bands = Bands { title: "Modes".into(), x: Axis::time(20.0), rows, marks: Vec::new() };
/// assert_eq!(bands.chart().series.len(), 2, "one entry of the legend per label");
/// ```
#[derive(Clone, Debug)]
pub struct Bands {
    pub title: String,
    pub x: Axis,
    /// The rows from top to bottom.
    pub rows: Vec<Row>,
    /// Marked places on the axis.
    pub marks: Vec<Mark>,
}

/// Spans of one label and colour, as boxes from corner to corner.
type Boxes<'a> = ((&'a str, Tone), Vec<[(f64, f64); 2]>);

impl Picture for Bands {
    fn title(&self) -> &str {
        &self.title
    }

    /// A series for each label and colour, in order of appearance.
    fn chart(&self) -> Chart {
        let count = self.rows.len() as f64;
        let y = Axis::linear("", 0.0, count.max(1.0));
        let mut kinds: Vec<Boxes<'_>> = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            let floor = count - 1.0 - index as f64;
            for span in &row.spans {
                let corners = [(span.from, floor + BAR.0), (span.to, floor + BAR.1)];
                let kind = (span.label.as_str(), span.tone);
                match kinds.iter_mut().find(|(known, _)| *known == kind) {
                    Some((_, boxes)) => boxes.push(corners),
                    None => kinds.push((kind, vec![corners])),
                }
            }
        }
        let mut chart = Chart::new(&self.x, &y, ROW_PX * count).marked(&self.marks);
        chart.y.rows = Some(self.rows.iter().map(|row| row.name.clone()).collect());
        let series = kinds
            .iter()
            .map(|((label, tone), boxes)| Series::boxes(label, *tone, boxes, (&self.x, &y)));
        chart.series = series.collect();
        chart
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_one_label_are_one_series() {
        let span = |from, to, label: &str, tone| Span { from, to, label: label.into(), tone };
        let spans = vec![
            span(0.0, 9.0, "cruise", Tone::Series(0)),
            span(9.0, 9.01, "follow", Tone::Series(1)),
            span(9.01, 10.0, "cruise", Tone::Series(0)),
        ];
        let rows = vec![Row { name: "mode".into(), spans }];
        let bands = Bands { title: "Modes".into(), x: Axis::time(10.0), rows, marks: Vec::new() };
        let chart = bands.chart();
        let label = |series: &Series| match series {
            Series::Box { label, .. } => label.clone(),
            other => panic!("{other:?}"),
        };
        let labels: Vec<_> = chart.series.iter().map(label).collect();
        assert_eq!(labels, ["cruise", "follow"]);
        assert_eq!(chart.y.rows.as_deref(), Some(&["mode".to_owned()][..]));
    }
}

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
