//! A lead whose speed is a sine, and the amplitude with which a car follows it.
//!
//! The lead drives `v(t) = c - A cos(2 pi f t)`. The amplitude is small, so that law and vehicle stay within their
//! bounds. After a settling time both speeds are fitted by least squares,
//!
//! ```text
//! v(t) ~ m + p cos(2 pi f t) + q sin(2 pi f t),     amplitude = sqrt(p² + q²)
//! ```
//!
//! over whole periods. The samples need not be in step with the sine. The car's other motion comes from its radar's
//! noise. It is fitted in the same way at the neighbouring frequencies of the same window.

use super::measure::{Measured, Sample, samples};
use scenario::Scenario;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use supervise::report::{ControlFigures, Outcome};
use supervise::{Drive, RequirementVerdict, UsageError};

/// Largest amplitude of the speed, m/s.
const MAX_AMPLITUDE_MPS: f64 = 1.0;
/// Largest acceleration of the lead, m/s²: below every law's bound of comfort.
const MAX_ACCELERATION_MPS2: f64 = 0.5;
/// Time after which the start has no effect on a law, s.
const SETTLE_S: f64 = 60.0;
/// The same that each car adds, since the start travels along the string, s.
const SETTLE_EACH_S: f64 = 5.0;
const LEAST_MEASURED_S: f64 = 40.0;
/// Slowest set speed at which a wave can be driven, m/s.
const SLOWEST_MPS: f64 = 5.0;

/// A sine of the lead's speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    hz: f64,
    centre_mps: f64,
    settle_s: f64,
}

impl Wave {
    /// Around the scenario's speed, as far as the set speed leaves room on both sides. It goes before a string of this
    /// many vehicles.
    pub fn of(scenario: &Scenario, vehicles: usize, hz: f64) -> Result<Self, UsageError> {
        let set_mps = scenario.set_speed_mps.value();
        let top_mps = scenario.speed_limit_mps.map_or(set_mps, |limit| set_mps.min(limit.value()));
        if top_mps < SLOWEST_MPS {
            let why = format_args!("a lead that swings needs room below {top_mps} m/s");
            let expected = format_args!("at least {SLOWEST_MPS} m/s");
            return Err(UsageError::at("the set speed", why, expected));
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
        self.settle_s + self.periods() / self.hz
    }

    /// Whole periods that are measured.
    fn periods(&self) -> f64 {
        (LEAST_MEASURED_S * self.hz).ceil()
    }

    /// Measures the sine in the speeds of a drive; none if the drive ended before.
    pub fn amplitudes(&self, drive: &Drive) -> Option<Amplitudes> {
        let reached_s = drive.steps.last()?.time_s;
        if reached_s < self.duration_s() - 1.0 {
            return None;
        }
        let settled: Vec<_> =
            samples(drive).filter(|sample| sample.time_s >= self.settle_s).collect();
        let of = |speed: fn(&Sample) -> f64, sample: &Sample| speed(sample) - self.centre_mps;
        let ahead = fit(self.hz, settled.iter().map(|at| (at.time_s, of(|at| at.ahead_mps, at))))?;
        let car = fit(self.hz, settled.iter().map(|at| (at.time_s, of(|at| at.speed_mps, at))))?;
        let rest =
            || settled.iter().map(|at| (at.time_s, of(|at| at.speed_mps, at) - car.at(at.time_s)));
        let periods = self.periods();
        let beside = [periods - 2.0, periods - 1.0, periods + 1.0, periods + 2.0];
        let noise = (beside.into_iter().filter(|&other| other > 0.0))
            .map(|other| Some(fit(self.hz * other / periods, rest())?.amplitude()))
            .collect::<Option<Vec<_>>>()?;
        let square = noise.iter().map(|mps| mps * mps).sum::<f64>() / noise.len() as f64;
        Some(Amplitudes {
            car_mps: car.amplitude(),
            ahead_mps: ahead.amplitude(),
            noise_mps: libm::sqrt(square),
        })
    }
}

/// Amplitudes of a sine, m/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Amplitudes {
    /// Amplitude of the car's speed.
    pub car_mps: f64,
    /// Amplitude of the speed of the vehicle ahead.
    pub ahead_mps: f64,
    /// Root mean square of the car's amplitudes at the neighbouring frequencies.
    pub noise_mps: f64,
}

/// `mean + cosine cos(2 pi f t) + sine sin(2 pi f t)`.
#[derive(Clone, Copy, Debug)]
struct Sine {
    hz: f64,
    coefficients: [f64; 3],
}

impl Sine {
    fn at(&self, time_s: f64) -> f64 {
        self.coefficients.iter().zip(basis(self.hz, time_s)).map(|(c, b)| c * b).sum()
    }

    fn amplitude(&self) -> f64 {
        libm::hypot(self.coefficients[1], self.coefficients[2])
    }
}

fn basis(hz: f64, time_s: f64) -> [f64; 3] {
    let angle = TAU * hz * time_s;
    [1.0, libm::cos(angle), libm::sin(angle)]
}

/// The sine of a frequency that is nearest to a signal, by Gauss's elimination. The matrix is positive definite if
/// three samples differ.
fn fit(hz: f64, signal: impl Iterator<Item = (f64, f64)>) -> Option<Sine> {
    // Each row with its right-hand side.
    let mut rows = [[0.0; 4]; 3];
    for (time_s, value) in signal {
        let basis = basis(hz, time_s);
        for (row, of) in rows.iter_mut().zip(basis) {
            for (sum, other) in row.iter_mut().zip(basis.into_iter().chain([value])) {
                *sum += of * other;
            }
        }
    }
    for pivot in 0..3 {
        let by: [f64; 4] = rows[pivot];
        if by[pivot].is_nan() || by[pivot] <= 1e-9 {
            return None;
        }
        for row in &mut rows[pivot + 1..] {
            let factor = row[pivot] / by[pivot];
            for (value, other) in row.iter_mut().zip(by) {
                *value -= factor * other;
            }
        }
    }
    let mut coefficients = [0.0; 3];
    for k in (0..3).rev() {
        let known: f64 = rows[k].iter().zip(coefficients).map(|(a, c)| a * c).sum();
        coefficients[k] = (rows[k][3] - known) / rows[k][k];
    }
    Some(Sine { hz, coefficients })
}

/// A sine ahead of a car is lost in its noise when it is smaller than this times the noise ...
const NOISES: f64 = 20.0;
/// ... and has lost more than this share of what the lead began with.
const LOST_SHARE: f64 = 0.75;

/// The gains of a string behind a sine.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Response {
    /// Frequency, Hz.
    pub hz: f64,
    /// The largest gain from one car to the next that can be measured; none if a run ended early.
    pub gain: Option<f64>,
    /// From the lead to the last car.
    pub head_to_tail_gain: Option<f64>,
    /// Gain of each car; none where the radars' noise covers the sine ahead, or a run ended early.
    pub gains: Vec<Option<f64>>,
}

/// The response of a string that was driven behind a sine.
pub fn response(hz: f64, cars: &[Driven]) -> Response {
    of(hz, cars.iter().map(|car| car.amplitudes).collect())
}

fn of(hz: f64, cars: Vec<Option<Amplitudes>>) -> Response {
    let first_mps = cars.first().copied().flatten().map_or(0.0, |first| first.ahead_mps);
    let ratio = |mps: f64, ahead_mps: f64| (ahead_mps > 0.0).then(|| mps / ahead_mps);
    let gains: Vec<Option<f64>> = (cars.iter())
        .map(|car| {
            let Amplitudes { car_mps, ahead_mps, noise_mps } = (*car)?;
            let is_lost = ahead_mps < (NOISES * noise_mps).min((1.0 - LOST_SHARE) * first_mps);
            ratio(car_mps, ahead_mps).filter(|_| !is_lost)
        })
        .collect();
    let whole: Option<Vec<Amplitudes>> = cars.into_iter().collect();
    let gain = whole.as_ref().and_then(|_| gains.iter().copied().flatten().reduce(f64::max));
    let head_to_tail_gain =
        whole.and_then(|cars| ratio(cars.last()?.car_mps, cars.first()?.ahead_mps));
    Response { hz, gain, head_to_tail_gain, gains }
}

/// The highest point of a curve; none if it has no point, or a point that was not measured.
pub fn peak(curve: &[Response]) -> Option<(f64, f64)> {
    let points = curve.iter().map(|response| Some((response.hz, response.gain?)));
    let points = points.collect::<Option<Vec<_>>>()?;
    points.into_iter().reduce(|peak, point| if point.1 > peak.1 { point } else { peak })
}

/// The drive of one car, reduced to figures and a trace.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Driven {
    /// Place of the car in the string, from 1.
    pub index: usize,
    pub controller: String,
    /// End of its drive.
    pub outcome: Outcome,
    pub requirements: Vec<RequirementVerdict>,
    pub figures: ControlFigures,
    /// Norms of its speeds and gaps.
    pub measured: Measured,
    /// Amplitudes behind a sine.
    pub amplitudes: Option<Amplitudes>,
    /// Time, s, position of its front bumper from the first car's start, m, and speed, m/s; empty
    /// behind a sine.
    pub trace: Vec<[f64; 3]>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use supervise::DriveStep;

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
        let found = wave.amplitudes(&drive).expect("it was driven to the end");
        let Amplitudes { car_mps, ahead_mps, noise_mps } = found;
        assert!((car_mps - 0.8).abs() < 1e-9 && (ahead_mps - 1.0).abs() < 1e-9, "{found:?}");
        assert!(noise_mps < 1e-9, "{found:?}");
        let short = Drive { steps: drive.steps[..800].to_vec(), ..Drive::default() };
        assert_eq!(wave.amplitudes(&short), None);
    }

    #[test]
    fn a_cars_motion_beside_the_sine_is_its_noise() {
        let wave = Wave { hz: 0.3, centre_mps: 20.0, settle_s: 60.0 };
        // One of the four neighbouring frequencies has 0.01 m/s.
        let other_hz = wave.hz * (wave.periods() + 1.0) / wave.periods();
        let step = |k: u32| {
            let time_s = f64::from(k) * 0.05;
            let speed_mps = 20.0 + 0.01 * libm::sin(TAU * other_hz * time_s);
            let lead_speed_mps = Some(20.0 - 0.2 * libm::cos(TAU * wave.hz * time_s));
            DriveStep { time_s, speed_mps, lead_speed_mps, ..DriveStep::default() }
        };
        let steps = (wave.duration_s() / 0.05) as u32;
        let drive = Drive { steps: (0..=steps).map(step).collect(), ..Drive::default() };
        let found = wave.amplitudes(&drive).expect("it was driven to the end");
        assert!((found.noise_mps - 0.005).abs() < 1e-4, "{found:?}");
        assert!(found.car_mps < 1e-4, "{found:?}");
    }

    #[test]
    fn a_fast_sine_is_a_small_one() {
        let wave = |hz| Wave { hz, centre_mps: 20.0, settle_s: 60.0 };
        assert_eq!(wave(0.005).amplitude_mps(), 1.0);
        assert!((wave(0.5).acceleration_mps2() - 0.5).abs() < 1e-12);
        assert!(wave(0.005).duration_s() >= 260.0);
    }

    #[test]
    fn a_sine_that_is_lost_in_noise_has_no_gain() {
        let car =
            |car_mps, ahead_mps, noise_mps| Some(Amplitudes { car_mps, ahead_mps, noise_mps });
        // As measured at 0.5 Hz: 0.14 of the sine is left by each car, then noise of 1 mm/s.
        let string = vec![
            car(0.0229, 0.159, 0.0005),
            car(0.0032, 0.0229, 0.001),
            car(0.0007, 0.0032, 0.001),
            car(0.0029, 0.0007, 0.001),
        ];
        let response = of(0.5, string);
        let kept: Vec<bool> = response.gains.iter().map(Option::is_some).collect();
        assert_eq!(kept, [true, true, false, false]);
        assert!(response.gain.is_some_and(|gain| gain < 0.15), "{response:?}");
        // Most of the lead's sine is left: amplified, however noisy.
        assert!(of(0.5, vec![car(0.2, 0.15, 0.05)]).gain.is_some_and(|gain| gain > 1.3));
        assert_eq!(of(0.5, vec![car(0.1, 0.15, 0.0), None]).gain, None);
    }

    #[test]
    fn a_curve_with_a_hole_has_no_peak() {
        let at = |hz: f64, gain| Response { hz, gain, head_to_tail_gain: gain, gains: vec![gain] };
        let curve = [at(0.1, Some(0.9)), at(0.2, Some(1.1)), at(0.3, Some(0.4))];
        assert_eq!(peak(&curve), Some((0.2, 1.1)));
        assert_eq!(peak(&[at(0.1, Some(0.9)), at(0.2, None)]), None);
        assert_eq!(peak(&[]), None);
    }
}
