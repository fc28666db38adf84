//! The design file: what is shipped passes, whatever is changed or hostile is refused.

use super::plant::ask;
use law::{Ego, Law, Quality, Target};
use laws::quadratic_bounded::{
    Condition, Design, DesignError, QUADRATIC_BOUNDED, QuadraticBounded, Settings,
};
use serde_json::{Value, json};

const SHIPPED: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/quadratic-bounded.json"));
const FIRM: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/quadratic-bounded-firm.json"));

/// The shipped file with something changed.
fn changed(change: impl FnOnce(&mut Value)) -> Result<Design, DesignError> {
    let mut value: Value = serde_json::from_str(SHIPPED).expect("it is JSON");
    change(&mut value);
    Design::load(&value.to_string())
}

#[track_caller]
fn condition(result: Result<Design, DesignError>) -> (Condition, Option<usize>) {
    match result {
        Err(DesignError::Condition(failure)) => (failure.condition, failure.rule),
        other => panic!("expected a failed condition, got {other:?}"),
    }
}

#[test]
fn shipped_designs_are_certified() {
    for text in [SHIPPED, FIRM] {
        Design::load(text).expect("its certificate holds");
    }
}

/// Paths of all numbers of one gain group.
fn entries(rule: usize, group: &str) -> Vec<String> {
    let value: Value = serde_json::from_str(SHIPPED).expect("it is JSON");
    let base = format!("/design/rules/{rule}/{group}");
    let list = value.pointer(&base).and_then(Value::as_array).expect("the group is a list");
    let mut paths = Vec::new();
    for (i, row) in list.iter().enumerate() {
        match row.as_array() {
            Some(row) => paths.extend((0..row.len()).map(|j| format!("{base}/{i}/{j}"))),
            None => paths.push(format!("{base}/{i}")),
        }
    }
    paths
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).expect("a number")
}

#[test]
fn a_tampered_gain_fails_its_certificate_and_names_the_rule() {
    let original: Value = serde_json::from_str(SHIPPED).expect("it is JSON");
    for rule in 0..2 {
        for (group, share) in [("ac", 0.5), ("l", 0.5), ("fx", 0.5), ("fy", 0.2)] {
            let largest = entries(rule, group)
                .into_iter()
                .max_by(|a, b| number(&original, a).abs().total_cmp(&number(&original, b).abs()))
                .expect("not empty");
            for factor in [1.0 + share, 1.0 - share, -1.0] {
                let result = changed(|v| {
                    let entry = v.pointer_mut(&largest).expect("it is there");
                    *entry = json!(number(&original, &largest) * factor);
                });
                let (failed, in_rule) = condition(result);
                assert!(
                    matches!(failed, Condition::Invariance | Condition::Increment),
                    "{largest} times {factor}: {failed:?}"
                );
                assert_eq!(in_rule, Some(rule + 1), "{largest} times {factor}");
            }
        }
    }
}

#[test]
fn each_condition_is_checked() {
    let set = |path: &'static str, value: Value| {
        condition(changed(|v| *v.pointer_mut(path).expect("it is there") = value))
    };
    let parameters = "/design/parameters";
    assert_eq!(set("/design/alpha", json!(0.5)).0, Condition::Invariance);
    assert_eq!(set("/design/alpha", json!(0.02)), (Condition::Multipliers, None));
    assert_eq!(set("/design/multipliers/1", json!(-1e-9)), (Condition::Multipliers, None));
    assert_eq!(set("/design/multipliers/1", json!(0.0)), (Condition::Multipliers, None));
    assert_eq!(set("/design/p/0/0", json!(-1.0)), (Condition::PositiveDefinite, None));
    assert_eq!(set("/design/p/0/1", json!(1.0)), (Condition::Symmetric, None));
    for (key, value, expected) in [
        ("lead_acceleration_mps2", 3.0, (Condition::Invariance, Some(1))),
        ("gap_noise_m", 2.0, (Condition::Invariance, Some(1))),
        ("actuator_lag_s", 1.0, (Condition::Invariance, Some(1))),
        ("greatest_speed_mps", 60.0, (Condition::Invariance, Some(2))),
        ("gap_error_bound_m", 15.0, (Condition::GapError, None)),
        ("speed_error_bound_mps", 5.0, (Condition::SpeedError, None)),
        ("acceleration_bound_mps2", 2.0, (Condition::Acceleration, None)),
        ("request_bound_mps2", 2.0, (Condition::Request, None)),
        ("increment_bound_mps2", 0.3, (Condition::Increment, Some(1))),
        ("gap_error_rate_bound_mps", 3.0, (Condition::GapErrorRate, Some(1))),
    ] {
        let path = format!("{parameters}/{key}");
        let result = changed(|v| *v.pointer_mut(&path).expect("it is there") = json!(value));
        assert_eq!(condition(result), expected, "{key}");
    }
    let start = "/design/parameters/start_set/0/0";
    assert_eq!(set(start, json!(35.0)), (Condition::StartSet, None));
}

#[test]
fn hostile_files_are_refused_with_a_reason() {
    let deep = "[".repeat(50_000);
    let huge = " ".repeat(10_000_000);
    let wrong_shape = changed(|v| {
        v.pointer_mut("/design/p/3").and_then(Value::as_array_mut).expect("a row").pop();
    });
    let texts = [
        "",
        "{",
        "null",
        "[]",
        "{\"format\":1}",
        &deep,
        "\u{0}",
        SHIPPED.trim_end_matches(['}', '\n']),
    ];
    for text in texts {
        assert!(matches!(Design::load(text), Err(DesignError::Syntax(_))), "{:.40}", text);
    }
    assert!(matches!(wrong_shape, Err(DesignError::Syntax(_))));
    assert_eq!(Design::load(&huge), Err(DesignError::TooLarge { bytes: huge.len() }));
    for number in ["NaN", "1e999", "-1e999", "null", "\"0.1\"", "[]"] {
        let text = SHIPPED.replacen("0.45", number, 1);
        assert_ne!(text, SHIPPED);
        assert!(matches!(Design::load(&text), Err(DesignError::Syntax(_))), "{number}");
    }
    let far = changed(|v| v["design"]["rules"][0]["ac"][0][0] = json!(1e300));
    assert_eq!(condition(far), (Condition::Invariance, Some(1)));
    let far = changed(|v| v["design"]["parameters"]["sample_time_s"] = json!(1e300));
    assert!(matches!(far, Err(DesignError::Parameter(e)) if e.path == "sample_time_s"));
    let many = changed(|v| v["design"]["parameters"]["start_set"] = json!(vec![[0.0; 4]; 17]));
    assert!(matches!(many, Err(DesignError::Parameter(e)) if e.path == "start_set (count)"));
    let unknown = changed(|v| v["design"]["gain"] = json!(1.0));
    assert!(matches!(unknown, Err(DesignError::Syntax(_))));
    let version = changed(|v| v["format"] = json!("timegap quadratic-bounded design 2"));
    assert!(matches!(version, Err(DesignError::Format(_))));
    let more = changed(|v| v["digest"] = json!("0"));
    assert!(matches!(more, Err(DesignError::Syntax(_))));
}

#[test]
fn errors_say_what_and_where() {
    let text = changed(|v| v["design"]["rules"][1]["fy"][1] = json!(0.2)).expect_err("tampered");
    let text = text.to_string();
    assert!(text.contains("quadratic boundedness") && text.contains("rule 2"), "{text}");
    let text = Design::load("{\n  \"format\": 3\n}").expect_err("not a design").to_string();
    assert!(text.contains("line 2"), "{text}");
}

/// The increments come every Ts, whatever the control period.
#[test]
fn other_control_periods_hold_the_request() {
    let requests = |period: f64, releases: u32| -> Vec<(f64, Quality)> {
        let mut law = QuadraticBounded::new(Design::shipped(), Settings::default()).expect("valid");
        let ego = Ego { speed_mps: 25.0, ..Ego::default() };
        let target =
            Target { track_id: 1, gap_m: 70.0, relative_speed_mps: -3.0, ..Target::default() };
        (0..releases)
            .map(|k| {
                let time = f64::from(k) * period;
                let out = ask(&mut law, (time, period), ego, Some(target), 30.0);
                (out.request_mps2(), out.quality)
            })
            .collect()
    };
    let own = requests(0.1, 5);
    assert!(own.windows(2).all(|w| w[0].0 != w[1].0));
    // Half the period: each value twice.
    let half = requests(0.05, 10);
    for (k, (request, quality)) in half.iter().enumerate() {
        assert_eq!((*request, *quality), own[k / 2]);
    }
    // 0.04 s does not divide 0.1 s: updates at 0, 0.12, 0.2, 0.32, 0.4 s.
    let odd: Vec<f64> = requests(0.04, 11).iter().map(|r| r.0).collect();
    let updates: Vec<usize> = (1..odd.len()).filter(|k| odd[*k] != odd[k - 1]).collect();
    assert_eq!(updates, [3, 5, 8, 10]);
    // Longer than Ts: one update each, and not what was certified.
    let long = requests(0.2, 5);
    for (k, (request, quality)) in long.iter().enumerate() {
        assert_eq!((*request, *quality), (own[k].0, Quality::Relaxed));
    }
}

#[test]
fn the_smaller_increment_wins_and_names_its_reason() {
    let mut law = QuadraticBounded::new(Design::shipped(), Settings::default()).expect("valid");
    let ego = Ego { speed_mps: 25.0, ..Ego::default() };
    let near = Target { track_id: 1, gap_m: 60.0, relative_speed_mps: -3.0, ..Target::default() };
    let cases = [
        (None, 30.0, "cruise", "no target in range"),
        (Some(near), 30.0, "follow", "lead demands less"),
        (Some(near), 10.0, "cruise", "set speed demands less"),
        (Some(Target { gap_m: 150.1, ..near }), 30.0, "cruise", "no target in range"),
    ];
    let formulation = QUADRATIC_BOUNDED.formulations[0];
    for (target, set_speed, mode, reason) in cases {
        law.reset();
        let out = ask(&mut law, (0.0, 0.1), ego, target, set_speed);
        assert_eq!(formulation.modes[out.mode as usize], mode);
        assert_eq!(formulation.reasons[out.mode_reason as usize], reason);
        let (cruise, follow) = (out.figures[6], out.figures[7]);
        let smaller = if mode == "follow" { follow } else { cruise };
        let bound = law.design().parameters().increment_bound_mps2;
        assert_eq!(out.figures[5], smaller.clamp(-bound, bound));
    }
}
