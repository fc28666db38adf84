//! A fault as it stands in a file: one table, whose keys depend on its `kind`.

use serde::{Deserialize, Deserializer};

use super::{
    Begin, BiasedField, ChannelFault, Disturbance, Effect, Extent, Falsification, Fault, Kind,
    MAX_FAULTS, ProcessFault, SenderFault, TopicName,
};
use crate::keys::{Keys, Written};
use crate::placed::Placed;
use crate::problem::Problem;
use crate::quantity::{Count, DelayMs, Probability, Time};

/// Takes the list of faults out of a document.
pub(crate) fn take_from(root: &mut Placed) -> Option<Placed> {
    root.remove("faults")
}

/// The faults of a document's list.
///
/// # Errors
/// The first thing that is wrong, with its place.
pub(crate) fn written(list: Option<&Placed>) -> Result<Vec<Fault>, Problem> {
    let Some(list) = list else { return Ok(Vec::new()) };
    let Some(faults) = list.elements() else {
        return Err(Problem::new("faults", "faults are a list", "[[faults]]").at(list.place()));
    };
    if faults.len() > MAX_FAULTS {
        let message = format!("{} faults", faults.len());
        let problem = Problem::new("faults", message, format!("at most {MAX_FAULTS}"));
        return Err(problem.at(list.place()));
    }
    let fault = |(i, table)| of_table(table, &format!("faults.{i}"));
    faults.iter().enumerate().map(fault).collect()
}

/// A fault from its keys.
///
/// # Errors
/// The first thing that is wrong; its path is `fault.` and the key.
pub fn read(keys: toml::Table) -> Result<Fault, Problem> {
    of_table(&Placed::at(toml::Value::Table(keys), &(0..0)), "fault")
}

/// The fault of a table, whose place in the document is `path`.
///
/// # Errors
/// The first thing that is wrong.
pub(crate) fn of_table(table: &Placed, path: &str) -> Result<Fault, Problem> {
    let mut keys = Written::new(table, path, "a fault")?;
    let kind: Kind = keys.required("kind")?;
    keys.describe(format!("a fault of kind `{kind}`"));
    let fault = keys_of(kind, &mut keys)?;
    keys.finish()?;
    Ok(fault)
}

/// A fault of that kind from its other keys.
///
/// # Errors
/// The first key that is missing or wrong.
pub(crate) fn keys_of(kind: Kind, keys: &mut impl Keys) -> Result<Fault, Problem> {
    Ok(Fault { effect: effect(kind, keys)?, begin: begin(keys)? })
}

fn begin(keys: &mut impl Keys) -> Result<Begin, Problem> {
    let (at_s, when) = (keys.optional("at_s")?, keys.optional("when")?);
    if at_s.is_some() && when.is_some() {
        let expected = "one of `at_s` and `when`".to_owned();
        keys.refuse("when", "the fault has a time and a condition", expected)?;
    }
    let at = Begin::At { at_s: at_s.unwrap_or(Time::of(0.0)) };
    Ok(when.map_or(at, |when| Begin::When { when }))
}

fn effect(kind: Kind, keys: &mut impl Keys) -> Result<Effect, Problem> {
    Ok(match kind {
        Kind::Kill => Effect::Process(ProcessFault::Kill { service: keys.required("service")? }),
        Kind::Stop => Effect::Process(ProcessFault::Stop {
            service: keys.required("service")?,
            for_s: keys.optional("for_s")?,
        }),
        Kind::RestartStorm => Effect::Process(ProcessFault::RestartStorm {
            service: keys.required("service")?,
            times: keys.or("times", Count::of(3))?,
            after_start_ms: keys.optional("after_start_ms")?,
        }),
        Kind::KillHelper => {
            Effect::Process(ProcessFault::KillHelper { helper: keys.required("helper")? })
        }
        Kind::Hog => Effect::Process(ProcessFault::Hog {
            core: keys.optional("core")?,
            for_s: keys.optional("for_s")?,
        }),
        Kind::Memory => Effect::Process(ProcessFault::Memory {
            megabytes: keys.required("megabytes")?,
            for_s: keys.optional("for_s")?,
        }),
        Kind::Delay => {
            let delay_ms = keys.required("delay_ms")?;
            let jitter_ms = keys.or("jitter_ms", DelayMs::of(0))?;
            channel(Disturbance::Delay { delay_ms, jitter_ms }, keys)?
        }
        Kind::Drop => channel(Disturbance::Drop, keys)?,
        Kind::Duplicate => channel(Disturbance::Duplicate, keys)?,
        Kind::Reorder => channel(Disturbance::Reorder, keys)?,
        Kind::Corrupt => {
            let bits = keys.or("bits", Count::of(1))?;
            channel(Disturbance::Corrupt { bits }, keys)?
        }
        Kind::Freeze => sender(Falsification::Freeze { topic: keys.required("topic")? }, keys)?,
        Kind::Bias => {
            let (field, amount) = (biased_field(keys)?, keys.required("amount")?);
            sender(Falsification::Bias { field, amount }, keys)?
        }
        Kind::Stale => {
            let (topic, amount) = (keys.required("topic")?, keys.required("amount")?);
            sender(Falsification::Stale { topic, amount }, keys)?
        }
        Kind::ClockStep => {
            let (service, amount) = (keys.required("service")?, keys.required("amount")?);
            sender(Falsification::ClockStep { service, amount }, keys)?
        }
    })
}

fn channel(disturbance: Disturbance, keys: &mut impl Keys) -> Result<Effect, Problem> {
    let topic = keys.required("topic")?;
    Ok(Effect::Channel(ChannelFault { disturbance, topic, extent: extent(keys)? }))
}

fn sender(falsification: Falsification, keys: &mut impl Keys) -> Result<Effect, Problem> {
    Ok(Effect::Sender(SenderFault { falsification, extent: extent(keys)? }))
}

fn extent(keys: &mut impl Keys) -> Result<Extent, Problem> {
    let probability = keys.or("probability", Probability::of(1.0))?;
    Ok(Extent { probability, for_s: keys.optional("for_s")? })
}

/// The field says which topic it is of; the file says it, too, and must agree.
fn biased_field(keys: &mut impl Keys) -> Result<BiasedField, Problem> {
    let (topic, field): (TopicName, BiasedField) =
        (keys.required("topic")?, keys.required("field")?);
    if field.topic() != topic.0 {
        let message = format!("{} has no such figure", topic.0.name());
        let expected = format!("a figure of that topic, or topic = \"{}\"", field.topic().name());
        keys.refuse("field", &message, expected)?;
    }
    Ok(field)
}

impl<'de> Deserialize<'de> for Fault {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keys = toml::Table::deserialize(deserializer)?;
        read(keys).map_err(|problem| {
            serde::de::Error::custom(format!("{}, expected {}", problem.message, problem.expected))
        })
    }
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

    /// One fault of each kind, with every key that it knows.
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
    fn each_kind_is_read_and_written_back_in_files_in_bytes_and_in_json() {
        for (fault, kind) in EACH.into_iter().zip(Kind::ALL) {
            let scenario = Scenario::parse("x.toml", &text(fault)).expect("it is right");
            assert_eq!(scenario.faults[0].effect.kind(), kind);
            let again = Scenario::parse("again.toml", &scenario.to_toml()).expect("it was written");
            assert_eq!(again.faults, scenario.faults, "{}", scenario.to_toml());
            let bytes = scenario.faults[0].to_bytes();
            assert_eq!(Fault::from_bytes(&bytes).as_ref(), Ok(&scenario.faults[0]));
            let json = serde_json::to_string(&scenario.faults[0]).expect("plain data");
            assert_eq!(serde_json::from_str::<Fault>(&json).expect(&json), scenario.faults[0]);
        }
    }

    #[test]
    fn what_is_wrong_is_shown_at_its_key() {
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
