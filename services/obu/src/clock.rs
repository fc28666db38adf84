//! The times of frames in the vehicle's own time.

use its::time::UnixMs;

/// An instant, by the vehicle's clock and by those of the senders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// Run time, ns.
    pub now_ns: i64,
    /// UTC of run time 0 by the vehicle's clock, ns.
    pub utc_start_ns: i64,
    /// By how much the senders' clocks are known to be ahead of the vehicle's, ns.
    pub ahead_ns: i64,
}

impl Moment {
    /// UTC that the senders' clocks show now, as far as the vehicle knows.
    #[must_use]
    pub fn utc_ms(&self) -> UnixMs {
        (self.utc_start_ns + self.now_ns + self.ahead_ns).div_euclid(1_000_000)
    }

    /// The run time of a UTC of the senders, ns.
    #[must_use]
    pub fn run_ns(&self, utc_ms: UnixMs) -> i64 {
        utc_ms.saturating_mul(1_000_000).saturating_sub(self.utc_start_ns + self.ahead_ns)
    }

    /// By how much the sender's stamp is older than the present, ms; negative for one of the future.
    #[must_use]
    pub fn age_ms(&self, utc_ms: UnixMs) -> i64 {
        self.utc_ms() - utc_ms
    }
}

/// The error of the vehicle's own clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockError {
    /// By how much it is ahead at the start, ms.
    pub offset_ms: i32,
    /// By how much it is too fast, millionths.
    pub drift_ppm: i32,
}

impl ClockError {
    /// By how much it is ahead at a run time, ns.
    #[must_use]
    pub fn at(self, now_ns: i64) -> i64 {
        let drift_ns = i128::from(now_ns) * i128::from(self.drift_ppm) / 1_000_000;
        i64::from(self.offset_ms) * 1_000_000 + drift_ns as i64
    }
}
