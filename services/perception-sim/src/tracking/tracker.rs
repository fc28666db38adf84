//! The tracker: it works on detections, and on the ego's own motion.
//!
//! Each scan moves all tracks on and gives every detection to a track ([`super::association`]). Each track takes in
//! its detections ([`super::track`]), and the rest begins tracks ([`super::birth`]). Then tracks of one vehicle are
//! united, and tracks are confirmed or end. A step allocates nothing.
//!
//! A radar that gives an object list knows the vehicle of each detection, and measures the middle of its rear. Such a
//! detection belongs to the track of its vehicle, and begins one that needs no confirmation.
//!
//! On a road with a plan all this happens on the course ([`super::road_ahead`]). The scan's standing echoes and the
//! trails of the tracks correct the course first. A track keeps its place in the plane then. It is shifted by the
//! correction at its distance, and gains no lateral speed.

use scenario::Scenario;
use scenario::perception::RadarModel;

use super::association::{Outline, Point, associate, part};
use super::birth;
use super::entry::entry;
use super::list::TrackList;
use super::longitudinal::{Measured, Model, Step};
use super::motion::Body;
use super::numbers::Numbers;
use super::path::{Across, PathLimits};
use super::road_ahead::{Radar, RoadAhead};
use super::sight::Sight;
use super::sighting::Sighting;
use super::sources::{MapAhead, Sources};
use super::track::{DetectedTrack, FieldOfView, Life};
use super::unite::unite;
use crate::radar::Scan;
use crate::radar::receiver::Receiver;
use crate::radar::scene::Ego;
use scenario::event::VEHICLE_WIDTH_M;

/// Tracks at most, those that are not confirmed included.
const MAX_KEPT: usize = 32;

#[derive(Clone, Debug)]
pub struct Tracker {
    model: Model,
    limits: PathLimits,
    life: Life,
    gate: f64,
    radar: Radar,
    view: FieldOfView,
    tracks: Vec<DetectedTrack>,
    body: Body,
    points: Vec<Point>,
    outlines: Vec<Outline>,
    ahead: RoadAhead,
    /// Share of the expected detections that come.
    pub sight: Sight,
    last_ns: Option<i64>,
    next_id: u32,
}

impl Tracker {
    /// The tracker of a scenario, with the accuracy of its radar and the numbers, which studies vary.
    pub fn new(scenario: &Scenario, receiver: &Receiver, numbers: &Numbers) -> Self {
        let perception = &scenario.perception;
        let keys = &perception.tracker;
        let radar = &perception.radar.detections;
        let (hits, scans, posts_per_km) = match perception.model() {
            RadarModel::ObjectList => (1, 1, 0.0),
            RadarModel::Ideal | RadarModel::Detections => (
                keys.confirm_hits.value().into(),
                keys.confirm_scans.value().into(),
                radar.standing_objects_per_km.value(),
            ),
        };
        Self {
            model: Model::of(scenario, numbers),
            limits: PathLimits::new(&perception.target_selection, false, numbers),
            life: Life { hits, scans, coast_s: keys.coast_s.value() },
            gate: keys.gate_sigma.value(),
            radar: Radar::new(&perception.radar, receiver),
            view: FieldOfView {
                half_rad: 0.5 * perception.radar.field_of_view_deg.value().to_radians(),
                resolution_rad: receiver.azimuth.resolution,
                edge_rad: numbers.edge_rad,
            },
            tracks: Vec::with_capacity(MAX_KEPT),
            body: Body::of(&scenario.plant),
            points: Vec::with_capacity(messages::MAX_DETECTIONS),
            outlines: Vec::with_capacity(MAX_KEPT),
            ahead: RoadAhead::new(Sources::default()),
            sight: Sight::new(radar.threshold_db.value(), posts_per_km, numbers),
            last_ns: None,
            next_id: 1,
        }
    }

    /// From now on the path is the course that these sources show.
    pub fn follow_course(&mut self, sources: Sources) {
        self.ahead = RoadAhead::new(sources);
    }

    /// Takes in the scan of `time_ns` and hands out the confirmed tracks. The course needs the yaw rate, rad/s, and the
    /// map where they are known.
    pub fn step(
        &mut self,
        time_ns: i64,
        ego: &Ego,
        yaw_rate_radps: Option<f64>,
        map: Option<&MapAhead>,
        scan: Scan,
    ) -> TrackList {
        let detections = scan.detections;
        let dt_s = self.last_ns.map_or(0.0, |last| (time_ns - last) as f64 * 1e-9);
        self.last_ns = Some(time_ns);
        self.predict(dt_s, ego);
        let motion = self.body.motion(ego.speed_mps, yaw_rate_radps);
        self.read(scan, ego.speed_mps);
        if !self.ahead.course().is_straight {
            let (known, read) = ((&self.radar, self.model.numbers()), (detections, &*self.points));
            let before = self.ahead.find(dt_s, &motion, map, read, known);
            let course = self.ahead.course();
            self.tracks.iter_mut().for_each(|track| track.shift(&before, course));
            let points = self.points.iter_mut().zip(detections);
            points.for_each(|(point, detection)| *point = point.on(course, detection, &motion));
        }
        let view = (&self.view, self.ahead.course());
        self.sight.take_scan(dt_s, ego.speed_mps, &self.points, detections, view);
        self.associate();
        self.update();
        self.watch();
        self.begin();
        let life = self.life.with_sight(self.sight.share());
        unite(&mut self.tracks, &life, self.model.numbers());
        self.find_lost();
        self.confirm(&life, dt_s, ego.speed_mps);
        self.leave_trails();
        self.list(time_ns, scan)
    }

    /// Confirmed tracks of vehicles leave trails.
    fn leave_trails(&mut self) {
        for track in &self.tracks {
            if track.id != 0 && track.is_seen() && track.moved && track.abreast.is_one() {
                self.ahead.leave_trail(track.id, track.place(), track.across.speed_mps());
            }
        }
    }

    /// The course and what is known of it.
    pub fn ahead(&self) -> &RoadAhead {
        &self.ahead
    }

    fn predict(&mut self, dt_s: f64, ego: &Ego) {
        let step = Step { dt_s, ego: *ego };
        self.tracks.iter_mut().for_each(|track| track.predict(&self.model, &step));
    }

    /// Takes the detections as points of a straight road.
    fn read(&mut self, scan: Scan, ego_mps: f64) {
        self.points.clear();
        for (index, detection) in scan.detections.iter().enumerate() {
            let point = Point::new(index, detection, ego_mps, &self.radar.receiver);
            let vehicle = scan.vehicles.get(index).copied();
            let half_width_m = vehicle.map_or(0.0, |_| 0.5 * self.model.numbers().first_width_m);
            self.points.push(Point { vehicle, half_width_m, ..point });
        }
    }

    fn associate(&mut self) {
        self.outlines.clear();
        let course = self.ahead.course();
        self.outlines.extend(self.tracks.iter().map(|track| track.outline(course)));
        let numbers = self.model.numbers();
        associate(&mut self.points, &self.outlines, self.gate, numbers);
        for (place, outline) in self.outlines.iter().enumerate() {
            part(&mut self.points, place, outline.lateral_m, numbers);
        }
    }

    fn update(&mut self) {
        let numbers = self.model.numbers();
        let view = (&self.view, self.ahead.course());
        let mut seen = [None; MAX_KEPT];
        for (place, track) in self.tracks.iter_mut().enumerate() {
            let own = self.points.iter().filter(|point| point.owner == Some(place));
            let sighting = Sighting::of(own, track.across.speed_mps(), numbers);
            seen[place] = sighting.map(|sighting| track.see(&self.model, &sighting, view));
        }
        self.share(&seen);
    }

    /// Shows an echo to the tracks beside the one that it belongs to, in the same cell of the receiver: they may have
    /// merged into it.
    fn share(&mut self, seen: &[Option<Measured>; MAX_KEPT]) {
        for place in 0..self.tracks.len() {
            let track = &self.tracks[place];
            if seen[place].is_some() || track.abreast.is_one() {
                continue;
            }
            let (gap_m, lateral_m) = track.place();
            let cell_m = self.view.resolution_rad * gap_m;
            let merges = |other: &DetectedTrack| {
                let (other_gap_m, other_lateral_m) = other.place();
                (other_gap_m - gap_m).abs() < self.model.numbers().same_before_m
                    && (other_lateral_m - lateral_m).abs() < cell_m + VEHICLE_WIDTH_M
            };
            let mut merged = self.tracks.iter().zip(seen).filter(|(other, _)| merges(other));
            let Some(echo) = merged.find_map(|(_, seen)| *seen) else { continue };
            let (predicted, abreast) = (track.across.position(), &mut self.tracks[place].abreast);
            abreast.observe(echo, predicted, cell_m);
        }
    }

    /// Compares the tracks that should have been seen with those that were.
    fn watch(&mut self) {
        let numbers = self.model.numbers();
        let mut places = [(0.0, 0.0); MAX_KEPT];
        for (place, track) in places.iter_mut().zip(&self.tracks) {
            let (gap_m, lateral_m) = track.place();
            *place = self.ahead.course().place(gap_m, lateral_m);
        }
        for (index, track) in self.tracks.iter().enumerate().filter(|(_, track)| track.id != 0) {
            let (gap_m, lateral_m) = places[index];
            let outer_m = lateral_m.abs() + 0.5 * track.width_m;
            let is_near = gap_m < numbers.reach_m && self.view.shows(gap_m, outer_m);
            // A vehicle that another one hides, or that may have merged with one beside it, is not expected.
            let mut others = places.iter().zip(&self.tracks);
            let mut is_hidden = || {
                others.any(|((other_gap_m, other_lateral_m), other)| {
                    *other_gap_m < gap_m + track.length_m
                        && (other_lateral_m - lateral_m).abs() < numbers.hides_m
                        && other.id != track.id
                })
            };
            if is_near && !is_hidden() {
                self.sight.observe_track(track.is_seen());
            }
            if track.is_seen() {
                self.sight.saw_a_vehicle();
            }
        }
    }

    fn begin(&mut self) {
        let tracks = &mut self.tracks;
        let model = &self.model;
        let numbers = model.numbers();
        let ahead = &self.ahead;
        let aside = |point: &Point| {
            ahead.is_aside((point.x_m, point.y_m), point.lateral_variance.sqrt(), numbers)
        };
        birth::find(&mut self.points, aside, numbers, |sighting, moves| {
            if tracks.len() < MAX_KEPT {
                tracks.push(DetectedTrack::begin(model, sighting, moves));
            }
        });
    }

    /// Ends what is lost in the path when it is found again: a track there that is seen.
    fn find_lost(&mut self) {
        let numbers = self.model.numbers();
        let found_m = (self.tracks.iter())
            .filter(|track| track.id != 0 && track.is_seen() && track.membership.in_path())
            .map(|track| track.along.estimate().gap_m)
            .fold(f64::INFINITY, f64::min);
        self.tracks.retain(|track| {
            let is_found = found_m < track.along.estimate().gap_m + numbers.found_m;
            !(is_found && track.is_lost(numbers) && track.unseen_s > self.life.coast_s)
        });
    }

    fn confirm(&mut self, life: &Life, dt_s: f64, ego_mps: f64) {
        let numbers = self.model.numbers();
        let ahead = &self.ahead;
        let is_roadside = |track: &DetectedTrack| {
            let (place, sigma_m) = (track.place(), track.across.position_sigma_m());
            track.has_stood() && ahead.is_aside(place, sigma_m, numbers)
        };
        self.tracks.retain(|track| !track.is_over(life, numbers) && !is_roadside(track));
        for track in &mut self.tracks {
            if track.id == 0 && track.deserves_confirmation(life) {
                track.id = self.next_id;
                self.next_id = self.next_id.wrapping_add(1).max(1);
            }
            let estimate = track.along.estimate();
            let ground_mps = ego_mps + estimate.relative_speed_mps;
            let drives = ground_mps > numbers.standing_mps;
            let mut across = Across { drives, ..track.across() };
            if let Some(belief) = self.ahead.belief() {
                let sigma_m = track.across.position_sigma_m();
                let in_way = belief.in_way_at(track.place(), sigma_m, track.width_m, track.moved);
                // A vehicle that follows the road crosses a course whose heading is off.
                let crossing_mps = ground_mps * belief.heading_sigma_rad(estimate.gap_m);
                across = across.on_course(in_way, crossing_mps);
            }
            self.limits.observe(&mut track.membership, &across, dt_s);
        }
    }

    fn list(&self, time_ns: i64, scan: Scan) -> TrackList {
        let mut list = TrackList::new(time_ns);
        for track in self.tracks.iter().filter(|track| track.id != 0) {
            list.add(entry(track, self.ahead.course(), scan.detections));
        }
        list.finish();
        list
    }
}

#[cfg(test)]
mod tests;
