//! The tracker of the object list, in which every measurement names its vehicle.

use messages::MAX_TRACKS;
use scenario::Scenario;

use super::detection_tracker::model_of;
use super::lateral;
use super::list::{Track, TrackList};
use super::longitudinal::{Filter, Measured, Model, Step};
use super::numbers::Numbers;
use super::path::{Across, Approach, Membership, PathLimits};
use super::sight::Share;
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
    tracks: [Option<ObjectTrack>; MAX_TRACKS],
    share: Share,
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
            model: model_of(scenario, &numbers),
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
            tracks: [None; MAX_TRACKS],
            share: Share::new(&numbers),
            last_ns: None,
            next_id: 1,
        }
    }

    /// Takes in the scan of `time_ns` and hands out the tracks.
    pub fn step(&mut self, time_ns: i64, ego: &Ego, scan: &Scan) -> TrackList {
        let first = self.last_ns.is_none();
        let dt_s = self.last_ns.map_or(0.0, |last| (time_ns - last) as f64 * 1e-9);
        self.last_ns = Some(time_ns);
        self.share.forget(dt_s);
        let step = self.model.step(dt_s, ego.acceleration_mps2);
        let mut list = TrackList::new(time_ns);
        for (index, measurement) in scan.iter().enumerate() {
            let mut track = self.tracks[index].take();
            if let Some(known) = &mut track {
                known.along.predict(&self.model, &step);
                known.across.predict(dt_s, self.model.numbers());
                known.unseen_s += dt_s;
                known.measured = false;
                if self.view.surely_shows(known.along.estimate().gap_m, known.across.position_m()) {
                    self.share.observe(1.0, measurement.is_some());
                }
            }
            if let Some(measurement) = *measurement {
                track = Some(match track {
                    Some(known) => self.correct(known, measurement, &step),
                    None => self.begin(measurement, first),
                });
            }
            self.tracks[index] = track.filter(|known| known.unseen_s <= self.coast_s + 1e-9);
            if let Some(known) = &self.tracks[index] {
                list.add(known.entry());
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
        Measured::new(along_and_across(measurement).0, self.range_sigma_m)
    }

    fn range_rate(&self, measurement: &Measurement) -> Measured {
        Measured::new(measurement.range_rate_mps, self.range_rate_sigma_mps)
    }

    fn lateral(&self, measurement: &Measurement) -> Measured {
        let (along_m, across_m) = along_and_across(measurement);
        Measured::new(across_m, self.azimuth_sigma_rad * along_m)
    }

    fn begin(&mut self, measurement: Measurement, long_known: bool) -> ObjectTrack {
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
            along: self.model.start(self.range(&measurement), self.range_rate(&measurement)),
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
        step: &Step,
    ) -> ObjectTrack {
        let (range, range_rate) = (self.range(&measurement), self.range_rate(&measurement));
        let believed = known.along.update(&self.model, step, range, range_rate);
        if believed.range && believed.range_rate {
            known.misfits = 0;
        } else {
            known.misfits += 1;
            if known.misfits >= self.model.numbers().misfits {
                return self.begin(measurement, false);
            }
        }
        known.across.update(self.lateral(&measurement), self.model.numbers());
        let across = Across {
            lateral_m: known.across.position_m(),
            speed_mps: known.across.speed_mps(),
            speed_sigma_mps: known.across.speed_sigma_mps(),
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

/// Gap and lateral position of a measurement, m.
fn along_and_across(measurement: &Measurement) -> (f64, f64) {
    let (range, azimuth) = (measurement.range_m, measurement.azimuth_rad);
    (range * libm::cos(azimuth), range * libm::sin(azimuth))
}
