//! Motion across the road: a single track that a driver steers, or the axis exactly.
//!
//! ```text
//!            axis                       p, l   place of the front bumper's middle along and across the axis
//!             │  l   ╱ body             ψ      heading of the body against the axis
//!             ├─────╳                   v_y    lateral speed of the centre of gravity
//!             │    ╱ ψ                  r      yaw rate
//!             p   ╱                     δ      angle of the front wheels
//!
//! p' = (v cos ψ − (v_y + d r) sin ψ) / (1 − κ l)      l' = v sin ψ + (v_y + d r) cos ψ      ψ' = r − κ p'
//! ```
//!
//! v is the speed of the longitudinal model. d is the distance from the centre of gravity to the front bumper, and κ
//! the curvature of the axis. The longitudinal model is not changed: its way is projected on the axis.
//!
//! | part | file |
//! | --- | --- |
//! | v_y and r: the linear single track (Riekert and Schunck 1940) | `single_track.rs` |
//! | δ: a driver who corrects offset and direction, and wanders | `driver.rs` |
//!
//! A truck is rigid: trailers do not cut the corner.

mod driver;
mod single_track;

pub use driver::Driver;
pub use single_track::{SingleTrack, Slip};

use messages::{EgoPose, LateralMotion};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::Scenario;
use scenario::lateral::{LateralModel, YawRateSensor as YawRateKeys};
use scenario::plan::Plan;
use serde::{Deserialize, Serialize};

use crate::longitudinal;
use crate::numbers::Numbers;

/// Streams of random numbers: one a step for driver and sensor, one a run for the sensor's offset.
const OF_STEPS: u64 = 0x6c61_7465_7261_6c00;
const OF_RUN: u64 = 0x6c61_7465_7261_6c01;

/// The ego's motion across a road with a plan.
#[derive(Clone, Debug)]
pub struct Lateral {
    axis: road::Axis,
    start: road::Pose,
    model: LateralModel,
    track: SingleTrack,
    driver: Driver,
    sensor: YawRateSensor,
    seed: u64,
    period_s: f64,
    /// Distance from the centre of gravity to the front bumper, m.
    to_bumper_m: f64,
    /// Factor on all random deviates: -1 in a mirrored world.
    noise: f64,
    pub state: State,
}

/// State of the motion across the road; it outlives the plant's process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Steps done: each has its own random numbers.
    pub steps: u64,
    /// Place of the front bumper across the axis, m, left positive.
    pub lateral_m: f64,
    /// Heading of the body against the axis, rad.
    pub heading_rad: f64,
    /// Lateral speed of the centre of gravity and yaw rate.
    pub slip: Slip,
    /// Angle of the front wheels, rad.
    pub steering_rad: f64,
    /// Lateral acceleration of the centre of gravity, m/s².
    pub lateral_acceleration_mps2: f64,
    /// Place in the lane at which the driver aims, m.
    pub aim_m: f64,
    /// The yaw rate behind the sensor's lag, rad/s.
    pub sensed_radps: f64,
}

impl Lateral {
    /// The motion of a scenario's ego at its start; `None` without a plan of the road.
    pub fn of(scenario: &Scenario, numbers: &Numbers) -> Option<Self> {
        let plan = scenario.road.plan()?;
        Some(Self::on(plan, scenario, numbers, 1.0))
    }

    /// The same with another factor on all random deviates.
    pub fn on(plan: &Plan, scenario: &Scenario, numbers: &Numbers, noise: f64) -> Self {
        let (plant, keys) = (&scenario.plant, &scenario.plant.lateral);
        let car_kg = || plant.powertrain.map_or(numbers.car_mass_kg, |own| own.mass_kg.value());
        let mass_kg =
            plant.vehicle.truck_kg().map_or_else(car_kg, |kg| kg * plant.mass_factor.value());
        let track = SingleTrack::new(keys, mass_kg);
        let wheelbase_m = keys.wheelbase_m.value();
        let overhang_m = 0.5 * (plant.length_m.value() - wheelbase_m).max(0.0);
        let seed = scenario.seed.value();
        let period_s = 1e-3 * f64::from(plant.period_ms.value());
        let offset = noise * random::normal(&mut generator(seed, OF_RUN));
        let mut lateral = Self {
            axis: plan.axis().clone(),
            start: plan.start.pose(),
            model: keys.model,
            track,
            driver: Driver::new(&keys.driver, period_s, numbers),
            sensor: YawRateSensor::new(&keys.yaw_rate, period_s, offset),
            seed,
            period_s,
            to_bumper_m: track.front_m + overhang_m,
            noise,
            state: State::default(),
        };
        lateral.settle(plant.initial_speed_mps.value());
        lateral
    }

    /// The state of steady driving on the axis at its beginning.
    fn settle(&mut self, speed_mps: f64) {
        // Just behind the beginning: before it the axis is straight.
        let curvature_perm = self.axis.curvature_perm(1e-6);
        self.follow_axis(curvature_perm, speed_mps);
        if self.model == LateralModel::SingleTrack {
            let state = &mut self.state;
            state.slip = self.track.steady(state.steering_rad, speed_mps);
            let sideways_mps = state.slip.lateral_mps + self.to_bumper_m * state.slip.yaw_radps;
            // The front bumper moves along the axis.
            state.heading_rad = match speed_mps > 0.0 {
                true => -libm::atan2(sideways_mps, speed_mps),
                false => 0.0,
            };
        }
        self.state.sensed_radps = self.state.slip.yaw_radps;
    }

    /// The state of a body that follows the axis exactly.
    fn follow_axis(&mut self, curvature_perm: f64, speed_mps: f64) {
        let yaw_radps = curvature_perm * speed_mps;
        self.state = State {
            slip: Slip { lateral_mps: -self.to_bumper_m * yaw_radps, yaw_radps },
            steering_rad: self.track.steering_rad(curvature_perm, speed_mps),
            lateral_acceleration_mps2: yaw_radps * speed_mps,
            lateral_m: 0.0,
            heading_rad: 0.0,
            ..self.state
        };
    }

    /// Moves on by one period of the plant, in which the longitudinal model moved from `from` to `to`. Returns the
    /// place of the front bumper on the axis, m, where it is another one than the longitudinal model's.
    pub fn step(&mut self, from: &longitudinal::State, to: &longitudinal::State) -> Option<f64> {
        self.state.steps += 1;
        let (aims, senses) = self.draws();
        let moved_m = match self.model {
            LateralModel::OnAxis => {
                let curvature_perm = self.axis.curvature_perm(to.position_m);
                self.follow_axis(curvature_perm, to.speed_mps);
                None
            }
            LateralModel::SingleTrack => Some(self.steered(from, to, aims)),
        };
        let yaw_radps = self.state.slip.yaw_radps;
        self.sensor.follow(&mut self.state.sensed_radps, yaw_radps, senses);
        moved_m
    }

    /// A step of the single track; returns the new place on the axis, m.
    fn steered(&mut self, from: &longitudinal::State, to: &longitudinal::State, aims: f64) -> f64 {
        let Self { axis, track, driver, state, .. } = self;
        let (h, speed_mps) = (self.period_s, to.speed_mps);
        let way_m = to.position_m - from.position_m;
        driver.wander(&mut state.aim_m, aims);
        let sideways_mps = state.slip.lateral_mps + self.to_bumper_m * state.slip.yaw_radps;
        let (sine, cosine) = libm::sincos(state.heading_rad);
        let across_mps = from.speed_mps * sine + sideways_mps * cosine;
        let ahead_perm = axis.curvature_perm(from.position_m + driver.lead_m(speed_mps));
        let wanted_perm =
            driver.curvature(ahead_perm, speed_mps, state.lateral_m - state.aim_m, across_mps);
        let before_rad = state.steering_rad;
        driver.steer(&mut state.steering_rad, track.steering_rad(wanted_perm, speed_mps));
        let steering_rad = 0.5 * (before_rad + state.steering_rad);
        let before = state.slip;
        state.slip = track.step(before, steering_rad, state.steering_rad, speed_mps, h);
        let mean = Slip {
            lateral_mps: 0.5 * (before.lateral_mps + state.slip.lateral_mps),
            yaw_radps: 0.5 * (before.yaw_radps + state.slip.yaw_radps),
        };
        // The slip jumps at the change of model, and no force stands behind that.
        let slides_mps2 = match track.is_dynamic(speed_mps) && track.is_dynamic(from.speed_mps) {
            true => (state.slip.lateral_mps - before.lateral_mps) / h,
            false => 0.0,
        };
        state.lateral_acceleration_mps2 = slides_mps2 + speed_mps * mean.yaw_radps;
        // The way of one period, with the heading of its middle.
        let curvature_perm = axis.curvature_perm(from.position_m + 0.5 * way_m);
        let turned_rad = mean.yaw_radps * h;
        let middle_rad = state.heading_rad + 0.5 * (turned_rad - curvature_perm * way_m);
        let (sine, cosine) = libm::sincos(middle_rad);
        let aside_m = (mean.lateral_mps + self.to_bumper_m * mean.yaw_radps) * h;
        let along_m = (way_m * cosine - aside_m * sine) / (1.0 - curvature_perm * state.lateral_m);
        state.lateral_m += way_m * sine + aside_m * cosine;
        state.heading_rad += turned_rad - curvature_perm * along_m;
        from.position_m + along_m
    }

    /// Normal deviates of this step: for the driver's aim and for the sensor.
    fn draws(&self) -> (f64, f64) {
        let mut generator = generator(self.seed ^ OF_STEPS, self.state.steps);
        let (first, second) = random::normal_pair(&mut generator);
        (self.noise * first, self.noise * second)
    }

    pub fn measure(&self, message: &mut LateralMotion) {
        let State { lateral_acceleration_mps2, steering_rad, sensed_radps, .. } = self.state;
        message.yaw_rate_radps = self.sensor.measured(sensed_radps);
        message.lateral_acceleration_mps2 = lateral_acceleration_mps2;
        message.steering_rad = steering_rad;
    }

    /// Pose of the front bumper's middle with the body's heading, in the frame that begins with the road.
    pub fn pose(&self, position_m: f64) -> road::Pose {
        let tangent = self.axis.point(position_m, self.state.lateral_m);
        road::Pose { heading_rad: tangent.heading_rad + self.state.heading_rad, ..tangent }
    }

    /// The same in the plane.
    pub fn placed(&self, position_m: f64) -> road::Pose {
        self.pose(position_m).placed(&self.start)
    }

    pub fn write(&self, ego: &longitudinal::State, message: &mut EgoPose) {
        let placed = self.placed(ego.position_m);
        let State { slip, lateral_m, lateral_acceleration_mps2, .. } = self.state;
        (message.x_m, message.y_m, message.heading_rad) =
            (placed.x_m, placed.y_m, placed.heading_rad);
        message.lateral_m = lateral_m;
        message.yaw_rate_radps = slip.yaw_radps;
        message.side_slip_rad = match ego.speed_mps > 0.0 {
            true => libm::atan2(slip.lateral_mps, ego.speed_mps),
            false => 0.0,
        };
        message.curvature_perm = self.axis.curvature_perm(ego.position_m);
        message.lateral_acceleration_mps2 = lateral_acceleration_mps2;
    }
}

/// The yaw-rate sensor: a lag, an offset for the whole run, noise of each sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YawRateSensor {
    /// Share of the way to the true rate in one period.
    share: f64,
    offset_radps: f64,
    sigma_radps: f64,
    /// Noise of the present sample, rad/s.
    noise_radps: f64,
}

impl YawRateSensor {
    /// The sensor of a run, sampled once in each period; `offset` is a normal deviate.
    pub fn new(keys: &YawRateKeys, period_s: f64, offset: f64) -> Self {
        let lag_s = 1e-3 * f64::from(keys.lag_ms.value());
        Self {
            share: if lag_s > 0.0 { 1.0 - libm::exp(-period_s / lag_s) } else { 1.0 },
            offset_radps: offset * keys.offset_sigma_dps.value().to_radians(),
            sigma_radps: keys.noise_dps.value().to_radians(),
            noise_radps: 0.0,
        }
    }

    /// Moves the lagged rate on by one period, and takes the noise of the next sample from a normal deviate.
    pub fn follow(&mut self, sensed_radps: &mut f64, yaw_radps: f64, deviate: f64) {
        *sensed_radps += self.share * (yaw_radps - *sensed_radps);
        self.noise_radps = self.sigma_radps * deviate;
    }

    /// The rate as the sensor gives it, rad/s.
    pub fn measured(&self, sensed_radps: f64) -> f64 {
        sensed_radps + self.offset_radps + self.noise_radps
    }
}

/// A generator of its own for each pair of numbers (the finaliser of SplitMix64, Steele, Lea and Flood 2014).
fn generator(seed: u64, index: u64) -> Pcg64 {
    let mut z = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    Pcg64::seed_from_u64(z ^ (z >> 31))
}

#[cfg(test)]
mod tests;
