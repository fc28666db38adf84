//! Starting behind a vehicle: its gap must have grown.
//!
//! A measured speed alone starts no vehicle that stands close behind another. A false speed of 2 m/s would move it
//! towards a car that stands.

use crate::law::Input;

/// Speed below which the ego stands, m/s.
const STANDS_MPS: f64 = 0.05;
/// Farthest gap at which a start waits, m. Chosen: all laws stand within 7 m.
const CLOSE_M: f64 = 8.0;
/// Growth of the gap that starts a vehicle, m. Chosen: the deviation of the radar's range, 0.4 m, and a little more.
const GROWN_M: f64 = 0.5;

/// The smallest gap while the ego stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Departure {
    smallest_m: Option<f64>,
    waits: bool,
}

impl Departure {
    /// Takes the ego and the target of a release.
    pub(super) fn observe(&mut self, input: &Input) {
        let close = input.target.filter(|_| input.ego.speed_mps < STANDS_MPS);
        self.smallest_m =
            close.map(|target| target.gap_m.min(self.smallest_m.unwrap_or(f64::INFINITY)));
        self.waits = close.zip(self.smallest_m).is_some_and(|(target, smallest_m)| {
            target.gap_m <= CLOSE_M && target.gap_m < smallest_m + GROWN_M
        });
    }

    /// The largest request, m/s²: a vehicle that waits stays.
    pub(super) fn most_mps2(&self) -> f64 {
        if self.waits { 0.0 } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Ego, Target};

    fn input(speed_mps: f64, gap_m: f64) -> Input {
        // The speed is false: the target stands.
        let target = Some(Target { gap_m, relative_speed_mps: 2.0, ..Target::default() });
        Input { ego: Ego { speed_mps, ..Ego::default() }, target, ..Input::default() }
    }

    #[test]
    fn a_vehicle_that_stands_waits_until_the_gap_has_grown() {
        let mut departure = Departure::default();
        for gap_m in [7.0, 6.6, 7.0] {
            departure.observe(&input(0.0, gap_m));
            assert_eq!(departure.most_mps2(), 0.0, "{gap_m}");
        }
        departure.observe(&input(0.0, 7.2));
        assert_eq!(departure.most_mps2(), f64::INFINITY);
    }

    #[test]
    fn nothing_waits_that_moves_or_stands_far_behind_or_behind_nothing() {
        let free = Input { target: None, ..input(0.0, 0.0) };
        for input in [input(0.1, 5.0), input(0.0, 8.1), free] {
            let mut departure = Departure::default();
            departure.observe(&input);
            assert_eq!(departure.most_mps2(), f64::INFINITY, "{input:?}");
        }
    }
}
