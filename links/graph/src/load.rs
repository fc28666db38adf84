//! The work of a cycle: a spin on the thread's processor time, or an answer of a program.
//!
//! A program gets a line of JSON on its standard input for each cycle, and answers with a line. The node publishes when
//! the answer has come. The program has the node's core and priority, and ends with it.
//!
//! ```text
//! {"node":"detect","cycle":17,"inputs":[{"topic":"image","sequence":17,"age_us":812.4}]}
//! ```

use runtime::scheduling::{Policy, set_fifo_of};
use rustix::time::{ClockId, clock_gettime};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{ChildStdout, Command, Stdio};
use std::time::Duration;
use supervise::{MachineError, Process};

/// A program that computes for a node.
#[derive(Debug)]
pub struct Program {
    process: Process,
    output: BufReader<ChildStdout>,
    answer: String,
}

/// Spins for `load_ns` of processor time.
pub fn spin_for(load_ns: i64) {
    let end_ns = processor_ns() + load_ns;
    while processor_ns() < end_ns {}
}

impl Program {
    /// Starts the program of a node with this `command`, under `policy` if that is a real-time one.
    pub fn start(command: &str, policy: Policy) -> Result<Self, MachineError> {
        let failed = MachineError::cannot(format!("start `{command}`"));
        let words = shlex::split(command).unwrap_or_default();
        let mut command = Command::new(words.first().map_or("", String::as_str));
        command.args(words.iter().skip(1)).stdin(Stdio::piped()).stdout(Stdio::piped());
        runtime::inherit_only(&mut command, None);
        runtime::die_with_this_thread(&mut command);
        let mut child = command.spawn().map_err(failed)?;
        if let Policy::Fifo(priority) = policy {
            set_fifo_of(child.id().cast_signed(), priority);
        }
        let output = BufReader::new(child.stdout.take().expect("piped"));
        Ok(Self { process: Process::of(child, 0), output, answer: String::new() })
    }

    /// Waits until it has answered `question`.
    pub fn ask(&mut self, question: &Value) -> Result<(), MachineError> {
        self.answer.clear();
        self.process.order(question);
        let answered = self.output.read_line(&mut self.answer);
        match answered.map_err(MachineError::cannot("ask the node's program"))? {
            0 => Err(MachineError("the node's program ended without an answer".to_owned())),
            _ => Ok(()),
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.process.end(Duration::ZERO);
    }
}

/// Processor time of this thread so far, ns.
fn processor_ns() -> i64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spin_takes_its_processor_time() {
        let begun_ns = processor_ns();
        spin_for(2_000_000);
        assert!(processor_ns() - begun_ns >= 2_000_000);
    }

    #[test]
    fn a_program_answers_each_question_and_one_that_ends_is_an_error() {
        let mut program = Program::start("cat", Policy::Other).expect("started");
        for _ in 0..3 {
            program.ask(&Value::Null).expect("it answers");
        }
        let mut program = Program::start("true", Policy::Other).expect("started");
        let said = (0..2).find_map(|_| program.ask(&Value::Null).err()).expect("it ended");
        assert!(said.to_string().contains("the node's program"), "{said}");
    }
}
