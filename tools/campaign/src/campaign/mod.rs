//! `timegap campaign`: many seeded runs with faults, and one verdict.
//!
//! ```text
//! file ─ plan ─► batch ─ record ─► journal (one line per run, on the disk) ─► verdict
//! ```
//!
//! The verdict is made of the journal's records alone, so that a campaign which was interrupted and
//! resumed, or done in shards and merged, comes to the same one.

mod exposure;
mod file;
mod launcher_death;
mod page;
mod plan;
mod planned;
mod print;
mod record;
mod reference;
mod tally;
mod variation;
mod verdict;

use crate::batch::{self, Interrupt, Job, Source};
use crate::parts::journal::{self, Journal};
use crate::parts::{self, MergeError, Shard, ShardChoice};
use crate::plausibility;
use crate::radio;
use group::{Error, Failure, GroupOptions, ScenarioOptions};
use report::output::{OutputDirectory, OutputOptions};

use clap::Args;
use exposure::Exposure;
pub use file::BUILTIN;
use file::Campaign;
use plan::Plan;
pub(crate) use planned::Planned;
use record::Record;
use runtime::Mode;
use scenario::Scenario;
use scenario::faults::Kind;
use std::collections::BTreeSet;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;
use verdict::Verdict;

/// The campaign as it took effect, in its directory.
const FILE: &str = "campaign.toml";

/// Most scenarios that are read before anything runs.
const MAX_CHECKED: usize = 1_000;

/// Chooses the runs that are repeated in process groups.
const SAMPLE_SEED: u64 = 1;

/// The table of the controller's checks, which is no campaign of its own.
const PLAUSIBILITY: &str = "plausibility";

/// Why a campaign is not done.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// Nothing says which.
    #[error(
        "no campaign is named, expected a file or one of {}",
        BUILTIN.map(|builtin| builtin.name).join(", ")
    )]
    NoneNamed,
    /// The runs have no numbers that their draws come from.
    #[error("--first is for the campaign `{}` alone", radio::NAME)]
    FirstOfNone,
    /// The directory is another one's.
    #[error(
        "{} holds another campaign, or another shard of it, expected the one that it began with",
        directory.display()
    )]
    OtherBegun {
        /// The directory.
        directory: PathBuf,
    },
    /// In simulated time nothing is to be seen of a process fault.
    #[error(
        "a fault of kind `{kind}` acts on processes, expected mode = \"realtime\" in the campaign"
    )]
    FaultOfProcesses {
        /// Its kind.
        kind: Kind,
    },
    /// A journal has a run that is not of its part.
    #[error("{}: run {run} does not belong to this part of the campaign", path.display())]
    OtherPart {
        /// The journal.
        path: PathBuf,
        /// The run's number.
        run: usize,
    },
    /// A journal has a run that is known.
    #[error(
        "{}: run {run} is there twice, or in a directory before this one as well", path.display()
    )]
    Twice {
        /// The journal.
        path: PathBuf,
        /// The run's number.
        run: usize,
    },
}

impl Failure for CampaignError {}

/// Arguments of `campaign`.
#[derive(Debug, Args)]
#[command(
    after_help = "Built-in campaigns: kills, messages, restarts, soak, takeovers. `plausibility` prints how often and how \
fast the controller's checks of its inputs find a false sender, `radio` what becomes of frames that are lost, late \
and falsified (2,000 runs, or --sample N from --first M on)."
)]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    pub campaign: Option<String>,
    /// Do only N of the runs, drawn by the first seed
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Begin with run number N: `radio` alone
    #[arg(long, value_name = "N")]
    pub first: Option<NonZeroUsize>,
    /// Runs of every combination, instead of what the file says
    #[arg(long, value_name = "N")]
    pub seeds: Option<NonZeroU32>,
    /// Do only part I of N of the runs, or the part that the array job's environment names (`auto`,
    /// or `auto/N` where that does not tell the number); `--merge` puts the parts together
    #[arg(long, value_name = "I/N|auto")]
    pub shard: Option<ShardChoice>,
    /// Go on with the campaign in this directory; begin it there if there is none
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Put the shards in these directories together
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["campaign", "seeds", "sample", "first", "shard", "resume"])]
    pub merge: Vec<PathBuf>,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go, and in which form.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the verdict as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    if arguments.campaign.as_deref() == Some(PLAUSIBILITY) {
        return plausibility::run(&arguments.group, arguments.jobs, arguments.json);
    }
    if arguments.campaign.as_deref() == Some(radio::NAME) {
        return radio::drive(arguments);
    }
    if arguments.first.is_some() {
        return Err(CampaignError::FirstOfNone.into());
    }
    if radio::holds_parts(&arguments.merge) {
        return radio::merge(arguments);
    }
    if arguments.merge.is_empty() { drive(arguments) } else { merge(arguments) }
}

/// Does the runs that are not in the journal yet.
fn drive(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let campaign = open(arguments)?;
    let plan = plan::plan(&campaign)?;
    check(&campaign, &plan)?;
    let output = match &arguments.resume {
        Some(directory) => OutputDirectory::resume(directory)?,
        None => OutputDirectory::create(&arguments.output, campaign.name.as_str())?,
    };
    output.write(FILE, campaign.to_toml().as_bytes())?;
    let (mut journal, mut records) = Journal::open::<Record>(output.path())?;
    let mine = || plan.numbers().filter(|run| campaign.shard.is_none_or(|shard| shard.holds(*run)));
    let mut kept = BTreeSet::new();
    check_journal(&output.path().join(journal::FILE), &campaign, &plan, &records, &mut kept)?;
    let all = mine().count();
    let left: Vec<usize> = mine().filter(|run| !kept.contains(run)).collect();

    let bar = report::progress::count_bar(all, arguments.json);
    bar.set_message(campaign.name.as_str().to_owned());
    bar.set_position(records.len() as u64);
    bar.reset_eta();
    // A run whose launcher is killed is a command of its own.
    let (mut together, mut apart) = (Vec::new(), Vec::new());
    let may_be_apart = campaign.faults.iter().any(launcher_death::may_be);
    for run in left {
        let is_apart =
            may_be_apart && launcher_death::is_planned(&job(&campaign, &plan.get(run))?.scenario);
        if is_apart { apart.push(run) } else { together.push(run) }
    }
    let left = together;
    let at_once = batch::at_once(arguments.jobs, campaign.mode);
    // Chosen of the whole campaign, so that shards and resumed parts repeat the same ones.
    let sampled = batch::choose(SAMPLE_SEED, plan.len());
    let sampled: BTreeSet<usize> = sampled.into_iter().map(|place| plan.number(place)).collect();
    let repeated = (0..left.len()).filter(|&index| sampled.contains(&left[index])).collect();
    let group = &arguments.group;
    let source = Source { runs: left.len(), make: &|index| job(&campaign, &plan.get(left[index])) };
    let mut each = |index: usize, job: &Job, result| {
        let record = Record::new(&plan.get(left[index]), &job.scenario, result);
        journal.add(&record)?;
        records.push(journal::as_read_back(&record));
        Ok(())
    };
    let end = batch::run_made(&repeated, &source, at_once, group, &bar, &mut each);
    if let Ok(sample) = &end {
        sample.tell(left.len(), &bar);
    }
    let end = end.map(drop).and_then(|()| {
        let interrupt = Interrupt::watch()?;
        for run in apart {
            let planned = plan.get(run);
            let job = job(&campaign, &planned)?;
            let record = launcher_death::run(&planned, &job.scenario, campaign.mode, &interrupt)?;
            journal.add(&record)?;
            records.push(journal::as_read_back(&record));
            bar.inc(1);
        }
        Ok(())
    });
    bar.finish_and_clear();
    if end.is_err() {
        let (done, directory) = (records.len(), output.path().display());
        eprintln!("{done} of {all} runs are kept: timegap campaign --resume {directory} goes on");
    }
    end?;
    conclude(arguments, &campaign, (&plan, all), records, &output)
}

/// Reads scenarios before anything runs: all of a small campaign, some from everywhere of a large one.
fn check(campaign: &Campaign, plan: &Plan) -> Result<(), Error> {
    let mut notices: BTreeSet<String> = BTreeSet::new();
    let stride = plan.len().div_ceil(MAX_CHECKED).max(1);
    for place in (0..plan.len()).step_by(stride) {
        let job = job(campaign, &plan.get(plan.number(place)))?;
        // What a person should know of how OpenSCENARIO files are run.
        notices.extend(job.scenario.storyboard.into_iter().flat_map(|story| story.notices));
    }
    for notice in notices {
        eprintln!("note: {notice}");
    }
    if plan.left_out() > 0 {
        let count = plan.left_out();
        eprintln!("note: {count} combinations break a constraint of the scenario and are left out");
    }
    Ok(())
}

/// Checks that the records are of runs of this part, each once, and adds their numbers to `known`.
fn check_journal(
    journal: &Path,
    campaign: &Campaign,
    plan: &Plan,
    records: &[Record],
    known: &mut BTreeSet<usize>,
) -> Result<(), CampaignError> {
    let planned: BTreeSet<usize> = match campaign.sample {
        Some(_) => plan.numbers().collect(),
        None => BTreeSet::new(),
    };
    for record in records {
        let run = record.run;
        let path = || journal.to_owned();
        let in_plan =
            if campaign.sample.is_some() { planned.contains(&run) } else { run < plan.len() };
        if !in_plan || campaign.shard.is_some_and(|shard| !shard.holds(run)) {
            return Err(CampaignError::OtherPart { path: path(), run });
        }
        if !known.insert(run) {
            return Err(CampaignError::Twice { path: path(), run });
        }
    }
    Ok(())
}

/// Puts shards together.
fn merge(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let mut whole: Option<(Campaign, Plan)> = None;
    let mut records: Vec<Record> = Vec::new();
    let mut known = BTreeSet::new();
    let mut held: Vec<(Option<Shard>, &Path)> = Vec::new();
    for directory in &arguments.merge {
        let part = Campaign::read(&directory.join(FILE))?;
        let shard = part.shard;
        let other =
            |(whole, _): &(Campaign, Plan)| *whole != Campaign { shard: None, ..part.clone() };
        let count = |shard: Option<Shard>| shard.map(|shard| shard.count);
        if whole.as_ref().is_some_and(other)
            || held.first().is_some_and(|(first, _)| count(*first) != count(shard))
        {
            let (directory, name) = (directory.clone(), "campaign".into());
            return Err(MergeError::OtherStudy { directory, name }.into());
        }
        if let Some((_, before)) = held.iter().find(|(held, _)| *held == shard) {
            let (directory, before) = (directory.clone(), before.to_path_buf());
            return Err(MergeError::SamePart { directory, before }.into());
        }
        if whole.is_none() {
            let campaign = Campaign { shard: None, ..part.clone() };
            let plan = plan::plan(&campaign)?;
            whole = Some((campaign, plan));
        }
        let (_, plan) = whole.as_ref().expect("it was just made");
        let journal = directory.join(journal::FILE);
        let mine = journal::read::<Record>(&journal)?.0;
        check_journal(&journal, &part, plan, &mine, &mut known)?;
        records.extend(mine);
        held.push((shard, directory));
    }
    let (campaign, plan) = whole.expect("clap asks for at least one directory");
    let first = &arguments.merge[0];
    let planned: BTreeSet<usize> = plan.numbers().collect();
    let highest = planned.last().map_or(0, |last| last + 1);
    // What is not planned is nothing to be done.
    let done = |run: usize| known.contains(&run) || !planned.contains(&run);
    let command = |shard: Shard, directory: Option<&Path>| match directory {
        Some(directory) => format!("timegap campaign --resume {}", directory.display()),
        None => {
            let Shard { index, count } = shard;
            let file = first.join(FILE);
            format!(
                "timegap campaign {} --shard {index}/{count} --resume shard-{index}-of-{count}",
                file.display()
            )
        }
    };
    parts::name_incomplete(&parts::incomplete(&held, highest, &done, &command));
    let output = OutputDirectory::create(&arguments.output, campaign.name.as_str())?;
    conclude(arguments, &campaign, (&plan, plan.len()), records, &output)
}

/// Judges, writes and prints.
fn conclude(
    arguments: &CampaignArguments,
    campaign: &Campaign,
    (plan, planned): (&Plan, usize),
    records: Vec<Record>,
    output: &OutputDirectory,
) -> Result<ExitCode, Error> {
    let csv = print::csv(&records);
    let times = page::Times::of(&records);
    let exposure = exposure(campaign, plan, &arguments.group)?;
    let verdict = Verdict::new(campaign, plan, planned, exposure, records);
    let json = serde_json::to_string_pretty(&verdict).expect("plain data") + "\n";
    let written = output
        .write("campaign.csv", csv.as_bytes())
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
    let planned = if campaign.faults.is_empty() { Vec::new() } else { plan.without_faults() };
    let mut met = Vec::new();
    for planned in planned {
        let Job { mut scenario, .. } = job(campaign, &planned)?;
        scenario.faults.clear();
        let done = batch::lockstep(&scenario, group, false, &|| true)?;
        let controller = scenario.controller.name.as_str().to_owned();
        met.push(Exposure::of(planned.scenario, controller, &done.drive.steps));
    }
    Ok(met)
}

/// The campaign that the arguments mean.
fn open(arguments: &CampaignArguments) -> Result<Campaign, Error> {
    let kept = arguments.resume.as_deref().map(|directory| directory.join(FILE));
    let kept = kept.filter(|path| path.exists());
    let begun = kept.as_deref().map(Campaign::read).transpose()?;
    let mut asked = match (&arguments.campaign, &begun) {
        (Some(name), _) => Campaign::open(name)?,
        (None, Some(begun)) => begun.clone(),
        (None, None) => return Err(CampaignError::NoneNamed.into()),
    };
    asked.seeds = arguments.seeds.unwrap_or(asked.seeds);
    let shard = arguments.shard.map(ShardChoice::resolve).transpose()?;
    asked.shard = shard.or(asked.shard);
    asked.sample = arguments.sample.or(asked.sample);
    match begun {
        Some(begun) if begun != asked => {
            let directory = arguments.resume.clone().unwrap_or_default();
            Err(CampaignError::OtherBegun { directory }.into())
        }
        _ => Ok(asked),
    }
}

/// A planned run, checked.
fn job(campaign: &Campaign, planned: &Planned) -> Result<Job, Error> {
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
