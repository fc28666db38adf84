//! Minimal cases: a failure that departs from the nominal values as little as it can.
//!
//! ```text
//! for each variable: nominal? ─ else halve the way to it, thrice ─ then fewest digits
//! ```
//!
//! Each change is kept if the failure still holds on 8 of 10 seeds. One seed is not enough. Noise turns verdicts near
//! the limit, and a case that was reduced on one seed holds on few others.

use group::Error;

use crate::problem::{Problem, Value, is_refusal, rounded};
use crate::value::Judged;

/// Share of the seeds on which a case must fail.
pub const HOLDS_ON: f64 = 0.8;
/// Times that the way to a nominal value is halved.
const HALVINGS: usize = 3;
/// Passes over all variables, while something changes.
const PASSES: usize = 2;

/// Verdict on some values over the seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Seeds on which it failed.
    pub failed: usize,
    /// Seeds that were tried. Fewer than all where the verdict was clear before.
    pub tried: usize,
    /// The first seed on which it failed, and its verdict.
    pub first: Option<(u64, Judged)>,
}

/// A failure that was reduced.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    pub values: Vec<Value>,
    /// Its verdict on all seeds.
    pub held: Held,
}

/// Drives values on several seeds.
pub trait Trial {
    fn seeds(&self) -> usize;

    /// Drives the values on the seeds, until their share of failures is clear, or on all of them. A scene that the
    /// reference does not avoid fails on none.
    ///
    /// # Errors
    /// An interrupt, or a run that cannot be done.
    fn drive(&self, values: &[Value], all: bool) -> Result<Held, Error>;

    /// Number of failures that are enough.
    fn enough(&self) -> usize {
        (HOLDS_ON * self.seeds() as f64).ceil() as usize
    }

    /// The failure holds with these values. Values that the scenario refuses hold nothing.
    ///
    /// # Errors
    /// As [`Trial::drive`], without a refusal of the scenario.
    fn holds(&self, values: &[Value]) -> Result<bool, Error> {
        match self.drive(values, false) {
            Ok(held) => Ok(held.failed >= self.enough()),
            // A combination on the way to the nominal values may be none of the scenario's.
            Err(error) if is_refusal(&error) => Ok(false),
            Err(error) => Err(error),
        }
    }
}

/// Reduces values that fail on enough seeds.
///
/// # Errors
/// As [`Trial::holds`].
pub fn reduce(problem: &Problem, from: &[Value], trial: &dyn Trial) -> Result<Case, Error> {
    let mut values = from.to_vec();
    for _ in 0..PASSES {
        let before = values.clone();
        for (place, variable) in problem.variables.iter().enumerate() {
            if values[place] == variable.nominal {
                continue;
            }
            let mut tried = values.clone();
            tried[place] = variable.nominal.clone();
            if trial.holds(&tried)? {
                values = tried;
            } else if let Some(nearer) = halved(problem, &values, place, trial)? {
                values = nearer;
            }
        }
        if values == before {
            break;
        }
    }
    for (place, variable) in problem.variables.iter().enumerate() {
        let Value::Number(number) = values[place] else { continue };
        if values[place] == variable.nominal || variable.domain.count().is_some() {
            continue;
        }
        for digits in 1..=4 {
            let mut tried = values.clone();
            tried[place] = variable.domain.nearest(&Value::Number(rounded(number, digits)));
            if tried[place] == values[place] {
                break;
            }
            if trial.holds(&tried)? {
                values = tried;
                break;
            }
        }
    }
    let held = trial.drive(&values, true)?;
    Ok(Case { values, held })
}

/// Values with one variable nearer to its nominal value, as near as halving finds.
fn halved(
    problem: &Problem,
    values: &[Value],
    place: usize,
    trial: &dyn Trial,
) -> Result<Option<Vec<Value>>, Error> {
    let variable = &problem.variables[place];
    if variable.domain.is_of_words() {
        return Ok(None);
    }
    let (mut holds, mut fails) =
        (variable.domain.place(&values[place]), variable.domain.place(&variable.nominal));
    let mut found = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (holds + fails);
        let mut tried = values.to_vec();
        tried[place] = variable.domain.at(middle);
        if tried[place] == values[place] {
            break;
        }
        if trial.holds(&tried)? {
            holds = middle;
            found = Some(tried);
        } else {
            fails = middle;
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::SearchArguments;
    use frame::Command;

    /// Fails if the gap is below 30 and the set speed above 20, on nine of ten seeds. The mass does not matter.
    struct Fake;

    impl Trial for Fake {
        fn seeds(&self) -> usize {
            10
        }

        fn drive(&self, values: &[Value], _: bool) -> Result<Held, Error> {
            let of = |place: usize| values[place].number().expect("numbers");
            let fails = of(0) < 30.0 && of(1) > 20.0;
            Ok(Held { failed: if fails { 9 } else { 1 }, tried: 10, first: None })
        }
    }

    #[test]
    fn a_case_keeps_what_it_needs_and_is_round() {
        let words = "tight-brake --vary actors.0.gap_m=20..60 --vary set_speed_mps=10..40 \
                     --vary plant.length_m=4..6";
        let words: Vec<&str> = words.split(' ').collect();
        let Command { study, options } = Command::<SearchArguments>::read(&words).expect("good");
        let problem = Problem::open(&study, &options.group).expect("a problem");
        // Nominal: a gap of 27 m, 25 m/s, 4.5 m, all from the scenario.
        let from = [Value::Number(21.234), Value::Number(36.75), Value::Number(5.789)];
        let case = reduce(&problem, &from, &Fake).expect("it runs");
        assert_eq!(case.values, problem.nominal_values(), "the nominal values fail too");
        let mut harmless = problem.clone();
        harmless.variables[0].nominal = Value::Number(50.0);
        let case = reduce(&harmless, &from, &Fake).expect("it runs");
        assert_eq!(case.values[1..], harmless.nominal_values()[1..]);
        let Value::Number(gap_m) = case.values[0] else { panic!("a number") };
        assert!((26.0..30.0).contains(&gap_m) && gap_m.fract() == 0.0, "{gap_m}");
        assert_eq!(case.held.failed, 9);
    }
}
