//! The parts of a campaign: whose a journal's runs are, and all of them put together.

use super::arguments::CampaignArguments;
use super::conclusion::conclude;
use super::error::CampaignError;
use super::file::{Campaign, FILE};
use super::plan::{self, Plan};
use super::records::{self, Records};
use frame::parts::journal;
use frame::parts::{self, MergeError, Shard};
use group::Error;
use report::output::OutputDirectory;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Refuses runs that are not of a part, and those that are there twice.
pub struct Membership<'a> {
    part: &'a Campaign,
    plan: &'a Plan,
    /// Runs of a sample; none where all are planned.
    sampled: Option<BTreeSet<usize>>,
    journal: PathBuf,
}

impl<'a> Membership<'a> {
    /// Of the runs in the journal of that directory.
    pub fn of(directory: &Path, part: &'a Campaign, plan: &'a Plan) -> Self {
        let sampled = part.sample.map(|_| plan.numbers().collect());
        Self { part, plan, sampled, journal: directory.join(journal::FILE) }
    }

    /// The journal.
    pub fn journal(&self) -> &Path {
        &self.journal
    }

    /// Adds a run to those that are `known`.
    ///
    /// # Errors
    /// [`CampaignError::OtherPart`], [`CampaignError::Twice`].
    pub fn check(&self, run: usize, known: &mut BTreeSet<usize>) -> Result<(), CampaignError> {
        let path = || self.journal.clone();
        let is_planned = match &self.sampled {
            Some(sampled) => sampled.contains(&run),
            None => run < self.plan.len(),
        };
        if !is_planned || self.part.shard.is_some_and(|shard| !shard.holds(run)) {
            return Err(CampaignError::OtherPart { path: path(), run });
        }
        if !known.insert(run) {
            return Err(CampaignError::Twice { path: path(), run });
        }
        Ok(())
    }
}

/// Puts shards together.
pub fn merge(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    parts::refuse_into_part(&arguments.parts.merge, arguments.output.out.as_deref())?;
    let mut whole: Option<(Campaign, Plan)> = None;
    let mut records = Records::default();
    let mut known = BTreeSet::new();
    let mut held: Vec<(Option<Shard>, &Path)> = Vec::new();
    for directory in &arguments.parts.merge {
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
        let membership = Membership::of(directory, &part, plan);
        let mut check = |run| Ok(membership.check(run, &mut known)?);
        records::read(&mut records, membership.journal(), &mut check)?;
        held.push((shard, directory));
    }
    let (campaign, plan) = whole.expect("clap asks for at least one directory");
    let first = &arguments.parts.merge[0];
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
