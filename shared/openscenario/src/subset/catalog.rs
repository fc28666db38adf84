//! Catalogs, and elements that stand in them.

use std::marker::PhantomData;

use crate::declare::{
    CATALOG_VERSIONS, Choice, Element, Form, Node, Text, check, check_head, elements,
};
use crate::error::{Place, ReadError, meant, one_of};
use crate::parameter::{Assignment, ParameterAssignments, opened};
use crate::scene::Location;
use crate::scope::Scope;
use crate::xml;

/// An entry that a `CatalogReference` names.
pub(crate) struct Reference {
    catalog: String,
    entry: String,
    assigned: Vec<Assignment>,
}

elements! { "Parameters and catalogs";
    /// directories, relative to the scenario file
    CatalogLocations -> () [] {
        _: Option<VehicleCatalog>,
        _: Option<PedestrianCatalog>,
        _: Option<MiscObjectCatalog>,
        _: Option<ControllerCatalog>,
        _: Option<TrajectoryCatalog>,
        _: Option<ManeuverCatalog>,
        _: Option<EnvironmentCatalog>,
        _: Option<RouteCatalog>,
    }

    /// searched for entries of its kind
    VehicleCatalog | PedestrianCatalog | MiscObjectCatalog | ControllerCatalog | TrajectoryCatalog
        | ManeuverCatalog | EnvironmentCatalog | RouteCatalog -> ()
    [] {directory: Directory}
    |node| {
        let (path, place) = directory;
        node.scene.locations.borrow_mut().push(Location { name: node.name().to_owned(), path, place });
        Ok(())
    }

    /// each `.xosc` file in it is a catalog
    Directory -> (String, Place) ["path" path: Text] {} |node| { Ok((path, node.place())) }

    /// the entry, with its parameters assigned
    CatalogReference -> Reference ["catalogName" catalog: Text, "entryName" entry: Text]
    {assigned: Option<ParameterAssignments>}
    { Ok(Reference { catalog, entry, assigned: assigned.unwrap_or_default() }) }
}

/// A `CatalogReference` to one of some elements: it reads the entry.
pub(super) struct FromCatalog<C>(PhantomData<C>);

impl<C: Choice> Element for FromCatalog<C> {
    const NAME: &'static str = CatalogReference::NAME;
    const FORM: &'static Form = CatalogReference::FORM;
    type Value = C::Value;

    fn read(node: Node<'_>) -> Result<C::Value, ReadError> {
        let Reference { catalog, entry, assigned } = &CatalogReference::read(node)?;
        let kind_of = |name: &str| C::ALTERNATIVES.iter().find(|(known, _)| *known == name);
        let locations = node.scene.locations.borrow().clone();
        let mut seen: Vec<String> = Vec::new();
        // The catalogs of `Vehicle`s are in the `VehicleCatalog`, and so on.
        let searched = locations
            .iter()
            .filter(|location| kind_of(location.name.trim_end_matches("Catalog")).is_some());
        for location in searched {
            for document in node.scene.catalogs(location)?.iter() {
                check_head(document, CATALOG_VERSIONS)?;
                let Some(found) = document.root.child("Catalog") else { continue };
                let name = found.attribute("name").unwrap_or_default();
                seen.push(name.to_owned());
                if name != catalog {
                    continue;
                }
                let named =
                    |element: &&xml::Element| element.attribute("name") == Some(entry.as_str());
                let Some(element) = found.children.iter().find(named) else {
                    let known = found.children.iter().filter_map(|entry| entry.attribute("name"));
                    return Err(node.refuse(
                        format!("catalog `{catalog}` ({}) has no entry `{entry}`", document.file),
                        meant(entry, known),
                    ));
                };
                let Some((_, form)) = kind_of(&element.name) else {
                    return Err(node.refuse(
                        format!("`{entry}` of catalog `{catalog}` is a `{}`", element.name),
                        one_of(C::ALTERNATIVES.iter().map(|(name, _)| *name)),
                    ));
                };
                let header = document.root.child("FileHeader");
                if header.and_then(|header| header.attribute("revMajor")) == Some("0") {
                    node.scene.notice(format!(
                        "{}: a catalog of version 0.9: its entries are read as those of 1.0",
                        document.file
                    ));
                }
                check(&document.file, element, form)?;
                let read = |outside: &Scope| {
                    let inside = Node { file: &document.file, element, scope: outside, ..node };
                    let scope =
                        opened(inside, assigned).map_err(|error| error.given_at(&node.place()))?;
                    C::read_chosen(Node { scope: &scope, ..inside })
                };
                // In the standard an entry sees its own parameters alone; esmini's files use the scenario's too.
                return match read(&Scope::default()) {
                    Err(error @ ReadError::Parameter { .. }) => {
                        let value = read(node.scope).map_err(|_| error)?;
                        node.scene.notice(format!(
                            "{}: `{entry}` uses parameters of the scenario that it does not declare",
                            document.file
                        ));
                        Ok(value)
                    }
                    other => other,
                };
            }
        }
        seen.sort();
        Err(node.refuse(
            format!("catalog `{catalog}` is in none of the catalog locations"),
            match seen.is_empty() {
                true => "a location with catalogs of this kind".to_owned(),
                false => meant(catalog, seen.iter().map(String::as_str)),
            },
        ))
    }
}
