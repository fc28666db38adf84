//! The tracker of the object list, in which every measurement names its vehicle.
//!
//! On a road with a plan it works on the course ([`super::course`]) by yaw rate, trails and map. An object list has no
//! standing objects.

use scenario::Scenario;

use super::course::Course;
use super::lateral;
use super::list::{Track, TrackList};
use super::longitudinal::{Filter, Measured, Model, Step};
use super::numbers::Numbers;
use super::path::{Across, Approach, Membership, PathLimits};
use super::road_ahead::RoadAhead;
use super::sight::Share;
use super::sources::{MapAhead, Sources};
use super::track::FieldOfView;
use crate::radar::object_list::{Measurement, Scan};
use crate::radar::scene::Ego;

/// The tracker.
#[derive(Clone, Debug)]
pub struct ObjectTracker {
    model: Model,
    limits: PathLimits,
    range_sigma_m: f64,
    range_rate_sigma_mps: f64,
    azimuth_sigma_rad: f64,
    coast_s: f64,
    view: FieldOfView,
    tracks: Vec<Option<ObjectTrack>>,
    share: Share,
    ahead: RoadAhead,
    last_ns: Option<i64>,
    next_id: u32,
}

/// State of one vehicle.
#[derive(Clone, Copy, Debug)]
struct ObjectTrack {
    id: u32,
    along: Filter,
    across: lateral::Filter,
    membership: Membership,
    measurement: Measurement,
    measured: bool,
    unseen_s: f64,
    misfits: u32,
}

impl ObjectTracker {
    /// The tracker of a scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let numbers = Numbers::DEFAULT;
        let perception = &scenario.perception;
        let radar = &perception.radar;
        Self {
            model: Model::of(scenario, &numbers),
            limits: PathLimits::new(&perception.target_selection, false, &numbers),
            range_sigma_m: radar.range_sigma_m.value(),
            range_rate_sigma_mps: radar.range_rate_sigma_mps.value(),
            azimuth_sigma_rad: radar.azimuth_sigma_deg.value().to_radians(),
            coast_s: perception.tracker.coast_s.value(),
            view: FieldOfView {
                half_rad: 0.5 * radar.field_of_view_deg.value().to_radians(),
                resolution_rad: 0.0,
                edge_rad: numbers.edge_rad,
            },
            tracks: vec![None; scenario.actors.len()],
            share: Share::new(&numbers),
            ahead: RoadAhead::new(Sources::default()),
            last_ns: None,
            next_id: 1,
        }
    }

    /// From now on the path is the course that these sources show.
    pub fn follow_course(&mut self, sources: Sources) {
        self.ahead = RoadAhead::new(Sources { standing: false, ..sources });
    }

    /// The road ahead.
    #[must_use]
    pub fn ahead(&self) -> &RoadAhead {
        &self.ahead
    }

    /// Takes in the scan of `time_ns` and hands out the tracks. The course needs the yaw rate, rad/s, and the map where
    /// they are known.
    pub fn step(
        &mut self,
        time_ns: i64,
        ego: &Ego,
        yaw_rate_radps: Option<f64>,
        map: Option<&MapAhead>,
        scan: &Scan,
    ) -> TrackList {
        let first = self.last_ns.is_none();
        let dt_s = self.last_ns.map_or(0.0, |last| (time_ns - last) as f64 * 1e-9);
        self.last_ns = Some(time_ns);
        self.share.forget(dt_s);
        let step = self.model.step(dt_s, ego.acceleration_mps2);
        let mut list = TrackList::new(time_ns);
        let motion = self.ahead.motion(ego.speed_mps, yaw_rate_radps);
        let before = self.ahead.find_blind(dt_s, &motion, map);
        for (index, measurement) in scan.iter().enumerate() {
            let mut track = self.tracks[index].take();
            if let Some(known) = &mut track {
                known.along.predict(&self.model, &step);
                known.across.predict(dt_s, self.model.numbers());
                known.shift(&before, self.ahead.course());
                known.unseen_s += dt_s;
                known.measured = false;
                let (x_m, y_m) = known.place(self.ahead.course());
                if self.view.surely_shows(x_m, y_m) {
                    self.share.observe(1.0, measurement.is_some());
                }
            }
            if let Some(measurement) = *measurement {
                track = Some(match track {
                    Some(known) => self.correct(known, measurement, ego.speed_mps, &step),
                    None => self.begin(measurement, ego.speed_mps, first),
                });
            }
            self.tracks[index] = track.filter(|known| known.unseen_s <= self.coast_s + 1e-9);
            if let Some(known) = &self.tracks[index] {
                list.add(known.entry());
                if known.measured {
                    let place = (known.along.estimate().gap_m, known.across.position_m());
                    self.ahead.leave_trail(known.id, place, known.across.speed_mps());
                }
            }
        }
        list.finish();
        list
    }

    /// Share of the expected measurements that came.
    #[must_use]
    pub fn seen_share(&self) -> f64 {
        self.share.value()
    }

    fn range(&self, measurement: &Measurement) -> Measured {
        Measured::new(self.along_and_across(measurement).0, self.range_sigma_m)
    }

    fn range_rate(&self, measurement: &Measurement, ego_mps: f64) -> Measured {
        let course = self.ahead.course();
        let rate_mps = match course.is_straight() {
            true => measurement.range_rate_mps,
            false => along_course(course, measurement, ego_mps),
        };
        Measured::new(rate_mps, self.range_rate_sigma_mps)
    }

    /// Gap and lateral position of a measurement, m.
    fn along_and_across(&self, measurement: &Measurement) -> (f64, f64) {
        let (range, azimuth) = (measurement.range_m, measurement.azimuth_rad);
        let (x_m, y_m) = (range * libm::cos(azimuth), range * libm::sin(azimuth));
        let there = self.ahead.course().locate(x_m, y_m);
        (there.sigma_m, there.d_m)
    }

    fn lateral(&self, measurement: &Measurement) -> Measured {
        let (along_m, across_m) = self.along_and_across(measurement);
        Measured::new(across_m, self.azimuth_sigma_rad * along_m)
    }

    fn begin(&mut self, measurement: Measurement, ego_mps: f64, long_known: bool) -> ObjectTrack {
        let lateral = self.lateral(&measurement);
        let mut membership = Membership::default();
        if long_known {
            membership = self.limits.long_known(lateral.value);
        } else {
            self.limits.observe(&mut membership, &Across::resting(lateral.value), 0.0);
        }
        let id = self.next_id;
        self.next_id = self.next_id.wrapping_add(1).max(1);
        ObjectTrack {
            id,
            along: self
                .model
                .start(self.range(&measurement), self.range_rate(&measurement, ego_mps)),
            across: lateral::Filter::start(lateral, self.model.numbers()),
            membership,
            measurement,
            measured: true,
            unseen_s: 0.0,
            misfits: 0,
        }
    }

    /// A known track with a new measurement. When the range or the range rate keeps contradicting it,
    /// the track is begun anew.
    fn correct(
        &mut self,
        mut known: ObjectTrack,
        measurement: Measurement,
        ego_mps: f64,
        step: &Step,
    ) -> ObjectTrack {
        let (range, range_rate) =
            (self.range(&measurement), self.range_rate(&measurement, ego_mps));
        let believed = known.along.update(&self.model, step, range, range_rate);
        if believed.range && believed.range_rate {
            known.misfits = 0;
        } else {
            known.misfits += 1;
            if known.misfits >= self.model.numbers().misfits {
                return self.begin(measurement, ego_mps, false);
            }
        }
        known.across.update(self.lateral(&measurement), self.model.numbers());
        let place = (known.along.estimate().gap_m, known.across.position_m());
        let (sigma_m, width_m) =
            (known.across.position_sigma_m(), self.model.numbers().first_width_m);
        let across = Across {
            lateral_m: known.across.position_m(),
            speed_mps: known.across.speed_mps(),
            speed_sigma_mps: known.across.speed_sigma_mps(),
            in_way: self
                .ahead
                .belief()
                .map(|belief| belief.in_way_at(place, sigma_m, width_m, true)),
            drives: true,
            approach: Approach {
                gap_m: known.along.estimate().gap_m,
                relative_speed_mps: known.along.estimate().relative_speed_mps,
                length_m: self.model.numbers().first_length_m,
            },
        };
        self.limits.observe(&mut known.membership, &across, step.dt_s());
        ObjectTrack { measurement, measured: true, unseen_s: 0.0, ..known }
    }
}

impl ObjectTrack {
    /// Its place in the body's axes, m.
    fn place(&self, course: &Course) -> (f64, f64) {
        course.place(self.along.estimate().gap_m, self.across.position_m())
    }

    /// Stays where it is in the plane while the course under it is corrected.
    fn shift(&mut self, before: &Course, after: &Course) {
        let (x_m, y_m) = self.place(before);
        let by_m = after.locate(x_m, y_m).d_m - self.across.position_m();
        self.across.shift(by_m);
    }

    fn entry(&self) -> Track {
        let estimate = self.along.estimate();
        Track {
            id: self.id,
            range_m: self.measurement.range_m,
            range_rate_mps: self.measurement.range_rate_mps,
            azimuth_rad: self.measurement.azimuth_rad,
            measured: self.measured,
            gap_m: estimate.gap_m.max(0.0),
            relative_speed_mps: estimate.relative_speed_mps,
            acceleration_mps2: estimate.acceleration_mps2,
            lateral_m: self.across.position_m(),
            lateral_speed_mps: self.across.speed_mps(),
            in_path: self.membership.in_path(),
            ..Track::default()
        }
    }
}

/// Range rate that the motion behind a measurement would have on a straight road, ahead of the ego, m/s. An object list
/// leaves lateral speeds out.
fn along_course(course: &Course, measurement: &Measurement, ego_mps: f64) -> f64 {
    let (sine, cosine) = libm::sincos(measurement.azimuth_rad);
    let range_m = measurement.range_m;
    let there = course.locate(range_m * cosine, range_m * sine);
    let along = (cosine * there.tangent.0 + sine * there.tangent.1).max(0.1);
    let stretch = (1.0 - there.curvature_perm * there.d_m).clamp(0.5, 2.0);
    (measurement.range_rate_mps + ego_mps * cosine) / (along * stretch) - ego_mps
}

#[cfg(test)]
mod tests;
