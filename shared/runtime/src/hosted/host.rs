//! The thread that starts a program, proves it, replaces it and ends it.
//!
//! It is not real-time: the control loop never waits for a process to start or to go. The kernel kills the program when
//! this thread ends, for whatever reason. The program and its children form a process group of their own, which is
//! killed as a whole.

use super::channel::{Channel, ChannelError};
use super::process::{GRACE, Plan, Process, StartError};
use super::{MAX_FAILURES, Proof};
use crate::machine::scheduling::lend_to;
use bytemuck::Pod;
use scenario::Scenario;
use scenario::supervision::Supervision;
use std::collections::VecDeque;
use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Reason why there is no program.
#[derive(Debug, Error)]
pub enum HostError {
    /// The thread that would start it.
    #[error("{subject} cannot be hosted: {reason}")]
    NoThread {
        /// The program in a sentence, here and below.
        subject: String,
        /// Error of the system.
        #[source]
        reason: io::Error,
    },
    /// It does not run.
    #[error("{subject} cannot be started: {reason}")]
    NotStarted {
        /// The program in a sentence.
        subject: String,
        /// Error of its start.
        reason: StartError,
    },
    /// Its first answer cannot be used.
    #[error("{subject} gave a wrong first answer: {what}")]
    FirstAnswer {
        /// The program in a sentence.
        subject: String,
        /// Fault of the answer.
        what: String,
    },
    /// It ended, or did not answer as it should.
    #[error(
        "{subject} {what}{}{words}{}",
        if words.is_empty() { "" } else { "; it said: " },
        if *first { " (it had not answered once)" } else { "" }
    )]
    Failed {
        /// The program in a sentence.
        subject: String,
        /// Behaviour of the program.
        what: String,
        /// Its last lines on standard error.
        words: String,
        /// It had not answered once.
        first: bool,
    },
    /// The budget of starts is used up.
    #[error("{subject} failed too often and is not started again")]
    TooOften {
        /// The program in a sentence.
        subject: String,
    },
    /// The thread does not answer in time.
    #[error("the host of the program does not answer")]
    Silent,
    /// The program's fault, where the thread cannot say more of it.
    #[error(transparent)]
    Channel(#[from] ChannelError),
}

/// Request of the control loop.
#[derive(Debug)]
enum Order {
    /// Say what the program did, and end it.
    Explain(ChannelError),
    /// Replace the program, for what it did.
    Replace(ChannelError),
    /// Lend the programs a share of the services' scheduling.
    Lend(Box<Scenario>),
}

/// Answer of the thread.
#[derive(Debug)]
pub(super) enum News<Q, A> {
    /// A program that gave its first answer.
    Ready(Box<Channel<Q, A>>),
    /// There will be none any more.
    Ended(HostError),
}

/// Record of all programs so far.
#[derive(Clone, Debug, Default)]
pub struct Life {
    /// Times that it was started.
    pub starts: u64,
    /// Its failures, at most [`MAX_FAILURES`] of them.
    pub failures: Vec<String>,
    /// It failed too often and was not started again.
    pub given_up: bool,
}

/// The control loop's side of the thread.
#[derive(Debug)]
pub(super) struct Host<Q, A> {
    orders: Option<Sender<Order>>,
    pub(super) news: Receiver<News<Q, A>>,
    life: Arc<Mutex<Life>>,
    thread: Option<JoinHandle<()>>,
}

impl<Q: Pod + Send, A: Pod + Send> Host<Q, A> {
    /// Starts the thread, which starts the program.
    pub(super) fn start(plan: Plan, proof: Proof<Q, A>) -> Result<Self, HostError> {
        let (orders, inbox) = channel();
        let (outbox, news) = channel();
        let life = Arc::new(Mutex::new(Life::default()));
        let subject = plan.subject();
        let own = Thread {
            plan,
            proof,
            orders: inbox,
            news: outbox,
            life: Arc::clone(&life),
            lent: None,
        };
        let thread = std::thread::Builder::new()
            .name("program-host".into())
            .spawn(move || own.run())
            .map_err(|reason| HostError::NoThread { subject, reason })?;
        Ok(Self { orders: Some(orders), news, life, thread: Some(thread) })
    }

    /// Asks for what the program did, in a sentence, and ends it; the answer comes as news.
    pub(super) fn explain(&self, error: ChannelError) {
        self.order(Order::Explain(error));
    }

    /// Asks for another program.
    pub(super) fn replace(&self, error: ChannelError) {
        self.order(Order::Replace(error));
    }

    /// Lends the programs a share of the services' scheduling.
    pub(super) fn lend(&self, scenario: &Scenario) {
        self.order(Order::Lend(Box::new(scenario.clone())));
    }

    /// Record of all programs so far.
    pub(super) fn life(&self) -> Life {
        self.life.lock().expect("no holder panics").clone()
    }

    fn order(&self, order: Order) {
        if let Some(orders) = &self.orders {
            // The thread may have given up.
            let _ = orders.send(order);
        }
    }
}

impl<Q, A> Drop for Host<Q, A> {
    fn drop(&mut self) {
        // The end of the orders is the order to end; the program's input must be closed before.
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The thread.
struct Thread<Q, A> {
    plan: Plan,
    proof: Proof<Q, A>,
    orders: Receiver<Order>,
    news: Sender<News<Q, A>>,
    life: Arc<Mutex<Life>>,
    lent: Option<Box<Scenario>>,
}

impl<Q: Pod + Send, A: Pod + Send> Thread<Q, A> {
    fn run(mut self) {
        let mut restarts = Restarts::default();
        let mut first = true;
        loop {
            match self.begin() {
                Ok((process, channel)) => {
                    if self.news.send(News::Ready(Box::new(channel))).is_err() {
                        return process.end(GRACE);
                    }
                    if !self.attend(process) {
                        return;
                    }
                }
                Err(why) if first => return self.give_up(why),
                Err(why) => self.note(&why),
            }
            first = false;
            let Some(wait) = restarts.next(&self.plan.supervision) else {
                return self.give_up(HostError::TooOften { subject: self.plan.subject() });
            };
            if !self.pause(wait) {
                return;
            }
        }
    }

    /// Looks after a program until it is to be replaced; false when there is nothing more to do.
    fn attend(&mut self, mut process: Process) -> bool {
        loop {
            match self.orders.recv() {
                Ok(Order::Lend(scenario)) => {
                    lend_to(process.pid(), &scenario, self.proof.service);
                    self.lent = Some(scenario);
                }
                Ok(Order::Replace(error)) => {
                    let why = self.why(&error, &mut process, false);
                    self.note(&why);
                    process.end(Duration::ZERO);
                    return true;
                }
                Ok(Order::Explain(error)) => {
                    let why = self.why(&error, &mut process, false);
                    process.end(Duration::ZERO);
                    self.give_up(why);
                    return false;
                }
                Err(_) => {
                    process.end(GRACE);
                    return false;
                }
            }
        }
    }

    /// Waits before the next start; false if there is to be none.
    fn pause(&mut self, wait: Duration) -> bool {
        let until = Instant::now() + wait;
        loop {
            match self.orders.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(Order::Lend(scenario)) => self.lent = Some(scenario),
                Ok(Order::Replace(_) | Order::Explain(_)) => {}
                Err(RecvTimeoutError::Timeout) => return true,
                Err(RecvTimeoutError::Disconnected) => return false,
            }
        }
    }

    /// Starts a program and reads its first answer.
    fn begin(&mut self) -> Result<(Process, Channel<Q, A>), HostError> {
        let subject = || self.plan.subject();
        let (mut process, mut channel) = Process::start(&self.plan)
            .map_err(|reason| HostError::NotStarted { subject: subject(), reason })?;
        self.life.lock().expect("no holder panics").starts += 1;
        let deadline = Instant::now() + self.plan.patience;
        let asked = channel.ask(&self.proof.question);
        match asked.and_then(|()| channel.answer(deadline)) {
            Ok(Some(answer)) => match (self.proof.check)(&answer) {
                Ok(()) => {
                    if let Some(scenario) = &self.lent {
                        lend_to(process.pid(), scenario, self.proof.service);
                    }
                    Ok((process, channel))
                }
                Err(what) => {
                    process.end(Duration::ZERO);
                    Err(HostError::FirstAnswer { subject: subject(), what })
                }
            },
            other => {
                let patience = self.plan.patience;
                let error = other.err().unwrap_or(ChannelError::Silent { patience });
                let why = self.why(&error, &mut process, true);
                process.end(Duration::ZERO);
                Err(why)
            }
        }
    }

    /// Behaviour of a program.
    fn why(&self, error: &ChannelError, process: &mut Process, first: bool) -> HostError {
        let what = match error {
            ChannelError::Closed => process.how_it_ended(),
            other => other.to_string(),
        };
        HostError::Failed { subject: self.plan.subject(), what, words: process.last_words(), first }
    }

    fn note(&self, why: &HostError) {
        let mut life = self.life.lock().expect("no holder panics");
        if life.failures.len() < MAX_FAILURES {
            life.failures.push(why.to_string());
        }
    }

    fn give_up(&self, why: HostError) {
        self.note(&why);
        self.life.lock().expect("no holder panics").given_up = true;
        // The loop may be gone.
        let _ = self.news.send(News::Ended(why));
    }
}

/// The starts within the supervisor's window.
#[derive(Debug, Default)]
struct Restarts(VecDeque<Instant>);

impl Restarts {
    /// The wait before the next start; none if the budget is used up.
    fn next(&mut self, policy: &Supervision) -> Option<Duration> {
        let now = Instant::now();
        let window = Duration::from_nanos(policy.window_s.nanoseconds());
        while self.0.front().is_some_and(|then| now.duration_since(*then) > window) {
            self.0.pop_front();
        }
        let row = self.0.len();
        if row >= usize::from(policy.budget.value()) {
            return None;
        }
        self.0.push_back(now);
        let doublings = u32::try_from(row).unwrap_or(u32::MAX).saturating_sub(1).min(30);
        let wait_ms = u64::from(policy.backoff_ms.value()).saturating_mul(1 << doublings);
        let wait_ms = wait_ms.min(policy.max_backoff_ms.value().into());
        Some(if row == 0 { Duration::ZERO } else { Duration::from_millis(wait_ms) })
    }
}
