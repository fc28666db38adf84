//! `bench.json`: stable names for what was measured. A figure that could not be had is null.

use super::goals::Goal;
use super::plan::{Conditions, Load, Placement, Scheduling};
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
    pub goals: Vec<Goal>,
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

impl ByPlacement {
    pub fn of(&self, placement: Placement) -> Option<Percentiles> {
        match placement {
            Placement::SameCore => self.same_core,
            Placement::TwoCores => self.two_cores,
        }
    }
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

/// How a message's bytes get to the reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Passing {
    /// Written into shared memory and read out of it, as services do.
    Copied,
    /// Left where it lies.
    Loaned,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TransportRow {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub period_us: u32,
    pub bytes: usize,
    pub passing: Passing,
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
    /// Of a process that only sleeps, on the controller's core, during the same seconds.
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

    /// The services' own message under these conditions.
    pub fn message(&self, conditions: Conditions) -> Option<Percentiles> {
        let mut rows = self.transport_us.iter().filter(|row| row.passing == Passing::Copied);
        rows.find(|row| row.conditions == conditions).and_then(|row| row.us)
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
