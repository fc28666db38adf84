//! Kalman filter behind a track.
//!
//! State x = [d, w, a]: gap, relative speed (lead minus ego) and the lead's acceleration. The ego's
//! acceleration u is known. With Singer's model of the lead (acceleration of standard deviation sigma
//! and correlation time tau), r = e^(-T/tau):
//!
//! ```text
//! d+ = d + w T + (a - u) T²/2      w+ = w + (a - u) T      a+ = r a
//! P+ = F P F' + sigma² (1 - r²) b b',   b = [T²/2, T, 1]'
//! ```
//!
//! Range and range rate are measured, and taken in one after the other; a measurement farther off
//! than `gate` standard deviations of its prediction is not used.
//!
//! | symbol | key of `[perception.tracker]`, `[perception.radar]` | unit |
//! |---|---|---|
//! | sigma, tau | `lead_acceleration_sigma_mps2`, `maneuver_time_constant_s` | m/s², s |
//! | gate | `gate_sigma` | - |
//! | deviations of the measurements | `range_sigma_m`, `range_rate_sigma_mps` | m, m/s |
//!
//! Source: the radar filter of Li et al.'s predictive cruise control.

use std::array::from_fn;

use scenario::perception::{Perception, Radar, Tracker};

/// Smallest standard deviation that the filter believes of a measurement, in its unit: with less,
/// rounding would decide.
const LEAST_SIGMA: f64 = 1e-3;

/// The parameters of all filters.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    sigma_mps2: f64,
    tau_s: f64,
    gate: f64,
    range_variance: f64,
    range_rate_variance: f64,
}

/// One filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Gap, m.
    pub gap_m: f64,
    /// Lead speed minus ego speed, m/s.
    pub relative_speed_mps: f64,
    /// Acceleration of the lead, m/s².
    pub acceleration_mps2: f64,
    /// Covariance in the order gap, relative speed, acceleration; symmetric.
    pub covariance: [[f64; 3]; 3],
}

impl Model {
    /// The model of a scenario.
    #[must_use]
    pub fn new(perception: &Perception) -> Self {
        let Tracker { lead_acceleration_sigma_mps2, maneuver_time_constant_s, gate_sigma, .. } =
            perception.tracker;
        let Radar { range_sigma_m, range_rate_sigma_mps, .. } = perception.radar;
        let variance = |sigma: f64| {
            let sigma = sigma.max(LEAST_SIGMA);
            sigma * sigma
        };
        Self {
            sigma_mps2: lead_acceleration_sigma_mps2.value(),
            tau_s: maneuver_time_constant_s.value(),
            gate: gate_sigma.value(),
            range_variance: variance(range_sigma_m.value()),
            range_rate_variance: variance(range_rate_sigma_mps.value()),
        }
    }

    /// A filter that starts with one measurement.
    #[must_use]
    pub fn start(&self, gap_m: f64, range_rate_mps: f64) -> Estimate {
        let mut covariance = [[0.0; 3]; 3];
        covariance[0][0] = self.range_variance;
        covariance[1][1] = self.range_rate_variance;
        covariance[2][2] = self.sigma_mps2 * self.sigma_mps2;
        Estimate { gap_m, relative_speed_mps: range_rate_mps, acceleration_mps2: 0.0, covariance }
    }

    /// Moves the estimate on by `dt_s` with the ego's acceleration over that time.
    pub fn predict(&self, estimate: &mut Estimate, dt_s: f64, ego_acceleration_mps2: f64) {
        let r = libm::exp(-dt_s / self.tau_s);
        let half = 0.5 * dt_s * dt_s;
        let a = estimate.acceleration_mps2 - ego_acceleration_mps2;
        estimate.gap_m += estimate.relative_speed_mps * dt_s + a * half;
        estimate.relative_speed_mps += a * dt_s;
        estimate.acceleration_mps2 *= r;

        let f = [[1.0, dt_s, half], [0.0, 1.0, dt_s], [0.0, 0.0, r]];
        let b = [half, dt_s, 1.0];
        let q = self.sigma_mps2 * self.sigma_mps2 * (1.0 - r * r);
        let p = estimate.covariance;
        let mut moved = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in i..3 {
                let mut sum = q * b[i] * b[j];
                for k in 0..3 {
                    for l in 0..3 {
                        sum += f[i][k] * p[k][l] * f[j][l];
                    }
                }
                moved[i][j] = sum;
                moved[j][i] = sum;
            }
        }
        estimate.covariance = moved;
    }

    /// Takes in a measurement. Returns whether any of it passed the gate.
    pub fn update(&self, estimate: &mut Estimate, gap_m: f64, range_rate_mps: f64) -> bool {
        let range = self.take_in(estimate, 0, gap_m, self.range_variance);
        let rate = self.take_in(estimate, 1, range_rate_mps, self.range_rate_variance);
        range || rate
    }

    /// Takes in a measurement of the state's element `m`.
    fn take_in(&self, estimate: &mut Estimate, m: usize, measured: f64, variance: f64) -> bool {
        let p = estimate.covariance;
        let predicted = if m == 0 { estimate.gap_m } else { estimate.relative_speed_mps };
        let innovation = measured - predicted;
        let spread = p[m][m] + variance;
        // Written so that a measurement that is not a number does not pass.
        let passes = innovation * innovation <= self.gate * self.gate * spread;
        if !passes {
            return false;
        }
        let gain = [p[0][m] / spread, p[1][m] / spread, p[2][m] / spread];
        estimate.gap_m += gain[0] * innovation;
        estimate.relative_speed_mps += gain[1] * innovation;
        estimate.acceleration_mps2 += gain[2] * innovation;
        // Each pair of elements from the same expression, so that the matrix stays symmetric.
        estimate.covariance = from_fn(|i| {
            from_fn(|j| {
                let (row, column) = (i.min(j), i.max(j));
                p[row][column] - gain[row] * p[m][column]
            })
        });
        true
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand_core::{Rng, SeedableRng};
    use rand_pcg::Pcg64;
    use scenario::quantity::Sigma;

    use super::*;

    fn model() -> Model {
        Model::new(&Perception::default())
    }

    fn gaussian(random: &mut Pcg64) -> f64 {
        // The sum of twelve uniform numbers has variance 1.
        (0..12).map(|_| (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64).sum::<f64>() - 6.0
    }

    /// Root mean square errors of gap, speed and acceleration over 2000 s, and the filter's own
    /// standard deviations at the end. `lead` gives the jump of the lead's acceleration at a time,
    /// from its present one and a standard normal number; the ego follows.
    fn errors(dt_s: f64, lead: impl Fn(f64, f64, f64) -> f64) -> ([f64; 3], [f64; 3]) {
        let model = model();
        let mut random = Pcg64::seed_from_u64(7);
        let (mut gap, mut v, mut vl, mut al) = (50.0, 20.0, 20.0, 0.0);
        let mut estimate = model.start(gap, 0.0);
        let (mut squares, mut count) = ([0.0; 3], 0.0);
        let steps = (2000.0 / dt_s) as usize;
        for k in 0..steps {
            let ego = (0.2 * (gap - 1.5 * v - 20.0) + 0.8 * (vl - v)).clamp(-3.0, 2.0);
            let jump = lead(k as f64 * dt_s, al, gaussian(&mut random));
            let mean = al + jump;
            gap += (vl - v) * dt_s + 0.5 * (mean - ego) * dt_s * dt_s;
            vl += mean * dt_s;
            v += ego * dt_s;
            al += jump;
            model.predict(&mut estimate, dt_s, ego);
            let range = gap + 0.4 * gaussian(&mut random);
            let rate = vl - v + 0.15 * gaussian(&mut random);
            model.update(&mut estimate, range, rate);
            if k > steps / 20 {
                let truth = [gap, vl - v, al];
                let ours =
                    [estimate.gap_m, estimate.relative_speed_mps, estimate.acceleration_mps2];
                for i in 0..3 {
                    squares[i] += (ours[i] - truth[i]) * (ours[i] - truth[i]);
                }
                count += 1.0;
            }
        }
        let own = [0, 1, 2].map(|i| estimate.covariance[i][i].sqrt());
        (squares.map(|sum: f64| (sum / count).sqrt()), own)
    }

    /// A lead on a motorway: steady, a slow braking, steady, a slow recovery.
    fn motorway(time_s: f64, acceleration: f64, _: f64) -> f64 {
        let wanted = match time_s % 60.0 {
            t if (25.0..30.0).contains(&t) => -0.6,
            t if (40.0..50.0).contains(&t) => 0.3,
            _ => 0.0,
        };
        wanted - acceleration
    }

    #[test]
    fn a_constant_target_is_found() {
        let model = model();
        let mut estimate = model.start(49.0, -3.0);
        let mut gap = 50.0;
        for _ in 0..2000 {
            model.predict(&mut estimate, 0.05, 0.0);
            gap -= 2.0 * 0.05;
            model.update(&mut estimate, gap, -2.0);
        }
        assert!((estimate.gap_m - gap).abs() < 1e-3);
        assert!((estimate.relative_speed_mps + 2.0).abs() < 1e-3);
        assert!(estimate.acceleration_mps2.abs() < 1e-3);
    }

    #[test]
    fn the_egos_own_acceleration_is_not_taken_for_the_leads() {
        let model = model();
        let (mut gap, mut rate) = (50.0, 0.0);
        let mut estimate = model.start(gap, rate);
        for _ in 0..100 {
            model.predict(&mut estimate, 0.05, -2.0);
            gap += rate * 0.05 + 0.5 * 2.0 * 0.05 * 0.05;
            rate += 2.0 * 0.05;
            model.update(&mut estimate, gap, rate);
        }
        assert!(estimate.acceleration_mps2.abs() < 1e-9);
    }

    #[test]
    fn the_gate_keeps_outliers_out_and_lets_the_rest_in() {
        let model = model();
        let mut estimate = model.start(50.0, 0.0);
        for _ in 0..100 {
            model.predict(&mut estimate, 0.05, 0.0);
            model.update(&mut estimate, 50.0, 0.0);
        }
        let before = estimate;
        assert!(!model.update(&mut estimate, 60.0, 4.0));
        assert!(!model.update(&mut estimate, f64::NAN, f64::INFINITY));
        assert_eq!(estimate, before);
        assert!(model.update(&mut estimate, 60.0, 0.1));
        assert!(estimate.relative_speed_mps > 0.0);
        assert!((estimate.gap_m - 50.0).abs() < 0.1);
    }

    #[test]
    fn a_radar_without_noise_does_not_break_the_filter() {
        let mut perception = Perception::default();
        perception.radar.range_sigma_m = Sigma::of(0.0);
        perception.radar.range_rate_sigma_mps = Sigma::of(0.0);
        perception.tracker.lead_acceleration_sigma_mps2 = Sigma::of(0.0);
        let model = Model::new(&perception);
        let mut estimate = model.start(50.0, 1.0);
        for k in 1..10_000 {
            model.predict(&mut estimate, 0.05, 0.0);
            model.update(&mut estimate, 50.0 + 0.05 * f64::from(k), 1.0);
        }
        assert!((estimate.gap_m - 50.0 - 0.05 * 9999.0).abs() < 1e-3);
    }

    #[test]
    fn the_errors_are_the_published_ones() {
        // The source gives 0.075 m, 0.081 m/s and 0.19 m/s² from raw 0.39 m and 0.15 m/s.
        let (errors, _) = errors(0.1, motorway);
        for (ours, published) in errors.into_iter().zip([0.075, 0.081, 0.19]) {
            assert!(ours <= published, "{errors:?}");
        }
        assert!(errors[0] > 0.05 && errors[1] > 0.05 && errors[2] > 0.1, "{errors:?}");
    }

    #[test]
    fn behind_the_lead_of_its_own_model_the_filter_errs_as_much_as_it_says() {
        for dt_s in [0.05, 0.1] {
            let r = libm::exp(-dt_s / 2.5);
            let deviation = 0.5 * (1.0 - r * r).sqrt();
            let (errors, own) = errors(dt_s, |_, a, normal| (r - 1.0) * a + deviation * normal);
            for (error, own) in errors.into_iter().zip(own) {
                assert!((error / own - 1.0).abs() < 0.1, "{error} against {own}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_covariance_stays_one(
            scans in prop::collection::vec((0.001..2.0f64, -3.0..3.0f64, any::<bool>()), 1..200),
        ) {
            let model = model();
            let mut estimate = model.start(50.0, 0.0);
            for (dt_s, offset, seen) in scans {
                model.predict(&mut estimate, dt_s, 0.0);
                if seen {
                    let (gap, rate) = (estimate.gap_m + offset, estimate.relative_speed_mps);
                    model.update(&mut estimate, gap, rate);
                }
                let p = estimate.covariance;
                for i in 0..3 {
                    prop_assert!(p[i][i] >= 0.0);
                    for j in 0..3 {
                        prop_assert_eq!(p[i][j], p[j][i]);
                        prop_assert!(p[i][j] * p[i][j] <= p[i][i] * p[j][j] * (1.0 + 1e-9) + 1e-12);
                    }
                }
            }
        }
    }
}
