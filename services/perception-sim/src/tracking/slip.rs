//! The slip angle of the ego's front bumper, as standing objects show it.
//!
//! A standing object at azimuth `phi` has the range rate `-v cos(phi) - w sin(phi)`. v is the bumper's speed along the
//! body. w is its speed to the left. Least squares over what stands gives both; their ratio is the slip angle, which a
//! scalar Kalman filter smooths. The driver's steering and the road's curvature change it.
//!
//! Source: D. Kellner, M. Barjenbruch, J. Klappstein, J. Dickmann, K. Dietmayer, Instantaneous ego-motion
//! estimation using Doppler radar, ITSC 2013.
//!
//! ```
//! use perception_sim::tracking::slip::Slip;
//!
//! let mut slip = Slip::default();
//! let objects = [0.3_f64, -0.25, 0.1, -0.4].map(|azimuth| {
//!     let (sine, cosine) = azimuth.sin_cos();
//!     (cosine, sine, -20.0 * (cosine + 0.01 * sine))
//! });
//! for _ in 0..20 {
//!     slip.take_scan(0.05, 20.0, &objects);
//! }
//! assert!((slip.slip_rad() - 0.01).abs() < 1e-4);
//! ```

/// Standard deviation of the range rate of a standing object, m/s: the receiver's, with a margin for what merges.
const NOISE_MPS: f64 = 0.08;
/// Difference from the fit beyond which an object does not stand, m/s.
const FAR_MPS: f64 = 0.3;
/// Change of the slip angle in a second: a curve of 125 m radius is entered in some 2 s.
const CHANGE_RADPS: f64 = 0.01;
/// Standard deviation before the first scan, and the largest, rad.
const FIRST_RAD: f64 = 0.02;
/// Speed below which nothing is measured, m/s.
const SLOW_MPS: f64 = 3.0;

/// The estimate.
#[derive(Clone, Copy, Debug)]
pub struct Slip {
    slip_rad: f64,
    variance: f64,
}

impl Default for Slip {
    fn default() -> Self {
        Self { slip_rad: 0.0, variance: FIRST_RAD * FIRST_RAD }
    }
}

impl Slip {
    /// Takes the standing objects of a scan, `dt_s` after the one before: cosine and sine of the azimuth, and range
    /// rate, m/s.
    pub fn take_scan(&mut self, dt_s: f64, ego_mps: f64, standing: &[(f64, f64, f64)]) {
        let change_rad = CHANGE_RADPS * CHANGE_RADPS * dt_s;
        self.variance = (self.variance + change_rad).min(FIRST_RAD * FIRST_RAD);
        if ego_mps < SLOW_MPS {
            return;
        }
        let all = fit(standing, |_| true);
        let Some((v, w, _)) = all else { return };
        let is_near = |&(cosine, sine, rate): &(f64, f64, f64)| {
            (rate + v * cosine + w * sine).abs() < FAR_MPS
        };
        let Some((v, w, information)) = fit(standing, is_near) else { return };
        let measured_rad = w / v.max(SLOW_MPS);
        let noise_rad = NOISE_MPS / v.max(SLOW_MPS);
        let variance = noise_rad * noise_rad / information;
        let gain = self.variance / (self.variance + variance);
        self.slip_rad += gain * (measured_rad - self.slip_rad);
        self.variance *= 1.0 - gain;
    }

    /// Angle from the body's axis to the way of the bumper, rad, left positive.
    pub fn slip_rad(&self) -> f64 {
        self.slip_rad
    }
}

/// Speeds along and across, and the information on the latter in multiples of one object's; `None` of too few.
fn fit(
    standing: &[(f64, f64, f64)],
    counts: impl Fn(&(f64, f64, f64)) -> bool,
) -> Option<(f64, f64, f64)> {
    let (mut cc, mut cs, mut ss, mut cr, mut sr, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0, 0);
    for object in standing.iter().filter(|object| counts(object)) {
        let (cosine, sine, rate) = *object;
        cc += cosine * cosine;
        cs += cosine * sine;
        ss += sine * sine;
        cr -= cosine * rate;
        sr -= sine * rate;
        count += 1;
    }
    let determinant = cc * ss - cs * cs;
    if count < 3 || determinant <= 1e-3 * cc {
        return None;
    }
    let (v, w) = ((ss * cr - cs * sr) / determinant, (cc * sr - cs * cr) / determinant);
    Some((v, w, determinant / cc))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Objects on both sides at 25 m/s and a slip angle, with noise; the second one moves.
    fn objects(slip_rad: f64, random: &mut Random, mover_mps: f64) -> Vec<(f64, f64, f64)> {
        (0..8)
            .map(|k| {
                let side = if k % 2 == 0 { 9.0 } else { -9.0 };
                let (sine, cosine) = libm::sincos(libm::atan2(side, 20.0 + 12.0 * f64::from(k)));
                let moves = if k == 1 { mover_mps } else { 0.0 };
                let rate = -25.0 * (cosine + slip_rad * sine) + moves + 0.05 * random.normal();
                (cosine, sine, rate)
            })
            .collect()
    }

    #[test]
    fn it_follows_the_angle_within_a_few_milliradians() {
        let mut random = Random::of_run(2, 0);
        let mut slip = Slip::default();
        let mut worst = 0.0_f64;
        for scan in 0..300 {
            // From 0 to 0.02 rad within 2 s, as in a sharp curve.
            let truth = 0.02 * ((f64::from(scan) - 100.0) / 40.0).clamp(0.0, 1.0);
            slip.take_scan(0.05, 25.0, &objects(truth, &mut random, 0.0));
            if scan > 20 {
                worst = worst.max((slip.slip_rad() - truth).abs());
            }
        }
        assert!(worst < 0.006, "{worst}");
    }

    #[test]
    fn a_crawling_vehicle_among_them_does_not_count() {
        let mut random = Random::of_run(2, 0);
        let mut slip = Slip::default();
        (0..100).for_each(|_| slip.take_scan(0.05, 25.0, &objects(0.01, &mut random, 0.8)));
        assert!((slip.slip_rad() - 0.01).abs() < 0.004, "{}", slip.slip_rad());
    }

    #[test]
    fn too_few_and_an_ego_that_stands_are_no_measurement() {
        let mut slip = Slip::default();
        slip.take_scan(0.05, 20.0, &[(1.0, 0.05, -20.0), (1.0, -0.05, -20.0)]);
        slip.take_scan(0.05, 0.1, &objects(0.0, &mut Random::of_run(1, 1), 0.0));
        assert_eq!(slip.slip_rad(), 0.0);
    }

    /// Objects that stand before an ego with these speeds along and across.
    fn stand(v: f64, w: f64, azimuths: &[f64]) -> Vec<(f64, f64, f64)> {
        let object = |azimuth: &f64| {
            let (sine, cosine) = libm::sincos(*azimuth);
            (cosine, sine, -v * cosine - w * sine)
        };
        azimuths.iter().map(object).collect()
    }

    #[test]
    fn a_fit_finds_both_speeds_and_its_information() {
        let (v, w, information) =
            fit(&stand(20.0, 0.5, &[0.3, -0.3, 0.1]), |_| true).expect("three objects");
        assert!((v - 20.0).abs() < 1e-9 && (w - 0.5).abs() < 1e-9, "{v} {w}");
        // The sines' squares less what the speed along explains.
        let (c, s) = (libm::cos, libm::sin);
        let cc = 2.0 * c(0.3) * c(0.3) + c(0.1) * c(0.1);
        let expected = 2.0 * s(0.3) * s(0.3) + s(0.1) * s(0.1) - square(s(0.1) * c(0.1)) / cc;
        assert!((information - expected).abs() < 1e-9, "{information} {expected}");
        assert!(fit(&stand(20.0, 0.5, &[0.3, -0.3]), |_| true).is_none(), "two");
        assert!(fit(&stand(20.0, 0.5, &[0.1, 0.1, 0.1]), |_| true).is_none(), "one direction");
    }

    fn square(value: f64) -> f64 {
        value * value
    }

    #[test]
    fn a_scan_is_weighted_by_its_information() {
        let azimuths = [0.3, -0.3, 0.2, -0.2];
        let of_all: f64 = azimuths.iter().map(|azimuth| square(libm::sin(*azimuth))).sum();
        // 0.02 rad are assumed at first, and are the most.
        let noise = square(0.08 / 20.0) / of_all;
        let gain = 4e-4 / (4e-4 + noise);
        let mut slip = Slip::default();
        slip.take_scan(0.05, 20.0, &stand(20.0, 0.2, &azimuths));
        assert!((slip.slip_rad() - gain * 0.01).abs() < 1e-12, "{}", slip.slip_rad());
        let kept = 4e-4 * (1.0 - gain);
        assert!((slip.variance - kept).abs() < 1e-15);
        // Between two scans the angle may change by 0.01 rad/s.
        slip.take_scan(0.05, 20.0, &[]);
        assert!((slip.variance - kept - 1e-4 * 0.05).abs() < 1e-15);
        let mut slow = Slip::default();
        slow.take_scan(0.05, 2.9, &stand(2.9, 0.1, &azimuths));
        assert_eq!(slow.slip_rad(), 0.0);
        slow.take_scan(0.05, 3.1, &stand(3.1, 0.1, &azimuths));
        let gain = 4e-4 / (4e-4 + square(0.08 / 3.1) / of_all);
        assert!((slow.slip_rad() - gain * 0.1 / 3.1).abs() < 1e-12, "{}", slow.slip_rad());
    }

    /// One of nine objects moves; the fit of all nine is off by a part of its speed.
    #[test]
    fn what_is_farther_than_0_3_mps_from_the_fit_is_left_out() {
        let azimuths = [0.4, -0.4, 0.35, -0.35, 0.3, -0.3, 0.25, -0.25, 0.0];
        let angle = |mover_mps: f64| {
            let mut objects = stand(20.0, 0.0, &azimuths);
            objects[0].2 += mover_mps;
            let mut slip = Slip::default();
            slip.take_scan(0.05, 20.0, &objects);
            slip.slip_rad()
        };
        assert_eq!(angle(0.0), 0.0);
        assert!(angle(0.3).abs() > 1e-4, "it counts");
        assert!(angle(0.6).abs() < 1e-12 && angle(-0.6).abs() < 1e-12, "it does not");
    }
}
