//! Maps along the ego's way through a net, and the timing of another simulator's lights.

use super::{EXITS, Now, Site, earth_node, egress_lane, ingress_lane, timed};
use crate::numbers::NUMBERS;
use its::geodesy::Plane;
use its::mapem::{LEFT, Mapem, RIGHT, STRAIGHT};
use its::spatem::MovementEvent;
use messages::{Lights, PhaseState};
use road::Axis;
use scenario::v2x::Phase;

/// Distance between the nodes of a lane along a curve, m.
const NODE_M: f64 = 10.0;
/// Turn from which a way through an intersection is a turn, rad.
const TURN_RAD: f64 = 0.5;

impl Site {
    /// The ego's lanes along its way through a net, with the nodes of their curves.
    pub(super) fn mapem_along(
        &self,
        axis: &Axis,
        station_id: u32,
        now: &Now,
        plane: &Plane,
    ) -> Mapem {
        let point = |p_m: f64| {
            let pose = axis.pose(p_m);
            (pose.x_m, pose.y_m)
        };
        let reference = point(self.middle_m());
        let count = (NUMBERS.lane_m / NODE_M) as i32;
        let nodes = |from_m: f64, step_m: f64| {
            let mut last = reference;
            let node = |index: i32| {
                let (x_m, y_m) = point(from_m + f64::from(index) * step_m);
                let to_cm = |to_m: f64| (100.0 * to_m).round() as i16;
                let cm = (to_cm(x_m - last.0), to_cm(y_m - last.1));
                // The next node makes up for the rest of rounding.
                last = (last.0 + f64::from(cm.0) / 100.0, last.1 + f64::from(cm.1) / 100.0);
                earth_node(plane, cm.0, cm.1)
            };
            (0..=count).map(node).collect::<Vec<_>>()
        };
        let mut lanes = Vec::new();
        for ((signal_group, stop_line_m, _), n) in self.signals.iter().zip(0_u8..) {
            let exit_m = stop_line_m + 2.0 * NUMBERS.to_middle_m;
            let turn_rad = axis.heading_rad(exit_m) - axis.heading_rad(stop_line_m - NODE_M);
            let maneuver = match turn_rad {
                left if left > TURN_RAD => LEFT,
                right if right < -TURN_RAD => RIGHT,
                _ => STRAIGHT,
            };
            let entry = nodes(*stop_line_m, -NODE_M);
            lanes.push(ingress_lane(1 + n, entry, (EXITS + n, maneuver), *signal_group));
            lanes.push(egress_lane(EXITS + n, nodes(exit_m, NODE_M)));
        }
        self.map(station_id, now, plane.position(reference.0, reference.1), lanes)
    }
}

/// The intervals of a signal of another simulator.
pub(super) fn shown(lights: &Lights, id: (u16, u8), now: &Now) -> Vec<MovementEvent> {
    let is_it = |signal: &&messages::Signal| {
        (signal.intersection_id, signal.signal_group) == (id.0.into(), id.1.into())
    };
    let found = lights.signals().iter().find(is_it);
    let intervals = found.map_or(&[][..], messages::Signal::intervals);
    let event = |interval: &messages::Interval| {
        let phase = match PhaseState::from_wire(interval.state) {
            PhaseState::ProtectedMovementAllowed => Phase::Green,
            PhaseState::ProtectedClearance => Phase::Yellow,
            PhaseState::StopAndRemain | PhaseState::Unavailable => Phase::Red,
        };
        let utc_ms =
            |end_s: f64| end_s.is_finite().then(|| now.of_run((end_s.max(0.0) * 1e9) as u64));
        let ends_ms = [interval.min_end_s, interval.likely_end_s, interval.max_end_s].map(utc_ms);
        timed(phase, ends_ms, interval.confidence as u8, now)
    };
    intervals.iter().map(event).collect()
}
