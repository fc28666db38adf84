//! A lead whose speed is a sine, and the amplitude with which a car follows it.
//!
//! The lead drives `v(t) = c - A cos(2 pi f t)`, small enough that no bound of law or vehicle is met.
//! After a time in which the start is forgotten, both speeds are fitted by least squares,
//!
//! ```text
//! v(t) ~ m + p cos(2 pi f t) + q sin(2 pi f t),     amplitude = sqrt(p² + q²)
//! ```
//!
//! over whole periods. The fit asks for no sampling in step with the sine.

use std::f64::consts::TAU;

use group::Drive;
use scenario::Scenario;

use super::measure::samples;

/// Largest amplitude of the speed, m/s.
const MAX_AMPLITUDE_MPS: f64 = 1.0;
/// Largest acceleration of the lead, m/s²: below every law's bound of comfort.
const MAX_ACCELERATION_MPS2: f64 = 0.5;
/// Time in which a law forgets the start, s.
const SETTLE_S: f64 = 60.0;
/// The same that each car adds, since the start travels along the string, s.
const SETTLE_EACH_S: f64 = 5.0;
/// Least time that is measured, s.
const LEAST_MEASURED_S: f64 = 40.0;
/// Slowest set speed at which a wave can be driven, m/s.
const SLOWEST_MPS: f64 = 5.0;

/// The set speed or the limit leaves no room for a wave.
#[derive(Debug, thiserror::Error)]
#[error(
    "a lead that swings needs room below the set speed of {top_mps} m/s, expected at least \
     {SLOWEST_MPS} m/s"
)]
pub struct TooSlow {
    top_mps: f64,
}

/// A sine of the lead's speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    hz: f64,
    centre_mps: f64,
    settle_s: f64,
}

impl Wave {
    /// Around the scenario's speed, as far as the set speed leaves room on both sides; before a string of
    /// this many vehicles.
    ///
    /// # Errors
    /// [`TooSlow`].
    pub fn of(scenario: &Scenario, vehicles: usize, hz: f64) -> Result<Self, TooSlow> {
        let set_mps = scenario.set_speed_mps.value();
        let top_mps = scenario.speed_limit_mps.map_or(set_mps, |limit| set_mps.min(limit.value()));
        if top_mps < SLOWEST_MPS {
            return Err(TooSlow { top_mps });
        }
        let initial_mps = scenario.plant.initial_speed_mps.value();
        let centre_mps = initial_mps.clamp(0.4 * top_mps, 0.8 * top_mps);
        let settle_s = SETTLE_S + SETTLE_EACH_S * (vehicles - 1) as f64;
        Ok(Self { hz, centre_mps, settle_s })
    }

    fn amplitude_mps(&self) -> f64 {
        MAX_AMPLITUDE_MPS.min(MAX_ACCELERATION_MPS2 / (TAU * self.hz))
    }

    /// Amplitude of the lead's acceleration, m/s².
    pub fn acceleration_mps2(&self) -> f64 {
        TAU * self.hz * self.amplitude_mps()
    }

    /// The lead's slowest speed, at which it begins, m/s.
    pub fn first_speed_mps(&self) -> f64 {
        self.centre_mps - self.amplitude_mps()
    }

    /// Length of the run, s.
    pub fn duration_s(&self) -> f64 {
        let periods = (LEAST_MEASURED_S * self.hz).ceil();
        self.settle_s + periods / self.hz
    }

    /// Amplitudes of the car's speed and of the speed of the vehicle ahead, m/s; none if the drive
    /// ended before.
    pub fn amplitudes(&self, drive: &Drive) -> Option<[f64; 2]> {
        let reached_s = drive.steps.last()?.time_s;
        if reached_s < self.duration_s() - 1.0 {
            return None;
        }
        let settled = samples(drive).filter(|sample| sample.time_s >= self.settle_s);
        let mut fit = Fit::default();
        for sample in settled {
            let angle = TAU * self.hz * sample.time_s;
            let deviations = [sample.speed_mps, sample.ahead_mps].map(|mps| mps - self.centre_mps);
            fit.add([1.0, libm::cos(angle), libm::sin(angle)], deviations);
        }
        fit.amplitudes()
    }
}

/// Normal equations of `[1, cos, sin]` for two signals.
#[derive(Clone, Copy, Debug, Default)]
struct Fit {
    matrix: [[f64; 3]; 3],
    right: [[f64; 2]; 3],
}

impl Fit {
    fn add(&mut self, basis: [f64; 3], values: [f64; 2]) {
        for (i, left) in basis.into_iter().enumerate() {
            for (j, other) in basis.into_iter().enumerate() {
                self.matrix[i][j] += left * other;
            }
            for (sum, value) in self.right[i].iter_mut().zip(values) {
                *sum += left * value;
            }
        }
    }

    /// By Gauss's elimination; the matrix is positive definite when three samples differ.
    fn amplitudes(mut self) -> Option<[f64; 2]> {
        for k in 0..3 {
            let pivot = self.matrix[k][k];
            if pivot.is_nan() || pivot <= 1e-9 {
                return None;
            }
            for row in k + 1..3 {
                let factor = self.matrix[row][k] / pivot;
                for column in k..3 {
                    self.matrix[row][column] -= factor * self.matrix[k][column];
                }
                for signal in 0..2 {
                    self.right[row][signal] -= factor * self.right[k][signal];
                }
            }
        }
        let solve = |signal: usize| {
            let q = self.right[2][signal] / self.matrix[2][2];
            let p = (self.right[1][signal] - self.matrix[1][2] * q) / self.matrix[1][1];
            libm::hypot(p, q)
        };
        Some([solve(0), solve(1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use group::DriveStep;

    #[test]
    fn amplitudes_are_found_beside_an_offset_and_out_of_step_with_the_samples() {
        let wave = Wave { hz: 0.0731, centre_mps: 20.0, settle_s: 60.0 };
        let step = |k: u32| {
            let time_s = f64::from(k) * 0.05;
            let angle = TAU * wave.hz * time_s;
            DriveStep {
                time_s,
                speed_mps: 20.3 + 0.8 * libm::sin(angle + 1.0),
                lead_speed_mps: Some(20.0 - libm::cos(angle)),
                ..DriveStep::default()
            }
        };
        let steps = (wave.duration_s() / 0.05) as u32;
        let drive = Drive { steps: (0..=steps).map(step).collect(), ..Drive::default() };
        let [speed, ahead] = wave.amplitudes(&drive).expect("it was driven to the end");
        assert!((speed - 0.8).abs() < 1e-9 && (ahead - 1.0).abs() < 1e-9, "{speed} {ahead}");
        let short = Drive { steps: drive.steps[..800].to_vec(), ..Drive::default() };
        assert_eq!(wave.amplitudes(&short), None);
    }

    #[test]
    fn a_fast_sine_is_a_small_one() {
        let wave = |hz| Wave { hz, centre_mps: 20.0, settle_s: 60.0 };
        assert_eq!(wave(0.005).amplitude_mps(), 1.0);
        assert!((wave(0.5).acceleration_mps2() - 0.5).abs() < 1e-12);
        assert!(wave(0.005).duration_s() >= 260.0);
    }
}
