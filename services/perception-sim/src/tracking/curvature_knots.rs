//! The curvature of the road ahead: a function of the way, linear between knots that stand on the road.
//!
//! Knots are [`APART_M`] apart. The first one is behind the ego or beside it, `passed_m` back; beyond the last one the
//! curvature is constant. A clothoid, whose curvature is linear, is contained. A road that bends and straightens again
//! within the radar's range is not one clothoid. It is near to such a function.
//!
//! θ is the heading at the ego, and κ are the curvatures of the knots. Everything is linear in them to first order:
//! curvature and heading at the arc length σ, and the place across the road there. Each function here gives the weights
//! of [θ, κ...] in one of them. With hats φ (1 at one knot, 0 at the others) and p for `passed_m`
//!
//! ```text
//! curvature   Σ κ φ(p + σ)
//! heading     θ + Σ κ ∫ φ             from p to p + σ
//! place       θ σ + Σ κ ∬ φ           likewise
//! ```

/// Knots.
pub const KNOTS: usize = 8;
/// Distance between two of them, m.
pub const APART_M: f64 = 25.0;
/// Heading and curvatures.
pub const STATES: usize = KNOTS + 1;

/// Weights in the curvature at σ.
#[must_use]
pub fn curvature(sigma_m: f64, passed_m: f64) -> [f64; STATES] {
    let (index, share) = between_knots(sigma_m, passed_m);
    let mut weights = [0.0; STATES];
    weights[1 + index] = 1.0 - share;
    weights[2 + index] = share;
    weights
}

/// The curvature of a state at σ.
#[must_use]
pub fn curvature_of(state: &[f64; STATES], sigma_m: f64, passed_m: f64) -> f64 {
    let (index, share) = between_knots(sigma_m, passed_m);
    (1.0 - share) * state[1 + index] + share * state[2 + index]
}

/// The knot before σ, and the share of the next one.
fn between_knots(sigma_m: f64, passed_m: f64) -> (usize, f64) {
    let place = ((sigma_m + passed_m) / APART_M).clamp(0.0, (KNOTS - 1) as f64);
    let index = (place as usize).min(KNOTS - 2);
    (index, place - index as f64)
}

/// Weights in the heading at σ.
#[must_use]
pub fn heading(sigma_m: f64, passed_m: f64) -> [f64; STATES] {
    let mut weights = between(passed_m, passed_m + sigma_m, |ramp_m| 0.5 * ramp_m * ramp_m);
    weights[0] = 1.0;
    weights
}

/// Weights in the place across the road at σ.
#[must_use]
pub fn place(sigma_m: f64, passed_m: f64) -> [f64; STATES] {
    let cube = |ramp_m: f64| ramp_m * ramp_m * ramp_m / 6.0;
    let mut weights = between(passed_m, passed_m + sigma_m, cube);
    // The double integral begins at the ego: what the first one has gathered before it does not count.
    let behind = between(-APART_M, passed_m, |ramp_m| 0.5 * ramp_m * ramp_m);
    for (weight, behind) in weights.iter_mut().zip(behind) {
        *weight -= behind * sigma_m;
    }
    weights[0] = sigma_m;
    weights
}

/// Differences of an integral of each hat. A hat is a sum of ramps, of which `integral` is that integral.
fn between(from_m: f64, to_m: f64, integral: impl Fn(f64) -> f64) -> [f64; STATES] {
    let ramp = |knot: usize| {
        let begins_m = (knot as f64 - 1.0) * APART_M;
        integral((to_m - begins_m).max(0.0)) - integral((from_m - begins_m).max(0.0))
    };
    let ramps: [f64; KNOTS + 1] = std::array::from_fn(ramp);
    let mut weights = [0.0; STATES];
    for knot in 0..KNOTS {
        let falls = if knot + 1 < KNOTS { ramps[knot + 1] - ramps[knot + 2] } else { 0.0 };
        weights[1 + knot] = (ramps[knot] - ramps[knot + 1] - falls) / APART_M;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(weights: &[f64; STATES], state: &[f64; STATES]) -> f64 {
        weights.iter().zip(state).map(|(weight, value)| weight * value).sum()
    }

    /// Heading and place are the integrals of the curvature, by small steps.
    #[test]
    fn the_weights_are_those_of_the_integrals() {
        let state = [0.02, 1e-3, -2e-3, 4e-3, 0.0, 1e-3, 3e-3, -1e-3, 2e-3];
        for passed_m in [0.0, 7.3, 24.9] {
            let (mut turned, mut across, step_m) = (state[0], 0.0, 0.01);
            for k in 0..16_000 {
                let sigma_m = f64::from(k) * step_m;
                if k % 1000 == 0 {
                    let there = dot(&heading(sigma_m, passed_m), &state);
                    assert!((there - turned).abs() < 1e-5, "{passed_m} {sigma_m}");
                    let there = dot(&place(sigma_m, passed_m), &state);
                    assert!((there - across).abs() < 1e-3, "{passed_m} {sigma_m}");
                }
                let bend = dot(&curvature(sigma_m + 0.5 * step_m, passed_m), &state);
                across += step_m * (turned + 0.5 * bend * step_m);
                turned += bend * step_m;
            }
        }
    }

    #[test]
    fn a_clothoid_is_contained() {
        let mut state = [0.01; STATES];
        (0..KNOTS).for_each(|knot| state[1 + knot] = 1e-3 + 1e-5 * APART_M * knot as f64);
        let sigma_m: f64 = 120.0;
        let expected = 0.01 * sigma_m + 1e-3 * sigma_m.powi(2) / 2.0 + 1e-5 * sigma_m.powi(3) / 6.0;
        assert!((dot(&place(sigma_m, 0.0), &state) - expected).abs() < 1e-9);
    }

    #[test]
    fn a_curvature_is_linear_between_knots_and_constant_beyond_them() {
        let state = [0.0, 1.0, 3.0, 4.0, 4.0, 5.0, 5.0, 6.0, 9.0];
        for (sigma_m, passed_m, expected) in [
            (0.0, 0.0, 1.0),
            (5.0, 0.0, 1.4),
            (5.0, 20.0, 3.0),
            (5.0, 22.5, 3.1),
            (170.0, 0.0, 8.4),
            (175.0, 0.0, 9.0),
            (400.0, 0.0, 9.0),
            (-30.0, 10.0, 1.0),
        ] {
            let found = curvature_of(&state, sigma_m, passed_m);
            assert!((found - expected).abs() < 1e-12, "{sigma_m} {passed_m}: {found}");
            let by_weights = dot(&curvature(sigma_m, passed_m), &state);
            assert!((by_weights - expected).abs() < 1e-12, "{sigma_m} {passed_m}: {by_weights}");
        }
    }
}
