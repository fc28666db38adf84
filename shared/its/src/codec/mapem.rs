//! MAPEM.

use super::dsrc::{
    APPROACH, COMPUTED_LANE, DATA_PARAMETERS, ELEVATION, LANE_ID, LANE_TYPES, LANE_WIDTH, LAYER_ID,
    LAYER_TYPE, MINUTE, NAME, NODE_AT_POSITION, NODE_ATTRIBUTES, OFFSETS, OTHER_ATTRIBUTES,
    OVERLAYS, PREEMPT_PRIORITY, REGIONAL, REGIONALS, RESTRICTIONS, REVISION, SIGNAL_GROUP,
    SPEED_LIMITS, VEHICLE_ATTRIBUTES,
};
use super::spatem::{INTERSECTIONS, reference};
use super::uper::{Fields, Number, Part, Skip};
use super::{LATITUDE, LONGITUDE, STATION_ID};
use crate::PayloadError;
use crate::geodesy::Position;
use crate::mapem::{Approach, Connection, IntersectionGeometry, Lane, Mapem};

/// `LaneSharing`: bit 3, motor vehicles.
const MOTOR_VEHICLES: u16 = 1 << 3;
/// `LaneDirection`.
const INGRESS: u16 = 1 << 0;
const EGRESS: u16 = 1 << 1;
const DIRECTION_BITS: u32 = 2;
const SHARING_BITS: u32 = 10;
const MANEUVER_BITS: u32 = 12;
/// `LayerType`.
const INTERSECTION_DATA: i64 = 3;
/// `LaneTypeAttributes`.
const VEHICLE: i64 = 0;
/// `NodeListXY`.
const NODES: i64 = 0;

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

pub(super) fn walk(fields: &mut impl Fields, message: &mut Mapem) -> Result<(), PayloadError> {
    fields.number(STATION_ID, &mut message.station_id)?;
    let there = [false, true, false, true, false, false, false, false];
    fields.extensible(there, |fields, there| {
        let [stamped, typed, layered, crossings, roads, data, limits, regional] = there;
        fields.skip(stamped, &Part::Whole(MINUTE))?;
        fields.number(REVISION, &mut message.revision)?;
        if typed {
            fields.enumeration(LAYER_TYPE, INTERSECTION_DATA)?;
        }
        fields.skip(layered, &LAYER_ID)?;
        if crossings {
            fields.list(INTERSECTIONS, &mut message.intersections, intersection)?;
        }
        if roads {
            fields.list(ROAD_SEGMENTS, &mut Vec::new(), road_segment)?;
        }
        fields.skip(data, &DATA_PARAMETERS)?;
        fields.skip(limits, &RESTRICTIONS)?;
        fields.skip(regional, &REGIONALS)
    })
}

fn intersection(
    fields: &mut impl Fields,
    geometry: &mut IntersectionGeometry,
) -> Result<(), PayloadError> {
    let there = [false, geometry.lane_width_cm.is_some(), false, false, false];
    fields.extensible(there, |fields, [named, wide, limited, preempted, regional]| {
        fields.skip(named, &NAME)?;
        reference(fields, &mut geometry.region, &mut geometry.id)?;
        fields.number(REVISION, &mut geometry.revision)?;
        position(fields, &mut geometry.reference)?;
        fields.some_number(wide, LANE_WIDTH, &mut geometry.lane_width_cm)?;
        fields.skip(limited, &SPEED_LIMITS)?;
        geometry.unread_lanes = lanes(fields, &mut geometry.lanes)?;
        fields.skip(preempted, &PREEMPT_PRIORITY)?;
        fields.skip(regional, &REGIONALS)
    })
}

/// A `RoadSegment`: checked and skipped.
fn road_segment(fields: &mut impl Fields, (): &mut ()) -> Result<(), PayloadError> {
    fields.extensible([false; 4], |fields, [named, wide, limited, regional]| {
        fields.skip(named, &NAME)?;
        reference(fields, &mut None, &mut 0)?;
        fields.unread(REVISION)?;
        position(fields, &mut Position::default())?;
        fields.skip(wide, &Part::Whole(LANE_WIDTH))?;
        fields.skip(limited, &SPEED_LIMITS)?;
        lanes(fields, &mut Vec::new())?;
        fields.skip(regional, &REGIONALS)
    })
}

/// `Position3D`, without its elevation.
fn position(fields: &mut impl Fields, position: &mut Position) -> Result<(), PayloadError> {
    fields.extensible([false; 2], |fields, [elevated, regional]| {
        fields.number(LATITUDE, &mut position.latitude)?;
        fields.number(LONGITUDE, &mut position.longitude)?;
        fields.skip(elevated, &ELEVATION)?;
        fields.skip(regional, &REGIONALS)
    })
}

/// The lanes in a form that is read here. Returns the number of the others.
fn lanes(fields: &mut impl Fields, lanes: &mut Vec<Lane>) -> Result<usize, PayloadError> {
    let mut are_known = Vec::new();
    fields.list(LANES, lanes, |fields, each| {
        are_known.push(lane(fields, each)?);
        Ok(())
    })?;
    let mut known = are_known.iter();
    lanes.retain(|_| known.next() == Some(&true));
    Ok(are_known.len() - lanes.len())
}

/// False for a lane that is not for vehicles, has no approach, or has nodes other than offsets.
fn lane(fields: &mut impl Fields, lane: &mut Lane) -> Result<bool, PayloadError> {
    let (mut direction, mut ingress, mut egress) = match lane.approach {
        Approach::Ingress(number) => (INGRESS, Some(number), None),
        Approach::Egress(number) => (EGRESS, None, Some(number)),
    };
    let connects = !lane.connections.is_empty();
    let there = [false, ingress.is_some(), egress.is_some(), true, connects, false, false];
    fields.extensible(there, |fields, there| {
        let [named, enters, leaves, turns, connects, overlaid, regional] = there;
        fields.number(LANE_ID, &mut lane.id)?;
        fields.skip(named, &NAME)?;
        fields.some_number(enters, APPROACH, &mut ingress)?;
        fields.some_number(leaves, APPROACH, &mut egress)?;
        let is_vehicles = attributes(fields, &mut direction)?;
        if turns {
            fields.flags("manoeuvres", MANEUVER_BITS, &mut lane.maneuvers)?;
        }
        let are_offsets = nodes(fields, &mut lane.nodes)?;
        if connects {
            fields.list(CONNECTIONS, &mut lane.connections, connection)?;
        }
        fields.skip(overlaid, &OVERLAYS)?;
        fields.skip(regional, &REGIONALS)?;
        let approach = match (ingress, egress) {
            (Some(number), _) if direction & INGRESS != 0 => Some(Approach::Ingress(number)),
            (_, Some(number)) if direction & EGRESS != 0 => Some(Approach::Egress(number)),
            _ => None,
        };
        lane.approach = approach.unwrap_or_default();
        Ok(is_vehicles && are_offsets && approach.is_some())
    })
}

/// The direction in which a lane is used; false if it is not for vehicles.
fn attributes(fields: &mut impl Fields, direction: &mut u16) -> Result<bool, PayloadError> {
    fields.sequence([false], |fields, [regional]| {
        fields.flags("direction", DIRECTION_BITS, direction)?;
        fields.flags("sharing", SHARING_BITS, &mut MOTOR_VEHICLES.clone())?;
        let is_vehicles = if fields.extended()? {
            fields.pass_small()?;
            fields.pass_open()?;
            false
        } else {
            let is_vehicles = fields.whole(KIND_OF_LANE, VEHICLE)? == VEHICLE;
            // The special attributes of a lane for vehicles are not written.
            let attributes = if is_vehicles { &VEHICLE_ATTRIBUTES } else { &OTHER_ATTRIBUTES };
            fields.skip(true, attributes)?;
            is_vehicles
        };
        fields.skip(regional, &REGIONAL)?;
        Ok(is_vehicles)
    })
}

/// The nodes of a lane; false for a lane computed from another lane, and for nodes other than offsets.
fn nodes(fields: &mut impl Fields, nodes: &mut Vec<(i16, i16)>) -> Result<bool, PayloadError> {
    if fields.extended()? {
        fields.pass_small()?;
        fields.pass_open()?;
        return Ok(false);
    }
    if fields.whole(KIND_OF_NODES, NODES)? != NODES {
        fields.skip(true, &COMPUTED_LANE)?;
        return Ok(false);
    }
    let mut are_offsets = true;
    fields.list(NODE_COUNT, nodes, |fields, each| {
        are_offsets &= node(fields, each)?;
        Ok(())
    })?;
    Ok(are_offsets)
}

/// An offset in the shortest form with room for it; false for another form. In all but the longest, the lowest number
/// means an unknown offset.
fn node(fields: &mut impl Fields, (x, y): &mut (i16, i16)) -> Result<bool, PayloadError> {
    fields.extensible([false], |fields, [attributed]| {
        let farthest = i64::from(x.unsigned_abs().max(y.unsigned_abs()));
        let form = OFFSETS.iter().take_while(|offset| !offset.contains(farthest)).count();
        let form = form.min(OFFSETS.len() - 1);
        let form = fields.whole(NODE_FORM, form as i64)? as usize;
        match OFFSETS.get(form) {
            Some(offset) => {
                fields.number(*offset, x)?;
                fields.number(*offset, y)?;
            }
            None if form == OFFSETS.len() => fields.skip(true, &NODE_AT_POSITION)?,
            None => fields.skip(true, &REGIONAL)?,
        }
        fields.skip(attributed, &NODE_ATTRIBUTES)?;
        Ok(form < OFFSETS.len())
    })
}

fn connection(fields: &mut impl Fields, to: &mut Connection) -> Result<(), PayloadError> {
    let there = [false, to.signal_group.is_some(), false, false];
    fields.sequence(there, |fields, [remote, signalled, classed, numbered]| {
        fields.sequence([to.maneuver.is_some()], |fields, [turns]| {
            fields.number(CONNECTING_LANE, &mut to.lane)?;
            if turns {
                let maneuver = to.maneuver.get_or_insert_default();
                fields.flags("manoeuvre", MANEUVER_BITS, maneuver)?;
            }
            Ok(())
        })?;
        if remote {
            reference(fields, &mut None, &mut 0)?;
        }
        fields.some_number(signalled, SIGNAL_GROUP, &mut to.signal_group)?;
        fields.skip(classed, &Part::Whole(USER_CLASS))?;
        fields.skip(numbered, &Part::Whole(CONNECTION_ID))
    })
}
