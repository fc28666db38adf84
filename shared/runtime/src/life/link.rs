//! The link between the launcher and a service: JSON lines on the service's standard streams.
//!
//! The launcher writes [`ToService`] to the service's standard input and reads [`FromService`] from
//! its standard output. The end of the input is the launcher's death, and an order to stop at once.

use crate::RuntimeError;
use crate::faults::Injected;
use crate::in_process::coroutine::Pause;
use crate::machine::scheduling::{Granted, set_fifo_of};
use crate::report::ServiceReport;
use crate::survival::standby::{ActiveProcess, TakeOver};
use serde::{Deserialize, Serialize};
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io::{BufRead, Write};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel, sync_channel};
use std::time::Duration;

/// The common start instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StartOrder {
    /// Run time 0, in `CLOCK_MONOTONIC` ns.
    pub start_ns: i64,
    /// The process that this one stands by for; `None` for an active process.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standby_for: Option<ActiveProcess>,
}

/// Message of the launcher to a service.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToService {
    /// Take part: for a process that was started ahead.
    Join,
    Start(StartOrder),
    /// End after the releases of this step; in realtime, at once.
    StopAfter(u64),
    /// A fault to act out.
    Inject(Injected),
    /// Bring the vehicle to a stop in lane and end: for the plant.
    SafeStop,
    Abort,
}

/// The signal that makes a service look at its peers again: one has joined. Ignored by default, so
/// that a program which does not expect it is not harmed.
pub const PEER_JOINED: i32 = signal_hook::consts::SIGURG;

/// Message of a service to the launcher.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FromService {
    /// All ports are open; what the kernel granted.
    Ready(Granted),
    /// This process was the standby, and is the active one now.
    TookOver(TakeOver),
    /// The service reached the ordered end, with this report.
    Report(Box<ServiceReport>),
    /// The plant ended the run in this step; the others may finish it.
    Ended(u64),
    /// The service cannot go on.
    Failed(String),
}

/// First step that is not to be run any more, shared with the link's thread.
#[derive(Clone, Debug)]
pub struct End(Arc<AtomicUsize>);

impl Default for End {
    fn default() -> Self {
        Self(Arc::new(AtomicUsize::new(usize::MAX)))
    }
}

impl End {
    /// True if `step` is not to be run any more.
    pub(crate) fn is_before(&self, step: u64) -> bool {
        self.0.load(Ordering::Relaxed) as u64 <= step
    }

    /// True if the run was aborted.
    pub(crate) fn is_now(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }

    /// Ends the run before `step`, unless it ends earlier.
    pub(crate) fn set_before(&self, step: u64) {
        self.0.fetch_min(usize::try_from(step).unwrap_or(usize::MAX), Ordering::Relaxed);
    }
}

/// The service's end of the link.
#[derive(Debug)]
pub struct Link {
    way: Way,
    pub(crate) orders: Orders,
    /// The launcher's faults.
    pub(crate) injected: Option<Receiver<Injected>>,
}

/// Orders of the launcher that act at any time, shared with the thread that reads them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Orders {
    pub(crate) end: End,
    pub(crate) joined: Arc<AtomicBool>,
    /// The vehicle is to be brought to a stop.
    pub(crate) safe_stop: Arc<AtomicBool>,
    /// The thread that reads; 0 without one.
    thread: Arc<AtomicI32>,
}

#[derive(Debug)]
enum Way {
    /// By the standard streams. The orders to join and to start come from the thread that reads them.
    Streams(Receiver<ToService>),
    /// In memory, between services that take turns.
    Memory(Desk, Pause),
}

/// Mailbox of a service and of the launcher in its thread.
#[derive(Clone, Debug, Default)]
pub(crate) struct Desk {
    /// Messages of the service, oldest first.
    pub(crate) said: Rc<RefCell<VecDeque<FromService>>>,
    pub(crate) start: Rc<Cell<Option<StartOrder>>>,
}

impl Link {
    /// The link of a service in the launcher's own thread.
    pub(crate) fn in_memory(desk: Desk, pause: Pause) -> Self {
        Self { way: Way::Memory(desk, pause), orders: Orders::default(), injected: None }
    }

    /// Gives the thread that reads the lowest real-time priority. A killed process is gone when all its threads are. On
    /// a busy machine an ordinary thread waits for a processor to end on.
    pub(crate) fn raise_thread(&self) {
        let thread = self.orders.thread.load(Ordering::Acquire);
        if thread > 0 {
            set_fifo_of(thread, 1);
        }
    }

    /// Listens to the launcher. SIGTERM and SIGINT keep their default: a service that they end has died,
    /// and the launcher replaces it.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`].
    pub fn open() -> Result<Self, RuntimeError> {
        let orders = Orders::default();
        signal_hook::flag::register(PEER_JOINED, Arc::clone(&orders.joined))
            .map_err(RuntimeError::link("signal handler"))?;
        let (sender, receiver) = sync_channel(2);
        let (faults, injected) = channel();
        let Orders { end, safe_stop, thread, .. } = orders.clone();
        std::thread::Builder::new()
            .name("link".into())
            .stack_size(128 * 1024)
            .spawn(move || {
                thread.store(rustix::thread::gettid().as_raw_pid(), Ordering::Release);
                for line in std::io::stdin().lock().lines() {
                    match line.ok().and_then(|l| serde_json::from_str::<ToService>(&l).ok()) {
                        // A second one finds the channel full or is not looked at.
                        Some(order @ (ToService::Join | ToService::Start(_))) => {
                            drop(sender.try_send(order));
                        }
                        Some(ToService::StopAfter(step)) => end.set_before(step + 1),
                        Some(ToService::Inject(injected)) => drop(faults.send(injected)),
                        Some(ToService::SafeStop) => safe_stop.store(true, Ordering::Relaxed),
                        Some(ToService::Abort) | None => end.set_before(0),
                    }
                }
                end.set_before(0);
            })
            .map_err(RuntimeError::link("thread"))?;
        Ok(Self { way: Way::Streams(receiver), orders, injected: Some(injected) })
    }

    /// Waits for the order to take part.
    pub(crate) fn wait_to_join(&self) -> Result<(), RuntimeError> {
        match &self.way {
            Way::Streams(orders) if orders.recv() == Ok(ToService::Join) => Ok(()),
            _ => Err(RuntimeError::Stopped),
        }
    }

    /// True once the run was ended.
    pub fn is_over(&self) -> bool {
        self.orders.end.is_now()
    }

    /// Waits for the start order.
    ///
    /// # Errors
    /// [`RuntimeError::Stopped`] if the run ends before.
    pub fn wait_for_start(&self) -> Result<StartOrder, RuntimeError> {
        loop {
            let order = match &self.way {
                Way::Streams(orders) => match orders.recv_timeout(Duration::from_millis(50)) {
                    Ok(ToService::Start(order)) => Some(order),
                    _ => None,
                },
                Way::Memory(desk, pause) => {
                    pause.wait();
                    desk.start.get()
                }
            };
            match order {
                Some(order) => return Ok(order),
                None if self.orders.end.is_now() => return Err(RuntimeError::Stopped),
                None => {}
            }
        }
    }

    /// Sends the launcher a message.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if the launcher is gone.
    pub fn send(&self, message: FromService) -> Result<(), RuntimeError> {
        if let Way::Memory(desk, _) = &self.way {
            desk.said.borrow_mut().push_back(message);
            return Ok(());
        }
        let mut line = serde_json::to_vec(&message).expect("link messages are plain data");
        line.push(b'\n');
        let mut out = std::io::stdout().lock();
        out.write_all(&line)
            .and_then(|()| out.flush())
            .map_err(RuntimeError::link("the launcher does not listen"))
    }

    /// Waits until the launcher has all reports and closes the run.
    pub(crate) fn wait_for_the_end(&self) {
        // In memory nothing is lost with its sender.
        while matches!(self.way, Way::Streams(_)) && !self.orders.end.is_now() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
