//! The computation of an exported unit: a law, or a law in the loop of a deployment.
//!
//! ```text
//! lead ─► measured each control period ─► law ─► delay, jitter, loss ─► actuator gateway ─► vehicle ─► position, speed
//!                                          ▲ restarted with an empty memory
//! ```

use crate::ports::{self, Port};
use law::{Ego, Input, Law, Output, Target};
use plant::gateway::Gateway;
use plant::longitudinal::Vehicle;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::quantity::Speed;
use scenario::{Problem, Scenario};
use std::collections::VecDeque;

/// Shortest time between two releases of the law that are one, s.
const SLACK_S: f64 = 1e-9;

/// A model with the values of its variables.
pub struct Model {
    scenario: Scenario,
    law: Box<dyn Law>,
    output: Output,
    time_s: f64,
    released: u64,
    /// Way of the vehicle, m.
    position_m: f64,
    deployment: Option<Deployment>,
}

/// The way from the law to the wheels.
struct Deployment {
    vehicle: Vehicle,
    gateway: Gateway,
    random: Pcg64,
    /// Commands on their way: the instant of arrival, ns, and the plan.
    on_the_way: VecDeque<(u64, Vec<f64>)>,
    periods: u64,
    was_down: bool,
}

impl Model {
    /// The law of a scenario, alone or in the loop.
    ///
    /// # Errors
    /// Names the key that the law refuses.
    pub fn new(scenario: Scenario, is_loop: bool) -> Result<Self, Problem> {
        let descriptor = laws::ALL.iter().find(|law| law.name == scenario.controller.name.as_str());
        let descriptor = descriptor.ok_or_else(|| {
            Problem::new("controller.name", "not a law of timegap's own", "one of `timegap list`")
        })?;
        let law = (descriptor.build)(&law::Reader::new(&scenario))?;
        let deployment = is_loop.then(|| Deployment::new(&scenario, 1));
        Ok(Self {
            scenario,
            law,
            output: Output::default(),
            time_s: 0.0,
            released: 0,
            position_m: 0.0,
            deployment,
        })
    }

    /// Begins anew. Values that are not numbers get their start.
    pub fn begin(&mut self, values: &mut [f64]) {
        let ports = if self.deployment.is_some() { ports::LOOP } else { ports::LAW };
        for (value, port) in values.iter_mut().zip(ports) {
            if !value.is_finite() {
                *value = port.start;
            }
        }
        self.law.reset();
        (self.time_s, self.released, self.position_m) = (0.0, 0, 0.0);
        self.output = Output::default();
        if self.deployment.is_some() {
            self.scenario.plant.initial_speed_mps = Speed::of(values[5].clamp(0.0, 100.0));
            self.deployment = Some(Deployment::new(&self.scenario, values[11] as u64));
            self.show(values);
        }
    }

    /// Moves on by `step_s` with these values as inputs.
    pub fn step(&mut self, values: &mut [f64], step_s: f64) {
        match self.deployment.take() {
            None => {
                let until_s = self.time_s + step_s;
                while self.next_release_s() < until_s - SLACK_S {
                    let of = |name| values[place(ports::LAW, name)];
                    let target = ["gap_m", "relative_speed_mps", "target_acceleration_mps2"];
                    let ahead = (of("has_target") != 0.0).then(|| target.map(of));
                    let ego = Ego {
                        position_m: self.position_m,
                        speed_mps: of("speed_mps"),
                        acceleration_mps2: of("acceleration_mps2"),
                    };
                    self.release(ego, ahead, of("set_speed_mps"), of("speed_limit_mps"));
                }
                self.position_m += values[0].max(0.0) * step_s;
                self.time_s = until_s;
                values[8] = self.output.request_mps2();
            }
            Some(mut deployment) => {
                let begun_s = self.time_s;
                let period_s = 1e-3 * f64::from(self.scenario.plant.period_ms.value());
                while self.time_s + 0.5 * period_s < begun_s + step_s {
                    self.period(&mut deployment, values, self.time_s - begun_s);
                    self.time_s = deployment.periods as f64 * period_s;
                }
                self.deployment = Some(deployment);
                self.show(values);
            }
        }
    }

    fn next_release_s(&self) -> f64 {
        self.released as f64 * 1e-3 * f64::from(self.scenario.controller.period_ms.value())
    }

    /// A release of the law; `ahead` has gap, relative speed and acceleration of the target.
    fn release(&mut self, ego: Ego, ahead: Option<[f64; 3]>, set_mps: f64, limit_mps: f64) {
        let input = Input {
            time_s: self.next_release_s(),
            period_s: 1e-3 * f64::from(self.scenario.controller.period_ms.value()),
            ego,
            target: ahead.map(|[gap_m, relative_speed_mps, acceleration_mps2]| Target {
                track_id: 1,
                gap_m,
                relative_speed_mps,
                acceleration_mps2,
                age_s: 0.0,
            }),
            set_speed_mps: set_mps,
            speed_limit_mps: limit_mps,
            ..Input::default()
        };
        self.law.step(&input, &mut self.output);
        self.released += 1;
    }

    /// One period of the plant, `into_s` behind the instant of the inputs.
    fn period(&mut self, deployment: &mut Deployment, values: &[f64], into_s: f64) {
        let of = |name| values[place(ports::LOOP, name)];
        let every_s = of("restart_every_s");
        let is_down = every_s > 0.0
            && self.time_s >= every_s
            && self.time_s % every_s < 1e-3 * of("restart_ms").max(0.0);
        if deployment.was_down && !is_down {
            self.law.reset();
        }
        deployment.was_down = is_down;
        let now_ns = (self.time_s * 1e9).round() as u64;
        if self.next_release_s() <= self.time_s + SLACK_S {
            let state = deployment.vehicle.state();
            let (position_m, speed_mps) = (state.position_m, state.speed_mps);
            let lead_mps = of("lead_speed_mps");
            let gap_m = of("lead_position_m") + lead_mps * into_s - position_m;
            let lead = [gap_m, lead_mps - speed_mps, of("lead_acceleration_mps2")];
            let ahead = (of("has_lead") != 0.0).then_some(lead);
            let ego = Ego { position_m, speed_mps, acceleration_mps2: state.acceleration_mps2 };
            match is_down {
                true => self.released += 1,
                false => self.release(ego, ahead, of("set_speed_mps"), f64::INFINITY),
            }
            // Both are drawn for each release, so that one parameter does not shift the other's sequence.
            let (later, lost) =
                (random::uniform(&mut deployment.random), random::uniform(&mut deployment.random));
            if !is_down && lost >= of("drop_share") {
                let delay_ns = 1e6 * (of("delay_ms").max(0.0) + later * of("jitter_ms").max(0.0));
                let plan = self.output.plan_mps2[..self.output.plan_len].to_vec();
                deployment.on_the_way.push_back((now_ns + delay_ns as u64, plan));
            }
        }
        let step_ns = u64::from(self.scenario.controller.period_ms.value()) * 1_000_000;
        deployment.move_on(now_ns, step_ns);
    }

    fn show(&self, values: &mut [f64]) {
        let Some(deployment) = &self.deployment else { return };
        let state = deployment.vehicle.state();
        let request_mps2 = self.output.request_mps2();
        let outputs = [state.position_m, state.speed_mps, state.acceleration_mps2, request_mps2];
        values[12..16].copy_from_slice(&outputs);
    }
}

fn place(ports: &[Port], name: &str) -> usize {
    ports.iter().position(|port| port.name == name).expect("a port of the list")
}

impl Deployment {
    fn new(scenario: &Scenario, seed: u64) -> Self {
        Self {
            vehicle: Vehicle::new(&scenario.plant),
            gateway: Gateway::new(&scenario.plant),
            random: Pcg64::seed_from_u64(seed),
            on_the_way: VecDeque::new(),
            periods: 0,
            was_down: false,
        }
    }

    /// Hands what has arrived to the gateway, the newest last, and moves the vehicle.
    fn move_on(&mut self, now_ns: u64, step_ns: u64) {
        self.on_the_way.retain(|(at_ns, plan)| {
            let arrives = *at_ns <= now_ns;
            if arrives {
                // An older one that was overtaken is refused by the gateway.
                let _ = self.gateway.accept(now_ns, *at_ns, step_ns, plan, None);
            }
            !arrives
        });
        let request_mps2 = self.gateway.actuate(now_ns).request_mps2;
        self.vehicle.step(request_mps2);
        self.periods += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(pairs: &[(&str, f64)]) -> Vec<f64> {
        let find = |name: &str| pairs.iter().find(|(given, _)| *given == name);
        ports::LOOP
            .iter()
            .map(|port| find(port.name).map_or(f64::NAN, |(_, value)| *value))
            .collect()
    }

    /// Smallest gap of 60 s behind a lead that brakes from 25 to 15 m/s.
    fn least_gap_m(pairs: &[(&str, f64)]) -> f64 {
        let text = "schema_version = 1\nname = \"unit\"\n[controller]\nname = \"acc-mpc\"\n";
        let scenario = Scenario::parse("unit", text).expect("a scenario");
        let mut model = Model::new(scenario, true).expect("a law");
        let mut values = values(pairs);
        model.begin(&mut values);
        let (mut lead_m, mut least_m) = (50.0, f64::INFINITY);
        for step in 0..600 {
            let time_s = 0.1 * f64::from(step);
            let speed_mps: f64 = (25.0 - 3.0 * (time_s - 10.0).max(0.0)).max(15.0);
            (values[0], values[1]) = (lead_m, speed_mps);
            model.step(&mut values, 0.1);
            lead_m += 0.1 * speed_mps;
            least_m = least_m.min(lead_m - values[12]);
        }
        assert!((values[13] - 15.0).abs() < 1.0, "it follows: {values:?}");
        least_m
    }

    #[test]
    fn delays_and_restarts_cost_distance_and_repeat_by_seed() {
        let start = ("initial_speed_mps", 25.0);
        let ideal = least_gap_m(&[start]);
        let late = least_gap_m(&[start, ("delay_ms", 400.0)]);
        let restarted = [start, ("restart_every_s", 10.5), ("restart_ms", 900.0)];
        assert!(late < ideal - 0.1, "{late} {ideal}");
        assert!(least_gap_m(&restarted) != ideal);
        let noisy = [start, ("jitter_ms", 200.0), ("drop_share", 0.3)];
        let noisy_again = least_gap_m(&noisy);
        assert_eq!(least_gap_m(&noisy), noisy_again);
        assert_ne!(least_gap_m(&[&noisy[..], &[("seed", 2.0)]].concat()), noisy_again);
    }
}
