//! Maps along the ego's way, and the timing of another simulator's lights.

use super::{EXITS, Now, Site, TURNING, egress_lane, ingress_lane, timed};
use crate::numbers::NUMBERS;
use its::EncodeError;
use its::mapem::{IntersectionGeometry, LEFT, Mapem, RIGHT, STRAIGHT};
use its::spatem::MovementEvent;
use messages::{Lights, PhaseState};
use obu::lanes::Path;
use scenario::v2x::Phase;

/// Distance between the nodes of a lane along a curve, m.
const NODE_M: f64 = 10.0;
/// Turn from which a way through an intersection is a turn, rad.
const TURN_RAD: f64 = 0.5;

impl Site {
    /// The ego's lanes along its way, with the nodes of their curves. The stop lines are moved by `shift_m` along the
    /// way. On a road without a net a turning lane lies beside each lane.
    pub(super) fn mapem(
        &self,
        station_id: u32,
        now: &Now,
        path: &Path,
        shift_m: f64,
    ) -> Result<Mapem, EncodeError> {
        let (middle, is_net) = (path.pose(self.middle_m()), path.axis.is_some());
        let step_m = if is_net { NODE_M } else { NUMBERS.lane_m };
        let count = (NUMBERS.lane_m / step_m) as i32;
        let nodes = |from_m: f64, step_m: f64, left_m: f64| {
            let mut last = (middle.x_m, middle.y_m);
            let node = |index: i32| {
                let pose = path.pose(from_m + f64::from(index) * step_m);
                let (x_m, y_m) = pose.to_world(0.0, left_m);
                let to_cm = |to_m: f64| (100.0 * to_m).round();
                let cm = (to_cm(x_m - last.0), to_cm(y_m - last.1));
                // The next node makes up for the rest of rounding.
                last = (last.0 + cm.0 / 100.0, last.1 + cm.1 / 100.0);
                let (east_cm, north_cm) = path.plane.to_earth(cm);
                (east_cm.round() as i16, north_cm.round() as i16)
            };
            (0..=count).map(node).collect::<Vec<_>>()
        };
        let mut lanes = Vec::new();
        for ((signal_group, stop_line_m, _), n) in self.signals.iter().zip(0_u8..) {
            let to_line_m = stop_line_m - self.middle_m();
            if !is_net && to_line_m.abs() > NUMBERS.most_to_line_m {
                let what =
                    format!("a stop line {to_line_m} m from intersection {}", self.intersection);
                return Err(EncodeError::Range(what));
            }
            let exit_m = stop_line_m + 2.0 * NUMBERS.to_middle_m;
            let before = path.pose(stop_line_m - NODE_M);
            let way = match path.pose(exit_m).heading_rad - before.heading_rad {
                left if left > TURN_RAD => LEFT,
                right if right < -TURN_RAD => RIGHT,
                _ => STRAIGHT,
            };
            let mut ingress = |id: u8, left_m: f64, way: u16, group: u8| {
                let nodes = nodes(*stop_line_m, -step_m, left_m);
                lanes.push(ingress_lane(id, nodes, (EXITS + n, way), group));
            };
            ingress(1 + n, 0.0, way, *signal_group);
            if !is_net {
                ingress(TURNING + n, NUMBERS.lane_width_m, LEFT, self.turning_group);
            }
            lanes.push(egress_lane(EXITS + n, nodes(exit_m, step_m, 0.0)));
        }
        let geometry = IntersectionGeometry {
            region: None,
            id: self.intersection,
            revision: now.revision,
            reference: path.earth(self.middle_m() + shift_m, 0.0).0,
            lane_width_cm: Some((100.0 * NUMBERS.lane_width_m) as u16),
            lanes,
            unread_lanes: 0,
        };
        Ok(Mapem { station_id, revision: now.revision, intersections: vec![geometry] })
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
