//! Scheduling of a service's loop: the request, and the kernel's grant.
//!
//! In the order of their worth: timer slack of 1 ns (always granted), `SCHED_FIFO`, locked memory,
//! and a core of its own. Nothing here fails: what is not granted is reported, as read back from
//! the kernel, with the reason.

#![allow(unsafe_code, reason = "no crate wraps sched_setscheduler")]

use messages::Service;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::Pid;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity, set_current_timer_slack};
use scenario::Scenario;
use scenario::runtime::Scheduling;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io;

/// The request for sleeps that end on time without real-time priority.
pub const TIMER_SLACK: &str = "timer slack of 1 ns";
/// The request for memory that stays where it is.
pub const LOCKED_MEMORY: &str = "locked memory";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// `SCHED_FIFO` with this priority, 1 to 99.
    Fifo(u8),
    /// The ordinary time-sharing policy.
    Other,
}

impl fmt::Display for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fifo(priority) => write!(f, "fifo:{priority}"),
            Self::Other => f.write_str("other"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    pub policy: Policy,
    pub core: Option<usize>,
    pub lock_memory: bool,
}

impl Request {
    /// The scenario's request for `service`. Without a core of its choice it shares the last core that this
    /// process may use ([`scenario::runtime`] says why).
    pub fn of(scenario: &Scenario, service: Service) -> Self {
        let runtime = &scenario.runtime;
        let default = usable_cores().last().copied();
        Self {
            policy: match runtime.scheduling {
                Scheduling::Fifo => Policy::Fifo(runtime.priority(service)),
                Scheduling::Other => Policy::Other,
            },
            core: runtime.services.of(service).core.map(|core| core.value().into()).or(default),
            lock_memory: runtime.lock_memory,
        }
    }

    /// The priority under `SCHED_FIFO`; 0 without.
    pub(crate) fn priority(&self) -> u8 {
        match self.policy {
            Policy::Fifo(priority) => priority,
            Policy::Other => 0,
        }
    }

    /// Nothing: for runs in simulated time, which share the machine.
    pub(crate) const NOTHING: Self = Self { policy: Policy::Other, core: None, lock_memory: false };
}

/// Grant to a service, read back from the kernel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Granted {
    /// Policy asked for.
    pub requested: String,
    /// Policy in force.
    pub granted: String,
    /// Core that the loop is pinned to; `None` if it may run on all.
    pub core: Option<usize>,
    pub memory_locked: bool,
    /// Requests that were not granted, each with the kernel's reason: `what: why`.
    pub refused: Vec<String>,
}

impl Granted {
    /// The priority of the loop that asked for `request`; 0 where it was not granted.
    pub(crate) fn priority(&self, request: &Request) -> u8 {
        if self.requested == self.granted { request.priority() } else { 0 }
    }

    /// The kernel's reason why it refused `what`: [`TIMER_SLACK`], [`LOCKED_MEMORY`] or a policy by its name.
    pub fn refusal(&self, what: &str) -> Option<&str> {
        self.refused.iter().find_map(|refused| refused.strip_prefix(what)?.strip_prefix(": "))
    }
}

/// The priority of a thread that acts on a loop of this one; 0 beside a loop without.
pub(crate) fn above(priority: u8) -> u8 {
    if priority > 0 { priority.saturating_add(1).min(99) } else { 0 }
}

/// Applies `request` to the calling thread.
#[must_use]
pub fn apply(request: &Request) -> Granted {
    let mut refused = Vec::new();
    let mut refuse = |what: &dyn fmt::Display, why: &dyn fmt::Display| {
        refused.push(format!("{what}: {why}"));
    };
    if let Err(e) = set_current_timer_slack(std::num::NonZeroU64::new(1)) {
        refuse(&TIMER_SLACK, &e);
    }
    if let Some(core) = request.core
        && let Err(reason) = pin_to(core)
    {
        refuse(&format_args!("core {core}"), &reason);
    }
    // Pages stay once touched; locking untouched ones too would double the resident set for code
    // that the loop never runs.
    let memory_locked = request.lock_memory
        && match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT) {
            Ok(()) => true,
            Err(e) => {
                refuse(&LOCKED_MEMORY, &e);
                false
            }
        };
    if let Policy::Fifo(priority) = request.policy
        && let Err(e) = set_policy_of(0, FIFO, priority)
    {
        refuse(&request.policy, &e);
    }
    prefault_stack();
    Granted {
        requested: request.policy.to_string(),
        granted: policy_in_force().to_string(),
        core: pinned_core(),
        memory_locked,
        refused,
    }
}

/// Lends process `pid`, which computes for a service, a share of the services' scheduling. That is their core, and a
/// priority below them all. So it never delays a service. Settings that the machine does not grant are not lent.
pub fn lend_to(pid: u32, scenario: &Scenario, service: Service) {
    let Ok(raw) = i32::try_from(pid) else { return };
    let request = Request::of(scenario, service);
    if let Some(core) = request.core {
        let _ = pin(Pid::from_raw(raw), core);
    }
    let below = below_services(scenario);
    if below > 0 {
        let _ = set_policy_of(raw, libc::SCHED_FIFO, below);
    }
}

/// The priority below those of all services; 0 if there is no such priority.
pub(crate) fn below_services(scenario: &Scenario) -> u8 {
    let priorities = Service::ALL.map(|service| Request::of(scenario, service).priority());
    priorities.into_iter().min().unwrap_or(0).saturating_sub(1)
}

/// Gives thread `thread` of this process, or the calling one for 0, `SCHED_FIFO` with this priority, if the machine
/// grants it. Priority 0 leaves it as it is.
pub fn set_fifo_of(thread: i32, priority: u8) {
    if priority > 0 {
        let _ = set_policy_of(thread, FIFO, priority);
    }
}

/// The calling thread's scheduling before any request.
pub(crate) fn in_force() -> Granted {
    let policy = policy_in_force().to_string();
    Granted {
        requested: policy.clone(),
        granted: policy,
        core: pinned_core(),
        memory_locked: false,
        refused: Vec::new(),
    }
}

/// A raised priority of the calling thread, until this is dropped; its children inherit it.
#[derive(Debug)]
pub struct Priority(());

impl Priority {
    /// Raises the calling thread to `SCHED_FIFO` with this priority, where the machine grants it.
    #[must_use]
    pub fn raise(priority: u8) -> Self {
        // Without it, everything works; later, on a busy machine.
        let _ = set_policy_of(0, libc::SCHED_FIFO, priority);
        Self(())
    }
}

impl Drop for Priority {
    fn drop(&mut self) {
        become_ordinary();
    }
}

/// Gives the calling thread the ordinary time-sharing policy: for work without a deadline, which must not delay a
/// process with one on the same core.
pub fn become_ordinary() {
    // Lowering is always granted.
    let _ = set_policy_of(0, libc::SCHED_OTHER, 0);
}

/// Gives the calling thread `SCHED_DEADLINE`: `runtime_ns` of processor time in each `period_ns`. The kernel refuses it
/// to a thread with a core of its own.
///
/// # Errors
/// Why the machine refuses it.
pub fn set_deadline(runtime_ns: u64, period_ns: u64) -> io::Result<()> {
    /// `struct sched_attr` of linux/sched/types.h, and the policy's number.
    #[repr(C)]
    struct Attributes {
        size: u32,
        policy: u32,
        flags: u64,
        nice: i32,
        priority: u32,
        times_ns: [u64; 3],
    }
    const DEADLINE: u32 = 6;
    let size = size_of::<Attributes>() as u32;
    let times_ns = [runtime_ns, period_ns, period_ns];
    let (policy, flags, nice, priority) = (DEADLINE, 0, 0, 0);
    let attributes = Attributes { size, policy, flags, nice, priority, times_ns };
    // SAFETY: `attributes` lives through the call, which only reads it.
    match unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const attributes, 0) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

pub fn pin_to(core: usize) -> io::Result<()> {
    pin(None, core)
}

fn pin(pid: Option<Pid>, core: usize) -> io::Result<()> {
    if core >= CpuSet::MAX_CPU {
        return Err(io::Error::other(format!("there is no core {core}")));
    }
    let mut set = CpuSet::new();
    set.set(core);
    Ok(sched_setaffinity(pid, &set)?)
}

/// Cores that this thread may run on.
pub fn usable_cores() -> Vec<usize> {
    let set = sched_getaffinity(None).unwrap_or_else(|_| CpuSet::new());
    (0..CpuSet::MAX_CPU).filter(|&core| set.is_set(core)).collect()
}

fn pinned_core() -> Option<usize> {
    match usable_cores().as_slice() {
        [core] => Some(*core),
        _ => None,
    }
}

/// Helper threads do not inherit the priority.
const FIFO: libc::c_int = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;

/// Sets the policy of the process or thread `pid`; 0 is the calling thread.
fn set_policy_of(pid: i32, policy: libc::c_int, priority: u8) -> io::Result<()> {
    let param = libc::sched_param { sched_priority: i32::from(priority) };
    // SAFETY: `param` lives through the call, which only reads it.
    match unsafe { libc::sched_setscheduler(pid, policy, &raw const param) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

fn policy_in_force() -> Policy {
    let mut param = libc::sched_param { sched_priority: 0 };
    // SAFETY: both calls concern the calling thread; `param` lives through the second, which
    // writes it.
    let (policy, read) =
        unsafe { (libc::sched_getscheduler(0), libc::sched_getparam(0, &raw mut param)) };
    if read == 0 && policy & !libc::SCHED_RESET_ON_FORK == libc::SCHED_FIFO {
        Policy::Fifo(u8::try_from(param.sched_priority).unwrap_or(u8::MAX))
    } else {
        Policy::Other
    }
}

/// Touches the stack that a loop may come to use, so that it does not fault later.
fn prefault_stack() {
    let mut stack = [0_u8; 256 * 1024];
    for page in stack.chunks_mut(4096) {
        page[0] = 1;
    }
    std::hint::black_box(&mut stack);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_priority_is_given_up() {
        let policies = std::thread::spawn(|| {
            let asked = Request { policy: Policy::Fifo(3), core: None, lock_memory: false };
            let granted = apply(&asked).granted;
            become_ordinary();
            (granted, policy_in_force())
        });
        let (granted, after) = policies.join().expect("no panic");
        assert!(["fifo:3", "other"].contains(&granted.as_str()), "{granted}");
        assert_eq!(after, Policy::Other);
    }

    #[test]
    fn a_missing_core_is_refused_and_the_rest_goes_on() {
        let request = Request { policy: Policy::Other, core: Some(1023), lock_memory: false };
        let granted = std::thread::spawn(move || apply(&request)).join().expect("no panic");
        assert_eq!(granted.granted, "other");
        assert!(granted.refusal("core 1023").is_some_and(|why| !why.is_empty()), "{granted:?}");
        assert_eq!((granted.refusal("core 102"), granted.refusal("core 1")), (None, None));
    }
}
