//! Entities, and which of them is the ego.

use super::Reader;
use crate::error::{ReadError, one_of};
use crate::model::{Body, Category, Drive, Entity, MAX_ENTITIES, Named};
use crate::node::Node;

/// Largest extent of a body, m.
const MAX_EXTENT_M: f64 = 100.0;

impl Reader<'_> {
    pub(super) fn read_entities(&mut self) -> Result<(), ReadError> {
        let list = self.root.child("Entities")?;
        let mut controlled = Vec::new();
        for object in list.named("ScenarioObject") {
            let name = object.text("name")?;
            if self.entities.iter().any(|entity| entity.name == name) {
                let reason = format!("`{name}` is there twice");
                return Err(object.fault("name").error(reason, "a name of its own"));
            }
            if self.entities.len() == MAX_ENTITIES {
                return Err(object.refuse("too many entities", format!("at most {MAX_ENTITIES}")));
            }
            let entity = self.entity(object, name)?;
            for controller in object.named("ObjectController") {
                if let Some(reference) = controller.child_if("CatalogReference") {
                    let locations = self.root.child_if("CatalogLocations");
                    let found = &mut |_: Node<'_>| Ok(());
                    self.library.entry(reference, locations, &["Controller"], found)?;
                }
                if controller.children().next().is_some() {
                    controlled.push(self.entities.len());
                }
            }
            self.entities.push(entity);
        }
        controlled.dedup();
        let called = |name: &str| {
            self.entities.iter().position(|entity| entity.name.eq_ignore_ascii_case(name))
        };
        let named = called("ego").or_else(|| called("hero"));
        self.ego = match (named, controlled.as_slice()) {
            (Some(ego), _) => ego,
            (None, [only]) => *only,
            (None, []) if self.entities.len() == 1 => 0,
            (None, _) => {
                let names = one_of(self.entities.iter().map(|entity| entity.name.as_str()));
                return Err(list.refuse(
                    format!("none of {names} is known to be the ego"),
                    "an entity called `Ego` or `hero`, or exactly one with an `ObjectController`",
                ));
            }
        };
        self.entities[self.ego].drive = Drive::External;
        if controlled.iter().any(|entity| *entity != self.ego) {
            self.notice("controllers of entities other than the ego have no effect".to_owned());
        }
        for selection in list.named("EntitySelection") {
            let mut members = Vec::new();
            for member in selection.child("Members")?.children() {
                members.push(self.entity_ref(member)?);
            }
            self.selections.push((selection.text("name")?, members));
        }
        Ok(())
    }

    fn entity(&self, object: Node<'_>, name: String) -> Result<Entity, ReadError> {
        const KINDS: &[&str] = &["Vehicle", "Pedestrian", "MiscObject"];
        let what = object.chosen(&["CatalogReference", "Vehicle", "Pedestrian", "MiscObject"])?;
        if what.name() == "CatalogReference" {
            let locations = self.root.child_if("CatalogLocations");
            let found = &mut |entry: Node<'_>| described(entry, name.clone());
            return self.library.entry(what, locations, KINDS, found);
        }
        let scope = what.scope.with(what.file, what.element, &[])?;
        described(Node { scope: &scope, ..what }, name)
    }

    /// The entity that `entityRef` names.
    pub(super) fn entity_ref(&self, node: Node<'_>) -> Result<usize, ReadError> {
        let name = node.text("entityRef")?;
        self.entities.iter().position(|entity| entity.name == name).ok_or_else(|| {
            node.fault("entityRef").error(
                format!("there is no entity `{name}`"),
                one_of(self.entities.iter().map(|entity| entity.name.as_str())),
            )
        })
    }

    /// The entities that a list of references names, selections taken apart.
    pub(super) fn entity_refs(&self, list: Node<'_>) -> Result<Vec<usize>, ReadError> {
        let mut entities = Vec::new();
        for node in list.named("EntityRef") {
            let name = node.text("entityRef")?;
            match self.selections.iter().find(|(selection, _)| *selection == name) {
                Some((_, members)) => entities.extend_from_slice(members),
                None => entities.push(self.entity_ref(node)?),
            }
        }
        Ok(entities)
    }

    pub(super) fn read_variables(&mut self) -> Result<(), ReadError> {
        let Some(list) = self.root.child_if("VariableDeclarations") else { return Ok(()) };
        for node in list.children() {
            let value = node.value("value")?.expect("the subset demands it");
            self.values.borrow_mut().push(Named { name: node.text("name")?, value });
        }
        Ok(())
    }

    /// The place of a parameter or variable among the script's values.
    pub(super) fn value_ref(
        &self,
        node: Node<'_>,
        attribute: &'static str,
    ) -> Result<usize, ReadError> {
        let raw = node.element.attribute(attribute).unwrap_or_default();
        let name = raw.trim_start_matches('$');
        let mut values = self.values.borrow_mut();
        if let Some(known) = values.iter().position(|value| value.name == name) {
            return Ok(known);
        }
        let Some(value) = node.scope.value(name).filter(|_| attribute == "parameterRef") else {
            let names: Vec<&str> = match attribute {
                "parameterRef" => node.scope.iter().map(|(name, _)| name).collect(),
                _ => values.iter().map(|value| value.name.as_str()).collect(),
            };
            let reason = format!("`{name}` is not declared");
            return Err(node.fault(attribute).error(reason, one_of(names)));
        };
        values.push(Named { name: name.to_owned(), value: value.clone() });
        Ok(values.len() - 1)
    }
}

/// An entity from its description in the scenario or in a catalog.
fn described(node: Node<'_>, name: String) -> Result<Entity, ReadError> {
    let category = match node.name() {
        "Vehicle" => Category::Vehicle,
        "Pedestrian" => Category::Pedestrian,
        _ => Category::MiscObject,
    };
    if let Some(trailer) = node.child_if("Trailer") {
        let pulled = trailer.child("TrailerRef")?;
        let name = pulled.text("entityRef")?;
        if !name.is_empty() {
            let reason = format!("`{name}` would be pulled as a trailer");
            return Err(pulled.fault("entityRef").error(reason, "none (an empty reference)"));
        }
    }
    let bounding = node.child("BoundingBox")?;
    let (center, dimensions) = (bounding.child("Center")?, bounding.child("Dimensions")?);
    let extent = |attribute| match dimensions.magnitude(attribute)? {
        metres if metres > 0.0 && metres <= MAX_EXTENT_M => Ok(metres),
        metres => Err(dimensions
            .fault(attribute)
            .error(format!("{metres} m"), format!("more than 0 and at most {MAX_EXTENT_M}"))),
    };
    dimensions.magnitude("height")?;
    let body = Body {
        center_ahead_m: center.number("x")?,
        center_left_m: center.number("y")?,
        length_m: extent("length")?,
        width_m: extent("width")?,
    };
    Ok(Entity { name, category, body, drive: Drive::Scripted })
}
