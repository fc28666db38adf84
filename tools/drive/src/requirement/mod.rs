//! Requirements on a drive: formulas over its signals, judged after the run.
//!
//! A requirement is a formula of [`temporal_logic`] over [`signals`], or a [named](names) one. It stands in a scenario's
//! `[require]` or behind `--require`. Some names stand for rules on the ground truth, which no formula expresses.

#[cfg(test)]
mod by_hand_tests;
mod contact;
mod evidence;
mod names;
mod others;
mod red_light;
mod reference;
mod signals;

pub use contact::ReferenceDriver;
pub use evidence::Evidence;
pub use reference::is_avoidable_collision;

use evidence::Finding;
use names::{Named, Rule};
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use signals::Samples;
use temporal_logic::{Formula, FormulaError, Trace};
use thiserror::Error;

/// A requirement that can be judged.
#[derive(Clone, Debug)]
pub struct Requirement {
    text: String,
    judge: Judge,
}

#[derive(Clone, Debug)]
enum Judge {
    Formula(Formula),
    Rule(Rule),
}

/// A requirement of the scenario that cannot be read, by its place among them.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("require.formulas.{index}: {why}")]
pub struct RequirementError {
    index: usize,
    why: String,
}

/// Verdict of a requirement on a drive, and its margin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RequirementVerdict {
    /// The requirement as it was given.
    pub requirement: String,
    /// Its formula, or its rule in words.
    pub formula: String,
    /// Distance to violation, in `unit`; negative where it is violated, null where nothing of the drive decides it.
    pub margin: Option<f64>,
    /// Unit of the margin. `tolerances` where the formula compares several units.
    pub unit: String,
    /// Run time of the sample that decides, s.
    pub at_s: f64,
    /// True if the requirement holds.
    pub met: bool,
}

/// The requirements of a scenario: its formulas, and on a road with a plan its limit of the lateral acceleration.
///
/// ```
/// # use scenario::Scenario;
/// let text = "schema_version = 1\nname = \"a\"\n[require]\nformulas = [\"always gap_m > 2\", \"min-gap:2\"]";
/// let scenario = Scenario::parse("a.toml", text)?;
/// let requirements = drive::requirements(&scenario)?;
/// assert_eq!(requirements[1].formula(), "always gap_m >= 2");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn requirements(scenario: &Scenario) -> Result<Vec<Requirement>, RequirementError> {
    let known = signals::signals();
    let read = |(index, text): (usize, &String)| {
        let refuse = |why: String| RequirementError { index, why };
        if let Some(name) = names::unknown(text) {
            let names = scenario::accepted(name, names::names());
            let why = format!("unknown requirement `{name}`, expected a formula or one of {names}");
            return Err(refuse(why));
        }
        let formula = match names::named(text) {
            None => text.clone(),
            Some(Ok(Named::Formula(formula))) => formula,
            Some(Ok(Named::Rule(rule))) => {
                return Ok(Requirement { text: text.clone(), judge: Judge::Rule(rule) });
            }
            Some(Err(expected)) => {
                return Err(refuse(format!("\"{text}\", expected {expected}")));
            }
        };
        let fault = |error: FormulaError| refuse(error.to_string());
        let formula = Formula::parse(&formula, &known).map_err(fault)?;
        formula.check_duration(scenario.duration_s.value()).map_err(fault)?;
        Ok(Requirement { text: text.clone(), judge: Judge::Formula(formula) })
    };
    let mut requirements =
        scenario.require.formulas.iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?;
    if scenario.road.plan().is_some() {
        let limit_mps2 = scenario.require.max_lateral_mps2.value();
        let judge = Judge::Rule(Rule::Lateral(limit_mps2));
        requirements.push(Requirement { text: format!("lateral:{limit_mps2}"), judge });
    }
    Ok(requirements)
}

impl Requirement {
    /// The formula, or the rule in words.
    pub fn formula(&self) -> &str {
        match &self.judge {
            Judge::Formula(formula) => formula.text(),
            Judge::Rule(rule) => rule.words(),
        }
    }

    /// Judges a drive. A drive without a sample meets nothing.
    pub fn judge(&self, evidence: &Evidence<'_>) -> RequirementVerdict {
        let found = match &self.judge {
            _ if evidence.drive.steps.is_empty() => {
                Finding { value: f64::NEG_INFINITY, met: false, ..Finding::UNDECIDED }
            }
            Judge::Formula(formula) => by_formula(formula, evidence),
            Judge::Rule(Rule::Collision) => contact::no_collision(evidence),
            Judge::Rule(Rule::AvoidableCollision) => reference::no_avoidable_collision(evidence),
            Judge::Rule(Rule::RedLight) => red_light::no_red_light(evidence),
            Judge::Rule(Rule::Lateral(limit_mps2)) => evidence::lateral(*limit_mps2, evidence),
        };
        RequirementVerdict {
            requirement: self.text.clone(),
            formula: self.formula().to_owned(),
            margin: found.value.is_finite().then_some(found.value),
            unit: found.unit.to_string(),
            at_s: found.time_s,
            met: found.met,
        }
    }
}

fn by_formula(formula: &Formula, evidence: &Evidence<'_>) -> Finding {
    let Evidence { scenario, drive, .. } = evidence;
    let set_speed_mps = scenario.set_speed_mps.value();
    let samples = Samples::of(drive, &formula.signals(), set_speed_mps).expect("it has a step");
    let of = samples.of.iter().map(Vec::as_slice).collect();
    let margin = formula.margin(&Trace { period_s: samples.period_s, samples: of });
    Finding {
        value: margin.value,
        unit: formula.unit(),
        time_s: samples.begin_s + margin.sample as f64 * samples.period_s,
        met: margin.value >= 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Drive, DriveStep};
    use messages::AllVehicles;

    /// 3 s at 10 ms. The speed is 20 m/s; the gap shrinks by 2 m/s from 30 m and is sampled every 50 ms. The vehicle
    /// ahead leaves after 2 s.
    fn drive() -> Drive {
        let mut drive = Drive::default();
        for step in 0..300_u64 {
            let time_s = step as f64 / 100.0;
            let is_sampled = step % 5 == 0;
            if is_sampled {
                let mut truth = AllVehicles::with_room(0);
                truth.header.step = step;
                drive.vehicles.push(truth);
            }
            drive.steps.push(DriveStep {
                step,
                time_s,
                speed_mps: 20.0,
                time_to_collision_s: f64::INFINITY,
                stop_line_m: f64::INFINITY,
                gap_m: (is_sampled && time_s < 2.0).then_some(30.0 - 2.0 * time_s),
                ..DriveStep::default()
            });
        }
        drive
    }

    fn judged(formula: &str) -> RequirementVerdict {
        let text = format!(
            "schema_version = 1\nname = \"a\"\nduration_s = 3\n[require]\nformulas = ['{formula}']"
        );
        let scenario = Scenario::parse("a.toml", &text).expect("valid");
        let drive = drive();
        let evidence = Evidence { scenario: &scenario, drive: &drive, impact_speed_mps: None };
        requirements(&scenario).expect("valid")[0].judge(&evidence)
    }

    #[test]
    fn a_gap_holds_between_its_samples_and_is_infinite_on_an_empty_road() {
        let verdict = judged("always gap_m > 26");
        assert!((verdict.margin.expect("decided") - 0.1).abs() < 1e-9, "{verdict:?}");
        assert!((verdict.at_s - 1.95).abs() < 1e-9 && verdict.met && verdict.unit == "m");
        // The vehicle has left at 2 s.
        assert_eq!(judged("always[2.1,2.9] gap_m > 1000").margin, None);
        assert!(judged("always[2.1,2.9] gap_m > 1000").met);
        assert!(!judged("always gap_m > 27").met);
    }

    #[test]
    fn names_stand_for_formulas() {
        let verdict = judged("time-gap:1..1.4");
        assert_eq!(verdict.unit, "s");
        assert!(
            (verdict.margin.expect("decided") + 0.1).abs() < 1e-9,
            "1.5 s at first: {verdict:?}"
        );
        assert!(judged("jerk:1").met && judged("comfort").met && judged("ttc:2").met);
    }

    #[test]
    fn faults_name_the_requirement() {
        let of = |formulas: &str| {
            let text =
                format!("schema_version = 1\nname = \"a\"\n[require]\nformulas = {formulas}");
            let scenario = Scenario::parse("a.toml", &text).expect("valid");
            requirements(&scenario).expect_err("refused").to_string()
        };
        assert!(
            of("[\"min-gap:2\", \"always gap > 2\"]")
                .starts_with("require.formulas.1: column 8: unknown signal")
        );
        assert!(of("[\"min-gap\"]").contains("expected min-gap:METRES"));
        assert!(of("[\"no-collision:3\"]").contains("expected the name without a value"));
        assert!(of("[\"string-stable\"]").contains("expected it in `timegap string`"));
        assert!(of("[\"always[0,500] gap_m > 2\"]").contains("the window ends after the run"));
    }
}
