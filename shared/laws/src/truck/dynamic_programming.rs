//! Receding-horizon dynamic programming over kinetic energy, with gears.
//!
//! ```text
//! min  sum(fuel + beta t + shifts) - gamma (K_end - K_set) + q gamma (K_end - K_set)²/K_set      q = 0.5
//! ```
//!
//! K_end is that of the road's guessed continuation ([`Beyond`]), in the values alone: the plan ends at the
//! horizon. A change of torque against the present one costs a little. So the torque does not chatter between
//! levels of the grid.

use super::bounds::speed_band_mps;
use super::energy_grid::{Costs, EnergyGrid, LOWEST, PLANNED_GEARS, Stage, Values};
use super::prices::Prices;
use super::settings::{Keys, Settings};
use law::{MAX_SEGMENTS, Plan, PlanRequest, Planner, Preview};
use truck_model::Truck;

/// Weight q of the terminal cost's square, if none is set.
const TERMINAL_SQUARE: f64 = 0.5;
/// Price of a change of tractive force, g/N.
const CHANGE_GPN: f64 = 2e-5;
/// Lowest speed of the grid, as a share of the set speed (50 km/h at 75 km/h).
const LOWEST_SPEED: f64 = 50.0 / 75.0;

/// Nodes over kinetic energy.
const NODES: usize = 70;

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
    pub fn new(settings: &Settings) -> Self {
        let Settings { truck, keys, .. } = settings;
        let values = || [(); PLANNED_GEARS].map(|()| vec![0.0; NODES]);
        Self {
            truck: *truck,
            keys: *keys,
            grid: EnergyGrid::new(truck, &keys.bounds, NODES),
            prices: Prices::default(),
            laid_out_for: (0.0, 0.0),
            values: (0..=MAX_SEGMENTS + GUESSES).map(|_| values()).collect(),
        }
    }

    fn lay_out(&mut self, request: &PlanRequest) {
        let (min_speed_mps, max_speed_mps) = speed_band_mps(&self.keys.bounds, request);
        let wanted = (request.set_speed_mps, max_speed_mps);
        if self.laid_out_for != wanted {
            self.laid_out_for = wanted;
            self.prices = Prices::new(&self.truck, request.set_speed_mps);
            self.grid.span(LOWEST_SPEED * wanted.0.min(wanted.1), wanted.1);
        }
        self.grid.set_costs(Costs {
            time_gps: request.time_price * self.prices.time_gps,
            shift_g: self.prices.shift_g,
            min_speed_mps,
        });
    }

    /// Values at the horizon: those of the guessed road after it. If the map ends before the horizon, the way ends
    /// there too: nothing is guessed.
    fn values_at_horizon(&mut self, request: &PlanRequest, steps: &PlanSteps) {
        let preview = &request.preview;
        let reaches = preview.end_m() >= request.position_m + self.keys.road.horizon_m;
        let (last, guessed) = (steps.len(), if reaches { GUESSES } else { 0 });
        self.value_at_the_end(last + guessed, request.set_speed_mps);
        let road = Beyond::new(preview, request.position_m, steps.end_m());
        for step in (0..guessed).rev() {
            let stage = self.grid.stage(GUESS_M, road.grade(step));
            let (here, next) = self.values.split_at_mut(last + step + 1);
            self.grid.backward(stage, &next[0], &mut here[last + step]);
        }
    }

    fn value_at_the_end(&mut self, steps: usize, set_speed_mps: f64) {
        let set_j = self.truck.kinetic_energy_j(set_speed_mps);
        let gamma = self.prices.energy_gpj;
        let square = self.keys.plan.terminal_square.unwrap_or(TERMINAL_SQUARE);
        for values in &mut self.values[steps] {
            for (value, &energy_j) in values.iter_mut().zip(&self.grid.energy_j) {
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

/// Length of a step that begins before this distance, m: (before, length).
const LENGTHS_M: [(f64, f64); 3] = [(400.0, 50.0), (1200.0, 100.0), (f64::INFINITY, 200.0)];
/// Shortest first step, m: its torque has to act before the next plan.
const SHORTEST_M: f64 = 25.0;
/// Edges are no further apart, m: a longer cell is divided.
const LONGEST_EDGE_M: f64 = 100.0;

/// Ends of the steps of a plan, m, in order.
///
/// They end at edges of the map's cells, where the grade changes. Between edges the speed has neither peak nor dip. A
/// step over two cells hides the peak between them. The truck then brakes there at its limit although the plan does
/// not. With errors of 1 m in the heights that cost 1.3 points of fuel. Near the truck a step is a cell; later ones,
/// which are planned again before they are driven, are longer.
#[derive(Clone, Copy, Debug)]
struct PlanSteps {
    start_m: f64,
    ends_m: [f64; MAX_SEGMENTS],
    len: usize,
}

impl PlanSteps {
    /// Steps from `start_m` on, as far as the map and `horizon_m` reach.
    fn new(preview: &Preview, start_m: f64, horizon_m: f64) -> Self {
        let edge_m = preview.cell_m / (preview.cell_m / LONGEST_EDGE_M).ceil();
        let edges_to = |end_m: f64| (end_m - preview.start_m) / edge_m;
        let end_m = preview.end_m().min(start_m + horizon_m);
        let last_edge = (edges_to(end_m) + 1e-6).floor();
        let mut steps = Self { start_m, ends_m: [start_m; MAX_SEGMENTS], len: 0 };
        let mut edge = edges_to(start_m + SHORTEST_M).ceil();
        while edge <= last_edge && steps.len < MAX_SEGMENTS {
            let end_m = preview.start_m + edge_m * edge;
            steps.ends_m[steps.len] = end_m;
            steps.len += 1;
            let length_m = LENGTHS_M.iter().find(|(before_m, _)| end_m - start_m < *before_m);
            let edges = (length_m.map_or(edge_m, |(_, length_m)| *length_m) / edge_m).ceil();
            // The last step is as long as what is left.
            edge = if edge < last_edge { (edge + edges).min(last_edge) } else { edge + edges };
        }
        steps
    }

    fn len(&self) -> usize {
        self.len
    }

    /// Start and end of a step, m.
    fn step_m(&self, index: usize) -> (f64, f64) {
        let from_m = if index == 0 { self.start_m } else { self.ends_m[index - 1] };
        (from_m, self.ends_m[index])
    }

    fn end_m(&self) -> f64 {
        self.ends_m[..self.len].last().copied().unwrap_or(self.start_m)
    }
}

/// Length of a step, m.
const GUESS_M: f64 = 400.0;
/// Number of steps: another horizon.
const GUESSES: usize = 5;
/// l, m: between the tangents of hills (300 to 1500 m) and those of motorways (1500 to 5000 m).
const FADING_M: f64 = 2000.0;
/// The last grade is a mean over this length, m: two steps of a plan.
const LAST_M: f64 = 200.0;

/// The road after the horizon, as far as it is worth guessing.
///
/// The value of speed at the horizon depends on the road after it. On a descent that continues, energy is braked away.
/// A slope does not end with the map. The guess is that it fades with the length of slopes:
///
/// ```text
/// g(s) = g_last e^(-s/l)
/// ```
#[derive(Clone, Copy, Debug)]
struct Beyond<'a> {
    preview: &'a Preview,
    horizon_m: f64,
    last_grade: f64,
}

impl<'a> Beyond<'a> {
    /// Road beyond the horizon of a plan that begins at `start_m`.
    fn new(preview: &'a Preview, start_m: f64, horizon_m: f64) -> Self {
        let from_m = start_m.max(horizon_m - LAST_M);
        let last_grade = preview.mean_grade(from_m, horizon_m).unwrap_or(0.0);
        Self { preview, horizon_m, last_grade }
    }

    /// Mean grade of a step, counted from 0: the map's where it is known, else the guess.
    fn grade(&self, step: usize) -> f64 {
        let (from_m, to_m) = (GUESS_M * step as f64, GUESS_M * (step + 1) as f64);
        let known = self.preview.mean_grade(self.horizon_m + from_m, self.horizon_m + to_m);
        known.unwrap_or_else(|| {
            let left = |distance_m: f64| libm::exp(-distance_m / FADING_M);
            self.last_grade * FADING_M / GUESS_M * (left(from_m) - left(to_m))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HORIZON_M: f64 = 2000.0;

    fn lengths_m(cell_m: f64, count: usize, start_m: f64) -> Vec<f64> {
        let preview = Preview { start_m: 1000.0, cell_m, count, ..Preview::default() };
        let steps = PlanSteps::new(&preview, start_m, HORIZON_M);
        (0..steps.len()).map(|index| steps.step_m(index)).map(|(from, to)| to - from).collect()
    }

    #[test]
    fn they_end_at_edges_of_cells_and_grow_with_the_distance() {
        let lengths = lengths_m(50.0, 41, 1010.0);
        let expected = [vec![40.0], vec![50.0; 8], vec![100.0; 8], vec![200.0; 3], vec![110.0]];
        let whole: f64 = lengths.iter().sum();
        assert_eq!(lengths[..17], expected.concat()[..17]);
        assert!((1940.0..=2000.0).contains(&whole), "{lengths:?}");
    }

    #[test]
    fn the_first_one_is_never_short() {
        assert_eq!(lengths_m(50.0, 41, 1024.0)[0], 26.0);
        assert_eq!(lengths_m(50.0, 41, 1026.0)[0], 74.0);
    }

    #[test]
    fn no_map_is_too_fine_too_coarse_or_too_short() {
        for cell_m in [1.0, 7.0, 10.0, 30.0, 50.0, 80.0, 170.0, 1000.0] {
            for count in [1_u32, 2, 40, 64] {
                let lengths = lengths_m(cell_m, count as usize, 1003.0);
                let known_m = (cell_m * f64::from(count) - 3.0).clamp(0.0, HORIZON_M);
                let whole: f64 = lengths.iter().sum();
                assert!(whole <= known_m + 1e-3, "{cell_m} {count}: {lengths:?}");
                assert!(whole > known_m - 101.0, "{cell_m} {count}: {lengths:?}");
            }
        }
    }

    #[test]
    fn the_last_slope_fades_where_the_map_ends() {
        let mut preview = Preview { count: 48, ..Preview::default() };
        preview.grades[36..40].fill(-0.03);
        preview.grades[40..48].fill(-0.01);
        let beyond = Beyond::new(&preview, 0.0, 2000.0);
        assert!((beyond.grade(0) + 0.01).abs() < 1e-12, "known: {}", beyond.grade(0));
        for step in 1..GUESSES {
            let middle_m = GUESS_M * (step as f64 + 0.5);
            let expected = -0.03 * libm::exp(-middle_m / FADING_M);
            assert!((beyond.grade(step) / expected - 1.0).abs() < 5e-3, "{step}");
        }
    }
}
