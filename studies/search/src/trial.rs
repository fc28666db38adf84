//! Values driven on several seeds, some at once.

use std::num::NonZeroUsize;
use std::sync::Mutex;

use frame::batch::{self, Done};
use group::{Error, GroupOptions};
use indicatif::ProgressBar;
use runtime::Mode;
use scenario::Scenario;

use crate::method::seed_of;
use crate::minimal::{Held, Trial};
use crate::problem::{Problem, Value};
use crate::value::{Judged, judge};

/// Drives in the worker's threads.
pub struct Seeds<'a> {
    pub problem: &'a Problem,
    /// Start of processes.
    pub group: &'a GroupOptions,
    /// Runs at once; none: one per core.
    pub jobs: Option<NonZeroUsize>,
    pub seed: u64,
    /// Number of seeds.
    pub count: usize,
    /// Counts the runs.
    pub bar: &'a ProgressBar,
}

/// The text of a file that `timegap run` repeats. A fault with nothing to act on has no effect. A single run refuses
/// it, so the file leaves it out.
pub fn repeatable(scenario: &Scenario) -> String {
    let mut repeatable = scenario.clone();
    repeatable.faults.retain(|fault| group::absent(fault, scenario).is_none());
    repeatable.to_toml()
}

impl Seeds<'_> {
    fn run(&self, values: &[Value], seed: u64, going_on: &dyn Fn() -> bool) -> Result<Done, Error> {
        let scenario = self.problem.scenario(values, seed)?;
        batch::lockstep(&scenario, self.group, going_on)
    }

    /// The drive with a seed.
    ///
    /// # Errors
    /// If it cannot be done.
    pub fn repeat(&self, values: &[Value], seed: u64) -> Result<Done, Error> {
        self.run(values, seed, &|| true)
    }

    fn seed(&self, index: usize) -> u64 {
        seed_of(self.seed, 7, index as u64)
    }
}

impl Trial for Seeds<'_> {
    fn seeds(&self) -> usize {
        self.count
    }

    fn drive(&self, values: &[Value], all: bool) -> Result<Held, Error> {
        if let Some(reference) = &self.problem.reference {
            let scenario = self.problem.scenario(values, 1)?;
            if !reference.drive(&scenario, false).avoids() {
                return Ok(Held { failed: 0, tried: 0, first: None });
            }
        }
        let at_once = batch::at_once(self.jobs, Mode::Lockstep);
        let (enough, mut done) = (self.enough(), 0);
        let mut failed: Vec<(usize, Judged)> = Vec::new();
        while done < self.count {
            let is_clear = failed.len() >= enough || done - failed.len() > self.count - enough;
            if is_clear && !all {
                break;
            }
            let next = at_once.min(self.count - done);
            let first = done;
            let ended = Mutex::new(Vec::new());
            let work = |index: usize, going_on: &dyn Fn() -> bool| {
                self.run(values, self.seed(first + index), going_on)
            };
            let mut each = |index: usize, result: Result<Done, Error>| {
                let judged = judge(&result?.summary);
                ended.lock().expect("one thread").push((first + index, judged));
                Ok(())
            };
            batch::share(next, at_once, &ProgressBar::hidden(), &work, &mut each)?;
            self.bar.inc(next as u64);
            done += next;
            let ended = ended.into_inner().expect("one thread");
            failed.extend(ended.into_iter().filter(|(_, judged)| judged.value < 0.0));
        }
        failed.sort_by_key(|(index, _)| *index);
        let first = failed.first().map(|(index, judged)| (self.seed(*index), judged.clone()));
        Ok(Held { failed: failed.len(), tried: done, first })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_the_faults_that_act() {
        let text = |brake: bool| {
            let head = "schema_version = 1\nname = \"a\"\n[aebs]\n";
            let fault = "[[faults]]\nkind = \"drop\"\ntopic = \"radar/detections\"\nat_s = 1\n";
            let text = format!("{head}enabled = {brake}\n{fault}");
            repeatable(&Scenario::parse("a.toml", &text).expect("a scenario"))
        };
        assert!(text(true).contains("radar/detections"));
        assert!(!text(false).contains("radar/detections"), "nothing receives it");
    }
}
