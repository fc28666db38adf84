//! Times of a vehicle's CAMs: ETSI EN 302 637-2 V1.4.1, clause 6.1.3.
//!
//! A message is due
//! 1. when `T_GenCam_DCC` has passed since the last one, and a figure differs from it: heading by more than 4 degrees,
//!    position by 4 m, or speed by 0.5 m/s; or
//! 2. when `T_GenCam` has passed since the last one.
//!
//! `T_GenCam` is 1 s at first. After a message of the first kind it is the time between the last two messages. After
//! three of the second kind in a row it is 1 s again. Without congestion control `T_GenCam_DCC` is 100 ms.
//!
//! ```
//! use its::triggers::{Motion, Triggers};
//!
//! let mut triggers = Triggers::default();
//! let motion = |position_m| Motion { position_m, speed_mps: 20.0, heading_deg: 90.0 };
//! assert!(triggers.check(0, &motion(0.0)).is_some(), "the first message is due at once");
//! assert!(triggers.check(100_000_000, &motion(2.0)).is_none());
//! assert!(triggers.check(300_000_000, &motion(6.0)).is_some(), "more than 4 m");
//! ```

/// Least time between two messages, ns.
pub const MIN_NS: i64 = 100_000_000;
/// Longest time between two messages, ns.
pub const MAX_NS: i64 = 1_000_000_000;
/// Time between two messages with the slow part, ns.
pub const LOW_FREQUENCY_NS: i64 = 500_000_000;

const HEADING_DEG: f64 = 4.0;
const POSITION_M: f64 = 4.0;
const SPEED_MPS: f64 = 0.5;
/// `N_GenCam`.
const SLOW_AGAIN: u32 = 3;
/// Tolerance, since releases of a loop are not exact.
const TOLERANCE_NS: i64 = 1_000_000;

/// A vehicle's motion in its messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Distance travelled, m.
    pub position_m: f64,
    pub speed_mps: f64,
    pub heading_deg: f64,
}

/// Decides when a message is due.
#[derive(Clone, Copy, Debug)]
pub struct Triggers {
    last: Option<(i64, Motion)>,
    interval_ns: i64,
    in_a_row: u32,
    low_frequency_ns: Option<i64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Due {
    /// True if it includes the slow part.
    pub low_frequency: bool,
}

impl Default for Triggers {
    fn default() -> Self {
        Self { last: None, interval_ns: MAX_NS, in_a_row: 0, low_frequency_ns: None }
    }
}

impl Triggers {
    /// Returns true if a message is due at `now_ns`; it then counts as sent.
    pub fn check(&mut self, now_ns: i64, motion: &Motion) -> Option<Due> {
        if let Some((sent_ns, said)) = self.last {
            let since_ns = now_ns - sent_ns + TOLERANCE_NS;
            let turned = (motion.heading_deg - said.heading_deg + 180.0).rem_euclid(360.0) - 180.0;
            let moved = turned.abs() > HEADING_DEG
                || (motion.position_m - said.position_m).abs() > POSITION_M
                || (motion.speed_mps - said.speed_mps).abs() > SPEED_MPS;
            if since_ns >= MIN_NS && moved {
                self.interval_ns = (now_ns - sent_ns).clamp(MIN_NS, MAX_NS);
                self.in_a_row = 0;
            } else if since_ns >= self.interval_ns {
                self.in_a_row += 1;
                if self.in_a_row >= SLOW_AGAIN {
                    self.interval_ns = MAX_NS;
                }
            } else {
                return None;
            }
        }
        self.last = Some((now_ns, *motion));
        let low_frequency = self
            .low_frequency_ns
            .is_none_or(|sent_ns| now_ns - sent_ns + TOLERANCE_NS >= LOW_FREQUENCY_NS);
        if low_frequency {
            self.low_frequency_ns = Some(now_ns);
        }
        Some(Due { low_frequency })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Messages in 10 s at a constant speed, checked every 100 ms.
    fn sent(speed_mps: f64) -> (usize, usize) {
        let mut triggers = Triggers::default();
        let due: Vec<Due> = (0..100)
            .filter_map(|k| {
                let position_m = speed_mps * f64::from(k) * 0.1;
                let motion = Motion { position_m, speed_mps, heading_deg: 359.0 };
                triggers.check(i64::from(k) * 100_000_000, &motion)
            })
            .collect();
        (due.len(), due.iter().filter(|due| due.low_frequency).count())
    }

    #[test]
    fn a_vehicle_that_stands_sends_once_a_second() {
        assert_eq!(sent(0.0), (10, 10));
    }

    #[test]
    fn four_metres_of_way_are_a_message() {
        // 20 m/s: more than 4 m after 300 ms. 50 m/s: after 100 ms.
        assert_eq!(sent(20.0).0, 34);
        assert_eq!(sent(50.0), (100, 20));
    }

    #[test]
    fn speed_and_heading_trigger_and_the_rate_falls_back_after_three() {
        let mut triggers = Triggers::default();
        let at = |k: i64| k * 100_000_000;
        let still = Motion { position_m: 0.0, speed_mps: 0.0, heading_deg: 0.0 };
        assert!(triggers.check(0, &still).is_some());
        assert!(triggers.check(at(1), &Motion { speed_mps: 0.4, ..still }).is_none());
        let faster = Motion { speed_mps: 0.6, ..still };
        assert!(triggers.check(at(2), &faster).is_some());
        let turned = Motion { heading_deg: -5.0, ..faster };
        assert!(triggers.check(at(4), &turned).is_some());
        // T_GenCam is 200 ms now, three times, then 1 s.
        let times: Vec<i64> =
            (5..30).filter(|&k| triggers.check(at(k), &turned).is_some()).collect();
        assert_eq!(times, [6, 8, 10, 20]);
    }
}
