//! Programs of the user's that answer questions: each is a process of its own, and its end is not the service's.
//!
//! The program reads questions from its standard input and writes answers to its standard output, both of fixed layout.
//! It answers each question once, in order, with the question's number, and ends when its input does.
//!
//! ```text
//!   a service's loop ── question ──► pipe ──► program
//!        ▲                                       │
//!        └──── answer, or none in time ◄── pipe ─┘        host thread: start, prove, replace, end
//! ```

mod channel;
mod host;
mod process;

pub use host::Life;
pub use process::Plan;

use bytemuck::Pod;
use channel::{Channel, ChannelError};
use host::{Host, Order};
use messages::Service;
use scenario::Scenario;
use std::time::{Duration, Instant};

/// Part of the time to the deadline that is left to the service.
const RESERVE: f64 = 0.1;

/// The first question to each new program, and what its answer must be.
#[derive(Clone, Copy, Debug)]
pub struct Proof<Q, A> {
    /// Number 1; it asks the program to begin anew.
    pub question: Q,
    pub check: fn(&A) -> Result<(), String>,
    /// Service whose scheduling the program gets a share of.
    pub service: Service,
}

#[derive(Debug)]
pub enum Reply<A> {
    Answer(Box<A>),
    /// It is not there in time.
    Late,
    /// There is no program at present.
    Absent,
}

/// Reason why there is no program: a sentence with the program and its fault.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct HostError(String);

/// A program with the host that starts, proves, replaces and ends it.
#[derive(Debug)]
pub struct Hosting<Q: Pod, A: Pod> {
    pub plan: Plan,
    proof: Proof<Q, A>,
    // The channel before the host: a program goes when its input ends.
    channel: Option<Box<Channel<Q, A>>>,
    host: Option<Host<Q, A>>,
    /// The program must clear its history.
    forget: bool,
}

impl<Q: Pod + Send, A: Pod + Send> Hosting<Q, A> {
    /// A program that is not started yet.
    pub fn new(plan: Plan, proof: Proof<Q, A>) -> Self {
        Self { plan, proof, channel: None, host: None, forget: true }
    }

    /// True if it runs and owes no answer.
    pub fn is_idle(&self) -> bool {
        self.channel.as_ref().is_some_and(|channel| channel.unanswered_since().is_none())
    }

    pub fn is_started(&self) -> bool {
        self.host.is_some()
    }

    /// The next question asks the program to clear its history.
    pub fn forget(&mut self) {
        self.forget = true;
    }

    /// Starts the program, and waits for its first answer.
    ///
    /// # Errors
    /// [`HostError`] if it does not answer, with its act.
    pub fn start(&mut self) -> Result<(), HostError> {
        if self.host.is_none() {
            self.host = Some(Host::start(self.plan.clone(), self.proof)?);
            // The host's own watchdog is shorter.
            self.look(2 * self.plan.patience + Duration::from_secs(5))?;
        }
        match self.channel {
            Some(_) => Ok(()),
            None => Err(HostError("the host of the program does not answer".into())),
        }
    }

    /// Lends the program a share of the service's scheduling.
    pub fn lend(&self, scenario: &Scenario) {
        self.order(|| Order::Lend(Box::new(scenario.clone())));
    }

    /// Asks the question that `question` makes of its number and of the wish to begin anew. `left` is the time to the
    /// deadline in real time; in simulated time, without it, a program that fails ends the run.
    ///
    /// # Errors
    /// In simulated time, when no answer comes, or a wrong one: its repetition would be another run.
    pub fn ask(
        &mut self,
        left: Option<Duration>,
        question: impl FnOnce(u64, bool) -> Q,
    ) -> Result<Reply<A>, HostError> {
        if self.channel.is_none() && left.is_some() {
            // A host that has given up has said so in its record.
            let _ = self.look(Duration::ZERO);
        }
        let patience = left.map_or(self.plan.patience, |left| left.mul_f64(1.0 - RESERVE));
        let error = match self.exchange(question, Instant::now() + patience) {
            Ok(Reply::Late) if left.is_none() => ChannelError::silent(patience),
            Ok(reply) => return Ok(reply),
            Err(error) => error,
        };
        // Its input ends with the channel.
        self.channel = None;
        let (is_last, own) = (left.is_none(), error.to_string());
        self.order(|| Order::Replace { error, is_last });
        if !is_last {
            return Ok(Reply::Absent);
        }
        let host = self.host.as_ref();
        Err(host.and_then(|host| host.news.iter().find_map(Result::err)).unwrap_or(HostError(own)))
    }

    fn exchange(
        &mut self,
        question: impl FnOnce(u64, bool) -> Q,
        deadline: Instant,
    ) -> Result<Reply<A>, ChannelError> {
        let Some(channel) = &mut self.channel else { return Ok(Reply::Absent) };
        // An answer to an earlier question comes too late to be used.
        if let Some(since) = channel.unanswered_since()
            && channel.answer(Instant::now())?.is_none()
        {
            let silence = self.plan.silence;
            return match since.elapsed() > silence {
                true => Err(ChannelError::silent(silence)),
                false => Ok(Reply::Late),
            };
        }
        channel.ask(&question(channel.next, self.forget))?;
        self.forget = false;
        Ok(match channel.answer(deadline)? {
            Some(answer) => Reply::Answer(Box::new(answer)),
            None => Reply::Late,
        })
    }

    pub fn life(&self) -> Life {
        self.host.as_ref().map_or_else(Life::default, Host::life)
    }

    /// Takes the next program, if the host has one within `patience`.
    fn look(&mut self, patience: Duration) -> Result<(), HostError> {
        if let Some(host) = &self.host
            && let Ok(news) = host.news.recv_timeout(patience)
        {
            (self.channel, self.forget) = (Some(news?), true);
        }
        Ok(())
    }

    fn order(&self, order: impl FnOnce() -> Order) {
        if let Some(host) = &self.host {
            host.order(order());
        }
    }
}
