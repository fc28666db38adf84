//! Keys and their effect: what a law's descriptor says that it reads is what changes its commands.
//!
//! Each key of `[controller]` and of the laws' tables is changed, one at a time. The law then
//! drives through scenes of every kind. A key that counts as read changes a command in one of them.
//! A key that is refused for the law changes none.

use controller::law::{Law, Output};
use controller::laws;
use scenario::schema::{Key, Shape};
use scenario::{Overrides, Scenario};

mod scenes;

use scenes::{Scene, drive, scenes};

/// Laws with the keys that choose a variant, and the vehicle that they drive.
const SUBJECTS: [(&str, &[&str]); 11] = [
    ("acc-mpc", &[]),
    ("acc-mpc", &["controller.spacing_policy=constant-distance"]),
    ("acc-signal-stop", &[]),
    ("cacc-mpc", &[]),
    ("cacc-mpc", &["controller.spacing_policy=measured-headway"]),
    ("six-mode", &[]),
    ("six-mode", &["controller.six_mode.variant=literal"]),
    ("six-mode", &["controller.six_mode.spacing=paper"]),
    ("quadratic-bounded", &[]),
    ("quadratic-bounded", &["controller.quadratic_bounded.gains=printed"]),
    ("predictive", &["plant.vehicle=jh6-49t"]),
];

/// Values with which a key that a law does not read is tried.
const UNREAD_TRIED: usize = 3;

/// Keys whose effect no drive of a law can show: the loop's, the host's and files.
const OUTSIDE: [&str; 8] = [
    "name",
    "command",
    "directory",
    "period_ms",
    "release",
    "deadline_ms",
    "quadratic_bounded.design",
    "spacing_policy",
];

fn open(law: &str, variant: &[&str], key: Option<&str>) -> Option<Scenario> {
    let mut overrides = Overrides::new().shared();
    overrides.option("--controller", "controller.name", law);
    for argument in variant.iter().copied().chain(key) {
        overrides.set(argument.parse().expect("KEY=VALUE"));
    }
    let text = "schema_version = 1\nname = \"keys\"\n";
    Scenario::parse_with("keys", text, &overrides, &laws::check).ok()
}

/// The keys below `[controller]` with their dotted paths.
fn keys() -> Vec<(String, Key)> {
    let scenario = scenario::keys().iter().find(|key| key.name == "controller").cloned();
    let Some(Key { shape: Shape::Table(own), .. }) = scenario else { panic!("a table") };
    let mut all = Vec::new();
    collect("", own, &mut all);
    for table in laws::tables() {
        collect(&format!("{}.", table.name), (table.keys)(), &mut all);
    }
    // The speed in curves acts before every law, on roads with a plan.
    let is_before = |path: &str| path.starts_with("external.") || path.starts_with("curve_speed.");
    all.retain(|(path, _)| !OUTSIDE.contains(&path.as_str()) && !is_before(path));
    all
}

fn collect(prefix: &str, keys: Vec<Key>, into: &mut Vec<(String, Key)>) {
    for key in keys {
        let path = format!("{prefix}{}", key.name);
        match key.shape {
            Shape::Table(below) => collect(&format!("{path}."), below, into),
            Shape::Free => {}
            _ => into.push((path, key)),
        }
    }
}

/// Other values of a key, as they are typed.
fn others(key: &Key) -> Vec<String> {
    match &key.shape {
        Shape::Boolean => vec!["true".into(), "false".into()],
        Shape::Text { words } => words.clone(),
        Shape::Choice(words) => words.iter().map(|word| word.name.clone()).collect(),
        Shape::Number { is_whole, range, .. } => {
            let default = key.default.as_ref();
            let default =
                default.and_then(|value| value.as_float().or(value.as_integer().map(|n| n as f64)));
            let near = default.unwrap_or(100.0);
            let (low, high) = range.unwrap_or((near - 1.0, near + 1.0));
            let values = [
                0.0,
                near * 1.5,
                near * 0.6,
                near + 1.0,
                near - 1.0,
                near * 4.0,
                low,
                high,
                near / 8.0,
            ];
            let typed = |value: f64| match is_whole {
                true => format!("{value:.0}"),
                false => format!("{value:?}"),
            };
            values.into_iter().map(typed).collect()
        }
        _ => Vec::new(),
    }
}

/// Commands of a law, bit by bit.
fn bits(output: &Output) -> Vec<u64> {
    let plan = &output.plan_mps2[..output.plan_len];
    let torque = output.torque.map(|torque| format!("{torque:?}")).unwrap_or_default();
    let shown = torque.bytes().map(u64::from);
    plan.iter()
        .map(|request| request.to_bits())
        .chain([u64::from(output.mode)])
        .chain(shown)
        .collect()
}

/// Requests of a law, scene by scene and step by step, in bits; its bounds come first.
type Record = Vec<Vec<Vec<u64>>>;

fn bounds(law: &dyn Law) -> Vec<u64> {
    let (least, most) = law.request_bounds_mps2();
    vec![least.to_bits(), most.to_bits()]
}

fn record(scenario: &Scenario) -> Record {
    let record_scene = |scene: &Scene| {
        let mut law = laws::build(scenario).expect("it was checked");
        let mut outputs = vec![bounds(law.as_ref())];
        drive(law.as_mut(), scene, |output| {
            outputs.push(bits(output));
            true
        });
        outputs
    };
    scenes().iter().map(record_scene).collect()
}

/// True if the law commands anything else than what was recorded.
fn differs(scenario: &Scenario, recorded: &Record) -> bool {
    scenes().iter().zip(recorded).any(|(scene, recorded)| {
        let mut law = laws::build(scenario).expect("it was checked");
        let mut same = recorded[0] == bounds(law.as_ref());
        let mut step = 1;
        drive(law.as_mut(), scene, |output| {
            same = recorded[step] == bits(output);
            step += 1;
            same
        });
        !same
    })
}

/// Keys that no scene here can show, with the reason.
const RARE: [(&str, &str, &str); 10] = [
    ("acc-signal-stop", "max_request_mps2", "limits road.acceleration_mps2, as for acc-mpc"),
    ("acc-signal-stop", "signal_stop.stop_deceleration_mps2", "acts in the scenario corridor"),
    ("acc-signal-stop", "signal_stop.stop_margin_m", "acts in the scenario corridor"),
    ("predictive", "predictive.follow.free_min_mps2", "acts in the scenario truck-follow"),
    ("predictive", "predictive.bounds.drag_share", "acts in the scenario truck-hills"),
    ("predictive", "predictive.plan.terminal_square", "acts in the scenario truck-hills"),
    ("acc-mpc", "max_request_mps2", "limits road.acceleration_mps2, which bounds the request"),
    ("cacc-mpc", "max_request_mps2", "limits road.acceleration_mps2, which bounds the request"),
    (
        "quadratic-bounded",
        "quadratic_bounded.lead_deceleration_mps2",
        "acts in the fall-back, which the printed gains rarely need",
    ),
    ("cacc-mpc", "road.hysteresis", "acts where two programs cost nearly the same"),
];

/// Keys of one law whose effect is not what its descriptor says.
fn wrong(law: &str, variant: &[&str]) -> Vec<String> {
    let scenario = open(law, variant, None).expect("the variant is right");
    let reads = laws::check(&scenario).expect("it was checked");
    let recorded = record(&scenario);
    let mut wrong = Vec::new();
    let keys = keys();
    // A law has no access to a table that it has not asked for.
    let table = |path: &str| path.split_once('.').map(|(table, _)| format!("{table}."));
    let has_access = |path: &str| {
        let Some(table) = table(path) else { return true };
        keys.iter().any(|(other, _)| other.starts_with(&table) && reads.has(other))
    };
    for (path, key) in keys.iter().filter(|(path, _)| has_access(path)) {
        // Keys that choose the variant stay unchanged.
        let chooses = |argument: &&str| argument.contains(&format!("controller.{path}="));
        let is_rare = RARE.iter().any(|(rare, key, _)| (*rare, *key) == (law, path.as_str()));
        if is_rare || variant.iter().any(chooses) {
            continue;
        }
        // A key that is read may act at a far value only. One that is not read is tried with a few values, for time.
        let tried = if reads.has(path) { usize::MAX } else { UNREAD_TRIED };
        let acts = others(key).iter().take(tried).any(|value| {
            let key = format!("controller.{path}={value}");
            open(law, variant, Some(&key)).is_some_and(|other| differs(&other, &recorded))
        });
        if acts != reads.has(path) {
            wrong.push(format!("{law} {variant:?}: {path} acts: {acts}, read: {}", !acts));
        }
    }
    wrong
}

#[test]
fn a_key_acts_if_and_only_if_the_law_reads_it() {
    let wrong: Vec<_> = std::thread::scope(|scope| {
        let judge = |(law, variant)| scope.spawn(move || wrong(law, variant));
        let judged: Vec<_> = SUBJECTS.into_iter().map(judge).collect();
        judged.into_iter().flat_map(|thread| thread.join().expect("it judges")).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_built_in_scenario_has_a_key_without_effect() {
    for builtin in scenario::builtin::ALL {
        let scenario = Scenario::open(builtin.name, &Overrides::new(), &laws::check);
        let notes = scenario.unwrap_or_else(|error| panic!("{error}")).notes;
        // It serves comparisons: the cars' laws read the headway that stands there.
        let is_for_others = builtin.name == "truck-traffic";
        assert_eq!(notes.is_empty(), !is_for_others, "{}: {notes:?}", builtin.name);
    }
}

fn opened(set: &[&str], law: Option<&str>, is_shared: bool) -> Result<Vec<String>, String> {
    let mut overrides = Overrides::new();
    if is_shared {
        overrides = overrides.shared();
    }
    if let Some(law) = law {
        overrides.option("--controller", "controller.name", law);
    }
    set.iter().for_each(|argument| overrides.set(argument.parse().expect("KEY=VALUE")));
    let opened = Scenario::open("cacc-a", &overrides, &laws::check);
    opened.map(|scenario| scenario.notes).map_err(|error| error.to_string())
}

#[test]
fn a_key_that_was_written_for_this_law_is_refused_where_it_stands() {
    let refused = opened(&["controller.time_headway_s=2"], Some("six-mode"), false);
    let shown = refused.expect_err("six-mode reads no headway of [controller]");
    assert!(shown.contains("--set controller.time_headway_s=2"), "{shown}");
    assert!(shown.contains("no effect with the law `six-mode`") && shown.contains('^'), "{shown}");
    let variant = ["controller.six_mode.variant=literal", "controller.six_mode.dwell_s=1"];
    let shown = opened(&variant, Some("six-mode"), false).expect_err("the literal law has none");
    assert!(shown.contains("dwell_s") && shown.contains("this variant"), "{shown}");
}

#[test]
fn a_file_of_another_law_is_noted_and_runs() {
    let noted = opened(&[], Some("six-mode"), false).expect("the file is for cacc-mpc");
    assert!(
        noted.iter().any(|note| note.contains("no effect with the law `six-mode`")),
        "{noted:?}"
    );
    let shared = opened(&["controller.time_headway_s=2"], Some("six-mode"), true);
    assert!(shared.expect("several laws are driven")[0].contains("time_headway_s"));
}

#[test]
fn keys_of_another_radar_are_refused_or_noted() {
    let radar = "perception.radar.range_sigma_m=0.5";
    let detections = ["perception.ideal=false", "perception.radar.model=detections"];
    let shown =
        opened(&[&detections[..], &[radar]].concat(), None, false).expect_err("no such key");
    assert!(shown.contains("no effect in the radar model `detections`"), "{shown}");
    assert!(opened(&["perception.tracker.coast_s=1"], None, false).is_err());
}
