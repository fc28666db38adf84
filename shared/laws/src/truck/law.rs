//! The law: what drives the truck at each release.
//!
//! | mode | when | torque |
//! |---|---|---|
//! | `cruise` | no plan: none arrived, it is stale, the map ends or contradicts the vehicle | keeps the set speed |
//! | `predictive` | 1: no target, or far beyond its band without risk | the plan's, within step 3's bounds |
//! | `follow` | 2 | inverse dynamics (6) of (18), between drag and full load; below the band the engine brake |
//! | `warn` | 3 | the same; what engine and engine brake cannot give, the service brakes do |
//!
//! The service brakes are the last resort. They serve when the target is too close, when much braking is needed, and
//! for the limit downhill. The published law has no brakes: it commands engine torque, and warns. The key `brakes`
//! takes them away.

use super::bounds::{Moment, SpeedKeeper, max_speed_mps, powertrain};
use super::create;
use super::following::{self, JERKS_MPS3, LastResort, Means, Mode, Spacing};
use super::prices::{Reference, Speeds, TimePrice};
use super::settings::{Keys, PlannerKind, REQUESTS_MPS2, Settings};
use super::target_filter::TargetFilter;
use super::tracking::{MapTrust, Tracking};
use super::{
    BAD_INPUT, CRUISE, FOLLOW, MAP_CONTRADICTS, NO_PLAN, PLAN, PREDICTIVE_MODE, TARGET,
    TARGET_GONE, TOO_CLOSE, WARN,
};
use law::{
    Input, Law, MAX_PLAN, Output, Plan, PlanRequest, Planner, Planning, Preview, Quality, Target,
};
use truck_model::Demand;

/// Lowest set speed that is planned for, m/s.
const PLANNED_FROM_MPS: f64 = 10.0;
/// Requests that a command carries of the plan.
const REQUESTS: usize = 50;

#[derive(Clone, Debug)]
pub struct Predictive {
    settings: Settings,
    state: State,
}

/// All state that `reset` clears.
#[derive(Clone, Debug, Default)]
struct State {
    tracking: Tracking,
    filter: TargetFilter,
    spacing_mode: Mode,
    price: TimePrice,
    trust: MapTrust,
    keeper: SpeedKeeper,
    reference: Reference,
    last_resort: LastResort,
    /// Last desired acceleration behind a target, m/s².
    wanted_mps2: Option<f64>,
    mode: u32,
    reason: u32,
    request: Option<PlanRequest>,
}

impl State {
    fn new(keys: &Keys) -> Self {
        let time_price = keys.plan.time_price.unwrap_or(keys.planner.usual_time_price());
        Self {
            filter: TargetFilter::new(&keys.filter),
            price: TimePrice::new(time_price, keys.mean_speed),
            ..Self::default()
        }
    }
}

impl Predictive {
    pub fn new(settings: &Settings) -> Self {
        Self { settings: *settings, state: State::new(&settings.keys) }
    }

    /// Lateness of the truck against its mean speed, s.
    pub fn lag_s(&self) -> f64 {
        self.state.price.lag_s
    }

    /// Books the time against that of the truck that keeps `mean_mps`.
    fn account(&mut self, input: &Input, grade: f64, mean_mps: f64, limit_mps: f64) {
        let start_mps = input.ego.speed_mps;
        let speeds = Speeds { set_mps: mean_mps, limit_mps, start_mps };
        let (truck, distance_m) = (&self.settings.truck, start_mps * input.period_s);
        let due_s = self.state.reference.advance(truck, distance_m, grade, &speeds);
        self.state.price.update(input.period_s, due_s);
    }

    /// The demand behind a target, if the target counts.
    fn behind(
        &mut self,
        input: &Input,
        at: &Moment<'_>,
        target: &Target,
        economic_mps: f64,
    ) -> Option<Demand> {
        let Keys { gap, follow: keys, .. } = &self.settings.keys;
        let speed_mps = input.ego.speed_mps;
        let target_mps = target.lead(speed_mps).speed_mps;
        let from_m = input.ego.position_m + target.gap_m.max(0.0);
        let grade = input
            .preview
            .filter(|preview| preview.is_sound() && !self.state.trust.lost)
            .and_then(|preview| preview.mean_grade(from_m, from_m + gap.slope_length_m));
        let spacing = Spacing::new(gap, speed_mps, target_mps, grade.unwrap_or(0.0));
        let mode = spacing.mode(gap, target, self.state.spacing_mode);
        self.state.spacing_mode = mode;
        let aim_mps =
            following::target_speed_mps(keys, economic_mps, target_mps, &spacing, target.gap_m);
        let means = self.state.last_resort.update(keys, mode, speed_mps, &spacing, target);
        if means == Means::Engine && mode == Mode::Predictive && aim_mps >= economic_mps {
            return None;
        }
        let wanted = following::acceleration_mps2(keys, mode, speed_mps, aim_mps, &spacing, target);
        let before = self.state.wanted_mps2.unwrap_or(input.ego.acceleration_mps2);
        let [down, up] = [JERKS_MPS3.0, JERKS_MPS3.1].map(|jerk| jerk * input.period_s);
        let eased = wanted.clamp(before - down, before + up);
        self.state.wanted_mps2 = Some(eased);
        let acceleration_mps2 = match means {
            Means::ServiceBrake(least_mps2) => least_mps2.min(eased),
            Means::Engine | Means::EngineBrake => eased,
        };
        let mut demand = at.demand(acceleration_mps2);
        let (drag_nm, full_nm) = at.engine_nm();
        demand.engine_torque_nm = demand.engine_torque_nm.min(full_nm);
        if !matches!(means, Means::ServiceBrake(_)) {
            demand.service_brake_n = 0.0;
        }
        if means == Means::Engine {
            demand.engine_torque_nm = demand.engine_torque_nm.max(drag_nm);
        }
        Some(demand)
    }

    /// Writes the demand and the accelerations that go with it.
    fn write(&self, input: &Input, at: &Moment<'_>, demand: &Demand, output: &mut Output) {
        let Moment { truck, speed_mps, gear, grade } = *at;
        let rpm = truck.engine_rpm(speed_mps, gear);
        let net_nm = demand.engine_torque_nm - truck.auxiliary_torque_nm(rpm);
        let force_n = truck.force_n(net_nm, gear)
            - demand.service_brake_n
            - truck.resistance_n(speed_mps, grade);
        let (low, high) = REQUESTS_MPS2;
        let bounded = |mps2: f64| mps2.clamp(low, high);
        output.set_request(bounded(force_n / truck.inertial_mass_kg()));
        output.torque = Some(*demand);
        if self.state.mode != PREDICTIVE_MODE {
            return;
        }
        // The rest of the plan, by the plan's own speeds.
        let plan = &self.state.tracking.plan;
        let (mut position_m, mut speed_mps) = (input.ego.position_m, speed_mps);
        for request in 1..REQUESTS.min(MAX_PLAN) {
            position_m += speed_mps * input.period_s;
            let Some(index) = plan.segment_at(position_m) else { break };
            speed_mps = plan.speed_mps(index, position_m);
            output.plan_mps2[request] = bounded(plan.acceleration_mps2(index));
            output.plan_len = request + 1;
        }
    }

    fn enter(&mut self, mode: u32, reason: u32) {
        if self.state.mode != mode {
            self.state.reason = reason;
        }
        self.state.mode = mode;
    }
}

impl Law for Predictive {
    fn reset(&mut self) {
        self.state = State::new(&self.settings.keys);
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        *output = Output::default();
        self.state.request = None;
        let Some(input) = &input.sound() else {
            output.quality = Quality::Backup;
            output.mode = CRUISE;
            output.mode_reason = BAD_INPUT;
            return;
        };
        let Settings { truck, keys } = self.settings;
        let (ego, dt_s, set_mps) = (&input.ego, input.period_s, input.set_speed_mps);
        let preview = input.preview.filter(Preview::is_sound);
        let map_grade = preview.and_then(|preview| preview.grade(ego.position_m));
        let powertrain = powertrain(&truck, input, map_grade);
        let (gear, grade) = (powertrain.gear, powertrain.grade);
        let at = Moment { truck: &truck, speed_mps: ego.speed_mps, gear, grade };
        self.state.trust.update(map_grade, grade, dt_s);
        // Noise alone makes no target at the edge of its range come and go.
        let farthest_m = keys.gap.no_target_m + keys.filter.gate * keys.filter.gap_sigma_m;
        let target = input.target.as_ref().filter(|target| target.gap_m <= farthest_m);
        let target = self.state.filter.update(target, ego.acceleration_mps2, dt_s);

        let distrusted = self.state.trust.lost;
        if distrusted {
            self.state.tracking.plan.len = 0;
        }
        let guidance = self.state.tracking.guidance(input);
        let economic_mps = guidance.map_or(set_mps, |guidance| guidance.speed_mps);
        let behind = match &target {
            Some(target) => self.behind(input, &at, target, economic_mps),
            None => {
                self.state.spacing_mode = Mode::Predictive;
                self.state.last_resort = LastResort::default();
                None
            }
        };
        if behind.is_none() {
            self.state.wanted_mps2 = None;
        }
        let demand = match (behind, guidance) {
            (Some(demand), _) => {
                match self.state.spacing_mode {
                    Mode::Warn => self.enter(WARN, TOO_CLOSE),
                    Mode::Follow | Mode::Predictive => self.enter(FOLLOW, TARGET),
                }
                demand
            }
            (None, Some(guidance)) => {
                let reason = if self.state.mode >= FOLLOW { TARGET_GONE } else { PLAN };
                self.enter(PREDICTIVE_MODE, reason);
                let planned_nm = guidance.segment.engine_torque_nm;
                let torque_nm = at.guarded_nm(&keys, input, planned_nm);
                Demand { gear: guidance.segment.gear, ..Demand::torque(torque_nm) }
            }
            (None, None) => {
                self.enter(CRUISE, if distrusted { MAP_CONTRADICTS } else { NO_PLAN });
                Demand::torque(self.state.keeper.torque_nm(&at, set_mps, dt_s))
            }
        };
        if self.state.mode != CRUISE {
            self.state.keeper = SpeedKeeper::default();
        }
        let limit_mps = max_speed_mps(&keys.bounds, set_mps, input.speed_limit_mps);
        if self.state.mode == PREDICTIVE_MODE {
            self.account(input, grade, keys.mean_speed * set_mps, limit_mps);
        } else {
            self.state.reference = Reference::default();
        }
        let demand = at.permitted(at.limited(demand, limit_mps), keys.brakes);
        self.write(input, &at, &demand, output);

        let price = self.state.price.value();
        if let Some(preview) = preview
            && !distrusted
            && set_mps >= PLANNED_FROM_MPS
        {
            self.state.request =
                self.state.tracking.request(input, &powertrain, &preview, price, guidance.as_ref());
        }
        output.mode = self.state.mode;
        output.mode_reason = self.state.reason;
        if self.state.mode == CRUISE && keys.planner != PlannerKind::ConstantSpeed {
            output.quality = Quality::Relaxed;
        }
        output.figures = [
            economic_mps,
            demand.engine_torque_nm,
            gear as f64 + 1.0,
            price,
            self.state.price.lag_s,
            target.map_or(0.0, |target| target.gap_m),
            demand.service_brake_n,
            self.state.tracking.plan.end_m() - ego.position_m,
        ];
        output.bound_figures();
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        REQUESTS_MPS2
    }

    fn planning(&mut self) -> Option<&mut dyn Planning> {
        (self.settings.keys.planner != PlannerKind::ConstantSpeed).then_some(self)
    }
}

impl Planning for Predictive {
    fn planner(&self) -> Box<dyn Planner> {
        create(&self.settings)
    }

    fn request(&mut self) -> Option<PlanRequest> {
        self.state.request.take()
    }

    fn accept(&mut self, plan: &Plan) {
        self.state.tracking.accept(plan);
    }
}
