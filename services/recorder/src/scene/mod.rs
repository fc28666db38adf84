//! The road as viewers draw it: standard ROS 2 messages beside ours, made from ours while they are
//! written.
//!
//! | topic | type | what it shows |
//! | --- | --- | --- |
//! | `/tf` | `tf2_msgs/msg/TFMessage` | frames `ego` (front bumper) and `vehicle_N` (rear bumpers) in `road` |
//! | `/scene/markers` | `visualization_msgs/msg/MarkerArray` | ego, vehicles, target, lanes, stop lines and lights, for viewers that know markers (Foxglove, Lichtblick, RViz) |
//! | `/scene/outlines` | `sensor_msgs/msg/PointCloud2` | the same as coloured points, for viewers that know points alone (rerun) |
//! | `/radar/points` | `sensor_msgs/msg/PointCloud2` | the radar's detections, in `ego`, where the radar has them |
//!
//! The frame `road` is x along the ego's axis from its front bumper's start, y to the left, z up, m. On a road with a
//! plan it is the plane, bodies have their true headings, and lanes are line strips. All but detections are drawn at 20
//! Hz of run time. A recorder is a process of its own: none of this costs a control loop anything.

mod definitions;
mod draw;
mod ground;
mod others;

use crate::Metadata;
use crate::cdr::Cdr;
pub(crate) use definitions::definition;
use draw::{Color, Marker, Points, kind};
use ground::{Ground, LANE_WIDTH_M, Place};
use messages::{
    EgoPose, MorePoses, MoreVehicles, Odometry, PhaseState, RadarDetections, RadarTracks,
    SignalTruth, Topic, VehiclePoses, VehicleTruth,
};
use scenario::Scenario;
use scenario::event::VEHICLE_WIDTH_M;

/// Time between two drawings, ns.
const PERIOD_NS: i64 = 50_000_000;
/// Length of a vehicle without a length in the scenario, m.
const USUAL_LENGTH_M: f64 = 4.5;
/// Height of vehicles, and of lights above the road, m.
const VEHICLE_HEIGHT_M: f64 = 1.5;
const LIGHT_HEIGHT_M: f64 = 4.5;
/// Length of lane that is drawn behind and ahead of the ego, m.
const BEHIND_M: f64 = 60.0;
const AHEAD_M: f64 = 240.0;

/// Name and type of each topic.
pub(crate) const TOPICS: [(&str, &str); 4] = [
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/scene/markers", "visualization_msgs/msg/MarkerArray"),
    ("/scene/outlines", "sensor_msgs/msg/PointCloud2"),
    ("/radar/points", "sensor_msgs/msg/PointCloud2"),
];

/// A message for viewers.
#[derive(Debug)]
pub(crate) struct Drawn {
    /// Its topic, by its place in [`TOPICS`].
    pub(crate) topic: usize,
    pub(crate) sequence: u32,
    /// CDR with its encapsulation.
    pub(crate) payload: Vec<u8>,
}

/// Present knowledge of the road.
#[derive(Debug, Default)]
pub(crate) struct Scene {
    epoch_ns: i64,
    ego_length_m: f64,
    lengths_m: Vec<f64>,
    ground: Ground,
    /// Time when it is drawn next, ns of run time.
    due_ns: i64,
    odometry: Option<Odometry>,
    pose: Option<EgoPose>,
    vehicles: Option<VehicleTruth>,
    more_vehicles: Option<Box<MoreVehicles>>,
    poses: Option<VehiclePoses>,
    more_poses: Option<Box<MorePoses>>,
    signals: Option<SignalTruth>,
    tracks: Option<RadarTracks>,
    sequences: [u32; TOPICS.len()],
    drawn: Vec<Drawn>,
}

/// A vehicle on the road.
struct Body {
    frame: String,
    /// Middle of the rear bumper.
    rear: Place,
    length_m: f64,
    width_m: f64,
    color: Color,
}

impl Body {
    /// A point of it, from the middle of its rear bumper, m.
    fn point(&self, ahead_m: f64, up_m: f64) -> [f64; 3] {
        let [x, y] = self.rear.point(ahead_m, 0.0);
        [x, y, up_m]
    }
}

impl Scene {
    pub(crate) fn of(metadata: &Metadata) -> Self {
        let scenario = Scenario::parse("scenario", &metadata.scenario).ok();
        Self::on(scenario.as_ref(), metadata.epoch_ns)
    }

    fn on(scenario: Option<&Scenario>, epoch_ns: i64) -> Self {
        let ego_length_m = scenario.map_or(USUAL_LENGTH_M, |s| s.plant.length_m.value());
        let actors = scenario.iter().flat_map(|scenario| &scenario.actors);
        let plan = scenario.and_then(|scenario| scenario.road.plan());
        let ground = plan.map_or(Ground::Straight, |plan| Ground::Plan(Box::new(plan.clone())));
        Self {
            epoch_ns,
            ego_length_m,
            lengths_m: actors.map(|actor| actor.length_m.value()).collect(),
            ground,
            due_ns: i64::MIN,
            ..Self::default()
        }
    }

    /// Takes note of a message that was recorded at `now_ns` of run time.
    pub(crate) fn take(&mut self, topic: Topic, now_ns: i64, message: &[u8]) {
        match topic {
            Topic::VehicleTruth => self.vehicles = Some(bytemuck::pod_read_unaligned(message)),
            Topic::SignalTruth => self.signals = Some(bytemuck::pod_read_unaligned(message)),
            Topic::RadarTracks => self.tracks = Some(bytemuck::pod_read_unaligned(message)),
            Topic::RadarDetections => {
                self.draw_detections(now_ns, &bytemuck::pod_read_unaligned(message));
            }
            Topic::MoreVehicles => {
                self.more_vehicles = Some(Box::new(bytemuck::pod_read_unaligned(message)));
            }
            Topic::VehiclePoses => self.poses = Some(bytemuck::pod_read_unaligned(message)),
            Topic::MorePoses => {
                self.more_poses = Some(Box::new(bytemuck::pod_read_unaligned(message)));
            }
            Topic::EgoPose => {
                self.pose = Some(bytemuck::pod_read_unaligned(message));
                if self.ground.has_plan() {
                    self.draw_if_due(now_ns);
                }
            }
            Topic::Odometry => {
                let odometry: Odometry = bytemuck::pod_read_unaligned(message);
                // A message from outside the group may hold anything.
                if odometry.position_m.is_finite() && odometry.speed_mps.is_finite() {
                    self.odometry = Some(odometry);
                    // On a road with a plan the ego's pose is the newer one.
                    if !self.ground.has_plan() {
                        self.draw_if_due(now_ns);
                    }
                }
            }
            _ => {}
        }
    }

    /// Shapes drawn since the last call.
    pub(crate) fn drawn(&mut self) -> Vec<Drawn> {
        std::mem::take(&mut self.drawn)
    }

    fn add(&mut self, topic: usize, payload: Vec<u8>) {
        self.sequences[topic] = self.sequences[topic].wrapping_add(1);
        self.drawn.push(Drawn { topic, sequence: self.sequences[topic], payload });
    }

    fn draw_if_due(&mut self, now_ns: i64) {
        let Some(ego) = self.odometry.filter(|_| now_ns >= self.due_ns) else { return };
        let Some(front) = self.front(&ego) else { return };
        self.due_ns = (now_ns.div_euclid(PERIOD_NS) + 1).saturating_mul(PERIOD_NS);
        self.draw(now_ns, &ego, &front);
    }

    /// Middle of the ego's front bumper.
    fn front(&self, ego: &Odometry) -> Option<Place> {
        if !self.ground.has_plan() {
            return Some(self.ground.place(ego.position_m, 0.0));
        }
        let pose = self.pose?;
        let place = Place { at_m: [pose.x_m, pose.y_m], heading_rad: pose.heading_rad };
        place.is_finite().then_some(place)
    }

    fn draw(&mut self, now_ns: i64, ego: &Odometry, front: &Place) {
        let unix_ns = self.epoch_ns.saturating_add(now_ns);
        let bodies = self.bodies(front);
        let lines = self.stop_lines(now_ns);
        self.add(0, transforms(unix_ns, front, &bodies));
        let markers = self.markers(ego, front, &bodies, &lines);
        self.add(1, draw::markers(unix_ns, &markers));
        let mut points = Points::default();
        for body in &bodies {
            points.rectangle(&body.rear, [body.length_m, body.width_m], body.color);
        }
        let lane = [ego.position_m - BEHIND_M, ego.position_m + AHEAD_M];
        for line in self.ground.lines(lane) {
            points.all(line, Color::GREY);
        }
        for (at_m, color, _) in &lines {
            let place = self.ground.place(*at_m, 0.0);
            points.across(&place, self.ground.lane_width_m(), *color);
        }
        self.add(2, points.cloud(unix_ns, "road"));
    }

    /// The ego and all vehicles.
    fn bodies(&self, front: &Place) -> Vec<Body> {
        let ego = Body {
            frame: "ego".into(),
            rear: Place { at_m: front.point(-self.ego_length_m, 0.0), ..*front },
            length_m: self.ego_length_m,
            width_m: VEHICLE_WIDTH_M,
            color: Color::BLUE,
        };
        std::iter::once(ego).chain(self.others()).collect()
    }

    /// Stop lines: where, colour of the light, and time until it may change, s.
    fn stop_lines(&self, now_ns: i64) -> Vec<(f64, Color, Option<f64>)> {
        let Some(truth) = &self.signals else { return Vec::new() };
        let now_s = now_ns as f64 / 1e9;
        let lines = truth.lanes().iter().zip(truth.signals());
        lines
            .filter(|(lane, _)| lane.stop_line_m.is_finite())
            .map(|(lane, signal)| {
                let now = signal.intervals[0];
                let color = match PhaseState::from_wire(now.state) {
                    PhaseState::StopAndRemain => Color::RED,
                    PhaseState::ProtectedMovementAllowed => Color::GREEN,
                    PhaseState::ProtectedClearance => Color::YELLOW,
                    PhaseState::Unavailable => Color::GREY,
                };
                let left_s = now.likely_end_s - now_s;
                (lane.stop_line_m, color, left_s.is_finite().then_some(left_s))
            })
            .collect()
    }

    fn markers(
        &self,
        ego: &Odometry,
        front: &Place,
        bodies: &[Body],
        lines: &[(f64, Color, Option<f64>)],
    ) -> Vec<Marker> {
        let mut markers = vec![Marker::clear()];
        markers.extend(self.lanes(ego.position_m));
        for body in bodies {
            let middle = body.point(0.5 * body.length_m, 0.5 * VEHICLE_HEIGHT_M);
            let size = [body.length_m, body.width_m, VEHICLE_HEIGHT_M];
            let cube = Marker::new("vehicles", kind::CUBE, middle, size, body.color);
            markers.push(cube.turned(body.rear.heading_rad));
        }
        let [x, y] = front.point(-0.5 * self.ego_length_m, 0.0);
        let words = format!("{:.1} m/s\n{:+.2} m/s²", ego.speed_mps, ego.acceleration_mps2);
        markers.push(Marker::text([x, y, VEHICLE_HEIGHT_M + 1.5], words));
        if let Some([x, y]) = self.target(front) {
            let [from_x, from_y] = front.at_m;
            let line = vec![[from_x, from_y, 0.6], [x, y, 0.6]];
            markers.push(Marker::lines("target", kind::LINE_LIST, 0.25, line, Color::BLUE));
        }
        for (at_m, color, left_s) in lines {
            markers.extend(self.stop_line(*at_m, *color, *left_s));
        }
        markers
    }

    /// Lines of the lanes around a position.
    fn lanes(&self, position_m: f64) -> Vec<Marker> {
        let [from_m, to_m] = [position_m - BEHIND_M, position_m + AHEAD_M];
        if self.ground.has_plan() {
            let strip = |line: Vec<[f64; 2]>| {
                let points = line.into_iter().map(|[x, y]| [x, y, 0.0]).collect();
                Marker::lines("lane", kind::LINE_STRIP, 0.12, points, Color::GREY)
            };
            return self.ground.lines([from_m, to_m]).into_iter().map(strip).collect();
        }
        let sides_m = [-0.5, 0.5].map(|side| side * LANE_WIDTH_M);
        let ends = sides_m.into_iter().flat_map(|y| [[from_m, y, 0.0], [to_m, y, 0.0]]).collect();
        vec![Marker::lines("lane", kind::LINE_LIST, 0.12, ends, Color::GREY)]
    }

    fn target(&self, front: &Place) -> Option<[f64; 2]> {
        let tracks = self.tracks.as_ref().filter(|tracks| tracks.target.valid == 1)?;
        if !self.ground.has_plan() {
            let gap_m = tracks.target.gap_m;
            return gap_m.is_finite().then(|| front.point(gap_m, 0.0));
        }
        // The gap is along the course; the track's place is before the bumper.
        let track = tracks.tracks().iter().find(|track| track.in_path != 0)?;
        let (sine, cosine) = libm::sincos(track.azimuth_rad);
        let place = front.point(track.range_m * cosine, track.range_m * sine);
        place.iter().all(|value| value.is_finite()).then_some(place)
    }

    /// A stop line with its light, and the time until it may change, s.
    fn stop_line(&self, at_m: f64, color: Color, left_s: Option<f64>) -> Vec<Marker> {
        let place = self.ground.place(at_m, 0.0);
        let width_m = self.ground.lane_width_m();
        let [x, y] = place.at_m;
        let size = [0.4, width_m, 0.05];
        let line = Marker::new("stop lines", kind::CUBE, [x, y, 0.02], size, color);
        let [x, y] = place.point(0.0, 0.5 * width_m + 0.8);
        let light = Marker::new("lights", kind::SPHERE, [x, y, LIGHT_HEIGHT_M], [0.9; 3], color);
        let words = left_s
            .map(|left_s| Marker::text([x, y, LIGHT_HEIGHT_M + 1.4], format!("{left_s:.0} s")));
        [line.turned(place.heading_rad), light].into_iter().chain(words).collect()
    }

    fn draw_detections(&mut self, now_ns: i64, scan: &RadarDetections) {
        if scan.detections().is_empty() {
            return;
        }
        let unix_ns = self.epoch_ns.saturating_add(now_ns);
        self.add(3, draw::detections(unix_ns, scan.detections()));
    }
}

/// `/tf`: the ego's front bumper and the vehicles' rear bumpers.
fn transforms(unix_ns: i64, front: &Place, bodies: &[Body]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.count(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let Place { at_m: [x, y], heading_rad } = if index == 0 { *front } else { body.rear };
        cdr.header(unix_ns, "road").text(&body.frame);
        cdr.point([x, y, 0.0]).turned(heading_rad);
    }
    cdr.finish()
}

#[cfg(test)]
mod tests;
