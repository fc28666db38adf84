//! The road as viewers draw it: standard ROS 2 messages beside ours, made from ours while they are
//! written.
//!
//! | topic | type | what it shows |
//! | --- | --- | --- |
//! | `/tf` | `tf2_msgs/msg/TFMessage` | frames `ego` (front bumper) and `vehicle_N` (rear bumpers) in `road` |
//! | `/scene/markers` | `visualization_msgs/msg/MarkerArray` | ego, vehicles, target, lane, stop lines and lights, for viewers that know markers (Foxglove, Lichtblick, RViz) |
//! | `/scene/outlines` | `sensor_msgs/msg/PointCloud2` | the same as coloured points, for viewers that know points alone (rerun) |
//! | `/radar/points` | `sensor_msgs/msg/PointCloud2` | the radar's detections, in `ego`, where the radar has them |
//!
//! The frame `road` is x along the ego's axis from where its front bumper starts, y to the left, z up, m.
//! All but detections are drawn at 20 Hz of run time. A recorder is a process of its own: none of this
//! costs a control loop anything.

mod definitions;
mod draw;

use crate::Metadata;
use crate::cdr::Cdr;
use draw::{Color, Marker, Points};
use messages::{
    Odometry, PhaseState, RadarDetections, RadarTracks, SignalTruth, Topic, VehicleTruth,
};
use scenario::Scenario;
use scenario::event::VEHICLE_WIDTH_M;

/// Time between two drawings, ns.
const PERIOD_NS: i64 = 50_000_000;
/// Length of a vehicle whose length the scenario does not say, m.
const USUAL_LENGTH_M: f64 = 4.5;
/// Height of vehicles, and of lights above the road, m.
const VEHICLE_HEIGHT_M: f64 = 1.5;
const LIGHT_HEIGHT_M: f64 = 4.5;
/// Width of a lane, m.
const LANE_WIDTH_M: f64 = 3.5;
/// Length of lane that is drawn behind and ahead of the ego, m.
const BEHIND_M: f64 = 60.0;
const AHEAD_M: f64 = 240.0;

/// A topic for viewers.
#[derive(Debug)]
pub(crate) struct SceneTopic {
    pub(crate) name: &'static str,
    pub(crate) type_name: &'static str,
    pub(crate) definition: &'static str,
}

/// The topics for viewers.
pub(crate) const TOPICS: [SceneTopic; 4] = [
    SceneTopic {
        name: "/tf",
        type_name: "tf2_msgs/msg/TFMessage",
        definition: definitions::TRANSFORMS,
    },
    SceneTopic {
        name: "/scene/markers",
        type_name: "visualization_msgs/msg/MarkerArray",
        definition: definitions::MARKERS,
    },
    SceneTopic {
        name: "/scene/outlines",
        type_name: "sensor_msgs/msg/PointCloud2",
        definition: definitions::POINTS,
    },
    SceneTopic {
        name: "/radar/points",
        type_name: "sensor_msgs/msg/PointCloud2",
        definition: definitions::POINTS,
    },
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
#[derive(Debug)]
pub(crate) struct Scene {
    epoch_ns: i64,
    ego_length_m: f64,
    lengths_m: Vec<f64>,
    /// When it is drawn next, ns of run time.
    due_ns: i64,
    odometry: Option<Odometry>,
    vehicles: Option<VehicleTruth>,
    signals: Option<SignalTruth>,
    tracks: Option<RadarTracks>,
    sequences: [u32; TOPICS.len()],
    drawn: Vec<Drawn>,
}

/// A vehicle on the road.
struct Body {
    frame: String,
    rear_m: f64,
    lateral_m: f64,
    length_m: f64,
    color: Color,
}

impl Scene {
    /// The scene of a run.
    pub(crate) fn of(metadata: &Metadata) -> Self {
        let scenario = Scenario::parse("scenario", &metadata.scenario).ok();
        let ego_length_m = scenario.as_ref().map_or(USUAL_LENGTH_M, |s| s.plant.length_m.value());
        let actors = scenario.iter().flat_map(|scenario| &scenario.actors);
        Self {
            epoch_ns: metadata.epoch_ns,
            ego_length_m,
            lengths_m: actors.map(|actor| actor.length_m.value()).collect(),
            due_ns: i64::MIN,
            odometry: None,
            vehicles: None,
            signals: None,
            tracks: None,
            sequences: [0; TOPICS.len()],
            drawn: Vec::new(),
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
            Topic::Odometry => {
                let odometry: Odometry = bytemuck::pod_read_unaligned(message);
                // A message from outside the group may hold anything.
                if odometry.position_m.is_finite() && odometry.speed_mps.is_finite() {
                    self.odometry = Some(odometry);
                    if now_ns >= self.due_ns {
                        self.due_ns = (now_ns.div_euclid(PERIOD_NS) + 1) * PERIOD_NS;
                        self.draw(now_ns, &odometry);
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

    fn draw(&mut self, now_ns: i64, ego: &Odometry) {
        let unix_ns = self.epoch_ns.saturating_add(now_ns);
        let bodies = self.bodies(ego);
        let lines = self.stop_lines(now_ns);
        self.add(0, transforms(unix_ns, ego, &bodies));
        let markers = self.markers(ego, &bodies, &lines);
        self.add(1, draw::markers(unix_ns, &markers));
        let mut points = Points::default();
        for body in &bodies {
            points.rectangle(
                [body.rear_m, body.lateral_m],
                [body.length_m, VEHICLE_WIDTH_M],
                body.color,
            );
        }
        let lane = [ego.position_m - BEHIND_M, ego.position_m + AHEAD_M];
        for side in [-0.5, 0.5] {
            points.along(lane, side * LANE_WIDTH_M, Color::GREY);
        }
        for (at_m, color, _) in &lines {
            points.across(*at_m, LANE_WIDTH_M, *color);
        }
        self.add(2, points.cloud(unix_ns, "road"));
    }

    /// The ego and all vehicles.
    fn bodies(&self, ego: &Odometry) -> Vec<Body> {
        let mut bodies = vec![Body {
            frame: "ego".into(),
            rear_m: ego.position_m - self.ego_length_m,
            lateral_m: 0.0,
            length_m: self.ego_length_m,
            color: Color::BLUE,
        }];
        let Some(truth) = &self.vehicles else { return bodies };
        let count = usize::try_from(truth.count).map_or(0, |count| count.min(truth.vehicles.len()));
        for (index, vehicle) in truth.vehicles[..count].iter().enumerate() {
            if vehicle.rear_position_m.is_finite() && vehicle.lateral_m.is_finite() {
                bodies.push(Body {
                    frame: format!("vehicle_{index}"),
                    rear_m: vehicle.rear_position_m,
                    lateral_m: vehicle.lateral_m,
                    length_m: self.lengths_m.get(index).copied().unwrap_or(USUAL_LENGTH_M),
                    color: if vehicle.in_lane == 0 { Color::GREY } else { Color::ORANGE },
                });
            }
        }
        bodies
    }

    /// Stop lines: where, colour of the light, and time until it may change, s.
    fn stop_lines(&self, now_ns: i64) -> Vec<(f64, Color, Option<f64>)> {
        let Some(truth) = &self.signals else { return Vec::new() };
        let count = usize::try_from(truth.count).map_or(0, |count| count.min(truth.lanes.len()));
        let now_s = now_ns as f64 / 1e9;
        let lines = truth.lanes[..count].iter().zip(&truth.signals);
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
        bodies: &[Body],
        lines: &[(f64, Color, Option<f64>)],
    ) -> Vec<Marker> {
        let mut markers = vec![Marker::clear()];
        let [from_m, to_m] = [ego.position_m - BEHIND_M, ego.position_m + AHEAD_M];
        let edge =
            |side: f64| [[from_m, side * LANE_WIDTH_M, 0.0], [to_m, side * LANE_WIDTH_M, 0.0]];
        markers.push(Marker::lines("lane", 0.12, [edge(-0.5), edge(0.5)].concat(), Color::GREY));
        for body in bodies {
            let middle =
                [body.rear_m + 0.5 * body.length_m, body.lateral_m, 0.5 * VEHICLE_HEIGHT_M];
            let size = [body.length_m, VEHICLE_WIDTH_M, VEHICLE_HEIGHT_M];
            markers.push(Marker::cube("vehicles", middle, size, body.color));
        }
        let above = [ego.position_m - 0.5 * self.ego_length_m, 0.0, VEHICLE_HEIGHT_M + 1.5];
        let words = format!("{:.1} m/s\n{:+.2} m/s²", ego.speed_mps, ego.acceleration_mps2);
        markers.push(Marker::text(above, words));
        if let Some(tracks) = &self.tracks
            && tracks.target.valid == 1
            && tracks.target.gap_m.is_finite()
        {
            let [from, to] = [0.0, tracks.target.gap_m].map(|x| [ego.position_m + x, 0.0, 0.6]);
            markers.push(Marker::lines("target", 0.25, vec![from, to], Color::BLUE));
        }
        for (at_m, color, left_s) in lines {
            let line = [0.4, LANE_WIDTH_M, 0.05];
            markers.push(Marker::cube("stop lines", [*at_m, 0.0, 0.02], line, *color));
            let light = [*at_m, 0.5 * LANE_WIDTH_M + 0.8, LIGHT_HEIGHT_M];
            markers.push(Marker::sphere("lights", light, 0.9, *color));
            if let Some(left_s) = left_s {
                let above = [light[0], light[1], light[2] + 1.4];
                markers.push(Marker::text(above, format!("{left_s:.0} s")));
            }
        }
        markers
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
fn transforms(unix_ns: i64, ego: &Odometry, bodies: &[Body]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.count(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let x_m = if index == 0 { ego.position_m } else { body.rear_m };
        cdr.header(unix_ns, "road").text(&body.frame);
        cdr.point([x_m, body.lateral_m, 0.0]).upright();
    }
    cdr.finish()
}
