//! MAPEM.

use super::dsrc::{
    APPROACH, COMPUTED_LANE, DATA_PARAMETERS, ELEVATION, LANE_ID, LANE_TYPES, LANE_WIDTH, LAYER_ID,
    LAYER_TYPE, LAYER_TYPES, MINUTE, NAME, NODE_AT_POSITION, NODE_ATTRIBUTES, OFFSETS,
    OTHER_ATTRIBUTES, OVERLAYS, PREEMPT_PRIORITY, REGIONAL, REGIONALS, RESTRICTIONS, REVISION,
    SIGNAL_GROUP, SPEED_LIMITS, VEHICLE_ATTRIBUTES,
};
use super::spatem::{INTERSECTIONS, read_reference, write_reference};
use super::uper::{Number, Part, Skip, Source, Writer};
use super::{LATITUDE, LONGITUDE, read_header, write_header};
use crate::geodesy::Position;
use crate::mapem::{Approach, Connection, IntersectionGeometry, Lane, Mapem};
use crate::{EncodeError, MessageKind, PayloadError};

/// `LaneSharing`: bit 3, motor vehicles.
const MOTOR_VEHICLES: u16 = 1 << 3;
/// `LaneDirection`.
const INGRESS: u16 = 1 << 0;
const EGRESS: u16 = 1 << 1;
const DIRECTION_BITS: u32 = 2;
const SHARING_BITS: u32 = 10;
const MANEUVER_BITS: u32 = 12;
/// `LayerType`.
const INTERSECTION_DATA: u8 = 3;
/// `LaneTypeAttributes`.
const VEHICLE: i64 = 0;
/// `NodeListXY`.
const NODES: u8 = 0;

const LANES: Number = Number::new("lanes", 1, 255);
const ROAD_SEGMENTS: Number = Number::new("road segments", 1, 32);
const KIND_OF_LANE: Number = Number::new("kind of lane", 0, LANE_TYPES - 1);
const KIND_OF_NODES: Number = Number::new("kind of nodes", 0, 1);
const NODE_COUNT: Number = Number::new("nodes", 2, 63);
/// The six offsets, a position, a regional extension.
const NODE_FORM: Number = Number::new("form of a node", 0, OFFSETS.len() as i64 + 1);
const CONNECTIONS: Number = Number::new("connections", 1, 16);
const CONNECTING_LANE: Number = Number::new("connecting lane", 0, 255);
const USER_CLASS: Number = Number::new("restriction class", 0, 255);
const CONNECTION_ID: Number = Number::new("connection", 0, 255);

pub(crate) fn encode(message: &Mapem) -> Result<Vec<u8>, EncodeError> {
    let mut to = write_header(MessageKind::Mapem, message.station_id)?;
    to.not_extended();
    // timeStamp, layerType, layerID, intersections, roadSegments, dataParameters, restrictionList, regional.
    to.present([false, true, false, true, false, false, false, false]);
    to.number(REVISION, message.revision)?;
    to.not_extended();
    to.number(Number::new("layer type", 0, LAYER_TYPES), INTERSECTION_DATA)?;
    to.list(INTERSECTIONS, &message.intersections, write_intersection)?;
    Ok(to.finish())
}

pub(super) fn read(from: &mut impl Source) -> Result<Mapem, PayloadError> {
    let station_id = read_header(from)?;
    from.extensible(|from, [stamped, typed, layered, crossings, roads, data, limits, regional]| {
        from.skip(stamped, &Part::Whole(MINUTE))?;
        let revision = from.number(REVISION)?;
        from.skip(typed, &LAYER_TYPE)?;
        from.skip(layered, &LAYER_ID)?;
        let intersections =
            if crossings { from.list(INTERSECTIONS, read_intersection)? } else { Vec::new() };
        if roads {
            from.list(ROAD_SEGMENTS, skip_road_segment)?;
        }
        from.skip(data, &DATA_PARAMETERS)?;
        from.skip(limits, &RESTRICTIONS)?;
        from.skip(regional, &REGIONALS)?;
        Ok(Mapem { station_id, revision, intersections })
    })
}

fn write_intersection(to: &mut Writer, geometry: &IntersectionGeometry) -> Result<(), EncodeError> {
    to.not_extended();
    // name, laneWidth, speedLimits, preemptPriorityData, regional.
    to.present([false, geometry.lane_width_cm.is_some(), false, false, false]);
    write_reference(to, geometry.region, geometry.id)?;
    to.number(REVISION, geometry.revision)?;
    to.not_extended();
    // elevation, regional.
    to.present([false; 2]);
    let Position { latitude, longitude } = geometry.reference;
    to.number(LATITUDE, latitude)?;
    to.number(LONGITUDE, longitude)?;
    to.some_number(LANE_WIDTH, geometry.lane_width_cm)?;
    to.list(LANES, &geometry.lanes, write_lane)
}

fn read_intersection(from: &mut impl Source) -> Result<IntersectionGeometry, PayloadError> {
    from.extensible(|from, [named, wide, limited, preempted, regional]| {
        from.skip(named, &NAME)?;
        let (region, id) = read_reference(from)?;
        let revision = from.number(REVISION)?;
        let reference = read_position(from)?;
        let lane_width_cm = from.some_number(wide, LANE_WIDTH)?;
        from.skip(limited, &SPEED_LIMITS)?;
        let lanes = from.list(LANES, read_lane)?;
        from.skip(preempted, &PREEMPT_PRIORITY)?;
        from.skip(regional, &REGIONALS)?;
        let unread_lanes = lanes.iter().filter(|lane| lane.is_none()).count();
        let lanes = lanes.into_iter().flatten().collect();
        Ok(IntersectionGeometry {
            region,
            id,
            revision,
            reference,
            lane_width_cm,
            lanes,
            unread_lanes,
        })
    })
}

/// A `RoadSegment`: checked and skipped.
fn skip_road_segment(from: &mut impl Source) -> Result<(), PayloadError> {
    from.extensible(|from, [named, wide, limited, regional]| {
        from.skip(named, &NAME)?;
        read_reference(from)?;
        from.whole(REVISION)?;
        read_position(from)?;
        from.some_number::<u16>(wide, LANE_WIDTH)?;
        from.skip(limited, &SPEED_LIMITS)?;
        from.list(LANES, |from| read_lane(from).map(drop))?;
        from.skip(regional, &REGIONALS)
    })
}

/// `Position3D`, without its elevation.
fn read_position(from: &mut impl Source) -> Result<Position, PayloadError> {
    from.extensible(|from, [elevated, regional]| {
        let (latitude, longitude) = (from.number(LATITUDE)?, from.number(LONGITUDE)?);
        from.skip(elevated, &ELEVATION)?;
        from.skip(regional, &REGIONALS)?;
        Ok(Position { latitude, longitude })
    })
}

fn write_lane(to: &mut Writer, lane: &Lane) -> Result<(), EncodeError> {
    let (direction, ingress, egress) = match lane.approach {
        Approach::Ingress(number) => (INGRESS, Some(number), None),
        Approach::Egress(number) => (EGRESS, None, Some(number)),
    };
    let connects = !lane.connections.is_empty();
    to.not_extended();
    // name, ingressApproach, egressApproach, maneuvers, connectsTo, overlays, regional.
    to.present([false, ingress.is_some(), egress.is_some(), true, connects, false, false]);
    to.number(LANE_ID, lane.id)?;
    to.some_number(APPROACH, ingress)?;
    to.some_number(APPROACH, egress)?;
    // LaneAttributes: regional.
    to.present([false]);
    to.flags(direction, DIRECTION_BITS);
    to.flags(MOTOR_VEHICLES, SHARING_BITS);
    to.not_extended();
    to.number(KIND_OF_LANE, VEHICLE)?;
    // No special attributes: eight bits without a length.
    to.not_extended();
    to.flags(0, 8);
    to.flags(lane.maneuvers, MANEUVER_BITS);
    to.not_extended();
    to.number(KIND_OF_NODES, NODES)?;
    to.list(NODE_COUNT, &lane.nodes, write_node)?;
    if connects { to.list(CONNECTIONS, &lane.connections, write_connection) } else { Ok(()) }
}

/// `None` for a lane that is not for vehicles, has no approach, or has nodes other than offsets.
fn read_lane(from: &mut impl Source) -> Result<Option<Lane>, PayloadError> {
    from.extensible(|from, [named, enters, leaves, turns, connects, overlaid, regional]| {
        let id = from.number(LANE_ID)?;
        from.skip(named, &NAME)?;
        let ingress = from.some_number(enters, APPROACH)?;
        let egress = from.some_number(leaves, APPROACH)?;
        let direction = read_attributes(from)?;
        let maneuvers = if turns { from.flags("manoeuvres", MANEUVER_BITS)? } else { 0 };
        let nodes = read_nodes(from)?;
        let connections =
            if connects { from.list(CONNECTIONS, read_connection)? } else { Vec::new() };
        from.skip(overlaid, &OVERLAYS)?;
        from.skip(regional, &REGIONALS)?;
        let approach = match (direction, ingress, egress) {
            (Some(way), Some(number), _) if way & INGRESS != 0 => Some(Approach::Ingress(number)),
            (Some(way), _, Some(number)) if way & EGRESS != 0 => Some(Approach::Egress(number)),
            _ => None,
        };
        Ok(approach.zip(nodes).map(|(approach, nodes)| Lane {
            id,
            approach,
            maneuvers,
            nodes,
            connections,
        }))
    })
}

/// The direction in which vehicles use a lane; `None` if it is not for vehicles.
fn read_attributes(from: &mut impl Source) -> Result<Option<u16>, PayloadError> {
    from.sequence(|from, [regional]| {
        let direction = from.flags("direction", DIRECTION_BITS)?;
        from.flags("sharing", SHARING_BITS)?;
        let direction = if from.extended()? {
            from.pass_small()?;
            from.pass_open()?;
            None
        } else {
            let is_vehicle = from.whole(KIND_OF_LANE)? == VEHICLE;
            let attributes = if is_vehicle { &VEHICLE_ATTRIBUTES } else { &OTHER_ATTRIBUTES };
            from.skip(true, attributes)?;
            is_vehicle.then_some(direction)
        };
        from.skip(regional, &REGIONAL)?;
        Ok(direction)
    })
}

/// The nodes of a lane; `None` for a lane computed from another lane, and for nodes other than offsets.
fn read_nodes(from: &mut impl Source) -> Result<Option<Vec<(i16, i16)>>, PayloadError> {
    if from.extended()? {
        from.pass_small()?;
        from.pass_open()?;
        return Ok(None);
    }
    if from.number::<u8>(KIND_OF_NODES)? != NODES {
        from.skip(true, &COMPUTED_LANE)?;
        return Ok(None);
    }
    Ok(from.list(NODE_COUNT, read_node)?.into_iter().collect())
}

/// Writes the shortest form with room for the node. In all but the longest, the lowest number means an unknown
/// offset.
fn write_node(to: &mut Writer, &(x, y): &(i16, i16)) -> Result<(), EncodeError> {
    to.not_extended();
    // attributes.
    to.present([false]);
    let farthest = i64::from(x.unsigned_abs().max(y.unsigned_abs()));
    let form = OFFSETS.iter().take_while(|offset| !offset.contains(farthest)).count();
    let form = form.min(OFFSETS.len() - 1);
    to.number(NODE_FORM, form as i64)?;
    to.number(OFFSETS[form], x)?;
    to.number(OFFSETS[form], y)
}

fn read_node(from: &mut impl Source) -> Result<Option<(i16, i16)>, PayloadError> {
    from.extensible(|from, [attributed]| {
        let form = from.number::<usize>(NODE_FORM)?;
        let node = match OFFSETS.get(form) {
            Some(offset) => Some((from.number(*offset)?, from.number(*offset)?)),
            None if form == OFFSETS.len() => from.skip(true, &NODE_AT_POSITION).map(|()| None)?,
            None => from.skip(true, &REGIONAL).map(|()| None)?,
        };
        from.skip(attributed, &NODE_ATTRIBUTES)?;
        Ok(node)
    })
}

fn write_connection(to: &mut Writer, connection: &Connection) -> Result<(), EncodeError> {
    // remoteIntersection, signalGroup, userClass, connectionID.
    to.present([false, connection.signal_group.is_some(), false, false]);
    // ConnectingLane: maneuver.
    to.present([connection.maneuver.is_some()]);
    to.number(CONNECTING_LANE, connection.lane)?;
    if let Some(maneuver) = connection.maneuver {
        to.flags(maneuver, MANEUVER_BITS);
    }
    to.some_number(SIGNAL_GROUP, connection.signal_group)
}

fn read_connection(from: &mut impl Source) -> Result<Connection, PayloadError> {
    from.sequence(|from, [remote, signalled, classed, numbered]| {
        let (lane, maneuver) = from.sequence(|from, [turns]| {
            let lane = from.number(CONNECTING_LANE)?;
            let maneuver = turns.then(|| from.flags("manoeuvre", MANEUVER_BITS)).transpose()?;
            Ok((lane, maneuver))
        })?;
        if remote {
            read_reference(from)?;
        }
        let signal_group = from.some_number(signalled, SIGNAL_GROUP)?;
        from.some_number::<u8>(classed, USER_CLASS)?;
        from.some_number::<u8>(numbered, CONNECTION_ID)?;
        Ok(Connection { lane, maneuver, signal_group })
    })
}
