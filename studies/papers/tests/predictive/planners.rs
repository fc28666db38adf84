//! The planners by themselves.

use crate::roads::{SET_MPS, generated};
use controller::law::{Plan, PlanRequest};
use controller::laws::truck::{
    BoundKeys, Keys, PlanKeys, PlannerKind, Settings, create, speed_band_mps,
};
use proptest::prelude::*;
use truck_model::{Preset, Truck};

const PLANNERS: [PlannerKind; 2] = [PlannerKind::DynamicProgramming, PlannerKind::PaperN2];

fn request(grades: &[f64], speed_mps: f64) -> PlanRequest {
    let mut request = PlanRequest {
        number: 1,
        speed_mps,
        gear: 5,
        engine_torque_nm: 600.0,
        set_speed_mps: SET_MPS,
        speed_limit_mps: f64::INFINITY,
        time_price: 1.0,
        ..PlanRequest::default()
    };
    request.preview.grades[..grades.len()].copy_from_slice(grades);
    request.preview.count = grades.len();
    request
}

#[test]
fn on_the_flat_they_hold_the_set_speed() {
    for preset in Preset::ALL {
        let truck = Truck::preset(preset);
        for kind in PLANNERS {
            let mut plan = Plan::default();
            assert!(
                create(&Settings::new(&truck, kind)).plan(&request(&[0.0; 42], SET_MPS), &mut plan)
            );
            for segment in &plan.segments[..plan.len] {
                let speed_mps = (2.0 * segment.end_speed2_half).sqrt();
                assert!((speed_mps - SET_MPS).abs() < 0.6, "{kind:?}: {speed_mps}");
            }
        }
    }
}

#[test]
fn before_a_hill_they_gain_speed_and_before_a_dip_they_lose_it() {
    let truck = Truck::preset(Preset::Jh6At49T);
    let before = |grade: f64| {
        let mut grades = [0.0; 42];
        grades[12..30].fill(grade);
        grades
    };
    for kind in PLANNERS {
        let mut planner = create(&Settings::new(&truck, kind));
        let mut torque_nm = |grade: f64| {
            let mut plan = Plan::default();
            assert!(planner.plan(&request(&before(grade), SET_MPS), &mut plan));
            // The mean over the 600 m before the slope.
            let inside = plan.segments[..plan.len].iter().filter(|s| s.end_m <= 600.0);
            let torques: Vec<f64> = inside.map(|segment| segment.engine_torque_nm).collect();
            torques.iter().sum::<f64>() / torques.len() as f64
        };
        let (uphill, flat, downhill) = (torque_nm(0.03), torque_nm(0.0), torque_nm(-0.03));
        assert!(uphill > flat + 50.0, "{kind:?}: {uphill}, on the flat {flat}");
        assert!(downhill < flat - 50.0, "{kind:?}: {downhill}, on the flat {flat}");
    }
}

#[test]
fn the_dynamic_program_keeps_a_lower_gear_for_a_hill() {
    let truck = Truck::preset(Preset::Jh6At49T);
    let mut plan = Plan::default();
    let mut planner = create(&Settings::new(&truck, PlannerKind::DynamicProgramming));
    assert!(planner.plan(&request(&[0.035; 42], SET_MPS), &mut plan));
    let gears: Vec<_> = plan.segments[..plan.len].iter().map(|segment| segment.gear).collect();
    assert!(gears.iter().any(|gear| gear.is_some_and(|gear| gear < 5)), "{gears:?}");
}

/// The map ends in a descent, at the horizon of 2 km. The plan assumes that the descent continues.
#[test]
fn a_descent_at_the_end_of_the_map_goes_on() {
    let truck = Truck::preset(Preset::Jh6At49T);
    let mut planner = create(&Settings::new(&truck, PlannerKind::DynamicProgramming));
    let mut speed_mps = |grades: &[f64]| {
        let mut plan = Plan::default();
        assert!(planner.plan(&request(grades, SET_MPS), &mut plan));
        (2.0 * plan.segments[15].end_speed2_half).sqrt()
    };
    // Speeds where the descent begins, 1.6 km ahead.
    let mut grades = [0.0; 60];
    grades[32..40].fill(-0.03);
    let flat_after_it = speed_mps(&grades);
    let unknown = speed_mps(&grades[..40]);
    grades[40..].fill(-0.03);
    let goes_on = speed_mps(&grades);
    assert!(goes_on < flat_after_it - 0.2, "{goes_on}, flat after it {flat_after_it}");
    assert!(unknown < flat_after_it - 0.2, "{unknown}, flat after it {flat_after_it}");
    assert!((unknown - goes_on).abs() < 0.5, "{unknown}, known {goes_on}");
}

#[test]
fn a_short_preview_gives_a_short_plan_and_no_preview_gives_no_plan() {
    let truck = Truck::preset(Preset::Jh6At49T);
    for kind in PLANNERS {
        let mut planner = create(&Settings::new(&truck, kind));
        let mut plan = Plan::default();
        assert!(planner.plan(&request(&[0.0; 6], SET_MPS), &mut plan), "{kind:?}");
        assert!(plan.end_m() <= 300.0);
        assert!(!planner.plan(&request(&[], SET_MPS), &mut plan), "{kind:?}");
        assert_eq!(plan.len, 0);
        // A map that begins ahead of the truck leaves a hole.
        let mut hole = request(&[0.0; 42], SET_MPS);
        hole.preview.start_m = 30.0;
        assert!(!planner.plan(&hole, &mut plan), "{kind:?}");
        assert!(!planner.plan(&request(&[0.0; 42], 3.0), &mut plan), "{kind:?}: too slow");
        assert_eq!(plan.len, 0);
    }
}

/// The paper takes n = 2 of the segments that it defines for any n.
#[test]
fn the_published_planner_plans_as_many_segments_as_are_set() {
    let truck = Truck::preset(Preset::Jh6At49T);
    let mut grades = [0.0; 42];
    grades[12..20].fill(0.02);
    grades[28..42].fill(-0.02);
    for segments in 1..=3 {
        let plan_keys = PlanKeys { segments, ..PlanKeys::default() };
        let keys = Keys { planner: PlannerKind::PaperN2, plan: plan_keys, ..Keys::default() };
        let mut plan = Plan::default();
        let mut planner = create(&Settings::of_keys(&truck, &keys));
        assert!(planner.plan(&request(&grades, SET_MPS), &mut plan));
        assert_eq!(plan.len, segments as usize);
    }
}

#[test]
fn plans_repeat_to_the_bit() {
    let truck = Truck::preset(Preset::Jh6At25T);
    let road = generated(10_000.0, 4);
    for kind in PLANNERS {
        let (mut one, mut other) =
            (create(&Settings::new(&truck, kind)), create(&Settings::new(&truck, kind)));
        // The other one has planned something else before.
        let _ = other.plan(&request(&[0.02; 30], 18.0), &mut Plan::default());
        let (mut a, mut b) = (Plan::default(), Plan::default());
        for place in 0..70 {
            let position_m = 100.0 * f64::from(place);
            let preview = road.preview(position_m, 2100.0);
            let request = PlanRequest { position_m, preview, ..request(&[], 20.0) };
            assert_eq!(one.plan(&request, &mut a), other.plan(&request, &mut b));
            assert_eq!(a, b);
        }
    }
}

proptest! {
    #[test]
    fn plans_are_physical(
        grades in prop::collection::vec(-0.06..0.06_f64, 10..60),
        speed_mps in 14.5..23.0_f64,
        gear in 3..6_usize,
        time_price in 0.5..3.0_f64,
    ) {
        let truck = Truck::preset(Preset::Jh6At49T);
        for kind in PLANNERS {
            let mut plan = Plan::default();
            let request = PlanRequest { gear, time_price, ..request(&grades, speed_mps) };
            if !create(&Settings::new(&truck, kind)).plan(&request, &mut plan) {
                continue;
            }
            let mut start_m = 0.0;
            for segment in &plan.segments[..plan.len] {
                prop_assert!(segment.end_m > start_m && segment.engine_torque_nm.is_finite());
                let speed_mps = (2.0 * segment.end_speed2_half).sqrt();
                prop_assert!(speed_mps <= speed_band_mps(&BoundKeys::default(), &request).1 + 1e-6, "{speed_mps}");
                prop_assert!(speed_mps > 7.0, "{speed_mps}");
                prop_assert!(segment.gear.is_none_or(|gear| gear < 6));
                start_m = segment.end_m;
            }
            prop_assert!(plan.end_m() <= request.preview.end_m() + 1e-6);
        }
    }
}
