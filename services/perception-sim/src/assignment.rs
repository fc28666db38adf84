//! The assignment of tracks to vehicles with the least GOSPA.

use messages::{MAX_TRACKS, MAX_VEHICLES};

use crate::radar::scene::Scene;
use crate::tracking::TrackList;

/// Distance c beyond which a track belongs to no vehicle, m.
pub(crate) const CUTOFF_M: f64 = 10.0;
/// A track may be this far from the body of a vehicle that is seen in part, m.
const BODY_MARGIN_M: f64 = 3.0;

/// Vehicle of each track.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Assignment {
    /// Places in the scenario, which has fewer than 256 vehicles.
    pub(crate) vehicle_of: [Option<u8>; MAX_TRACKS],
    /// Pairs, and the sum of their squared distances, m².
    pub(crate) count: u64,
    pub(crate) squares: f64,
    /// Tracks of vehicles that are in view in part at most.
    pub(crate) partly: u64,
}

impl Assignment {
    /// The assignment with the least GOSPA.
    pub(crate) fn best(scene: &Scene, in_view: &[bool], list: &TrackList) -> Self {
        let limit = CUTOFF_M * CUTOFF_M;
        // Squared distances by vehicle, of those near any track. Each track may also have no vehicle, at the limit's cost.
        let mut near = [(0, [limit; MAX_TRACKS]); MAX_VEHICLES];
        let mut count = 0;
        for (vehicle, truth) in scene.vehicles.iter().enumerate().filter(|(i, _)| in_view[*i]) {
            let gap_m = truth.rear_position_m - scene.ego.position_m;
            let mut squares = [limit; MAX_TRACKS];
            for (square, track) in squares.iter_mut().zip(list.tracks()) {
                let (x, y) = (track.gap_m - gap_m, track.lateral_m - truth.lateral_m);
                *square = (x * x + y * y).min(limit);
            }
            if squares.iter().any(|square| *square < limit) {
                near[count] = (vehicle as u8, squares);
                count += 1;
            }
        }
        let near = &near[..count];
        let cost = |track: usize, column: usize| near.get(column).map_or(limit, |n| n.1[track]);
        let columns = cheapest(list.count, count + list.count, cost);
        let mut best = Self::default();
        for (track, column) in columns.into_iter().enumerate().take(list.count) {
            if let Some((vehicle, squares)) = near.get(column)
                && squares[track] < limit
            {
                best.vehicle_of[track] = Some(*vehicle);
                best.count += 1;
                best.squares += squares[track];
            }
        }
        best.add_partly_seen(scene, in_view, list);
        best
    }

    pub(crate) fn track_of(&self, vehicle: usize) -> Option<usize> {
        self.vehicle_of.iter().position(|of| of.map(usize::from) == Some(vehicle))
    }

    /// Gives the remaining tracks to the vehicles on whose bodies they are.
    fn add_partly_seen(&mut self, scene: &Scene, in_view: &[bool], list: &TrackList) {
        for (index, track) in list.tracks().iter().enumerate() {
            if self.vehicle_of[index].is_some() {
                continue;
            }
            let owner = (0..scene.vehicles.len()).find(|&vehicle| {
                let truth = &scene.vehicles[vehicle];
                let along_m = track.gap_m + scene.ego.position_m - truth.rear_position_m;
                truth.present
                    && !in_view[vehicle]
                    && self.track_of(vehicle).is_none()
                    && (-BODY_MARGIN_M..truth.length_m + BODY_MARGIN_M).contains(&along_m)
                    && (track.lateral_m - truth.lateral_m).abs() < BODY_MARGIN_M
            });
            if let Some(owner) = owner {
                self.vehicle_of[index] = Some(owner as u8);
                self.partly += 1;
            }
        }
    }
}

/// Columns beyond which there are none: all vehicles, and none for each track.
const COLUMNS: usize = MAX_VEHICLES + MAX_TRACKS;

/// A column for each of `rows` such that the sum of the costs is least. Each row takes the shortest augmenting path.
///
/// Source: Jonker and Volgenant, A shortest augmenting path algorithm for dense and sparse linear assignment problems,
/// Computing 38 (1987) 325.
fn cheapest(
    rows: usize,
    columns: usize,
    cost: impl Fn(usize, usize) -> f64,
) -> [usize; MAX_TRACKS] {
    const NONE: usize = usize::MAX;
    // Prices, of which no sum of a row's and a column's is above their cost.
    let (mut row_price, mut column_price) = ([0.0; MAX_TRACKS], [0.0; COLUMNS]);
    let mut row_of = [NONE; COLUMNS];
    for begin in 0..rows {
        // Length of the shortest path to each column, and the column before it.
        let (mut way, mut before) = ([f64::INFINITY; COLUMNS], [NONE; COLUMNS]);
        let mut is_reached = [false; COLUMNS];
        let (mut row, mut last) = (begin, NONE);
        while row != NONE {
            let (mut step, mut next) = (f64::INFINITY, NONE);
            for column in (0..columns).filter(|column| !is_reached[*column]) {
                let here = cost(row, column) - row_price[row] - column_price[column];
                if here < way[column] {
                    (way[column], before[column]) = (here, last);
                }
                if way[column] < step {
                    (step, next) = (way[column], column);
                }
            }
            row_price[begin] += step;
            for column in 0..columns {
                if is_reached[column] {
                    row_price[row_of[column]] += step;
                    column_price[column] -= step;
                } else {
                    way[column] -= step;
                }
            }
            is_reached[next] = true;
            (row, last) = (row_of[next], next);
        }
        while last != NONE {
            let from = before[last];
            row_of[last] = if from == NONE { begin } else { row_of[from] };
            last = from;
        }
    }
    let mut column_of = [NONE; MAX_TRACKS];
    for (column, row) in row_of.into_iter().enumerate().filter(|(_, row)| *row != NONE) {
        column_of[row] = column;
    }
    column_of
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Least sum of the costs by trying all columns for each row.
    fn tried(costs: &[Vec<f64>], taken: u32) -> f64 {
        let Some((row, rest)) = costs.split_first() else { return 0.0 };
        let free = (0..row.len()).filter(|column| taken & 1 << column == 0);
        let sums = free.map(|column| row[column] + tried(rest, taken | 1 << column));
        sums.fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn the_sum_is_the_least_of_all(
            costs in prop::collection::vec(prop::collection::vec(0.0..100.0_f64, 6), 1..=5),
        ) {
            let columns = cheapest(costs.len(), 6, |row, column| costs[row][column]);
            let found: f64 = costs.iter().zip(columns).map(|(row, column)| row[column]).sum();
            prop_assert!((found - tried(&costs, 0)).abs() < 1e-9);
            let mut taken = columns[..costs.len()].to_vec();
            taken.sort_unstable();
            taken.dedup();
            prop_assert_eq!(taken.len(), costs.len());
        }
    }
}
