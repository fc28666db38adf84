//! The simulators' ground truth in the form that the gateway and the referee need.

use crate::ahead::Ahead;
use crate::referee::{MAX_SIGNALS, SignalTruth};
use messages::{self, AllVehicles, PhaseState};
use scenario::Scenario;
use scenario::v2x::Phase;

/// Lengths of the ego and the others, m. The ground truth has the others' rears alone.
#[derive(Clone, Debug)]
pub(crate) struct Lengths {
    ego_m: f64,
    /// In the scenario's order, which the truth keeps.
    others_m: Vec<f64>,
}

impl Lengths {
    /// Those of the scenario's vehicles.
    pub(crate) fn of(scenario: &Scenario) -> Self {
        let others_m = scenario.actors.iter().map(|actor| actor.length_m.value()).collect();
        Self { ego_m: scenario.plant.length_m.value(), others_m }
    }

    /// Greatest distance from the ego's front back to the rear of one of `count` vehicles beside the ego, m.
    fn beside_m(&self, index: usize, count: usize) -> f64 {
        let length_m = if count == self.others_m.len() {
            self.others_m[index]
        } else {
            // Some are not on the road, and it is not known which: no contact is invented.
            self.others_m.iter().copied().reduce(f64::min).unwrap_or(0.0)
        };
        self.ego_m + length_m
    }
}

/// The nearest vehicle ahead in the ego's lane at `time_s`, each moved on from its sample at
/// constant acceleration. One whose body overlaps with the ego's, from whichever side it came, counts: its gap is
/// negative.
pub(crate) fn ahead(
    truth: &AllVehicles,
    lengths: &Lengths,
    position_m: f64,
    time_s: f64,
) -> Option<Ahead> {
    let age_s = time_s - truth.header.acquisition_ns as f64 / 1e9;
    let count = truth.vehicles.len();
    truth
        .vehicles
        .iter()
        .enumerate()
        .filter(|(_, vehicle)| vehicle.in_lane != 0)
        .map(|(index, vehicle)| {
            let (v, a) = (vehicle.speed_mps, vehicle.acceleration_mps2);
            // Braking ends at standstill.
            let moving_s = if a < 0.0 { age_s.min(v / -a) } else { age_s };
            let ahead = Ahead {
                gap_m: vehicle.rear_position_m + v * moving_s + 0.5 * a * moving_s * moving_s
                    - position_m,
                speed_mps: v + a * moving_s,
                acceleration_mps2: a,
            };
            (lengths.beside_m(index, count), ahead)
        })
        .filter(|(beside_m, ahead)| ahead.gap_m > -beside_m)
        .map(|(_, ahead)| ahead)
        .min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}

/// The signals as the referee watches them; returns how many.
pub(crate) fn signals(
    truth: &messages::SignalTruth,
    into: &mut [SignalTruth; MAX_SIGNALS],
) -> usize {
    let count = usize::try_from(truth.count).map_or(0, |count| count.min(truth.lanes.len()));
    for ((lane, signal), place) in
        truth.lanes.iter().zip(&truth.signals).zip(&mut *into).take(count)
    {
        let [now, next] = [signal.intervals[0], signal.intervals[1]];
        *place = SignalTruth {
            id: lane.intersection_id.wrapping_mul(256).wrapping_add(lane.signal_group),
            stop_line_m: lane.stop_line_m,
            phase: phase(now.state),
            ends_ns: now.likely_end_s.is_finite().then(|| (now.likely_end_s * 1e9).round() as u64),
            next_phase: phase(if signal.count > 1 { next.state } else { now.state }),
        };
    }
    count
}

/// A state that no simulator sends counts as red.
fn phase(state: u32) -> Phase {
    match PhaseState::from_wire(state) {
        PhaseState::ProtectedMovementAllowed => Phase::Green,
        PhaseState::ProtectedClearance => Phase::Yellow,
        PhaseState::StopAndRemain | PhaseState::Unavailable => Phase::Red,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::VehicleTruthItem;

    fn lengths(others_m: &[f64]) -> Lengths {
        Lengths { ego_m: 5.0, others_m: others_m.to_vec() }
    }

    #[test]
    fn the_nearest_in_lane_counts_and_is_moved_on() {
        let mut truth = AllVehicles::with_room(3);
        let vehicle = |in_lane, rear, v, a| VehicleTruthItem {
            in_lane,
            rear_position_m: rear,
            speed_mps: v,
            acceleration_mps2: a,
            lateral_m: 0.0,
        };
        truth.vehicles.push(vehicle(1, 60.0, 10.0, 0.0));
        truth.vehicles.push(vehicle(0, 20.0, 10.0, 0.0));
        truth.vehicles.push(vehicle(1, 30.0, 1.0, -2.0));
        let lengths = lengths(&[4.0, 4.0, 4.0]);
        let at = |time_s| ahead(&truth, &lengths, 10.0, time_s).expect("two are in lane");
        assert_eq!((at(0.0).gap_m, at(0.0).speed_mps), (20.0, 1.0));
        // Stops after 0.5 s and 0.25 m.
        assert_eq!((at(2.0).gap_m, at(2.0).speed_mps), (20.25, 0.0));
        assert_eq!(ahead(&truth, &lengths, 100.0, 0.0), None, "all are behind");
    }

    #[test]
    fn a_body_beside_or_behind_that_overlaps_is_in_contact() {
        let mut truth = AllVehicles::with_room(2);
        truth.vehicles = vec![VehicleTruthItem::zeroed(); 2];
        truth.vehicles[0].rear_position_m = 300.0;
        (truth.vehicles[1].in_lane, truth.vehicles[1].rear_position_m) = (1, 91.0);
        let gap = |lengths: &Lengths, position_m| {
            ahead(&truth, lengths, position_m, 0.0).map(|ahead| ahead.gap_m)
        };
        // The ego is 5 m long. Its rear is at 95 m, and the front of a vehicle of 4.1 m at 95.1 m.
        let long = lengths(&[12.0, 4.1]);
        assert_eq!(gap(&long, 100.0), Some(-9.0));
        assert_eq!(gap(&long, 100.2), None, "its front is behind the ego's rear");
        // One is not on the road: which of the others this is is not known.
        let three = lengths(&[12.0, 4.1, 3.0]);
        assert_eq!(gap(&three, 100.0), None);
        assert_eq!(gap(&three, 98.5), Some(-7.5));
    }

    #[test]
    fn a_vehicle_that_speeds_up_goes_on_doing_so() {
        let mut truth = AllVehicles::with_room(1);
        truth.header.acquisition_ns = 1_000_000_000;
        truth.vehicles.push(VehicleTruthItem {
            in_lane: 1,
            rear_position_m: 60.0,
            speed_mps: 10.0,
            acceleration_mps2: 1.0,
            lateral_m: 0.0,
        });
        let found = ahead(&truth, &lengths(&[4.0]), 10.0, 3.0).expect("it is in lane");
        assert_eq!((found.gap_m, found.speed_mps, found.acceleration_mps2), (72.0, 12.0, 1.0));
    }

    #[test]
    fn signals_show_their_phase_its_end_and_the_next_one() {
        let mut truth = messages::SignalTruth::zeroed();
        truth.count = 2;
        for (place, (intersection, line_m)) in [(3, 80.0), (4, 200.0)].into_iter().enumerate() {
            truth.lanes[place].intersection_id = intersection;
            truth.lanes[place].signal_group = 2;
            truth.lanes[place].stop_line_m = line_m;
        }
        let green = PhaseState::ProtectedMovementAllowed.to_wire();
        let yellow = PhaseState::ProtectedClearance.to_wire();
        truth.signals[0].count = 2;
        (truth.signals[0].intervals[0].state, truth.signals[0].intervals[0].likely_end_s) =
            (green, 2.5);
        truth.signals[0].intervals[1].state = yellow;
        truth.signals[1].count = 1;
        (truth.signals[1].intervals[0].state, truth.signals[1].intervals[0].likely_end_s) =
            (yellow, f64::INFINITY);
        truth.signals[1].intervals[1].state = green;
        let dark = SignalTruth {
            id: 0,
            stop_line_m: 0.0,
            phase: Phase::Red,
            ends_ns: None,
            next_phase: Phase::Red,
        };
        let mut shown = [dark; MAX_SIGNALS];
        assert_eq!(signals(&truth, &mut shown), 2);
        let first = SignalTruth {
            id: 3 * 256 + 2,
            stop_line_m: 80.0,
            phase: Phase::Green,
            ends_ns: Some(2_500_000_000),
            next_phase: Phase::Yellow,
        };
        let second = SignalTruth {
            id: 4 * 256 + 2,
            stop_line_m: 200.0,
            phase: Phase::Yellow,
            ends_ns: None,
            next_phase: Phase::Yellow,
        };
        assert_eq!(shown[..3], [first, second, dark]);
    }
}
