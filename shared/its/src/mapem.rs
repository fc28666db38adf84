//! MAPEM: where lanes and stop lines are (ETSI TS 103 301, SAE J2735 `MapData`).

use crate::geodesy::Position;

/// The geometry of one or more intersections.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mapem {
    /// Station id of the sender.
    pub station_id: u32,
    /// `msgIssueRevision`, 0 to 127.
    pub revision: u8,
    /// The intersections, 1 to 32.
    pub intersections: Vec<IntersectionGeometry>,
}

/// `IntersectionGeometry`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IntersectionGeometry {
    /// Road regulator, where the id is not unique without it.
    pub region: Option<u16>,
    /// Id of the intersection.
    pub id: u16,
    /// Counts changes of the geometry, 0 to 127.
    pub revision: u8,
    /// The point from which lanes are measured.
    pub reference: Position,
    /// Width of a lane, cm.
    pub lane_width_cm: Option<u16>,
    /// The lanes, 1 to 255.
    pub lanes: Vec<Lane>,
    /// Lanes of a received map that are described in a way that is not read here (computed from
    /// another lane, by a regional extension).
    pub unread_lanes: usize,
}

/// `GenericLane`, for vehicles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lane {
    /// Id of the lane in its intersection.
    pub id: u8,
    /// Which way it leads.
    pub approach: Approach,
    /// What is allowed at its end: a set of [`STRAIGHT`], [`LEFT`], [`RIGHT`] and the standard's others.
    pub maneuvers: u16,
    /// The middle of the lane, cm to the east and to the north, each from the one before, the first
    /// from the reference point: 2 to 63, from the stop line outwards.
    pub nodes: Vec<(i16, i16)>,
    /// Where it goes on, up to 16.
    pub connections: Vec<Connection>,
}

/// Which way a lane leads, with the number of its approach, 0 to 15.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Approach {
    /// To the intersection: its first node is the stop line.
    Ingress(u8),
    /// Away from it.
    Egress(u8),
}

/// `Connection`: from an ingress lane to an egress lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Connection {
    /// Id of the egress lane.
    pub lane: u8,
    /// What kind of manoeuvre that is, as in [`Lane::maneuvers`].
    pub maneuver: Option<u16>,
    /// The signal group that governs it.
    pub signal_group: Option<u8>,
}

/// `maneuverStraightAllowed`.
pub const STRAIGHT: u16 = 1 << 0;
/// `maneuverLeftAllowed`.
pub const LEFT: u16 = 1 << 1;
/// `maneuverRightAllowed`.
pub const RIGHT: u16 = 1 << 2;
