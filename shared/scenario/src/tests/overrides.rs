//! Keys from the command line.

use super::*;

#[test]
fn overrides_reach_every_key() {
    let text = builtin::find("cacc-a").expect("it is built in").text;
    let scenario = open(
        text,
        &[
            "controller.solver=clarabel",
            "actors.0.gap_m=30",
            "actors.0.profile.sine={ amplitude_mps2 = 1, period_s = 4 }",
            "perception.radar.max_range_m=100",
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
            "perception.radar.max_range_m=100",
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
        ("duration_s=30s", "`30s` is not a number", "^^^ expected a number alone, such as 30"),
        ("set_speed_mps=20mps", "`20mps` is not a number", "a number alone, such as 20"),
        (
            "controller.command=python3 law.py",
            "invalid type",
            "^ expected a list of words, such as [\"python3\", \"law.py\"]",
        ),
        (
            "plant.mass_kg=1500",
            "unknown key `mass_kg`",
            "(did you mean `plant.powertrain.mass_kg`?)",
        ),
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
    let shown = build(text, &overrides, &check).expect_err("no such controller").to_string();
    assert!(shown.starts_with("error: --controller cac-mpc: unknown"), "{shown}");
}

#[test]
fn the_last_override_of_a_key_wins() {
    let scenario = open(SHORT, &["seed=3", "seed=4"]).expect("both are right");
    assert_eq!(scenario.seed.value(), 4);
}

#[test]
fn a_laws_table_keeps_its_places_also_on_the_command_line() {
    #[derive(Debug, Default, serde::Serialize, serde::Deserialize, schema::Schema)]
    #[serde(deny_unknown_fields, default)]
    struct Table {
        gain_per_s: f64,
    }
    let read = |scenario: &Scenario| {
        let table: Result<Table, Problem> = scenario.controller.tables.read("mine");
        table.map(|table| {
            assert!(table.gain_per_s >= 0.0);
            Reads::everything()
        })
    };
    let text = format!("{SHORT}[controller.mine]\ngain_per_s = 1\n");
    let shown = |text: &str, argument: &str| {
        let mut overrides = Overrides::new();
        overrides.set(argument.parse().expect("KEY=VALUE"));
        build(text, &overrides, &read).map_err(|error| error.to_string())
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
fn an_option_replaces_an_actors_profile() {
    let text = "schema_version = 1\nname = \"x\"\n[[actors]]\nname = \"a\"\ngap_m = 9\n\
        initial_speed_mps = 3\nprofile.sine = { amplitude_mps2 = 1, period_s = 9 }\n";
    let scenario = open(text, &["actors[0].profile.cycle=\"udds\""]).expect("one profile is left");
    assert_eq!(scenario.actors[0].profile, actor::Profile::Cycle(speeds::Cycle::Udds));
    let scenario = open(text, &["actors.0.profile.sine.period_s=4"]).expect("it changes one key");
    assert_eq!(scenario.actors[0].initial_speed_mps.map(f64::from), Some(3.0));
    let refused = open(text, &["actors[0.gap_m=4"]).expect_err("the bracket stays open");
    assert!(refused.to_string().contains("cannot be a key"), "{refused}");
}
