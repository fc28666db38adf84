//! MAPEM.

use super::spatem::{header, reference};
use super::uper::Writer;
use super::{flags, from_uper};
use crate::geodesy::Position;
use crate::mapem::{Approach, Connection, IntersectionGeometry, Lane, Mapem};
use crate::{DecodeError, EncodeError, MessageKind};
use c_its_parser::standards::dsrc_2_2_1::etsi_its_dsrc as dsrc;
use c_its_parser::standards::mapem_2_2_1::mapem_pdu_descriptions::MAPEM;
use dsrc::NodeOffsetPointXY as Offset;
use std::ops::RangeInclusive;

/// `LaneSharing`: bit 3, motor vehicles.
const MOTOR_VEHICLES: u16 = 1 << 3;
/// `LaneDirection`.
const INGRESS: u16 = 1 << 0;
const EGRESS: u16 = 1 << 1;
/// `LayerType`.
const INTERSECTION_DATA: u8 = 3;
/// `LaneTypeAttributes`.
const VEHICLE: u8 = 0;
/// `NodeListXY`.
const NODES: u8 = 0;
/// Bits of each coordinate in the first forms of `NodeOffsetPointXY`.
const OFFSET_BITS: [u32; 6] = [10, 11, 12, 13, 14, 16];

pub(crate) fn encode(message: &Mapem) -> Result<Vec<u8>, EncodeError> {
    let mut to = header(MessageKind::Mapem, message.station_id)?;
    to.not_extended();
    // timeStamp, layerType, layerID, intersections, roadSegments, dataParameters, restrictionList, regional.
    to.present([false, true, false, true, false, false, false, false]);
    to.number("revision of the message", message.revision, 0..=127)?;
    to.not_extended();
    to.number("layer type", INTERSECTION_DATA, 0..=7)?;
    to.list("intersections", &message.intersections, 1..=32, intersection)?;
    Ok(to.finish())
}

pub(crate) fn decode(payload: &[u8]) -> Result<Mapem, DecodeError> {
    let MAPEM { header, map } = from_uper(payload)?;
    let intersections = map.intersections.as_ref();
    Ok(Mapem {
        station_id: header.station_id.0,
        revision: map.msg_issue_revision.0,
        intersections: intersections
            .into_iter()
            .flat_map(|list| list.0.iter().map(read_intersection))
            .collect(),
    })
}

fn intersection(to: &mut Writer, geometry: &IntersectionGeometry) -> Result<(), EncodeError> {
    to.not_extended();
    // name, laneWidth, speedLimits, preemptPriorityData, regional.
    to.present([false, geometry.lane_width_cm.is_some(), false, false, false]);
    reference(to, geometry.region, geometry.id)?;
    to.number("revision", geometry.revision, 0..=127)?;
    to.not_extended();
    // elevation, regional.
    to.present([false; 2]);
    let Position { latitude, longitude } = geometry.reference;
    to.number("latitude", latitude, -900_000_000..=900_000_001)?;
    to.number("longitude", longitude, -1_800_000_000..=1_800_000_001)?;
    to.some_number("lane width", geometry.lane_width_cm, 0..=32_767)?;
    to.list("lanes", &geometry.lanes, 1..=255, lane)
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

fn lane(to: &mut Writer, lane: &Lane) -> Result<(), EncodeError> {
    let (direction, ingress, egress) = match lane.approach {
        Approach::Ingress(number) => (INGRESS, Some(number), None),
        Approach::Egress(number) => (EGRESS, None, Some(number)),
    };
    let connects = !lane.connections.is_empty();
    to.not_extended();
    // name, ingressApproach, egressApproach, maneuvers, connectsTo, overlays, regional.
    to.present([false, ingress.is_some(), egress.is_some(), true, connects, false, false]);
    to.number("lane", lane.id, 0..=255)?;
    to.some_number("approach", ingress, 0..=15)?;
    to.some_number("approach", egress, 0..=15)?;
    // LaneAttributes: regional.
    to.present([false]);
    to.flags(direction, 2);
    to.flags(MOTOR_VEHICLES, 10);
    to.not_extended();
    to.number("kind of lane", VEHICLE, 0..=7)?;
    // Nothing special, in the eight bits that need no length.
    to.not_extended();
    to.flags(0, 8);
    to.flags(lane.maneuvers, 12);
    to.not_extended();
    to.number("kind of nodes", NODES, 0..=1)?;
    to.list("nodes", &lane.nodes, 2..=63, node)?;
    if connects { to.list("connections", &lane.connections, 1..=16, connection) } else { Ok(()) }
}

/// In the shortest form that has room for it, where the lowest number of each but the longest means that the
/// offset is unknown.
fn node(to: &mut Writer, &(x, y): &(i16, i16)) -> Result<(), EncodeError> {
    to.not_extended();
    // attributes.
    to.present([false]);
    let farthest = x.unsigned_abs().max(y.unsigned_abs());
    let form = OFFSET_BITS.iter().take_while(|bits| farthest >> (**bits - 1) != 0).count();
    let form = form.min(OFFSET_BITS.len() - 1);
    let range = within(OFFSET_BITS[form]);
    to.number("form of a node", form as i64, 0..=7)?;
    to.number("east", x, range.clone())?;
    to.number("north", y, range)
}

/// The numbers of so many bits.
fn within(bits: u32) -> RangeInclusive<i64> {
    -(1 << (bits - 1))..=(1 << (bits - 1)) - 1
}

/// `None` for a lane whose nodes are not read here, and for one that is not for vehicles.
fn read_lane(lane: &dsrc::GenericLane) -> Option<Lane> {
    if !matches!(lane.lane_attributes.lane_type, dsrc::LaneTypeAttributes::vehicle(_)) {
        return None;
    }
    let dsrc::NodeListXY::nodes(nodes) = &lane.node_list else { return None };
    let direction = flags(&lane.lane_attributes.directional_use.0);
    let approach = match (&lane.ingress_approach, &lane.egress_approach) {
        (Some(number), _) if direction & INGRESS != 0 => Approach::Ingress(number.0),
        (_, Some(number)) if direction & EGRESS != 0 => Approach::Egress(number.0),
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

fn connection(to: &mut Writer, connection: &Connection) -> Result<(), EncodeError> {
    // remoteIntersection, signalGroup, userClass, connectionID.
    to.present([false, connection.signal_group.is_some(), false, false]);
    // ConnectingLane: maneuver.
    to.present([connection.maneuver.is_some()]);
    to.number("connecting lane", connection.lane, 0..=255)?;
    if let Some(maneuver) = connection.maneuver {
        to.flags(maneuver, 12);
    }
    to.some_number("signal group", connection.signal_group, 0..=255)
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
