//! The two pipes to a program: one question at a time, and its answer.

use bytemuck::Pod;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::io::{Errno, read, write};
use std::io;
use std::marker::PhantomData;
use std::os::fd::OwnedFd;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Bytes of a wrong answer that are shown.
const SHOWN: usize = 40;

/// Misbehaviour of a program.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(super) enum ChannelError {
    #[error("ended")]
    Closed,
    /// Its act, behind the program's name.
    #[error("{0}")]
    Wrong(String),
}

impl ChannelError {
    /// It has not answered in this time.
    pub(super) fn silent(patience: Duration) -> Self {
        Self::Wrong(format!("gave no answer within {} s", patience.as_secs_f64()))
    }

    fn pipe(errno: Errno) -> Self {
        Self::Wrong(format!("cannot be spoken to: {errno}"))
    }
}

/// The pipes. Questions `Q` and answers `A` are records that begin with the question's number.
#[derive(Debug)]
pub(super) struct Channel<Q, A> {
    questions: OwnedFd,
    answers: OwnedFd,
    part: Vec<u8>,
    filled: usize,
    /// The question that is not answered yet, and since when.
    asked: Option<(u64, Instant)>,
    pub(super) next: u64,
    records: PhantomData<(Q, A)>,
}

impl<Q: Pod, A: Pod> Channel<Q, A> {
    pub(super) fn new(questions: OwnedFd, answers: OwnedFd) -> io::Result<Self> {
        for end in [&questions, &answers] {
            fcntl_setfl(end, fcntl_getfl(end)? | OFlags::NONBLOCK)?;
        }
        let part = vec![0; size_of::<A>()];
        let records = PhantomData;
        Ok(Self { questions, answers, part, filled: 0, asked: None, next: 1, records })
    }

    /// Time since which a question is not answered.
    pub(super) fn unanswered_since(&self) -> Option<Instant> {
        self.asked.map(|(_, since)| since)
    }

    /// Asks `question`, whose number is the next one.
    pub(super) fn ask(&mut self, question: &Q) -> Result<(), ChannelError> {
        let bytes = bytemuck::bytes_of(question);
        debug_assert!(self.asked.is_none() && bytes.starts_with(&self.next.to_le_bytes()));
        if self.filled > 0 || self.fill()? {
            return Err(ChannelError::Wrong(format!(
                "wrote {} without a question, expected one answer of {} bytes to each",
                shown(&self.part[..self.filled]),
                self.part.len()
            )));
        }
        // Up to PIPE_BUF bytes are written whole or not at all.
        loop {
            match write(&self.questions, bytes) {
                Ok(_) => break,
                Err(Errno::INTR) => {}
                // The program reads no questions: it will be late.
                Err(Errno::AGAIN) => break,
                Err(Errno::PIPE) => return Err(ChannelError::Closed),
                Err(error) => return Err(ChannelError::pipe(error)),
            }
        }
        self.asked = Some((self.next, Instant::now()));
        self.next += 1;
        Ok(())
    }

    /// The answer to the question, if it is there by `deadline`.
    pub(super) fn answer(&mut self, deadline: Instant) -> Result<Option<A>, ChannelError> {
        let Some((number, _)) = self.asked else { return Ok(None) };
        loop {
            let more = self.fill()?;
            // A wrong beginning is refused at once.
            let seen = self.filled.min(8);
            if self.part[..seen] != number.to_le_bytes()[..seen] {
                return Err(ChannelError::Wrong(format!(
                    "wrote {} where an answer of {} bytes was expected that begins with the \
                     question's number, {number}, as 8 bytes",
                    shown(&self.part[..self.filled]),
                    self.part.len()
                )));
            }
            if self.filled == self.part.len() {
                let mut answer = A::zeroed();
                bytemuck::bytes_of_mut(&mut answer).copy_from_slice(&self.part);
                (self.filled, self.asked) = (0, None);
                return Ok(Some(answer));
            }
            if more {
                continue;
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            let wait = Timespec::try_from(left).expect("deadlines are near");
            match poll(&mut [PollFd::new(&self.answers, PollFlags::IN)], Some(&wait)) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(error) => return Err(ChannelError::pipe(error)),
            }
        }
    }

    /// Takes what is there; true if it was anything.
    fn fill(&mut self) -> Result<bool, ChannelError> {
        if self.filled == self.part.len() {
            return Ok(false);
        }
        loop {
            match read(&self.answers, &mut self.part[self.filled..]) {
                Ok(0) => return Err(ChannelError::Closed),
                Ok(count) => {
                    self.filled += count;
                    return Ok(true);
                }
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => return Ok(false),
                Err(error) => return Err(ChannelError::pipe(error)),
            }
        }
    }
}

/// Bytes as a person may read them: as text where they are, else as numbers.
fn shown(bytes: &[u8]) -> String {
    let first = &bytes[..bytes.len().min(SHOWN)];
    let more = if bytes.len() > SHOWN { "..." } else { "" };
    let printable = |byte: &u8| byte.is_ascii_graphic() || b" \n\r\t".contains(byte);
    if first.iter().all(printable) {
        return format!("`{}{more}`", String::from_utf8_lossy(first).escape_debug());
    }
    let digits: Vec<_> = first.iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    format!("the bytes {}{}", digits.join(" "), if bytes.len() > 16 { " ..." } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{LawAnswer, LawInput};
    use rustix::pipe::pipe;

    type LawChannel = Channel<LawInput, LawAnswer>;

    /// A channel, and the program's ends of it.
    fn channel() -> (LawChannel, OwnedFd, OwnedFd) {
        let (theirs, questions) = pipe().expect("a pipe");
        let (answers, ours) = pipe().expect("a pipe");
        (Channel::new(questions, answers).expect("pipes"), theirs, ours)
    }

    fn ask(channel: &mut LawChannel) -> Result<(), ChannelError> {
        let sequence = channel.next;
        channel.ask(&LawInput { sequence, ..LawInput::zeroed() })
    }

    fn answer(sequence: u64) -> Vec<u8> {
        let answer = LawAnswer { sequence, request_mps2: -1.5, ..LawAnswer::zeroed() };
        bytemuck::bytes_of(&answer).to_vec()
    }

    fn soon() -> Instant {
        Instant::now() + Duration::from_millis(5)
    }

    #[test]
    fn an_answer_may_come_in_pieces_and_late() {
        let (mut channel, _theirs, ours) = channel();
        ask(&mut channel).expect("there is room");
        assert_eq!(channel.answer(soon()), Ok(None));
        let bytes = answer(1);
        write(&ours, &bytes[..3]).expect("there is room");
        assert_eq!(channel.answer(soon()), Ok(None));
        write(&ours, &bytes[3..]).expect("there is room");
        let found = channel.answer(soon()).expect("it is right").expect("it is there");
        assert_eq!((found.sequence, found.request_mps2), (1, -1.5));
        assert!(channel.unanswered_since().is_none());
        ask(&mut channel).expect("there is room");
        write(&ours, &answer(2)).expect("there is room");
        assert!(channel.answer(soon()).expect("right").is_some());
    }

    #[test]
    fn an_invalid_answer_is_shown_as_soon_as_it_is_seen() {
        let (mut channel, _theirs, ours) = channel();
        ask(&mut channel).expect("there is room");
        write(&ours, b"hello\n").expect("there is room");
        let error = channel.answer(soon()).expect_err("no answer");
        assert!(error.to_string().contains("`hello\\n`"), "{error}");
        assert!(error.to_string().contains("expected"), "{error}");
        let (mut channel, _theirs, ours) = self::channel();
        ask(&mut channel).expect("there is room");
        write(&ours, &answer(7)).expect("there is room");
        let error = channel.answer(soon()).expect_err("another number");
        assert!(error.to_string().contains("07 00"), "{error}");
    }

    #[test]
    fn unasked_answers_are_refused_and_an_end_is_an_end() {
        let (mut channel, _theirs, ours) = channel();
        ask(&mut channel).expect("there is room");
        write(&ours, &[answer(1), answer(1)].concat()).expect("there is room");
        assert!(channel.answer(soon()).expect("right").is_some());
        let error = ask(&mut channel).expect_err("no question");
        assert!(error.to_string().contains("without a question"), "{error}");
        let (mut channel, theirs, ours) = self::channel();
        ask(&mut channel).expect("there is room");
        drop((theirs, ours));
        assert_eq!(channel.answer(soon()), Err(ChannelError::Closed));
    }
}
