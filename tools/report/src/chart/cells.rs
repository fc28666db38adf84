//! Cells of a grid over two axes, with straight edges drawn over them.

use super::axis::Axis;
use super::plot::{BOTTOM, LEFT, RIGHT, horizontal_ticks};
use super::svg::{Anchor, Svg};
use super::{Key, Picture, Stroke, Tone, Width};

/// Height of the grid, px.
const HEIGHT: f64 = 200.0;
/// Space above it for the vertical axis's label, px.
const TOP: f64 = 22.0;

/// A filled cell: its lower left and upper right corner on the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledCell {
    /// (Horizontal, vertical) value of the lower left corner.
    pub from: (f64, f64),
    /// The same of the upper right corner.
    pub to: (f64, f64),
    /// Which of [`Cells::kinds`] it is.
    pub kind: usize,
}

/// Straight pieces of one edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Edges {
    /// What the legend says.
    pub label: String,
    /// Colour.
    pub tone: Tone,
    /// Stroke.
    pub stroke: Stroke,
    /// The two ends of each piece on the axes.
    pub pieces: Vec<[(f64, f64); 2]>,
}

/// Cells of a grid with edges drawn in.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Title.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What the cells mean: label and colour.
    pub kinds: Vec<(String, Tone)>,
    /// The filled cells.
    pub cells: Vec<FilledCell>,
    /// The edges.
    pub edges: Vec<Edges>,
}

impl Picture for Cells {
    fn title(&self) -> &str {
        &self.title
    }

    fn keys(&self) -> Vec<Key> {
        let kinds = self.kinds.iter().map(|(label, tone)| Key {
            label: label.clone(),
            tone: *tone,
            stroke: None,
        });
        let edges = self.edges.iter().map(|edges| Key {
            label: edges.label.clone(),
            tone: edges.tone,
            stroke: Some(edges.stroke),
        });
        kinds.chain(edges).collect()
    }

    fn svg(&self, width: Width) -> String {
        let (left, right, bottom) = (LEFT, width.px() - RIGHT, TOP + HEIGHT);
        let x = |value: f64| left + self.x.share(value) * (right - left);
        let y = |value: f64| bottom - self.y.share(value) * HEIGHT;
        let label = format!("{}: {} over {}", self.title, self.y.label, self.x.label);
        let mut svg = Svg::new(width.px(), bottom + BOTTOM, &label);
        svg.text("unit", Anchor::Start, (4.0, 13.0), &self.y.label);
        for tick in self.y.ticks(5) {
            let at = bottom - tick.share * HEIGHT;
            svg.line("grid-line", (left, at), (right, at));
            svg.text("tick", Anchor::End, (left - 6.0, at + 4.0), &tick.label);
        }
        for cell in &self.cells {
            let tone = self.kinds.get(cell.kind).map_or(Tone::Muted, |kind| kind.1);
            let corner = (x(cell.from.0), y(cell.to.1));
            let size = (x(cell.to.0) - x(cell.from.0), y(cell.from.1) - y(cell.to.1));
            svg.rect(&format!("fill {}", tone.class()), corner, size, "");
        }
        for edges in &self.edges {
            let class = format!("line {} {}", edges.stroke.class(), edges.tone.class());
            let place = |end: &(f64, f64)| (x(end.0), y(end.1));
            let runs: Vec<_> =
                edges.pieces.iter().map(|piece| piece.iter().map(place).collect()).collect();
            svg.curve(&class, &runs);
        }
        horizontal_ticks(&mut svg, &self.x, (left, right), bottom);
        svg.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_and_an_edge_stand_where_their_values_are() {
        let cells = Cells {
            title: "Collisions".into(),
            x: Axis::linear("distance, m", 0.0, 10.0),
            y: Axis::linear("lateral speed, m/s", 0.0, 2.0),
            kinds: vec![("rear-end".into(), Tone::Alarm)],
            cells: vec![FilledCell { from: (0.0, 0.0), to: (5.0, 1.0), kind: 0 }],
            edges: vec![Edges {
                label: "model".into(),
                tone: Tone::Series(1),
                stroke: Stroke::Solid,
                pieces: vec![[(5.0, 0.0), (5.0, 1.0)]],
            }],
        };
        let svg = cells.svg(Width::Narrow);
        let middle = LEFT + (Width::Narrow.px() - RIGHT - LEFT) / 2.0;
        assert!(svg.contains(&format!("x=\"{LEFT:.1}\" y=\"{:.1}\"", TOP + 100.0)), "{svg}");
        assert!(svg.contains(&format!("M{middle:.1} {:.1}L{middle:.1}", TOP + 200.0)), "{svg}");
        assert_eq!(cells.keys().len(), 2);
    }
}
