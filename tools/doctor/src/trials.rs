//! The effect of a change on the user's loop, measured by trying it: blocks with and without it take turns.
//!
//! The kernel takes back what belongs to the process. Files of the machine get their content back, also when a signal
//! ends the trials; after `kill -9` they keep the change. A change that cannot be tried is listed with the reason.

use super::machine::read;
use super::processor::list;
use super::wake_ups::{Loop, LoopFigures, figures, lateness};
use report::results::{Column, Table, count, micros, word};
use runtime::scheduling::{self, Policy, Request, usable_cores};
use runtime::statistics::Latencies;
use serde::Serialize;
use std::fs::{self, File};
use std::io::Write;
use std::path::PathBuf;
use supervise::{Error, is_signalled};

/// Blocks with a change, and as many without it.
const BLOCKS: u32 = 3;
/// Longest time of one trial, s.
const LONGEST_S: f64 = 10.0;
/// Time for real-time threads of a group in each second, µs: half of it, since the groups above need a part.
const BUDGET_US: &str = "500000";

/// A change of this process, or of the machine while it measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    IdleStatesOff,
    Governor,
    Interrupts,
    Budget,
    Deadline,
    OtherCore,
    Isolation,
    Kernel,
}

/// All changes, each with the way to make it last.
const CHANGES: [(Change, &str, &str); 8] = [
    (Change::IdleStatesOff, "idle states off", "hold /dev/cpu_dma_latency open at 0"),
    (Change::Governor, "frequency governor performance", "cpupower frequency-set -g performance"),
    (Change::Interrupts, "interrupts on other cores", "write /proc/irq/*/smp_affinity_list"),
    (Change::Budget, "real-time time of the control group", "write cpu.rt_runtime_us"),
    (Change::Deadline, "SCHED_DEADLINE", "in place of SCHED_FIFO, without a core of its own"),
    (Change::OtherCore, "another core", "pin the loop there: taskset, or `core`"),
    (Change::Isolation, "isolated core", "boot with isolcpus: see the finding"),
    (Change::Kernel, "PREEMPT_RT", "install a real-time kernel: see the finding"),
];

/// A change. The one that brings most is first, and those that could not be tried are last.
#[derive(Debug, Serialize)]
pub struct Trial {
    pub change: &'static str,
    /// Reason why it could not be tried; null if it was.
    pub not_tried: Option<String>,
    /// The way to make it last.
    pub how: &'static str,
    /// The loop without and with it; null if it was not tried.
    pub without: Option<LoopFigures>,
    pub with: Option<LoopFigures>,
}

/// What holds a change: an open file, or files that get their content back.
#[derive(Debug, Default)]
struct Held {
    _open: Option<File>,
    before: Vec<(PathBuf, String)>,
}

impl Drop for Held {
    fn drop(&mut self) {
        for (path, before) in &self.before {
            // It was written a moment ago.
            let _ = fs::write(path, before.trim());
        }
    }
}

impl Held {
    /// Writes `value` into those of these files that have another content which `is_meant`; `none` says that there is
    /// no such file.
    fn write(
        paths: impl IntoIterator<Item = PathBuf>,
        value: &str,
        is_meant: impl Fn(&str) -> bool,
        none: &str,
    ) -> Result<Self, String> {
        let (mut held, mut why) = (Self::default(), none.to_owned());
        for path in paths {
            let Some(before) = read(&path).filter(|before| is_meant(before.trim())) else {
                continue;
            };
            match fs::write(&path, value) {
                Ok(()) => held.before.push((path, before)),
                Err(error) => why = format!("{}: {error}", path.display()),
            }
        }
        if held.before.is_empty() { Err(why) } else { Ok(held) }
    }
}

impl Change {
    /// Makes the change for a loop on `core`.
    fn make(self, each: Loop, core: usize) -> Result<Held, String> {
        let others = usable_cores().into_iter().filter(|other| *other != core);
        let others: Vec<String> = others.map(|other| other.to_string()).collect();
        match self {
            Self::Interrupts | Self::OtherCore if others.is_empty() => {
                Err("there is no other core".to_owned())
            }
            Self::OtherCore => Ok(Held::default()),
            Self::IdleStatesOff => {
                let file = File::options().write(true).open("/dev/cpu_dma_latency");
                let held = file.and_then(|mut file| file.write_all(&[0; 4]).map(|()| file));
                let held = held.map(|file| Held { _open: Some(file), before: Vec::new() });
                held.map_err(|error| error.to_string())
            }
            Self::Governor => {
                let path = format!("/sys/devices/system/cpu/cpu{core}/cpufreq/scaling_governor");
                let none = "no frequency governor here, or it is that already";
                Held::write([path.into()], "performance", |now| now != "performance", none)
            }
            Self::Interrupts => {
                let numbers = fs::read_dir("/proc/irq").into_iter().flatten().flatten();
                let paths = numbers.map(|number| number.path().join("smp_affinity_list"));
                let comes_here = |now: &str| list(now).contains(&core);
                Held::write(
                    paths,
                    &others.join(","),
                    comes_here,
                    "no interrupt may come to the core",
                )
            }
            Self::Budget => {
                let groups = super::machine::limits().rt_runtime_us.into_iter();
                let paths = groups.map(|limit| PathBuf::from(limit.path));
                Held::write(paths, BUDGET_US, |now| now == "0", "no control group is without it")
            }
            Self::Deadline => {
                let period_ns = u64::from(each.period_us) * 1_000;
                let set = scheduling::set_deadline(period_ns / 10, period_ns);
                set.map(|()| Held::default()).map_err(|error| error.to_string())
            }
            Self::Isolation => Err("the kernel isolates cores when it boots".to_owned()),
            Self::Kernel => Err("it is another kernel".to_owned()),
        }
    }
}

/// Adds the lateness of one block of the loop of `s` seconds, as it is or under a change.
fn block(change: Option<Change>, each: Loop, s: f64, into: &mut Latencies) -> Result<(), String> {
    let cores = usable_cores();
    let place = usize::from(change == Some(Change::OtherCore));
    let core = cores.iter().rev().nth(place).or(cores.last()).copied().unwrap_or(0);
    let measure = || {
        // A group without real-time time gets it before the loop asks for its priority.
        let held = change.map(|change| change.make(each, core)).transpose()?;
        if change != Some(Change::Deadline) {
            let policy = Policy::Fifo(80);
            let _ = scheduling::apply(&Request { policy, core: Some(core), lock_memory: true });
        }
        *into = lateness(each.period_us, s, std::mem::take(into));
        drop(held);
        Ok(())
    };
    std::thread::scope(|scope| scope.spawn(measure).join().expect("measuring does not panic"))
}

/// Tries all changes on the user's loop, each for `seconds` at most.
///
/// # Errors
/// [`Error::Interrupted`] after a signal; nothing is changed any more then.
pub fn measure(each: Loop, seconds: f64) -> Result<Vec<Trial>, Error> {
    let block_s = seconds.min(LONGEST_S) / f64::from(2 * BLOCKS);
    let mut trials = Vec::new();
    for (change, name, how) in CHANGES {
        let (mut without, mut with) = (Latencies::default(), Latencies::default());
        let blocks = (0..BLOCKS).try_for_each(|_| {
            // A change that cannot be made costs no time.
            block(Some(change), each, block_s, &mut with)?;
            block(None, each, block_s, &mut without)
        });
        if is_signalled() {
            return Err(Error::Interrupted);
        }
        let figures = |()| (figures(each, &without), figures(each, &with));
        let (without, with) = blocks.as_ref().ok().copied().map(figures).unzip();
        trials.push(Trial { change: name, not_tried: blocks.err(), how, without, with });
    }
    let brings = |Trial { without, with, .. }: &Trial| {
        let (without, with) = without.as_ref().zip(with.as_ref())?;
        Some((without.late as f64 - with.late as f64, without.worst_us - with.worst_us))
    };
    trials.sort_by(|a, b| brings(b).partial_cmp(&brings(a)).expect("numbers"));
    Ok(trials)
}

pub fn table(trials: &[Trial]) -> Table {
    let columns: [Column<Trial>; 7] = [
        word("change", "tried", "Change, taken back in the end"),
        word("not_tried", "not tried", "Reason why it could not be tried"),
        count("without.late", "late without", "Late wake-ups without it"),
        count("with.late", "with", "Late wake-ups with it"),
        micros("without.worst_us", "worst without", "Largest lateness without it"),
        micros("with.worst_us", "with", "Largest lateness with it"),
        word("how", "how", "The way to make it last").weight(1),
    ];
    Table::new("What a change brings, measured in turns", &columns, trials).without_cases()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_change_is_measured_as_often_as_its_absence_or_has_a_reason() {
        let each = Loop { period_us: 1_000, budget_us: 100 };
        let trials = measure(each, 0.06).expect("no signal");
        assert_eq!(trials.len(), CHANGES.len());
        for Trial { not_tried, without, with, .. } in &trials {
            for figures in [without, with] {
                assert_eq!(figures.is_some(), not_tried.is_none(), "{trials:?}");
                assert!(figures.iter().all(|of| of.wakes == 30 && of.late <= 30), "{trials:?}");
            }
        }
        assert!(trials.is_sorted_by_key(|trial| trial.not_tried.is_some()), "{trials:?}");
        let fewer_late = |trial: &Trial| {
            Some(trial.without.as_ref()?.late as i64 - trial.with.as_ref()?.late as i64)
        };
        assert!(trials.iter().filter_map(fewer_late).is_sorted_by(|a, b| a >= b), "{trials:?}");
    }

    #[test]
    fn a_file_that_was_changed_gets_its_content_back() {
        let path = std::env::temp_dir().join(format!("timegap-doctor-{}", std::process::id()));
        fs::write(&path, "powersave\n").expect("writable");
        let write = || Held::write([path.clone()], "fast", |now| now != "fast", "there is none");
        let held = write().expect("ours");
        assert_eq!(fs::read_to_string(&path).expect("ours"), "fast");
        assert_eq!(write().expect_err("it is so already"), "there is none");
        drop(held);
        assert_eq!(fs::read_to_string(&path).expect("ours"), "powersave");
        fs::remove_file(&path).expect("ours");
    }
}
