//! MAPEM.

use super::spatem::{header, reference};
use super::{bits, flags, from_uper, to_uper};
use crate::geodesy::Position;
use crate::mapem::{Approach, Connection, IntersectionGeometry, Lane, Mapem};
use crate::{DecodeError, EncodeError, MessageKind};
use c_its_parser::standards::cdd_2_2_1::etsi_its_cdd as cdd;
use c_its_parser::standards::dsrc_2_2_1::etsi_its_dsrc as dsrc;
use c_its_parser::standards::mapem_2_2_1::mapem_pdu_descriptions::MAPEM;
use dsrc::NodeOffsetPointXY as Offset;

/// `LaneSharing`: bit 3, motor vehicles.
const MOTOR_VEHICLES: u16 = 1 << 3;
/// `LaneDirection`.
const INGRESS: u16 = 1 << 0;
const EGRESS: u16 = 1 << 1;
/// Bits of `LaneAttributes-Vehicle`, all 0: nothing special.
const VEHICLE_BITS: usize = 8;

pub(crate) fn encode(message: &Mapem) -> Result<Vec<u8>, EncodeError> {
    let intersections = message.intersections.iter().map(intersection).collect();
    to_uper(&MAPEM::new(
        header(MessageKind::Mapem, message.station_id),
        dsrc::MapData::new(
            None,
            dsrc::MsgCount(message.revision),
            Some(dsrc::LayerType::intersectionData),
            None,
            Some(dsrc::IntersectionGeometryList(intersections)),
            None,
            None,
            None,
            None,
        ),
    ))
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

fn intersection(geometry: &IntersectionGeometry) -> dsrc::IntersectionGeometry {
    let Position { latitude, longitude } = geometry.reference;
    dsrc::IntersectionGeometry::new(
        None,
        reference(geometry.region, geometry.id),
        dsrc::MsgCount(geometry.revision),
        dsrc::Position3D::new(cdd::Latitude(latitude), cdd::Longitude(longitude), None, None),
        geometry.lane_width_cm.map(dsrc::LaneWidth),
        None,
        dsrc::LaneList(geometry.lanes.iter().map(lane).collect()),
        None,
        None,
    )
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

fn lane(lane: &Lane) -> dsrc::GenericLane {
    let approach = |number| Some(dsrc::ApproachID(number));
    let (direction, ingress, egress) = match lane.approach {
        Approach::Ingress(number) => (INGRESS, approach(number), None),
        Approach::Egress(number) => (EGRESS, None, approach(number)),
    };
    let vehicle = rasn::types::BitString::repeat(false, VEHICLE_BITS);
    let nodes = lane.nodes.iter().map(|&(x, y)| dsrc::NodeXY::new(offset(x, y), None));
    let connections = lane.connections.iter().map(connection).collect::<Vec<_>>();
    dsrc::GenericLane::new(
        dsrc::LaneID(lane.id),
        None,
        ingress,
        egress,
        dsrc::LaneAttributes::new(
            dsrc::LaneDirection(bits(direction)),
            dsrc::LaneSharing(bits(MOTOR_VEHICLES)),
            dsrc::LaneTypeAttributes::vehicle(dsrc::LaneAttributesVehicle(vehicle)),
            None,
        ),
        Some(dsrc::AllowedManeuvers(bits(lane.maneuvers))),
        dsrc::NodeListXY::nodes(dsrc::NodeSetXY(nodes.collect())),
        (!connections.is_empty()).then_some(dsrc::ConnectsToList(connections)),
        None,
        None,
    )
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

fn connection(connection: &Connection) -> dsrc::Connection {
    let maneuver = connection.maneuver.map(|flags| dsrc::AllowedManeuvers(bits(flags)));
    dsrc::Connection::new(
        dsrc::ConnectingLane::new(dsrc::LaneID(connection.lane), maneuver),
        None,
        connection.signal_group.map(dsrc::SignalGroupID),
        None,
        None,
    )
}

fn read_connection(connection: &dsrc::Connection) -> Connection {
    Connection {
        lane: connection.connecting_lane.lane.0,
        maneuver: connection.connecting_lane.maneuver.as_ref().map(|m| flags(&m.0)),
        signal_group: connection.signal_group.as_ref().map(|group| group.0),
    }
}

/// The shortest form that has room for it.
fn offset(x: i16, y: i16) -> Offset {
    let farthest = x.unsigned_abs().max(y.unsigned_abs());
    match farthest {
        0..512 => Offset::node_XY1(dsrc::NodeXY20b::new(dsrc::OffsetB10(x), dsrc::OffsetB10(y))),
        512..1024 => Offset::node_XY2(dsrc::NodeXY22b::new(dsrc::OffsetB11(x), dsrc::OffsetB11(y))),
        1024..2048 => {
            Offset::node_XY3(dsrc::NodeXY24b::new(dsrc::OffsetB12(x), dsrc::OffsetB12(y)))
        }
        2048..4096 => {
            Offset::node_XY4(dsrc::NodeXY26b::new(dsrc::OffsetB13(x), dsrc::OffsetB13(y)))
        }
        4096..8192 => {
            Offset::node_XY5(dsrc::NodeXY28b::new(dsrc::OffsetB14(x), dsrc::OffsetB14(y)))
        }
        _ => Offset::node_XY6(dsrc::NodeXY32b::new(dsrc::OffsetB16(x), dsrc::OffsetB16(y))),
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
