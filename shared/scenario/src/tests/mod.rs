//! Tests of whole documents: defaults, round trips; refusals, overrides and files in files of their own.

use proptest::prelude::*;

use super::*;
use crate::reading::Place;

mod files;
mod overrides;
mod refusals;
mod run;

const SHORT: &str = "schema_version = 1\nname = \"short\"\n";

fn refusal(rest: &str) -> String {
    let text = format!("{SHORT}{rest}");
    Scenario::parse("x.toml", &text).expect_err("this scenario is wrong").to_string()
}

/// The scenario of a text that stands for a built-in one: keys without effect are judged.
fn build(
    text: &str,
    overrides: &Overrides,
    check: &dyn Fn(&Scenario) -> Result<Reads, Problem>,
) -> Result<Scenario, ScenarioError> {
    let document = Document::parse("x.toml", text, overrides)?;
    Scenario::of_document(&document, Place::BuiltIn(None), check)
}

fn open(text: &str, arguments: &[&str]) -> Result<Scenario, ScenarioError> {
    let mut overrides = Overrides::new();
    for argument in arguments {
        overrides.set(argument.parse()?);
    }
    build(text, &overrides, &|_| Ok(Default::default()))
}

#[test]
fn two_lines_are_a_scenario() {
    let scenario = Scenario::parse("x.toml", SHORT).expect("all else has defaults");
    assert_eq!(scenario.plant.period_ms.value(), 10);
    assert_eq!(scenario.perception.period_ms.value(), 50);
    assert_eq!(scenario.v2x.period_ms.value(), 100);
    assert_eq!(scenario.controller.period_ms.value(), 100);
    assert_eq!(scenario.controller.deadline().value(), 100);
}

#[test]
fn every_built_in_scenario_is_right_and_carries_its_name_and_summary() {
    for builtin in builtin::ALL {
        let scenario = Scenario::open(builtin.name, &Overrides::new(), &|_| Ok(Default::default()))
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario.name.as_str(), builtin.name);
        assert_eq!(scenario.description.as_str(), builtin.summary());
    }
}

#[test]
fn the_effective_scenario_reads_back_equal() {
    for builtin in builtin::ALL {
        let scenario = Scenario::parse(builtin.name, builtin.text).expect("it is right");
        let again = Scenario::parse("effective.toml", &scenario.to_toml())
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario, again);
        assert_eq!(scenario.to_toml(), again.to_toml());
    }
}

#[test]
fn one_key_makes_the_controller_fast() {
    let scenario = open(SHORT, &["controller.period_ms=1"]).expect("the rest follows");
    assert_eq!(scenario.plant.period_ms.value(), 1);
    assert_eq!(scenario.controller.release, controller::Release::Timer);
    assert_eq!(scenario.controller.prediction_step().value(), 100);
    // A written value stays, and is refused if it does not fit.
    assert!(open(SHORT, &["controller.period_ms=1", "plant.period_ms=10"]).is_err());
    assert!(open(SHORT, &["controller.period_ms=1", "controller.release=radar"]).is_err());
}

#[test]
fn a_delay_between_two_steps_of_the_plant_makes_them_shorter() {
    let period_ms = |delay: &str| {
        let delay = format!("runtime.extra_delay_ms={delay}");
        open(SHORT, &[&delay]).expect("the rest follows").plant.period_ms.value()
    };
    assert_eq!(["0", "10", "400", "25", "4"].map(period_ms), [10, 10, 10, 5, 2]);
    assert!(open(SHORT, &["runtime.extra_delay_ms=25", "plant.period_ms=10"]).is_err());
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        let _ = Scenario::parse("x.toml", &text).map_err(|error| error.to_string());
    }

    #[test]
    fn no_mutation_of_a_scenario_makes_the_reader_panic(
        at in 0usize..2000, length in 0usize..12, put in "[\\[\\]{}=.,\"'#\n a-z0-9é-]{0,6}",
    ) {
        let mut text = builtin::find("corridor").expect("it is built in").text.to_owned();
        let (at, end) = (at.min(text.len()), (at + length).min(text.len()));
        if text.is_char_boundary(at) && text.is_char_boundary(end) {
            text.replace_range(at..end, &put);
        }
        match Scenario::parse("x.toml", &text) {
            Ok(scenario) => {
                let again = Scenario::parse("again.toml", &scenario.to_toml());
                prop_assert_eq!(again.as_ref(), Ok(&scenario));
            }
            Err(error) => prop_assert!(error.to_string().starts_with("error: ")),
        }
    }

    #[test]
    fn no_override_makes_the_reader_panic(argument in "[a-z.0-9_=\\[\\]{}\" é]{0,40}") {
        let _ = open(SHORT, &[&argument]).map_err(|error| error.to_string());
    }
}

#[test]
fn a_lead_drives_a_standard_cycle() {
    let text = format!("{SHORT}[[actors]]\nname = \"a\"\ngap_m = 9\nprofile.cycle = \"us06\"\n");
    let scenario = Scenario::parse("x.toml", &text).expect("the cycle is known");
    let points = scenario.actors[0].profile.points().expect("a cycle is a table of speeds");
    assert_eq!(points.len(), 601);
}

#[test]
fn a_radar_has_one_model() {
    let model = |keys: &str| {
        let text = format!("schema_version = 1\nname = \"x\"\n[perception]\n{keys}");
        build(&text, &Overrides::new(), &|_| Ok(Default::default()))
            .map(|scenario| (scenario.perception.model(), scenario.to_toml()))
    };
    for one in
        ["ideal = true\n", "radar.model = \"ideal\"\n", "ideal = true\nradar.model = \"ideal\"\n"]
    {
        let (found, effective) = model(one).expect("one model");
        assert_eq!(found, perception::RadarModel::Ideal, "{one}");
        // The effective scenario can be opened again.
        build(&effective, &Overrides::new(), &|_| Ok(Default::default())).expect(one);
    }
    for other in ["detections", "object-list"] {
        let error =
            model(&format!("ideal = true\nradar.model = \"{other}\"\n")).expect_err("two models");
        assert!(error.to_string().contains("perception.ideal = true"), "{error}");
        // As a run of an earlier version kept it.
        let kept = format!(
            "schema_version = 1\nname = \"x\"\n[perception]\nideal = true\nradar.model = \"{other}\"\n"
        );
        let kept = Scenario::parse("kept", &kept).expect("ideal counts");
        assert_eq!(kept.perception.model(), perception::RadarModel::Ideal);
    }
}
