//! Conditions about entities.

use super::along::Position;
use super::entity::EntityRef;
use super::reference::EntityName;
use crate::comparison::Rule;
use crate::declare::{AtLeastOne, AtLeastZero, Node, Number, OneOf, Truth, elements, words};
use crate::error::ReadError;
use crate::model::Category;
use crate::model::condition::{Along, CollisionWith, EntityTest, Measured, Target, Test};

words! {
    /// Entities that a condition needs; the value is true for all of them.
    TriggeringEntitiesRule = bool { "any" false, "all" true }

    /// The axes of a distance; its value is whether the entity's own rather than the road's.
    CoordinateSystem = bool { "entity" true, "lane" false, "road" false, "trajectory" false }

    /// The direction of a speed or an acceleration.
    Direction = () { "longitudinal" () }
}

elements! { "Conditions";
    /// about entities
    ByEntityCondition -> Option<Test> []
    {triggering: TriggeringEntities, is: EntityCondition}
    {
        let (all, entities) = triggering;
        Ok(Some(Test::Entity { entities, all, is }))
    }

    /// any or all of them
    TriggeringEntities -> (bool, Vec<usize>)
    ["triggeringEntitiesRule" all: TriggeringEntitiesRule] {entities: AtLeastOne<EntityRef>}
    { Ok((all, entities.concat())) }

    /// an entity that is not on the road meets none
    EntityCondition -> EntityTest [] {
        test: OneOf<(
            EndOfRoadCondition,
            CollisionCondition,
            OffroadCondition,
            TimeHeadwayCondition,
            TimeToCollisionCondition,
            AccelerationCondition,
            StandStillCondition,
            SpeedCondition,
            RelativeSpeedCondition,
            TraveledDistanceCondition,
            ReachPositionCondition,
            DistanceCondition,
            RelativeDistanceCondition,
        )>,
    }

    /// at the road's end for that long
    EndOfRoadCondition -> EntityTest ["duration" duration_s: AtLeastZero as "s"] {}
    { Ok(EntityTest::EndOfRoad(duration_s)) }

    /// origin outside all lanes for that long
    OffroadCondition -> EntityTest ["duration" duration_s: AtLeastZero as "s"] {}
    { Ok(EntityTest::Offroad(duration_s)) }

    /// the bounding boxes overlap
    CollisionCondition -> EntityTest [] {with: OneOf<(Touched, ByType)>}
    { Ok(EntityTest::Collision(with)) }

    /// all entities of a kind
    ByType -> CollisionWith ["type" category: Category] {}
    { Ok(CollisionWith::Category(category)) }

    /// a reference by name
    Touched = "EntityRef" -> CollisionWith ["entityRef" entity: EntityName] {}
    { Ok(CollisionWith::Entity(entity)) }

    /// distance over the triggering entity's speed; infinite at standstill; none to what is behind it
    TimeHeadwayCondition -> EntityTest
    ["entityRef" entity: EntityName, "value" value: Number as "s", "freespace" freespace: Truth,
        "rule" rule: Rule, "alongRoute" along_route: Option<Truth>,
        "coordinateSystem" axes: Option<CoordinateSystem>,
        "relativeDistanceType" along: Option<Along>] {}
    unused ["routingAlgorithm?"]
    {
        let to = measured(Target::Entity(entity), freespace, along_route, axes, along);
        Ok(EntityTest::Headway { to, rule, value })
    }

    /// distance over closing speed; infinite when not closing
    TimeToCollisionCondition -> EntityTest
    ["value" value: Number as "s", "freespace" freespace: Truth, "rule" rule: Rule,
        "alongRoute" along_route: Option<Truth>,
        "coordinateSystem" axes: Option<CoordinateSystem>,
        "relativeDistanceType" along: Option<Along>]
    {target: TimeToCollisionConditionTarget}
    unused ["routingAlgorithm?"]
    {
        let to = measured(target, freespace, along_route, axes, along);
        Ok(EntityTest::TimeToCollision { to, rule, value })
    }

    /// to what
    TimeToCollisionConditionTarget -> Target [] {target: OneOf<(TargetEntity, TargetPosition)>}

    /// a reference by name
    TargetEntity = "EntityRef" -> Target ["entityRef" entity: EntityName] {}
    { Ok(Target::Entity(entity)) }

    /// along the entity's heading
    AccelerationCondition -> EntityTest
    ["value" value: Number as "m/s²", "rule" rule: Rule, "direction" _: Option<Direction>] {}
    { Ok(EntityTest::Acceleration { rule, value }) }

    /// speed 0 for that long
    StandStillCondition -> EntityTest ["duration" duration_s: AtLeastZero as "s"] {}
    { Ok(EntityTest::StandStill(duration_s)) }

    /// along the entity's heading
    SpeedCondition -> EntityTest
    ["value" value: Number as "m/s", "rule" rule: Rule, "direction" _: Option<Direction>] {}
    { Ok(EntityTest::Speed { rule, value }) }

    /// the triggering entity's speed minus the other's
    RelativeSpeedCondition -> EntityTest
    ["entityRef" entity: EntityName, "value" value: Number as "m/s", "rule" rule: Rule,
        "direction" _: Option<Direction>] {}
    { Ok(EntityTest::RelativeSpeed { entity, rule, value }) }

    /// at least that far since the start
    TraveledDistanceCondition -> EntityTest ["value" metres: AtLeastZero as "m"] {}
    { Ok(EntityTest::TraveledDistance(metres)) }

    /// origin within the tolerance
    ReachPositionCondition -> EntityTest ["tolerance" tolerance_m: AtLeastZero as "m"]
    {position: Position}
    { Ok(EntityTest::ReachPosition { position, tolerance_m }) }

    /// to a position
    DistanceCondition -> EntityTest
    ["value" value: Number as "m", "freespace" freespace: Truth, "rule" rule: Rule,
        "alongRoute" along_route: Option<Truth>,
        "coordinateSystem" axes: Option<CoordinateSystem>,
        "relativeDistanceType" along: Option<Along>]
    {position: Position}
    unused ["routingAlgorithm?"]
    {
        let to = measured(Target::Position(position), freespace, along_route, axes, along);
        Ok(EntityTest::Distance { to, rule, value })
    }

    /// to another entity; freespace: between the boxes, 0 where they overlap
    RelativeDistanceCondition -> EntityTest
    ["entityRef" entity: EntityName, "relativeDistanceType" along: Along,
        "value" value: Number as "m", "freespace" freespace: Truth, "rule" rule: Rule,
        "coordinateSystem" axes: Option<CoordinateSystem>] {}
    unused ["routingAlgorithm?"]
    {
        let to = measured(Target::Entity(entity), freespace, None, axes, Some(along));
        Ok(EntityTest::Distance { to, rule, value })
    }
}

/// The end of a distance that is a position.
struct TargetPosition;

impl crate::declare::Element for TargetPosition {
    const NAME: &'static str = Position::NAME;
    const FORM: &'static crate::declare::Form = Position::FORM;
    type Value = Target;

    fn read(node: Node<'_>) -> Result<Target, ReadError> {
        Position::read(node).map(Target::Position)
    }
}

/// The measure of a distance. A file that does not say how is measured along the entity's heading, or straight to a
/// position; version 1.0 says by `along_route` that it is along the road.
fn measured(
    target: Target,
    freespace: bool,
    along_route: Option<bool>,
    axes: Option<bool>,
    along: Option<Along>,
) -> Measured {
    let along_route = along_route == Some(true);
    let otherwise = match matches!(target, Target::Position(_)) && !along_route {
        true => Along::Euclidean,
        false => Along::Longitudinal,
    };
    let (along, entity_axes) = (along.unwrap_or(otherwise), axes.unwrap_or(!along_route));
    Measured { target, freespace, along, entity_axes }
}
