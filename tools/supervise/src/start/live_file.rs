//! `live.json`: the needs of another program that joins a run and reads its messages.

use controller::laws;
use messages::level::Level;
use messages::{Element, LAYOUT_VERSION, Layout, TOPICS};
use runtime::{Group, monotonic_ns};
use scenario::Scenario;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::SystemTime;

/// The file, there for as long as this lives.
#[derive(Debug)]
pub struct LiveFile<'a>(&'a Path);

#[derive(Serialize)]
struct Live<'a> {
    /// Root, prefix, clock and periods of the group.
    #[serde(flatten)]
    group: &'a Group,
    /// Run time 0 in `CLOCK_MONOTONIC` ns. In lockstep all stamps are simulated time, which begins here.
    start_monotonic_ns: i64,
    /// Run time 0 in ns since 1970.
    started_unix_ns: i64,
    layout_version: &'static str,
    /// Type and sender of each topic.
    topics: Map<String, Value>,
    /// Fields of each type: type, offset and meaning.
    types: Map<String, Value>,
    /// Meaning of the numbers in the messages.
    names: Value,
}

impl<'a> LiveFile<'a> {
    /// Writes the file of a group whose run time began at `start_ns`.
    pub fn write(path: &'a Path, group: &Group, scenario: &Scenario, start_ns: i64) -> Self {
        let since_1970 =
            SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let now_unix_ns = i64::try_from(since_1970.as_nanos()).unwrap_or(0);
        let live = Live {
            group,
            start_monotonic_ns: start_ns,
            started_unix_ns: now_unix_ns - (monotonic_ns() - start_ns),
            layout_version: LAYOUT_VERSION,
            topics: topics(scenario),
            types: types(),
            names: names(scenario),
        };
        let text = serde_json::to_string_pretty(&live).expect("plain data");
        // Written aside and renamed: a reader finds all of it or none.
        let half = path.with_extension("json.new");
        if let Err(error) = std::fs::write(&half, text).and_then(|()| std::fs::rename(&half, path))
        {
            tracing::warn!("cannot write {}: {error}", path.display());
            // It may never have been made.
            let _ = std::fs::remove_file(&half);
        }
        Self(path)
    }
}

impl Drop for LiveFile<'_> {
    fn drop(&mut self) {
        // It may never have been written.
        let _ = std::fs::remove_file(self.0);
    }
}

fn topics(scenario: &Scenario) -> Map<String, Value> {
    let services = scenario.services();
    let entry = |topic: messages::Topic| {
        let value = json!({
            "type": topic.layout().type_name,
            "struct": topic.layout().name,
            "bytes": topic.message_bytes(),
            "sender": topic.source(&services).map(messages::Service::name),
        });
        (topic.name().to_owned(), value)
    };
    TOPICS.into_iter().map(entry).collect()
}

fn types() -> Map<String, Value> {
    let mut types = Map::new();
    TOPICS.into_iter().for_each(|topic| collect(topic.layout(), &mut types));
    types
}

fn collect(layout: &'static Layout, types: &mut Map<String, Value>) {
    if types.contains_key(layout.name) {
        return;
    }
    let fields = layout.fields.iter().map(|field| {
        if let Element::Struct(inner) = field.shape.element {
            collect(inner, types);
        }
        json!({
            "name": field.name,
            "offset": field.offset,
            "type": field.shape.element.name(),
            "length": field.shape.len,
            "meaning": field.meaning(),
        })
    });
    let fields: Vec<Value> = fields.collect();
    types.insert(layout.name.to_owned(), json!({ "bytes": layout.bytes, "fields": fields }));
}

/// The words behind the numbers in `control/diagnostics` and `health/heartbeat`.
fn names(scenario: &Scenario) -> Value {
    let law = laws::formulation(scenario);
    let figures = law.map_or(&[][..], |law| law.figures);
    let figures: Vec<_> =
        figures.iter().map(|figure| json!({ "name": figure.name, "unit": figure.unit })).collect();
    let levels: Map<_, _> = (Level::ALL.into_iter())
        .map(|level| ((level as u32).to_string(), json!(level.name())))
        .collect();
    json!({
        "mode": law.map_or(&[][..], |law| law.modes),
        "mode_reason": law.map_or(&[][..], |law| law.reasons),
        "figures": figures,
        "quality": ["full", "relaxed", "backup", "fall-back"],
        "rung": levels,
    })
}
