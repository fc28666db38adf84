//! The published planner: constant torques over the next n = 2 segments (steps 3 to 6).
//!
//! ```text
//! J = sum_{i<n}(fuel_i + beta t_i) - gamma (K_end - K_set) + q gamma (K_end - K_set)²/K_set      n = 2, q = 1
//! ```
//!
//! Torques are enumerated: 21 levels, and those that hold the present and the set speed. Each further segment's are
//! tried for each of those before it. The class of the road trims the first torque. K over a segment is the closed form
//! (4), time over it Simpson's rule.

use super::bounds::{Moment, speed_band_mps};
use super::prices::Prices;
use super::road_classes::{Class, LimitGrades, MOST_SEGMENTS, Reconstruction, Stretch};
use super::settings::{Keys, Settings};
use law::{Plan, PlanRequest, Planner};
use truck_model::Truck;

/// Weight q of the terminal cost's square, if none is set.
const TERMINAL_SQUARE: f64 = 1.0;
/// Penalty of energy above the highest speed, and below the lowest, as shares of the price of energy.
const TOO_FAST: f64 = 0.02;
const TOO_SLOW: f64 = 0.08;
/// Lowest speed for which the closed form is taken, m/s.
const CRAWLING_MPS: f64 = 8.0;
/// Slack of the rules that trim the first torque, N m.
const TRIM_SLACK_NM: f64 = 1.0;
/// Share of full load that is taken uphill at least. Inferred, as the next two: half and double changed no figure.
const UPHILL_SHARE: f64 = 0.25;
/// Speed above the set speed from which a coming hill asks for no more torque, and below it from which a coming dip asks
/// for no less, m/s.
const BEFORE_UPHILL_MPS: f64 = 0.5;
const BEFORE_DOWNHILL_MPS: f64 = 2.0;

#[derive(Clone, Debug)]
pub struct PaperN2 {
    truck: Truck,
    keys: Keys,
    prices: Prices,
    limits: LimitGrades,
    /// Set speed that prices and limits belong to.
    set_speed_mps: f64,
    road: Reconstruction,
    segments: Vec<Stretch>,
}

impl PaperN2 {
    pub fn new(settings: &Settings) -> Self {
        Self {
            truck: settings.truck,
            keys: settings.keys,
            prices: Prices::default(),
            limits: LimitGrades::default(),
            set_speed_mps: 0.0,
            road: Reconstruction::new(&settings.keys.road),
            segments: Vec::with_capacity(MOST_SEGMENTS),
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
        let wanted = MOST_SEGMENTS.min(self.keys.plan.segments as usize);
        self.segments.clear();
        self.segments.extend(self.road.segments().take(wanted));
        if self.segments.is_empty() || request.speed_mps < CRAWLING_MPS {
            return false;
        }
        let search = Search::new(&self.truck, &self.keys, &self.prices, request);
        let Some(best) = search.best(&self.segments) else { return false };
        let mut end_m = request.position_m;
        for (segment, (torque_nm, speed_mps)) in self.segments.iter().zip(best) {
            end_m += segment.length_m;
            plan.push(end_m, torque_nm + search.auxiliary_nm, None, speed_mps);
        }
        plan.binding = 1;
        true
    }
}

struct Search<'a> {
    truck: &'a Truck,
    keys: &'a Keys,
    request: &'a PlanRequest,
    energy_gpj: f64,
    time_gps: f64,
    terminal_square: f64,
    auxiliary_nm: f64,
    set_j: f64,
    min_j: f64,
    max_j: f64,
    crawling_j: f64,
}

/// A segment with what its closed form needs.
#[derive(Clone, Copy, Default)]
struct Piece {
    stretch: Stretch,
    road_n: f64,
    decay: f64,
    half_decay: f64,
    /// Least and largest net torque that the engine gives, N m: the ends of the levels.
    limits_nm: (f64, f64),
    /// The same within the bounds of acceleration, N m.
    low_nm: f64,
    high_nm: f64,
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

/// Torque and speed at the end, for each segment.
type Way = [(f64, f64); MOST_SEGMENTS];

impl<'a> Search<'a> {
    fn new(truck: &'a Truck, keys: &'a Keys, prices: &Prices, request: &'a PlanRequest) -> Self {
        let rpm = truck.engine_rpm(request.speed_mps, request.gear);
        let (min_mps, max_mps) = speed_band_mps(&keys.bounds, request);
        Self {
            truck,
            keys,
            request,
            energy_gpj: prices.energy_gpj,
            time_gps: request.time_price * prices.time_gps,
            terminal_square: keys.plan.terminal_square.unwrap_or(TERMINAL_SQUARE),
            auxiliary_nm: truck.auxiliary_torque_nm(rpm),
            set_j: truck.kinetic_energy_j(request.set_speed_mps),
            min_j: truck.kinetic_energy_j(min_mps),
            max_j: truck.kinetic_energy_j(max_mps),
            crawling_j: truck.kinetic_energy_j(CRAWLING_MPS),
        }
    }

    fn piece(&self, stretch: &Stretch) -> Piece {
        let PlanRequest { set_speed_mps, speed_mps, gear, .. } = *self.request;
        let decay = libm::exp(-self.truck.drag_per_m() * stretch.length_m);
        let hold_n = self.truck.resistance_n(set_speed_mps, stretch.grade);
        let bounds = &self.keys.bounds;
        let at = Moment { truck: self.truck, speed_mps, gear, grade: stretch.grade };
        let (low_nm, high_nm) = at.bounds_nm(bounds);
        let (least_nm, most_nm) = at.limits_nm(bounds);
        let net_nm = |engine_nm: f64| engine_nm - self.auxiliary_nm;
        Piece {
            stretch: *stretch,
            road_n: self.truck.road_resistance_n(stretch.grade),
            decay,
            half_decay: decay.sqrt(),
            limits_nm: (net_nm(least_nm), net_nm(most_nm)),
            low_nm: net_nm(low_nm),
            high_nm: net_nm(high_nm),
            hold_nm: self.truck.net_torque_nm(hold_n, gear),
        }
    }

    /// The cheapest way over the segments whose first torque fits them.
    fn best(&self, segments: &[Stretch]) -> Option<Way> {
        let mut pieces = [Piece::default(); MOST_SEGMENTS];
        for (piece, stretch) in pieces.iter_mut().zip(segments) {
            *piece = self.piece(stretch);
        }
        let pieces = &pieces[..segments.len()];
        let first = &pieces[0];
        let speed_mps = self.request.speed_mps;
        let energy_j = self.truck.kinetic_energy_j(speed_mps);
        let start = End { energy_j, speed_mps, cost_g: 0.0 };
        let resistance_n = self.truck.resistance_n(speed_mps, first.stretch.grade);
        let hold_now_nm = self.truck.net_torque_nm(resistance_n, self.request.gear);
        let next_class = segments.get(1).map_or(Class::Level, |stretch| stretch.class);
        let torques = self.torques_nm(first, Some(hold_now_nm));
        let fitting = torques.filter(|&torque_nm| self.fits(first, next_class, torque_nm));
        self.cheapest(pieces, 0, start, fitting).map(|(_, way)| way)
    }

    /// The cheapest way from piece `index` on with one of `torques_nm` on it: its cost, g, and the way.
    fn cheapest(
        &self,
        pieces: &[Piece],
        index: usize,
        start: End,
        torques_nm: impl Iterator<Item = f64>,
    ) -> Option<(f64, Way)> {
        let mut best = None;
        let mut least_g = f64::INFINITY;
        for torque_nm in torques_nm {
            let Some(end) = self.drive(&pieces[index], start, torque_nm) else { continue };
            let (cost_g, mut way) = match pieces.get(index + 1) {
                None => (end.cost_g + self.terminal_g(end.energy_j), Way::default()),
                Some(next) => {
                    match self.cheapest(pieces, index + 1, end, self.torques_nm(next, None)) {
                        Some(found) => found,
                        None => continue,
                    }
                }
            };
            if cost_g < least_g {
                least_g = cost_g;
                way[index] = (torque_nm, end.speed_mps);
                best = Some((cost_g, way));
            }
        }
        best
    }

    /// Torques to try on a piece, and one more.
    fn torques_nm(&self, piece: &Piece, more: Option<f64>) -> impl Iterator<Item = f64> + use<> {
        let levels = self.keys.plan.torque_levels;
        let Piece { limits_nm: (least_nm, most_nm), low_nm, high_nm, hold_nm, .. } = *piece;
        let level_nm =
            move |level| least_nm + (most_nm - least_nm) * f64::from(level) / f64::from(levels - 1);
        let torques = (0..levels).map(level_nm).chain(more).chain([hold_nm]);
        torques.map(move |torque_nm| torque_nm.clamp(low_nm, high_nm))
    }

    /// The drive type of the first segment trims its torque.
    fn fits(&self, first: &Piece, next: Class, torque_nm: f64) -> bool {
        let speed_mps = self.request.speed_mps;
        let set_mps = self.request.set_speed_mps;
        let hold_nm = first.hold_nm.clamp(first.low_nm, first.high_nm);
        match first.stretch.class {
            Class::Downhill => torque_nm <= hold_nm.max(0.0) + TRIM_SLACK_NM,
            Class::Uphill => torque_nm >= UPHILL_SHARE * first.limits_nm.1,
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
        self.energy_gpj * above_j * (self.terminal_square * above_j / self.set_j - 1.0)
    }
}
