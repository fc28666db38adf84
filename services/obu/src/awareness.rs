//! A vehicle's CAM: when it is due, and its content (EN 302 637-2).

use crate::clock::Moment;
use crate::lanes::Path;
use its::cam::{Cam, LowFrequency, Motion};
use its::geonetworking::{Source, StationType};
use its::time::its_timestamp;
use its::triggers::{self, Triggers};
use its::{Frame, Message};
use messages::Odometry;
use scenario::Scenario;

const WIDTH_DM: u8 = 19;
const CAR: u8 = 5;
const TRUCK: u8 = 8;

#[derive(Clone, Debug)]
pub struct Awareness {
    station_id: u32,
    station_type: u8,
    length_dm: u16,
    triggers: Triggers,
    pub(crate) path: Path,
}

impl Awareness {
    /// The CAMs of a vehicle like the ego, with a station id.
    pub fn of(scenario: &Scenario, station_id: u32) -> Self {
        let plant = &scenario.plant;
        Self {
            station_id,
            station_type: if plant.vehicle.is_truck() { TRUCK } else { CAR },
            length_dm: (10.0 * plant.length_m.value()).round().clamp(1.0, 1022.0) as u16,
            triggers: Triggers::default(),
            path: Path::of(scenario),
        }
    }

    /// The frame of a vehicle that drives `left_m` beside its path, if one is due.
    pub fn due(&mut self, odometry: &Odometry, left_m: f64, moment: &Moment) -> Option<Vec<u8>> {
        let (position_m, speed_mps) = odometry.moved_to(moment.now_ns as f64 / 1e9);
        let (position, heading_deg) = self.path.earth(position_m, left_m);
        let motion = triggers::Motion { position_m, speed_mps, heading_deg };
        // Tenths of degrees; 3600 is north again.
        let heading = (10.0 * heading_deg).round() as u16 % 3600;
        let due = self.triggers.check(moment.now_ns, &motion)?;
        let timestamp = its_timestamp(moment.utc_ms());
        let acceleration = (10.0 * odometry.acceleration_mps2).round().clamp(-160.0, 160.0) as i16;
        let speed_cmps = (100.0 * speed_mps).round().clamp(0.0, 16_382.0);
        let Self { station_id, station_type, length_dm, .. } = *self;
        let cam = Cam {
            station_id,
            generation_delta: timestamp.rem_euclid(1 << 16) as u16,
            station_type,
            position,
            motion: Motion {
                heading,
                speed: speed_cmps as u16,
                acceleration,
                yaw_rate: 0,
                length: length_dm,
                width: WIDTH_DM,
            },
            low_frequency: due.low_frequency.then_some(LowFrequency { role: 0, lights: 0 }),
        };
        let source = Source {
            station_type: StationType::of(cam.station_type),
            address: 0x0200_0000_0000 | u64::from(station_id),
            timestamp: timestamp.rem_euclid(1 << 32) as u32,
            position,
            accurate: true,
            speed: speed_cmps.min(16_383.0) as i16,
            heading,
        };
        // Every field is inside its range.
        Frame { source, message: Message::Cam(cam) }.encode().ok()
    }
}
