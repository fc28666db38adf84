//! The study of a campaign file: its runs, their records, and the verdict.

use super::blame::Blame;
use super::columns::{self, RUNS};
use super::document::document;
use super::file::Campaign;
use super::jobs::{Targets, job};
use super::open::open;
use super::plan::{Plan, plan};
use super::record::Record;
use super::sums::Sums;
use super::verdict::{Scope, Verdict};
use super::{jobs, launcher_death};
use clap::Args;
use frame::batch::{Done, Job};
use frame::{Command, Crew, DriveOptions, Entry, Found, Recorded, RunOptions, Study, batch, parts};
use report::gate::Baseline;
use report::results::{Column, Document};
use runtime::Mode;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;
use std::process::ExitCode;
use supervise::{Error, GroupOptions};

/// Largest number of scenarios that are read before anything runs.
const MAX_CHECKED: usize = 1_000;

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<FileCampaign>();

pub fn run(command: &Command<CampaignArguments>) -> Result<ExitCode, Error> {
    let mut command = command.clone();
    let campaign = effective(&command.study)?;
    FileCampaign::of(campaign.clone(), &command.options)?.check()?;
    command.study.effective = Some(campaign.to_toml());
    frame::run::<FileCampaign>(&command)
}

/// The campaign of the arguments' file, with the options laid over it.
fn effective(arguments: &CampaignArguments) -> Result<Campaign, Error> {
    let mut campaign = open(&arguments.campaign)?;
    if let Some(seeds) = arguments.seeds {
        campaign.limit_seeds(seeds);
    }
    campaign.first_seed = arguments.first.unwrap_or(campaign.first_seed);
    campaign.sample = arguments.sample.or(campaign.sample);
    let DriveOptions { controllers, laws, set, require } = &arguments.drives;
    if !require.is_empty() {
        campaign.formulas.extend(require.iter().cloned());
        // None may be broken, unless the file sets another limit.
        campaign.require.entry("max_requirements_broken".to_owned()).or_insert(0.0);
    }
    laws.check()?;
    campaign.set.extend(laws.settings().into_iter().chain(set.iter().cloned()));
    if !controllers.is_empty() {
        campaign.controllers = batch::laws::named(controllers, &laws.names(), false)?;
    } else if campaign.controllers.is_empty() {
        campaign.controllers = laws.names();
    }
    laws.expect_all_in(&campaign.controllers)?;
    Ok(campaign)
}

struct FileCampaign {
    campaign: Campaign,
    plan: Plan,
    /// Start of the processes, for the drives without faults too.
    group: GroupOptions,
    may_kill_launcher: bool,
    baseline: Option<Baseline>,
}

impl FileCampaign {
    fn of(campaign: Campaign, options: &RunOptions) -> Result<Self, Error> {
        let plan = plan(&campaign)?;
        let may_kill_launcher = campaign.faults.iter().any(launcher_death::may_be);
        let (group, baseline) = (options.group.clone(), None);
        Ok(Self { campaign, plan, group, may_kill_launcher, baseline })
    }

    /// Reads scenarios before anything runs: all of a small campaign, or evenly spread ones of a large one.
    fn check(&self) -> Result<(), Error> {
        let mut notices: BTreeSet<String> = BTreeSet::new();
        let mut targets = Targets::default();
        let stride = self.plan.len().div_ceil(MAX_CHECKED).max(1);
        let drawn = (0..self.plan.len()).step_by(stride).map(|place| self.plan.at(place));
        for planned in drawn.chain(self.plan.first_of_cases()) {
            let scenario = job(&self.campaign, &planned?)?.scenario;
            // Reading of OpenSCENARIO files.
            notices.extend(scenario.notices().map(str::to_owned));
            targets.note(&scenario);
        }
        targets.check()?;
        jobs::fault_free(&self.campaign, &self.plan)?;
        if self.plan.left_out() > 0 {
            let count = self.plan.left_out();
            notices.insert(format!(
                "{count} combinations break a constraint of the scenario and are left out"
            ));
        }
        notices.iter().for_each(|notice| report::print::note(&format!("note: {notice}")));
        Ok(())
    }
}

impl Study for FileCampaign {
    type Arguments = CampaignArguments;
    type Record = Record;
    type Seen = ();

    const NAME: &'static str = "campaign";
    const OWN_COLUMNS: &'static [Column<Record>] = RUNS;

    fn plan(arguments: &CampaignArguments, options: &RunOptions) -> Result<Self, Error> {
        let text = arguments.effective.as_deref().unwrap_or_default();
        let study = Self::of(Campaign::parse(parts::FILE, text)?, options)?;
        let read =
            |file: &PathBuf| Baseline::read(file, "the campaign.json of an earlier campaign");
        Ok(Self { baseline: arguments.against.as_ref().map(read).transpose()?, ..study })
    }

    fn subject(&self) -> Result<String, Error> {
        Ok(self.campaign.to_toml())
    }

    fn runs(&self) -> usize {
        self.plan.len()
    }

    fn mode(&self) -> Mode {
        self.campaign.mode
    }

    fn label(&self) -> String {
        self.campaign.name.as_str().to_owned()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        job(&self.campaign, &self.plan.at(run)?)
    }

    fn is_alone(&self, run: usize) -> Result<bool, Error> {
        Ok(self.may_kill_launcher && launcher_death::is_planned(&self.job(run)?.scenario))
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Recorded<Self> {
        let job = self.job(run)?;
        if !launcher_death::is_planned(&job.scenario) {
            return crew.drive_and_record(self, run, &job);
        }
        let (planned, mode) = (self.plan.at(run)?, self.campaign.mode);
        let record = launcher_death::run(&planned, &job.scenario, mode, crew.going_on())?;
        Ok((record, ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        // A run with faults that cannot be read does not begin.
        let planned = self.plan.at(run).map(|run| (run.fault, run.parameters.join(" ")));
        let (fault, parameters) = planned.unwrap_or_default();
        vec![("fault".to_owned(), fault), ("parameters".to_owned(), parameters)]
    }

    fn record(&self, run: usize, job: &Job, result: Result<Done, Error>) -> Recorded<Self> {
        Ok((Record::new(&self.plan.at(run)?, &job.scenario, &result), ()))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let Found { records, shard, .. } = found;
        let exposure = jobs::exposure(&self.campaign, &self.plan, &self.group)?;
        let mut sums = Sums::default();
        records.each(&mut |_, record| {
            sums.add(record);
            Ok(())
        })?;
        let is_mine = |run: &usize| shard.is_none_or(|shard| shard.holds(*run));
        let planned = (0..self.runs()).filter(is_mine).count();
        let scope = Scope { planned, is_part: shard.is_some() };
        let mut verdict = Verdict::new(&self.campaign, &self.plan, scope, exposure, &sums);
        if !verdict.ok {
            let mut blame = Blame::new(&self.plan, self.campaign.mode, verdict.broken_limits());
            records.each(&mut |_, record| Ok(blame.add(record)?))?;
            (verdict.failures, verdict.broken) = blame.found();
        }
        if shard.is_none() {
            let mut records_of = Vec::new();
            records.each(&mut |_, record| {
                records_of.push(columns::Run::of(record));
                Ok(())
            })?;
            verdict.samples = columns::samples(&records_of, self.campaign.mode);
        }
        // A part is compared when it is merged.
        let baseline = self.baseline.as_ref().filter(|_| shard.is_none());
        verdict.against = baseline.map(|file| file.judge(&verdict.samples)).transpose()?;
        let document = document(&verdict, &sums.all);
        Ok(match &verdict.against {
            Some(against) => against.onto(document),
            None => document,
        })
    }
}

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[command(after_help = "`timegap list` describes the built-in campaigns.")]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    pub campaign: String,
    /// Content of the campaign as it takes effect: a part then needs no other file.
    #[arg(skip)]
    pub effective: Option<String>,
    /// Do only N of the runs, drawn by the first seed
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// The first seed [default: as in the file]
    #[arg(long, value_name = "N")]
    pub first: Option<u32>,
    /// Runs of every combination, each with a seed of its own [default: as in the file]
    #[arg(long, value_name = "N")]
    pub seeds: Option<NonZeroU32>,
    /// Judge the runs by an earlier result, its campaign.json: a figure that got worse is status 1
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Laws that drive in place of the file's, and keys and requirements of all runs.
    #[command(flatten)]
    pub drives: DriveOptions,
}
