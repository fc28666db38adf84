//! The times of frames in the vehicle's own time.
//!
//! ```
//! use obu::clock::{ClockError, Moment};
//!
//! let moment = Moment { now_ns: 2_000_000_000, utc_start_ns: 60_000_000_000, ahead_ns: 0 };
//! assert_eq!((moment.utc_ms(), moment.age_ms(61_500)), (62_000, 500));
//! assert_eq!(moment.run_ns(63_000), 3_000_000_000);
//!
//! let fast = ClockError { offset_ms: 10, drift_ppm: 20 };
//! assert_eq!(fast.at(1_000_000_000), 10_020_000);
//! ```

use its::time::UnixMs;

/// An instant, by the vehicle's clock and by the senders' clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// Run time, ns.
    pub now_ns: i64,
    /// UTC of run time 0 by the vehicle's clock, ns.
    pub utc_start_ns: i64,
    /// Known lead of the senders' clocks over the vehicle's, ns.
    pub ahead_ns: i64,
}

impl Moment {
    /// UTC of the senders' clocks at this instant, as the vehicle estimates it.
    pub fn utc_ms(&self) -> UnixMs {
        (self.utc_start_ns + self.now_ns + self.ahead_ns).div_euclid(1_000_000)
    }

    /// Run time of a UTC of the senders, ns.
    pub fn run_ns(&self, utc_ms: UnixMs) -> i64 {
        utc_ms.saturating_mul(1_000_000).saturating_sub(self.utc_start_ns + self.ahead_ns)
    }

    /// Age of a sender's stamp, ms; negative for a stamp of the future.
    pub fn age_ms(&self, utc_ms: UnixMs) -> i64 {
        self.utc_ms() - utc_ms
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockError {
    /// Lead at the start, ms.
    pub offset_ms: i32,
    /// Excess of its rate, millionths.
    pub drift_ppm: i32,
}

impl ClockError {
    /// Lead at a run time, ns.
    pub fn at(self, now_ns: i64) -> i64 {
        let drift_ns = i128::from(now_ns) * i128::from(self.drift_ppm) / 1_000_000;
        i64::from(self.offset_ms) * 1_000_000 + drift_ns as i64
    }
}
