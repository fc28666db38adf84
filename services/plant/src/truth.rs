//! What the simulators say is really there, as the gateway and the referee want it.

use crate::ahead::Ahead;
use crate::referee::{MAX_SIGNALS, SignalTruth};
use messages::{self, PhaseState, VehicleTruth};
use scenario::v2x::Phase;

/// A vehicle whose rear is farther behind the ego's front than this is beside or behind it, m.
const BEHIND_M: f64 = 5.0;

/// The nearest vehicle ahead in the ego's lane at `time_s`, each moved on from its sample at
/// constant acceleration.
#[must_use]
pub(crate) fn ahead(truth: &VehicleTruth, position_m: f64, time_s: f64) -> Option<Ahead> {
    let age_s = time_s - truth.header.acquisition_ns as f64 / 1e9;
    let count = usize::try_from(truth.count).map_or(0, |count| count.min(truth.vehicles.len()));
    truth.vehicles[..count]
        .iter()
        .filter(|vehicle| vehicle.in_lane != 0)
        .map(|vehicle| {
            let (v, a) = (vehicle.speed_mps, vehicle.acceleration_mps2);
            // Braking ends at standstill.
            let moving_s = if a < 0.0 { age_s.min(v / -a) } else { age_s };
            Ahead {
                gap_m: vehicle.rear_position_m + v * moving_s + 0.5 * a * moving_s * moving_s
                    - position_m,
                speed_mps: v + a * moving_s,
                acceleration_mps2: a,
            }
        })
        .filter(|ahead| ahead.gap_m > -BEHIND_M)
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

/// A state that no simulator sends counts as red: the referee gives no benefit of the doubt.
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

    #[test]
    fn the_nearest_in_lane_counts_and_is_moved_on() {
        let mut truth = VehicleTruth::zeroed();
        truth.count = 3;
        let vehicle = |in_lane, rear, v, a| VehicleTruthItem {
            in_lane,
            rear_position_m: rear,
            speed_mps: v,
            acceleration_mps2: a,
            lateral_m: 0.0,
        };
        truth.vehicles[0] = vehicle(1, 60.0, 10.0, 0.0);
        truth.vehicles[1] = vehicle(0, 20.0, 10.0, 0.0);
        truth.vehicles[2] = vehicle(1, 30.0, 1.0, -2.0);
        let at = |time_s| ahead(&truth, 10.0, time_s).expect("two are in lane");
        assert_eq!((at(0.0).gap_m, at(0.0).speed_mps), (20.0, 1.0));
        // Stops after 0.5 s and 0.25 m.
        assert_eq!((at(2.0).gap_m, at(2.0).speed_mps), (20.25, 0.0));
        assert_eq!(ahead(&truth, 100.0, 0.0), None, "all are behind");
    }
}
