//! `modelDescription.xml`: what a unit is, and its variables.

use crate::UnitError;
use crate::measure::Measure;
use openscenario::xml::{self, Document, Element};
use std::collections::BTreeMap;

/// The file in a unit.
pub const FILE: &str = "modelDescription.xml";

/// Version of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    Two,
    Three,
}

/// Bytes of a variable's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Float(usize),
    Signed(usize),
    Unsigned(usize),
    Boolean(usize),
}

/// A variable with one number as its value.
#[derive(Clone, Debug)]
pub struct Variable {
    pub name: String,
    pub reference: u32,
    /// Its part: `input`, `output`, `parameter` and others.
    pub causality: String,
    /// Its start may be set before the unit initialises.
    pub has_start: bool,
    pub kind: Kind,
    /// End of the names of the functions that set and get it.
    pub suffix: String,
    /// Name of its unit of measure, and the unit; the unit is none when nothing defines the name.
    pub measure: Option<(String, Option<Measure>)>,
}

/// A unit as its description has it.
#[derive(Clone, Debug)]
pub struct Description {
    pub version: Version,
    /// Token that the unit compares with its own.
    pub token: String,
    /// Name of its shared library.
    pub identifier: String,
    /// Step that it takes alone, s; `None` if it takes any.
    pub step_s: Option<f64>,
    /// Step that it proposes and cannot vary, s.
    pub proposed_s: Option<f64>,
    pub variables: Vec<Variable>,
}

/// Type of an element: the end of its functions' names, and its bytes. Version 3 has the bits in the name.
fn type_of(version: Version, name: &str) -> Option<(&str, Kind)> {
    match (version, name) {
        (Version::Two, "Real") => Some((name, Kind::Float(8))),
        (Version::Two, "Integer" | "Enumeration") => Some(("Integer", Kind::Signed(4))),
        (Version::Two, "Boolean") => Some((name, Kind::Boolean(4))),
        (Version::Two, _) => None,
        (Version::Three, "Boolean") => Some((name, Kind::Boolean(1))),
        (Version::Three, "Enumeration") => Some(("Int64", Kind::Signed(8))),
        (Version::Three, _) => {
            let (word, bits) = name.split_at(name.find(|c: char| c.is_ascii_digit())?);
            let bytes = [8, 16, 32, 64].into_iter().find(|known| bits == known.to_string())? / 8;
            match word {
                "Float" if bytes >= 4 => Some((name, Kind::Float(bytes))),
                "Int" => Some((name, Kind::Signed(bytes))),
                "UInt" => Some((name, Kind::Unsigned(bytes))),
                _ => None,
            }
        }
    }
}

impl Description {
    /// Reads the file's text; `unit` names the unit in errors.
    ///
    /// # Errors
    /// When it is not such a file, of another version, or not for co-simulation.
    pub fn read(unit: &str, text: &str) -> Result<Self, UnitError> {
        let file = format!("{unit}/{FILE}");
        let Document { root, .. } = xml::parse(&file, text)
            .map_err(|error| UnitError::new(unit, error.to_string(), "a model description"))?;
        let refuse = |fault: String, expected: &str| UnitError::new(&file, fault, expected);
        if root.name != "fmiModelDescription" {
            return Err(refuse(format!("element `{}`", root.name), "`fmiModelDescription`"));
        }
        let version = match root.attribute("fmiVersion").unwrap_or("") {
            text if text.starts_with("2.") => Version::Two,
            text if text.starts_with("3.") => Version::Three,
            text => return Err(refuse(format!("FMI version `{text}`"), "2.0 or 3.0")),
        };
        let Some(kind) = root.child("CoSimulation") else {
            let fault = "the unit is not for co-simulation (no element `CoSimulation`)";
            return Err(refuse(fault.to_owned(), "a co-simulation unit"));
        };
        let attribute = |element: &Element, name: &str| {
            element.attribute(name).map(str::to_owned).ok_or_else(|| {
                let file = format!("{file}:{}", element.spot);
                UnitError::new(file, format!("no `{name}` in `{}`", element.name), "one")
            })
        };
        let token = if version == Version::Two { "guid" } else { "instantiationToken" };
        let number = |text: Option<&str>| text.and_then(|text| text.trim().parse::<f64>().ok());
        let varies = kind.attribute("canHandleVariableCommunicationStepSize") == Some("true");
        let proposed = root.child("DefaultExperiment").and_then(|e| e.attribute("stepSize"));
        let step = |text| number(text).filter(|step_s| step_s.is_finite() && *step_s > 0.0);
        let identifier = attribute(kind, "modelIdentifier")?;
        if identifier.is_empty() || identifier.contains(['/', '\0']) {
            return Err(refuse(format!("model identifier `{identifier}`"), "a file's name"));
        }
        Ok(Self {
            version,
            token: attribute(&root, token)?,
            identifier,
            step_s: step(kind.attribute("fixedInternalStepSize")),
            proposed_s: step(proposed).filter(|_| !varies),
            variables: variables(&root, version, &file)?,
        })
    }
}

/// Measures by the names of units, and the units' names by the names of types.
struct Names<'a> {
    units: BTreeMap<&'a str, Option<Measure>>,
    types: BTreeMap<&'a str, &'a str>,
}

impl<'a> Names<'a> {
    fn of(root: &'a Element) -> Self {
        let children = |name: &str| root.child(name).map_or(&[][..], |list| &list.children);
        let units = children("UnitDefinitions")
            .iter()
            .filter_map(|unit| Some((unit.attribute("name")?, Measure::defined(unit))))
            .collect();
        let types = children("TypeDefinitions").iter().filter_map(|kind| {
            let inner = kind.children.iter().find_map(|inner| inner.attribute("unit"));
            Some((kind.attribute("name")?, kind.attribute("unit").or(inner)?))
        });
        Self { units, types: types.collect() }
    }

    fn measure(&self, element: &'a Element) -> Option<(String, Option<Measure>)> {
        let declared = || self.types.get(element.attribute("declaredType")?).copied();
        let name = element.attribute("unit").or_else(declared)?;
        let defined = self.units.get(name).copied().flatten();
        Some((name.to_owned(), defined.or_else(|| Measure::named(name))))
    }
}

/// The scalar variables with a number as value; others cannot be exchanged.
fn variables(root: &Element, version: Version, file: &str) -> Result<Vec<Variable>, UnitError> {
    let names = Names::of(root);
    let Some(list) = root.child("ModelVariables") else {
        return Err(UnitError::new(file, "no element `ModelVariables`", "one"));
    };
    let mut found = Vec::new();
    for element in &list.children {
        // Version 2 has the type as an element inside.
        let typed = match version {
            Version::Two => element.children.iter().find(|inner| inner.name != "Annotations"),
            Version::Three => Some(element),
        };
        let Some(typed) = typed else { continue };
        let Some((suffix, kind)) = type_of(version, &typed.name) else { continue };
        if element.child("Dimension").is_some() {
            continue;
        }
        let reference = element.attribute("valueReference").and_then(|text| text.parse().ok());
        let (Some(name), Some(reference)) = (element.attribute("name"), reference) else {
            let place = format!("{file}:{}", element.spot);
            return Err(UnitError::new(place, "a variable without a name or a number", "both"));
        };
        let causality = element.attribute("causality").unwrap_or("local");
        let is = |name: &str, value: &str| element.attribute(name) == Some(value);
        found.push(Variable {
            name: name.to_owned(),
            reference,
            causality: causality.to_owned(),
            has_start: matches!(causality, "input" | "parameter")
                || is("initial", "exact") && !is("variability", "constant"),
            kind,
            suffix: suffix.to_owned(),
            measure: names.measure(typed),
        });
    }
    Ok(found)
}
