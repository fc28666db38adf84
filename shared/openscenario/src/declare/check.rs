//! Holds a file against the forms of its elements.

use super::{ChildForm, Form};
use crate::error::{Place, ReadError, meant, one_of};
use crate::xml::{Document, Element};

pub(crate) const SCENARIO_VERSIONS: &[(&str, &str)] =
    &[("1", "0"), ("1", "1"), ("1", "2"), ("1", "3")];
/// Versions of catalogs. Their entries are the same since 0.9.
pub(crate) const CATALOG_VERSIONS: &[(&str, &str)] =
    &[("0", "9"), ("1", "0"), ("1", "1"), ("1", "2"), ("1", "3")];

/// Elements, by the beginning of their names, that are refused in words of their own, with all that is in them.
const REFUSED: &[(&str, &str)] = &[
    ("TrafficAction", "only the entities of the file are on the road"),
    ("Trailer", "no vehicle pulls a trailer"),
    ("ClothoidSpline", "a trajectory is a `Polyline`, a `Clothoid` or a `Nurbs`"),
    ("FromCurrentEntity", "the place of an entity is a `RelativeRoadPosition`"),
];

/// True if a file is of the format, in one of some versions.
pub(crate) fn check_head(document: &Document, versions: &[(&str, &str)]) -> Result<(), ReadError> {
    let root = &document.root;
    let place = |element: &Element| Place { file: document.file.clone(), spot: element.spot };
    if root.name != "OpenSCENARIO" {
        let names = (root.name.as_str(), "the file");
        return Err(ReadError::element(place(root), names, "is not supported", "`OpenSCENARIO`"));
    }
    let Some(header) = root.child("FileHeader") else { return Ok(()) };
    let part = |name| header.attribute(name).unwrap_or("?");
    let (major, minor) = (part("revMajor"), part("revMinor"));
    if versions.contains(&(major, minor)) {
        return Ok(());
    }
    let reason = format!("version {major}.{minor} of OpenSCENARIO XML is not supported");
    Err(ReadError::meaning(place(header), reason, "1.0 to 1.3"))
}

/// Holds an element and all that is inside it against its form.
///
/// # Errors
/// At the first element or attribute that is unknown, missing or too many.
pub(crate) fn check(file: &str, here: &Element, form: &'static Form) -> Result<(), ReadError> {
    if form.unused == ["*"] {
        return Ok(());
    }
    attributes(file, here, form)?;
    let place = |at: &Element| Place { file: file.to_owned(), spot: at.spot };
    let fault = |at: &Element, name: &str, fault: &str, expected: &str| {
        ReadError::element(place(at), (name, &here.name), fault, expected)
    };
    for child in &here.children {
        if !form.children.iter().any(|known| known.has(&child.name)) {
            let expected = meant(&child.name, form.children.iter().flat_map(ChildForm::names));
            let refused = |(name, _): &&(&str, &str)| {
                child.name.starts_with(name) || here.name.starts_with(name)
            };
            let own = REFUSED.iter().find(refused).map(|(_, why)| format!(": {why}"));
            let words = format!("is not supported{}", own.unwrap_or_default());
            return Err(fault(child, &child.name, &words, &expected));
        }
    }
    for known in form.children {
        let mut found = here.children.iter().filter(|child| known.has(&child.name));
        let count = found.clone().count();
        if (known.least..=known.most).contains(&count) {
            continue;
        }
        let [(name, _)] = known.alternatives else {
            let reason = format!("`{}` holds {count} elements of its choice", here.name);
            let expected = format!("exactly one of {}", one_of(known.names()));
            return Err(ReadError::meaning(place(here), reason, expected));
        };
        return Err(match found.nth(known.most) {
            Some(second) => fault(second, name, "is there twice", "one"),
            None if known.most == 1 => fault(here, name, "is missing", "one"),
            None => fault(here, name, "is missing", "at least one"),
        });
    }
    here.children.iter().try_for_each(|child| {
        let mut alternatives = form.children.iter().flat_map(|known| known.alternatives);
        match alternatives.find(|(name, _)| *name == child.name) {
            Some((_, form)) => check(file, child, form),
            None => Ok(()),
        }
    })
}

fn attributes(file: &str, here: &Element, form: &Form) -> Result<(), ReadError> {
    let names = || {
        let unused =
            form.unused.iter().map(|name| (name.trim_end_matches('?'), name.ends_with('?')));
        form.attributes.iter().map(|known| (known.name, known.optional)).chain(unused)
    };
    let fault = |spot, attribute: &str, reason: &str, expected: String| {
        let place = Place { file: file.to_owned(), spot };
        ReadError::attribute(place, (attribute, &here.name), reason, expected)
    };
    for given in &here.attributes {
        let schema = matches!(given.name.as_str(), "noNamespaceSchemaLocation" | "xsi" | "xmlns");
        if !schema && !names().any(|(known, _)| known == given.name) {
            let expected = meant(&given.name, names().map(|(name, _)| name));
            return Err(fault(given.spot, &given.name, "is not supported", expected));
        }
    }
    match names().find(|(name, optional)| !optional && here.given(name).is_none()) {
        None => Ok(()),
        Some((name, _)) => {
            let known = form.attributes.iter().find(|known| known.name == name);
            let expected = known.map_or_else(|| "a value".to_owned(), |known| (known.kind)());
            Err(fault(here.spot, name, "is missing", expected))
        }
    }
}
