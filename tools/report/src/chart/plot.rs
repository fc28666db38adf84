//! Curves over two axes.

use super::axis::Axis;
use super::decimate::decimate;
use super::svg::{Anchor, Svg, text_width};
use super::{Key, Mark, Picture, Stroke, Tone, Width};

/// Room left of the axes, px: the same in all pictures, so that those below each other line up. "99.99 %" fits.
pub const LEFT: f64 = 60.0;
/// Room right of the axes, px.
pub const RIGHT: f64 = 14.0;
/// Room above the axes: the unit and the marks' numbers.
const TOP: f64 = 24.0;
/// Room below the axes: ticks and label.
pub const BOTTOM: f64 = 38.0;

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name for the legend.
    pub name: String,
    /// Points; one that is not finite breaks the curve.
    pub points: Vec<(f64, f64)>,
    /// Colour.
    pub tone: Tone,
    /// Stroke.
    pub stroke: Stroke,
    /// Holds each value until the next point instead of joining them.
    pub steps: bool,
    /// Number of curves that may cover this one: it is drawn that much wider, so that it still
    /// shows on both sides of them.
    pub covered_by: usize,
    /// One of so many that a thin line shows more.
    pub is_thin: bool,
}

impl Curve {
    /// A solid curve.
    pub fn new(name: &str, tone: Tone, points: Vec<(f64, f64)>) -> Self {
        let (stroke, name) = (Stroke::Solid, name.into());
        Self { name, points, tone, stroke, steps: false, covered_by: 0, is_thin: false }
    }

    /// The same with another stroke.
    pub fn stroke(self, stroke: Stroke) -> Self {
        Self { stroke, ..self }
    }

    /// The same below so many others that may have the same points.
    pub fn covered_by(self, others: usize) -> Self {
        Self { covered_by: others, ..self }
    }

    /// The same as one of many.
    pub fn thin(self) -> Self {
        Self { is_thin: true, ..self }
    }

    /// The same as a staircase.
    pub fn steps(self) -> Self {
        Self { steps: true, ..self }
    }
}

/// A horizontal bar made of spans, at a place on the vertical axis: a signal at its stop line.
#[derive(Clone, Debug)]
pub struct Strip {
    /// Place on the vertical axis.
    pub y: f64,
    /// Written above its left end.
    pub label: String,
    /// From, to and colour.
    pub spans: Vec<(f64, f64, Tone)>,
}

/// A labelled point: a value that a paper prints.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Value on the horizontal axis.
    pub x: f64,
    /// Value on the vertical axis.
    pub y: f64,
    /// Name and value, for the reader.
    pub label: String,
}

/// Curves over two axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Title.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis; its label stands above it.
    pub y: Axis,
    /// Height of the axes, px.
    pub height: f64,
    /// Behind the curves.
    pub strips: Vec<Strip>,
    /// The curves; of those with the same stroke the first is on top.
    pub curves: Vec<Curve>,
    /// Labelled points, on top of the curves.
    pub points: Vec<Point>,
    /// Marked places on the horizontal axis.
    pub marks: Vec<Mark>,
    /// Entries of the legend beside the curves'.
    pub more_keys: Vec<Key>,
}

impl Plot {
    /// A plot over the run's time whose vertical axis holds all curves; those without a point are
    /// left out.
    pub fn over_time(title: &str, until_s: f64, unit: &str, curves: Vec<Curve>) -> Self {
        Self::over(title, Axis::time(until_s), unit, curves)
    }

    /// The same over another axis.
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
            points: Vec::new(),
            marks: Vec::new(),
            more_keys: Vec::new(),
        }
    }

    /// The same with the run's marks.
    pub fn marked(self, marks: &[Mark]) -> Self {
        Self { marks: marks.to_vec(), ..self }
    }

    /// The same with labelled points; the vertical axis holds them too.
    pub fn with_points(self, points: Vec<Point>) -> Self {
        let curves = self.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
        let y = Axis::holding(&self.y.label, curves.chain(points.iter().map(|point| point.y)));
        Self { y, points, ..self }
    }
}

impl Picture for Plot {
    fn title(&self) -> &str {
        &self.title
    }

    fn keys(&self) -> Vec<Key> {
        let curves = self.curves.iter().map(|curve| Key {
            label: curve.name.clone(),
            tone: curve.tone,
            stroke: Some(curve.stroke),
        });
        let mut keys: Vec<Key> = Vec::new();
        for key in curves.chain(self.more_keys.iter().cloned()) {
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        // The title has said it.
        if matches!(keys.as_slice(), [key] if key.label == self.title) { Vec::new() } else { keys }
    }

    fn svg(&self, width: Width) -> String {
        // A narrow picture is not a tower.
        let height = self.height.min(0.95 * width.px());
        let area = Area::new(width.px(), height);
        let label = format!("{}: {} over {}", self.title, self.y.label, self.x.label);
        let mut svg = Svg::new(width.px(), TOP + height + BOTTOM, &label);
        area.grid(&mut svg, &self.x, &self.y);
        for strip in &self.strips {
            self.strip(&mut svg, &area, strip);
        }
        for mark in &self.marks {
            let x = area.x(self.x.share(mark.x));
            svg.line("mark", (x, TOP), (x, TOP + height));
        }
        // Broken strokes last: what is under them still shows.
        let (solid, broken): (Vec<_>, Vec<_>) =
            self.curves.iter().rev().partition(|curve| curve.stroke == Stroke::Solid);
        for curve in solid.into_iter().chain(broken) {
            let points = stairs(curve);
            let places =
                points.iter().map(|(x, y)| (area.x(self.x.share(*x)), area.y(self.y.share(*y))));
            let wider = ["", " wide-1", " wide-2", " wide-3", " wide-4"];
            let wider = wider[curve.covered_by.min(wider.len() - 1)];
            let thin = if curve.is_thin { " thin" } else { "" };
            let (tone, stroke) = (curve.tone.class(), curve.stroke.class());
            let class = format!("line {tone} {stroke}{wider}{thin}");
            svg.curve(&class, &decimate(places));
        }
        for point in &self.points {
            let (x, y) = (area.x(self.x.share(point.x)), area.y(self.y.share(point.y)));
            svg.ring((x, y), &point.label);
        }
        badges(&mut svg, &self.marks, |x| area.x(self.x.share(x)), 10.0);
        svg.finish()
    }
}

impl Plot {
    fn strip(&self, svg: &mut Svg, area: &Area, strip: &Strip) {
        let y = area.y(self.y.share(strip.y));
        for (from, to, tone) in &strip.spans {
            let (from, to) = (area.x(self.x.share(*from)), area.x(self.x.share(*to).min(1.0)));
            // What stops is thick, what lets pass is thin: without colours too.
            let half = match tone {
                Tone::Stop => 3.5,
                Tone::Clear => 2.2,
                _ => 1.2,
            };
            let class = format!("fill {}", tone.class());
            svg.rect(&class, (from, y - half), (to - from, 2.0 * half), "");
        }
        svg.text("small halo", Anchor::Start, (area.left + 4.0, y - 7.0), &strip.label);
    }
}

/// Numbers of the marks in a line above the axes; close ones stand beside each other.
pub fn badges(svg: &mut Svg, marks: &[Mark], place: impl Fn(f64) -> f64, y: f64) {
    let mut free = f64::NEG_INFINITY;
    for mark in marks {
        let x = place(mark.x).max(free);
        svg.badge((x, y), mark.number);
        free = x + 17.0;
    }
}

/// The points of a curve, with the corners of a staircase where it is one.
fn stairs(curve: &Curve) -> Vec<(f64, f64)> {
    if !curve.steps {
        return curve.points.clone();
    }
    let corners = curve.points.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    corners.chain(curve.points.last().copied()).collect()
}

/// Where the axes are, px.
pub struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Area {
    fn new(width: f64, height: f64) -> Self {
        Self { left: LEFT, right: width - RIGHT, top: TOP, bottom: TOP + height }
    }

    fn x(&self, share: f64) -> f64 {
        self.left + share * (self.right - self.left)
    }

    fn y(&self, share: f64) -> f64 {
        self.bottom - share * (self.bottom - self.top)
    }

    fn grid(&self, svg: &mut Svg, x: &Axis, y: &Axis) {
        for tick in y.ticks(((self.bottom - self.top) as usize / 25).min(10)) {
            let at = self.y(tick.share);
            svg.line("grid-line", (self.left, at), (self.right, at));
            svg.text("tick", Anchor::End, (self.left - 6.0, at + 4.0), &tick.label);
        }
        for tick in x.ticks((self.right - self.left) as usize / 62) {
            let at = self.x(tick.share);
            svg.line("grid-line", (at, self.top), (at, self.bottom));
        }
        horizontal_ticks(svg, x, (self.left, self.right), self.bottom);
        svg.text("unit", Anchor::Start, (4.0, 13.0), &y.label);
    }
}

/// Ticks and label of a horizontal axis between two places, below `y`.
pub fn horizontal_ticks(svg: &mut Svg, axis: &Axis, (left, right): (f64, f64), y: f64) {
    let ticks = axis.ticks((right - left) as usize / 62);
    let mut free = f64::NEG_INFINITY;
    for tick in ticks {
        let at = left + tick.share * (right - left);
        svg.line("grid-line", (at, y), (at, y + 4.0));
        // A label that would touch its neighbour or the edge is left out; its tick stays.
        let half = text_width(&tick.label) / 2.0;
        if at - half >= free && at + half <= right + RIGHT {
            svg.text("tick", Anchor::Middle, (at, y + 17.0), &tick.label);
            free = at + half + 6.0;
        }
    }
    svg.line("base", (left, y), (right, y));
    svg.text("unit", Anchor::End, (right, y + 33.0), &axis.label);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>) -> Plot {
        Plot::over_time("Speed", 10.0, "m/s", vec![Curve::new("ego", Tone::Series(0), points)])
    }

    /// Coordinates of all paths of curves.
    fn coordinates(svg: &str) -> Vec<(f64, f64)> {
        let path = svg.split("class=\"line").nth(1).and_then(|rest| rest.split("d=\"").nth(1));
        let path = path.and_then(|rest| rest.split('"').next()).unwrap_or_default();
        path.split(['M', 'L'])
            .filter_map(|pair| pair.split_once(' '))
            .map(|(x, y)| (x.parse().expect("a number"), y.parse().expect("a number")))
            .collect()
    }

    #[test]
    fn curves_stay_inside_the_axes_at_every_width() {
        for width in Width::ALL {
            let points = (0..1000).map(|i| (f64::from(i) / 100.0, f64::from(i % 37) - 20.0));
            let svg = plot(points.collect()).svg(width);
            let drawn = coordinates(&svg);
            assert!(drawn.len() > 50, "{svg}");
            for (x, y) in drawn {
                assert!(x >= LEFT - 0.1 && x <= width.px() - RIGHT + 0.1, "{x}");
                assert!((TOP - 0.1..=TOP + 180.1).contains(&y), "{y}");
            }
        }
    }

    #[test]
    fn a_plot_of_nothing_still_has_its_axes() {
        let svg = plot(Vec::new()).svg(Width::Narrow);
        assert!(svg.contains("m/s") && svg.contains("time, s") && !svg.contains("NaN"), "{svg}");
        assert!(plot(Vec::new()).keys().is_empty(), "nothing drawn, nothing explained");
    }

    #[test]
    fn a_point_widens_the_axis_and_is_drawn() {
        let points = vec![Point { x: 5.0, y: 30.0, label: "printed: 30".into() }];
        let plot = plot(vec![(0.0, 1.0), (10.0, 2.0)]).with_points(points);
        assert!(plot.y.share(30.0) <= 1.0, "{:?}", plot.y);
        assert!(plot.svg(Width::Wide).contains("<title>printed: 30</title>"));
    }

    #[test]
    fn a_staircase_has_corners() {
        let curve = Curve::new("u", Tone::Series(0), vec![(0.0, 1.0), (1.0, 2.0)]).steps();
        assert_eq!(stairs(&curve), [(0.0, 1.0), (1.0, 1.0), (1.0, 2.0)]);
    }

    #[test]
    fn close_marks_do_not_cover_each_other() {
        let mut svg = Svg::new(100.0, 100.0, "");
        let marks = [1, 2, 3].map(|number| Mark { x: 50.0, number });
        badges(&mut svg, &marks, |x| x, 10.0);
        let text = svg.finish();
        for x in ["cx=\"50.0\"", "cx=\"67.0\"", "cx=\"84.0\""] {
            assert!(text.contains(x), "{text}");
        }
    }
}
