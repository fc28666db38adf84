//! CAM: position and motion of a vehicle (ETSI EN 302 637-2 V1.4.1).

use crate::geodesy::Position;

/// A cooperative awareness message of a vehicle. Other fields of the standard are sent as unavailable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cam {
    pub station_id: u32,
    /// `TimestampIts` modulo 65536 of the position, ms.
    pub generation_delta: u16,
    /// Type of the station, 0 to 255: 5 is a passenger car, 8 a heavy truck.
    pub station_type: u8,
    pub position: Position,
    /// The fast part.
    pub motion: Motion,
    /// The slow part, in one message per half second.
    pub low_frequency: Option<LowFrequency>,
}

/// `BasicVehicleContainerHighFrequency`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Motion {
    /// Heading from north, clockwise, 0.1 degrees, 0 to 3600; 3601 unavailable.
    pub heading: u16,
    /// Speed, cm/s, 0 to 16382; 16383 unavailable.
    pub speed: u16,
    /// Longitudinal acceleration, dm/s², -160 to 160; 161 unavailable.
    pub acceleration: i16,
    /// Yaw rate, 0.01 degrees/s, -32766 to 32766; 32767 unavailable.
    pub yaw_rate: i16,
    /// Length, dm, 1 to 1022; 1023 unavailable.
    pub length: u16,
    /// Width, dm, 1 to 61; 62 unavailable.
    pub width: u8,
}

/// `BasicVehicleContainerLowFrequency`, without a path history.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LowFrequency {
    /// `VehicleRole`, 0 (default) to 15.
    pub role: u8,
    /// `ExteriorLights`: bit n of the standard is bit n here.
    pub lights: u8,
}
