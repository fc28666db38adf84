//! Figures that the on-board unit reports at its end.

use crate::signers::Signers;
use runtime::statistics::Percentiles;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Frames on air, by what the on-board unit made of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObuReport {
    pub frames: u64,
    /// Frames that arrived and for which a batch had no room.
    pub left_out: u64,
    /// Frames by what was made of them.
    pub verdicts: BTreeMap<String, u64>,
    /// Signed frames with the signers that they name; absent without such a frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signed: Option<Signers>,
    pub cams_sent: u64,
    /// Time from the sending of a frame to its arrival.
    pub air_us: Option<Percentiles>,
    /// Time to decode and check a frame, on the wall clock in both modes.
    pub decode_us: Option<Percentiles>,
    /// Age of the oldest timing of the signals ahead when it is handed on.
    pub age_us: Option<Percentiles>,
}
