//! The classic picture of the cut-ins. For each pair of speeds it shows the cases that end in a collision, over
//! distance and lateral speed. It also shows the edges of the models' regions.

use report::chart::{Axis, Edges, Stroke, Tone, cells};
use report::html::{figure, grid};

use super::matrix::Case;
use super::results::Judged;
use crate::{Model, Outcome, cut_in};

/// Pictures of the collisions of each driver of the cut-ins, with their heading; of `regulation` without a law.
pub fn of(judged: &Judged) -> Vec<(String, String)> {
    let cases: Vec<_> = judged.cases.iter().filter_map(Case::cut_in).enumerate().collect();
    if cases.is_empty() {
        return Vec::new();
    }
    let speeds = |of: &(usize, &cut_in::Case)| (of.1.ego_kmh, of.1.other_kmh);
    let pairs = cases.chunk_by(|a, b| speeds(a) == speeds(b));
    let pairs: Vec<_> = pairs.map(|cases| (cases, regions(speeds(&cases[0])))).collect();
    if judged.drivers.is_empty() {
        let outcome = |index: usize| cases[index].1.drive(Model::Regulation).outcome;
        return vec![("Collisions of regulation".to_owned(), pictures(&pairs, &outcome))];
    }
    let drivers = judged.drivers.iter().map(|driven| {
        let with = if driven.aebs { " with the emergency brake" } else { "" };
        let outcome = |index: usize| driven.ends[index].verdict.outcome;
        (format!("Collisions of {}{with}", driven.law), pictures(&pairs, &outcome))
    });
    drivers.collect()
}

/// The regions of a pair of speeds: title and axes of its picture, and the edges of each model's region.
struct Regions {
    title: String,
    x: Axis,
    y: Axis,
    edges: Vec<Edges>,
}

/// A picture for each pair of speeds with a collision.
fn pictures(
    pairs: &[(&[(usize, &cut_in::Case)], Regions)],
    outcome: &dyn Fn(usize) -> Outcome,
) -> String {
    let (mut html, mut empty) = (String::new(), 0);
    for (cases, regions) in pairs {
        let ends = cases.iter().map(|(index, case)| (case, outcome(*index)));
        let collisions = ends.filter(|(_, end)| end.is_collision());
        let (side, rear): (Vec<_>, Vec<_>) = collisions.partition(|(_, end)| *end == Outcome::Side);
        if side.is_empty() && rear.is_empty() {
            empty += 1;
            continue;
        }
        let corners = |ends: &[(&&cut_in::Case, Outcome)]| -> Vec<_> {
            ends.iter().map(|(case, _)| cell(case)).collect()
        };
        let kinds =
            [("rear-end", Tone::Alarm, corners(&rear)), ("side", Tone::Clear, corners(&side))];
        let Regions { title, x, y, edges } = regions;
        html += &figure(cells(title, (x, y), &kinds, edges));
    }
    format!(
        "<p class=\"quiet\">{empty} other pairs of speeds have no collision</p>\n{}",
        grid(&html)
    )
}

fn regions((ego_kmh, other_kmh): (u32, u32)) -> Regions {
    let (distances_m, step_m) = cut_in::distances_m(ego_kmh);
    let distances_m: Vec<u32> = distances_m.collect();
    let laterals = cut_in::LATERAL_TENTHS_MPS;
    // Corners of the cells around the cases.
    let half_m = step_m as f64 / 2.0;
    let corner = |distance_m: &u32| f64::from(*distance_m) + half_m;
    let x: Vec<f64> = [1.0 - half_m].into_iter().chain(distances_m.iter().map(corner)).collect();
    let y: Vec<f64> = (0..=laterals.end).map(|tenths| f64::from(tenths) * 0.1 - 0.05).collect();
    let edges = Model::ALL.iter().zip(0..).map(|(model, index)| {
        let column = |&distance_m: &u32| {
            let case = |lateral_tenths_mps| cut_in::Case {
                ego_kmh,
                other_kmh,
                distance_m,
                lateral_tenths_mps,
            };
            laterals.clone().map(|tenths| case(tenths).drive(*model).is_collision()).collect()
        };
        let region: Vec<Vec<bool>> = distances_m.iter().map(column).collect();
        let has = |column: usize, row: usize| {
            region.get(column).and_then(|column| column.get(row)) == Some(&true)
        };
        Edges {
            label: model.name().to_owned(),
            tone: Tone::Series(index),
            stroke: Stroke::Solid,
            pieces: edges(&x, &y, &has),
        }
    });
    Regions {
        title: format!("{ego_kmh} km/h behind {other_kmh} km/h"),
        edges: edges.collect(),
        x: Axis::linear("distance, m", 0.0, x[x.len() - 1]),
        y: Axis::linear("lateral speed, m/s", y[0], y[y.len() - 1]),
    }
}

/// Lower left and upper right corner of a case's cell.
fn cell(case: &cut_in::Case) -> [(f64, f64); 2] {
    let half_m = cut_in::distances_m(case.ego_kmh).1 as f64 / 2.0;
    let (distance_m, lateral_mps) = (f64::from(case.distance_m), case.lateral_mps());
    [(distance_m - half_m, lateral_mps - 0.05), (distance_m + half_m, lateral_mps + 0.05)]
}

/// The edges of a region of cells, as long as they are straight. `x` and `y` are the corners. `has` takes column and
/// row, and is false off the grid.
fn edges(x: &[f64], y: &[f64], has: &dyn Fn(usize, usize) -> bool) -> Vec<[(f64, f64); 2]> {
    let lying = upright(y, x, &|row, column| has(column, row));
    let lying = lying.into_iter().map(|ends| ends.map(|(y, x)| (x, y)));
    upright(x, y, has).into_iter().chain(lying).collect()
}

fn upright(x: &[f64], y: &[f64], has: &dyn Fn(usize, usize) -> bool) -> Vec<[(f64, f64); 2]> {
    let mut edges = Vec::new();
    for (column, &at) in x.iter().enumerate() {
        let is_edge = |row: &usize| has(column.wrapping_sub(1), *row) != has(column, *row);
        let rows: Vec<usize> = (0..y.len() - 1).filter(is_edge).collect();
        let runs = rows.chunk_by(|a, b| a + 1 == *b);
        edges.extend(runs.map(|run| [(at, y[run[0]]), (at, y[run[0] + run.len()])]));
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_runs_around_the_region() {
        let has = |column, row| row == 0 && column < 2;
        let edges = edges(&[0.5, 1.5, 2.5, 3.5], &[-0.05, 0.05, 0.15], &has);
        assert_eq!(edges.len(), 4, "two cells beside each other are one rectangle");
        assert!(edges.contains(&[(2.5, -0.05), (2.5, 0.05)]), "{edges:?}");
        assert!(edges.contains(&[(0.5, 0.05), (2.5, 0.05)]), "{edges:?}");
    }

    #[test]
    fn a_cell_lies_around_its_case_and_the_models_regions_are_drawn() {
        let case =
            cut_in::Case { ego_kmh: 90, other_kmh: 10, distance_m: 21, lateral_tenths_mps: 5 };
        let [from, to] = cell(&case);
        assert_eq!((from.0, to.0), (20.0, 22.0));
        assert!((from.1 - 0.45).abs() < 1e-12 && (to.1 - 0.55).abs() < 1e-12);
        let picture = regions((case.ego_kmh, case.other_kmh));
        assert!(picture.edges.iter().all(|edges| !edges.pieces.is_empty()));
    }
}
