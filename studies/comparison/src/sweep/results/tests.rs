//! Tests of the result of a sweep.

use super::*;
use crate::sweep::page;

fn run(value: &str, seed: u64, outcome: Outcome, gap_m: Option<f64>) -> Run {
    let mut figures = Figures::default();
    figures.0[0] = Some(2.0);
    figures.0[4] = gap_m;
    let aborted_because = (outcome == Outcome::Aborted).then(|| "the law ended".to_owned());
    let requirements = Vec::new();
    Run { values: vec![value.into()], seed, outcome, aborted_because, requirements, figures }
}

fn sweep() -> (Sweep, Vec<Param>) {
    let params = vec![Param::parse("runtime.extra_delay_ms=0..20/20").expect("good")];
    let runs = vec![
        run("0", 1, Outcome::Completed, Some(9.0)),
        run("0", 2, Outcome::Completed, Some(7.0)),
        run("20", 1, Outcome::Completed, None),
        run("20", 2, Outcome::Collision, Some(-0.1)),
    ];
    (Sweep::new("x", vec!["acc-mpc".into()], Mode::Lockstep, &params, runs), params)
}

#[test]
fn seeds_are_folded_into_their_point() {
    let (sweep, _) = sweep();
    let json = serde_json::to_value(&sweep).expect("plain data");
    assert_eq!(json["points"][0]["figures"]["min_gap_m"], 7.0);
    assert_eq!(json["points"][1]["figures"]["min_gap_m"], -0.1);
    assert_eq!(json["points"][1]["completed"], 1);
    assert_eq!(json["runs"].as_array().map(Vec::len), Some(4));
    assert!(json["runs"][2]["figures"]["min_gap_m"].is_null());
}

#[test]
fn the_csv_has_a_row_per_run_and_empty_fields_where_nothing_applies() {
    let (sweep, _) = sweep();
    let csv = sweep.csv();
    let lines: Vec<_> = csv.lines().collect();
    assert!(lines[0].starts_with("runtime.extra_delay_ms,seed,outcome,rms_gap_error_m,"));
    assert_eq!(lines[3], "20,1,completed,2,,,,,,,,,,,,,,,,,,,");
    assert!(lines[4].starts_with("20,2,collision,2,,,,-0.1,"));
}

#[test]
fn a_point_has_the_least_margin_of_its_seeds() {
    let (mut sweep, params) = sweep();
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
    let (laws, runs) = (sweep.controllers, sweep.runs);
    let sweep = Sweep::new("x", laws, Mode::Lockstep, &params, runs);
    let table = sweep.table().console(300);
    assert!(table.contains("min-gap:5: met, margin 1.00 m at 4.00 s"), "{table}");
    assert!(table.contains("BROKEN, margin -0.50 m") || table.contains("−0.50 m"), "{table}");
    let csv = sweep.csv();
    assert!(csv.lines().nth(1).is_some_and(|line| line.contains("margin 3.00 m")), "{csv}");
    assert!(csv.lines().next().is_some_and(|line| line.ends_with(",margins")), "{csv}");
    let json = serde_json::to_value(&sweep).expect("plain data");
    assert_eq!(json["points"][1]["requirements"][0]["margin"], -0.5);
}

#[test]
fn the_table_leaves_empty_columns_out_and_names_what_went_wrong() {
    let table = sweep().0.table().console(80);
    assert!(table.contains("min gap, m") && !table.contains("L/100 km"), "{table}");
    assert!(table.contains("1 completed, 1 COLLISION") && table.contains("2.00 ± 0.00"), "{table}");
    let json = serde_json::to_value(sweep().0).expect("plain data");
    assert_eq!(json["points"][0]["spread"]["min_gap_m"]["deviation"], 2.0_f64.sqrt());
    assert_eq!(json["points"][1]["spread"]["min_gap_m"]["n"], 1);
}

#[test]
fn the_text_reports_once_why_runs_were_aborted() {
    let (mut sweep, _) = sweep();
    sweep.runs.extend([1, 2].map(|seed| run("20", seed, Outcome::Aborted, None)));
    let text = page::document(&sweep).console(80);
    assert!(text.contains("2 aborted: the law ended\n"), "{text}");
}

#[test]
fn every_output_is_of_the_same_declaration() {
    let (sweep, _) = sweep();
    let document = page::document(&sweep);
    let page = document.page();
    assert!(page.contains("acc-mpc"), "{page}");
    let (head, _) = page.split_once("<h2>Points</h2>").expect("a table of points");
    assert!(!head.contains("rms_gap_error_m") && !head.contains("min_gap_m"), "{head}");
    assert!(document.console(80).starts_with("x (acc-mpc, lockstep): 2 points, 2 seeds each"));
    assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
}

#[test]
fn a_count_has_an_axis_from_zero() {
    let (mut sweep, _) = sweep();
    let missed = ALL.iter().position(|figure| figure.name() == "deadline_misses");
    for point in &mut sweep.points {
        point.figures.0[missed.expect("a figure")] = Some(0.0);
    }
    let plots = page::plots(&sweep);
    let plot = plots.iter().find(|plot| plot.title == "deadlines missed").expect("drawn");
    assert_eq!(plot.y.share(0.0), 0.0, "{:?}", plot.y);
}

#[test]
fn the_pictures_are_over_the_first_key_that_is_a_number() {
    let (sweep, _) = sweep();
    let plots = page::plots(&sweep);
    assert!(plots.iter().any(|plot| plot.title == "smallest gap" && plot.y.label == "m"));
    assert!(plots.iter().all(|plot| plot.x.label == "extra delay, ms (runtime.extra_delay_ms)"));
    let params = [Param::parse("controller.name=a,b").expect("good")];
    let runs = vec![run("a", 1, Outcome::Completed, None), run("b", 1, Outcome::Completed, None)];
    assert!(page::plots(&Sweep::new("x", Vec::new(), Mode::Lockstep, &params, runs)).is_empty());
}
