//! Requests of a viewer to a run: its keys as parameters, and a service that injects faults.

use crate::protocol::{Answer, Parameter, SERVICE};
use scenario::faults::{self, Kind, keys_of};
use scenario::schema::Shape;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use supervise::control;

/// Name of the service, and of its type.
const NAME: &str = "/timegap/inject";

/// Announces the service: a request is a fault, with the keys that it has in a scenario's file.
pub(crate) fn announcement() -> String {
    let answer = json!({
        "title": "timegap.Answer",
        "type": "object",
        "properties": { "ok": { "type": "boolean" }, "message": { "type": "string" } },
    });
    let [request, response] = [request_schema(), answer].map(|schema| {
        json!({
            "encoding": "json",
            "schemaName": schema["title"],
            "schemaEncoding": "jsonschema",
            "schema": schema.to_string(),
        })
    });
    let service = json!({
        "id": SERVICE, "name": NAME, "type": NAME, "request": request, "response": response,
    });
    json!({ "op": "advertiseServices", "services": [service] }).to_string()
}

fn request_schema() -> Value {
    let mut properties = BTreeMap::new();
    for key in Kind::ALL.into_iter().flat_map(keys_of) {
        let type_name = match key.shape {
            Shape::Number { is_whole: true, .. } => "integer",
            Shape::Number { .. } => "number",
            Shape::Boolean => "boolean",
            _ => "string",
        };
        let entry = json!({ "type": type_name, "description": key.meaning });
        properties.entry(key.name).or_insert(entry);
    }
    properties.insert("kind".to_owned(), json!({ "enum": Kind::ALL.map(Kind::name) }));
    json!({
        "title": "timegap.Fault",
        "type": "object",
        "properties": properties,
        "required": ["kind"],
        "additionalProperties": false,
    })
}

/// Hands faults to the run at `root`.
pub(crate) fn injector(root: PathBuf) -> Answer {
    Box::new(move |request| {
        let keys = serde_json::from_slice::<toml::Table>(request);
        let keys = keys.map_err(|why| format!("not a fault: {why}, expected its keys in JSON"))?;
        let fault = faults::read(keys).map_err(|why| why.to_string())?;
        let answer = control::inject(&root, &fault).map_err(|why| format!("the run: {why}"))?;
        if answer.ok {
            Ok(serde_json::to_vec(&answer).expect("plain data"))
        } else {
            Err(answer.message)
        }
    })
}

/// The keys of a scenario, each with its path: `controller.name`, `actors.0.gap_m`.
pub(crate) fn parameters(scenario: &str) -> Vec<Parameter> {
    let mut found = Vec::new();
    let keys = scenario.parse::<toml::Table>().unwrap_or_default();
    flatten(String::new(), &json!(keys), &mut found);
    found
}

fn flatten(path: String, value: &Value, into: &mut Vec<Parameter>) {
    let below = |name: &str| match path.is_empty() {
        true => name.to_owned(),
        false => format!("{path}.{name}"),
    };
    match value {
        Value::Object(keys) => keys.iter().for_each(|(key, v)| flatten(below(key), v, into)),
        Value::Array(list) if list.iter().any(|one| one.is_object() || one.is_array()) => {
            list.iter().enumerate().for_each(|(i, v)| flatten(below(&i.to_string()), v, into));
        }
        value => into.push((path, value.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_their_paths() {
        let keys =
            "seed = 3\n[controller]\nname = \"acc-mpc\"\n[[actors]]\ngap_m = 40.0\nat = [1, 2]";
        let found = parameters(keys);
        let of = |name: &str| found.iter().find(|one| one.0 == name).map(|one| &one.1);
        assert_eq!(of("controller.name"), Some(&json!("acc-mpc")));
        assert_eq!(of("actors.0.gap_m"), Some(&json!(40.0)));
        assert_eq!(of("actors.0.at"), Some(&json!([1, 2])));
        assert_eq!(found.len(), 4);
    }

    #[test]
    fn a_request_that_is_no_fault_is_refused_with_what_was_expected() {
        let inject = injector(PathBuf::from("/nowhere"));
        for (request, what) in [
            (&b"{"[..], "not a fault"),
            (b"[1]", "not a fault"),
            (b"\xff", "not a fault"),
            (br#"{"kind":"dorp","topic":"radar/tracks"}"#, "fault.kind"),
            (br#"{"kind":"drop","topic":"radar"}"#, "fault.topic"),
            (br#"{"kind":"drop"}"#, "topic"),
            (br#"{"kind":"drop","topic":"radar/tracks","for_s":-2}"#, "for_s"),
            (br#"{"kind":"drop","topic":"radar/tracks"}"#, "the run: "),
        ] {
            let said = inject(request).expect_err("it is none");
            assert!(said.contains(what), "{}: {said}", String::from_utf8_lossy(request));
        }
    }

    #[test]
    fn the_service_names_every_kind_and_every_key() {
        let schema = request_schema();
        let kinds = schema["properties"]["kind"]["enum"].as_array().expect("a list");
        assert!(kinds.contains(&json!("drop")) && kinds.len() == Kind::ALL.len());
        assert_eq!(schema["properties"]["for_s"]["type"], "number", "{schema}");
        assert_eq!(schema["properties"]["topic"]["type"], "string");
    }
}
