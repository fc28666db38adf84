//! `actors[].profile.csv`: the keys.

use crate::quantity::{Duration, TimeConstant, TimeShift};
use crate::schema::Schema;
use crate::speeds::SpeedPoint;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A recorded motion in a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct CsvFile {
    /// Path of the file (CSV or MCAP). A relative one starts at the scenario file's directory, with `--set`
    /// also at the present one.
    pub file: PathBuf,
    /// Columns by what they hold, with their units: `t=stamp, v=speed:km/h`; absent: `time_s` and `speed_mps`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<String>,
    /// Rows of one vehicle in a file of several: `column=value`; absent: all rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rows: Option<String>,
    /// Topic of a bag, whose messages are the rows and whose fields are the columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub topic: Option<String>,
    /// Start of the run, s after the first row. Negative: the record begins during the run. Absent: the file's own
    /// times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_s: Option<TimeShift>,
    /// Half the window of the smoothing filter, s; absent: no filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smooth_s: Option<TimeConstant>,
    /// Longest step between two rows, s; absent: in a regular record ten usual steps, at least 1 s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_gap_s: Option<Duration>,
    /// Motion after the last row.
    #[serde(default, skip_serializing_if = "AfterEnd::is_default")]
    pub after_end: AfterEnd,
    /// The file's content when the scenario was opened. It is not read again if present.
    #[serde(default)]
    pub points: Vec<SpeedPoint>,
}

/// Motion after the last row of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum AfterEnd {
    /// Keeps the last speed.
    #[default]
    KeepSpeed,
    /// Brakes to a stop at 2 m/s².
    Stop,
    /// Leaves the road.
    Leave,
}

impl AfterEnd {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::KeepSpeed, Self::Stop, Self::Leave];

    /// The name, as a scenario says it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::KeepSpeed => "keep-speed",
            Self::Stop => "stop",
            Self::Leave => "leave",
        }
    }

    fn is_default(&self) -> bool {
        *self == Self::KeepSpeed
    }
}

/// Keys that say how the file is read, beside the file itself.
pub(crate) const READING: [&str; 7] =
    ["columns", "rows", "topic", "offset_s", "smooth_s", "max_gap_s", "after_end"];
