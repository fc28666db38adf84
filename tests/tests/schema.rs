//! The JSON of every study against the schema that `timegap print schema results` prints. Each declared key is
//! there, unless it is optional, and no other one.

use std::collections::BTreeSet;

use serde_json::Value;
use system_tests::schema::check;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Defines a test for each study: its name in the schema, and the words of a small command. The slow run of
/// `bench.rs` serves for the schema of `bench` too, and `graph.rs` has the schema of graphs.
macro_rules! studies {
    ($($name:ident: $words:literal;)*) => {
        const STUDIES: &[&str] = &["bench", "graph", $(stringify!($name)),*];

        $(
            #[test]
            fn $name() {
                has_its_schema(stringify!($name), $words);
            }
        )*
    };
}

studies! {
    compare: "compare following cut-in --controllers acc-mpc,six-mode --set duration_s=5";
    sweep: "sweep cut-in --duration 5 --vary runtime.extra_delay_ms=0,100 --seeds 1..2";
    search: "search tight-brake --vary actors.0.gap_m=24..34 --budget 8 --cases 1";
    string: "string following --vehicles 2 --frequencies 0.05,0.1 --vary controller.time_headway_s=1,2";
    r157: "test r157 --controllers acc-mpc --sample 1";
    iso15622: "test iso15622 --controllers acc-mpc";
    reproduce: "papers six-mode";
    signals: "test signals --seeds 1";
    curves: "test curves --seeds 1";
    everyday: "test everyday --seeds 1 --only acc-mpc --only cut-in";
    plausibility: "test plausibility --seeds 1 --shard 1/40 --out part";
    campaign: "campaign messages --sample 4";
}

fn has_its_schema(name: &str, words: &str) {
    let corner = Corner::new(PROGRAM);
    let arguments: Vec<&str> = words.split(' ').chain(["--json"]).collect();
    let output = corner.run(&arguments);
    // A study may find that a requirement is broken.
    assert!(matches!(output.status.code(), Some(0 | 1)), "{words}: {}", text(&output));
    let result: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(check(&corner.schemas()[name], &result), [""; 0], "{words}");
    corner.expect_nothing_left(&[]);
}

#[test]
fn every_schema_is_held_against_a_result() {
    let defined = Corner::new(PROGRAM).schemas();
    let defined: BTreeSet<&str> =
        defined.as_object().expect("definitions").keys().map(String::as_str).collect();
    assert_eq!(defined, STUDIES.iter().copied().collect());
}

/// The check's finding: a renamed key is a missing and an undeclared one.
#[test]
fn a_renamed_key_is_found_in_both_directions() {
    let corner = Corner::new(PROGRAM);
    let mut schema = corner.schemas()["sweep"].clone();
    let points = &mut schema["properties"]["points"]["items"];
    let seeds = points["properties"].as_object_mut().expect("keys").remove("seeds");
    points["properties"]["count"] = seeds.expect("it is declared");
    let required = points["required"].as_array_mut().expect("a list");
    required.iter_mut().filter(|key| **key == "seeds").for_each(|key| *key = "count".into());
    let words = ["sweep", "cut-in", "--duration", "1", "--vary", "runtime.extra_delay_ms=0"];
    let result = corner.json(&words);
    let wrong = check(&schema, &result);
    assert_eq!(wrong, ["points.0.count: missing", "points.0.seeds: not declared"]);
}
