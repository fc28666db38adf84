//! The actuator gateway: the last word on what reaches the actuators.
//!
//! A command carries a plan: requests for successive control steps. While commands keep coming, the first request of each
//! plan acts. When no command comes, the gateway goes down a ladder. The next valid command brings it back up:
//!
//! ```text
//!  command ──────┬── its step is over ──┬── `follow_plan_s` later ──┐
//!  first request │ later requests;      │ `stop_deceleration_mps2`, │ until it stands,
//!                │ then the last one,   │ or as hard as the plan    │ or a command comes
//!                │ as far as it brakes  │ braked at its worst       │
//!  Source::Command  Source::Plan           Source::StopInLane
//! ```
//!
//! The plan is the gateway's only knowledge of the traffic. A plan that brakes harder than the moderate stop had a
//! reason. The reason did not end with the commands. So the stop is as hard as the hardest braking of the plan.
//!
//! Every request is bounded in range and rate, whatever its source. The emergency brake has a path of its own to the
//! wheels ([`crate::brake`]). The vehicle gets the harder of the two.
//!
//! A command to a truck may carry an engine torque beside its plan. The torque replaces the first request, and is bounded
//! in range and rate itself. It acts in the first step only.
//!
//! ```
//! use plant::gateway::{Gateway, Source};
//! use scenario::plant::Plant;
//!
//! let mut gateway = Gateway::new(&Plant::default());
//! let (period_ns, step_ns) = (10_000_000, 100_000_000);
//! assert!(gateway.accept(0, 0, step_ns, &[0.0, -4.0, -1.0], None), "a valid command");
//! let sources: Vec<Source> = (0..200).map(|k| gateway.actuate(k * period_ns).source).collect();
//! assert_eq!(sources[9], Source::Command);
//! assert_eq!(sources[10], Source::Plan);
//! assert_eq!(sources[199], Source::StopInLane);
//! assert_eq!(gateway.actuate(200 * period_ns).request_mps2, -4.0);
//! ```

#[cfg(test)]
mod tests;

use messages::PLAN_LEN;
use scenario::plant::{Fallback, Gateway as Bounds, Plant};
use serde::{Deserialize, Serialize};
use truck_model::Demand;

/// Source of the request that acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// The start of the run: no command has come yet.
    #[default]
    None,
    /// A command in its own control step.
    Command,
    /// The rest of the last command's plan.
    Plan,
    StopInLane,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuation {
    pub request_mps2: f64,
    pub source: Source,
    /// The bounds of the gateway changed the request or the torque.
    pub limited: bool,
    /// Torque for the engine in place of the request.
    pub engine: Option<Demand>,
}

#[derive(Clone, Debug)]
pub struct Gateway {
    bounds: Bounds,
    fallback: Fallback,
    period_s: f64,
    plan: Option<Plan>,
    engine: Option<Demand>,
    /// Torque request of the previous period, or what the engine gave then.
    last_torque_nm: f64,
    pub(crate) kept: Kept,
}

/// The part of the gateway that outlives its process. The plan comes again with the last command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Kept {
    last_request_mps2: f64,
    /// The launcher asked for a stop: no command counts any more.
    stopping: bool,
}

impl Gateway {
    pub fn new(plant: &Plant) -> Self {
        Self {
            bounds: plant.gateway,
            fallback: plant.fallback,
            period_s: 1e-3 * f64::from(plant.period_ms.value()),
            plan: None,
            engine: None,
            last_torque_nm: 0.0,
            kept: Kept {
                last_request_mps2: plant.initial_acceleration_mps2.value(),
                stopping: false,
            },
        }
    }

    /// Stops in lane and ignores all commands from now on.
    pub fn stop(&mut self) {
        self.kept.stopping = true;
    }

    /// Takes a command: `plan_mps2[k]` is meant for `start_ns + k * step_ns` on. A request to the engine acts in the
    /// plan's first step.
    ///
    /// False if the command cannot be used: it has no request, a step without duration or a number that is not finite,
    /// is not newer than the one that is being followed, or starts more than one step from now. The previous command
    /// stays in force then.
    pub fn accept(
        &mut self,
        now_ns: u64,
        start_ns: u64,
        step_ns: u64,
        plan_mps2: &[f64],
        engine: Option<Demand>,
    ) -> bool {
        let Some(plan) = Plan::new(start_ns, step_ns, plan_mps2) else { return false };
        let is_finite = engine.is_none_or(|engine| {
            engine.engine_torque_nm.is_finite() && engine.service_brake_n.is_finite()
        });
        let is_newer = self.plan.as_ref().is_none_or(|last| start_ns > last.start_ns);
        let is_usable = is_finite && is_newer && start_ns <= now_ns.saturating_add(step_ns);
        if is_usable {
            (self.plan, self.engine) = (Some(plan), engine);
        }
        is_usable
    }

    /// Notes the torque that the engine gives. The first torque request after a time without requests starts from it.
    pub fn engine_gives(&mut self, torque_nm: f64) {
        if self.engine.is_none() {
            self.last_torque_nm = torque_nm;
        }
    }

    /// The request for the plant's period that starts at `now_ns`. Called once in each period.
    pub fn actuate(&mut self, now_ns: u64) -> Actuation {
        let (source, wanted) = self.planned(now_ns);
        let request_mps2 = self.bounded(wanted);
        self.kept.last_request_mps2 = request_mps2;
        let asked = self.engine.filter(|_| source == Source::Command);
        self.engine = asked;
        let engine = asked.map(|asked| self.bounded_engine(asked));
        let limited = request_mps2 != wanted || engine != asked;
        Actuation { request_mps2, source, limited, engine }
    }

    fn bounded_engine(&mut self, asked: Demand) -> Demand {
        let reach_nm = self.bounds.max_torque_rate_nmps.value() * self.period_s;
        let engine_torque_nm = asked
            .engine_torque_nm
            .clamp(self.last_torque_nm - reach_nm, self.last_torque_nm + reach_nm)
            .clamp(self.bounds.min_torque_nm.value(), self.bounds.max_torque_nm.value());
        self.last_torque_nm = engine_torque_nm;
        Demand { engine_torque_nm, service_brake_n: asked.service_brake_n.max(0.0), ..asked }
    }

    /// True until the successor of the newest command is overdue by the margin. A command that comes a moment after the
    /// plant's tick is late, not lost.
    pub fn is_commanded(&self, now_ns: u64) -> bool {
        match &self.plan {
            Some(plan) => {
                now_ns < plan.due_ns().saturating_add(self.fallback.overdue_s.nanoseconds())
            }
            None => now_ns <= self.fallback.follow_plan_s.nanoseconds(),
        }
    }

    /// The source that acts at `now_ns`, and its request, m/s².
    fn planned(&self, now_ns: u64) -> (Source, f64) {
        let worst_mps2 = self.plan.as_ref().map_or(0.0, Plan::worst_mps2);
        let stop_mps2 = worst_mps2.min(-self.fallback.stop_deceleration_mps2.value());
        let follow_ns = self.fallback.follow_plan_s.nanoseconds();
        match &self.plan {
            _ if self.kept.stopping => (Source::StopInLane, stop_mps2),
            None if now_ns <= follow_ns => (Source::None, self.kept.last_request_mps2),
            Some(plan) if now_ns < plan.due_ns() => (Source::Command, plan.requests_mps2[0]),
            Some(plan) if now_ns <= plan.due_ns().saturating_add(follow_ns) => {
                (Source::Plan, plan.at(now_ns))
            }
            _ => (Source::StopInLane, stop_mps2),
        }
    }

    fn bounded(&self, wanted: f64) -> f64 {
        let (last, period_s) = (self.kept.last_request_mps2, self.period_s);
        let highest = last + self.bounds.max_rise_mps3.value() * period_s;
        let lowest = last - self.bounds.max_fall_mps3.value() * period_s;
        let request = wanted.min(highest).max(lowest);
        request.clamp(self.bounds.min_request_mps2.value(), self.bounds.max_request_mps2.value())
    }
}

/// Requests for successive control steps.
#[derive(Clone, Debug)]
struct Plan {
    requests_mps2: [f64; PLAN_LEN],
    len: usize,
    start_ns: u64,
    step_ns: u64,
}

impl Plan {
    /// A plan whose request `k` is meant for `start_ns + k * step_ns` on. A longer one is cut.
    fn new(start_ns: u64, step_ns: u64, plan_mps2: &[f64]) -> Option<Self> {
        let is_finite = plan_mps2.iter().all(|request| request.is_finite());
        if plan_mps2.is_empty() || step_ns == 0 || !is_finite {
            return None;
        }
        let len = plan_mps2.len().min(PLAN_LEN);
        let mut requests_mps2 = [0.0; PLAN_LEN];
        requests_mps2[..len].copy_from_slice(&plan_mps2[..len]);
        Some(Self { requests_mps2, len, start_ns, step_ns })
    }

    /// End of the first step: a new command is due.
    fn due_ns(&self) -> u64 {
        self.start_ns.saturating_add(self.step_ns)
    }

    /// Request at `now_ns`. After the end of the plan its last request is held for one step, then only if it brakes.
    fn at(&self, now_ns: u64) -> f64 {
        let age_ns = now_ns.saturating_sub(self.start_ns);
        let k = usize::try_from(age_ns / self.step_ns).unwrap_or(usize::MAX);
        let requests = &self.requests_mps2[..self.len];
        let last = requests[self.len - 1];
        requests.get(k).copied().unwrap_or(if k == self.len { last } else { last.min(0.0) })
    }

    /// Hardest braking of the plan, 0 if it does not brake.
    fn worst_mps2(&self) -> f64 {
        self.requests_mps2[..self.len].iter().copied().fold(0.0, f64::min)
    }
}
