//! Trips at equal time: fuel is only compared between those.

use super::Trip;

/// Largest difference of trip times that counts as none.
pub const EQUAL_TIME: f64 = 1e-3;
/// Difference that is good enough to stop looking.
const CLOSE: f64 = 1e-4;
/// Trips at most.
const ATTEMPTS: usize = 20;
/// How often the range is moved on when the trip is not in it.
const WIDENINGS: usize = 3;
/// Trips nearby when the one that is wanted was jumped over, and how far apart, as a share of the range.
const NEARBY: u32 = 16;
const NEAR: f64 = 0.01;

/// The trip whose time is nearest to `time_s`, within [`EQUAL_TIME`]; `trip(x)` is faster for a larger
/// x, at least on the whole. It is looked for between the bounds first, then beyond. `None` when no such trip was found.
pub fn at_equal_time(
    time_s: f64,
    (mut low, mut high): (f64, f64),
    mut trip: impl FnMut(f64) -> Option<Trip>,
) -> Option<Trip> {
    let mut best: Option<(f64, f64, Trip)> = None;
    let mut look = |x: f64| {
        let found = trip(x)?;
        let late = found.time_s / time_s - 1.0;
        if best.as_ref().is_none_or(|(off, ..)| late.abs() < *off) {
            best = Some((late.abs(), x, found));
        }
        Some(late)
    };
    let span = high - low;
    let (mut late_low, mut late_high) = (look(low)?, look(high)?);
    for _ in 0..WIDENINGS {
        if late_high > 0.0 {
            (low, late_low) = (high, late_high);
            high += span;
            late_high = look(high)?;
        } else if late_low < 0.0 {
            (high, late_high) = (low, late_low);
            low -= span;
            late_low = look(low)?;
        }
    }
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
    // Trip time jumped over the one that is wanted: another decision somewhere. Nearby there are others.
    let (mut off, x) = best.as_ref().map(|(off, x, _)| (*off, *x))?;
    for step in 1..=NEARBY {
        if off <= EQUAL_TIME {
            break;
        }
        let side = if step % 2 == 0 { 1.0 } else { -1.0 };
        let found = trip(x + side * span * NEAR * f64::from(step.div_ceil(2)))?;
        off = (found.time_s / time_s - 1.0).abs();
        if off <= EQUAL_TIME {
            best = Some((off, x, found));
        }
    }
    best.filter(|(off, ..)| *off <= EQUAL_TIME).map(|(.., trip)| trip)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trip(time_s: f64) -> Trip {
        Trip {
            length_m: 1.0,
            time_s,
            fuel_g: 0.0,
            gained_j: 0.0,
            service_brake_j: 0.0,
            engine_brake_j: 0.0,
            shifts: 0,
            speed_range_mps: (1.0, 1.0),
            samples: Vec::new(),
        }
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
