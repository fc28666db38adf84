//! The formulation for the road.
//!
//! In each cycle the signals ahead are stored and the lead is predicted. For the nearest stop line there are two
//! candidates, to pass and to stop. Each has a reference, which is a comfortable driver rolled out over the horizon. A
//! convex program smooths it and enforces the limits:
//!
//! ```text
//! x = (e, ed, a),   e = t_h v + s0 - gap,   ed = v - v_lead
//! e+  = e + T ed + (t_h c_v + c_p) a + (t_h b_v + b_p) u + d_e        exact, linear
//! ed+ = ed + c_v a + b_v u + d_ed,          a+ = c_a a + b_a u
//! d   = what the lead's acceleration a_l(t) = a_l(0) exp(-t/tau_l) does to e and ed
//!
//! minimise  1/2 sum( q_e (e - e_ref)² + q_v (ed - ed_ref)² + q_a (a - a_ref)²
//!                  + q_j ((u - a)/tau)² + r (u - u_ref)² ) + exact penalties
//! pass:  position >= line at the last stage of green, comfortable requests only
//! stop:  position <= line - margin while it is closed
//! both:  position <= lead - gap_min,  0 <= v <= v_max
//! ```
//!
//! One of the two is chosen by feasibility and by one cost for both plans, with hysteresis. The first request then
//! passes a filter of pure kinematics, which has the last word. After the filter the vehicle can still stop before each
//! line that it may not pass. It can still stop behind a lead that brakes as hard as is assumed. It crosses a line that
//! is passed before red.
//!
//! A pass has to do more than reach the line. The paper's penalty `w/D` pulls the vehicle ahead. `D` is the margin by
//! which it is past the line at the end of green. The paper sums it over the stages before. Its slope at the reference's
//! margin is a linear cost of the position there:
//!
//! ```text
//! minimise ... - K (w / D_ref²) p_K     while D_ref < d_th,    K the stage at which green ends
//! ```
//!
//! So the vehicle closes up to its lead before the line and falls back behind it. Each cycle takes the slope
//! anew, and the program stays quadratic. The vehicle glides to a red that ends (see the reference), so that it crosses
//! the line rolling.
//!
//! The lines behind the nearest are in the references and in the filter, and become the nearest in turn. Programs of
//! their own could only gain a green that this drive misses. There is no such green: it drives through each green that
//! a drive without later lines reaches. The 60 scenes begin with a standstill, a glide or a running start. Two later
//! lines follow, 40 to 250 m apart (`later_signals` among the tests).
//!
//! When a program is not solved, the law follows the rest of the previous plan. After it the law follows the
//! driver's own requests. The filter judges these like any other.
//!
//! | symbol | field | unit |
//! |---|---|---|
//! | `T`, `tau` | [`Config::step_s`], [`Config::model_time_constant_s`] | s |
//! | `t_h` | [`Config::time_headway_s`] | s |
//! | `s0`, `gap_min` | [`Config::standstill_distance_m`], `min_gap_m` | m |
//! | `c`, `b` | [`LagStep`](law::following::kinematics::LagStep) | s², s, 1 |
//! | `tau_l` | `RoadConfig::lead_decay_s` | s |
//! | `q_e`, `q_v`, `q_a`, `q_j`, `r` | the weights of `RoadConfig` | see there |
//! | margin | `RoadConfig::stop_margin_m` | m |
//! | `w`, `d_th` | `RoadConfig::light_weight_m`, `light_threshold_m` | m |

mod decision;
mod filter;
mod lead;
mod output;
mod own_lag;
mod planner;
mod program;
mod reference;
mod signals;

use mpc_solver::{ProblemError, Solver};

pub use self::decision::FORMULATION;
use self::decision::{Choice, Situation, choose};
use self::filter::{Filter, Gate, Pass};
use self::own_lag::OwnLag;
use self::planner::{Planner, Seen};
use self::program::Deadline;
use self::signals::{Green, SignalMemory};
use super::config::Config;
use super::plan::PlanMemory;
use law::following::kinematics::{Lag, Motion};
use law::{Input, Law, ModeMemory, Output, Quality};

/// Speed that stands for "no limit", m/s.
const NO_LIMIT_MPS: f64 = 70.0;
/// A previous plan older than this is not followed, s.
const MAX_PLAN_AGE_S: f64 = 0.5;
/// Margin of a comfortable stop, m.
const STOP_ROOM_M: f64 = 0.3;
/// Distance to a closed line within which a vehicle that stands waits, m. Chosen: a car's length, as a driver does.
const WAITS_WITHIN_M: f64 = 5.0;
/// Speed below which a vehicle that close starts, m/s. Chosen: what 2 m/s² give over that distance, rounded down.
const STARTS_MPS: f64 = 4.0;

/// `acc-mpc` and `cacc-mpc` for the road.
pub struct RoadLaw {
    config: Config,
    uses_light: bool,
    planner: Planner,
    state: State,
}

#[derive(Clone, Copy, Debug, Default)]
struct State {
    signals: SignalMemory,
    chosen: Option<(u32, Choice)>,
    plan: PlanMemory,
    own: OwnLag,
    /// State for which the plan in memory was made.
    planned: Option<Choice>,
    mode: ModeMemory,
}

/// Treatment of the nearest line.
#[derive(Clone, Copy, Debug, Default)]
struct Decision {
    /// `None` without a line.
    choice: Option<Choice>,
    /// Why, as an index into the reasons.
    reason: u32,
    /// Distance by which the pass falls short of the line at the end of green, m.
    shortfall_m: f64,
}

impl RoadLaw {
    /// Builds the law with its programs; `uses_light` makes it `cacc-mpc`.
    pub fn new(
        config: &Config,
        uses_light: bool,
        solver: Box<dyn Solver + Send>,
    ) -> Result<Self, ProblemError> {
        Ok(Self {
            config: *config,
            uses_light,
            planner: Planner::new(config, solver)?,
            state: State::default(),
        })
    }

    /// The measured state, in the law's own terms; `None` when a number is missing.
    fn look(&mut self, input: &Input) -> Option<Seen> {
        let ego = &input.ego;
        let lead = input.target.map(|target| target.lead(ego.speed_mps));
        if !input.is_plausible() {
            return None;
        }
        if self.uses_light {
            self.state.signals.update(input);
        }
        let moves = Motion {
            position_m: 0.0,
            speed_mps: ego.speed_mps.clamp(0.0, NO_LIMIT_MPS),
            acceleration_mps2: ego.acceleration_mps2.clamp(-15.0, 15.0),
        };
        let acceleration_mps2 = self.state.own.begin_mps2(moves.acceleration_mps2);
        Some(Seen {
            ego: moves,
            begin: Motion { acceleration_mps2, ..moves },
            lead,
            signals: self.state.signals,
            desired_mps: input.set_speed_mps.min(input.speed_limit_mps).clamp(0.0, NO_LIMIT_MPS),
            profile: input.profile,
        })
    }

    /// Plans for the nearest line and decides about it.
    fn plan(
        &mut self,
        input: &Input,
        seen: &Seen,
        filter: &Filter,
        output: &mut Output,
    ) -> Decision {
        let Some(line) = seen.signals.lines().first() else {
            self.planner.candidate(Choice::Pass, input, seen, reference::Gate::Open, None);
            self.state.chosen = None;
            return Decision::default();
        };
        let now = input.time_s;
        let line_m = line.at_m - input.ego.position_m;
        let before = self.state.chosen.filter(|chosen| chosen.0 == line.id).map(|chosen| chosen.1);
        let green = if line.known {
            line.greens().iter().find(|green| green.clear_s > now).copied()
        } else {
            line.shown(now).copied()
        };
        let step_s = self.planner.lag.step_s;
        let stage_at = |time_s: f64| {
            let stage = ((time_s - now) / step_s + 1e-6).floor();
            (stage >= 1.0).then(|| (stage.min(1e6)) as usize)
        };
        let deadline = green.and_then(|green| {
            let latest_s = green.to_s + self.clearance_s(&green, seen.ego.speed_mps);
            stage_at(latest_s.max(green.likely_s))
        });
        let n = self.config.horizon;
        let (mut reaches, mut clears, mut untouched) = (false, false, false);
        let mut shortfall_m = 0.0;
        if let Some(green) = green {
            let gate = if green.from_s <= now {
                reference::Gate::Open
            } else {
                reference::Gate::ClosedUntil(green.from_s)
            };
            let row = deadline.filter(|&stage| stage <= n).map(|stage| {
                let switch = stage_at(green.to_s).filter(|&switch| switch <= n);
                Deadline { stage, switch, line_m }
            });
            self.planner.candidate(Choice::Pass, input, seen, gate, row);
            let pass = Pass { red_in_s: green.clear_s - now, most_mps: seen.desired_mps };
            let gate = Gate { distance_m: line_m, pass: Some(pass) };
            let arrival = self.planner.arrival(Choice::Pass, line_m);
            let by = |stage: Option<usize>| {
                stage.is_some_and(|stage| arrival.map_or(stage > n, |arrival| arrival <= stage))
            };
            // Where its end is open, the filter keeps the vehicle able to stop or to clear the line in yellow.
            reaches = by(deadline)
                && (arrival.is_none()
                    || green.likely_s > green.to_s
                    || self.planner.is_let_through(pass, line_m, filter));
            clears = by(stage_at(green.clear_s))
                || green.from_s <= now && filter.can_cross(0.0, seen.ego, seen.lead.as_ref(), gate);
            // The undisturbed driver passes: nothing can be cheaper.
            let driver = &self.planner.candidate_of(Choice::Pass).reference;
            let in_time = |k| deadline.is_some_and(|stage| k <= stage);
            untouched = reaches && driver.reaches(line_m, n).is_some_and(in_time);
            shortfall_m = self.planner.shortfall(line_m, deadline);
            output.figures[4] = shortfall_m;
        }
        let (mut pass_cost, mut stop_cost) = (0.0, f64::INFINITY);
        if !(line.known && untouched) {
            let next = line
                .greens()
                .iter()
                .find(|next| line.known && green.is_none_or(|green| next.from_s >= green.clear_s));
            let gate = next
                .map_or(reference::Gate::Closed, |next| reference::Gate::ClosedUntil(next.from_s));
            self.planner.candidate(Choice::Stop, input, seen, gate, None);
            if green.is_some() {
                pass_cost = self.planner.cost(Choice::Pass);
                stop_cost = self.planner.cost(Choice::Stop);
                output.figures[5] = pass_cost;
                output.figures[6] = stop_cost;
            }
        }
        let lag = Lag { tau_s: self.config.model_time_constant_s };
        let comfort = -self.config.road.comfort_deceleration_mps2;
        let room = STOP_ROOM_M.min(0.5 * line_m);
        let comfortable_stop = lag.stop(seen.ego, comfort).distance_m <= line_m - room;
        let situation = Situation {
            known: line.known,
            reaches,
            starts: line_m < WAITS_WITHIN_M
                && seen.ego.speed_mps < STARTS_MPS
                && green.is_some_and(|green| (green.from_s..green.to_s).contains(&now)),
            clears,
            comfortable_stop,
            hard_stop: filter.can_stop(seen.ego, line_m),
            pass_cost,
            stop_cost,
            before,
        };
        let (choice, reason) = choose(&situation, self.config.road.hysteresis);
        self.state.chosen = Some((line.id, choice));
        Decision { choice: Some(choice), reason: reason as u32, shortfall_m }
    }

    /// Time after the end of green in which the line may still be crossed at a speed, s. A driver who brakes for the
    /// yellow would not stop before the line.
    fn clearance_s(&self, green: &Green, speed_mps: f64) -> f64 {
        let road = &self.config.road;
        if road.yellow_reaction_s == 0.0 {
            return 0.0;
        }
        let lag_s = road.yellow_reaction_s + self.config.model_time_constant_s;
        let stop_s = lag_s + speed_mps / (2.0 * road.comfort_deceleration_mps2);
        stop_s.min(green.clear_s - green.to_s)
    }
}

impl Law for RoadLaw {
    fn reset(&mut self) {
        self.state = State::default();
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        *output = Output::default();
        let Some(seen) = self.look(input) else {
            output.quality = Quality::Backup;
            if !self.state.plan.write(input.time_s, self.config.step_s, MAX_PLAN_AGE_S, output) {
                output.set_request(-self.config.road.reference_deceleration_mps2);
            }
            self.state.mode.show(output);
            return;
        };
        self.planner.predict(&seen);
        let filter = Filter::new(&self.config, input.period_s);
        let decision = self.plan(input, &seen, &filter, output);
        let closed = self.write(input, &seen, &decision, &filter, output);
        if let Some(lead) = &seen.lead {
            let v = seen.ego.speed_mps;
            let desired = self.config.time_headway_s * v + self.config.standstill_distance_m;
            output.figures[0] = desired - lead.gap_m;
            output.figures[1] = v - lead.speed_mps;
        }
        output.bound_figures();
        let mode = match (decision.choice, seen.lead) {
            (Some(_), _) if closed => 3,
            (Some(_), _) => 2,
            (None, Some(_)) => 1,
            (None, None) => 0,
        };
        self.state.mode.note(output, mode, |_| match mode {
            0 => 1,
            1 => 2,
            _ => decision.reason,
        });
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        (self.config.min_request_mps2, self.config.max_request_mps2)
    }
}
