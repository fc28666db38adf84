//! A hosted program's process: its start, its last words, its end.

use super::channel::Channel;
use crate::machine::spawn::{die_with_this_thread, inherit_only};
use bytemuck::Pod;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use scenario::supervision::Supervision;
use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Time that a program gets to go when its input ends.
pub(super) const GRACE: Duration = Duration::from_millis(500);

/// Lines of a program's standard error that are handed on, each time that it is started.
const KEPT_LINES: usize = 50;
/// Longest line that is handed on, bytes.
const LONGEST_LINE: u64 = 400;
/// Last lines that an error shows.
const LAST_WORDS: usize = 3;

/// Program to host.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The part that it computes, in a word: `law`.
    pub part: &'static str,
    pub command: Vec<String>,
    /// Variables of its environment, beside this process's own.
    pub variables: Vec<(String, String)>,
    pub directory: PathBuf,
    /// Time for the first answer.
    pub patience: Duration,
    /// Time for which it may owe an answer in real time.
    pub silence: Duration,
    pub supervision: Supervision,
}

impl Plan {
    pub fn subject(&self) -> String {
        format!("the {} `{}`", self.part, self.command.join(" ").escape_debug())
    }
}

pub(super) struct Process {
    child: Child,
    words: Arc<Mutex<VecDeque<String>>>,
    /// It was waited for: its ids may be another's by now.
    is_reaped: bool,
}

impl Process {
    pub(super) fn start<Q: Pod, A: Pod>(plan: &Plan) -> io::Result<(Self, Channel<Q, A>)> {
        let no_name = || io::Error::other("it has no name");
        let (name, arguments) = plan.command.split_first().ok_or_else(no_name)?;
        let place = plan.directory.join(name);
        let mut command = match name.contains('/') {
            _ if fmi::is_unit(name) => {
                let host = fmi::host(plan.part).map_err(io::Error::other)?;
                let mut command = Command::new(&host[0]);
                command.args(&host[1..]).arg(place);
                command
            }
            true => Command::new(place),
            false => Command::new(name),
        };
        command
            .args(arguments)
            .envs(plan.variables.iter().map(|(key, value)| (key, value)))
            .current_dir(&plan.directory)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0);
        inherit_only(&mut command, None);
        die_with_this_thread(&mut command);
        let child = command.spawn()?;
        let mut process = Self { child, words: Arc::default(), is_reaped: false };
        match process.open(plan) {
            Ok(channel) => Ok((process, channel)),
            Err(why) => {
                process.end(Duration::ZERO);
                Err(why)
            }
        }
    }

    /// Takes its pipes: the channel, and a thread that reads its standard error.
    fn open<Q: Pod, A: Pod>(&mut self, plan: &Plan) -> io::Result<Channel<Q, A>> {
        let questions = self.child.stdin.take().expect("piped");
        let answers = self.child.stdout.take().expect("piped");
        let errors = self.child.stderr.take().expect("piped");
        let (words, part) = (Arc::clone(&self.words), plan.part);
        let is_unit = plan.command.first().is_some_and(|name| fmi::is_unit(name));
        std::thread::Builder::new()
            .name("program-words".into())
            .stack_size(128 << 10)
            .spawn(move || read_errors(errors, &words, part, is_unit))?;
        Channel::new(questions.into(), answers.into())
    }

    pub(super) fn pid(&self) -> u32 {
        self.child.id()
    }

    fn group(&self) -> Pid {
        Pid::from_child(&self.child)
    }

    /// Waits until it is gone or `grace` is over; it stays to be waited for. True if it is gone.
    fn is_gone_within(&self, grace: Duration) -> bool {
        let deadline = Instant::now() + grace;
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT | WaitIdOptions::NOHANG;
        loop {
            match waitid(WaitId::Pid(self.group()), options) {
                Ok(None) if Instant::now() < deadline => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Ok(None) => return false,
                Ok(Some(_)) | Err(_) => return true,
            }
        }
    }

    /// Exit of the program, which is killed if it still runs.
    pub(super) fn how_it_ended(&mut self) -> String {
        if !self.is_gone_within(GRACE) {
            return "closed its standard output, which is for answers".into();
        }
        // Its children must not outlive it. It is not waited for yet: the group is its own.
        let _ = kill_process_group(self.group(), Signal::KILL);
        self.is_reaped = true;
        match self.child.wait() {
            Ok(status) => format!("ended ({status}), expected an answer to each question"),
            Err(error) => format!("ended ({error})"),
        }
    }

    pub(super) fn last_words(&self) -> String {
        // The reading thread may be a moment behind the program's end.
        std::thread::sleep(Duration::from_millis(20));
        let words = self.words.lock().expect("no holder panics");
        words.iter().map(String::as_str).collect::<Vec<_>>().join(" / ")
    }

    /// Ends it and what it started, after `grace`.
    pub(super) fn end(mut self, grace: Duration) {
        if self.is_reaped {
            return;
        }
        self.is_gone_within(grace);
        // Also where it is gone: what it started must not live on. Not waited for yet: the group is its own.
        let _ = kill_process_group(self.group(), Signal::KILL);
        let _ = self.child.wait();
    }
}

/// Hands the first lines of a program's standard error on, and keeps the last ones. The last word of a unit's process
/// stands in the error that the host makes of it.
fn read_errors(errors: ChildStderr, words: &Mutex<VecDeque<String>>, part: &str, is_unit: bool) {
    let mut reader = BufReader::new(errors);
    let (mut line, mut lines) = (Vec::new(), 0);
    loop {
        line.clear();
        match (&mut reader).take(LONGEST_LINE).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let text = String::from_utf8_lossy(&line);
        let text: String = text.trim_end().chars().filter(|c| !c.is_control()).collect();
        if text.is_empty() {
            continue;
        }
        let text = match text.strip_prefix(fmi::LAST_WORD).filter(|_| is_unit) {
            Some(last) => last.to_owned(),
            None => {
                lines += 1;
                if lines <= KEPT_LINES {
                    // A closed standard error is ignored.
                    let _ = writeln!(std::io::stderr(), "{part}: {text}");
                }
                text
            }
        };
        let mut words = words.lock().expect("no holder panics");
        words.push_back(text);
        if words.len() > LAST_WORDS {
            words.pop_front();
        }
    }
}
