//! `bench.json`: stable names for the measurements. A figure that is not available is null.

use super::goals::Goal;
use super::paired::{Compared, Comparison};
use super::setup::{Conditions, Load, Placement, Scheduling};
use super::statistics;
use doctor::wake_ups::WakeUps;
use report::gate::{Against, Sample};
use report::results::Object;
use report::summary::Host;
use runtime::statistics::Percentiles;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use supervise::report::Hops;

#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Report {
    pub schema_version: u32,
    #[schemars(with = "Object")]
    pub host: Host,
    pub quick: bool,
    /// Length of each measurement, s.
    pub seconds: f64,
    /// Loops that hold on this machine.
    #[schemars(with = "Option<Object>")]
    pub wake_ups: Option<WakeUps>,
    /// Requests that the kernel refused, with its reasons.
    pub refused: BTreeSet<String>,
    pub floor: Floor,
    pub transport_us: Vec<TransportRow>,
    pub chain: Vec<ChainRow>,
    pub deadlines: Vec<DeadlineRow>,
    /// Comparisons in alternating blocks, which decide the goals.
    pub paired: Vec<PairedRow>,
    /// Goals with interval and verdict.
    pub goals: Vec<Goal>,
    /// Differences between this machine and the one that the goals are meant for.
    pub caveats: Vec<String>,
    /// Figures over their floor, for `--against`.
    #[schemars(with = "Vec<Object>")]
    pub samples: Vec<Sample>,
    /// The comparison with an earlier benchmark; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<Against>,
}

/// A comparison of two ways to wake, block by block.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct PairedRow {
    pub comparison: Comparison,
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub pairs: usize,
    pub lost: u64,
    #[schemars(with = "Option<Object>")]
    pub ours_us: Option<Percentiles>,
    #[schemars(with = "Option<Object>")]
    pub floor_us: Option<Percentiles>,
    pub ratio: Option<f64>,
    /// Its 95 % interval, lower and upper end.
    pub ci95: Option<[f64; 2]>,
}

impl PairedRow {
    pub fn of(compared: &Compared) -> Self {
        let [ours, floor] = compared.histograms();
        let medians = statistics::medians(&compared.sessions());
        Self {
            comparison: compared.comparison,
            conditions: compared.conditions,
            period_us: compared.period_us,
            pairs: compared.pairs.len(),
            lost: compared.lost,
            ours_us: ours.percentiles_us(),
            floor_us: floor.percentiles_us(),
            ratio: medians.map(|estimate| estimate.ratio),
            ci95: medians.map(|estimate| [estimate.low, estimate.high]),
        }
    }
}

/// The machine's floor. The named figures are of an idle machine under `SCHED_FIFO` at 1 kHz.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct Floor {
    #[schemars(with = "Option<Object>")]
    pub sleep_jitter_us: Option<Percentiles>,
    pub futex_us: ByPlacement,
    pub eventfd_us: ByPlacement,
    pub iceoryx2_event_us: ByPlacement,
    pub rows: Vec<FloorRow>,
}

#[derive(Clone, Copy, Debug, Default, Serialize, JsonSchema)]
pub struct ByPlacement {
    #[schemars(with = "Option<Object>")]
    pub same_core: Option<Percentiles>,
    #[schemars(with = "Option<Object>")]
    pub two_cores: Option<Percentiles>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FloorMeasure {
    Sleep,
    Futex,
    Eventfd,
    Iceoryx2Event,
}

#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FloorRow {
    pub measure: FloorMeasure,
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    #[schemars(with = "Option<Object>")]
    pub us: Option<Percentiles>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Passing {
    /// A message of the services, protected and checked.
    Message,
    /// Bytes that neither end reads or writes.
    Bare,
    /// Bytes that are written, protected and checked in place.
    Protected,
}

#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct TransportRow {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub bytes: usize,
    pub passing: Passing,
    /// Bytes copied for each message between the sender's writing and the reader's reading.
    pub copied_bytes: Option<f64>,
    /// Messages sent and never received.
    pub lost: Option<u64>,
    #[schemars(with = "Option<Object>")]
    pub us: Option<Percentiles>,
}

#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ChainRow {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    #[schemars(with = "Option<Object>")]
    pub reaction_time_us: Option<Percentiles>,
    #[schemars(with = "Option<Object>")]
    pub designed_wait_us: Option<Percentiles>,
    /// Software overhead: reaction time without radar latency and waits for the next period.
    #[schemars(with = "Option<Object>")]
    pub net_reaction_us: Option<Percentiles>,
    /// Sum of the medians of the floors. They are two absolute sleeps (radar and plant), a futex wake-up at this
    /// period, and the law. Null without a futex measurement at this period.
    pub floor_sum_us: Option<f64>,
    #[schemars(with = "Object")]
    pub hops_us: Hops,
    #[schemars(with = "Option<Object>")]
    pub solve_us: Option<Percentiles>,
    /// Lateness of a process that only sleeps, on the controller's core, during the same seconds.
    #[schemars(with = "Option<Object>")]
    pub sleep_jitter_us: Option<Percentiles>,
}

#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct DeadlineRow {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub cycles: Option<u64>,
    pub misses: Option<u64>,
    pub misses_per_million: Option<f64>,
    /// Cycles of a process that sleeps and computes for the law's time, on the controller's core during the
    /// same seconds.
    pub floor_cycles: Option<u64>,
    pub floor_misses: Option<u64>,
    pub floor_misses_per_million: Option<f64>,
}

impl Report {
    /// The wake-up by futex under these conditions at this period.
    pub fn futex(&self, conditions: Conditions, period_us: u32) -> Option<Percentiles> {
        let sought = (FloorMeasure::Futex, conditions, period_us);
        let is_it = |row: &&FloorRow| (row.measure, row.conditions, row.period_us) == sought;
        self.floor.rows.iter().find(is_it)?.us
    }
}

impl Floor {
    /// Adds a row, and its named figure if the conditions are the reference.
    pub fn add(&mut self, row: FloorRow, reference_period_us: u32) {
        let Conditions { placement, scheduling, load } = row.conditions;
        let reference = scheduling == Scheduling::Fifo && load == Load::Idle;
        if reference && row.period_us == reference_period_us {
            let named = match row.measure {
                FloorMeasure::Futex => Some(&mut self.futex_us),
                FloorMeasure::Eventfd => Some(&mut self.eventfd_us),
                FloorMeasure::Iceoryx2Event => Some(&mut self.iceoryx2_event_us),
                FloorMeasure::Sleep => {
                    self.sleep_jitter_us = self.sleep_jitter_us.or(row.us);
                    None
                }
            };
            if let Some(named) = named {
                match placement {
                    Placement::SameCore => named.same_core = row.us,
                    Placement::TwoCores => named.two_cores = row.us,
                }
            }
        }
        self.rows.push(row);
    }
}
