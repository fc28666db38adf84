//! Distinct failures: failing runs that are not neighbours.

use crate::problem::{Domain, Variable};
use crate::record::Record;

/// Failures nearer than this belong together, in diagonals of the cube.
const RADIUS: f64 = 0.15;

/// Failing runs that belong together, the worst first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Their places among the records.
    pub members: Vec<usize>,
}

/// The failures of `records` in groups around the worst of each, the worst group first. Runs with different words are
/// in different groups.
#[must_use]
pub fn groups(variables: &[Variable], records: &[(usize, Record)]) -> Vec<Group> {
    let mut failures: Vec<usize> =
        (0..records.len()).filter(|place| records[*place].1.is_failure()).collect();
    failures.sort_by(|a, b| records[*a].1.value().total_cmp(&records[*b].1.value()).then(a.cmp(b)));
    let mut groups: Vec<Group> = Vec::new();
    for place in failures {
        let record = &records[place].1;
        let is_near = |group: &&mut Group| near(variables, &records[group.members[0]].1, record);
        match groups.iter_mut().find(is_near) {
            Some(group) => group.members.push(place),
            None => groups.push(Group { members: vec![place] }),
        }
    }
    groups
}

fn near(variables: &[Variable], a: &Record, b: &Record) -> bool {
    let mut squared = 0.0;
    for (place, variable) in variables.iter().enumerate() {
        match variable.domain {
            Domain::Words(_) if a.values[place] != b.values[place] => return false,
            Domain::Words(_) => {}
            Domain::Range { .. } | Domain::Numbers(_) => {
                let off = a.point[place] - b.point[place];
                squared += off * off;
            }
        }
    }
    squared < RADIUS * RADIUS * variables.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Value;
    use crate::value::Judged;
    use group::report::Outcome;

    #[test]
    fn neighbours_belong_together_and_words_set_apart() {
        let domain = |text| Domain::parse(text).expect("a domain");
        let variable = |name: &str, text| Variable {
            name: name.into(),
            domain: domain(text),
            nominal: Value::Number(0.0),
        };
        let variables = [variable("x", "0..1"), variable("w", "a,b")];
        let record = |x: f64, word: &str, value: f64| {
            let point = vec![x, if word == "a" { 0.25 } else { 0.75 }];
            let judged =
                Judged { value, requirement: "r".into(), margin: Some(value), unit: "m".into() };
            let values = vec![Value::Number(x), Value::Word(word.into())];
            Record {
                point,
                values,
                seed: 1,
                outcome: Outcome::Completed,
                judged,
                reference: -200.0,
                is_even: true,
                tried: 0,
                refused: Vec::new(),
            }
        };
        let all = [
            record(0.5, "a", 1.0),
            record(0.1, "a", -1.0),
            record(0.2, "a", -2.0),
            record(0.9, "a", -0.5),
            record(0.2, "b", -0.1),
        ];
        let records: Vec<(usize, Record)> = all.into_iter().enumerate().collect();
        let found: Vec<Vec<usize>> =
            groups(&variables, &records).into_iter().map(|group| group.members).collect();
        assert_eq!(found, [vec![2, 1], vec![3], vec![4]]);
    }
}
