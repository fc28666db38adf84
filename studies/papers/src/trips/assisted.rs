//! The law as a driver: it sees a map, its plans take effect some cycles after they were asked for.

use super::{CONTROL_PERIOD_S, Driver, Road, Seen};
use controller::law::{Ego, Input, Law, Output, Plan, Planner, Planning, Powertrain};
use controller::laws::truck::{Predictive, Settings};
use truck_model::Demand;

/// Control cycles from a request to its plan's effect, as in the real loop.
const DELAY_CYCLES: u32 = 2;
/// Distance that the map shows, m.
const REACH_M: f64 = 2000.0;

/// Road in the map, which need not be the true one.
#[derive(Clone, Debug)]
pub struct Map {
    pub road: Road,
    /// Distance by which the map shows everything ahead of its true place, m.
    pub shift_m: f64,
}

/// The predictive law with its planner.
pub struct Assisted {
    law: Predictive,
    planner: Box<dyn Planner>,
    map: Map,
    set_speed_mps: f64,
    answer: Option<(Plan, u32)>,
    output: Output,
}

impl Assisted {
    /// The law on a road that it has from `map`.
    pub fn new(settings: &Settings, set_speed_mps: f64, map: Map) -> Self {
        let law = Predictive::new(settings);
        let planner = law.planner();
        Self { law, planner, map, set_speed_mps, answer: None, output: Output::default() }
    }

    /// Mode of the law in its last cycle.
    pub fn mode(&self) -> u32 {
        self.output.mode
    }
}

impl Driver for Assisted {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let motion = seen.motion;
        let mut preview = self.map.road.preview(motion.position_m - self.map.shift_m, REACH_M);
        preview.start_m += self.map.shift_m;
        let input = Input {
            time_s: seen.time_s,
            period_s: CONTROL_PERIOD_S,
            ego: Ego {
                position_m: motion.position_m,
                speed_mps: motion.speed_mps,
                acceleration_mps2: motion.acceleration_mps2,
            },
            target: seen.target,
            powertrain: Some(Powertrain {
                gear: motion.gear,
                since_shift_s: motion.since_shift_s,
                engine_torque_nm: motion.engine_torque_nm,
                grade: seen.grade,
            }),
            preview: Some(preview),
            set_speed_mps: self.set_speed_mps,
            speed_limit_mps: f64::INFINITY,
            ..Input::default()
        };
        if let Some((plan, cycles)) = &mut self.answer {
            *cycles -= 1;
            if *cycles == 0 {
                self.law.accept(plan);
                self.answer = None;
            }
        }
        self.law.step(&input, &mut self.output);
        if self.answer.is_none()
            && let Some(request) = self.law.request()
        {
            let mut plan = Plan::default();
            self.planner.plan(&request, &mut plan);
            self.answer = Some((plan, DELAY_CYCLES));
        }
        let request = self.output.torque.unwrap_or_default();
        Demand {
            engine_torque_nm: request.engine_torque_nm,
            service_brake_n: request.service_brake_n,
            gear: request.gear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trips::drive;
    use controller::laws::truck::PlannerKind;
    use truck_model::{Preset, Truck};

    /// The lag against the set speed is the road's for a good part.
    #[test]
    fn a_climb_that_no_engine_holds_is_no_reason_to_hurry() {
        let (truck, set_mps) = (Truck::preset(Preset::Jh6At49T), 75.0 / 3.6);
        let road = Road::new(50.0, [vec![0.0; 20], vec![0.03; 100], vec![0.0; 20]].concat());
        for planner in [PlannerKind::PaperN2, PlannerKind::DynamicProgramming] {
            let map = Map { road: road.clone(), shift_m: 0.0 };
            let mut driver = Assisted::new(&Settings::new(&truck, planner), set_mps, map);
            let trip = drive(&truck, &road, set_mps, &mut driver).expect("it gets there");
            let behind_s = trip.time_s - road.length_m() / set_mps;
            assert!(behind_s > 60.0, "{planner:?}: {behind_s} s behind the set speed");
            let lag_s = driver.law.lag_s();
            assert!(lag_s.abs() < 0.6 * behind_s, "{planner:?}: {lag_s} of {behind_s} s");
        }
    }
}
