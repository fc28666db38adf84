//! Refusals, with their place and the expected value.

use super::*;

#[test]
fn a_wrong_value_is_shown_with_line_caret_and_expectation() {
    assert_eq!(
        refusal("[perception]\nperiod_ms = -50 # too fast\n"),
        "error: x.toml:4:13: -50 is out of range\n  \
           |\n\
         4 | period_ms = -50 # too fast\n  \
           |             ^^^ expected a period from 1 to 10000 ms, a whole number"
    );
}

#[test]
fn refusals_of_single_values() {
    let cases = [
        ("[plant]\npowertrain = { mass_kg = 0, max_power_kw = 90 }", "4:26: 0 is out of range"),
        ("[plant]\ninitial_speed_mps = nan", "4:21: NaN is out of range"),
        ("[plant]\ninitial_speed_mps = -inf", "4:21: -inf is out of range"),
        ("duration_s = 1e300", "3:14: 1"),
        ("duration_s = 0", "3:14: 0 is out of range"),
        ("seed = -1", "3:8: -1 is out of range"),
        ("seed = 99999999999999999999", "3:8: invalid value: integer `99999999999999999999`"),
        ("seed = 1.5", "3:8: invalid type: floating point `1.5`"),
        ("set_speed_mps = \"fast\"", "3:17: invalid type: string \"fast\""),
        ("[plant]\nperiod_ms = 99999999999", "4:13: 99999999999 is out of range"),
        ("[perception.radar]\ndropout_probability = 1.1", "4:23: 1.1 is out of range"),
        ("[perception.radar]\nrange_sigma_m = -0.1", "4:17: -0.1 is out of range"),
        ("[perception.radar]\nfield_of_view_deg = 0", "4:21: 0 is out of range"),
        ("[perception.radar.detections]\ncar_rcs_dbsm = 61", "4:16: 61 is out of range"),
        ("[perception.radar.detections]\nazimuth_floor_deg = 101", "4:21: 101 is out of range"),
        (
            "[perception.radar.detections]\nfalse_alarms_per_scan = 2001",
            "4:25: 2001 is out of range",
        ),
        ("[perception.radar.detections]\nswerling = 2", "4:12: 2 is out of range"),
        ("[controller]\nname = \"cac mpc\"", "4:8: not a name"),
        ("[controller]\nweights = { q1 = -1 }", "4:18: -1 is out of range"),
        (
            "[[actors]]\nname = \"a\"\ngap_m = 1\nprofile.sine = { period_s = 3 }",
            "6:16: missing key",
        ),
        ("[[actors]]\ngap_m = 1", "3:1: missing key `name`"),
        ("v2x = 3", "3:7: invalid type: integer `3`"),
    ];
    for (rest, expected) in cases {
        let shown = refusal(rest);
        assert!(shown.starts_with(&format!("error: x.toml:{expected}")), "{rest}\n{shown}");
    }
}

#[test]
fn lists_and_kinds_of_a_wrong_shape_are_named_in_the_words_of_a_scenario() {
    let of_actor = |rest: &str| format!("[[actors]]\nname = \"a\"\ngap_m = 50\n{rest}");
    let cases = [
        (
            of_actor("profile.speeds = [[0, 20, 99]]"),
            "6:19: invalid length 3",
            "a point [time_s, speed_mps]",
        ),
        (
            of_actor("profile.speeds = [[0]]"),
            "6:19: invalid length 1",
            "a point [time_s, speed_mps]",
        ),
        (
            of_actor("profile.speeds = [{ time_s = 0 }]"),
            "6:19: invalid type: a table",
            "a point [time_s, speed_mps]",
        ),
        (
            of_actor("profile = 3"),
            "6:11: invalid type: integer",
            "exactly one of `constant`, `steps`",
        ),
        (
            of_actor("[[actors.events]]\nwhen = { time_s = 1, gap_below_m = 3 }"),
            "7:8: invalid type: a table of 2 keys",
            "exactly one of `time_s`, `gap_below_m`",
        ),
        (
            "[road]\npoints = [[0, 0, 3]]".to_owned(),
            "4:11: invalid length 3",
            "a point [distance_m, height_m]",
        ),
        ("[referee]\ndesired_gap = 4".to_owned(), "4:15: invalid type: integer", "exactly one of "),
        (
            of_actor("profile = \"cycle\""),
            "6:11: the kind without what it is to be",
            "a table with its name as the key",
        ),
        ("[[plant]]\nperiod_ms = 5".to_owned(), "3:1: invalid type: a list", "a table"),
        (
            "[[fault]]\nkind = \"kill\"".to_owned(),
            "3:3: unknown key `fault`",
            "(did you mean `faults`?)",
        ),
    ];
    for (rest, found, expected) in cases {
        let shown = refusal(&rest);
        let right =
            shown.starts_with(&format!("error: x.toml:{found}")) && shown.contains(expected);
        assert!(right, "{rest}\n{shown}");
    }
}

#[test]
fn unknown_keys_are_refused_at_every_level() {
    let cases = [
        "colour = 1",
        "[plant]\ncolour = 1",
        "[plant.gateway]\ncolour = 1",
        "[plant.fallback]\ncolour = 1",
        "[plant.powertrain]\ncolour = 1",
        "[perception]\ncolour = 1",
        "[perception.radar]\ncolour = 1",
        "[perception.tracker]\ncolour = 1",
        "[perception.target_selection]\ncolour = 1",
        "[v2x]\ncolour = 1",
        "[[v2x.signals]]\ncolour = 1",
        "[[v2x.signals]]\nprogram = [{ colour = 1 }]",
        "[[actors]]\ncolour = 1",
        "[[actors]]\nprofile.colour = 1",
        "[[actors]]\nprofile.sine.colour = 1",
        "[[actors]]\nprofile.steps = [{ colour = 1 }]",
        "[[actors]]\nprofile.csv.colour = 1",
        "[[actors]]\nlateral = [{ colour = 1 }]",
        "[controller]\ncolour = 1",
        "[controller.weights]\ncolour = 1",
        "[road]\ncolour = 1",
        "[road.generated]\nseed = 1\nlength_km = 2\ncolour = 1",
        "[v2x.preview]\ncolour = 1",
        "[runtime]\ncolour = 1",
        "[runtime.services]\ncolour = 1",
        "[runtime.services.plant]\ncolour = 1",
    ];
    for case in cases {
        let shown = refusal(case);
        assert!(shown.contains("`colour`") && shown.contains("^^^^^^ expected `"), "{shown}");
    }
}

#[test]
fn keys_out_of_tune_are_shown_where_they_are_written() {
    let actor = "[[actors]]\nname = \"a\"\ngap_m = 9\n";
    let cases = [
        (
            "[controller]\nperiod_ms = 75".into(),
            "4:13: controller.period_ms = 75 is not a whole multiple of plant",
        ),
        (
            "[controller]\nperiod_ms = 70".into(),
            "4:13: controller.period_ms = 70 is not a whole multiple of perception",
        ),
        (
            "[plant]\nperiod_ms = 20".into(),
            "4:13: perception.period_ms = 50 is not a whole multiple",
        ),
        ("[plant]\nintegration_step_ms = 3".into(), "4:23: a step of 3 ms does not divide"),
        ("[controller]\nmax_request_mps2 = -1".into(), "4:20: this bound leaves no way to drive"),
        ("[controller]\ndeadline_ms = 101".into(), "4:15: the deadline is longer"),
        (
            "[perception.radar]\nlatency_ms = 30".into(),
            "4:14: perception.radar.latency_ms = 30 is not",
        ),
        (
            "[plant]\nperiod_ms = 10\n[runtime]\nextra_delay_ms = 5".into(),
            "6:18: runtime.extra_delay_ms = 5 is not",
        ),
        ("[runtime]\nextra_jitter_ms = 5".into(), "4:19: runtime.extra_jitter_ms = 5 is not"),
        (actor.to_owned(), "3:1: missing key `initial_speed_mps`"),
        (format!("{actor}profile.steps = []\ninitial_speed_mps = 1"), "6:17: an empty list"),
        (
            format!(
                "{actor}initial_speed_mps = 1\nprofile.piecewise = [{{ time_s = 2, \
                 acceleration_mps2 = 1 }}, {{ time_s = 2, acceleration_mps2 = 1 }}]"
            ),
            "7:61: times must increase",
        ),
        (
            format!("{actor}initial_speed_mps = 1\n{actor}initial_speed_mps = 1"),
            "8:8: another actor has the same name",
        ),
        (
            format!("{actor}initial_speed_mps = 1\nleaves_at_s = 0"),
            "7:15: it leaves before it appears",
        ),
        (format!("{actor}profile.csv.file = \"a.csv\""), "6:9: the file has not been read"),
    ];
    for (rest, expected) in cases {
        let shown = refusal(&rest);
        assert!(shown.starts_with(&format!("error: x.toml:{expected}")), "{rest}\n{shown}");
    }
}

#[test]
fn a_newer_schema_is_named_before_its_unknown_keys() {
    let text = "a_new_key = 1\nschema_version = 2\nname = \"x\"\n";
    let shown = Scenario::parse("x.toml", text).expect_err("version 2 is not known").to_string();
    assert!(shown.starts_with("error: x.toml:2:18: version 2 of the schema"), "{shown}");
}

#[test]
fn a_name_cannot_lead_out_of_the_run_directory() {
    let text = "schema_version = 1\nname = \"../../etc\"\n";
    let shown = Scenario::parse("x.toml", text).expect_err("not a name").to_string();
    assert!(shown.starts_with("error: x.toml:2:8: not a name"), "{shown}");
}

#[test]
fn a_law_can_refuse_its_own_parameters_with_their_place() {
    let text = format!("{SHORT}[controller.six_mode]\nrange_m = \"far\"\n");
    let shown = build(&text, &Overrides::new(), &|_| {
        Err(Problem::new("controller.six_mode.range_m", "not a range", "metres"))
    })
    .expect_err("the law refuses it")
    .to_string();
    assert!(shown.starts_with("error: x.toml:4:11: not a range"), "{shown}");
}

#[test]
fn hostile_documents_are_refused_in_order() {
    let deep = format!("{SHORT}x = {}1{}", "[".repeat(100_000), "]".repeat(100_000));
    let dotted = format!("{SHORT}{}x = 1", "a.".repeat(200_000));
    let header = format!("{SHORT}[{}x]\n", "a.".repeat(200_000));
    let inline = format!("{SHORT}x = {}1{}", "{a=".repeat(100_000), "}".repeat(100_000));
    for text in [deep, dotted, header, inline] {
        assert!(Scenario::parse("x.toml", &text).is_err());
    }
    let long = format!("{SHORT}# {}", "x".repeat(MAX_TEXT_BYTES));
    let shown = Scenario::parse("x.toml", &long).expect_err("it is too long").to_string();
    assert!(shown.contains("expected at most 1048576 bytes"), "{shown}");
    let crowd = format!("{SHORT}{}", "[[actors]]\nname = \"a\"\ngap_m = 1\n".repeat(20_000));
    assert!(Scenario::parse("x.toml", &crowd).is_err());
}

#[test]
fn an_unknown_scenario_lists_the_known_ones() {
    let error = Scenario::open("cacc-d", &Overrides::new(), &|_| Ok(Default::default()))
        .expect_err("no such");
    let shown = error.to_string();
    assert!(shown.contains("cacc-a, cacc-b") && shown.contains("did you mean cacc-a?"), "{shown}");
    let error = Scenario::open("no/such.toml", &Overrides::new(), &|_| Ok(Default::default()))
        .expect_err("none");
    assert!(error.to_string().contains("no/such.toml: cannot be opened"), "{error}");
    let error = Scenario::open("folowing", &Overrides::new(), &|_| Ok(Default::default()))
        .expect_err("misspelt");
    assert!(error.to_string().contains("(did you mean following?), expected a path"), "{error}");
}

#[test]
fn an_unknown_cycle_is_shown_with_a_suggestion() {
    let shown = refusal("[[actors]]\nname = \"a\"\ngap_m = 9\nprofile.cycle = \"us6\"\n");
    assert!(shown.contains("6:17: unknown value `us6`"), "{shown}");
    assert!(shown.contains("`wltc-3b`") && shown.contains("did you mean `us06`?"), "{shown}");
}

#[test]
fn an_emergency_brake_without_authority_is_refused() {
    let shown = refusal("[aebs]\ndeceleration_mps2 = 3\n");
    assert!(shown.contains("4:21") && shown.contains("has no authority"), "{shown}");
    assert!(shown.contains("at least 5 m/s²"), "{shown}");
    let off = format!("{SHORT}[aebs]\nenabled = false\ndeceleration_mps2 = 3\n");
    Scenario::parse("x.toml", &off).expect("what is off may be weak");
}
