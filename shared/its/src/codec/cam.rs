//! CAM.

use super::container::{
    ACCELERATION, ACCELERATION_CONFIDENCE, ACCELERATION_CONTROL, LANE_POSITION, OTHER_ACCELERATION,
    PATH_HISTORY, PERFORMANCE_CLASS, SPECIAL_VEHICLE, STEERING_WHEEL, TOLLING_ZONE,
};
use super::uper::{Number, Part, Skip, Source, Writer};
use super::{LATITUDE, LONGITUDE, read_header, write_header};
use crate::cam::{Cam, LowFrequency, Motion};
use crate::geodesy::Position;
use crate::{EncodeError, MessageKind, PayloadError};

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
const PATH_POINTS: Number = Number::new("points of the path", 0, 40);
/// Size of `ExteriorLights`.
const LIGHT_BITS: u32 = 8;

/// `DriveDirection`.
const FORWARD: u8 = 0;
/// Figures of the basic container that are not read, and sent as unknown.
const NOT_READ: [Number; 5] = [AXIS, AXIS, ORIENTATION, ALTITUDE, ALTITUDE_CONFIDENCE];
/// `HighFrequencyContainer`: a vehicle's.
const VEHICLE: u8 = 0;

pub(crate) fn encode(message: &Cam) -> Result<Vec<u8>, EncodeError> {
    let mut to = write_header(MessageKind::Cam, message.station_id)?;
    to.number(GENERATION_TIME, message.generation_delta)?;
    // CamParameters: lowFrequencyContainer, specialVehicleContainer.
    to.not_extended();
    to.present([message.low_frequency.is_some(), false]);
    write_basic(&mut to, message)?;
    to.not_extended();
    to.number(KIND_OF_STATION, VEHICLE)?;
    write_motion(&mut to, &message.motion)?;
    if let Some(slow) = message.low_frequency {
        // LowFrequencyContainer: a vehicle's, the only kind.
        to.not_extended();
        to.number(ROLE, slow.role)?;
        to.flags(slow.lights.into(), LIGHT_BITS);
        to.number(PATH_POINTS, 0)?;
    }
    Ok(to.finish())
}

pub(super) fn read(from: &mut impl Source) -> Result<Cam, PayloadError> {
    let station_id = read_header(from)?;
    let generation_delta = from.number(GENERATION_TIME)?;
    from.extensible(|from, [slow, special]| {
        let (station_type, position) = read_basic(from)?;
        if from.extended()? || from.number::<u8>(KIND_OF_STATION)? != VEHICLE {
            return Err(PayloadError::OtherStation);
        }
        let motion = read_motion(from)?;
        let low_frequency = slow.then(|| read_low_frequency(from)).transpose()?;
        from.skip(special, &SPECIAL_VEHICLE)?;
        Ok(Cam { station_id, generation_delta, station_type, position, motion, low_frequency })
    })
}

fn write_basic(to: &mut Writer, message: &Cam) -> Result<(), EncodeError> {
    let Position { latitude, longitude } = message.position;
    to.not_extended();
    to.number(STATION_TYPE, message.station_type)?;
    to.number(LATITUDE, latitude)?;
    to.number(LONGITUDE, longitude)?;
    NOT_READ.into_iter().try_for_each(|number| to.unknown(number))
}

/// `BasicContainer`: type and position of the station.
fn read_basic(from: &mut impl Source) -> Result<(u8, Position), PayloadError> {
    from.extensible(|from, []| {
        let station_type = from.number(STATION_TYPE)?;
        let (latitude, longitude) = (from.number(LATITUDE)?, from.number(LONGITUDE)?);
        NOT_READ.into_iter().try_for_each(|number| from.whole(number).map(drop))?;
        Ok((station_type, Position { latitude, longitude }))
    })
}

fn write_motion(to: &mut Writer, motion: &Motion) -> Result<(), EncodeError> {
    // accelerationControl, lanePosition, steeringWheelAngle, lateralAcceleration, verticalAcceleration,
    // performanceClass, cenDsrcTollingZone.
    to.present([false; 7]);
    to.number(HEADING, motion.heading)?;
    to.unknown(HEADING_CONFIDENCE)?;
    to.number(SPEED, motion.speed)?;
    to.unknown(SPEED_CONFIDENCE)?;
    to.number(DRIVE_DIRECTION, FORWARD)?;
    to.number(LENGTH, motion.length)?;
    to.unknown(TRAILER)?;
    to.number(WIDTH, motion.width)?;
    to.number(ACCELERATION, motion.acceleration)?;
    to.unknown(ACCELERATION_CONFIDENCE)?;
    to.unknown(CURVATURE)?;
    to.unknown(CURVATURE_CONFIDENCE)?;
    to.not_extended();
    to.unknown(CURVATURE_CALCULATION)?;
    to.number(YAW_RATE, motion.yaw_rate)?;
    to.unknown(YAW_RATE_CONFIDENCE)
}

fn read_motion(from: &mut impl Source) -> Result<Motion, PayloadError> {
    from.sequence(|from, [controls, lane, wheel, lateral, vertical, performance, tolling]| {
        let heading = from.number(HEADING)?;
        from.whole(HEADING_CONFIDENCE)?;
        let speed = from.number(SPEED)?;
        from.whole(SPEED_CONFIDENCE)?;
        from.whole(DRIVE_DIRECTION)?;
        let length = from.number(LENGTH)?;
        from.whole(TRAILER)?;
        let width = from.number(WIDTH)?;
        let acceleration = from.number(ACCELERATION)?;
        from.whole(ACCELERATION_CONFIDENCE)?;
        from.whole(CURVATURE)?;
        from.whole(CURVATURE_CONFIDENCE)?;
        from.skip(true, &Part::ExtensibleEnumeration(CURVATURE_CALCULATION))?;
        let yaw_rate = from.number(YAW_RATE)?;
        from.whole(YAW_RATE_CONFIDENCE)?;
        from.skip(controls, &ACCELERATION_CONTROL)?;
        from.skip(lane, &LANE_POSITION)?;
        from.skip(wheel, &STEERING_WHEEL)?;
        from.skip(lateral, &OTHER_ACCELERATION)?;
        from.skip(vertical, &OTHER_ACCELERATION)?;
        from.skip(performance, &PERFORMANCE_CLASS)?;
        from.skip(tolling, &TOLLING_ZONE)?;
        Ok(Motion { heading, speed, acceleration, yaw_rate, length, width })
    })
}

/// A vehicle's container. Another kind of a later version counts as a vehicle's without content.
fn read_low_frequency(from: &mut impl Source) -> Result<LowFrequency, PayloadError> {
    if from.extended()? {
        from.pass_small()?;
        from.pass_open()?;
        return Ok(LowFrequency { role: 0, lights: 0 });
    }
    let role = from.number(ROLE)?;
    let lights = from.flags("lights", LIGHT_BITS)? as u8;
    from.skip(true, &PATH_HISTORY)?;
    Ok(LowFrequency { role, lights })
}
