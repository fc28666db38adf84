//! The file: header, variables, road.

use super::catalog::CatalogLocations;
use super::entity::{Controller, Entities, MiscObject, Pedestrian, Vehicle};
use super::environment::Environment;
use super::signal::TrafficSignals;
use super::storyboard::{Maneuver, Storyboard};
use super::trajectory::Trajectory;
use super::unused::{License, Properties, SceneGraphFile};
use crate::declare::{Literal, Text, elements};
use crate::error::Place;
use crate::model::Named;
use crate::model::condition::Trigger;
use crate::model::storyboard::Story;
use crate::parameter::ParameterDeclarations;

/// The stories, and the trigger that ends them.
type Board = (Vec<Story>, Option<Trigger>);

elements! { "File";
    /// a scenario
    ScenarioFile = "OpenSCENARIO" -> (String, Option<Board>) [] {
        description: FileHeader,
        _: Option<ParameterDeclarations>,
        _: Option<VariableDeclarations>,
        _: Option<CatalogLocations>,
        road: Option<RoadNetwork>,
        entities: Option<Entities>,
        storyboard: Option<Storyboard>,
    } |node| {
        if road != Some(true) {
            // It comes first, where a user looks for the road.
            let text = "no road file: a straight road with lanes of 3.5 m is assumed".to_owned();
            node.scene.notices.borrow_mut().insert(0, text);
        }
        Ok((description, entities.and(storyboard)))
    }

    /// a catalog
    CatalogFile = "OpenSCENARIO" -> () [] {_: FileHeader, _: Catalog}

    /// version 1.0 to 1.3; the description becomes the scenario's
    FileHeader -> String
    ["revMajor" _: Text, "revMinor" _: Text, "description" description: Option<Text>]
    {_: Option<License>, _: Option<Properties>}
    unused ["date?" "author?"]
    { Ok(description.unwrap_or_default()) }

    /// variables of the storyboard
    VariableDeclarations -> () [] {variables: Vec<VariableDeclaration>}
    |node| {
        node.scene.values.borrow_mut().extend(variables);
        Ok(())
    }

    /// read and changed while the storyboard runs
    VariableDeclaration -> Named ["name" name: Text, "value" value: Literal] {}
    unused ["variableType"]
    { Ok(Named { name, value }) }

    /// the road; without one, lanes of 3.5 m on a straight road are assumed
    RoadNetwork -> bool [] {
        file: Option<LogicFile>,
        _: Option<SceneGraphFile>,
        _: Option<TrafficSignals>,
    }
    |node| {
        let Some((path, place)) = file else { return Ok(false) };
        node.scene.open_road(&path, &place)?;
        Ok(true)
    }

    /// an OpenDRIVE file, see "Roads"
    LogicFile -> (String, Place) ["filepath" path: Text] {} |node| { Ok((path, node.place())) }
}

elements! { "Parameters and catalogs";
    /// entries for catalog references; only the entries in use have to be in the subset
    Catalog -> () ["name" _: Text] {
        _: Vec<Vehicle>,
        _: Vec<Pedestrian>,
        _: Vec<MiscObject>,
        _: Vec<Controller>,
        _: Vec<Trajectory>,
        _: Vec<Maneuver>,
        _: Vec<Environment>,
    }
}
