//! Results of a run for people: console text, `report.html`, tables, CSV, and `summary.json`.
//!
//! ```text
//! GroupOutcome ─► Summary ─► console, summary.json
//!              └► RunPicture (series) ─► Plot, Bands (pictures) ─► Chart (data) ─► page
//!                          └► PlaneView (road with a plan) ────────────────────────────┘
//! ```
//!
//! A page begins with verdict and figures; charts and the machine's data follow. It loads nothing: uPlot and
//! one script of ours are in it and draw the charts from data. Without JavaScript it shows verdict and tables.
//! It fits a desk, a telephone, dark mode and paper.
//!
//! ```
//! use report::chart::{Curve, Plot, Tone};
//! use report::html::{document, figure};
//!
//! let speed_mps = vec![(0.0, 20.0), (5.0, 25.0), (10.0, 25.0)];
//! let plot = Plot::over_time("Speed", 10.0, "m/s", vec![Curve::new("ego", Tone::Series(0), speed_mps)]);
//! let page = document("My run", "30 s", true, "Completed", &figure(&plot));
//! assert!(page.contains("<h1>My run</h1>") && page.contains("\"label\":\"ego\""));
//! ```

pub mod chart;
mod compare;
pub mod figures;
pub mod gate;
pub mod html;
mod lateral;
pub mod output;
mod over_time;
mod picture;
mod plane;
pub mod print;
pub mod results;
mod run;
pub mod table;
mod timing;
pub mod trajectory;
pub mod verdicts;

pub use ::drive::summary::{self, Following, Passing, Trip, targets};
pub use compare::overlay;
pub use picture::RunPicture;
pub use plane::PlaneView;
pub use run::{document as run_document, pictures as run_pictures};
pub use timing::{Distribution, distributions};

/// Name of the page in the results' directory.
pub const FILE: &str = "report.html";
