//! The document of the results.

use std::collections::BTreeSet;

use report::results::{Broken, Column, Document, Format, Table, column, count, number, word};
use serde_json::{Value, json};

use super::limits::Position;
use super::results::{Figures, Judged, LawResult, MatrixResult, Results};
use super::{R157Arguments, picture};

/// Columns of the drivers: models, and laws with and without the emergency brake.
const DRIVERS: &[Column<Value>] = &[
    word("cases", "cases", "Matrix or part"),
    word("driver", "driver", "Model, or law with or without the emergency brake"),
    count("law.collisions", "collisions", "Collisions"),
    count("law.rear_end", "rear-end", "Rear-end collisions").weight(3),
    count("law.avoidable.both", "avoidable", "Collisions in cases that both models master"),
    count("law.avoidable.both-within-a-step", "short ones", "Contacts below a step").weight(4),
    count("law.from_its_gap.collisions", "driver from its gap", "careful-driver's").weight(2),
    count("law.from_its_gap.avoidable", "avoidable from it", "Where it has none").weight(1),
    count("law.requirements_broken", "requirements broken", "Cases with a broken requirement"),
    number("law.mean_impact_mps", "impact", "m/s", 1, "Mean speed at the contact").weight(3),
    number("law.model_impact_mps", "model's impact", "m/s", 1, "The model's").weight(4),
    word("held", "by the limit", "Collisions that count, their share, its 95 % interval"),
    column("verdict", "criterion", "", Format::Verdict(words), "Position to the limits"),
];

/// A law alone has no limit, so that only one with the brake can miss it.
fn words(name: &str) -> (&'static str, bool) {
    match name {
        "beyond" => ("MISSED", false),
        "alone" => ("beyond, alone", true),
        "undecided" => ("undecided", true),
        _ => ("within", true),
    }
}

pub fn document(results: &Results, judged: &[Judged], arguments: &R157Arguments) -> Document {
    let mut document = Document::new("r157", "UN R157", results).about(scope(judged));
    for matrix in &results.matrices {
        let mut rows = Vec::new();
        for (name, figures) in matrix.figures() {
            if let Some(limit) = figures.limit {
                document = document.text(format!("{name}: {limit}"));
            }
            add(&mut rows, &name, figures);
        }
        document = document.table(Table::new(matrix.matrix, DRIVERS, &rows).blocks("cases"));
    }
    for (heading, html) in judged.iter().flat_map(picture::of) {
        document = document.figures(&heading, html);
    }
    document.verdict(results.ok, verdict(results)).broken(broken(results, arguments))
}

fn add(rows: &mut Vec<Value>, name: &str, figures: &Figures) {
    let Figures { cases, mastered_by_both, .. } = *figures;
    let cases = format!("{name}: {cases} cases, {mastered_by_both} mastered by both models");
    for (model, collisions) in &figures.models {
        let counts = json!({"collisions": collisions, "rear_end": figures.models_rear_end[model]});
        rows.push(json!({"cases": cases, "driver": model, "law": counts}));
    }
    for law in &figures.laws {
        let verdict = law.limit.as_ref().map(|held| match held.verdict {
            Position::Beyond if !law.aebs => json!("alone"),
            position => json!(position),
        });
        rows.push(json!({
            "cases": cases,
            "driver": law.driver(),
            "law": law,
            "held": law.limit.as_ref().map(ToString::to_string),
            "verdict": verdict,
        }));
    }
}

/// The verdict with and without the emergency brake.
fn verdict(results: &Results) -> String {
    let figures = results.matrices.iter().flat_map(MatrixResult::figures);
    let laws: Vec<_> = figures.flat_map(|(_, figures)| &figures.laws).collect();
    let names: BTreeSet<&str> = laws.iter().map(|law| law.law.as_str()).collect();
    if names.is_empty() {
        return "the models alone".to_owned();
    }
    let within = |aebs: bool| {
        let beyond = |law: &&&LawResult| law.aebs == aebs && law.is_beyond();
        let beyond: BTreeSet<&str> = laws.iter().filter(beyond).map(|law| &*law.law).collect();
        format!("{} of {}", names.len() - beyond.len(), names.len())
    };
    let (with, alone) = (within(true), within(false));
    format!("with the emergency brake {with} laws are within the criteria, alone {alone}")
}

/// Each law with the emergency brake that is beyond a limit, and each that broke a requirement.
fn broken(results: &Results, arguments: &R157Arguments) -> Vec<Broken> {
    let mut all = Vec::new();
    for matrix in &results.matrices {
        for (name, figures) in matrix.figures() {
            for law in figures.laws.iter().filter(|law| law.is_broken()) {
                let held = law.limit.as_ref().filter(|_| law.is_beyond()).map(ToString::to_string);
                let cases = law.requirements_broken.filter(|cases| *cases > 0);
                let cases = cases.map(|cases| format!("a requirement is broken in {cases} cases"));
                let why: Vec<String> = held.into_iter().chain(cases).collect();
                let what = format!("{name}, {}: {}", law.driver(), why.join("; "));
                all.push(Broken::new(what, arguments.command(matrix.matrix, &law.law)));
            }
        }
    }
    all
}

/// The matrices, and how much of each was driven.
fn scope(judged: &[Judged]) -> String {
    let each = judged.iter().map(|Judged { matrix, cases, .. }| {
        format!("{}: {} of {} cases", matrix.name(), cases.len(), matrix.cases().len())
    });
    each.collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::super::matrix::Matrix;
    use super::super::results::{Driven, End};
    use super::*;
    use crate::{Outcome, Verdict};
    use frame::DriveOptions;

    /// The document of a law that collides in `hits` cases of a matrix alone, and in `braked` of them with the brake.
    fn following(hits: usize, braked: usize) -> Document {
        let mut judged = Judged::new(Matrix::Following, Matrix::Following.cases());
        let hit = Verdict { outcome: Outcome::RearEnd, impact_speed_mps: 4.0 };
        for (aebs, hits) in [(false, hits), (true, braked)] {
            let verdict = |index| if index < hits { hit } else { Verdict::NONE };
            let ends = (0..judged.cases.len())
                .map(|index| End { verdict: verdict(index), is_broken: None })
                .collect();
            judged.drivers.push(Driven { law: "acc-mpc".into(), aebs, ends, from_its_gap: None });
        }
        let matrices = vec![judged.result()];
        let ok = matrices.iter().all(MatrixResult::holds);
        let arguments = R157Arguments {
            matrix: Vec::new(),
            drives: DriveOptions::default(),
            models_only: false,
            sample: None,
            seed: 1,
            table: None,
        };
        document(&Results { schema_version: 1, ok, matrices }, &[judged], &arguments)
    }

    #[test]
    fn the_heading_says_which_matrices_were_driven_and_how_much_of_each() {
        let following = Judged::new(Matrix::Following, Matrix::Following.cases());
        let cut_outs = Judged::new(Matrix::CutOut, vec![Matrix::CutOut.cases()[7]]);
        let expected = "following: 1121 of 1121 cases; cut-out: 1 of 5850 cases";
        assert_eq!(scope(&[following, cut_outs]), expected);
    }

    #[test]
    fn a_law_that_collides_alone_is_named_beside_a_green_verdict() {
        let document = following(1121, 0);
        assert!(document.is_ok());
        for text in [document.console(200), document.page(), document.markdown()] {
            for words in ["following: no collision", "beyond, alone", "alone 0 of 1"] {
                assert!(text.contains(words), "{words}: {text}");
            }
        }
    }

    #[test]
    fn a_law_that_collides_with_the_brake_stands_at_the_end_with_its_command() {
        let document = following(9, 2);
        assert!(!document.is_ok());
        let console = document.console(200);
        let last = console.lines().last().expect("it has lines");
        assert!(last.contains("following, acc-mpc + AEBS: 2 of 1121, 0.18 %"), "{last}");
        assert!(
            last.ends_with("timegap test r157 --matrix following --controllers acc-mpc --seed 1"),
            "{last}"
        );
    }
}
