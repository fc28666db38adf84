//! The way of every study: plan, runs, judgement, results.

use std::collections::BTreeMap;
use std::process::ExitCode;

use indicatif::ProgressBar;
use report::output::OutputDirectory;
use report::results::ResultOptions;
use supervise::{Error, GroupOptions};

use super::command::{Command, MergeArguments, ResumeArguments, RunOptions};
use super::crew::{Crew, Observed};
use super::verify::Verify;
use super::{Found, Needs, Recorded, Study};
use crate::keep::{self, Keeper, Key};
use crate::parts::{
    Begun, Merged, Part, PartFile, Shard, ShardChoice, SoFar, name_incomplete, resume_command,
};
use crate::{batch, drives};

pub fn run<S: Study>(command: &Command<S::Arguments>) -> Result<ExitCode, Error> {
    let Command { study: arguments, options } = command;
    let study = S::plan(arguments, options)?;
    let shard = options.shard.map(ShardChoice::resolve).transpose()?;
    let file = part_of(&study, arguments, &options.group, shard)?;
    let output = match &options.resume {
        Some(path) => OutputDirectory::resume(path, crate::parts::FILE)?,
        None => OutputDirectory::create(&options.results.output, &study.label())?,
    };
    let mut part = Part::<S::Record>::open(file, &output)?;
    part.records.each(&mut |run, record| {
        study.recall(run, record);
        Ok(())
    })?;
    let left = part.left();
    let bar = report::print::count_bar(part.runs(), options.results.json);
    bar.set_message(study.label());
    bar.set_position((part.runs() - left.len()) as u64);
    bar.reset_eta();
    let keeper = options.keep.map(|keep| Keeper::new(keep, &output, &left, columns(&study, &left)));
    let mut seen = BTreeMap::new();
    let begun = part.take_begun();
    let end = all(&study, options, &mut part, &mut seen, keeper.as_ref(), (&bar, begun, &output));
    bar.finish_and_clear();
    let end = match end {
        // Nothing is left of a study without a result: what the directory held before comes back.
        Err(error) if part.records.is_empty() && !part.has_begun(&output) => return Err(error),
        end => end,
    };
    output.keep();
    if let Some(keeper) = keeper {
        let kept = keeper.finish()?;
        let place = output.path().join(keep::FILE);
        report::print::note(&format!("trajectories kept: {kept} in {}", place.display()));
    }
    match end {
        Ok(()) => part.end(&output),
        Err(_) => {
            let (done, all) = (part.records.len(), part.runs());
            let command = resume_command(output.path());
            eprintln!("{done} of {all} runs are kept; to continue: {command}");
        }
    }
    // Without a run there is nothing to judge.
    if S::NEEDS != Needs::Any || part.records.is_empty() {
        end?;
        return conclude(&study, options, part, seen, &output, Ok(()));
    }
    conclude(&study, options, part, seen, &output, end)
}

/// Goes on with the part in a directory by the arguments that it began with, or begins another part of its study.
pub(crate) fn resume<S: Study>(
    arguments: &ResumeArguments,
    part: PartFile,
) -> Result<ExitCode, Error> {
    let study = part.arguments(&arguments.directory)?;
    let options = RunOptions {
        shard: arguments.shard.or(part.shard).map(ShardChoice::Given),
        resume: arguments.shard.is_none().then(|| arguments.directory.clone()),
        jobs: arguments.jobs,
        results: arguments.results.clone(),
        ..options_of(&part)
    };
    run::<S>(&Command { study, options })
}

/// Joins parts. Pictures are not kept in parts.
pub(crate) fn merge<S: Study>(
    arguments: &MergeArguments,
    part: PartFile,
) -> Result<ExitCode, Error> {
    let MergeArguments { parts, results } = arguments;
    let merged = Merged::<S::Record>::read(parts, results.output.out.as_deref())?;
    let own = part.arguments(&parts[0])?;
    let study = S::plan(&own, &options_of(&part))?;
    let now = part_of(&study, &own, &part.group, part.shard)?;
    merged.check(&now)?;
    name_incomplete(&merged.incomplete);
    let is_whole = merged.incomplete.is_empty();
    if !is_whole && S::NEEDS == Needs::All {
        return Ok(ExitCode::FAILURE);
    }
    let output = OutputDirectory::create(&results.output, &study.label())?;
    let records = merged.records;
    drives::write(
        &|take| records.each_drive(take),
        &columns(&study, &[0]),
        S::OWN_COLUMNS,
        &output,
    )?;
    let directory = output.path().to_owned();
    let seen = BTreeMap::new();
    let document = study.judge(Found { records, seen, shard: None, is_whole, directory })?;
    results.deliver(&document, &output)?;
    Ok(if is_whole { document.exit_code() } else { ExitCode::FAILURE })
}

/// The part `shard` of a study, as its directory describes it.
fn part_of<S: Study>(
    study: &S,
    arguments: &S::Arguments,
    group: &GroupOptions,
    shard: Option<Shard>,
) -> Result<PartFile, Error> {
    Ok(PartFile::new(S::NAME, arguments, group, (study.runs(), &study.subject()?), shard))
}

fn options_of(part: &PartFile) -> RunOptions {
    RunOptions {
        shard: None,
        resume: None,
        keep: None,
        jobs: None,
        verify_processes: false,
        group: part.group.clone(),
        results: ResultOptions::default(),
    }
}

/// Does all runs of the part that are left, those that must be alone last.
fn all<S: Study>(
    study: &S,
    options: &RunOptions,
    part: &mut Part<S::Record>,
    seen: &mut BTreeMap<usize, S::Seen>,
    keeper: Option<&Keeper>,
    (bar, begun, output): (&ProgressBar, (Begun, BTreeMap<usize, SoFar>), &OutputDirectory),
) -> Result<(), Error> {
    let (mut together, mut alone) = (Vec::new(), Vec::new());
    for run in part.left() {
        if study.is_alone(run)? { alone.push(run) } else { together.push(run) }
    }
    let verify = match options.verify_processes {
        true => Verify::some_of(study.runs()),
        false => Verify::default(),
    };
    let observed = Observed::new(keeper, verify, bar, begun);
    let mut keep = |run: usize, gave: Recorded<S>| {
        let (record, picture) = gave?;
        if let Some(keeper) = keeper {
            keeper.settle(run)?;
        }
        seen.insert(run, picture);
        output.keep();
        part.keep(run, record, observed.end(run))
    };
    let at_once = batch::at_once(options.jobs, study.mode());
    for (runs, at_once) in [(together, at_once), (alone, 1)] {
        let work = |place: usize, going_on: &dyn Fn() -> bool| {
            let crew = Crew::new(&options.group, going_on, &observed);
            study.drive(runs[place], &crew)
        };
        let mut each = |place: usize, gave| keep(runs[place], gave);
        // The runs count their own steps.
        batch::share(runs.len(), at_once, &ProgressBar::hidden(), &work, &mut each)?;
    }
    if options.verify_processes {
        let count = observed.verified();
        report::print::note(&format!(
            "{count} drives were repeated in process groups: the same bytes"
        ));
    }
    Ok(())
}

/// The keys of all runs, by those of `runs`.
fn columns<S: Study>(study: &S, runs: &[usize]) -> Vec<Key> {
    let runs = runs.iter().filter(|run| **run < study.runs());
    keep::keys(runs.map(|run| study.keys(*run)))
}

/// Judges, writes and prints the runs that were done; after an interrupt some are missing.
fn conclude<S: Study>(
    study: &S,
    options: &RunOptions,
    part: Part<S::Record>,
    seen: BTreeMap<usize, S::Seen>,
    output: &OutputDirectory,
    end: Result<(), Error>,
) -> Result<ExitCode, Error> {
    let (shard, runs) = (part.shard(), part.runs());
    let records = part.records;
    if let Some(shard) = shard {
        let (name, directory) = (String::from(shard), output.path().display());
        eprintln!("shard {name}: {runs} runs in {directory}; timegap merge puts all together");
        if S::NEEDS == Needs::All {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let is_whole = records.len() == runs;
    drives::write(&|take| records.each_drive(take), &columns(study, &[0]), S::OWN_COLUMNS, output)?;
    let directory = output.path().to_owned();
    let document = study.judge(Found { records, seen, shard, is_whole, directory })?;
    match end {
        Ok(()) => options.results.deliver(&document, output)?,
        Err(error) => {
            options.results.deliver_interrupted(&document, output)?;
            return Err(error);
        }
    }
    Ok(document.exit_code())
}
