//! Rows coloured by a value along one axis, such as the speeds of many vehicles over time.

use super::Picture;
use super::axis::Axis;
use super::data::{Chart, Map, columns};

/// Least and largest height of a row, px.
const ROW_PX: (f64, f64) = (2.0, 16.0);
/// Height that all rows share, px.
const ROOM_PX: f64 = 320.0;
/// Columns and values distinguished in a row.
const RESOLUTION: (f64, f64) = (800.0, 200.0);

#[derive(Clone, Debug, PartialEq)]
pub struct Ribbon {
    /// Place on the axis and the value from there to the next place.
    pub values: Vec<(f64, f64)>,
}

/// Rows over one axis, from top to bottom.
#[derive(Clone, Debug)]
pub struct Ribbons {
    pub title: String,
    pub x: Axis,
    pub rows_label: String,
    pub unit: String,
    pub rows: Vec<Ribbon>,
}

impl Ribbons {
    /// Lowest and highest value; they always differ.
    fn range(&self) -> (f64, f64) {
        let values = self.rows.iter().flat_map(|row| &row.values).map(|value| value.1);
        let values = values.filter(|value| value.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        match (low, high) {
            (low, high) if low < high => (low, high),
            (low, _) if low.is_finite() => (low, low + low.abs().max(1.0)),
            _ => (0.0, 1.0),
        }
    }
}

impl Picture for Ribbons {
    fn title(&self) -> &str {
        &self.title
    }

    fn chart(&self) -> Chart {
        let count = self.rows.len().max(1) as f64;
        let (low, high) = self.range();
        let values = Axis::linear(&self.unit, low, high);
        let rows = self.rows.iter();
        let rows = rows.map(|row| columns(&row.values, true, (&self.x, &values), RESOLUTION));
        let map = Map { low, high, unit: self.unit.clone(), rows: rows.collect() };
        let y = Axis::whole(&self.rows_label, 0.5, count + 0.5);
        let row_px = (ROOM_PX / count).floor().clamp(ROW_PX.0, ROW_PX.1);
        Chart { map: Some(map), ..Chart::new(&self.x, &y, row_px * count) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ribbons(rows: usize) -> Ribbons {
        let row = |k: usize| Ribbon {
            values: vec![(0.0, 10.0), (4.0, 10.0), (6.0, 20.0 + k as f64), (10.0, 20.0)],
        };
        Ribbons {
            title: "Speeds".into(),
            x: Axis::time(10.0),
            rows_label: "car".into(),
            unit: "m/s".into(),
            rows: (0..rows).map(row).collect(),
        }
    }

    #[test]
    fn many_rows_are_thin_and_few_are_not_tall() {
        let height = |rows| ribbons(rows).chart().height / rows as f64;
        assert_eq!([1, 10, 100, 1000].map(height), [16.0, 16.0, 3.0, 2.0]);
    }

    #[test]
    fn a_picture_without_values_or_of_one_has_a_range() {
        let empty = Ribbons { rows: vec![Ribbon { values: Vec::new() }], ..ribbons(0) };
        assert_eq!(empty.range(), (0.0, 1.0));
        let still = Ribbons { rows: vec![Ribbon { values: vec![(0.0, 5.0)] }], ..ribbons(0) };
        assert_eq!(still.range(), (5.0, 10.0));
    }
}
