//! A run whose launcher is killed. It is a command of its own, since the campaign itself launches its other runs.
//!
//! Three things must hold. The group ends with its launcher, nothing of the group is left, and its results show that
//! the run did not reach its end.

use super::record::{Measured, Planned, Record};
use frame::batch::{Scratch, leftovers};
use runtime::{Group, Mode};
use scenario::Scenario;
use scenario::faults::{Helper, Kind, Target};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use supervise::report::Outcome;
use supervise::{Error, MachineError, this_program};
use toml::{Table, Value};

/// Time within which the whole group must be gone.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two checks.
const CHECK: Duration = Duration::from_millis(5);

/// True if a fault that is drawn from the table may kill the launcher.
pub fn may_be(template: &Table) -> bool {
    template.get("kind").and_then(Value::as_str) == Some(Kind::KillHelper.name())
}

/// True if the launcher is killed in a run of this scenario.
pub fn is_planned(scenario: &Scenario) -> bool {
    let launcher = Target::Helper(Helper::Launcher);
    scenario.faults.iter().any(|fault| fault.effect.target() == launcher)
}

/// Does the run and waits until nothing of it is left.
pub fn run(
    planned: &Planned,
    scenario: &Scenario,
    mode: Mode,
    going_on: &dyn Fn() -> bool,
) -> Result<Record, Error> {
    let scratch = Scratch::new().map_err(MachineError::cannot("make a directory"))?;
    let (file, out) = (scratch.path().join("run.toml"), scratch.path().join("out"));
    std::fs::write(&file, scenario.to_toml()).map_err(MachineError::cannot("write a scenario"))?;
    let mut command = this_program(&["run", "--no-record", "--mode", mode.name()])?;
    command.arg(&file).arg("--out").arg(&out);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut launcher = command.spawn().map_err(MachineError::cannot("start a run"))?;
    let status = wait(&mut launcher, going_on)?;
    let aborted = Record::aborted(planned, scenario);
    if status.signal().is_none() {
        // The drive ended before the fault.
        let outcome = if status.success() { Outcome::Completed } else { Outcome::Aborted };
        return Ok(Record { outcome, ..aborted });
    }
    let died = Instant::now();
    let left = leftovers_after(&out, died);
    let ends_twice = out.join("summary.json").exists();
    let why = match ends_twice {
        true => "the launcher was killed, and the results say that the run has ended".into(),
        false => format!(
            "the launcher was killed; its group was gone after {} ms",
            died.elapsed().as_millis()
        ),
    };
    let measured = Measured {
        kills: 1,
        helper_kills: 1,
        launcher_died: !ends_twice,
        faults: 1,
        leaks: left,
        ..Measured::default()
    };
    Ok(Record { aborted_because: Some(why), measured, ..aborted })
}

fn wait(launcher: &mut Child, going_on: &dyn Fn() -> bool) -> Result<ExitStatus, Error> {
    loop {
        match launcher.try_wait() {
            Ok(Some(status)) => return Ok(status),
            Ok(None) if !going_on() => {
                // Its group goes with it.
                let _ = launcher.kill();
                let _ = launcher.wait();
                return Err(Error::Interrupted);
            }
            Ok(None) => std::thread::sleep(CHECK),
            Err(e) => return Err(MachineError::cannot("wait for a run")(e).into()),
        }
    }
}

/// Leftovers of the run with these results, at most [`PATIENCE`] after its launcher's death.
fn leftovers_after(out: &Path, died: Instant) -> Vec<String> {
    // A killed launcher leaves its description of the run.
    let text = std::fs::read_to_string(out.join("live.json")).unwrap_or_default();
    let Ok(group) = serde_json::from_str::<Group>(&text) else {
        return vec!["its results do not name the run".into()];
    };
    loop {
        let left = leftovers(&group.root);
        if left.is_empty() || died.elapsed() > PATIENCE {
            return left;
        }
        std::thread::sleep(CHECK);
    }
}
