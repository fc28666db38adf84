//! Weight of variables: the share of the values' variance that each explains alone.
//!
//! The correlation ratio (Pearson 1903): the variance of the means over the whole variance. The means are those in six
//! equal parts of the variable's interval, or of each word. Values enter as `asinh`. It misses an effect that two
//! variables have only together. A search that gathers points in one region weighs that region.

use crate::problem::Variable;
use crate::record::Record;

/// Parts of a variable's interval.
const PARTS: usize = 6;

/// The share of each variable; none of a search whose values do not vary.
#[must_use]
pub fn effects(variables: &[Variable], records: &[(usize, Record)]) -> Vec<Option<f64>> {
    let values: Vec<f64> = records.iter().map(|(_, one)| libm::asinh(one.value())).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let whole: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    let share = |(place, variable): (usize, &Variable)| {
        let parts = variable.domain.count().unwrap_or(PARTS);
        let mut sums = vec![(0.0, 0.0); parts];
        for ((_, record), value) in records.iter().zip(&values) {
            let part = ((record.point[place] * parts as f64) as usize).min(parts - 1);
            sums[part].0 += value;
            sums[part].1 += 1.0;
        }
        let between = sums.iter().filter(|(_, count)| *count > 0.0);
        let between: f64 = between.map(|(sum, count)| count * (sum / count - mean).powi(2)).sum();
        (whole > 0.0).then(|| between / whole)
    };
    variables.iter().enumerate().map(share).collect()
}
