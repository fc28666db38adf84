//! All faults of messages and of timing that a scenario can have, each as a problem.
//!
//! | fault | size | from, to |
//! | --- | --- | --- |
//! | `delay` of each topic | delay | 10 ms, 1 s |
//! | `drop`, `duplicate`, `reorder`, `corrupt` of each topic | share of the messages | 5 %, all |
//! | `freeze` of each topic | - | - |
//! | `bias` of a figure, up and down | the figure's unit | a tenth of the largest one |
//! | `stale` of each topic | age added | 50 ms, 5 s |
//! | `clock-step` of each service | time ahead | 50 ms, 5 s |
//! | `runtime.extra_delay_ms`, `runtime.extra_jitter_ms` | delay | 10 ms, 500 ms, in steps of the plant's period |
//! | `runtime.miss_probability` | share of the cycles | 5 %, 95 % |
//!
//! A fault of messages begins within the first 80 % of the drive and lasts from 0.1 s to the drive's length. One of
//! timing lasts from start to end. Chosen: the largest sizes are beyond what a system in order could show.

use group::{Error, absent};
use messages::Service;
use scenario::Scenario;
use scenario::faults::TopicName;

use crate::problem::{
    Domain, Draft, FAULT, FaultChoice, Problem, Setting, Term, Value, Variable, is_refusal,
};

/// Names of the variables of a fault.
pub const BEGIN: &str = "at_s";
/// Its duration.
pub const LASTS: &str = "for_s";
/// Its size.
pub const SIZE: &str = "size";

/// A fault with its ranges.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Its name: kind and target.
    pub name: String,
    /// Unit of its size; empty for shares and for a fault without a size.
    pub unit: &'static str,
    /// Its variables: begin, duration and size, as far as it has them.
    pub problem: Problem,
}

/// A fault without its place in the scenario.
struct Sort {
    name: String,
    unit: &'static str,
    /// Key, smallest and largest value of its size.
    size: Option<(&'static str, f64, f64)>,
    /// Fixed keys of a message fault; none: the size's key is one of the scenario.
    keys: Option<Vec<(&'static str, String)>>,
}

/// The faults that a scenario of this duration can have. `open` makes a problem of a draft.
///
/// # Errors
/// Mistakes in the scenario.
pub fn candidates(
    draft: &dyn Fn() -> Draft,
    duration_s: f64,
    open: &dyn Fn(Draft) -> Result<Problem, Error>,
) -> Result<Vec<Candidate>, Error> {
    let mut found = Vec::new();
    for sort in sorts() {
        let (name, unit) = (sort.name.clone(), sort.unit);
        let candidate =
            Candidate { name, unit, problem: open(sort.lay_over(draft(), duration_s))? };
        match candidate.problem.scenario(&candidate.severe(&[0.5]), 1) {
            Ok(scenario) if has_targets(&scenario) => found.push(candidate),
            Ok(_) => {}
            // The scenario does not allow a fault of this kind, such as a figure of a topic that is not sent.
            Err(error) if is_refusal(&error) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// Every fault of the scenario has something to act on.
fn has_targets(scenario: &Scenario) -> bool {
    scenario.faults.iter().all(|fault| absent(fault, scenario).is_none())
}

fn sorts() -> Vec<Sort> {
    let text = |word: &str| format!("\"{word}\"");
    let mut all = Vec::new();
    for topic in TopicName::all() {
        let keys = |kind| vec![("kind", text(kind)), ("topic", text(topic.name()))];
        let of = |kind: &'static str, unit, size| Sort {
            name: format!("{kind} {}", topic.name()),
            unit,
            size,
            keys: Some(keys(kind)),
        };
        all.push(of("delay", "ms", Some(("delay_ms", 10.0, 1_000.0))));
        for kind in ["drop", "duplicate", "reorder", "corrupt"] {
            all.push(of(kind, "", Some(("probability", 0.05, 1.0))));
        }
        all.push(of("freeze", "", None));
        all.push(of("stale", "s", Some(("amount", 0.05, 5.0))));
    }
    for (topic, field, unit, most) in [
        ("radar/tracks", "gap_m", "m", 40.0),
        ("radar/tracks", "relative_speed_mps", "m/s", 15.0),
        ("vehicle/odometry", "speed_mps", "m/s", 15.0),
        ("v2x/spat", "end_s", "s", 20.0),
    ] {
        for (sign, word) in [(1.0, "up"), (-1.0, "down")] {
            let keys = vec![("kind", text("bias")), ("topic", text(topic)), ("field", text(field))];
            all.push(Sort {
                name: format!("bias {field} {word}"),
                unit,
                size: Some(("amount", sign * most / 10.0, sign * most)),
                keys: Some(keys),
            });
        }
    }
    for service in Service::ALL {
        let keys = vec![("kind", text("clock-step")), ("service", text(service.name()))];
        all.push(Sort {
            name: format!("clock-step {}", service.name()),
            unit: "s",
            size: Some(("amount", 0.05, 5.0)),
            keys: Some(keys),
        });
    }
    for (key, unit, from, to) in [
        ("runtime.extra_delay_ms", "ms", 10.0, 500.0),
        ("runtime.extra_jitter_ms", "ms", 10.0, 500.0),
        ("runtime.miss_probability", "", 0.05, 0.95),
    ] {
        let name = key.trim_start_matches("runtime.").to_owned();
        all.push(Sort { name, unit, size: Some((key, from, to)), keys: None });
    }
    all
}

impl Sort {
    /// The problem of this fault: its variables, from the smallest values on.
    fn lay_over(self, mut draft: Draft, duration_s: f64) -> Draft {
        let mut keys = Vec::new();
        let mut vary = |name: &str, from: f64, to: f64| {
            let place = draft.variables.len();
            let is_log = from > 0.0;
            let (low, high) = (from.min(to), from.max(to));
            let domain = Domain::range(low, high, is_log).expect("the ends differ");
            draft.variables.push((name.to_owned(), domain, Some(Value::Number(from))));
            Term::Variable(place)
        };
        let Some(fixed) = self.keys else {
            let (key, from, to) = self.size.expect("timing has a size");
            // Delays are whole periods of the plant.
            let term = if self.unit == "ms" {
                let place = draft.variables.len();
                let steps = (1..=50).map(|step| (10 * step).to_string()).collect();
                let domain = Domain::list(steps).expect("numbers");
                draft.variables.push((SIZE.to_owned(), domain, Some(Value::Number(from))));
                Term::Variable(place)
            } else {
                vary(SIZE, from, to)
            };
            draft.settings.push(Setting { key: key.to_owned(), term });
            return draft;
        };
        keys.push(Setting { key: "at_s".into(), term: vary(BEGIN, 0.0, 0.8 * duration_s) });
        keys.push(Setting { key: "for_s".into(), term: vary(LASTS, 0.1, duration_s.max(0.2)) });
        if let Some((key, from, to)) = self.size {
            keys.push(Setting { key: key.to_owned(), term: vary(SIZE, from, to) });
        }
        let fixed = fixed
            .into_iter()
            .map(|(key, text)| Setting { key: key.to_owned(), term: Term::Constant(text) });
        keys.extend(fixed);
        draft.faults.push(FaultChoice { name: self.name, keys });
        draft
    }
}

impl Candidate {
    /// The values of a point of the unit cube: begin as it comes, duration and size from the upper half of their
    /// ranges. Where these break nothing, smaller ones hardly do.
    #[must_use]
    pub fn severe(&self, point: &[f64]) -> Vec<Value> {
        let place = |(k, variable): (usize, &Variable)| {
            let at = point[k % point.len()];
            let at = match variable.name.as_str() {
                BEGIN => at,
                FAULT => 0.999,
                // A size that is negative grows downwards.
                _ if variable.nominal == variable.domain.at(1.0) => 0.5 - 0.5 * at,
                _ => 0.5 + 0.5 * at,
            };
            variable.domain.at(at)
        };
        self.problem.variables.iter().enumerate().map(place).collect()
    }

    /// Place of a value between the smallest and the largest, from 0 to 1.
    #[must_use]
    pub fn severity(&self, name: &str, values: &[Value]) -> Option<f64> {
        let found = self.problem.variables.iter().zip(values).find(|(one, _)| one.name == name);
        let (variable, value) = found?;
        let (at, nominal) =
            (variable.domain.place(value), variable.domain.place(&variable.nominal));
        Some((at - nominal).abs())
    }

    /// The value of a variable by its name.
    #[must_use]
    pub fn value(&self, name: &str, values: &[Value]) -> Option<f64> {
        let found = self.problem.variables.iter().zip(values).find(|(one, _)| one.name == name);
        found?.1.number()
    }
}
