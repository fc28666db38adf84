//! The scenario file and the messages as data and as pages. `timegap print schema` prints them; a test compares the
//! reference pages of `docs` with this module.

use controller::law::{Descriptor, Figure};
use controller::laws;
use messages::{Element, LAYOUT_VERSION, Layout, TOPICS};
use recorder::schema as layouts;
use scenario::schema::{Key, Shape, Variant};
use serde_json::{Map, Value, json};

/// The keys of a scenario file, with the tables of the laws.
fn keys() -> Vec<Key> {
    let mut keys = scenario::keys().to_vec();
    let of_laws = laws::tables().into_iter().map(|table| {
        let is_its = |law: &&&Descriptor| law.table.is_some_and(|own| own.name == table.name);
        let names = laws::ALL.iter().filter(is_its).map(|law| format!("`{}`", law.name));
        Key {
            name: table.name.to_owned(),
            shape: Shape::Table((table.keys)()),
            expected: None,
            is_required: false,
            default: None,
            meaning: format!("Settings of {}.", names.collect::<Vec<_>>().join(", ")),
        }
    });
    for key in keys.iter_mut().filter(|key| key.name == "controller") {
        if let Shape::Table(own) = &mut key.shape {
            own.extend(of_laws.clone());
        }
    }
    keys
}

/// A JSON Schema of the scenario file, for editors.
pub fn json_schema() -> Value {
    let mut root = table(&keys());
    root["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    root["title"] = json!("timegap scenario");
    root
}

fn table(keys: &[Key]) -> Value {
    let properties: Map<String, Value> =
        keys.iter().map(|key| (key.name.clone(), property(key))).collect();
    let required: Vec<&str> =
        keys.iter().filter(|key| key.is_required).map(|key| key.name.as_str()).collect();
    json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn property(key: &Key) -> Value {
    let mut value = of_shape(&key.shape);
    let meaning = match &key.expected {
        Some(expected) => format!("{} Expected: {expected}.", key.meaning),
        None => key.meaning.clone(),
    };
    value["description"] = json!(meaning);
    if let Some(default) = &key.default {
        value["default"] = json!(default);
    }
    value
}

fn of_shape(shape: &Shape) -> Value {
    match shape {
        Shape::Boolean => json!({ "type": "boolean" }),
        Shape::Number { is_whole, range, .. } => {
            let mut value = json!({ "type": if *is_whole { "integer" } else { "number" } });
            if let Some((least, most)) = range {
                value["minimum"] = json!(least);
                value["maximum"] = json!(most);
            }
            value
        }
        Shape::Text { words } if words.is_empty() => json!({ "type": "string" }),
        Shape::Text { words } => json!({ "enum": words }),
        Shape::List(element) => json!({ "type": "array", "items": of_shape(element) }),
        Shape::Tuple(elements, _) => {
            let prefix: Vec<_> = elements.iter().map(of_shape).collect();
            json!({ "type": "array", "prefixItems": prefix, "items": false })
        }
        Shape::Table(keys) => table(keys),
        Shape::Choice(variants) => {
            let (tables, words): (Vec<_>, Vec<_>) =
                variants.iter().partition(|variant| variant.shape.is_some());
            let words: Vec<_> = words.iter().map(|variant| &variant.name).collect();
            let tables = tables.iter().filter_map(|Variant { name, meaning, shape }| {
                let mut only = json!({ "type": "object", "additionalProperties": false });
                only["properties"] = json!({ (name.as_str()): of_shape(shape.as_ref()?) });
                only["required"] = json!([name]);
                only["description"] = json!(meaning);
                Some(only)
            });
            let mut forms: Vec<_> = tables.collect();
            if !words.is_empty() {
                forms.insert(0, json!({ "enum": words }));
            }
            if forms.len() == 1 { forms.remove(0) } else { json!({ "anyOf": forms }) }
        }
        Shape::Kinds(kinds) => {
            let of_kind = |(name, keys): &(String, Vec<Key>)| {
                let mut value = table(keys);
                value["properties"]["kind"] = json!({ "const": name });
                let required = value["required"].as_array_mut().expect("it was made a list");
                required.insert(0, json!("kind"));
                value
            };
            json!({ "oneOf": kinds.iter().map(of_kind).collect::<Vec<_>>() })
        }
        Shape::Free => json!({ "type": "object" }),
    }
}

pub fn scenario_page() -> String {
    let mut page = Page {
        text: "# Scenario keys\n\nMade by `timegap print reference scenario` from the types that read the file; a test \
               compares. Units are part of the names: `_m`, `_mps`, `_mps2`, `_s`, `_ms`. A value is a number of the \
               range unless its cell says otherwise. A key without a default is either required or absent. For \
               editors: `timegap print schema`.\n"
            .to_owned(),
        known: Vec::new(),
    };
    page.section("", &keys());
    page.text
}

/// Most keys of a table whose rows stand in the table above it.
const FEW: usize = 8;

/// The page of the scenario's keys in the making.
struct Page {
    text: String,
    /// Tables on the page with their paths. A later table with the same keys refers to the first one.
    known: Vec<(String, Vec<Key>)>,
}

impl Page {
    /// A table for the keys of `path`, then the large tables below it.
    fn section(&mut self, path: &str, keys: &[Key]) {
        let heading = if path.is_empty() { "top level".to_owned() } else { format!("`{path}`") };
        self.text +=
            &format!("\n## {heading}\n\nkey | value (default) | meaning\n--- | --- | ---\n");
        let mut below = Vec::new();
        self.rows(path, "", keys, &mut below);
        for (path, keys) in below {
            self.section(&path, &keys);
        }
    }

    /// Rows of the keys below `inner`, a path inside the table at `path`. Small tables follow their key.
    fn rows(&mut self, path: &str, inner: &str, keys: &[Key], below: &mut Vec<(String, Vec<Key>)>) {
        for key in keys {
            let name = join(inner, &key.name);
            let mut value = value(key);
            let mut small = Vec::new();
            for (name, keys) in tables(&name, &key.shape) {
                let whole = join(path, &name);
                if let Some((of, _)) = self.known.iter().find(|(_, known)| *known == keys) {
                    value += &format!(", as `{of}`");
                    continue;
                }
                self.known.push((whole.clone(), keys.clone()));
                let is_small = !path.is_empty()
                    && keys.len() <= FEW
                    && keys.iter().all(|key| tables("", &key.shape).is_empty());
                if is_small {
                    small.push((name, keys));
                } else {
                    below.push((whole, keys));
                }
            }
            if let Some(default) = &key.default {
                value += &format!(" (`{default}`)");
            } else if key.is_required {
                value += ", required";
            }
            let meaning = without_unit(&key.meaning).replace('|', "\\|");
            self.text += &format!("`{name}` | {value} | {meaning}\n");
            for (name, keys) in small {
                self.rows(path, &name, &keys, below);
            }
        }
    }
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

/// The tables that a value holds, with their paths.
fn tables(path: &str, shape: &Shape) -> Vec<(String, Vec<Key>)> {
    match shape {
        Shape::Table(keys) => vec![(path.to_owned(), keys.clone())],
        Shape::List(element) => tables(&format!("{path}[]"), element),
        Shape::Choice(variants) => {
            let of = |Variant { name, shape, .. }: &Variant| {
                shape.as_ref().map(|shape| tables(&join(path, name), shape))
            };
            variants.iter().filter_map(of).flatten().collect()
        }
        Shape::Kinds(kinds) => vec![(path.to_owned(), together(kinds))],
        _ => Vec::new(),
    }
}

/// The accepted values: the range of a number, else type or words.
fn value(key: &Key) -> String {
    let expected = key.expected.as_deref().unwrap_or_default();
    match (&key.shape, range(expected)) {
        (Shape::Number { is_whole: true, .. }, Some(range)) => format!("whole, {range}"),
        (Shape::Number { .. }, Some(range)) => range,
        (shape, _) if expected.is_empty() => kind(shape),
        (shape, _) => format!("{}: {expected}", kind(shape)),
    }
}

/// "a time from 0 to 86400 s, without a sign" as "0..86400 s".
fn range(expected: &str) -> Option<String> {
    let words = expected.split(',').next()?;
    if let Some((_, ends)) = words.split_once(" above ") {
        return ends.split_once(" and at most ").map(|(low, high)| format!("above {low}..{high}"));
    }
    let (low, high) = words.split_once(" from ")?.1.split_once(" to ")?;
    Some(format!("{low}..{high}"))
}

/// The meaning without the unit at its end: the key's name has it.
fn without_unit(meaning: &str) -> String {
    const UNITS: [&str; 8] = ["m", "m/s", "m/s²", "m/s³", "s", "ms", "dB", "degrees"];
    let bare = UNITS.iter().find_map(|unit| meaning.strip_suffix(&format!(", {unit}.")));
    bare.map_or_else(|| meaning.to_owned(), |bare| format!("{bare}."))
}

/// The keys of all kinds as one table; a key that some kinds lack names its kinds.
fn together(kinds: &[(String, Vec<Key>)]) -> Vec<Key> {
    let mut all: Vec<(Key, Vec<&str>)> = Vec::new();
    for (kind, keys) in kinds {
        for key in keys {
            match all.iter_mut().find(|(known, _)| known == key) {
                Some((_, of)) => of.push(kind),
                None => all.push((key.clone(), vec![kind])),
            }
        }
    }
    let words = kinds.iter().map(|(kind, _)| kind.clone()).collect();
    let kind = Key {
        name: "kind".into(),
        shape: Shape::Text { words },
        expected: None,
        is_required: true,
        default: None,
        meaning: "Kind of the fault.".into(),
    };
    let of_some = |(key, of): (Key, Vec<&str>)| {
        let meaning = match of.len() == kinds.len() {
            true => key.meaning,
            false => format!("`{}`: {}", of.join("`, `"), key.meaning),
        };
        Key { meaning, ..key }
    };
    std::iter::once(kind).chain(all.into_iter().map(of_some)).collect()
}

fn kind(shape: &Shape) -> String {
    match shape {
        Shape::Boolean => "boolean".into(),
        Shape::Number { is_whole: true, .. } => "whole number".into(),
        Shape::Number { is_whole: false, .. } => "number".into(),
        Shape::Text { words } if words.is_empty() => "text".into(),
        Shape::Text { words } => {
            words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
        }
        Shape::List(element) => format!("list of {}", kind(element)),
        Shape::Tuple(elements, _) => {
            format!("[{}]", elements.iter().map(kind).collect::<Vec<_>>().join(", "))
        }
        Shape::Table(_) | Shape::Kinds(_) | Shape::Free => "table".into(),
        Shape::Choice(variants) => {
            let names: Vec<_> =
                variants.iter().map(|variant| format!("`{}`", variant.name)).collect();
            names.join(", ")
        }
    }
}

pub fn messages_page() -> String {
    let mut page = format!(
        "# Messages\n\nMade by `timegap print reference messages` from the structs themselves; a test \
         compares. Layout version {LAYOUT_VERSION}; all fields are little-endian without padding. A number before a \
         field is its offset in bytes. A message of a topic without a row at offset 0 begins with a [Header](#header). \
         For Python and C: `timegap print layouts`.\n\ntopic | message | bytes | sent by | read by\n\
         --- | --- | --- | --- | ---\n"
    );
    for topic in TOPICS {
        let from = names(topic.sources(), "every service");
        let to = names(topic.consumers(), "recorder and launcher");
        let (message, bytes) = (link(topic.layout()), topic.message_bytes());
        page += &format!("`{}` | {message} | {bytes} | {from} | {to}\n", topic.name());
    }
    for layout in layouts::all() {
        structure(&mut page, layout);
    }
    figures(&mut page);
    page
}

/// Meaning and sign of the laws' figures. Laws of one formulation share a row.
fn figures(page: &mut String) {
    page.push_str(
        "\n## Figures of the laws\n\nEntries of `figures` of the diagnostics, and columns of `trajectory.csv`. Their \
         signs are those of each law's source. In `summary.json`, `final_gap_error_m` is the real minus the desired \
         gap for every law (negative: too close), and the jerks leave out the step of the acceleration at which the \
         ego comes to a stand.\n\nlaw | formulation | figures\n--- | --- | ---\n",
    );
    let mut rows: Vec<(Vec<String>, String)> = Vec::new();
    for law in laws::ALL {
        let of = format!("`{}`", law.name);
        for formulation in law.formulations {
            let figures: Vec<String> = formulation.figures.iter().map(figure).collect();
            let row = format!("{} | {}", formulation.name, figures.join("; "));
            match rows.iter_mut().find(|(_, known)| *known == row) {
                Some((laws, _)) => laws.push(of.clone()),
                None => rows.push((vec![of.clone()], row)),
            }
        }
    }
    for (laws, row) in rows {
        *page += &format!("{} | {row}\n", laws.join(", "));
    }
}

fn figure(Figure { name, meaning, .. }: &Figure) -> String {
    if meaning.is_empty() { format!("`{name}`") } else { format!("`{name}`: {meaning}") }
}

fn link(layout: &Layout) -> String {
    format!("[{}](#{})", layout.name, layout.name.to_lowercase())
}

fn names(services: &[messages::Service], none: &str) -> String {
    let names: Vec<_> = services.iter().map(|service| service.name()).collect();
    if names.is_empty() { none.into() } else { names.join(", ") }
}

fn structure(page: &mut String, layout: &Layout) {
    let (name, bytes) = (layout.name, layout.bytes);
    *page += &format!("\n## {name}\n\n{bytes} bytes.\n\nfield | type | meaning\n--- | --- | ---\n");
    // The head of the page describes the header once.
    let fields = layout.fields.iter().filter(|field| field.meaning() != "Common header.");
    for field in fields {
        let element = match field.shape.element {
            Element::Struct(inner) => link(inner),
            scalar => scalar.name().to_owned(),
        };
        let count = field.shape.len.map_or_else(String::new, |len| format!("×{len}"));
        let (offset, name, meaning) = (field.offset, field.name, field.meaning());
        *page += &format!("{offset} `{name}` | {element}{count} | {meaning}\n");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_has_ranges_words_and_tables() {
        let schema = json_schema();
        let period = &schema["properties"]["plant"]["properties"]["period_ms"];
        assert_eq!((&period["minimum"], &period["maximum"]), (&json!(1.0), &json!(10_000.0)));
        assert_eq!(period["default"], 10);
        let profile = &schema["properties"]["actors"]["items"]["properties"]["profile"];
        assert!(
            profile["anyOf"].as_array().is_some_and(|variants| variants.len() > 4),
            "{profile}"
        );
        let faults = &schema["properties"]["faults"]["items"]["oneOf"];
        let kill = faults.as_array().and_then(|kinds| kinds.first()).expect("kinds of faults");
        assert_eq!(kill["properties"]["kind"]["const"], "kill");
        assert_eq!(
            (&kill["required"], &kill["properties"]["for_s"]),
            (&json!(["kind", "service"]), &json!(null))
        );
        assert_eq!(schema["additionalProperties"], false);
        let six_mode = &schema["properties"]["controller"]["properties"]["six_mode"]["properties"];
        assert_eq!(six_mode["variant"]["enum"], json!(["literal", "robust"]));
        assert_eq!(
            (&six_mode["dwell_s"]["maximum"], &six_mode["dwell_s"]["default"]),
            (&json!(10.0), &json!(0.8))
        );
    }

    /// Follows the keys of `value` through the schema, except through alternative forms.
    fn known(schema: &Value, value: &Value, path: &str) {
        for (index, element) in value.as_array().into_iter().flatten().enumerate() {
            known(&schema["items"], element, &format!("{path}[{index}]"));
        }
        let (Some(entries), Some(properties)) =
            (value.as_object(), schema["properties"].as_object())
        else {
            return;
        };
        for (key, value) in entries {
            let path = format!("{path}.{key}");
            let below =
                properties.get(key).unwrap_or_else(|| panic!("{path} is not in the schema"));
            known(below, value, &path);
        }
    }

    #[test]
    fn the_schema_has_every_key_of_the_built_in_scenarios() {
        let schema = json_schema();
        for builtin in scenario::builtin::ALL {
            let text: toml::Table = builtin.text.parse().expect("it is TOML");
            known(&schema, &serde_json::to_value(text).expect("plain data"), builtin.name);
        }
    }
}
