//! Lines of lanes along an axis: lanes that begin, end and change their width.

use serde::{Deserialize, Serialize};

/// The lines at stations along an axis. Between two stations they run straight in the axis' coordinates.
///
/// A station is `[p, l, ..]`, m: its place along the axis, and the lines there from right to left. The first and the
/// last line are the edges of the road. Lines begin and end where their number changes.
///
/// ```
/// use road::LaneLines;
/// // A second lane opens to the right of the first one between 100 and 150 m.
/// let lines = LaneLines::new(vec![
///     vec![0.0, -1.75, 1.75],
///     vec![100.0, -1.75, 1.75],
///     vec![100.0, -1.75, -1.75, 1.75],
///     vec![150.0, -5.25, -1.75, 1.75],
/// ]);
/// assert!(lines.is_sound());
/// assert_eq!(lines.edges_m(125.0), Some([-3.5, 1.75]));
/// assert_eq!(lines.edges_m(900.0), Some([-5.25, 1.75]));
/// // Two lines of the first stretch, three of the second.
/// assert_eq!(lines.between(0.0, 200.0).len(), 5);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct LaneLines {
    stations: Vec<Vec<f64>>,
}

impl LaneLines {
    pub fn new(stations: Vec<Vec<f64>>) -> Self {
        Self { stations }
    }

    /// True without stations.
    pub fn is_empty(&self) -> bool {
        self.stations.is_empty()
    }

    pub fn stations(&self) -> &[Vec<f64>] {
        &self.stations
    }

    /// True if all stations are in order and have edges, and all lines are in order from right to left.
    pub fn is_sound(&self) -> bool {
        let is_sorted = |values: &[f64]| values.windows(2).all(|pair| pair[0] <= pair[1]);
        let is_station = |station: &Vec<f64>| {
            station.len() >= 3
                && station.iter().all(|value| value.is_finite())
                && is_sorted(&station[1..])
        };
        self.stations.iter().all(is_station)
            && self.stations.windows(2).all(|pair| pair[0][0] <= pair[1][0])
    }

    /// The right and the left edge at a place, m; `None` without stations. Beyond the ends they stay as they are.
    pub fn edges_m(&self, p_m: f64) -> Option<[f64; 2]> {
        let edges = |station: &Vec<f64>| [station[1], station[station.len() - 1]];
        let (a, b, share) = around(&self.stations, |station| station[0], p_m)?;
        let (from, to) = (edges(a), edges(b));
        Some([0, 1].map(|side| from[side] + share * (to[side] - from[side])))
    }

    /// The lines between two places as points `[p, l]`, m. Each stretch with one number of lines has these from right
    /// to left.
    pub fn between(&self, from_m: f64, to_m: f64) -> Vec<Vec<[f64; 2]>> {
        let mut lines: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut open = 0..0;
        for (index, station) in self.stations.iter().enumerate() {
            let next_m = self.stations.get(index + 1).map_or(f64::INFINITY, |next| next[0]);
            if next_m < from_m || station[0] > to_m && open.is_empty() {
                continue;
            }
            if open.len() != station.len() - 1 {
                open = lines.len()..lines.len() + station.len() - 1;
                lines.resize(open.end, Vec::new());
            }
            for (line, l_m) in lines[open.clone()].iter_mut().zip(&station[1..]) {
                line.push([station[0], *l_m]);
            }
            if station[0] > to_m {
                break;
            }
        }
        // The last stretch goes on.
        for line in &mut lines[open] {
            if let Some([p_m, l_m]) = line.last().copied()
                && p_m < to_m
            {
                line.push([to_m, l_m]);
            }
        }
        lines
    }
}

/// The offset of a line at a place, from its points `[p, l]`, m. Beyond the ends it stays as it is.
///
/// ```
/// let line = [[0.0, 1.0], [10.0, 3.0]];
/// assert_eq!([-5.0, 5.0, 20.0].map(|p_m| road::offset_at(&line, p_m)), [1.0, 2.0, 3.0]);
/// ```
pub fn offset_at(line: &[[f64; 2]], p_m: f64) -> f64 {
    let found = around(line, |point| point[0], p_m);
    found.map_or(0.0, |([_, a_m], [_, b_m], share)| a_m + share * (b_m - a_m))
}

/// The two of a sorted list around a place, and the share of the way between them. Beyond an end it is the last one.
pub(crate) fn around<T>(list: &[T], at: impl Fn(&T) -> f64, p_m: f64) -> Option<(&T, &T, f64)> {
    let next = list.partition_point(|item| at(item) <= p_m);
    match (next.checked_sub(1).map(|before| &list[before]), list.get(next)) {
        (Some(a), Some(b)) => Some((a, b, (p_m - at(a)) / (at(b) - at(a)))),
        (Some(end), None) | (None, Some(end)) => Some((end, end, 0.0)),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_list_of_lines_is_not_sound() {
        for stations in [
            vec![vec![0.0, 1.0]],
            vec![vec![0.0, 1.0, -1.0]],
            vec![vec![0.0, -1.0, f64::NAN]],
            vec![vec![5.0, -1.0, 1.0], vec![4.0, -1.0, 1.0]],
        ] {
            assert!(!LaneLines::new(stations.clone()).is_sound(), "{stations:?}");
        }
        assert!(LaneLines::default().is_sound());
        assert_eq!(LaneLines::default().edges_m(3.0), None);
    }

    #[test]
    fn a_part_of_the_road_has_the_stations_around_it() {
        let station = |p_m: f64| vec![p_m, -1.75, 1.75];
        let lines = LaneLines::new((0..10).map(|k| station(10.0 * f64::from(k))).collect());
        let part = lines.between(35.0, 52.0);
        assert_eq!(part.len(), 2);
        assert_eq!(part[0], [30.0, 40.0, 50.0, 60.0].map(|p_m| [p_m, -1.75]));
        let beyond = lines.between(85.0, 120.0);
        assert_eq!(beyond[1], [[80.0, 1.75], [90.0, 1.75], [120.0, 1.75]]);
    }
}
