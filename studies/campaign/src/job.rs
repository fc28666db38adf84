//! A planned run as a job of the batch.

use super::error::CampaignError;
use super::file::Campaign;
use super::planned::Planned;
use frame::batch::Job;
use group::{Error, ScenarioOptions};
use runtime::Mode;
use scenario::Scenario;
use std::time::Duration;

/// A planned run, checked.
pub fn job(campaign: &Campaign, planned: &Planned) -> Result<Job, Error> {
    let options = ScenarioOptions {
        controller: planned.controller.clone(),
        seed: Some(planned.seed.to_string()),
        parameters: planned.parameters.clone(),
        ..ScenarioOptions::default()
    };
    let scenario = group::open_with(&planned.scenario, &options, "set", &planned.keys)?;
    if campaign.mode == Mode::Lockstep {
        refuse_faults_of_processes(&scenario)?;
    }
    let sample_every = campaign.sample_every_s.map(Duration::from_secs_f64);
    Ok(Job { scenario, mode: campaign.mode, sample_every, record: campaign.record })
}

/// In simulated time nothing is to be seen of a process fault.
fn refuse_faults_of_processes(scenario: &Scenario) -> Result<(), CampaignError> {
    match scenario.faults.iter().find(|fault| fault.effect.of_processes().is_some()) {
        None => Ok(()),
        Some(fault) => Err(CampaignError::FaultOfProcesses { kind: fault.effect.kind() }),
    }
}
