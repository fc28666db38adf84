//! Curves over two axes.

use super::axis::Axis;
use super::data::{Chart, Column, Series, Text};
use super::{Mark, Stroke, Tone};

/// Width of a curve, px.
const LINE_PX: f64 = 2.0;
/// Width of one of many curves, px.
const THIN_PX: f64 = 1.1;
/// Additional width of a curve for each curve that may cover it, px.
const COVERED_PX: f64 = 4.0;
/// Most covering curves that widen a curve.
const MOST_COVERING: usize = 4;

#[derive(Clone, Debug)]
pub struct Curve {
    pub name: String,
    /// Points in any order of their horizontal values; a value that is not finite interrupts the curve.
    pub points: Vec<(f64, f64)>,
    pub tone: Tone,
    pub stroke: Stroke,
    /// True if each value holds until the next point; otherwise points are joined.
    pub steps: bool,
    /// Number of curves that may cover this one. It is drawn wider, so that it shows on both sides of them.
    pub covered_by: usize,
    /// True if the curve is one of many, which thin lines show better.
    pub is_thin: bool,
}

impl Curve {
    /// A solid curve.
    pub fn new(name: &str, tone: Tone, points: Vec<(f64, f64)>) -> Self {
        let (stroke, name) = (Stroke::Solid, name.into());
        Self { name, points, tone, stroke, steps: false, covered_by: 0, is_thin: false }
    }

    /// This curve with another stroke.
    pub fn stroke(self, stroke: Stroke) -> Self {
        Self { stroke, ..self }
    }

    /// This curve below `others` that may have the same points.
    pub fn covered_by(self, others: usize) -> Self {
        Self { covered_by: others, ..self }
    }

    /// This curve as one of many.
    pub fn thin(self) -> Self {
        Self { is_thin: true, ..self }
    }

    /// This curve as a staircase.
    pub fn steps(self) -> Self {
        Self { steps: true, ..self }
    }
}

/// A horizontal bar of spans at a place on the vertical axis, such as a signal at its stop line.
#[derive(Clone, Debug)]
pub struct Strip {
    /// Place on the vertical axis.
    pub y: f64,
    /// Text above its left end.
    pub label: String,
    /// Begin, end and colour.
    pub spans: Vec<(f64, f64, Tone)>,
}

/// Curves over two axes.
#[derive(Clone, Debug)]
pub struct Plot {
    pub title: String,
    pub x: Axis,
    /// Vertical axis; its label is above it.
    pub y: Axis,
    /// Height of the axes, px.
    pub height: f64,
    /// Strips behind the curves.
    pub strips: Vec<Strip>,
    /// The curves; among curves of one stroke the first is on top.
    pub curves: Vec<Curve>,
    /// Marked places on the horizontal axis.
    pub marks: Vec<Mark>,
    /// Names of the colours of the strips, for the legend.
    pub strip_keys: Vec<(String, Tone)>,
}

impl Plot {
    /// A plot over run time. Its vertical axis holds all curves; curves without a point are left out.
    pub fn over_time(title: &str, until_s: f64, unit: &str, curves: Vec<Curve>) -> Self {
        Self::over(title, Axis::time(until_s), unit, curves)
    }

    /// A plot over another axis.
    pub fn over(title: &str, x: Axis, unit: &str, curves: Vec<Curve>) -> Self {
        let mut curves = curves;
        curves.retain(|curve| curve.points.iter().any(|point| point.1.is_finite()));
        let values = curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
        let y = Axis::holding(unit, values);
        Self {
            title: title.into(),
            x,
            y,
            height: 180.0,
            strips: Vec::new(),
            curves,
            marks: Vec::new(),
            strip_keys: Vec::new(),
        }
    }

    /// This plot with the run's marks.
    pub fn marked(self, marks: &[Mark]) -> Self {
        Self { marks: marks.to_vec(), ..self }
    }
}

impl From<&Plot> for Chart {
    fn from(plot: &Plot) -> Self {
        let axes = (&plot.x, &plot.y);
        let lines = plot.curves.iter().map(|curve| {
            let covering = curve.covered_by.min(MOST_COVERING) as f64;
            let width = if curve.is_thin { THIN_PX } else { LINE_PX + COVERED_PX * covering };
            let name = (curve.name.as_str(), curve.tone, curve.stroke);
            Series::line(name, (width, curve.steps), &curve.points, axes)
        });
        let bars = plot.strip_keys.iter().map(|(label, tone)| plot.bar(label, *tone));
        let texts = plot.strips.iter();
        let texts = texts.map(|strip| Text { y: strip.y, label: strip.label.clone() });
        Self {
            series: lines.chain(bars).collect(),
            texts: texts.collect(),
            ..Self::new(&plot.title, &plot.x, &plot.y, plot.height).marked(&plot.marks)
        }
    }
}

impl Plot {
    /// The spans of one colour in all strips.
    fn bar(&self, label: &str, tone: Tone) -> Series {
        let spans = self.strips.iter().flat_map(|strip| {
            let spans = strip.spans.iter().filter(move |span| span.2 == tone);
            spans.map(|(from, to, _)| (*from, strip.y, *to))
        });
        let spans: Vec<_> = spans.collect();
        // Red is thick and green is thin, so that they differ without colours.
        let px = match tone {
            Tone::Stop => 7.0,
            Tone::Clear => 4.4,
            _ => 2.4,
        };
        Series::Bar {
            label: label.into(),
            tone: tone.name(),
            px,
            x: Column::new(spans.iter().map(|span| span.0), &self.x),
            y: Column::new(spans.iter().map(|span| span.1), &self.y),
            x2: Column::new(spans.iter().map(|span| span.2), &self.x),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>) -> Plot {
        Plot::over_time("Speed", 10.0, "m/s", vec![Curve::new("ego", Tone::Series(0), points)])
    }

    #[test]
    fn a_curve_is_a_series_of_few_points_and_wider_below_others() {
        let points = (0..1000).map(|i| (f64::from(i) / 100.0, f64::from(i) / 100.0)).collect();
        let mut plot = plot(points);
        plot.curves[0].covered_by = 1;
        let chart = Chart::from(&plot);
        let [Series::Line { x: Column::Differences { v, .. }, width, .. }] =
            chart.series.as_slice()
        else {
            panic!("{chart:?}")
        };
        assert!(v.len() < 40 && *width > LINE_PX, "{chart:?}");
    }

    #[test]
    fn a_plot_of_nothing_still_has_its_axes() {
        let text = super::super::script_json(&Chart::from(&plot(Vec::new())));
        assert!(text.contains("m/s") && text.contains("time, s"), "{text}");
        assert!(Chart::from(&plot(Vec::new())).series.is_empty(), "an empty curve has no legend");
    }
}
