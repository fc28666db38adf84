//! The map ends, is late, describes another road, or is not a map. The law drives plain cruise, and never invents a
//! slope.

use crate::roads::{SET_MPS, generated};
use controller::law::{
    Ego, Input, Law, Output, Plan, PlanRequest, Planner, Planning, Powertrain, Preview, Quality,
};
use controller::laws::truck::{PlannerKind, Predictive, Settings};
use papers::trips::{Assisted, Map, Road, drive};
use truck_model::{Preset, Truck};

const CRUISE: u32 = 0;
const PREDICTIVE: u32 = 1;

fn truck() -> Truck {
    Truck::preset(Preset::Jh6At49T)
}

/// State at 20 m/s since the start, on a flat road, with this map.
fn input(step: u32, preview: Option<Preview>) -> Input {
    let time_s = 0.1 * f64::from(step);
    Input {
        time_s,
        period_s: 0.1,
        ego: Ego { position_m: 20.0 * time_s, speed_mps: 20.0, acceleration_mps2: 0.0 },
        powertrain: Some(Powertrain {
            gear: 5,
            since_shift_s: 30.0,
            engine_torque_nm: 800.0,
            grade: 0.0,
        }),
        preview,
        set_speed_mps: SET_MPS,
        speed_limit_mps: f64::INFINITY,
        ..Input::default()
    }
}

fn flat(count: usize, grade: f64) -> Preview {
    Preview { start_m: 0.0, cell_m: 50.0, grades: [grade; 64], count }
}

struct Loop {
    law: Predictive,
    planner: Box<dyn Planner>,
    plan: Plan,
    output: Output,
}

impl Loop {
    fn new() -> Self {
        let law = Predictive::new(&Settings::new(&truck(), PlannerKind::DynamicProgramming));
        let planner = law.planner();
        Self { law, planner, plan: Plan::default(), output: Output::default() }
    }

    fn step(&mut self, input: &Input) -> &Output {
        self.law.step(input, &mut self.output);
        if let Some(request) = self.law.request() {
            self.planner.plan(&request, &mut self.plan);
            self.law.accept(&self.plan);
        }
        &self.output
    }
}

#[test]
fn without_a_map_it_cruises_and_says_so() {
    let mut cruise = Loop::new();
    for step in 0..50 {
        let output = cruise.step(&input(step, None));
        assert_eq!((output.mode, output.quality), (CRUISE, Quality::Relaxed));
        assert!(output.request_mps2() > 0.0, "below its set speed it accelerates");
    }
}

#[test]
fn a_map_that_ends_is_used_to_its_end_and_no_further() {
    let mut law = Loop::new();
    let map = flat(20, 0.0);
    for step in 0..480 {
        let output = law.step(&input(step, Some(map)));
        let left_m = map.end_m() - 2.0 * f64::from(step);
        if step > 1 && left_m > 120.0 {
            assert_eq!(output.mode, PREDICTIVE, "{left_m} m before the end");
        }
        if left_m < 0.0 {
            assert_eq!(output.mode, CRUISE, "{left_m} m before the end");
        }
    }
}

#[test]
fn a_map_of_another_road_is_not_used() {
    let mut law = Loop::new();
    // The vehicle feels no slope; the map has two percent.
    let mut modes = Vec::new();
    for step in 0..300 {
        let mut map = flat(60, 0.02);
        map.start_m = 20.0 * 0.1 * f64::from(step);
        modes.push(law.step(&input(step, Some(map))).mode);
    }
    assert_eq!(modes[2], PREDICTIVE);
    assert!(modes[150..].iter().all(|mode| *mode == CRUISE), "{modes:?}");
}

#[test]
fn a_map_that_is_not_a_road_counts_as_no_map() {
    for spoil in [
        (|map| map.count = 0) as fn(&mut Preview),
        |map| map.count = 65,
        |map| map.cell_m = 0.0,
        |map| map.grades[3] = f64::NAN,
        |map| map.grades[3] = 0.5,
        |map| map.start_m = f64::INFINITY,
        |map| map.start_m = 1e6,
    ] {
        let mut law = Loop::new();
        for step in 0..5 {
            let mut map = flat(40, 0.0);
            spoil(&mut map);
            let output = law.step(&input(step, Some(map)));
            assert_eq!(output.mode, CRUISE, "{map:?}");
        }
    }
}

#[test]
fn a_planner_that_never_answers_leaves_a_cruise_control() {
    let mut law = Predictive::new(&Settings::new(&truck(), PlannerKind::DynamicProgramming));
    let mut output = Output::default();
    let mut asked = 0;
    for step in 0..100 {
        law.step(&input(step, Some(flat(64, 0.0))), &mut output);
        asked += u32::from(law.request().is_some());
        assert_eq!(output.mode, CRUISE);
    }
    assert!((9..=11).contains(&asked), "asked again every second: {asked} times in ten");
}

#[test]
fn old_answers_and_answers_that_no_request_asked_for_are_not_taken() {
    let mut law = Predictive::new(&Settings::new(&truck(), PlannerKind::DynamicProgramming));
    let mut planner = law.planner();
    let mut output = Output::default();
    let mut plan = Plan::default();
    let foreign = PlanRequest {
        number: 77,
        speed_mps: 20.0,
        gear: 5,
        set_speed_mps: SET_MPS,
        speed_limit_mps: f64::INFINITY,
        time_price: 1.0,
        preview: flat(64, 0.0),
        ..PlanRequest::default()
    };
    assert!(planner.plan(&foreign, &mut plan));
    law.step(&input(0, Some(flat(64, 0.0))), &mut output);
    law.accept(&plan);
    law.step(&input(1, Some(flat(64, 0.0))), &mut output);
    assert_eq!(output.mode, CRUISE);
}

#[test]
fn a_whole_trip_on_the_wrong_map_is_driven_at_the_set_speed() {
    let road = generated(10_000.0, 3);
    let wrong = Road::new(50.0, road.grades().iter().map(|grade| -grade).collect());
    let settings = Settings::new(&truck(), PlannerKind::DynamicProgramming);
    let mut driver = Assisted::new(&settings, SET_MPS, Map { road: wrong, shift_m: 0.0 });
    let trip = drive(&truck(), &road, SET_MPS, &mut driver).expect("it arrives");
    let mean_mps = trip.length_m / trip.time_s;
    assert!((mean_mps / SET_MPS - 1.0).abs() < 0.06, "{mean_mps}");
}
