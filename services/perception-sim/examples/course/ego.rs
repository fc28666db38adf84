//! An ego in the plane that follows its lane as a driver does.
//!
//! Its offset from the middle of the lane follows a wandering aim, as a mass on a damped spring. Its body has the slip
//! angle of a car in a steady turn (Riekert and Schunck). The front bumper is 3.6 m before the rear axle, whose tyres
//! need 0.0055 rad per m/s². The yaw-rate sensor has an offset of 0.1 °/s (standard deviation over the drives) and as
//! much noise.

use messages::{Detection, MAX_DETECTIONS};
use perception_sim::perception::Perception;
use perception_sim::radar::scene::{Ego, PlaneEgo};
use perception_sim::random::Random;
use perception_sim::tracking::TrackList;
use perception_sim::tracking::sources::MapAhead;
use road::{Axis, Pose};

/// Period of the radar, ns.
pub const PERIOD_NS: u64 = 50_000_000;
const DT_S: f64 = 0.05;
/// Wander of the aim: standard deviation, m, and correlation time, s.
const WANDER_M: f64 = 0.2;
const WANDER_S: f64 = 3.0;
/// The driver's correction: natural frequency, rad/s, and damping.
const FREQUENCY_RADPS: f64 = 1.0;
const DAMPING: f64 = 0.9;
/// Distance from the rear axle to the front bumper, m.
const AXLE_TO_BUMPER_M: f64 = 3.6;
/// Slip of the rear tyres, rad per m/s².
const SLIP_RAD_PER_MPS2: f64 = 0.0055;

/// Length of a cell of the map, m.
pub const CELL_M: f64 = 25.0;

/// A scan of a drive.
pub struct Scan<'a> {
    /// Time after it, s.
    pub time_s: f64,
    /// Place of the ego along the road, m.
    pub position_m: f64,
    pub perception: &'a Perception,
    pub tracks: &'a TrackList,
    pub detections: &'a [Detection],
}

/// Drives an ego of `seed` along `road`, with a map of these curvatures in cells, until `each` scan returns false.
pub fn drive(
    perception: &mut Perception,
    road: &Axis,
    (seed, speed_mps): (u64, f64),
    curvatures_perm: &[f64],
    detections: &mut [Detection; MAX_DETECTIONS],
    mut each: impl FnMut(&Scan<'_>) -> bool,
) {
    let mut ego = Driven::new(seed, speed_mps);
    loop {
        let (here, in_plane) = ego.now(road);
        let first_m = 0.5 * CELL_M - here.position_m;
        let map = MapAhead { curvatures_perm, first_m, cell_m: CELL_M };
        let tracks = *perception.step_in_plane(
            ego.time_ns(),
            &here,
            Some(here),
            Some(in_plane),
            Some(&map),
            detections,
        );
        ego.advance(road);
        let (time_s, position_m) = (ego.time_s(), here.position_m);
        let detections = &detections[..perception.received.count];
        if !each(&Scan { time_s, position_m, perception, tracks: &tracks, detections }) {
            return;
        }
    }
}

/// The ego.
struct Driven {
    random: Random,
    scan: u64,
    speed_mps: f64,
    position_m: f64,
    offset_m: f64,
    offset_mps: f64,
    aim_m: f64,
    sensor_offset_radps: f64,
    heading_rad: Option<f64>,
    yaw_rate_radps: f64,
}

impl Driven {
    fn new(seed: u64, speed_mps: f64) -> Self {
        let mut random = Random::of_run(seed, 99);
        let sensor_offset_radps = 0.1_f64.to_radians() * random.normal();
        Self {
            random,
            scan: 0,
            speed_mps,
            position_m: 0.0,
            offset_m: 0.0,
            offset_mps: 0.0,
            aim_m: 0.0,
            sensor_offset_radps,
            heading_rad: None,
            yaw_rate_radps: 0.0,
        }
    }

    fn time_ns(&self) -> u64 {
        self.scan * PERIOD_NS
    }

    fn time_s(&self) -> f64 {
        self.scan as f64 * DT_S
    }

    /// The ego as it is, and its place in the plane.
    fn now(&mut self, road: &Axis) -> (Ego, PlaneEgo) {
        let there = road.point(self.position_m, self.offset_m);
        let slip_rad = self.slip_rad(road);
        let pose = Pose { heading_rad: self.heading(road), ..there };
        let noise_radps = 0.1_f64.to_radians() * self.random.normal();
        let ego =
            Ego { position_m: self.position_m, speed_mps: self.speed_mps, acceleration_mps2: 0.0 };
        let in_plane = PlaneEgo {
            pose,
            velocity_mps: (self.speed_mps, self.speed_mps * slip_rad),
            yaw_rate_radps: self.yaw_rate_radps,
            told_yaw_rate_radps: Some(self.yaw_rate_radps + self.sensor_offset_radps + noise_radps),
        };
        (ego, in_plane)
    }

    /// Angle from the body to the way of the front bumper.
    fn slip_rad(&self, road: &Axis) -> f64 {
        let curvature = road.curvature_perm(self.position_m);
        let lateral_mps2 = curvature * self.speed_mps * self.speed_mps;
        AXLE_TO_BUMPER_M * curvature - SLIP_RAD_PER_MPS2 * lateral_mps2
    }

    fn heading(&self, road: &Axis) -> f64 {
        let way_rad = road.pose(self.position_m).heading_rad + self.offset_mps / self.speed_mps;
        way_rad - self.slip_rad(road)
    }

    /// Moves on to the next scan.
    fn advance(&mut self, road: &Axis) {
        let shake = WANDER_M * (2.0 * DT_S / WANDER_S).sqrt() * self.random.normal();
        self.aim_m += shake - self.aim_m * DT_S / WANDER_S;
        let pull = FREQUENCY_RADPS * FREQUENCY_RADPS * (self.aim_m - self.offset_m);
        self.offset_mps += DT_S * (pull - 2.0 * DAMPING * FREQUENCY_RADPS * self.offset_mps);
        self.offset_m += DT_S * self.offset_mps;
        let stretch = 1.0 - road.curvature_perm(self.position_m) * self.offset_m;
        self.position_m += DT_S * self.speed_mps / stretch;
        self.scan += 1;
        let heading_rad = self.heading(road);
        let before_rad = self.heading_rad.replace(heading_rad).unwrap_or(heading_rad);
        self.yaw_rate_radps = (heading_rad - before_rad) / DT_S;
    }
}
