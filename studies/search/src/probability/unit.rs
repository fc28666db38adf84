//! Units of the study: what each of them computes, and what the journal keeps of it.

use rare_events::{ENOUGH_EVENTS, REPLICAS, Replica};
use serde::{Deserialize, Serialize};

/// Points of a unit of Monte Carlo.
const POINTS: usize = 50;
/// Rows of a unit of Sobol's indices.
const ROWS: usize = 5;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Units {
    replica: usize,
    /// Points of Monte Carlo.
    points: usize,
    /// Failures after which Monte Carlo ends.
    enough: usize,
    /// Rows of Sobol's indices.
    rows: usize,
}

/// Work of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Replica { number: usize, runs: usize },
    MonteCarlo { first: usize, count: usize },
    Rows { first: usize, count: usize },
}

impl Units {
    /// Half the budget for the replicas, half for Monte Carlo; the rows come beside it. A number of points for Monte
    /// Carlo comes beside the budget, and all of them are done.
    pub(super) fn new(budget: usize, monte_carlo: Option<usize>, rows: usize) -> Self {
        if let Some(points) = monte_carlo {
            return Self { replica: (budget / REPLICAS).max(1), points, enough: usize::MAX, rows };
        }
        let replica = (budget / 2 / REPLICAS).max(1);
        let points = budget.saturating_sub(replica * REPLICAS).max(1);
        Self { replica, points, enough: ENOUGH_EVENTS, rows }
    }

    /// Failures after which Monte Carlo ends.
    pub(super) fn enough(&self) -> usize {
        self.enough
    }

    /// Number of units.
    pub(super) fn count(&self) -> usize {
        REPLICAS + self.points.div_ceil(POINTS) + self.rows.div_ceil(ROWS)
    }

    /// Points of a unit, for the progress bar.
    pub(super) fn points(&self, unit: usize, dimensions: usize) -> usize {
        match self.kind(unit) {
            Kind::Replica { runs, .. } => runs,
            Kind::MonteCarlo { count, .. } => count,
            Kind::Rows { count, .. } => count * (dimensions + 2),
        }
    }

    pub(super) fn kind(&self, unit: usize) -> Kind {
        let Some(after) = unit.checked_sub(REPLICAS) else {
            return Kind::Replica { number: unit, runs: self.replica };
        };
        let first = after * POINTS;
        if first < self.points {
            return Kind::MonteCarlo { first, count: POINTS.min(self.points - first) };
        }
        let first = (after - self.points.div_ceil(POINTS)) * ROWS;
        Kind::Rows { first, count: ROWS.min(self.rows - first) }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unit {
    /// Points that were evaluated.
    pub points: usize,
    /// Points that were driven.
    pub driven: usize,
    /// Points with a value beyond its variable's range.
    pub clipped: usize,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<f64>,
    /// Estimate of a replica.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// The replica's density settled on the event.
    #[serde(default)]
    pub is_settled: bool,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<Vec<f64>>,
}

impl Unit {
    pub(super) fn take(&mut self, found: Replica) {
        self.probability = Some(found.probability);
        self.is_settled = found.is_settled;
        (self.events, self.weights) = (found.events, found.weights);
    }

    pub(super) fn replica(&self) -> Option<Replica> {
        Some(Replica {
            probability: self.probability?,
            runs: self.points,
            is_settled: self.is_settled,
            events: self.events.clone(),
            weights: self.weights.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_units_use_the_budget_and_each_number_once() {
        let units = Units::new(1_000, None, 7);
        let kinds: Vec<Kind> = (0..units.count()).map(|unit| units.kind(unit)).collect();
        assert_eq!(kinds.len(), 5 + 10 + 2);
        assert_eq!(kinds[4], Kind::Replica { number: 4, runs: 100 });
        assert_eq!(kinds[5], Kind::MonteCarlo { first: 0, count: 50 });
        assert_eq!(kinds[14], Kind::MonteCarlo { first: 450, count: 50 });
        assert_eq!(
            kinds[15..],
            [Kind::Rows { first: 0, count: 5 }, Kind::Rows { first: 5, count: 2 }]
        );
        let units = Units::new(1_000, Some(120), 0);
        let kinds: Vec<Kind> = (0..units.count()).map(|unit| units.kind(unit)).collect();
        assert_eq!(kinds[4], Kind::Replica { number: 4, runs: 200 });
        assert_eq!(kinds[5..].last(), Some(&Kind::MonteCarlo { first: 100, count: 20 }));
        assert_eq!(units.enough(), usize::MAX);
        let points =
            |units: Units| -> usize { (0..units.count()).map(|unit| units.points(unit, 3)).sum() };
        assert_eq!([units, Units::new(1_000, None, 7)].map(points), [1_000 + 120, 1_000 + 7 * 5]);
    }
}
