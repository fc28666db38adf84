//! Parameters: declarations, types, constraints.

use std::collections::BTreeMap;
use std::marker::PhantomData;

use crate::declare::{AtLeastOne, Content, Element, Form, Later, Literal, Node, Text, elements};
use crate::error::{Place, ReadError, meant};
use crate::expression::Value;
use crate::scope::{Raw, Scope, undeclared};
use crate::words::{Rule, Words, instant_s, word_enums};

/// A value that `--param` or a variation gives to a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assignment {
    pub name: String,
    /// Its value, as an attribute would hold it.
    pub value: String,
}

word_enums! {
    Type {
        Text: "string",
        Double: "double",
        Integer: "integer" | "int",
        Unsigned: "unsignedInt" | "unsignedShort",
        Boolean: "boolean",
        Instant: "dateTime",
    }
}

impl Type {
    /// The value in this type, or what was expected.
    fn take(self, value: Value) -> Result<Value, &'static str> {
        let whole = |number: &f64| libm::trunc(*number) == *number;
        match (self, value) {
            (Self::Text, value) => Ok(Value::Text(value.text())),
            (Self::Instant, Value::Text(text)) if instant_s(text.trim()).is_some() => {
                Ok(Value::Text(text))
            }
            (Self::Instant, _) => Err("a date and time, such as 2026-05-01T12:00:00"),
            (Self::Boolean, Value::Boolean(value)) => Ok(Value::Boolean(value)),
            (Self::Boolean, Value::Text(text)) if text == "1" => Ok(Value::Boolean(true)),
            (Self::Boolean, Value::Number(number)) if number == 0.0 || number == 1.0 => {
                Ok(Value::Boolean(number == 1.0))
            }
            (Self::Boolean, _) => Err("true or false"),
            (Self::Double, value) => value.number().map(Value::Number).ok_or("a number"),
            (Self::Integer, value) => {
                value.number().filter(whole).map(Value::Number).ok_or("a whole number")
            }
            (Self::Unsigned, value) => {
                let number = value.number().filter(|number| whole(number) && *number >= 0.0);
                number.map(Value::Number).ok_or("a whole number, 0 or more")
            }
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Declaration {
    place: Place,
    name: String,
    kind: Type,
    value: Raw,
    /// One of these groups must hold, with all its constraints.
    groups: Vec<Vec<Constraint>>,
}

#[derive(Clone, Debug)]
pub(crate) struct Constraint {
    rule: Raw,
    value: Raw,
}

elements! { "Parameters and catalogs";
    /// parameters of the file, of a catalog entry or of a part of the storyboard
    ParameterDeclarations -> Vec<Declaration> [] {declarations: Vec<ParameterDeclaration>}

    /// the value is a literal, `$name` or `${expression}`; `--param` and variations set it
    ParameterDeclaration -> Declaration
    ["name" name: Later<Text>, "parameterType" kind: Type, "value" value: Later<Literal>]
    {groups: Vec<ConstraintGroup>}
    |node| { Ok(Declaration { place: node.place(), name: name.text, kind, value, groups }) }

    /// holds when all its constraints hold; one of several groups must hold
    ConstraintGroup -> Vec<Constraint> [] {constraints: AtLeastOne<ValueConstraint>}

    /// compares numbers, dates or truth values by the parameter's type, else numbers where both are numbers, or texts
    ValueConstraint -> Constraint ["rule" rule: Later<Rule>, "value" value: Later<Literal>] {}
    { Ok(Constraint { rule, value }) }

    /// values for the entry's parameters
    ParameterAssignments -> Vec<Assignment> [] {assignments: Vec<ParameterAssignment>}

    /// a parameter's name, with `$` or without, and its value
    ParameterAssignment -> Assignment ["parameterRef" name: Later<Text>, "value" value: Text] {}
    { Ok(Assignment { name: name.text.trim_start_matches('$').to_owned(), value }) }
}

/// An element that declares parameters: it is read in a scope with them.
pub(crate) struct Scoped<E>(PhantomData<E>);

impl<E: Element> Element for Scoped<E> {
    const NAME: &'static str = E::NAME;
    const FORM: &'static Form = E::FORM;
    type Value = E::Value;

    fn read(node: Node<'_>) -> Result<E::Value, ReadError> {
        let scope = opened(node, &[])?;
        E::read(Node { scope: &scope, ..node })
    }
}

/// The scope inside an element: its own scope with the parameters that it declares. `assigned` values
/// replace the declared ones.
///
/// # Errors
/// When a declaration is circular, ill-typed or breaks its constraints, or an assignment names no
/// parameter.
pub(crate) fn opened(node: Node<'_>, assigned: &[Assignment]) -> Result<Scope, ReadError> {
    let declared = Option::<ParameterDeclarations>::read_inside(node)?.unwrap_or_default();
    let named = |name: &str| declared.iter().find(|declaration| declaration.name == name);
    if let Some(unknown) = assigned.iter().find(|assignment| named(&assignment.name).is_none()) {
        return Err(ReadError::Override {
            name: unknown.name.clone(),
            value: unknown.value.clone(),
            reason: format!("{} does not declare it", node.file),
            expected: meant(&unknown.name, names(&declared)),
        });
    }
    let mut values = Values {
        file: node.file,
        declared: &declared,
        assigned,
        outer: node.scope,
        known: BTreeMap::new(),
        open: Vec::new(),
    };
    for (i, declaration) in declared.iter().enumerate() {
        if declared[..i].iter().any(|other| other.name == declaration.name) {
            return Err(declaration.fault("is declared twice", "one declaration"));
        }
        values.of(declaration)?;
    }
    let scope = node.scope.extended(values.known);
    declared.iter().try_for_each(|declaration| declaration.constrain(&scope))?;
    Ok(scope)
}

fn names(declared: &[Declaration]) -> impl Iterator<Item = &str> {
    declared.iter().map(|declaration| declaration.name.as_str())
}

impl Declaration {
    fn fault(&self, reason: &str, expected: impl Into<String>) -> ReadError {
        ReadError::Parameter {
            place: self.place.clone(),
            parameter: self.name.clone(),
            reason: reason.to_owned(),
            expected: expected.into(),
        }
    }

    fn constrain(&self, scope: &Scope) -> Result<(), ReadError> {
        let Some(value) = scope.value(&self.name) else { return Ok(()) };
        let mut broken = Vec::new();
        for group in &self.groups {
            let mut holds = true;
            let mut words = Vec::new();
            for Constraint { rule, value: bound } in group {
                let name = rule.resolve(scope)?.text();
                let Some((_, meaning)) = Rule::WORDS.iter().find(|(known, _)| *known == name)
                else {
                    let expected = meant(&name, Rule::WORDS.iter().map(|rule| rule.0));
                    return Err(rule.wrong(format!("`{name}` is not a rule"), expected));
                };
                let kind = self.kind;
                let typed = kind.take(bound.resolve(scope)?).map_err(|expected| {
                    bound
                        .wrong(format!("`{}` is not of type {}", bound.text, kind.word()), expected)
                })?;
                let comparable = |value: &Value| match kind {
                    Type::Instant => instant_s(value.text().trim()).map(Value::Number),
                    _ => None,
                };
                holds &= match comparable(value).zip(comparable(&typed)) {
                    Some((value, typed)) => meaning.compares(&value, &typed),
                    None => meaning.compares(value, &typed),
                };
                words.push(format!("{name} {}", typed.text()));
            }
            if holds {
                return Ok(());
            }
            broken.push(words.join(" and "));
        }
        match broken.is_empty() {
            true => Ok(()),
            false => Err(ReadError::Constraint {
                place: self.place.clone(),
                parameter: self.name.clone(),
                value: value.text(),
                expected: broken.join(", or "),
            }),
        }
    }
}

/// The values of a list of declarations, each of which may refer to the others.
struct Values<'a> {
    file: &'a str,
    declared: &'a [Declaration],
    assigned: &'a [Assignment],
    outer: &'a Scope,
    known: BTreeMap<String, Value>,
    /// Parameters whose values are being found: one of them again makes a circle.
    open: Vec<&'a str>,
}

impl<'a> Values<'a> {
    fn of(&mut self, declaration: &'a Declaration) -> Result<Value, ReadError> {
        let name = declaration.name.as_str();
        if let Some(value) = self.known.get(name) {
            return Ok(value.clone());
        }
        if let Some(start) = self.open.iter().position(|open| *open == name) {
            let circle = [&self.open[start..], &[name]].concat().join(" -> ");
            return Err(declaration.fault(&format!("depends on itself ({circle})"), "no circle"));
        }
        self.open.push(name);
        let assigned = self.assigned.iter().rev().find(|assignment| assignment.name == name);
        let mut raw = declaration.value.clone();
        if let Some(assignment) = assigned {
            raw.text.clone_from(&assignment.value);
        }
        let (declared, outer) = (self.declared, self.outer);
        let find = |other: &str| declared.iter().find(|declaration| declaration.name == other);
        let value = raw.resolve_by(&mut |other| match find(other) {
            Some(found) => self.of(found),
            None => outer.value(other).cloned().ok_or_else(|| {
                undeclared(&declaration.place, other, meant(other, names(declared)))
            }),
        })?;
        let (kind, type_name) = (declaration.kind, declaration.kind.word());
        let value = match kind {
            Type::Text if !raw.text.trim().starts_with('$') => Value::Text(raw.text.clone()),
            _ => value,
        };
        let value = kind.take(value).map_err(|expected| match assigned {
            Some(assignment) => ReadError::Override {
                name: name.to_owned(),
                value: assignment.value.clone(),
                reason: format!("{} declares it as {type_name}", self.file),
                expected: expected.to_owned(),
            },
            None => raw.wrong(format!("`{}` is not of type {type_name}", raw.text), expected),
        })?;
        self.open.pop();
        self.known.insert(name.to_owned(), value.clone());
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::memory::Memory;
    use crate::scene::Scene;
    use crate::xml;
    use std::path::Path;

    fn scope(declarations: &str, assigned: &[(&str, &str)]) -> Result<Scope, ReadError> {
        let text =
            format!("<A><ParameterDeclarations>\n{declarations}\n</ParameterDeclarations></A>");
        let document = xml::parse("x.xosc", &text).expect("it is well-formed");
        let assigned: Vec<Assignment> = assigned
            .iter()
            .map(|(name, value)| Assignment { name: (*name).into(), value: (*value).into() })
            .collect();
        let (scope, files) = (Scope::default(), Memory::of(&[]));
        let scene = Scene::new(&files, Path::new("x.xosc"));
        let node = Node { file: "x.xosc", element: &document.root, scope: &scope, scene: &scene };
        opened(node, &assigned)
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
            "x.xosc:2:1: parameter `a` depends on itself (a -> b -> a), expected no circle"
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
            "x.xosc:2:1: parameter `v` has the value 0, expected greaterThan 0 and lessOrEqual 60, or equalTo -1"
        );
    }

    #[test]
    fn truth_values_and_dates_are_compared_as_such() {
        let of = |kind: &str, value: &str, rule: &str, bound: &str| {
            let constraint = format!(
                "<ConstraintGroup><ValueConstraint rule=\"{rule}\" value=\"{bound}\"/></ConstraintGroup>"
            );
            scope(&declared("p", kind, value, &constraint), &[]).map(|_| ())
        };
        for (value, bound) in [("true", "1"), ("1", "true"), ("false", "0")] {
            assert_eq!(of("boolean", value, "equalTo", bound), Ok(()), "{value} {bound}");
            assert!(of("boolean", value, "notEqualTo", bound).is_err());
        }
        let (early, late) = ("2024-03-31T01:59:59+01:00", "2024-03-31T01:00:00Z");
        assert_eq!(of("dateTime", early, "lessThan", late), Ok(()));
        assert_eq!(of("dateTime", late, "greaterOrEqual", early), Ok(()));
        assert!(of("dateTime", late, "lessThan", early).is_err());
        let said = of("dateTime", late, "lessThan", "noon").expect_err("no date").to_string();
        assert!(
            said.contains("`noon` is not of type dateTime, expected a date and time"),
            "{said}"
        );
    }

    #[test]
    fn types_are_checked() {
        assert!(refusal(&declared("n", "integer", "1.5", ""), &[]).contains("whole number"));
        assert!(
            refusal(&declared("n", "double", "fast", ""), &[])
                .contains("`fast` is not of type double")
        );
        assert!(
            refusal(&declared("n", "speed", "1", ""), &[]).contains("`speed` is not supported")
        );
        let shown = refusal(&declared("n", "double", "1", ""), &[("n", "x")]);
        assert_eq!(shown, "parameter n=x: x.xosc declares it as double, expected a number");
        let shown = refusal(&declared("n", "double", "1", ""), &[("m", "1")]);
        assert_eq!(shown, "parameter m=1: x.xosc does not declare it, expected `n`");
        let shown = refusal(&declared("n", "double", "$m", ""), &[]);
        assert!(shown.starts_with("x.xosc:2:1: parameter `m` is not declared"), "{shown}");
    }
}
