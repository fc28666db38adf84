//! The thread that starts a program, proves it, replaces it and ends it.
//!
//! It is not real-time: the control loop never waits for a process to start or to go. The kernel kills the program when
//! this thread ends, for whatever reason. The program and its children form a process group of their own, which is
//! killed as a whole.

use super::channel::{Channel, ChannelError};
use super::process::{GRACE, Plan, Process};
use super::{HostError, Proof};
use crate::machine::scheduling::lend_to;
use bytemuck::Pod;
use scenario::Scenario;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const MAX_FAILURES: usize = 8;

/// Request of the control loop.
#[derive(Debug)]
pub(super) enum Order {
    /// Replace the program, for what it did. The last one is ended, and the reason is the news.
    Replace { error: ChannelError, is_last: bool },
    /// Lend the programs a share of the services' scheduling.
    Lend(Box<Scenario>),
}

/// A program that gave its first answer, or the reason why there will be none any more.
type News<Q, A> = Result<Box<Channel<Q, A>>, HostError>;

/// Record of all programs so far.
#[derive(Clone, Debug, Default)]
pub struct Life {
    pub starts: u64,
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
    pub(super) fn start(plan: Plan, proof: Proof<Q, A>) -> Result<Self, HostError> {
        let (orders, inbox) = channel();
        let (outbox, news) = channel();
        let life = Arc::<Mutex<Life>>::default();
        let subject = plan.subject();
        let own = Arc::clone(&life);
        let (lent, starts) = Default::default();
        let own = Thread { plan, proof, orders: inbox, news: outbox, life: own, lent, starts };
        let thread = std::thread::Builder::new()
            .name("program-host".into())
            .spawn(move || own.run())
            .map_err(|reason| HostError(format!("{subject} cannot be hosted: {reason}")))?;
        Ok(Self { orders: Some(orders), news, life, thread: Some(thread) })
    }

    pub(super) fn order(&self, order: Order) {
        if let Some(orders) = &self.orders {
            // The thread may have given up.
            let _ = orders.send(order);
        }
    }

    pub(super) fn life(&self) -> Life {
        self.life.lock().expect("no holder panics").clone()
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

struct Thread<Q, A> {
    plan: Plan,
    proof: Proof<Q, A>,
    orders: Receiver<Order>,
    news: Sender<News<Q, A>>,
    life: Arc<Mutex<Life>>,
    lent: Option<Box<Scenario>>,
    /// The starts within the supervisor's window.
    starts: VecDeque<Instant>,
}

impl<Q: Pod + Send, A: Pod + Send> Thread<Q, A> {
    fn run(mut self) {
        let mut is_first = true;
        loop {
            let (why, is_last) = match self.begin() {
                Ok((process, channel)) => {
                    if self.news.send(Ok(Box::new(channel))).is_err() {
                        return process.end(GRACE);
                    }
                    let Some(end) = self.attend(process) else { return };
                    end
                }
                Err(why) => (why, is_first),
            };
            is_first = false;
            if is_last {
                return self.give_up(why);
            }
            self.note(&why);
            let Some(wait) = self.next_wait() else {
                return self.give_up(self.error("failed too often and is not started again"));
            };
            if !self.pause(wait) {
                return;
            }
        }
    }

    /// Looks after a program until it is to be replaced: for this reason, and whether it was the last one. `None` when
    /// there is nothing more to do.
    fn attend(&mut self, mut process: Process) -> Option<(HostError, bool)> {
        loop {
            match self.orders.recv() {
                Ok(Order::Lend(scenario)) => {
                    lend_to(process.pid(), &scenario, self.proof.service);
                    self.lent = Some(scenario);
                }
                Ok(Order::Replace { error, is_last }) => {
                    let why = self.failure(&error, &mut process, "");
                    process.end(Duration::ZERO);
                    return Some((why, is_last));
                }
                Err(_) => {
                    process.end(GRACE);
                    return None;
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
                Ok(Order::Replace { .. }) => {}
                Err(error) => return error == RecvTimeoutError::Timeout,
            }
        }
    }

    /// Starts a program and reads its first answer.
    fn begin(&mut self) -> Result<(Process, Channel<Q, A>), HostError> {
        let (mut process, mut channel) = Process::start(&self.plan)
            .map_err(|reason| self.error(&format!("cannot be started: {reason}")))?;
        self.life.lock().expect("no holder panics").starts += 1;
        let patience = self.plan.patience;
        let deadline = Instant::now() + patience;
        let answer = channel.ask(&self.proof.question).and_then(|()| channel.answer(deadline));
        let answer = answer.and_then(|answer| answer.ok_or(ChannelError::silent(patience)));
        let why = match answer.map(|answer| (self.proof.check)(&answer)) {
            Ok(Ok(())) => {
                if let Some(scenario) = &self.lent {
                    lend_to(process.pid(), scenario, self.proof.service);
                }
                return Ok((process, channel));
            }
            Ok(Err(what)) => self.error(&format!("gave a wrong first answer: {what}")),
            Err(error) => self.failure(&error, &mut process, " (it had not answered once)"),
        };
        process.end(Duration::ZERO);
        Err(why)
    }

    fn error(&self, what: &str) -> HostError {
        HostError(format!("{} {what}", self.plan.subject()))
    }

    /// Behaviour of a program, and its last lines on standard error.
    fn failure(&self, error: &ChannelError, process: &mut Process, note: &str) -> HostError {
        let what = match error {
            ChannelError::Closed => process.how_it_ended(),
            ChannelError::Wrong(what) => what.clone(),
        };
        let said = match process.last_words() {
            words if words.is_empty() => words,
            words => format!("; it said: {words}"),
        };
        self.error(&format!("{what}{said}{note}"))
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
        let _ = self.news.send(Err(why));
    }

    /// The wait before the next start; none if the budget is used up.
    fn next_wait(&mut self) -> Option<Duration> {
        let (policy, now) = (&self.plan.supervision, Instant::now());
        let window = Duration::from_nanos(policy.window_s.nanoseconds());
        while self.starts.front().is_some_and(|then| now.duration_since(*then) > window) {
            self.starts.pop_front();
        }
        let row = self.starts.len();
        let has_budget = row < usize::from(policy.budget.value());
        has_budget.then(|| {
            self.starts.push_back(now);
            policy.backoff(row)
        })
    }
}
