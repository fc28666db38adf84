//! Rows of which each is coloured by a value along one axis: speeds of many vehicles over time.

use super::axis::{Axis, number};
use super::plot::{BOTTOM, LEFT, RIGHT, horizontal_ticks};
use super::svg::{Anchor, Svg};
use super::{Key, Picture, Tone, Width};

/// Steps of the scale of colours.
pub const SHADES: usize = 8;
/// Heights that a row may have, px; the style sheet has a class for each.
const HEIGHTS: [usize; 7] = [2, 3, 4, 6, 8, 12, 16];
/// Height that all rows share, px.
const ROOM: usize = 320;
/// Room above the rows, px.
const TOP: f64 = 22.0;

/// A row.
#[derive(Clone, Debug, PartialEq)]
pub struct Ribbon {
    /// Place on the axis and value there, which holds until the next one.
    pub values: Vec<(f64, f64)>,
}

/// Rows over one axis, the first on top.
#[derive(Clone, Debug)]
pub struct Ribbons {
    /// Title.
    pub title: String,
    /// The axis.
    pub x: Axis,
    /// What a row is.
    pub rows_label: String,
    /// Unit of the values.
    pub unit: String,
    /// The rows.
    pub rows: Vec<Ribbon>,
}

impl Ribbons {
    /// Lowest and highest value; never equal.
    fn range(&self) -> (f64, f64) {
        let values = self.rows.iter().flat_map(|row| &row.values).map(|value| value.1);
        let values = values.filter(|value| value.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        if low < high { (low, high) } else { (low.min(0.0), low.min(0.0) + low.abs().max(1.0)) }
    }

    fn shade(&self, (low, high): (f64, f64), value: f64) -> usize {
        ((value - low) / (high - low) * SHADES as f64).clamp(0.0, SHADES as f64 - 1.0) as usize
    }

    /// Height of a row, px.
    fn height(&self) -> usize {
        let share = ROOM / self.rows.len().max(1);
        HEIGHTS.into_iter().rev().find(|height| *height <= share).unwrap_or(HEIGHTS[0])
    }

    /// The pieces of a row, each of one shade: from, to and shade.
    fn pieces(&self, row: &Ribbon, range: (f64, f64)) -> Vec<(f64, f64, usize)> {
        let mut pieces: Vec<(f64, f64, usize)> = Vec::new();
        for (index, (x, value)) in row.values.iter().enumerate() {
            let until = row.values.get(index + 1).map_or(*x, |next| next.0);
            let shade = self.shade(range, *value);
            match pieces.last_mut() {
                Some(last) if last.2 == shade => last.1 = until,
                _ => pieces.push((*x, until, shade)),
            }
        }
        pieces
    }
}

impl Picture for Ribbons {
    fn title(&self) -> &str {
        &self.title
    }

    fn keys(&self) -> Vec<Key> {
        let (low, high) = self.range();
        let step = (high - low) / SHADES as f64;
        let decimals = if step < 1.0 { 1 } else { 0 };
        let key = |shade: usize| {
            let from = number(low + shade as f64 * step, decimals);
            let unit = &self.unit;
            let label = match shade {
                0 => format!("from {from} {unit}"),
                _ => from,
            };
            Key { label, tone: Tone::Shade(shade), stroke: None }
        };
        (0..SHADES).map(key).collect()
    }

    fn svg(&self, width: Width) -> String {
        let (left, right) = (LEFT, width.px() - RIGHT);
        let height = self.height();
        let bottom = TOP + (height * self.rows.len()) as f64;
        let place = |x: f64| left + self.x.share(x).clamp(0.0, 1.0) * (right - left);
        let label = format!("{} over {}", self.title, self.x.label);
        let mut svg = Svg::new(width.px(), bottom + BOTTOM, &label);
        svg.text("unit", Anchor::Start, (4.0, 13.0), &self.rows_label);
        let range = self.range();
        let mut shades: [Vec<Vec<(f64, f64)>>; SHADES] = Default::default();
        for (index, row) in self.rows.iter().enumerate() {
            let y = TOP + height as f64 * (index as f64 + 0.5);
            for (from, to, shade) in self.pieces(row, range) {
                shades[shade].push(vec![(place(from), y), (place(to), y)]);
            }
            // A number for every row that has room for one, and for the last.
            let every = (16 / height).max(1) * if self.rows.len() > 20 { 5 } else { 1 };
            if index == 0 || (index + 1) % every == 0 {
                svg.text("tick", Anchor::End, (left - 6.0, y + 4.0), &(index + 1).to_string());
            }
        }
        for (shade, pieces) in shades.iter().enumerate().filter(|(_, pieces)| !pieces.is_empty()) {
            svg.curve(&format!("ribbon h{height} {}", Tone::Shade(shade).class()), pieces);
        }
        horizontal_ticks(&mut svg, &self.x, (left, right), bottom);
        svg.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ribbons(rows: usize) -> Ribbons {
        let row = |k: usize| Ribbon {
            values: vec![(0.0, 10.0), (4.0, 10.1), (6.0, 20.0 + k as f64), (10.0, 20.0)],
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
    fn neighbours_of_one_shade_are_one_piece() {
        let ribbons = ribbons(1);
        let pieces = ribbons.pieces(&ribbons.rows[0], ribbons.range());
        assert_eq!(pieces, [(0.0, 6.0, 0), (6.0, 10.0, SHADES - 1)]);
    }

    #[test]
    fn many_rows_are_thin_and_few_are_not_tall() {
        assert_eq!([1, 10, 100, 1000].map(|rows| ribbons(rows).height()), [16, 16, 3, 2]);
        let svg = ribbons(100).svg(Width::Narrow);
        assert!(svg.contains("ribbon h3 q0") && !svg.contains("NaN"), "{svg}");
        assert_eq!(ribbons(3).keys().len(), SHADES);
    }

    #[test]
    fn a_picture_without_values_is_no_error() {
        let empty = Ribbons { rows: vec![Ribbon { values: Vec::new() }], ..ribbons(0) };
        assert!(!empty.svg(Width::Wide).contains("NaN"));
        let still = Ribbons { rows: vec![Ribbon { values: vec![(0.0, 5.0)] }], ..ribbons(0) };
        assert!(!still.svg(Width::Wide).contains("NaN"));
    }
}
