//! Receding-horizon dynamic programming over kinetic energy, with gears.
//!
//! ```text
//! min  sum(fuel + beta t + shifts) - gamma (K_end - K_set) + q gamma (K_end - K_set)²/K_set      q = 0.5
//! ```
//!
//! K_end is that of the road's guessed continuation (`beyond`), in the values alone: the plan ends at the
//! horizon. A change of torque against the present one costs a little. So the torque does not chatter between
//! levels of the grid.

use super::beyond::{self, Beyond};
use super::energy_grid::{Costs, EnergyGrid, LOWEST, PLANNED_GEARS, SLOWNESS_GPM, Stage, Values};
use super::plan_steps::PlanSteps;
use super::prices::Prices;
use super::settings::{Keys, Settings};
use super::speed_band::SpeedBand;
use crate::law::{MAX_SEGMENTS, Plan, PlanRequest, Planner};
use truck_model::Truck;

/// Weight q of the terminal cost's square, if none is set.
const TERMINAL_SQUARE: f64 = 0.5;
/// Price of a change of tractive force, g/N.
const CHANGE_GPN: f64 = 2e-5;
/// Lowest speed of the grid, as a share of the set speed (50 km/h at 75 km/h).
const LOWEST_SPEED: f64 = 50.0 / 75.0;

/// Nodes over kinetic energy.
const NODES: usize = 70;

/// The planner.
#[derive(Clone, Debug)]
pub struct DynamicProgramming {
    truck: Truck,
    keys: Keys,
    grid: EnergyGrid,
    prices: Prices,
    /// Set and highest speed that the grid is laid out for.
    laid_out_for: (f64, f64),
    values: Vec<Values>,
}

impl DynamicProgramming {
    /// A planner of these settings.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        let Settings { truck, keys, .. } = settings;
        let values = || [(); PLANNED_GEARS].map(|()| vec![0.0; NODES]);
        Self {
            truck: *truck,
            keys: *keys,
            grid: EnergyGrid::new(truck, &keys.bounds, NODES),
            prices: Prices::default(),
            laid_out_for: (0.0, 0.0),
            values: (0..=MAX_SEGMENTS + beyond::STEPS).map(|_| values()).collect(),
        }
    }

    fn lay_out(&mut self, request: &PlanRequest) {
        let band = SpeedBand::of(&self.keys.bounds, request);
        let wanted = (request.set_speed_mps, band.max_mps);
        if self.laid_out_for != wanted {
            self.laid_out_for = wanted;
            self.prices = Prices::new(&self.truck, request.set_speed_mps);
            self.grid.span(LOWEST_SPEED * wanted.0.min(wanted.1), wanted.1);
        }
        self.grid.set_costs(Costs {
            time_gps: request.time_price * self.prices.time_gps,
            shift_g: self.prices.shift_g,
            slow_gpm: SLOWNESS_GPM,
            min_speed_mps: band.min_mps,
        });
    }

    /// Values at the horizon: those of the guessed road after it. If the map ends before the horizon, the way ends
    /// there too: nothing is guessed.
    fn values_at_horizon(&mut self, request: &PlanRequest, steps: &PlanSteps) {
        let preview = &request.preview;
        let reaches = preview.end_m() >= request.position_m + self.keys.road.horizon_m;
        let (last, guessed) = (steps.len(), if reaches { beyond::STEPS } else { 0 });
        self.value_at_the_end(last + guessed, request.set_speed_mps);
        let road = Beyond::new(preview, request.position_m, steps.end_m());
        for step in (0..guessed).rev() {
            let stage = self.grid.stage(beyond::STEP_M, road.grade(step));
            let (here, next) = self.values.split_at_mut(last + step + 1);
            self.grid.backward(stage, &next[0], &mut here[last + step]);
        }
    }

    fn value_at_the_end(&mut self, steps: usize, set_speed_mps: f64) {
        let set_j = self.truck.kinetic_energy_j(set_speed_mps);
        let gamma = self.prices.energy_gpj;
        let square = self.keys.plan.terminal_square.unwrap_or(TERMINAL_SQUARE);
        for values in &mut self.values[steps] {
            for (value, &energy_j) in values.iter_mut().zip(self.grid.energies_j()) {
                let above_j = energy_j - set_j;
                *value = gamma * above_j * (square * above_j / set_j - 1.0);
            }
        }
    }

    /// Follows the values from the truck's state to the horizon.
    fn roll_out(&mut self, request: &PlanRequest, steps: &PlanSteps, plan: &mut Plan) -> bool {
        let mut energy_j = self.truck.kinetic_energy_j(request.speed_mps);
        let mut gear = request.gear;
        let rpm = self.truck.engine_rpm(request.speed_mps, gear);
        let net_nm = request.engine_torque_nm - self.truck.auxiliary_torque_nm(rpm);
        let mut force_n = self.truck.force_n(net_nm, gear);
        for step in 0..steps.len() {
            let Some(stage) = self.stage(request, steps, step) else { return false };
            let (_, end_m) = steps.step_m(step);
            let next = &self.values[step + 1];
            let before = (force_n, CHANGE_GPN);
            let Some(choice) = self.grid.choose(stage, energy_j, gear, next, before) else {
                return false;
            };
            let mean_mps = self.truck.speed_mps(0.5 * (energy_j + choice.end_j));
            (gear, force_n, energy_j) = (choice.gear, choice.force_n, choice.end_j);
            let rpm = self.truck.engine_rpm(mean_mps, gear);
            let torque_nm =
                self.truck.net_torque_nm(force_n, gear) + self.truck.auxiliary_torque_nm(rpm);
            plan.push(end_m, torque_nm, Some(gear), self.truck.speed_mps(energy_j));
        }
        true
    }

    fn stage(&self, request: &PlanRequest, steps: &PlanSteps, step: usize) -> Option<Stage> {
        let (from_m, to_m) = steps.step_m(step);
        let grade = request.preview.mean_grade(from_m, to_m)?;
        Some(self.grid.stage(to_m - from_m, grade))
    }
}

impl Planner for DynamicProgramming {
    fn plan(&mut self, request: &PlanRequest, plan: &mut Plan) -> bool {
        plan.begin(request);
        let steps = PlanSteps::new(&request.preview, request.position_m, self.keys.road.horizon_m);
        if steps.len() == 0 {
            return false;
        }
        self.lay_out(request);
        let (low_j, high_j) = self.grid.range_j();
        let energy_j = self.truck.kinetic_energy_j(request.speed_mps);
        if !(low_j..=1.05 * high_j).contains(&energy_j) || request.gear < LOWEST {
            return false;
        }
        self.values_at_horizon(request, &steps);
        for step in (1..steps.len()).rev() {
            let Some(stage) = self.stage(request, &steps, step) else { return false };
            let (here, next) = self.values.split_at_mut(step + 1);
            self.grid.backward(stage, &next[0], &mut here[step]);
        }
        let done = self.roll_out(request, &steps, plan);
        if done {
            plan.binding = 1;
        } else {
            plan.len = 0;
        }
        done
    }
}
