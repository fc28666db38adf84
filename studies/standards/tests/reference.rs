//! The models against the outcomes that the Joint Research Centre published, and against the counts of
//! its own program.

use standards::{Model, Outcome, PerModel, Tally, Verdict, cut_in, cut_out, following};

const LOW: &str = include_str!("data/cut-in-low.txt");

/// The reference outcomes of the low cut-ins, in the order of the matrix.
fn reference() -> Vec<PerModel<Outcome>> {
    LOW.lines()
        .flat_map(str::bytes)
        .map(|character| {
            let mut digits = character - b'!';
            let mut outcomes = [27, 9, 3, 1].map(|place| {
                let digit = digits / place;
                digits %= place;
                Outcome::from_digit(digit).expect("a digit to the base 3")
            });
            outcomes.reverse();
            let mut outcomes = outcomes.to_vec();
            PerModel::new(|_| outcomes.pop().expect("one for each model"))
        })
        .collect()
}

fn tally(verdicts: impl Iterator<Item = PerModel<Option<Verdict>>>) -> Tally {
    let mut tally = Tally::default();
    for verdicts in verdicts {
        tally.count(&verdicts);
    }
    tally
}

fn tally_cut_ins(cases: impl Iterator<Item = cut_in::Case>) -> Tally {
    tally(cases.map(|case| PerModel::new(|model| Some(case.drive(model)))))
}

#[test]
fn every_low_cut_in_ends_as_in_the_reference() {
    let reference = reference();
    let cases: Vec<_> = cut_in::low().collect();
    assert_eq!(cases.len(), reference.len());
    for (case, expected) in cases.iter().zip(&reference) {
        assert_eq!(case.outcomes(), *expected, "{case:?}");
    }
}

#[test]
fn the_low_cut_ins_have_the_published_counts() {
    let tally = tally_cut_ins(cut_in::low());
    assert_eq!(tally.cases, 15_930);
    assert_eq!(tally.rear_ends[Model::CarefulDriver], 3001);
    assert_eq!(tally.rear_ends[Model::Regulation], 1606);
    assert_eq!(tally.rear_ends[Model::Fuzzy], 672);
    assert_eq!(tally.rear_ends[Model::Rss], 628);
    assert_eq!(tally.collisions[Model::Regulation], 2252);
    assert_eq!(tally.mastered_by_both, 12_124);
}

#[test]
fn the_high_cut_ins_have_the_published_counts() {
    let tally = tally_cut_ins(cut_in::high());
    assert_eq!(tally.cases, 14_040);
    assert_eq!(tally.rear_ends[Model::CarefulDriver], 3146);
    assert_eq!(tally.rear_ends[Model::Regulation], 2487);
    assert_eq!(tally.rear_ends[Model::Fuzzy], 1437);
    assert_eq!(tally.rear_ends[Model::Rss], 1219);
    assert_eq!(tally.collisions[Model::Regulation], 2869);
    assert_eq!(tally.mastered_by_both, 10_351);
}

#[test]
fn braking_leads_have_the_published_counts() {
    let tally = tally(following::matrix().map(|case| PerModel::new(|model| case.drive(model))));
    assert_eq!(tally.cases, 1121);
    assert_eq!(tally.collisions[Model::CarefulDriver], 0);
    assert_eq!(tally.collisions[Model::Fuzzy], 0);
    assert_eq!(tally.collisions[Model::Rss], 21);
}

#[test]
fn cut_outs_are_within_3_percent_of_the_published_counts() {
    let tally = tally(cut_out::matrix().map(|case| PerModel::new(|model| case.drive(model))));
    assert_eq!(tally.cases, 5850);
    for (model, published) in
        [(Model::CarefulDriver, 848.0), (Model::Fuzzy, 980.0), (Model::Rss, 936.0)]
    {
        let ours = f64::from(tally.collisions[model]);
        assert!((ours / published - 1.0).abs() < 0.03, "{model}: {ours}, published {published}");
    }
}

#[test]
fn the_regulations_system_says_nothing_about_braking_leads() {
    assert!(following::matrix().all(|case| case.drive(Model::Regulation).is_none()));
    assert!(cut_out::matrix().all(|case| case.drive(Model::Regulation).is_none()));
}
