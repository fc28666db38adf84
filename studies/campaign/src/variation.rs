//! Parameter variation files of OpenSCENARIO.

use openscenario::variation::Variation;
use openscenario::{Disk, ReadError, read};
use scenario::ScenarioError;
use std::path::{Path, PathBuf};
use supervise::{Error, UsageError};

/// The values that a variation file gives to its scenario's parameters.
#[derive(Debug)]
pub struct Variants {
    pub scenario: String,
    /// The description in the variation file.
    pub description: String,
    /// Number of combinations that break a constraint of the scenario.
    pub left_out: usize,
    variation: Variation,
    /// The places of those that keep them.
    admitted: Vec<usize>,
}

impl Variants {
    /// Reads a variation file and the parameters of its scenario.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let variation = Variation::open(path, &Disk).map_err(refuse)?;
        let template = read::Template::open(&variation.scenario, &Disk).map_err(refuse)?;
        let mut admitted = Vec::new();
        for index in 0..variation.len() {
            let admits = template.admits(&variation.get(index));
            if admits.map_err(|error| refuse(variation.locate(error)))? {
                admitted.push(index);
            }
        }
        let scenario = normal(&variation.scenario).to_string_lossy().into_owned();
        let left_out = variation.len() - admitted.len();
        if admitted.is_empty() {
            let why = format_args!("all {left_out} combinations break a constraint of {scenario}");
            return Err(UsageError::at(path.display(), why, "one that does not").into());
        }
        let description = variation.description.clone();
        Ok(Self { scenario, description, left_out, variation, admitted })
    }

    /// Number of combinations that are runs; at least 1.
    pub fn len(&self) -> usize {
        self.admitted.len()
    }

    /// The values of a run, as for `--param`.
    pub fn get(&self, run: usize) -> Vec<String> {
        let values = self.variation.get(self.admitted[run]);
        values.iter().map(|value| format!("{}={}", value.name, value.value)).collect()
    }
}

/// The path without its `.` parts.
fn normal(path: &Path) -> PathBuf {
    path.components().filter(|part| *part != std::path::Component::CurDir).collect()
}

fn refuse(error: ReadError) -> Error {
    ScenarioError::whole_of(&error).into()
}

#[cfg(test)]
mod tests {
    use super::super::open::of_variation;
    use super::super::plan::{Plan, plan};
    use super::*;

    const SCENARIO: &str = r#"<OpenSCENARIO><FileHeader revMajor="1" revMinor="1"/>
        <ParameterDeclarations>
          <ParameterDeclaration name="v" parameterType="double" value="10"><ConstraintGroup><ValueConstraint rule="lessThan" value="30"/></ConstraintGroup></ParameterDeclaration>
          <ParameterDeclaration name="m" parameterType="string" value="car"/>
        </ParameterDeclarations></OpenSCENARIO>"#;
    const VARIATION: &str = r#"<OpenSCENARIO><FileHeader revMajor="1" revMinor="1" description="two by three"/>
        <ParameterValueDistribution><ScenarioFile filepath="./sub/a.xosc"/><Deterministic>
          <DeterministicSingleParameterDistribution parameterName="v"><DistributionRange stepWidth="10"><Range lowerLimit="10" upperLimit="30"/></DistributionRange></DeterministicSingleParameterDistribution>
          <DeterministicSingleParameterDistribution parameterName="m"><DistributionSet><Element value="car"/><Element value="bus"/></DistributionSet></DeterministicSingleParameterDistribution>
        </Deterministic></ParameterValueDistribution></OpenSCENARIO>"#;

    /// A directory with both files, gone when it is dropped.
    struct Files(PathBuf);

    impl Files {
        fn new(name: &str, variation: &str) -> Self {
            let directory =
                std::env::temp_dir().join(format!("timegap-{name}-{}", std::process::id()));
            std::fs::create_dir_all(directory.join("sub")).expect("writable");
            std::fs::write(directory.join("sub/a.xosc"), SCENARIO).expect("writable");
            std::fs::write(directory.join("v.xosc"), variation).expect("writable");
            Self(directory)
        }
    }

    impl Drop for Files {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn every_combination_that_keeps_the_constraints_is_a_run() {
        let files = Files::new("variation", VARIATION);
        let campaign = of_variation(&files.0.join("v.xosc")).expect("a variation");
        assert_eq!(campaign.description.as_str(), "two by three");
        let planned = plan(&campaign).expect("a plan");
        assert_eq!(planned.left_out(), 2);
        let runs: Vec<_> =
            (0..planned.len()).map(|place| planned.at(place).expect("no faults")).collect();
        let values: Vec<String> = runs.iter().map(|run| run.parameters.join(" ")).collect();
        assert_eq!(values, ["v=10 m=car", "v=10 m=bus", "v=20 m=car", "v=20 m=bus"]);
        let said = runs[1].repeat("lockstep");
        assert!(
            said.ends_with("sub/a.xosc --mode lockstep --seed 1 --param 'v=10' --param 'm=bus'"),
            "{said}"
        );
    }

    #[test]
    fn a_sample_is_spread_and_repeats() {
        let files = Files::new("sample", VARIATION);
        let mut campaign = of_variation(&files.0.join("v.xosc")).expect("a variation");
        campaign.sample = std::num::NonZeroUsize::new(3);
        let planned = plan(&campaign).expect("a plan");
        let numbers = |plan: Plan| (0..plan.len()).map(|place| plan.number(place)).collect();
        let drawn: Vec<_> = numbers(planned);
        assert!(drawn.len() == 3 && drawn.is_sorted(), "{drawn:?}");
        assert_eq!(drawn, numbers(plan(&campaign).expect("a plan")));
        campaign.sample = std::num::NonZeroUsize::new(9);
        assert_eq!(plan(&campaign).expect("a plan").len(), 4);
    }

    #[test]
    fn a_variation_that_fits_nothing_is_refused() {
        let files = Files::new("unfit", &VARIATION.replace("\"v\"", "\"w\""));
        let said =
            of_variation(&files.0.join("v.xosc")).expect_err("no such parameter").to_string();
        assert!(said.contains("v.xosc:3:11: parameter w=10"), "{said}");
        assert!(said.contains("a.xosc does not declare it, expected `v` or `m`"), "{said}");
    }
}
