//! Triggers and conditions, and the states of a storyboard's parts.

use serde::{Deserialize, Serialize};

use super::Category;
use super::position::Position;
use crate::expression::Value;
use crate::words::{Rule, word_enums};

/// A trigger: it fires when one group holds. A group holds when all its conditions do.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Trigger(pub Vec<Vec<Condition>>);

/// A condition with its edge and delay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// The change that it waits for.
    pub edge: Edge,
    /// Delay after the edge, ns.
    pub delay_ns: u64,
    pub test: Test,
}

word_enums! {
    /// The change of a test that a condition waits for.
    Edge {
        /// No change: the condition holds while its test does.
        None: "none",
        /// From false to true.
        Rising: "rising",
        /// From true to false.
        Falling: "falling",
        RisingOrFalling: "risingOrFalling",
    }

    /// The direction of a distance.
    Along {
        /// Along the axes.
        Longitudinal: "longitudinal",
        /// Across the axes.
        Lateral: "lateral",
        /// In a straight line.
        Euclidean: "euclidianDistance" | "euclideanDistance" | "cartesianDistance",
    }
}

/// A test: the subject of a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Time since the start, s.
    Time { rule: Rule, value: f64 },
    /// A parameter or variable.
    Value {
        /// Its place among the script's values.
        of: usize,
        rule: Rule,
        value: Value,
    },
    /// A part of the storyboard.
    Element {
        kind: ElementKind,
        /// Its name, or its path with `::`.
        name: String,
        state: ElementState,
    },
    /// A test of entities.
    Entity {
        entities: Vec<usize>,
        /// True if all of them must meet it, rather than one.
        all: bool,
        /// The test of each.
        is: EntityTest,
    },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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
    Acceleration { rule: Rule, value: f64 },
    /// Speed, m/s.
    Speed { rule: Rule, value: f64 },
    /// Own speed minus another's, m/s.
    RelativeSpeed { entity: usize, rule: Rule, value: f64 },
    ReachPosition {
        position: Position,
        /// Largest distance to it, m.
        tolerance_m: f64,
    },
    /// Distance, m.
    Distance { to: Measured, rule: Rule, value: f64 },
    /// Distance over own speed, s.
    Headway { to: Measured, rule: Rule, value: f64 },
    /// Distance over closing speed, s.
    TimeToCollision { to: Measured, rule: Rule, value: f64 },
    /// No other entity is in a part of the road.
    Clearance(Clearance),
}

/// A part of the road around an entity without others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clearance {
    /// The others that count.
    pub entities: Vec<usize>,
    /// Ranges of lanes to the left of the entity's own, both ends included.
    pub lanes: Vec<(i32, i32)>,
    pub ahead_m: f64,
    pub behind_m: f64,
    /// True if a body counts with its whole extent, not with its origin alone.
    pub freespace: bool,
    /// Lanes of the other direction count too.
    pub opposite: bool,
}

/// The other body of a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CollisionWith {
    Entity(usize),
    /// Any entity of a category.
    Category(Category),
}

/// Measure of a distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The far end.
    pub target: Target,
    /// True if it counts between the bodies, not the origins.
    pub freespace: bool,
    pub along: Along,
    /// True if its axes are the entity's, not the road's.
    pub entity_axes: bool,
}

/// The far end of a distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    Entity(usize),
    Position(Position),
}

word_enums! {
    /// The parts of a storyboard.
    ElementKind {
        Story: "story",
        Act: "act",
        ManeuverGroup: "maneuverGroup",
        Maneuver: "maneuver",
        Event: "event",
        Action: "action",
    }

    /// A state, or a transition between states, which lasts one step.
    ElementState {
        Standby: "standbyState",
        Running: "runningState",
        Complete: "completeState",
        StartTransition: "startTransition",
        EndTransition: "endTransition",
        StopTransition: "stopTransition",
        /// Was triggered and did not run.
        SkipTransition: "skipTransition",
    }
}
