//! The group's processes.

use crate::events::{Event, Who, follow};
use crate::role::Role;
use crate::root::RunRoot;
use crate::root::dead_runs::remove_unfinished;
use crate::{Error, MachineError};
use controller::laws;
use messages::Service;
use runtime::scheduling::set_fifo_of;
use runtime::{Mode, NAME_PREFIX, PEER_JOINED, PREPARED, PREPARED_PREFIX, ToService, inherit_only};
use rustix::process::{Pid, Signal, kill_process};
use scenario::Scenario;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

/// Order of a launcher that has already cleaned up, in place of a process group.
pub const DONE: i32 = 0;

/// A process that this one started, with the lines that it gets.
#[derive(Debug)]
pub struct Process {
    child: Child,
    group: i32,
    orders: Option<ChildStdin>,
    status: Option<ExitStatus>,
    /// The threads that wait for its end.
    followers: Arc<[AtomicI32; 2]>,
}

impl Process {
    /// A child in process group `group`, or in its own for 0.
    pub fn of(mut child: Child, group: i32) -> Self {
        let orders = child.stdin.take();
        let group = if group == 0 { pid(&child) } else { group };
        Self { child, group, orders, status: None, followers: Arc::default() }
    }

    /// Starts a process of a member, as this program again or as `program`. Its process group is `group`, or a new one
    /// for 0. Its name differs from the member's while it `waits` to be let in.
    pub fn spawn<R: Role>(
        who: Who<R>,
        program: Option<&PathBuf>,
        root: &RunRoot,
        group: i32,
        events: Sender<Event<R>>,
        waits: bool,
    ) -> Result<Self, Error> {
        let Who { role, incarnation } = who;
        let mut command = match program {
            Some(program) => Command::new(program),
            None => {
                let mut command = this_program(&["service"])?;
                command.args(role.words());
                command
            }
        };
        let prefix = if waits { PREPARED_PREFIX } else { NAME_PREFIX };
        command
            .arg0(format!("{prefix}{role}"))
            .arg(root.path())
            .arg(incarnation.to_string())
            .args(waits.then_some(PREPARED))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(group);
        inherit_only(&mut command, Some(root.lock()));
        let mut child = command.spawn().map_err(|e| match program {
            Some(program) => Error::path("start", program)(e),
            None => MachineError::cannot(format_args!("start {role}"))(e).into(),
        })?;
        if !waits {
            role.enroll(root.prefix(), incarnation, child.id())?;
        }
        let out = child.stdout.take().expect("piped");
        let err = child.stderr.take().expect("piped");
        let (prefix, id) = (root.prefix().to_owned(), child.id());
        let on_end = move || remove_unfinished(&prefix, id);
        let followers = follow(who, on_end, out, err, events)
            .map_err(MachineError::cannot("start a thread"))?;
        Ok(Self { followers, ..Self::of(child, group) })
    }

    /// Lets a process that waits for it into the run at `root`.
    pub fn let_in<R: Role>(&mut self, who: Who<R>, root: &RunRoot) -> Result<(), Error> {
        who.role.enroll(root.prefix(), who.incarnation, self.child.id())?;
        self.order(&ToService::Join);
        Ok(())
    }

    /// Gives the threads that wait for its end this priority: on a busy machine ordinary ones notice it late.
    pub fn raise_followers(&self, priority: u8) {
        let threads = self.followers.iter().map(|thread| thread.load(Ordering::Acquire));
        threads.filter(|thread| *thread > 0).for_each(|thread| set_fifo_of(thread, priority));
    }

    /// Process id.
    pub fn pid(&self) -> i32 {
        pid(&self.child)
    }

    pub fn group(&self) -> i32 {
        self.group
    }

    pub fn kill(&mut self) {
        self.signal(Signal::KILL);
    }

    /// Makes it look for a peer that has joined the group.
    pub fn tell_of_peer(&mut self) {
        const _: () = assert!(PEER_JOINED == Signal::URG.as_raw());
        self.signal(Signal::URG);
    }

    pub fn signal(&mut self, signal: Signal) {
        // Not waited for yet: the id cannot be another's.
        if self.poll().is_none()
            && let Some(pid) = Pid::from_raw(self.pid())
        {
            // It may be gone by now.
            let _ = kill_process(pid, signal);
        }
    }

    /// Sends it a message. The process may be gone.
    pub fn order(&mut self, order: &impl Serialize) {
        if let Some(orders) = &mut self.orders {
            let line = serde_json::to_string(order).expect("orders are plain data");
            if writeln!(orders, "{line}").is_err() {
                self.orders = None;
            }
        }
    }

    /// Waits until the process is gone; kills it after `grace`. Its status, and whether it was killed
    /// here.
    pub fn end(&mut self, grace: Duration) -> (ExitStatus, bool) {
        // The end of its input ends it.
        self.orders = None;
        let begun = Instant::now();
        let mut killed = false;
        loop {
            if let Some(status) = self.poll() {
                return (status, killed);
            }
            if begun.elapsed() > grace {
                // Ours and not yet waited for: the id cannot be another's.
                killed |= self.child.kill().is_ok();
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// The exit status if the process is gone.
    pub fn poll(&mut self) -> Option<ExitStatus> {
        if self.status.is_none() {
            self.status = self.child.try_wait().ok().flatten();
        }
        self.status
    }
}

fn pid(child: &Child) -> i32 {
    i32::try_from(child.id()).expect("process ids are positive and fit")
}

/// Time that a janitor with nothing left to do gets to end; a stopped one never would.
const DISMISSAL: Duration = Duration::from_secs(1);

#[derive(Debug)]
pub struct Janitor(pub(crate) Process);

impl Janitor {
    /// Starts the janitor of the run at `root`, outside the services' process group.
    pub fn spawn(root: &RunRoot) -> Result<Self, MachineError> {
        let mut command = this_program(&["service", "janitor"])?;
        command
            .arg0("timegap-janitor")
            .arg(root.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0);
        // Not even another run's descriptors, which threads beside this one have open.
        inherit_only(&mut command, None);
        let child = command.spawn().map_err(MachineError::cannot("start the janitor"))?;
        Ok(Self(Process::of(child, 0)))
    }

    /// Sends it the process group of the services.
    pub fn watch(&mut self, group: i32) {
        self.0.order(&group);
    }

    /// Ends it: the launcher has cleaned up.
    pub fn dismiss(mut self) {
        self.0.order(&DONE);
        self.0.end(DISMISSAL);
    }
}

/// This program again, with other arguments.
pub fn this_program(arguments: &[&str]) -> Result<Command, MachineError> {
    let error = MachineError::cannot("find this program's own file");
    let program = std::env::current_exe().map_err(error)?;
    // A new build may have replaced the file meanwhile.
    let program = if program.exists() { program } else { PathBuf::from("/proc/self/exe") };
    let mut command = Command::new(program);
    command.args(arguments);
    Ok(command)
}

#[derive(Debug)]
pub struct Launch {
    pub mode: Mode,
    pub scenario: Scenario,
    /// Programs that take the place of built-in services.
    pub programs: BTreeMap<Service, PathBuf>,
    /// Time until all services must be ready.
    pub ready_timeout: Duration,
    /// Time between readiness and the common start instant.
    pub start_delay: Duration,
    /// File that describes to others how to join the group; present while it drives.
    pub live_file: Option<PathBuf>,
    /// File of the run's recording.
    pub recording: Option<PathBuf>,
    /// Address of the run's bridge to viewers.
    pub bridge: Option<OsString>,
}

/// The scenario as the services read it. It has the gap at which the law aims. So the referee can measure against it
/// without any law. The aim of a program in the controller's place is known only from the scenario.
pub(crate) fn for_services(scenario: &Scenario, is_replaced: bool) -> Scenario {
    let mut scenario = scenario.clone();
    if !is_replaced {
        scenario.referee.desired_gap = laws::desired_gap(&scenario);
    }
    scenario
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_janitor_that_does_not_answer_keeps_no_run_from_its_end() {
        let mut command = Command::new("sleep");
        let child = command.arg("1000").stdin(Stdio::piped()).spawn().expect("a process");
        let pid = child.id();
        Janitor(Process::of(child, 0)).dismiss();
        assert!(!std::path::Path::new(&format!("/proc/{pid}")).exists(), "it is gone");
    }
}
