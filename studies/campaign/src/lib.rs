//! `timegap campaign`: many seeded runs with faults, and one verdict.
//!
//! A campaign file names scenarios, controllers, faults and what must hold. Each combination has a number of runs, and
//! each run draws its faults from its own seed. A run keeps one record; the verdict is made of the records alone. So a
//! campaign that was interrupted and resumed, or done in shards and merged, comes to the same verdict.
//!
//! ```text
//! file ─ plan ─► run 0 … run N-1 ─ job ─► drive ─ record ─► journal (a line per run, on the disk) ─► verdict
//!                                                                              └─ campaign.json, .csv, page
//! ```
//!
//! A collision counts as avoidable where braking with 6 m/s², 0.35 s after the need, would have avoided it (`reference`).
//! A campaign whose faults meet nothing fails (`exposure`), and so does one whose faults have no receiver (`targets`).
//!
//! | campaign | what it does | module |
//! |---|---|---|
//! | a file, `kills`, `messages`, `restarts`, `soak`, `takeovers` | faults of processes and of messages | this one |
//! | `radio` | frames that are lost, late and falsified | `radio` |
//! | `signals` | trips through corridors of signals, beside the fastest legal one | `signals` |
//! | `plausibility` | false alarms of the checks of the inputs, and their detection times | `plausibility` |
//!
//! ```toml
//! schema_version = 1
//! name = "lost-commands"
//! scenarios = ["following", "cut-in"]
//! seeds = 50
//!
//! [[faults]]
//! kind = "drop"
//! topic = "control/command"
//! probability = [0.1, 1.0] # one number between them is drawn for each run
//! at_s = [1.0, 20.0]
//! for_s = 5.0
//!
//! [require]
//! max_avoidable_collisions = 0
//! ```

mod arguments;
mod conclusion;
mod error;
mod exposure;
mod exposure_table;
mod file;
mod job;
mod launcher_death;
mod page;
mod plan;
mod planned;
mod plausibility;
mod print;
mod radio;
mod record;
mod records;
mod reference;
mod shards;
mod signals;
mod tally;
mod targets;
mod variation;
mod verdict;

use frame::batch::{self, Interrupt, Job, Source};
use frame::parts::ShardChoice;
use frame::parts::journal::Journal;
use group::Error;
use report::output::OutputDirectory;

pub use arguments::CampaignArguments;
use conclusion::{conclude, fault_free};
pub use error::CampaignError;
pub use file::BUILTIN;
use file::{Campaign, FILE};
use job::job;
use plan::Plan;
use record::Record;
use records::Records;
use shards::{Membership, merge};
use std::collections::BTreeSet;
use std::process::ExitCode;
use targets::Targets;

/// Campaigns that come from no file: their names and what they do.
pub const WITHOUT_FILE: [(&str, &str); 3] = [
    (file::RADIO, "2,000 drives through signals whose frames are lost, late and falsified"),
    (signals::NAME, "500 corridors of signals, `cacc-mpc` against an ACC that stops for them"),
    (plausibility::NAME, "how often and how fast the checks of the inputs find a false sender"),
];

/// Most scenarios that are read before anything runs.
const MAX_CHECKED: usize = 1_000;

/// Chooses the runs that are repeated in process groups.
const SAMPLE_SEED: u64 = 1;

/// Runs the command.
pub fn run(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    if arguments.campaign.as_deref() == Some(plausibility::NAME) {
        refuse_options(arguments, plausibility::NAME, &["--hours", "--seed"])?;
        return plausibility::run(arguments);
    }
    let given = [("--hours", arguments.hours.is_some()), ("--seed", arguments.seed.is_some())];
    if let Some((option, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
        return Err(CampaignError::OfPlausibility { option }.into());
    }
    if arguments.campaign.as_deref() == Some(file::RADIO) {
        if arguments.seeds.is_some() {
            return Err(CampaignError::NoSeeds.into());
        }
        return radio::drive(arguments);
    }
    if arguments.campaign.as_deref() == Some(signals::NAME) {
        refuse_options(arguments, signals::NAME, &["--first", "--seeds"])?;
        return signals::run(arguments);
    }
    if arguments.first.is_some() {
        return Err(CampaignError::FirstOfNone.into());
    }
    if radio::holds_parts(&arguments.parts.merge) {
        return radio::merge(arguments);
    }
    if arguments.parts.merge.is_empty() { drive(arguments) } else { merge(arguments) }
}

/// Refuses the options that choose runs, but those that `name` takes: it has one table of all its runs.
fn refuse_options(
    arguments: &CampaignArguments,
    name: &'static str,
    takes: &[&str],
) -> Result<(), CampaignError> {
    let given = [
        ("--sample", arguments.sample.is_some()),
        ("--first", arguments.first.is_some()),
        ("--seeds", arguments.seeds.is_some()),
        ("--shard", arguments.parts.shard.is_some()),
        ("--resume", arguments.parts.resume.is_some()),
    ];
    match given.into_iter().find(|(option, is_given)| *is_given && !takes.contains(option)) {
        Some((option, _)) => Err(CampaignError::NotForAll { option, name }),
        None => Ok(()),
    }
}

/// Does the runs that are not in the journal yet.
fn drive(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let campaign = open(arguments)?;
    let plan = plan::plan(&campaign)?;
    check(&campaign, &plan)?;
    let output = match &arguments.parts.resume {
        Some(directory) => OutputDirectory::resume(directory, FILE)?,
        None => OutputDirectory::create(&arguments.output, campaign.name.as_str())?,
    };
    output.write(FILE, campaign.to_toml().as_bytes())?;
    let mut records = Records::default();
    let mut kept = BTreeSet::new();
    let membership = Membership::of(output.path(), &campaign, &plan);
    records.begin(membership.journal());
    let mut each = |place, record: Record| {
        membership.check(record.run, &mut kept)?;
        records.add(record.run, place);
        Ok(())
    };
    let mut journal = Journal::open(output.path(), &mut each)?;
    let mine = || plan.numbers().filter(|run| campaign.shard.is_none_or(|shard| shard.holds(*run)));
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
        records.add(record.run, journal.add(&record)?);
        Ok(())
    };
    let end = batch::run_made(&repeated, &source, at_once, group, &bar, &mut each);
    if let Ok(sample) = &end {
        sample.print(left.len(), &bar);
    }
    let end = end.map(drop).and_then(|()| {
        let interrupt = Interrupt::watch()?;
        for run in apart {
            let planned = plan.get(run);
            let job = job(&campaign, &planned)?;
            let record = launcher_death::run(&planned, &job.scenario, campaign.mode, &interrupt)?;
            records.add(record.run, journal.add(&record)?);
            bar.inc(1);
        }
        Ok(())
    });
    bar.finish_and_clear();
    if end.is_err() {
        let (done, directory) = (records.len(), output.path().display());
        eprintln!(
            "{done} of {all} runs are kept; to continue: timegap campaign --resume {directory}"
        );
    }
    end?;
    conclude(arguments, &campaign, (&plan, all), records, &output)
}

/// Reads scenarios before anything runs: all of a small campaign, some from everywhere of a large one.
fn check(campaign: &Campaign, plan: &Plan) -> Result<(), Error> {
    let mut notices: BTreeSet<String> = BTreeSet::new();
    let mut targets = Targets::default();
    let stride = plan.len().div_ceil(MAX_CHECKED).max(1);
    for place in (0..plan.len()).step_by(stride) {
        let job = job(campaign, &plan.get(plan.number(place)))?;
        // What a person should know of how OpenSCENARIO files are run.
        notices.extend(job.scenario.notices().map(str::to_owned));
        targets.note(&job.scenario);
    }
    targets.check()?;
    fault_free(campaign, plan)?;
    for notice in notices {
        eprintln!("note: {notice}");
    }
    if plan.left_out() > 0 {
        let count = plan.left_out();
        eprintln!("note: {count} combinations break a constraint of the scenario and are left out");
    }
    Ok(())
}

/// The campaign that the arguments mean.
fn open(arguments: &CampaignArguments) -> Result<Campaign, Error> {
    let kept = arguments.parts.resume.as_deref().map(|directory| directory.join(FILE));
    let kept = kept.filter(|path| path.exists());
    let begun = kept.as_deref().map(Campaign::read).transpose()?;
    let mut asked = match (&arguments.campaign, &begun) {
        (Some(name), _) => Campaign::open(name)?,
        (None, Some(begun)) => begun.clone(),
        (None, None) => return Err(CampaignError::NoneNamed.into()),
    };
    if let Some(seeds) = arguments.seeds {
        asked.limit_seeds(seeds);
    }
    let shard = arguments.parts.shard.map(ShardChoice::resolve).transpose()?;
    asked.shard = shard.or(asked.shard);
    asked.sample = arguments.sample.or(asked.sample);
    match begun {
        Some(begun) if begun != asked => {
            let directory = arguments.parts.resume.clone().unwrap_or_default();
            Err(CampaignError::OtherBegun { directory }.into())
        }
        _ => Ok(asked),
    }
}
