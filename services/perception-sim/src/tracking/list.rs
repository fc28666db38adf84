//! The result of tracking after a scan.

use messages::MAX_TRACKS;

/// The tracks after a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackList {
    /// Time of the scan, ns since the start of the run; negative before it.
    pub acquisition_ns: i64,
    /// The tracks, nearest first; `count` are valid.
    pub tracks: [Track; MAX_TRACKS],
    /// Valid entries of `tracks`.
    pub count: usize,
    /// Tracks without room: the farthest that are not in the path.
    pub left_out: u32,
    /// Index of the target among the tracks: the nearest one in the path.
    pub target: Option<usize>,
}

/// One vehicle as it is tracked, at the time of the scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Track {
    /// Identity: a new number means a new vehicle, or the same one found again.
    pub id: u32,
    /// Range of the last measurement, m.
    pub range_m: f64,
    /// Range rate of the last measurement, m/s, negative when closing.
    pub range_rate_mps: f64,
    /// Azimuth of the last measurement, rad, left positive.
    pub azimuth_rad: f64,
    /// It was measured in this scan; otherwise the estimates are predictions.
    pub measured: bool,
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    /// Its speed minus the ego's, m/s.
    pub relative_speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Lateral position of its centre, m, left positive.
    pub lateral_m: f64,
    /// Lateral speed, m/s, left positive.
    pub lateral_speed_mps: f64,
    /// Length as far as it is seen, m.
    pub length_m: f64,
    /// Width as far as it is seen, m.
    pub width_m: f64,
    pub in_path: bool,
    /// As in the message.
    pub doubt_share: f64,
}

impl TrackList {
    /// An empty list of the scan of `acquisition_ns`.
    pub fn new(acquisition_ns: i64) -> Self {
        Self { acquisition_ns, ..Self::default() }
    }

    pub fn tracks(&self) -> &[Track] {
        &self.tracks[..self.count]
    }

    pub fn target(&self) -> Option<&Track> {
        self.target.map(|index| &self.tracks[index])
    }

    /// Adds a track. In a full list it replaces the farthest one outside the path. It is left out if it is that one
    /// itself.
    pub fn add(&mut self, track: Track) {
        if self.count < MAX_TRACKS {
            self.tracks[self.count] = track;
            self.count += 1;
            return;
        }
        self.left_out += 1;
        let rank = |track: &Track| (!track.in_path, track.gap_m);
        let farther = |a: &Track, b: &Track| {
            let ((a, a_m), (b, b_m)) = (rank(a), rank(b));
            a.cmp(&b).then(a_m.total_cmp(&b_m))
        };
        let last = self.tracks.iter_mut().max_by(|a, b| farther(a, b));
        if let Some(last) = last
            && farther(&track, last).is_lt()
        {
            *last = track;
        }
    }

    /// Brings the tracks into their order and picks the target.
    pub fn finish(&mut self) {
        self.tracks[..self.count].sort_unstable_by(|a, b| a.gap_m.total_cmp(&b.gap_m));
        self.target = self.tracks().iter().position(|track| track.in_path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(id: u32, gap_m: f64, in_path: bool) -> Track {
        Track { id, gap_m, in_path, ..Track::default() }
    }

    #[test]
    fn the_target_is_the_nearest_in_the_path() {
        let mut list = TrackList::new(0);
        for track in [track(1, 50.0, true), track(2, 10.0, false), track(3, 30.0, true)] {
            list.add(track);
        }
        list.finish();
        assert_eq!(list.target().map(|track| track.id), Some(3));
        assert_eq!(list.tracks().iter().map(|track| track.id).collect::<Vec<_>>(), [2, 3, 1]);
    }

    #[test]
    fn a_full_list_keeps_the_path_and_counts_the_rest() {
        let mut list = TrackList::new(0);
        for id in 0..10 {
            list.add(track(id, f64::from(id), false));
        }
        list.add(track(99, 200.0, true));
        list.finish();
        assert_eq!((list.count, list.left_out), (MAX_TRACKS, 3));
        assert_eq!(list.target().map(|track| track.id), Some(99));
        assert!(list.tracks().iter().all(|track| track.id < 7 || track.id == 99));
    }
}
