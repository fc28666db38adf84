//! JSON Schema of results, from the types that are written as JSON.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::column::Column;
use super::head::{Format, Head};

/// Any object, in the schema of a result whose parts another crate declares.
pub type Object = Map<String, Value>;

/// Contents of a command's JSON.
#[derive(Clone, Debug)]
pub struct Schema {
    command: &'static str,
    root: Value,
}

impl Schema {
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

    /// Adds fields that are known only when the program runs. A dotted name is of an object.
    pub fn fields<R>(mut self, columns: &[Column<R>]) -> Self {
        columns.iter().for_each(|column| insert(&mut self.root, &column.head));
        self
    }

    /// Adds a list of objects with these columns.
    pub fn rows<R>(mut self, name: &str, meaning: &str, columns: &[Column<R>]) -> Self {
        let mut items = json!({"type": "object"});
        columns.iter().for_each(|column| insert(&mut items, &column.head));
        let list = json!({"type": "array", "description": meaning, "items": items});
        declare(&mut self.root, name, list);
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

fn declare(object: &mut Value, name: &str, value: Value) {
    object["properties"][name] = value;
    match &mut object["required"] {
        Value::Array(names) => names.push(json!(name)),
        none => *none = json!([name]),
    }
}

fn insert(object: &mut Value, head: &Head) {
    let kind = match head.format {
        Format::Count => "integer",
        Format::Word | Format::Sentence | Format::Command => "string",
        Format::Flag(..) => "boolean",
        _ => "number",
    };
    let meaning = match head.unit {
        "" => head.meaning.to_owned(),
        unit => format!("{}, {unit}", head.meaning),
    };
    let value = json!({"type": [kind, "null"], "description": meaning});
    match head.name.split_once('.') {
        None => declare(object, &head.name, value),
        Some((of, name)) => {
            if object["properties"].get(of).is_none() {
                declare(object, of, json!({"type": "object"}));
            }
            declare(&mut object["properties"][of], name, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::column::{count, number, word};
    use super::*;

    /// A result with a declared key.
    #[derive(JsonSchema)]
    #[expect(dead_code, reason = "its schema alone is of interest")]
    struct Result {
        /// All is well.
        ok: bool,
    }

    #[test]
    fn columns_stand_beside_the_keys_of_the_type() {
        let figures: [Column<()>; 2] =
            [count("hits", "", "Hits"), number("control.gap_m", "gap", "m", 1, "Smallest gap")];
        let laws: [Column<()>; 1] = [word("law", "", "Its name")];
        let schema = Schema::of::<Result>("x").fields(&figures).rows("laws", "The laws", &laws);
        let gap = json!({"type": ["number", "null"], "description": "Smallest gap, m"});
        let name = json!({"type": ["string", "null"], "description": "Its name"});
        assert_eq!(
            schema.json(),
            json!({
                "type": "object",
                "description": "A result with a declared key.",
                "properties": {
                    "ok": {"type": "boolean", "description": "All is well."},
                    "hits": {"type": ["integer", "null"], "description": "Hits"},
                    "control": {
                        "type": "object",
                        "properties": {"gap_m": gap},
                        "required": ["gap_m"],
                    },
                    "laws": {
                        "type": "array",
                        "description": "The laws",
                        "items": {
                            "type": "object",
                            "properties": {"law": name},
                            "required": ["law"],
                        },
                    },
                },
                "required": ["ok", "hits", "control", "laws"],
            })
        );
    }
}
