//! Units of the Functional Mock-up Interface as laws and as the ego, made here in C, and by other people's tools.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use system_tests::cases::{self, Needed, case, needing};
use system_tests::missing::Missing;
use system_tests::{Corner, python, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// A variable of a model description of version 2: name, number, part, attributes of its value.
type Variable<'a> = (&'a str, u32, &'a str, &'a str);

const LAW: [Variable<'_>; 6] = [
    ("v", 0, "input", "start='0' unit='m/s'"),
    ("gap", 1, "input", "start='0' unit='m'"),
    ("dv", 2, "input", "start='0'"),
    ("v_set", 3, "input", "start='0'"),
    ("a", 4, "output", ""),
    ("gain", 5, "parameter", "start='0.4'"),
];

const CAR: [Variable<'_>; 5] = [
    ("a_req", 0, "input", "start='0'"),
    ("v0", 2, "parameter", "start='0'"),
    ("x", 3, "output", "unit='m'"),
    ("v", 4, "output", "unit='km/h'"),
    ("a", 5, "output", ""),
];

fn description(version: &str, kind: &str, variables: &[Variable<'_>]) -> String {
    let variables = variables.iter().map(|(name, number, part, value)| {
        format!(
            "<ScalarVariable name='{name}' valueReference='{number}' causality='{part}'>\
             <Real {value}/></ScalarVariable>\n"
        )
    });
    format!(
        "<?xml version='1.0'?>\n<fmiModelDescription fmiVersion='{version}' modelName='unit' guid='1'>\n\
         <{kind} modelIdentifier='unit' canHandleVariableCommunicationStepSize='true'/>\n\
         <ModelVariables>\n{}</ModelVariables><ModelStructure/></fmiModelDescription>\n",
        variables.collect::<String>()
    )
}

/// The library of a unit in C.
fn library(corner: &Corner, source: &str, flags: &[&str]) -> Vec<u8> {
    let file = format!("{}/data/fmi/{source}", env!("CARGO_MANIFEST_DIR"));
    let library = corner.path().join("unit.so");
    let at = if flags.iter().any(|flag| flag.starts_with("-DAT")) { "-DUNUSED" } else { "-DAT=-1" };
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", at])
        .args(flags)
        .arg(file)
        .arg("-o")
        .arg(&library)
        .arg("-lm")
        .output()
        .expect("Rust links with cc");
    assert!(built.status.success(), "{}", text(&built));
    std::fs::read(library).expect("it was built")
}

/// Writes a unit into a corner.
fn unit(corner: &Corner, name: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let path = corner.path().join(name);
    std::fs::write(&path, fmi::pack(files).expect("small")).expect("our own directory");
    path
}

/// A unit in C that this machine runs.
fn of_source(
    corner: &Corner,
    name: &str,
    source: &str,
    flags: &[&str],
    variables: &[Variable<'_>],
) {
    let library = library(corner, source, flags);
    let description = description("2.0", "CoSimulation", variables);
    let place = match std::env::consts::ARCH {
        "x86_64" => "binaries/linux64/unit.so".to_owned(),
        other => format!("binaries/{other}-linux/unit.so"),
    };
    unit(corner, name, &[("modelDescription.xml", description.as_bytes()), (&place, &library)]);
}

const RUN: [&str; 7] = ["run", "following", "--mode", "lockstep", "--duration", "8", "--no-record"];

/// A unit drives in one process and in a group, and gives the same bytes. Its knob can be swept.
fn a_unit_is_a_law() {
    let corner = Corner::new(PROGRAM);
    of_source(&corner, "law.fmu", "law.c", &[], &LAW);
    let law = ["--law", "mine=law.fmu"];
    let inside = corner.json(&[&RUN[..], &law, &["--in-process", "--digests"]].concat());
    assert_eq!((&inside["outcome"], &inside["law"]["name"]), (&"completed".into(), &"mine".into()));
    let group = corner.json(&[&RUN[..], &law].concat());
    let digests = |summary: &Value| summary["messages"]["control/command"]["digests"].clone();
    assert_eq!(digests(&group), digests(&inside));
    let gains = "--vary=laws.mine.arguments.gain=0.2,0.8";
    let short = ["sweep", "following", "--duration", "4", "--set", "set_speed_mps=18"];
    let swept = corner.json(&[&short[..], &law, &[gains]].concat());
    let jerk = |k: usize| swept["points"][k]["figures"]["rms_jerk_mps3"].as_f64();
    assert!(jerk(0).is_some() && jerk(0) != jerk(1), "{swept}");
    corner.expect_nothing_left(&[]);
}

/// A variable is found by its unit of measure, by a map, and inside a component.
fn variables_are_wired_by_measure_and_by_map() {
    let corner = Corner::new(PROGRAM);
    let digest = |name: &str, words: &str, variables: &[Variable<'_>]| {
        of_source(&corner, name, "law.c", &[], variables);
        let law = format!("mine={name}{words}");
        let run = corner.json(&[&RUN[..], &["--in-process", "--digests", "--law", &law]].concat());
        run["messages"]["control/command"]["digests"].clone()
    };
    let plain = digest("plain.fmu", "", &LAW);
    let mut other = LAW;
    (other[0].0, other[1].0, other[4].0) = ("car.chassis.v_ego", "q7", "drive_mps2");
    other[4].3 = "unit='m/s2'";
    assert_eq!(digest("other.fmu", " gap_m=q7", &other), plain);
    corner.expect_nothing_left(&[]);
}

fn a_unit_that_is_no_law_is_refused_in_one_line() {
    let corner = Corner::new(PROGRAM);
    let library = library(&corner, "law.c", &[]);
    let described = |text: &str, place: &str| {
        unit(&corner, "u.fmu", &[("modelDescription.xml", text.as_bytes()), (place, &library)]);
    };
    let here = match std::env::consts::ARCH {
        "x86_64" => "binaries/linux64/unit.so".to_owned(),
        other => format!("binaries/{other}-linux/unit.so"),
    };
    let refused = |what: &str| {
        let output = corner.run(&["run", "following", "--mode", "lockstep", "--law", "m=u.fmu"]);
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(what) && said.contains("expected"), "{what}: {said}");
        let errors = said.lines().filter(|line| line.starts_with("error")).count();
        assert_eq!(errors, 1, "{said}");
    };
    let changed = |place: usize, variable: Variable<'static>| {
        let mut variables = LAW;
        variables[place] = variable;
        description("2.0", "CoSimulation", &variables)
    };
    for (text, what) in [
        (description("1.0", "CoSimulation", &LAW), "FMI version `1.0`"),
        (description("2.0", "ModelExchange", &LAW), "not for co-simulation"),
        (changed(4, ("a", 4, "local", "")), "an output for request_mps2 is not found"),
        (changed(4, ("a", 4, "input", "start='0'")), "an output for request_mps2 is not found"),
        (changed(0, ("v", 0, "input", "unit='kg'")), "the unit `kg` of `v`"),
        (changed(0, ("v", 0, "input", "unit='furlong'")), "`furlong` of `v` is not defined"),
        ("<a/>".to_owned(), "element `a`"),
        ("<a".to_owned(), "not XML"),
    ] {
        described(&text, &here);
        refused(what);
    }
    let right = description("2.0", "CoSimulation", &LAW);
    described(&right, "binaries/win64/unit.dll");
    refused("binaries for win64");
    let broken = [("modelDescription.xml", right.as_bytes()), (&*here, b"no library".as_slice())];
    unit(&corner, "u.fmu", &broken);
    refused("its library cannot be loaded");
    std::fs::write(corner.path().join("u.fmu"), "no archive").expect("our own directory");
    refused("not a zip archive");
    for failure in ["-DSEGV", "-DEXIT", "-DERROR", "-DNANS"] {
        of_source(&corner, "u.fmu", "law.c", &[failure, "-DAT=1"], &LAW);
        refused("the law `u.fmu`");
    }
    corner.expect_nothing_left(&[]);
}

/// In simulated time the run ends with a line; in real time the backup drives, and a new unit is started.
fn a_unit_that_fails_on_its_way_is_replaced() {
    let corner = Corner::new(PROGRAM);
    for (failure, what) in [
        ("-DSEGV", "SIGSEGV"),
        ("-DEXIT", "exit status: 0"),
        ("-DERROR", "DoStep gave an error"),
        ("-DHANG", "gave no answer"),
    ] {
        of_source(&corner, "u.fmu", "law.c", &[failure, "-DAT=12"], &LAW);
        let patience = ["--set", "controller.external.patience_s=1"];
        let output = corner.run(&[&RUN[..], &["--law", "m=u.fmu"], &patience].concat());
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        assert!(text(&output).contains(what), "{what}: {}", text(&output));
        let realtime = ["run", "following", "--duration", "3", "--no-record", "--law", "m=u.fmu"];
        let quick =
            ["--set", "controller.external.silence_s=0.2", "--set", "require.max_backup_share=1"];
        let summary = corner.json(&[&realtime[..], &quick].concat());
        let program = &summary["timing"]["law_program"];
        assert!(program["starts"].as_u64() > Some(1), "{what}: {program}");
        assert!(program["answers"].as_u64() > Some(5), "{what}: {program}");
        assert!(program["failures"][0].to_string().contains(what), "{what}: {program}");
    }
    of_source(&corner, "u.fmu", "law.c", &["-DNANS", "-DAT=12"], &LAW);
    let share = ["--law", "m=u.fmu", "--set", "require.max_backup_share=1"];
    let summary = corner.json(&[&RUN[..], &share].concat());
    assert!(summary["timing"]["law_program"]["refused"].as_u64() > Some(10), "{summary}");
    corner.expect_nothing_left(&[]);
}

/// A car that moves in a unit: the same bytes in one process and in a group.
fn a_unit_is_the_ego() {
    let corner = Corner::new(PROGRAM);
    let mut pedals = CAR.to_vec();
    pedals[0].0 = "throttle";
    pedals.push(("brake", 1, "input", "start='0'"));
    for (flags, variables) in [(&[][..], &CAR[..]), (&["-DPEDALS"][..], &pedals)] {
        of_source(&corner, "car.fmu", "car.c", flags, variables);
        let car = ["--set", "plant.fmu=car.fmu"];
        let inside = corner.json(&[&RUN[..], &car, &["--in-process", "--digests"]].concat());
        let own = corner.json(&[&RUN[..], &["--in-process", "--digests"]].concat());
        let group = corner.json(&[&RUN[..], &car].concat());
        let digests = |summary: &Value| summary["messages"]["vehicle/odometry"]["digests"].clone();
        assert_eq!(digests(&group), digests(&inside));
        assert_ne!(digests(&own), digests(&inside), "it is another car");
        let gap = |summary: &Value| summary["control"]["min_gap_m"].as_f64().expect("a gap");
        assert!((gap(&own) - gap(&inside)).abs() < 5.0, "{} {}", gap(&own), gap(&inside));
        assert_eq!(inside["outcome"], "completed");
    }
    corner.expect_nothing_left(&[]);
}

/// In simulated time a car that fails ends the run; in real time the plant's own car moves meanwhile.
fn an_ego_that_fails_is_replaced() {
    let corner = Corner::new(PROGRAM);
    let car = ["--set", "plant.fmu=car.fmu"];
    for (failure, what) in [("-DSEGV", "SIGSEGV"), ("-DNANS", "speed_mps = NaN")] {
        of_source(&corner, "car.fmu", "car.c", &[failure, "-DAT=120"], &CAR);
        let output = corner.run(&[&RUN[..], &car].concat());
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        assert!(text(&output).contains(what), "{what}: {}", text(&output));
        let realtime = ["run", "following", "--duration", "3", "--no-record", "--json"];
        let output = corner.run(&[&realtime[..], &car].concat());
        assert!(output.status.success(), "{}", text(&output));
        assert!(text(&output).contains("the plant's own car"), "{}", text(&output));
    }
    of_source(&corner, "car.fmu", "car.c", &[], &CAR[..1]);
    for (words, what) in [
        (&["--set", "plant.fmu=car.fmu"][..], "an output for speed_mps is not found"),
        (&["--set", "plant.fmu=none.fmu"], "No such file"),
        (&["--set", "plant.fmu_map.speed_mps=v"], "there is no unit"),
    ] {
        let output = corner.run(&[&RUN[..], words].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(what), "{what}: {}", text(&output));
    }
    // It begins at rest whatever it is told, and the scenario begins at speed: only a unit that runs shows that.
    let mut deaf = CAR;
    deaf[1].0 = "other";
    of_source(&corner, "car.fmu", "car.c", &[], &deaf);
    let output = corner.run(&[&RUN[..], &car].concat());
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(text(&output).contains("begins at 0 m/s"), "{}", text(&output));
    corner.expect_nothing_left(&[]);
}

fn interpreter() -> Result<PathBuf, Missing> {
    python::FMI.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR")))
}

fn has_python() -> Needed {
    interpreter().map(|_| ())
}

/// Runs Python in a corner, which must succeed.
fn run_python(corner: &Corner, arguments: &[&str]) -> String {
    let mut command = Command::new(interpreter().expect("looked for before"));
    let output = command.args(arguments).current_dir(corner.path()).output().expect("it starts");
    assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    text(&output)
}

/// Units of version 2 and 3 that pythonfmu wrote, with the same law, drive alike.
fn units_of_another_tool_are_laws() {
    let corner = Corner::new(PROGRAM);
    let source = include_str!("../../examples/fmi/law.py");
    std::fs::write(corner.path().join("law.py"), source).expect("our own directory");
    let three = [
        ("pythonfmu", "pythonfmu3"),
        ("Fmi2", "Fmi3"),
        ("Real", "Float64"),
        (
            "        return True",
            "        return Fmi3StepResult(Fmi3Status.ok, False, False, time + step)",
        ),
        ("import Boolean,", "import Boolean, Fmi3Status, Fmi3StepResult,"),
        ("class Law(", "class Law3("),
        (
            "        for name in",
            "        self.time = 0.0\n        self.register_variable(Float64(\"time\", \
             causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous))\n        for name in",
        ),
    ];
    let text = three.iter().fold(source.to_owned(), |text, (two, three)| text.replace(two, three));
    std::fs::write(corner.path().join("law3.py"), text).expect("our own directory");
    run_python(&corner, &["-m", "pythonfmu", "build", "-f", "law.py"]);
    run_python(&corner, &["-m", "pythonfmu3", "build", "-f", "law3.py"]);
    let gap = |law: &str| {
        let run = corner.json(&[&RUN[..], &["--law", law]].concat());
        run["control"]["min_gap_m"].as_f64().expect("a gap")
    };
    let (two, three) = (gap("mine=Law.fmu"), gap("mine=Law3.fmu"));
    assert!((two - three).abs() < 1e-6, "{two} {three}");
    assert!(gap("mine=Law.fmu --headway=2.5") > two);
    corner.expect_nothing_left(&[]);
}

/// fmpy validates the units that timegap writes, and drives them. An exported law drives timegap as the law itself.
fn exported_units_run_under_another_master() {
    let corner = Corner::new(PROGRAM);
    for (name, words) in [("law.fmu", &[][..]), ("loop.fmu", &["--plant", "--link"])] {
        let export = ["export-fmu", "--law", "acc-mpc", "--file", name];
        let output = corner.run(&[&export[..], words].concat());
        assert!(output.status.success(), "{}", text(&output));
    }
    let master = format!("{}/data/fmi/master.py", env!("CARGO_MANIFEST_DIR"));
    let said = run_python(&corner, &[&master, "law.fmu", "loop.fmu"]);
    assert!(said.contains("both units drive"), "{said}");
    corner.expect_nothing_left(&[]);
}

/// The way out and in again: the law as a unit drives as the law.
fn an_exported_law_is_the_law() {
    let corner = Corner::new(PROGRAM);
    let export = ["export-fmu", "--law", "six-mode", "--link", "--file", "six.fmu"];
    let output = corner.run(&export);
    assert!(output.status.success(), "{}", text(&output));
    let gap = |words: &[&str]| {
        let run = corner.json(&[&RUN[..], words].concat());
        run["control"]["min_gap_m"].as_f64().expect("a gap")
    };
    let (law, unit) = (gap(&["--controller", "six-mode"]), gap(&["--law", "six=six.fmu"]));
    assert!((law - unit).abs() < 0.5, "{law} {unit}");
    for (words, what) in [
        (&["--law", "acc-mcp", "--file", "x.fmu"][..], "did you mean `acc-mpc`?"),
        (&["--law", "acc-mpc", "--file", "x.zip"], "ends with .fmu"),
        (&["--law", "predictive", "--file", "x.fmu"], "expected"),
        (&["--law", "acc-mpc", "--file", "none/x.fmu"], "cannot write"),
    ] {
        let output = corner.run(&[&["export-fmu"], words].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(what), "{what}: {}", text(&output));
    }
    corner.expect_nothing_left(&[]);
}

fn main() -> ExitCode {
    cases::run(&[
        case("a_unit_is_a_law", a_unit_is_a_law),
        case(
            "variables_are_wired_by_measure_and_by_map",
            variables_are_wired_by_measure_and_by_map,
        ),
        case(
            "a_unit_that_is_no_law_is_refused_in_one_line",
            a_unit_that_is_no_law_is_refused_in_one_line,
        ),
        case("a_unit_that_fails_on_its_way_is_replaced", a_unit_that_fails_on_its_way_is_replaced),
        case("a_unit_is_the_ego", a_unit_is_the_ego),
        case("an_ego_that_fails_is_replaced", an_ego_that_fails_is_replaced),
        case("an_exported_law_is_the_law", an_exported_law_is_the_law),
        needing(has_python, "units_of_another_tool_are_laws", units_of_another_tool_are_laws),
        needing(
            has_python,
            "exported_units_run_under_another_master",
            exported_units_run_under_another_master,
        ),
    ])
}
