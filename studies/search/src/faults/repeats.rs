//! Repetitions of a fault in realtime, where chance decides as well.
//!
//! ```text
//! repeat until |violations − others| = 3, at most N times;   the fault breaks: violations lead by 3
//! ```
//!
//! This is Wald's sequential test between a share of violations of 20 % and one of 80 %. At either share it is wrong in
//! one of 65 cases. After 3 runs it is over if all runs agree. Source: Wald, Sequential Tests of Statistical
//! Hypotheses, Ann. Math. Stat. 16 (1945), for Bernoulli trials: wrong with 1 / (1 + (0.8 / 0.2)³).

use frame::batch;
use group::report::Outcome;
use group::{Error, GroupOptions};
use indicatif::ProgressBar;
use report::summary::Summary;
use runtime::Mode;

use super::candidates::Candidate;
use super::sort::{LASTS, SIZE};
use crate::method::seed_of;
use crate::minimal::{Case, Held, Trial};
use crate::problem::{Domain, Problem, Value, is_refusal, rounded};
use crate::value::{Judged, MOST, judge};

/// The verdict on a drive in a process group: a group that ends early breaks more than any requirement.
pub(super) fn judge_orderly(summary: &Summary) -> Judged {
    if summary.outcome != Outcome::Aborted {
        return judge(summary);
    }
    let requirement = "orderly end".to_owned();
    Judged { value: -MOST, requirement, margin: None, unit: String::new() }
}

/// Lead that ends the repetitions.
const LEAD: usize = 3;
/// Times that the way to the smallest fault is halved: what is left is a sixteenth.
const HALVINGS: usize = 4;

/// Drives values again and again, one after the other.
pub(super) struct Repeats<'a> {
    pub problem: &'a Problem,
    pub group: &'a GroupOptions,
    pub seed: u64,
    /// Repetitions at most.
    pub most: usize,
    /// Counts the runs.
    pub bar: &'a ProgressBar,
}

/// Violations lead; none while neither verdict does.
fn verdict(failed: usize, tried: usize) -> Option<bool> {
    let held = tried - failed;
    match (failed >= held + LEAD, held >= failed + LEAD) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

impl Trial for Repeats<'_> {
    fn seeds(&self) -> usize {
        self.most
    }

    fn drive(&self, values: &[Value], _: bool) -> Result<Held, Error> {
        let mut held = Held { failed: 0, tried: 0, first: None };
        while held.tried < self.most && verdict(held.failed, held.tried).is_none() {
            let seed = seed_of(self.seed, 7, held.tried as u64);
            let scenario = self.problem.scenario(values, seed)?;
            let mut judged = None;
            // One piece of work: an interrupt ends the run.
            let work = |_: usize, going_on: &dyn Fn() -> bool| {
                batch::realtime(&scenario, self.group, going_on)
            };
            let mut each = |_: usize, done: Result<batch::Done, Error>| {
                judged = Some(judge_orderly(&done?.summary));
                Ok(())
            };
            let at_once = batch::at_once(None, Mode::Realtime);
            batch::share(1, at_once, &ProgressBar::hidden(), &work, &mut each)?;
            self.bar.inc(1);
            held.tried += 1;
            if let Some(judged) = judged.filter(|judged| judged.value < 0.0) {
                held.failed += 1;
                held.first.get_or_insert((seed, judged));
            }
        }
        Ok(held)
    }

    fn holds(&self, values: &[Value]) -> Result<bool, Error> {
        match self.drive(values, false) {
            Ok(held) => Ok(verdict(held.failed, held.tried) == Some(true)),
            Err(error) if is_refusal(&error) => Ok(false),
            Err(error) => Err(error),
        }
    }
}

/// The smallest size or duration that breaks, by halving. The begin stays: it is the moment that matters.
pub(super) fn smallest(
    candidate: &Candidate,
    from: &[Value],
    trial: &Repeats<'_>,
) -> Result<Case, Error> {
    let mut case = Case { values: from.to_vec(), held: trial.drive(from, true)? };
    if verdict(case.held.failed, case.held.tried) != Some(true) {
        return Ok(case);
    }
    let variables = &candidate.problem.variables;
    let severe = variables.iter().position(|one| one.name == LASTS || one.name == SIZE);
    let Some(place) = severe else { return Ok(case) };
    let (domain, nominal) = (&variables[place].domain, &variables[place].nominal);
    let (mut fails, mut holds) = (domain.place(&from[place]), domain.place(nominal));
    for step in 0..=HALVINGS {
        // The smallest of all comes first: it may be enough.
        let middle = if step == 0 { holds } else { 0.5 * (fails + holds) };
        let mut tried = case.values.clone();
        tried[place] = round(domain, middle);
        if tried[place] == case.values[place] {
            break;
        }
        let held = trial.drive(&tried, true)?;
        let is_broken = verdict(held.failed, held.tried) == Some(true);
        if is_broken {
            (fails, case) = (middle, Case { values: tried, held });
        } else {
            holds = middle;
        }
        if step == 0 && is_broken {
            break;
        }
    }
    Ok(case)
}

/// The value at a place, with two digits.
fn round(domain: &Domain, place: f64) -> Value {
    match domain.at(place) {
        Value::Number(number) => domain.nearest(&Value::Number(rounded(number, 2))),
        word @ Value::Word(_) => word,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_of_three_decides() {
        assert_eq!(verdict(3, 3), Some(true));
        assert_eq!(verdict(0, 3), Some(false));
        assert_eq!((verdict(2, 2), verdict(3, 4), verdict(5, 10)), (None, None, None));
        assert_eq!((verdict(4, 5), verdict(1, 5)), (Some(true), Some(false)));
    }

    /// The share of wrong verdicts that the documentation states.
    #[test]
    fn one_verdict_of_65_is_wrong_at_four_fifths() {
        // Probability to lead by -3 before +3 from 0: the chain of leads, solved by iteration.
        let mut wrong = [0.0_f64; 7];
        wrong[0] = 1.0;
        for _ in 0..10_000 {
            for lead in 1..6 {
                wrong[lead] = 0.8 * wrong[lead + 1] + 0.2 * wrong[lead - 1];
            }
        }
        assert!((wrong[3] - 1.0 / 65.0).abs() < 1e-9, "{}", wrong[3]);
    }
}
