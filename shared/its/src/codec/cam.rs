//! CAM.

use super::spatem::header;
use super::uper::Writer;
use super::{flags, from_uper};
use crate::cam::{Cam, LowFrequency, Motion};
use crate::geodesy::Position;
use crate::{DecodeError, EncodeError, MessageKind};
use c_its_parser::standards::cam_1_4_1::cam_pdu_descriptions as pdu;
use c_its_parser::standards::cdd_1_3_1_1::its_container as its;
use its::VehicleRole as R;

/// The standard's values for what is not known.
const NO_AXIS: u16 = 4095;
const NO_ORIENTATION: u16 = 3601;
const NO_ALTITUDE: i32 = 800_001;
const NO_HEADING_CONFIDENCE: u8 = 127;
const NO_SPEED_CONFIDENCE: u8 = 127;
const NO_ACCELERATION_CONFIDENCE: u8 = 102;
const NO_CURVATURE: i16 = 1023;
const NO_ALTITUDE_CONFIDENCE: u8 = 15;
const NO_TRAILER_KNOWN: u8 = 4;
const NO_CURVATURE_CONFIDENCE: u8 = 7;
const NO_CURVATURE_CALCULATION: u8 = 2;
const NO_YAW_RATE_CONFIDENCE: u8 = 8;
/// `DriveDirection`.
const FORWARD: u8 = 0;

/// Roles in the order of their numbers.
const ROLES: [R; 16] = [
    R::default,
    R::publicTransport,
    R::specialTransport,
    R::dangerousGoods,
    R::roadWork,
    R::rescue,
    R::emergency,
    R::safetyCar,
    R::agriculture,
    R::commercial,
    R::military,
    R::roadOperator,
    R::taxi,
    R::reserved1,
    R::reserved2,
    R::reserved3,
];

pub(crate) fn encode(message: &Cam) -> Result<Vec<u8>, EncodeError> {
    let mut to = header(MessageKind::Cam, message.station_id)?;
    to.number("generation time", message.generation_delta, 0..=65_535)?;
    // CamParameters: lowFrequencyContainer, specialVehicleContainer.
    to.not_extended();
    to.present([message.low_frequency.is_some(), false]);
    basic(&mut to, message)?;
    // HighFrequencyContainer: that of a vehicle.
    to.not_extended();
    to.number("kind of station", 0, 0..=1)?;
    high_frequency(&mut to, &message.motion)?;
    if let Some(slow) = message.low_frequency {
        // LowFrequencyContainer: that of a vehicle, the only one.
        to.not_extended();
        to.number("vehicle role", slow.role, 0..=15)?;
        to.flags(slow.lights.into(), 8);
        to.number("points of the path", 0, 0..=40)?;
    }
    Ok(to.finish())
}

fn basic(to: &mut Writer, message: &Cam) -> Result<(), EncodeError> {
    let Position { latitude, longitude } = message.position;
    to.not_extended();
    to.number("station type", message.station_type, 0..=255)?;
    to.number("latitude", latitude, -900_000_000..=900_000_001)?;
    to.number("longitude", longitude, -1_800_000_000..=1_800_000_001)?;
    to.number("axis", NO_AXIS, 0..=4095)?;
    to.number("axis", NO_AXIS, 0..=4095)?;
    to.number("orientation", NO_ORIENTATION, 0..=3601)?;
    to.number("altitude", NO_ALTITUDE, -100_000..=800_001)?;
    to.number("altitude's confidence", NO_ALTITUDE_CONFIDENCE, 0..=15)
}

fn high_frequency(to: &mut Writer, motion: &Motion) -> Result<(), EncodeError> {
    // accelerationControl, lanePosition, steeringWheelAngle, lateralAcceleration, verticalAcceleration,
    // performanceClass, cenDsrcTollingZone.
    to.present([false; 7]);
    to.number("heading", motion.heading, 0..=3601)?;
    to.number("heading's confidence", NO_HEADING_CONFIDENCE, 1..=127)?;
    to.number("speed", motion.speed, 0..=16_383)?;
    to.number("speed's confidence", NO_SPEED_CONFIDENCE, 1..=127)?;
    to.number("drive direction", FORWARD, 0..=2)?;
    to.number("length", motion.length, 1..=1023)?;
    to.number("trailer", NO_TRAILER_KNOWN, 0..=4)?;
    to.number("width", motion.width, 1..=62)?;
    to.number("acceleration", motion.acceleration, -160..=161)?;
    to.number("acceleration's confidence", NO_ACCELERATION_CONFIDENCE, 0..=102)?;
    to.number("curvature", NO_CURVATURE, -1023..=1023)?;
    to.number("curvature's confidence", NO_CURVATURE_CONFIDENCE, 0..=7)?;
    to.not_extended();
    to.number("curvature's calculation", NO_CURVATURE_CALCULATION, 0..=2)?;
    to.number("yaw rate", motion.yaw_rate, -32_766..=32_767)?;
    to.number("yaw rate's confidence", NO_YAW_RATE_CONFIDENCE, 0..=8)
}

pub(crate) fn decode(payload: &[u8]) -> Result<Cam, DecodeError> {
    let pdu::CAM { header, cam } = from_uper(payload)?;
    let parameters = &cam.cam_parameters;
    let basic = &parameters.basic_container;
    let pdu::HighFrequencyContainer::basicVehicleContainerHighFrequency(fast) =
        &parameters.high_frequency_container
    else {
        return Err(DecodeError::Payload("a CAM that is not a vehicle's".to_owned()));
    };
    Ok(Cam {
        station_id: header.station_id.0,
        generation_delta: cam.generation_delta_time.0,
        station_type: basic.station_type.0,
        position: Position {
            latitude: basic.reference_position.latitude.0,
            longitude: basic.reference_position.longitude.0,
        },
        motion: Motion {
            heading: fast.heading.heading_value.0,
            speed: fast.speed.speed_value.0,
            acceleration: fast.longitudinal_acceleration.longitudinal_acceleration_value.0,
            yaw_rate: fast.yaw_rate.yaw_rate_value.0,
            length: fast.vehicle_length.vehicle_length_value.0,
            width: fast.vehicle_width.0,
        },
        low_frequency: parameters.low_frequency_container.as_ref().map(read_low_frequency),
    })
}

fn read_low_frequency(slow: &pdu::LowFrequencyContainer) -> LowFrequency {
    let pdu::LowFrequencyContainer::basicVehicleContainerLowFrequency(slow) = slow else {
        return LowFrequency { role: 0, lights: 0 };
    };
    let role = ROLES.iter().position(|role| *role == slow.vehicle_role).unwrap_or(0);
    LowFrequency { role: role as u8, lights: flags(&slow.exterior_lights.0) as u8 }
}
