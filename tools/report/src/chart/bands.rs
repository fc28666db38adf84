//! Rows over one axis: labelled spans, or lines through one value a row (parallel coordinates).

use super::axis::Axis;
use super::data::{Chart, Series};
use super::{Mark, Stroke, Tone};

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
/// use report::chart::{Axis, Bands, Chart, Row, Span, Tone};
///
/// let span = |from, to, label: &str, tone| Span { from, to, label: label.into(), tone };
/// let spans = vec![
///     span(0.0, 9.0, "cruise", Tone::Series(0)),
///     span(9.0, 20.0, "follow", Tone::Series(1)),
/// ];
/// let rows = vec![Row { name: "mode of the law".into(), spans }];
/// let bands = Bands { title: "Modes".into(), x: Axis::time(20.0), rows, marks: Vec::new() };
/// assert_eq!(Chart::from(&bands).series.len(), 2, "one entry of the legend per label");
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

impl From<&Bands> for Chart {
    /// A series for each label and colour, in order of appearance.
    fn from(bands: &Bands) -> Self {
        let Bands { title, x, rows, marks } = bands;
        let count = rows.len() as f64;
        let y = Axis::linear("", 0.0, count.max(1.0));
        let mut kinds: Vec<Boxes<'_>> = Vec::new();
        for (index, row) in rows.iter().enumerate() {
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
        let mut chart = Self::new(title, x, &y, ROW_PX * count).marked(marks);
        chart.y.rows = Some(rows.iter().map(|row| row.name.clone()).collect());
        let series =
            kinds.iter().map(|((label, tone), boxes)| Series::boxes(label, *tone, boxes, (x, &y)));
        chart.series = series.collect();
        chart
    }
}

/// Height of a row's line in it, as a share of the row.
const LINE: f64 = 0.2;
/// Widths of the lines of the first kinds, px; further kinds have the last one. They differ in grey too.
const WIDTHS_PX: [f64; 3] = [2.0, 1.4, 0.7];

/// Many lines over the same rows, from top to bottom. A line has a place from 0 to 1 on each row. The first kind is on top.
///
/// ```
/// use report::chart::{Tone, parallel};
///
/// let rows = ["speed: 12..36".to_owned(), "gap: 5..80".to_owned()];
/// let kinds = [("failure", Tone::Alarm, vec![&[0.9, 0.1][..]]), ("others", Tone::Muted, vec![])];
/// assert_eq!(parallel("Runs", &rows, &kinds).series.len(), 1, "a kind without a line has no entry");
/// ```
pub fn parallel(title: &str, rows: &[String], kinds: &[(&str, Tone, Vec<&[f64]>)]) -> Chart {
    let count = rows.len() as f64;
    let x = Axis::linear("share of the range", 0.0, 1.0);
    let y = Axis::linear("", 0.0, count.max(1.0));
    let mut chart = Chart::new(title, &x, &y, ROW_PX * count);
    chart.y.rows = Some(rows.to_vec());
    chart.y.row_line = Some(LINE);
    for (kind, (label, tone, lines)) in kinds.iter().enumerate() {
        let place = |(row, share): (usize, &f64)| (*share, count - 1.0 - row as f64 + LINE);
        // A gap after each line.
        let points = |line: &&[f64]| {
            let points: Vec<_> = line.iter().enumerate().map(place).collect();
            points.into_iter().chain([(0.0, f64::NAN)])
        };
        let points: Vec<(f64, f64)> = lines.iter().flat_map(points).collect();
        if !points.is_empty() {
            let width = WIDTHS_PX[kind.min(WIDTHS_PX.len() - 1)];
            let name = (*label, *tone, Stroke::Solid);
            chart.series.push(Series::line(name, (width, false), &points, (&x, &y)));
        }
    }
    chart
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
        let chart = Chart::from(&bands);
        let label = |series: &Series| match series {
            Series::Box { label, .. } => label.clone(),
            other => panic!("{other:?}"),
        };
        let labels: Vec<_> = chart.series.iter().map(label).collect();
        assert_eq!(labels, ["cruise", "follow"]);
        assert_eq!(chart.y.rows.as_deref(), Some(&["mode".to_owned()][..]));
    }
}
