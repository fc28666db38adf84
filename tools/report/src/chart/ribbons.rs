//! Rows coloured by a value along one axis, such as the speeds of many vehicles over time.

use super::axis::{Axis, bounds};
use super::data::{Chart, Map, columns};

/// Least and largest height of a row, px.
const ROW_PX: (f64, f64) = (2.0, 16.0);
/// Height that all rows share, px.
const ROOM_PX: f64 = 320.0;
/// Columns and values distinguished in a row.
const RESOLUTION: (f64, f64) = (800.0, 200.0);

/// Rows from top to bottom. Each has places on the axis, and its values from there to the next place.
pub fn ribbons(
    title: &str,
    x: &Axis,
    rows_label: &str,
    unit: &str,
    rows: &[Vec<(f64, f64)>],
) -> Chart {
    let count = rows.len().max(1) as f64;
    let (low, high) = range(rows);
    let values = Axis::linear(unit, low, high);
    let columns = rows.iter().map(|row| columns(row, true, (x, &values), RESOLUTION));
    let map = Map { low, high, unit: unit.to_owned(), rows: columns.collect() };
    let y = Axis::whole(rows_label, 0.5, count + 0.5);
    let row_px = (ROOM_PX / count).floor().clamp(ROW_PX.0, ROW_PX.1);
    Chart { map: Some(map), ..Chart::new(title, x, &y, row_px * count) }
}

/// Lowest and highest value; they always differ.
fn range(rows: &[Vec<(f64, f64)>]) -> (f64, f64) {
    match bounds(rows.iter().flatten().map(|value| value.1)) {
        Some((low, high)) if low < high => (low, high),
        Some((low, _)) => (low, low + low.abs().max(1.0)),
        None => (0.0, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_rows_are_thin_and_few_are_not_tall() {
        let row = |k: usize| vec![(0.0, 10.0), (4.0, 10.0), (6.0, 20.0 + k as f64), (10.0, 20.0)];
        let height = |count: usize| {
            let rows: Vec<_> = (0..count).map(row).collect();
            ribbons("Speeds", &Axis::time(10.0), "car", "m/s", &rows).height / count as f64
        };
        assert_eq!([1, 10, 100, 1000].map(height), [16.0, 16.0, 3.0, 2.0]);
    }

    #[test]
    fn a_picture_without_values_or_of_one_has_a_range() {
        assert_eq!(range(&[Vec::new()]), (0.0, 1.0));
        assert_eq!(range(&[vec![(0.0, 5.0)]]), (5.0, 10.0));
    }
}
