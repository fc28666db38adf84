//! Roads in the plane, by arc length.
//!
//! An [`Axis`] is a chain of pieces: lines, arcs, clothoids and cubics. It begins at (0, 0) with heading 0, x ahead and
//! y to the left. A point of the road has the coordinates (p, l): `p` along the axis, `l` to its left.
//!
//! ```text
//! heading   θ(p) = ∫ κ dp            κ: curvature, 1/m, positive in a left curve
//! axis      x(p) = ∫ cos θ dp,  y(p) = ∫ sin θ dp
//! point     x(p) - l sin θ,     y(p) + l cos θ
//! ```
//!
//! The integrals are taken once, for the middles of cells of at most 5 m. The method is Gauss-Legendre quadrature with
//! 8 points. A cell never reaches across the joint of two pieces. Inside a cell a Taylor series serves, without a
//! transcendental function. Its error is below 1e-6 m down to a radius of 20 m. A call allocates nothing.
//!
//! Straight parts at the beginning give `p` and `l` back exactly, so that a straight road costs no digit.
//!
//! ```
//! use road::{Axis, Piece};
//! let axis = Axis::new(&[
//!     Piece::Line { length_m: 100.0 },
//!     Piece::Spiral { length_m: 50.0, start_perm: 0.0, end_perm: 0.002 },
//!     Piece::Arc { length_m: 200.0, curvature_perm: 0.002 },
//! ])?;
//! assert_eq!(axis.point(40.0, 3.5).y_m, 3.5);
//! let lead = axis.point(250.0, -3.5);
//! let (p_m, l_m) = axis.project(lead.x_m, lead.y_m, 240.0);
//! assert!((p_m - 250.0).abs() < 1e-6 && (l_m + 3.5).abs() < 1e-6);
//! # Ok::<(), road::AxisError>(())
//! ```

#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN fails a check that is written so")]

mod axis;
mod beside;
mod build;
mod cell;
mod cubic;
mod error;
pub mod grade;
mod lanes;
mod lines;
mod piece;
mod pose;
mod profile;
pub mod random;
mod smooth;

pub use axis::Axis;
pub use beside::Leg;
pub use cell::Place;
pub use error::{AxisError, AxisFault};
pub use lanes::{Lane, Lanes, Section, Strip};
pub use lines::{LaneLines, offset_at};
pub use piece::{Laid, Piece};
pub use pose::Pose;
pub use profile::{Profile, Stretch};

/// Smallest radius of an axis, m.
pub const MIN_RADIUS_M: f64 = 20.0;
/// Longest axis, m.
pub const MAX_LENGTH_M: f64 = 1e6;
/// Two branches of an axis must not cross where they are less than this apart along it, m.
pub const CROSSING_WITHIN_M: f64 = 200.0;
/// Largest gap between two pieces that are laid, m.
pub const MAX_GAP_M: f64 = 0.05;
/// Largest kink between two pieces that are laid, rad.
pub const MAX_KINK_RAD: f64 = 0.01;
/// Largest kink of an axis beside another one, rad: lanes that shift begin to do so with a kink.
pub const MAX_SHIFT_RAD: f64 = 0.3;
