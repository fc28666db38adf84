//! The jobs of a campaign: its planned runs, and the drives without faults.

use super::exposure::Exposure;
use super::file::Campaign;
use super::plan::Plan;
use super::planned::Planned;
use frame::batch::{self, Job};
use runtime::Mode;
use scenario::Scenario;
use scenario::supervision::Standbys;
use std::time::Duration;
use supervise::{Error, GroupOptions, ScenarioOptions, UsageError};

/// A planned run as a job, checked.
pub fn job(campaign: &Campaign, planned: &Planned) -> Result<Job, Error> {
    let options = ScenarioOptions {
        controller: planned.controller.clone(),
        seed: Some(planned.seed.to_string()),
        parameters: planned.parameters.clone(),
        require: planned.formulas.clone(),
        ..ScenarioOptions::default()
    };
    let scenario = supervise::open_with(&planned.scenario, &options, "set", &planned.keys)?;
    let of_processes = scenario.faults.iter().find(|fault| fault.effect.of_processes().is_some());
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
        scenario.supervision.standby = Standbys::default();
        supervise::check_in_process(&scenario)?;
        Ok((planned.scenario, scenario))
    };
    planned.into_iter().map(drive).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::{BUILTIN, Builtin};
    use crate::{open, plan};

    #[test]
    fn the_drives_without_faults_of_every_built_in_campaign_are_possible() {
        for Builtin { name, .. } in BUILTIN {
            let campaign = open::open(name).expect("it is built in");
            let plan = plan::plan(&campaign).expect("it is built in");
            let drives = fault_free(&campaign, &plan).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(drives.is_empty(), campaign.faults.is_empty(), "{name}");
        }
    }
}
