//! Trips at equal time: fuel is only compared between those.

use super::Trip;

/// Largest difference of trip times that counts as none.
pub const EQUAL_TIME: f64 = 1e-3;
/// Difference that is good enough to stop looking.
const CLOSE: f64 = 1e-4;
/// Trips within the range at most.
const ATTEMPTS: usize = 18;
/// Number of moves of the range while the trip is not in it.
const WIDENINGS: usize = 3;
/// Number of trips nearby when the desired one was jumped over, and their distance, as a share of the range.
const NEARBY: u32 = 16;
const NEAR: f64 = 0.01;

/// The trip whose time is nearest to `time_s`, within [`EQUAL_TIME`].
///
/// `trip(x)` is faster for a larger x, at least on the whole. Without a trip (the truck got stuck) x was too small. It
/// is looked for between the bounds first, then beyond.
pub fn at_equal_time(
    time_s: f64,
    (low, high): (f64, f64),
    trip: impl FnMut(f64) -> Option<Trip>,
) -> Option<Trip> {
    let mut search = Search { time_s, trip, best: None };
    let x = search.bracketed(low, high);
    // Trip time may jump over the desired one: somewhere another decision was taken. Nearby there are others.
    for step in 0..NEARBY {
        if search.found() {
            break;
        }
        let side = if step % 2 == 0 { 1.0 } else { -1.0 };
        search.late(x + side * NEAR * (high - low) * f64::from(1 + step / 2));
    }
    search.best.filter(|(off, _)| *off <= EQUAL_TIME).map(|(_, trip)| trip)
}

struct Search<F> {
    time_s: f64,
    trip: F,
    /// Error of the best trip's time, and the trip.
    best: Option<(f64, Trip)>,
}

impl<F: FnMut(f64) -> Option<Trip>> Search<F> {
    /// Relative lateness of the trip; a truck that gets stuck is very late.
    fn late(&mut self, x: f64) -> f64 {
        let Some(found) = (self.trip)(x) else { return 1.0 };
        let late = found.time_s / self.time_s - 1.0;
        if self.best.as_ref().is_none_or(|(off, _)| late.abs() < *off) {
            self.best = Some((late.abs(), found));
        }
        late
    }

    fn found(&self) -> bool {
        self.best.as_ref().is_some_and(|(off, _)| *off <= EQUAL_TIME)
    }

    /// False position; the x where it ended.
    fn bracketed(&mut self, mut low: f64, mut high: f64) -> f64 {
        let span = high - low;
        let (mut late_low, mut late_high) = (self.late(low), self.late(high));
        for _ in 0..WIDENINGS {
            if late_high > 0.0 {
                (low, late_low) = (high, late_high);
                high += span;
                late_high = self.late(high);
            } else if late_low < 0.0 {
                (high, late_high) = (low, late_low);
                low -= 0.5 * span;
                late_low = self.late(low);
            }
        }
        for attempt in 0..ATTEMPTS {
            if late_low.abs().min(late_high.abs()) < CLOSE || late_low <= late_high {
                break;
            }
            // A bisection now and then, since trip time is not smooth in x.
            let share = late_low / (late_low - late_high);
            let share = if attempt % 3 == 2 { 0.5 } else { share.clamp(0.05, 0.95) };
            let x = low + share * (high - low);
            let late = self.late(x);
            if late > 0.0 {
                (low, late_low) = (x, late);
            } else {
                (high, late_high) = (x, late);
            }
            if late.abs() < CLOSE {
                break;
            }
        }
        if late_low.abs() < late_high.abs() { low } else { high }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trip(time_s: f64) -> Trip {
        Trip { time_s, ..Trip::default() }
    }

    #[test]
    fn it_is_found_inside_and_beyond_the_range() {
        for wanted_s in [80.0, 100.0, 125.0] {
            let found = at_equal_time(wanted_s, (0.95, 1.05), |x| Some(trip(100.0 / x)));
            assert!((found.expect("found").time_s / wanted_s - 1.0).abs() <= EQUAL_TIME);
        }
    }

    #[test]
    fn a_time_that_no_trip_has_is_not_found() {
        assert!(at_equal_time(50.0, (0.95, 1.05), |_| Some(trip(100.0))).is_none());
        let jump = |x: f64| Some(trip(if x < 1.0 { 110.0 } else { 90.0 }));
        assert!(at_equal_time(100.0, (0.95, 1.05), jump).is_none());
        assert!(at_equal_time(100.0, (0.95, 1.05), |_| None).is_none());
    }
}
