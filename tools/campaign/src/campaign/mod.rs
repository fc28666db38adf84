//! `timegap campaign`: many seeded runs with faults, and one verdict.
//!
//! ```text
//! file ─ plan ─► batch ─ record ─► journal (one line per run, on the disk) ─► verdict
//! ```
//!
//! The verdict is made of the journal's records alone, so that a campaign which was interrupted and
//! resumed, or done in shards and merged, comes to the same one.

mod file;
mod journal;
mod page;
mod plan;
mod print;
mod record;
mod reference;
mod tally;
mod variation;
mod verdict;

use crate::batch::{self, Job};
use group::Error;
use group::{GroupOptions, ScenarioOptions};
use report::output::{OutputDirectory, OutputOptions};

use clap::Args;
pub use file::BUILTIN;
use file::{Campaign, Shard};
use journal::Journal;
use plan::Planned;
use record::Record;
use runtime::Mode;
use scenario::Scenario;
use std::collections::BTreeSet;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;
use verdict::Verdict;

/// The campaign as it took effect, in its directory.
const FILE: &str = "campaign.toml";

/// Chooses the runs that are repeated in process groups.
const SAMPLE_SEED: u64 = 1;

/// Arguments of `campaign`.
#[derive(Debug, Args)]
#[command(after_help = "Built-in campaigns: kills, messages, soak.")]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    pub campaign: Option<String>,
    /// Do only N of the runs, drawn by the first seed
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Runs of every combination, instead of what the file says
    #[arg(long, value_name = "N")]
    pub seeds: Option<NonZeroU32>,
    /// Do only part I of N of the runs; `--merge` puts the parts together
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Go on with the campaign in this directory; begin it there if there is none
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Put the shards in these directories together
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["campaign", "seeds", "sample", "shard", "resume"])]
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
    if arguments.merge.is_empty() { drive(arguments) } else { merge(arguments) }
}

/// Does the runs that are not in the journal yet.
fn drive(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let campaign = open(arguments)?;
    let plan = plan::plan(&campaign)?;
    let mine = shard(&campaign, &plan.runs);
    // Everything is read before anything runs.
    let mut jobs = Vec::with_capacity(mine.len());
    for planned in &mine {
        jobs.push(job(&campaign, planned)?);
    }
    note(&plan, &jobs);
    let output = match &arguments.resume {
        Some(directory) => OutputDirectory::resume(directory)?,
        None => OutputDirectory::create(&arguments.output, campaign.name.as_str())?,
    };
    output.write(FILE, campaign.to_toml().as_bytes())?;
    let (mut journal, mut records) = Journal::open::<Record>(output.path())?;
    let (planned, jobs): (Vec<_>, Vec<_>) = (mine.iter().copied().zip(jobs))
        .filter(|(planned, _)| records.iter().all(|record| record.run != planned.run))
        .unzip();

    let bar = report::progress::count_bar(mine.len(), arguments.json);
    bar.set_message(campaign.name.as_str().to_owned());
    bar.set_position(records.len() as u64);
    bar.reset_eta();
    let at_once = batch::at_once(arguments.jobs, campaign.mode);
    // Chosen of the whole campaign, so that shards and resumed parts repeat the same ones.
    let sampled = batch::choose(SAMPLE_SEED, plan.runs.len());
    let sampled: BTreeSet<usize> = sampled.into_iter().map(|k| plan.runs[k].run).collect();
    let repeated =
        (0..planned.len()).filter(|&index| sampled.contains(&planned[index].run)).collect();
    let group = &arguments.group;
    let mut each = |index: usize, result| {
        let record = Record::new(planned[index], &jobs[index].scenario, result);
        journal.add(&record)?;
        records.push(record);
        Ok(())
    };
    let end = batch::run_repeating(&repeated, &jobs, at_once, group, &bar, &mut each);
    if let Ok(sample) = &end {
        sample.tell(jobs.len(), &bar);
    }
    bar.finish_and_clear();
    if end.is_err() {
        let (done, all, directory) = (records.len(), mine.len(), output.path().display());
        eprintln!("{done} of {all} runs are kept: timegap campaign --resume {directory} goes on");
    }
    end?;
    conclude(arguments, &campaign, (&mine, plan.left_out), records, &output)
}

/// Says what a person should know of how OpenSCENARIO files are run.
fn note(plan: &plan::Plan, jobs: &[Job]) {
    let storyboards = jobs.iter().filter_map(|job| job.scenario.storyboard.as_ref());
    let notices: BTreeSet<&String> =
        storyboards.flat_map(|storyboard| &storyboard.notices).collect();
    for notice in notices {
        eprintln!("note: {notice}");
    }
    if plan.left_out > 0 {
        let count = plan.left_out;
        eprintln!("note: {count} combinations break a constraint of the scenario and are left out");
    }
}

/// Puts shards together.
fn merge(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let mut whole: Option<Campaign> = None;
    let mut records: Vec<Record> = Vec::new();
    for directory in &arguments.merge {
        let part = Campaign { shard: None, ..Campaign::read(&directory.join(FILE))? };
        if whole.as_ref().is_some_and(|whole| *whole != part) {
            let what = "is part of another campaign than the directories before it";
            return Err(Error::Usage(format!("{} {what}", directory.display())));
        }
        whole = Some(part);
        for record in journal::read::<Record>(&directory.join(journal::FILE))?.0 {
            if records.iter().any(|known| known.run == record.run) {
                let (directory, run) = (directory.display(), record.run);
                let what = format!("{directory}: run {run} is in a directory before it as well");
                return Err(Error::Usage(what));
            }
            records.push(record);
        }
    }
    let campaign = whole.expect("clap asks for at least one directory");
    let plan = plan::plan(&campaign)?;
    let output = OutputDirectory::create(&arguments.output, campaign.name.as_str())?;
    let all = plan.runs.iter().collect::<Vec<_>>();
    conclude(arguments, &campaign, (&all, plan.left_out), records, &output)
}

/// Judges, writes and prints.
fn conclude(
    arguments: &CampaignArguments,
    campaign: &Campaign,
    (planned, left_out): (&[&Planned], usize),
    records: Vec<Record>,
    output: &OutputDirectory,
) -> Result<ExitCode, Error> {
    let csv = print::csv(&records);
    let times = page::Times::of(&records);
    let verdict = Verdict { left_out, ..Verdict::new(campaign, planned, records) };
    let json = serde_json::to_string_pretty(&verdict).expect("plain data") + "\n";
    let written = output
        .write("campaign.csv", csv.as_bytes())
        .and_then(|()| output.write("campaign.json", json.as_bytes()))
        .and_then(|()| output.write(report::FILE, page::page(&verdict, &times).as_bytes()));
    if arguments.json {
        report::print::out(&json)?;
    } else {
        let results = format!("results: {}\n", output.path().display());
        let page = format!("report:  {}\n", output.path().join(report::FILE).display());
        report::print::out(&(print::verdict(&verdict) + &results + &page))?;
    }
    // What was measured has been told before a full disk is.
    written?;
    Ok(if verdict.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The campaign that the arguments mean.
fn open(arguments: &CampaignArguments) -> Result<Campaign, Error> {
    let kept = arguments.resume.as_deref().map(|directory| directory.join(FILE));
    let kept = kept.filter(|path| path.exists());
    let begun = kept.as_deref().map(Campaign::read).transpose()?;
    let mut asked = match (&arguments.campaign, &begun) {
        (Some(name), _) => Campaign::open(name)?,
        (None, Some(begun)) => begun.clone(),
        (None, None) => {
            let names = BUILTIN.map(|builtin| builtin.name).join(", ");
            let what = "no campaign is named, expected a file or one of";
            return Err(Error::Usage(format!("{what} {names}")));
        }
    };
    asked.seeds = arguments.seeds.unwrap_or(asked.seeds);
    asked.shard = arguments.shard.or(asked.shard);
    asked.sample = arguments.sample.or(asked.sample);
    match begun {
        Some(begun) if begun != asked => Err(Error::Usage(format!(
            "{} holds another campaign, or another shard of it, expected the one that it began with",
            arguments.resume.as_deref().unwrap_or(Path::new("")).display()
        ))),
        _ => Ok(asked),
    }
}

/// The runs of the campaign's shard.
fn shard<'a>(campaign: &Campaign, plan: &'a [Planned]) -> Vec<&'a Planned> {
    let held = |run: &&Planned| campaign.shard.is_none_or(|shard| shard.holds(run.run));
    plan.iter().filter(held).collect()
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
    Ok(Job { scenario, mode: campaign.mode, sample_every })
}

/// In simulated time nothing is to be seen of a process fault.
fn refuse_faults_of_processes(scenario: &Scenario) -> Result<(), Error> {
    match scenario.faults.iter().find(|fault| fault.effect.of_processes().is_some()) {
        None => Ok(()),
        Some(fault) => Err(Error::Usage(format!(
            "a fault of kind `{}` acts on processes, expected mode = \"realtime\" in the campaign",
            fault.effect.kind()
        ))),
    }
}
