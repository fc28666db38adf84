//! Points or filled cells of some kinds over two axes, with straight edges drawn over them.

use super::axis::Axis;
use super::data::{Chart, Series};
use super::{Stroke, Tone};

/// Height of the axes, px.
const HEIGHT: f64 = 200.0;
const EDGE_PX: f64 = 2.0;

/// A kind of what is drawn: its name for the legend, its tone, and all of its places.
pub type Kind<'a, T> = (&'a str, Tone, Vec<T>);

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

/// Filled cells of some kinds, each by its lower left and its upper right corner.
pub fn cells(
    title: &str,
    axes: (&Axis, &Axis),
    kinds: &[Kind<'_, [(f64, f64); 2]>],
    edges: &[Edges],
) -> Chart {
    let boxes = kinds.iter().map(|(label, tone, cells)| Series::boxes(label, *tone, cells, axes));
    with_edges(title, axes, boxes, edges)
}

/// Points of some kinds. The first kind is on top.
///
/// ```
/// use report::chart::{Axis, Tone, scatter};
///
/// let (x, y) = (Axis::linear("speed, m/s", 0.0, 40.0), Axis::linear("gap, m", 0.0, 100.0));
/// let kinds = [("failure", Tone::Alarm, vec![(20.0, 15.0)]), ("others", Tone::Muted, vec![])];
/// let chart = scatter("gap over speed", (&x, &y), &kinds, &[]);
/// assert_eq!(chart.series.len(), 1, "a kind without a point has no entry");
/// ```
pub fn scatter(
    title: &str,
    axes: (&Axis, &Axis),
    kinds: &[Kind<'_, (f64, f64)>],
    edges: &[Edges],
) -> Chart {
    let kinds = kinds.iter().filter(|(.., points)| !points.is_empty());
    let points = kinds.map(|(label, tone, points)| Series::points(label, *tone, points, axes));
    with_edges(title, axes, points, edges)
}

fn with_edges(
    title: &str,
    axes: (&Axis, &Axis),
    series: impl Iterator<Item = Series>,
    edges: &[Edges],
) -> Chart {
    let edges = edges.iter().map(|Edges { label, tone, stroke, pieces }| {
        // A gap after each piece.
        let points = pieces.iter().flat_map(|[from, to]| [*from, *to, (to.0, f64::NAN)]);
        let points: Vec<_> = points.collect();
        Series::line((label, *tone, *stroke), (EDGE_PX, false), &points, axes)
    });
    Chart { series: series.chain(edges).collect(), ..Chart::new(title, axes.0, axes.1, HEIGHT) }
}

#[cfg(test)]
mod tests {
    use super::super::data::Column;
    use super::*;

    #[test]
    fn cells_and_edges_are_series_at_their_values() {
        let x = Axis::linear("distance, m", 0.0, 20.0);
        let y = Axis::linear("lateral speed, m/s", 0.0, 2.0);
        let rear = ("rear-end", Tone::Alarm, vec![[(0.0, 0.0), (5.0, 1.0)]]);
        let edges = [Edges {
            label: "model".into(),
            tone: Tone::Series(1),
            stroke: Stroke::Solid,
            pieces: vec![[(5.0, 0.0), (5.0, 1.0)], [(5.0, 1.0), (6.0, 1.0)]],
        }];
        let kinds = [rear, ("side", Tone::Clear, vec![])];
        let chart = cells("Collisions", (&x, &y), &kinds, &edges);
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
