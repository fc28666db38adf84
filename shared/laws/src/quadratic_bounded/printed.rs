//! The controller as the paper prints it (section 2.3, after equation (5)):
//!
//! ```text
//! u(k) = Du(k) + u(k-1),  u(0) = 0
//! Du(k) = 1e-3 [0.2796 0.109 -0.0024 -0.1405] xc(k) + [0.2545 0.7617 -0.324 -0.7822] y(k)
//! ```
//!
//! The dynamics of xc (Ac, L) are lost, so its term is left out. Its gains are a thousandth of the others. With an xc
//! of the size of y it adds some thousandths of a m/s². The coordinates of xc are lost too, so this is not a proof.
//! Lost as well are the bounds, the desired gap, the sample time and the Lyapunov matrix. The [`Design`](super::Design)
//! gives the desired gap, the sample time, and the clamps of request and increment. u(0) is the measured acceleration.
//! It is the paper's 0 if a drive begins without one. So a process that is restarted while the car brakes goes on
//! braking.
//!
//! The gap error is cut off at `gap_error_limit_m` here too. Without that the car that cuts in 150 m ahead is
//! braked for 5.8 s late. The factor 1e-3 belongs to the first bracket alone: with it before both, the gap
//! overshoots by 40 m.

use super::model::{Parameters, State};

/// Gains on y = [Dd, Dv, a, u(k-1)], per m, s/m, 1, 1.
const OUTPUT_GAINS: [f64; 4] = [0.2545, 0.7617, -0.324, -0.7822];
/// Deceleration beyond which the fall-back takes over, m/s²: its own comfortable one.
const COMFORT_MPS2: f64 = 2.0;

/// Du(k), m/s².
pub(super) fn increment(y: &State) -> f64 {
    y.iter().zip(OUTPUT_GAINS).map(|(y, gain)| gain * y).sum()
}

/// Constant deceleration that removes the closing speed before the gap at standstill is reached, as a share of the
/// comfortable one. It stands where a certified design has V: above 1 the fall-back drives.
pub(super) fn urgency(p: &Parameters, gap_m: f64, relative_mps: f64) -> f64 {
    let closing_mps = (-relative_mps).max(0.0);
    let room_m = (gap_m - p.gap_constant_m).max(1e-3);
    closing_mps * closing_mps / (2.0 * room_m) / COMFORT_MPS2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_increment_is_the_printed_sum() {
        let y = State::new(1.0, 10.0, 100.0, 1000.0);
        assert!((increment(&y) - (0.2545 + 7.617 - 32.4 - 782.2)).abs() < 1e-9);
    }

    /// At 110 km/h behind 90 the lead asks for less from a gap error of 16.6 m on.
    #[test]
    fn following_starts_where_gap_and_speed_error_cancel() {
        let at = |error_m| increment(&State::new(error_m, -20.0 / 3.6, 0.0, 0.0));
        assert!(at(16.7) > 0.0 && at(16.6) < 0.0);
    }

    #[test]
    fn urgency_counts_closing_alone() {
        let p = Parameters::default();
        assert_eq!(urgency(&p, 20.0, 3.0), 0.0);
        assert!((urgency(&p, 55.0, -10.0) - 0.5).abs() < 1e-12);
        assert!(urgency(&p, 1.0, -1.0) > 100.0);
    }
}
