//! Rows of labelled spans over one axis.

use super::axis::Axis;
use super::plot::{BOTTOM, LEFT, RIGHT, badges, horizontal_ticks};
use super::svg::{Anchor, Svg, text_width};
use super::{Key, Mark, Picture, Tone, Width};

/// Height of a row's bar, px.
const BAR: f64 = 20.0;
/// Height of a row with its name above the bar, px.
const ROW: f64 = BAR + 22.0;

/// A part of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Begin on the axis.
    pub from: f64,
    /// End on the axis.
    pub to: f64,
    /// Written inside where it fits, and in the legend.
    pub label: String,
    /// Colour.
    pub tone: Tone,
}

/// A row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Written above the bar.
    pub name: String,
    /// Its spans in order.
    pub spans: Vec<Span>,
}

/// Rows over one axis.
#[derive(Clone, Debug)]
pub struct Bands {
    /// Title.
    pub title: String,
    /// The axis.
    pub x: Axis,
    /// The rows, first one on top.
    pub rows: Vec<Row>,
    /// Marked places on the axis.
    pub marks: Vec<Mark>,
}

impl Picture for Bands {
    fn title(&self) -> &str {
        &self.title
    }

    /// Every label once, in order of appearance.
    fn keys(&self) -> Vec<Key> {
        let mut keys: Vec<Key> = Vec::new();
        for span in self.rows.iter().flat_map(|row| &row.spans) {
            let key = Key { label: span.label.clone(), tone: span.tone, stroke: None };
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        keys
    }

    fn svg(&self, width: Width) -> String {
        let (left, right) = (LEFT, width.px() - RIGHT);
        let top = if self.marks.is_empty() { 0.0 } else { 22.0 };
        let bottom = top + ROW * self.rows.len() as f64 + 6.0;
        let place = |x: f64| left + self.x.share(x).clamp(0.0, 1.0) * (right - left);
        let label = format!("{} over {}", self.title, self.x.label);
        let mut svg = Svg::new(width.px(), bottom + BOTTOM, &label);
        for (index, row) in self.rows.iter().enumerate() {
            let y = top + ROW * index as f64;
            svg.text("row", Anchor::Start, (left, y + 14.0), &row.name);
            for span in &row.spans {
                let (from, to) = (place(span.from), place(span.to));
                let class = format!("band {}", span.tone.class());
                // A span of no length is still seen.
                let size = ((to - from).max(1.0), BAR);
                svg.rect(&class, (from, y + 20.0), size, &span.label);
                if text_width(&span.label) + 8.0 <= to - from {
                    svg.text("inside", Anchor::Start, (from + 5.0, y + 34.0), &span.label);
                }
            }
        }
        for mark in &self.marks {
            svg.line("mark", (place(mark.x), top), (place(mark.x), bottom));
        }
        badges(&mut svg, &self.marks, place, 10.0);
        horizontal_ticks(&mut svg, &self.x, (left, right), bottom);
        svg.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bands() -> Bands {
        let span = |from, to, label: &str, tone| Span { from, to, label: label.into(), tone };
        let modes = vec![
            span(0.0, 9.0, "cruise", Tone::Series(0)),
            span(9.0, 9.01, "follow", Tone::Series(1)),
            span(9.01, 10.0, "cruise", Tone::Series(0)),
        ];
        let rows = vec![Row { name: "mode".into(), spans: modes }];
        Bands { title: "Modes".into(), x: Axis::time(10.0), rows, marks: Vec::new() }
    }

    #[test]
    fn a_label_is_written_only_where_it_fits_and_explained_once() {
        let svg = bands().svg(Width::Narrow);
        assert_eq!(svg.matches(">cruise</text>").count(), 1, "{svg}");
        assert_eq!(svg.matches(">follow</text>").count(), 0, "{svg}");
        assert!(svg.contains("<title>follow</title>"), "{svg}");
        assert_eq!(bands().keys().len(), 2);
    }
}
