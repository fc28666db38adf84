//! The unit's view of the signals ahead, from the received frames.
//!
//! Frames have no signatures, or ones that are not verified, so that nothing proves who sent one. The unit checks them against each other,
//! against their own stamps and against the vehicle's clock:
//!
//! * An intersection counts after two frames, so that a falsified id makes no intersection.
//! * A sender that contradicts itself must repeat the new content once.
//! * If two senders disagree, the signal is unknown until they agree or one announcement is over.
//! * Timing is used only with the map of its revision. If a line has moved, the nearest one counts.
//! * An intersection exists even without a map, or if its frames are too old.

use crate::clock::Moment;
use crate::intersection::Intersection;
use crate::known_map::Told;
use crate::lanes::{Path, StopLine, stop_lines};
use crate::numbers::Numbers;
use crate::report::Signers;
use crate::verdict::{Verdict, Verdicts};
use its::Message;
use its::cam::Cam;
use its::geodesy::Plane;
use its::mapem::IntersectionGeometry;
use its::signed;
use its::spatem::IntersectionState;
use its::time::from_its_timestamp;
use its::triggers::MAX_NS;
use messages::{AnnouncedMotion, Lane, MAX_MOTIONS, Map, Spat};
use std::collections::VecDeque;
use xxhash_rust::xxh3::xxh3_64;

/// Frames in which repeated bytes are detected.
const REMEMBERED_FRAMES: usize = 512;
/// Silence after which an intersection that is not ahead is dropped, ns. Chosen: longer than a unit is out of sight
/// behind a lorry.
const FORGOTTEN_NS: i64 = 30_000_000_000;
/// Greatest age of the first map of an intersection, ms. Chosen: a map changes with works on the road, not within minutes.
const OLDEST_MAP_MS: i64 = 600_000;
/// Longest delay of a CAM behind the longest time between two, ns. Chosen: two periods of the unit.
const CAM_LATE_NS: i64 = 200_000_000;
/// Speed and acceleration of a CAM that are not available (ETSI TS 102 894-2).
const UNAVAILABLE: (u16, i16) = (16_383, 161);
const MOST_INTERSECTIONS: usize = 64;

/// The intersections that the unit has, and its verdicts on the frames.
#[derive(Debug)]
pub struct Receiver {
    pub numbers: Numbers,
    station_id: u32,
    max_age_ms: i64,
    /// The road, or a way through a net.
    pub(crate) path: Path,
    intersections: Vec<Intersection>,
    /// The newest motion of each other vehicle.
    pub motions: Vec<AnnouncedMotion>,
    heard: VecDeque<u64>,
    pub verdicts: Verdicts,
    /// Signed frames are not ignored.
    pub(crate) uses_signed: bool,
    /// The signers of the frames so far, as their envelopes name them.
    pub signers: Signers,
}

/// The sending of a frame, as it arrived.
struct Sent<'a> {
    station: u32,
    /// Time of the frame by its sender's stamp, ms of UTC.
    made_ms: i64,
    /// Position of the sender on the vehicle's path, m; `None` if it is not beside the path.
    unit_m: Option<f64>,
    moment: &'a Moment,
}

impl Receiver {
    /// A unit before its first frame, on a road that is the axis of `plane`.
    pub fn new(station_id: u32, max_age_ms: i64, plane: Plane) -> Self {
        Self {
            numbers: Numbers::DEFAULT,
            station_id,
            max_age_ms,
            path: Path { plane, axis: None },
            intersections: Vec::new(),
            motions: Vec::new(),
            heard: VecDeque::with_capacity(REMEMBERED_FRAMES),
            verdicts: Verdicts::default(),
            uses_signed: true,
            signers: Signers::default(),
        }
    }

    /// Takes a frame; returns and counts the verdict.
    pub fn take(&mut self, bytes: &[u8], moment: &Moment) -> Verdict {
        let verdict = self.judge(bytes, moment);
        self.verdicts.count(verdict);
        verdict
    }

    /// Drops intersections that are passed and silent, and vehicles whose next CAM did not come. `ego_m` is the vehicle's
    /// position on its path.
    pub fn forget(&mut self, now_ns: i64, ego_m: f64) {
        self.motions.retain(|motion| now_ns - motion.made_ns <= MAX_NS + CAM_LATE_NS);
        self.intersections.retain(|intersection| {
            intersection.lines(now_ns, ego_m).next().is_some()
                || now_ns - intersection.heard_ns < FORGOTTEN_NS
        });
    }

    /// Writes the stop lines ahead and the timing of their signals, nearest first. Returns the instant of the oldest
    /// timing, ns of run time; `None` if no signal is ahead.
    pub fn write(&self, now_ns: i64, ego_m: f64, map: &mut Map, spat: &mut Spat) -> Option<i64> {
        let mut ahead: Vec<(&Intersection, StopLine)> = (self.intersections.iter())
            .filter(|intersection| intersection.is_confirmed())
            .flat_map(|known| known.lines(now_ns, ego_m).map(move |line| (known, line)))
            .collect();
        ahead.sort_by(|(_, a), (_, b)| a.position_m.total_cmp(&b.position_m));
        let mut oldest_ns: Option<i64> = None;
        for ((known, line), lane) in ahead.iter().zip(&mut map.lanes) {
            *lane = Lane {
                intersection_id: known.id.into(),
                signal_group: line.signal_group.into(),
                stop_line_m: line.position_m,
            };
            map.count += 1;
            if line.position_m >= ego_m {
                // Without any certain timing: as old as the run.
                let made_ns = known.certain_ns.unwrap_or(0);
                oldest_ns = Some(oldest_ns.map_or(made_ns, |oldest| oldest.min(made_ns)));
            }
            if let Some(timing) = known.timing(line.signal_group, now_ns) {
                timing.write(known.id, &mut spat.signals[spat.count as usize]);
                spat.count += 1;
            }
        }
        oldest_ns
    }

    fn judge(&mut self, bytes: &[u8], moment: &Moment) -> Verdict {
        let hash = xxh3_64(bytes);
        if self.heard.contains(&hash) {
            return Verdict::Duplicated;
        }
        if self.heard.len() == REMEMBERED_FRAMES {
            self.heard.pop_front();
        }
        self.heard.push_back(hash);
        let (frame, envelope) = match signed::decode(bytes) {
            Ok(read) => read,
            Err(error) => return Verdict::from(&error),
        };
        if let Some(envelope) = envelope {
            self.signers.note(&envelope);
            if !self.uses_signed {
                return Verdict::Signed;
            }
        }
        if frame.message.station_id() == self.station_id {
            return Verdict::SameStationId;
        }
        let stamp = i64::from(frame.source.timestamp);
        let made_ms = from_its_timestamp(stamp, 1 << 32, moment.utc_ms());
        let (along_m, left_m) = self.path.point(frame.source.position);
        let unit_m = (left_m.abs() <= self.numbers.beside_path_m).then_some(along_m);
        let sent = Sent { station: frame.message.station_id(), made_ms, unit_m, moment };
        match &frame.message {
            Message::Spatem(spatem) => {
                let states = spatem.intersections.iter().map(|state| self.take_state(state, &sent));
                states.max().unwrap_or(Verdict::Accepted)
            }
            Message::Mapem(mapem) => {
                let maps = mapem.intersections.iter().map(|map| self.take_map(map, &sent));
                maps.max().unwrap_or(Verdict::Accepted)
            }
            Message::Cam(cam) if self.is_of_now(made_ms, moment) => {
                self.take_motion(cam, moment.run_ns(made_ms), (along_m, left_m));
                Verdict::Accepted
            }
            Message::Cam(_) => Verdict::TooOld,
        }
    }

    fn is_of_now(&self, made_ms: i64, moment: &Moment) -> bool {
        moment.age_ms(made_ms).abs() <= self.max_age_ms
    }

    /// Keeps the motion of a vehicle at `made_ns`, at a place along the path and to its left, m.
    fn take_motion(&mut self, cam: &Cam, made_ns: i64, (along_m, left_m): (f64, f64)) {
        let &Cam { station_id, motion, .. } = cam;
        let is_its = |known: &AnnouncedMotion| known.station_id == u64::from(station_id);
        // The air may reorder frames.
        self.motions.retain(|known| !is_its(known) || known.made_ns > made_ns);
        let is_known = motion.speed < UNAVAILABLE.0 && motion.acceleration < UNAVAILABLE.1;
        if is_known && self.motions.len() < MAX_MOTIONS && !self.motions.iter().any(is_its) {
            self.motions.push(AnnouncedMotion {
                station_id: station_id.into(),
                made_ns,
                rear_position_m: along_m - f64::from(motion.length) / 10.0,
                lateral_m: left_m,
                speed_mps: f64::from(motion.speed) / 100.0,
                acceleration_mps2: f64::from(motion.acceleration) / 10.0,
            });
        }
    }

    /// Timing that is too old still shows that the intersection exists: its signals are unknown, not absent.
    fn take_state(&mut self, state: &IntersectionState, sent: &Sent) -> Verdict {
        let moment = sent.moment;
        let made_ms = state.stamp.map_or(sent.made_ms, |stamp| stamp.utc(moment.utc_ms()));
        let is_of_now = self.is_of_now(sent.made_ms, moment) && self.is_of_now(made_ms, moment);
        let Some(known) = self.intersection(state.id, moment.now_ns) else {
            return Verdict::UnknownIntersection;
        };
        known.note(moment.now_ns, sent.unit_m);
        if !is_of_now {
            return Verdict::TooOld;
        }
        known.take_timing(sent.station, state, moment.run_ns(made_ms), moment)
    }

    fn take_map(&mut self, geometry: &IntersectionGeometry, sent: &Sent) -> Verdict {
        let (now_ns, station) = (sent.moment.now_ns, sent.station);
        let is_of_now = self.is_of_now(sent.made_ms, sent.moment);
        let is_usable = sent.moment.age_ms(sent.made_ms).abs() <= OLDEST_MAP_MS;
        let lines = stop_lines(geometry, &self.path, &self.numbers);
        match self.intersection(geometry.id, now_ns) {
            Some(known) if is_of_now || is_usable && known.map.is_none() => {
                known.note(now_ns, sent.unit_m);
                let geometry = geometry.clone();
                known.take_map(Told { station, geometry, lines }, now_ns)
            }
            Some(_) => Verdict::TooOld,
            None => Verdict::UnknownIntersection,
        }
    }

    /// The entry of an intersection; `None` if the room is full.
    fn intersection(&mut self, id: u16, now_ns: i64) -> Option<&mut Intersection> {
        let found = self.intersections.iter().position(|known| known.id == id);
        if found.is_none() && self.intersections.len() == MOST_INTERSECTIONS {
            return None;
        }
        let index = found.unwrap_or_else(|| {
            self.intersections.push(Intersection::new(id, now_ns, self.numbers));
            self.intersections.len() - 1
        });
        Some(&mut self.intersections[index])
    }
}

#[cfg(test)]
mod tests;
