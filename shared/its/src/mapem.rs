//! MAPEM: geometry of lanes and stop lines (ETSI TS 103 301, SAE J2735 `MapData`).

use crate::geodesy::Position;

/// The geometry of one or more intersections.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mapem {
    pub station_id: u32,
    /// `msgIssueRevision`, 0 to 127.
    pub revision: u8,
    /// The intersections, 1 to 32.
    pub intersections: Vec<IntersectionGeometry>,
}

/// `IntersectionGeometry`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IntersectionGeometry {
    /// Road regulator, if the id is not unique without it.
    pub region: Option<u16>,
    pub id: u16,
    /// Counts changes of the geometry, 0 to 127.
    pub revision: u8,
    /// The reference point of the lanes.
    pub reference: Position,
    pub lane_width_cm: Option<u16>,
    /// The lanes, 1 to 255.
    pub lanes: Vec<Lane>,
    /// Number of received lanes in forms that are not read here (computed from another lane, or by a regional
    /// extension).
    pub unread_lanes: usize,
}

/// `GenericLane`, for vehicles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lane {
    /// Id of the lane in its intersection.
    pub id: u8,
    pub approach: Approach,
    /// Allowed manoeuvres at its end: a set of [`STRAIGHT`], [`LEFT`], [`RIGHT`] and the standard's others.
    pub maneuvers: u16,
    /// The middle of the lane, cm to the east and to the north. It has 2 to 63 nodes from the stop line outwards. The
    /// first is relative to the reference point, the others to the previous node.
    pub nodes: Vec<(i16, i16)>,
    /// Continuations, up to 16.
    pub connections: Vec<Connection>,
}

/// Direction of a lane, with the number of its approach, 0 to 15.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Approach {
    /// To the intersection: its first node is the stop line.
    Ingress(u8),
    /// Away from the intersection.
    Egress(u8),
}

impl Default for Approach {
    fn default() -> Self {
        Self::Ingress(0)
    }
}

/// `Connection`: from an ingress lane to an egress lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Connection {
    /// Id of the egress lane.
    pub lane: u8,
    /// Manoeuvre, as in [`Lane::maneuvers`].
    pub maneuver: Option<u16>,
    pub signal_group: Option<u8>,
}

/// `maneuverStraightAllowed`.
pub const STRAIGHT: u16 = 1 << 0;
/// `maneuverLeftAllowed`.
pub const LEFT: u16 = 1 << 1;
/// `maneuverRightAllowed`.
pub const RIGHT: u16 = 1 << 2;
