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
//! `fine` solves this exactly over steps h of constant request. `paper-euler` takes the Euler step of
//! the predictive laws' own model, x += T v, v += T a, a += T/tau (u - a), with all three right-hand
//! sides from the start of the step (He et al. 2024); a step that is longer than the plant's period
//! is sampled along its straight lines, so that its ends are the paper's values whatever the period.
//!
//! While the emergency brake holds the vehicle's acceleration below a, the lag goes on by itself, without drive:
//! when the brake lets go, what the controller commands acts again, and nothing of the brake is left. `paper-euler`,
//! which has no emergency brake in its paper, puts the ceiling on the request.
//!
//! The vehicle never moves backwards: at standstill speed and (negative) acceleration are zero.

use scenario::plant::{Integrator, Plant};
use serde::{Deserialize, Serialize};

/// State of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Position of the front bumper along the road, m from the start.
    pub position_m: f64,
    /// Speed, m/s, never negative.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
}

/// The ego vehicle.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Vehicle {
    tau_s: f64,
    min_mps2: f64,
    max_mps2: f64,
    /// Largest power by mass, W/kg; infinite when there is no powertrain to limit it.
    specific_power: f64,
    motion: Motion,
    state: State,
}

/// The integrator and what it keeps between samples.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Motion {
    /// `substeps` steps of `step_s` in a period; `decay` is e^(-h/tau). `lag_mps2` is the acceleration of
    /// the lag, which is the vehicle's unless the emergency brake holds that below it.
    Fine { substeps: u32, step_s: f64, decay: f64, lag_mps2: f64 },
    /// A step of `samples` periods, begun at `base`; `taken` of them are done, in which the request
    /// has the integral `request_integral` (m/s).
    PaperEuler { samples: u32, taken: u32, period_s: f64, base: State, request_integral: f64 },
}

impl Vehicle {
    /// The vehicle at its start.
    #[must_use]
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
            motion,
            state,
        }
    }

    /// Moves on by one period of the plant under a constant request, m/s². The gateway has seen to
    /// it that the request is finite.
    pub fn step(&mut self, request_mps2: f64) {
        self.step_below(request_mps2, None);
    }

    /// The same with the emergency brake's ceiling on the acceleration, m/s².
    pub fn step_below(&mut self, request_mps2: f64, ceiling_mps2: Option<f64>) {
        let ceiling = ceiling_mps2.map(|ceiling| ceiling.max(self.min_mps2));
        match &mut self.motion {
            Motion::Fine { substeps, step_s, decay, lag_mps2 } => {
                let (substeps, step_s, decay, mut lag_mps2) =
                    (*substeps, *step_s, *decay, *lag_mps2);
                for _ in 0..substeps {
                    let request = self.attainable(request_mps2, self.state.speed_mps);
                    let unbraked = State { acceleration_mps2: lag_mps2, ..self.state };
                    let free = exact_step(unbraked, request, self.tau_s, step_s, decay);
                    lag_mps2 = free.acceleration_mps2;
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

    /// Present state.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    fn keep_lag(&mut self, mps2: f64) {
        if let Motion::Fine { lag_mps2, .. } = &mut self.motion {
            *lag_mps2 = mps2;
        }
    }

    fn attainable(&self, request_mps2: f64, speed_mps: f64) -> f64 {
        let traction = self.specific_power / speed_mps.max(1.0);
        request_mps2.clamp(self.min_mps2, self.max_mps2).min(traction)
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
mod tests {
    use proptest::prelude::*;
    use scenario::plant::Powertrain;
    use scenario::quantity::{Acceleration, Mass, PeriodMs, Power, Speed, TimeConstant};

    use super::*;

    macro_rules! reference {
        ($name:literal) => {
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/", $name, ".csv"))
        };
    }

    fn paper(period_ms: u32, initial_speed_mps: f64) -> Plant {
        Plant {
            period_ms: PeriodMs::of(period_ms),
            integrator: Integrator::PaperEuler,
            integration_step_ms: PeriodMs::of(100),
            initial_speed_mps: Speed::of(initial_speed_mps),
            ..Plant::default()
        }
    }

    /// Follows the requests of a reference run and returns the largest deviations of x, v and a.
    fn deviations(csv: &str, period_ms: u32) -> [f64; 3] {
        let rows: Vec<Vec<f64>> = csv
            .lines()
            .skip(1)
            .map(|line| line.split(',').take(5).map(|f| f.parse().expect("a number")).collect())
            .collect();
        let mut vehicle = Vehicle::new(&paper(period_ms, rows[0][2]));
        let mut worst = [0.0f64; 3];
        for row in &rows {
            let State { position_m, speed_mps, acceleration_mps2 } = vehicle.state();
            for (i, ours) in [position_m, speed_mps, acceleration_mps2].into_iter().enumerate() {
                worst[i] = worst[i].max((ours - row[1 + i]).abs());
            }
            for _ in 0..100 / period_ms {
                vehicle.step(row[4]);
            }
        }
        worst
    }

    #[test]
    fn the_papers_plant_is_reproduced_at_any_period() {
        let references = [
            reference!("cacc-a-acc"),
            reference!("cacc-a-cacc"),
            reference!("cacc-b-acc"),
            reference!("cacc-b-cacc"),
            reference!("cacc-c-acc"),
            reference!("cacc-c-cacc"),
            reference!("cacc-table3-acc"),
            reference!("cacc-table3-cacc"),
        ];
        for csv in references {
            for period_ms in [10, 20, 50, 100] {
                // The reference prints five decimals, its requests six.
                for deviation in deviations(csv, period_ms) {
                    assert!(deviation < 2e-5, "off by {deviation} at {period_ms} ms");
                }
            }
        }
    }

    #[test]
    fn the_fine_integrator_is_exact_for_a_step_of_the_request() {
        let plant = Plant { initial_speed_mps: Speed::of(20.0), ..Plant::default() };
        let mut vehicle = Vehicle::new(&plant);
        for _ in 0..200 {
            vehicle.step(-3.0);
        }
        // The closed form for t = 2 s: a = u (1 - e^(-t/tau)) and its integrals.
        let (t, tau, u) = (2.0, 0.5, -3.0);
        let gained = tau * (1.0 - libm::exp(-t / tau));
        let state = vehicle.state();
        assert!((state.acceleration_mps2 - u * (1.0 - libm::exp(-t / tau))).abs() < 1e-12);
        assert!((state.speed_mps - (20.0 + u * (t - gained))).abs() < 1e-11);
        let x = 20.0 * t + u * (0.5 * t * t - tau * (t - gained));
        assert!((state.position_m - x).abs() < 1e-10);
    }

    #[test]
    fn the_result_does_not_depend_on_the_fine_step_while_moving() {
        let run = |step_ms| {
            let plant = Plant {
                initial_speed_mps: Speed::of(20.0),
                integration_step_ms: PeriodMs::of(step_ms),
                ..Plant::default()
            };
            let mut vehicle = Vehicle::new(&plant);
            for k in 0..500 {
                vehicle.step(if k % 7 < 3 { 2.0 } else { -1.5 });
            }
            vehicle.state()
        };
        let (fine, coarse) = (run(1), run(10));
        assert!((fine.position_m - coarse.position_m).abs() < 1e-9);
        assert!((fine.speed_mps - coarse.speed_mps).abs() < 1e-10);
    }

    #[test]
    fn a_stop_ends_at_standstill_and_a_start_leaves_it() {
        let plant = Plant { initial_speed_mps: Speed::of(10.0), ..Plant::default() };
        let mut vehicle = Vehicle::new(&plant);
        for _ in 0..1000 {
            vehicle.step(-4.0);
        }
        let stopped = vehicle.state();
        assert_eq!((stopped.speed_mps, stopped.acceleration_mps2), (0.0, 0.0));
        // v0²/(2 b) + v0 tau, less the little that the lag's tail gives back.
        assert!((stopped.position_m - (12.5 + 5.0)).abs() < 0.6, "{stopped:?}");
        vehicle.step(-4.0);
        assert_eq!(vehicle.state(), stopped);
        vehicle.step(1.0);
        assert!(vehicle.state().speed_mps > 0.0);
    }

    #[test]
    fn a_request_that_changes_inside_an_euler_step_counts_with_its_mean() {
        let (mut split, mut mean) =
            (Vehicle::new(&paper(10, 15.0)), Vehicle::new(&paper(10, 15.0)));
        for k in 0..10 {
            split.step(if k < 5 { 4.0 } else { -2.0 });
            mean.step(1.0);
        }
        let difference = split.state().acceleration_mps2 - mean.state().acceleration_mps2;
        assert!(difference.abs() < 1e-12);
    }

    #[test]
    fn power_limits_the_acceleration_at_speed() {
        let plant = Plant {
            initial_speed_mps: Speed::of(25.0),
            powertrain: Some(Powertrain {
                mass_kg: Mass::of(2000.0),
                max_power_kw: Power::of(100.0),
            }),
            ..Plant::default()
        };
        let mut vehicle = Vehicle::new(&plant);
        for _ in 0..300 {
            vehicle.step(5.0);
        }
        let state = vehicle.state();
        assert!(state.acceleration_mps2 > 1.5 && state.acceleration_mps2 < 2.0);
        let mut free = Vehicle::new(&Plant { powertrain: None, ..plant });
        for _ in 0..300 {
            free.step(5.0);
        }
        assert!(free.state().acceleration_mps2 > 4.9);
    }

    fn plants() -> impl Strategy<Value = Plant> {
        let integrators =
            prop_oneof![Just((Integrator::Fine, 1)), Just((Integrator::PaperEuler, 100))];
        (0.0..40.0f64, -5.0..4.0f64, 0.1..2.0f64, integrators).prop_map(
            |(v, a, tau, (how, step))| Plant {
                integrator: how,
                integration_step_ms: PeriodMs::of(step),
                initial_speed_mps: Speed::of(v),
                initial_acceleration_mps2: Acceleration::of(a),
                actuator_time_constant_s: TimeConstant::of(tau),
                ..Plant::default()
            },
        )
    }

    proptest! {
        #[test]
        fn it_never_reverses_and_stays_within_its_bounds(
            plant in plants(), requests in prop::collection::vec(-20.0..20.0f64, 1..400),
        ) {
            let mut vehicle = Vehicle::new(&plant);
            for request in requests {
                let before = vehicle.state();
                vehicle.step(request);
                let after = vehicle.state();
                prop_assert!(after.speed_mps >= 0.0);
                prop_assert!(after.position_m >= before.position_m);
                prop_assert!((-9.0 - 1e-9..=5.0 + 1e-9).contains(&after.acceleration_mps2));
            }
        }
    }

    #[test]
    fn what_the_emergency_brake_does_is_over_when_it_lets_go() {
        let initial_speed_mps = Speed::of(30.0);
        let mut vehicle = Vehicle::new(&Plant { initial_speed_mps, ..Plant::default() });
        for _ in 0..50 {
            vehicle.step_below(1.0, Some(-8.0));
        }
        assert_eq!(vehicle.state().acceleration_mps2, -8.0);
        vehicle.step(0.0);
        assert_eq!(vehicle.state().acceleration_mps2, 0.0, "there was no drive under the brake");
        // What the controller brakes with itself is still there.
        for _ in 0..100 {
            vehicle.step_below(-2.0, Some(-8.0));
        }
        vehicle.step(-2.0);
        let State { speed_mps, acceleration_mps2, .. } = vehicle.state();
        assert!(speed_mps > 10.0 && (-2.0..-1.0).contains(&acceleration_mps2));
    }

    #[test]
    fn the_emergency_brake_stops_the_vehicle_where_the_formula_says() {
        let plant = Plant { initial_speed_mps: Speed::of(4.1), ..Plant::default() };
        let mut vehicle = Vehicle::new(&plant);
        for _ in 0..25 {
            vehicle.step_below(0.0, Some(-8.0));
        }
        let State { position_m, speed_mps, .. } = vehicle.state();
        assert!((speed_mps - 2.1).abs() < 1e-12 && (position_m - 0.775).abs() < 1e-12);
        for _ in 0..50 {
            vehicle.step_below(0.0, Some(-8.0));
        }
        let stopped = vehicle.state();
        assert!((stopped.position_m - 4.1 * 4.1 / 16.0).abs() < 1e-9, "{stopped:?}");
        assert_eq!((stopped.speed_mps, stopped.acceleration_mps2), (0.0, 0.0));
    }

    #[test]
    fn a_vehicle_that_brakes_harder_than_the_ceiling_keeps_to_its_own_braking() {
        let plant = Plant {
            initial_speed_mps: Speed::of(20.0),
            initial_acceleration_mps2: Acceleration::of(-4.0),
            ..Plant::default()
        };
        let mut vehicle = Vehicle::new(&plant);
        vehicle.step_below(-4.0, Some(-1.0));
        assert!((vehicle.state().acceleration_mps2 + 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_stop_inside_of_a_step_is_placed_by_the_share_of_the_step() {
        let plant = Plant {
            integration_step_ms: PeriodMs::of(10),
            initial_speed_mps: Speed::of(0.02),
            initial_acceleration_mps2: Acceleration::of(-4.0),
            ..Plant::default()
        };
        let mut vehicle = Vehicle::new(&plant);
        vehicle.step(-4.0);
        // 0.02 m/s less 0.04 m/s in 10 ms: it stands after 5 ms.
        assert!((vehicle.state().position_m - 5e-5).abs() < 1e-12);
    }
}
