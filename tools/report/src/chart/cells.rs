//! Cells of a grid and points over two axes, with straight edges drawn over or below them.

use super::axis::Axis;
use super::data::{Chart, Series};
use super::{Picture, Stroke, Tone};

/// Height of the axes, px.
const HEIGHT: f64 = 200.0;
const EDGE_PX: f64 = 2.0;

/// A filled cell: its lower left and upper right corner on the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledCell {
    /// (Horizontal, vertical) value of the lower left corner.
    pub from: (f64, f64),
    /// (Horizontal, vertical) value of the upper right corner.
    pub to: (f64, f64),
    /// Index of its kind in [`Cells::kinds`].
    pub kind: usize,
}

/// Straight pieces of one edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Edges {
    /// Name for the legend.
    pub label: String,
    pub tone: Tone,
    pub stroke: Stroke,
    /// The two ends of each piece on the axes.
    pub pieces: Vec<[(f64, f64); 2]>,
}

impl Edges {
    pub(super) fn series(&self, axes: (&Axis, &Axis)) -> Series {
        // A gap after each piece.
        let points = self.pieces.iter().flat_map(|[from, to]| [*from, *to, (to.0, f64::NAN)]);
        let points: Vec<_> = points.collect();
        Series::line((&self.label, self.tone, self.stroke), (EDGE_PX, false), &points, axes)
    }
}

/// Cells of a grid with edges drawn in.
#[derive(Clone, Debug)]
pub struct Cells {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// Kinds of cells: label and colour.
    pub kinds: Vec<(String, Tone)>,
    pub cells: Vec<FilledCell>,
    pub edges: Vec<Edges>,
}

impl Picture for Cells {
    fn title(&self) -> &str {
        &self.title
    }

    fn chart(&self) -> Chart {
        let axes = (&self.x, &self.y);
        let kinds = self.kinds.iter().enumerate().map(|(kind, (label, tone))| {
            let cells = self.cells.iter().filter(|cell| cell.kind == kind);
            let boxes: Vec<_> = cells.map(|cell| [cell.from, cell.to]).collect();
            Series::boxes(label, *tone, &boxes, axes)
        });
        let edges = self.edges.iter().map(|edges| edges.series(axes));
        Chart { series: kinds.chain(edges).collect(), ..Chart::new(&self.x, &self.y, HEIGHT) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::data::Column;
    use super::*;

    #[test]
    fn cells_and_edges_are_series_at_their_values() {
        let cells = Cells {
            title: "Collisions".into(),
            x: Axis::linear("distance, m", 0.0, 20.0),
            y: Axis::linear("lateral speed, m/s", 0.0, 2.0),
            kinds: vec![("rear-end".into(), Tone::Alarm), ("side".into(), Tone::Clear)],
            cells: vec![FilledCell { from: (0.0, 0.0), to: (5.0, 1.0), kind: 0 }],
            edges: vec![Edges {
                label: "model".into(),
                tone: Tone::Series(1),
                stroke: Stroke::Solid,
                pieces: vec![[(5.0, 0.0), (5.0, 1.0)], [(5.0, 1.0), (6.0, 1.0)]],
            }],
        };
        let chart = cells.chart();
        let [Series::Box { x2, .. }, Series::Box { x: none, .. }, Series::Line { y, .. }] =
            chart.series.as_slice()
        else {
            panic!("{chart:?}")
        };
        assert_eq!(*x2, Column::Differences { d: 3, v: vec![Some(5000)] });
        assert_eq!(*none, Column::Differences { d: 3, v: vec![] });
        let v = vec![Some(0), Some(10_000), None, Some(0), Some(0), None];
        assert_eq!(*y, Column::Differences { d: 4, v });
    }
}

/// A point of a scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// (Horizontal, vertical) value.
    pub at: (f64, f64),
    /// Index of its kind in [`Scatter::kinds`].
    pub kind: usize,
}

/// Points of some kinds.
///
/// ```
/// use report::chart::{Axis, Dot, Picture, Scatter, Tone};
///
/// let scatter = Scatter {
///     title: "gap over speed".into(),
///     x: Axis::linear("speed, m/s", 0.0, 40.0),
///     y: Axis::linear("gap, m", 0.0, 100.0),
///     kinds: vec![("failure".into(), Tone::Alarm), ("others".into(), Tone::Muted)],
///     dots: vec![Dot { at: (20.0, 15.0), kind: 0 }],
///     edges: Vec::new(),
/// };
/// assert_eq!(scatter.chart().series.len(), 1, "a kind without a point has no entry");
/// ```
#[derive(Clone, Debug)]
pub struct Scatter {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// Kinds of points: label and colour. The first is on top.
    pub kinds: Vec<(String, Tone)>,
    pub dots: Vec<Dot>,
    pub edges: Vec<Edges>,
}

impl Picture for Scatter {
    fn title(&self) -> &str {
        &self.title
    }

    fn chart(&self) -> Chart {
        let axes = (&self.x, &self.y);
        let kinds = self.kinds.iter().enumerate().filter_map(|(kind, (label, tone))| {
            let dots = self.dots.iter().filter(|dot| dot.kind == kind);
            let points: Vec<_> = dots.map(|dot| dot.at).collect();
            (!points.is_empty()).then(|| Series::points(label, *tone, &points, axes))
        });
        let edges = self.edges.iter().map(|edges| edges.series(axes));
        Chart { series: kinds.chain(edges).collect(), ..Chart::new(&self.x, &self.y, HEIGHT) }
    }
}
