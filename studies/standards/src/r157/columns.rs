//! The columns of the results, and their document.

use super::judged::Judged;
use super::pictures;
use super::results::{Figures, LawResult, MatrixResult, Results};
use report::results::{
    Column, Document, Format, Kind, Schema, Table, column, count, fact, nested, number, word,
};
use serde::Serialize;
use std::collections::BTreeSet;

/// Fields of the JSON.
const FIELDS: &[Column<Results>] =
    &[frame::ok("Every law with the emergency brake is within the criteria")];

/// Figures over some cases, for programs.
const FIGURES: &[Column<()>] = &[
    count("cases", "", "Number of cases"),
    nested("models", Kind::Object, "Collisions with each model; null where it says nothing"),
    nested("models_rear_end", Kind::Object, "Rear-end collisions with each model"),
    count(
        "mastered_by_both",
        "",
        "Cases that both models of the regulation end without a collision",
    ),
    nested("laws", Kind::List, "Each law, with and without the emergency brake"),
];

/// A law over some cases, for programs.
const LAWS: &[Column<()>] = &[
    word("law", "", "Control law"),
    fact("aebs", "", "With the emergency brake"),
    count("collisions", "", "Collisions"),
    count("rear_end", "", "Rear-end collisions"),
    count("avoidable.careful-driver", "", "Collisions in cases that careful-driver masters"),
    count("avoidable.regulation", "", "Collisions in cases that the regulation's model masters"),
    count("avoidable.both", "", "Collisions in cases that both master"),
    count(
        "avoidable.both-within-a-step",
        "",
        "Those whose contact at constant speeds is nearer than a step of the models",
    ),
    nested(
        "from_its_gap",
        Kind::Object,
        "careful-driver from the law's gap; null without cut-outs",
    ),
    count("from_its_gap.collisions", "", "Its collisions"),
    count("from_its_gap.mastered", "", "Cases that it ends without one"),
    count("from_its_gap.avoidable", "", "Collisions of the law in these cases"),
    count("requirements_broken", "", "Cases with a broken requirement; null without one"),
    number("mean_impact_mps", "", "m/s", 2, "Mean speed difference at the contact"),
    number("model_impact_mps", "", "m/s", 2, "The model's over the same cases"),
];

/// A driver over some cases, for people.
#[derive(Serialize)]
struct Line {
    cases: String,
    driver: String,
    collisions: Option<u32>,
    rear_end: Option<u32>,
    avoidable: Option<u32>,
    avoidable_percent: Option<f64>,
    within_a_step: Option<u32>,
    from_its_gap: Option<u32>,
    avoidable_from: Option<u32>,
    avoidable_from_percent: Option<f64>,
    requirements_broken: Option<u32>,
    impact_mps: Option<f64>,
    model_impact_mps: Option<f64>,
    verdict: Option<&'static str>,
}

/// Columns of these lines.
const LINES: &[Column<Line>] = &[
    word("cases", "cases", "Matrix or part"),
    word("driver", "driver", "Model, or law with or without the emergency brake"),
    count("collisions", "collisions", "Collisions"),
    count("rear_end", "rear-end", "Rear-end collisions").weight(3),
    count("avoidable", "avoidable", "Collisions in cases that both models master"),
    number("avoidable_percent", "avoidable", "%", 2, "Their share of the cases that both master"),
    count("within_a_step", "within a step", "Those that the models may not see").weight(4),
    count("from_its_gap", "driver from its gap", "Collisions of careful-driver from the law's gap")
        .weight(2),
    count("avoidable_from", "avoidable from it", "Collisions in cases that it masters").weight(1),
    number("avoidable_from_percent", "avoidable from it", "%", 2, "Their share of those cases"),
    count("requirements_broken", "requirements broken", "Cases with a broken requirement"),
    number("impact_mps", "impact", "m/s", 1, "Mean speed difference at the contact").weight(3),
    number("model_impact_mps", "model's impact", "m/s", 1, "The model's over the same cases")
        .weight(4),
    column("verdict", "criterion", "", Format::Verdict(verdict_words), "Within the criterion"),
];

/// A law alone has no limit, so that only one with the brake can miss it.
fn verdict_words(name: &str) -> (&'static str, bool) {
    match name {
        "missed" => ("MISSED", false),
        "beyond" => ("beyond, alone", true),
        _ => ("within", true),
    }
}

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    let matrix = [
        word("matrix", "", "Name of the matrix"),
        nested("parts", Kind::Object, "The same figures of each part, by its name"),
    ];
    let matrices: Vec<_> = matrix.into_iter().chain(FIGURES.iter().cloned()).collect();
    Schema::new("r157", "UN R157's matrices")
        .fields(FIELDS)
        .rows("matrices", "The matrices", &matrices)
        .rows("matrices.laws", "Each law over all cases", LAWS)
        .map("matrices.parts", "The same figures of each part, by its name", FIGURES)
        .rows("matrices.parts.*.laws", "Each law over the cases of the part", LAWS)
}

/// The document of the results.
pub fn document(results: &Results, judged: &[Judged]) -> Document {
    let mut document = Document::new("r157", "UN R157", results).about(scope(judged));
    for matrix in &results.matrices {
        let mut lines = Vec::new();
        // Low before high, then both together.
        for (part, figures) in matrix.parts.iter().rev() {
            let name = format!("{}, {part}", matrix.matrix);
            document = document.text(criterion(&name, figures));
            add(&mut lines, &name, figures);
        }
        document = document.text(criterion(matrix.matrix, &matrix.all));
        add(&mut lines, matrix.matrix, &matrix.all);
        document = document.table(Table::new(matrix.matrix, LINES, &lines).blocks("cases"));
    }
    let pictures = judged.iter().flat_map(pictures::of);
    pictures
        .fold(document, |document, (heading, html)| document.figures(&heading, html))
        .verdict(results.ok, verdict(results))
}

/// The criterion of some cases; empty without one.
fn criterion(name: &str, figures: &Figures) -> String {
    figures.criterion().map_or_else(String::new, |words| format!("{name}: {words}"))
}

fn add(lines: &mut Vec<Line>, name: &str, figures: &Figures) {
    let Figures { cases, mastered_by_both, .. } = *figures;
    let cases = format!("{name}: {cases} cases, {mastered_by_both} mastered by both models");
    for (model, collisions) in &figures.models {
        let rear_end = figures.models_rear_end[model];
        let (cases, driver) = (cases.clone(), (*model).to_owned());
        lines.push(Line { collisions: *collisions, rear_end, ..Line::of(cases, driver) });
    }
    let percent =
        |count: u32, all: u32| (all > 0).then(|| 100.0 * f64::from(count) / f64::from(all));
    for law in &figures.laws {
        let from = law.from_its_gap.as_ref();
        let verdict = match (figures.is_within(law), law.aebs) {
            (true, _) => "within",
            (false, true) => "missed",
            (false, false) => "beyond",
        };
        lines.push(Line {
            collisions: Some(law.collisions),
            rear_end: Some(law.rear_end),
            avoidable: Some(law.avoidable.both),
            avoidable_percent: percent(law.avoidable.both, mastered_by_both),
            within_a_step: law.avoidable.both_within_a_step,
            from_its_gap: from.map(|model| model.collisions),
            avoidable_from: from.map(|model| model.avoidable),
            avoidable_from_percent: from.and_then(|model| percent(model.avoidable, model.mastered)),
            requirements_broken: law.requirements_broken,
            impact_mps: law.mean_impact_mps,
            model_impact_mps: law.model_impact_mps,
            verdict: (!figures.limits.is_empty()).then_some(verdict),
            ..Line::of(cases.clone(), law.driver())
        });
    }
}

impl Line {
    fn of(cases: String, driver: String) -> Self {
        Self {
            cases,
            driver,
            collisions: None,
            rear_end: None,
            avoidable: None,
            avoidable_percent: None,
            within_a_step: None,
            from_its_gap: None,
            avoidable_from: None,
            avoidable_from_percent: None,
            requirements_broken: None,
            impact_mps: None,
            model_impact_mps: None,
            verdict: None,
        }
    }
}

/// The verdict with and without the emergency brake.
fn verdict(results: &Results) -> String {
    let of = |aebs: bool| {
        let name = |law: &LawResult| (law.aebs == aebs).then(|| law.law.clone());
        let all = results.matrices.iter().flat_map(|matrix| &matrix.all.laws).filter_map(name);
        let beyond = results.matrices.iter().flat_map(|matrix| {
            let figures = matrix.parts.values().chain([&matrix.all]);
            figures.flat_map(|figures| {
                figures.laws.iter().filter(|law| !figures.is_within(law)).filter_map(name)
            })
        });
        let all: BTreeSet<String> = all.collect();
        let beyond: BTreeSet<String> = beyond.collect();
        (all.len() - beyond.len(), all.len())
    };
    let ((with, braked), (alone, all)) = (of(true), of(false));
    let broken: u32 = results.matrices.iter().map(MatrixResult::requirements_broken).sum();
    let broken = match broken {
        0 => String::new(),
        _ => format!("; requirements BROKEN in {broken} drives"),
    };
    match all {
        0 => "the models alone".to_owned(),
        _ => format!(
            "with the emergency brake {with} of {braked} laws are within the criteria, alone {alone} of {all}{broken}"
        ),
    }
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

#[cfg(test)]
mod tests {
    use super::super::matrix::Matrix;
    use super::*;

    #[test]
    fn the_heading_says_which_matrices_were_driven_and_how_much_of_each() {
        let mut following = Judged::new(Matrix::Following, Matrix::Following.cases());
        assert_eq!(scope(std::slice::from_ref(&following)), "following");
        let all = following.cases.len();
        following.cases.truncate(2);
        assert_eq!(scope(&[following]), format!("following: a sample, 2 of {all} cases"));
    }

    #[test]
    fn a_law_that_collides_alone_is_named_beside_a_green_verdict() {
        use super::super::drive::Driver;
        use super::super::judged::Driven;
        use crate::{Outcome, Verdict};
        let mut judged = Judged::new(Matrix::Following, Matrix::Following.cases());
        let hit = Verdict { outcome: Outcome::RearEnd, impact_speed_mps: 4.0 };
        for (aebs, verdict) in [(false, hit), (true, Verdict::NONE)] {
            let driver = Driver { law: "acc-mpc".into(), aebs };
            let verdicts = vec![verdict; judged.cases.len()];
            judged.laws.push(Driven { driver, verdicts, from_its_gap: None, broken: None });
        }
        let matrices = vec![judged.result()];
        let ok = matrices.iter().all(super::super::results::MatrixResult::holds);
        let results = Results { schema_version: 1, ok, matrices };
        let document = document(&results, &[judged]);
        assert!(document.is_ok());
        for text in [document.console(200), document.page(), document.markdown()] {
            for words in ["no collision. With the emergency brake every law", "alone 0 of 1"] {
                assert!(text.contains(words), "{words}: {text}");
            }
        }
        assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
    }
}
