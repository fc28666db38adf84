//! The way into a run that goes on: a socket in the run's root, one JSON line each way.

pub use crate::events::Answer;

use crate::MachineError;
use crate::events::Event;
use scenario::faults::{self, Fault};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

/// Name of the socket in the run's root, which is for its user alone.
const SOCKET: &str = "control";
/// Longest request, bytes.
const LONGEST: u64 = 64 * 1024;
/// Silence after which a client is dropped.
const PATIENCE: Duration = Duration::from_secs(1);

/// Accepts faults until the run's root is gone.
pub fn listen(root: &Path, events: Sender<Event>) -> Result<(), MachineError> {
    let error = MachineError::cannot("open the run's control socket");
    let listener = UnixListener::bind(root.join(SOCKET)).map_err(&error)?;
    let accepts = std::thread::Builder::new().name("control".into()).spawn(move || {
        for client in listener.incoming().flatten() {
            if ask(client, &events).is_none() {
                return;
            }
        }
    });
    accepts.map(drop).map_err(error)
}

/// Hands one client's request to the supervisor; `None` once the supervisor is gone.
fn ask(mut client: UnixStream, events: &Sender<Event>) -> Option<()> {
    let mut line = String::new();
    let waits = client.set_read_timeout(Some(PATIENCE));
    match waits.and_then(|()| BufReader::new((&client).take(LONGEST)).read_line(&mut line)) {
        // A client that went away does not need an answer.
        Err(_) => return Some(()),
        // The end of the run knocks, so that this thread notices it.
        Ok(0) => return events.send(Event::Knock).ok(),
        Ok(_) => {}
    }
    let keys = serde_json::from_str(&line).map_err(|e| e.to_string());
    let answer = match keys.and_then(|keys| faults::read(keys).map_err(|e| e.to_string())) {
        Err(e) => Answer { ok: false, message: format!("not a fault: {e}") },
        Ok(fault) => {
            let (reply, replied) = channel();
            events.send(Event::Inject(Box::new(fault), reply)).ok()?;
            replied.recv_timeout(PATIENCE).ok()?
        }
    };
    let text = serde_json::to_string(&answer).expect("plain data");
    // The client may be gone.
    writeln!(client, "{text}").ok().or(Some(()))
}

/// Wakes the thread of [`listen`], so that it notices the end of its receiver.
pub fn close(root: &Path) {
    // The thread is gone already, or wakes.
    let _ = UnixStream::connect(root.join(SOCKET));
}

/// Sends `fault` to the run with this root.
pub fn inject(root: &Path, fault: &Fault) -> std::io::Result<Answer> {
    let mut stream = UnixStream::connect(root.join(SOCKET))?;
    let text = serde_json::to_string(fault).expect("plain data");
    writeln!(stream, "{text}")?;
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line)?;
    serde_json::from_str(&line).map_err(std::io::Error::other)
}
