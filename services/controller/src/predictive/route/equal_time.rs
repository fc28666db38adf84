//! Trips at equal time: fuel is only compared between those.

use super::Trip;

/// Largest difference of trip times that counts as none.
pub const EQUAL_TIME: f64 = 1e-3;
/// Difference that is good enough to stop looking.
const CLOSE: f64 = 1e-4;
/// Trips at most.
const ATTEMPTS: usize = 20;

/// The trip whose time is nearest to `time_s`, within [`EQUAL_TIME`]; `trip(x)` is faster for a larger
/// x, at least on the whole, and x lies between the bounds. `None` when no such trip was found.
pub fn at_equal_time(
    time_s: f64,
    (mut low, mut high): (f64, f64),
    mut trip: impl FnMut(f64) -> Option<Trip>,
) -> Option<Trip> {
    let mut best: Option<(f64, Trip)> = None;
    let mut look = |x: f64| {
        let found = trip(x)?;
        let late = found.time_s / time_s - 1.0;
        if best.as_ref().is_none_or(|(off, _)| late.abs() < *off) {
            best = Some((late.abs(), found));
        }
        Some(late)
    };
    let (mut late_low, mut late_high) = (look(low)?, look(high)?);
    for attempt in 2..ATTEMPTS {
        if late_low.abs().min(late_high.abs()) < CLOSE || late_low <= late_high {
            break;
        }
        // False position; a bisection now and then, since trip time is not smooth in x.
        let share = late_low / (late_low - late_high);
        let share = if attempt % 3 == 2 && attempt > 2 { 0.5 } else { share.clamp(0.05, 0.95) };
        let x = low + share * (high - low);
        let late = look(x)?;
        if late.abs() < CLOSE {
            break;
        }
        if late > 0.0 {
            (low, late_low) = (x, late);
        } else {
            (high, late_high) = (x, late);
        }
    }
    best.filter(|(off, _)| *off <= EQUAL_TIME).map(|(_, trip)| trip)
}
