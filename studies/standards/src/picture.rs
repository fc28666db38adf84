//! The classic picture of the cut-ins. For each pair of speeds it shows the cases that end in a collision, over
//! distance and lateral speed. It also shows the edges of the models' regions.

use std::collections::{BTreeMap, BTreeSet};

use crate::cut_in::Case;
use crate::{Outcome, PerModel};

/// The cut-ins of one pair of speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Speed of the ego \[km/h\].
    pub ego_kmh: u32,
    /// Speed of the other \[km/h\].
    pub other_kmh: u32,
    /// The distances of the cases \[m\], rising.
    pub distances_m: Vec<u32>,
    /// The lateral speeds of the cases in tenths \[0.1 m/s\], rising.
    pub lateral_tenths_mps: Vec<u32>,
    /// The cases in which the vehicle that is judged collides.
    pub collisions: Vec<Collision>,
    /// The edges of the region in which each model collides.
    pub edges: PerModel<Vec<Edge>>,
}

/// A cell of a panel with a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collision {
    /// Distance \[m\].
    pub distance_m: u32,
    /// Lateral speed in tenths \[0.1 m/s\].
    pub lateral_tenths_mps: u32,
    /// Side or rear-end.
    pub outcome: Outcome,
}

/// A straight piece of an edge between two cells: its two ends, (distance \[m\], lateral speed \[m/s\]).
pub type Edge = [(f64, f64); 2];

/// The panels of `cases`, which are in the order of the tables. `outcome` is that of the vehicle judged in each case.
pub fn panels(
    cases: impl IntoIterator<Item = Case>,
    mut outcome: impl FnMut(&Case) -> Outcome,
) -> Vec<Panel> {
    let mut grids: Vec<Grid> = Vec::new();
    for case in cases {
        let begins = grids.last().is_none_or(|grid| !grid.holds(&case));
        if begins {
            grids.push(Grid::new(&case));
        }
        let grid = grids.last_mut().expect("one was pushed if there was none");
        grid.add(&case, outcome(&case));
    }
    grids.into_iter().map(Grid::into_panel).collect()
}

/// The cases of a pair of speeds with their outcomes.
struct Grid {
    ego_kmh: u32,
    other_kmh: u32,
    /// By distance and lateral speed: the outcome that is judged and the models'.
    cells: BTreeMap<(u32, u32), (Outcome, PerModel<Outcome>)>,
}

impl Grid {
    fn new(case: &Case) -> Grid {
        Grid { ego_kmh: case.ego_kmh, other_kmh: case.other_kmh, cells: BTreeMap::new() }
    }

    fn holds(&self, case: &Case) -> bool {
        (self.ego_kmh, self.other_kmh) == (case.ego_kmh, case.other_kmh)
    }

    fn add(&mut self, case: &Case, outcome: Outcome) {
        let key = (case.distance_m, case.lateral_tenths_mps);
        self.cells.insert(key, (outcome, case.outcomes()));
    }

    fn into_panel(self) -> Panel {
        let distances_m = rising(self.cells.keys().map(|key| key.0));
        let lateral_tenths_mps = rising(self.cells.keys().map(|key| key.1));
        let collisions = self
            .cells
            .iter()
            .filter(|(_, (outcome, _))| outcome.is_collision())
            .map(|(&(distance_m, lateral_tenths_mps), &(outcome, _))| Collision {
                distance_m,
                lateral_tenths_mps,
                outcome,
            })
            .collect();
        let edges = PerModel::new(|model| {
            let inside = |column: usize, row: usize| {
                let key = (distances_m[column], lateral_tenths_mps[row]);
                let cell = self.cells.get(&key);
                cell.is_some_and(|(_, outcomes)| outcomes[model].is_collision())
            };
            let region = Region::new(distances_m.len(), lateral_tenths_mps.len(), inside);
            region.edges(&distances_m, &lateral_tenths_mps)
        });
        Panel {
            ego_kmh: self.ego_kmh,
            other_kmh: self.other_kmh,
            distances_m,
            lateral_tenths_mps,
            collisions,
            edges,
        }
    }
}

fn rising(values: impl Iterator<Item = u32>) -> Vec<u32> {
    values.collect::<BTreeSet<_>>().into_iter().collect()
}

/// A set of cells of a grid.
struct Region {
    columns: usize,
    rows: usize,
    cells: Vec<bool>,
}

impl Region {
    fn new(columns: usize, rows: usize, inside: impl Fn(usize, usize) -> bool) -> Region {
        let cells =
            (0..rows * columns).map(|index| inside(index % columns, index / columns)).collect();
        Region { columns, rows, cells }
    }

    /// True if a cell is in the region; outside of the grid none is.
    fn has(&self, column: isize, row: isize) -> bool {
        let within = |value: isize, end: usize| usize::try_from(value).ok().filter(|v| *v < end);
        match (within(column, self.columns), within(row, self.rows)) {
            (Some(column), Some(row)) => self.cells[row * self.columns + column],
            _ => false,
        }
    }

    /// The edges between cells inside and outside, as long as they are straight.
    fn edges(&self, distances_m: &[u32], lateral_tenths_mps: &[u32]) -> Vec<Edge> {
        let x = boundaries(distances_m, 1.0);
        let y = boundaries(lateral_tenths_mps, 0.1);
        let mut edges = Vec::new();
        for (column, &at) in (0..).zip(&x) {
            let between = |row| self.has(column - 1, row) != self.has(column, row);
            for (from, to) in runs(self.rows, between) {
                edges.push([(at, y[from]), (at, y[to])]);
            }
        }
        for (row, &at) in (0..).zip(&y) {
            let between = |column| self.has(column, row - 1) != self.has(column, row);
            for (from, to) in runs(self.columns, between) {
                edges.push([(x[from], at), (x[to], at)]);
            }
        }
        edges
    }
}

/// The boundaries of cells around `centres`, times `unit`. They go from half a cell before the first to half a cell
/// after the last.
fn boundaries(centres: &[u32], unit: f64) -> Vec<f64> {
    let half = match centres {
        [first, second, ..] => f64::from(second - first) / 2.0,
        _ => 0.5,
    };
    let first = centres.iter().take(1).map(|centre| f64::from(*centre) - half);
    let others = centres.iter().map(|centre| f64::from(*centre) + half);
    first.chain(others).map(|boundary| boundary * unit).collect()
}

/// The runs of numbers below `count` that `holds`: (first, one past the last).
fn runs(count: usize, holds: impl Fn(isize) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (index, number) in (0..count).zip(0..) {
        if !holds(number) {
            continue;
        }
        match runs.last_mut() {
            Some((_, end)) if *end == index => *end += 1,
            _ => runs.push((index, index + 1)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Model, cut_in};

    #[test]
    fn an_edge_runs_around_the_region() {
        let region = Region::new(3, 2, |column, row| row == 0 && column < 2);
        let edges = region.edges(&[1, 2, 3], &[0, 1]);
        assert_eq!(edges.len(), 4, "two cells beside each other are one rectangle");
        assert!(edges.contains(&[(2.5, -0.05), (2.5, 0.05)]), "{edges:?}");
        assert!(edges.contains(&[(0.5, 0.05), (2.5, 0.05)]), "{edges:?}");
    }

    #[test]
    fn there_is_a_panel_for_each_pair_of_speeds() {
        let panels = panels(cut_in::low().filter(|case| case.ego_kmh <= 30), |case| {
            case.drive(Model::Regulation).outcome
        });
        let speeds: Vec<_> = panels.iter().map(|panel| (panel.ego_kmh, panel.other_kmh)).collect();
        assert_eq!(speeds, [(20, 10), (30, 10), (30, 20)]);
        let panel = &panels[1];
        assert_eq!(panel.distances_m.len(), 59);
        assert_eq!(panel.lateral_tenths_mps.len(), 18);
        let expected = cut_in::low()
            .filter(|case| (case.ego_kmh, case.other_kmh) == (30, 10))
            .filter(|case| case.drive(Model::Regulation).outcome.is_collision())
            .count();
        assert_eq!(panel.collisions.len(), expected);
        assert!(expected > 0);
    }
}
