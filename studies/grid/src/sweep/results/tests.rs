//! Tests of the result of a sweep.

use super::*;
use crate::row::tests::row;
use crate::sweep::page;
use report::figures::{DEADLINE_MISSES, MIN_GAP_M, RMS_GAP_ERROR_M, Values};

fn run(value: &str, seed: u64, outcome: Outcome, gap_m: Option<f64>) -> Row {
    let figures = Values::default().with(&RMS_GAP_ERROR_M, 2.0);
    let figures = gap_m.map_or(figures, |gap_m| figures.with(&MIN_GAP_M, gap_m));
    let aborted_because = (outcome == Outcome::Aborted).then(|| "the law ended".to_owned());
    Row {
        values: vec![value.into()],
        outcome,
        figures,
        aborted_because,
        ..row("acc-mpc", seed, 1.0)
    }
}

fn sweep_of(params: &str, runs: Vec<Row>) -> Sweep {
    Sweep::new("x", vec!["acc-mpc".into()], Mode::Lockstep, vec![params.to_owned()], runs)
}

fn sweep() -> Sweep {
    let runs = vec![
        run("0", 1, Outcome::Completed, Some(9.0)),
        run("0", 2, Outcome::Completed, Some(7.0)),
        run("20", 1, Outcome::Completed, None),
        run("20", 2, Outcome::Collision, Some(-0.1)),
    ];
    sweep_of("runtime.extra_delay_ms", runs)
}

#[test]
fn seeds_are_folded_into_their_point() {
    let sweep = sweep();
    let json = serde_json::to_value(&sweep).expect("plain data");
    assert_eq!(json["points"][0]["figures"]["min_gap_m"], 7.0);
    assert_eq!(json["points"][1]["figures"]["min_gap_m"], -0.1);
    assert_eq!(json["points"][1]["completed"], 1);
    assert_eq!(json["runs"].as_array().map(Vec::len), Some(4));
    assert!(json["runs"][2]["figures"]["min_gap_m"].is_null());
}

#[test]
fn a_point_has_the_least_margin_of_its_seeds() {
    let mut sweep = sweep();
    for (run, margin) in sweep.runs.iter_mut().zip([3.0, 1.0, 2.0, -0.5]) {
        run.requirements = vec![RequirementVerdict {
            requirement: "min-gap:5".into(),
            formula: "always gap_m >= 5".into(),
            margin: Some(margin),
            unit: "m".into(),
            at_s: 4.0,
            met: margin >= 0.0,
        }];
    }
    let sweep = sweep_of("runtime.extra_delay_ms", sweep.runs);
    let table = sweep.table().console(300);
    assert!(table.contains("min-gap:5: met, margin 1.00 m at 4.00 s"), "{table}");
    assert!(table.contains("BROKEN, margin -0.50 m") || table.contains("−0.50 m"), "{table}");
    let json = serde_json::to_value(&sweep).expect("plain data");
    assert_eq!(json["points"][1]["requirements"][0]["margin"], -0.5);
}

#[test]
fn the_table_leaves_empty_columns_out_and_names_what_went_wrong() {
    let table = sweep().table().console(80);
    assert!(table.contains("min gap, m") && !table.contains("L/100 km"), "{table}");
    assert!(table.contains("1 completed, 1 COLLISION") && table.contains("2.00 ± 0.00"), "{table}");
    let json = serde_json::to_value(sweep()).expect("plain data");
    assert_eq!(json["points"][0]["spread"]["min_gap_m"]["deviation"], 2.0_f64.sqrt());
    assert_eq!(json["points"][1]["spread"]["min_gap_m"]["n"], 1);
}

#[test]
fn the_text_reports_once_why_runs_were_aborted() {
    let mut sweep = sweep();
    sweep.runs.extend([1, 2].map(|seed| run("20", seed, Outcome::Aborted, None)));
    let text = page::document(&sweep).console(80);
    assert!(text.contains("2 aborted: the law ended\n"), "{text}");
}

#[test]
fn every_output_is_of_the_same_declaration() {
    let sweep = sweep();
    let document = page::document(&sweep);
    let page = document.page();
    assert!(page.contains("acc-mpc"), "{page}");
    let (head, _) = page.split_once("<h2>Points</h2>").expect("a table of points");
    assert!(!head.contains("rms_gap_error_m") && !head.contains("min_gap_m"), "{head}");
    assert!(document.console(80).starts_with("x (acc-mpc, lockstep): 2 points, 2 seeds each"));
}

#[test]
fn a_count_has_an_axis_from_zero() {
    let mut sweep = sweep();
    for point in &mut sweep.points {
        point.figures.insert(DEADLINE_MISSES.name.to_owned(), json!(0.0));
    }
    let plots = page::plots(&sweep);
    let plot = plots.iter().find(|plot| plot.title == "deadlines missed").expect("drawn");
    assert_eq!(plot.y.share(0.0), 0.0, "{:?}", plot.y);
}

#[test]
fn the_pictures_are_over_the_first_key_that_is_a_number() {
    let sweep = sweep();
    let plots = page::plots(&sweep);
    assert!(plots.iter().any(|plot| plot.title == "smallest gap" && plot.y.label == "m"));
    assert!(plots.iter().all(|plot| plot.x.label == "extra delay, ms (runtime.extra_delay_ms)"));
    let runs = vec![run("a", 1, Outcome::Completed, None), run("b", 1, Outcome::Completed, None)];
    assert!(page::plots(&sweep_of("controller.name", runs)).is_empty());
}
