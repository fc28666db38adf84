//! The tracker: it works on detections, and on the ego's own motion.
//!
//! Each scan moves all tracks on and gives every detection to a track ([`super::association`]). Each track takes in
//! its detections ([`super::track`]), and the rest begins tracks ([`super::birth`]). Then tracks of one vehicle are
//! united, mirror images end ([`super::mirror`]), and tracks are confirmed or end. A step allocates nothing.
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
use super::longitudinal::{Measured, Model};
use super::mirror;
use super::motion::Body;
use super::numbers::Numbers;
use super::path::{Across, PathLimits};
use super::road_ahead::{Radar, RoadAhead};
use super::sight::Sight;
use super::sighting::Sighting;
use super::sources::{MapAhead, Sources};
use super::track::{DetectedTrack, FieldOfView, Life, Lost};
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
    sight: Sight,
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
        self.predict(dt_s, ego.acceleration_mps2);
        let motion = self.body.motion(ego.speed_mps, yaw_rate_radps);
        self.read(scan, ego.speed_mps);
        if !self.ahead.course().is_straight() {
            let (known, read) = ((&self.radar, self.model.numbers()), (detections, &*self.points));
            let before = self.ahead.find(dt_s, &motion, map, read, known);
            let course = self.ahead.course();
            self.tracks.iter_mut().for_each(|track| track.shift(&before, course));
            let points = self.points.iter_mut().zip(detections);
            points.for_each(|(point, detection)| *point = point.on(course, detection, &motion));
        }
        self.sight.take_scan(
            dt_s,
            ego.speed_mps,
            &self.points,
            detections,
            (&self.view, self.ahead.course()),
        );
        self.associate();
        self.update();
        self.watch();
        self.begin();
        let life = self.life.with_sight(self.sight.share());
        unite(&mut self.tracks, self.ahead.course(), &life, self.model.numbers());
        self.end_images();
        self.lose(dt_s, ego);
        self.confirm(&life, dt_s, ego.speed_mps);
        self.leave_trails();
        self.list(time_ns, ego, scan)
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

    fn predict(&mut self, dt_s: f64, ego_acceleration_mps2: f64) {
        let step = self.model.step(dt_s, ego_acceleration_mps2);
        for track in &mut self.tracks {
            track.predict(&self.model, &step);
        }
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
        let outlines = self
            .tracks
            .iter()
            .enumerate()
            .map(|(place, track)| track.outline(place, self.ahead.course()));
        self.outlines.extend(outlines);
        let numbers = self.model.numbers();
        associate(&mut self.points, &self.outlines, self.gate, numbers);
        for outline in &self.outlines {
            part(&mut self.points, outline, numbers);
        }
    }

    fn update(&mut self) {
        let numbers = self.model.numbers();
        let mut seen = [None; MAX_KEPT];
        for (place, track) in self.tracks.iter_mut().enumerate() {
            let own = self.points.iter().filter(|point| point.owner == Some(place));
            let Some(sighting) = Sighting::of(own, track.across.speed_mps(), numbers) else {
                continue;
            };
            seen[place] = Some(track.see(&self.model, &sighting, &self.view, self.ahead.course()));
        }
        self.share(&seen);
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
            let is_near = gap_m < numbers.reach_m && self.view.surely_shows(gap_m, lateral_m);
            // A vehicle that another one hides, or that has merged with one, is not expected.
            let to_m = gap_m + numbers.hides_behind_m;
            let mut others = places.iter().zip(&self.tracks);
            let mut is_hidden = || {
                others.any(|((other_gap_m, other_lateral_m), other)| {
                    *other_gap_m < to_m
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

    pub fn seen_share(&self) -> f64 {
        self.sight.share()
    }

    /// An unseen track whose cell holds a seen one has merged into that echo.
    fn share(&mut self, seen: &[Option<Measured>; MAX_KEPT]) {
        for place in 0..self.tracks.len() {
            let track = &self.tracks[place];
            if seen[place].is_some() || track.abreast.is_one() {
                continue;
            }
            let cell_m = self.view.resolution_rad * track.along.estimate().gap_m;
            let others = self.tracks.iter().zip(seen);
            let merged = others.filter(|(other, _)| self.is_merged(track, other));
            let Some(measured) = merged.filter_map(|(_, seen)| *seen).next() else { continue };
            let (predicted, abreast) = (track.across.position(), &mut self.tracks[place].abreast);
            abreast.observe(measured, predicted, cell_m, self.model.numbers());
        }
    }

    /// Two tracks are in one cell of the receiver, or parts of their vehicles are.
    fn is_merged(&self, a: &DetectedTrack, b: &DetectedTrack) -> bool {
        let surely_sigma = self.model.numbers().surely_sigma;
        let (of_a, of_b) = (a.along.estimate(), b.along.estimate());
        let agree = |difference: f64, resolution: f64, entry: usize| {
            let variance = of_a.covariance[entry][entry] + of_b.covariance[entry][entry];
            difference.abs() < resolution + surely_sigma * variance.max(0.0).sqrt()
        };
        let cell_m = self.view.resolution_rad * of_a.gap_m;
        agree(of_a.gap_m - of_b.gap_m, self.radar.receiver.range.resolution, 0)
            && agree(
                of_a.relative_speed_mps - of_b.relative_speed_mps,
                self.radar.receiver.range_rate.resolution,
                1,
            )
            && (a.across.position_m() - b.across.position_m()).abs() < cell_m + VEHICLE_WIDTH_M
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

    /// Ends what could be the mirror image of another track before it is confirmed.
    fn end_images(&mut self) {
        let mut place = 0;
        while place < self.tracks.len() {
            let track = &self.tracks[place];
            let mut others = self.tracks.iter();
            if track.id == 0
                && track.vehicle.is_none()
                && others.any(|other| mirror::is_image(track, other, self.model.numbers()))
            {
                self.tracks.remove(place);
            } else {
                place += 1;
            }
        }
    }

    /// Carries on what is lost in the path, until it is found again: a track there that is seen.
    fn lose(&mut self, dt_s: f64, ego: &Ego) {
        let numbers = self.model.numbers();
        let found_m = (self.tracks.iter())
            .filter(|track| track.id != 0 && track.is_seen() && track.membership.in_path())
            .map(|track| track.along.estimate().gap_m)
            .fold(f64::INFINITY, f64::min);
        self.tracks.iter_mut().for_each(|track| track.watch(dt_s, ego));
        self.tracks.retain(|track| {
            let reach_m = |lost: &Lost| lost.gap_m + numbers.found_m;
            let is_found = track.lost(numbers).is_some_and(|lost| found_m < reach_m(lost));
            !(is_found && track.unseen_s > self.life.coast_s)
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
        for place in 0..self.tracks.len() {
            let track = &self.tracks[place];
            let mut across = track.across();
            // The centroid of several vehicles is not a vehicle. But a track that may be one vehicle has to count
            // before only hard braking helps.
            let is_urgent = across.approach.braking_mps2() > numbers.comfortable_mps2;
            if !track.abreast.is_one() && !is_urgent {
                across = Across::resting(self.nearest_of_several_m(track).unwrap_or(f64::INFINITY));
            }
            let track = &mut self.tracks[place];
            if track.id == 0 && track.deserves_confirmation(life) {
                track.id = self.next_id;
                self.next_id = self.next_id.wrapping_add(1).max(1);
            }
            let estimate = track.along.estimate();
            let ground_mps = ego_mps + estimate.relative_speed_mps;
            across.drives = ground_mps > self.model.numbers().standing_mps;
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

    /// Place of the body nearest to the ego's axis among those that a track may stand for, m.
    fn nearest_of_several_m(&self, track: &DetectedTrack) -> Option<f64> {
        let lateral_m = track.across.position_m();
        let (mut right, mut left) = (false, false);
        for other in self.tracks.iter().filter(|other| other.id != 0 && other.id != track.id) {
            if self.is_merged(track, other) {
                right |= other.across.position_m() < lateral_m;
                left |= other.across.position_m() > lateral_m;
            }
        }
        track.abreast.nearest_of_several_m((right, left), self.model.numbers())
    }

    fn list(&self, time_ns: i64, ego: &Ego, scan: Scan) -> TrackList {
        let mut list = TrackList::new(time_ns);
        for track in self.tracks.iter().filter(|track| track.id != 0) {
            list.add(entry(track, ego, self.ahead.course(), scan.detections, self.model.numbers()));
        }
        list.finish();
        list
    }
}

#[cfg(test)]
mod tests;
