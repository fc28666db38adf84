//! Results of a run for people: `report.html`, text tables, CSV, the summary.
//!
//! ```text
//! results ─► RunPicture (series) ─► Plot, Bands (pictures) ─► Chart (data) ─► one page
//! ```
//!
//! The verdict and the figures come first, then the charts, then how the machine ran it. A page
//! loads nothing: uPlot and one script of ours stand in it and draw the charts from data. Without
//! scripts it shows verdict and tables. It is read on a desk, on a telephone, in the dark and on paper.

pub mod chart;
mod compare;
mod drive;
mod duration;
mod following;
pub mod html;
mod link;
pub mod output;
mod picture;
pub mod print;
pub mod progress;
mod radio;
mod run;
pub mod summary;
pub mod table;
mod timing;
pub mod trajectory;
mod trip;

pub use compare::overlay;
pub use following::Following;
pub use picture::RunPicture;
pub use run::{page as run_page, pictures as run_pictures};
pub use timing::{Distribution, distributions};
pub use trip::{Passing, Trip, nothing_ahead};

/// Name of the page in the results' directory.
pub const FILE: &str = "report.html";
