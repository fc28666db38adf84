//! Each refusal shows its place and what was expected.

use temporal_logic::{Formula, Problem, Signal, Unit};

const SIGNALS: [Signal; 3] = [
    Signal { name: "gap_m", unit: Unit::METRE },
    Signal { name: "speed_mps", unit: Unit::METRE_PER_SECOND },
    Signal { name: "time_gap_s", unit: Unit::SECOND },
];

fn message(text: &str) -> String {
    Formula::parse(text, &SIGNALS).expect_err("refused").to_string()
}

#[test]
fn a_misspelt_signal_is_shown_with_a_similar_one() {
    let expected = "column 9: unknown signal \"gap\", expected one of gap_m, speed_mps, time_gap_s, did you mean gap_m?\n  \
                    | always (gap > 2)\n  |         ^^^";
    assert_eq!(message("always (gap > 2)"), expected);
}

#[test]
fn units_that_do_not_go_together_are_named() {
    assert!(
        message("gap_m > speed_mps").starts_with("column 7: m and m/s cannot be added or compared")
    );
    assert!(Formula::parse("gap_m > 1.5 * speed_mps", &SIGNALS).is_ok());
    assert!(Formula::parse("gap_m >= time_gap_s * speed_mps", &SIGNALS).is_ok());
}

#[test]
fn numbers_and_conditions_have_their_places() {
    assert!(message("always gap_m").contains("a number, expected a condition"));
    assert!(message("(gap_m > 2) + 1 > 0").contains("a condition, expected a number"));
    assert!(message("gap_m > 2 and").contains("the end, expected a signal"));
    assert!(message("gap_m > 2 3").contains("3, expected an operator or the end"));
    assert!(message("always[3,1] gap_m > 2").starts_with("column 7: a window from 3 s to 1 s"));
    assert!(message("always[-1,1] gap_m > 2").contains("expected a time in s, at least 0"));
    assert!(message("").contains("the end, expected"));
}

#[test]
fn deep_nesting_is_refused_and_not_followed() {
    let deep = "(".repeat(5000) + "gap_m > 2" + &")".repeat(5000);
    let error = Formula::parse(&deep, &SIGNALS).expect_err("too deep");
    assert!(matches!(error.problem, Problem::Depth { most: 64 }));
    assert!(Formula::parse(&("not ".repeat(1000) + "gap_m > 2"), &SIGNALS).is_err());
}

#[test]
fn a_window_beyond_the_run_is_refused() {
    let formula =
        Formula::parse("eventually[0,20] (gap_m > 2 and always[1,3] gap_m > 1)", &SIGNALS)
            .expect("reads");
    assert!(formula.check_duration(20.0).is_ok());
    let error = formula.check_duration(10.0).expect_err("too long").to_string();
    assert!(
        error.starts_with("column 1: the window ends after the run, which lasts 10 s"),
        "{error}"
    );
}

#[test]
fn margins_of_several_units_count_tolerances() {
    let formula = Formula::parse("gap_m > 2 and time_gap_s > 1", &SIGNALS).expect("reads");
    assert_eq!(formula.unit(), Unit::Mixed);
    let trace = temporal_logic::Trace { period_s: 0.01, samples: vec![&[3.0], &[0.0], &[1.5]] };
    // 1 m is two tolerances, 0.5 s five.
    assert_eq!(formula.margin(&trace).value, 2.0);
    assert_eq!(
        Formula::parse("gap_m > 2 or gap_m < 1", &SIGNALS).expect("reads").unit(),
        Unit::METRE
    );
    assert_eq!(formula.signals(), [0, 2]);
}
