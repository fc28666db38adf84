//! Triggers and conditions.

use super::{Reader, Reference};
use crate::error::ReadError;
use crate::model::Category;
use crate::model::condition::{
    Along, CollisionWith, Condition, Edge, EntityTest, Measured, Target, Test, Trigger,
};
use crate::model::element::{ElementKind, ElementState};
use crate::node::Node;
use crate::parameter::Rule;

/// Longest delay of a condition, s.
const MAX_DELAY_S: f64 = 1e6;

impl Reader<'_> {
    pub(super) fn trigger(&self, node: Node<'_>) -> Result<Trigger, ReadError> {
        node.children()
            .map(|group| {
                let meant =
                    group.children().filter(|condition| !self.is_without_meaning(*condition));
                meant.map(|condition| self.condition(condition)).collect()
            })
            .collect::<Result<_, _>>()
            .map(Trigger)
    }

    /// Whether a condition compares no parameter of the file. Files for CARLA name the criteria of its tests
    /// in this way: with an empty reference, or with a figure that only CARLA knows.
    fn is_without_meaning(&self, node: Node<'_>) -> bool {
        let about = node.child_if("ByValueCondition");
        let compared = about.and_then(|about| about.child_if("ParameterCondition"));
        let Some(compared) = compared else { return false };
        let name = compared.element.attribute("parameterRef").unwrap_or_default();
        let name = name.trim().trim_start_matches('$');
        let condition = node.element.attribute("name").unwrap_or_default();
        let is_criterion = condition.starts_with("criteria_");
        let is_left_out = name.is_empty() || is_criterion && compared.scope.value(name).is_none();
        if is_left_out {
            self.notice(
                "conditions on no parameter of the file are left out (criteria for CARLA)"
                    .to_owned(),
            );
        }
        is_left_out
    }

    fn condition(&self, node: Node<'_>) -> Result<Condition, ReadError> {
        let edges = [
            ("none", Edge::None),
            ("rising", Edge::Rising),
            ("falling", Edge::Falling),
            ("risingOrFalling", Edge::RisingOrFalling),
        ];
        let delay_s = node.number_or("delay", 0.0)?;
        if !(0.0..=MAX_DELAY_S).contains(&delay_s) {
            return Err(node.fault("delay").error(format!("{delay_s} s"), "0 or more"));
        }
        let about = node.chosen(&["ByEntityCondition", "ByValueCondition"])?;
        let test = match about.name() {
            "ByEntityCondition" => self.by_entity(about)?,
            _ => self.by_value(about.children().next().expect("the subset demands one"))?,
        };
        Ok(Condition {
            edge: node.word("conditionEdge", &edges)?,
            delay_ns: libm::round(delay_s * 1e9) as u64,
            test,
        })
    }

    fn by_value(&self, node: Node<'_>) -> Result<Test, ReadError> {
        let value_of = |attribute| -> Result<Test, ReadError> {
            let of = self.value_ref(node, attribute)?;
            let value = node.value("value")?.expect("the subset demands it");
            Ok(Test::Value { of, rule: rule(node)?, value })
        };
        match node.name() {
            "SimulationTimeCondition" => {
                Ok(Test::Time { rule: rule(node)?, value: node.number("value")? })
            }
            "ParameterCondition" => value_of("parameterRef"),
            "VariableCondition" => value_of("variableRef"),
            _ => {
                let kinds = [
                    ("story", ElementKind::Story),
                    ("act", ElementKind::Act),
                    ("maneuverGroup", ElementKind::ManeuverGroup),
                    ("maneuver", ElementKind::Maneuver),
                    ("event", ElementKind::Event),
                    ("action", ElementKind::Action),
                ];
                let states = [
                    ("standbyState", ElementState::Standby),
                    ("runningState", ElementState::Running),
                    ("completeState", ElementState::Complete),
                    ("startTransition", ElementState::StartTransition),
                    ("endTransition", ElementState::EndTransition),
                    ("stopTransition", ElementState::StopTransition),
                    ("skipTransition", ElementState::SkipTransition),
                ];
                let kind = node.word("storyboardElementType", &kinds)?;
                let name = node.text("storyboardElementRef")?;
                let state = node.word("state", &states)?;
                let reference = Reference { place: node.place(), kind, name: name.clone() };
                self.references.borrow_mut().push(reference);
                Ok(Test::Element { kind, name, state })
            }
        }
    }

    fn by_entity(&self, node: Node<'_>) -> Result<Test, ReadError> {
        let list = node.child("TriggeringEntities")?;
        let all = list.word("triggeringEntitiesRule", &[("any", false), ("all", true)])?;
        let entities = self.entity_refs(list)?;
        let what = node.child("EntityCondition")?.children().next();
        let is = self.entity_test(what.expect("the subset demands one"))?;
        Ok(Test::Entity { entities, all, is })
    }

    fn entity_test(&self, node: Node<'_>) -> Result<EntityTest, ReadError> {
        Ok(match node.name() {
            "EndOfRoadCondition" => EntityTest::EndOfRoad(node.magnitude("duration")?),
            "OffroadCondition" => EntityTest::Offroad(node.magnitude("duration")?),
            "StandStillCondition" => EntityTest::StandStill(node.magnitude("duration")?),
            "TraveledDistanceCondition" => EntityTest::TraveledDistance(node.magnitude("value")?),
            "CollisionCondition" => EntityTest::Collision(self.collision(node)?),
            "AccelerationCondition" => {
                directed(node)?;
                EntityTest::Acceleration { rule: rule(node)?, value: node.number("value")? }
            }
            "SpeedCondition" => {
                directed(node)?;
                EntityTest::Speed { rule: rule(node)?, value: node.number("value")? }
            }
            "RelativeSpeedCondition" => {
                directed(node)?;
                let entity = self.entity_ref(node)?;
                EntityTest::RelativeSpeed {
                    entity,
                    rule: rule(node)?,
                    value: node.number("value")?,
                }
            }
            "ReachPositionCondition" => EntityTest::ReachPosition {
                position: self.position_in(node)?,
                tolerance_m: node.magnitude("tolerance")?,
            },
            "DistanceCondition" => EntityTest::Distance {
                to: measured(node, Target::Position(self.position_in(node)?))?,
                rule: rule(node)?,
                value: node.number("value")?,
            },
            "RelativeDistanceCondition" => EntityTest::Distance {
                to: measured(node, Target::Entity(self.entity_ref(node)?))?,
                rule: rule(node)?,
                value: node.number("value")?,
            },
            "TimeHeadwayCondition" => EntityTest::Headway {
                to: measured(node, Target::Entity(self.entity_ref(node)?))?,
                rule: rule(node)?,
                value: node.number("value")?,
            },
            _ => {
                let target = node.child("TimeToCollisionConditionTarget")?;
                let target = match target.chosen(&["EntityRef", "Position"])? {
                    entity if entity.name() == "EntityRef" => {
                        Target::Entity(self.entity_ref(entity)?)
                    }
                    _ => Target::Position(self.position_in(target)?),
                };
                EntityTest::TimeToCollision {
                    to: measured(node, target)?,
                    rule: rule(node)?,
                    value: node.number("value")?,
                }
            }
        })
    }

    fn collision(&self, node: Node<'_>) -> Result<CollisionWith, ReadError> {
        let with = node.chosen(&["EntityRef", "ByType"])?;
        if with.name() == "EntityRef" {
            return self.entity_ref(with).map(CollisionWith::Entity);
        }
        let kinds = [
            ("vehicle", Category::Vehicle),
            ("pedestrian", Category::Pedestrian),
            ("miscellaneous", Category::MiscObject),
        ];
        with.word("type", &kinds).map(CollisionWith::Category)
    }
}

fn rule(node: Node<'_>) -> Result<Rule, ReadError> {
    node.word("rule", Rule::NAMES)
}

/// Only along the entity's heading.
fn directed(node: Node<'_>) -> Result<(), ReadError> {
    node.word_if("direction", &[("longitudinal", ())]).map(|_| ())
}

/// A distance. Where the file does not say so, it is along the entity's heading, straight to a position,
/// or, with version 1.0's `alongRoute`, along the road.
fn measured(node: Node<'_>, target: Target) -> Result<Measured, ReadError> {
    let directions = [
        ("longitudinal", Along::Longitudinal),
        ("lateral", Along::Lateral),
        ("euclidianDistance", Along::Euclidean),
        ("euclideanDistance", Along::Euclidean),
        ("cartesianDistance", Along::Euclidean),
    ];
    let systems = [("entity", true), ("lane", false), ("road", false), ("trajectory", false)];
    let along_route = match node.element.attribute("alongRoute") {
        Some(_) => node.boolean("alongRoute")?,
        None => false,
    };
    let default = match node.name() {
        _ if along_route => Along::Longitudinal,
        "DistanceCondition" => Along::Euclidean,
        "TimeToCollisionCondition" if matches!(target, Target::Position(_)) => Along::Euclidean,
        _ => Along::Longitudinal,
    };
    Ok(Measured {
        target,
        freespace: node.boolean("freespace")?,
        along: node.word_if("relativeDistanceType", &directions)?.unwrap_or(default),
        entity_axes: node.word_if("coordinateSystem", &systems)?.unwrap_or(!along_route),
    })
}
