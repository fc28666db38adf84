//! A run whose launcher is killed. It is a command of its own, since the launcher of a campaign's other runs is
//! the campaign itself; and it has a verdict of its own: the group ends with its launcher, nothing of it is
//! left, and no result says that the run came to its end.

use super::planned::Planned;
use super::record::Record;
use frame::batch::{Interrupt, PrepareError, Scratch, leftovers};
use group::report::Outcome;
use group::{Error, this_program};
use runtime::{Group, Mode};
use scenario::Scenario;
use scenario::faults::{Helper, Kind, Target};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use toml::{Table, Value};

/// Time within which all that is the run's must be gone.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(5);

/// True if a fault that is drawn so may kill the launcher.
pub fn may_be(template: &Table) -> bool {
    template.get("kind").and_then(Value::as_str) == Some(Kind::KillHelper.name())
}

/// True if the launcher is killed in a run of this scenario.
pub fn is_planned(scenario: &Scenario) -> bool {
    let launcher = Target::Helper(Helper::Launcher);
    scenario.faults.iter().any(|fault| fault.effect.target() == launcher)
}

/// Does the run and waits until nothing of it is left.
///
/// # Errors
/// [`Error::Interrupted`], or what keeps the command from starting.
pub fn run(
    planned: &Planned,
    scenario: &Scenario,
    mode: Mode,
    interrupt: &Interrupt,
) -> Result<Record, Error> {
    let scratch = Scratch::new().map_err(PrepareError::of("make a directory"))?;
    let (file, out) = (scratch.path().join("run.toml"), scratch.path().join("out"));
    std::fs::write(&file, scenario.to_toml()).map_err(PrepareError::of("write a scenario"))?;
    let mut command = this_program(&["run", "--no-record", "--mode", mode.name()])?;
    command.arg(&file).arg("--out").arg(&out);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut launcher = command.spawn().map_err(PrepareError::of("start a run"))?;
    let status = wait(&mut launcher, interrupt)?;
    let blank = Record::blank(planned, scenario);
    if status.signal().is_none() {
        // The fault did not come: the drive was over before.
        let outcome = if status.success() { Outcome::Completed } else { Outcome::Aborted };
        return Ok(Record { outcome, ..blank });
    }
    let died = Instant::now();
    let left = leftovers_after(&out, died);
    let ends_twice = out.join("summary.json").exists();
    Ok(Record {
        outcome: Outcome::Aborted,
        aborted_because: Some(match ends_twice {
            true => "the launcher was killed, and the results say that the run has ended".into(),
            false => format!(
                "the launcher was killed; its group was gone after {} ms",
                died.elapsed().as_millis()
            ),
        }),
        kills: 1,
        helper_kills: 1,
        launcher_died: !ends_twice,
        faults: 1,
        leaks: left,
        ..blank
    })
}

fn wait(launcher: &mut Child, interrupt: &Interrupt) -> Result<ExitStatus, Error> {
    loop {
        match launcher.try_wait() {
            Ok(Some(status)) => return Ok(status),
            Ok(None) if interrupt.came() => {
                // Its group goes with it.
                let _ = launcher.kill();
                let _ = launcher.wait();
                return Err(Error::Interrupted);
            }
            Ok(None) => std::thread::sleep(LOOK),
            Err(e) => return Err(PrepareError::of("wait for a run")(e).into()),
        }
    }
}

/// What is still there of the run with these results [`PATIENCE`] after its launcher's death.
fn leftovers_after(out: &Path, died: Instant) -> Vec<String> {
    // A launcher that was killed could not remove the file that tells of its run.
    let text = std::fs::read_to_string(out.join("live.json")).unwrap_or_default();
    let Ok(group) = serde_json::from_str::<Group>(&text) else {
        return vec!["its results do not tell which run it was".into()];
    };
    loop {
        let left = leftovers(&group.root);
        if left.is_empty() || died.elapsed() > PATIENCE {
            return left;
        }
        std::thread::sleep(LOOK);
    }
}
