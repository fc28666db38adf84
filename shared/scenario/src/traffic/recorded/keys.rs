//! `actors[].profile.csv`: the keys.

use crate::quantity::{Duration, TimeConstant, TimeShift};
use crate::speeds::SpeedPoint;
use scenario_derive::tables;
use std::path::PathBuf;

tables! {
    /// A recorded motion in a file.
    #[derive(Default)]
    pub struct CsvFile {
        /// Path of the file (CSV or MCAP). A relative one starts at the scenario file's directory, with
        /// `--set` also at the present one.
        pub file: PathBuf,
        /// Columns by what they hold, with their units: `t=stamp, v=speed:km/h`; absent: `time_s` and `speed_mps`.
        pub columns: Option<String>,
        /// Rows of one vehicle in a file of several: `column=value`; absent: all rows.
        pub rows: Option<String>,
        /// Topic of a bag, whose messages are the rows and whose fields are the columns.
        pub topic: Option<String>,
        /// Start of the run, s after the first row. Negative: the record begins during the run. Absent: the file's own
        /// times.
        pub offset_s: Option<TimeShift>,
        /// Half the window of the smoothing filter, s; absent: no filter.
        pub smooth_s: Option<TimeConstant>,
        /// Longest step between two rows, s; absent: in a regular record ten usual steps, at least 1 s.
        pub max_gap_s: Option<Duration>,
        /// Motion after the last row.
        pub after_end: AfterEnd = sparse,
        /// The file's content when the scenario was opened. It is not read again if present.
        pub points: Vec<SpeedPoint> = default,
    }

    /// Motion after the last row of a record.
    pub enum AfterEnd {
        /// Keeps the last speed.
        #[default]
        KeepSpeed,
        /// Brakes to a stop at 2 m/s².
        Stop,
        /// Leaves the road.
        Leave,
    }
}

/// Keys that say how the file is read, beside the file itself.
pub(crate) const READING: [&str; 7] =
    ["columns", "rows", "topic", "offset_s", "smooth_s", "max_gap_s", "after_end"];
