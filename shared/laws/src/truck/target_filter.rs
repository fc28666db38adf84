//! Kalman filter of the target: state [d, dv, a_lead], the ego's acceleration as input.
//!
//! The lead's acceleration is Singer's: a_(k+1) = e^(-dt/tau) a_k + w with tau = 2.5 s and a standard deviation of 0.5
//! m/s². Measured are gap and relative speed, R = diag(0.4², 0.15²). A measurement more than five standard deviations
//! off is not used. After three in a row the filter is wrong: it starts again, as with a new target. All these numbers
//! are keys.

use kalman::Gaussian;

use super::settings::FilterKeys;
use law::Target;

/// Variances of a new state.
const INITIAL: [f64; 3] = [1.0, 0.25, 0.25];
/// Measurements in a row outside the gate that restart the filter.
const LOST: u32 = 3;

#[derive(Clone, Debug, Default)]
pub struct TargetFilter {
    keys: FilterKeys,
    track: Option<Track>,
}

#[derive(Clone, Debug)]
struct Track {
    id: u32,
    state: Gaussian<3>,
    rejected: u32,
}

impl TargetFilter {
    pub fn new(keys: &FilterKeys) -> Self {
        Self { keys: *keys, track: None }
    }

    /// Takes in what the radar shows after `dt_s` in which the ego accelerated by `ego_mps2`.
    pub fn update(&mut self, target: Option<&Target>, ego_mps2: f64, dt_s: f64) -> Option<Target> {
        let is_sound =
            |target: &&Target| target.gap_m.is_finite() && target.relative_speed_mps.is_finite();
        let Some(target) = target.filter(is_sound) else {
            self.track = None;
            return None;
        };
        let measured = [target.gap_m, target.relative_speed_mps];
        match &mut self.track {
            Some(track) if track.id == target.track_id => {
                track.predict(&self.keys, ego_mps2, dt_s);
                track.correct(&self.keys, measured);
                if track.rejected >= LOST {
                    *track = Track::new(target.track_id, measured);
                    if target.acceleration_mps2.is_finite() {
                        track.state.mean[2] = target.acceleration_mps2;
                    }
                }
            }
            _ => self.track = Some(Track::new(target.track_id, measured)),
        }
        self.track.as_ref().map(|track| {
            let [gap_m, relative_speed_mps, acceleration_mps2] = track.state.mean;
            Target { gap_m, relative_speed_mps, acceleration_mps2, ..*target }
        })
    }
}

impl Track {
    fn new(id: u32, measured: [f64; 2]) -> Self {
        let state = Gaussian::independent([measured[0], measured[1], 0.0], INITIAL);
        Self { id, state, rejected: 0 }
    }

    fn predict(&mut self, keys: &FilterKeys, ego_mps2: f64, dt_s: f64) {
        let kept = libm::exp(-dt_s / keys.time_constant_s);
        let [gap_m, relative_mps, lead_mps2] = self.state.mean;
        let relative_mps2 = lead_mps2 - ego_mps2;
        self.state.mean = [
            gap_m + relative_mps * dt_s + 0.5 * relative_mps2 * dt_s * dt_s,
            relative_mps + relative_mps2 * dt_s,
            kept * lead_mps2,
        ];
        let transition = [[1.0, dt_s, 0.5 * dt_s * dt_s], [0.0, 1.0, dt_s], [0.0, 0.0, kept]];
        let sigma_mps2 = keys.acceleration_sigma_mps2;
        let noise = sigma_mps2 * sigma_mps2 * (1.0 - kept * kept);
        self.state.spread(&transition, &[0.5 * dt_s * dt_s, dt_s, 1.0], noise);
    }

    /// Both measurements, one after the other.
    fn correct(&mut self, keys: &FilterKeys, measured: [f64; 2]) {
        let mut inside = true;
        let variances = [keys.gap_sigma_m, keys.speed_sigma_mps].map(|sigma| sigma * sigma);
        for (element, (value, variance)) in measured.into_iter().zip(variances).enumerate() {
            let innovation = self.state.innovation(element, value, variance);
            if innovation.passes(keys.gate) {
                self.state.correct(element, &innovation);
            } else {
                inside = false;
            }
        }
        self.rejected = if inside { 0 } else { self.rejected + 1 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg64;

    /// The page: rmse 0.075 m, 0.081 m/s and 0.19 m/s² from a radar of 0.39 m and 0.15 m/s.
    #[test]
    fn it_is_several_times_as_good_as_the_radar() {
        let mut rng = Pcg64::new(1, 1);
        // Irwin and Hall: the sum of twelve uniform numbers has a variance of one.
        let mut normal = || {
            let uniform = |_| (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            (0..12).map(uniform).sum::<f64>() - 6.0
        };
        let mut filter = TargetFilter::default();
        let (dt_s, sigma_mps2) = (0.1, 0.25);
        let kept = libm::exp(-dt_s / filter.keys.time_constant_s);
        let (mut gap_m, mut relative_mps, mut lead_mps2) = (60.0, 0.0, 0.0);
        let mut squares = [0.0; 3];
        let steps = 20_000;
        for _ in 0..steps {
            gap_m += dt_s * relative_mps + 0.5 * dt_s * dt_s * lead_mps2;
            relative_mps += dt_s * lead_mps2;
            lead_mps2 = kept * lead_mps2 + sigma_mps2 * (1.0 - kept * kept).sqrt() * normal();
            let target = Target {
                track_id: 1,
                gap_m: gap_m + 0.39 * normal(),
                relative_speed_mps: relative_mps + 0.15 * normal(),
                ..Target::default()
            };
            let seen = filter.update(Some(&target), 0.0, dt_s).expect("a target");
            squares[0] += (seen.gap_m - gap_m).powi(2);
            squares[1] += (seen.relative_speed_mps - relative_mps).powi(2);
            squares[2] += (seen.acceleration_mps2 - lead_mps2).powi(2);
        }
        let [gap, speed, acceleration] = squares.map(|sum| (sum / f64::from(steps)).sqrt());
        println!("rmse {gap:.3} m, {speed:.3} m/s, {acceleration:.3} m/s²");
        assert!(gap < 0.11 && speed < 0.1 && acceleration < 0.25);
    }

    #[test]
    fn another_target_starts_anew_and_a_jump_is_followed_at_last() {
        let mut filter = TargetFilter::default();
        let mut see = |track_id, gap_m| {
            let target = Target { track_id, gap_m, ..Target::default() };
            filter.update(Some(&target), 0.0, 0.1).expect("a target").gap_m
        };
        assert_eq!(see(1, 50.0), 50.0);
        assert_eq!(see(2, 20.0), 20.0);
        assert!((see(2, 80.0) - 20.0).abs() < 1.0, "one wild measurement is not believed");
        let _ = see(2, 80.0);
        assert_eq!(see(2, 80.0), 80.0);
    }
}
