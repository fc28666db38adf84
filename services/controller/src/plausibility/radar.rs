//! Plausibility of the radar's tracks.
//!
//! | check | a contradiction | not one |
//! |---|---|---|
//! | frozen | noise that repeats itself; exact figures that stay the same while the ego's speed changes | an empty scan at a stand; an exact lead at constant gap |
//! | rate | a range that moves other than its rate for a second | one measurement of another part of the vehicle |
//! | target | a gap or speed far from a track that moves on evenly | a new target, or a measurement that jumped |
//!
//! A measurement jumps where the radar sees another object, or another part of a vehicle. Such parts are a flank, or a
//! lorry's front axle through its under-body. The filter behind the target rejects that, so the two differ for one
//! scan.
//!
//! An origin ends with the effect of the limit at half and at double, within the range. The drives are half an hour
//! without faults, and five with each false radar.
//!
//! ```sh
//! timegap test plausibility --effects plausibility --seeds 20
//! ```
//!
//! The base: no drive has a false alarm. A frozen radar is found after 0.13 to 0.20 s. A gap that is off by 5 m is
//! found after 0.03 s, in five of five drives. So is a relative speed that is off by 3 m/s. A gap that is off by 2 m
//! and a speed that is off by 1 m/s are not found.

use super::{Check, Findings};
use messages::{Header, Odometry, RadarTracks};
use parameters::{Varied, parameters};

parameters! {
    /// Limits of the radar's checks.
    pub struct Limits {
        /// Scans in a row with the same figures that no noise makes.
        repeated: u32 = 2, "scans", 1.0..=10.0,
            "Chosen: one repetition can be a message that came twice. At 1: a frozen radar is found after 0.03 to 0.10 s; \
             at 4: after 0.33 to 0.40 s.";
        /// The same of a radar without noise.
        repeated_exact: u32 = 10, "scans", 2.0..=40.0,
            "Chosen: half a second at 20 scans per second. No change at 5 and 20.";
        /// Change of the ego's speed that exact figures must show.
        ego_changes_mps: f64 = 0.1, "m/s", 0.01..=1.0,
            "Chosen: above what an acceleration of 1 m/s² over the age of a scan makes of the ego's speed. No change \
             at 0.05 and 0.2.";
        /// Memory of the sum of a range's differences from its rate.
        sum_s: f64 = 1.0, "s", 0.2..=5.0,
            "Chosen: with 3 m of bound it finds a rate that is off by 4 m/s in 1 s. No change at 0.5 and 2.";
        /// Bound of that sum.
        sum_m: f64 = 3.0, "m", 1.0..=10.0,
            "Chosen: 61 % of it were reached in 10 h without faults. No change at 1.5 and 6.";
        /// The same by range.
        sum_share: f64 = 0.03, "1", 0.0..=0.1,
            "Chosen: detections of a vehicle spread with its distance. No change at 0.015 and 0.06.";
        /// Scans after which a track's figures have settled.
        settled: u32 = 10, "scans", 1.0..=40.0,
            "Chosen: the tracker's filter settles in half a second. No change at 5 and 20.";
        /// Scans after which a target can be compared with its track.
        settled_target: u32 = 5, "scans", 1.0..=40.0,
            "Chosen: beside a vehicle that cuts in the radar sees its flank, 3.9 m ahead of its rear, for 0.3 s. No \
             change at 3 and 10.";
        /// Difference of the target from its track, in distance.
        target_m: f64 = 2.5, "m", 0.5..=10.0,
            "Chosen: six standard deviations of the object list's range. At 1.25: gap biased (+2 m) found 5 instead \
             of 0 times; at 5: gap biased (+5 m) found after 1.73 instead of 0.03 s, gap biased (-5 m) found 0 \
             instead of 5 times.";
        /// The same of a radar whose range has more noise.
        target_sigmas: f64 = 6.0, "1", 3.0..=10.0, "Chosen: as above. No change at 3 and 10.";
        /// The same by range.
        target_share: f64 = 0.03, "1", 0.0..=0.1,
            "Chosen: as above. At 0.015: no change; at 0.06: gap biased (-5 m) found 1 instead of 5 times, after 9.83 s.";
        /// The same in speed.
        target_mps: f64 = 2.5, "m/s", 0.5..=10.0,
            "Chosen: above what a lead of 10 m/s² makes of a filter's lag. At 1.25: no change; at 5: relative speed \
             biased (+3 m/s) found 0 instead of 5 times.";
    }
}

pub static LIMITS: Varied<Limits> = Varied::new(Limits::DEFAULT);

/// Compares each scan with the one before, and the target with its track.
#[derive(Clone, Debug)]
pub struct Radar {
    noisy: bool,
    /// Standard deviation of a single range, m; 0 where it is small.
    range_sigma_m: f64,
    /// The scan before; made ahead, as the loop must not allocate.
    last: Box<RadarTracks>,
    has_seen: bool,
    repeated: u32,
    /// Speed of the ego at the first scan of the row, m/s.
    row_begins_mps: f64,
    followed: Option<Followed>,
    contradicted: bool,
    corrected: Box<RadarTracks>,
}

/// The track of the target over its scans.
#[derive(Clone, Copy, Debug)]
struct Followed {
    now: Measured,
    scans: u32,
    /// Sum of the differences of range and rate, m.
    sum_m: f64,
}

/// Measurement of the target's track in one scan.
#[derive(Clone, Copy, Debug)]
struct Measured {
    id: u32,
    acquisition_ns: i64,
    range_m: f64,
    range_rate_mps: f64,
    /// A track stands behind it, not the target alone.
    is_measured: bool,
}

impl Radar {
    /// Nothing seen yet. `noisy` of a radar whose figures have noise, with the deviation of a single range, m.
    pub fn new(noisy: bool, range_sigma_m: f64) -> Self {
        Self {
            noisy,
            range_sigma_m,
            last: Box::new(bytemuck::Zeroable::zeroed()),
            has_seen: false,
            repeated: 0,
            row_begins_mps: 0.0,
            followed: None,
            contradicted: false,
            corrected: Box::new(bytemuck::Zeroable::zeroed()),
        }
    }

    /// Takes the newest scan and the newest odometry. Returns the scan, or `None` if it is not valid. A target that
    /// contradicts its track gets its more careful figures.
    pub fn look(
        &mut self,
        sample: &RadarTracks,
        odometry: Option<&Odometry>,
        time_s: f64,
        findings: &mut Findings,
    ) -> Option<&RadarTracks> {
        let is_new = !self.has_seen || self.last.header != sample.header;
        if is_new {
            *self.corrected = *sample;
            let frozen = self.is_frozen(sample, odometry, time_s, findings);
            let by_rate = match Measured::of(sample) {
                Some(now) => self.follow(&now, time_s, findings),
                None => {
                    self.followed = None;
                    false
                }
            };
            self.contradicted = frozen || by_rate;
            *self.last = *sample;
            self.has_seen = true;
        }
        (!self.contradicted).then_some(&*self.corrected)
    }

    fn is_frozen(
        &mut self,
        sample: &RadarTracks,
        odometry: Option<&Odometry>,
        time_s: f64,
        findings: &mut Findings,
    ) -> bool {
        let scan_ns = sample.header.acquisition_ns;
        let ego_mps = odometry.map_or(0.0, |odometry| {
            let apart_s = (odometry.header.acquisition_ns - scan_ns) as f64 / 1e9;
            odometry.speed_mps - odometry.acceleration_mps2 * apart_s
        });
        // A speed of exactly 0 is a measurement that was cut off there: it has no noise.
        let varies = sample.count > 0 || sample.ego_speed_mps != 0.0;
        let same = varies && self.has_seen && content(&self.last) == content(sample);
        if same {
            self.repeated += 1;
        } else {
            (self.repeated, self.row_begins_mps) = (0, ego_mps);
        }
        let (counted, bound) = if self.noisy {
            (self.repeated, LIMITS.repeated)
        } else {
            // Exact figures repeat behind a lead of the ego's own speed, until that changes: range rates show it.
            let moved = (ego_mps - self.row_begins_mps).abs() > LIMITS.ego_changes_mps;
            let counted = if moved { self.repeated } else { 0 };
            (counted, LIMITS.repeated_exact)
        };
        let share = f64::from(counted) / (f64::from(bound) - 0.5);
        findings.note(Check::RadarFrozen, time_s, share)
    }

    /// Follows the target's track from scan to scan; true if its range contradicts its rate.
    fn follow(&mut self, now: &Measured, time_s: f64, findings: &mut Findings) -> bool {
        let begun = Followed { now: *now, scans: 0, sum_m: 0.0 };
        let Some(last) = self.followed.replace(begun).filter(|last| last.now.id == now.id) else {
            return false;
        };
        let elapsed_s = (now.acquisition_ns - last.now.acquisition_ns) as f64 / 1e9;
        if elapsed_s <= 0.0 || elapsed_s > LIMITS.sum_s {
            return false;
        }
        let by_rate_m = 0.5 * (last.now.range_rate_mps + now.range_rate_mps) * elapsed_s;
        let differs_m = now.range_m - last.now.range_m - by_rate_m;
        let scans = last.scans + 1;
        if scans >= LIMITS.settled_target {
            self.correct(now, differs_m, time_s, findings);
        }
        let bound_m = LIMITS.sum_m + LIMITS.sum_share * now.range_m.abs();
        // A single jump is not a motion. It counts with at most half the bound, and its way back removes that again.
        let counted_m = differs_m.clamp(-0.5 * bound_m, 0.5 * bound_m);
        let sum_m = if last.scans >= LIMITS.settled {
            (last.sum_m * libm::exp(-elapsed_s / LIMITS.sum_s) + counted_m)
                .clamp(-1.5 * bound_m, 1.5 * bound_m)
        } else {
            0.0
        };
        self.followed = Some(Followed { now: *now, scans, sum_m });
        findings.note(Check::RangeRateAgainstRange, time_s, sum_m.abs() / bound_m)
    }

    /// Takes the more careful of the target's figures and its track's where they are far apart. `differs_m` is what the
    /// track's range differs from what the last scan and the rate said.
    fn correct(&mut self, track: &Measured, differs_m: f64, time_s: f64, findings: &mut Findings) {
        let target = &mut self.corrected.target;
        let noise_m = LIMITS.target_sigmas * self.range_sigma_m;
        let bound_m = LIMITS.target_m.max(noise_m) + LIMITS.target_share * track.range_m.abs();
        if !track.is_measured || differs_m.abs() > bound_m {
            return;
        }
        let share = ((target.gap_m - track.range_m).abs() / bound_m)
            .max((target.relative_speed_mps - track.range_rate_mps).abs() / LIMITS.target_mps);
        if findings.note(Check::TargetAgainstTrack, time_s, share) {
            target.gap_m = target.gap_m.min(track.range_m);
            target.relative_speed_mps = target.relative_speed_mps.min(track.range_rate_mps);
        }
    }
}

impl Measured {
    /// The measurement behind the target of a scan, or the target itself where no track is named.
    fn of(sample: &RadarTracks) -> Option<Self> {
        let target = Some(&sample.target).filter(|target| target.valid != 0)?;
        let track = sample.tracks().iter().find(|track| track.in_path != 0);
        let (range_m, range_rate_mps) = track
            .map_or((target.gap_m, target.relative_speed_mps), |t| (t.range_m, t.range_rate_mps));
        Some(Self {
            id: target.track_id,
            acquisition_ns: sample.header.acquisition_ns,
            range_m,
            range_rate_mps,
            is_measured: track.is_some(),
        })
    }
}

/// Content of a scan, behind its header.
fn content(scan: &RadarTracks) -> &[u8] {
    &bytemuck::bytes_of(scan)[size_of::<Header>()..]
}
