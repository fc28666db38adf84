//! A scenario with every value resolved.
//!
//! [`Script`] is plain data: it can be serialised (`serde`), and built without any XML. Entities, parameters
//! and variables are referred to by their place in the script's lists.

pub mod action;
pub mod condition;
pub mod position;
pub mod storyboard;
pub mod timed;

use serde::{Deserialize, Serialize};

use crate::expression::Value;
use crate::road::Road;
use crate::words::word_enums;
use action::Action;
use condition::Trigger;
use storyboard::Story;

/// Most entities, the ego included.
pub const MAX_ENTITIES: usize = 65;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Script {
    /// Each is a row of roads of the file. A road may be in several.
    pub roads: Vec<Road>,
    /// The ego's place among the entities.
    pub ego: usize,
    pub entities: Vec<Entity>,
    /// Parameters and variables that the storyboard compares or changes.
    pub values: Vec<Named>,
    /// Actions before the first step, in order.
    pub init: Vec<InitAction>,
    pub stories: Vec<Story>,
    pub stop: Option<Trigger>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entity {
    pub name: String,
    pub category: Category,
    pub body: Body,
    pub drive: Drive,
}

word_enums! {
    Category {
        /// A car, van, lorry, bus, motorbike, bicycle, trailer, train or tram.
        Vehicle: "vehicle",
        /// A pedestrian, wheelchair or animal.
        Pedestrian: "pedestrian",
        MiscObject: "miscellaneous",
    }
}

/// Mover of an entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drive {
    Scripted,
    /// The caller: for the ego, and for traffic with profiles of its own.
    External,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Centre of the box ahead of the entity's origin, m.
    pub center_ahead_m: f64,
    /// Centre of the box to the left of the entity's origin, m.
    pub center_left_m: f64,
    pub length_m: f64,
    pub width_m: f64,
}

/// A parameter or variable with its value at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Named {
    pub name: String,
    pub value: Value,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InitAction {
    /// The acting entity; none for an action of the world.
    pub actor: Option<usize>,
    pub action: Action,
}

impl Script {
    /// The place of the entity with a name.
    pub fn entity(&self, name: &str) -> Option<usize> {
        self.entities.iter().position(|entity| entity.name == name)
    }
}
