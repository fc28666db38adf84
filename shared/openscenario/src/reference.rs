//! The subset as tables in Markdown, for the documentation.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::declare::{AttributeForm, ChildForm, Element, Form};
use crate::subset::{CatalogFile, ScenarioFile};
use crate::variation::VariationFile;

const PARTS: [&str; 8] = [
    "File",
    "Parameters and catalogs",
    "Entities",
    "Positions",
    "Storyboard",
    "Actions",
    "Conditions",
    "Parameter variation",
];

/// The part of elements without effect: a list of their names.
const UNUSED: &str = "Read, without effect";

/// The table of the subset as it stands in `docs/openscenario.md`.
///
/// ```
/// let table = openscenario::reference::markdown();
/// assert!(table.contains("`TeleportAction` |"));
/// ```
pub fn markdown() -> String {
    let mut rows = Rows::default();
    for (name, form) in [
        (ScenarioFile::NAME, ScenarioFile::FORM),
        (CatalogFile::NAME, CatalogFile::FORM),
        (VariationFile::NAME, VariationFile::FORM),
    ] {
        rows.add(name, form);
    }
    let mut text = String::new();
    for part in PARTS {
        let _ = writeln!(text, "### {part}\n");
        text.push_str("element | attributes, then elements | what it does\n--- | --- | ---\n");
        for (names, row) in rows.0.get(part).into_iter().flatten() {
            let _ = writeln!(text, "{} | {row}", quoted(names));
        }
        text.push('\n');
    }
    let unused: Vec<_> =
        rows.0.get(UNUSED).into_iter().flatten().map(|(names, _)| quoted(names)).collect();
    let _ = writeln!(text, "### {UNUSED}\n\nTheir content is not read: {}.", unused.join(", "));
    text
}

/// Rows by part: the elements that have it, and its other cells.
#[derive(Default)]
struct Rows(BTreeMap<&'static str, Vec<(Vec<&'static str>, String)>>);

impl Rows {
    /// Adds an element and all that is inside it, each row once.
    fn add(&mut self, name: &'static str, form: &'static Form) {
        let mut inside: Vec<String> = form.attributes.iter().map(attribute).collect();
        if !form.unused.is_empty() {
            inside.push(format!("unused {}", form.unused.join(" ")));
        }
        inside.extend(form.children.iter().map(child));
        let row = format!("{} | {}", inside.join("; "), form.effect.trim());
        let rows = self.0.entry(form.part).or_default();
        match rows.iter_mut().find(|(_, known)| *known == row) {
            Some((names, _)) if names.contains(&name) => return,
            Some((names, _)) => names.push(name),
            None => rows.push((vec![name], row)),
        }
        for (name, form) in form.children.iter().flat_map(|child| child.alternatives) {
            self.add(name, form);
        }
    }
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Name, unit and accepted values. A number or a text has no more to say than its name.
fn attribute(form: &AttributeForm) -> String {
    let optional = if form.optional { "?" } else { "" };
    let unit = match form.unit {
        "" => String::new(),
        unit => format!(" ({unit})"),
    };
    let values = (form.kind)();
    let values = match values.as_str() {
        "a number" | "a text" | "a value" => String::new(),
        words if words.contains('`') || words == "true or false" => {
            format!(": {}", words.replace('`', "").replace(", ", "/").replace(" or ", "/"))
        }
        values => {
            let plain = values.trim_start_matches("an ").trim_start_matches("a ");
            format!(
                ": {}",
                plain.replace("more than 0, or INF", ">0/INF").replace("0 or more", "≥0")
            )
        }
    };
    format!("{}{optional}{unit}{values}", form.name)
}

fn child(form: &ChildForm) -> String {
    let names: Vec<&str> = form.names().collect();
    let count = match (form.least, form.most) {
        (1, 1) => "",
        (0, 1) => "?",
        (0, _) => "*",
        _ => "+",
    };
    let all = names.join("/");
    if names.len() > 1 && !count.is_empty() { format!("({all}){count}") } else { all + count }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_rows_and_every_row_a_part() {
        let mut rows = Rows::default();
        rows.add(ScenarioFile::NAME, ScenarioFile::FORM);
        rows.add(CatalogFile::NAME, CatalogFile::FORM);
        rows.add(VariationFile::NAME, VariationFile::FORM);
        let mut parts = [&PARTS[..], &[UNUSED]].concat();
        parts.sort_unstable();
        assert_eq!(rows.0.keys().copied().collect::<Vec<_>>(), parts);
    }

    #[test]
    fn an_element_of_two_names_has_one_row() {
        let table = markdown();
        assert!(table.contains("\n`SpeedActionDynamics`, `LaneChangeActionDynamics` |"), "{table}");
        assert_eq!(table.matches("\n`RoadPosition`").count(), 1);
    }
}
