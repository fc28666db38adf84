//! The use of a green: closing up to reach it, arriving rolling as it begins, and its yellow.

use laws::cacc::config::Config;
use laws::cacc::road::RoadLaw;

use crate::scenes::{Run, run, run_law, with_lead, with_signal};
use crate::world::{Event, World};

/// The paper's scenario A with yellow: a lead at 15 m/s, 15 m beyond the desired gap, and 5 s of green for 80 m.
fn scenario_a() -> World {
    with_lead(with_signal(15.0, 25.0, 80.0, [20.0, 3.0, 20.0], 0, 5.0), 42.5, 15.0)
}

fn with_light_weight(light_weight_m: f64, world: World, seconds: f64) -> Run {
    let mut config = Config::default();
    config.road.light_weight_m = light_weight_m;
    let mut law = RoadLaw::new(&config, true, config.create_solver()).expect("it is convex");
    run_law(&mut law, world, seconds, &[])
}

#[test]
fn the_light_makes_it_close_up_to_its_lead_and_fall_back() {
    let blind = with_light_weight(0.0, scenario_a(), 25.0);
    let lit = run(scenario_a(), 25.0, &[]);
    let (blind_s, lit_s) = (blind.crossings_s[0], lit.crossings_s[0]);
    assert!(lit_s < blind_s - 0.05 && lit_s < 5.0, "{lit_s} against {blind_s}");
    assert!(lit.hardest_mps2 > -3.0, "{lit:?}");
    let (ego, lead) = (lit.world().ego, lit.world().lead.expect("it stays"));
    let error_m = 1.5 * ego.speed_mps + 5.0 - (lead.position_m - ego.position_m);
    assert!(error_m.abs() < 0.5, "{error_m}");
}

#[test]
fn it_arrives_rolling_as_a_far_red_ends() {
    for (line_m, red_s) in [(200.0, 20.0), (300.0, 40.0), (400.0, 35.0)] {
        let run =
            run(with_signal(14.0, 14.0, line_m, [20.0, 3.0, 40.0], 2, red_s), red_s + 8.0, &[]);
        let late_s = run.crossings_s[0] - red_s;
        assert!((0.0..2.5).contains(&late_s), "{line_m} m, {red_s} s: {late_s}");
        assert!(run.hardest_mps2 > -2.0, "{run:?}");
        assert!(run.slowest_mps > 1.0, "it does not stop: {run:?}");
    }
}

#[test]
fn a_glide_ends_in_a_stop_where_the_light_stays_red() {
    let world = with_signal(14.0, 14.0, 200.0, [20.0, 3.0, 60.0], 2, 20.0);
    for at_s in [10.0, 18.0, 19.9] {
        // It is no longer known when the light opens.
        let lost = [(at_s, Event::Silence { unknown: true })];
        let run = run(world.clone(), 40.0, &lost);
        assert!(run.crossings_s.is_empty() && run.hardest_mps2 > -4.5, "{at_s}: {run:?}");
        assert_eq!(run.world().ego.speed_mps, 0.0);
    }
}

#[test]
fn it_rolls_up_behind_a_lead_that_waits() {
    let world = with_lead(with_signal(14.0, 14.0, 250.0, [30.0, 3.0, 30.0], 2, 25.0), 245.0, 0.0);
    let start = [(26.0, Event::LeadAccelerates(1.5)), (33.0, Event::LeadAccelerates(0.0))];
    let run = run(world, 36.0, &start);
    assert!(run.crossings_s[0] < 32.0, "{run:?}");
    assert!(run.slowest_mps > 0.3 && run.hardest_mps2 > -2.5, "{run:?}");
}

#[test]
fn a_yellow_is_crossed_where_a_driver_would_not_stop_for_it() {
    // At 14 m/s the line is 7.3 s away. A driver's stop, with its reaction, takes 47 m.
    let green = |green_s| with_signal(14.0, 14.0, 102.0, [20.0, 4.0, 20.0], 0, green_s);
    let late = run(green(4.8), 20.0, &[]);
    assert!(late.crossings_s[0] > 4.8 && late.hardest_mps2 > -0.5, "{late:?}");
    assert!(late.fastest_mps < 14.2, "{late:?}");
    let early = run(green(3.0), 20.0, &[]);
    assert!(early.crossings_s.is_empty() && early.hardest_mps2 > -3.0, "{early:?}");
}
