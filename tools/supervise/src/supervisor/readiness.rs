//! From the first spawn to the common start.

use super::roster::Roster;
use super::{EXIT_GRACE, Supervisor};
use crate::events::{Event, Who};
use crate::member::Member;
use crate::role::Role;
use crate::succession::{self, Step};
use crate::{Error, control};
use drive::Exit;
use messages::Service;
use runtime::FromService;
use std::time::{Duration, Instant};

/// Time within which a signal is an event, once it has interrupted a call.
const SIGNAL_GRACE: Duration = Duration::from_millis(100);

impl<R: Role> Roster<'_, R> {
    /// Waits until the first processes of all members are ready, for `patience` after they were `spawned` at
    /// most. `not_ready` makes the error of a member that is not, from the reason in words.
    pub fn wait_until_ready(
        &mut self,
        spawned: Instant,
        patience: Duration,
        not_ready: impl Fn(R, String) -> Error,
    ) -> Result<(), Error> {
        let mut waiting: Vec<Who<R>> = self.iter().flat_map(Member::all).collect();
        while let Some(first) = waiting.first().map(|who| who.role) {
            let left = patience.saturating_sub(spawned.elapsed());
            if left.is_zero() {
                let seconds = patience.as_secs_f64();
                let why = format!("was not ready within {seconds} s");
                return Err(not_ready(first, why));
            }
            match self.events.recv_timeout(left) {
                Ok(Event::Message(who, FromService::Ready(granted))) => {
                    waiting.retain(|waiting| *waiting != who);
                    self.granted.insert(who.role.to_string(), granted);
                }
                Ok(Event::Message(who, FromService::Failed(reason))) => {
                    return Err(not_ready(who.role, format!("failed: {reason}")));
                }
                Ok(Event::Flooded(who)) => {
                    let what = "wrote endless text instead of messages: it is not a service";
                    return Err(not_ready(who.role, what.into()));
                }
                Ok(Event::Gone(Who { role, incarnation })) => {
                    let process = self.of(role).attached(incarnation);
                    let process = process.expect("it has just been started");
                    let exit = process.exit(EXIT_GRACE, Exit::OutputClosed);
                    let how = match exit {
                        Exit::Ok => "exit status 0".to_owned(),
                        other => other.to_string(),
                    };
                    let what = format!("ended before it was ready ({how})");
                    return Err(not_ready(role, what + &self.last_lines(role)));
                }
                Ok(Event::Signal) => return Err(Error::Interrupted),
                Ok(Event::Output(who, line)) => self.wrote.push((who.role, line)),
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

    /// Gives all processes, which are ready, the common start at `start_ns`.
    pub fn begin_all(&mut self, start_ns: i64) {
        self.start_ns = start_ns;
        let all: Vec<Who<R>> = self.iter().flat_map(Member::all).collect();
        for Who { role, incarnation } in all {
            for step in self.of(role).on(succession::Event::Ready(incarnation), 0) {
                match step {
                    Step::Activate(incarnation) => self.begin(role, incarnation, None, 0),
                    Step::StandBy { incarnation, active } => {
                        self.begin(role, incarnation, Some(active), 0);
                    }
                    _ => unreachable!("nothing has ended yet"),
                }
            }
        }
    }
}

impl Supervisor<'_> {
    pub(super) fn wait_until_ready(&mut self, spawned: Instant) -> Result<(), Error> {
        let patience = self.launch.ready_timeout;
        let programs = &self.programs;
        self.roster.wait_until_ready(spawned, patience, |service, what| {
            let foreign = programs.contains_key(&service);
            let hint = match foreign && service == Service::Controller {
                true => " (a law's program is not a service: give it with --law NAME=COMMAND)",
                false => "",
            };
            Error::NotReady { service, what: what + hint, foreign }
        })
    }

    /// Reason why the group did not come up: a signal, if one came. It also interrupts calls of this process and of
    /// services that got it too. These calls fail with reasons of their own.
    pub(super) fn or_interrupted(&self, error: Error) -> Error {
        let until = Instant::now() + SIGNAL_GRACE;
        while let Ok(event) =
            self.roster.events.recv_timeout(until.saturating_duration_since(Instant::now()))
        {
            if matches!(event, Event::Signal) {
                return Error::Interrupted;
            }
        }
        error
    }
}
