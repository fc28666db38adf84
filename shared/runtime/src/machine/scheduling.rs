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

/// Scheduling policy of a loop.
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

/// Request of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Policy.
    pub policy: Policy,
    /// Core to be pinned to.
    pub core: Option<usize>,
    /// True to lock all memory.
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
    /// True if all memory is locked.
    pub memory_locked: bool,
    /// Requests that were not granted.
    pub refused: Vec<NotGranted>,
}

impl Granted {
    /// True if the loop has a real-time priority.
    pub(crate) fn is_realtime(&self) -> bool {
        self.granted != Policy::Other.to_string()
    }

    /// The priority of the loop that asked for `request`; 0 where it was not granted.
    pub(crate) fn priority(&self, request: &Request) -> u8 {
        if self.requested == self.granted { request.priority() } else { 0 }
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
    let mut refuse =
        |what, why: &dyn fmt::Display| refused.push(NotGranted { what, why: why.to_string() });
    if let Err(e) = set_current_timer_slack(std::num::NonZeroU64::new(1)) {
        refuse(Asked::TimerSlack, &e);
    }
    if let Some(core) = request.core
        && let Err(reason) = pin_to(core)
    {
        refuse(Asked::Core(core), &reason);
    }
    // Pages stay once touched; locking untouched ones too would double the resident set for code
    // that the loop never runs.
    let memory_locked = request.lock_memory
        && match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT) {
            Ok(()) => true,
            Err(e) => {
                refuse(Asked::LockedMemory, &e);
                false
            }
        };
    if let Policy::Fifo(priority) = request.policy
        && let Err(e) = set_policy_of(0, FIFO, priority)
    {
        refuse(Asked::Fifo(priority), &e);
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
    if let Some(core) = request.core.filter(|&core| core < CpuSet::MAX_CPU) {
        let mut set = CpuSet::new();
        set.set(core);
        let _ = sched_setaffinity(Pid::from_raw(raw), &set);
    }
    let below = below_services(scenario);
    if below > 0 {
        let _ = set_policy_of(raw, libc::SCHED_FIFO, below);
    }
}

/// The priority below those of all services; 0 if there is no such priority.
fn below_services(scenario: &Scenario) -> u8 {
    let priorities = Service::ALL.map(|service| Request::of(scenario, service).priority());
    priorities.into_iter().min().unwrap_or(0).saturating_sub(1)
}

/// Puts the calling thread, which has a service's priority, below all services: a standby must not delay the
/// active process.
pub(crate) fn set_below_services(scenario: &Scenario) {
    let below = below_services(scenario);
    if below > 0 {
        let _ = set_policy_of(0, FIFO, below);
    }
}

/// Gives thread `thread` of this process `SCHED_FIFO` with this priority, if the machine grants it. 0 leaves it as it
/// is.
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

/// Pins the calling thread to `core`.
pub fn pin_to(core: usize) -> io::Result<()> {
    if core >= CpuSet::MAX_CPU {
        return Err(io::Error::other(format!("there is no core {core}")));
    }
    let mut set = CpuSet::new();
    set.set(core);
    Ok(sched_setaffinity(None, &set)?)
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

/// A request to the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Asked {
    /// Sleeps that end on time without real-time priority.
    TimerSlack,
    /// This core.
    Core(usize),
    /// Memory that stays where it is.
    LockedMemory,
    /// `SCHED_FIFO` with this priority.
    Fifo(u8),
}

const TIMER_SLACK: &str = "timer slack of 1 ns";
const LOCKED_MEMORY: &str = "locked memory";

impl fmt::Display for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimerSlack => f.write_str(TIMER_SLACK),
            Self::Core(core) => write!(f, "core {core}"),
            Self::LockedMemory => f.write_str(LOCKED_MEMORY),
            Self::Fifo(priority) => write!(f, "fifo:{priority}"),
        }
    }
}

/// Something that the kernel did not grant. In JSON it is one text, `what: why`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct NotGranted {
    /// The request.
    pub what: Asked,
    /// The kernel's reason.
    pub why: String,
}

impl fmt::Display for NotGranted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.what, self.why)
    }
}

impl From<NotGranted> for String {
    fn from(refused: NotGranted) -> Self {
        refused.to_string()
    }
}

impl TryFrom<String> for NotGranted {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let what = |name: &str| match name {
            TIMER_SLACK => Some(Asked::TimerSlack),
            LOCKED_MEMORY => Some(Asked::LockedMemory),
            _ => match (name.strip_prefix("core "), name.strip_prefix("fifo:")) {
                (Some(core), _) => core.parse().ok().map(Asked::Core),
                (None, Some(priority)) => priority.parse().ok().map(Asked::Fifo),
                (None, None) => None,
            },
        };
        let parts = text.split_once(": ").and_then(|(name, why)| Some((what(name)?, why)));
        match parts {
            Some((what, why)) => Ok(Self { what, why: why.to_owned() }),
            None => Err(format!("`{text}` is nothing that is asked of the kernel")),
        }
    }
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
        assert!(
            granted.refused.iter().any(|refused| refused.what == Asked::Core(1023)),
            "{granted:?}"
        );
    }

    #[test]
    fn a_refusal_is_read_back_as_it_was_written() {
        let asked = [Asked::TimerSlack, Asked::Core(3), Asked::LockedMemory, Asked::Fifo(80)];
        for what in asked {
            let refused = NotGranted { what, why: "no: not here".into() };
            assert_eq!(NotGranted::try_from(refused.to_string()), Ok(refused));
        }
        assert!(NotGranted::try_from("core x: no".to_owned()).is_err());
    }
}
