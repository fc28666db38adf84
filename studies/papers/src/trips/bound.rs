//! The bound: a dynamic program over the whole route, driven.

use super::{CONTROL_PERIOD_S, Driver, Road, Seen};
use controller::laws::truck::energy_grid::{Costs, EnergyGrid, LOWEST, PLANNED_GEARS, Values};
use controller::laws::truck::{BoundKeys, Prices, SpeedKeeper, min_speed_mps};
use truck_model::{Demand, Truck};

/// Lowest speed of the grid, as a share of the set speed.
const SLOWEST_SPEED: f64 = 45.0 / 75.0;
/// Length of a step, m: no grade changes within one on a road of 50 m cells.
const STEP_M: f64 = 50.0;

/// Knows the whole road and the values on it.
#[derive(Clone, Debug)]
pub struct Bound {
    truck: Truck,
    grid: EnergyGrid,
    limit_mps: f64,
    road: Road,
    values: Vec<Values>,
    step: usize,
    demand: Demand,
}

impl Bound {
    /// Solves the route, with `nodes` over kinetic energy and a price of time of `time_price` times the
    /// flat's. The trip ends at the value of its kinetic energy.
    pub fn solve(
        truck: &Truck,
        road: &Road,
        set_speed_mps: f64,
        limit_mps: f64,
        time_price: f64,
        nodes: usize,
    ) -> Self {
        let prices = Prices::new(truck, set_speed_mps);
        let mut grid = EnergyGrid::new(truck, &BoundKeys::default(), nodes);
        grid.span(SLOWEST_SPEED * set_speed_mps, limit_mps);
        grid.set_costs(Costs {
            time_gps: time_price * prices.time_gps,
            shift_g: prices.shift_g,
            min_speed_mps: min_speed_mps(&BoundKeys::default(), set_speed_mps),
        });
        let road = Road::new(STEP_M, stages(road));
        let steps = road.grades().len();
        let empty = || [(); PLANNED_GEARS].map(|()| vec![0.0; nodes]);
        let mut values: Vec<Values> = (0..=steps).map(|_| empty()).collect();
        for gear in &mut values[steps] {
            for (value, &energy_j) in gear.iter_mut().zip(&grid.energy_j) {
                *value = -prices.energy_gpj * energy_j;
            }
        }
        for step in (0..steps).rev() {
            let stage = grid.stage(STEP_M, road.grades()[step]);
            let (here, next) = values.split_at_mut(step + 1);
            grid.backward(stage, &next[0], &mut here[step]);
        }
        let demand = Demand::default();
        Self { truck: *truck, grid, limit_mps, road, values, step: usize::MAX, demand }
    }

    fn decide(&mut self, seen: &Seen<'_>) {
        let motion = seen.motion;
        let last = self.road.grades().len() - 1;
        let end_m = (self.step + 1) as f64 * STEP_M;
        let left_m = (end_m - motion.position_m).max(1.0);
        let stage = self.grid.stage(left_m, self.road.grades()[self.step]);
        let (low_j, _) = self.grid.range_j();
        let energy_j = self.truck.kinetic_energy_j(motion.speed_mps);
        let next = &self.values[self.step.min(last) + 1];
        let gear = motion.gear.max(LOWEST);
        let choice = if energy_j < low_j {
            None
        } else {
            self.grid.choose(stage, energy_j, gear, next, (0.0, 0.0))
        };
        self.demand = match choice {
            Some(choice) => {
                let rpm = self.truck.engine_rpm(motion.speed_mps, choice.gear);
                let net_nm = self.truck.net_torque_nm(choice.force_n, choice.gear);
                Demand {
                    engine_torque_nm: net_nm + self.truck.auxiliary_torque_nm(rpm),
                    service_brake_n: 0.0,
                    gear: Some(choice.gear),
                }
            }
            None => Demand::torque(f64::MAX),
        };
    }
}

/// Mean grades of steps of [`STEP_M`]; the road's end may be cut short by less than a step.
fn stages(road: &Road) -> Vec<f64> {
    let per_step = (STEP_M / road.cell_m()).round().max(1.0) as usize;
    road.grades().chunks(per_step).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
}

impl Driver for Bound {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let last = self.road.grades().len() - 1;
        let step = ((seen.motion.position_m / STEP_M) as usize).min(last);
        if step != self.step {
            self.step = step;
            self.decide(seen);
        }
        seen.moment(&self.truck).limited(self.demand, self.limit_mps)
    }
}

/// PI cruise at constant speed; it brakes above its limit only.
#[derive(Clone, Debug)]
pub struct Cruise {
    truck: Truck,
    set_speed_mps: f64,
    limit_mps: f64,
    keeper: SpeedKeeper,
}

impl Cruise {
    /// A cruise control with a set speed and a limit.
    pub fn new(truck: &Truck, set_speed_mps: f64, limit_mps: f64) -> Self {
        Self { truck: *truck, set_speed_mps, limit_mps, keeper: SpeedKeeper::default() }
    }
}

impl Driver for Cruise {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let at = seen.moment(&self.truck);
        let torque_nm = self.keeper.torque_nm(&at, self.set_speed_mps, CONTROL_PERIOD_S);
        at.limited(Demand::torque(torque_nm), self.limit_mps)
    }
}
