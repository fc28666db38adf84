//! Parameters: declarations, constraints, scopes.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::error::{Place, ReadError};
use crate::expression::{Fault, Value, evaluate};
use crate::xml::Element;

/// A value that `--param` or a variation gives to a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assignment {
    /// The parameter's name.
    pub name: String,
    /// Its value, as an attribute would hold it.
    pub value: String,
}

/// Types that a parameter can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    Text,
    Double,
    Integer { negative: bool },
    Boolean,
}

impl Type {
    fn named(name: &str) -> Option<Self> {
        match name {
            "string" | "dateTime" => Some(Self::Text),
            "double" => Some(Self::Double),
            "integer" | "int" => Some(Self::Integer { negative: true }),
            "unsignedInt" | "unsignedShort" => Some(Self::Integer { negative: false }),
            "boolean" => Some(Self::Boolean),
            _ => None,
        }
    }

    /// The value in this type, or what was expected.
    fn take(self, value: Value) -> Result<Value, &'static str> {
        match (self, value) {
            (Self::Text, value) => Ok(Value::Text(value.text())),
            (Self::Boolean, Value::Boolean(value)) => Ok(Value::Boolean(value)),
            (Self::Boolean, Value::Text(text)) if text == "1" => Ok(Value::Boolean(true)),
            (Self::Boolean, Value::Number(number)) if number == 0.0 || number == 1.0 => {
                Ok(Value::Boolean(number == 1.0))
            }
            (Self::Boolean, _) => Err("true or false"),
            (Self::Double, value) => value.number().map(Value::Number).ok_or("a number"),
            (Self::Integer { negative }, value) => value
                .number()
                .filter(|number| libm::trunc(*number) == *number && (negative || *number >= 0.0))
                .map(Value::Number)
                .ok_or(if negative { "a whole number" } else { "a whole number, 0 or more" }),
        }
    }
}

/// The parameters that an element can refer to.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    values: BTreeMap<String, Value>,
}

impl Scope {
    /// The value of a parameter.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// All parameters with their values, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.values.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// This scope with the declarations inside `element` added; `assigned` values take the place of
    /// the declared ones.
    ///
    /// # Errors
    /// When a declaration is circular, ill-typed or breaks its constraints, or an assignment names no
    /// parameter.
    pub fn with(
        &self,
        file: &str,
        element: &Element,
        assigned: &[Assignment],
    ) -> Result<Self, ReadError> {
        let declared: &[Element] =
            element.child("ParameterDeclarations").map_or(&[], |list| &list.children);
        let mut reading = Reading {
            file,
            declared,
            assigned,
            outer: self,
            values: BTreeMap::new(),
            open: Vec::new(),
        };
        for assignment in assigned {
            if !declared.iter().any(|d| d.attribute("name") == Some(&assignment.name)) {
                return Err(ReadError::Override {
                    name: assignment.name.clone(),
                    value: assignment.value.clone(),
                    reason: format!("{file} does not declare it"),
                    expected: names(declared),
                });
            }
        }
        for (i, declaration) in declared.iter().enumerate() {
            let name = declaration.attribute("name").unwrap_or_default();
            if declared[..i].iter().any(|other| other.attribute("name") == Some(name)) {
                return Err(reading.fault(
                    declaration,
                    name,
                    "is declared twice",
                    "one declaration",
                ));
            }
            reading.value(name, declaration)?;
        }
        let mut scope = self.clone();
        scope.values.extend(std::mem::take(&mut reading.values));
        for declaration in declared {
            constraints(file, declaration, &scope)?;
        }
        Ok(scope)
    }

    /// The value of an attribute's text: a literal, `$name` or `${expression}`.
    ///
    /// # Errors
    /// When it refers to nothing or is no expression.
    pub fn resolve(&self, text: &str, fault: &AttributeFault<'_>) -> Result<Value, ReadError> {
        resolve(text, fault, &mut |name| {
            self.value(name).cloned().ok_or_else(|| ReadError::Parameter {
                place: fault.place(),
                parameter: name.to_owned(),
                reason: "is not declared".to_owned(),
                expected: match self.values.is_empty() {
                    true => "no parameter here".to_owned(),
                    false => crate::error::one_of(self.values.keys().map(String::as_str)),
                },
            })
        })
    }
}

/// Where an attribute stands, for its errors.
#[derive(Clone, Copy, Debug)]
pub struct AttributeFault<'a> {
    /// The file.
    pub file: &'a str,
    /// The element.
    pub element: &'a Element,
    /// The attribute's name.
    pub attribute: &'a str,
}

impl AttributeFault<'_> {
    /// The place of its element.
    #[must_use]
    pub fn place(&self) -> Place {
        Place { file: self.file.to_owned(), line: self.element.line }
    }

    /// The error.
    #[must_use]
    pub fn error(&self, reason: impl Into<String>, expected: impl Into<String>) -> ReadError {
        ReadError::Attribute {
            place: self.place(),
            attribute: self.attribute.to_owned(),
            element: self.element.name.clone(),
            reason: reason.into(),
            expected: expected.into(),
        }
    }
}

/// Most characters of an expression that an error shows.
const MOST_SHOWN: usize = 200;

/// The begin of a text, as far as it helps to find it.
fn excerpt(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

fn resolve(
    text: &str,
    fault: &AttributeFault<'_>,
    parameter: &mut dyn FnMut(&str) -> Result<Value, ReadError>,
) -> Result<Value, ReadError> {
    let trimmed = text.trim();
    if let Some(expression) = trimmed.strip_prefix("${") {
        let Some(expression) = expression.strip_suffix('}') else {
            let shown = excerpt(trimmed);
            return Err(fault.error(format!("`{shown}` is not closed"), "`}` at the end"));
        };
        return evaluate(expression, parameter).map_err(|wrong| match wrong {
            Fault::Expression(reason, expected) => {
                fault.error(format!("in `{}`: {}", excerpt(trimmed), excerpt(&reason)), expected)
            }
            Fault::Parameter(error) => error,
        });
    }
    match trimmed.strip_prefix('$') {
        Some(name) => parameter(name),
        None => Ok(Value::literal(text)),
    }
}

/// The state of reading a list of declarations, each of which may refer to the others.
struct Reading<'a> {
    file: &'a str,
    declared: &'a [Element],
    assigned: &'a [Assignment],
    outer: &'a Scope,
    values: BTreeMap<String, Value>,
    /// Names whose values are being read: one of them again is a circle.
    open: Vec<String>,
}

impl<'a> Reading<'a> {
    fn fault(&self, at: &Element, parameter: &str, reason: &str, expected: &str) -> ReadError {
        ReadError::Parameter {
            place: Place { file: self.file.to_owned(), line: at.line },
            parameter: parameter.to_owned(),
            reason: reason.to_owned(),
            expected: expected.to_owned(),
        }
    }

    fn value(&mut self, name: &str, declaration: &'a Element) -> Result<Value, ReadError> {
        if let Some(value) = self.values.get(name) {
            return Ok(value.clone());
        }
        if let Some(start) = self.open.iter().position(|open| open == name) {
            let circle = [&self.open[start..], &[name.to_owned()]].concat().join(" -> ");
            let reason = format!("depends on itself ({circle})");
            return Err(self.fault(declaration, name, &reason, "no circle"));
        }
        self.open.push(name.to_owned());
        let type_name = declaration.attribute("parameterType").unwrap_or_default();
        let Some(kind) = Type::named(type_name) else {
            let fault = AttributeFault {
                file: self.file,
                element: declaration,
                attribute: "parameterType",
            };
            return Err(fault.error(
                format!("`{type_name}` is not a type"),
                "string, double, integer, int, unsignedInt, unsignedShort, boolean or dateTime",
            ));
        };
        let assigned = self.assigned.iter().rev().find(|assignment| assignment.name == name);
        let text = match assigned {
            Some(assignment) => assignment.value.as_str(),
            None => declaration.attribute("value").unwrap_or_default(),
        };
        let fault = AttributeFault { file: self.file, element: declaration, attribute: "value" };
        let declared = self.declared;
        let value =
            resolve(text, &fault, &mut |other| match declared
                .iter()
                .find(|d| d.attribute("name") == Some(other))
            {
                Some(found) => self.value(other, found),
                None => self.outer.value(other).cloned().ok_or_else(|| {
                    self.fault(declaration, other, "is not declared", &names(declared))
                }),
            })?;
        let value = match kind {
            Type::Text if !text.trim().starts_with('$') => Value::Text(text.to_owned()),
            _ => value,
        };
        let value = kind.take(value).map_err(|expected| match assigned {
            Some(assignment) => ReadError::Override {
                name: name.to_owned(),
                value: assignment.value.clone(),
                reason: format!("{} declares it as {type_name}", self.file),
                expected: expected.to_owned(),
            },
            None => fault.error(format!("`{text}` is not of type {type_name}"), expected),
        })?;
        self.open.pop();
        self.values.insert(name.to_owned(), value.clone());
        Ok(value)
    }
}

fn names(declared: &[Element]) -> String {
    crate::error::one_of(declared.iter().filter_map(|declaration| declaration.attribute("name")))
}

/// Rules for comparing two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Equal.
    EqualTo,
    /// Not equal.
    NotEqualTo,
    /// Greater.
    GreaterThan,
    /// Less.
    LessThan,
    /// Greater or equal.
    GreaterOrEqual,
    /// Less or equal.
    LessOrEqual,
}

impl Rule {
    /// The rules with their names in the standard.
    pub const NAMES: &[(&str, Self)] = &[
        ("equalTo", Self::EqualTo),
        ("notEqualTo", Self::NotEqualTo),
        ("greaterThan", Self::GreaterThan),
        ("lessThan", Self::LessThan),
        ("greaterOrEqual", Self::GreaterOrEqual),
        ("lessOrEqual", Self::LessOrEqual),
    ];

    /// The name in the standard.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, rule)| *rule == self).map_or("", |(name, _)| name)
    }

    /// Whether it holds between numbers.
    #[must_use]
    pub fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Self::EqualTo => left == right,
            Self::NotEqualTo => left != right,
            Self::GreaterThan => left > right,
            Self::LessThan => left < right,
            Self::GreaterOrEqual => left >= right,
            Self::LessOrEqual => left <= right,
        }
    }

    /// Whether it holds between values: as numbers where both are, as text otherwise.
    #[must_use]
    pub fn compares(self, left: &Value, right: &Value) -> bool {
        match (left.number(), right.number()) {
            (Some(left), Some(right)) => self.holds(left, right),
            _ => match self {
                Self::EqualTo => left.text() == right.text(),
                Self::NotEqualTo => left.text() != right.text(),
                _ => false,
            },
        }
    }
}

/// Of several groups one must hold, with all its constraints.
fn constraints(file: &str, declaration: &Element, scope: &Scope) -> Result<(), ReadError> {
    let name = declaration.attribute("name").unwrap_or_default();
    let Some(value) = scope.value(name) else { return Ok(()) };
    let mut groups = Vec::new();
    for group in &declaration.children {
        let mut holds = true;
        let mut words = Vec::new();
        for constraint in &group.children {
            let fault = AttributeFault { file, element: constraint, attribute: "rule" };
            let rule_name =
                scope.resolve(constraint.attribute("rule").unwrap_or_default(), &fault)?;
            let rule_name = rule_name.text();
            let Some((_, rule)) = Rule::NAMES.iter().find(|(known, _)| *known == rule_name) else {
                return Err(fault.error(
                    format!("`{rule_name}` is not a rule"),
                    crate::error::one_of(Rule::NAMES.iter().map(|(known, _)| *known)),
                ));
            };
            let fault = AttributeFault { attribute: "value", ..fault };
            let bound = scope.resolve(constraint.attribute("value").unwrap_or_default(), &fault)?;
            holds &= rule.compares(value, &bound);
            words.push(format!("{rule_name} {}", bound.text()));
        }
        if holds {
            return Ok(());
        }
        groups.push(words.join(" and "));
    }
    if groups.is_empty() {
        return Ok(());
    }
    Err(ReadError::Constraint {
        place: Place { file: file.to_owned(), line: declaration.line },
        parameter: name.to_owned(),
        value: value.text(),
        expected: groups.join(", or "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml;

    fn scope(declarations: &str, assigned: &[(&str, &str)]) -> Result<Scope, ReadError> {
        let text =
            format!("<A><ParameterDeclarations>\n{declarations}\n</ParameterDeclarations></A>");
        let document = xml::parse("x.xosc", &text).expect("it is well-formed");
        let assigned: Vec<Assignment> = assigned
            .iter()
            .map(|(name, value)| Assignment { name: (*name).into(), value: (*value).into() })
            .collect();
        Scope::default().with("x.xosc", &document.root, &assigned)
    }

    fn declared(name: &str, kind: &str, value: &str, inside: &str) -> String {
        format!(
            "<ParameterDeclaration name=\"{name}\" parameterType=\"{kind}\" value=\"{value}\">{inside}</ParameterDeclaration>\n"
        )
    }

    fn refusal(declarations: &str, assigned: &[(&str, &str)]) -> String {
        scope(declarations, assigned).expect_err("it is wrong").to_string()
    }

    #[test]
    fn an_error_shows_the_begin_of_a_long_expression() {
        assert_eq!(excerpt("${1 + 2}"), "${1 + 2}");
        let long = excerpt(&"(".repeat(100_000)).into_owned();
        assert!(long.ends_with('…') && long.chars().count() == MOST_SHOWN + 1, "{long}");
    }

    #[test]
    fn declarations_refer_to_each_other_in_any_order() {
        let text = declared("gap", "double", "${2 * $v}", "")
            + &declared("v", "double", "${60 / 3.6}", "");
        let scope = scope(&text, &[("v", "10")]).expect("it is right");
        assert_eq!(scope.value("gap"), Some(&Value::Number(20.0)));
    }

    #[test]
    fn a_circle_is_named() {
        let text = declared("a", "double", "$b", "") + &declared("b", "double", "${$a + 1}", "");
        assert_eq!(
            refusal(&text, &[]),
            "x.xosc:2: parameter `a` depends on itself (a -> b -> a), expected no circle"
        );
    }

    #[test]
    fn one_group_of_constraints_must_hold() {
        let group = |bounds: &str| format!("<ConstraintGroup>{bounds}</ConstraintGroup>");
        let bound = |rule: &str, value: &str| {
            format!("<ValueConstraint rule=\"{rule}\" value=\"{value}\"/>")
        };
        let range = group(&(bound("greaterThan", "0") + &bound("lessOrEqual", "$top")));
        let text = declared("v", "double", "60", &(range + &group(&bound("equalTo", "-1"))))
            + &declared("top", "double", "60", "");
        for (value, holds) in [("60", true), ("0", false), ("60.5", false), ("-1", true)] {
            let outcome = scope(&text, &[("v", value)]);
            assert_eq!(outcome.is_ok(), holds, "{value}");
            assert!(holds || matches!(outcome, Err(ReadError::Constraint { .. })));
        }
        assert_eq!(
            refusal(&text, &[("v", "0")]),
            "x.xosc:2: parameter `v` has the value 0, expected greaterThan 0 and lessOrEqual 60, or equalTo -1"
        );
    }

    #[test]
    fn types_are_checked() {
        assert!(refusal(&declared("n", "integer", "1.5", ""), &[]).contains("whole number"));
        assert!(
            refusal(&declared("n", "double", "fast", ""), &[])
                .contains("`fast` is not of type double")
        );
        assert!(refusal(&declared("n", "speed", "1", ""), &[]).contains("is not a type"));
        let shown = refusal(&declared("n", "double", "1", ""), &[("n", "x")]);
        assert_eq!(shown, "parameter n=x: x.xosc declares it as double, expected a number");
        let shown = refusal(&declared("n", "double", "1", ""), &[("m", "1")]);
        assert_eq!(shown, "parameter m=1: x.xosc does not declare it, expected `n`");
        let shown = refusal(&declared("n", "double", "$m", ""), &[]);
        assert!(shown.starts_with("x.xosc:2: parameter `m` is not declared"), "{shown}");
    }
}
