//! The actuator gateway: the last word on what reaches the actuators.
//!
//! A command carries a plan: requests for successive control steps from its start time on. While
//! commands keep coming, each plan's first request acts. When none comes, the gateway goes down a
//! short ladder, and back up with the next valid command:
//!
//! | level | entered | request |
//! |---|---|---|
//! | [`Source::Command`] | a valid command | the plan's first request |
//! | [`Source::Plan`] | its control step is over | the plan's later requests; past its end, the last one for one step, then that one as far as it brakes |
//! | [`Source::StopInLane`] | `follow_plan_s` later | `-stop_deceleration_mps2`, or what the plan ended with where that brakes harder |
//!
//! Every request, whatever its source, is bounded in range and rate. The gateway knows nothing of what is
//! ahead: braking for it is the controller's work, and beside it that of the emergency brake, which has a
//! path of its own to the wheels ([`crate::brake`]); the vehicle gets the harder of the two.
//!
//! A command to a truck may carry an engine torque beside its plan. It acts in place of the plan's
//! first request, bounded in range and rate itself; the levels below know the plan alone.

use scenario::plant::{Fallback, Gateway as Bounds, Plant};
use serde::{Deserialize, Serialize};

/// Longest plan that is kept, in control steps: as long as a command carries.
const MAX_PLAN: usize = messages::PLAN_LEN;

/// Why a command was not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It has no request, or its control step has no duration.
    Empty,
    /// One of its requests, or its torque, is not a finite number.
    NotFinite,
    /// It is not newer than the one that is being followed.
    NotNewer,
    /// It starts more than one control step from now.
    FromTheFuture,
}

/// Where the request that acts comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// Nothing yet: the run has only begun.
    #[default]
    None,
    /// A command in its own control step.
    Command,
    /// The rest of the last command's plan.
    Plan,
    /// A stop in lane at moderate deceleration.
    StopInLane,
}

/// What the actuators get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuation {
    /// The request, m/s².
    pub request_mps2: f64,
    /// Where it comes from.
    pub source: Source,
    /// The bounds of the gateway changed it, or the torque.
    pub limited: bool,
    /// What the engine gets in place of the request.
    pub engine: Option<EngineRequest>,
}

/// A request to the engine of a truck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineRequest {
    /// Torque at the crankshaft, N m.
    pub torque_nm: f64,
    /// Force of the service brakes at the wheels, N.
    pub service_brake_n: f64,
    /// Gear, counted from 0; `None` leaves it to the gearbox.
    pub gear: Option<usize>,
}

/// The gateway.
#[derive(Clone, Debug)]
pub struct Gateway {
    bounds: Bounds,
    fallback: Fallback,
    period_s: f64,
    follow_plan_ns: u64,
    /// A command is lost when its successor is overdue by this time.
    overdue_ns: u64,
    plan: [f64; MAX_PLAN],
    plan_len: usize,
    start_ns: u64,
    step_ns: u64,
    last_request_mps2: f64,
    engine: Option<EngineRequest>,
    /// Torque request of the period before, or what the engine gave then.
    last_torque_nm: f64,
    /// The launcher asked for a stop: no command counts any more.
    stopping: bool,
}

/// What of the gateway outlives its process; the plan comes again with the last command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    last_request_mps2: f64,
    stopping: bool,
}

impl Gateway {
    /// A gateway that has heard nothing yet.
    #[must_use]
    pub fn new(plant: &Plant) -> Self {
        Self {
            bounds: plant.gateway,
            fallback: plant.fallback,
            period_s: 1e-3 * f64::from(plant.period_ms.value()),
            follow_plan_ns: plant.fallback.follow_plan_s.nanoseconds(),
            overdue_ns: plant.fallback.overdue_s.nanoseconds(),
            plan: [0.0; MAX_PLAN],
            plan_len: 0,
            start_ns: 0,
            step_ns: 0,
            last_request_mps2: plant.initial_acceleration_mps2.value(),
            engine: None,
            last_torque_nm: 0.0,
            stopping: false,
        }
    }

    /// What is to outlive this process.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let Self { last_request_mps2, stopping, .. } = *self;
        Snapshot { last_request_mps2, stopping }
    }

    /// Goes on from what another process kept.
    pub fn restore(&mut self, kept: &Snapshot) {
        (self.last_request_mps2, self.stopping) = (kept.last_request_mps2, kept.stopping);
    }

    /// Stops in lane, whatever commands come.
    pub fn stop(&mut self) {
        self.stopping = true;
    }

    /// Takes a command: `plan_mps2[k]` is meant for `start_ns + k * step_ns` on.
    ///
    /// # Errors
    /// When the command cannot be used; the one before stays in force.
    pub fn accept(
        &mut self,
        now_ns: u64,
        start_ns: u64,
        step_ns: u64,
        plan_mps2: &[f64],
    ) -> Result<(), Rejection> {
        self.accept_with_engine(now_ns, start_ns, step_ns, plan_mps2, None)
    }

    /// Takes a command with a request to the engine, which acts in the plan's first step.
    ///
    /// # Errors
    /// When the command cannot be used; the one before stays in force.
    pub fn accept_with_engine(
        &mut self,
        now_ns: u64,
        start_ns: u64,
        step_ns: u64,
        plan_mps2: &[f64],
        engine: Option<EngineRequest>,
    ) -> Result<(), Rejection> {
        if plan_mps2.is_empty() || step_ns == 0 {
            return Err(Rejection::Empty);
        }
        let engine_numbers = engine.map_or([0.0; 2], |e| [e.torque_nm, e.service_brake_n]);
        if plan_mps2.iter().chain(&engine_numbers).any(|request| !request.is_finite()) {
            return Err(Rejection::NotFinite);
        }
        if start_ns > now_ns.saturating_add(step_ns) {
            return Err(Rejection::FromTheFuture);
        }
        if self.plan_len > 0 && start_ns <= self.start_ns {
            return Err(Rejection::NotNewer);
        }
        let len = plan_mps2.len().min(MAX_PLAN);
        self.plan[..len].copy_from_slice(&plan_mps2[..len]);
        self.plan_len = len;
        self.start_ns = start_ns;
        self.step_ns = step_ns;
        self.engine = engine;
        Ok(())
    }

    /// Tells what torque the engine gives, from which the first request after a time without
    /// torque requests rises or falls.
    pub fn engine_gives(&mut self, torque_nm: f64) {
        if self.engine.is_none() {
            self.last_torque_nm = torque_nm;
        }
    }

    /// The request for the plant's period that starts at `now_ns`. Called once in each period.
    pub fn actuate(&mut self, now_ns: u64) -> Actuation {
        let (source, wanted) = self.planned(now_ns);
        let request_mps2 = self.bounded(wanted);
        self.last_request_mps2 = request_mps2;
        let asked = self.engine.filter(|_| source == Source::Command);
        self.engine = asked;
        let engine = asked.map(|asked| self.bounded_engine(asked));
        let limited = request_mps2 != wanted || engine != asked;
        Actuation { request_mps2, source, limited, engine }
    }

    fn bounded_engine(&mut self, asked: EngineRequest) -> EngineRequest {
        let reach_nm = self.bounds.max_torque_rate_nmps.value() * self.period_s;
        let torque_nm = asked
            .torque_nm
            .clamp(self.last_torque_nm - reach_nm, self.last_torque_nm + reach_nm)
            .clamp(self.bounds.min_torque_nm.value(), self.bounds.max_torque_nm.value());
        self.last_torque_nm = torque_nm;
        EngineRequest { torque_nm, service_brake_n: asked.service_brake_n.max(0.0), ..asked }
    }

    /// True until the newest command's successor is overdue by the margin: a command that comes a
    /// moment after the plant's tick is late, not lost.
    #[must_use]
    pub fn is_commanded(&self, now_ns: u64) -> bool {
        let waiting = self.plan_len == 0 && now_ns <= self.follow_plan_ns;
        let due_ns = self.start_ns.saturating_add(self.step_ns);
        waiting || (self.plan_len > 0 && now_ns < due_ns.saturating_add(self.overdue_ns))
    }

    fn planned(&self, now_ns: u64) -> (Source, f64) {
        let moderate_mps2 = -self.fallback.stop_deceleration_mps2.value();
        if self.stopping {
            return (Source::StopInLane, moderate_mps2);
        }
        let planned_mps2 = self.plan[self.plan_len.saturating_sub(1)];
        let stop = (Source::StopInLane, moderate_mps2.min(planned_mps2));
        let age_ns = now_ns.saturating_sub(self.start_ns);
        if self.plan_len == 0 {
            let waiting = now_ns <= self.follow_plan_ns;
            return if waiting { (Source::None, self.last_request_mps2) } else { stop };
        }
        if age_ns < self.step_ns {
            return (Source::Command, self.plan[0]);
        }
        if age_ns > self.step_ns.saturating_add(self.follow_plan_ns) {
            return stop;
        }
        let k = usize::try_from(age_ns / self.step_ns).unwrap_or(usize::MAX);
        let last = self.plan[self.plan_len - 1];
        let request = match k {
            _ if k < self.plan_len => self.plan[k],
            _ if k == self.plan_len => last,
            _ => last.min(0.0),
        };
        (Source::Plan, request)
    }

    fn bounded(&self, wanted: f64) -> f64 {
        let (last, period_s) = (self.last_request_mps2, self.period_s);
        let highest = last + self.bounds.max_rise_mps3.value() * period_s;
        let lowest = last - self.bounds.max_fall_mps3.value() * period_s;
        let request = wanted.min(highest).max(lowest);
        request.clamp(self.bounds.min_request_mps2.value(), self.bounds.max_request_mps2.value())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use scenario::quantity::{JerkMagnitude, PeriodMs};

    use super::*;

    const STEP_NS: u64 = 100_000_000;
    const PERIOD_NS: u64 = 10_000_000;

    /// A gateway whose rates do not bind.
    fn gateway() -> Gateway {
        let mut plant = Plant::default();
        plant.gateway.max_rise_mps3 = JerkMagnitude::of(1000.0);
        plant.gateway.max_fall_mps3 = JerkMagnitude::of(1000.0);
        plant.period_ms = PeriodMs::of(100);
        Gateway::new(&plant)
    }

    fn at(gateway: &mut Gateway, now_ns: u64) -> (f64, Source) {
        let actuation = gateway.actuate(now_ns);
        (actuation.request_mps2, actuation.source)
    }

    #[test]
    fn the_ladder_is_gone_down_by_time_and_up_by_a_command() {
        let mut gateway = gateway();
        assert_eq!(at(&mut gateway, 0), (0.0, Source::None));
        let plan = [1.0, 0.5, -0.5, -1.0];
        assert_eq!(gateway.accept(0, 0, STEP_NS, &plan), Ok(()));
        assert_eq!(at(&mut gateway, 0), (1.0, Source::Command));
        assert_eq!(at(&mut gateway, STEP_NS - 1), (1.0, Source::Command));
        assert_eq!(at(&mut gateway, STEP_NS), (0.5, Source::Plan));
        assert_eq!(at(&mut gateway, 3 * STEP_NS), (-1.0, Source::Plan));
        assert_eq!(at(&mut gateway, 9 * STEP_NS), (-1.0, Source::Plan));
        assert_eq!(at(&mut gateway, 11 * STEP_NS), (-1.0, Source::Plan));
        assert_eq!(at(&mut gateway, 11 * STEP_NS + 1), (-2.5, Source::StopInLane));
        let now = 12 * STEP_NS;
        assert_eq!(gateway.accept(now, now, STEP_NS, &[0.7]), Ok(()));
        assert_eq!(at(&mut gateway, now), (0.7, Source::Command));
    }

    #[test]
    fn a_torque_is_bounded_in_range_and_rate_and_acts_only_while_its_command_is_fresh() {
        let mut gateway = gateway();
        gateway.engine_gives(500.0);
        let asked = EngineRequest { torque_nm: 9e3, service_brake_n: 0.0, gear: Some(5) };
        gateway.accept_with_engine(0, 0, STEP_NS, &[0.1], Some(asked)).expect("a right command");
        let torque = |gateway: &mut Gateway, now_ns| {
            gateway.actuate(now_ns).engine.map(|engine| engine.torque_nm)
        };
        // 5000 N m/s over periods of 100 ms, from what the engine gave.
        assert_eq!(torque(&mut gateway, 0), Some(1000.0));
        assert_eq!(torque(&mut gateway, 1), Some(1500.0));
        let all = [2, 3, 4].map(|now_ns| torque(&mut gateway, now_ns));
        assert_eq!(all, [Some(2000.0), Some(2200.0), Some(2200.0)]);
        assert_eq!(torque(&mut gateway, STEP_NS), None, "the rest of the plan is acceleration");
        let bad = EngineRequest { torque_nm: f64::NAN, ..asked };
        let refused = gateway.accept_with_engine(STEP_NS, STEP_NS, STEP_NS, &[0.1], Some(bad));
        assert_eq!(refused, Err(Rejection::NotFinite));
    }

    #[test]
    fn a_single_request_is_held_for_one_step_and_then_only_if_it_brakes() {
        for (request, later) in [(1.5, 0.0), (-1.5, -1.5)] {
            let mut gateway = gateway();
            gateway.accept(0, 0, STEP_NS, &[request]).expect("it is valid");
            assert_eq!(at(&mut gateway, STEP_NS), (request, Source::Plan));
            assert_eq!(at(&mut gateway, 2 * STEP_NS), (later, Source::Plan));
        }
    }

    #[test]
    fn a_plant_that_never_hears_a_command_stops() {
        let mut gateway = gateway();
        assert_eq!(at(&mut gateway, 1_000_000_000).1, Source::None);
        assert_eq!(at(&mut gateway, 1_010_000_000), (-2.5, Source::StopInLane));
    }

    #[test]
    fn unusable_commands_are_refused_and_change_nothing() {
        let mut gateway = gateway();
        gateway.accept(0, STEP_NS / 2, STEP_NS, &[1.0]).expect("it is valid");
        for (start, step, plan, why) in [
            (STEP_NS, STEP_NS, &[][..], Rejection::Empty),
            (STEP_NS, 0, &[0.0], Rejection::Empty),
            (STEP_NS, STEP_NS, &[0.0, f64::NAN], Rejection::NotFinite),
            (STEP_NS, STEP_NS, &[f64::NEG_INFINITY], Rejection::NotFinite),
            (STEP_NS / 2, STEP_NS, &[0.0], Rejection::NotNewer),
            (0, STEP_NS, &[0.0], Rejection::NotNewer),
            (STEP_NS + 1, STEP_NS, &[0.0], Rejection::FromTheFuture),
            (u64::MAX, u64::MAX - 1, &[0.0], Rejection::FromTheFuture),
        ] {
            assert_eq!(gateway.accept(0, start, step, plan), Err(why));
        }
        assert_eq!(at(&mut gateway, STEP_NS), (1.0, Source::Command));
    }

    #[test]
    fn a_plan_longer_than_the_store_is_cut() {
        let mut gateway = gateway();
        gateway.accept(0, 0, PERIOD_NS / 10, &[-0.5; 1000]).expect("it is valid");
        assert_eq!(at(&mut gateway, 2 * STEP_NS), (-0.5, Source::Plan));
    }

    #[test]
    fn range_and_rate_are_bounded_and_said_so() {
        let mut plant = Plant::default();
        plant.gateway.max_rise_mps3 = JerkMagnitude::of(10.0);
        plant.gateway.max_fall_mps3 = JerkMagnitude::of(50.0);
        let mut gateway = Gateway::new(&plant);
        gateway.accept(0, 0, STEP_NS, &[100.0, -100.0]).expect("it is valid");
        let first = gateway.actuate(0);
        assert!(first.limited && (first.request_mps2 - 0.1).abs() < 1e-12);
        let second = gateway.actuate(STEP_NS);
        assert!(second.limited && (second.request_mps2 + 0.4).abs() < 1e-12);
        let mut free = self::gateway();
        free.accept(0, 0, STEP_NS, &[100.0, -100.0]).expect("it is valid");
        assert_eq!(free.actuate(0).request_mps2, 5.0);
        assert_eq!(free.actuate(STEP_NS).request_mps2, -8.0);
    }

    proptest! {
        #[test]
        fn whatever_comes_the_request_is_finite_and_in_range(
            commands in prop::collection::vec(
                (0u64..40, prop::collection::vec(prop::num::f64::ANY, 0..4)), 0..60),
        ) {
            let mut plant = Plant::default();
            plant.gateway.max_rise_mps3 = JerkMagnitude::of(20.0);
            let mut gateway = Gateway::new(&plant);
            let (mut now, mut last) = (0, 0.0);
            for (wait, plan) in commands {
                let _ = gateway.accept(now, now, STEP_NS, &plan);
                for _ in 0..wait {
                    let request = gateway.actuate(now).request_mps2;
                    prop_assert!((-8.0..=5.0).contains(&request));
                    prop_assert!(request <= last + 0.2 + 1e-12);
                    last = request;
                    now += PERIOD_NS;
                }
            }
        }
    }
}
