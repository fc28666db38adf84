//! Distributions over a set of instances.

use mpc_solver::{Report, Status};

/// Largest residual that counts as solved.
pub(crate) const TOLERANCE: f64 = 1e-8;

/// One instance.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample {
    pub(crate) time_us: f64,
    /// Rounds of an active set and iterations of an interior point.
    rounds: u32,
    interior: u32,
    residual: f64,
    is_solved: bool,
    pub(crate) pattern: &'static str,
}

impl Sample {
    pub(crate) fn new(report: &Report, pattern: &'static str) -> Self {
        Self {
            time_us: 0.0,
            rounds: report.iterations - report.interior_iterations,
            interior: report.interior_iterations,
            residual: report.residuals.max(),
            // By the one judge, whatever the solver says.
            is_solved: report.status == Status::Solved && report.residuals.max() <= TOLERANCE,
            pattern,
        }
    }

    /// Sets the time to the median of several.
    pub(crate) fn take_median(&mut self, times: &mut [f64]) {
        times.sort_by(f64::total_cmp);
        self.time_us = times[times.len() / 2];
    }
}

/// The samples in order.
pub(crate) struct Summary {
    times_us: Vec<f64>,
    rounds: Vec<u32>,
    interior: Vec<u32>,
    solved: usize,
    residual: f64,
}

impl Summary {
    pub(crate) fn of(samples: &[Sample]) -> Self {
        let mut times_us: Vec<f64> = samples.iter().map(|sample| sample.time_us).collect();
        times_us.sort_by(f64::total_cmp);
        let sorted = |value: fn(&Sample) -> u32| {
            let mut values: Vec<u32> = samples.iter().map(value).collect();
            values.sort_unstable();
            values
        };
        Self {
            times_us,
            rounds: sorted(|sample| sample.rounds),
            interior: sorted(|sample| sample.interior),
            solved: samples.iter().filter(|sample| sample.is_solved).count(),
            residual: samples.iter().fold(0.0, |worst, sample| sample.residual.max(worst)),
        }
    }

    pub(crate) fn median_us(&self) -> f64 {
        rank(&self.times_us, 50).unwrap_or(f64::NAN)
    }

    /// Instances, and how many of them were solved.
    pub(crate) fn counts(&self) -> (usize, usize) {
        (self.times_us.len(), self.solved)
    }

    pub(crate) fn print(&self, name: &str) {
        let n = self.times_us.len();
        let time = |percent| rank(&self.times_us, percent).unwrap_or(f64::NAN);
        let count = |values: &[u32]| {
            let at = |percent| rank(values, percent).unwrap_or(0);
            format!("{}/{}/{}", at(50), at(99), at(100))
        };
        println!(
            "{name:<30} {n:>5} {:>9.2} {:>9.2} {:>9.2} {:>10} {:>10} {:>7} {:>9.1e}",
            time(50),
            time(99),
            time(100),
            count(&self.rounds),
            count(&self.interior),
            self.solved,
            self.residual,
        );
    }
}

/// The line above a table of summaries.
pub(crate) fn header(name: &str) {
    println!(
        "{name:<30} {:>5} {:>9} {:>9} {:>9} {:>10} {:>10} {:>7} {:>9}",
        "n", "p50", "p99", "max", "rounds", "ip", "solved", "residual"
    );
}

/// Nearest rank; nothing of nothing.
fn rank<T: Copy>(sorted: &[T], percent: usize) -> Option<T> {
    let rank = (sorted.len() * percent).div_ceil(100).max(1);
    sorted.get(rank - 1).copied()
}
