//! Longitudinal motion of the ego vehicle.
//!
//! The acceleration a follows the request u with a first-order lag, position x and speed v follow a:
//!
//! ```text
//! x' = v        v' = a        a' = (u - a) / tau
//! ```
//!
//! | symbol | key of `[plant]` | unit |
//! |---|---|---|
//! | x, v, a | [`State`], `initial_speed_mps`, `initial_acceleration_mps2` | m, m/s, m/s² |
//! | tau | `actuator_time_constant_s` | s |
//! | bounds of u | `min_acceleration_mps2`, `max_acceleration_mps2`, `powertrain` | m/s² |
//! | T, h | `integration_step_ms` | ms |
//!
//! `fine` solves this exactly over steps h of constant request. `paper-euler` takes the Euler step of the predictive
//! laws' own model: x += T v, v += T a, a += T/tau (u - a). All three right-hand sides are from the start of the step
//! (He et al. 2024). A step longer than the plant's period is sampled along its straight lines. So its ends are the
//! paper's values at any period.
//!
//! The lag goes on by itself, without drive, while the emergency brake holds the vehicle's acceleration below a. When
//! the brake lets go, the controller's commands act again, and no effect of the brake is left. `paper-euler`, which has
//! no emergency brake in its paper, puts the ceiling on the request.
//!
//! On a grade gravity takes g sin θ from the acceleration of driveline and brakes. θ is the mean grade under the car.
//! The lag is theirs: they contain the grade, and a change of it acts at once and fades with tau. The bounds of u and
//! the power are theirs too. So a car on a level road is the same to the last bit.
//!
//! The vehicle never moves backwards: at standstill speed and (negative) acceleration are zero.

use scenario::grade::GradeProfile;
use scenario::plant::{Integrator, Plant};
use serde::{Deserialize, Serialize};

/// Speed below which the engine's power limits no further, m/s: keeps the limit finite at a stand. Chosen.
const TRACTION_FROM_MPS: f64 = 1.0;
const GRAVITY_MPS2: f64 = 9.81;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Position of the front bumper along the road, m from the start.
    pub position_m: f64,
    /// Speed, m/s, never negative.
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Vehicle {
    tau_s: f64,
    min_mps2: f64,
    max_mps2: f64,
    /// Largest power by mass, W/kg; infinite without a powertrain.
    specific_power: f64,
    length_m: f64,
    motion: Motion,
    state: State,
    /// Share of gravity along the road at the last step, m/s².
    slope_mps2: f64,
}

/// The integrator and what it keeps between samples.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Motion {
    /// `substeps` steps of `step_s` in a period; `decay` is e^(-h/tau). `lag_mps2` is the acceleration of
    /// the lag, which is the vehicle's unless the emergency brake holds that below it.
    Fine { substeps: u32, step_s: f64, decay: f64, lag_mps2: f64 },
    /// A step of `samples` periods from `base`. In the first `taken` periods the request has the integral
    /// `request_integral`, m/s.
    PaperEuler { samples: u32, taken: u32, period_s: f64, base: State, request_integral: f64 },
}

impl Vehicle {
    pub fn new(plant: &Plant) -> Self {
        let tau_s = plant.actuator_time_constant_s.value();
        let (period_ms, step_ms) = (plant.period_ms.value(), plant.integration_step_ms.value());
        let state = State {
            position_m: 0.0,
            speed_mps: plant.initial_speed_mps.value(),
            acceleration_mps2: plant.initial_acceleration_mps2.value(),
        };
        let motion = match plant.integrator {
            Integrator::Fine => {
                let step_s = 1e-3 * f64::from(step_ms);
                let decay = libm::exp(-step_s / tau_s);
                let lag_mps2 = state.acceleration_mps2;
                Motion::Fine { substeps: period_ms / step_ms, step_s, decay, lag_mps2 }
            }
            Integrator::PaperEuler => Motion::PaperEuler {
                samples: step_ms / period_ms,
                taken: 0,
                period_s: 1e-3 * f64::from(period_ms),
                base: state,
                request_integral: 0.0,
            },
        };
        Self {
            tau_s,
            min_mps2: plant.min_acceleration_mps2.value(),
            max_mps2: plant.max_acceleration_mps2.value(),
            specific_power: plant.powertrain.map_or(f64::INFINITY, |powertrain| {
                1e3 * powertrain.max_power_kw.value() / powertrain.mass_kg.value()
            }),
            length_m: plant.length_m.value(),
            motion,
            state,
            slope_mps2: 0.0,
        }
    }

    /// Moves on by one period of the plant under a constant request, m/s². The gateway has seen to
    /// it that the request is finite.
    pub fn step(&mut self, request_mps2: f64) {
        self.step_on(request_mps2, None, None);
    }

    /// The same with the emergency brake's ceiling on the acceleration, m/s², and on a road with heights.
    pub fn step_on(
        &mut self,
        request_mps2: f64,
        ceiling_mps2: Option<f64>,
        road: Option<&GradeProfile>,
    ) {
        let ceiling = ceiling_mps2.map(|ceiling| ceiling.max(self.min_mps2));
        match &mut self.motion {
            Motion::Fine { substeps, step_s, decay, lag_mps2 } => {
                let (substeps, step_s, decay, mut lag_mps2) =
                    (*substeps, *step_s, *decay, *lag_mps2);
                for _ in 0..substeps {
                    if let Some(road) = road {
                        lag_mps2 -= self.take_slope(road);
                    }
                    let request = self.attainable(request_mps2, self.state.speed_mps);
                    let unbraked = State { acceleration_mps2: lag_mps2, ..self.state };
                    let free = exact_step(unbraked, request, self.tau_s, step_s, decay);
                    lag_mps2 = free.acceleration_mps2;
                    let least = self.min_mps2 - self.slope_mps2;
                    let ceiling = ceiling.map(|ceiling| ceiling.max(least));
                    self.state = match ceiling {
                        Some(ceiling) if ceiling < lag_mps2 => {
                            // Traction goes back with the ceiling, not at once.
                            lag_mps2 = lag_mps2.min(ceiling.max(0.0));
                            braked_step(self.state, ceiling, step_s)
                        }
                        _ => free,
                    };
                }
                self.keep_lag(lag_mps2);
            }
            Motion::PaperEuler { base, .. } => {
                let speed_mps = base.speed_mps;
                let request = self.attainable(request_mps2, speed_mps);
                self.euler_sample(ceiling.map_or(request, |ceiling| request.min(ceiling)));
            }
        }
    }

    /// Takes the slope under the car; returns by how much it has grown, m/s². A standing car is held. At the start of a
    /// drive, brakes and driveline are then in balance with the grade.
    pub fn take_slope(&mut self, road: &GradeProfile) -> f64 {
        let front_m = self.state.position_m;
        let grade = road.mean_grade(front_m - self.length_m, front_m);
        let slope_mps2 = GRAVITY_MPS2 * grade / libm::sqrt(1.0 + grade * grade);
        let grown = slope_mps2 - self.slope_mps2;
        self.slope_mps2 = slope_mps2;
        if self.state.speed_mps > 0.0 { grown } else { 0.0 }
    }

    pub fn place(&mut self, position_m: f64) {
        if let Motion::PaperEuler { base, .. } = &mut self.motion {
            base.position_m += position_m - self.state.position_m;
        }
        self.state.position_m = position_m;
    }

    pub fn state(&self) -> State {
        self.state
    }

    /// Takes on a motion that another model has reached.
    pub(crate) fn go_on_from(&mut self, reached: State) {
        self.state = reached;
        self.keep_lag(reached.acceleration_mps2);
        if let Motion::PaperEuler { base, taken, request_integral, .. } = &mut self.motion {
            (*base, *taken, *request_integral) = (reached, 0, 0.0);
        }
    }

    fn keep_lag(&mut self, mps2: f64) {
        if let Motion::Fine { lag_mps2, .. } = &mut self.motion {
            *lag_mps2 = mps2;
        }
    }

    fn attainable(&self, request_mps2: f64, speed_mps: f64) -> f64 {
        let traction = self.specific_power / speed_mps.max(TRACTION_FROM_MPS);
        let slope = self.slope_mps2;
        request_mps2.clamp(self.min_mps2 - slope, self.max_mps2 - slope).min(traction - slope)
    }

    fn euler_sample(&mut self, request_mps2: f64) {
        let Motion::PaperEuler { samples, taken, period_s, base, request_integral } =
            &mut self.motion
        else {
            return;
        };
        *taken += 1;
        *request_integral += *period_s * request_mps2;
        let elapsed_s = f64::from(*taken) * *period_s;
        let a = base.acceleration_mps2;
        let sample = State {
            position_m: base.position_m + elapsed_s * base.speed_mps,
            speed_mps: base.speed_mps + elapsed_s * a,
            acceleration_mps2: a + (*request_integral - elapsed_s * a) / self.tau_s,
        };
        self.state = without_reverse(sample);
        if taken == samples {
            *taken = 0;
            *request_integral = 0.0;
            *base = self.state;
        }
    }
}

/// The lag's exact solution over `h` seconds of constant request.
fn exact_step(state: State, request: f64, tau_s: f64, h: f64, decay: f64) -> State {
    let State { position_m: x, speed_mps: v, acceleration_mps2: a } = state;
    let excess = a - request;
    let gained_s = tau_s * (1.0 - decay);
    let next = State {
        position_m: x + v * h + 0.5 * request * h * h + excess * tau_s * (h - gained_s),
        speed_mps: v + request * h + excess * gained_s,
        acceleration_mps2: request + excess * decay,
    };
    if next.speed_mps >= 0.0 {
        return State { position_m: next.position_m.max(x), ..next };
    }
    // It stops inside this step: the speed falls to zero in about the share v / (v - v') of it.
    let moving_s = h * v / (v - next.speed_mps);
    without_reverse(State { position_m: x + 0.5 * v * moving_s, ..next })
}

/// `h` seconds in which the emergency brake sets the acceleration.
fn braked_step(state: State, acceleration_mps2: f64, h: f64) -> State {
    let State { position_m: x, speed_mps: v, .. } = state;
    let speed_mps = v + acceleration_mps2 * h;
    if speed_mps <= 0.0 {
        // It stops inside this step.
        let stopping_m =
            if acceleration_mps2 < 0.0 { -0.5 * v * v / acceleration_mps2 } else { 0.0 };
        return State { position_m: x + stopping_m, speed_mps: 0.0, acceleration_mps2: 0.0 };
    }
    State { position_m: x + 0.5 * (v + speed_mps) * h, speed_mps, acceleration_mps2 }
}

fn without_reverse(state: State) -> State {
    if state.speed_mps >= 0.0 {
        return state;
    }
    State {
        speed_mps: 0.0,
        acceleration_mps2: state.acceleration_mps2.max(0.0),
        position_m: state.position_m,
    }
}

#[cfg(test)]
mod grade_tests;
#[cfg(test)]
mod tests;
