//! A comfortable driver: the improved intelligent driver model (Treiber and Kesting, Traffic Flow
//! Dynamics, 2013, section 11.3.7).
//!
//! ```text
//! s*     = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b)))
//! a_free = a (1 - (v/v0)^4)                 for v <= v0
//!        = -b (1 - v0/v)^(1/2)              for v >  v0
//! z      = s*/s
//! a_follow = a (1 - z²)                     for v <= v0, z >= 1
//!          = a_free (1 - z^(2a/a_free))     for v <= v0, z <  1
//!          = a_free + a (1 - z²)            for v >  v0, z >= 1
//!          = a_free                         for v >  v0, z <  1
//! ```
//!
//! Alone it brakes harder than needed when a vehicle cuts in closely. So the constant-acceleration heuristic of
//! Kesting, Treiber and Helbing tempers it, with `a_l' = min(a_lead, a)`. Source: "Enhanced intelligent driver model",
//! 2010, equations 5 to 7:
//!
//! ```text
//! a_cah = v² a_l' / (v_lead² - 2 s a_l')               while the lead stops first
//!       = a_l' - max(0, v - v_lead)² / (2 s)           else
//! a_acc = a_follow                                     for a_follow >= a_cah
//!       = a_cah + b tanh((a_follow - a_cah) / b)       else          (their coolness c = 1)
//! ```
//!
//! Both react late to a lead that brakes hard while the gap is still ample. Beyond a deceleration
//! of 1 m/s² the driver therefore takes the heuristic's request, in full from 2 m/s² on:
//!
//! ```text
//! a_driver = a_acc + clamp(-a_lead / (1 m/s²) - 1, 0, 1) min(0, a_cah - a_acc)
//! ```
//!
//! It is explicit and always has an answer. The road controller rolls it out as its reference. Both laws fall
//! back to it when a convex program has no solution in time.
//!
//! | symbol | field | unit |
//! |---|---|---|
//! | `T` | [`Obstacle::headway_s`] | s |
//! | `s0` | [`Obstacle::standstill_m`] | m |
//! | `s` | [`Obstacle::gap_m`] | m |
//! | `v_lead` | [`Obstacle::speed_mps`] | m/s |
//! | `a_lead` | [`Obstacle::acceleration_mps2`] | m/s² |
//! | `a` | [`Driver::acceleration_mps2`] | m/s² |
//! | `b` | [`Driver::deceleration_mps2`] | m/s² |
//! | `v0` | `desired_mps` | m/s |

/// Temper of the driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driver {
    /// Acceleration on a free road from standstill, m/s².
    pub acceleration_mps2: f64,
    /// Deceleration that it finds comfortable, m/s², positive.
    pub deceleration_mps2: f64,
    /// Hardest braking it is capable of, m/s², positive.
    pub hardest_mps2: f64,
}

/// Something ahead that it must not reach: a vehicle or a closed stop line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    pub gap_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Time headway kept to it, s.
    pub headway_s: f64,
    /// Distance kept at standstill, m.
    pub standstill_m: f64,
}

/// Headway that a driver keeps to a stop line, s.
const LINE_HEADWAY_S: f64 = 1.0;

impl Obstacle {
    /// A closed line, before which the driver stops at `standstill_m`.
    pub fn line(gap_m: f64, standstill_m: f64) -> Self {
        let (speed_mps, acceleration_mps2) = (0.0, 0.0);
        Self { gap_m, speed_mps, acceleration_mps2, headway_s: LINE_HEADWAY_S, standstill_m }
    }
}

impl Driver {
    /// Acceleration with nothing ahead, m/s².
    #[inline]
    pub fn free_mps2(&self, speed_mps: f64, desired_mps: f64) -> f64 {
        let (v, v0) = (speed_mps.max(0.0), desired_mps.max(0.1));
        if v <= v0 {
            let ratio = v / v0;
            self.acceleration_mps2 * (1.0 - ratio * ratio * ratio * ratio)
        } else {
            -self.deceleration_mps2 * (1.0 - v0 / v).sqrt()
        }
    }

    /// Acceleration behind `obstacle`, m/s².
    pub fn follow_mps2(&self, speed_mps: f64, desired_mps: f64, obstacle: &Obstacle) -> f64 {
        let free = self.free_mps2(speed_mps, desired_mps);
        self.follow_below_mps2(free, speed_mps, desired_mps, obstacle)
    }

    /// The same where [`Self::free_mps2`] at these speeds is known.
    #[inline]
    pub fn follow_below_mps2(
        &self,
        free: f64,
        speed_mps: f64,
        desired_mps: f64,
        obstacle: &Obstacle,
    ) -> f64 {
        let (v, a) = (speed_mps.max(0.0), self.acceleration_mps2);
        let closing = v - obstacle.speed_mps;
        let braking = v * closing / (2.0 * (a * self.deceleration_mps2).sqrt());
        let desired = obstacle.standstill_m + (v * obstacle.headway_s + braking).max(0.0);
        let z = desired / obstacle.gap_m.max(0.1);
        let wanted = if v <= desired_mps {
            if z >= 1.0 {
                a * (1.0 - z * z)
            } else if free > 1e-3 * a {
                free * (1.0 - power(z, 2.0 * a / free))
            } else {
                free
            }
        } else if z >= 1.0 {
            free + a * (1.0 - z * z)
        } else {
            free
        };
        let heuristic = self.constant_acceleration_mps2(v, obstacle);
        let b = self.deceleration_mps2;
        let tempered = if wanted >= heuristic {
            wanted
        } else {
            heuristic + b * tanh_below_zero((wanted - heuristic) / b)
        };
        let heed = (-obstacle.acceleration_mps2 - 1.0).clamp(0.0, 1.0);
        (tempered + heed * (heuristic - tempered).min(0.0)).max(-self.hardest_mps2)
    }

    /// Acceleration that just avoids a collision while the obstacle keeps its acceleration, m/s².
    fn constant_acceleration_mps2(&self, speed_mps: f64, obstacle: &Obstacle) -> f64 {
        let (v, v_lead, s) = (speed_mps, obstacle.speed_mps.max(0.0), obstacle.gap_m.max(0.1));
        let a_lead = obstacle.acceleration_mps2.min(self.acceleration_mps2);
        if a_lead < 0.0 && v_lead * (v - v_lead) <= -2.0 * s * a_lead {
            v * v * a_lead / (v_lead * v_lead - 2.0 * s * a_lead)
        } else {
            let closing = (v - v_lead).max(0.0);
            a_lead - closing * closing / (2.0 * s)
        }
    }
}

/// `base^exponent` for a base in (0, 1) and an exponent above 0, within 2.3e-16 (absolute). It takes 40 % of the time
/// of `libm::pow`, which keeps all digits of small results.
fn power(base: f64, exponent: f64) -> f64 {
    libm::exp2(exponent * libm::log2(base))
}

/// `tanh(x)` for `x <= 0`, within 2.3e-16 (absolute), from the exponential alone.
fn tanh_below_zero(x: f64) -> f64 {
    let e = libm::exp2(2.0 * std::f64::consts::LOG2_E * x);
    (e - 1.0) / (e + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_own_powers_are_as_exact_as_they_say() {
        for step in 1..2_000 {
            let base = f64::from(step) / 2_000.0;
            for exponent in [0.1, 2.0, 2.7, 11.0, 400.0, 2_000.0] {
                let off = power(base, exponent) - libm::pow(base, exponent);
                assert!(off.abs() < 2.3e-16, "{base}^{exponent}: {off:e}");
            }
            let x = -20.0 * base;
            let off = tanh_below_zero(x) - libm::tanh(x);
            assert!(off.abs() < 2.3e-16, "tanh {x}: {off:e}");
        }
        assert_eq!((tanh_below_zero(0.0), tanh_below_zero(-1e9)), (0.0, -1.0));
    }

    const DRIVER: Driver =
        Driver { acceleration_mps2: 1.5, deceleration_mps2: 1.8, hardest_mps2: 4.9 };

    #[test]
    fn the_desired_gap_is_an_equilibrium() {
        let lead = Obstacle {
            gap_m: 27.5,
            speed_mps: 15.0,
            acceleration_mps2: 0.0,
            headway_s: 1.5,
            standstill_m: 5.0,
        };
        assert!(DRIVER.follow_mps2(15.0, 25.0, &lead).abs() < 1e-12);
        assert!(DRIVER.free_mps2(25.0, 25.0).abs() < 1e-12);
    }

    #[test]
    fn a_lead_that_brakes_hard_is_heeded_at_once() {
        let ample = Obstacle {
            gap_m: 52.0,
            speed_mps: 20.0,
            acceleration_mps2: -3.8,
            headway_s: 1.5,
            standstill_m: 5.0,
        };
        // Deceleration that stops 52 m later than a lead that needs 52.6 m: 434 / (2 (52 + 52.6)).
        let needed = -20.8 * 20.8 / (2.0 * (52.0 + 400.0 / 7.6));
        assert!((DRIVER.follow_mps2(20.8, 25.0, &ample) - needed).abs() < 1e-9);
        let gentle = Obstacle { acceleration_mps2: -0.8, ..ample };
        assert!(DRIVER.follow_mps2(20.8, 25.0, &gentle) > 0.0);
    }

    #[test]
    fn it_stops_short_of_a_standing_obstacle_comfortably() {
        let (mut x, mut v, mut hardest) = (0.0, 20.0, 0.0_f64);
        for _ in 0..6000 {
            let line = Obstacle {
                gap_m: 180.0 - x,
                speed_mps: 0.0,
                acceleration_mps2: 0.0,
                headway_s: 0.6,
                standstill_m: 1.0,
            };
            let a = DRIVER.follow_mps2(v, 20.0, &line);
            hardest = hardest.min(a);
            x += 0.01 * v;
            v = (v + 0.01 * a).max(0.0);
        }
        assert!(x > 177.0 && x < 179.3, "{x}");
        assert!(hardest > -2.6, "{hardest}");
    }
}
