//! Decoding by the types of `c-its-parser` and `rasn` into this crate's messages.

use crate::cam::{Cam, LowFrequency, Motion};
use crate::geodesy::Position;
use crate::mapem::{Approach, Connection, IntersectionGeometry, Lane, Mapem};
use crate::spatem::{
    IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing,
};
use crate::time::{Stamp, TimeMark};
use crate::{Message, MessageKind};
use c_its_parser::standards::cam_1_4_1::cam_pdu_descriptions as pdu;
use c_its_parser::standards::dsrc_2_2_1::etsi_its_dsrc as dsrc;
use c_its_parser::standards::mapem_2_2_1::mapem_pdu_descriptions::MAPEM;
use c_its_parser::standards::spatem_2_2_1::spatem_pdu_descriptions::SPATEM;
use dsrc::NodeOffsetPointXY as Offset;
use rasn::types::FixedBitString;

/// Reason why a message was refused, in words.
#[derive(Debug)]
pub(super) struct Refused(#[expect(dead_code, reason = "shown by a failing test")] String);

pub(super) fn decode(kind: MessageKind, payload: &[u8]) -> Result<Message, Refused> {
    match kind {
        MessageKind::Spatem => from_uper(payload).map(|it| Message::Spatem(spatem(&it))),
        MessageKind::Mapem => from_uper(payload).map(|it| Message::Mapem(mapem(&it))),
        MessageKind::Cam => from_uper(payload).and_then(|it| cam(&it)).map(Message::Cam),
    }
}

fn from_uper<T: rasn::Decode>(payload: &[u8]) -> Result<T, Refused> {
    rasn::uper::decode(payload).map_err(|error| Refused(error.kind.to_string()))
}

/// A bit string of the standard: its bit n is bit n of the flags.
fn flags<const N: usize>(bits: &FixedBitString<N>) -> u16 {
    (0..N.min(16)).map(|n| u16::from(bits[n]) << n).sum()
}

fn spatem(SPATEM { header, spat }: &SPATEM) -> Spatem {
    Spatem {
        station_id: header.station_id.0,
        intersections: spat
            .intersections
            .0
            .iter()
            .map(|state| read_state(state, spat.time_stamp.as_ref()))
            .collect(),
    }
}

/// The minute is in the intersection, or once for all.
fn read_state(
    state: &dsrc::IntersectionState,
    minute: Option<&dsrc::MinuteOfTheYear>,
) -> IntersectionState {
    let minute = state.moy.as_ref().or(minute);
    let stamp = minute.zip(state.time_stamp.as_ref());
    IntersectionState {
        region: state.id.region.as_ref().map(|region| region.0),
        id: state.id.id.0,
        revision: state.revision.0,
        status: flags(&state.status.0),
        stamp: stamp
            .map(|(minute, second)| Stamp { minute_of_year: minute.0, millisecond: second.0 }),
        movements: state.states.0.iter().map(read_movement).collect(),
    }
}

fn read_movement(state: &dsrc::MovementState) -> MovementState {
    MovementState {
        signal_group: state.signal_group.0,
        events: state.state_time_speed.0.iter().map(read_event).collect(),
    }
}

fn read_event(event: &dsrc::MovementEvent) -> MovementEvent {
    MovementEvent {
        state: MovementPhase::ALL[event.event_state as usize],
        timing: event.timing.as_ref().map(read_timing),
    }
}

fn read_timing(timing: &dsrc::TimeChangeDetails) -> Timing {
    let mark = |mark: &dsrc::TimeMark| TimeMark::new(mark.0).unwrap_or(TimeMark::UNKNOWN);
    Timing {
        start: timing.start_time.as_ref().map(mark),
        min_end: mark(&timing.min_end_time),
        max_end: timing.max_end_time.as_ref().map(mark),
        likely_end: timing.likely_time.as_ref().map(mark),
        confidence: timing.confidence.as_ref().map(|confidence| confidence.0),
        next: timing.next_time.as_ref().map(mark),
    }
}

fn mapem(MAPEM { header, map }: &MAPEM) -> Mapem {
    let intersections = map.intersections.as_ref();
    Mapem {
        station_id: header.station_id.0,
        revision: map.msg_issue_revision.0,
        intersections: intersections
            .into_iter()
            .flat_map(|list| list.0.iter().map(read_intersection))
            .collect(),
    }
}

fn read_intersection(geometry: &dsrc::IntersectionGeometry) -> IntersectionGeometry {
    let lanes: Vec<Lane> = geometry.lane_set.0.iter().filter_map(read_lane).collect();
    IntersectionGeometry {
        region: geometry.id.region.as_ref().map(|region| region.0),
        id: geometry.id.id.0,
        revision: geometry.revision.0,
        reference: Position {
            latitude: geometry.ref_point.lat.0,
            longitude: geometry.ref_point.long.0,
        },
        lane_width_cm: geometry.lane_width.as_ref().map(|width| width.0),
        unread_lanes: geometry.lane_set.0.len() - lanes.len(),
        lanes,
    }
}

/// `None` for a lane with unread nodes, and for one that is not for vehicles.
fn read_lane(lane: &dsrc::GenericLane) -> Option<Lane> {
    if !matches!(lane.lane_attributes.lane_type, dsrc::LaneTypeAttributes::vehicle(_)) {
        return None;
    }
    let dsrc::NodeListXY::nodes(nodes) = &lane.node_list else { return None };
    let direction = flags(&lane.lane_attributes.directional_use.0);
    let approach = match (&lane.ingress_approach, &lane.egress_approach) {
        (Some(number), _) if direction & 1 != 0 => Approach::Ingress(number.0),
        (_, Some(number)) if direction & 2 != 0 => Approach::Egress(number.0),
        _ => return None,
    };
    Some(Lane {
        id: lane.lane_id.0,
        approach,
        maneuvers: lane.maneuvers.as_ref().map_or(0, |maneuvers| flags(&maneuvers.0)),
        nodes: nodes.0.iter().map(|node| read_offset(&node.delta)).collect::<Option<_>>()?,
        connections: (lane.connects_to.iter())
            .flat_map(|list| list.0.iter().map(read_connection))
            .collect(),
    })
}

fn read_connection(connection: &dsrc::Connection) -> Connection {
    Connection {
        lane: connection.connecting_lane.lane.0,
        maneuver: connection.connecting_lane.maneuver.as_ref().map(|m| flags(&m.0)),
        signal_group: connection.signal_group.as_ref().map(|group| group.0),
    }
}

fn read_offset(offset: &Offset) -> Option<(i16, i16)> {
    Some(match offset {
        Offset::node_XY1(node) => (node.x.0, node.y.0),
        Offset::node_XY2(node) => (node.x.0, node.y.0),
        Offset::node_XY3(node) => (node.x.0, node.y.0),
        Offset::node_XY4(node) => (node.x.0, node.y.0),
        Offset::node_XY5(node) => (node.x.0, node.y.0),
        Offset::node_XY6(node) => (node.x.0, node.y.0),
        Offset::node_LatLon(_) | Offset::regional(_) => return None,
    })
}

fn cam(pdu::CAM { header, cam }: &pdu::CAM) -> Result<Cam, Refused> {
    let parameters = &cam.cam_parameters;
    let basic = &parameters.basic_container;
    let pdu::HighFrequencyContainer::basicVehicleContainerHighFrequency(fast) =
        &parameters.high_frequency_container
    else {
        return Err(Refused("not a vehicle's".to_owned()));
    };
    Ok(Cam {
        station_id: header.station_id.0,
        generation_delta: cam.generation_delta_time.0,
        station_type: basic.station_type.0,
        position: Position {
            latitude: basic.reference_position.latitude.0,
            longitude: basic.reference_position.longitude.0,
        },
        motion: Motion {
            heading: fast.heading.heading_value.0,
            speed: fast.speed.speed_value.0,
            acceleration: fast.longitudinal_acceleration.longitudinal_acceleration_value.0,
            yaw_rate: fast.yaw_rate.yaw_rate_value.0,
            length: fast.vehicle_length.vehicle_length_value.0,
            width: fast.vehicle_width.0,
        },
        low_frequency: parameters.low_frequency_container.as_ref().map(read_low_frequency),
    })
}

fn read_low_frequency(slow: &pdu::LowFrequencyContainer) -> LowFrequency {
    let pdu::LowFrequencyContainer::basicVehicleContainerLowFrequency(slow) = slow else {
        return LowFrequency { role: 0, lights: 0 };
    };
    LowFrequency { role: slow.vehicle_role as u8, lights: flags(&slow.exterior_lights.0) as u8 }
}
