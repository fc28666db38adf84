//! From the first spawn to the common start.

use super::{EXIT_GRACE, Supervisor};
use crate::events::{Event, ServiceProcess};
use crate::start::is_foreign;
use crate::succession::{self, Step};
use crate::{Error, control};
use drive::Exit;
use messages::Service;
use runtime::FromService;
use std::time::{Duration, Instant};

/// Time within which a signal is an event, once it has interrupted a call.
const SIGNAL_GRACE: Duration = Duration::from_millis(100);

impl Supervisor<'_> {
    /// Gives all processes, which are ready, the common start.
    pub(super) fn begin_all(&mut self) {
        for service in self.launch.scenario.services() {
            let member = self.roster.of(service);
            let mut steps = member.on(succession::Event::Ready(0), 0);
            steps.extend(member.on(succession::Event::Ready(1), 0));
            for step in steps {
                match step {
                    Step::Activate(incarnation) => self.begin(service, incarnation, None, 0),
                    Step::StandBy { incarnation, active } => {
                        self.begin(service, incarnation, Some(active), 0);
                    }
                    _ => unreachable!("nothing has ended yet"),
                }
            }
        }
    }

    pub(super) fn wait_until_ready(&mut self, spawned: Instant) -> Result<(), Error> {
        let processes = |&service: &Service| {
            let of = self.group.standby.contains(&service);
            (0..=u32::from(of)).map(move |incarnation| ServiceProcess { service, incarnation })
        };
        let mut waiting: Vec<ServiceProcess> =
            self.launch.scenario.services().iter().flat_map(processes).collect();
        while let Some(first) = waiting.first().map(|who| who.service) {
            let left = self.launch.ready_timeout.saturating_sub(spawned.elapsed());
            if left.is_zero() {
                let timeout = self.launch.ready_timeout.as_secs_f64();
                return Err(self.not_ready(first, format!("was not ready within {timeout} s")));
            }
            match self.events.recv_timeout(left) {
                Ok(Event::Message(who, FromService::Ready(granted))) => {
                    waiting.retain(|waiting| *waiting != who);
                    self.journal.granted.insert(who.service.name().into(), granted);
                }
                Ok(Event::Message(who, FromService::Failed(reason))) => {
                    return Err(self.not_ready(who.service, format!("failed: {reason}")));
                }
                Ok(Event::Flooded(who)) => {
                    let what = "wrote endless text instead of messages: it is not a service".into();
                    return Err(self.not_ready(who.service, what));
                }
                Ok(Event::Gone(ServiceProcess { service, incarnation })) => {
                    let process = self.roster.of(service).attached(incarnation);
                    let process = process.expect("it has just been started");
                    let exit = process.exit(EXIT_GRACE, Exit::OutputClosed);
                    let how = match exit {
                        Exit::Ok => "exit status 0".to_owned(),
                        other => other.to_string(),
                    };
                    let what = format!("ended before it was ready ({how})");
                    let what = what + &self.journal.last_lines(service);
                    return Err(self.not_ready(service, what));
                }
                Ok(Event::Signal) => return Err(Error::Interrupted),
                Ok(Event::Output(who, line)) => self.journal.wrote.push((who.service, line)),
                Ok(Event::Inject(_, reply)) => {
                    let message = "the run has not begun".into();
                    // The client may be gone.
                    let _ = reply.send(control::Answer { ok: false, message });
                }
                // The timeout is looked at above.
                Ok(Event::Message(..) | Event::Knock) | Err(_) => {}
            }
        }
        Ok(())
    }

    /// Reason why the group did not come up: a signal, if one came. It also interrupts calls of this process and of
    /// services that got it too. These calls fail with reasons of their own.
    pub(super) fn or_interrupted(&self, error: Error) -> Error {
        let until = Instant::now() + SIGNAL_GRACE;
        while let Ok(event) =
            self.events.recv_timeout(until.saturating_duration_since(Instant::now()))
        {
            if matches!(event, Event::Signal) {
                return Error::Interrupted;
            }
        }
        error
    }

    fn not_ready(&mut self, service: Service, what: String) -> Error {
        let foreign = is_foreign(&self.programs, service);
        let hint = match foreign && service == Service::Controller {
            true => " (a law's program is not a service: give it with --law NAME=COMMAND)",
            false => "",
        };
        let what = what + hint;
        Error::NotReady { service, what, foreign }
    }
}
