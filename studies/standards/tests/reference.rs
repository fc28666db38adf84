//! The models against the outcomes that the Joint Research Centre published, and against the counts of
//! its own program.

use standards::r157::{Case, Matrix};
use standards::{Model, Outcome, cut_in};

const LOW: &str = include_str!("data/cut-in-low.txt");

/// The reference outcomes of the low cut-ins, in the order of the matrix.
fn reference() -> Vec<[Outcome; 4]> {
    LOW.lines()
        .flat_map(str::bytes)
        .map(|character| {
            let digits = character - b'!';
            [27, 9, 3, 1].map(|place| match digits / place % 3 {
                0 => Outcome::None,
                1 => Outcome::Side,
                _ => Outcome::RearEnd,
            })
        })
        .collect()
}

/// Cases of a matrix, or of one of its parts, that end in one of these ways with a model.
fn count(cases: &[Case], model: Model, ends: &[Outcome]) -> usize {
    let outcomes = cases.iter().filter_map(|case| case.drive(model));
    outcomes.filter(|verdict| ends.contains(&verdict.outcome)).count()
}

const COLLISION: &[Outcome] = &[Outcome::Side, Outcome::RearEnd];

fn assert_cut_ins(cases: &[Case], rear_ends: [usize; 4], regulation: usize, mastered: usize) {
    let counts = Model::ALL.map(|model| count(cases, model, &[Outcome::RearEnd]));
    assert_eq!(counts, rear_ends);
    assert_eq!(count(cases, Model::Regulation, COLLISION), regulation);
    let both = [Model::CarefulDriver, Model::Regulation];
    let masters = |case: &&Case| {
        both.iter().all(|model| case.drive(*model).is_some_and(|verdict| !verdict.is_collision()))
    };
    assert_eq!(cases.iter().filter(masters).count(), mastered);
}

#[test]
fn every_low_cut_in_ends_as_in_the_reference() {
    let reference = reference();
    let cases: Vec<_> = cut_in::low().collect();
    assert_eq!(cases.len(), reference.len());
    for (case, expected) in cases.iter().zip(&reference) {
        assert_eq!(Model::ALL.map(|model| case.drive(model).outcome), *expected, "{case:?}");
    }
}

#[test]
fn the_cut_ins_have_the_published_counts() {
    let cases: Vec<Case> = cut_in::low().map(Case::CutIn).collect();
    assert_eq!(cases.len(), 15_930);
    assert_cut_ins(&cases, [3001, 1606, 628, 672], 2252, 12_124);
    let cases: Vec<Case> = cut_in::high().map(Case::CutIn).collect();
    assert_eq!(cases.len(), 14_040);
    assert_cut_ins(&cases, [3146, 2487, 1219, 1437], 2869, 10_351);
}

#[test]
fn braking_leads_have_the_published_counts() {
    let cases = Matrix::Following.cases();
    assert_eq!(cases.len(), 1121);
    assert_eq!(count(&cases, Model::CarefulDriver, COLLISION), 0);
    assert_eq!(count(&cases, Model::Fuzzy, COLLISION), 0);
    assert_eq!(count(&cases, Model::Rss, COLLISION), 21);
}

#[test]
fn cut_outs_are_within_3_percent_of_the_published_counts() {
    let cases = Matrix::CutOut.cases();
    assert_eq!(cases.len(), 5850);
    for (model, published) in
        [(Model::CarefulDriver, 848.0), (Model::Fuzzy, 980.0), (Model::Rss, 936.0)]
    {
        let ours = count(&cases, model, COLLISION) as f64;
        assert!((ours / published - 1.0).abs() < 0.03, "{model:?}: {ours}, published {published}");
    }
}

#[test]
fn the_regulations_system_says_nothing_about_braking_leads() {
    for matrix in [Matrix::Following, Matrix::CutOut] {
        assert!(matrix.cases().iter().all(|case| case.drive(Model::Regulation).is_none()));
    }
}
