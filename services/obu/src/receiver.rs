//! The unit's view of the signals ahead, from the frames that it hears.
//!
//! Nothing here can prove who sent a frame: there are no signatures. What is checked is whether frames fit
//! each other, their own stamps and the vehicle's clock:
//!
//! * an intersection counts when two frames have told of it, so that a falsified id makes none;
//! * what differs from what its sender said before must be said twice in a row;
//! * where two senders disagree within [`AGREED_NS`], neither is believed: the signal is unknown;
//! * timing is used with the map of its revision alone.

use crate::clock::Moment;
use crate::lanes::{StopLine, road_plane, stop_lines};
use crate::timing::Timing;
use crate::verdict::{Verdict, Verdicts};
use its::geodesy::Plane;
use its::mapem::{IntersectionGeometry, Mapem};
use its::spatem::{IntersectionState, Spatem};
use its::time::from_its_timestamp;
use its::{Frame, Message};
use messages::{Lane, Map, Spat};
use std::collections::VecDeque;
use xxhash_rust::xxh3::xxh3_64;

/// A stop line is forgotten when it is this far behind, m.
const PASSED_M: f64 = 45.0;
/// Frames among which the same bytes are noticed.
const REMEMBERED_FRAMES: usize = 512;
/// Intersections and senders of one intersection that are kept.
const MOST_INTERSECTIONS: usize = 64;
const MOST_SENDERS: usize = 4;
/// For so long a sender's word stands against another's, ns.
const AGREED_NS: i64 = 2_000_000_000;
/// After so long without its sender another one may replace a map, ns.
const MAP_SILENT_NS: i64 = 5_000_000_000;
/// An intersection of which nothing was heard for so long, and which is not ahead, is forgotten, ns.
const FORGOTTEN_NS: i64 = 30_000_000_000;

/// What the unit knows, and what it made of the frames.
#[derive(Debug)]
pub struct Receiver {
    station_id: u32,
    max_age_ms: i64,
    plane: Plane,
    intersections: Vec<Intersection>,
    heard: VecDeque<u64>,
    verdicts: Verdicts,
}

/// An intersection as it was told of.
#[derive(Clone, Debug)]
struct Intersection {
    id: u16,
    /// Frames that told of it.
    frames: u64,
    heard_ns: i64,
    map: Option<KnownMap>,
    senders: Vec<Sender>,
    /// When its timing was last made without a contradiction, ns of run time.
    certain_ns: Option<i64>,
}

/// A map as it is believed, and one that waits to be heard again.
#[derive(Clone, Debug)]
struct KnownMap {
    station: u32,
    heard_ns: i64,
    geometry: IntersectionGeometry,
    lines: Vec<StopLine>,
    /// Of the map before. A vehicle that waits at one of these has not passed it because a newer map puts it
    /// behind the vehicle.
    former: Vec<StopLine>,
    candidate: Option<(u32, IntersectionGeometry)>,
}

impl KnownMap {
    /// Where a line counts for a vehicle at `ego_m`.
    fn in_force(&self, line: &StopLine, ego_m: f64) -> StopLine {
        let is_passed = |line: &StopLine| line.position_m < ego_m;
        let same = |former: &&StopLine| former.signal_group == line.signal_group;
        let former = self.former.iter().find(same).filter(|former| !is_passed(former));
        former.filter(|_| is_passed(line)).copied().unwrap_or(*line)
    }
}

/// What one sender says of an intersection's signals.
#[derive(Clone, Debug)]
struct Sender {
    station: u32,
    /// When it was made, ns of run time.
    made_ns: i64,
    revision: u8,
    timings: Vec<Timing>,
    /// What it said last, if that did not fit.
    candidate: Option<Vec<Timing>>,
}

impl Receiver {
    /// A unit that has heard nothing yet.
    #[must_use]
    pub fn new(station_id: u32, max_age_ms: i64) -> Self {
        Self {
            station_id,
            max_age_ms,
            plane: road_plane(),
            intersections: Vec::new(),
            heard: VecDeque::with_capacity(REMEMBERED_FRAMES),
            verdicts: Verdicts::default(),
        }
    }

    /// Goes on from these counts.
    #[must_use]
    pub fn counting(self, verdicts: Verdicts) -> Self {
        Self { verdicts, ..self }
    }

    /// Takes a frame.
    pub fn take(&mut self, bytes: &[u8], moment: &Moment) -> Verdict {
        let verdict = self.judge(bytes, moment);
        self.verdicts.count(verdict);
        verdict
    }

    /// What was made of all frames so far.
    #[must_use]
    pub fn verdicts(&self) -> &Verdicts {
        &self.verdicts
    }

    /// Forgets what is over. `ego_m` is the vehicle's position on its path.
    pub fn forget(&mut self, now_ns: i64, ego_m: f64) {
        self.intersections.retain(|intersection| {
            intersection.lines_ahead(ego_m).next().is_some()
                || now_ns - intersection.heard_ns < FORGOTTEN_NS
        });
    }

    /// Writes the stop lines ahead and the timing of their signals, nearest first. Returns when the oldest
    /// timing of them was made, ns of run time; `None` where no signal is ahead.
    pub fn write(&self, now_ns: i64, ego_m: f64, map: &mut Map, spat: &mut Spat) -> Option<i64> {
        let mut ahead: Vec<(&Intersection, StopLine)> = (self.intersections.iter())
            .filter(|intersection| intersection.frames >= 2)
            .flat_map(|known| known.lines_ahead(ego_m).map(move |line| (known, line)))
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
            // Nothing was ever certain: as old as the run.
            let made_ns = known.certain_ns.unwrap_or(0);
            oldest_ns = Some(oldest_ns.map_or(made_ns, |oldest| oldest.min(made_ns)));
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
        let frame = match Frame::decode(bytes) {
            Ok(frame) => frame,
            Err(error) => return Verdict::from(&error),
        };
        if frame.message.station_id() == self.station_id {
            return Verdict::SameStationId;
        }
        let stamp = i64::from(frame.source.timestamp);
        let made_ms = from_its_timestamp(stamp, 1 << 32, moment.utc_ms());
        if !self.is_of_now(made_ms, moment) {
            return Verdict::TooOld;
        }
        match &frame.message {
            Message::Spatem(spatem) => self.take_spatem(spatem, made_ms, moment),
            Message::Mapem(mapem) => self.take_mapem(mapem, moment),
            // Of other vehicles: the signals do not depend on them.
            Message::Cam(_) => Verdict::Accepted,
        }
    }

    fn is_of_now(&self, made_ms: i64, moment: &Moment) -> bool {
        moment.age_ms(made_ms).abs() <= self.max_age_ms
    }

    fn take_spatem(&mut self, spatem: &Spatem, sent_ms: i64, moment: &Moment) -> Verdict {
        let mut worst = Verdict::Accepted;
        for state in &spatem.intersections {
            let made_ms = state.stamp.map_or(sent_ms, |stamp| stamp.utc(moment.utc_ms()));
            let verdict = if self.is_of_now(made_ms, moment) {
                let made_ns = moment.run_ns(made_ms);
                match self.intersection(state.id) {
                    Some(known) => known.take_timing(spatem.station_id, state, made_ns, moment),
                    None => Verdict::UnknownIntersection,
                }
            } else {
                Verdict::TooOld
            };
            worst = worst.max(verdict);
        }
        worst
    }

    fn take_mapem(&mut self, mapem: &Mapem, moment: &Moment) -> Verdict {
        let mut worst = Verdict::Accepted;
        for geometry in &mapem.intersections {
            let lines = stop_lines(geometry, &self.plane);
            let verdict = match self.intersection(geometry.id) {
                _ if lines.is_empty() => Verdict::MissingLane,
                Some(known) => known.take_map(mapem.station_id, geometry, lines, moment.now_ns),
                None => Verdict::UnknownIntersection,
            };
            worst = worst.max(verdict);
        }
        worst
    }

    /// What is known of an intersection; `None` if there is no room for one more.
    fn intersection(&mut self, id: u16) -> Option<&mut Intersection> {
        let found = self.intersections.iter().position(|known| known.id == id);
        let index = match found {
            Some(index) => index,
            None if self.intersections.len() < MOST_INTERSECTIONS => {
                self.intersections.push(Intersection {
                    id,
                    frames: 0,
                    heard_ns: 0,
                    map: None,
                    senders: Vec::new(),
                    certain_ns: None,
                });
                self.intersections.len() - 1
            }
            None => return None,
        };
        Some(&mut self.intersections[index])
    }
}

impl Intersection {
    fn lines_ahead(&self, ego_m: f64) -> impl Iterator<Item = StopLine> + '_ {
        let lines = self
            .map
            .iter()
            .flat_map(move |map| map.lines.iter().map(move |line| map.in_force(line, ego_m)));
        lines.filter(move |line| line.position_m - ego_m > -PASSED_M)
    }

    fn take_timing(
        &mut self,
        station: u32,
        state: &IntersectionState,
        made_ns: i64,
        moment: &Moment,
    ) -> Verdict {
        let now_s = moment.now_ns as f64 / 1e9;
        let timings: Vec<Timing> =
            state.movements.iter().map(|m| Timing::of(m, made_ns, moment)).collect();
        match self.senders.iter_mut().find(|sender| sender.station == station) {
            Some(sender) => {
                if made_ns <= sender.made_ns {
                    return Verdict::OutOfOrder;
                }
                let fits = agree(&sender.timings, &timings, now_s)
                    || moment.now_ns - sender.made_ns > AGREED_NS;
                let again = (sender.candidate.as_ref())
                    .is_some_and(|candidate| agree(candidate, &timings, now_s));
                if !fits && !again {
                    sender.candidate = Some(timings);
                    return Verdict::Contradicting;
                }
                sender.candidate = None;
                (sender.made_ns, sender.revision) = (made_ns, state.revision);
                sender.timings = timings;
            }
            None => {
                if self.senders.len() == MOST_SENDERS {
                    // The one that has been silent for the longest makes room.
                    self.senders.sort_by_key(|sender| -sender.made_ns);
                    self.senders.pop();
                }
                let revision = state.revision;
                self.senders.push(Sender { station, made_ns, revision, timings, candidate: None });
            }
        }
        self.frames += 1;
        self.heard_ns = moment.now_ns;
        if self.disagreement(moment.now_ns) {
            return Verdict::Contradicting;
        }
        let Some(map) = &self.map else { return Verdict::UnknownIntersection };
        if map.geometry.revision != state.revision {
            return Verdict::Contradicting;
        }
        self.renew(moment.now_ns);
        let Some(map) = &self.map else { return Verdict::UnknownIntersection };
        let told = |line: &StopLine| {
            state.movements.iter().any(|movement| movement.signal_group == line.signal_group)
        };
        if map.lines.iter().all(told) { Verdict::Accepted } else { Verdict::MissingLane }
    }

    fn take_map(
        &mut self,
        station: u32,
        geometry: &IntersectionGeometry,
        lines: Vec<StopLine>,
        now_ns: i64,
    ) -> Verdict {
        self.frames += 1;
        self.heard_ns = now_ns;
        // A sender whose timing is of this revision already says so a second time.
        let is_announced = (self.senders.iter())
            .any(|sender| sender.station == station && sender.revision == geometry.revision);
        let Some(map) = &mut self.map else {
            let geometry = geometry.clone();
            let former = Vec::new();
            let heard_ns = now_ns;
            self.map =
                Some(KnownMap { station, heard_ns, geometry, lines, former, candidate: None });
            self.renew(now_ns);
            return Verdict::Accepted;
        };
        if map.geometry == *geometry {
            (map.heard_ns, map.candidate) = (now_ns, None);
            return Verdict::Accepted;
        }
        let is_new = map.geometry.revision != geometry.revision && is_announced;
        let again =
            map.candidate.as_ref().is_some_and(|(by, said)| *by == station && said == geometry);
        let may_replace = map.station == station || now_ns - map.heard_ns > MAP_SILENT_NS;
        if may_replace && (is_new || again) {
            let geometry = geometry.clone();
            let former = std::mem::take(&mut map.lines);
            let heard_ns = now_ns;
            *map = KnownMap { station, heard_ns, geometry, lines, former, candidate: None };
            self.renew(now_ns);
            return Verdict::Accepted;
        }
        map.candidate = Some((station, geometry.clone()));
        Verdict::Contradicting
    }

    /// Notes how new the timing is that fits the map and that nothing contradicts.
    fn renew(&mut self, now_ns: i64) {
        let Some(map) = self.map.as_ref().filter(|_| !self.disagreement(now_ns)) else { return };
        let of_revision = self.senders.iter().filter(|s| s.revision == map.geometry.revision);
        self.certain_ns = self.certain_ns.max(of_revision.map(|sender| sender.made_ns).max());
    }

    /// True if two senders whose word stands say different things.
    fn disagreement(&self, now_ns: i64) -> bool {
        let now_s = now_ns as f64 / 1e9;
        let standing = |sender: &&Sender| now_ns - sender.made_ns <= AGREED_NS;
        let mut standing = self.senders.iter().filter(standing);
        let Some(first) = standing.next() else { return false };
        standing.any(|other| !agree(&first.timings, &other.timings, now_s))
    }

    /// The newest timing of a signal group that nothing contradicts.
    fn timing(&self, signal_group: u8, now_ns: i64) -> Option<&Timing> {
        let map = self.map.as_ref()?;
        if self.disagreement(now_ns) {
            return None;
        }
        let of_revision = self.senders.iter().filter(|s| s.revision == map.geometry.revision);
        let newest = of_revision.max_by_key(|sender| sender.made_ns)?;
        newest.timings.iter().find(|timing| timing.signal_group == signal_group)
    }
}

/// True if all that both say of the same signal groups can be true.
fn agree(a: &[Timing], b: &[Timing], now_s: f64) -> bool {
    a.iter().all(|of_a| {
        let mut same = b.iter().filter(|of_b| of_b.signal_group == of_a.signal_group);
        same.all(|of_b| of_a.agrees_with(of_b, now_s))
    })
}

#[cfg(test)]
mod tests;
