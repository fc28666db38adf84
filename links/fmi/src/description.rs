//! `modelDescription.xml`: what a unit is, and its variables.

use crate::UnitError;
use crate::measure::Measure;
use openscenario::xml::{self, Document, Element};

pub const FILE: &str = "modelDescription.xml";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    Two,
    Three,
}

/// A type with one number as its value, which stands in the first of eight bytes.
#[derive(Debug)]
pub struct Type {
    version: Version,
    element: &'static str,
    /// End of the names of the functions that set and get it.
    pub suffix: &'static str,
    pub encode: fn(f64) -> [u8; 8],
    pub decode: fn([u8; 8]) -> f64,
}

macro_rules! types {
    ($($version:ident $element:literal $suffix:literal $number:ident $clean:expr;)*) => {
        &[$(Type {
            version: Version::$version,
            element: $element,
            suffix: $suffix,
            encode: |value| {
                let mut room = [0; 8];
                let bytes = ($clean(value) as $number).to_ne_bytes();
                room[..bytes.len()].copy_from_slice(&bytes);
                room
            },
            decode: |room| {
                $clean($number::from_ne_bytes(std::array::from_fn(|k| room[k])) as f64)
            },
        }),*]
    };
}

fn truth(value: f64) -> f64 {
    f64::from(u8::from(value != 0.0))
}

static TYPES: &[Type] = types! {
    Two "Real" "Real" f64 f64::from;
    Two "Integer" "Integer" i32 f64::round;
    Two "Enumeration" "Integer" i32 f64::round;
    Two "Boolean" "Boolean" i32 truth;
    Three "Float32" "Float32" f32 f64::from;
    Three "Float64" "Float64" f64 f64::from;
    Three "Int8" "Int8" i8 f64::round;
    Three "UInt8" "UInt8" u8 f64::round;
    Three "Int16" "Int16" i16 f64::round;
    Three "UInt16" "UInt16" u16 f64::round;
    Three "Int32" "Int32" i32 f64::round;
    Three "UInt32" "UInt32" u32 f64::round;
    Three "Int64" "Int64" i64 f64::round;
    Three "UInt64" "UInt64" u64 f64::round;
    Three "Enumeration" "Int64" i64 f64::round;
    Three "Boolean" "Boolean" u8 truth;
};

/// A variable with one number as its value.
#[derive(Clone, Debug)]
pub struct Variable {
    pub name: String,
    pub reference: u32,
    /// Its part: `input`, `output`, `parameter` and others.
    pub causality: String,
    /// Its start may be set before the unit initialises.
    pub has_start: bool,
    pub kind: &'static Type,
    /// Name of its unit of measure, and the unit; the unit is none when nothing defines the name.
    pub measure: Option<(String, Option<Measure>)>,
}

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
        let varies = kind.attribute("canHandleVariableCommunicationStepSize") == Some("true");
        let proposed = root.child("DefaultExperiment").and_then(|e| e.attribute("stepSize"));
        let step = |text: Option<&str>| {
            let step_s = text?.trim().parse::<f64>().ok();
            step_s.filter(|step_s| step_s.is_finite() && *step_s > 0.0)
        };
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

/// Name of an element's unit of measure, and the unit. An element may have it by its type.
fn measure(root: &Element, element: &Element) -> Option<(String, Option<Measure>)> {
    let named = |list: &str, name: &str| {
        root.child(list)?.children.iter().find(|one| one.attribute("name") == Some(name))
    };
    let declared = || {
        let kind = named("TypeDefinitions", element.attribute("declaredType")?)?;
        let inner = || kind.children.iter().find_map(|inner| inner.attribute("unit"));
        kind.attribute("unit").or_else(inner)
    };
    let name = element.attribute("unit").or_else(declared)?;
    let defined = named("UnitDefinitions", name).and_then(Measure::defined);
    Some((name.to_owned(), defined.or_else(|| Measure::named(name))))
}

/// The scalar variables with a number as value; others cannot be exchanged.
fn variables(root: &Element, version: Version, file: &str) -> Result<Vec<Variable>, UnitError> {
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
        let is_typed = |kind: &&Type| kind.version == version && kind.element == typed.name;
        let Some(kind) = TYPES.iter().find(is_typed) else { continue };
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
            measure: measure(root, typed),
        });
    }
    Ok(found)
}
