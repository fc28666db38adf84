//! Relations among the runs: distinct failures, which are not neighbours, and the weight of each variable.

use crate::problem::{Domain, Variable};
use crate::record::Record;

/// Failures nearer than this belong together, in diagonals of the cube.
const RADIUS: f64 = 0.15;

/// The places of the failures among `records`, in groups around the worst of each, the worst group first. Runs with
/// different words are in different groups.
pub fn groups(variables: &[Variable], records: &[(usize, Record)]) -> Vec<Vec<usize>> {
    let mut failures: Vec<usize> =
        (0..records.len()).filter(|place| records[*place].1.is_failure()).collect();
    failures.sort_by(|a, b| records[*a].1.value().total_cmp(&records[*b].1.value()).then(a.cmp(b)));
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for place in failures {
        let record = &records[place].1;
        let is_near = |group: &&mut Vec<usize>| near(variables, &records[group[0]].1, record);
        match groups.iter_mut().find(is_near) {
            Some(group) => group.push(place),
            None => groups.push(vec![place]),
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
                squared += (a.driven.point[place] - b.driven.point[place]).powi(2);
            }
        }
    }
    squared < RADIUS * RADIUS * variables.len() as f64
}

/// Parts of a variable's interval.
const PARTS: usize = 6;

/// The share of the values' variance that each variable explains alone; none where values do not vary.
///
/// The correlation ratio (Pearson 1903): the variance of the means over the whole variance. The means are those in six
/// equal parts of the variable's interval, or of each word. Values enter as `asinh`.
pub fn effects(variables: &[Variable], records: &[(usize, Record)]) -> Vec<Option<f64>> {
    let values: Vec<f64> = records.iter().map(|(_, one)| libm::asinh(one.value())).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let whole: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    let share = |(place, variable): (usize, &Variable)| {
        let parts = variable.domain.count().unwrap_or(PARTS);
        let mut sums = vec![(0.0, 0.0); parts];
        for ((_, record), value) in records.iter().zip(&values) {
            let part = ((record.driven.point[place] * parts as f64) as usize).min(parts - 1);
            sums[part].0 += value;
            sums[part].1 += 1.0;
        }
        let between = sums.iter().filter(|(_, count)| *count > 0.0);
        let between: f64 = between.map(|(sum, count)| count * (sum / count - mean).powi(2)).sum();
        (whole > 0.0).then(|| between / whole)
    };
    variables.iter().enumerate().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Proposal;
    use crate::problem::Value;
    use crate::record::Judged;
    use supervise::report::Outcome;

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
            let judged = Judged { robustness: value, ..Judged::default() };
            let values = vec![Value::Number(x), Value::Word(word.into())];
            let driven =
                Proposal { point, is_even: true, reference: -200.0, tried: 0, refused: Vec::new() };
            Record { driven, values, seed: 1, outcome: Outcome::Completed, judged }
        };
        let all = [
            record(0.5, "a", 1.0),
            record(0.1, "a", -1.0),
            record(0.2, "a", -2.0),
            record(0.9, "a", -0.5),
            record(0.2, "b", -0.1),
        ];
        let records: Vec<(usize, Record)> = all.into_iter().enumerate().collect();
        assert_eq!(groups(&variables, &records), [vec![2, 1], vec![3], vec![4]]);
    }
}
