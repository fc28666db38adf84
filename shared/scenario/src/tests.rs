//! Tests of whole documents: defaults, refusals with their places, overrides, round trips.

use proptest::prelude::*;

use super::*;

const SHORT: &str = "schema_version = 1\nname = \"short\"\n";

fn refusal(rest: &str) -> String {
    let text = format!("{SHORT}{rest}");
    Scenario::parse("x.toml", &text).expect_err("this scenario is wrong").to_string()
}

fn open(text: &str, arguments: &[&str]) -> Result<Scenario, ScenarioError> {
    let mut overrides = Overrides::new();
    for argument in arguments {
        overrides.set(argument)?;
    }
    Scenario::build("x.toml", text, &overrides, Place::BuiltIn, &|_| Ok(()))
}

#[test]
fn two_lines_are_a_scenario() {
    let scenario = Scenario::parse("x.toml", SHORT).expect("all else has defaults");
    assert_eq!(scenario.plant.period_ms.value(), 10);
    assert_eq!(scenario.perception.period_ms.value(), 50);
    assert_eq!(scenario.v2x.period_ms.value(), 100);
    assert_eq!(scenario.controller.period_ms.value(), 100);
    assert_eq!(scenario.controller.deadline().value(), 100);
}

#[test]
fn every_built_in_scenario_is_right_and_carries_its_name_and_summary() {
    for builtin in builtin::ALL {
        let scenario = Scenario::open(builtin.name, &Overrides::new(), &|_| Ok(()))
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario.name.as_str(), builtin.name);
        assert_eq!(scenario.description.as_str(), builtin.summary);
    }
}

#[test]
fn the_effective_scenario_reads_back_equal() {
    for builtin in builtin::ALL {
        let scenario = Scenario::parse(builtin.name, builtin.text).expect("it is right");
        let again = Scenario::parse("effective.toml", &scenario.to_toml())
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario, again);
        assert_eq!(scenario.to_toml(), again.to_toml());
    }
}

#[test]
fn a_wrong_value_is_shown_with_line_caret_and_expectation() {
    assert_eq!(
        refusal("[perception]\nperiod_ms = -50 # too fast\n"),
        "error: x.toml:4:13: -50 is out of range\n  \
           |\n\
         4 | period_ms = -50 # too fast\n  \
           |             ^^^ expected a period from 1 to 10000, in whole milliseconds"
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
fn lists_and_kinds_of_a_wrong_shape_are_told_in_the_words_of_a_scenario() {
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
            "6:19: invalid type: map",
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
fn overrides_reach_every_key() {
    let text = builtin::find("cacc-a").expect("it is built in").text;
    let scenario = open(
        text,
        &[
            "controller.solver=clarabel",
            "actors.0.gap_m=30",
            "actors.0.profile.sine={ amplitude_mps2 = 1, period_s = 4 }",
            "perception.radar.latency_ms=100",
            "v2x.signals.0.program.0.duration_s=6",
            "runtime.services.controller.core=1",
            "plant.powertrain={mass_kg=1500,max_power_kw=90}",
            "controller.six_mode.variant=literal",
            "seed=7",
        ],
    );
    // A string cannot be descended into: the profile of the file is `"constant"`.
    let shown = scenario.expect_err("a word has no keys").to_string();
    assert!(shown.contains("`profile` holds a value (string), so it has no keys"), "{shown}");

    let scenario = open(
        text,
        &[
            "controller.solver=clarabel",
            "actors.0.gap_m=30",
            "actors.0.profile={ sine = { amplitude_mps2 = 1, period_s = 4 } }",
            "perception.radar.latency_ms=100",
            "v2x.signals.0.program.0.duration_s=6",
            "runtime.services.controller.core=1",
            "plant.powertrain={mass_kg=1500,max_power_kw=90}",
            "controller.six_mode.variant=literal",
            "seed=7",
        ],
    )
    .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scenario.actors[0].gap_m.value(), 30.0);
    assert_eq!(scenario.v2x.signals[0].program[0].duration_s.value(), 6.0);
    assert_eq!(scenario.seed.value(), 7);
    let six_mode: toml::Table = scenario.controller.tables.read("six_mode").expect("it is a table");
    assert_eq!(six_mode["variant"].as_str(), Some("literal"));
    let again = Scenario::parse("effective.toml", &scenario.to_toml()).expect("it reads back");
    assert_eq!(scenario, again);
}

#[test]
fn a_wrong_override_is_shown_as_it_was_typed() {
    let text = builtin::find("cacc-a").expect("it is built in").text;
    let cases = [
        ("plant.period_ms=-5", "-5 is out of range", "                      ^^ expected a period"),
        ("plant.perod_ms=5", "unknown key `perod_ms`", "            ^^^^^^^^ expected"),
        ("actors.1.gap_m=5", "no element `1` in an array of 1", "             ^ expected an index"),
        ("actors.lead.gap_m=5", "no element `lead`", "             ^^^^ expected an index"),
        ("seed.x=5", "missing", "never"),
        ("seed", "no `=`", "      ^^^^ expected KEY=VALUE"),
        ("a..b=1", "`` cannot be a key", "        ^ expected names"),
        ("controller.name=a/b", "not a name", "^^^ expected 1 to 64"),
        ("controller.perod_ms=5", "unknown key `perod_ms`", "(did you mean `period_ms`?)"),
        (
            "controller.period_ms=70",
            "= 70 is not a whole multiple",
            "^^ expected controller.period_ms",
        ),
        ("plant.period_ms=30", "perception.period_ms = 50 is not", "^^ expected perception.period"),
        ("actors.0.profile=[1,", "", "^"),
        ("description=\"a", "", "^"),
    ];
    for (argument, message, caret) in cases {
        let shown = match open(text, &[argument]) {
            Ok(_) if caret == "never" => continue,
            Ok(_) => panic!("{argument} was taken"),
            Err(error) => error.to_string(),
        };
        assert!(shown.starts_with(&format!("error: --set {argument}: ")), "{shown}");
        if caret != "never" {
            assert!(shown.contains(message) && shown.contains(caret), "{shown}");
        }
    }
}

#[test]
fn an_option_of_its_own_is_named_in_its_errors() {
    let text = builtin::find("cacc-a").expect("it is built in").text;
    let mut overrides = Overrides::new();
    overrides.option("--controller", "controller.name", "cac-mpc");
    let check = |_: &Scenario| {
        Err(Problem::new("controller.name", "unknown value `cac-mpc`", "`acc-mpc`, `cacc-mpc`"))
    };
    let shown = Scenario::build("x.toml", text, &overrides, Place::BuiltIn, &check)
        .expect_err("no such controller")
        .to_string();
    assert!(shown.starts_with("error: --controller cac-mpc: unknown"), "{shown}");
}

#[test]
fn the_last_override_of_a_key_wins() {
    let scenario = open(SHORT, &["seed=3", "seed=4"]).expect("both are right");
    assert_eq!(scenario.seed.value(), 4);
}

#[test]
fn a_law_can_refuse_its_own_parameters_with_their_place() {
    let text = format!("{SHORT}[controller.six_mode]\nrange_m = \"far\"\n");
    let shown = Scenario::build("x.toml", &text, &Overrides::new(), Place::BuiltIn, &|_| {
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
    let error = Scenario::open("cacc-d", &Overrides::new(), &|_| Ok(())).expect_err("no such");
    let shown = error.to_string();
    assert!(shown.contains("cacc-a, cacc-b") && shown.contains("did you mean cacc-a?"), "{shown}");
    let error = Scenario::open("no/such.toml", &Overrides::new(), &|_| Ok(())).expect_err("none");
    assert!(error.to_string().contains("no/such.toml: cannot be opened"), "{error}");
}

#[test]
fn one_key_makes_the_controller_fast() {
    let scenario = open(SHORT, &["controller.period_ms=1"]).expect("the rest follows");
    assert_eq!(scenario.plant.period_ms.value(), 1);
    assert_eq!(scenario.controller.release, controller::Release::Timer);
    assert_eq!(scenario.controller.prediction_step().value(), 100);
    // What is written stays, and is refused where it does not fit.
    assert!(open(SHORT, &["controller.period_ms=1", "plant.period_ms=10"]).is_err());
    assert!(open(SHORT, &["controller.period_ms=1", "controller.release=radar"]).is_err());
}

#[test]
fn a_delay_between_two_steps_of_the_plant_makes_them_shorter() {
    let period_ms = |delay: &str| {
        let delay = format!("runtime.extra_delay_ms={delay}");
        open(SHORT, &[&delay]).expect("the rest follows").plant.period_ms.value()
    };
    assert_eq!(["0", "10", "400", "25", "4"].map(period_ms), [10, 10, 10, 5, 2]);
    assert!(open(SHORT, &["runtime.extra_delay_ms=25", "plant.period_ms=10"]).is_err());
}

#[test]
fn a_laws_table_keeps_its_places_also_on_the_command_line() {
    #[derive(Debug, Default, serde::Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct Table {
        gain_per_s: f64,
    }
    let read = |scenario: &Scenario| {
        let table: Result<Table, Problem> = scenario.controller.tables.read("mine");
        table.map(|table| assert!(table.gain_per_s >= 0.0))
    };
    let text = format!("{SHORT}[controller.mine]\ngain_per_s = 1\n");
    let shown = |text: &str, argument: &str| {
        let mut overrides = Overrides::new();
        overrides.set(argument).expect("KEY=VALUE");
        Scenario::build("x.toml", text, &overrides, Place::BuiltIn, &read)
            .map_err(|error| error.to_string())
    };
    assert!(shown(&text, "seed=1").is_ok());
    let error = shown(&text, "controller.mine.gian_per_s=2").expect_err("no such key");
    assert!(error.starts_with("error: --set controller.mine.gian_per_s=2: unknown key"), "{error}");
    assert!(error.contains("did you mean `gain_per_s`?"), "{error}");
    let error = shown(&text.replace("gain_per_s = 1", "gain_per_s = true"), "seed=1")
        .expect_err("no number");
    assert!(error.starts_with("error: x.toml:4:14: ") && error.contains("^^^^"), "{error}");
}

#[test]
fn a_speed_table_in_a_file_becomes_part_of_the_effective_scenario() {
    let directory = std::env::temp_dir().join(format!("timegap-scenario-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("the temporary directory is writable");
    let write = |name: &str, text: &str| {
        std::fs::write(directory.join(name), text).expect("the temporary directory is writable");
    };
    write("lead.csv", "time_s,speed_mps\n0,10\n5,12.5\n");
    write(
        "drive.toml",
        &format!(
            "{SHORT}[[actors]]\nname = \"lead\"\ngap_m = 9\nprofile.csv.file = \"lead.csv\"\n"
        ),
    );
    let path = directory.join("drive.toml").display().to_string();
    let opened = Scenario::open(&path, &Overrides::new(), &|_| Ok(()));
    write("lead.csv", "time_s,speed_mps\n0,10\n0,12.5\n");
    let refused = Scenario::open(&path, &Overrides::new(), &|_| Ok(()));
    std::fs::remove_file(directory.join("lead.csv")).expect("it was written above");
    let missing = Scenario::open(&path, &Overrides::new(), &|_| Ok(()));
    std::fs::remove_dir_all(&directory).expect("it was made above");

    let scenario = opened.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scenario.actors[0].profile.points().map(<[_]>::len), Some(2));
    let again = Scenario::parse("effective.toml", &scenario.to_toml()).expect("it reads back");
    assert_eq!(scenario, again);
    let shown = refused.expect_err("time stands still").to_string();
    assert!(shown.contains("lead.csv:3:1: times must increase"), "{shown}");
    let shown = missing.expect_err("the table is gone").to_string();
    assert!(shown.contains("drive.toml:6:20: ") && shown.contains("lead.csv cannot be opened"));
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        let _ = Scenario::parse("x.toml", &text).map_err(|error| error.to_string());
    }

    #[test]
    fn no_mutation_of_a_scenario_makes_the_reader_panic(
        at in 0usize..2000, length in 0usize..12, put in "[\\[\\]{}=.,\"'#\n a-z0-9é-]{0,6}",
    ) {
        let mut text = builtin::find("corridor").expect("it is built in").text.to_owned();
        let (at, end) = (at.min(text.len()), (at + length).min(text.len()));
        if text.is_char_boundary(at) && text.is_char_boundary(end) {
            text.replace_range(at..end, &put);
        }
        match Scenario::parse("x.toml", &text) {
            Ok(scenario) => {
                let again = Scenario::parse("again.toml", &scenario.to_toml());
                prop_assert_eq!(again.as_ref(), Ok(&scenario));
            }
            Err(error) => prop_assert!(error.to_string().starts_with("error: ")),
        }
    }

    #[test]
    fn no_override_makes_the_reader_panic(argument in "[a-z.0-9_=\\[\\]{}\" é]{0,40}") {
        let _ = open(SHORT, &[&argument]).map_err(|error| error.to_string());
    }
}

#[test]
fn a_road_from_a_file_is_embedded_and_its_faults_are_shown_in_it() {
    let directory = std::env::temp_dir().join(format!("timegap-road-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("a directory");
    let scenario = format!("{SHORT}plant.vehicle = \"jh6-25t\"\nroad.csv = \"hills.csv\"\n");
    let place = directory.join("hilly.toml");
    std::fs::write(&place, scenario).expect("our own");
    let open = || {
        let path = place.to_string_lossy();
        Scenario::open(&path, &Overrides::new(), &|_| Ok(())).map_err(|error| error.to_string())
    };
    let missing = open().expect_err("no road yet");
    assert!(missing.contains("hilly.toml:4:12") && missing.contains("hills.csv"), "{missing}");

    let road = directory.join("hills.csv");
    let marked = "\u{feff}distance_m,height_m\n0,10\n50,11\n100,9.5\n";
    std::fs::write(&road, marked).expect("our own");
    let opened = open().expect("a right road");
    let again = Scenario::parse("effective.toml", &opened.to_toml()).expect("what took effect");
    assert_eq!(again.road.profile(), opened.road.profile());
    assert_eq!(again.road.profile().map(|road| road.grade(60.0)), Ok(-0.03));

    std::fs::write(&road, "distance_m,height_m\n0,10\n50,nan\n").expect("our own");
    let wrong = open().expect_err("no height");
    assert!(wrong.contains("hills.csv:3:4: NaN is out of range"), "{wrong}");
    std::fs::remove_dir_all(&directory).expect("our own");
}

#[test]
fn roads_that_cannot_be_are_refused() {
    const TRUCK: &str = "plant.vehicle = \"jh6-49t\"\n";
    let cases = [
        ("road.builtin = \"hills-60km\"", "a car knows no grade"),
        ("plant.mass_factor = 1.2", "a car has no mass here"),
        ("road.csv = \"x.csv\"", "the file has not been read"),
        ("road.points = [[0, 0], [50, 1], [50, 2]]", "distances must increase"),
        ("road.points = [[0, 0], [50, 20]]", "a grade of 40.0 %"),
        (
            "road = { builtin = \"hills-60km\", points = [[0, 0], [1, 0]] }",
            "the road is given twice",
        ),
        ("road.generated = { seed = 1, length_km = 0.1 }", "0.1 is out of range"),
        (
            "plant.integrator = \"paper-euler\"\nplant.integration_step_ms = 10",
            "a truck has no paper's Euler step",
        ),
    ];
    for (index, (rest, expected)) in cases.into_iter().enumerate() {
        let head = if index < 3 { "" } else { TRUCK };
        let shown = refusal(&format!("{head}{rest}"));
        assert!(shown.contains(expected), "{rest}\n{shown}");
    }
}

#[test]
fn a_lead_drives_a_standard_cycle() {
    let text = format!("{SHORT}[[actors]]\nname = \"a\"\ngap_m = 9\nprofile.cycle = \"us06\"\n");
    let scenario = Scenario::parse("x.toml", &text).expect("the cycle is known");
    let points = scenario.actors[0].profile.points().expect("a cycle is a table of speeds");
    assert_eq!(points.len(), 601);
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

#[test]
fn an_option_replaces_an_actors_profile() {
    let text = "schema_version = 1\nname = \"x\"\n[[actors]]\nname = \"a\"\ngap_m = 9\n\
        initial_speed_mps = 3\nprofile.sine = { amplitude_mps2 = 1, period_s = 9 }\n";
    let scenario = open(text, &["actors[0].profile.cycle=\"udds\""]).expect("one profile is left");
    assert_eq!(scenario.actors[0].profile, actor::Profile::Cycle(cycle::Cycle::Udds));
    let scenario = open(text, &["actors.0.profile.sine.period_s=4"]).expect("it changes one key");
    assert_eq!(scenario.actors[0].initial_speed_mps.map(f64::from), Some(3.0));
    let refused = open(text, &["actors[0.gap_m=4"]).expect_err("the bracket stays open");
    assert!(refused.to_string().contains("cannot be a key"), "{refused}");
}

#[test]
fn a_radar_has_one_model() {
    let model = |keys: &str| {
        let text = format!("schema_version = 1\nname = \"x\"\n[perception]\n{keys}");
        Scenario::build("x.toml", &text, &Overrides::new(), Place::BuiltIn, &|_| Ok(()))
            .map(|scenario| (scenario.perception.model(), scenario.to_toml()))
    };
    for one in
        ["ideal = true\n", "radar.model = \"ideal\"\n", "ideal = true\nradar.model = \"ideal\"\n"]
    {
        let (found, effective) = model(one).expect("one model");
        assert_eq!(found, perception::RadarModel::Ideal, "{one}");
        // What took effect can be opened again.
        Scenario::build("x.toml", &effective, &Overrides::new(), Place::BuiltIn, &|_| Ok(()))
            .expect(one);
    }
    for other in ["detections", "object-list"] {
        let error =
            model(&format!("ideal = true\nradar.model = \"{other}\"\n")).expect_err("two models");
        assert!(error.to_string().contains("perception.ideal = true"), "{error}");
        // As a run of an earlier version kept it.
        let kept = format!(
            "schema_version = 1\nname = \"x\"\n[perception]\nideal = true\nradar.model = \"{other}\"\n"
        );
        let kept = Scenario::parse("kept", &kept).expect("ideal counts");
        assert_eq!(kept.perception.model(), perception::RadarModel::Ideal);
    }
}
