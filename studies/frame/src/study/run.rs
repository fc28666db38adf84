//! The way of every study: plan, runs, judgement, results.

use std::collections::BTreeMap;
use std::process::ExitCode;

use group::{Error, GroupOptions};
use indicatif::ProgressBar;
use report::output::OutputDirectory;

use super::crew::Observed;
use super::{Crew, Found, Needs, Options, RunResult, Study};
use crate::batch::{self, ProcessesSample};
use crate::drives;
use crate::keep::{self, Keeper, Key};
use crate::parts::{self, Begun, Merged, Part, PartOptions, ShardChoice, SoFar, name_incomplete};

/// Runs the command of a study.
///
/// # Errors
/// Mistakes in the arguments, reasons why the runs do not start, an interrupt, or a file that cannot be written.
pub fn run<S: Study>(arguments: &S::Arguments) -> Result<ExitCode, Error> {
    match S::options(arguments).parts {
        Some(parts) if !parts.merge.is_empty() => merge::<S>(arguments, parts),
        _ => drive::<S>(arguments),
    }
}

/// Does the runs that are left of this part.
fn drive<S: Study>(arguments: &S::Arguments) -> Result<ExitCode, Error> {
    let given = S::options(arguments);
    let mut parts = given.parts.cloned().unwrap_or_default();
    let mut group = given.group.clone();
    let (study, subject) = match parts::begun(&parts).transpose()? {
        Some((directory, begun)) => {
            let own = begun.study.arguments()?;
            group = GroupOptions { processes: group.processes, ..S::options(&own).group.clone() };
            parts.shard = parts.shard.or(begun.shard.map(ShardChoice::Given));
            let study = S::reopen(&own, &directory)?;
            let subject = begun.study.now(study.runs(), &study.subject()?);
            (study, subject)
        }
        None => {
            let study = S::plan(arguments)?;
            let subject = parts::Study::of_command(study.runs(), &study.subject()?);
            (study, subject)
        }
    };
    let options = Options { group: &group, ..given };
    let results = options.results;
    let (mut part, output) = Part::<S::Record>::open(
        &study.label(),
        &parts,
        &results.output,
        subject,
        S::KEEPS_JOURNAL,
    )?;
    if let Some((name, text)) = study.inputs() {
        output.write(name, text.as_bytes())?;
    }
    part.records().each(&mut |run, record| {
        study.recall(run, record);
        Ok(())
    })?;
    let begun = part.take_begun();
    for (run, so_far) in &begun.1 {
        study.recall_begun(*run, &so_far.values);
    }
    let bar = report::progress::count_bar(steps(&study, part.mine()), results.json);
    bar.set_message(study.label());
    let mut seen = BTreeMap::new();
    let keeper = S::keep(arguments)
        .map(|keep| Keeper::new(keep, &output, &part.left(), study.columns(&part.left())));
    let end = all(&study, options, &mut part, &mut seen, keeper.as_ref(), (&bar, begun));
    bar.finish_and_clear();
    if let Some(keeper) = keeper {
        let kept = keeper.finish()?;
        let place = output.path().join(keep::FILE);
        report::print::note(&format!("trajectories kept: {kept} in {}", place.display()));
    }
    match end {
        Ok(()) => part.end(&output),
        Err(_) => part.print_how_to_continue(&output),
    }
    // Without a run there is nothing to judge.
    if S::NEEDS != Needs::Any || part.records().is_empty() {
        end?;
        return conclude(&study, options, part, seen, &output, Ok(()));
    }
    conclude(&study, options, part, seen, &output, end)
}

/// Does all runs of the part that are left, those that must be alone last.
fn all<S: Study>(
    study: &S,
    options: Options<'_>,
    part: &mut Part<S::Record>,
    seen: &mut BTreeMap<usize, S::Seen>,
    keeper: Option<&Keeper>,
    (bar, begun): (&ProgressBar, (Begun, BTreeMap<usize, SoFar>)),
) -> Result<(), Error> {
    let left = part.left();
    let before = steps(study, part.mine()) - steps(study, left.iter().copied());
    bar.set_position(before as u64);
    bar.reset_eta();
    let (mut together, mut alone) = (Vec::new(), Vec::new());
    for &run in &left {
        if study.is_alone(run)? { alone.push(run) } else { together.push(run) }
    }
    let sampled = part.sampled(study.seed());
    let mut sample = ProcessesSample::default();
    let observed = Observed::new(keeper, bar, begun);
    let mut keep = |run: usize, gave: Result<RunResult<S::Record, S::Seen>, Error>| {
        let RunResult { record, seen: picture, repetition } = gave?;
        if let Some(line) = study.notice(&record) {
            bar.suspend(|| report::print::note(&line));
        }
        sample.count(run, repetition.as_ref());
        if let Some(keeper) = keeper {
            keeper.settle(run)?;
        }
        seen.insert(run, picture);
        let drives = observed.end(run, study.steps(run) as u64);
        part.keep(run, record, drives, repetition.as_ref())
    };
    let at_once = batch::at_once(options.jobs, study.mode());
    for (runs, at_once) in [(together, at_once), (alone, 1)] {
        let work = |place: usize, going_on: &dyn Fn() -> bool| {
            let crew = Crew::new(options.group, &sampled, going_on, &observed);
            study.drive(runs[place], &crew)
        };
        let mut each = |place: usize, gave| keep(runs[place], gave);
        // The runs count their own steps.
        batch::share(runs.len(), at_once, &ProgressBar::hidden(), &work, &mut each)?;
    }
    sample.print(left.len(), bar);
    Ok(())
}

/// Steps of runs, as the progress bar counts them.
fn steps<S: Study>(study: &S, runs: impl Iterator<Item = usize>) -> usize {
    runs.map(|run| study.steps(run)).sum()
}

/// Joins parts. Pictures are not kept in parts.
fn merge<S: Study>(arguments: &S::Arguments, parts: &PartOptions) -> Result<ExitCode, Error> {
    let options = S::options(arguments);
    let out = options.results.output.out.as_deref();
    let merged = Merged::<S::Record>::read(S::NAME, &parts.merge, out)?;
    let study = S::reopen(&merged.study.arguments()?, &parts.merge[0])?;
    merged.check(study.runs(), &study.subject()?)?;
    name_incomplete(&merged.incomplete);
    let is_whole = merged.incomplete.is_empty();
    if !is_whole && S::NEEDS == Needs::All {
        return Ok(ExitCode::FAILURE);
    }
    let output = OutputDirectory::create(&options.results.output, &study.label())?;
    let Merged { records, sample, .. } = merged;
    let seen = BTreeMap::new();
    let sample = agreed(&study, sample)?;
    drives::write(&records, &columns(&study), &study.own_columns(), &output)?;
    let directory = output.path().to_owned();
    let found = Found { records, seen, sample, shard: None, is_whole, directory };
    let document = study.judge(found)?;
    options.results.deliver(&document, &output)?;
    Ok(if is_whole { document.exit_code() } else { ExitCode::FAILURE })
}

/// The keys of all runs, those of the first.
fn columns<S: Study>(study: &S) -> Vec<Key> {
    if study.runs() > 0 { study.columns(&[0]) } else { Vec::new() }
}

/// The sample, unless it ends the study.
fn agreed<S: Study>(study: &S, sample: ProcessesSample) -> Result<ProcessesSample, Error> {
    if S::JUDGES_SAMPLE {
        return Ok(sample);
    }
    Ok(sample.agreed(|run| study.describe(run))?)
}

/// Judges, writes and prints the runs that were done; after an interrupt some are missing.
fn conclude<S: Study>(
    study: &S,
    options: Options<'_>,
    part: Part<S::Record>,
    seen: BTreeMap<usize, S::Seen>,
    output: &OutputDirectory,
    end: Result<(), Error>,
) -> Result<ExitCode, Error> {
    let (shard, runs) = (part.shard(), part.runs());
    let (records, sample) = part.into_records();
    let (sample, end) = match end.and_then(|()| agreed(study, sample)) {
        Ok(sample) => (sample, Ok(())),
        Err(error) if S::NEEDS == Needs::Any => (ProcessesSample::default(), Err(error)),
        Err(error) => return Err(error),
    };
    if let Some(shard) = shard {
        let (name, directory) = (String::from(shard), output.path().display());
        let command = S::NAME;
        eprintln!(
            "shard {name}: {runs} runs in {directory}; timegap {command} --merge puts all together"
        );
        if S::NEEDS == Needs::All {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let is_whole = records.len() == runs;
    drives::write(&records, &columns(study), &study.own_columns(), output)?;
    let directory = output.path().to_owned();
    let document = study.judge(Found { records, seen, sample, shard, is_whole, directory })?;
    match end {
        Ok(()) => options.results.deliver(&document, output)?,
        Err(error) => {
            options.results.deliver_interrupted(&document, output)?;
            return Err(error);
        }
    }
    Ok(document.exit_code())
}
