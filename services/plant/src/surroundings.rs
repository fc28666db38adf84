//! Surroundings of the ego by the ground truth. Faults that wait for a phase of the drive use them, and so does a
//! campaign's account of its drives. The referee uses the vehicle ahead. No law and no service that drives uses it.

use crate::ahead::Lengths;
use crate::longitudinal::State;
use crate::numbers::Numbers;
use crate::referee::shown;
use bytemuck::Zeroable;
use messages::{AllVehicles, EgoTruth, PhaseState, SignalTruth};
use scenario::Scenario;

/// Slowest closing speed for which a fault's time to collision exists, m/s. Chosen: faults do not wait for a time to
/// collision beyond 1000 s.
const PHASE_CLOSING_MPS: f64 = 0.1;

/// Looks around, once in each period, and keeps the places of the others.
#[derive(Clone, Debug)]
pub struct Surroundings {
    numbers: Numbers,
    pub(crate) lengths: Lengths,
    /// The sample before the newest one.
    last: AllVehicles,
    has_last: bool,
    cut_in: bool,
}

impl Surroundings {
    pub fn new(scenario: &Scenario, numbers: &Numbers) -> Self {
        Self {
            numbers: *numbers,
            lengths: Lengths::of(scenario),
            last: AllVehicles::with_room(scenario.actors.len()),
            has_last: false,
            cut_in: false,
        }
    }

    /// The motion and the surroundings of an ego in `state` at `time_s`.
    pub fn of(
        &mut self,
        state: &State,
        time_s: f64,
        vehicles: Option<&AllVehicles>,
        signals: Option<&SignalTruth>,
    ) -> EgoTruth {
        if let Some(vehicles) = vehicles {
            self.observe(state, vehicles);
        }
        let ahead =
            vehicles.and_then(|vehicles| self.lengths.ahead(vehicles, state.position_m, time_s));
        let closing_mps = ahead.map_or(0.0, |ahead| state.speed_mps - ahead.speed_mps);
        let time_to_collision_s = match ahead {
            Some(ahead) if closing_mps > PHASE_CLOSING_MPS => ahead.gap_m.max(0.0) / closing_mps,
            _ => f64::INFINITY,
        };
        let (stop_line_m, signal_state) = signals
            .and_then(|signals| next_line(signals, state.position_m, time_s))
            .unwrap_or((f64::INFINITY, 0));
        EgoTruth {
            position_m: state.position_m,
            speed_mps: state.speed_mps,
            acceleration_mps2: state.acceleration_mps2,
            time_to_collision_s,
            stop_line_m,
            signal_state,
            cut_in: self.cut_in.into(),
            ..EgoTruth::zeroed()
        }
    }

    fn observe(&mut self, state: &State, now: &AllVehicles) {
        if self.has_last {
            let elapsed_ns = now.header.acquisition_ns - self.last.header.acquisition_ns;
            if elapsed_ns <= 0 {
                return;
            }
            self.cut_in = self.cuts_in(state, now, elapsed_ns as f64 / 1e9);
        }
        self.last.header = now.header;
        // It keeps its room: a loop does not allocate.
        self.last.vehicles.clone_from(&now.vehicles);
        self.has_last = true;
    }

    /// A vehicle ahead has moved sideways towards the lane since the last sample.
    fn cuts_in(&self, state: &State, now: &AllVehicles, elapsed_s: f64) -> bool {
        let Numbers { cut_in_mps, cut_in_arrived_m, cut_in_away_m, cut_in_ahead_m, .. } =
            self.numbers;
        now.vehicles.len() == self.last.vehicles.len()
            && now.vehicles.iter().zip(&self.last.vehicles).any(|(now, last)| {
                let inward_mps = (last.lateral_m.abs() - now.lateral_m.abs()) / elapsed_s;
                let ahead_m = now.rear_position_m - state.position_m;
                inward_mps > cut_in_mps
                    && (cut_in_arrived_m..cut_in_away_m).contains(&now.lateral_m.abs())
                    && (0.0..cut_in_ahead_m).contains(&ahead_m)
            })
    }
}

/// Distance to the next stop line, m, and what its signal shows at `time_s`.
fn next_line(truth: &SignalTruth, position_m: f64, time_s: f64) -> Option<(f64, u32)> {
    let ahead = shown(truth).filter(|(lane, _)| lane.stop_line_m > position_m);
    ahead.min_by(|a, b| a.0.stop_line_m.total_cmp(&b.0.stop_line_m)).map(|(lane, signal)| {
        let shown = signal.intervals().iter().find(|interval| interval.likely_end_s > time_s);
        let state = shown.map_or(PhaseState::StopAndRemain.to_wire(), |interval| interval.state);
        (lane.stop_line_m - position_m, state)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::VehicleTruthItem;

    const EGO: State = State { position_m: 100.0, speed_mps: 20.0, acceleration_mps2: 0.0 };

    fn new() -> Surroundings {
        let text = "schema_version = 1\nname = \"x\"\n[[actors]]\nname = \"a\"\ngap_m = 9\ninitial_speed_mps = 10\n";
        let scenario = Scenario::parse("x", text).unwrap_or_else(|error| panic!("{error}"));
        Surroundings::new(&scenario, &Numbers::DEFAULT)
    }

    fn vehicle(time_s: f64, lateral_m: f64, in_lane: u64) -> AllVehicles {
        let mut truth = AllVehicles::with_room(1);
        truth.header.acquisition_ns = (time_s * 1e9) as i64;
        truth.vehicles.push(VehicleTruthItem {
            in_lane,
            rear_position_m: 130.0,
            speed_mps: 15.0,
            acceleration_mps2: 0.0,
            lateral_m,
        });
        truth
    }

    #[test]
    fn a_vehicle_that_comes_over_cuts_in_until_it_has_arrived() {
        let mut around = new();
        let meets = |around: &mut Surroundings, time_s, lateral_m| {
            around.of(&EGO, time_s, Some(&vehicle(time_s, lateral_m, 0)), None).cut_in != 0
        };
        assert!(!meets(&mut around, 0.0, 3.5));
        assert!(!meets(&mut around, 0.1, 3.5), "beside the lane");
        assert!(meets(&mut around, 0.2, 3.4));
        assert!(meets(&mut around, 0.2, 3.4), "the same sample again");
        assert!(!meets(&mut around, 0.3, 3.45), "on its way out");
        assert!(!meets(&mut around, 0.4, 0.2), "arrived");
        let near = around.of(&EGO, 0.5, Some(&vehicle(0.5, 0.0, 1)), None);
        assert!((near.time_to_collision_s - 30.0 / 5.0).abs() < 1e-9);
        assert_eq!((near.stop_line_m, near.signal_state), (f64::INFINITY, 0));
    }

    #[test]
    fn the_next_line_shows_what_its_signal_shows_now() {
        let mut truth = SignalTruth::zeroed();
        truth.count = 2;
        truth.lanes[0].stop_line_m = 90.0;
        truth.lanes[1].stop_line_m = 150.0;
        truth.signals[1].count = 2;
        truth.signals[1].intervals[0].state = PhaseState::ProtectedMovementAllowed.to_wire();
        truth.signals[1].intervals[0].likely_end_s = 5.0;
        truth.signals[1].intervals[1].state = PhaseState::StopAndRemain.to_wire();
        truth.signals[1].intervals[1].likely_end_s = 9.0;
        let at = |time_s| new().of(&EGO, time_s, None, Some(&truth));
        assert_eq!((at(4.9).stop_line_m, at(4.9).signal_state), (50.0, 6));
        assert_eq!(at(5.0).signal_state, 3);
    }
}
