//! The two convex programs, go and hold, in the state and with the cost of [the formulation](super):
//!
//! ```text
//! d_e = T v_l - (x_l+ - x_l),   d_ed = -(v_l+ - v_l)                     the predicted lead as a disturbance
//! p   = x_l + e - t_h (ed + v_l) - s0                                  position of the ego
//! ```
//!
//! | row | go (comfortable requests only) | hold (all requests) |
//! |---|---|---|
//! | 0 | `p <= ceiling` (lead, closed lines) | the same |
//! | 1 | `v <= v_max + 0.1 m/s`, in curves by the road at the reference's place | the same |
//! | 2 | `v >= -0.1 m/s` | the same |
//! | 3 | `p >= line` at the last stage of green | `a >= -comfort` |
//!
//! All rows are soft with an exact linear price. A measured state, a cut-in or a jumping countdown can make any of them
//! impossible. Then the aim is the least violation, not a failed solve.

use mpc_solver::{Problem, ProblemError, Row, Softness};

use super::lead::Prediction;
use super::reference::Reference;
use crate::cacc::config::{Config, RoadConfig};
use law::following::kinematics::{LagStep, Motion};
use law::following::safe_gap::LeadNow;

/// Price of a metre beyond the ceiling.
const CEILING_PRICE: f64 = 300.0;
/// Price of a m/s above the limit: no green is worth speeding. A m/s over
/// the whole horizon costs 100 000, and gains 10 m, which are worth 30 000 at [`PASS_PRICE`].
const FAST_PRICE: f64 = 1000.0;
/// Price of a m/s below zero.
const SLOW_PRICE: f64 = 100.0;
/// Price of a m/s² beyond the comfort bound.
const COMFORT_PRICE: f64 = 30.0;
/// Price of a metre short of the line at the end of green.
const PASS_PRICE: f64 = 3000.0;
/// Ratio of the last stage's weights to the others'.
const TERMINAL: f64 = 5.0;
/// Distance beyond the line that a pass must reach, m.
const PASS_M: f64 = 0.3;
/// Margin below which the light's price grows no more, m. About a second of motion: there the pass itself is at stake,
/// and has its own price.
const LEAST_MARGIN_M: f64 = 12.0;
/// Band of speed below the limit in which the light's pull fades, m/s.
const PULL_BAND_MPS: f64 = 1.0;
/// Distance of the limits of the speed beyond the reference's speed, m/s. If the reference lay on a limit (above all at
/// a stand), the limit would hold without a force. No method finds such a solution quickly.
const SPEED_MARGIN_MPS: f64 = 0.1;

/// The same for a reference above the limit, m/s.
const EXCESS_MARGIN_MPS: f64 = 0.02;

const CEILING: usize = 0;
const FAST: usize = 1;
const SLOW: usize = 2;
const PASS: usize = 3;

/// The line that a pass must reach, and at which stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deadline {
    pub(super) stage: usize,
    /// The stage at which green ends, within the horizon.
    pub(super) switch: Option<usize>,
    /// Position of the line, the ego's front bumper now being zero, m.
    pub(super) line_m: f64,
}

pub(super) struct Programs {
    pub(super) go: Problem,
    pub(super) hold: Problem,
    config: Config,
}

impl Programs {
    pub(super) fn new(config: &Config, lag: &LagStep) -> Result<Self, ProblemError> {
        let road = &config.road;
        let n = config.horizon;
        let pass = row([-1.0, config.time_headway_s, 0.0], n, PASS_PRICE);
        let comfort = Row {
            limit: road.comfort_deceleration_mps2,
            ..row([0.0, 0.0, -1.0], n, COMFORT_PRICE)
        };
        Ok(Self {
            go: problem(config, lag, -road.comfort_deceleration_mps2, pass)?,
            hold: problem(config, lag, config.min_request_mps2, comfort)?,
            config: *config,
        })
    }

    /// Fills `go`; without a deadline nothing has to be passed.
    pub(super) fn fill_go(
        &mut self,
        reference: &Reference,
        lead: &Prediction,
        deadline: Option<Deadline>,
    ) {
        let (t_h, s0) = (self.config.time_headway_s, self.config.standstill_distance_m);
        fill(&mut self.go, &self.config, reference, lead);
        match deadline {
            Some(Deadline { stage, switch, line_m }) => {
                if let Some(switch) = switch {
                    let margin_m = reference.motion[switch].position_m - line_m;
                    let slower = reference.fastest_mps[0] - reference.motion[0].speed_mps;
                    let share = (slower / PULL_BAND_MPS).clamp(0.0, 1.0);
                    self.pull(switch, share * switch as f64 * self.light_price(margin_m));
                }
                let offset = lead.stages[stage].gap_m - t_h * lead.stages[stage].speed_mps - s0;
                self.go.set_row_stages(PASS, stage, stage);
                self.go.row_limits_mut(PASS)[stage] = offset - (line_m + PASS_M);
            }
            None => self.go.set_row_stages(PASS, 1, 0),
        }
    }

    /// Price of a metre of the margin `D` at the end of green, for each stage before it: the paper sums `w/D` over these
    /// stages. It is the slope of `w/D` at the reference's margin.
    fn light_price(&self, margin_m: f64) -> f64 {
        let margin_m = margin_m.max(LEAST_MARGIN_M);
        if margin_m < self.config.road.light_threshold_m {
            self.config.road.light_weight_m / (margin_m * margin_m)
        } else {
            0.0
        }
    }

    /// Rewards a position ahead at a stage of `go`, by `price` a metre.
    fn pull(&mut self, stage: usize, price: f64) {
        let gradient = [1.0, -self.config.time_headway_s, 0.0].map(|g| -price * g);
        let add = |to: &mut [f64; 3]| to.iter_mut().zip(gradient).for_each(|(to, g)| *to += g);
        if let Some(stage) = self.go.state_gradients_mut().get_mut(stage) {
            add(stage);
        }
    }

    pub(super) fn fill_hold(&mut self, reference: &Reference, lead: &Prediction) {
        fill(&mut self.hold, &self.config, reference, lead);
    }
}

/// Fills what both programs have.
fn fill(problem: &mut Problem, config: &Config, reference: &Reference, lead: &Prediction) {
    let (t_h, s0, step) = (config.time_headway_s, config.standstill_distance_m, config.step_s);
    let (weights, r) = (weights(&config.road), config.road.request_weight_s4_per_m2);
    let error = |k: usize, motion: &Motion| {
        let LeadNow { gap_m, speed_mps, .. } = lead.stages[k];
        let v = motion.speed_mps;
        [t_h * v + s0 - (gap_m - motion.position_m), v - speed_mps, motion.acceleration_mps2]
    };
    let n = problem.horizon();
    problem.set_initial_state(error(0, &reference.motion[0]));
    for (k, d) in problem.disturbances_mut().iter_mut().enumerate() {
        let (now, next) = (&lead.stages[k], &lead.stages[k + 1]);
        let moved = next.gap_m - now.gap_m;
        *d = [step * now.speed_mps - moved, now.speed_mps - next.speed_mps, 0.0];
    }
    for (k, gradient) in problem.state_gradients_mut().iter_mut().enumerate() {
        let x = error(k, &reference.motion[k]);
        *gradient = std::array::from_fn(|i| -weights[i] * x[i]);
    }
    for (gradient, request) in problem.input_gradients_mut().iter_mut().zip(reference.request_mps2)
    {
        *gradient = -r * request;
    }
    let last = error(n, &reference.motion[n]);
    problem.set_terminal_gradient(std::array::from_fn(|i| -TERMINAL * weights[i] * last[i]));
    for k in 1..=n {
        let v_lead = lead.stages[k].speed_mps;
        let offset = lead.stages[k].gap_m - t_h * v_lead - s0;
        problem.row_limits_mut(CEILING)[k] = reference.ceiling_m[k] - offset;
        // Above the limit nothing may become faster: a limit that followed would be driven up, cycle by cycle.
        let above = reference.motion[k].speed_mps.min(reference.motion[0].speed_mps);
        let fastest = (reference.fastest_mps[k] + SPEED_MARGIN_MPS).max(above + EXCESS_MARGIN_MPS);
        problem.row_limits_mut(FAST)[k] = fastest - v_lead;
        problem.row_limits_mut(SLOW)[k] = v_lead + SPEED_MARGIN_MPS;
    }
}

fn weights(road: &RoadConfig) -> [f64; 3] {
    [road.gap_weight_per_m2, road.speed_weight_s2_per_m2, road.acceleration_weight_s4_per_m2]
}

fn row(gradient: [f64; 3], horizon: usize, price: f64) -> Row {
    let softness = Softness::Soft { linear: price, quadratic: 0.0 };
    Row { gradient, from: 1, to: horizon, limit: f64::INFINITY, softness }
}

fn problem(
    config: &Config,
    lag: &LagStep,
    min_mps2: f64,
    fourth: Row,
) -> Result<Problem, ProblemError> {
    let (n, t_h, road) = (config.horizon, config.time_headway_s, &config.road);
    let [cv, bv] = lag.speed;
    let [cp, bp] = lag.position;
    let [ca, ba] = lag.acceleration;
    Problem::builder(n)
        .dynamics(
            [[1.0, lag.step_s, t_h * cv + cp], [0.0, 1.0, cv], [0.0, 0.0, ca]],
            [t_h * bv + bp, bv, ba],
        )
        .state_weights(weights(road))
        .terminal_weights(weights(road).map(|w| TERMINAL * w))
        .input_cost(road.request_weight_s4_per_m2)
        .jerk_cost(road.jerk_weight_s6_per_m2, config.model_time_constant_s)
        .input_bounds(min_mps2, road.acceleration_mps2)
        .row(row([1.0, -t_h, 0.0], n, CEILING_PRICE))
        .row(row([0.0, 1.0, 0.0], n, FAST_PRICE))
        .row(row([0.0, -1.0, 0.0], n, SLOW_PRICE))
        .row(fourth)
        .build()
}
