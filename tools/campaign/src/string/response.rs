//! The gains of a string behind a sine, over its frequency.

use serde::Serialize;

use super::drive::Driven;

/// What a string makes of a sine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Response {
    /// Frequency, Hz.
    pub hz: f64,
    /// The largest gain from one car to the next; none if a run ended before it was measured.
    pub gain: Option<f64>,
    /// From the lead to the last car.
    pub head_to_tail_gain: Option<f64>,
    /// Of each car.
    pub gains: Vec<Option<f64>>,
}

/// The response of a string that was driven behind a sine.
pub fn response(hz: f64, cars: &[Driven]) -> Response {
    let ratio = |speed: f64, ahead: f64| (ahead > 0.0).then(|| speed / ahead);
    let gains: Vec<Option<f64>> = cars
        .iter()
        .map(|car| car.amplitudes.and_then(|[speed, ahead]| ratio(speed, ahead)))
        .collect();
    let gain = gains.iter().copied().try_fold(0.0, |most: f64, gain| Some(most.max(gain?)));
    let last = cars.last().and_then(|car| car.amplitudes);
    let first = cars.first().and_then(|car| car.amplitudes);
    let head_to_tail_gain = last.zip(first).and_then(|(last, first)| ratio(last[0], first[1]));
    Response { hz, gain, head_to_tail_gain, gains }
}

/// The frequency at which a curve is highest; none if it has no point, or one that was not measured.
pub fn peak(curve: &[Response]) -> Option<(f64, f64)> {
    let points = curve.iter().map(|response| Some((response.hz, response.gain?)));
    let points = points.collect::<Option<Vec<_>>>()?;
    points.into_iter().reduce(|peak, point| if point.1 > peak.1 { point } else { peak })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_with_a_hole_has_no_peak() {
        let at = |hz: f64, gain| Response { hz, gain, head_to_tail_gain: gain, gains: vec![gain] };
        let curve = [at(0.1, Some(0.9)), at(0.2, Some(1.1)), at(0.3, Some(0.4))];
        assert_eq!(peak(&curve), Some((0.2, 1.1)));
        assert_eq!(peak(&[at(0.1, Some(0.9)), at(0.2, None)]), None);
        assert_eq!(peak(&[]), None);
    }
}
