//! An echo on its way to the receiver, and the antenna that it passes through.

use crate::random::{Random, exponential};

/// Distance at which `snr_at_100_m_db` is stated, m.
pub const REFERENCE_M: f64 = 100.0;

/// One echo as it reaches the receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// Length of its path, m.
    pub range_m: f64,
    /// Rate of that length, m/s, negative when closing.
    pub range_rate_mps: f64,
    /// Azimuth, rad, left positive.
    pub azimuth_rad: f64,
    /// Power as a multiple of the receiver's noise; 0: merged into another.
    pub power: f64,
    /// It is noise that was taken for an echo: its power is already that of a detection.
    pub false_alarm: bool,
}

/// Mean power of an echo by its place. This is the radar equation; one constant holds all but range, azimuth and radar
/// cross section.
///
/// ```text
/// S/N = (S/N at 100 m, 1 m²) · sigma / 1 m² · (100 m / R)^4 · g(azimuth)²
/// ```
///
/// with a pattern g that falls like a Gaussian from the axis to the edge of the field of view. Source:
/// Skolnik, Introduction to Radar Systems (3rd ed.), sections 1.2 and 9.2.
#[derive(Clone, Copy, Debug)]
pub struct Antenna {
    /// S/N of 1 m² at 100 m on the axis, as a ratio.
    snr_at_reference: f64,
    /// Two-way loss exponent: 2^(-loss · azimuth²).
    loss_per_rad2: f64,
    pub half_field_of_view_rad: f64,
    pub max_range_m: f64,
    /// A point farther to the side than this times its distance ahead is surely out of sight.
    beyond_sight: f64,
}

impl Antenna {
    /// An antenna whose two-way gain is `edge_loss_db` less at the edge of its field of view.
    pub fn new(
        snr_at_100_m_db: f64,
        edge_loss_db: f64,
        field_of_view_deg: f64,
        max_range_m: f64,
    ) -> Self {
        let half_field_of_view_rad = 0.5 * field_of_view_deg.min(180.0).to_radians();
        Self {
            snr_at_reference: ratio(snr_at_100_m_db),
            loss_per_rad2: 0.1 * std::f64::consts::LOG2_10 * edge_loss_db
                / (half_field_of_view_rad * half_field_of_view_rad),
            half_field_of_view_rad,
            max_range_m,
            // Its rounding errors are far below the margin.
            beyond_sight: libm::tan(half_field_of_view_rad).abs() * (1.0 + 1e-9),
        }
    }

    /// The echo of a point at (`x_m` ahead, `y_m` left); `None` out of sight. It moves relative to the antenna with
    /// (`vx_mps`, `vy_mps`). `area_m2` computes its cross section, if it is in sight.
    pub fn echo(
        &self,
        (x_m, y_m): (f64, f64),
        (vx_mps, vy_mps): (f64, f64),
        area_m2: impl FnOnce() -> f64,
    ) -> Option<Echo> {
        let square = x_m * x_m + y_m * y_m;
        let is_near = square <= self.max_range_m * self.max_range_m;
        if x_m <= 0.0 || !is_near || y_m.abs() > self.beyond_sight * x_m {
            return None;
        }
        let azimuth_rad = libm::atan(y_m / x_m);
        if azimuth_rad.abs() > self.half_field_of_view_rad {
            return None;
        }
        let range_m = square.sqrt();
        let power = area_m2() * self.power_of_square_metre(range_m, azimuth_rad);
        let range_rate_mps = (vx_mps * x_m + vy_mps * y_m) / range_m;
        Some(Echo { range_m, range_rate_mps, azimuth_rad, power, false_alarm: false })
    }

    pub fn power_of_square_metre(&self, range_m: f64, azimuth_rad: f64) -> f64 {
        let near = REFERENCE_M / range_m.max(0.1);
        let square = near * near;
        let gain = libm::exp2(-self.loss_per_rad2 * azimuth_rad * azimuth_rad);
        self.snr_at_reference * square * square * gain
    }
}

/// Change of a point's cross section from scan to scan. At 77 GHz a wave is 4 mm long. Between two scans every vehicle
/// moves by many waves, so successive scans are independent.
///
/// Source: Swerling, Probability of detection for fluctuating targets, IRE Trans. Information Theory 6
/// (1960) 269.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fluctuation {
    /// Case 0: none.
    None,
    /// Case 1: many equal parts; the power is exponential.
    ManyParts,
    /// Case 3: one strong part among many; the power is chi-square with four degrees of freedom.
    StrongPart,
}

impl Fluctuation {
    /// Draws for this scan; what it gives computes the factor on the mean power.
    pub fn draw(self, random: &mut Random) -> impl FnOnce() -> f64 + use<> {
        let draws = match self {
            Self::None => [0.0; 2],
            Self::ManyParts => [random.uniform(), 0.0],
            Self::StrongPart => [random.uniform(), random.uniform()],
        };
        move || {
            let [first, second] = draws;
            match self {
                Self::None => 1.0,
                Self::ManyParts => exponential(first),
                Self::StrongPart => 0.5 * (exponential(first) + exponential(second)),
            }
        }
    }
}

pub fn ratio(decibels: f64) -> f64 {
    libm::exp(0.1 * std::f64::consts::LN_10 * decibels)
}

pub fn decibels(ratio: f64) -> f64 {
    10.0 * std::f64::consts::LOG10_E * libm::log(ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn antenna() -> Antenna {
        Antenna::new(15.0, 6.0, 60.0, 150.0)
    }

    #[test]
    fn power_falls_with_the_fourth_power_of_range_and_to_the_edge() {
        let power = |x, y| antenna().echo((x, y), (0.0, 0.0), || 10.0).expect("in sight").power;
        assert!((decibels(power(100.0, 0.0)) - 25.0).abs() < 1e-9);
        assert!((decibels(power(50.0, 0.0)) - 25.0 - 12.0412).abs() < 1e-3);
        let edge = (29.999f64.to_radians().cos() * 100.0, 29.999f64.to_radians().sin() * 100.0);
        assert!((decibels(power(edge.0, edge.1)) - 19.0).abs() < 1e-2);
    }

    #[test]
    fn sight_ends_at_range_and_field_of_view() {
        let sees = |x, y| antenna().echo((x, y), (0.0, 0.0), || 1.0).is_some();
        assert!(sees(150.0, 0.0) && !sees(150.1, 0.0) && !sees(-1.0, 0.0) && !sees(0.0, 1.0));
        assert!(sees(10.0, 5.77) && !sees(10.0, 5.78) && sees(10.0, -5.77) && !sees(10.0, -5.78));
    }

    #[test]
    fn the_range_rate_is_the_motion_along_the_line_of_sight() {
        let echo = antenna().echo((40.0, 3.0), (-5.0, 2.0), || 1.0).expect("in sight");
        assert!((echo.range_rate_mps - (-5.0 * 40.0 + 2.0 * 3.0) / echo.range_m).abs() < 1e-12);
        assert!((echo.azimuth_rad - libm::atan2(3.0, 40.0)).abs() < 1e-12);
    }

    #[test]
    fn fluctuations_keep_the_mean_and_have_swerlings_variances() {
        for (fluctuation, variance) in [
            (Fluctuation::None, 0.0),
            (Fluctuation::ManyParts, 1.0),
            (Fluctuation::StrongPart, 0.5),
        ] {
            let mut random = Random::of_run(1, 2);
            let n = 100_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..n {
                let factor = fluctuation.draw(&mut random)();
                sum += factor;
                squares += (factor - 1.0) * (factor - 1.0);
            }
            assert!((sum / f64::from(n) - 1.0).abs() < 0.01, "{fluctuation:?}");
            assert!((squares / f64::from(n) - variance).abs() < 0.03, "{fluctuation:?}");
        }
    }
}
