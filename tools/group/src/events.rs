//! What happens to a running group, as one stream.

use super::control::Answer;
use messages::Service;
use runtime::FromService;
use scenario::faults::Fault;
use signal_hook::iterator::Handle;
use std::io::BufRead;
use std::process::{ChildStderr, ChildStdout};
use std::sync::mpsc::Sender;

/// Something that happened.
#[derive(Debug)]
pub enum Event {
    /// A service said something.
    Said(Service, FromService),
    /// A service wrote a line that is no message: a warning, a panic.
    Wrote(Service, String),
    /// A service's process is gone; its status waits to be taken.
    Gone(Service),
    /// Somebody asked for an end: Ctrl-C, SIGTERM, SIGHUP.
    Signal,
    /// Somebody sends a fault and awaits the answer.
    Inject(Box<Fault>, Sender<Answer>),
    /// Nothing: a sender finds out whether anybody listens.
    Knock,
}

/// Follows what a service says and writes, until its streams end.
pub fn follow(
    service: Service,
    out: ChildStdout,
    err: ChildStderr,
    events: Sender<Event>,
) -> std::io::Result<()> {
    let said = events.clone();
    std::thread::Builder::new().name(format!("{service}-out")).spawn(move || {
        for line in std::io::BufReader::new(out).lines().map_while(Result::ok) {
            let event = match serde_json::from_str(&line) {
                Ok(message) => Event::Said(service, message),
                Err(_) => Event::Wrote(service, line),
            };
            if said.send(event).is_err() {
                return;
            }
        }
        // The end of the output is the end of the process; nobody else holds the pipe.
        let _ = said.send(Event::Gone(service));
    })?;
    std::thread::Builder::new().name(format!("{service}-err")).spawn(move || {
        for line in std::io::BufReader::new(err).lines().map_while(Result::ok) {
            if events.send(Event::Wrote(service, line)).is_err() {
                return;
            }
        }
    })?;
    Ok(())
}

/// Turns the signals that ask for an end into events, until the handle is closed.
pub fn follow_signals(events: Sender<Event>) -> std::io::Result<Handle> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    let handle = signals.handle();
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        for _ in signals.forever() {
            if events.send(Event::Signal).is_err() {
                return;
            }
        }
    })?;
    Ok(handle)
}
