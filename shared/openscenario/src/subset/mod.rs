//! The subset, as a table: which elements and attributes are read, and what they do.
//!
//! The table is the whole truth: a file is held against it before anything else reads it, and
//! `docs/openscenario.md` is printed from it ([`markdown`]).

mod action;
mod condition;
mod structure;

use std::fmt::Write as _;

use crate::error::{Place, ReadError, one_of};
use crate::xml::{Document, Element};

/// What an element of the subset may hold. Names end in `?` where they may be absent, in `*` where
/// there may be any number, in `+` where there is at least one.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The element's name.
    pub name: &'static str,
    /// Its attributes.
    pub attributes: &'static str,
    /// Elements inside it.
    pub children: &'static str,
    /// Elements of which exactly one stands inside it.
    pub choice: &'static str,
    /// What timegap does with it.
    pub effect: &'static str,
}

impl Rule {
    pub(crate) const fn new(
        name: &'static str,
        attributes: &'static str,
        children: &'static str,
        choice: &'static str,
        effect: &'static str,
    ) -> Self {
        Self { name, attributes, children, choice, effect }
    }
}

/// The parts of the table with their headings.
pub const PARTS: &[(&str, &[Rule])] = &[
    ("File, parameters, catalogs, entities", structure::FILE),
    ("Positions", structure::POSITIONS),
    ("Storyboard", structure::STORYBOARD),
    ("Actions", action::ACTIONS),
    ("Conditions", condition::CONDITIONS),
    ("Parameter variation", structure::VARIATION),
];

/// The rule for elements of a name.
#[must_use]
pub fn rule(name: &str) -> Option<&'static Rule> {
    PARTS.iter().flat_map(|(_, rules)| *rules).find(|rule| rule.name == name)
}

/// Splits a name of the table from its multiplicity.
fn multiplicity(name: &str) -> (&str, usize, usize) {
    match name.as_bytes().last() {
        Some(b'?') => (&name[..name.len() - 1], 0, 1),
        Some(b'*') => (&name[..name.len() - 1], 0, usize::MAX),
        Some(b'+') => (&name[..name.len() - 1], 1, usize::MAX),
        _ => (name, 1, 1),
    }
}

fn names(list: &str) -> impl Iterator<Item = &str> {
    list.split_whitespace().map(|name| multiplicity(name).0)
}

/// Holds a whole file against the table.
///
/// # Errors
/// At the first element or attribute that the subset does not have, or that is missing.
pub fn check(document: &Document) -> Result<(), ReadError> {
    check_head(document)?;
    check_part(&document.file, &document.root)
}

/// Holds an element and what is inside it against the table: of a catalog only the entries that are used.
///
/// # Errors
/// As [`check`].
pub fn check_part(file: &str, part: &Element) -> Result<(), ReadError> {
    element(file, part)
}

/// Whether a file is of the format, in a version of the subset.
///
/// # Errors
/// If it is not.
pub fn check_head(document: &Document) -> Result<(), ReadError> {
    if document.root.name != "OpenSCENARIO" {
        return Err(ReadError::Element {
            place: Place { file: document.file.clone(), line: document.root.line },
            element: document.root.name.clone(),
            parent: "the file".to_owned(),
            fault: "is not supported",
            expected: "`OpenSCENARIO`".to_owned(),
        });
    }
    version(document)
}

fn version(document: &Document) -> Result<(), ReadError> {
    let Some(header) = document.root.child("FileHeader") else { return Ok(()) };
    let part = |name| header.attribute(name).unwrap_or("?");
    match (part("revMajor"), part("revMinor")) {
        ("1", "0" | "1" | "2" | "3") => Ok(()),
        (major, minor) => Err(ReadError::Version {
            place: Place { file: document.file.clone(), line: header.line },
            found: format!("{major}.{minor}"),
        }),
    }
}

fn element(file: &str, here: &Element) -> Result<(), ReadError> {
    let place = |line| Place { file: file.to_owned(), line };
    let Some(rule) = rule(&here.name) else { return Ok(()) };
    attributes(file, here, rule)?;
    let allowed = || names(rule.children).chain(names(rule.choice));
    for child in &here.children {
        if !allowed().any(|name| name == child.name) {
            return Err(ReadError::Element {
                place: place(child.line),
                element: child.name.clone(),
                parent: here.name.clone(),
                fault: "is not supported",
                expected: one_of(allowed()),
            });
        }
    }
    for listed in rule.children.split_whitespace() {
        let (name, least, most) = multiplicity(listed);
        let mut of_name = here.children.iter().filter(|child| child.name == name);
        if least > 0 && of_name.clone().next().is_none() {
            return Err(ReadError::Element {
                place: place(here.line),
                element: name.to_owned(),
                parent: here.name.clone(),
                fault: "is missing",
                expected: if most == 1 { "one".to_owned() } else { "at least one".to_owned() },
            });
        }
        if most == 1
            && let Some(second) = of_name.nth(1)
        {
            return Err(ReadError::Element {
                place: place(second.line),
                element: name.to_owned(),
                parent: here.name.clone(),
                fault: "is there twice",
                expected: "one".to_owned(),
            });
        }
    }
    if !rule.choice.is_empty() {
        let chosen = here.children.iter().filter(|c| names(rule.choice).any(|n| n == c.name));
        if let count @ (0 | 2..) = chosen.count() {
            return Err(ReadError::Meaning {
                place: place(here.line),
                reason: format!("`{}` holds {count} elements of its choice", here.name),
                expected: format!("exactly one of {}", one_of(names(rule.choice))),
            });
        }
    }
    here.children.iter().try_for_each(|child| element(file, child))
}

fn attributes(file: &str, here: &Element, rule: &Rule) -> Result<(), ReadError> {
    let fault = |attribute: &str, reason: &str, expected: String| ReadError::Attribute {
        place: Place { file: file.to_owned(), line: here.line },
        attribute: attribute.to_owned(),
        element: here.name.clone(),
        reason: reason.to_owned(),
        expected,
    };
    for (name, _) in &here.attributes {
        let schema = matches!(name.as_str(), "noNamespaceSchemaLocation" | "xsi" | "xmlns");
        if !schema && !names(rule.attributes).any(|known| known == name) {
            return Err(fault(name, "is not supported", one_of(names(rule.attributes))));
        }
    }
    for listed in rule.attributes.split_whitespace() {
        let (name, least, _) = multiplicity(listed);
        if least == 1 && here.attribute(name).is_none() {
            return Err(fault(name, "is missing", "a value".to_owned()));
        }
    }
    Ok(())
}

/// The table as pages of Markdown.
#[must_use]
pub fn markdown() -> String {
    let mut text = String::new();
    for (heading, rules) in PARTS {
        let _ = writeln!(text, "### {heading}\n");
        text.push_str("| element | attributes | elements inside | what it does |\n");
        text.push_str("| --- | --- | --- | --- |\n");
        for rule in *rules {
            let choice = names(rule.choice).collect::<Vec<_>>().join(" or ");
            let inside = [rule.children, &choice].join(" ");
            let _ = writeln!(
                text,
                "| `{}` | {} | {} | {} |",
                rule.name,
                rule.attributes.split_whitespace().collect::<Vec<_>>().join(", "),
                inside.trim(),
                rule.effect
            );
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml;

    fn checked(body: &str) -> Result<(), ReadError> {
        let text = format!(
            "<OpenSCENARIO>\n<FileHeader revMajor=\"1\" revMinor=\"2\" date=\"\" description=\"\" author=\"\"/>\n{body}\n</OpenSCENARIO>"
        );
        check(&xml::parse("x.xosc", &text).expect("it is well-formed"))
    }

    fn refusal(body: &str) -> String {
        checked(body).expect_err("it is outside the subset").to_string()
    }

    #[test]
    fn every_element_named_in_the_table_has_its_own_row() {
        for (_, rules) in PARTS {
            for rule in *rules {
                for name in names(rule.children).chain(names(rule.choice)) {
                    assert!(super::rule(name).is_some(), "{} names {name}", rule.name);
                }
            }
        }
    }

    #[test]
    fn no_element_has_two_rows() {
        let mut seen = std::collections::BTreeSet::new();
        for rule in PARTS.iter().flat_map(|(_, rules)| *rules) {
            assert!(seen.insert(rule.name), "{}", rule.name);
        }
    }

    #[test]
    fn an_unknown_element_is_refused_with_line_and_choice() {
        let shown = refusal("<RoadNetwork>\n <TrafficSignals/>\n</RoadNetwork>");
        assert_eq!(
            shown,
            "x.xosc:4: element `TrafficSignals` in `RoadNetwork` is not supported, \
             expected `LogicFile` or `SceneGraphFile`"
        );
    }

    #[test]
    fn attributes_and_counts_are_checked() {
        let shown = refusal("<RoadNetwork><LogicFile path=\"a\"/></RoadNetwork>");
        assert!(shown.contains("attribute `path` of `LogicFile`: is not supported"), "{shown}");
        let shown = refusal("<RoadNetwork><LogicFile/></RoadNetwork>");
        assert!(shown.contains("`filepath` of `LogicFile`: is missing"), "{shown}");
        let twice = "<LogicFile filepath=\"a\"/>\n<LogicFile filepath=\"a\"/>";
        let shown = refusal(&format!("<RoadNetwork>{twice}</RoadNetwork>"));
        assert!(
            shown.contains("x.xosc:4: element `LogicFile` in `RoadNetwork` is there twice"),
            "{shown}"
        );
        let shown = refusal("<Entities><ScenarioObject name=\"a\"/></Entities>");
        assert!(shown.contains("exactly one of `CatalogReference`"), "{shown}");
    }

    #[test]
    fn another_version_is_refused() {
        let text = "<OpenSCENARIO>\n\n<FileHeader revMajor=\"2\" revMinor=\"0\"/></OpenSCENARIO>";
        let document = xml::parse("x.xosc", text).expect("it is well-formed");
        let shown = check(&document).expect_err("another version").to_string();
        assert_eq!(
            shown,
            "x.xosc:3: version 2.0 of OpenSCENARIO XML is not supported, expected 1.0 to 1.3"
        );
    }
}
