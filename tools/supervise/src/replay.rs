//! A group of two: the controller, and a replayer in the place of all others.

use crate::events::{Event, Who, follow_signals};
use crate::root::RunRoot;
use crate::root::check_room;
use crate::start::attendant::Attendant;
use crate::start::processes::{Janitor, Process};
use crate::{Error, MachineError};
use controller::laws;
use drive::Exit;
use messages::{Command, Diagnostics, Service, Topic};
use recorder::{FromReplayer, Recording, Take, ToReplayer};
use runtime::{
    FromService, Group, Guest, Mode, Schedule, StartOrder, Tapped, Timetable, ToService,
    enroll_listener, monotonic_ns, shared_memory_bytes,
};
use scenario::Scenario;
use std::ffi::OsStr;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

/// Time until both processes must be ready.
const READY: Duration = Duration::from_secs(10);
/// Time that they get to go.
const EXIT_GRACE: Duration = Duration::from_secs(2);
/// Time between two looks at the topics, whose senders wait for room.
const POLL: Duration = Duration::from_millis(1);

/// The replayer cannot give the recorded samples.
fn replayer(why: impl Display) -> Error {
    MachineError(format!("the replayer: {why}")).into()
}

/// Messages of the controller in a replay.
#[derive(Debug)]
pub enum Replayed<'a> {
    Command(&'a Command),
    Diagnostics(&'a Diagnostics),
}

/// Gives the controller of `scenario`, or `program` in its place, the releases and inputs of `take` in `recording`.
/// `heard` gets all its messages.
///
/// # Errors
/// If the group does not come up or the controller does not reach the end.
pub fn replay(
    scenario: &Scenario,
    recording: &Recording,
    take: &Take,
    program: Option<&PathBuf>,
    heard: &mut dyn FnMut(Replayed<'_>),
) -> Result<(), Error> {
    let foreign = program.is_some() || laws::program(scenario).is_ok_and(|law| law.is_some());
    let timetable = Timetable::of(scenario);
    check_room(shared_memory_bytes(&timetable, &[]))?;
    let root = RunRoot::create()?;
    let mut janitor = Janitor::spawn(&root)?;
    let (sender, events) = channel();
    let signals = follow_signals(sender.clone())?;
    let group = root.group(Mode::Lockstep, timetable, Vec::new(), scenario.to_toml());
    let result = group
        .write()
        .and_then(|()| enroll_listener(root.prefix(), std::process::id()))
        .and_then(|()| {
            let releases = recording.cycles(take).map(|cycle| cycle.release());
            Schedule::write(root.path(), Service::Controller, releases)
        })
        .map_err(Error::from)
        .and_then(|()| {
            let file = recording.path();
            Cast::enter(&root, &mut janitor, take, file, (program, foreign), sender)
        })
        .and_then(|mut cast| {
            let replayed = cast.play(&group, take, &events, heard);
            cast.leave();
            replayed
        });
    signals.close();
    root.remove();
    janitor.dismiss();
    result
}

/// The two processes.
struct Cast {
    controller: Process,
    /// A program of the user's decides what it does.
    foreign: bool,
    replayer: Attendant,
}

impl Cast {
    fn enter(
        root: &RunRoot,
        janitor: &mut Janitor,
        take: &Take,
        file: &Path,
        (program, foreign): (Option<&PathBuf>, bool),
        events: Sender<Event>,
    ) -> Result<Self, Error> {
        let who = Who { role: Service::Controller, incarnation: take.incarnation };
        let mut controller = Process::spawn(who, program, root, 0, events, false)?;
        let group = controller.pid();
        janitor.watch(group);
        let numbers = [take.incarnation.to_string(), take.cycles.to_string()];
        let arguments = [file.as_os_str(), OsStr::new(&numbers[0]), OsStr::new(&numbers[1])];
        match Attendant::spawn("replayer", &arguments, root, group) {
            Ok(replayer) => Ok(Self { controller, foreign, replayer }),
            Err(error) => {
                controller.end(EXIT_GRACE);
                Err(error)
            }
        }
    }

    fn play(
        &mut self,
        group: &Group,
        take: &Take,
        events: &Receiver<Event>,
        heard: &mut dyn FnMut(Replayed<'_>),
    ) -> Result<(), Error> {
        let guest = Guest::join(group, "launcher")?;
        let (commands, diagnostics) = (guest.tap(Topic::Command)?, guest.tap(Topic::Diagnostics)?);
        let mut listener = Listener { commands, diagnostics, cycles: 0, heard };
        self.wait_until_ready(events)?;
        // A receiver that has not looked is not connected.
        listener.listen()?;
        self.controller
            .order(&ToService::Start(StartOrder { start_ns: monotonic_ns(), standby_for: None }));
        self.replayer.process.order(&ToReplayer::Start);
        loop {
            let event = events.recv_timeout(POLL);
            listener.listen()?;
            if let Ok(event) = event
                && let Some(FromService::Report(_)) = self.message(event)?
            {
                break;
            }
            if self.replayer.process.poll().is_some() {
                return Err(replayer(match self.replayer.receive(Duration::ZERO) {
                    Some(FromReplayer::Failed(why)) => why,
                    _ => "it ended before its time".to_owned(),
                }));
            }
        }
        listener.listen()?;
        match listener.cycles == take.cycles {
            true => Ok(()),
            false => Err(broken(format!("it ran {} cycles", listener.cycles), self.foreign)),
        }
    }

    fn wait_until_ready(&mut self, events: &Receiver<Event>) -> Result<(), Error> {
        loop {
            let Ok(event) = events.recv_timeout(READY) else {
                return Err(broken("it did not get ready".into(), self.foreign));
            };
            if let Some(FromService::Ready(_)) = self.message(event)? {
                break;
            }
        }
        match self.replayer.receive(READY) {
            Some(FromReplayer::Ready) => Ok(()),
            Some(FromReplayer::Failed(why)) => Err(replayer(why)),
            None => Err(replayer("it did not get ready")),
        }
    }

    /// The controller's message in an event.
    ///
    /// # Errors
    /// The controller failed or is gone, or the replay is interrupted.
    fn message(&mut self, event: Event) -> Result<Option<FromService>, Error> {
        match event {
            Event::Message(_, FromService::Failed(how)) => Err(broken(how, self.foreign)),
            Event::Message(_, message) => Ok(Some(message)),
            Event::Gone(_) => {
                let (status, _) = self.controller.end(EXIT_GRACE);
                Err(broken(Exit::of(status).to_string(), self.foreign))
            }
            Event::Signal => Err(Error::Interrupted),
            Event::Output(_, line) => {
                eprintln!("controller: {line}");
                Ok(None)
            }
            Event::Flooded(_) | Event::Inject(..) | Event::Knock => Ok(None),
        }
    }

    fn leave(mut self) {
        self.controller.order(&ToService::Abort);
        self.controller.end(EXIT_GRACE);
        self.replayer.process.end(EXIT_GRACE);
    }
}

fn broken(what: String, foreign: bool) -> Error {
    let what = format!("broke the replay: {what}");
    Error::NotReady { service: Service::Controller, what, foreign }
}

/// Hears the controller.
struct Listener<'a> {
    commands: Tapped,
    diagnostics: Tapped,
    cycles: u64,
    heard: &'a mut dyn FnMut(Replayed<'_>),
}

impl Listener<'_> {
    fn listen(&mut self) -> Result<(), Error> {
        let Self { commands, diagnostics, cycles, heard } = self;
        while commands.take(|bytes| heard(Replayed::Command(bytemuck::from_bytes(bytes))))? {}
        while diagnostics.take(|bytes| {
            *cycles += 1;
            heard(Replayed::Diagnostics(bytemuck::from_bytes(bytes)));
        })? {}
        Ok(())
    }
}
