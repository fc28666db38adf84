//! Names of entities and values in attributes.

use crate::declare::scalars;
use crate::error::meant;
use crate::model::Named;

scalars! {
    /// The name of an entity; its value is the entity's place in the list.
    pub(super) EntityName -> usize: "an entity", |given| {
        let name = given.text()?;
        let entities = given.node.scene.entities.borrow();
        let names = entities.iter().map(|entity| entity.name.as_str());
        place_of(&name, names).map_err(|Unknown(expected)| {
            given.raw.wrong(format!("there is no entity `{name}`"), expected)
        })
    };

    /// The name of an entity or of a selection of several.
    pub(super) EntityNames -> Vec<usize>: "an entity or a selection", |given| {
        let name = given.text()?;
        let selections = given.node.scene.selections.borrow();
        match selections.iter().find(|(selection, _)| *selection == name) {
            Some((_, members)) => Ok(members.clone()),
            None => EntityName::take(given).map(|entity| vec![entity]),
        }
    };

    /// The name of a parameter; its value is its place among the values of the script.
    pub(super) ParameterName -> usize: "a parameter", |given| {
        let name = given.raw.text.trim_start_matches('$');
        let mut values = given.node.scene.values.borrow_mut();
        if let Some(known) = values.iter().position(|value| value.name == name) {
            return Ok(known);
        }
        let Some(value) = given.node.scope.value(name).cloned() else {
            let names = given.node.scope.iter().map(|(name, _)| name);
            return Err(given.raw.wrong(format!("`{name}` is not declared"), meant(name, names)));
        };
        values.push(Named { name: name.to_owned(), value });
        Ok(values.len() - 1)
    };

    /// The name of a variable; its value is its place among the values of the script.
    pub(super) VariableName -> usize: "a variable", |given| {
        let name = given.raw.text.trim_start_matches('$');
        let values = given.node.scene.values.borrow();
        place_of(name, values.iter().map(|value| value.name.as_str()))
            .map_err(|Unknown(expected)| given.raw.wrong(format!("`{name}` is not declared"), expected))
    };
}

/// A name that is not known: the names that were expected, in words.
pub(super) struct Unknown(pub String);

/// The place of a name among others.
pub(super) fn place_of<'a>(
    name: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Unknown> {
    names.clone().position(|known| known == name).ok_or_else(|| Unknown(meant(name, names)))
}
