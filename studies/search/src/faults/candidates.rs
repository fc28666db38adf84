//! The faults of messages and of timing that a scenario can have, each as a problem.
//!
//! A fault begins within the first 80 % of the drive, and lasts from 0.1 s to the drive's length. One of timing lasts
//! from start to end. Chosen: the largest sizes are beyond what a system in order could show.

use messages::Service;
use scenario::faults::TopicName;
use supervise::{Error, absent};

use crate::problem::{
    Domain, FAULT, FaultChoice, Problem, Rule, Term, Value, Variable, is_refusal,
};

/// Names of the variables of a fault.
pub(super) const BEGIN: &str = "at_s";
pub(super) const LASTS: &str = "for_s";
pub(super) const SIZE: &str = "size";

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

/// A size's key, smallest and largest value.
type Size = (&'static str, f64, f64);

/// The faults that have something to act on in the scenario of `base`.
pub fn candidates(base: &Problem) -> Result<Vec<Candidate>, Error> {
    let mut found = of_messages(base);
    found.extend(of_timing(base));
    let mut possible = Vec::new();
    for candidate in found {
        match candidate.problem.scenario(&candidate.severe(&[0.5]), 1) {
            Ok(scenario) if scenario.faults.iter().all(|one| absent(one, &scenario).is_none()) => {
                possible.push(candidate);
            }
            Ok(_) => {}
            // The scenario does not allow a fault of this kind. One example is a figure of a topic that is not sent.
            Err(error) if is_refusal(&error) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(possible)
}

fn of_messages(base: &Problem) -> Vec<Candidate> {
    let of = |name, unit, keys: &[(&str, &str)], size| {
        Candidate::of_message(base, (name, unit), keys, size)
    };
    let mut all = Vec::new();
    for topic in TopicName::all() {
        let topic = topic.name();
        for (kind, unit, size) in [
            ("delay", "ms", Some(("delay_ms", 10.0, 1_000.0))),
            ("drop", "", Some(("probability", 0.05, 1.0))),
            ("duplicate", "", Some(("probability", 0.05, 1.0))),
            ("reorder", "", Some(("probability", 0.05, 1.0))),
            ("corrupt", "", Some(("probability", 0.05, 1.0))),
            ("freeze", "", None),
            ("stale", "s", Some(("amount", 0.05, 5.0))),
        ] {
            let keys = [("kind", kind), ("topic", topic)];
            all.push(of(format!("{kind} {topic}"), unit, &keys, size));
        }
    }
    for (topic, field, unit, most) in [
        ("radar/tracks", "gap_m", "m", 40.0),
        ("radar/tracks", "relative_speed_mps", "m/s", 15.0),
        ("vehicle/odometry", "speed_mps", "m/s", 15.0),
        ("v2x/spat", "end_s", "s", 20.0),
    ] {
        for (sign, word) in [(1.0, "up"), (-1.0, "down")] {
            let keys = [("kind", "bias"), ("topic", topic), ("field", field)];
            let size = Some(("amount", sign * most / 10.0, sign * most));
            all.push(of(format!("bias {field} {word}"), unit, &keys, size));
        }
    }
    for service in Service::ALL {
        let keys = [("kind", "clock-step"), ("service", service.name())];
        let size = Some(("amount", 0.05, 5.0));
        all.push(of(format!("clock-step {}", service.name()), "s", &keys, size));
    }
    all
}

fn of_timing(base: &Problem) -> Vec<Candidate> {
    let of = |(key, unit, from, values): (&str, &'static str, f64, &str)| {
        let mut problem = base.clone();
        let domain = Domain::parse(values).expect("a domain");
        let size = problem.add(SIZE, domain, Some(Value::Number(from)));
        problem.rules.push(Rule::new(key, size));
        Candidate { name: key.trim_start_matches("runtime.").to_owned(), unit, problem }
    };
    // Delays are whole periods of the plant.
    let all = [
        ("runtime.extra_delay_ms", "ms", 10.0, "10..500/10"),
        ("runtime.extra_jitter_ms", "ms", 10.0, "10..500/10"),
        ("runtime.miss_probability", "", 0.05, "0.05..0.95:log"),
    ];
    all.map(of).into()
}

impl Candidate {
    /// A fault with fixed keys, from its smallest values on.
    fn of_message(
        base: &Problem,
        (name, unit): (String, &'static str),
        fixed: &[(&str, &str)],
        size: Option<Size>,
    ) -> Self {
        let mut problem = base.clone();
        let duration_s = base.nominal.duration_s.value();
        let mut vary = |key: &str, name: &str, from: f64, to: f64| {
            // The logarithm is spread evenly where it exists.
            let (least, most) = (from.min(to), from.max(to));
            let domain = Domain::Range { from: least, to: most, is_log: from > 0.0 };
            Rule::of_fault(key, problem.add(name, domain, Some(Value::Number(from))))
        };
        let mut keys = vec![
            vary("at_s", BEGIN, 0.0, 0.8 * duration_s),
            vary("for_s", LASTS, 0.1, duration_s.max(0.2)),
        ];
        keys.extend(size.map(|(key, from, to)| vary(key, SIZE, from, to)));
        let constant = |word: &str| Term::Constant(word.into());
        keys.extend(fixed.iter().map(|(key, word)| Rule::of_fault(key, constant(word))));
        problem.faults.push(FaultChoice { name: name.clone(), keys });
        Self { name, unit, problem: problem.with_choice_of_fault() }
    }

    /// The values of a point of the unit cube. The begin is as drawn; duration and size come from the upper half of
    /// their ranges. Smaller faults hardly break anything if these break nothing.
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
    pub fn severity(&self, name: &str, values: &[Value]) -> f64 {
        let mut named = self.problem.variables.iter().zip(values);
        let Some((variable, value)) = named.find(|(one, _)| one.name == name) else {
            // Without a size a fault has its full one.
            return 1.0;
        };
        let place = |value| variable.domain.place(value);
        (place(value) - place(&variable.nominal)).abs()
    }

    pub fn value(&self, name: &str, values: &[Value]) -> Option<f64> {
        let found = self.problem.variables.iter().zip(values).find(|(one, _)| one.name == name);
        found?.1.number()
    }
}
