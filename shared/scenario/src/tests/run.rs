//! The way of a scenario to another process of its run.

use super::*;
use crate::builtin;
use std::path::Path;

fn everything(_: &Scenario) -> Result<Reads, Problem> {
    Ok(Reads::everything())
}

fn any_builtin() -> impl Strategy<Value = &'static str> {
    proptest::sample::select(builtin::ALL.iter().map(|it| it.name).collect::<Vec<_>>())
}

#[test]
fn every_builtin_scenario_survives_the_way_to_another_process() {
    for it in builtin::ALL {
        let scenario = Scenario::open(it.name, &Overrides::new(), &everything).expect(it.name);
        let again = Scenario::of_run(&scenario.to_toml()).expect(it.name);
        assert_eq!(again, Scenario { notes: Vec::new(), ..scenario }, "{}", it.name);
    }
}

#[test]
fn a_storyboard_survives_the_way_to_another_process() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/openscenario/cut_in.xosc");
    let scenario = Scenario::open_openscenario(
        Path::new(path),
        &Default::default(),
        &Overrides::new(),
        &everything,
    )
    .expect("an example");
    assert!(scenario.storyboard.is_some());
    assert_eq!(Scenario::of_run(&scenario.to_toml()), Ok(scenario));
}

proptest! {
    #[test]
    fn numbers_keep_all_their_bits(
        name in any_builtin(), speed in 0.0..60.0f64, seed in 0..i64::MAX,
        gain in -1e300..1e300f64,
    ) {
        let mut overrides = Overrides::new();
        overrides.option("--speed", "set_speed_mps", speed);
        overrides.option("--seed", "seed", seed);
        overrides.option("--gain", "controller.mine.gain", gain);
        let scenario = Scenario::open(name, &overrides, &everything).expect(name);
        let again = Scenario::of_run(&scenario.to_toml()).expect(name);
        prop_assert_eq!(again.set_speed_mps.value().to_bits(), speed.to_bits());
        prop_assert_eq!(again.seed, scenario.seed);
        prop_assert_eq!(again.controller.tables, scenario.controller.tables);
    }
}
