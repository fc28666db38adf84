//! Six-mode switching cruise control (`six-mode`).
//!
//! Wang, Liu, Zhang, Tong: "A multi-mode adaptive cruise control strategy", 2014,
//! doi 10.3963/j.issn 1674-4861.2014.04.026. Boundaries in gap and relative speed divide driving
//! into six modes; each mode has a simple law of its own. With V_h and V_p the speeds of ego and
//! target, V_r = V_p - V_h and R the gap:
//!
//! | mode | when V_r < 0 | when V_r > 0 | request, m/s² |
//! | --- | --- | --- | --- |
//! | 1 cruise | no target in range | no target in range | (7): 1, or k1 (V_set - V_h) near V_set |
//! | 2 approach | R >= R_w, closing at k or more | | (8): -V_r²/(2 (R - R_w)) |
//! | 3 steady | R >= R_w, closing below k | R_w <= R < R_j | (9), (10): -0.1, 0.4, or k3 V_r |
//! | 4 decelerate | R_b < R < R_w | R_b < R < R_w | eight levels, -0.5 to -3.75, mean of four |
//! | 5 avoid | R <= R_b | R <= R_b | -a_h |
//! | 6 accelerate | | R >= R_j | 1 |
//!
//! ```text
//! R_x = 1.25 V below 80 km/h, else 2.5 V - 100             V = V_h in km/h
//! R_w = R_x + V_r²/(2 a) + t1 |V_r|  (closing)             (1)     R_x (opening)          (5)
//! R_b = V_h²/(2 a_h) + V_h t1 - V_p²/(2 a_p) + R0          (2) (3)
//! R_b = V_h²/(2 a_h) + V_h t1 - (V_p t_h - a_p t_h²/2) + R0        t_h = V_h/a_h + t1 < V_p/a_p  (4)
//! R_j = 5 V_r + 30/7 V_h + (V_h + V_r) + 8 (18 - V_r)/(V_r + 2) - V_r²/(2 a_h)            (6)
//! ```
//!
//! | symbol | field | unit |
//! | --- | --- | --- |
//! | R_x, R_w, R_b, R_j | [`Boundaries`] | m |
//! | R, V_h, V_r | [`Situation`] | m, m/s, m/s |
//! | a_h, a_p, a | `braking_mps2`, `lead_braking_mps2`, `warning_deceleration_mps2` | m/s² |
//! | t1 | `reaction_time_s` | s |
//! | R0 | `standstill_gap_m` | m |
//! | k, k_c | `approach_threshold_mps`, `steady_band_mps` | m/s |
//! | k1, k3 | `cruise_gain_per_s`, `steady_gain_per_s` | 1/s |
//!
//! # Two variants
//!
//! [`Variant::Literal`] is the paper, corrected only where the print is impossible (a lost square,
//! a lost minus, a sign, an undefined symbol); its requests are clamped to the law's bounds and
//! nothing else is added. [`Variant::Robust`], the default, cures what makes it undrivable:
//!
//! | trap of the literal law | cure |
//! | --- | --- |
//! | 1. R_w < R_b near standstill: blips of full braking | R_w at least `least_band_m` above R_b |
//! | 2. (4) falls below R0, even below zero | floor at R0 |
//! | 3. (8) has no bound as R -> R_w | limit and floor of the denominator |
//! | 4. R_j has a pole at V_r = -2 and drops 30 m up to V_r = 3 | max(V_r, 0), hysteresis |
//! | 5. no row for V_r = 0 | one order of tests for all V_r, a sign band |
//! | 6. modes 2, 3, 4, 6 ignore the set speed; no gap is regulated between R_x and R_j | minimum with the cruise law; the push of (9) fades towards R_w |
//! | 7. avoid ends and begins again at R_b | leave above R_b + `braking_hysteresis_m` |
//! | 8. noise changes modes all the time | hysteresis, dwell, filter |
//! | 9. range edge, steps of the request, stale filter | range hysteresis, jerk limit, filter reset |
//!
//! Trap 4 has a second half that the clamp leaves standing: (6) itself still falls by about 30 m
//! between V_r = 0 and 3 m/s, which is the paper's; hysteresis keeps it from chattering.

mod boundaries;
mod filter;
mod modes;
mod parameters;
mod requests;

pub use boundaries::Boundaries;
pub use modes::{Mode, Reason, Situation};
pub use parameters::{Expected, ParameterError, Parameters, Variant};

use crate::law::{Ego, Input, Law, Output, Quality, Target};
use filter::TargetFilter;

/// Samples in the mean of the decelerate mode.
const MEAN: usize = 4;
/// Request towards which a law without usable input moves, m/s².
const BLIND_REQUEST: f64 = -1.0;
/// Control period assumed when the given one is not usable, s.
const BLIND_PERIOD: f64 = 0.1;
/// Largest distance shown among the figures, m: the literal R_j has a pole.
const FARTHEST: f64 = 1e6;
/// No road vehicle is faster, m/s; anything above is a broken input.
const FASTEST: f64 = 150.0;

/// The six-mode law.
#[derive(Clone, Debug)]
pub struct SixMode {
    parameters: Parameters,
    filter: TargetFilter,
    mode: Option<Mode>,
    reason: Reason,
    /// Time since the mode was entered, s.
    held_s: f64,
    /// The last demands, newest at `samples - 1` modulo [`MEAN`].
    demands: [f64; MEAN],
    samples: usize,
    /// Request of the last step, m/s².
    request: f64,
}

/// What a step needs of its input once that is known to be usable.
struct Checked {
    ego: Ego,
    target: Option<Target>,
    set_speed: f64,
    period: f64,
}

impl SixMode {
    /// A law with the given parameters.
    ///
    /// # Errors
    /// The parameter that is not usable.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self {
            parameters,
            filter: TargetFilter::default(),
            mode: None,
            reason: Reason::None,
            held_s: 0.0,
            demands: [0.0; MEAN],
            samples: 0,
            request: 0.0,
        })
    }

    /// The law's parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Mode of the last step; `None` before the first, and for the literal law as long as the
    /// paper's table has had no row for what it saw.
    #[must_use]
    pub fn mode(&self) -> Option<Mode> {
        self.mode
    }

    fn robust(&self) -> bool {
        self.parameters.variant == Variant::Robust
    }

    /// The target, if it is within range, as the law sees it.
    fn observe(&mut self, input: &Checked) -> Option<Situation> {
        let robust = self.robust();
        let p = &self.parameters;
        let Some(target) = &input.target else {
            self.filter.clear();
            return None;
        };
        let time_constant = if robust { p.filter_time_s } else { 0.0 };
        let (gap_m, relative_mps) =
            self.filter.update(target, &input.ego, input.period, time_constant);
        modes::in_range(p, self.mode, gap_m, robust).then_some(Situation {
            gap_m,
            speed_mps: input.ego.speed_mps,
            relative_mps,
        })
    }

    /// Decides the mode and returns its demand, m/s². `None`: the table has no row, all stays.
    fn decide(&mut self, cruise: f64, seen: Option<(Situation, Boundaries)>) -> Option<f64> {
        let p = &self.parameters;
        let Some((s, b)) = seen else {
            self.enter(Mode::Cruise, Reason::NoTarget);
            return Some(cruise);
        };
        let (mode, reason) = match p.variant {
            Variant::Literal => modes::literal(p, &s, &b)?,
            Variant::Robust => modes::robust(p, self.mode, self.held_s, &s, &b),
        };
        let demand = requests::following(p, mode, &s, &b);
        let demand = match p.variant {
            Variant::Literal => demand.max(self.request_bounds_mps2().0),
            Variant::Robust => demand.min(cruise),
        };
        self.enter(mode, reason);
        Some(demand)
    }

    fn enter(&mut self, mode: Mode, reason: Reason) {
        if self.mode != Some(mode) {
            self.mode = Some(mode);
            self.reason = reason;
            self.held_s = 0.0;
        }
    }

    /// Mean of the last demands in the decelerate mode, the newest otherwise.
    fn mean(&mut self, demand: f64) -> f64 {
        self.demands[self.samples % MEAN] = demand;
        self.samples += 1;
        if self.mode == Some(Mode::Decelerate) {
            let count = self.samples.min(MEAN);
            self.demands[..count].iter().sum::<f64>() / count as f64
        } else {
            demand
        }
    }

    /// Bounds the request and, in the robust law, its rate.
    fn limit(&self, demand: f64, period: f64) -> f64 {
        let (low, high) = self.request_bounds_mps2();
        let demand = demand.clamp(low, high);
        let p = &self.parameters;
        let rise = p.jerk_limit_mps3 * period;
        match (p.variant, self.mode) {
            (Variant::Literal, _) => demand,
            (_, Some(Mode::Avoid)) => {
                demand.max(self.request - p.emergency_jerk_limit_mps3 * period)
            }
            _ => demand.clamp(self.request - rise, self.request + rise),
        }
    }

    /// Without usable input: towards comfortable braking, never releasing a brake that is on.
    fn blind(&mut self, output: &mut Output) {
        let rise = self.parameters.jerk_limit_mps3 * BLIND_PERIOD;
        self.request = BLIND_REQUEST.min(self.request).max(self.request - rise);
        output.quality = Quality::Backup;
        output.set_request(self.request);
    }
}

impl Law for SixMode {
    fn reset(&mut self) {
        self.filter.clear();
        self.mode = None;
        self.reason = Reason::None;
        self.held_s = 0.0;
        self.demands = [0.0; MEAN];
        self.samples = 0;
        self.request = 0.0;
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        *output = Output::default();
        if let Some(input) = check(input) {
            let seen = self.observe(&input);
            let seen = seen.map(|s| {
                let p = &self.parameters;
                let b = if self.robust() {
                    Boundaries::robust(p, s.speed_mps, s.relative_mps)
                } else {
                    Boundaries::literal(p, s.speed_mps, s.relative_mps)
                };
                (s, b)
            });
            let cruise = requests::cruise(&self.parameters, input.set_speed, input.ego.speed_mps);
            let decided = self.decide(cruise, seen);
            if let Some(demand) = decided {
                let demand = self.mean(demand);
                self.request = self.limit(demand, input.period);
            }
            self.held_s += input.period;
            output.set_request(self.request);
            if let Some((s, b)) = seen {
                output.figures[..6].copy_from_slice(&[
                    b.warning_m,
                    b.braking_m,
                    b.following_m.clamp(-FARTHEST, FARTHEST),
                    b.desired_m,
                    s.gap_m,
                    s.relative_mps,
                ]);
            }
            output.figures[6] = decided.unwrap_or(self.request);
            output.figures[7] = self.held_s;
        } else {
            self.blind(output);
        }
        output.mode = self.mode.unwrap_or(Mode::Cruise).index();
        output.mode_reason = self.reason.index();
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        let least = requests::LEVELS[requests::LEVELS.len() - 1];
        (least.min(-self.parameters.braking_mps2), requests::FULL_ACCELERATION)
    }

    fn mode_names(&self) -> &'static [&'static str] {
        Mode::NAMES
    }

    fn reason_names(&self) -> &'static [&'static str] {
        Reason::NAMES
    }

    fn figure_names(&self) -> &'static [&'static str] {
        &[
            "r_w_m",
            "r_b_m",
            "r_j_m",
            "r_x_m",
            "gap_m",
            "relative_speed_mps",
            "demand_mps2",
            "time_in_mode_s",
        ]
    }
}

/// The input, if every value the law uses is one that a vehicle can have.
fn check(input: &Input) -> Option<Checked> {
    let within = |v: f64, low: f64, high: f64| (low..=high).contains(&v);
    let set_speed = input.set_speed_mps.min(input.speed_limit_mps).max(0.0);
    let usable = within(input.period_s, 1e-4, 10.0)
        && within(input.ego.speed_mps, -1.0, FASTEST)
        && within(set_speed, 0.0, FASTEST)
        && !input.set_speed_mps.is_nan()
        && !input.speed_limit_mps.is_nan()
        && input.target.is_none_or(|t| {
            within(t.gap_m, -FARTHEST, FARTHEST)
                && within(t.relative_speed_mps, -2.0 * FASTEST, FASTEST)
        });
    usable.then(|| Checked {
        ego: Ego { speed_mps: input.ego.speed_mps.max(0.0), ..input.ego },
        target: input.target,
        set_speed,
        period: input.period_s,
    })
}
