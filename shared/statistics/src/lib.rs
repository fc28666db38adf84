//! Means with their spread, and intervals for the centre of paired differences.
//!
//! ```text
//! figures of law A over the seeds ─┬─► Spread: mean ± deviation, n
//! figures of law B over the seeds ─┴─► A - B, seed by seed ─► Interval: [low, high]
//! ```
//!
//! A mean over seeds means little without its spread. Two laws that met the same seeds are compared seed by seed. The
//! common effect of a seed then cancels in the difference.
//!
//! ```
//! let differences = [0.4, 0.1, 0.3, 0.2, 0.6, 0.3];
//! let interval = statistics::interval(&differences, 0.05).expect("six pairs are enough");
//! assert_eq!((interval.low, interval.high), (0.1, 0.6));
//! assert!(interval.leaves_out_zero());
//! ```

mod paired;
mod quantile;
mod spread;

pub use paired::{Interval, interval, least_pairs};
pub use quantile::{beta_quantile, poisson_interval, student_t};
pub use spread::Spread;
