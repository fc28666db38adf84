//! Pictures as data, which the page's script draws (`assets/charts.js` with `assets/shapes.js`).
//!
//! * [`Plot`]: curves over two axes (linear, logarithmic or by percentiles). It has marks by numbers or letters, and
//!   strips, such as a signal's phases at its stop line. A curve need not be a function of the horizontal value.
//! * [`scatter`] and [`cells`]: points, or filled cells of a grid, of some kinds over two axes, with edges.
//! * [`Bands`]: rows of labelled spans over one axis: modes over time, the parts of a chain.
//! * [`parallel`]: lines through one value a row, such as the variables of many runs.
//! * [`ribbons`]: rows coloured by a value along one axis: speeds of many vehicles over time.
//!
//! A picture becomes a [`Chart`]: series over two axes, with the points that a screen can show. The script
//! takes every colour from the page's style sheet, so that one page serves light, dark and paper.
//!
//! ```
//! use report::chart::{Chart, Curve, Plot, Tone, script_json};
//!
//! let speed_mps = vec![(0.0, 20.0), (5.0, 25.0), (10.0, 25.0)];
//! let ego = Curve::new("ego", Tone::Series(0), speed_mps);
//! let plot = Plot::over_time("Speed", 10.0, "m/s", vec![ego]);
//! let data = script_json(&Chart::from(&plot));
//! assert!(data.contains("\"label\":\"ego\""));
//! ```

mod axis;
mod bands;
mod cells;
mod data;
mod decimate;
mod plot;
mod ribbons;

pub use axis::{Axis, number};
pub use bands::{Bands, Row, Span, parallel};
pub use cells::{Edges, cells, scatter};
pub use data::{Chart, escape, script_json};
pub use plot::{Curve, Plot, Strip};
pub use ribbons::ribbons;

/// A colour by its meaning; the style sheet defines how it looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// One of eight colours that colour-blind readers can distinguish.
    Series(usize),
    /// Goals and references.
    Muted,
    /// A green light.
    Go,
    /// A yellow light.
    Clear,
    /// A red light.
    Stop,
    Alarm,
}

impl Tone {
    const fn name(self) -> &'static str {
        match self {
            Self::Series(index) => ["t0", "t1", "t2", "t3", "t4", "t5", "t6", "t7"][index % 8],
            Self::Muted => "muted",
            Self::Go => "go",
            Self::Clear => "clear",
            Self::Stop => "stop",
            Self::Alarm => "alarm",
        }
    }
}

/// Line style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Measured values. Several solid curves of one picture get different dashes.
    Solid,
    /// Targets and references.
    Dashed,
    /// Constants, and vehicles beside the lane.
    Dotted,
}

impl Stroke {
    const fn name(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::Dashed => "dashed",
            Self::Dotted => "dotted",
        }
    }
}

/// A marked place on the horizontal axis; a table beside the picture explains the labels.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Place on the axis.
    pub x: f64,
    /// Number of a fault, letter of a requirement.
    pub label: String,
    pub tone: Tone,
}

impl Mark {
    /// A place with a number, in the colour of a fault.
    pub fn numbered(x: f64, number: usize) -> Self {
        Self { x, label: number.to_string(), tone: Tone::Alarm }
    }
}
