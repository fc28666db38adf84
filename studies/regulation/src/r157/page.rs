//! The results as a page: tables, and the classic picture of the cut-ins.

use crate::picture::{Collision, Panel, panels};
use crate::{Model, Outcome, Verdict};
use report::chart::{Axis, Cells, Edges, FilledCell, Stroke, Tone};
use report::html::{Cell, Column, document, figure, section, table};

use super::drive::Driver;
use super::judged::{Driven, Judged};
use super::limits::Limit;
use super::matrix::Case;
use super::print;
use super::results::{Figures, LawResult, Results};

/// Half a step of the lateral speeds, m/s.
const HALF_LATERAL_MPS: f64 = 0.05;

/// The page.
pub fn page(results: &Results, judged: &[Judged]) -> String {
    let verdict = if judged.iter().all(|judged| judged.laws.is_empty()) {
        "The models alone".to_owned()
    } else if results.ok {
        "Every law with the emergency brake masters what the models master".to_owned()
    } else {
        "A law with the emergency brake misses a limit".to_owned()
    };
    let mut body = String::new();
    for matrix in &results.matrices {
        for (part, of_part) in matrix.parts.iter().rev() {
            body += &section(&format!("{}, {part}", matrix.matrix), &figures(of_part));
        }
        body += &section(matrix.matrix, &figures(&matrix.all));
    }
    for judged in judged {
        body += &pictures(judged);
    }
    document("UN R157", &scope(judged), results.ok, &verdict, &body)
}

/// The matrices, and how much of each was driven.
fn scope(judged: &[Judged]) -> String {
    let each = judged.iter().map(|judged| {
        let (name, cases, all) =
            (judged.matrix.name(), judged.cases.len(), judged.matrix.cases().len());
        if cases == all {
            name.to_owned()
        } else {
            format!("{name}: a sample, {cases} of {all} cases")
        }
    });
    each.collect::<Vec<_>>().join("; ")
}

fn figures(figures: &Figures) -> String {
    let mut head = vec![
        ("driver", Column::Text),
        ("collisions", Column::Number),
        ("rear-end", Column::Number),
        ("avoidable by both models", Column::Number),
        ("of that within a step", Column::MoreNumber),
        ("impact, m/s", Column::MoreNumber),
        ("model's impact, m/s", Column::MoreNumber),
    ];
    let from_its_gap = figures.laws.iter().any(|law| law.from_its_gap.is_some());
    if from_its_gap {
        head.push(("careful-driver from its gap", Column::Number));
        head.push(("avoidable from it", Column::Number));
    }
    let mut rows = Vec::new();
    for (model, collisions) in &figures.models {
        let mut row = vec![
            Cell::Plain((*model).to_owned()),
            Cell::Plain(print::number(*collisions)),
            Cell::Plain(print::number(figures.models_rear_end[model])),
        ];
        row.resize_with(head.len(), || Cell::Plain("–".into()));
        rows.push(row);
    }
    for law in &figures.laws {
        let judged = |limits: &[Limit], text: String| judged_cell(figures, law, limits, text);
        let mut row = vec![
            Cell::Plain(print::driver(law)),
            judged(&[Limit::NoCollision, Limit::ThirdOfRegulation], law.collisions.to_string()),
            Cell::Plain(law.rear_end.to_string()),
            judged(
                &[Limit::MasteredByBoth],
                print::share(law.avoidable.both, figures.mastered_by_both),
            ),
            Cell::Plain(print::number(law.avoidable.both_within_a_step)),
            Cell::Plain(print::speed(law.mean_impact_mps)),
            Cell::Plain(print::speed(law.model_impact_mps)),
        ];
        if let Some(model) = &law.from_its_gap {
            row.push(Cell::Plain(model.collisions.to_string()));
            let avoidable = print::share(model.avoidable, model.mastered);
            row.push(judged(&[Limit::MasteredFromItsGap], avoidable));
        }
        rows.push(row);
    }
    let sizes = format!(
        "<p class=\"quiet\">{} cases, {} mastered by both models</p>",
        figures.cases, figures.mastered_by_both
    );
    sizes + &table(&head, &rows)
}

/// A figure, which is good or bad where one of the limits applies.
fn judged_cell(figures: &Figures, law: &LawResult, limits: &[Limit], text: String) -> Cell {
    match limits.iter().find_map(|limit| figures.holds_limit(law, *limit)) {
        None => Cell::Plain(text),
        Some(true) => Cell::Good(text),
        Some(false) => Cell::Bad(text),
    }
}

/// A section with the collision cells of each driver of the cut-ins; of `regulation` without a law.
fn pictures(judged: &Judged) -> String {
    let cut_ins = || {
        judged.cases.iter().filter_map(|case| match case {
            Case::CutIn(case) => Some(*case),
            Case::Following(_) | Case::CutOut(_) => None,
        })
    };
    if cut_ins().next().is_none() {
        return String::new();
    }
    let of = |heading: &str, outcomes: Vec<Outcome>| {
        let mut outcomes = outcomes.into_iter();
        let panels = panels(cut_ins(), |_| outcomes.next().expect("one for each case"));
        let pairs = panels.len();
        let drawn: Vec<_> = panels.into_iter().filter(shows_something).collect();
        let empty = match pairs - drawn.len() {
            0 => String::new(),
            left_out => format!(
                "<p class=\"quiet\">{left_out} of {pairs} pairs of speeds have no case with a collision</p>\n"
            ),
        };
        let figures: String = drawn.iter().map(|panel| figure(&picture(panel))).collect();
        section(heading, &(empty + "<div class=\"grid\">\n" + &figures + "</div>\n"))
    };
    if judged.laws.is_empty() {
        let outcome = |verdict: Option<Verdict>| verdict.map_or(Outcome::None, |v| v.outcome);
        let outcomes = judged.models.iter().map(|models| outcome(models[Model::Regulation]));
        return of("Collisions of regulation", outcomes.collect());
    }
    (judged.laws.iter())
        .map(|Driven { driver: Driver { law, aebs }, verdicts, .. }| {
            let heading = format!(
                "Collisions of {law}{}",
                if *aebs { " with the emergency brake" } else { "" }
            );
            of(&heading, verdicts.iter().map(|verdict| verdict.outcome).collect())
        })
        .collect()
}

/// Whether a picture of the panel has a cell or a line in it.
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
    use super::super::matrix::Matrix;
    use super::*;
    use crate::PerModel;

    #[test]
    fn the_heading_says_which_matrices_were_driven_and_how_much_of_each() {
        let mut following = Judged::new(Matrix::Following, Matrix::Following.cases());
        assert_eq!(scope(std::slice::from_ref(&following)), "following");
        let all = following.cases.len();
        following.cases.truncate(2);
        assert_eq!(scope(&[following]), format!("following: a sample, 2 of {all} cases"));
    }

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
