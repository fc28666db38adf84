//! The gains of a string behind a sine, over its frequency.

use schemars::JsonSchema;
use serde::Serialize;

use super::driven::Driven;
use super::wave::Amplitudes;

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

#[cfg(test)]
mod tests {
    use super::*;

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
