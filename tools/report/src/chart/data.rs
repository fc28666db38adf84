//! A chart as the page's script reads it: series and marks as data, safe inside a page.

use super::axis::{Axis, Format, Scale};
use super::decimate::kept;
use super::{Mark, Stroke, Tone};
use serde::Serialize;

/// Columns into which points fall along the horizontal axis. They are more than a screen shows, so that
/// zooming shows more.
const COLUMNS: f64 = 4_000.0;
/// Places distinguished along the vertical axis.
const PLACES: f64 = 1_000.0;
/// Least number of a value's last decimal along an axis.
const STEPS: f64 = 20_000.0;

#[derive(Debug, Serialize)]
pub struct Chart {
    /// Title, with the unit if all axes share it.
    #[serde(skip)]
    pub title: String,
    pub x: AxisData,
    pub y: AxisData,
    /// Height of the axes, px.
    pub height: f64,
    /// Series in the order of the legend.
    pub series: Vec<Series>,
    /// Rows coloured by a value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<Map>,
    /// Places on the horizontal axis, their labels and colours.
    pub marks: Vec<(f64, String, &'static str)>,
    /// Texts at values of the vertical axis.
    pub texts: Vec<Text>,
}

impl Chart {
    /// A chart without series.
    pub fn new(title: &str, x: &Axis, y: &Axis, height: f64) -> Self {
        let (title, marks, texts) = (title.to_owned(), Vec::new(), Vec::new());
        let (x, y) = (AxisData::from(x), AxisData::from(y));
        Self { title, x, y, height, series: Vec::new(), map: None, marks, texts }
    }

    pub fn marked(self, marks: &[Mark]) -> Self {
        let mark = |mark: &Mark| (mark.x, mark.label.clone(), mark.tone.name());
        Self { marks: marks.iter().map(mark).collect(), ..self }
    }
}

#[derive(Debug, Serialize)]
pub struct AxisData {
    label: String,
    low: f64,
    high: f64,
    scale: &'static str,
    format: &'static str,
    /// Number of nines on a distribution's axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    nines: Option<u32>,
    /// Names of rows that replace the values of an axis, from top to bottom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<Vec<String>>,
    /// Height of each row's own line, as a share of the row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row_line: Option<f64>,
}

impl From<&Axis> for AxisData {
    fn from(axis: &Axis) -> Self {
        let (low, high, scale, nines) = match axis.scale {
            Scale::Linear { low, high } => (low, high, "linear", None),
            Scale::Log { low, high } => (low, high, "log", None),
            Scale::Percentile { nines } => (0.0, 1.0, "percentile", Some(nines)),
        };
        let format = match axis.format {
            Format::Number => "number",
            Format::Count => "count",
            Format::DurationUs => "duration",
            Format::Percent => "percent",
        };
        Self {
            label: axis.label.clone(),
            low,
            high,
            scale,
            format,
            nines,
            rows: None,
            row_line: None,
        }
    }
}

/// An entry of the legend.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Series {
    /// A line through points.
    Line {
        label: String,
        tone: &'static str,
        stroke: &'static str,
        width: f64,
        /// True if each value holds until the next point.
        steps: bool,
        /// Horizontal values.
        x: Column,
        /// Vertical values.
        y: Column,
    },
    /// Boxes between a lower left and an upper right corner.
    Box {
        label: String,
        tone: &'static str,
        /// Left edges.
        x: Column,
        /// Lower edges.
        y: Column,
        /// Right edges.
        x2: Column,
        /// Upper edges.
        y2: Column,
    },
    Point {
        label: String,
        tone: &'static str,
        /// Horizontal values.
        x: Column,
        /// Vertical values.
        y: Column,
    },
    /// Bars of a fixed height at values of the vertical axis.
    Bar {
        label: String,
        tone: &'static str,
        px: f64,
        /// Left ends.
        x: Column,
        y: Column,
        /// Right ends.
        x2: Column,
    },
}

impl Series {
    /// A line with the points that a screen can show.
    pub fn line(
        (label, tone, stroke): (&str, Tone, Stroke),
        (width, steps): (f64, bool),
        points: &[(f64, f64)],
        (x, y): (&Axis, &Axis),
    ) -> Self {
        let (x, y) = columns(points, steps, (x, y), (COLUMNS, PLACES));
        let (tone, stroke) = (tone.name(), stroke.name());
        Self::Line { label: label.into(), tone, stroke, width, steps, x, y }
    }

    pub fn points(label: &str, tone: Tone, points: &[(f64, f64)], (x, y): (&Axis, &Axis)) -> Self {
        Self::Point {
            label: label.into(),
            tone: tone.name(),
            x: Column::new(points.iter().map(|point| point.0), x),
            y: Column::new(points.iter().map(|point| point.1), y),
        }
    }

    /// Boxes by their lower left and upper right corners.
    pub fn boxes(
        label: &str,
        tone: Tone,
        boxes: &[[(f64, f64); 2]],
        (x, y): (&Axis, &Axis),
    ) -> Self {
        let column = |axis: &Axis, value: fn(&[(f64, f64); 2]) -> f64| {
            Column::new(boxes.iter().map(value), axis)
        };
        Self::Box {
            label: label.into(),
            tone: tone.name(),
            x: column(x, |corners| corners[0].0),
            y: column(y, |corners| corners[0].1),
            x2: column(x, |corners| corners[1].0),
            y2: column(y, |corners| corners[1].1),
        }
    }
}

/// The columns of the points that a screen of `columns` by `places` px can show.
pub fn columns(
    points: &[(f64, f64)],
    steps: bool,
    (x, y): (&Axis, &Axis),
    (columns, places): (f64, f64),
) -> (Column, Column) {
    let px: Vec<_> = points
        .iter()
        .map(|point| (x.share(point.0) * columns, y.share(point.1) * places))
        .collect();
    let kept: Vec<_> = kept(&px, steps).into_iter().map(|index| points[index]).collect();
    (
        Column::new(kept.iter().map(|point| point.0), x),
        Column::new(kept.iter().map(|point| point.1), y),
    )
}

/// Rows coloured by a value that holds until the next one.
#[derive(Debug, Serialize)]
pub struct Map {
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    pub unit: String,
    /// Places and values of each row, from top to bottom.
    pub rows: Vec<(Column, Column)>,
}

/// A text at a value of the vertical axis.
#[derive(Debug, Serialize)]
pub struct Text {
    pub y: f64,
    pub label: String,
}

/// Values in order. A value that is not finite is null: a gap in the curve.
#[derive(Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Column {
    /// Differences in units of 10^-d: few digits for smooth values.
    Differences {
        d: usize,
        /// The differences; the first is from 0.
        v: Vec<Option<i64>>,
    },
    /// Values to five digits, for axes that are not linear.
    Values(Vec<Option<f64>>),
}

impl Column {
    pub fn new(values: impl Iterator<Item = f64>, axis: &Axis) -> Self {
        let values = values.map(|value| value.is_finite().then_some(value));
        let Scale::Linear { low, high } = axis.scale else {
            let round = |value: f64| format!("{value:.4e}").parse().unwrap_or(value);
            return Self::Values(values.map(|value| value.map(round)).collect());
        };
        let d = (STEPS / (high - low)).log10().ceil().clamp(0.0, 9.0) as usize;
        let unit = 10_f64.powi(d as i32);
        let mut before = 0;
        let difference = |value: f64| {
            let multiple = (value * unit).round() as i64;
            multiple - std::mem::replace(&mut before, multiple)
        };
        let mut difference = difference;
        Self::Differences { d, v: values.map(|value| value.map(&mut difference)).collect() }
    }
}

/// Text that is safe inside HTML and its attributes.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            _ => safe.push(character),
        }
    }
    safe
}

/// JSON that is safe inside a `script` element: it cannot end the element or a line of the script.
pub fn script_json(value: &impl Serialize) -> String {
    let text = serde_json::to_string(value).expect("a chart is JSON");
    // These characters occur in strings only.
    text.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_differences_and_a_hole_is_null() {
        let axis = Axis::linear("", 0.0, 20.0);
        let column = Column::new([1.5, f64::NAN, 1.501, 1.4].into_iter(), &axis);
        let v = vec![Some(1500), None, Some(1), Some(-101)];
        assert_eq!(column, Column::Differences { d: 3, v });
        let durations = Axis::durations("", [1.0, 1e5].into_iter());
        let column = Column::new([1.23456789, 98_765.4].into_iter(), &durations);
        assert_eq!(column, Column::Values(vec![Some(1.2346), Some(98_765.0)]));
    }

    #[test]
    fn data_cannot_end_its_script_and_markup_stays_text() {
        let text = script_json(&"</script><!--\u{2028}\u{2029}\"");
        assert_eq!(text, r#""\u003c/script>\u003c!--\u2028\u2029\"""#);
        let back: String = serde_json::from_str(&text).expect("still JSON");
        assert_eq!(back, "</script><!--\u{2028}\u{2029}\"");
        assert_eq!(escape("<b title='x'>&"), "&lt;b title=&#39;x&#39;&gt;&amp;");
    }
}
