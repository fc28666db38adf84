//! Speeds that follow a profile, as pieces of constant jerk.
//!
//! An entry changes the speed by Δ. Without smoothing this is a straight line over the entry's time T. With it the
//! acceleration rises at the rate J to a, stays there, and falls to 0 at the rate J, so that
//!
//! ```text
//! T = Δ/a + a/J,  a = 2 Δ / (T + √(T² - 4 Δ/J)),  a ≤ A,  a ≤ √(Δ J)
//! ```
//!
//! If A or J does not allow T, the entry takes the shortest time that they allow, and those after it come later.

use serde::{Deserialize, Serialize};

use crate::model::timed::{Bounds, SpeedEntry, SpeedProfile};
use crate::world::shape::{MAX_SPEED_MPS, SHORTEST_S, seconds};

/// A change of the speed that counts as none, m/s.
const SMALLEST_MPS: f64 = 1e-9;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Profile {
    start_ns: u64,
    pub relative_to: Option<usize>,
    /// In order of time. The last one has no end.
    pieces: Vec<Piece>,
}

/// A part with constant jerk.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Piece {
    /// Its beginning, s since the start of the profile.
    at_s: f64,
    /// Distance covered before it, m.
    way_m: f64,
    mps: f64,
    mps2: f64,
    mps3: f64,
}

impl Profile {
    pub(super) fn of(profile: &SpeedProfile, from_mps: f64, start_ns: u64) -> Self {
        let is_relative = profile.relative_to.is_some();
        let most_mps = profile.bounds.speed_mps.min(MAX_SPEED_MPS);
        let within = |mps: f64| mps.clamp(if is_relative { -most_mps } else { 0.0 }, most_mps);
        let mut pieces = Pieces { end_s: 0.0, way_m: 0.0, mps: from_mps, list: Vec::new() };
        for SpeedEntry { mps, time_s } in &profile.entries {
            match profile.smooth {
                true => pieces.smooth(within(*mps), *time_s, &profile.bounds),
                false => pieces.straight(within(*mps), *time_s, &profile.bounds),
            }
        }
        pieces.push(f64::INFINITY, 0.0, 0.0);
        Self { start_ns, relative_to: profile.relative_to, pieces: pieces.list }
    }

    /// The time since its start, s, and the piece at that time.
    fn at(&self, time_ns: u64) -> (f64, &Piece) {
        let at_s = seconds(time_ns.saturating_sub(self.start_ns));
        let after = self.pieces.partition_point(|piece| piece.at_s <= at_s);
        let piece = &self.pieces[after.max(1) - 1];
        (at_s - piece.at_s, piece)
    }

    pub(super) fn is_over(&self, time_ns: u64) -> bool {
        let last = &self.pieces[self.pieces.len() - 1];
        seconds(time_ns.saturating_sub(self.start_ns)) >= last.at_s
    }

    pub(super) fn speed(&self, time_ns: u64) -> f64 {
        let (t, piece) = self.at(time_ns);
        piece.mps + t * (piece.mps2 + 0.5 * t * piece.mps3)
    }

    pub(super) fn acceleration(&self, time_ns: u64) -> f64 {
        let (t, piece) = self.at(time_ns);
        piece.mps2 + t * piece.mps3
    }

    /// Distance covered between two times, m.
    pub(super) fn way(&self, from_ns: u64, to_ns: u64) -> f64 {
        let until = |time_ns: u64| {
            let (t, piece) = self.at(time_ns);
            piece.way_m + piece.way(t)
        };
        until(to_ns) - until(from_ns)
    }
}

impl Piece {
    fn way(&self, t: f64) -> f64 {
        t * (self.mps + 0.5 * t * (self.mps2 + t * self.mps3 / 3.0))
    }
}

/// Pieces that are laid one after the other.
struct Pieces {
    end_s: f64,
    way_m: f64,
    mps: f64,
    list: Vec<Piece>,
}

impl Pieces {
    /// Adds a piece from the present speed on.
    fn push(&mut self, duration_s: f64, mps2: f64, mps3: f64) {
        if !(duration_s >= SHORTEST_S) {
            return;
        }
        let piece = Piece { at_s: self.end_s, way_m: self.way_m, mps: self.mps, mps2, mps3 };
        self.end_s += duration_s;
        self.way_m += piece.way(duration_s);
        self.mps += duration_s * (mps2 + 0.5 * duration_s * mps3);
        self.list.push(piece);
    }

    /// Reaches a speed on a straight line, or at once.
    fn straight(&mut self, to_mps: f64, time_s: Option<f64>, bounds: &Bounds) {
        let change = to_mps - self.mps;
        let most = match change > 0.0 {
            true => bounds.acceleration_mps2,
            false => bounds.deceleration_mps2,
        };
        let duration_s = time_s.unwrap_or(change.abs() / most);
        self.push(duration_s, change / duration_s, 0.0);
        self.mps = to_mps;
    }

    /// Reaches a speed without jumps of the acceleration where its rate has a bound.
    fn smooth(&mut self, to_mps: f64, time_s: Option<f64>, bounds: &Bounds) {
        let (change, sign) = ((to_mps - self.mps).abs(), (to_mps - self.mps).signum());
        if change < SMALLEST_MPS {
            self.push(time_s.unwrap_or(0.0), 0.0, 0.0);
            return;
        }
        let (most, rate) = match sign > 0.0 {
            true => (bounds.acceleration_mps2, bounds.acceleration_rate_mps3),
            false => (bounds.deceleration_mps2, bounds.deceleration_rate_mps3),
        };
        let in_time = time_s.map_or(f64::INFINITY, |time_s| {
            let root = time_s * time_s - 4.0 * change / rate;
            if root < 0.0 { f64::INFINITY } else { 2.0 * change / (time_s + libm::sqrt(root)) }
        });
        let peak = in_time.min(most).min(libm::sqrt(change * rate));
        if peak.is_finite() {
            let (rise_s, jerk) = match rate.is_finite() {
                true => (peak / rate, sign * rate),
                false => (0.0, 0.0),
            };
            self.push(rise_s, 0.0, jerk);
            self.push(change / peak - rise_s, sign * peak, 0.0);
            self.push(rise_s, sign * peak, -jerk);
        }
        self.mps = to_mps;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(mps: f64, time_s: Option<f64>) -> SpeedEntry {
        SpeedEntry { mps, time_s }
    }

    /// 1 m/s² and 2 m/s³ up, 4 m/s² and 8 m/s³ down.
    const BOUNDS: Bounds = Bounds {
        acceleration_mps2: 1.0,
        deceleration_mps2: 4.0,
        acceleration_rate_mps3: 2.0,
        deceleration_rate_mps3: 8.0,
        speed_mps: 30.0,
    };

    fn driven(smooth: bool, bounds: Bounds, entries: &[SpeedEntry]) -> Profile {
        let entries = entries.to_vec();
        Profile::of(&SpeedProfile { relative_to: None, smooth, bounds, entries }, 10.0, 0)
    }

    fn ns(time_s: f64) -> u64 {
        (time_s * 1e9).round() as u64
    }

    #[track_caller]
    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-8, "{a} instead of {b}");
    }

    #[test]
    fn straight_entries_are_reached_at_their_times() {
        let entries = [entry(20.0, Some(4.0)), entry(20.0, Some(1.0)), entry(8.0, None)];
        let profile = driven(false, BOUNDS, &entries);
        near(profile.speed(ns(2.0)), 15.0);
        near(profile.acceleration(ns(2.0)), 2.5);
        near(profile.way(0, ns(5.0)), 80.0);
        // 12 m/s at 4 m/s² take 3 s.
        near(profile.speed(ns(6.5)), 14.0);
        assert!(!profile.is_over(ns(7.99)) && profile.is_over(ns(8.0)));
        near(profile.way(ns(5.0), ns(9.0)), 0.5 * (20.0 + 8.0) * 3.0 + 8.0);
        let at_once = driven(false, Bounds::NONE, &[entry(3.0, None), entry(7.0, Some(2.0))]);
        near(at_once.speed(0), 3.0);
        near(at_once.way(0, ns(2.0)), 10.0);
    }

    #[test]
    fn a_smooth_entry_has_the_acceleration_that_its_time_asks_for() {
        // Δ = 3, T = 4.5, J = 2: a = 6 / (4.5 + √(20.25 - 6)) = 0.724..., T = Δ/a + a/J.
        let profile = driven(true, BOUNDS, &[entry(13.0, Some(4.5))]);
        let peak = 6.0 / (4.5 + 14.25_f64.sqrt());
        near(3.0 / peak + peak / 2.0, 4.5);
        near(profile.acceleration(ns(2.25)), peak);
        near(profile.acceleration(ns(0.1)), 0.2);
        near(profile.speed(ns(2.25)), 11.5);
        near(profile.speed(ns(4.5)), 13.0);
        // By symmetry the mean speed is the mean of both ends.
        near(profile.way(0, ns(4.5)), 11.5 * 4.5);
        assert!(profile.is_over(ns(4.5) + 10) && !profile.is_over(ns(4.499)));
    }

    #[test]
    fn bounds_come_before_times() {
        // 10 m/s at 4 m/s² and 8 m/s³: 10/4 + 4/8 = 3 s instead of 1 s. The next entry begins then.
        let limited = driven(true, BOUNDS, &[entry(-2.0, Some(1.0)), entry(0.0, Some(1.0))]);
        near(limited.acceleration(ns(1.0)), -4.0);
        near(limited.speed(ns(3.0)), 0.0);
        assert!(limited.is_over(ns(4.0) + 10) && !limited.is_over(ns(3.99)));
        // 0.25 m/s at 2 m/s³ never reach 1 m/s²: √(0.25 2), 2 √(0.25/2) s.
        let short = driven(true, BOUNDS, &[entry(10.25, None)]);
        near(short.acceleration(ns(0.125_f64.sqrt())), 0.5_f64.sqrt());
        near(short.speed(ns(0.5_f64.sqrt())), 10.25);
        // The largest speed bounds the targets.
        near(driven(true, BOUNDS, &[entry(50.0, None)]).speed(ns(60.0)), 30.0);
    }

    #[test]
    fn the_speed_is_the_derivative_of_the_way_through_all_pieces() {
        let entries = [
            entry(13.0, Some(4.5)),
            entry(5.0, None),
            entry(5.0, Some(0.5)),
            entry(6.0, Some(9.0)),
        ];
        for smooth in [false, true] {
            let profile = driven(smooth, BOUNDS, &entries);
            for step in 0..1800 {
                let (a, b) = (ns(f64::from(step) * 0.01), ns(f64::from(step + 1) * 0.01));
                let mean = profile.way(a, b) / 0.01;
                assert!((mean - 0.5 * (profile.speed(a) + profile.speed(b))).abs() < 2e-3);
                let slope = (profile.speed(b) - profile.speed(a)) / 0.01;
                assert!(slope.abs() < 4.0 + 1e-6 || !smooth, "{slope}");
            }
        }
    }

    #[test]
    fn extreme_bounds_and_times_stay_finite() {
        for value in [1e-320, 1e-9, 1e9, f64::INFINITY] {
            let bounds =
                Bounds { acceleration_mps2: value, deceleration_rate_mps3: value, ..Bounds::NONE };
            for time_s in [None, Some(0.0), Some(1e-320), Some(1e9)] {
                for smooth in [false, true] {
                    let entries = [entry(1e9, time_s), entry(0.0, time_s), entry(1e-320, time_s)];
                    let profile = driven(smooth, bounds, &entries);
                    for time_ns in [0, 1, ns(1.0), ns(300.0)] {
                        let figures = [
                            profile.speed(time_ns),
                            profile.acceleration(time_ns),
                            profile.way(0, time_ns),
                        ];
                        assert!(figures.iter().all(|it| it.is_finite()), "{value} {time_s:?}");
                    }
                }
            }
        }
    }
}
