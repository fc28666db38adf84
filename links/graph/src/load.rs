//! The work of a cycle: a spin on the thread's processor time, or an answer of a program.
//!
//! A program gets a line of JSON on its standard input for each cycle, and answers with a line. The node publishes when
//! the answer has come. The program has the node's core and priority, and ends with it.
//!
//! ```text
//! {"node":"detect","cycle":17,"inputs":[{"topic":"image","sequence":17,"age_us":812.4}]}
//! ```

use runtime::scheduling::set_fifo_of;
use rustix::time::{ClockId, clock_gettime};
use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use supervise::MachineError;

/// Rounds of the spin between two looks at the clock, some microseconds: a look is a system call.
const ROUNDS: u64 = 3_000;

/// A program that computes for a node.
#[derive(Debug)]
pub struct Program {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    answer: String,
}

/// Spins for `load_ns` of processor time.
pub fn spin_for(load_ns: i64) {
    let end_ns = processor_ns() + load_ns;
    while load_ns > 0 && processor_ns() < end_ns {
        spin();
    }
}

impl Program {
    /// Starts the program of a node with this `command`, at `priority` if the node has that itself.
    pub fn start(command: &str, priority: Option<u8>) -> Result<Self, MachineError> {
        let words = shlex::split(command).unwrap_or_default();
        let Some((program, arguments)) = words.split_first() else {
            return Err(MachineError(format!("cannot start `{command}`")));
        };
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        runtime::inherit_only(&mut command, None);
        runtime::die_with_this_thread(&mut command);
        let failed = MachineError::cannot(format!("start {program}"));
        let mut child = command.spawn().map_err(failed)?;
        if let Some(priority) = priority {
            set_fifo_of(child.id().cast_signed(), priority);
        }
        let input = child.stdin.take().expect("piped");
        let output = BufReader::new(child.stdout.take().expect("piped"));
        Ok(Self { child, input, output, answer: String::new() })
    }

    /// Waits until it has answered `question`.
    pub fn ask(&mut self, question: &str) -> Result<(), MachineError> {
        self.answer.clear();
        let asked = writeln!(self.input, "{question}");
        let answered = asked.and_then(|()| self.output.read_line(&mut self.answer));
        match answered.map_err(MachineError::cannot("ask the node's program"))? {
            0 => Err(MachineError("the node's program ended without an answer".to_owned())),
            _ => Ok(()),
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Its own child; after its end this does nothing.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Processor time of this thread so far, ns.
fn processor_ns() -> i64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}

/// Rounds that each depend on the previous one.
fn spin() {
    let mut state = 1_u64;
    for _ in 0..ROUNDS {
        state = black_box(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
    }
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
        let mut program = Program::start("cat", None).expect("started");
        for _ in 0..3 {
            program.ask("{}").expect("it answers");
        }
        let mut program = Program::start("true", None).expect("started");
        let said = (0..2).find_map(|_| program.ask("{}").err()).expect("it ended");
        assert!(said.to_string().contains("the node's program"), "{said}");
    }
}
