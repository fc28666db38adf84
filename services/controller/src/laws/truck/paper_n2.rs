//! The published planner: constant torques over the next n = 2 segments (steps 3 to 6).
//!
//! ```text
//! J = sum_{i<n}(fuel_i + beta t_i) - gamma (K_end - K_set) + q gamma (K_end - K_set)²/K_set      n = 2, q = 1
//! ```
//!
//! Torques are enumerated: 21 levels and those that hold the present and the set speed, the second
//! segment's for each of the first's. The class of the road trims the first torque. K over a segment is
//! the closed form (4), time over it Simpson's rule.

use super::prices::Prices;
use super::road_classes::{Class, LimitGrades, Reconstruction, Stretch};
use super::speed_band::SpeedBand;
use crate::law::{Plan, PlanRequest, Planner};
use truck_model::Truck;

/// Torque levels of each segment.
const LEVELS: usize = 21;
/// Weight q of the terminal cost's square.
const TERMINAL_SQUARE: f64 = 1.0;
/// Penalty of energy above the highest speed, and below the lowest, as shares of the price of energy.
const TOO_FAST: f64 = 0.02;
const TOO_SLOW: f64 = 0.08;
/// Lowest speed for which the closed form is taken, m/s.
const CRAWLING_MPS: f64 = 8.0;
/// Share of full load that an uphill gets at least.
const UPHILL_SHARE: f64 = 0.25;
/// Slack of the rules that trim the first torque, N m.
const TRIM_SLACK_NM: f64 = 1.0;
/// The trims before a hill hold below this excess and before a dip above this deficit of speed, m/s.
const BEFORE_UPHILL_MPS: f64 = 0.5;
const BEFORE_DOWNHILL_MPS: f64 = 2.0;

/// The planner.
#[derive(Clone, Debug)]
pub struct PaperN2 {
    truck: Truck,
    prices: Prices,
    limits: LimitGrades,
    /// Set speed that prices and limits belong to.
    set_speed_mps: f64,
    road: Reconstruction,
}

impl PaperN2 {
    /// A planner for `truck`.
    #[must_use]
    pub fn new(truck: &Truck) -> Self {
        Self {
            truck: *truck,
            prices: Prices::default(),
            limits: LimitGrades::default(),
            set_speed_mps: 0.0,
            road: Reconstruction::default(),
        }
    }
}

impl Planner for PaperN2 {
    fn plan(&mut self, request: &PlanRequest, plan: &mut Plan) -> bool {
        plan.begin(request);
        if self.set_speed_mps != request.set_speed_mps {
            self.set_speed_mps = request.set_speed_mps;
            self.prices = Prices::new(&self.truck, request.set_speed_mps);
            self.limits = LimitGrades::new(&self.truck, request.set_speed_mps);
        }
        self.road.rebuild(&request.preview, request.position_m, &self.limits);
        let (segments, count) = self.road.segments();
        if count == 0 || request.speed_mps < CRAWLING_MPS {
            return false;
        }
        let search = Search::new(&self.truck, &self.prices, request);
        let Some(best) = search.best(&segments[..count]) else { return false };
        let mut end_m = request.position_m;
        for (segment, (torque_nm, speed_mps)) in segments[..count].iter().zip(best) {
            end_m += segment.length_m;
            plan.push(end_m, torque_nm + search.auxiliary_nm, None, speed_mps);
        }
        plan.binding = 1;
        true
    }
}

/// What does not change during one search.
struct Search<'a> {
    truck: &'a Truck,
    request: &'a PlanRequest,
    energy_gpj: f64,
    time_gps: f64,
    auxiliary_nm: f64,
    low_nm: f64,
    high_nm: f64,
    set_j: f64,
    min_j: f64,
    max_j: f64,
    crawling_j: f64,
}

/// A segment with what its closed form needs.
struct Piece {
    stretch: Stretch,
    road_n: f64,
    decay: f64,
    half_decay: f64,
    /// Torque that holds the set speed, N m.
    hold_nm: f64,
}

/// State at a segment's end and what it cost.
#[derive(Clone, Copy)]
struct End {
    energy_j: f64,
    speed_mps: f64,
    cost_g: f64,
}

impl<'a> Search<'a> {
    fn new(truck: &'a Truck, prices: &Prices, request: &'a PlanRequest) -> Self {
        let rpm = truck.engine_rpm(request.speed_mps, request.gear);
        let (low_nm, high_nm) = truck.net_torque_limits_nm(request.speed_mps, request.gear);
        Self {
            truck,
            request,
            energy_gpj: prices.energy_gpj,
            time_gps: request.time_price * prices.time_gps,
            auxiliary_nm: truck.auxiliary_torque_nm(rpm),
            low_nm,
            high_nm,
            set_j: truck.kinetic_energy_j(request.set_speed_mps),
            min_j: truck.kinetic_energy_j(SpeedBand::of(request).min_mps),
            max_j: truck.kinetic_energy_j(SpeedBand::of(request).max_mps),
            crawling_j: truck.kinetic_energy_j(CRAWLING_MPS),
        }
    }

    fn piece(&self, stretch: &Stretch) -> Piece {
        let decay = libm::exp(-self.truck.drag_per_m() * stretch.length_m);
        let set_mps = self.request.set_speed_mps;
        let hold_n = self.truck.resistance_n(set_mps, stretch.grade);
        Piece {
            stretch: *stretch,
            road_n: self.truck.road_resistance_n(stretch.grade),
            decay,
            half_decay: decay.sqrt(),
            hold_nm: self.truck.net_torque_nm(hold_n, self.request.gear),
        }
    }

    /// Torque and speed at the end, for each segment.
    fn best(&self, segments: &[Stretch]) -> Option<[(f64, f64); 2]> {
        let first = self.piece(&segments[0]);
        let second = segments.get(1).map(|stretch| self.piece(stretch));
        let speed_mps = self.request.speed_mps;
        let energy_j = self.truck.kinetic_energy_j(speed_mps);
        let start = End { energy_j, speed_mps, cost_g: 0.0 };
        let resistance_n = self.truck.resistance_n(speed_mps, first.stretch.grade);
        let hold_now_nm = self.truck.net_torque_nm(resistance_n, self.request.gear);
        let next_class = segments.get(1).map_or(Class::Level, |stretch| stretch.class);

        let mut best = None;
        let mut least = f64::INFINITY;
        let levels = (0..LEVELS).map(|level| self.level_nm(level));
        for torque_nm in levels.chain([hold_now_nm, first.hold_nm]) {
            let torque_nm = torque_nm.clamp(self.low_nm, self.high_nm);
            if !self.fits(&first, next_class, torque_nm) {
                continue;
            }
            let Some(middle) = self.drive(&first, start, torque_nm) else { continue };
            let (end, last) = match &second {
                None => (middle, (0.0, 0.0)),
                Some(second) => match self.best_second(second, middle) {
                    Some((end, torque_nm)) => (end, (torque_nm, end.speed_mps)),
                    None => continue,
                },
            };
            let cost_g = end.cost_g + self.terminal_g(end.energy_j);
            if cost_g < least {
                least = cost_g;
                best = Some([(torque_nm, middle.speed_mps), last]);
            }
        }
        best
    }

    fn best_second(&self, piece: &Piece, start: End) -> Option<(End, f64)> {
        let mut best = None;
        let mut least = f64::INFINITY;
        for torque_nm in (0..LEVELS).map(|level| self.level_nm(level)).chain([piece.hold_nm]) {
            let torque_nm = torque_nm.clamp(self.low_nm, self.high_nm);
            let Some(end) = self.drive(piece, start, torque_nm) else { continue };
            let cost_g = end.cost_g + self.terminal_g(end.energy_j);
            if cost_g < least {
                least = cost_g;
                best = Some((end, torque_nm));
            }
        }
        best
    }

    fn level_nm(&self, level: usize) -> f64 {
        self.low_nm + (self.high_nm - self.low_nm) * level as f64 / (LEVELS - 1) as f64
    }

    /// The drive type of the first segment trims its torque.
    fn fits(&self, first: &Piece, next: Class, torque_nm: f64) -> bool {
        let speed_mps = self.request.speed_mps;
        let set_mps = self.request.set_speed_mps;
        let hold_nm = first.hold_nm.clamp(self.low_nm, self.high_nm);
        match first.stretch.class {
            Class::Downhill => torque_nm <= hold_nm.max(0.0) + TRIM_SLACK_NM,
            Class::Uphill => torque_nm >= UPHILL_SHARE * self.high_nm,
            Class::Level => match next {
                Class::Uphill => {
                    speed_mps >= set_mps + BEFORE_UPHILL_MPS || torque_nm >= hold_nm - TRIM_SLACK_NM
                }
                Class::Downhill => {
                    speed_mps <= set_mps - BEFORE_DOWNHILL_MPS
                        || torque_nm <= hold_nm + TRIM_SLACK_NM
                }
                Class::Level => true,
            },
        }
    }

    /// Constant torque over a segment; `None` when the truck would crawl.
    fn drive(&self, piece: &Piece, start: End, torque_nm: f64) -> Option<End> {
        let gear = self.request.gear;
        let force_n = self.truck.force_n(torque_nm, gear);
        let limit_j = (force_n - piece.road_n) / self.truck.drag_per_m();
        let mut end_j = limit_j + (start.energy_j - limit_j) * piece.decay;
        let mut middle_j = limit_j + (start.energy_j - limit_j) * piece.half_decay;
        if end_j < self.crawling_j || middle_j < self.crawling_j {
            return None;
        }
        let mut cost_g = start.cost_g;
        if end_j > self.max_j {
            cost_g += TOO_FAST * self.energy_gpj * (end_j - self.max_j);
            end_j = self.max_j;
        }
        if end_j < self.min_j {
            cost_g += TOO_SLOW * self.energy_gpj * (self.min_j - end_j);
        }
        middle_j = middle_j.min(self.max_j);
        let speed_mps = self.truck.speed_mps(end_j);
        let middle_mps = self.truck.speed_mps(middle_j);
        let time_s = piece.stretch.length_m / 6.0
            * (1.0 / start.speed_mps + 4.0 / middle_mps + 1.0 / speed_mps);
        let rpm = self.truck.engine_rpm(middle_mps, gear);
        let fuel_gps = self.truck.engine().fuel_gps(rpm, torque_nm + self.auxiliary_nm);
        cost_g += (fuel_gps + self.time_gps) * time_s;
        Some(End { energy_j: end_j, speed_mps, cost_g })
    }

    fn terminal_g(&self, energy_j: f64) -> f64 {
        let above_j = energy_j - self.set_j;
        self.energy_gpj * above_j * (TERMINAL_SQUARE * above_j / self.set_j - 1.0)
    }
}
