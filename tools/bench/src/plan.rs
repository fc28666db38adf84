//! Measurements, their conditions and their order.

use super::paired::{Comparison, PAIRS, PAIRS_IN_SESSION, UNCOUNTED, WAKES, sessions};
use super::setup::{Conditions, FLAT_FROM, LARGEST, Load, Mechanism, Placement, Scheduling};
use indicatif::ProgressBar;
use std::time::Duration;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Jitter of absolute sleeps.
    Sleep,
    /// Time from before the sender's first action until the receiver has the message.
    Wake(Mechanism),
    /// The four services with the 100-step problem in their loop.
    Chain,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    pub measure: Measure,
    pub conditions: Conditions,
    pub period_us: u32,
}

pub const CONTROLLER_PERIODS_US: [u32; 7] = [100_000, 50_000, 20_000, 10_000, 5_000, 2_000, 1_000];
/// Sizes of the payloads, bytes; from [`FLAT_FROM`] on the time is constant.
pub const PAYLOAD_BYTES: [usize; 8] =
    [64, 1 << 10, FLAT_FROM, 1 << 14, 1 << 16, 1 << 18, 1 << 20, LARGEST];
/// Sizes of the payloads of a quick run, bytes.
const QUICK_PAYLOAD_BYTES: [usize; 3] = [64, FLAT_FROM, LARGEST];
/// Period of the wake-up measurements, µs.
const WAKE_PERIOD_US: u32 = 1_000;
/// Period of a quick run's comparisons, µs.
const QUICK_WAKE_PERIOD_US: u32 = 330;
/// Longer period of the wake-up measurements, with cold caches, µs.
pub const COLD_PERIOD_US: u32 = 10_000;

impl Cell {
    /// Words beside the progress bar.
    pub fn describe(&self) -> String {
        let what = match self.measure {
            Measure::Sleep => "sleep".into(),
            Measure::Wake(way) => way.name(),
            Measure::Chain => format!("chain {} ms", self.period_us / 1000),
        };
        format!("{what}, {}", self.conditions.in_words())
    }

    /// Duration if each measurement lasts `seconds`.
    pub fn estimate(&self, seconds: f64) -> Duration {
        let overhead_s = match self.measure {
            Measure::Chain => 0.25,
            Measure::Sleep | Measure::Wake(_) => 0.05,
        };
        Duration::from_secs_f64(seconds + overhead_s)
    }
}

/// Comparisons in alternating blocks on `cores` cores, and the time between two wake-ups, µs. A quick run
/// wakes more often.
pub fn comparisons(
    quick: bool,
    cores: usize,
    reference: Scheduling,
) -> Vec<(Comparison, Conditions, u32)> {
    let period_us = if quick { QUICK_WAKE_PERIOD_US } else { WAKE_PERIOD_US };
    let of = |conditions| Comparison::ALL.map(|comparison| (comparison, conditions, period_us));
    quietest(cores, reference).flat_map(of).collect()
}

pub fn comparison_estimate(quick: bool, period_us: u32) -> Duration {
    sessions(quick) * session_estimate(period_us)
}

pub fn session_estimate(period_us: u32) -> Duration {
    let wakes = 2 * PAIRS_IN_SESSION * (WAKES + UNCOUNTED);
    Duration::from_micros(u64::from(wakes) * u64::from(period_us)) + Duration::from_millis(150)
}

/// A chain in blocks beside its floors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainBlocks {
    pub conditions: Conditions,
    /// Period of perception and controller, µs.
    pub period_us: u32,
    pub blocks: u32,
    pub block_s: f64,
}

impl ChainBlocks {
    /// Duration of the blocks, with the start of each group and the futex beside it.
    pub fn estimate(&self) -> Duration {
        let futex_s = f64::from(CHAIN_WAKES * self.period_us) / 1e6;
        Duration::from_secs_f64(f64::from(self.blocks) * (self.block_s + futex_s + 0.3))
    }
}

/// Wake-ups of the futex block beside each block of a chain.
pub const CHAIN_WAKES: u32 = 100;

/// The chains in blocks: at 1 ms; in a quick run on one core only.
pub fn chain_blocks(quick: bool, cores: usize, reference: Scheduling) -> Vec<ChainBlocks> {
    let placements = if quick { 1 } else { 2 };
    let (blocks, block_s) = if quick { (PAIRS, 0.2) } else { (2 * PAIRS, 1.0) };
    let period_us = WAKE_PERIOD_US;
    let blocks_of = move |conditions| ChainBlocks { conditions, period_us, blocks, block_s };
    quietest(cores, reference).take(placements).map(blocks_of).collect()
}

/// The cells of a run on `cores` cores. `quick` keeps only an idle machine under `reference`, the best
/// scheduling that the kernel grants.
pub fn cells(quick: bool, cores: usize, reference: Scheduling) -> Vec<Cell> {
    let mut cells = Vec::new();
    let all: Vec<_> = match quick {
        true => quietest(cores, reference).collect(),
        false => conditions(cores).collect(),
    };
    for conditions in all {
        let mut add = |measure, period_us| cells.push(Cell { measure, conditions, period_us });
        add(Measure::Sleep, WAKE_PERIOD_US);
        add(Measure::Wake(Mechanism::Eventfd), WAKE_PERIOD_US);
        add(Measure::Wake(Mechanism::Iceoryx2Event), WAKE_PERIOD_US);
        let sizes = if quick { &QUICK_PAYLOAD_BYTES[..] } else { &PAYLOAD_BYTES };
        for &bytes in sizes {
            add(Measure::Wake(Mechanism::bare(bytes)), WAKE_PERIOD_US);
            if !quick {
                let protected = Mechanism::Payload { bytes, is_protected: true };
                add(Measure::Wake(protected), WAKE_PERIOD_US);
            }
        }
        add(Measure::Wake(Mechanism::Futex), COLD_PERIOD_US);
        add(Measure::Wake(Mechanism::Futex), WAKE_PERIOD_US);
        add(Measure::Wake(Mechanism::Message), WAKE_PERIOD_US);
        for period_us in CONTROLLER_PERIODS_US {
            let telling = matches!(period_us, 1_000 | COLD_PERIOD_US | 100_000);
            if !quick || telling {
                add(Measure::Chain, period_us);
            }
        }
    }
    cells
}

/// An idle machine under `reference`.
fn quietest(cores: usize, reference: Scheduling) -> impl Iterator<Item = Conditions> {
    let is_quiet = move |of: &Conditions| of.load == Load::Idle && of.scheduling == reference;
    conditions(cores).filter(is_quiet)
}

/// All conditions, the quietest first.
fn conditions(cores: usize) -> impl Iterator<Item = Conditions> {
    let placements: &[_] = if cores > 1 {
        &[Placement::SameCore, Placement::TwoCores]
    } else {
        &[Placement::SameCore]
    };
    [Load::Idle, Load::Cpu, Load::Memory].into_iter().flat_map(move |load| {
        [Scheduling::Fifo, Scheduling::Other].into_iter().flat_map(move |scheduling| {
            let of = move |&placement| Conditions { placement, scheduling, load };
            placements.iter().map(of)
        })
    })
}

/// A bar over the estimated time.
pub fn progress_bar(whole: Duration, quiet: bool) -> ProgressBar {
    let bar = report::print::bar(millis(whole), "{msg:44} {wide_bar} {eta} to go", quiet);
    if !bar.is_hidden() {
        eprintln!("about {} s", whole.as_secs());
    }
    bar
}

/// Length in whole milliseconds, as the bar counts.
pub fn millis(duration: Duration) -> u64 {
    u64::try_from(duration.as_millis()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_full_matrix_has_every_cell_once() {
        let cells = cells(false, 2, Scheduling::Fifo);
        // Sleep, four ways of waking, the cold futex; payloads bare and protected; seven periods.
        assert_eq!(cells.len(), 2 * 2 * 3 * (1 + 4 + 1 + 2 * PAYLOAD_BYTES.len() + 7));
        for (k, cell) in cells.iter().enumerate() {
            assert!(!cells[..k].contains(cell), "{cell:?} twice");
        }
    }

    #[test]
    fn a_quick_run_is_a_part_of_the_full_one_and_ends_in_time() {
        let full = cells(false, 2, Scheduling::Fifo);
        for reference in [Scheduling::Fifo, Scheduling::Other] {
            let quick = cells(true, 2, reference);
            assert!(quick.iter().all(|cell| full.contains(cell)));
            let sum: Duration = quick.iter().map(|cell| cell.estimate(super::super::QUICK_S)).sum();
            let compared = comparisons(true, 2, reference);
            let compared = compared.into_iter().map(|(_, _, us)| comparison_estimate(true, us));
            let chains = chain_blocks(true, 2, reference);
            let chains = chains.iter().map(ChainBlocks::estimate);
            let sum = sum + compared.chain(chains).sum::<Duration>();
            assert!(sum < Duration::from_secs(58), "{sum:?}");
        }
    }

    #[test]
    fn a_single_core_has_no_placement_on_two() {
        let all = cells(false, 1, Scheduling::Fifo);
        assert!(all.iter().all(|cell| cell.conditions.placement == Placement::SameCore));
    }
}
