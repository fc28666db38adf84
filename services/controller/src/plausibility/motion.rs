//! Plausibility of odometry.

use super::{Check, Findings};
use messages::{Odometry, RadarTracks};

/// Limits of the difference between position and speed in two samples. They are a distance at any speed, m; a share of
/// the distance travelled; and the effect of a jerk in the time between them, m/s².
const STEP_M: f64 = 0.04;
const STEP_SHARE: f64 = 0.01;
const STEP_MPS2: f64 = 2.0;
/// The same summed up with a memory of this time, s: m, and by the distance travelled in it.
const SUM_S: f64 = 2.0;
const SUM_M: f64 = 0.25;
const SUM_SHARE: f64 = 0.01;
/// Largest change of speed: m/s², and m/s on top.
const LIMIT_MPS2: f64 = 12.0;
const LIMIT_MPS: f64 = 0.3;
/// Difference from the radar's measurement of the ego's speed, in m/s and by the speed. The third value is the scans in
/// a row that must show it.
const RADAR_MPS: f64 = 1.0;
const RADAR_SHARE: f64 = 0.02;
const RADAR_SCANS: u32 = 3;
/// Difference below which a track has the speed of the measurement, m/s. The radar allows a standing object's detection
/// as much.
const QUEUE_MPS: f64 = 0.6;
/// Difference of commands from the one that odometry last followed, m/s². The second value is its least duration, s,
/// while no figure of odometry changes.
const COMMAND_MPS2: f64 = 0.3;
const COMMAND_S: f64 = 0.8;

/// Compares each sample of odometry with the one before, the radar and the commands.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    last: Option<Odometry>,
    contradicted: bool,
    /// Sum of the differences of position and speed, m.
    sum_m: f64,
    /// Acquisition of the last scan compared with, ns, and scans in a row that disagree.
    scan_ns: i64,
    disagreeing: u32,
    /// Time since which no figure changed, s.
    same_since_s: Option<f64>,
    /// The command at that time, m/s².
    then_mps2: f64,
}

impl Motion {
    /// Takes the newest sample; true if nothing contradicts it.
    pub fn agrees(
        &mut self,
        sample: &Odometry,
        radar: Option<&RadarTracks>,
        commanded_mps2: f64,
        time_s: f64,
        findings: &mut Findings,
    ) -> bool {
        let Some(last) = self.last.replace(*sample) else { return true };
        let elapsed_ns = sample.header.acquisition_ns - last.header.acquisition_ns;
        // The same sample again adds nothing; an older one is judged by its age.
        if elapsed_ns > 0 {
            let elapsed_s = elapsed_ns as f64 / 1e9;
            let by_itself = self.by_itself(&last, sample, elapsed_s, time_s, findings);
            let by_limits = {
                let change_mps = (sample.speed_mps - last.speed_mps).abs();
                let share = change_mps / (LIMIT_MPS + LIMIT_MPS2 * elapsed_s);
                findings.note(Check::VehicleLimits, time_s, share)
            };
            let by_command = self.by_command(&last, sample, commanded_mps2, time_s, findings);
            let by_radar = self.by_radar(sample, radar, time_s, findings);
            self.contradicted = by_itself || by_limits || by_command || by_radar;
        }
        !self.contradicted
    }

    fn by_itself(
        &mut self,
        last: &Odometry,
        sample: &Odometry,
        elapsed_s: f64,
        time_s: f64,
        findings: &mut Findings,
    ) -> bool {
        let by_speed_m = 0.5 * (last.speed_mps + sample.speed_mps) * elapsed_s;
        let differs_m = sample.position_m - last.position_m - by_speed_m;
        let step_m = STEP_M + STEP_SHARE * by_speed_m.abs() + STEP_MPS2 * elapsed_s * elapsed_s;
        let bound_m = SUM_M + SUM_SHARE * sample.speed_mps.abs() * SUM_S;
        // Bounded, so that it is over soon after the fault.
        self.sum_m = (self.sum_m * libm::exp(-elapsed_s / SUM_S) + differs_m)
            .clamp(-1.5 * bound_m, 1.5 * bound_m);
        let share = (differs_m.abs() / step_m).max(self.sum_m.abs() / bound_m);
        findings.note(Check::SpeedAgainstPosition, time_s, share)
    }

    fn by_command(
        &mut self,
        last: &Odometry,
        sample: &Odometry,
        commanded_mps2: f64,
        time_s: f64,
        findings: &mut Findings,
    ) -> bool {
        let figures =
            |o: &Odometry| [o.position_m, o.speed_mps, o.acceleration_mps2, o.request_mps2];
        if figures(last) != figures(sample) {
            self.same_since_s = None;
            return findings.note(Check::SpeedAgainstCommand, time_s, 0.0);
        }
        let since_s = *self.same_since_s.get_or_insert(time_s);
        if since_s == time_s {
            self.then_mps2 = commanded_mps2;
        }
        if (commanded_mps2 - self.then_mps2).abs() < COMMAND_MPS2 {
            // A quantity that follows the commands may stand still with them.
            self.same_since_s = Some(time_s);
            return findings.note(Check::SpeedAgainstCommand, time_s, 0.0);
        }
        findings.note(Check::SpeedAgainstCommand, time_s, (time_s - since_s) / COMMAND_S)
    }

    fn by_radar(
        &mut self,
        sample: &Odometry,
        radar: Option<&RadarTracks>,
        time_s: f64,
        findings: &mut Findings,
    ) -> bool {
        let Some(radar) = radar else {
            self.disagreeing = 0;
            return false;
        };
        let Some(measured_mps) = radar.measured_ego_speed_mps() else { return false };
        if radar.header.acquisition_ns != self.scan_ns {
            self.scan_ns = radar.header.acquisition_ns;
            let apart_s = (sample.header.acquisition_ns - self.scan_ns) as f64 / 1e9;
            let then_mps = sample.speed_mps - sample.acceleration_mps2 * apart_s;
            let bound_mps = RADAR_MPS + RADAR_SHARE * measured_mps + 2.0 * apart_s.abs();
            let share = match queue_moves_so(radar, measured_mps, then_mps) {
                true => 0.0,
                false => (then_mps - measured_mps).abs() / bound_mps,
            };
            self.disagreeing = if share > 1.0 { self.disagreeing + 1 } else { 0 };
            // Only a row of them counts.
            let counted = if self.disagreeing < RADAR_SCANS { share.min(1.0) } else { share };
            findings.note(Check::SpeedAgainstRadar, time_s, counted);
        }
        self.disagreeing >= RADAR_SCANS
    }
}

/// True if a tracked vehicle has the speed that the radar took for standing objects, while odometry is
/// faster.
///
/// A queue that crawls beside the ego fills the scan with detections of one speed. The measurement is then the ego's
/// speed minus the queue's. No vehicle makes it greater, since a queue does not drive backwards.
fn queue_moves_so(radar: &RadarTracks, measured_mps: f64, odometry_mps: f64) -> bool {
    measured_mps < odometry_mps
        && radar.tracks().iter().any(|track| {
            let cosine = libm::cos(track.azimuth_rad).max(0.5);
            (track.range_rate_mps / cosine + measured_mps).abs() < QUEUE_MPS
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn sample(time_s: f64, position_m: f64, speed_mps: f64) -> Odometry {
        let mut odometry = Odometry::zeroed();
        odometry.header.acquisition_ns = (time_s * 1e9) as i64;
        (odometry.position_m, odometry.speed_mps) = (position_m, speed_mps);
        odometry
    }

    fn scan(time_s: f64, ego_mps: f64) -> RadarTracks {
        let mut radar = RadarTracks::zeroed();
        radar.header.acquisition_ns = (time_s * 1e9) as i64;
        (radar.ego_speed_mps, radar.ego_speed_points) = (ego_mps, 8);
        radar
    }

    /// A check with its findings.
    #[derive(Default)]
    struct Checked(Motion, Findings);

    impl Checked {
        fn agrees(&mut self, sample: &Odometry) -> bool {
            let time_s = sample.header.acquisition_ns as f64 / 1e9;
            self.0.agrees(sample, None, 0.0, time_s, &mut self.1)
        }
    }

    #[test]
    fn honest_motion_agrees_at_any_rate_and_at_full_braking() {
        for period_s in [0.001, 0.01, 0.1, 1.0] {
            let mut motion = Checked::default();
            let (mut time_s, mut speed_mps) = (0.0, 35.0_f64);
            let mut position_m = 0.0;
            while speed_mps > 0.0 {
                assert!(motion.agrees(&sample(time_s, position_m, speed_mps)));
                let next = (speed_mps - 9.0 * period_s).max(0.0);
                position_m += 0.5 * (speed_mps + next) * period_s;
                (time_s, speed_mps) = (time_s + period_s, next);
            }
        }
    }

    #[test]
    fn a_frozen_sender_contradicts_itself_until_it_thaws() {
        let mut motion = Checked::default();
        assert!(motion.agrees(&sample(0.0, 0.0, 2.0)));
        assert!(!motion.agrees(&sample(0.1, 0.0, 2.0)));
        assert!(!motion.agrees(&sample(0.1, 0.0, 2.0)), "the same sample says nothing new");
        assert!(!motion.agrees(&sample(0.3, 0.6, 2.0)), "the jump back to the truth");
        assert!(motion.agrees(&sample(1.2, 2.4, 2.0)));
    }

    #[test]
    fn a_bias_of_the_speed_is_found_at_once_or_summed_up() {
        for (bias_mps, within_s) in [(4.0, 0.15), (1.0, 0.25), (0.4, 3.0)] {
            let mut motion = Checked::default();
            motion.agrees(&sample(0.0, 0.0, 10.0));
            let found = (1..=100)
                .map(|k| 0.1 * f64::from(k))
                .find(|time_s| !motion.agrees(&sample(*time_s, 10.0 * time_s, 10.0 + bias_mps)));
            assert!(found.is_some_and(|at_s| at_s < within_s), "{bias_mps}: {found:?}");
        }
    }

    #[test]
    fn a_jump_beyond_a_vehicles_limits_is_not_its_motion() {
        let mut motion = Checked::default();
        motion.agrees(&sample(0.0, 0.0, 10.0));
        assert!(!motion.agrees(&sample(0.1, 1.15, 13.0)));
        let found = motion.1.report().into_iter().filter(|found| found.cycles > 0);
        let found: Vec<_> = found.map(|found| found.check).collect();
        assert_eq!(found, ["vehicle-limits"], "the position moved on as the speeds say");
    }

    #[test]
    fn a_standstill_that_no_command_ends_counts_only_while_the_radar_agrees() {
        let mut motion = Motion::default();
        let mut findings = Findings::default();
        let mut agree = |k: u32, radar: Option<&RadarTracks>, commanded: f64| {
            let time_s = 0.1 * f64::from(k);
            motion.agrees(&sample(time_s, 5.0, 0.0), radar, commanded, time_s, &mut findings)
        };
        assert!((0..20).all(|k| agree(k, None, -0.5)), "it holds");
        let found = (20..40).find(|k| !agree(*k, None, 0.8));
        assert!(found.is_some_and(|k| k < 32), "commands to go have no effect: {found:?}");
        let mut motion = Motion::default();
        let mut agree = |k: u32, ego_mps: f64| {
            let time_s = 0.1 * f64::from(k);
            let scan = scan(time_s - 0.05, ego_mps);
            let sample = sample(time_s, 5.0, 0.0);
            motion.agrees(&sample, Some(&scan), -0.5, time_s, &mut findings)
        };
        assert!((0..20).all(|k| agree(k, 0.2)));
        let found = (20..40).find(|k| !agree(*k, 2.0));
        assert_eq!(found, Some(22), "posts pass by");
    }

    #[test]
    fn a_queue_that_crawls_beside_the_ego_is_not_taken_for_the_roadside() {
        // The ego drives 6 m/s past a queue at 2 m/s. The radar takes the queue for standing and measures 4 m/s.
        for (azimuth_rad, queue_mps, measured_mps, agrees) in [
            (0.0, 2.0, 4.0, true),
            (-0.5, 2.0, 4.0, true),
            (0.0, 2.0, 4.7, false),
            (0.0, 0.0, 4.0, false),
            (0.0, -2.0, 8.0, false),
        ] {
            let (mut motion, mut findings) = (Motion::default(), Findings::default());
            let all = (0..10).all(|k| {
                let time_s = 0.1 * f64::from(k);
                let mut scan = scan(time_s, measured_mps);
                scan.count = 1;
                scan.tracks[0].azimuth_rad = azimuth_rad;
                scan.tracks[0].range_rate_mps = (queue_mps - 6.0) * libm::cos(azimuth_rad);
                let sample = sample(time_s, 6.0 * time_s, 6.0);
                motion.agrees(&sample, Some(&scan), 0.0, time_s, &mut findings)
            });
            assert_eq!(all, agrees, "{queue_mps} {measured_mps}");
        }
    }
}
