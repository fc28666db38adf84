//! The ego's motion while its odometry is missing or not valid.
//!
//! It goes on from the last odometry. It takes the speed that the radar measures by standing objects beside the road.
//! Without these it takes, for a short time, the speed that the commands make. Only odometry ends the estimate: the
//! radar measures no position, and stop lines are kept by position.

use messages::{Odometry, RadarTracks};

/// Times for which the radar's speed replaces odometry, s, and for which the commands do.
const BY_RADAR_S: f64 = 10.0;
const BY_COMMANDS_S: f64 = 1.5;
/// Oldest measurement of use, s.
const STALE_S: f64 = 0.3;
/// Lag of the vehicle behind its commands, s.
const LAG_S: f64 = 0.5;

#[derive(Clone, Copy, Debug, Default)]
pub struct EgoEstimate {
    /// The motion, as a message from this time.
    now: Option<Odometry>,
    /// Times of the last valid odometry, and of the last speed from it or the radar, s.
    believed_s: f64,
    measured_s: f64,
}

impl EgoEstimate {
    /// Takes fresh and valid odometry.
    pub fn believe(&mut self, odometry: &Odometry, time_s: f64) {
        self.now = Some(*odometry);
        (self.believed_s, self.measured_s) = (time_s, time_s);
    }

    /// The motion at `time_s` without odometry. It takes the radar's scan if it is valid, and the request of the last
    /// command, m/s². `None` when too much time has passed.
    pub fn advance(
        &mut self,
        radar: Option<&RadarTracks>,
        commanded_mps2: f64,
        time_s: f64,
    ) -> Option<&Odometry> {
        let now = self.now.as_mut()?;
        let then_s = now.header.acquisition_ns as f64 / 1e9;
        let elapsed_s = (time_s - then_s).clamp(0.0, 1.0);
        let (speed_mps, acceleration_mps2) = (now.speed_mps, now.acceleration_mps2);
        let share = 1.0 - libm::exp(-elapsed_s / LAG_S);
        let mut next_mps2 = acceleration_mps2 + share * (commanded_mps2 - acceleration_mps2);
        let mut next_mps = (speed_mps + 0.5 * (acceleration_mps2 + next_mps2) * elapsed_s).max(0.0);
        let scanned = radar.and_then(|radar| {
            let age_s = time_s - radar.header.acquisition_ns as f64 / 1e9;
            radar.measured_ego_speed_mps().filter(|_| age_s <= STALE_S).map(|mps| (mps, age_s))
        });
        if let Some((mps, age_s)) = scanned {
            next_mps = (mps + next_mps2 * age_s).max(0.0);
            self.measured_s = time_s;
        }
        if next_mps == 0.0 {
            next_mps2 = 0.0;
        }
        now.position_m += 0.5 * (speed_mps + next_mps) * elapsed_s;
        (now.speed_mps, now.acceleration_mps2) = (next_mps, next_mps2);
        now.header.acquisition_ns = (time_s * 1e9) as i64;
        let holds =
            time_s - self.believed_s <= BY_RADAR_S && time_s - self.measured_s <= BY_COMMANDS_S;
        if !holds {
            self.now = None;
        }
        self.now.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn it_goes_on_with_the_radars_speed_and_shortly_without() {
        let mut estimate = EgoEstimate::default();
        assert!(estimate.advance(None, 0.0, 0.0).is_none(), "nothing to go on from");
        let mut odometry = Odometry::zeroed();
        (odometry.position_m, odometry.speed_mps) = (100.0, 20.0);
        estimate.believe(&odometry, 0.0);
        let mut scan = RadarTracks::zeroed();
        scan.ego_speed_points = 5;
        for k in 1..=50 {
            let time_s = 0.1 * f64::from(k);
            scan.header.acquisition_ns = (time_s * 1e9) as i64;
            scan.ego_speed_mps = 20.0 - 2.0 * time_s;
            assert!(estimate.advance(Some(&scan), -2.0, time_s).is_some());
        }
        let now = *estimate.advance(None, -2.0, 5.0).expect("it was there just now");
        assert!((now.position_m - 175.0).abs() < 1.0 && (now.speed_mps - 10.0).abs() < 0.2);
        assert!(estimate.advance(None, -2.0, 6.4).is_some());
        assert!(estimate.advance(None, -2.0, 6.6).is_none());
        scan.header.acquisition_ns = 6_700_000_000;
        assert!(estimate.advance(Some(&scan), -2.0, 6.7).is_none(), "where it is, is not known");
        estimate.believe(&odometry, 7.0);
        assert!(estimate.advance(None, 0.0, 7.1).is_some());
    }
}
