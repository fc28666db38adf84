//! The grid over kinetic energy on which both dynamic programs work.
//!
//! Inverse dynamic programming: from node i a step of length ds to node j needs the tractive force
//!
//! ```text
//! F = (K_j - K_i)/ds + R + c (K_i + K_j)/2            R = m g (f cos a + sin a)
//! ```
//!
//! (equation 1, trapezoidal in K) and costs fuel(F) ds + beta ds (1/v_i + 1/v_j)/2. All that depends on a node alone is
//! in tables. The fuel over force is left, which is a polynomial (`gear_curve`). So a step between two nodes costs a
//! handful of multiplications, and several are made side by side.

use super::gear_curve::GearCurve;
use super::settings::BoundKeys;
use truck_model::{GEARS, Truck};

/// Gears that are planned with: the highest ones.
pub const PLANNED_GEARS: usize = 3;
/// The lowest of them.
pub const LOWEST: usize = GEARS - PLANNED_GEARS;
/// Price of being slower than the lowest desired speed, g/s per m/s: a soft bound.
const SLOWNESS_GPM: f64 = 1.0;
/// Cost of what cannot be.
pub const NEVER: f64 = 1e18;

/// Cost of a step in addition to fuel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Costs {
    /// beta, g/s.
    pub time_gps: f64,
    pub shift_g: f64,
    pub min_speed_mps: f64,
}

impl Costs {
    /// Half of a step's cost that belongs to one of its ends, g/m.
    fn at_end_gpm(&self, speed_mps: f64) -> f64 {
        let slow_mps = (self.min_speed_mps - speed_mps).max(0.0);
        0.5 * (self.time_gps + SLOWNESS_GPM * slow_mps) / speed_mps
    }
}

/// One step of the road.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    pub length_m: f64,
    /// R, N.
    pub road_n: f64,
}

/// The best first step from somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    pub cost_g: f64,
    /// Kinetic energy at the step's end, J.
    pub end_j: f64,
    /// Tractive force, N; below what the engine's drag gives where brakes must help.
    pub force_n: f64,
    /// Gear, counted from 0.
    pub gear: usize,
}

/// Values at one place: cost to the end of the road, by gear and node, g.
pub type Values = [Vec<f64>; PLANNED_GEARS];

/// Nodes that are looked at side by side.
const LANES: usize = 4;

/// Grid, equidistant in kinetic energy.
#[derive(Clone, Debug)]
pub struct EnergyGrid {
    truck: Truck,
    bounds: BoundKeys,
    /// Energies of the nodes, in ascending order, J.
    pub energy_j: Vec<f64>,
    speed_mps: Vec<f64>,
    end_cost_gpm: Vec<f64>,
    curves: [Vec<GearCurve>; PLANNED_GEARS],
    costs: Costs,
    /// Numbers of the nodes, and `LANES` more.
    number: Vec<f64>,
    /// Values at a step's end with the half of its cost that belongs there, and `LANES` that never are.
    ahead: Vec<f64>,
}

impl EnergyGrid {
    /// A grid of `nodes` without place yet: see [`span`](Self::span).
    pub fn new(truck: &Truck, bounds: &BoundKeys, nodes: usize) -> Self {
        let empty = vec![0.0; nodes];
        Self {
            truck: *truck,
            bounds: *bounds,
            energy_j: empty.clone(),
            speed_mps: empty.clone(),
            end_cost_gpm: empty,
            curves: [(); PLANNED_GEARS].map(|()| vec![GearCurve::default(); nodes]),
            costs: Costs::default(),
            number: (0..nodes + LANES).map(|node| node as f64).collect(),
            ahead: vec![NEVER; nodes + LANES],
        }
    }

    /// Lays the nodes between two speeds.
    pub fn span(&mut self, low_mps: f64, high_mps: f64) {
        let low_j = self.truck.kinetic_energy_j(low_mps);
        let high_j = self.truck.kinetic_energy_j(high_mps);
        let step_j = (high_j - low_j) / (self.len() - 1) as f64;
        for node in 0..self.len() {
            let energy_j = low_j + step_j * node as f64;
            let speed_mps = self.truck.speed_mps(energy_j);
            self.energy_j[node] = energy_j;
            self.speed_mps[node] = speed_mps;
            for (index, curves) in self.curves.iter_mut().enumerate() {
                curves[node] = GearCurve::new(&self.bounds, &self.truck, speed_mps, LOWEST + index);
            }
        }
        self.set_costs(self.costs);
    }

    pub fn set_costs(&mut self, costs: Costs) {
        self.costs = costs;
        for (cost, &speed_mps) in self.end_cost_gpm.iter_mut().zip(&self.speed_mps) {
            *cost = costs.at_end_gpm(speed_mps);
        }
    }

    #[expect(clippy::len_without_is_empty, reason = "a grid has nodes")]
    pub fn len(&self) -> usize {
        self.energy_j.len()
    }

    /// Lowest and highest energy, J.
    pub fn range_j(&self) -> (f64, f64) {
        (self.energy_j[0], self.energy_j[self.len() - 1])
    }

    pub fn stage(&self, length_m: f64, grade: f64) -> Stage {
        Stage { length_m, road_n: self.truck.road_resistance_n(grade) }
    }

    /// One step backwards: from the values at its end to those at its start.
    pub fn backward(&mut self, stage: Stage, next: &Values, here: &mut Values) {
        let nodes = self.len();
        for gear in 0..PLANNED_GEARS {
            self.look_ahead(stage, &next[gear], 0, nodes - 1);
            for (node, value) in here[gear].iter_mut().enumerate() {
                let curve = &self.curves[gear][node];
                *value = if curve.usable {
                    let line = self.line(stage, self.energy_j[node]);
                    stage.length_m * self.end_cost_gpm[node] + self.least(&line, curve)
                } else {
                    NEVER
                };
            }
        }
        let [low, middle, high] = here;
        for ((low, middle), high) in low.iter_mut().zip(middle).zip(high) {
            let with_shift = low.min(*middle).min(*high) + self.costs.shift_g;
            *low = low.min(with_shift);
            *middle = middle.min(with_shift);
            *high = high.min(with_shift);
        }
    }

    /// Fills `ahead` from node `first` to `last`.
    fn look_ahead(&mut self, stage: Stage, next: &[f64], first: usize, last: usize) {
        let ends = &self.end_cost_gpm[first..=last];
        let ahead = &mut self.ahead[first..=last];
        for ((ahead, value), end) in ahead.iter_mut().zip(&next[first..=last]).zip(ends) {
            *ahead = value + stage.length_m * end;
        }
    }

    /// Least cost of a step, without that of its start.
    #[inline]
    fn least(&self, line: &ForceLine, curve: &GearCurve) -> f64 {
        let (lowest, highest) = line.reach(curve);
        let last = highest as usize;
        let most_n = line.at(last as f64 + 0.5);
        let mut lanes = [NEVER; LANES];
        let mut start = rounded_up(lowest).min(last);
        while start <= last {
            let values = &self.ahead[start..start + LANES];
            let numbers = &self.number[start..start + LANES];
            for ((lane, value), number) in lanes.iter_mut().zip(values).zip(numbers) {
                let force_n = line.at(*number);
                let cost = value + line.length_m * curve.fuel_gpm(force_n);
                // Nodes past the last one fill the lanes only.
                let cost = if force_n > most_n { NEVER } else { cost };
                *lane = if cost < *lane { cost } else { *lane };
            }
            start += LANES;
        }
        let mut least = lanes[0].min(lanes[1]).min(lanes[2]).min(lanes[3]);
        // Full load and drag themselves, between the nodes.
        for place in [lowest, highest] {
            let cost = self.ahead_at(place) + line.length_m * curve.fuel_gpm(line.at(place));
            least = if cost < least { cost } else { least };
        }
        least
    }

    /// `ahead` between nodes, linear.
    #[inline]
    fn ahead_at(&self, place: f64) -> f64 {
        let index = (place as usize).min(self.len() - 2);
        let share = place - index as f64;
        self.ahead[index] + share * (self.ahead[index + 1] - self.ahead[index])
    }

    /// The best step from any energy, in any gear, not only from node to node. A change of force from
    /// `before_n` costs `change_gpn` per newton.
    pub fn choose(
        &mut self,
        stage: Stage,
        energy_j: f64,
        gear: usize,
        next: &Values,
        (before_n, change_gpn): (f64, f64),
    ) -> Option<Choice> {
        let speed_mps = self.truck.speed_mps(energy_j);
        let line = self.line(stage, energy_j);
        let mut best: Option<Choice> = None;
        for (index, next) in next.iter().enumerate() {
            let curve = GearCurve::new(&self.bounds, &self.truck, speed_mps, LOWEST + index);
            if !curve.usable {
                continue;
            }
            let (lowest, highest) = line.reach(&curve);
            let from = (lowest as usize).min(self.len() - 2);
            let to = (highest as usize + 1).clamp(from + 1, self.len() - 1);
            self.look_ahead(stage, next, from, to);
            let shift_g = if LOWEST + index == gear { 0.0 } else { self.costs.shift_g };
            let mut consider = |place: f64| {
                let force_n = line.at(place);
                let cost_g = self.ahead_at(place)
                    + shift_g
                    + stage.length_m * curve.fuel_gpm(force_n)
                    + change_gpn * (force_n - before_n).abs();
                if best.is_none_or(|best| cost_g < best.cost_g) {
                    let end_j = self.energy_j[0] + self.step_j() * place;
                    best = Some(Choice { cost_g, end_j, force_n, gear: LOWEST + index });
                }
            };
            consider(lowest);
            consider(highest);
            let before = line.place(before_n);
            if before > lowest && before < highest {
                consider(before);
            }
            for node in rounded_up(lowest)..=highest as usize {
                consider(self.number[node]);
            }
        }
        best.filter(|best| best.cost_g < 0.5 * NEVER)
    }

    fn step_j(&self) -> f64 {
        self.energy_j[1] - self.energy_j[0]
    }

    /// Force over the node that a step from `energy_j` ends at.
    #[inline]
    fn line(&self, stage: Stage, energy_j: f64) -> ForceLine {
        let half_drag = 0.5 * self.truck.drag_per_m();
        let per_m = 1.0 / stage.length_m;
        let per_joule = per_m + half_drag;
        let per_node_n = per_joule * self.step_j();
        ForceLine {
            length_m: stage.length_m,
            base_n: stage.road_n + energy_j * (half_drag - per_m) + per_joule * self.energy_j[0],
            per_node_n,
            nodes_per_n: 1.0 / per_node_n,
            top: self.number[self.len() - 1],
        }
    }
}

/// Tractive force of a step, linear in the number of the node that it ends at.
struct ForceLine {
    length_m: f64,
    base_n: f64,
    per_node_n: f64,
    nodes_per_n: f64,
    top: f64,
}

impl ForceLine {
    #[inline]
    fn at(&self, place: f64) -> f64 {
        self.base_n + self.per_node_n * place
    }

    #[inline]
    fn place(&self, force_n: f64) -> f64 {
        (force_n - self.base_n) * self.nodes_per_n
    }

    /// Places that the engine can reach. If drag alone is too fast, that is the top, with brakes; if full load is too
    /// slow, the bottom.
    #[inline]
    fn reach(&self, curve: &GearCurve) -> (f64, f64) {
        let lowest = self.place(curve.min_n).clamp(0.0, self.top);
        (lowest, self.place(curve.max_n).clamp(lowest, self.top))
    }
}

/// The next whole number; `place` is in range and not negative.
#[inline]
fn rounded_up(place: f64) -> usize {
    let whole = place as i32;
    (whole + i32::from(place > f64::from(whole))) as usize
}
