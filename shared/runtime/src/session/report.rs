//! The report of a service at its end.

use super::Runtime;
use crate::report::{Payload, Reported, ServiceReport};
use crate::transport::Carrier;
use crate::{FromService, RuntimeError};

impl Runtime {
    /// Reports to the launcher, with the service's own `figures`, and keeps all ports open until all services have
    /// reported. So no last message is lost with its sender.
    ///
    /// # Errors
    /// [`RuntimeError::Link`].
    pub fn finish(self, figures: impl Reported) -> Result<(), RuntimeError> {
        let (cycles, skipped) = self.survival.counted(self.cycles.run(), self.cycles.skipped());
        let (sent, received) = self.ports.reports();
        let report = ServiceReport {
            allocations_in_loop: self.life.allocations_in_loop,
            service: self.service,
            cycles,
            skipped,
            release_jitter_us: self.cycles.jitter().percentiles_us(),
            sent,
            received,
            peak_rss_kib: (self.carrier() == Carrier::SharedMemory).then(peak_rss_kib),
            scheduling: self.life.granted.expect("`begin` comes before `finish`"),
            fault_statistics: self.injection.faults.statistics(),
            details: Payload::of(figures),
        };
        self.life.link.send(FromService::Report(Box::new(report)))?;
        self.life.link.wait_for_the_end();
        Ok(())
    }
}

/// Peak resident set of this process, KiB; 0 if the kernel does not give it.
fn peak_rss_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}
