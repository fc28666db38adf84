//! The filter of speeds: local linear regression that keeps stops.
//!
//! Each value becomes the value at its instant of the straight line that fits its neighbours best, with
//! Cleveland's tricube weights over ±`h` (W. S. Cleveland, "Robust locally weighted regression and smoothing
//! scatterplots", J. Am. Stat. Assoc. 74 (1979) 829–836, doi 10.1080/01621459.1979.10481038, equations 1 and 2
//! with degree 1, without the robustness steps):
//!
//! ```text
//! w(d) = (1 − |d/h|³)³ for |d| < h, else 0
//! ```
//!
//! Reasons for this filter: a constant acceleration passes unchanged. That holds at both ends of a record and with
//! uneven sampling, where a moving average bends it. It has no phase lag.
//!
//! A linear filter alone would let a vehicle creep where it stood. So a *stop* is found first. It consists of the
//! instants at which most samples within ±`h` are slower than 0.3 m/s. So the running median is below it there (an edge
//! passes a median unchanged). There the speed is zero. Each stretch of motion between two stops is filtered by itself.
//! Behind a stop it is continued by its own point reflection, `v(t₀ − τ) = −v(t₀ + τ)`. So it begins and ends at
//! exactly zero. A stop that is shorter than `h` is not kept.

use std::ops::Range;

/// Speed below which a sample counts as standing, m/s. Chosen: 1 km/h, a usual resolution of wheel-speed sensors
/// and of a receiver's noise at rest.
const STANDING_MPS: f64 = 1.0 / 3.6;

/// Smoothed speeds of samples at times `t`, and the stops among them. `t` increases.
pub fn smoothed(t: &[f64], v: &[f64], half_s: f64) -> (Vec<f64>, Vec<Range<usize>>) {
    let stops = stops(t, v, half_s);
    let mut smoothed = vec![0.0; v.len()];
    let mut begin = 0;
    for stop in stops.iter().cloned().chain(std::iter::once(v.len()..v.len())) {
        let moving = begin..stop.start;
        let before = begin.checked_sub(1).map(|last| t[last]);
        let after = t.get(stop.start).copied();
        for i in moving.clone() {
            let own = near(t, &moving, t[i] - half_s, t[i] + half_s).map(|j| (t[j], v[j]));
            let rest = [before, after].into_iter().flatten().flat_map(|at| {
                let (from, to) = (2.0 * at - t[i] - half_s, 2.0 * at - t[i] + half_s);
                let mirrored = near(t, &moving, from, to).map(move |j| (2.0 * at - t[j], -v[j]));
                mirrored.chain([(at, 0.0)])
            });
            smoothed[i] = line(t[i], half_s, own.chain(rest)).0.max(0.0);
        }
        begin = stop.end;
    }
    (smoothed, stops)
}

/// Slopes of the local lines through samples at times `t`, per second.
pub(crate) fn slopes(t: &[f64], values: &[f64], half_s: f64) -> Vec<f64> {
    let all = 0..t.len();
    let slope = |i: usize| {
        let near = near(t, &all, t[i] - half_s, t[i] + half_s);
        line(t[i], half_s, near.map(|j| (t[j], values[j]))).1
    };
    (0..t.len()).map(slope).collect()
}

/// Indices within `of` of the times from `from` to `to`.
fn near(t: &[f64], of: &Range<usize>, from: f64, to: f64) -> Range<usize> {
    let within = &t[of.clone()];
    let begin = within.partition_point(|time| *time < from);
    let end = within.partition_point(|time| *time <= to);
    of.start + begin..of.start + end.max(begin)
}

/// Stretches of standing samples.
fn stops(t: &[f64], v: &[f64], half_s: f64) -> Vec<Range<usize>> {
    let mut slow_before = vec![0];
    for speed in v {
        slow_before.push(slow_before[slow_before.len() - 1] + usize::from(*speed < STANDING_MPS));
    }
    let all = 0..t.len();
    let mut stops: Vec<Range<usize>> = Vec::new();
    for i in all.clone() {
        let window = near(t, &all, t[i] - half_s, t[i] + half_s);
        let slow = slow_before[window.end] - slow_before[window.start];
        if 2 * slow > window.len() {
            match stops.last_mut().filter(|stop| stop.end == i) {
                Some(stop) => stop.end += 1,
                None => stops.push(i..i + 1),
            }
        }
    }
    stops
}

/// Value at `at` and slope of the weighted line through `samples`.
fn line(at: f64, half_s: f64, samples: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (mut s0, mut s1, mut s2, mut y0, mut y1) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (t, y) in samples {
        // In units of the window, so that the sums are of one size.
        let d = (t - at) / half_s;
        let part = 1.0 - d.abs().powi(3);
        if part > 0.0 {
            let w = part.powi(3);
            s0 += w;
            s1 += w * d;
            s2 += w * d * d;
            y0 += w * y;
            y1 += w * d * y;
        }
    }
    let determinant = s0 * s2 - s1 * s1;
    // One sample, or several at one place: their mean.
    if determinant <= 1e-9 * s0 * s0 {
        return (y0 / s0, 0.0);
    }
    ((s2 * y0 - s1 * y1) / determinant, (s0 * y1 - s1 * y0) / determinant / half_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stands for 5 s, drives off at 2 m/s², stops again at 3 m/s² and stands.
    fn drive(time_s: f64) -> f64 {
        let off = 2.0 * (time_s - 5.0);
        off.min(16.0).min(3.0 * (20.0 - time_s)).max(0.0)
    }

    fn times() -> Vec<f64> {
        (0..300).map(|k| 0.1 * f64::from(k)).collect()
    }

    #[test]
    fn a_constant_acceleration_passes_unchanged_also_at_the_ends() {
        let t: Vec<f64> = (0..60).map(|k| f64::from(k) * 0.1 + 0.03 * f64::from(k % 3)).collect();
        let v: Vec<f64> = t.iter().map(|t| 3.0 + 1.5 * t).collect();
        let (smoothed, stops) = smoothed(&t, &v, 1.0);
        assert!(stops.is_empty());
        for (a, b) in smoothed.iter().zip(&v) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        assert!(slopes(&t, &v, 1.0).iter().all(|slope| (slope - 1.5).abs() < 1e-9));
    }

    #[test]
    fn stops_stay_at_zero_and_noise_goes() {
        let t = times();
        let mut state = 1_u64;
        let mut noise = || {
            // The sum of twelve uniform deviates less six: a standard normal deviate.
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
            }
            0.25 * sum
        };
        let v: Vec<f64> = t.iter().map(|t| (drive(*t) + noise()).max(0.0)).collect();
        let (smoothed, stops) = smoothed(&t, &v, 1.0);
        assert_eq!(stops.len(), 2, "{stops:?}");
        let steepest = |v: &[f64]| {
            v.windows(2).map(|pair| (pair[1] - pair[0]).abs() / 0.1).fold(0.0, f64::max)
        };
        assert!(steepest(&v) > 6.0, "{}", steepest(&v));
        assert!(steepest(&smoothed) < 4.5, "{}", steepest(&smoothed));
        for (time_s, speed) in t.iter().zip(&smoothed) {
            // It stands up to a sample or two at the edges.
            if !(4.7..20.3).contains(time_s) {
                assert_eq!(*speed, 0.0, "at {time_s} s");
            }
            assert!((speed - drive(*time_s)).abs() < 0.6, "{speed} at {time_s} s");
        }
        let driven = |v: &[f64]| 0.1 * v.iter().sum::<f64>();
        let truth: f64 = 0.1 * t.iter().map(|t| drive(*t)).sum::<f64>();
        assert!((driven(&smoothed) - truth).abs() < 0.01 * truth, "{} m", driven(&smoothed));
    }

    #[test]
    fn a_window_without_neighbours_changes_nothing() {
        let (t, v) = ([0.0, 5.0, 10.0], [4.0, 7.0, 5.0]);
        assert_eq!(smoothed(&t, &v, 1.0).0, v);
    }
}
