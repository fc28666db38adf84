//! Whether the radar's tracks can be believed.

use super::{Check, Findings};
use messages::{Header, RadarTracks, Track};

/// Scans in a row with the same figures that no noise makes.
const REPEATED: u32 = 2;
/// The same of a radar without noise, on the move: rounding alone differs from scan to scan.
const REPEATED_EXACT: u32 = 10;
/// Speed from which the ego moves, m/s.
const MOVES_MPS: f64 = 0.5;
/// Difference of a range's change from its rate, summed up with a memory of this time, s: m, and by range.
const SUM_S: f64 = 1.0;
const SUM_M: f64 = 3.0;
const SUM_SHARE: f64 = 0.03;
/// Scans after which a track's figures have settled.
const SETTLED: u32 = 10;
/// Difference of the target from its track: m, by range, and m/s.
const TARGET_M: f64 = 2.5;
const TARGET_SHARE: f64 = 0.03;
const TARGET_MPS: f64 = 2.5;

/// Compares each scan with the one before, and the target with its track.
#[derive(Clone, Debug)]
pub struct Radar {
    noisy: bool,
    /// The scan before; made ahead, as the loop must not allocate.
    last: Box<RadarTracks>,
    has_seen: bool,
    repeated: u32,
    followed: Option<Followed>,
    contradicted: bool,
    corrected: Box<RadarTracks>,
}

/// The track of the target over its scans.
#[derive(Clone, Copy, Debug)]
struct Followed {
    id: u32,
    acquisition_ns: i64,
    range_m: f64,
    range_rate_mps: f64,
    scans: u32,
    sum_m: f64,
}

impl Radar {
    /// Nothing seen yet. `noisy` of a radar whose figures have noise.
    #[must_use]
    pub fn new(noisy: bool) -> Self {
        Self {
            noisy,
            last: Box::new(bytemuck::Zeroable::zeroed()),
            has_seen: false,
            repeated: 0,
            followed: None,
            contradicted: false,
            corrected: Box::new(bytemuck::Zeroable::zeroed()),
        }
    }

    /// Takes the newest scan, with the ego's speed, m/s; returns it, with the more careful figures of its
    /// target where they contradict its track, or `None` if it cannot be believed.
    pub fn look(
        &mut self,
        sample: &RadarTracks,
        ego_mps: f64,
        time_s: f64,
        findings: &mut Findings,
    ) -> Option<&RadarTracks> {
        let is_new = !self.has_seen || self.last.header != sample.header;
        if is_new {
            *self.corrected = *sample;
            let track = in_path(sample);
            if let Some(track) = track.filter(|_| sample.target.valid != 0) {
                self.correct(&track, time_s, findings);
            }
            let frozen = self.is_frozen(sample, ego_mps, time_s, findings);
            let by_rate = self.by_rate(sample, track, time_s, findings);
            self.contradicted = frozen || by_rate;
            *self.last = *sample;
            self.has_seen = true;
        }
        (!self.contradicted).then_some(&*self.corrected)
    }

    fn is_frozen(
        &mut self,
        sample: &RadarTracks,
        ego_mps: f64,
        time_s: f64,
        findings: &mut Findings,
    ) -> bool {
        let varies = (self.noisy || ego_mps > MOVES_MPS)
            && (sample.count > 0 || sample.ego_speed_points > 0);
        let bound = if self.noisy { REPEATED } else { REPEATED_EXACT };
        let same = varies && self.has_seen && content(&self.last) == content(sample);
        self.repeated = if same { self.repeated + 1 } else { 0 };
        let share = f64::from(self.repeated) / (f64::from(bound) - 0.5);
        findings.note(Check::RadarFrozen, time_s, share)
    }

    fn by_rate(
        &mut self,
        sample: &RadarTracks,
        track: Option<Track>,
        time_s: f64,
        findings: &mut Findings,
    ) -> bool {
        let target = &sample.target;
        if target.valid == 0 {
            self.followed = None;
            return false;
        }
        let (range_m, range_rate_mps) = track
            .map_or((target.gap_m, target.relative_speed_mps), |t| (t.range_m, t.range_rate_mps));
        let acquisition_ns = sample.header.acquisition_ns;
        let begun = Followed {
            id: target.track_id,
            acquisition_ns,
            range_m,
            range_rate_mps,
            scans: 0,
            sum_m: 0.0,
        };
        let Some(last) = self.followed.replace(begun).filter(|last| last.id == begun.id) else {
            return false;
        };
        let elapsed_s = (acquisition_ns - last.acquisition_ns) as f64 / 1e9;
        if elapsed_s <= 0.0 || elapsed_s > SUM_S {
            return false;
        }
        let by_rate_m = 0.5 * (last.range_rate_mps + range_rate_mps) * elapsed_s;
        let differs_m = range_m - last.range_m - by_rate_m;
        let bound_m = SUM_M + SUM_SHARE * range_m.abs();
        let settled = last.scans >= SETTLED;
        let sum_m = if settled {
            (last.sum_m * libm::exp(-elapsed_s / SUM_S) + differs_m)
                .clamp(-1.5 * bound_m, 1.5 * bound_m)
        } else {
            0.0
        };
        self.followed = Some(Followed { scans: last.scans + 1, sum_m, ..begun });
        findings.note(Check::RangeRateAgainstRange, time_s, sum_m.abs() / bound_m)
    }

    fn correct(&mut self, track: &Track, time_s: f64, findings: &mut Findings) {
        let target = &mut self.corrected.target;
        let bound_m = TARGET_M + TARGET_SHARE * track.range_m.abs();
        let share = ((target.gap_m - track.range_m).abs() / bound_m)
            .max((target.relative_speed_mps - track.range_rate_mps).abs() / TARGET_MPS);
        if findings.note(Check::TargetAgainstTrack, time_s, share) {
            target.gap_m = target.gap_m.min(track.range_m);
            target.relative_speed_mps = target.relative_speed_mps.min(track.range_rate_mps);
        }
    }
}

/// What a scan says, behind its header.
fn content(scan: &RadarTracks) -> &[u8] {
    &bytemuck::bytes_of(scan)[size_of::<Header>()..]
}

fn in_path(sample: &RadarTracks) -> Option<Track> {
    let count = usize::try_from(sample.count).map_or(0, |count| count.min(sample.tracks.len()));
    sample.tracks[..count].iter().find(|track| track.in_path != 0).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn scan(k: i64, gap_m: f64, rate_mps: f64) -> RadarTracks {
        let mut radar = RadarTracks::zeroed();
        (radar.header.acquisition_ns, radar.header.sequence) = (k * 100_000_000, k.unsigned_abs());
        radar.target.valid = 1;
        (radar.target.track_id, radar.target.gap_m) = (7, gap_m);
        radar.target.relative_speed_mps = rate_mps;
        radar.count = 1;
        radar.tracks[0].in_path = 1;
        (radar.tracks[0].range_m, radar.tracks[0].range_rate_mps) = (gap_m, rate_mps);
        radar
    }

    #[test]
    fn a_repeated_scan_is_frozen_where_there_is_noise() {
        for noisy in [true, false] {
            let (mut radar, mut findings) = (Radar::new(noisy), Findings::default());
            assert!(radar.look(&scan(0, 30.0, 0.0), 20.0, 0.0, &mut findings).is_some());
            let believed: Vec<bool> = (1..5)
                .map(|k| radar.look(&scan(k, 30.0, 0.0), 20.0, 0.0, &mut findings).is_some())
                .collect();
            assert_eq!(believed, [true, !noisy, !noisy, !noisy]);
            let exact = (5..12)
                .filter(|k| radar.look(&scan(*k, 30.0, 0.0), 20.0, 0.0, &mut findings).is_some());
            assert_eq!(exact.count(), if noisy { 0 } else { 5 }, "without noise it takes longer");
            assert!(radar.look(&scan(12, 30.01, 0.0), 20.0, 0.0, &mut findings).is_some());
        }
    }

    #[test]
    fn a_range_that_does_not_follow_its_rate_is_not_believed() {
        let (mut radar, mut findings) = (Radar::new(false), Findings::default());
        let mut gap_m = 60.0;
        for k in 0..30 {
            assert!(radar.look(&scan(k, gap_m, -4.0), 20.0, 0.0, &mut findings).is_some());
            gap_m -= 0.4;
        }
        let found = (30..60)
            .find(|k| radar.look(&scan(*k, gap_m, -8.0), 20.0, 0.0, &mut findings).is_none());
        assert!(found.is_some_and(|k| k < 40), "{found:?}");
    }

    #[test]
    fn of_target_and_track_the_more_careful_figures_count() {
        for (bias_m, expected_m) in [(5.0, 40.0), (-5.0, 35.0), (1.0, 41.0)] {
            let (mut radar, mut findings) = (Radar::new(false), Findings::default());
            let mut scan = scan(0, 40.0, -1.0);
            scan.target.gap_m += bias_m;
            let believed = radar.look(&scan, 20.0, 0.0, &mut findings).expect("it is believed");
            assert_eq!(believed.target.gap_m, expected_m);
        }
    }
}
