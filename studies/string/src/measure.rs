//! Norms of speed and gap error, of a car and of the vehicle ahead.
//!
//! A speed is measured from its start, `v(t) - v(0)`. Both signals of a gain are taken at the same instants: when the
//! vehicle ahead is published.
//!
//! ```text
//! |x|_2 = sqrt( sum x(t_k)² (t_k - t_(k-1)) )        |x|_max = max |x(t_k)|
//! ```

use controller::laws;
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use supervise::Drive;

/// Largest deviation, m/s or m, below which a signal is not a disturbance. Its gain would be noise over noise. Cars
/// behind a constant speed deviate by 0.1 m/s by their radars' noise.
const QUIET: f64 = 0.2;

/// Two norms of a signal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Norms {
    /// Root of the integral of the square.
    pub l2: f64,
    /// Largest magnitude.
    pub max: f64,
}

impl Norms {
    fn of(samples: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let mut last_s: Option<f64> = None;
        let (mut square, mut max) = (0.0, 0.0_f64);
        for (time_s, value) in samples {
            square += value * value * (time_s - last_s.unwrap_or(time_s));
            max = max.max(value.abs());
            last_s = Some(time_s);
        }
        last_s.map(|_| Self { l2: libm::sqrt(square), max })
    }

    /// Factor by which this is larger than `before`; `None` if there was nothing to amplify.
    pub fn over(self, before: Option<Self>) -> (Option<f64>, Option<f64>) {
        let before = before.filter(|before| before.max > QUIET);
        let ratio = |now: f64, before: Option<f64>| before.map(|before| now / before);
        (
            ratio(self.l2, before.map(|norms| norms.l2)),
            ratio(self.max, before.map(|norms| norms.max)),
        )
    }
}

/// Speeds of a car and of the vehicle ahead at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub time_s: f64,
    pub speed_mps: f64,
    /// Speed of the vehicle ahead, m/s.
    pub ahead_mps: f64,
}

/// The instants of a drive at which a vehicle ahead is known.
pub fn samples(drive: &Drive) -> impl Iterator<Item = Sample> + '_ {
    drive.steps.iter().filter_map(|step| {
        let ahead_mps = step.lead_speed_mps?;
        Some(Sample { time_s: step.time_s, speed_mps: step.speed_mps, ahead_mps })
    })
}

/// The norms of a drive; `None` for a signal that the drive does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Norms of the car's speed.
    pub speed: Option<Norms>,
    /// Norms of the speed of the vehicle ahead.
    pub ahead: Option<Norms>,
    /// Norms of the gap's difference from the gap that the law aims at.
    pub gap_error: Option<Norms>,
}

pub fn measure(scenario: &Scenario, drive: &Drive) -> Measured {
    let first = samples(drive).next();
    let deviation = |speed: fn(&Sample) -> f64| {
        let begin = first.as_ref().map_or(0.0, speed);
        Norms::of(samples(drive).map(move |sample| (sample.time_s, speed(&sample) - begin)))
    };
    Measured {
        speed: deviation(|sample| sample.speed_mps),
        ahead: deviation(|sample| sample.ahead_mps),
        gap_error: Norms::of(gap_errors(scenario, drive)),
    }
}

/// The gap errors of a drive, as far as the law's desired gap is known.
fn gap_errors<'a>(
    scenario: &Scenario,
    drive: &'a Drive,
) -> impl Iterator<Item = (f64, f64)> + use<'a> {
    let desired = laws::desired_gap(scenario);
    let figure = laws::gap_error_figure(scenario);
    drive.steps.iter().filter_map(move |step| {
        let gap_m = step.gap_m?;
        let error_m = match (desired, figure) {
            (Some(desired), _) => gap_m - desired.at(step.speed_mps),
            (None, Some(place)) => step.figures?[place],
            (None, None) => return None,
        };
        error_m.is_finite().then_some((step.time_s, error_m))
    })
}

#[cfg(test)]
mod tests {
    use supervise::DriveStep;

    use super::*;

    #[test]
    fn norms_are_those_of_the_deviation_from_the_start() {
        let step = |k: u32, speed_mps: f64, ahead_mps: f64| DriveStep {
            time_s: f64::from(k) * 0.5,
            speed_mps,
            lead_speed_mps: Some(ahead_mps),
            gap_m: Some(30.0),
            ..DriveStep::default()
        };
        let steps = vec![step(0, 20.0, 22.0), step(1, 21.0, 24.0), step(2, 18.0, 22.0)];
        let scenario = Scenario::parse("x", "schema_version = 1\nname = \"x\"").expect("it is one");
        let measured = measure(&scenario, &Drive { steps, ..Drive::default() });
        let speed = measured.speed.expect("three samples");
        assert!((speed.l2 - libm::sqrt(0.5 * (1.0 + 4.0))).abs() < 1e-12);
        assert_eq!(speed.max, 2.0);
        assert_eq!(speed.over(measured.ahead).1, Some(1.0));
        assert_eq!(measured.gap_error.map(|error| error.l2 > 0.0), Some(true));
    }

    #[test]
    fn an_undisturbed_signal_has_no_gain() {
        let norms = Norms { l2: 1.0, max: 1.0 };
        assert_eq!(norms.over(None), (None, None));
        assert_eq!(norms.over(Some(Norms::default())), (None, None));
        // The hundredth car: what it has ahead is the noise of the radars before it.
        assert_eq!(norms.over(Some(Norms { l2: 0.2, max: 0.08 })), (None, None));
    }
}
