//! Number series from recordings of others: MCAP files, ROS 2's default, by topic and field.
//!
//! ```text
//! file ─► records ─► messages of a topic ─► fields by their path ─► rows of numbers, by time
//!             (mcap)                       (definition, decode)
//! ```
//!
//! | | read | not read |
//! | --- | --- | --- |
//! | messages | CDR with `ros2msg`, ROS 1 with `ros1msg`, JSON | protobuf, CDR with IDL, XCDR 2 |
//! | chunks | LZ4, Zstandard, no compression | |
//!
//! A series of positions or speeds becomes a motion: [`speeds`] and the filter [`smoothed`].
//!
//! ROS 1 bags and bags of SQLite are recognised and refused with the program that makes an MCAP file of them.
//!
//! A file streams from front to back, one chunk in memory. Every length is checked before memory is taken for it.
//! A field is named by its path as in the definition: `twist.linear.x`, `pose.covariance[0]`. A path that ends at
//! a time (`header.stamp`) gives seconds since 1970.
//!
//! ```no_run
//! let fields = ["header.stamp", "twist.linear.x"].map(String::from);
//! let series = bags::series("drive.mcap".as_ref(), "/gps/velocity", &fields)?;
//! println!("{} messages, the first at {} s", series.rows.len(), series.rows[0].log_time_s());
//! # Ok::<(), bags::BagError>(())
//! ```

mod decode;
mod definition;
mod error;
pub mod mcap;
mod motion;
mod series;
mod smooth;

use decode::Encoding;
pub use error::{BagError, BagFault};
pub use motion::{Motion, speeds};
pub use series::{Row, Series, Topic, is_bag, series, series_from, topics};
pub use smooth::smoothed;

#[cfg(test)]
mod tests;
