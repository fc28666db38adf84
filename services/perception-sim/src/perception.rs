//! One step of perception: traffic, radar, tracks, target.
//!
//! The radar is on before the run begins. Its latency holds back scans of that time, and the tracker gets the traffic
//! from them. Every vehicle keeps its initial speed in that time.

use std::array::from_fn;
use std::sync::Arc;

use crate::report::PerceptionReport;
use bytemuck::Zeroable;
use messages::{Detection, MAX_DETECTIONS};
use road::Axis;
use scenario::Scenario;
use scenario::perception::{MAX_LATENCY_SCANS, RadarModel};

use crate::plane::sources;
use crate::quality::Quality;
use crate::radar::Scan;
use crate::radar::detections::DetectionRadar;
use crate::radar::object_list::ObjectListRadar;
use crate::radar::receiver::Received;
use crate::radar::scene::{Ego, PlaneEgo, Scene};
use crate::tracking::TrackList;
use crate::tracking::ego_speed::EgoSpeed;
use crate::tracking::exact_tracker::ExactTracker;
use crate::tracking::numbers::Numbers;
use crate::tracking::road_ahead::RoadAhead;
use crate::tracking::sources::{MapAhead, Sources};
use crate::tracking::tracker::Tracker;
use crate::traffic::Traffic;
use crate::vehicle::Vehicle;

/// Scans held back at most, and the newest one.
const HELD: usize = MAX_LATENCY_SCANS as usize + 1;

/// Scans before the start from which the tracker gets the traffic.
const SETTLING_SCANS: u64 = 30;

/// The other vehicles and all that the ego perceives of them.
#[derive(Clone, Debug)]
pub struct Perception {
    /// The traffic; its state outlives the process.
    pub traffic: Traffic,
    sensor: Sensor,
    /// The road, where it has a plan.
    road: Option<Arc<Axis>>,
    period_ns: u64,
    latency_scans: usize,
    held: [Scene; HELD],
    taken: usize,
    /// Room for the present scene, and for one before it.
    rooms: [Scene; 2],
    quality: Quality,
    /// Number of detections that the last step wrote, and number of those without room.
    pub received: Received,
    detections: u64,
    detections_left_out: u64,
    list: TrackList,
    pub(crate) ego_speed: EgoSpeed,
    /// The ego's motion that the tracker worked with.
    pub known: Ego,
}

#[derive(Clone, Debug)]
enum Sensor {
    Ideal(ExactTracker),
    Tracked(Box<(Radar, Tracker)>),
}

#[derive(Clone, Debug)]
enum Radar {
    ObjectList(ObjectListRadar),
    Detections(DetectionRadar),
}

impl Perception {
    pub fn new(scenario: &Scenario) -> Self {
        Self::with(scenario, &Numbers::DEFAULT)
    }

    /// The same with other numbers of a tracker of detections, for studies of their effect.
    pub fn with(scenario: &Scenario, numbers: &Numbers) -> Self {
        let perception = &scenario.perception;
        let latency = perception.radar.latency_ms.value() / perception.period_ms.value();
        let mut latency_scans = latency.min(MAX_LATENCY_SCANS) as usize;
        let sensor = match perception.model() {
            RadarModel::Ideal => {
                latency_scans = 0;
                Sensor::Ideal(ExactTracker::new(scenario))
            }
            RadarModel::ObjectList => {
                let radar = ObjectListRadar::new(scenario);
                let tracker = Tracker::new(scenario, radar.receiver(), numbers);
                Sensor::Tracked(Box::new((Radar::ObjectList(radar), tracker)))
            }
            RadarModel::Detections => {
                let radar = DetectionRadar::new(scenario);
                let tracker = Tracker::new(scenario, radar.receiver(), numbers);
                Sensor::Tracked(Box::new((Radar::Detections(radar), tracker)))
            }
        };
        let road = scenario.road.plan().map(|plan| Arc::new(plan.axis().clone()));
        let perception = Self {
            traffic: Traffic::new(scenario),
            sensor,
            road: None,
            period_ns: perception.period_ms.nanoseconds(),
            latency_scans,
            held: from_fn(|_| Scene::with_room(scenario.actors.len(), false)),
            taken: 0,
            rooms: from_fn(|_| Scene::with_room(scenario.actors.len(), false)),
            quality: Quality::new(scenario),
            received: Received::default(),
            detections: 0,
            detections_left_out: 0,
            list: TrackList::default(),
            ego_speed: EgoSpeed::new(numbers),
            known: Ego::default(),
        };
        match road {
            Some(road) => perception.on_road(road, sources(scenario)),
            None => perception,
        }
    }

    /// The same on a road in the plane, with a course from these sources.
    pub fn on_road(mut self, road: Arc<Axis>, sources: Sources) -> Self {
        self.road = Some(road);
        for scene in self.held.iter_mut().chain(&mut self.rooms) {
            *scene = Scene::with_room(self.traffic.vehicles().len(), true);
        }
        if let Sensor::Tracked(both) = &mut self.sensor {
            // An object list has no standing objects.
            let standing = sources.standing && matches!(both.0, Radar::Detections(_));
            both.1.follow_course(Sources { standing, ..sources });
        }
        self
    }

    /// Takes the scan of `time_ns` with the true state of the ego. Returns the tracks of the scan that the radar's
    /// latency lets out now, and writes its detections to `detections`. Called once in each period; a period that was
    /// missed may be left out.
    pub fn step(
        &mut self,
        time_ns: u64,
        ego: &Ego,
        detections: &mut [Detection; MAX_DETECTIONS],
    ) -> &TrackList {
        self.step_in_plane(time_ns, ego, Some(*ego), None, None, detections)
    }

    /// The same with the ego's motion by its odometry, which the tracker uses; and of an ego in the plane, with the map
    /// ahead of it if there is one. These two are of use on a road with a plan alone.
    pub fn step_in_plane(
        &mut self,
        time_ns: u64,
        ego: &Ego,
        told: Option<Ego>,
        in_plane: Option<PlaneEgo>,
        map: Option<&MapAhead>,
        detections: &mut [Detection; MAX_DETECTIONS],
    ) -> &TrackList {
        self.traffic.advance(time_ns, ego);
        let now_ns = i64::try_from(time_ns).unwrap_or(i64::MAX);
        let mut scene = std::mem::take(&mut self.rooms[0]);
        (scene.time_ns, scene.ego, scene.told) = (now_ns, *ego, told);
        scene.vehicles.clear();
        scene.vehicles.extend_from_slice(self.traffic.vehicles());
        match (&self.road, in_plane) {
            (Some(road), Some(in_plane)) => scene.stand_on(road, in_plane),
            _ => scene.plane = None,
        }
        if self.taken == 0 {
            self.warm_up(&scene, detections);
        }
        self.process(&scene, map, detections);
        self.rooms[0] = scene;
        self.detections += self.received.count as u64;
        self.detections_left_out += self.received.left_out;
        let scanned = &self.held[Self::out(self.taken, self.latency_scans)];
        self.quality.observe(scanned, &self.list, now_ns);
        &self.list
    }

    /// Takes the scans that are before the first one.
    fn warm_up(&mut self, now: &Scene, detections: &mut [Detection; MAX_DETECTIONS]) {
        let settles = now.time_ns == 0 && self.tracker().is_some();
        let settling = if settles { SETTLING_SCANS } else { 0 };
        let mut scene = std::mem::take(&mut self.rooms[1]);
        for back in (1..=self.latency_scans as u64 + settling).rev() {
            let back_ns = (back * self.period_ns) as i64;
            now.write_earlier(back_ns, self.road.as_deref(), &mut scene);
            if self.taken < self.latency_scans {
                self.hold(&scene);
            } else {
                self.process(&scene, None, detections);
            }
        }
        // Unused entries of the first message are 0.
        if settling > 0 {
            detections.fill(Detection::zeroed());
        }
    }

    fn hold(&mut self, scene: &Scene) {
        self.held[self.taken % HELD].copy(scene);
        self.taken += 1;
    }

    /// The scene of the scan that the last step let out.
    pub fn scanned(&self) -> &Scene {
        &self.held[Self::out(self.taken, self.latency_scans)]
    }

    /// Place of the scene that the latency lets out after `taken` scans.
    fn out(taken: usize, latency_scans: usize) -> usize {
        (taken - 1 - latency_scans) % HELD
    }

    fn process(
        &mut self,
        scene: &Scene,
        map: Option<&MapAhead>,
        detections: &mut [Detection; MAX_DETECTIONS],
    ) {
        self.hold(scene);
        let out = &self.held[Self::out(self.taken, self.latency_scans)];
        let road = self.road.as_deref();
        let yaw_rate_radps = out.plane.as_ref().and_then(|plane| plane.ego.told_yaw_rate_radps);
        self.received = Received::default();
        self.list = match &mut self.sensor {
            Sensor::Ideal(tracker) => tracker.step(out),
            Sensor::Tracked(both) => {
                let (radar, tracker) = both.as_mut();
                let scan = match radar {
                    Radar::ObjectList(radar) => {
                        self.known = out.told.unwrap_or(self.known);
                        radar.scan(out)
                    }
                    Radar::Detections(radar) => {
                        self.received = radar.scan(road, out, detections);
                        let scan = Scan::of_echoes(&detections[..self.received.count]);
                        let course = tracker.ahead().course();
                        self.known = self.ego_speed.take_scan(
                            course,
                            out.time_ns,
                            out.told,
                            scan.detections,
                        );
                        scan
                    }
                };
                tracker.step(out.time_ns, &self.known, yaw_rate_radps, map, scan)
            }
        };
    }

    /// Share of the expected detections that the radar gives; 1 with exact tracks.
    pub fn seen_share(&self) -> f64 {
        self.tracker().map_or(1.0, |tracker| tracker.sight.share())
    }

    /// The road ahead as the tracker estimates it; `None` with exact tracks.
    pub fn road_ahead(&self) -> Option<&RoadAhead> {
        self.tracker().map(Tracker::ahead)
    }

    fn tracker(&self) -> Option<&Tracker> {
        match &self.sensor {
            Sensor::Ideal(_) => None,
            Sensor::Tracked(both) => Some(&both.1),
        }
    }

    /// Figures of how well the tracks have matched the traffic.
    pub fn report(&self) -> PerceptionReport {
        let counts = match &self.sensor {
            Sensor::Tracked(both) => matches!(both.0, Radar::Detections(_)),
            Sensor::Ideal(_) => false,
        };
        PerceptionReport {
            detections: counts.then_some(self.detections),
            detections_left_out: counts.then_some(self.detections_left_out),
            unstarted_acts: self.traffic.unstarted_acts(),
            road_ended: self.has_road_ended(),
            ..self.quality.figures()
        }
    }

    /// The run is over: the storyboard has come to its end, or the ego to the road's.
    pub fn is_over(&self) -> bool {
        self.traffic.is_over() || self.has_road_ended()
    }

    /// The ego has come to the end of its road. A storyboard decides that itself.
    fn has_road_ended(&self) -> bool {
        let [now, _] = &self.rooms;
        let is_beyond = |road: &Arc<Axis>| now.ego.position_m >= road.length_m();
        match self.traffic.has_storyboard() {
            true => self.traffic.has_road_ended(),
            false => self.road.as_ref().is_some_and(is_beyond),
        }
    }

    /// The other vehicles as they truly are, in the scenario's order.
    pub fn vehicles(&self) -> &[Vehicle] {
        self.traffic.vehicles()
    }
}

#[cfg(test)]
mod plane_tests;
#[cfg(test)]
mod tests;
