//! The subset as tables in Markdown, for the documentation.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::declare::{AttributeForm, ChildForm, Element, Form};
use crate::subset::{CatalogFile, ScenarioFile};
use crate::variation::VariationFile;

/// The headings of the reference, in order.
const PARTS: [&str; 9] = [
    "File",
    "Parameters and catalogs",
    "Entities",
    "Positions",
    "Storyboard",
    "Actions",
    "Conditions",
    "Parameter variation",
    "Read, without effect",
];

/// The table of the subset as it stands in `docs/openscenario.md`.
///
/// ```
/// let table = openscenario::reference::markdown();
/// assert!(table.contains("| `TeleportAction` |"));
/// ```
#[must_use]
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
        text.push_str("| element | attributes | elements inside | what it does |\n");
        text.push_str("| --- | --- | --- | --- |\n");
        for (names, row) in rows.0.get(part).into_iter().flatten() {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            let _ = writeln!(text, "| {} | {row} |", names.join(", "));
        }
        text.push('\n');
    }
    text
}

/// Rows by part: the elements that have it, and its other cells.
#[derive(Default)]
struct Rows(BTreeMap<&'static str, Vec<(Vec<&'static str>, String)>>);

impl Rows {
    /// Adds an element and all that is inside it, each row once.
    fn add(&mut self, name: &'static str, form: &'static Form) {
        let mut attributes: Vec<String> = form.attributes.iter().map(attribute).collect();
        if !form.unused.is_empty() {
            attributes.push(format!("without effect: {}", form.unused.join(", ")));
        }
        let inside: Vec<String> = form.children.iter().map(child).collect();
        let cells = [attributes.join("; "), inside.join(", "), form.effect.trim().to_owned()];
        let row = cells.join(" | ");
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

fn attribute(form: &AttributeForm) -> String {
    let optional = if form.optional { "?" } else { "" };
    let unit = match form.unit {
        "" => String::new(),
        unit => format!(" ({unit})"),
    };
    format!("{}{optional}{unit}: {}", form.name, (form.kind)())
}

fn child(form: &ChildForm) -> String {
    let names: Vec<&str> = form.names().collect();
    let names = match names.as_slice() {
        [only] => (*only).to_owned(),
        all if (form.least, form.most) == (1, 1) => all.join(" or "),
        all => format!("({})", all.join(" or ")),
    };
    let count = match (form.least, form.most) {
        (1, 1) => "",
        (0, 1) => "?",
        (0, _) => "*",
        _ => "+",
    };
    format!("{names}{count}")
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
        let mut parts = PARTS.to_vec();
        parts.sort_unstable();
        assert_eq!(rows.0.keys().copied().collect::<Vec<_>>(), parts);
    }

    #[test]
    fn an_element_of_two_names_has_one_row() {
        let table = markdown();
        assert!(table.contains("| `SpeedActionDynamics`, `LaneChangeActionDynamics` |"), "{table}");
        assert_eq!(table.matches("| `Position`").count(), 1);
    }
}
