//! CAM.

use super::{PROTOCOL_VERSION, bits, flags, from_uper, to_uper};
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
    let Position { latitude, longitude } = message.position;
    let basic = pdu::BasicContainer::new(
        its::StationType(message.station_type),
        its::ReferencePosition::new(
            its::Latitude(latitude),
            its::Longitude(longitude),
            its::PosConfidenceEllipse::new(
                its::SemiAxisLength(NO_AXIS),
                its::SemiAxisLength(NO_AXIS),
                its::HeadingValue(NO_ORIENTATION),
            ),
            its::Altitude::new(
                its::AltitudeValue(NO_ALTITUDE),
                its::AltitudeConfidence::unavailable,
            ),
        ),
    );
    let fast = pdu::HighFrequencyContainer::basicVehicleContainerHighFrequency(high_frequency(
        &message.motion,
    ));
    let slow = message.low_frequency.map(low_frequency).transpose()?;
    to_uper(&pdu::CAM::new(
        its::ItsPduHeader::new(
            PROTOCOL_VERSION,
            MessageKind::Cam.message_id(),
            its::StationID(message.station_id),
        ),
        pdu::CoopAwareness::new(
            pdu::GenerationDeltaTime(message.generation_delta),
            pdu::CamParameters::new(basic, fast, slow, None),
        ),
    ))
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

fn high_frequency(motion: &Motion) -> pdu::BasicVehicleContainerHighFrequency {
    pdu::BasicVehicleContainerHighFrequency::new(
        its::Heading::new(
            its::HeadingValue(motion.heading),
            its::HeadingConfidence(NO_HEADING_CONFIDENCE),
        ),
        its::Speed::new(its::SpeedValue(motion.speed), its::SpeedConfidence(NO_SPEED_CONFIDENCE)),
        its::DriveDirection::forward,
        its::VehicleLength::new(
            its::VehicleLengthValue(motion.length),
            its::VehicleLengthConfidenceIndication::unavailable,
        ),
        its::VehicleWidth(motion.width),
        its::LongitudinalAcceleration::new(
            its::LongitudinalAccelerationValue(motion.acceleration),
            its::AccelerationConfidence(NO_ACCELERATION_CONFIDENCE),
        ),
        its::Curvature::new(
            its::CurvatureValue(NO_CURVATURE),
            its::CurvatureConfidence::unavailable,
        ),
        its::CurvatureCalculationMode::unavailable,
        its::YawRate::new(its::YawRateValue(motion.yaw_rate), its::YawRateConfidence::unavailable),
        None,
        None,
        None,
        None,
        None,
        None,
        None,
    )
}

fn low_frequency(slow: LowFrequency) -> Result<pdu::LowFrequencyContainer, EncodeError> {
    let role = ROLES.get(usize::from(slow.role));
    let role = role.ok_or_else(|| EncodeError::Range(format!("vehicle role {}", slow.role)))?;
    Ok(pdu::LowFrequencyContainer::basicVehicleContainerLowFrequency(
        pdu::BasicVehicleContainerLowFrequency::new(
            *role,
            its::ExteriorLights(bits(slow.lights.into())),
            its::PathHistory(Vec::new()),
        ),
    ))
}

fn read_low_frequency(slow: &pdu::LowFrequencyContainer) -> LowFrequency {
    let pdu::LowFrequencyContainer::basicVehicleContainerLowFrequency(slow) = slow else {
        return LowFrequency { role: 0, lights: 0 };
    };
    let role = ROLES.iter().position(|role| *role == slow.vehicle_role).unwrap_or(0);
    LowFrequency { role: role as u8, lights: flags(&slow.exterior_lights.0) as u8 }
}
