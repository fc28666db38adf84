//! Points over two axes, with straight edges drawn below them.

use super::axis::Axis;
use super::cells::Edges;
use super::data::{Chart, Series};
use super::{Picture, Tone};

/// Height of the axes, px.
const HEIGHT: f64 = 200.0;

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
