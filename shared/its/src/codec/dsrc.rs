//! Parts of SPATEM and MAPEM that are checked and skipped (module ETSI-ITS-DSRC of ETSI TS 103 301 V2.2.1).

use super::uper::{Form, Number, Part, enumeration, extensible, fixed, list, optional, required};
use super::{LATITUDE, LONGITUDE};

/// `MinuteOfTheYear`.
pub(super) const MINUTE: Number = Number::new("minute", 0, 527_040);
/// `RoadRegulatorID`.
pub(super) const REGION: Number = Number::new("region", 0, 65_535);
/// `LaneID`.
pub(super) const LANE_ID: Number = Number::new("lane", 0, 255);
/// `MsgCount`.
pub(super) const REVISION: Number = Number::new("revision", 0, 127);
/// `SignalGroupID`.
pub(super) const SIGNAL_GROUP: Number = Number::new("signal group", 0, 255);
/// `ApproachID`.
pub(super) const APPROACH: Number = Number::new("approach", 0, 15);
/// `LaneWidth`.
pub(super) const LANE_WIDTH: Number = Number::new("lane width", 0, 32_767);
/// `Offset-B10` to `Offset-B14` and `Offset-B16`: coordinates of the first forms of `NodeOffsetPointXY`.
pub(super) const OFFSETS: [Number; 6] =
    [offset(10), offset(11), offset(12), offset(13), offset(14), offset(16)];

const fn offset(bits: u32) -> Number {
    Number::new("offset of a node", -(1 << (bits - 1)), (1 << (bits - 1)) - 1)
}

const CONNECTION_ID: Part = Part::whole("connection", 0, 255);
const RESTRICTION_CLASS: Part = Part::whole("restriction class", 0, 255);
const ZONE_LENGTH: Part = Part::whole("zone's length", 0, 10_000);
const CHARACTER: Part = Part::whole("character", 0, 127);

/// `DescriptiveName`.
pub(super) const NAME: Part = list("characters of a name", 1..=63, &CHARACTER);

/// `RegionalExtension`.
pub(super) const REGIONAL: Part =
    fixed(&[required(Part::whole("region's id", 0, 255)), required(Part::Open)]);

/// One to four regional extensions, as in most types.
pub(super) const REGIONALS: Part = list("regional extensions", 1..=4, &REGIONAL);

/// `EnabledLaneList`.
pub(super) const ENABLED_LANES: Part = list("enabled lanes", 1..=16, &Part::Whole(LANE_ID));

/// `ManeuverAssistList`.
pub(super) const MANEUVER_ASSIST: Part = list(
    "manoeuvre assists",
    1..=16,
    &extensible(&[
        required(CONNECTION_ID),
        optional(ZONE_LENGTH),
        optional(ZONE_LENGTH),
        optional(Part::whole("wait on stop", 0, 1)),
        optional(Part::whole("pedestrian or bicycle", 0, 1)),
        optional(REGIONALS),
    ]),
);

/// `AdvisorySpeedList`.
pub(super) const ADVISORY_SPEEDS: Part = list(
    "advisory speeds",
    1..=16,
    &extensible(&[
        required(enumeration("kind of advisory speed", 3)),
        optional(Part::whole("advisory speed", 0, 500)),
        optional(Part::whole("confidence in a speed", 0, 7)),
        optional(ZONE_LENGTH),
        optional(RESTRICTION_CLASS),
        optional(REGIONALS),
    ]),
);

/// `LayerType`.
pub(super) const LAYER_TYPE: Number = Number::new("layer type", 0, 7);

/// `LayerID`.
pub(super) const LAYER_ID: Part = Part::whole("layer", 0, 100);

/// `SpeedLimitList`.
pub(super) const SPEED_LIMITS: Part = list(
    "speed limits",
    1..=9,
    &fixed(&[
        required(enumeration("kind of speed limit", 12)),
        required(Part::whole("speed limit", 0, 8191)),
    ]),
);

/// `Elevation`.
pub(super) const ELEVATION: Part = Part::whole("elevation", -4096, 61_439);

/// `PreemptPriorityList`.
pub(super) const PREEMPT_PRIORITY: Part =
    list("zones of priority", 1..=32, &extensible(&[required(REGIONAL)]));

/// Alternatives of `LaneTypeAttributes`. The first is a vehicle's.
pub(super) const LANE_TYPES: i64 = 8;
pub(super) const VEHICLE_ATTRIBUTES: Part = Part::ExtensibleBits(8);
pub(super) const OTHER_ATTRIBUTES: Part = Part::bits("attributes of a lane", 16);

/// `OverlayLaneList`.
pub(super) const OVERLAYS: Part = list("overlays", 1..=5, &Part::Whole(LANE_ID));

const SMALL_OFFSET: Part = Part::whole("offset of a lane", -2047, 2047);
const LARGE_OFFSET: Part = Part::whole("offset of a lane", -32_767, 32_767);
const LANE_OFFSET: Part = Part::Choice(Form::Fixed, &[&SMALL_OFFSET, &LARGE_OFFSET]);
const SCALE: Part = Part::whole("scale", -2048, 2047);

/// `ComputedLane`.
pub(super) const COMPUTED_LANE: Part = extensible(&[
    required(Part::Whole(LANE_ID)),
    required(LANE_OFFSET),
    required(LANE_OFFSET),
    optional(Part::whole("rotation", 0, 28_800)),
    optional(SCALE),
    optional(SCALE),
    optional(REGIONALS),
]);

/// `Node-LLmD-64b`.
pub(super) const NODE_AT_POSITION: Part =
    fixed(&[required(Part::Whole(LONGITUDE)), required(Part::Whole(LATITUDE))]);

const CROWN_ANGLE: Part = Part::whole("crown angle", -128, 127);

const LANE_DATA: Part = Part::Choice(
    Form::Extensible,
    &[
        &Part::whole("end angle of a path", -150, 150),
        &CROWN_ANGLE,
        &CROWN_ANGLE,
        &CROWN_ANGLE,
        &Part::whole("angle of a lane", -180, 180),
        &SPEED_LIMITS,
        &REGIONALS,
    ],
);

const SEGMENT_ATTRIBUTES: Part =
    list("attributes of a segment", 1..=8, &enumeration("attribute of a segment", 37));

/// `NodeAttributeSetXY`.
pub(super) const NODE_ATTRIBUTES: Part = extensible(&[
    optional(list("attributes of a node", 1..=8, &enumeration("attribute of a node", 11))),
    optional(SEGMENT_ATTRIBUTES),
    optional(SEGMENT_ATTRIBUTES),
    optional(list("data of a lane", 1..=8, &LANE_DATA)),
    optional(Part::Whole(OFFSETS[0])),
    optional(Part::Whole(OFFSETS[0])),
    optional(REGIONALS),
]);

const TEXT: Part = list("characters of a text", 1..=255, &CHARACTER);

/// `DataParameters`.
pub(super) const DATA_PARAMETERS: Part =
    extensible(&[optional(TEXT), optional(TEXT), optional(TEXT), optional(TEXT)]);

const USER: Part = Part::Choice(Form::Extensible, &[&enumeration("restriction", 13), &REGIONALS]);

/// `RestrictionClassList`.
pub(super) const RESTRICTIONS: Part = list(
    "restrictions",
    1..=254,
    &fixed(&[required(RESTRICTION_CLASS), required(list("restricted users", 1..=16, &USER))]),
);
