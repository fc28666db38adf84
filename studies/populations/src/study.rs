//! The one engine: each drive of a population is a run of a study.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;

use clap::Args;
use frame::batch::{Done, Job};
use frame::{Found, Recorded, RunOptions, Study};
use report::figures::Values;
use report::results::Document;
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use supervise::{Error, UsageError};

use crate::population::{Drive, DriveOptions, Planned, Population};
use crate::results;

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct PopulationArguments {
    /// Number of scenes [default: the population's]
    #[arg(long, value_name = "N")]
    pub seeds: Option<NonZeroUsize>,
    /// Number of the first scene
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub first: usize,
    /// Do only the drives with one of these kinds, laws or other words (repeatable: one of each list)
    #[arg(long, value_name = "WORD,...")]
    pub only: Vec<String>,
    /// Laws, keys and requirements of all drives.
    #[command(flatten)]
    pub drives: DriveOptions,
    /// Print the effect of each number of a table instead: of a law's, `following`, `plausibility` or `v2x-sim`
    #[arg(long, value_name = "TABLE")]
    pub effects: Option<String>,
}

/// A population with its drives.
pub struct Test<P> {
    population: P,
    pub drives: Vec<Planned>,
    pub options: DriveOptions,
}

impl<P: Population> Test<P> {
    /// The drives that the arguments mean.
    pub fn of(arguments: &PopulationArguments) -> Result<Self, Error> {
        let PopulationArguments { first, drives: options, .. } = arguments;
        options.laws.check()?;
        let named = match options.controllers.as_slice() {
            [] => options.laws.names(),
            _ => options.own_named()?,
        };
        let population = P::new(named)?;
        let count = arguments.seeds.map_or(P::NUMBERS, NonZeroUsize::get);
        let mut drives = population.plan(*first..*first + count);
        for only in &arguments.only {
            let is = |word: &String| only.split(',').any(|one| one == word);
            let has = |drive: &Planned| is(&drive.law) || drive.keys.iter().any(is);
            if !drives.iter().any(has) {
                let words =
                    drives.into_iter().flat_map(|drive| [drive.keys, vec![drive.law]].concat());
                let words: BTreeSet<String> = words.filter(|word| !word.is_empty()).collect();
                let words = words.into_iter().collect::<Vec<_>>().join(", ");
                let why = format!("no drive of `{}` has it", P::NAME);
                return Err(UsageError::option("--only", only, why, words).into());
            }
            drives.retain(has);
        }
        Ok(Self { population, drives, options: options.clone() })
    }

    pub fn scenario(&self, planned: &Planned) -> Result<Scenario, Error> {
        self.population.scenario(planned, &self.options)
    }

    /// The command that repeats a drive.
    pub fn repeat(&self, planned: &Planned) -> String {
        let Planned { number, law, keys } = planned;
        let number = number.to_string();
        let mut words = vec!["timegap", "test", P::NAME, "--first", &number, "--seeds", "1"];
        words.extend(
            keys.iter().chain([law]).filter(|key| !key.is_empty()).flat_map(|key| ["--only", key]),
        );
        let controllers = self.options.controllers.join(",");
        if !controllers.is_empty() {
            words.extend(["--controllers", &controllers]);
        }
        let options = self.options.words();
        words.extend(options.iter().map(String::as_str));
        runtime::command_line(&words)
    }

    /// What the judge says of a drive.
    pub fn judged(&self, planned: &Planned, scenario: &Scenario, done: &Done) -> Drive<P::Facts> {
        let summary = &done.summary;
        Drive {
            planned: planned.clone(),
            outcome: summary.outcome,
            aborted_because: summary.aborted_because.clone(),
            duration_s: summary.duration_s,
            figures: Values::of(summary),
            requirements: summary.requirements.clone(),
            facts: self.population.judge(planned, scenario, done),
        }
    }
}

impl<P: Population> Study for Test<P> {
    type Arguments = PopulationArguments;
    type Record = Drive<P::Facts>;
    type Seen = ();

    const NAME: &'static str = P::NAME;

    fn plan(arguments: &PopulationArguments, _: &RunOptions) -> Result<Self, Error> {
        Self::of(arguments)
    }

    fn runs(&self) -> usize {
        self.drives.len()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        Ok(Job::lockstep(self.scenario(&self.drives[run])?))
    }

    fn record(&self, run: usize, job: &Job, result: Result<Done, Error>) -> Recorded<Self> {
        Ok((self.judged(&self.drives[run], &job.scenario, &result?), ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let Planned { number, keys, .. } = &self.drives[run];
        let own = P::KEYS.iter().zip(keys).map(|(name, key)| ((*name).to_owned(), key.clone()));
        [("number".to_owned(), number.to_string())].into_iter().chain(own).collect()
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let drives: Vec<_> = found.records.all()?.into_iter().map(|(_, drive)| drive).collect();
        Ok(results::document::<P>(&drives, &|planned| self.repeat(planned), &|planned| {
            self.scenario(planned)
        }))
    }
}
