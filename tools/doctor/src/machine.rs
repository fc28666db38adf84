//! Reads the machine's state for the checks, without judging it.

use super::cgroup::{self, Limit, Limits};
use super::processor::IdleState;
use runtime::scheduling::{self, Granted, Policy, Request};
use std::path::{Path, PathBuf};
use supervise::MachineError;

/// A file's contents; `None` if it cannot be read.
pub fn read(path: impl AsRef<Path>) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// The result of a service's requests for a thread, without a core of its own.
pub fn granted() -> Granted {
    let policy = Policy::Fifo(80);
    let request = Request { policy, core: None, lock_memory: true };
    let probe = std::thread::spawn(move || scheduling::apply(&request));
    probe.join().expect("applying a request does not panic")
}

/// Limits of all control groups of this process.
pub fn limits() -> Limits {
    let cgroup = read("/proc/self/cgroup").unwrap_or_default();
    let mounts = read("/proc/mounts").unwrap_or_default();
    let find = |controller: &str, file: &str| -> Vec<Limit> {
        let directories = cgroup::directories(&cgroup, &mounts, controller);
        let files = directories.into_iter().map(|directory| format!("{directory}/{file}"));
        files.filter_map(|path| read(&path).map(|text| Limit { path, text })).collect()
    };
    let memory = [find("", "memory.max"), find("memory", "memory.limit_in_bytes")].concat();
    Limits {
        cpu_max: find("", "cpu.max"),
        cpu_quota_us: find("cpu", "cpu.cfs_quota_us"),
        rt_runtime_us: find("cpu", "cpu.rt_runtime_us"),
        memory,
    }
}

/// Frequency governors of these cores.
pub fn governors(cores: &[usize]) -> Vec<(usize, String)> {
    let governor = |&core: &usize| {
        let path = format!("/sys/devices/system/cpu/cpu{core}/cpufreq/scaling_governor");
        read(path).map(|governor| (core, governor))
    };
    cores.iter().filter_map(governor).collect()
}

pub fn idle_states(core: usize) -> Vec<IdleState> {
    let base = format!("/sys/devices/system/cpu/cpu{core}/cpuidle");
    let state = |number: usize| {
        let file = |name: &str| read(format!("{base}/state{number}/{name}"));
        Some(IdleState {
            number,
            name: file("name")?.trim().into(),
            latency_us: file("latency")?.trim().parse().ok()?,
            disabled: file("disable")?.trim() == "1",
        })
    };
    (0..).map_while(state).collect()
}

/// Directory for the sockets of all runs. It is created, and removed again unless it holds runs.
pub fn base() -> Result<PathBuf, MachineError> {
    let base = supervise::base()?;
    let _ = std::fs::remove_dir(&base);
    Ok(base)
}
