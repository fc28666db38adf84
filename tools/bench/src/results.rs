//! `bench.json`: stable names for what was measured. A figure that could not be had is null.

use super::goals::Goal;
use super::paired::{Compared, Comparison};
use super::setup::{Conditions, Load, Placement, Scheduling};
use super::statistics;
use report::summary::Host;
use runtime::report::Hops;
use runtime::statistics::Percentiles;
use serde::{Deserialize, Serialize};

/// A whole benchmark.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    pub schema_version: u32,
    pub host: Host,
    pub quick: bool,
    /// Length of each measurement, s.
    pub seconds: f64,
    /// What the kernel did not grant, in its words.
    pub refused: Vec<String>,
    pub floor: Floor,
    pub transport_us: Vec<TransportRow>,
    pub chain: Vec<ChainRow>,
    pub deadlines: Vec<DeadlineRow>,
    /// Comparisons in alternating blocks, which the goals are judged by.
    #[serde(skip_deserializing)]
    pub paired: Vec<PairedRow>,
    /// Peers that this build has not, each with the reason.
    #[serde(default)]
    pub not_compared: Vec<String>,
    /// What is promised, with its interval and verdict.
    #[serde(skip_deserializing)]
    pub goals: Vec<Goal>,
    /// What keeps this machine from being the one that the goals are meant for.
    #[serde(default)]
    pub caveats: Vec<String>,
}

/// A comparison of two ways to wake, block by block.
#[derive(Clone, Debug, Serialize)]
pub struct PairedRow {
    /// What was compared with what.
    pub comparison: Comparison,
    /// Under which conditions.
    #[serde(flatten)]
    pub conditions: Conditions,
    /// Time between two wake-ups, µs.
    pub period_us: u32,
    /// Pairs of blocks.
    pub pairs: usize,
    /// Wake-ups that never arrived.
    pub lost: u64,
    /// Ours, µs.
    pub ours_us: Option<Percentiles>,
    /// The floor, µs.
    pub floor_us: Option<Percentiles>,
    /// Ratio of the medians.
    pub ratio: Option<f64>,
    /// Its 95 % interval, lower and upper end.
    pub ci95: Option<[f64; 2]>,
}

impl PairedRow {
    /// The row of a comparison.
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

/// What the machine itself takes. The named figures are those of an idle machine under `SCHED_FIFO`
/// at 1 kHz.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Floor {
    /// Lateness of absolute sleeps.
    pub sleep_jitter_us: Option<Percentiles>,
    pub futex_us: ByPlacement,
    pub eventfd_us: ByPlacement,
    pub iceoryx2_event_us: ByPlacement,
    pub rows: Vec<FloorRow>,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct ByPlacement {
    pub same_core: Option<Percentiles>,
    pub two_cores: Option<Percentiles>,
}

/// What a floor row measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FloorMeasure {
    Sleep,
    Futex,
    Eventfd,
    Iceoryx2Event,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FloorRow {
    pub measure: FloorMeasure,
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub us: Option<Percentiles>,
}

/// What is handed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Passing {
    /// A message of the services, protected and checked.
    Message,
    /// Bytes that neither end touches.
    Bare,
    /// Bytes that are written, protected and checked where they are.
    Protected,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TransportRow {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub bytes: usize,
    pub passing: Passing,
    /// Bytes that were copied for each one, between the sender's writing and the reader's reading.
    #[serde(default)]
    pub copied_bytes: Option<f64>,
    /// Sent and never received.
    pub lost: Option<u64>,
    pub us: Option<Percentiles>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ChainRow {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub reaction_time_us: Option<Percentiles>,
    pub designed_wait_us: Option<Percentiles>,
    /// Reaction time without its designed waits.
    pub net_reaction_us: Option<Percentiles>,
    /// Sum of the medians of what the machine and the law take: two absolute sleeps (radar and plant),
    /// a futex wake-up at this period, the law. Null where the futex was not measured at this period.
    pub floor_sum_us: Option<f64>,
    pub hops_us: Hops,
    pub solve_us: Option<Percentiles>,
    /// Lateness of a process that only sleeps, on the controller's core, during the same seconds.
    pub sleep_jitter_us: Option<Percentiles>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DeadlineRow {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub cycles: Option<u64>,
    pub misses: Option<u64>,
    pub misses_per_million: Option<f64>,
    /// Of a process that sleeps and computes for as long as the law, on the controller's core, during the same
    /// seconds.
    pub floor_cycles: Option<u64>,
    pub floor_misses: Option<u64>,
    pub floor_misses_per_million: Option<f64>,
}

impl Report {
    /// The wake-up by futex under these conditions at this period.
    pub fn futex(&self, conditions: Conditions, period_us: u32) -> Option<Percentiles> {
        let mut rows = self.floor.rows.iter().filter(|row| {
            row.measure == FloorMeasure::Futex
                && row.conditions == conditions
                && row.period_us == period_us
        });
        rows.next().and_then(|row| row.us)
    }

    /// The chain under these conditions at this period.
    pub fn chain(&self, conditions: Conditions, period_us: u32) -> Option<&ChainRow> {
        let mut rows = self.chain.iter();
        rows.find(|row| row.conditions == conditions && row.period_us == period_us)
    }
}

impl Floor {
    /// Keeps a row, and its figure under its name if it is of the reference conditions.
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
