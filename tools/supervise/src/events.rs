//! Events of a running group as one stream.
//!
//! A service's output is bounded: a line by [`LONGEST_LINE`], other text by [`CHATTER`] in all. [`KEPT_LINES`] lines of
//! that text are handed on. A service that says more than that is broken ([`Event::Flooded`]), whatever it says.

use crate::MachineError;
use crate::role::Role;
use messages::Service;
use runtime::FromService;
use scenario::faults::Fault;
use serde::{Deserialize, Serialize};
use signal_hook::SigId;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
use signal_hook::iterator::Handle;
use std::io::{BufRead, BufReader, Read};
use std::process::{ChildStderr, ChildStdout};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Longest line of a service, bytes: a report with all its histograms has a few hundred KiB.
const LONGEST_LINE: u64 = 16 << 20;
/// Text beside messages that one process may write, bytes.
const CHATTER: u64 = 256 << 10;
/// Lines of such text that are handed on.
const KEPT_LINES: usize = 50;
/// Longest time for which the end of a process waits for the end of its standard error.
const LAST_WORDS: Duration = Duration::from_millis(100);
/// Characters of such a line that are handed on.
const KEPT_CHARACTERS: usize = 400;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// True if the fault was accepted.
    pub ok: bool,
    /// The fault, or the reason of the refusal.
    pub message: String,
}

/// A process of a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Who<R = Service> {
    pub role: R,
    /// Index of the process among the member's, from 0.
    pub incarnation: u32,
}

/// Something that happened.
#[derive(Debug)]
pub enum Event<R = Service> {
    Message(Who<R>, FromService),
    /// A process wrote a line other than a message: a warning, a panic.
    Output(Who<R>, String),
    /// A process writes more than a service does.
    Flooded(Who<R>),
    /// A process is gone, or closed its output; its status waits to be taken.
    Gone(Who<R>),
    /// One of [`end_signals`] asks for an end.
    Signal,
    /// A fault from outside, and where its answer goes.
    Inject(Box<Fault>, Sender<Answer>),
    /// Nothing: a sender finds out whether the receiver is still there.
    Knock,
}

/// Follows a service's output until its streams end. Then it does `on_end`, in a thread that waits for nothing else.
/// Returns where the threads of both streams leave their ids, by which they can be raised.
pub fn follow<R: Role>(
    who: Who<R>,
    on_end: impl FnOnce() + Send + 'static,
    out: ChildStdout,
    err: ChildStderr,
    events: Sender<Event<R>>,
) -> std::io::Result<Arc<[AtomicI32; 2]>> {
    let (said, errors) = (events.clone(), events.clone());
    let role = who.role;
    let threads: Arc<[AtomicI32; 2]> = Arc::default();
    let (of_out, of_err) = (Arc::clone(&threads), Arc::clone(&threads));
    let (lives, ends) = channel::<()>();
    std::thread::Builder::new().name(format!("{role}-err")).spawn(move || {
        let _lives = lives;
        of_err[1].store(rustix::thread::gettid().as_raw_pid(), Ordering::Release);
        follow_stream(who, err, &errors);
    })?;
    std::thread::Builder::new().name(format!("{role}-out")).spawn(move || {
        of_out[0].store(rustix::thread::gettid().as_raw_pid(), Ordering::Release);
        follow_stream(who, out, &said);
        // The end of the output is the end of the process: it alone holds the pipe.
        on_end();
        // Its last words come before its end, unless another process holds the stream.
        let _ = ends.recv_timeout(LAST_WORDS);
        let _ = said.send(Event::Gone(who));
    })?;
    Ok(threads)
}

/// Hands on messages and text until the stream ends or its reader does not listen any more.
fn follow_stream<R: Role>(who: Who<R>, stream: impl Read, events: &Sender<Event<R>>) {
    let mut reader = BufReader::new(stream);
    let (mut line, mut chatter, mut lines) = (Vec::new(), 0, 0);
    loop {
        line.clear();
        match (&mut reader).take(LONGEST_LINE).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let event = match serde_json::from_slice(&line) {
            Ok(message) => Event::Message(who, message),
            Err(_) => {
                chatter += line.len() as u64;
                lines += 1;
                if chatter > CHATTER {
                    break;
                }
                if lines > KEPT_LINES {
                    continue;
                }
                Event::Output(who, kept(&line))
            }
        };
        if events.send(event).is_err() {
            return;
        }
    }
    if events.send(Event::Flooded(who)).is_ok() {
        // A process that is to be killed may wait for room in the pipe until it is.
        let _ = std::io::copy(&mut reader, &mut std::io::sink());
    }
}

/// A line as a person may see it.
fn kept(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(line);
    text.trim_end().chars().take(KEPT_CHARACTERS).collect()
}

/// The signals that ask this process for an end: SIGINT, SIGQUIT (`Ctrl-\`), SIGTERM and SIGHUP. SIGHUP does not count if
/// this process was started to ignore it (`nohup`).
fn end_signals() -> Vec<i32> {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    // Shells start background jobs with SIGINT and SIGQUIT ignored; they count all the same.
    let mut signals = vec![SIGINT, SIGQUIT, SIGTERM];
    if !is_ignored(&status, SIGHUP) {
        signals.push(SIGHUP);
    }
    signals
}

/// A signal that came after [`hold_signals`].
static HELD: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// From now on a signal that asks for an end waits for the group that is about to start. It does not end this process
/// at once: files that it has made would stay.
pub fn hold_signals() -> Result<(), MachineError> {
    flag_end(HELD.get_or_init(Arc::default)).map(drop)
}

/// From now on a signal that asks for an end sets `flag`.
pub fn flag_end(flag: &Arc<AtomicBool>) -> Result<Vec<SigId>, MachineError> {
    let register = |signal| signal_hook::flag::register(signal, Arc::clone(flag));
    let registered = end_signals().into_iter().map(register).collect::<Result<_, _>>();
    registered.map_err(MachineError::cannot("handle signals"))
}

/// True if a signal that asks for an end came since [`hold_signals`].
pub fn is_signalled() -> bool {
    HELD.get().is_some_and(|held| held.load(Ordering::Relaxed))
}

/// Turns the signals that ask for an end into events, until the handle is closed.
pub fn follow_signals<R: Role>(events: Sender<Event<R>>) -> Result<Handle, MachineError> {
    let error = MachineError::cannot("handle signals");
    let mut signals = signal_hook::iterator::Signals::new(end_signals()).map_err(&error)?;
    let handle = signals.handle();
    if is_signalled() {
        // The receiver is the caller's.
        let _ = events.send(Event::Signal);
    }
    let follows = std::thread::Builder::new().name("signals".into()).spawn(move || {
        for _ in signals.forever() {
            if events.send(Event::Signal).is_err() {
                return;
            }
        }
    });
    follows.map(|_| handle).map_err(error)
}

/// True if the process with this `/proc/<pid>/status` ignores `signal`.
fn is_ignored(status: &str, signal: i32) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events(stream: impl Read) -> Vec<Event> {
        let (sender, receiver) = channel();
        let who = Who { role: Service::Controller, incarnation: 0 };
        follow_stream(who, stream, &sender);
        drop(sender);
        receiver.into_iter().collect()
    }

    #[test]
    fn the_last_words_of_a_process_come_before_its_end() {
        let who = Who { role: Service::Controller, incarnation: 0 };
        for _ in 0..20 {
            let mut command = std::process::Command::new("sh");
            command.args(["-c", "exec 1>&-; echo last words >&2"]);
            command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
            let mut child = command.spawn().expect("`sh` is everywhere");
            let (out, err) = (child.stdout.take(), child.stderr.take());
            let (sender, receiver) = channel();
            let (out, err) = (out.expect("piped"), err.expect("piped"));
            follow(who, || {}, out, err, sender).expect("threads");
            let events: Vec<Event> = receiver.into_iter().collect();
            let [Event::Output(_, said), Event::Gone(_)] = &events[..] else {
                panic!("{events:?}");
            };
            assert_eq!(said, "last words");
            child.wait().expect("ours");
        }
    }

    #[test]
    fn messages_and_text_are_distinguished() {
        let found = events("{\"ended\":7}\nwarning: \u{1b}x\n\n".as_bytes());
        assert!(matches!(found[0], Event::Message(_, FromService::Ended(7))), "{found:?}");
        assert!(matches!(&found[1], Event::Output(_, line) if line.starts_with("warning")));
    }

    #[test]
    fn a_flood_is_reported_once_and_only_its_first_lines_are_kept() {
        let found = events(std::io::repeat(b'y').take(CHATTER + 1));
        assert!(matches!(found[..], [Event::Flooded(_)]), "one endless line");
        let lines = "y\n".repeat(CHATTER as usize);
        let found = events(lines.as_bytes());
        assert_eq!(found.len(), KEPT_LINES + 1);
        assert!(matches!(found.last(), Some(Event::Flooded(_))));
    }

    #[test]
    fn an_inherited_disposition_is_read_from_the_kernels_mask() {
        let status = "Name:\tx\nSigBlk:\t0000000000000000\nSigIgn:\t0000000000000001\n";
        assert!(is_ignored(status, SIGHUP));
        assert!(!is_ignored(status, SIGTERM) && !is_ignored("", SIGHUP));
    }
}
