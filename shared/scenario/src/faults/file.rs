//! A fault as it stands in a file: one table, whose keys depend on its `kind`.

use toml::Value;

use super::{
    Begin, Disturbance, Effect, Extent, Falsification, Fault, Kind, MAX_FAULTS, ProcessFault,
    SenderFault, TopicName,
};
use crate::quantity::Time;
use crate::reading::{self, Problem, refuse};
use crate::schema::{self, Key, Schema, Shape};

/// Takes the list of faults out of the keys of a scenario, whose form was checked.
pub(crate) fn take_from(keys: &mut Value) -> Result<Vec<Fault>, Problem> {
    let list = keys.as_table_mut().and_then(|keys| keys.remove("faults"));
    let Some(Value::Array(list)) = list else { return Ok(Vec::new()) };
    let count = list.len();
    refuse!(if count > MAX_FAULTS, "faults": "{count} faults", "at most {MAX_FAULTS}");
    let fault = |(i, keys)| of_keys(keys, &format!("faults.{i}"));
    list.into_iter().enumerate().map(fault).collect()
}

/// A fault from its keys.
///
/// # Errors
/// The first error; its path is `fault`, or `fault.` and the key.
pub fn read(keys: toml::Table) -> Result<Fault, Problem> {
    let keys = Value::Table(keys);
    reading::check_form::<Fault>(&keys, "fault")?;
    of_keys(keys, "fault")
}

/// The fault of a table that has the form of one.
fn of_keys(keys: Value, path: &str) -> Result<Fault, Problem> {
    let mut fault: Fault = reading::plain(keys, path)?;
    let begin = &mut fault.begin;
    refuse!(if begin.at_s.is_some() && begin.when.is_some(),
        "{path}.when": "the fault has a time and a condition", "one of `at_s` and `when`");
    if begin.when.is_none() {
        begin.at_s.get_or_insert(Time::of(0.0));
    }
    if let Effect::Sender(SenderFault {
        falsification: Falsification::Bias { topic, field, .. },
        ..
    }) = &fault.effect
    {
        let (own, other) = (topic.0.name(), field.topic().name());
        refuse!(if own != other, "{path}.field": "{own} has no such figure",
            "a figure of that topic, or topic = \"{other}\"");
    }
    Ok(fault)
}

/// The keys of a fault of that kind beside `kind`, with their ranges. They serve a reference, or a search over faults.
///
/// ```
/// use scenario::faults::{Kind, keys_of};
/// use scenario::schema::Shape;
///
/// let keys = keys_of(Kind::Delay);
/// let Shape::Number { range, unit, .. } = keys[0].shape else { panic!("a number") };
/// assert_eq!((keys[0].name.as_str(), range, unit), ("delay_ms", Some((0.0, 10_000.0)), "ms"));
/// ```
pub fn keys_of(kind: Kind) -> Vec<Key> {
    let own = |family: Shape| {
        let Shape::Choice(variants) = family else { return None };
        let variant = variants.into_iter().find(|variant| variant.name == kind.name())?;
        match variant.shape {
            Some(Shape::Table(keys)) => Some(keys),
            _ => None,
        }
    };
    let extent = schema::keys_of::<Extent>;
    let topic = || Key::of::<TopicName>("topic", "The topic whose messages it acts on.", None);
    let of_channel = |own: Vec<Key>| own.into_iter().chain([topic()]).chain(extent()).collect();
    let of_sender = |own: Vec<Key>| own.into_iter().chain(extent()).collect();
    let keys: Option<Vec<Key>> = own(ProcessFault::shape())
        .or_else(|| own(Disturbance::shape()).map(of_channel))
        .or_else(|| own(Falsification::shape()).map(of_sender));
    keys.into_iter().flatten().chain(schema::keys_of::<Begin>()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    const HEAD: &str = "schema_version = 1\nname = \"faulty\"\n";

    fn text(fault: &str) -> String {
        format!("{HEAD}[[faults]]\n{fault}\n")
    }

    fn refusal(fault: &str) -> String {
        Scenario::parse("x.toml", &text(fault)).expect_err(fault).to_string()
    }

    /// One fault of each kind, with every key that it has.
    const EACH: [&str; Kind::ALL.len()] = [
        "kind = \"kill\"\nservice = \"plant\"\nat_s = 1",
        "kind = \"stop\"\nservice = \"plant\"\nfor_s = 0.5",
        "kind = \"restart-storm\"\nservice = \"controller\"\ntimes = 4\nafter_start_ms = 3",
        "kind = \"kill-helper\"\nhelper = \"janitor\"\nat_s = 2",
        "kind = \"hog\"\ncore = 1\nfor_s = 2",
        "kind = \"memory\"\nmegabytes = 64\nfor_s = 2",
        "kind = \"delay\"\ntopic = \"v2x/map\"\ndelay_ms = 20\njitter_ms = 5\nprobability = 0.5",
        "kind = \"drop\"\ntopic = \"v2x/spat\"\nfor_s = 2",
        "kind = \"duplicate\"\ntopic = \"v2x/spat\"",
        "kind = \"reorder\"\ntopic = \"v2x/spat\"\nwhen = { speed_below_mps = 3 }",
        "kind = \"corrupt\"\ntopic = \"control/command\"\nbits = 3",
        "kind = \"freeze\"\ntopic = \"radar/tracks\"",
        "kind = \"bias\"\ntopic = \"radar/tracks\"\nfield = \"gap_m\"\namount = -3.5",
        "kind = \"stale\"\ntopic = \"v2x/spat\"\namount = 1.5",
        "kind = \"clock-step\"\nservice = \"perception-sim\"\namount = -1",
    ];

    #[test]
    fn each_kind_is_read_and_written_back_in_files_and_in_json() {
        for (fault, kind) in EACH.into_iter().zip(Kind::ALL) {
            let scenario = Scenario::parse("x.toml", &text(fault)).expect("it is right");
            assert_eq!(scenario.faults[0].effect.kind(), kind);
            let again = Scenario::parse("again.toml", &scenario.to_toml()).expect("it was written");
            assert_eq!(again.faults, scenario.faults, "{}", scenario.to_toml());
            let json = serde_json::to_string(&scenario.faults[0]).expect("plain data");
            assert_eq!(serde_json::from_str::<Fault>(&json).expect(&json), scenario.faults[0]);
        }
    }

    #[test]
    fn a_mistake_is_shown_at_its_key() {
        for (fault, place, what) in [
            ("kind = \"kill\"", "x.toml:3:1", "a fault of kind `kill` needs `service`"),
            ("service = \"plant\"", "x.toml:3:1", "a fault needs `kind`"),
            ("kind = \"melt\"", "x.toml:4:8", "`clock-step`"),
            ("kind = \"kill\"\nservice = \"radar\"", "x.toml:5:11", "`perception-sim`"),
            ("for_s = 2\nkind = \"kill\"\nservice = \"plant\"", "x.toml:4:1", "kind `kill`"),
            (
                "kind = \"drop\"\ntopic = \"v2x/spat\"\nbits = 1",
                "x.toml:6:1",
                "`topic`, `probability`",
            ),
            ("kind = \"hog\"\nservcie = \"plant\"", "x.toml:5:1", "`kind`, `core`, `for_s`"),
            ("kind = \"hog\"\nfor_s = 0", "x.toml:5:9", "0 is out of range"),
            ("kind = \"drop\"\ntopic = \"health/heartbeat\"", "x.toml:5:9", "radar/tracks"),
            ("kind = \"hog\"\nat_s = 1\nwhen = { speed_below_mps = 1 }", "x.toml:6:8", "`at_s`"),
            ("kind = \"hog\"\nwhen = { speed_under_mps = 1 }", "x.toml:5:10", "speed_below_mps"),
            (
                "kind = \"bias\"\ntopic = \"v2x/spat\"\nfield = \"gap_m\"\namount = 1",
                "x.toml:6:9",
                "topic = \"radar/tracks\"",
            ),
        ] {
            let shown = refusal(fault);
            assert!(
                shown.contains(place) && shown.contains(what) && shown.contains('^'),
                "{shown}"
            );
        }
        let shown = Scenario::parse("x.toml", &format!("{HEAD}faults = 3\n")).expect_err("no list");
        assert!(shown.to_string().contains("x.toml:3:10"), "{shown}");
        let many = text(EACH[0]).replacen("[[faults]]", "", 1);
        let one = many.trim_start_matches(HEAD);
        let many = format!("{HEAD}{}", format!("[[faults]]\n{one}").repeat(MAX_FAULTS + 1));
        let shown = Scenario::parse("x.toml", &many).expect_err("too many");
        assert!(shown.to_string().contains("at most 64"), "{shown}");
    }
}
