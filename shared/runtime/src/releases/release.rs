//! Releases: when a service's cycles begin.

/// Reaction of a service that missed whole periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overrun {
    /// Runs every missed cycle, late: for the plant, whose integration has no gaps.
    CatchUp,
    /// Leaves them out and counts them: for services that sample the present.
    Skip,
}

/// One release of a service.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    /// Simulation step.
    pub step: u64,
    /// Time of the step, s of run time.
    pub time_s: f64,
    /// Scheduled instant, ns of run time.
    pub scheduled_ns: i64,
    /// Since when the service waited for it, ns of run time: when the one before was done.
    pub idle_ns: i64,
    /// Time when the service really began, ns of run time.
    pub start_ns: i64,
}
