//! Working rows: the rows that may act, each at one stage.
//!
//! Rows whose multiplier became zero leave the set. The worst stage of every run of neighbouring violated stages
//! enters. One stage per run suffices at first: a row that holds at the worst stage mostly holds at its neighbours.
//! Later rounds move or split it.

use multiversion::multiversion;

use crate::limits::MAX_ROWS;
use crate::problem::{Problem, dot};

/// Largest number of rows treated at once.
pub(super) const MAX_WORKING_ROWS: usize = 8;
/// Number of members whose response costs the same as that of one, see [`super::response`].
const LANES: usize = 4;
/// Violation that counts as zero, relative to the limit or 1.
const TOLERANCE: f64 = 1e-10;

#[derive(Clone, Copy, Debug)]
pub(super) struct WorkingRow {
    pub(super) row: usize,
    pub(super) stage: usize,
    /// `μ`.
    pub(super) multiplier: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Update {
    /// All rows outside of the set hold.
    Complete,
    /// New rows have entered.
    Extended,
    /// Only rows that had just left have entered: their multipliers are zero, and they are violated.
    Stuck,
    /// The method cannot treat this many violated rows.
    TooMany,
}

/// Set of at most [`MAX_WORKING_ROWS`] members.
#[derive(Clone, Debug)]
pub(super) struct WorkingRows {
    pub(super) members: Vec<WorkingRow>,
    /// Row and stage of the members before the last update.
    before: Vec<(usize, usize)>,
}

impl WorkingRows {
    pub(super) fn new() -> Self {
        let (members, before) =
            (Vec::with_capacity(MAX_WORKING_ROWS), Vec::with_capacity(MAX_WORKING_ROWS));
        Self { members, before }
    }

    pub(super) fn clear(&mut self) {
        self.members.clear();
    }

    /// Updates the set from a trajectory with at most `most_violated` violated stages.
    pub(super) fn update(
        &mut self,
        problem: &Problem,
        states: &[[f64; 3]],
        most_violated: usize,
    ) -> Update {
        self.before.clear();
        self.before.extend(self.members.iter().map(|member| (member.row, member.stage)));
        self.members.retain(|member| member.multiplier > 0.0);
        let mut violated = 0;
        let mut update = Update::Complete;
        for (j, row) in problem.rows.iter().enumerate() {
            if row.from > row.to {
                continue;
            }
            let (states, limits) =
                (&states[row.from..=row.to], &problem.limits[j][row.from..=row.to]);
            // Mostly no stage is violated; counting finds this faster than searching for runs.
            let count = count_violated(&row.gradient, states, limits);
            if count == 0 {
                continue;
            }
            violated += count;
            // Worst stage of the present run, with a positive violation.
            let mut worst = (0, 0.0);
            let mut left = count;
            for (i, (x, h)) in states.iter().zip(limits).enumerate() {
                let (k, z) = (row.from + i, dot(&row.gradient, x) - h);
                if is_violated(z, *h) {
                    left -= 1;
                    if z > worst.1 {
                        worst = (k, z);
                    }
                } else if worst.1 > 0.0 {
                    update = self.enter(j, worst.0, update);
                    worst = (0, 0.0);
                }
                if left == 0 {
                    break;
                }
            }
            if worst.1 > 0.0 {
                update = self.enter(j, worst.0, update);
            }
        }
        if violated > most_violated {
            return Update::TooMany;
        }
        let is_new = |member: &WorkingRow| !self.before.contains(&(member.row, member.stage));
        if update == Update::Extended && !self.members.iter().any(is_new) {
            update = Update::Stuck;
        }
        self.add_neighbours(problem, states);
        update
    }

    /// Fills idle lanes with the neighbours of the members, nearest to their limits first. The next
    /// round then has a row that acts at two stages, or at the stage beside the worst.
    fn add_neighbours(&mut self, problem: &Problem, states: &[[f64; 3]]) {
        let count = self.members.len();
        while self.members.len() < LANES {
            let mut nearest: Option<(usize, usize, f64)> = None;
            for member in &self.members[..count] {
                let row = &problem.rows[member.row];
                for stage in [member.stage - 1, member.stage + 1] {
                    let is_member =
                        self.members.iter().any(|m| (m.row, m.stage) == (member.row, stage));
                    if is_member || stage < row.from || stage > row.to {
                        continue;
                    }
                    let z = dot(&row.gradient, &states[stage]) - problem.limits[member.row][stage];
                    if nearest.is_none_or(|(_, _, most)| z > most) {
                        nearest = Some((member.row, stage, z));
                    }
                }
            }
            let Some((row, stage, _)) = nearest else { break };
            self.members.push(WorkingRow { row, stage, multiplier: 0.0 });
        }
    }

    /// Adds a row at a stage unless it is present; returns the resulting state of the update.
    fn enter(&mut self, row: usize, stage: usize, update: Update) -> Update {
        if self.members.iter().any(|member| (member.row, member.stage) == (row, stage)) {
            return update;
        }
        if self.members.len() == MAX_WORKING_ROWS {
            return Update::TooMany;
        }
        self.members.push(WorkingRow { row, stage, multiplier: 0.0 });
        if update == Update::TooMany { update } else { Update::Extended }
    }

    /// Writes the multipliers of the members, and zero elsewhere.
    pub(super) fn write(&self, problem: &Problem, multipliers: &mut [Vec<f64>; MAX_ROWS]) {
        for row in &mut multipliers[..problem.rows.len()] {
            row[..=problem.horizon].fill(0.0);
        }
        for member in &self.members {
            multipliers[member.row][member.stage] = member.multiplier;
        }
    }
}

#[inline(always)]
fn is_violated(z: f64, h: f64) -> bool {
    z > TOLERANCE * h.abs().max(1.0)
}

/// Counts the stages that violate a row.
#[multiversion(targets("x86_64+avx2"))]
fn count_violated(gradient: &[f64; 3], states: &[[f64; 3]], limits: &[f64]) -> usize {
    let stages = states.iter().zip(limits);
    stages.map(|(x, h)| usize::from(is_violated(dot(gradient, x) - h, *h))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::{Row, Softness};

    #[test]
    fn rows_are_violated_where_they_are_in_force() {
        let softness = Softness::Hard;
        let row = Row { gradient: [0.0, 1.0, 0.0], from: 2, to: 4, limit: 1.0, softness };
        let problem = Problem::builder(5)
            .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
            .input_cost(1.0)
            .input_bounds(-1.0, 1.0)
            .row(row)
            .row(Row { from: 5, to: 5, ..row })
            .build()
            .expect("a valid problem");
        // The first row is violated at stages 2 and 3, the second one at its only stage.
        let states = [9.0, 9.0, 1.5, 2.0, 1.0, 1.1].map(|speed| [0.0, speed, 0.0]);
        let mut rows = WorkingRows::new();
        assert_eq!(rows.update(&problem, &states, 2), Update::TooMany);
        rows.clear();
        assert_eq!(rows.update(&problem, &states, 3), Update::Extended);
        // The worst stage of each run, then neighbours.
        let members = rows.members.iter().map(|member| (member.row, member.stage));
        assert_eq!(members.collect::<Vec<_>>(), [(0, 3), (1, 5), (0, 2), (0, 4)]);
    }
}
