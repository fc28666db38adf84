//! A drive seen from above, on a road with a plan.
//!
//! One scene for each scan of the radar. Poses are the ground truth at the scan. The target is the track that
//! perception selected from it; the ego's true pose places it in the plane.
//!
//! ```text
//! truth/pose ──────────┐
//! truth/poses ─────────┼─ by time of acquisition ─► PlaneScene
//! truth/vehicles ──────┤
//! radar/tracks ────────┘ (later by the radar's latency)
//! ```

use messages::{
    AllVehicles, EgoPose, Header, MAX_TRACKS, Message, MorePoses, RadarTracks, Topic, VehiclePose,
    VehiclePoses,
};
use runtime::{Guest, RuntimeError, Subscriber};

use crate::log::present::{join, take_step};
use crate::report::ReceivedTopic;

/// Ego, vehicles and target at a scan of the radar.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaneScene {
    /// Run time of the scan, s.
    pub time_s: f64,
    pub ego: EgoPlace,
    /// The other vehicles, in the order of `truth/vehicles`.
    pub bodies: Vec<Body>,
    /// Result of the scan; `None` if `radar/tracks` has no result of this time.
    pub seen: Option<Seen>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EgoPlace {
    /// Middle of the front bumper, m.
    pub x_m: f64,
    /// Middle of the front bumper, m.
    pub y_m: f64,
    pub heading_rad: f64,
    /// Distance of the front bumper's middle from the axis, m, positive to the left.
    pub lateral_m: f64,
    /// Curvature of the axis there, 1/m.
    pub curvature_perm: f64,
    pub lateral_acceleration_mps2: f64,
}

/// Another vehicle in the plane and on the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// Middle of the body, m.
    pub x_m: f64,
    /// Middle of the body, m.
    pub y_m: f64,
    pub heading_rad: f64,
    pub length_m: f64,
    pub width_m: f64,
    /// Position of the rear bumper on the axis, m.
    pub rear_position_m: f64,
    pub speed_mps: f64,
    /// Its body reaches into the ego's lane.
    pub in_lane: bool,
}

/// Result of a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Run time at which it was published, s.
    pub published_s: f64,
    pub target: Option<TargetPlace>,
}

/// The selected target where perception places it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TargetPlace {
    /// Place in the plane, m.
    pub x_m: f64,
    /// Place in the plane, m.
    pub y_m: f64,
    /// Gap along the course, m.
    pub gap_m: f64,
    pub track_id: u32,
}

impl EgoPlace {
    fn of(pose: &EgoPose) -> Self {
        Self {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
            lateral_m: pose.lateral_m,
            curvature_perm: pose.curvature_perm,
            lateral_acceleration_mps2: pose.lateral_acceleration_mps2,
        }
    }
}

impl Body {
    fn of(pose: &VehiclePose) -> Self {
        Self {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
            length_m: pose.length_m,
            width_m: pose.width_m,
            ..Self::default()
        }
    }

    /// Distance of a place from the body, m; 0 inside.
    pub fn distance_m(&self, x_m: f64, y_m: f64) -> f64 {
        let (sine, cosine) = libm::sincos(self.heading_rad);
        let (x, y) = (x_m - self.x_m, y_m - self.y_m);
        let along = (x * cosine + y * sine).abs() - 0.5 * self.length_m;
        let across = (y * cosine - x * sine).abs() - 0.5 * self.width_m;
        libm::hypot(along.max(0.0), across.max(0.0))
    }

    /// Middle of the rear bumper, m.
    pub fn rear_m(&self) -> (f64, f64) {
        let (sine, cosine) = libm::sincos(self.heading_rad);
        (self.x_m - 0.5 * self.length_m * cosine, self.y_m - 0.5 * self.length_m * sine)
    }
}

/// The topics of a road with a plan, and their messages so far.
#[derive(Debug)]
pub(crate) struct PlaneTopics {
    pose: Subscriber<EgoPose>,
    poses: Subscriber<VehiclePoses>,
    /// Present in a scenario with more vehicles than the first message has room for.
    more: Option<Subscriber<MorePoses>>,
    tracks: Subscriber<RadarTracks>,
    pub(crate) log: PlaneLog,
}

impl PlaneTopics {
    /// Opens the topics.
    pub(crate) fn listen(observer: &Guest, others: usize) -> Result<Self, RuntimeError> {
        Ok(Self {
            pose: observer.subscriber()?,
            poses: observer.subscriber()?,
            more: (others > MAX_TRACKS).then(|| observer.subscriber()).transpose()?,
            tracks: observer.subscriber()?,
            log: PlaneLog::default(),
        })
    }

    /// Takes the messages that arrived; `note` sees the header of each track message.
    pub(crate) fn drain(
        &mut self,
        note: &mut dyn FnMut(Topic, &Header),
    ) -> Result<(), RuntimeError> {
        let log = &mut self.log;
        self.pose.drain(|message| log.pose(message))?;
        self.poses.drain(|message| log.poses(&message.header, message.poses()))?;
        if let Some(more) = &mut self.more {
            more.drain(|message| log.more.push((message.header.step, message.poses().to_vec())))?;
        }
        log.join();
        self.tracks.drain(|message| {
            note(RadarTracks::TOPIC, &message.header);
            log.tracks(message);
        })
    }

    /// Counts of received messages.
    pub(crate) fn received(&self) -> Vec<ReceivedTopic> {
        let mut received =
            vec![self.pose.received(), self.poses.received(), self.tracks.received()];
        received.extend(self.more.as_ref().map(Subscriber::received));
        received
    }
}

/// A target before it has its place: its track from the front bumper of the ego.
#[derive(Clone, Copy, Debug)]
struct Selected {
    range_m: f64,
    azimuth_rad: f64,
    gap_m: f64,
    track_id: u32,
}

/// The messages of a drive on a road with a plan, each topic in order of time.
#[derive(Debug, Default)]
pub struct PlaneLog {
    egos: Vec<(u64, i64, EgoPlace)>,
    bodies: Vec<(u64, i64, Vec<Body>)>,
    /// Further bodies of steps whose first ones have not come yet.
    more: Vec<(u64, Vec<VehiclePose>)>,
    seen: Vec<(u64, i64, f64, Option<Selected>)>,
}

impl PlaneLog {
    pub(crate) fn pose(&mut self, pose: &EgoPose) {
        let Header { step, acquisition_ns, .. } = pose.header;
        self.egos.push((step, acquisition_ns, EgoPlace::of(pose)));
    }

    /// Takes the first bodies at a scan.
    pub(crate) fn poses(&mut self, header: &Header, poses: &[VehiclePose]) {
        let bodies = poses.iter().map(Body::of).collect();
        self.bodies.push((header.step, header.acquisition_ns, bodies));
    }

    /// Puts further bodies to the first ones of their step.
    fn join(&mut self) {
        join(&mut self.bodies, &mut self.more, (|entry| entry.0, |more| more.0), |entry, more| {
            entry.2.extend(more.1.iter().map(Body::of));
        });
    }

    /// Takes the tracks of a scan.
    pub(crate) fn tracks(&mut self, tracks: &RadarTracks) {
        let selected = tracks.tracks().iter().find(|track| track.in_path != 0);
        let selected = selected.filter(|_| tracks.target.valid == 1).map(|track| Selected {
            range_m: track.range_m,
            azimuth_rad: track.azimuth_rad,
            gap_m: tracks.target.gap_m,
            track_id: track.id,
        });
        let Header { step, acquisition_ns, publish_ns, .. } = tracks.header;
        self.seen.push((step, acquisition_ns, publish_ns as f64 / 1e9, selected));
    }

    /// Thins out the samples of a long drive.
    pub(crate) fn retain(&mut self, keeps: &dyn Fn(u64) -> bool) {
        self.egos.retain(|entry| keeps(entry.0));
        self.bodies.retain(|entry| keeps(entry.0));
        self.seen.retain(|entry| keeps(entry.0));
    }

    /// The scenes, in order of time. `truths` are those of the same drive.
    pub(crate) fn finish(self, truths: &[AllVehicles]) -> Vec<PlaneScene> {
        let mut egos = self.egos.iter().peekable();
        let mut truths = truths.iter().peekable();
        let mut seen = self.seen.iter().peekable();
        let scenes = self.bodies.into_iter().filter_map(|(_, time_ns, mut bodies)| {
            let ego = take_step(&mut egos, time_ns, |entry| entry.1)?.2;
            let truth = take_step(&mut truths, time_ns, |truth| truth.header.acquisition_ns);
            let vehicles = truth.iter().flat_map(|truth| &truth.vehicles);
            for (body, vehicle) in bodies.iter_mut().zip(vehicles) {
                body.rear_position_m = vehicle.rear_position_m;
                body.speed_mps = vehicle.speed_mps;
                body.in_lane = vehicle.in_lane != 0;
            }
            let seen = take_step(&mut seen, time_ns, |entry| entry.1);
            let seen = seen.map(|(_, _, published_s, selected)| Seen {
                published_s: *published_s,
                target: selected.map(|selected| selected.from(&ego)),
            });
            Some(PlaneScene { time_s: time_ns as f64 / 1e9, ego, bodies, seen })
        });
        scenes.collect()
    }
}

impl Selected {
    fn from(self, ego: &EgoPlace) -> TargetPlace {
        let (sine, cosine) = libm::sincos(ego.heading_rad + self.azimuth_rad);
        TargetPlace {
            x_m: ego.x_m + self.range_m * cosine,
            y_m: ego.y_m + self.range_m * sine,
            gap_m: self.gap_m,
            track_id: self.track_id,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{Origins, Track, TrackedTarget, VehicleTruthItem};

    fn header(step: u64) -> Header {
        let origins = Origins::NONE;
        Header::new(step, i64::try_from(step).expect("small") * 10_000_000, origins)
    }

    #[test]
    fn a_scene_joins_the_topics_by_the_time_of_the_scan() {
        let mut log = PlaneLog::default();
        for step in 0..=10 {
            let heading_rad = std::f64::consts::FRAC_PI_2;
            let pose = EgoPose {
                header: header(step),
                x_m: 5.0,
                y_m: step as f64,
                heading_rad,
                ..EgoPose::zeroed()
            };
            log.pose(&pose);
        }
        let body =
            VehiclePose { x_m: 5.0, y_m: 37.0, heading_rad: 1.5, length_m: 4.0, width_m: 2.0 };
        log.more.push((5, vec![VehiclePose { x_m: 9.0, ..body }]));
        log.more.push((10, vec![body]));
        log.poses(&header(5), &[body]);
        log.join();
        assert_eq!(log.more.len(), 1, "one step has no first message yet");
        let mut tracks = RadarTracks {
            // Published with the next scan.
            header: Header { acquisition_ns: 50_000_000, ..header(10) },
            target: TrackedTarget { valid: 1, gap_m: 30.5, ..TrackedTarget::zeroed() },
            count: 1,
            ..RadarTracks::zeroed()
        };
        tracks.tracks[0] = Track { id: 7, in_path: 1, range_m: 30.0, ..Track::zeroed() };
        log.tracks(&tracks);
        let mut truth = AllVehicles { header: header(5), ..AllVehicles::with_room(2) };
        truth.vehicles = vec![VehicleTruthItem::zeroed(); 2];
        truth.vehicles[0].rear_position_m = 35.0;
        truth.vehicles[0].in_lane = 1;
        let truths = [truth];
        let scenes = log.finish(&truths);
        let [PlaneScene { time_s, ego, bodies, seen: Some(seen) }] = scenes.as_slice() else {
            panic!("{scenes:?}")
        };
        assert_eq!((*time_s, ego.y_m), (0.05, 5.0));
        assert_eq!((bodies.len(), bodies[1].x_m), (2, 9.0));
        assert!(bodies[0].in_lane && bodies[0].rear_position_m == 35.0);
        // The ego looks along y.
        let target = seen.target.expect("it is selected");
        assert!((target.x_m - 5.0).abs() < 1e-9 && (target.y_m - 35.0).abs() < 1e-9);
        assert_eq!((target.gap_m, target.track_id), (30.5, 7));
        assert!(bodies[0].distance_m(target.x_m, target.y_m) < 0.2);
    }

    #[test]
    fn a_body_has_its_distance_and_its_rear() {
        let body = Body { length_m: 4.0, width_m: 2.0, ..Body::default() };
        assert_eq!(body.distance_m(1.0, 0.5), 0.0);
        assert_eq!(body.distance_m(5.0, 5.0), 5.0);
        assert_eq!(body.rear_m(), (-2.0, 0.0));
    }
}
