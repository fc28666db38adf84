//! The jobs of a campaign: its planned runs, and the drives without faults.

use super::exposure::Exposure;
use super::file::Campaign;
use super::plan::Plan;
use super::record::Planned;
use frame::batch::{self, Job};
use runtime::Mode;
use scenario::Scenario;
use scenario::faults::{Effect, Target};
use std::time::Duration;
use supervise::{Error, GroupOptions, ScenarioOptions, UsageError, absent};

/// A planned run as a job, checked.
pub fn job(campaign: &Campaign, planned: &Planned) -> Result<Job, Error> {
    let options = ScenarioOptions {
        controller: planned.controller.clone(),
        seed: Some(planned.seed.into()),
        parameters: planned.parameters.clone(),
        require: planned.formulas.clone(),
        ..ScenarioOptions::default()
    };
    let scenario = supervise::open_with(&planned.scenario, &options, "set", &planned.settings)?;
    let of_processes =
        scenario.faults.iter().find(|fault| matches!(fault.effect, Effect::Process(_)));
    if let Some(fault) = of_processes.filter(|_| campaign.mode == Mode::Lockstep) {
        let place = format_args!("a fault of kind `{}`", fault.effect.kind());
        let expected = "mode = \"realtime\" in the campaign";
        return Err(UsageError::at(place, "it acts on processes", expected).into());
    }
    let sample_every = campaign.sample_every_s.map(Duration::from_secs_f64);
    Ok(Job { scenario, mode: campaign.mode, sample_every, record: campaign.record })
}

/// Exposure of each scenario and controller without faults: one drive each, in simulated time.
pub fn exposure(
    campaign: &Campaign,
    plan: &Plan,
    group: &GroupOptions,
) -> Result<Vec<Exposure>, Error> {
    let drive = |(name, scenario): (String, Scenario)| {
        let done = batch::lockstep(&scenario, group, &|| true)?;
        let controller = scenario.controller.name.as_str().to_owned();
        Ok(Exposure::of(name, controller, &done.drive.steps))
    };
    fault_free(campaign, plan)?.into_iter().map(drive).collect()
}

/// The drives without faults, each with the name of its scenario; none in a campaign without faults.
pub fn fault_free(campaign: &Campaign, plan: &Plan) -> Result<Vec<(String, Scenario)>, Error> {
    let planned = if campaign.faults.is_empty() { Vec::new() } else { plan.without_faults() };
    let drive = |planned: Planned| {
        let Job { mut scenario, .. } = job(campaign, &planned)?;
        scenario.faults.clear();
        // In simulated time no process ends, and a standby is refused.
        scenario.supervision.standby.clear();
        supervise::check_simulated(&scenario)?;
        Ok((planned.scenario, scenario))
    };
    planned.into_iter().map(drive).collect()
}

/// The targets of the faults, and those without a receiver.
#[derive(Debug, Default)]
pub struct Targets {
    present: Vec<Target>,
    absent: Vec<(Target, UsageError)>,
}

impl Targets {
    /// Notes the faults of a run.
    pub fn note(&mut self, scenario: &Scenario) {
        for fault in &scenario.faults {
            let target = fault.effect.target();
            match absent(fault, scenario) {
                None if !self.present.contains(&target) => self.present.push(target),
                Some(what) if self.absent.iter().all(|(known, _)| *known != target) => {
                    self.absent.push((target, what));
                }
                _ => {}
            }
        }
    }

    /// Refuses a target that was absent in every run.
    pub fn check(self) -> Result<(), UsageError> {
        let Self { present, absent } = self;
        match absent.into_iter().find(|(target, _)| !present.contains(target)) {
            Some((_, what)) => {
                let place = "faults, in every scenario of the campaign".to_owned();
                Err(UsageError { place, ..what })
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::BUILTIN;
    use crate::{open, plan};

    #[test]
    fn the_drives_without_faults_of_every_built_in_campaign_are_possible() {
        for (name, _) in BUILTIN {
            let campaign = open::open(name).expect("it is built in");
            let plan = plan::plan(&campaign).expect("it is built in");
            let drives = fault_free(&campaign, &plan).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(drives.is_empty(), campaign.faults.is_empty(), "{name}");
        }
    }

    fn scenario(aebs: bool, topic: &str) -> Scenario {
        let text = format!(
            "schema_version = 1\nname = \"x\"\n[aebs]\nenabled = {aebs}\n[[faults]]\nkind = \"drop\"\n\
             topic = \"{topic}\"\nat_s = 1.0\nfor_s = 1.0\n"
        );
        Scenario::parse("x.toml", &text).expect("a scenario")
    }

    #[test]
    fn a_topic_that_no_scenario_receives_is_refused() {
        let mut targets = Targets::default();
        targets.note(&scenario(true, "radar/tracks"));
        targets.note(&scenario(false, "radar/detections"));
        let refused = targets.check().expect_err("no emergency brake takes part").to_string();
        assert!(refused.contains("radar/detections"), "{refused}");
    }

    #[test]
    fn a_topic_that_one_scenario_receives_is_drawn() {
        let mut targets = Targets::default();
        targets.note(&scenario(false, "radar/detections"));
        targets.note(&scenario(true, "radar/detections"));
        assert!(targets.check().is_ok());
    }
}
