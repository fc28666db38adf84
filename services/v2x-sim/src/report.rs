//! Figures that v2x-sim reports at its end, if the run's roadside units are on other hosts or in a capture.

use serde::{Deserialize, Serialize};

/// Frames between the vehicle and other hosts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkReport {
    pub carrier: String,
    /// The vehicle's frames that were handed to the network.
    pub sent: u64,
    /// Those that could not be handed over.
    pub not_sent: u64,
    /// Frames received, without repeats.
    pub received: u64,
    /// Frames among these that came before the run began.
    pub before_start: u64,
    /// Frames that were not read in time: the queue was full.
    pub dropped: u64,
    /// Packets that are not frames.
    pub malformed: u64,
    /// True if the true state of the signals is known: the unit runs the same scenario and sends when it began. Else
    /// the referee does not judge red lights.
    pub truth_known: bool,
    /// Each sender that was received and names itself, vehicles too.
    pub stations: Vec<StationReport>,
}

/// Frames of one sender.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StationReport {
    /// Its number, in hexadecimal digits; drawn anew at each start.
    pub sender: String,
    pub received: u64,
    /// Frames between the first and the last received that never came.
    pub lost: u64,
    /// Frames that came again.
    pub duplicates: u64,
    /// Frames that another overtook.
    pub reordered: u64,
    /// Frames that were not taken because their number was far from all others.
    #[serde(default)]
    pub implausible: u64,
    /// Its clock minus the vehicle's, µs; null: a vehicle's, or not known.
    pub clock_offset_us: Option<f64>,
    /// The true difference is at most this far from that, µs.
    pub clock_uncertainty_us: Option<f64>,
    /// Shortest round trip of a question about the clock and its answer, µs.
    pub shortest_round_trip_us: Option<f64>,
}
