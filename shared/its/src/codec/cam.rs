//! CAM.

use super::container::{
    ACCELERATION, ACCELERATION_CONFIDENCE, ACCELERATION_CONTROL, LANE_POSITION, OTHER_ACCELERATION,
    PATH_HISTORY, PERFORMANCE_CLASS, SPECIAL_VEHICLE, STEERING_WHEEL, TOLLING_ZONE,
};
use super::uper::{Fields, Number, Part, Skip};
use super::{LATITUDE, LONGITUDE, STATION_ID};
use crate::PayloadError;
use crate::cam::{Cam, LowFrequency, Motion};

const GENERATION_TIME: Number = Number::new("generation time", 0, 65_535);
const STATION_TYPE: Number = Number::new("station type", 0, 255);
const AXIS: Number = Number::new("axis", 0, 4095);
const ORIENTATION: Number = Number::new("orientation", 0, 3601);
const ALTITUDE: Number = Number::new("altitude", -100_000, 800_001);
const ALTITUDE_CONFIDENCE: Number = Number::new("altitude's confidence", 0, 15);
const KIND_OF_STATION: Number = Number::new("kind of station", 0, 1);
const HEADING: Number = Number::new("heading", 0, 3601);
const HEADING_CONFIDENCE: Number = Number::new("heading's confidence", 1, 127);
const SPEED: Number = Number::new("speed", 0, 16_383);
const SPEED_CONFIDENCE: Number = Number::new("speed's confidence", 1, 127);
const DRIVE_DIRECTION: Number = Number::new("drive direction", 0, 2);
const LENGTH: Number = Number::new("length", 1, 1023);
const TRAILER: Number = Number::new("trailer", 0, 4);
const WIDTH: Number = Number::new("width", 1, 62);
const CURVATURE: Number = Number::new("curvature", -1023, 1023);
const CURVATURE_CONFIDENCE: Number = Number::new("curvature's confidence", 0, 7);
const CURVATURE_CALCULATION: Number = Number::new("curvature's calculation", 0, 2);
const YAW_RATE: Number = Number::new("yaw rate", -32_766, 32_767);
const YAW_RATE_CONFIDENCE: Number = Number::new("yaw rate's confidence", 0, 8);
const ROLE: Number = Number::new("vehicle role", 0, 15);
/// Size of `ExteriorLights`.
const LIGHT_BITS: u32 = 8;

/// `DriveDirection`.
const FORWARD: i64 = 0;
/// Figures of the basic container that are not read, and sent as unknown.
const NOT_READ: [Number; 5] = [AXIS, AXIS, ORIENTATION, ALTITUDE, ALTITUDE_CONFIDENCE];
/// `HighFrequencyContainer`: a vehicle's.
const VEHICLE: i64 = 0;

pub(super) fn walk(fields: &mut impl Fields, cam: &mut Cam) -> Result<(), PayloadError> {
    fields.number(STATION_ID, &mut cam.station_id)?;
    fields.number(GENERATION_TIME, &mut cam.generation_delta)?;
    // CamParameters.
    fields.extensible([cam.low_frequency.is_some(), false], |fields, [slow, special]| {
        basic(fields, cam)?;
        if fields.extended()? || fields.whole(KIND_OF_STATION, VEHICLE)? != VEHICLE {
            return Err(PayloadError::OtherStation);
        }
        motion(fields, &mut cam.motion)?;
        if slow {
            low_frequency(fields, cam.low_frequency.get_or_insert_default())?;
        }
        fields.skip(special, &SPECIAL_VEHICLE)
    })
}

/// `BasicContainer`: type and position of the station.
fn basic(fields: &mut impl Fields, cam: &mut Cam) -> Result<(), PayloadError> {
    fields.extensible([], |fields, []| {
        fields.number(STATION_TYPE, &mut cam.station_type)?;
        fields.number(LATITUDE, &mut cam.position.latitude)?;
        fields.number(LONGITUDE, &mut cam.position.longitude)?;
        NOT_READ.into_iter().try_for_each(|number| fields.unread(number))
    })
}

fn motion(fields: &mut impl Fields, motion: &mut Motion) -> Result<(), PayloadError> {
    fields.sequence([false; 7], |fields, there| {
        let [controls, lane, wheel, lateral, vertical, performance, tolling] = there;
        fields.number(HEADING, &mut motion.heading)?;
        fields.unread(HEADING_CONFIDENCE)?;
        fields.number(SPEED, &mut motion.speed)?;
        fields.unread(SPEED_CONFIDENCE)?;
        fields.whole(DRIVE_DIRECTION, FORWARD)?;
        fields.number(LENGTH, &mut motion.length)?;
        fields.unread(TRAILER)?;
        fields.number(WIDTH, &mut motion.width)?;
        fields.number(ACCELERATION, &mut motion.acceleration)?;
        fields.unread(ACCELERATION_CONFIDENCE)?;
        fields.unread(CURVATURE)?;
        fields.unread(CURVATURE_CONFIDENCE)?;
        fields.skip(true, &Part::ExtensibleEnumeration(CURVATURE_CALCULATION))?;
        fields.number(YAW_RATE, &mut motion.yaw_rate)?;
        fields.unread(YAW_RATE_CONFIDENCE)?;
        fields.skip(controls, &ACCELERATION_CONTROL)?;
        fields.skip(lane, &LANE_POSITION)?;
        fields.skip(wheel, &STEERING_WHEEL)?;
        fields.skip(lateral, &OTHER_ACCELERATION)?;
        fields.skip(vertical, &OTHER_ACCELERATION)?;
        fields.skip(performance, &PERFORMANCE_CLASS)?;
        fields.skip(tolling, &TOLLING_ZONE)
    })
}

/// A vehicle's container. Another kind of a later version counts as a vehicle's without content.
fn low_frequency(fields: &mut impl Fields, slow: &mut LowFrequency) -> Result<(), PayloadError> {
    if fields.extended()? {
        fields.pass_small()?;
        return fields.pass_open();
    }
    fields.number(ROLE, &mut slow.role)?;
    let mut lights = slow.lights.into();
    fields.flags("lights", LIGHT_BITS, &mut lights)?;
    slow.lights = lights as u8;
    fields.skip(true, &PATH_HISTORY)
}
