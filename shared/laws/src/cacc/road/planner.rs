//! The two candidates of a cycle: references, programs and the plans that come out.

use mpc_solver::{ProblemError, Solver, Start};

use super::decision::Choice;
use super::filter::{Filter, Gate as Held, Pass, safe_gap};
use super::lead::Prediction;
use super::program::{Deadline, Programs};
use super::reference::{Gate, Reference, Scene};
use super::signals::SignalMemory;
use crate::cacc::config::Config;
use crate::cacc::paper::usable;
use law::following::driver::Driver;
use law::following::kinematics::{Lag, LagStep, Motion};
use law::following::safe_gap::{LeadNow, SafeGap};
use law::{Input, MAX_PLAN, SpeedProfile};

/// Least time constant with which a lead's gain of speed before a line decays, s. Chosen: a start takes longer than the
/// braking for which `lead_decay_s` was chosen.
const GAINING_DECAY_S: f64 = 2.0;

/// The measured scene of one cycle.
pub(super) struct Seen {
    pub(super) ego: Motion,
    /// Start of a plan: the ego, without the braking of another system.
    pub(super) begin: Motion,
    pub(super) lead: Option<LeadNow>,
    pub(super) signals: SignalMemory,
    pub(super) desired_mps: f64,
    /// The same along the road.
    pub(super) profile: Option<SpeedProfile>,
}

/// Makes candidates.
pub(super) struct Planner {
    config: Config,
    solver: Box<dyn Solver + Send>,
    programs: Programs,
    driver: Driver,
    pub(super) lag: LagStep,
    lead_decay: f64,
    gaining_decay: f64,
    safe: SafeGap,
    work: Box<Work>,
}

/// Buffers of one cycle.
struct Work {
    lead: Prediction,
    pass: Candidate,
    stop: Candidate,
}

/// A reference and the plan made from it.
pub(super) struct Candidate {
    pub(super) reference: Reference,
    pub(super) requests: [f64; MAX_PLAN],
    /// The ego that the requests move; position 0 is its front bumper now.
    motion: [Motion; MAX_PLAN + 1],
    pub(super) solved: bool,
    pub(super) iterations: u32,
    pub(super) residual: f64,
}

impl Candidate {
    const EMPTY: Self = Self {
        reference: Reference::EMPTY,
        requests: [0.0; MAX_PLAN],
        motion: Reference::EMPTY.motion,
        solved: false,
        iterations: 0,
        residual: 0.0,
    };
}

impl Planner {
    pub(super) fn new(
        config: &Config,
        solver: Box<dyn Solver + Send>,
    ) -> Result<Self, ProblemError> {
        let lag = Lag { tau_s: config.model_time_constant_s }.discretise(config.step_s);
        let road = &config.road;
        Ok(Self {
            config: *config,
            solver,
            programs: Programs::new(config, &lag)?,
            driver: config.driver(),
            lag,
            safe: safe_gap(config, config.step_s),
            lead_decay: libm::exp(-config.step_s / road.lead_decay_s),
            gaining_decay: libm::exp(-config.step_s / road.lead_decay_s.max(GAINING_DECAY_S)),
            work: Box::new(Work {
                lead: Prediction::ABSENT,
                pass: Candidate::EMPTY,
                stop: Candidate::EMPTY,
            }),
        })
    }

    /// Predicts the lead for the candidates of this cycle.
    pub(super) fn predict(&mut self, seen: &Seen) {
        let gains =
            |lead: &LeadNow| !seen.signals.lines().is_empty() && lead.acceleration_mps2 > 0.0;
        let decay = match &seen.lead {
            Some(lead) if gains(lead) => self.gaining_decay,
            _ => self.lead_decay,
        };
        self.work.lead.update(seen.lead.as_ref(), self.lag.step_s, decay);
    }

    /// Makes one candidate: rolls out its driver and solves its program.
    pub(super) fn candidate(
        &mut self,
        choice: Choice,
        input: &Input,
        seen: &Seen,
        gate: Gate,
        deadline: Option<Deadline>,
    ) {
        let Work { lead, pass, stop } = &mut *self.work;
        let scene = Scene {
            config: &self.config,
            driver: self.driver,
            lag: self.lag,
            now_s: input.time_s,
            desired_mps: seen.desired_mps,
            profile: seen.profile.as_ref(),
            origin_m: input.ego.position_m,
            safe: &self.safe,
            lead,
            lines: seen.signals.lines(),
        };
        let candidate = if choice == Choice::Pass { pass } else { stop };
        candidate.reference.roll_out(&scene, seen.begin, gate);
        let emergency =
            candidate.reference.hardest_mps2 > self.config.road.comfort_deceleration_mps2;
        let problem = if choice == Choice::Pass && !emergency {
            self.programs.fill_go(&candidate.reference, lead, deadline);
            &self.programs.go
        } else {
            self.programs.fill_hold(&candidate.reference, lead);
            &self.programs.hold
        };
        let report = self.solver.solve(problem, Start::Cold);
        candidate.solved = usable(&report);
        candidate.iterations = report.iterations;
        candidate.residual = report.residuals.max();
        let n = self.config.horizon;
        let source =
            if candidate.solved { self.solver.inputs() } else { &candidate.reference.request_mps2 };
        candidate.requests[..n].copy_from_slice(&source[..n]);
        candidate.motion[0] = seen.begin;
        for (k, &request) in candidate.requests[..n].iter().enumerate() {
            candidate.motion[k + 1] = self.lag.advance(candidate.motion[k], request);
        }
    }

    /// The candidate made last for a choice.
    pub(super) fn candidate_of(&self, choice: Choice) -> &Candidate {
        match choice {
            Choice::Pass => &self.work.pass,
            Choice::Stop => &self.work.stop,
        }
    }

    /// First stage at which a candidate's plan is beyond the line.
    pub(super) fn arrival(&self, choice: Choice, line_m: f64) -> Option<usize> {
        let motion = &self.candidate_of(choice).motion[..=self.config.horizon];
        motion.iter().position(|motion| motion.position_m >= line_m)
    }

    /// True if the safety filter lets the pass's plan cross a line before red. From the first place where a stop is no
    /// longer possible, the speed and request that the plan has there must be enough.
    pub(super) fn is_let_through(&self, pass: Pass, line_m: f64, filter: &Filter) -> bool {
        let Candidate { requests, motion, .. } = &self.work.pass;
        let to_line_m = |at: &Motion| line_m - at.position_m;
        let mut stages = motion[..=self.config.horizon].iter();
        let Some(stage) = stages.position(|at| !filter.can_stop(*at, to_line_m(at))) else {
            return true;
        };
        let at = &motion[stage];
        let lead = self.work.lead.at(stage, at.position_m);
        let request = requests[stage.min(self.config.horizon - 1)];
        let red_in_s = pass.red_in_s - stage as f64 * self.lag.step_s;
        let gate = Held { distance_m: to_line_m(at), pass: Some(Pass { red_in_s, ..pass }) };
        filter.can_cross(request, *at, lead.as_ref(), gate)
    }

    /// Distance by which the pass falls short of the line at its latest stage, m; otherwise zero.
    pub(super) fn shortfall(&self, line_m: f64, deadline: Option<usize>) -> f64 {
        let stage = deadline.filter(|&stage| stage <= self.config.horizon);
        stage.map_or(0.0, |stage| (line_m - self.work.pass.motion[stage].position_m).max(0.0))
    }

    /// Cost of a plan: time lost against the driver who passes, acceleration and jerk.
    pub(super) fn cost(&self, choice: Choice) -> f64 {
        let road = &self.config.road;
        let n = self.config.horizon;
        let passing = &self.work.pass.reference.motion;
        let Candidate { requests, motion, .. } = self.candidate_of(choice);
        let mut sum = 0.0;
        for (k, &request) in requests[..n].iter().enumerate() {
            let jerk = (request - motion[k].acceleration_mps2) / self.config.model_time_constant_s;
            let next = &motion[k + 1];
            let (a, slower) = (next.acceleration_mps2, next.speed_mps - passing[k + 1].speed_mps);
            sum += road.speed_weight_s2_per_m2 * slower * slower
                + road.acceleration_weight_s4_per_m2 * a * a
                + road.jerk_weight_s6_per_m2 * jerk * jerk;
        }
        0.5 * sum
    }
}
