//! A sort of fault, and the problem that it makes of a scenario.
//!
//! A fault begins within the first 80 % of the drive, and lasts from 0.1 s to the drive's length. One of timing lasts
//! from start to end.

use crate::problem::{Domain, Draft, FaultChoice, Setting, Term, Value};

/// Names of the variables of a fault.
pub(super) const BEGIN: &str = "at_s";
pub(super) const LASTS: &str = "for_s";
pub(super) const SIZE: &str = "size";

/// A fault without its place in the scenario.
pub(super) struct Sort {
    pub name: String,
    pub unit: &'static str,
    /// Key, smallest and largest value of its size.
    pub size: Option<(&'static str, f64, f64)>,
    /// Fixed keys of a fault; none: the size's key is one of the scenario.
    pub keys: Option<Vec<(&'static str, String)>>,
}

impl Sort {
    /// The problem of this fault: its variables, from the smallest values on.
    pub(super) fn lay_over(self, mut draft: Draft, duration_s: f64) -> Draft {
        let mut vary = |name: &str, from: f64, domain: Domain| {
            let place = draft.variables.len();
            draft.variables.push((name.to_owned(), domain, Some(Value::Number(from))));
            Term::Variable(place)
        };
        let Some(fixed) = self.keys else {
            let (key, from, to) = self.size.expect("timing has a size");
            // Delays are whole periods of the plant.
            let domain = if self.unit == "ms" { steps(10, from, to) } else { range(from, to) };
            let term = vary(SIZE, from, domain);
            draft.settings.push(Setting::new(key, term));
            return draft;
        };
        let begin = vary(BEGIN, 0.0, range(0.0, 0.8 * duration_s));
        let lasts = vary(LASTS, 0.1, range(0.1, duration_s.max(0.2)));
        let mut keys = vec![Setting::of_fault("at_s", begin), Setting::of_fault("for_s", lasts)];
        if let Some((key, from, to)) = self.size {
            keys.push(Setting::of_fault(key, vary(SIZE, from, range(from, to))));
        }
        let fixed = fixed.into_iter();
        keys.extend(fixed.map(|(key, text)| Setting::of_fault(key, Term::Constant(text))));
        draft.faults.push(FaultChoice { name: self.name, keys });
        draft
    }
}

/// The numbers between two ends; their logarithm is spread evenly where it exists.
fn range(from: f64, to: f64) -> Domain {
    Domain::range(from.min(to), from.max(to), from > 0.0).expect("the ends differ")
}

/// Multiples of a whole number between two ends.
fn steps(step: u32, from: f64, to: f64) -> Domain {
    let number = |k: u32| f64::from(k * step);
    let all = (1..).map(number).skip_while(|x| *x < from).take_while(|x| *x <= to);
    Domain::list(all.map(|x| x.to_string()).collect()).expect("the ends differ")
}
