//! The effect of a change on the user's loop, measured by trying it: blocks with and without it take turns.
//!
//! A change that this process may not make is left out: its finding has the command. So is one that would outlive a
//! killed process, such as a frequency governor. The kernel takes back the others with the process.

use super::wake_ups::{Loop, lateness};
use report::results::{Column, Table, count, micros, word};
use runtime::scheduling::{self, Policy, Request, usable_cores};
use runtime::statistics::Latencies;
use serde::Serialize;
use std::fs::File;
use std::io::Write;

/// Blocks with a change, and as many without it.
const BLOCKS: u32 = 3;
/// Longest time of one trial, s.
const LONGEST_S: f64 = 10.0;

/// A change of this process, or of the machine while it measures.
#[derive(Clone, Copy, Debug)]
enum Change {
    Nothing,
    IdleStatesOff,
    Deadline,
    Core(usize),
}

/// A change that was tried. The one that brings most is first.
#[derive(Debug, Serialize)]
pub struct Trial {
    pub change: String,
    /// The way to make it last.
    pub how: String,
    /// Wake-ups of each side, and those that were late without and with it.
    pub wakes: u64,
    pub late_without: u64,
    pub late_with: u64,
    /// Largest lateness, µs.
    pub worst_without_us: f64,
    pub worst_with_us: f64,
}

impl Change {
    /// Makes the change; what it holds open while it acts. `None` if it cannot be made.
    fn make(self, each: Loop) -> Option<Option<File>> {
        match self {
            Self::Nothing | Self::Core(_) => Some(None),
            Self::IdleStatesOff => {
                let mut file = File::options().write(true).open("/dev/cpu_dma_latency").ok()?;
                file.write_all(&[0; 4]).ok()?;
                Some(Some(file))
            }
            Self::Deadline => {
                let period_ns = u64::from(each.period_us) * 1_000;
                scheduling::set_deadline(period_ns / 10, period_ns).ok().map(|()| None)
            }
        }
    }

    fn words(self) -> (String, &'static str) {
        match self {
            Self::Nothing => Default::default(),
            Self::IdleStatesOff => {
                ("idle states off".into(), "hold /dev/cpu_dma_latency open at 0")
            }
            Self::Deadline => {
                ("SCHED_DEADLINE".into(), "in place of SCHED_FIFO, without a core of its own")
            }
            Self::Core(core) => (format!("core {core}"), "pin the loop there: taskset, or `core`"),
        }
    }
}

/// Lateness of one block of the loop under a change; `None` if it cannot be made.
fn block(change: Change, each: Loop, seconds: f64) -> Option<Latencies> {
    let last = usable_cores().last().copied().unwrap_or(0);
    let core = if let Change::Core(core) = change { core } else { last };
    let measuring = std::thread::spawn(move || {
        let is_deadline = matches!(change, Change::Deadline);
        let policy = if is_deadline { Policy::Other } else { Policy::Fifo(80) };
        let core_of = (!is_deadline).then_some(core);
        let _ = scheduling::apply(&Request { policy, core: core_of, lock_memory: true });
        let held = change.make(each)?;
        let latencies = lateness(each.period_us, seconds);
        drop(held);
        Some(latencies)
    });
    measuring.join().expect("measuring does not panic")
}

/// Tries all changes on the user's loop, each for `seconds` at most.
pub fn measure(each: Loop, seconds: f64) -> Vec<Trial> {
    let block_s = seconds.min(LONGEST_S) / f64::from(2 * BLOCKS);
    let cores = usable_cores();
    let others = cores.iter().rev().skip(1).take(1).map(|core| Change::Core(*core));
    let changes = [Change::IdleStatesOff, Change::Deadline];
    let trial = |change: Change| {
        let (mut without, mut with) = (Vec::new(), Vec::new());
        for _ in 0..BLOCKS {
            without.push(block(Change::Nothing, each, block_s)?);
            with.push(block(change, each, block_s)?);
        }
        let budget_ns = u64::from(each.budget_us) * 1_000;
        let late = |all: &[Latencies]| all.iter().map(|one| one.count_above_ns(budget_ns)).sum();
        let worst_us = |all: &[Latencies]| {
            let worst = all.iter().filter_map(Latencies::percentiles_us).map(|us| us.max);
            worst.fold(0.0, f64::max)
        };
        let (words, how) = change.words();
        Some(Trial {
            change: words,
            how: how.to_owned(),
            wakes: with.iter().map(Latencies::count).sum(),
            late_without: late(&without),
            late_with: late(&with),
            worst_without_us: worst_us(&without),
            worst_with_us: worst_us(&with),
        })
    };
    let mut trials: Vec<Trial> = changes.into_iter().chain(others).filter_map(trial).collect();
    let brings = |trial: &Trial| {
        let late = trial.late_without as f64 - trial.late_with as f64;
        (late, trial.worst_without_us - trial.worst_with_us)
    };
    trials.sort_by(|a, b| brings(b).partial_cmp(&brings(a)).expect("numbers"));
    trials
}

pub fn table(trials: &[Trial]) -> Table {
    let columns: [Column<Trial>; 6] = [
        word("change", "tried", "Change, taken back in the end"),
        count("late_without", "late without", "Late wake-ups without it"),
        count("late_with", "with", "Late wake-ups with it"),
        micros("worst_without_us", "worst without", "Largest lateness without it"),
        micros("worst_with_us", "with", "Largest lateness with it"),
        word("how", "how", "The way to make it last").weight(1),
    ];
    Table::new("What a change brings, measured in turns", &columns, trials).without_cases()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_change_that_can_be_made_is_measured_as_often_as_its_absence() {
        let trials = measure(Loop { period_us: 1_000, budget_us: 100 }, 0.06);
        assert!(trials.iter().all(|trial| trial.wakes == 30), "{trials:?}");
        assert!(trials.iter().all(|trial| trial.late_with <= trial.wakes), "{trials:?}");
        let late = |trial: &Trial| trial.late_without as i64 - trial.late_with as i64;
        assert!(trials.is_sorted_by(|a, b| late(a) >= late(b)), "{trials:?}");
    }
}
