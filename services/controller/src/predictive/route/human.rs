//! A driver of flesh and blood: wanders about the set speed and slows down now and then.

use super::{CONTROL_PERIOD_S, Driver, Seen};
use crate::predictive::limiter;
use rand_core::Rng;
use rand_pcg::Pcg64;
use truck_model::{Demand, Truck};

/// Time between two movements of the foot, s.
const TICK_S: f64 = 2.0;
/// Distance over which the aim wanders, m.
const WANDERING_M: f64 = 1500.0;
/// Mean distance between two slowdowns, m, and how far and by how much each goes.
const BETWEEN_SLOWDOWNS_M: f64 = 8000.0;
const SLOWDOWN_M: f64 = 400.0;
const SLOWDOWN_MPS: f64 = 10.0 / 3.6;
/// Torque per speed error, N m per m/s, of the generic engine.
const GAIN: f64 = 400.0;

/// A driver whose aimed speed is a seeded wandering about the set speed.
#[derive(Clone, Debug)]
pub struct Human {
    truck: Truck,
    set_speed_mps: f64,
    limit_mps: f64,
    sigma_mps: f64,
    rng: Pcg64,
    wandering_mps: f64,
    slow_until_m: f64,
    slow_from_m: f64,
    position_m: f64,
    next_s: f64,
    torque_nm: f64,
}

impl Human {
    /// A driver whose aim has the standard deviation `sigma_mps`.
    #[must_use]
    pub fn new(
        truck: &Truck,
        set_speed_mps: f64,
        limit_mps: f64,
        sigma_mps: f64,
        seed: u64,
    ) -> Self {
        let mut human = Self {
            truck: *truck,
            set_speed_mps,
            limit_mps,
            sigma_mps,
            rng: Pcg64::new(u128::from(seed), 0xa02b_dbf7_bb3c_0a7a_c28f_a16a_64ab_f96d),
            wandering_mps: 0.0,
            slow_until_m: 0.0,
            slow_from_m: 0.0,
            position_m: 0.0,
            next_s: 0.0,
            torque_nm: 0.0,
        };
        human.wandering_mps = sigma_mps * human.normal();
        human.slow_from_m = human.until_slowdown_m();
        human.slow_until_m = human.slow_from_m + SLOWDOWN_M;
        human
    }

    fn uniform(&mut self) -> f64 {
        ((self.rng.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Box and Muller.
    fn normal(&mut self) -> f64 {
        let (u, angle) = (self.uniform(), self.uniform());
        (-2.0 * libm::log(u)).sqrt() * libm::cos(2.0 * core::f64::consts::PI * angle)
    }

    fn until_slowdown_m(&mut self) -> f64 {
        -BETWEEN_SLOWDOWNS_M * libm::log(self.uniform())
    }

    /// The speed that is aimed at, at a position: an Ornstein-Uhlenbeck process over distance.
    fn aim_mps(&mut self, position_m: f64) -> f64 {
        let kept = libm::exp(-(position_m - self.position_m) / WANDERING_M);
        self.position_m = position_m;
        self.wandering_mps = kept * self.wandering_mps
            + self.sigma_mps * (1.0 - kept * kept).max(0.0).sqrt() * self.normal();
        if position_m > self.slow_until_m {
            self.slow_from_m = position_m + self.until_slowdown_m();
            self.slow_until_m = self.slow_from_m + SLOWDOWN_M;
        }
        let slow = position_m > self.slow_from_m;
        let aim = self.set_speed_mps + self.wandering_mps - if slow { SLOWDOWN_MPS } else { 0.0 };
        aim.min(self.limit_mps - 0.3)
    }
}

impl Driver for Human {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let motion = seen.motion;
        if seen.time_s + 0.5 * CONTROL_PERIOD_S >= self.next_s {
            self.next_s = seen.time_s + TICK_S;
            let error_mps = self.aim_mps(motion.position_m) - motion.speed_mps;
            let hold_nm =
                self.truck.engine_torque_nm(0.0, motion.speed_mps, motion.gear, seen.grade);
            let gain = GAIN * self.truck.parameters().engine_scale;
            self.torque_nm = hold_nm + gain * error_mps;
        }
        let rpm = self.truck.engine_rpm(motion.speed_mps, motion.gear);
        let engine = self.truck.engine();
        let torque_nm = self.torque_nm.clamp(engine.drag_torque_nm(rpm), engine.max_torque_nm(rpm));
        let demand = Demand::torque(torque_nm);
        limiter::limited(
            &self.truck,
            demand,
            motion.speed_mps,
            motion.gear,
            seen.grade,
            self.limit_mps,
        )
    }
}
