//! The paper's formulation.
//!
//! ```text
//! E = (e, ed, a),  e = d_s - R,  ed = v_ego - v_lead,  d_s = t_h v_ego + d_b
//! E+ = A E + B u,  A = [[1,T,0],[0,1,T],[0,0,1-T/tau]],  B = [0,0,T/tau]'
//!
//! minimise  1/2 sum(E_k' Q E_k + R u_k²) + w sum(1/min(D_k, d_th) - 1/d_th)
//! subject to  u_min <= u_k <= u_max,  e_k <= d_b,  E_N = 0,  D_k > 0
//!
//! D_k = C_s (e_k + t_k ed_k + t_k² a_k / 2 + H)          t_k = t_l - k T > 0
//! H   = v_lead t_l - d_l - e_0                           C_s = +1 green, -1 red or yellow
//! ```
//!
//! `D_k` is the paper's `D_R = C_s (d_p(k) - d_l(k))`, written in the stage's state. `1/D` is convex on `D > 0`. Its
//! literal jump to zero at `d_th` is removed: `1/d_th` is subtracted. The light counts before the stop line and before
//! its first switch only. After that, and always in `acc-mpc`, the cost is the following one alone.
//!
//! Two choices of stages: equation 15 sums over k = 1..N, equation 23 has the penalty where `d_l(k) > 0` and
//! `t_l(k) > 0`. The law sums while `t_k > 0`. With [`LightStages::All`] it sums over all k, with negative `t_k` behind
//! the switch; this is convex, too. It asks `d_l > 0` of the present cycle, not of each k: a set of stages that depends
//! on the predicted distance is not convex.
//!
//! The paper's program can have no solution. Then, in this order: the same without the light; the same with two
//! changes; the previous plan, shifted; the driver model. The first change softens `e_k <= d_b` from `k = 3`, the first
//! stage that an input reaches. The second one weights `E_N` instead of fixing it. The paper has no case without a
//! lead. The driver model then holds the set speed, and ignores signals.
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | `T` | [`Config::step_s`] | s |
//! | `tau` | [`Config::model_time_constant_s`] | s |
//! | `t_h`, `d_b` | [`Config::time_headway_s`], [`Config::standstill_distance_m`] | s, m |
//! | `Q`, `R`, `w`, `d_th` | [`Config::weights`] | see there |
//! | `N` | [`Config::horizon`] | 1 |
//! | `R` (gap), `d_l`, `t_l` | [`law::Input`] | m, m, s |

use mpc_solver::{
    LightCost, LightStage, Problem, ProblemError, Report, Row, Softness, Solver, Start, Status,
};

use scenario::controller::{LightStages, SpacingPolicy};
use scenario::quantity::Weight;

use super::config::Config;
use super::plan::PlanMemory;
use law::{
    Figure, Formulation, Input, Law, MAX_PLAN, ModeMemory, Output, Phase, Quality, SignalAhead,
    Target,
};

/// A plan older than this is not followed any more, s.
const MAX_PLAN_AGE_S: f64 = 1.0;
/// Shortest time before the switch at which the light still counts, s.
const SWITCH_S: f64 = 1e-6;
/// Scaled residuals below this count as solved for driving: a tenth of a millimetre, or of a mm/s.
const USABLE_RESIDUAL: f64 = 1e-4;

pub static FORMULATION: Formulation = Formulation {
    name: "paper",
    caution: None,
    modes: &["cruise", "follow", "follow-with-light"],
    reasons: &["start", "target-lost", "target-found", "light-ahead", "light-over"],
    figures: &[
        Figure::new("gap_error_m", "m").meaning("desired minus real gap; positive: too close"),
        Figure::new("speed_error_mps", "m/s").meaning("speed minus the target's"),
        Figure::new("objective", "1"),
        Figure::new("solver_residual", "1"),
    ],
};
const CRUISE: u32 = 0;
const FOLLOW: u32 = 1;
const LIGHT: u32 = 2;

/// `acc-mpc` and `cacc-mpc` in the paper's formulation.
pub struct PaperLaw {
    config: Config,
    uses_light: bool,
    solver: Box<dyn Solver + Send>,
    /// By [`Program`].
    programs: [Problem; 3],
    state: State,
}

#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// `d_s` at the first target, under [`SpacingPolicy::ConstantDistance`].
    frozen_m: Option<f64>,
    light: Option<LatchedLight>,
    plan: PlanMemory,
    mode: ModeMemory,
}

/// The light that is being approached: it counts until its phase first changes.
#[derive(Clone, Copy, Debug)]
struct LatchedLight {
    id: u32,
    phase: Phase,
    over: bool,
}

#[derive(Clone, Copy, Debug)]
struct ActiveLight {
    sign: f64,
    switch_s: f64,
    distance_m: f64,
}

impl PaperLaw {
    /// Builds the law with its programs; `uses_light` makes it `cacc-mpc`.
    pub fn new(
        config: &Config,
        uses_light: bool,
        solver: Box<dyn Solver + Send>,
    ) -> Result<Self, ProblemError> {
        Ok(Self {
            config: *config,
            uses_light,
            solver,
            programs: [
                problem(config, Program::Lit)?,
                problem(config, Program::Follow)?,
                problem(config, Program::Softened)?,
            ],
            state: State::default(),
        })
    }

    fn follow_target(&mut self, input: &Input, target: &Target, output: &mut Output) -> Quality {
        let error = self.error(input, target);
        output.figures[0] = error[0];
        output.figures[1] = error[1];
        let light = if self.uses_light { self.state.active_light(input) } else { None };
        output.mode = if light.is_some() { LIGHT } else { FOLLOW };
        let without_light = if light.is_some() { Quality::Relaxed } else { Quality::Full };
        for (program, quality) in [
            (Program::Lit, Quality::Full),
            (Program::Follow, without_light),
            (Program::Softened, Quality::Relaxed),
        ] {
            let problem = &mut self.programs[program as usize];
            problem.set_initial_state(error);
            if program == Program::Lit {
                let Some(light) = &light else { continue };
                let v_lead = input.ego.speed_mps + target.relative_speed_mps;
                problem.set_light(light_stages(light, &error, v_lead, &self.config));
            }
            let report = self.solver.solve(problem, Start::Cold);
            output.solver_iterations += report.iterations;
            output.figures[2] = problem.objective(self.solver.inputs(), self.solver.states());
            output.figures[3] = report.residuals.max();
            if usable(&report) {
                self.state.plan.store(self.solver.inputs(), input.time_s, self.config.step_s);
                let fresh = self.state.plan.write(input.time_s, input.period_s, 0.0, output);
                return if fresh { quality } else { Quality::Backup };
            }
        }
        Quality::Backup
    }

    /// `E_0`; freezes the desired distance the first time.
    fn error(&mut self, input: &Input, target: &Target) -> [f64; 3] {
        let ego = &input.ego;
        let measured =
            self.config.time_headway_s * ego.speed_mps + self.config.standstill_distance_m;
        let desired = match self.config.spacing_policy {
            SpacingPolicy::ConstantDistance => *self.state.frozen_m.get_or_insert(measured),
            SpacingPolicy::MeasuredHeadway | SpacingPolicy::ConstantTimeHeadway => measured,
        };
        [desired - target.gap_m, -target.relative_speed_mps, ego.acceleration_mps2]
    }

    /// The last resort, and the plain cruise that the paper does not treat.
    fn driver_request(&self, input: &Input) -> f64 {
        let driver = self.config.driver();
        let speed = input.ego.speed_mps;
        let desired = input.set_speed_mps.min(input.speed_limit_mps);
        let Some(target) = &input.target else {
            return driver.free_mps2(speed, desired);
        };
        let Config { time_headway_s, standstill_distance_m, .. } = self.config;
        let lead = target.lead(speed).obstacle(time_headway_s, standstill_distance_m);
        driver.follow_mps2(speed, desired, &lead)
    }

    /// Keeps the predicted speed at or below the set speed. The present acceleration leads to the
    /// speed `v + a tau` with `tau` = 0.5 s. Once that reaches the set speed,
    /// `u <= (v_set - v - a tau) / 1 s`.
    fn cap_by_set_speed(&self, input: &Input, output: &mut Output) {
        let share = input.period_s / self.config.model_time_constant_s;
        let (mut v, mut a) = (input.ego.speed_mps, input.ego.acceleration_mps2);
        for request in &mut output.plan_mps2[..output.plan_len] {
            if v + 0.5 * a >= input.set_speed_mps {
                let most = input.set_speed_mps - v - 0.5 * a;
                *request = request.min(most.max(self.config.min_request_mps2));
            }
            v += input.period_s * a;
            a += share * (*request - a);
        }
    }
}

/// The convex programs, in the order in which they are tried.
#[derive(Clone, Copy, PartialEq)]
enum Program {
    Lit,
    Follow,
    Softened,
}

/// True if the inputs of a solve may be used.
pub(super) fn usable(report: &Report) -> bool {
    match report.status {
        Status::Solved => true,
        Status::IterationLimit => report.residuals.max() < USABLE_RESIDUAL,
        Status::Infeasible | Status::InvalidInput => false,
    }
}

impl Law for PaperLaw {
    fn reset(&mut self) {
        self.state = State::default();
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        *output = Output::default();
        output.quality = match &input.target {
            Some(target) => self.follow_target(input, target, output),
            None => {
                output.mode = CRUISE;
                self.state.plan.clear();
                output.set_request(self.driver_request(input));
                Quality::Full
            }
        };
        if output.quality == Quality::Backup
            && !self.state.plan.write(input.time_s, input.period_s, MAX_PLAN_AGE_S, output)
        {
            output.set_request(self.driver_request(input));
        }
        self.cap_by_set_speed(input, output);
        let (min, max) = self.request_bounds_mps2();
        for request in &mut output.plan_mps2[..output.plan_len] {
            // No number to go by: brake gently.
            *request = if request.is_finite() { request.clamp(min, max) } else { 0.3 * min };
        }
        output.bound_figures();
        let mode = output.mode;
        self.state.mode.note(output, mode, |before| match (before, mode) {
            (_, CRUISE) => 1,
            (_, LIGHT) => 3,
            (LIGHT, _) => 4,
            _ => 2,
        });
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        (self.config.min_request_mps2, self.config.max_request_mps2)
    }
}

impl State {
    /// The nearest signal, as long as it is ahead and shows its first phase.
    fn active_light(&mut self, input: &Input) -> Option<ActiveLight> {
        let ahead = |signal: &&SignalAhead| signal.distance_m > 0.0;
        let signal = input.signals.iter().flatten().find(ahead)?;
        let now = signal.intervals[..signal.count.min(signal.intervals.len())].first()?;
        let latched = match &mut self.light {
            Some(latched) if latched.id == signal.id => latched,
            other => other.insert(LatchedLight { id: signal.id, phase: now.phase, over: false }),
        };
        if now.phase != latched.phase || now.ends_in_s <= SWITCH_S {
            latched.over = true;
        }
        let sign = match now.phase {
            Phase::Green => 1.0,
            Phase::Yellow | Phase::Red => -1.0,
            Phase::Unknown => return None,
        };
        let active = ActiveLight { sign, switch_s: now.ends_in_s, distance_m: signal.distance_m };
        (!latched.over).then_some(active)
    }
}

/// `D_k` for the stages before the switch.
fn light_stages(
    light: &ActiveLight,
    error: &[f64; 3],
    v_lead: f64,
    config: &Config,
) -> impl Iterator<Item = LightStage> + use<> {
    let (sign, switch, step) = (light.sign, light.switch_s, config.step_s);
    let h = v_lead * switch - light.distance_m - error[0];
    let last = match config.weights.light_stages {
        LightStages::BeforeSwitch => ((switch - SWITCH_S) / step) as usize,
        LightStages::All => config.horizon,
    };
    (1..=last.min(config.horizon)).map(move |k| {
        let t = switch - k as f64 * step;
        LightStage { gradient: [sign, sign * t, sign * 0.5 * t * t], offset: sign * h }
    })
}

fn problem(config: &Config, program: Program) -> Result<Problem, ProblemError> {
    let (n, t, weights) = (config.horizon, config.step_s, &config.weights);
    let c = t / config.model_time_constant_s;
    let q = [weights.q1, weights.q2, weights.q3].map(Weight::value);
    let mut buffer = Row {
        gradient: [1.0, 0.0, 0.0],
        from: 1,
        to: n - 1,
        limit: config.standstill_distance_m,
        softness: Softness::Hard,
    };
    let mut builder = Problem::builder(n)
        .dynamics([[1.0, t, 0.0], [0.0, 1.0, t], [0.0, 0.0, 1.0 - c]], [0.0, 0.0, c])
        .state_weights(q)
        .input_cost(weights.r.value())
        .input_bounds(config.min_request_mps2, config.max_request_mps2);
    if program == Program::Softened {
        buffer.from = 3;
        // Dearer than any error within the buffer is to the following cost.
        let linear = 10.0 * (q[0] + q[1]).max(1.0) * config.standstill_distance_m;
        buffer.softness = Softness::Soft { linear, quadratic: 0.0 };
        builder = builder.terminal_weights([100.0 * q[0] + 1.0, 100.0 * q[1] + 1.0, q[2] + 1.0]);
    } else {
        builder = builder.terminal_equality([0.0; 3]);
    }
    if program == Program::Lit && weights.light_weight.value() > 0.0 {
        builder = builder.light(LightCost {
            weight: weights.light_weight.value(),
            threshold: weights.light_threshold_m.value(),
            softness: Softness::Hard,
        });
    }
    debug_assert!(n <= MAX_PLAN, "a validated horizon fits a plan");
    builder.row(buffer).build()
}
