//! Rows of labelled spans over one axis.

use super::axis::Axis;
use super::data::{Chart, Series};
use super::{Mark, Picture, Tone};

/// Height of a row, px: its name above its bar.
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
