//! A service without the processor is awaited and reported: a new process would wait as well.
//!
//! The controller gets the lowest policy of all, on a core with an endless loop of the highest ordinary
//! priority. Raising a priority needs a privilege.

use rustix::process::{Pid, setpriority_process};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use serde_json::Value;
use std::process::{Child, Command, ExitCode};
use std::time::Duration;
use system_tests::cases::{self, Needed, needing};
use system_tests::missing::Missing;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
/// The priority of the endless loop.
const NICE: i32 = -20;
/// Time without the processor for the controller: three times the limit for a silent service.
const STARVED: Duration = Duration::from_millis(1_050);

fn privileges() -> Needed {
    cases::program("chrt")?;
    let mut hog = Hog::start().map_err(|error| Missing(format!("no endless loop: {error}")))?;
    hog.raise().map_err(|error| Missing(format!("no process may have nice {NICE}: {error}")))
}

/// An endless loop that ends with its owner.
struct Hog(Child);

impl Hog {
    fn start() -> std::io::Result<Self> {
        Command::new("sh").args(["-c", "while :; do :; done"]).spawn().map(Self)
    }

    fn raise(&mut self) -> std::io::Result<()> {
        Ok(setpriority_process(Some(Pid::from_child(&self.0)), NICE)?)
    }
}

impl Drop for Hog {
    fn drop(&mut self) {
        let _ = (self.0.kill(), self.0.wait());
    }
}

/// Limits a process to one core.
fn pin(process: Pid, core: usize) {
    let mut only = CpuSet::new();
    only.set(core);
    sched_setaffinity(Some(process), &only).expect("a core that it has");
}

fn a_starved_controller_is_not_replaced_and_it_is_said() {
    // The kernel does not always withhold the processor as required; then the run proves nothing.
    assert!((0..5).any(|_| is_starved_and_said()), "no controller was seen to starve");
}

/// False if the controller got the processor nevertheless. It must not be replaced in either case.
fn is_starved_and_said() -> bool {
    let corner = Corner::new(PROGRAM);
    let arguments = [
        "run",
        "following",
        "--duration",
        "4",
        "--out",
        "out",
        "--no-record",
        "--set",
        "runtime.scheduling=\"other\"",
        // One process has the controller's name.
        "--set",
        "supervision.prepared=false",
    ];
    let running = corner.start(&arguments);
    assert!(wait_for(|| corner.path().join("out/live.json").exists()), "never drove");
    let controller = corner.wait_for_process("timegap-controller");
    let process = Pid::from_raw(controller).expect("a process id");
    let allowed = sched_getaffinity(Some(process)).expect("it lives");
    let core = (0..CpuSet::MAX_CPU).find(|&core| allowed.is_set(core)).expect("it has a core");
    let mut hog = Hog::start().expect("a shell");
    pin(Pid::from_child(&hog.0), core);
    hog.raise().expect("it was allowed before");
    pin(process, core);
    let lowest = ["--idle", "--pid", "0", &controller.to_string()];
    let status = Command::new("chrt").args(lowest).status().expect("it is there");
    assert!(status.success(), "chrt");
    std::thread::sleep(STARVED);
    drop(hog);

    let output = running.wait_with_output().expect("our own child");
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    let summary = std::fs::read(corner.path().join("out/summary.json")).expect("it is kept");
    let summary: Value = serde_json::from_slice(&summary).expect("JSON");
    let services = summary["services"].as_array().expect("a list");
    let controller = services.iter().find(|service| service["name"] == "controller");
    let controller = controller.expect("it is listed");
    assert_eq!(controller["restarts"], 0, "{controller}");
    let starved_ms = controller["heartbeats"]["starved_ms"].as_f64().expect("a number");
    assert_eq!(summary["faults"].as_array().map(Vec::len), Some(0), "{said}");
    if starved_ms < 350.0 {
        return false;
    }
    assert!(said.contains("starved, ms"), "{said}");
    true
}

fn main() -> ExitCode {
    cases::run(&[needing(
        privileges,
        "a_starved_controller_is_not_replaced_and_it_is_said",
        a_starved_controller_is_not_replaced_and_it_is_said,
    )])
}
