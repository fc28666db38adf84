//! Human driver model: the speed wanders around the set speed and drops now and then.
//!
//! No published model of a truck driver's speed on hills was at hand: every value here is chosen. An Ornstein-Uhlenbeck
//! process over distance is the usual form of a speed that wanders. Its important figure is the standard deviation,
//! which `timegap papers --driver-spread` sets. On the paper's road 2.5 km/h cost 1.6 to 2.1 % of fuel against a
//! constant speed. 4 km/h cost 2.8 to 3.6 %. Slowdowns stand for traffic: one in 30 km, by 8 km/h.

use super::trip::normal;
use super::{CONTROL_PERIOD_S, Driver, Seen};
use rand_pcg::Pcg64;
use truck_model::{Demand, Truck};

/// Time between two movements of the foot, s.
const TICK_S: f64 = 2.0;
/// Distance over which the aim wanders, and the stride of that, m.
const WANDERING_M: f64 = 500.0;
const STRIDE_M: f64 = 50.0;
/// Mean distance between two slowdowns, m, and how far and by how much each goes.
const BETWEEN_SLOWDOWNS_M: f64 = 30_000.0;
const SLOWDOWN_M: f64 = 300.0;
const SLOWDOWN_MPS: f64 = 8.0 / 3.6;
/// Hardest braking in a slowdown, m/s², and per speed error, 1/s.
const BRAKING_MPS2: f64 = 0.6;
const BRAKING_PER_S: f64 = 0.3;
/// Torque per speed error, N m per m/s, of the generic engine.
const GAIN: f64 = 1000.0;

/// A driver whose aimed speed is a seeded wandering about the set speed.
#[derive(Clone, Debug)]
pub struct Human {
    truck: Truck,
    set_speed_mps: f64,
    limit_mps: f64,
    sigma_mps: f64,
    wandering: Pcg64,
    wandering_mps: f64,
    position_m: f64,
    slowdowns: Pcg64,
    slow_from_m: f64,
    next_s: f64,
    torque_nm: f64,
}

impl Human {
    /// A driver whose aim has the standard deviation `sigma_mps`.
    pub fn new(
        truck: &Truck,
        set_speed_mps: f64,
        limit_mps: f64,
        sigma_mps: f64,
        seed: u64,
    ) -> Self {
        let mut wandering = Pcg64::new(u128::from(seed), 1);
        let mut slowdowns = Pcg64::new(u128::from(seed), 2);
        Self {
            truck: *truck,
            set_speed_mps,
            limit_mps,
            sigma_mps,
            wandering_mps: sigma_mps * normal(&mut wandering),
            wandering,
            position_m: 0.0,
            slow_from_m: between_slowdowns_m(&mut slowdowns),
            slowdowns,
            next_s: 0.0,
            torque_nm: 0.0,
        }
    }

    /// Goes on to a position. All chance is drawn over distance, so that the same happens at the same
    /// places whatever the speed.
    fn advance(&mut self, position_m: f64) {
        let kept = libm::exp(-STRIDE_M / WANDERING_M);
        while self.position_m + STRIDE_M <= position_m {
            self.position_m += STRIDE_M;
            self.wandering_mps = kept * self.wandering_mps
                + self.sigma_mps * (1.0 - kept * kept).sqrt() * normal(&mut self.wandering);
        }
        while position_m > self.slow_from_m + SLOWDOWN_M {
            self.slow_from_m += SLOWDOWN_M + between_slowdowns_m(&mut self.slowdowns);
        }
    }
}

fn between_slowdowns_m(random: &mut Pcg64) -> f64 {
    BETWEEN_SLOWDOWNS_M * -libm::log(random::open_uniform(random))
}

impl Driver for Human {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let motion = seen.motion;
        let (speed_mps, gear) = (motion.speed_mps, motion.gear);
        self.advance(motion.position_m);
        let slow_mps = self.set_speed_mps - SLOWDOWN_MPS;
        let slowing = motion.position_m > self.slow_from_m;
        if seen.time_s + 0.5 * CONTROL_PERIOD_S >= self.next_s {
            self.next_s = seen.time_s + TICK_S;
            let aim_mps = if slowing { slow_mps } else { self.set_speed_mps + self.wandering_mps };
            let error_mps = aim_mps.min(self.limit_mps - 0.3) - speed_mps;
            let hold_nm = self.truck.engine_torque_nm(0.0, speed_mps, gear, seen.grade);
            let gain = GAIN * self.truck.parameters().engine_scale;
            self.torque_nm = hold_nm + gain * error_mps;
        }
        let rpm = self.truck.engine_rpm(speed_mps, gear);
        let engine = self.truck.engine();
        let torque_nm = self.torque_nm.clamp(engine.drag_torque_nm(rpm), engine.max_torque_nm(rpm));
        let mut demand = Demand::torque(torque_nm);
        if slowing && speed_mps > slow_mps {
            let acceleration_mps2 = (BRAKING_PER_S * (slow_mps - speed_mps)).max(-BRAKING_MPS2);
            let braking = Demand::for_acceleration(
                &self.truck,
                acceleration_mps2,
                speed_mps,
                gear,
                seen.grade,
            );
            if braking.engine_torque_nm < torque_nm {
                demand = braking;
            }
        }
        seen.moment(&self.truck).limited(demand, self.limit_mps)
    }
}
