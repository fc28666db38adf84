//! The stop lines of an intersection, according to its maps.
//!
//! Maps can differ: a newer map moves a line, a falsified map contradicts. Nothing in them shows which one is right. So
//! a line of any of them counts until it is passed. It is the last map's, an earlier one's, or a contradicting one's.
//! If one signal has several lines, the nearest ahead counts.

use crate::lanes::StopLine;
use its::mapem::IntersectionGeometry;

/// Silence of a map's sender after which another sender can replace the map, ns. Chosen: four lost maps in a row are no
/// chance.
const MAP_SILENT_NS: i64 = 5_000_000_000;
const MOST_FORMER: usize = 16;

/// A map as a sender tells it, with its lines on the vehicle's path.
#[derive(Clone, Debug)]
pub struct Told {
    pub station: u32,
    pub geometry: IntersectionGeometry,
    pub lines: Vec<StopLine>,
}

/// The accepted map, and one that waits for its repetition.
#[derive(Clone, Debug)]
pub struct KnownMap {
    pub(crate) accepted: Told,
    heard_ns: i64,
    former: Vec<StopLine>,
    candidate: Option<Told>,
}

impl KnownMap {
    pub fn new(accepted: Told, now_ns: i64) -> Self {
        Self { accepted, heard_ns: now_ns, former: Vec::new(), candidate: None }
    }

    /// Takes another map of the same intersection; returns true if it is the accepted one now. `is_announced`: its
    /// sender's timing has its revision, which confirms it.
    pub fn take(&mut self, told: Told, now_ns: i64, is_announced: bool) -> bool {
        if self.accepted.geometry == told.geometry {
            (self.heard_ns, self.candidate) = (now_ns, None);
            return true;
        }
        let is_new = self.revision() != told.geometry.revision && is_announced;
        let again = (self.candidate.as_ref())
            .is_some_and(|said| said.station == told.station && said.geometry == told.geometry);
        let is_silent = now_ns - self.heard_ns > MAP_SILENT_NS;
        let may_replace = self.accepted.station == told.station || is_silent;
        if !(may_replace && (is_new || again)) {
            self.candidate = Some(told);
            return false;
        }
        let mut former = std::mem::take(&mut self.former);
        former.extend(&self.accepted.lines);
        former.retain(|line| !told.lines.contains(line));
        former.drain(..former.len().saturating_sub(MOST_FORMER));
        *self = Self { former, ..Self::new(told, now_ns) };
        true
    }

    /// Revision; only timing of the same revision is used.
    pub fn revision(&self) -> u8 {
        self.accepted.geometry.revision
    }

    /// The line of each signal group for a vehicle at `ego_m`.
    pub fn in_force(&self, ego_m: f64) -> impl Iterator<Item = StopLine> + '_ {
        self.accepted.lines.iter().map(move |line| {
            let candidate = self.candidate.iter().flat_map(|said| &said.lines);
            let all = self.accepted.lines.iter().chain(&self.former).chain(candidate);
            let ahead = all.filter(|other| {
                other.signal_group == line.signal_group && other.position_m >= ego_m
            });
            let nearest = ahead.min_by(|a, b| a.position_m.total_cmp(&b.position_m));
            nearest.copied().unwrap_or(*line)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use its::geodesy::Position;

    fn map(revision: u8) -> IntersectionGeometry {
        IntersectionGeometry {
            region: None,
            id: 1,
            revision,
            reference: Position { latitude: 0, longitude: 0 },
            lane_width_cm: None,
            lanes: Vec::new(),
            unread_lanes: 0,
        }
    }

    fn told(station: u32, geometry: IntersectionGeometry, position_m: f64) -> Told {
        Told { station, geometry, lines: vec![StopLine { signal_group: 1, position_m }] }
    }

    fn nearest(map: &KnownMap, ego_m: f64) -> f64 {
        map.in_force(ego_m).next().expect("it has a line").position_m
    }

    #[test]
    fn lines_that_moved_count_one_after_the_other() {
        for (first_m, then_m) in [(300.0, 290.0), (300.0, 320.0)] {
            let mut known = KnownMap::new(told(1, map(0), first_m), 0);
            assert!(known.take(told(1, map(1), then_m), 1, true));
            let (near_m, far_m) = (f64::min(first_m, then_m), f64::max(first_m, then_m));
            assert_eq!(nearest(&known, 200.0), near_m);
            assert_eq!(nearest(&known, near_m + 1.0), far_m);
            assert_eq!(nearest(&known, far_m + 1.0), then_m);
        }
    }

    #[test]
    fn a_map_that_is_said_once_can_only_bring_a_line_nearer_until_the_first_is_said_again() {
        let mut known = KnownMap::new(told(1, map(0), 300.0), 0);
        assert!(!known.take(told(1, map(1), 320.0), 1, false));
        assert_eq!(nearest(&known, 0.0), 300.0);
        assert!(!known.take(told(1, map(2), 240.0), 2, false));
        assert_eq!(nearest(&known, 0.0), 240.0);
        assert!(known.take(told(1, map(0), 300.0), 3, false));
        assert_eq!(nearest(&known, 0.0), 300.0);
    }

    #[test]
    fn another_sender_replaces_a_map_only_after_silence() {
        let mut known = KnownMap::new(told(1, map(0), 300.0), 0);
        assert!(!known.take(told(2, map(1), 320.0), 1, true));
        assert!(!known.take(told(2, map(1), 320.0), 2, true));
        assert!(known.take(told(2, map(1), 320.0), 5_000_000_001, true));
        assert_eq!((known.revision(), nearest(&known, 0.0)), (1, 300.0));
    }
}
