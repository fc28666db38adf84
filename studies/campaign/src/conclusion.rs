//! A campaign's end: judged, written, printed.

use super::arguments::CampaignArguments;
use super::exposure::Exposure;
use super::file::Campaign;
use super::job::job;
use super::plan::Plan;
use super::planned::Planned;
use super::records::Records;
use super::verdict::{Sums, Verdict};
use super::{page, print};
use frame::batch::{self, Job};
use group::{Error, GroupOptions};
use report::output::{OutputDirectory, ResultFile};
use scenario::Scenario;
use scenario::supervision::Standbys;
use std::process::ExitCode;

/// Judges, writes and prints.
pub fn conclude(
    arguments: &CampaignArguments,
    campaign: &Campaign,
    (plan, planned): (&Plan, usize),
    mut records: Records,
    output: &OutputDirectory,
) -> Result<ExitCode, Error> {
    let exposure = exposure(campaign, plan, &arguments.group)?;
    let mut sums = Sums::default();
    let mut times = page::Times::default();
    records.each(&mut |record| {
        sums.add(record);
        times.add(record);
    })?;
    let mut verdict = Verdict::new(campaign, plan, planned, exposure, sums);
    if !verdict.ok {
        records.each(&mut |record| verdict.blame(plan, record))?;
    }
    let rows = |file: &mut ResultFile| {
        let mut written = file.add(&print::csv_head());
        records.each(&mut |record| {
            if written.is_ok() {
                written = file.add(&print::csv_row(record));
            }
        })?;
        written
    };
    let table = output.write_by("campaign.csv", rows);
    let json = serde_json::to_string_pretty(&verdict).expect("plain data") + "\n";
    let written = table
        .and_then(|()| output.write("campaign.json", json.as_bytes()))
        .and_then(|()| output.write(report::FILE, page::page(&verdict, &times).as_bytes()));
    if arguments.json {
        report::print::out(&json)?;
    } else {
        report::print::out(&(print::verdict(&verdict) + &output.places()))?;
    }
    // What was measured has been told before a full disk is.
    written?;
    Ok(if verdict.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What the drives meet without faults: one in simulated time for each scenario and controller.
fn exposure(
    campaign: &Campaign,
    plan: &Plan,
    group: &GroupOptions,
) -> Result<Vec<Exposure>, Error> {
    let mut met = Vec::new();
    for (name, scenario) in fault_free(campaign, plan)? {
        let done = batch::lockstep(&scenario, group, false, &|| true)?;
        let controller = scenario.controller.name.as_str().to_owned();
        met.push(Exposure::of(name, controller, &done.drive.steps));
    }
    Ok(met)
}

/// The drives without faults, each with the name of its scenario. In simulated time no process ends, so that none
/// needs a standby.
///
/// # Errors
/// If a scenario cannot be driven in simulated time.
pub fn fault_free(campaign: &Campaign, plan: &Plan) -> Result<Vec<(String, Scenario)>, Error> {
    let planned = if campaign.faults.is_empty() { Vec::new() } else { plan.without_faults() };
    let drive = |planned: Planned| {
        let Job { mut scenario, .. } = job(campaign, &planned)?;
        scenario.faults.clear();
        scenario.supervision.standby = Standbys::default();
        group::check_in_process(&scenario)?;
        Ok((planned.scenario, scenario))
    };
    planned.into_iter().map(drive).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{file, plan};

    #[test]
    fn the_drives_without_faults_of_every_built_in_campaign_are_possible() {
        for file::Builtin { name, .. } in file::BUILTIN {
            let campaign = Campaign::open(name).expect("it is built in");
            let plan = plan::plan(&campaign).expect("it is built in");
            let drives = fault_free(&campaign, &plan).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert!(!drives.is_empty(), "{name}");
        }
    }
}
