//! Pictures as SVG that takes its colours from the page's style sheet, so that one picture serves
//! light, dark and paper.
//!
//! * [`Plot`]: curves over two axes, linear, logarithmic or by percentiles, with background bands,
//!   reference levels, numbered marks and strips (a signal's phases at its stop line).
//! * [`Cells`]: filled cells of a grid over two axes, with edges.
//! * [`Bands`]: rows of labelled spans over one axis: modes over time, the parts of a chain.
//! * [`Ribbons`]: rows coloured by a value along one axis: speeds of many vehicles over time.
//!
//! A picture is drawn once for each [`Width`], since text that is scaled down cannot be read; the
//! style sheet shows the one that fits. Legends are text of the page and wrap like it.

mod axis;
mod bands;
mod cells;
mod decimate;
mod plot;
mod ribbons;
mod svg;

pub use axis::{Axis, number};
pub use bands::{Bands, Row, Span};
pub use cells::{Cells, Edges, FilledCell};
pub use plot::{Curve, Plot, Point, Strip};
pub use ribbons::{Ribbon, Ribbons, SHADES};

/// What a picture is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// A desk or a sheet of paper.
    Wide,
    /// A telephone.
    Narrow,
}

impl Width {
    /// Both, in the order in which a page has them.
    pub const ALL: [Self; 2] = [Self::Wide, Self::Narrow];

    /// Width of the picture, px.
    pub const fn px(self) -> f64 {
        match self {
            Self::Wide => 680.0,
            Self::Narrow => 350.0,
        }
    }

    /// Class that the style sheet shows or hides.
    pub const fn class(self) -> &'static str {
        match self {
            Self::Wide => "wide",
            Self::Narrow => "narrow",
        }
    }
}

/// A colour by its meaning; the style sheet knows how it looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// One of eight that colour-blind readers tell apart.
    Series(usize),
    /// Goals and references.
    Muted,
    /// A green light.
    Go,
    /// A yellow light.
    Clear,
    /// A red light.
    Stop,
    /// A fault.
    Alarm,
    /// A step of the scale from low to high, the same in light and dark.
    Shade(usize),
}

impl Tone {
    const fn class(self) -> &'static str {
        match self {
            Self::Series(index) => ["t0", "t1", "t2", "t3", "t4", "t5", "t6", "t7"][index % 8],
            Self::Muted => "muted",
            Self::Go => "go",
            Self::Clear => "clear",
            Self::Stop => "stop",
            Self::Alarm => "alarm",
            Self::Shade(step) => ["q0", "q1", "q2", "q3", "q4", "q5", "q6", "q7"][step % SHADES],
        }
    }
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// For what is.
    Solid,
    /// For what should be.
    Dashed,
    /// For what is fixed, or for what is not in the lane.
    Dotted,
}

impl Stroke {
    const fn class(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::Dashed => "dashed",
            Self::Dotted => "dotted",
        }
    }
}

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// What it says.
    pub label: String,
    /// Colour.
    pub tone: Tone,
    /// Stroke of a curve; none for an area.
    pub stroke: Option<Stroke>,
}

impl Key {
    /// The entry as HTML: a sample and its label.
    pub fn html(&self) -> String {
        let sample = match self.stroke {
            Some(stroke) => {
                format!("<path class=\"line {}\" d=\"M0 5H22\"/>", stroke.class())
            }
            None => "<rect class=\"fill\" width=\"22\" height=\"10\" rx=\"2\"/>".to_owned(),
        };
        format!(
            "<span class=\"key\"><svg class=\"{}\" width=\"22\" height=\"10\" aria-hidden=\"true\">\
             {sample}</svg>{}</span>",
            self.tone.class(),
            svg::escape(&self.label),
        )
    }
}

/// A numbered instant or place on the horizontal axis; the page says beside the picture what the
/// numbers mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Place on the axis.
    pub x: f64,
    /// Number.
    pub number: usize,
}

/// Anything that can be drawn at both widths.
pub trait Picture {
    /// Title, with the unit where one axis has all.
    fn title(&self) -> &str;
    /// Legend; empty where nothing needs one.
    fn keys(&self) -> Vec<Key>;
    /// The picture as an SVG element.
    fn svg(&self, width: Width) -> String;
}

pub use svg::escape;
