//! Whether the ego's motion can be believed: its position must move as its speed says.
//!
//! The end-to-end protection finds what was changed on the way, not what its sender made up. A sender
//! that repeats itself under fresh stamps, or whose speed is off, contradicts itself here.

use messages::Odometry;

/// Distance by which position and speed may differ between two samples, m.
const TOLERANCE_M: f64 = 0.3;
/// Part of the distance travelled by which they may differ.
const TOLERANCE: f64 = 0.1;

/// Compares each sample of odometry with the one before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    last: Option<Odometry>,
    contradicted: bool,
}

impl Motion {
    /// Takes the newest sample; true if it agrees with the one before.
    pub fn agrees(&mut self, sample: &Odometry) -> bool {
        let Some(last) = self.last.replace(*sample) else { return true };
        let elapsed_ns = sample.header.acquisition_ns - last.header.acquisition_ns;
        // The same sample again says nothing new; an older one is the age's concern.
        if elapsed_ns > 0 {
            let elapsed_s = elapsed_ns as f64 / 1e9;
            let by_speed_m = 0.5 * (last.speed_mps + sample.speed_mps) * elapsed_s;
            let by_position_m = sample.position_m - last.position_m;
            let bound_m = TOLERANCE_M + TOLERANCE * by_speed_m.abs();
            let agrees = (by_position_m - by_speed_m).abs() <= bound_m;
            self.contradicted = !agrees;
        }
        !self.contradicted
    }
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

    #[test]
    fn honest_motion_agrees_at_any_rate_and_at_full_braking() {
        for period_s in [0.001, 0.01, 0.1, 1.0] {
            let mut motion = Motion::default();
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
        let mut motion = Motion::default();
        assert!(motion.agrees(&sample(0.0, 0.0, 20.0)));
        assert!(!motion.agrees(&sample(0.1, 0.0, 20.0)));
        assert!(!motion.agrees(&sample(0.1, 0.0, 20.0)), "the same sample says nothing new");
        assert!(!motion.agrees(&sample(0.2, 0.0, 20.0)));
        assert!(!motion.agrees(&sample(0.3, 6.0, 20.0)), "the jump back to the truth");
        assert!(motion.agrees(&sample(0.4, 8.0, 20.0)));
    }

    #[test]
    fn a_speed_that_is_off_contradicts_the_position() {
        let mut motion = Motion::default();
        assert!(motion.agrees(&sample(0.0, 0.0, 26.0)));
        assert!(!motion.agrees(&sample(0.1, 2.0, 28.0)));
    }
}
