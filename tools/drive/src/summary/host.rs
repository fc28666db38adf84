//! The machine of a run.

use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// The machine that ran the processes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Host {
    /// Processors that this process may use.
    pub cpus: usize,
    pub kernel: String,
    /// True if the kernel is built with PREEMPT_RT.
    pub realtime_kernel: bool,
}

impl Host {
    pub fn this() -> Self {
        static THIS: OnceLock<Host> = OnceLock::new();
        THIS.get_or_init(Self::read).clone()
    }

    fn read() -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default().trim().to_owned();
        Self {
            cpus: std::thread::available_parallelism().map_or(1, usize::from),
            kernel: read("/proc/sys/kernel/osrelease"),
            realtime_kernel: read("/sys/kernel/realtime") == "1",
        }
    }
}
