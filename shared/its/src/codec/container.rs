//! Parts of a CAM that are checked and skipped. Sources: module ITS-Container of ETSI TS 102 894-2 V1.3.1, and ETSI EN
//! 302 637-2 V1.4.1.

use super::uper::{Form, Number, Part, enumeration, extensible, fixed, list, optional, required};
use super::{LATITUDE, LONGITUDE};

pub(super) const ACCELERATION: Number = Number::new("acceleration", -160, 161);
pub(super) const ACCELERATION_CONFIDENCE: Number = Number::new("acceleration's confidence", 0, 102);
const ZONE_ID: Part = Part::whole("protected zone", 0, 134_217_727);

/// `AccelerationControl`.
pub(super) const ACCELERATION_CONTROL: Part = Part::bits("acceleration control", 7);

/// `LanePosition`.
pub(super) const LANE_POSITION: Part = Part::whole("position in the lane", -1, 14);

/// `SteeringWheelAngle`.
pub(super) const STEERING_WHEEL: Part = fixed(&[
    required(Part::whole("steering wheel's angle", -511, 512)),
    required(Part::whole("steering wheel's confidence", 1, 127)),
]);

/// `LateralAcceleration`, `VerticalAcceleration`.
pub(super) const OTHER_ACCELERATION: Part =
    fixed(&[required(Part::Whole(ACCELERATION)), required(Part::Whole(ACCELERATION_CONFIDENCE))]);

/// `PerformanceClass`.
pub(super) const PERFORMANCE_CLASS: Part = Part::whole("performance class", 0, 7);

/// `CenDsrcTollingZone`.
pub(super) const TOLLING_ZONE: Part = extensible(&[
    required(Part::Whole(LATITUDE)),
    required(Part::Whole(LONGITUDE)),
    optional(ZONE_ID),
]);

/// `PathHistory`.
pub(super) const PATH_HISTORY: Part = list(
    "points of the path",
    0..=40,
    &fixed(&[
        required(Part::whole("latitude of a path", -131_071, 131_072)),
        required(Part::whole("longitude of a path", -131_071, 131_072)),
        required(Part::whole("altitude of a path", -12_700, 12_800)),
        optional(Part::ExtensibleNumber(Number::new("time of a path", 1, 65_535))),
    ]),
);

const LIGHT_BAR: Part = Part::bits("light bar and siren", 2);

const CAUSE: Part = extensible(&[
    required(Part::whole("cause", 0, 255)),
    required(Part::whole("detail of a cause", 0, 255)),
]);

const HARD_SHOULDER: Part = Part::whole("hard shoulder", 0, 2);

const CLOSED_LANES: Part = extensible(&[
    optional(HARD_SHOULDER),
    optional(HARD_SHOULDER),
    optional(list("driving lanes", 1..=13, &Part::whole("lane", 0, 1))),
]);

const PUBLIC_TRANSPORT: Part = fixed(&[
    required(Part::whole("embarkation", 0, 1)),
    optional(fixed(&[
        required(Part::whole("kind of activation", 0, 255)),
        required(list("octets of an activation", 1..=20, &Part::whole("octet", 0, 255))),
    ])),
]);

const SPECIAL_TRANSPORT: Part =
    fixed(&[required(Part::bits("special transport", 4)), required(LIGHT_BAR)]);

const ROAD_WORKS: Part = fixed(&[
    optional(Part::whole("kind of road works", 0, 255)),
    required(LIGHT_BAR),
    optional(CLOSED_LANES),
]);

const EMERGENCY: Part =
    fixed(&[required(LIGHT_BAR), optional(CAUSE), optional(Part::bits("emergency priority", 2))]);

const SAFETY_CAR: Part = fixed(&[
    required(LIGHT_BAR),
    optional(CAUSE),
    optional(enumeration("traffic rule", 3)),
    optional(Part::whole("speed limit", 1, 255)),
]);

/// `SpecialVehicleContainer`: public transport, special transport, dangerous goods, road works, rescue,
/// emergency, safety car.
pub(super) const SPECIAL_VEHICLE: Part = Part::Choice(
    Form::Extensible,
    &[
        &PUBLIC_TRANSPORT,
        &SPECIAL_TRANSPORT,
        &Part::whole("dangerous goods", 0, 19),
        &ROAD_WORKS,
        &LIGHT_BAR,
        &EMERGENCY,
        &SAFETY_CAR,
    ],
);
