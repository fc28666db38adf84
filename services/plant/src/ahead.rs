//! The vehicle ahead as it truly is: for the referee, and for verdicts on what braking could have done.

use crate::numbers::Numbers;
use messages::AllVehicles;
use scenario::Scenario;

/// The vehicle ahead as it truly is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead {
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

/// Constant deceleration that keeps the ego behind the vehicle ahead, m/s². The vehicle ahead keeps its present
/// acceleration until it stands. 0 without a need to brake.
pub fn required_deceleration(speed_mps: f64, ahead: &Ahead) -> f64 {
    required_with(speed_mps, ahead, &Numbers::DEFAULT)
}

/// The same with other numbers, for studies of their effect.
pub fn required_with(speed_mps: f64, ahead: &Ahead, numbers: &Numbers) -> f64 {
    let room = (ahead.gap_m - numbers.margin_m).max(0.1);
    let braking = (-ahead.acceleration_mps2).max(0.0);
    let closing = speed_mps - ahead.speed_mps;
    let lead_stops_in_s = if braking > 0.0 { ahead.speed_mps / braking } else { f64::INFINITY };
    // Equal speeds are reached after 2 room / closing at the deceleration that just avoids contact.
    let meets_in_s = if closing > 0.0 { 2.0 * room / closing } else { f64::INFINITY };
    if meets_in_s <= lead_stops_in_s && closing > 0.0 {
        braking + closing * closing / (2.0 * room)
    } else if lead_stops_in_s.is_finite() {
        let to_its_stop = 0.5 * ahead.speed_mps * lead_stops_in_s;
        speed_mps * speed_mps / (2.0 * (room + to_its_stop))
    } else {
        0.0
    }
}

/// Lengths of the ego and the others, m. The ground truth has the others' rears alone.
#[derive(Clone, Debug)]
pub(crate) struct Lengths {
    ego_m: f64,
    /// In the scenario's order, which the truth keeps.
    others_m: Vec<f64>,
}

impl Lengths {
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

    /// The nearest vehicle ahead of an ego at `position_m` in its lane at `time_s`, each moved on from its sample at
    /// constant acceleration. One whose body overlaps with the ego's, from whichever side it came, counts: its gap is
    /// negative.
    pub(crate) fn ahead(&self, truth: &AllVehicles, position_m: f64, time_s: f64) -> Option<Ahead> {
        let age_s = time_s - truth.header.acquisition_ns as f64 / 1e9;
        let count = truth.vehicles.len();
        (truth.vehicles.iter().enumerate())
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
                (self.beside_m(index, count), ahead)
            })
            .filter(|(beside_m, ahead)| ahead.gap_m > -beside_m)
            .map(|(_, ahead)| ahead)
            .min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::VehicleTruthItem;

    #[test]
    fn required_deceleration_by_hand() {
        let ahead =
            |gap_m, speed_mps, acceleration_mps2| Ahead { gap_m, speed_mps, acceleration_mps2 };
        // Standing obstacle: v²/(2 d).
        assert!((required_deceleration(20.0, &ahead(41.0, 0.0, 0.0)) - 5.0).abs() < 1e-12);
        // Constant lead: closing²/(2 d).
        assert!((required_deceleration(20.0, &ahead(26.0, 10.0, 0.0)) - 2.0).abs() < 1e-12);
        // A lead that brakes to a stop from the same speed: its stopping distance is ours too.
        assert!((required_deceleration(20.0, &ahead(11.0, 20.0, -5.0)) - 4.0).abs() < 1e-12);
        // Opening, and a lead that drives on.
        assert_eq!(required_deceleration(10.0, &ahead(5.0, 20.0, 1.0)), 0.0);
    }

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
        let at = |time_s| lengths.ahead(&truth, 10.0, time_s).expect("two are in lane");
        assert_eq!((at(0.0).gap_m, at(0.0).speed_mps), (20.0, 1.0));
        // Stops after 0.5 s and 0.25 m.
        assert_eq!((at(2.0).gap_m, at(2.0).speed_mps), (20.25, 0.0));
        assert_eq!(lengths.ahead(&truth, 100.0, 0.0), None, "all are behind");
    }

    #[test]
    fn a_body_beside_or_behind_that_overlaps_is_in_contact() {
        let mut truth = AllVehicles::with_room(2);
        truth.vehicles = vec![VehicleTruthItem::zeroed(); 2];
        truth.vehicles[0].rear_position_m = 300.0;
        (truth.vehicles[1].in_lane, truth.vehicles[1].rear_position_m) = (1, 91.0);
        let gap = |lengths: &Lengths, position_m| {
            lengths.ahead(&truth, position_m, 0.0).map(|ahead| ahead.gap_m)
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
        let found = lengths(&[4.0]).ahead(&truth, 10.0, 3.0).expect("it is in lane");
        assert_eq!((found.gap_m, found.speed_mps, found.acceleration_mps2), (72.0, 12.0, 1.0));
    }
}
