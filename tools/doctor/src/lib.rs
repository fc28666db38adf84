//! `timegap doctor`: the state of this machine, the cost of each flaw, and the command that corrects it.
//!
//! ```text
//! /proc, /sys, a probe thread ─ machine ─► contents ─ checks ─► Finding ─► console, JSON, exit status
//! ```
//!
//! `machine` reads; the other modules judge: plain functions from the contents of files to a [`Finding`].
//! [`wake_ups`] measures which loops hold now. Status 0 without a bad finding, 1 with one, 3 if nothing can run.
//!
//! ```
//! use doctor::finding::{Finding, table};
//!
//! let finding = Finding::warn("clock source", "hpet", "every stamp is a system call", None);
//! assert!(table(&[finding]).console(80).contains("clock source"));
//! ```

mod cgroup;
pub mod finding;
mod machine;
mod processor;
mod scheduling;
mod storage;
mod trials;
pub mod wake_ups;

use clap::Args;
use finding::{Finding, Verdict};
use report::print;
use report::results::Document;
use report::summary::Host;
use runtime::scheduling::usable_cores;
use runtime::{Timetable, shared_memory_bytes};
use scenario::{Scenario, builtin};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use supervise::{Error, number_within};
use wake_ups::{LoopOptions, WakeUps};

/// Memory of a run's processes without its shared memory, bytes: five of up to 12 MiB.
const PROCESSES_BYTES: u64 = 64 << 20;

/// Time for which each loop is measured, s.
const MEASURE_S: f64 = 2.0;

#[derive(Debug, Args)]
pub struct DoctorArguments {
    /// A loop of the user's own.
    #[command(flatten)]
    pub own: LoopOptions,
    /// Time for which wake-ups of each loop are measured, s: rare delays need minutes
    #[arg(long = "for", value_name = "S", default_value_t = MEASURE_S, value_parser = number_within(0.1..=86_400.0, "a number of seconds"))]
    pub seconds: f64,
    /// Print the findings as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    schema_version: u32,
    /// No finding is worse than "ok".
    ok: bool,
    /// True if runs can start.
    can_run: bool,
    host: Host,
    findings: Vec<Finding>,
    wake_ups: WakeUps,
    /// Changes for the user's own loop, tried where the machine grants them.
    trials: Vec<trials::Trial>,
}

pub fn run(arguments: &DoctorArguments) -> Result<ExitCode, Error> {
    let host = Host::this();
    let (findings, wake_ups) = examine(&host, arguments);
    let can_run = findings.iter().all(|finding| !finding.prevents_runs);
    let ok = findings.iter().all(|finding| finding.verdict == Verdict::Ok);
    let own = arguments.own.loops();
    let trials = match own.as_slice() {
        [each] => {
            // A signal ends the trials after they have taken their changes back.
            supervise::hold_signals()?;
            trials::measure(*each, arguments.seconds)?
        }
        _ => Vec::new(),
    };
    let report = Report { schema_version: 1, ok, can_run, host, findings, wake_ups, trials };
    print::show(arguments.json, &document(&report))?;
    Ok(ExitCode::from(status(&report)))
}

fn document(report: &Report) -> Document {
    let is_good = report.findings.iter().all(|finding| finding.verdict != Verdict::Bad);
    Document::new("doctor", "Doctor", report)
        .text(report.wake_ups.answer())
        .table(report.wake_ups.histogram_table())
        .table(trials::table(&report.trials))
        .table(finding::table(&report.findings))
        .verdict(is_good, conclusion(report))
}

/// The exit status: 3 if nothing can run, 1 with a bad finding.
fn status(report: &Report) -> u8 {
    let bad = report.findings.iter().any(|finding| finding.verdict == Verdict::Bad);
    if report.can_run { u8::from(bad) } else { 3 }
}

fn examine(host: &Host, arguments: &DoctorArguments) -> (Vec<Finding>, WakeUps) {
    let default = builtin::ALL.first().expect("there are built-in scenarios");
    let scenario = Scenario::parse(default.name, default.text).expect("built-in ones are right");
    let needed = shared_memory_bytes(&Timetable::of(&scenario), &[]);
    let granted = machine::granted();
    let limits = machine::limits();
    let cores = usable_cores();
    let root = rustix::process::geteuid().is_root();
    let sys = |name: &str| machine::read(format!("/sys/devices/system/{name}"));
    let proc = |name: &str| machine::read(format!("/proc/{name}"));
    let online = sys("cpu/online").unwrap_or_default();
    let before = proc("stat").unwrap_or_default();
    let (wake_ups, _) = wake_ups::measure(&arguments.own.loops(), arguments.seconds);
    let after = proc("stat").unwrap_or_default();
    let memory = storage::available_memory(&proc("meminfo").unwrap_or_default());
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let room = supervise::shared_memory_room().map(|(size, free)| storage::Room { size, free });
    let program = std::env::current_exe().unwrap_or_else(|_| "timegap".into());
    let clock = |name: &str| sys(&format!("clocksource/clocksource0/{name}_clocksource"));
    let mut findings = vec![
        storage::shared_memory(room, needed, memory),
        storage::run_directory(machine::base().as_deref(), runtime.as_deref()),
        storage::leftovers(&supervise::dead_runs()),
        processor::affinity(&cores, &online),
        scheduling::policy(&granted, root, &program),
        scheduling::throttling(
            proc("sys/kernel/sched_rt_runtime_us").as_deref(),
            proc("sys/kernel/sched_rt_period_us").as_deref(),
        ),
        cgroup::real_time_time(&limits),
        cgroup::processor_time(&limits, cores.len()),
        scheduling::locked_memory(&granted, &proc("self/limits").unwrap_or_default(), &program),
        cgroup::memory(&limits, needed + PROCESSES_BYTES),
        scheduling::timer_slack(&granted),
        processor::kernel(&host.kernel, host.realtime_kernel),
        processor::isolation(&cores, sys("cpu/isolated").as_deref()),
        processor::governor(&machine::governors(&cores)),
        processor::idle_states(&machine::idle_states(cores.last().copied().unwrap_or(0))),
        processor::clock_source(clock("current").as_deref(), clock("available").as_deref()),
        processor::steal(&before, &after),
    ];
    findings.insert(0, wake_ups.finding());
    (findings, wake_ups)
}

/// The findings in one line.
fn conclusion(report: &Report) -> String {
    let count = |verdict| report.findings.iter().filter(|f| f.verdict == verdict).count();
    let [ok, warn, bad] = [Verdict::Ok, Verdict::Warn, Verdict::Bad].map(count);
    let runs = if !report.can_run {
        "nothing can run here"
    } else if bad > 0 {
        "runs work, but do not trust realtime figures"
    } else {
        "runs work; `timegap bench` measures their overhead"
    };
    format!("{ok} ok, {warn} improvable, {bad} bad: {runs}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_conclusion_names_the_worst() {
        let host = Host { cpus: 2, kernel: "6".into(), realtime_kernel: false };
        let bad = Finding::bad("x", "refused", "much", None);
        let fatal = Finding::fatal("y", "gone", "put it back");
        let (seconds, granted) = (0.0, String::new());
        let wake_ups = WakeUps { seconds, granted, loops: Vec::new(), histogram: Vec::new() };
        let findings = vec![bad];
        let mut report = Report {
            schema_version: 1,
            ok: false,
            can_run: true,
            host,
            findings,
            wake_ups,
            trials: Vec::new(),
        };
        assert!(conclusion(&report).contains("do not trust"));
        assert_eq!(status(&report), 1);
        report.findings.push(fatal);
        report.can_run = false;
        assert!(conclusion(&report).contains("nothing can run"));
        assert_eq!(status(&report), 3);
        let table = document(&report).console(100);
        assert!(table.contains("BAD") && table.contains("fix: put it back"), "{table}");
        let good = Report { can_run: true, findings: Vec::new(), ..report };
        assert_eq!(status(&good), 0);
    }
}
