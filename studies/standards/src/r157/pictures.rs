//! The classic picture of the cut-ins: collisions over distance and lateral speed, one panel for each pair of speeds.

use crate::picture::{Collision, Panel, panels};
use crate::{Model, Outcome, Verdict};
use report::chart::{Axis, Cells, Edges, FilledCell, Stroke, Tone};
use report::html::figure;

use super::drive::Driver;
use super::judged::{Driven, Judged};
use super::matrix::Case;

/// Half a step of the lateral speeds, m/s.
const HALF_LATERAL_MPS: f64 = 0.05;

/// Pictures of the collisions of each driver of the cut-ins, with their heading; of `regulation` without a law.
pub fn of(judged: &Judged) -> Vec<(String, String)> {
    let cut_ins = || {
        judged.cases.iter().filter_map(|case| match case {
            Case::CutIn(case) => Some(*case),
            Case::Following(_) | Case::CutOut(_) => None,
        })
    };
    if cut_ins().next().is_none() {
        return Vec::new();
    }
    let drawn = |heading: &str, outcomes: Vec<Outcome>| {
        let mut outcomes = outcomes.into_iter();
        let panels = panels(cut_ins(), |_| outcomes.next().expect("one for each case"));
        let pairs = panels.len();
        let full: Vec<_> = panels.into_iter().filter(shows_something).collect();
        let empty = match pairs - full.len() {
            0 => String::new(),
            left_out => format!(
                "<p class=\"quiet\">{left_out} of {pairs} pairs of speeds have no case with a collision</p>\n"
            ),
        };
        let figures: String = full.iter().map(|panel| figure(&picture(panel))).collect();
        (heading.to_owned(), empty + "<div class=\"grid\">\n" + &figures + "</div>\n")
    };
    if judged.laws.is_empty() {
        let outcome = |verdict: Option<Verdict>| verdict.map_or(Outcome::None, |v| v.outcome);
        let outcomes = judged.models.iter().map(|models| outcome(models[Model::Regulation]));
        return vec![drawn("Collisions of regulation", outcomes.collect())];
    }
    (judged.laws.iter())
        .map(|Driven { driver: Driver { law, aebs }, verdicts, .. }| {
            let heading = format!(
                "Collisions of {law}{}",
                if *aebs { " with the emergency brake" } else { "" }
            );
            drawn(&heading, verdicts.iter().map(|verdict| verdict.outcome).collect())
        })
        .collect()
}

/// True if a picture of the panel has a cell or a line in it.
fn shows_something(panel: &Panel) -> bool {
    !panel.collisions.is_empty() || panel.edges.iter().any(|(_, pieces)| !pieces.is_empty())
}

fn picture(panel: &Panel) -> Cells {
    let half_m = match panel.distances_m.as_slice() {
        [first, second, ..] => f64::from(second - first) / 2.0,
        _ => 0.5,
    };
    let end = |values: &[u32]| values.last().copied().map_or(0.0, f64::from);
    let farthest_m = end(&panel.distances_m) + half_m;
    let fastest_mps = end(&panel.lateral_tenths_mps) * 0.1 + HALF_LATERAL_MPS;
    // Between the cases of a sample an edge can be far from both.
    let inside = |(distance_m, lateral_mps): (f64, f64)| {
        (distance_m.clamp(0.0, farthest_m), lateral_mps.clamp(-HALF_LATERAL_MPS, fastest_mps))
    };
    let cell = |collision: &Collision| {
        let distance_m = f64::from(collision.distance_m);
        let lateral_mps = f64::from(collision.lateral_tenths_mps) * 0.1;
        FilledCell {
            from: inside((distance_m - half_m, (lateral_mps - HALF_LATERAL_MPS).max(0.0))),
            to: inside((distance_m + half_m, lateral_mps + HALF_LATERAL_MPS)),
            kind: usize::from(collision.outcome == Outcome::Side),
        }
    };
    let edges = panel.edges.iter().zip(0..).map(|((model, pieces), index)| Edges {
        label: model.name().to_owned(),
        tone: Tone::Series(index),
        stroke: Stroke::Solid,
        pieces: pieces.iter().map(|piece| piece.map(inside)).collect(),
    });
    Cells {
        title: format!("{} km/h behind {} km/h", panel.ego_kmh, panel.other_kmh),
        x: Axis::linear("distance, m", 0.0, farthest_m),
        y: Axis::linear("lateral speed, m/s", -HALF_LATERAL_MPS, fastest_mps),
        kinds: vec![("rear-end".into(), Tone::Alarm), ("side".into(), Tone::Clear)],
        cells: panel.collisions.iter().map(cell).collect(),
        edges: edges.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PerModel;

    #[test]
    fn a_panel_without_a_collision_is_not_drawn() {
        let edges = PerModel::new(|_| Vec::new());
        let mut panel = Panel {
            ego_kmh: 40,
            other_kmh: 20,
            distances_m: vec![10],
            lateral_tenths_mps: vec![3],
            collisions: Vec::new(),
            edges,
        };
        assert!(!shows_something(&panel));
        let outcome = Outcome::Side;
        panel.collisions.push(Collision { distance_m: 10, lateral_tenths_mps: 3, outcome });
        assert!(shows_something(&panel));
    }
}
