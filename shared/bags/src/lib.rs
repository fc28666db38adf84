//! Number series from recordings of others: MCAP files and ROS 1 bags, by topic and field.
//!
//! ```text
//! file ─► records ─► messages of a topic ─► fields by their path ─► rows of numbers, by time
//!          (mcap, ros1)                       (definition, decode)
//! ```
//!
//! | file | read | not read |
//! | --- | --- | --- |
//! | MCAP ([`mcap`]), ROS 2's default too | CDR with `ros2msg`, ROS 1 with `ros1msg`, JSON; LZ4, Zstandard, none | protobuf, CDR with IDL, XCDR 2 |
//! | ROS 1 bag, version 2.0 | LZ4, no compression | bzip2 (`rosbag decompress` unpacks it) |
//! | ROS 2 bag of SQLite (`.db3`), with feature `sqlite` | CDR; Zstandard a message, none | Zstandard of the whole file (`zstd -d` unpacks it) |
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
mod ros1;
mod series;
mod sink;
#[cfg(feature = "sqlite")]
mod sqlite;
#[cfg(any(feature = "sqlite", test))]
mod standard;

pub use error::BagError;
pub use series::{Row, Series, Topic, is_bag, series, series_from, topics};
pub use sink::Encoding;

#[cfg(test)]
mod tests;
