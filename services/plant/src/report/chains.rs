//! Figures of the cause-effect chains that ended at the actuators.

use runtime::statistics::Percentiles;
use serde::{Deserialize, Serialize};

/// A value for each part of a reaction time, in order of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Parts<T> {
    /// Acquisition to the sample's publication: the radar's latency, its release, scan and tracking.
    pub radar_publish: T,
    /// Time for which the published sample lay there and the controller was busy or not yet due.
    pub controller_queue: T,
    /// Time from then until the controller had woken up with it.
    pub radar_transport: T,
    /// Start of the control cycle to its command's publication.
    pub controller_compute: T,
    /// Publication of the command to the scheduled release of the plant that looks for it.
    pub command_wait: T,
    /// Time from then until the plant had woken up.
    pub command_transport: T,
    /// Time from then to the actuators.
    pub actuate: T,
}

impl<T> From<[T; 7]> for Parts<T> {
    fn from([publish, queue, transport, compute, wait, wake, actuate]: [T; 7]) -> Self {
        Self {
            radar_publish: publish,
            controller_queue: queue,
            radar_transport: transport,
            controller_compute: compute,
            command_wait: wait,
            command_transport: wake,
            actuate,
        }
    }
}

/// The parts of the reaction time, which add up to it sample by sample, and sums of the first three and the last three:
///
/// ```text
/// radar_to_controller = radar_publish + controller_queue + radar_transport
/// controller_compute
/// controller_to_plant = command_wait + command_transport + actuate
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hops {
    /// Radar acquisition to the start of the control cycle that uses it.
    pub radar_to_controller: Option<Percentiles>,
    /// Publication of the command to its first actuation.
    pub controller_to_plant: Option<Percentiles>,
    #[serde(flatten)]
    pub parts: Parts<Option<Percentiles>>,
}

/// Parts of the time from a signal's change to the first actuation that uses the new phase. Their sum is that time:
///
/// ```text
/// changed ─► timing made ─► v2x/spat published ─► command published ─► actuated
///       announce       receive              control               actuate
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SignalHops {
    /// Time from the change to the making of the message that shows it: the roadside unit's period.
    pub announce: Option<Percentiles>,
    /// Time from there through frame, air and decoding to the publication of `v2x/spat`.
    pub receive: Option<Percentiles>,
    /// Time from there to the publication of the command.
    pub control: Option<Percentiles>,
    /// Time from there to the actuators.
    pub actuate: Option<Percentiles>,
}

/// One chain, whole, with what the controller's cycle met with: what to look at first when a
/// deadline was missed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorstChain {
    /// Run time of the actuation, s.
    pub t_s: f64,
    /// Sequence number of the radar sample.
    pub radar_sequence: u64,
    pub command_sequence: u64,
    /// Radar acquisition to actuation, µs.
    pub reaction_time_us: f64,
    pub designed_wait_us: f64,
    pub hops_us: Parts<f64>,
    /// True if the control cycle finished after its deadline.
    pub deadline_missed: bool,
    /// Age of the odometry sample at the start of the control cycle, µs; null without a sample.
    pub odometry_age_us: Option<f64>,
    /// Age of the radar sample then, µs.
    pub radar_age_us: Option<f64>,
    /// Age of the signal timing then, µs; null without a sample.
    pub spat_age_us: Option<f64>,
    pub solver_iterations: u32,
    /// Mode of the law, an index.
    pub mode: u32,
    /// Times that the control cycle gave the processor up.
    pub voluntary_switches: u32,
    /// Times that the processor was taken from it.
    pub involuntary_switches: u32,
    /// Page faults served from memory.
    pub minor_faults: u32,
    /// Page faults that waited for a device.
    pub major_faults: u32,
}
