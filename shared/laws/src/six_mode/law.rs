//! The law: observe, decide, request, smooth, limit.

use super::avoid::{Behind, LAG_S};
use super::boundaries::Boundaries;
use super::deceleration::{LEVELS_MPS2, PARTS};
use super::filter::TargetFilter;
use super::modes::{self, Mode, Reason, Situation};
use super::parameters::{Parameters, Spacing, Variant};
use super::requests;
use law::following::soft_stop::{Room, soften, within_set_speed};
use law::settings::Settings as _;
use law::{Ego, Figure, Formulation, Input, Law, Output, Quality};
use scenario::Problem;

/// Samples in the mean of the decelerate mode.
const MEAN: usize = 4;
/// Request towards which a law without usable input moves, m/s².
const BLIND_REQUEST: f64 = -1.0;
/// Control period assumed when the given one is not usable, s.
const BLIND_PERIOD: f64 = 0.1;
/// Largest distance shown among the figures, m: the literal R_j has a pole.
const FARTHEST: f64 = 1e6;

pub(super) static FORMULATION: Formulation = Formulation {
    name: "six modes",
    caution: None,
    modes: Mode::NAMES,
    reasons: Reason::NAMES,
    figures: &[
        Figure::new("r_w_m", "m"),
        Figure::new("r_b_m", "m"),
        Figure::new("r_j_m", "m"),
        Figure::new("r_x_m", "m"),
        Figure::new("gap_m", "m"),
        Figure::new("relative_speed_mps", "m/s"),
        Figure::new("demand_mps2", "m/s²"),
        Figure::new("time_in_mode_s", "s"),
    ],
};

#[derive(Clone, Debug, Default)]
pub struct SixMode {
    pub parameters: Parameters,
    filter: TargetFilter,
    /// Mode of the last step. `None` before the first; the literal law also has `None` while the paper's table has no
    /// row for what it saw.
    pub mode: Option<Mode>,
    reason: Reason,
    /// Time since the mode was entered, s.
    held_s: f64,
    /// The last demands, newest at `samples - 1` modulo [`MEAN`].
    demands: [f64; MEAN],
    samples: usize,
    /// Request of the last step, m/s².
    request: f64,
}

impl SixMode {
    pub fn new(parameters: Parameters) -> Result<Self, Problem> {
        parameters.check()?;
        Ok(Self { parameters, ..Self::default() })
    }

    fn robust(&self) -> bool {
        self.parameters.variant == Variant::Robust
    }

    /// The target, if it is within range, as the law sees it.
    fn observe(&mut self, input: &Input) -> Option<Situation> {
        let robust = self.robust();
        let p = &self.parameters;
        let Some(target) = &input.target else {
            self.filter.clear();
            return None;
        };
        let time_constant = if robust { p.filter_time_s } else { 0.0 };
        let (gap_m, relative_mps) =
            self.filter.update(target, &input.ego, input.period_s, time_constant);
        modes::in_range(p, self.mode, gap_m, robust).then_some(Situation {
            gap_m,
            speed_mps: input.ego.speed_mps,
            relative_mps,
        })
    }

    /// Decides the mode and returns its demand, m/s². `None`: the table has no row, all stays.
    fn decide(
        &mut self,
        cruise: f64,
        input: &Input,
        seen: Option<(Situation, Boundaries)>,
    ) -> Option<f64> {
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
        if self.parameters.regulates() && mode != Mode::Avoid {
            let fully = -p.braking_mps2;
            if self.behind(input, &s).is_needed(demand) {
                self.enter(Mode::Avoid, Reason::TargetBraking);
                return Some(fully);
            }
        }
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

    fn behind(&self, input: &Input, s: &Situation) -> Behind<'_> {
        let target_mps2 = input.target.map_or(0.0, |target| target.acceleration_mps2);
        Behind::new(&self.parameters, s, &input.ego, target_mps2, input.period_s)
    }

    /// The demand as hard as needed, in the avoid mode and below; the paper's spacing brakes fully.
    fn grade(&self, demand: f64, cruise: f64, input: &Input, s: &Situation) -> f64 {
        if !self.parameters.regulates() {
            return demand;
        }
        let behind = self.behind(input, s);
        if self.mode == Some(Mode::Avoid) {
            return behind.graded(self.request).min(cruise);
        }
        if demand >= -self.parameters.approach_limit_mps2 {
            return demand;
        }
        behind.enough_mps2().map_or(demand, |most| demand.max(most))
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
                let low = self.request - p.emergency_jerk_limit_mps3 * period;
                match p.spacing {
                    Spacing::Paper => demand.max(low),
                    Spacing::TimeGap => demand.clamp(low, (self.request + rise).max(low)),
                }
            }
            _ => demand.clamp(self.request - rise, self.request + rise),
        }
    }

    /// The demand with a soft end of a stop; the paper's spacing ends hard.
    fn soften(&self, demand: f64, ego: &Ego, seen: Option<Situation>) -> f64 {
        if !self.parameters.regulates() {
            return demand;
        }
        let room = seen.map_or(Room::FREE, |s| self.room(&s));
        soften(demand, ego.motion(), LAG_S, room)
    }

    /// The way to where the target stands if it brakes as hard as the ego can.
    fn room(&self, s: &Situation) -> Room {
        let p = &self.parameters;
        let target_mps = (s.speed_mps + s.relative_mps).max(0.0);
        let stops_m = 0.5 * target_mps * target_mps / p.braking_mps2;
        let spare_m = 0.25 * p.standstill_gap_m;
        Room { wanted_m: s.gap_m + stops_m - 2.0 * spare_m, spare_m }
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
        *self = Self { parameters: self.parameters.clone(), ..Self::default() };
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        *output = Output::default();
        if let Some(input) = input.sound() {
            let seen = self.observe(&input);
            let seen = seen.map(|s| {
                let p = &self.parameters;
                (s, Boundaries::of(p, s.speed_mps, s.relative_mps))
            });
            let cruise =
                requests::cruise(&self.parameters, input.set_speed_mps, input.ego.speed_mps);
            let decided = self.decide(cruise, &input, seen);
            if let Some(demand) = decided {
                let demand = self.mean(demand);
                let demand = match seen {
                    Some((s, _)) => self.grade(demand, cruise, &input, &s),
                    None => demand,
                };
                let demand = within_set_speed(demand, input.set_speed_mps);
                let demand = self.soften(demand, &input.ego, seen.map(|(s, _)| s));
                self.request = self.limit(demand, input.period_s);
            }
            self.held_s += input.period_s;
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
        output.mode = self.mode.unwrap_or(Mode::Cruise) as u32;
        output.mode_reason = self.reason as u32;
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        let least = LEVELS_MPS2[PARTS - 1];
        (least.min(-self.parameters.braking_mps2), self.parameters.largest_mps2())
    }
}
