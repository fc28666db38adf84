//! What storyboards wait for.

use serde::{Deserialize, Serialize};

use super::Category;
use super::element::{ElementKind, ElementState};
use super::position::Position;
use crate::expression::Value;
use crate::parameter::Rule;

/// Fires when one group holds: a group holds when all its conditions do.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Trigger(pub Vec<Vec<Condition>>);

/// A condition with its edge and delay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// What must change for it to hold.
    #[serde(default)]
    pub edge: Edge,
    /// How much later it holds, ns.
    #[serde(default)]
    pub delay_ns: u64,
    /// What it looks at.
    pub test: Test,
}

/// What must change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edge {
    /// Nothing: it holds while its test does.
    #[default]
    None,
    /// From false to true.
    Rising,
    /// From true to false.
    Falling,
    /// Either.
    RisingOrFalling,
}

/// What a condition looks at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Test {
    /// Time since the start, s.
    Time {
        /// How it compares.
        rule: Rule,
        /// With what, s.
        value: f64,
    },
    /// A parameter or variable.
    Value {
        /// Which, among the script's values.
        of: usize,
        /// How it compares.
        rule: Rule,
        /// With what.
        value: Value,
    },
    /// A part of the storyboard.
    Element {
        /// What kind of part.
        kind: ElementKind,
        /// Its name, or its path with `::`.
        name: String,
        /// The state or transition.
        state: ElementState,
    },
    /// Something about entities.
    Entity {
        /// Which.
        entities: Vec<usize>,
        /// All of them, or any.
        all: bool,
        /// What.
        is: EntityTest,
    },
}

/// Something about an entity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum EntityTest {
    /// At the road's end for that long, s.
    EndOfRoad(f64),
    /// Outside all lanes for that long, s.
    Offroad(f64),
    /// Speed 0 for that long, s.
    StandStill(f64),
    /// Bodies overlap.
    Collision(CollisionWith),
    /// At least that far since the start, m.
    TraveledDistance(f64),
    /// Acceleration, m/s².
    Acceleration {
        /// How it compares.
        rule: Rule,
        /// With what, m/s².
        value: f64,
    },
    /// Speed, m/s.
    Speed {
        /// How it compares.
        rule: Rule,
        /// With what, m/s.
        value: f64,
    },
    /// Own speed minus another's, m/s.
    RelativeSpeed {
        /// The other.
        entity: usize,
        /// How it compares.
        rule: Rule,
        /// With what, m/s.
        value: f64,
    },
    /// Near a position.
    ReachPosition {
        /// Where.
        position: Position,
        /// How near, m.
        tolerance_m: f64,
    },
    /// Distance, m.
    Distance {
        /// To what.
        to: Measured,
        /// How it compares.
        rule: Rule,
        /// With what, m.
        value: f64,
    },
    /// Distance over own speed, s.
    Headway {
        /// To what.
        to: Measured,
        /// How it compares.
        rule: Rule,
        /// With what, s.
        value: f64,
    },
    /// Distance over closing speed, s.
    TimeToCollision {
        /// To what.
        to: Measured,
        /// How it compares.
        rule: Rule,
        /// With what, s.
        value: f64,
    },
}

/// What a body touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CollisionWith {
    /// This entity.
    Entity(usize),
    /// Any of a kind.
    Category(Category),
}

/// A distance to something.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// To what.
    pub target: Target,
    /// Between the bodies rather than the origins.
    pub freespace: bool,
    /// Along which direction.
    pub along: Along,
    /// Directions are the entity's own rather than the road's.
    pub entity_axes: bool,
}

/// The far end of a distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// An entity.
    Entity(usize),
    /// A position.
    Position(Position),
}

/// The direction of a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Along {
    /// Ahead.
    Longitudinal,
    /// Aside.
    Lateral,
    /// Straight.
    Euclidean,
}
