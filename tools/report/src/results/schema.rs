//! JSON Schema of results, from the types that are written as JSON.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::column::Column;
use super::head::{Format, Head, Kind};

/// Any object, in the schema of a result whose parts another crate declares.
pub type Object = Map<String, Value>;

/// Contents of a command's JSON.
///
/// ```
/// use report::results::{Column, Schema, check, flag, number, word};
/// use serde_json::{Value, json};
///
/// const FIELDS: &[Column<()>] = &[flag("ok", "", ("ok", "BROKEN"), "Every law kept its gap")];
/// const ROWS: &[Column<()>] = &[
///     word("law", "law", "Control law"),
///     number("gap_m", "gap", "m", 1, "Smallest gap"),
/// ];
/// let schema = Schema::new("gaps", "Gaps of the laws").fields(FIELDS).rows("rows", "The laws", ROWS).json();
/// let result = json!({"schema_version": 1, "ok": true, "rows": [{"law": "acc-mpc", "gap_m": null}]});
/// assert_eq!(check(&schema, &result), [""; 0]);
/// let wrong = json!({"schema_version": 1, "ok": true, "rows": [{"law": 7, "gap_m": 1.0}]});
/// assert_eq!(check(&schema, &wrong), ["rows.0.law: 7 is not of type string"]);
/// ```
#[derive(Clone, Debug)]
pub struct Schema {
    command: &'static str,
    root: Value,
}

impl Schema {
    /// The schema of a command's result, which has its version so far.
    pub fn new(command: &'static str, meaning: &str) -> Self {
        let version = json!({"const": 1, "description": "Version of these names"});
        let root = json!({
            "type": "object",
            "description": meaning,
            "properties": {"schema_version": version},
            "required": ["schema_version"],
        });
        Self { command, root }
    }

    /// The schema of the results of type `T`, which `command` writes. Doc comments are its descriptions. A field of
    /// another crate's type is [`Object`] in it: `#[schemars(with = "Object")]`.
    ///
    /// ```
    /// use report::results::{Object, Schema};
    ///
    /// /// Gaps of the laws.
    /// #[derive(serde::Serialize, schemars::JsonSchema)]
    /// struct Gaps {
    ///     schema_version: u32,
    ///     /// Every law kept its gap.
    ///     ok: bool,
    ///     /// Verdict of each law.
    ///     rows: Vec<Row>,
    /// }
    ///
    /// #[derive(serde::Serialize, schemars::JsonSchema)]
    /// struct Row {
    ///     /// Smallest gap, m.
    ///     gap_m: Option<f64>,
    ///     /// Latencies, as in summary.json.
    ///     #[schemars(with = "Object")]
    ///     timing: report::summary::Timing,
    /// }
    ///
    /// let schema = Schema::of::<Gaps>("gaps").json();
    /// assert_eq!(schema["description"], "Gaps of the laws.");
    /// let row = &schema["properties"]["rows"]["items"]["properties"];
    /// assert_eq!(row["gap_m"]["type"], serde_json::json!(["number", "null"]));
    /// assert_eq!(row["timing"]["type"], "object");
    /// ```
    pub fn of<T: JsonSchema>(command: &'static str) -> Self {
        let settings = SchemaSettings::draft2020_12()
            .for_serialize()
            .with(|settings| settings.inline_subschemas = true);
        let mut root = SchemaGenerator::new(settings).into_root_schema_for::<T>().to_value();
        if let Some(root) = root.as_object_mut() {
            // The document around it has both.
            root.retain(|key, _| key != "$schema" && key != "title");
        }
        Self { command, root }
    }

    pub fn command(&self) -> &'static str {
        self.command
    }

    /// Adds fields beside the version.
    pub fn fields<R>(mut self, columns: &[Column<R>]) -> Self {
        columns.iter().for_each(|column| insert(&mut self.root, &column.head));
        self
    }

    /// Adds a list of objects at a dotted path. A list on the way is passed through, and `*` is every key.
    pub fn rows<R>(mut self, path: &str, meaning: &str, columns: &[Column<R>]) -> Self {
        let node = descend(&mut self.root, path);
        let mut items = json!({"type": "object"});
        columns.iter().for_each(|column| insert(&mut items, &column.head));
        *node = json!({"type": "array", "description": meaning, "items": items});
        self
    }

    pub fn json(&self) -> Value {
        self.root.clone()
    }
}

/// One document with a definition for each command.
pub fn document(schemas: &[Schema]) -> Value {
    let definitions = schemas.iter().map(|schema| (schema.command.to_owned(), schema.json()));
    let references =
        schemas.iter().map(|schema| json!({"$ref": format!("#/$defs/{}", schema.command)}));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Results of timegap, as --json prints them",
        "anyOf": references.collect::<Vec<_>>(),
        "$defs": definitions.collect::<Map<_, _>>(),
    })
}

/// The node at a path below an object or a list of objects.
fn descend<'a>(node: &'a mut Value, path: &str) -> &'a mut Value {
    let mut node = node;
    for part in path.split('.') {
        if node.get("items").is_some() {
            node = &mut node["items"];
        }
        let types = &mut node["type"];
        if types.is_null() {
            *types = json!("object");
        }
        node = match part {
            "*" => &mut node["additionalProperties"],
            part => {
                let required = &mut node["required"];
                if required.is_null() {
                    *required = json!([]);
                }
                let required = required.as_array_mut().expect("it was just made");
                if !required.iter().any(|known| known == part) {
                    required.push(json!(part));
                }
                &mut node["properties"][part]
            }
        };
    }
    node
}

fn insert(object: &mut Value, head: &Head) {
    // Places of a list have one description: that of the list.
    let is_place = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if head.name.is_empty() || head.name.split('.').any(is_place) {
        return;
    }
    let kind = match head.format {
        Format::Decimals(_) | Format::Exact | Format::Duration => json!(["number", "null"]),
        Format::Count => json!(["integer", "null"]),
        Format::Mean(_) => json!(["object", "number", "null"]),
        Format::Value => json!(["number", "string", "null"]),
        Format::Word | Format::Sentence | Format::Command => json!(["string", "null"]),
        Format::Verdict(_) => json!(["string", "null"]),
        Format::Flag(..) | Format::Fact => json!(["boolean", "null"]),
        Format::Nested(Kind::Object) | Format::Judged => json!(["object", "null"]),
        Format::Nested(Kind::List) => json!(["array", "null"]),
    };
    let meaning = match head.unit {
        "" => head.meaning.to_owned(),
        unit => format!("{}, {unit}", head.meaning),
    };
    let node = descend(object, &head.name);
    node["type"] = kind;
    node["description"] = json!(meaning);
}

/// Deviations of `value` from the schema, each with its place. They are values of another type, missing keys, and
/// undeclared keys. It supports the part of JSON Schema that [`Schema`] writes.
pub fn check(schema: &Value, value: &Value) -> Vec<String> {
    let mut wrong = Vec::new();
    walk(schema, value, "", &mut wrong);
    wrong
}

fn walk(schema: &Value, value: &Value, place: &str, wrong: &mut Vec<String>) {
    let below =
        |part: &str| if place.is_empty() { part.to_owned() } else { format!("{place}.{part}") };
    if let Some(expected) = schema.get("const")
        && expected != value
    {
        wrong.push(format!("{place}: {value} is not {expected}"));
    }
    let types: Vec<&str> = match schema.get("type") {
        Some(Value::Array(types)) => types.iter().filter_map(Value::as_str).collect(),
        Some(Value::String(one)) => vec![one],
        _ => Vec::new(),
    };
    if !types.is_empty() && !types.iter().any(|kind| is_of(kind, value)) {
        wrong.push(format!("{place}: {value} is not of type {}", types[0]));
        return;
    }
    if let Value::Object(object) = value {
        let names = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
        for name in names.filter(|name| !object.contains_key(*name)) {
            wrong.push(format!("{}: missing", below(name)));
        }
        for (name, value) in object {
            match (schema["properties"].get(name), schema.get("additionalProperties")) {
                (Some(schema), _) => walk(schema, value, &below(name), wrong),
                (None, Some(schema)) => walk(schema, value, &below(name), wrong),
                // An object that may be null, or that has no declared keys, may have others.
                (None, None)
                    if schema.get("properties").is_some() && schema["type"] == "object" =>
                {
                    wrong.push(format!("{}: not declared", below(name)));
                }
                (None, None) => {}
            }
        }
    }
    if let (Value::Array(list), Some(items)) = (value, schema.get("items")) {
        for (index, value) in list.iter().enumerate() {
            walk(items, value, &below(&index.to_string()), wrong);
        }
    }
}

fn is_of(kind: &str, value: &Value) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "null" => value.is_null(),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::super::column::{count, nested, number, word};
    use super::*;

    #[test]
    fn nested_rows_and_keys_are_described_and_what_is_not_declared_is_found() {
        let figures: [Column<()>; 2] =
            [word("name", "", ""), number("control.gap_m", "gap", "m", 1, "Smallest gap")];
        let laws: [Column<()>; 1] = [count("hits", "", "")];
        let papers: [Column<()>; 2] = [word("paper", "", ""), nested("rows", Kind::List, "")];
        let schema = Schema::new("x", "")
            .rows("papers", "The papers", &papers)
            .rows("papers.rows", "Their figures", &figures)
            .rows("parts.*.laws", "Laws of each part", &laws)
            .json();
        let good = json!({
            "schema_version": 1,
            "papers": [{"paper": "a", "rows": [{"name": "b", "control": {"gap_m": 1.5}}]}],
            "parts": {"low": {"laws": [{"hits": 3}]}},
        });
        assert_eq!(check(&schema, &good), [""; 0], "{schema:#}");
        let bad = json!({
            "schema_version": 2,
            "papers": [{"paper": "a", "rows": [{"name": 1, "control": {}}], "more": 1}],
            "parts": {"low": {"laws": [{"hits": 3.5}]}},
        });
        let mut wrong = check(&schema, &bad);
        wrong.sort();
        assert_eq!(
            wrong,
            [
                "papers.0.more: not declared",
                "papers.0.rows.0.control.gap_m: missing",
                "papers.0.rows.0.name: 1 is not of type string",
                "parts.low.laws.0.hits: 3.5 is not of type integer",
                "schema_version: 2 is not 1",
            ]
        );
    }
}
