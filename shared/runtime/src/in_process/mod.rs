//! All services of a lockstep run in one thread: each is a task that goes on until it waits.
//!
//! The services' code, ports, checks and reports are those of a group of processes. Two things
//! differ: memory carries the messages, and a wait is another service's turn.

pub mod coroutine;

use self::coroutine::{Pause, Task, Turn};
use crate::life::link::{Desk, End, Link};
use crate::transport::{Bus, Sealing, Seat};
use crate::{FromService, Group, Guest, Mode, Runtime, RuntimeError, StartOrder, Timetable};
use messages::Service;
use scenario::Scenario;
use std::path::PathBuf;
use std::rc::Rc;

/// The code of a service from its start to its end.
pub type Entry = fn(Runtime) -> Result<(), RuntimeError>;

/// Wall time after which a wait for a due sample gives up, ns. Messages in memory come at once or not at all, which is
/// noticed. This bounds a service that computes for ever.
const PATIENCE_NS: i64 = 60_000_000_000;

/// A run in one thread.
///
/// ```text
/// new ── observer ── start each service ──► take_turns ─► all ready ─► begin ─► take_turns … ─► idle
/// ```
///
/// Two services, one that sends and one that reads, with the same ports as in a group of processes:
///
/// ```
/// use messages::{Header, Odometry, Origins, Service, ServiceState};
/// use runtime::{Cycle, InProcess, Overrun, Runtime, RuntimeError, Sealing};
/// use scenario::Scenario;
///
/// fn plant(mut runtime: Runtime) -> Result<(), RuntimeError> {
///     let mut odometry = runtime.publisher::<Odometry>()?;
///     runtime.begin(&runtime.scenario())?;
///     runtime.run_cycles(|runtime| {
///         let Some(release) = runtime.next_release(Overrun::Skip)? else { return Ok(Cycle::Last) };
///         odometry.send_with(|message| {
///             message.header = Header::new(release.step, release.scheduled_ns, Origins::NONE);
///             message.speed_mps = 20.0;
///         })?;
///         runtime.end_cycle(ServiceState::Running)?;
///         Ok(Cycle::Next)
///     })?;
///     runtime.finish(())
/// }
///
/// fn controller(mut runtime: Runtime) -> Result<(), RuntimeError> {
///     let mut odometry = runtime.subscriber::<Odometry>()?;
///     runtime.begin(&runtime.scenario())?;
///     runtime.run_cycles(|runtime| {
///         let Some(_) = runtime.next_release(Overrun::Skip)? else { return Ok(Cycle::Last) };
///         // In lockstep this waits for the sample that is due.
///         runtime.update(&mut odometry)?;
///         assert_eq!(odometry.newest().map(|message| message.speed_mps), Some(20.0));
///         runtime.end_cycle(ServiceState::Running)?;
///         Ok(Cycle::Next)
///     })?;
///     runtime.finish(())
/// }
///
/// let text = "schema_version = 1\nname = \"two-services\"\nduration_s = 1\n";
/// let scenario = Scenario::parse("two-services", text).expect("a scenario");
/// let mut run = InProcess::new(&scenario, Sealing::Sealed);
/// run.start(Service::Plant, &scenario, plant)?;
/// run.start(Service::Controller, &scenario, controller)?;
/// run.take_turns(&mut |_, _| ());
/// run.begin();
/// let mut reports = 0;
/// while reports < 2 && run.take_turns(&mut |_, said| {
///     reports += u32::from(matches!(said, runtime::FromService::Report(_)));
/// }) {}
/// assert_eq!(reports, 2);
/// # Ok::<(), RuntimeError>(())
/// ```
#[derive(Debug)]
pub struct InProcess {
    bus: Rc<Bus>,
    group: Group,
    members: Vec<Member>,
}

#[derive(Debug)]
struct Member {
    service: Service,
    task: Task,
    desk: Desk,
    end: End,
}

impl InProcess {
    /// A run of `scenario` without services yet.
    pub fn new(scenario: &Scenario, sealing: Sealing) -> Self {
        let timetable = Timetable::of(scenario);
        let group = Group {
            // Nothing of it is in the file system.
            root: PathBuf::new(),
            prefix: String::new(),
            mode: Mode::Lockstep,
            timetable,
            standby: Vec::new(),
            patience_ns: PATIENCE_NS,
            // Each service gets it as a value.
            scenario: String::new(),
        };
        Self { bus: Rc::new(Bus::new(&timetable, sealing)), group, members: Vec::new() }
    }

    /// The run's periods.
    pub fn timetable(&self) -> Timetable {
        self.group.timetable
    }

    /// A listener. It must be drained between turns, or the services wait for it.
    pub fn observer(&self) -> Guest {
        Guest::at(Seat::new(Rc::clone(&self.bus), None), self.group.timetable)
    }

    /// Adds a service, which does `entry`.
    pub fn start(
        &mut self,
        service: Service,
        scenario: &Scenario,
        entry: impl FnOnce(Runtime) -> Result<(), RuntimeError> + 'static,
    ) -> Result<(), RuntimeError> {
        let (pause, desk) = (Pause::default(), Desk::default());
        let seat = Seat::new(Rc::clone(&self.bus), Some(pause.clone()));
        let link = Link::in_memory(desk.clone(), pause.clone());
        let end = link.orders.end.clone();
        let (group, scenario) = (self.group.clone(), scenario.clone());
        let runtime = Runtime::join_in_process(service, group, scenario, seat, link);
        let task = Task::new(pause, move || entry(runtime))?;
        self.members.push(Member { service, task, desk, end });
        Ok(())
    }

    /// Gives the services that are ready the common start.
    pub fn begin(&self) {
        for member in &self.members {
            // Simulated time has no instant on the wall.
            member.desk.start.set(Some(StartOrder { start_ns: 0, standby_for: None }));
        }
    }

    /// Ends the run after the releases of `step`.
    pub fn stop_after(&self, step: u64) {
        self.members.iter().for_each(|member| member.end.set_before(step + 1));
    }

    /// Ends the run at once.
    pub fn abort(&self) {
        self.members.iter().for_each(|member| member.end.set_before(0));
    }

    /// Gives every service a turn and hands what they say to `said`, a failure included. False when
    /// all have ended.
    ///
    /// Call it again only after all listeners have taken their messages. When a whole round moves no message,
    /// the services wait for each other for ever, and receive an error.
    pub fn take_turns(&mut self, said: &mut dyn FnMut(Service, FromService)) -> bool {
        let before = self.bus.moved();
        let (mut alive, mut changed) = (false, false);
        for member in &mut self.members {
            let failed = match member.task.resume() {
                Some(Turn::Waits) => {
                    alive = true;
                    None
                }
                Some(Turn::Done(Ok(()) | Err(RuntimeError::Stopped))) => {
                    changed = true;
                    None
                }
                Some(Turn::Done(Err(error))) => Some(error.to_string()),
                Some(Turn::Panicked(message)) => Some(format!("panicked: {message}")),
                None => None,
            };
            while let Some(message) = member.desk.said.borrow_mut().pop_front() {
                changed = true;
                said(member.service, message);
            }
            if let Some(reason) = failed {
                changed = true;
                said(member.service, FromService::Failed(reason));
            }
        }
        if !changed && self.bus.moved() == before {
            self.bus.stall();
        }
        alive
    }
}
